//! Bodies in contact: against closed forms, and hard cases where nothing may ever pass through.

mod bar;
mod collision;
mod detection;
pub(in crate::experiment) mod energy;
mod floor;
pub(in crate::experiment) mod forms;
mod hard;
mod hertz;
pub(in crate::experiment) mod particle;
pub(in crate::experiment) mod portrait;
mod press;
mod projection;
mod slip;
pub(in crate::experiment) mod term;
mod units;
pub(in crate::experiment) mod watch;
pub(in crate::experiment) mod world;

pub(super) use bar::BarImpact;
pub(super) use collision::Collision;
pub(super) use detection::PlantedContacts;
pub(super) use floor::{BlockOnFloor, GapForEveryStep};
pub(super) use hard::{
    DegeneratePair, FastImpact, FoldedCloth, HardDrop, LinkedChain, NarrowPipe, TwistedMat, TwoBlocks,
};
pub(super) use hertz::Hertz;
pub(super) use particle::ParticleOnPlate;
pub(super) use press::PressedBar;
pub(super) use projection::PressedStack;
pub(super) use units::Units;
