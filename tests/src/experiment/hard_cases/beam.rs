//! A clamped beam in its own weight, with one parameter driven to extremes.

use super::Effort;
use super::body::{Deformation, LAWS, elastic, mass, options, skin};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Count;
use lagrangian::element::DeadLoad;
use lagrangian::stepper::Stepper;
use mechanics_core::law::Lame;
use mechanics_core::mesh::{BoxSplit, MeshError, TetMesh, block};
use mechanics_core::point_map::PointMap;
use mechanics_core::potential::Potential;
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

/// A beam 1 × 0.25 × 0.25 m, clamped at one end and let go in its weight: E = 1e5 Pa, ν = 0.4, 1000 kg/m³, backward Euler with
/// h = 0.04 s and the tolerance 1e-5 m/s; the ladder is the one of these that is varied.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct HardBeam {
    /// What the ladder is.
    varied: Varied,
    /// How many steps are made.
    steps: Count,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum Varied {
    /// Poisson's ratio.
    PoissonRatio,
    /// The stiffness of the outer half over that of the inner one.
    StiffnessRatio,
    /// The density (kg/m³).
    Density,
    /// The step (s).
    Step,
    /// The smallest dihedral angle (°): a layer across the beam becomes so flat.
    DihedralAngle,
}

struct Beam {
    poisson_ratio: f64,
    stiffness_ratio: f64,
    density: f64,
    step: f64,
    /// The thickness of the flat layer over that of the others.
    flatness: f64,
}

const CELLS: [u32; 3] = [8, 2, 2];
const SIZE: [f64; 3] = [1.0, 0.25, 0.25];

impl HardBeam {
    fn beam(&self, value: f64) -> Beam {
        let mut beam =
            Beam { poisson_ratio: 0.4, stiffness_ratio: 1.0, density: 1000.0, step: 0.04, flatness: 1.0 };
        match self.varied {
            Varied::PoissonRatio => beam.poisson_ratio = value,
            Varied::StiffnessRatio => beam.stiffness_ratio = value,
            Varied::Density => beam.density = value,
            Varied::Step => beam.step = value,
            // In a cell of a × a × ε the smallest angle between faces has the tangent ε/a.
            Varied::DihedralAngle => beam.flatness = value.to_radians().tan(),
        }
        beam
    }
}

impl Beam {
    /// The mesh: the fifth layer from the clamp is so flat, and the sixth so much thicker.
    fn mesh(&self) -> Result<TetMesh, MeshError> {
        let mut mesh = block(&Vec3::zeros(), &Vec3::from(SIZE), CELLS, BoxSplit::Six)?;
        let layer = SIZE[0] / f64::from(CELLS[0]);
        mesh.map_points(|p| {
            let is_far_side = (p.x - 5.0 * layer).abs() < 0.1 * layer;
            let x = if is_far_side { layer * (4.0 + self.flatness) } else { p.x };
            Vec3::new(x, p.y, p.z)
        })?;
        Ok(mesh)
    }

    fn elastic(&self, method: &str, mesh: &TetMesh) -> Result<Vec<Box<dyn Potential>>, ExperimentError> {
        let is_outer = |cell: &[u32; 4]| cell.iter().all(|&i| mesh.points()[i as usize].x > 0.49);
        let (outer, inner): (Vec<_>, Vec<_>) = mesh.cells().iter().copied().partition(is_outer);
        let part = |young: f64, cells: &[[u32; 4]]| {
            let lame =
                Lame::from_young_poisson(young, self.poisson_ratio).map_err(ExperimentError::stopped)?;
            elastic(method, lame, mesh, cells)
        };
        Ok(vec![part(1e5, &inner)?, part(1e5 * self.stiffness_ratio, &outer)?])
    }
}

impl Experiment for HardBeam {
    fn methods(&self) -> &'static [&'static str] {
        LAWS
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let beam = self.beam(at.ladder);
        let mesh = beam.mesh().map_err(ExperimentError::stopped)?;
        let mut elastic = beam.elastic(at.method, &mesh)?;
        let mass = mass(&mesh, beam.density)?;
        let mut gravity =
            DeadLoad::gravity(&mass, &Vec3::new(0.0, 0.0, -9.81)).map_err(ExperimentError::stopped)?;
        let rest = mesh.points();
        let held: Vec<(u32, Vec3)> =
            (0..).zip(rest).filter(|(_, x)| x.x == 0.0).map(|(i, x)| (i, *x)).collect();
        let map = PointMap::with_fixed(rest.len(), &held).map_err(ExperimentError::stopped)?;
        let mut stepper = Stepper::new(mass, map, options(at.method, 1e-5, beam.step));
        let mut state = State::at_rest(rest.to_vec());
        let deformation = Deformation::of(&mesh);
        let (mut effort, mut smallest, mut farthest) = (Effort::default(), f64::INFINITY, 0.0_f64);
        for _ in 0..self.steps.value() {
            let mut terms: Vec<&mut dyn Potential> =
                elastic.iter_mut().map(|term| &mut **term as &mut dyn Potential).collect();
            terms.push(&mut gravity);
            let report = clock
                .time(|| stepper.step(&mut state, &mut terms, beam.step))
                .map_err(ExperimentError::stopped)?;
            effort.add(&report);
            smallest = smallest.min(deformation.smallest_determinant(&state.position));
            let moved = state.position.iter().zip(rest).map(|(x, rest)| (x - rest).norm());
            farthest = moved.fold(farthest, f64::max);
        }
        let angle = mesh.quality_summary().map_or(0.0, |summary| summary.min_dihedral_angle.value);
        let outcome = Outcome::default()
            .invariant("smallest det F", smallest)
            .invariant("largest displacement (m)", farthest)
            .invariant("smallest dihedral angle (°)", angle.to_degrees());
        effort.finished(outcome, at, &state, &skin(&mesh)?)
    }
}
