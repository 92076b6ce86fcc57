#![doc = include_str!("../README.md")]

pub mod action;
pub mod conserved;
pub mod constraint;
pub mod coordinates;
pub mod dense;
pub mod error;
pub mod euler_lagrange;
pub mod integrator;
pub mod jet;
pub mod system;
pub mod systems;

#[cfg(feature = "bodies")]
pub mod element;
#[cfg(feature = "bodies")]
pub mod position_based;
#[cfg(feature = "bodies")]
pub mod stepper;

pub use coordinates::{Coordinates, Phase};
pub use error::LagrangianError;
pub use euler_lagrange::{EulerLagrange, SlicedEulerLagrange};
pub use mechanics_core;
pub use mechanics_core::scalar::Scalar;
pub use system::{Curvature, Expansion, Gradient, Lagrangian, SlicedLagrangian, System};
