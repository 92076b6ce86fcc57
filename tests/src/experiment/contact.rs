//! Bodies in contact: against closed forms, and hard cases where nothing may ever pass through.

mod floor;
mod hard;
mod watch;
mod world;

pub(super) use floor::BlockOnFloor;
pub(super) use hard::{
    DegeneratePair, FastImpact, FoldedCloth, HardDrop, LinkedChain, NarrowPipe, TwistedMat, TwoBlocks,
};
