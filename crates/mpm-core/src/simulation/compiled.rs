//! Steps that are compiled once.
//!
//! Generic code is compiled in every crate that names its types. A step with all its kernels takes a compiler half a minute;
//! here it is compiled for the four kinds of simulation there are, and whoever makes one only calls it.

use super::implicit::Regime;
use super::{Simulation, StepReport};
use crate::{ImplicitReport, ImplicitStep, MpmError};
use mechanics_core::lanes::Element;
use std::any::Any;

type Outcome = Result<StepReport, MpmError>;

/// [`Simulation::whole_step`] of this kind of simulation.
pub(super) fn step<E: Element, const D: usize>(simulation: &mut Simulation<E, D>, step: f64) -> Outcome {
    let simulation: &mut dyn Any = simulation;
    if let Some(solid) = simulation.downcast_mut() {
        solid_single(solid, step)
    } else if let Some(solid) = simulation.downcast_mut() {
        solid_double(solid, step)
    } else if let Some(plane) = simulation.downcast_mut() {
        plane_single(plane, step)
    } else if let Some(plane) = simulation.downcast_mut() {
        plane_double(plane, step)
    } else {
        unreachable!("numbers are sealed to f32 and f64, dimensions checked by Simulation::new")
    }
}

#[inline(never)]
fn solid_single(simulation: &mut Simulation<f32, 3>, step: f64) -> Outcome {
    simulation.whole_step(step)
}

#[inline(never)]
fn solid_double(simulation: &mut Simulation<f64, 3>, step: f64) -> Outcome {
    simulation.whole_step(step)
}

#[inline(never)]
fn plane_single(simulation: &mut Simulation<f32, 2>, step: f64) -> Outcome {
    simulation.whole_step(step)
}

#[inline(never)]
fn plane_double(simulation: &mut Simulation<f64, 2>, step: f64) -> Outcome {
    simulation.whole_step(step)
}

type ImplicitOutcome = Result<ImplicitReport, MpmError>;

/// [`Simulation::whole_implicit_step`] likewise.
pub(super) fn implicit_step<E: Element, const D: usize>(
    simulation: &mut Simulation<E, D>,
    step: f64,
    options: &ImplicitStep,
    regime: Regime,
) -> ImplicitOutcome {
    let simulation: &mut dyn Any = simulation;
    if let Some(solid) = simulation.downcast_mut() {
        implicit_solid_single(solid, step, options, regime)
    } else if let Some(solid) = simulation.downcast_mut() {
        implicit_solid_double(solid, step, options, regime)
    } else if let Some(plane) = simulation.downcast_mut() {
        implicit_plane_single(plane, step, options, regime)
    } else if let Some(plane) = simulation.downcast_mut() {
        implicit_plane_double(plane, step, options, regime)
    } else {
        unreachable!("numbers are sealed to f32 and f64, dimensions checked by Simulation::new")
    }
}

#[inline(never)]
fn implicit_solid_single(
    simulation: &mut Simulation<f32, 3>,
    step: f64,
    options: &ImplicitStep,
    regime: Regime,
) -> ImplicitOutcome {
    simulation.whole_implicit_step(step, options, regime)
}

#[inline(never)]
fn implicit_solid_double(
    simulation: &mut Simulation<f64, 3>,
    step: f64,
    options: &ImplicitStep,
    regime: Regime,
) -> ImplicitOutcome {
    simulation.whole_implicit_step(step, options, regime)
}

#[inline(never)]
fn implicit_plane_single(
    simulation: &mut Simulation<f32, 2>,
    step: f64,
    options: &ImplicitStep,
    regime: Regime,
) -> ImplicitOutcome {
    simulation.whole_implicit_step(step, options, regime)
}

#[inline(never)]
fn implicit_plane_double(
    simulation: &mut Simulation<f64, 2>,
    step: f64,
    options: &ImplicitStep,
    regime: Regime,
) -> ImplicitOutcome {
    simulation.whole_implicit_step(step, options, regime)
}
