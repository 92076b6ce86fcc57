//! The material point method. (Front page: to be written with the README.)

mod body;
pub mod boundary;
mod error;
mod grid;
pub mod kernel;
pub mod kinematics;
mod material;
mod neighbourhood;
mod particles;
mod simulation;
mod transfer;

pub use error::MpmError;
pub(crate) use grid::Grid;
pub use kernel::Kernel;
pub use material::PointState;
pub use boundary::{Boundary, Shape, Surface};
pub use simulation::{AdvanceReport, Samples, Simulation, SimulationOptions, StepReport};
pub use transfer::Transfer;
