//! Incremental Potential Contact: barrier, distances, broad phase, continuous collision detection. Not built yet: see the README.
