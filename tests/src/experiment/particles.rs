//! The material point method: known motions, equilibria and impacts on ladders of grids, by kernel × transfer × precision × particles a
//! cell.

mod ball_drop;
mod cantilever;
mod cell_crossing;
mod cloud;
mod colliders;
mod column;
mod dam_break;
mod disks;
mod granular_column;
mod hard;
mod incline;
mod known_motion;
mod layered_column;
mod loaded_bar;
mod manufactured;
mod meeting_bars;
mod method;
mod noise;
pub(super) mod portrait;
mod pulled_bar;
mod rotation;
mod solver;
mod taylor_bar;
mod vibrating_bar;

pub(super) use ball_drop::BouncingBall;
pub(super) use cantilever::HangingCantilever;
pub(super) use cell_crossing::CellCrossing;
pub(super) use colliders::{BunnyInSand, BunnyInWater, ThinSheet};
pub(super) use column::SelfWeightColumn;
pub(super) use dam_break::DamBreak;
pub(super) use disks::TwoDisks;
pub(super) use granular_column::GranularColumn;
pub(super) use hard::{
    CrowdedCell, HardCollision, LawsAtLimits, ParticleAlone, RefusedNumbers, SettlingSand,
    StretchedAndReleased,
};
pub(super) use incline::BlockOnIncline;
pub(super) use layered_column::LayeredColumn;
pub(super) use loaded_bar::LoadedBar;
pub(super) use manufactured::ManufacturedParticles;
pub(super) use meeting_bars::MeetingBars;
pub(super) use noise::{MassMatrix, NullSpace};
pub(super) use pulled_bar::PulledBar;
pub(super) use rotation::FreeRotation;
pub(super) use taylor_bar::TaylorBar;
pub(super) use vibrating_bar::VibratingBar;
