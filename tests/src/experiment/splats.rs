//! Experiments with Gaussian splats: what moves with a body, and how it looks.

mod filling;
mod inside;
mod modes;
mod plain;
mod plastic;
pub(crate) mod portrait;
mod rigid;
mod samples;
mod stretch;
pub(crate) mod surface;

pub(crate) use filling::SplatFilling;
pub(crate) use modes::SplatPictureModes;
pub(crate) use plastic::SplatPlasticShear;
pub(crate) use rigid::SplatRigidMotion;
pub(crate) use samples::SplatSamples;
pub(crate) use stretch::SplatStretch;
