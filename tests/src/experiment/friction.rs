//! Bodies with friction: against closed forms and event-driven solutions; structures that friction holds; machines that work by it.

mod robot;
mod scenes;

pub(super) use robot::{
    BallImpact, FrictionPair, Gripper, HeavyOnLight, Rollers, StickingPile, TactilePad, Turntable,
};
