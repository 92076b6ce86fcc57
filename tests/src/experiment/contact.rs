//! Bodies in contact: against closed forms, and hard cases where nothing may ever pass through.

mod floor;
mod world;

pub(super) use floor::BlockOnFloor;
