#![doc = include_str!("../README.md")]
//!
//! # Where to go next
//! The seam that a grid reads: [`PointLaw`]; laws: [`elastic`], [`plastic`], [`fluid`], each with its derivation; viscosity for any of them: [`Viscous`]; the time step: [`StiffnessBound`].
//! Formulas with the places where they are in the code: `docs/theory/mpm-constitutive.md` of the repository.

mod curvature;
mod elementary;
mod error;
mod logarithmic;
mod point_law;
mod root;
mod stiffness_bound;
mod strain;
mod viscosity;

pub mod elastic;
pub mod fluid;
pub mod plastic;

pub use curvature::Curvature;
pub use error::{Parameter, PointLawError};
pub use mechanics_core;
pub use point_law::{Motion, PointLaw, Stress, TotalDeformation, fresh_history};
pub use stiffness_bound::StiffnessBound;
pub use strain::{Numbers, Strain, VolumeChange};
pub use viscosity::{Viscosity, Viscous};
