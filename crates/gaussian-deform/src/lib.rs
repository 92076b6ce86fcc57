//! Trained Gaussian splats that move and deform with a simulated continuum. Not built yet: see the README.
