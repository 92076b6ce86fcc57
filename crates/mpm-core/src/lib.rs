#![doc = include_str!("../README.md")]
//!
//! # Where to go next
//! A simulation: [`Simulation`]; its particles: [`sampling`]; velocities between particles and nodes: [`Transfer`]; walls: [`boundary`], meshes: [`collider`], clamps: [`grip`], loads: [`traction`]; manufactured
//! solutions: [`kinematics`]. The examples `jelly_drop`, `sand_column`, `dam_break` and `bunny_in_sand` run in seconds. Formulas with the places where they are in the code: `docs/theory/mpm-core.md` of the repository.
#![allow(
    clippy::neg_cmp_op_on_partial_ord,
    reason = "a comparison with NaN fails, and its negation is what refuses it"
)]

mod body;
pub mod boundary;
pub mod collider;
mod error;
mod forecast;
mod grid;
pub mod grip;
mod implicit;
pub mod kernel;
pub mod kinematics;
mod material;
mod neighbourhood;
mod particles;
pub mod sampling;
mod simulation;
pub mod traction;
mod transfer;

pub use boundary::{Boundary, PrescribedVelocity, Shape, Surface};
pub use collider::{Collider, ColliderError, ColliderLoad, RigidMotion, SheetMesh, SolidMesh};
pub use error::MpmError;
pub(crate) use grid::Grid;
pub use grip::Grip;
pub use implicit::{ImplicitError, ImplicitReport, ImplicitStep};
pub use kernel::Kernel;
pub use material::PointState;
pub use mechanics_core;
pub use mpm_constitutive;
pub use simulation::{
    AdvanceReport, DeformationBuffer, Equilibrium, EquilibriumReport, MemoryUse, ParticleNumbers,
    ResumeError, Samples, Simulation, SimulationOptions, StageTimes, StepReport, Totals,
};
pub use traction::Traction;
pub use transfer::Transfer;
