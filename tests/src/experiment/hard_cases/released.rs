//! A block that starts crushed, inverted or torn out, and is let go.

use super::Effort;
use super::body::{Deformation, LAWS, elastic, mass, options, skin};
use super::settled::Settled;
use crate::experiment::random::Random;
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{Count, NonNegative, Positive};
use lagrangian::stepper::Stepper;
use mechanics_core::law::Lame;
use mechanics_core::mesh::{BoxSplit, block};
use mechanics_core::point_map::PointMap;
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

/// A cube of side 1 m, E = 1e4 Pa, ν = 0.4, 1000 kg/m³, released at rest; backward Euler, tolerance 1e-5 m/s; the ladder is
/// the step (s). At the end its spin is taken off, and it is let down to its equilibrium, of which force and curvature are measured.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ReleasedBlock {
    /// The shape it starts in.
    start: Start,
    /// Cells along each side.
    cells: Count,
    /// How long it moves (s).
    duration_s: Positive,
    /// Every coordinate is moved by up to this length (m).
    #[serde(default)]
    jitter_m: Option<NonNegative>,
}

/// An equilibrium with a larger strain is not the rest shape.
const REST_STRAIN: f64 = 1e-6;
/// [kg/m³]
const DENSITY: f64 = 1000.0;

#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Start {
    /// All points in one.
    Point,
    /// All points in the plane z = 0.
    Plane,
    /// All points at random in a cube of side 2.
    Random,
    /// The block mirrored in z: every tetrahedron is inverted.
    Mirrored,
    /// Five times as long along x.
    Stretched,
}

impl Start {
    /// Where a point starts.
    pub(super) fn place(self, rest: &Vec3, random: &mut Random) -> Vec3 {
        match self {
            Self::Point => Vec3::zeros(),
            Self::Plane => Vec3::new(rest.x, rest.y, 0.0),
            Self::Random => random_vector(random),
            Self::Mirrored => Vec3::new(rest.x, rest.y, -rest.z),
            Self::Stretched => Vec3::new(5.0 * rest.x, rest.y, rest.z),
        }
    }
}

pub(super) fn random_vector(random: &mut Random) -> Vec3 {
    Vec3::from_fn(|_, _| random.symmetric())
}

impl Experiment for ReleasedBlock {
    fn methods(&self) -> &'static [&'static str] {
        LAWS
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let cells = [self.cells.value() as u32; 3];
        let mesh = block(&Vec3::zeros(), &Vec3::repeat(1.0), cells, BoxSplit::Six)
            .map_err(ExperimentError::stopped)?;
        let lame = Lame::from_young_poisson(1e4, 0.4).map_err(ExperimentError::stopped)?;
        let mut elastic = elastic(at.method, lame, &mesh, mesh.cells())?;
        let map = PointMap::identity(mesh.points().len());
        let mut stepper = Stepper::new(mass(&mesh, DENSITY)?, map, options(at.method, 1e-5, at.ladder));
        let mut random = Random::new(at.seed);
        let jitter = self.jitter_m.map_or(0.0, NonNegative::value);
        let mut place = |rest| self.start.place(rest, &mut random) + random_vector(&mut random) * jitter;
        let mut state = State::at_rest(mesh.points().iter().map(&mut place).collect());
        let deformation = Deformation::of(&mesh);
        let mut effort = Effort::default();
        let mut smallest = deformation.smallest_determinant(&state.position);
        let mut energy = elastic.value(&state.position);
        let start = energy;
        let mut gain = 0.0_f64;
        for _ in 0..(self.duration_s.value() / at.ladder).round() as u64 {
            let report = clock
                .time(|| stepper.step(&mut state, &mut [&mut *elastic], at.ladder))
                .map_err(ExperimentError::stopped)?;
            effort.add(&report);
            smallest = smallest.min(deformation.smallest_determinant(&state.position));
            let now = elastic.value(&state.position) + stepper.mass().kinetic_energy(&state.velocity);
            gain = gain.max(now - energy);
            energy = now;
        }
        let settled = Settled::of(&mesh, DENSITY, &mut *elastic, at.method, &state)?;
        let outcome = Outcome::default()
            .invariant("spin at the end (rad/s)", settled.spin)
            .invariant("strain at the end beyond that of its spin", settled.unsettled)
            .invariant("strain of the equilibrium", settled.strain)
            .invariant("smallest det F of the equilibrium", settled.smallest_determinant)
            .invariant("force left in the equilibrium", settled.force)
            .invariant("smallest curvature of the equilibrium, of the largest", settled.curvature)
            .invariant("smallest det F", smallest)
            .invariant("smallest det F at the end", deformation.smallest_determinant(&state.position))
            .invariant("largest strain at the end", deformation.largest_strain(&state.position))
            .invariant("energy gained in a step, of the start's", gain / start);
        let outcome = outcome.count("in another equilibrium", u64::from(settled.strain > REST_STRAIN));
        effort.finished(outcome, at, &state, &skin(&mesh)?)
    }
}
