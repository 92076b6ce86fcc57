//! The physical part of a scene whose equilibrium is homogeneous: x = F X everywhere, with a known F.
//!
//! Linear shape functions hold that motion exactly, so whatever the mesh, the error is that of the solver (the patch
//! test).
//!
//! # Reference
//! B. M. Irons, A. Razzaque, *Experience with the patch test for convergence of finite elements*, 1972.

use crate::experiment::simulation::simulate;
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{Finite, Positive};
use mechanics_core::tensor::{Mat3, Vec3};
use schemars::JsonSchema;
use serde::Deserialize;

/// The scene's bodies against the motion x = F X.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct HomogeneousDeformation {
    /// F, row by row [1].
    deformation_gradient: [[Finite; 3]; 3],
    /// The von Mises stress that belongs to it [Pa].
    von_mises_pa: Positive,
}

impl Experiment for HomogeneousDeformation {
    fn methods(&self) -> &'static [&'static str] {
        &["simulation"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let (course, outcome) = simulate(at, clock)?;
        let f = Mat3::from_fn(|i, j| self.deformation_gradient[i][j].value());
        let (bodies, x) = (course.bodies(), course.positions());
        let rest = bodies.mesh().points();
        let position = x.iter().zip(rest).map(|(x, rest): (&Vec3, &Vec3)| (x - f * rest).norm());
        let wanted = self.von_mises_pa.value();
        let stress = bodies.cell_fields(x).von_mises.into_iter().map(|found| (found / wanted - 1.0).abs());
        Ok(outcome
            .error("position", position.fold(0.0, f64::max))
            .error("von Mises stress", stress.fold(0.0, f64::max)))
    }
}
