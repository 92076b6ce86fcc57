//! Experiments with Gaussian splats: what moves with a body, and how it looks.

pub(crate) mod portrait;
pub(crate) mod surface;
