//! A cantilever of tetrahedra under a dead load on its end, far from small displacements.
//!
//! Length L = 1 m, a square section of edge H, ν = 0, PL²/EI = the load. A slender beam is the elastica; of a stout one shear and the
//! straining of the section are the parts of order (H/L)² that the elastica lacks.
//!
//! Reference: K. E. Bisshopp, D. C. Drucker, *Large deflection of cantilever beams*, Q. Appl. Math. 3 (1945).

use super::counted;
use super::portrait::pictured;
use super::solid::{Shape, Solid};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{Count, Positive};
use lagrangian::element::{Amplitude, DeadLoad, Mass};
use lagrangian::stepper::{Stepper, StepperOptions};
use mechanics_core::law::{Lame, StVenantKirchhoff};
use mechanics_core::mesh::{BoxSplit, block};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::point_map::PointMap;
use mechanics_core::projection::Projection;
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

/// What the ladder is.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
enum Ladder {
    /// The distance of nodes (m), of a beam with this edge H.
    NodeDistance {
        /// H (m).
        height_m: Positive,
    },
    /// H/L, with so many cells across.
    Slenderness {
        /// Cells across the section; the cells are cubes.
        cells_across: Count,
    },
}

/// The beam.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Cantilever {
    /// PL²/EI [1].
    load: Positive,
    /// What the ladder is.
    ladder: Ladder,
    /// The end's way down in the reference, over L [1].
    tip_down: Positive,
    /// The elastica's.
    elastica_tip_down: Positive,
}

const YOUNG: f64 = 1e6;
/// The load is put on in so many steps.
const LOAD_STEPS: u32 = 4;

impl Experiment for Cantilever {
    fn methods(&self) -> &'static [&'static str] {
        &["linear", "ten-node", "linear, unprojected", "ten-node, unprojected"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let shape = if at.method.starts_with("linear") { Shape::Linear } else { Shape::TenNode };
        let (height, cell) = match self.ladder {
            Ladder::NodeDistance { height_m } if shape == Shape::Linear => (height_m.value(), at.ladder),
            Ladder::NodeDistance { height_m } => (height_m.value(), 2.0 * at.ladder),
            Ladder::Slenderness { cells_across } => (at.ladder, at.ladder / cells_across.value() as f64),
        };
        let mut solid = beam(height, cell, shape)?;
        let inertia = height.powi(4) / 12.0;
        let force = self.load.value() * YOUNG * inertia;
        let end = solid.face_shares(|x| (x.x - 1.0).abs() < 1e-9);
        let pressure = force / (height * height);
        let forces = end.iter().map(|&(i, share)| (i, Vec3::z() * (-share * pressure))).collect();
        let load = DeadLoad::new("end load", forces).map_err(ExperimentError::stopped)?;
        let mut load = load.with_amplitude(Amplitude::Ramp);
        let held = solid.held(|x| x.x == 0.0);
        let count = solid.points.len();
        let map = PointMap::with_fixed(count, &held).map_err(ExperimentError::stopped)?;
        let newton = NewtonOptions { tolerance: 1e-9, ..NewtonOptions::default() };
        let projection =
            if at.method.ends_with("unprojected") { Projection::None } else { Projection::Clamp };
        let options = StepperOptions { newton, projection, ..StepperOptions::default() };
        let mut stepper = Stepper::new(Mass::zeros(count), map, options);
        let mut state = State::at_rest(solid.points.clone());
        let report = clock
            .time(|| stepper.equilibrium(&mut state, &mut [solid.elastic.as_mut(), &mut load], LOAD_STEPS))
            .map_err(ExperimentError::stopped)?;

        // The mean over the end, weighted as the load is.
        let down = |&(i, share): &(u32, f64)| {
            share * (solid.points[i as usize].z - state.position[i as usize].z) / (height * height)
        };
        let found: f64 = end.iter().map(down).sum();
        let outcome = Outcome::default()
            .error("tip", (found / self.tip_down.value() - 1.0).abs())
            .error("gap to the elastica", (found / self.elastica_tip_down.value() - 1.0).abs())
            .count("unknowns", 3 * (count - held.len()) as u64)
            .invariant("tip down", found)
            .invariant("smallest volume ratio", solid.smallest_volume_ratio(&state.position))
            .state(state.hash());
        let outcome = pictured(outcome, at, &solid, &state.position, "the beam under its load")?;
        Ok(counted(outcome, &report, clock))
    }
}

/// The beam at rest along x, its cells about cubes.
fn beam(height: f64, cell: f64, shape: Shape) -> Result<Solid, ExperimentError> {
    let across = (height / cell).round().max(1.0) as u32;
    let along = (1.0 / cell).round() as u32;
    let size = Vec3::new(1.0, height, height);
    let mesh = block(&Vec3::zeros(), &size, [along, across, across], BoxSplit::Six)
        .map_err(ExperimentError::stopped)?;
    let lame = Lame::from_young_poisson(YOUNG, 0.0).map_err(ExperimentError::stopped)?;
    Solid::new(StVenantKirchhoff::new(lame), &mesh, shape)
}
