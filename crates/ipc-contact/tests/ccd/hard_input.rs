//! Input at the edges.
