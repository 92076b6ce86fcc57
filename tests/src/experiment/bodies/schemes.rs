//! The time schemes that scenes can name, implicit and explicit, behind one face.

use crate::experiment::{Clock, ExperimentError, Outcome};
use lagrangian::element::Mass;
use lagrangian::stepper::{ExplicitScheme, ExplicitStepper, Stepper, StepperOptions, TimeScheme};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::point_map::PointMap;
use mechanics_core::potential::Potential;
use mechanics_core::state::State;
use std::time::Duration;

/// All of them.
pub(super) const SCHEMES: &[&str] =
    &["backward-euler", "bdf2", "newmark", "implicit-midpoint", "symplectic-euler", "central-differences"];

/// A scheme by name.
#[derive(Clone, Copy, PartialEq)]
pub(in crate::experiment) enum Scheme {
    Implicit(TimeScheme),
    Explicit(ExplicitScheme),
}

impl Scheme {
    pub(in crate::experiment) fn named(method: &str) -> Result<Self, ExperimentError> {
        Ok(match method {
            "backward-euler" => Self::Implicit(TimeScheme::BackwardEuler),
            "bdf2" => Self::Implicit(TimeScheme::Bdf2),
            "newmark" => Self::Implicit(TimeScheme::Newmark),
            "implicit-midpoint" => Self::Implicit(TimeScheme::ImplicitMidpoint),
            "symplectic-euler" => Self::Explicit(ExplicitScheme::SymplecticEuler),
            "central-differences" => Self::Explicit(ExplicitScheme::CentralDifferences),
            _ => {
                return Err(ExperimentError::Refused {
                    key: "validation.methods".to_owned(),
                    reason: format!("there is no method `{method}`"),
                });
            }
        })
    }

    pub(super) fn is_explicit(self) -> bool {
        matches!(self, Self::Explicit(_))
    }
}

/// Moves states with one scheme and adds up what that takes.
pub(in crate::experiment) struct Mover {
    stepper: Kind,
    steps: u64,
    iterations: u64,
    factorisations: u64,
    assembly: Duration,
    solve: Duration,
}

enum Kind {
    Implicit(Box<Stepper>),
    Explicit(ExplicitStepper),
}

impl Mover {
    /// A mover whose Newton iterations stop at `tolerance` (m/s).
    pub(in crate::experiment) fn new(
        scheme: Scheme,
        mass: Mass,
        map: PointMap,
        tolerance: f64,
    ) -> Result<Self, ExperimentError> {
        let stepper = match scheme {
            Scheme::Implicit(scheme) => {
                let newton = NewtonOptions { tolerance, ..NewtonOptions::default() };
                let options = StepperOptions { scheme, newton, ..StepperOptions::default() };
                Kind::Implicit(Box::new(Stepper::new(mass, map, options)))
            }
            Scheme::Explicit(scheme) => {
                Kind::Explicit(ExplicitStepper::new(scheme, mass, map).map_err(ExperimentError::stopped)?)
            }
        };
        let (assembly, solve) = (Duration::ZERO, Duration::ZERO);
        Ok(Self { stepper, steps: 0, iterations: 0, factorisations: 0, assembly, solve })
    }

    /// Moves `state` by `h` (s).
    pub(in crate::experiment) fn step(
        &mut self,
        state: &mut State,
        terms: &mut [&mut dyn Potential],
        h: f64,
    ) -> Result<(), ExperimentError> {
        self.steps += 1;
        match &mut self.stepper {
            Kind::Implicit(stepper) => {
                let report = stepper.step(state, terms, h).map_err(ExperimentError::stopped)?;
                self.iterations += report.newton.iterations;
                self.factorisations += report.newton.factorisations;
                self.assembly += report.newton.times.assembly;
                self.solve += report.newton.times.solve;
                Ok(())
            }
            Kind::Explicit(stepper) => stepper.step(state, terms, h).map_err(ExperimentError::stopped),
        }
    }

    /// `outcome` with the counts and the state, and the clock with the terms.
    pub(in crate::experiment) fn counted(
        &self,
        outcome: Outcome,
        state: &State,
        clock: &mut Clock,
    ) -> Outcome {
        if self.iterations > 0 {
            clock.add_term("assembly", self.assembly);
            clock.add_term("linear solve", self.solve);
        }
        let mut outcome = outcome
            .count("steps", self.steps)
            .count("Newton iterations", self.iterations)
            .count("factorisations", self.factorisations)
            .state(state.hash());
        outcome.simulated_seconds = Some(state.time);
        outcome
    }
}
