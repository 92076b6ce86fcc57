//! Bodies with friction: against closed forms and event-driven solutions; structures that friction holds; machines that work by it.

mod blow;
mod capstan;
mod creep;
mod disk;
mod incline;
pub(super) mod robot;
mod scenes;
mod sliding;
mod stick_slip;
mod surfaces;

pub(super) use blow::GlancingBlow;
pub(super) use capstan::Capstan;
pub(super) use creep::ElasticBlockOnIncline;
pub(super) use disk::SpinningDisk;
pub(super) use incline::BlocksOnInclines;
pub(super) use robot::{
    BallImpact, FrictionPair, Gripper, HeavyOnLight, Rollers, StickingPile, TactilePad, Turntable,
};
pub(super) use sliding::SlidingDistance;
pub(super) use stick_slip::StickSlip;

pub(super) use scenes::{BitingRollers, CardHouse, Funnel, MasonryArch, PulledKnot, PulledStack, Tablecloth};
