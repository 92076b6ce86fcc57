#![doc = include_str!("../README.md")]
//!
//! # The way of the data
//! In the order of the modules: contact's normal forces, with the [`coefficients`] of their surfaces and the [`law`], become
//! [`pair`]s that are held constant → [`lagged`] friction, a term of the incremental potential → [`coupling`] with contact, which
//! takes the normal forces anew until they agree with what was found.
//!
//! # Where to go next
//! [`ContactWithFriction`] is what a solver takes, [`FrictionOptions`] what it asks; [`coefficients`] which surface has which; [`surface_motion`] belts and turntables. The example `blocks_on_slope` runs in
//! seconds. Formulas with the places where they are in the code: `docs/theory/ipc-friction.md` of the repository.
//!
//! # Reference
//! M. Li, Z. Ferguson, T. Schneider, T. Langlois, D. Zorin, D. Panozzo, C. Jiang, D. M. Kaufman, *Incremental Potential
//! Contact: intersection- and inversion-free, large-deformation dynamics*, ACM Trans. Graph. 39(4), 2020, section 5.

pub mod basis;
mod blend;
pub mod coefficients;
pub mod coupling;
mod error;
pub mod lagged;
pub mod law;
pub mod pair;
pub mod surface_motion;

pub use coupling::{ContactWithFriction, FrictionOptions, FrictionReport};
pub use error::FrictionError;
pub use ipc_contact;
pub use mechanics_core;
