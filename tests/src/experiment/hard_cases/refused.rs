//! Starts outside a law's domain: refused, with the element named and the state as it was.

use super::body::{Deformation, LAWS, elastic, mass, options, skin};
use super::released::{Start, random_vector};
use crate::experiment::contact::portrait::pictured;
use crate::experiment::random::Random;
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use lagrangian::stepper::Stepper;
use mechanics_core::law::Lame;
use mechanics_core::mesh::{BoxSplit, block};
use mechanics_core::point_map::PointMap;
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;
use std::error::Error;

/// The cube of `released-block` where its law is not defined; the ladder is the step (s).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct RefusedStart {
    /// The shape it starts in.
    start: Start,
}

impl Experiment for RefusedStart {
    fn methods(&self) -> &'static [&'static str] {
        LAWS
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let mesh = block(&Vec3::zeros(), &Vec3::repeat(1.0), [4; 3], BoxSplit::Six)
            .map_err(ExperimentError::stopped)?;
        let lame = Lame::from_young_poisson(1e4, 0.4).map_err(ExperimentError::stopped)?;
        let mut elastic = elastic(at.method, lame, &mesh, mesh.cells())?;
        let map = PointMap::identity(mesh.points().len());
        let mut stepper = Stepper::new(mass(&mesh, 1000.0)?, map, options(at.method, 1e-5, at.ladder));
        let mut random = Random::new(at.seed);
        let place = |rest| self.start.place(rest, &mut random) + random_vector(&mut random) * 1e-6;
        let mut state = State::at_rest(mesh.points().iter().map(place).collect());
        let before = state.hash();
        let first = Deformation::of(&mesh).first_inverted(&state.position);
        let result = clock.time(|| stepper.step(&mut state, &mut [&mut *elastic], at.ladder));
        let words = result.err().map(|error| all_words(&error)).unwrap_or_default();
        let named = first.is_some_and(|element| words.contains(&format!("element {element} ")));
        let outcome = Outcome::default()
            .invariant("refused", f64::from(u8::from(!words.is_empty())))
            .invariant("first inverted element named", f64::from(u8::from(named)))
            .invariant("state unchanged", f64::from(u8::from(state.hash() == before)));
        let moved = state.position.iter().zip(mesh.points()).map(|(x, rest)| (x - rest).norm()).collect();
        pictured(outcome, at, &state.position, &skin(&mesh)?, ("displacement", "m", moved))
    }
}

/// An error with all its causes.
fn all_words(error: &dyn Error) -> String {
    let mut words = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        words += &format!("; {error}");
        cause = error.source();
    }
    words
}
