//! Steps that are compiled once.
//!
//! Generic code is compiled in every crate that names its types. A step with all its kernels takes a compiler half a minute;
//! here it is compiled for the four kinds of simulation there are, and whoever makes one only calls it.

use super::implicit::Regime;
use super::{Simulation, StepReport};
use crate::{ImplicitReport, ImplicitStep, MpmError};
use mechanics_core::lanes::Element;
use std::any::Any;

/// A function that calls a method of whatever kind the simulation is: one compiled copy of the method for each kind.
macro_rules! compiled {
    ($(#[$doc:meta])* $name:ident calls $method:ident($($argument:ident: $of:ty),*) -> $outcome:ty) => {
        $(#[$doc])*
        pub(super) fn $name<E: Element, const D: usize>(
            simulation: &mut Simulation<E, D>,
            $($argument: $of),*
        ) -> Result<$outcome, MpmError> {
            compiled!(@kind solid_single, f32, 3, $method($($argument: $of),*) -> $outcome);
            compiled!(@kind solid_double, f64, 3, $method($($argument: $of),*) -> $outcome);
            compiled!(@kind plane_single, f32, 2, $method($($argument: $of),*) -> $outcome);
            compiled!(@kind plane_double, f64, 2, $method($($argument: $of),*) -> $outcome);
            let simulation: &mut dyn Any = simulation;
            if let Some(solid) = simulation.downcast_mut() {
                solid_single(solid, $($argument),*)
            } else if let Some(solid) = simulation.downcast_mut() {
                solid_double(solid, $($argument),*)
            } else if let Some(plane) = simulation.downcast_mut() {
                plane_single(plane, $($argument),*)
            } else if let Some(plane) = simulation.downcast_mut() {
                plane_double(plane, $($argument),*)
            } else {
                unreachable!("numbers are sealed to f32 and f64, dimensions checked by Simulation::new")
            }
        }
    };
    (@kind $kind:ident, $e:ty, $d:literal, $method:ident($($argument:ident: $of:ty),*) -> $outcome:ty) => {
        #[inline(never)]
        fn $kind(simulation: &mut Simulation<$e, $d>, $($argument: $of),*) -> Result<$outcome, MpmError> {
            simulation.$method($($argument),*)
        }
    };
}

compiled! {
    /// [`Simulation::whole_step`] of this kind of simulation.
    step calls whole_step(step: f64) -> StepReport
}

compiled! {
    /// [`Simulation::whole_implicit_step`] likewise.
    implicit_step calls whole_implicit_step(step: f64, options: &ImplicitStep, regime: Regime) -> ImplicitReport
}
