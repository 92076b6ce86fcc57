#![doc = include_str!("../README.md")]
//!
//! # The way of the data
//! In the order of the modules:
//! [`collision_mesh`] what may touch → [`broad_phase`] which pairs come near → [`ccd`] how far a step may go →
//! [`contact_set`] which closest features are active → [`distance`], [`barrier`], [`pair`] the energy of a pair and its
//! derivatives → [`contact`] the term of the incremental potential. [`intersection`] and [`topology`] check the result by
//! independent means.
//!
//! # Where to go next
//! [`contact::BarrierContact`] is what a solver takes; [`collision_mesh`] what may touch; [`stiffness`] how stiff. The example `two_cubes` runs in a second. Formulas with the places where they are in the code:
//! `docs/theory/ipc-contact.md` of the repository.
//!
//! # Reference
//! M. Li, Z. Ferguson, T. Schneider, T. Langlois, D. Zorin, D. Panozzo, C. Jiang, D. M. Kaufman, *Incremental Potential
//! Contact: intersection- and inversion-free, large-deformation dynamics*, ACM Trans. Graph. 39(4), 2020.

pub mod barrier;
pub mod broad_phase;
pub mod ccd;
pub mod collision_mesh;
pub mod contact;
pub mod contact_set;
pub mod distance;
mod error;
pub mod intersection;
pub mod normal_force;
pub mod pair;
pub mod stiffness;
pub mod topology;

pub use error::ContactError;
pub use mechanics_core;
