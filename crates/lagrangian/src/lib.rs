#![doc = include_str!("../README.md")]
//!
//! # Where to go next
//! A system of your own: [`system`]; a worked one that is near to it: [`systems`]; which integrator: the table above, then [`integrator`]; constraints: [`constraint`]; what is kept: [`conserved`];
//! a path between two points: [`action`]. Elastic bodies begin at `stepper` and `element` (feature `bodies`). Formulas with the places where they are in the code: `docs/theory/lagrangian.md` of the repository.

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
