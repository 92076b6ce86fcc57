//! A cloth strip that swings from one corner.

use super::Effort;
use super::body::options;
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{Count, Positive};
use lagrangian::element::hinge::{Hinges, RestAngle, flexural_rigidity};
use lagrangian::element::membrane::{Membranes, NeoHookeanSheet, SaintVenantKirchhoffSheet};
use lagrangian::element::plate::PlateBending;
use lagrangian::element::strain_limit::StrainLimits;
use lagrangian::element::{DeadLoad, Mass, ThinError};
use lagrangian::stepper::Stepper;
use mechanics_core::mesh::{Diagonals, MeshError, TriMesh, sheet, triangle_area_vector};
use mechanics_core::point_map::PointMap;
use mechanics_core::potential::Potential;
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

/// A strip 1 × 0.2 m and 0.5 mm thick, E = 1e6 Pa, ν = 0.3, 400 kg/m³, let go level and held by one corner; backward Euler,
/// h = 0.04 s, tolerance 1e-3 m/s; the ladder is one over the number of cells along it.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct HardCloth {
    /// The step (s).
    step_s: Positive,
    /// How many steps are made.
    steps: Count,
}

const SIZE: [f64; 2] = [1.0, 0.2];
const THICKNESS: f64 = 5e-4;
const YOUNG: f64 = 1e6;
const POISSON: f64 = 0.3;
const DENSITY: f64 = 400.0;

#[derive(Debug, thiserror::Error)]
enum SetUpError {
    #[error(transparent)]
    Mesh(#[from] MeshError),
    #[error(transparent)]
    Thin(#[from] ThinError),
}

/// The energies of a method, and the largest stretch it allows.
fn terms(method: &str, mesh: &TriMesh) -> Result<Vec<Box<dyn Potential>>, SetUpError> {
    let mut terms: Vec<Box<dyn Potential>> = Vec::new();
    if method.starts_with("saint-venant-kirchhoff") {
        let law = SaintVenantKirchhoffSheet::new(YOUNG, POISSON)?;
        terms.push(Box::new(Membranes::term("membrane", mesh, law, THICKNESS)?));
    } else {
        let law = NeoHookeanSheet::new(YOUNG, POISSON)?;
        terms.push(Box::new(Membranes::term("membrane", mesh, law, THICKNESS)?));
    }
    if method.contains("shape-operators") {
        let plate = PlateBending::new("bending", mesh, YOUNG, POISSON, THICKNESS, RestAngle::Flat)?;
        terms.push(Box::new(plate));
    } else {
        let rigidity = flexural_rigidity(YOUNG, POISSON, THICKNESS)?;
        terms.push(Box::new(Hinges::new(mesh, rigidity, RestAngle::Flat)?.term("bending")?));
    }
    if method.ends_with("limited") {
        terms.push(Box::new(StrainLimits::term("limit", mesh, [1.02, 1.05], YOUNG, THICKNESS)?));
    }
    Ok(terms)
}

impl Experiment for HardCloth {
    fn methods(&self) -> &'static [&'static str] {
        &[
            "neo-hookean-hinges",
            "neo-hookean-shape-operators",
            "neo-hookean-shape-operators-on-demand",
            "neo-hookean-hinges-limited",
            "saint-venant-kirchhoff-hinges",
        ]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let n = (1.0 / at.ladder).round() as u32;
        let mesh =
            sheet(SIZE, [n, (n / 5).max(1)], Diagonals::Alternating).map_err(ExperimentError::stopped)?;
        let mut terms = terms(at.method, &mesh).map_err(ExperimentError::stopped)?;
        let mut mass = Mass::zeros(mesh.points().len());
        for (triangle, area) in mesh.triangles().iter().zip(mesh.areas()) {
            for &i in triangle {
                mass.add_point(i, DENSITY * THICKNESS * area / 3.0).map_err(ExperimentError::stopped)?;
            }
        }
        let gravity =
            DeadLoad::gravity(&mass, &Vec3::new(0.0, 0.0, -9.81)).map_err(ExperimentError::stopped)?;
        terms.push(Box::new(gravity));
        let map = PointMap::with_fixed(mesh.points().len(), &[(0, mesh.points()[0])])
            .map_err(ExperimentError::stopped)?;
        let mut stepper = Stepper::new(mass, map, options(at.method, 1e-3, self.step_s.value()));
        let mut state = State::at_rest(mesh.points().to_vec());
        let mut terms: Vec<&mut dyn Potential> =
            terms.iter_mut().map(|term| &mut **term as &mut dyn Potential).collect();
        let mut effort = Effort::default();
        let (mut smallest, mut farthest) = (f64::INFINITY, 0.0_f64);
        for _ in 0..self.steps.value() {
            let report = clock
                .time(|| stepper.step(&mut state, &mut terms, self.step_s.value()))
                .map_err(ExperimentError::stopped)?;
            effort.add(&report);
            smallest = smallest.min(smallest_area_ratio(&mesh, &state.position));
            farthest = state.position.iter().map(|x| (x - mesh.points()[0]).norm()).fold(farthest, f64::max);
        }
        let fastest = state.velocity.iter().map(|v| v.norm()).fold(0.0, f64::max);
        let outcome = Outcome::default()
            .invariant("smallest area over that at rest", smallest)
            .invariant("farthest point from the corner (m)", farthest)
            .invariant("fastest point at the end (m/s)", fastest);
        effort.finished(outcome, at, &state, mesh.triangles())
    }
}

fn smallest_area_ratio(mesh: &TriMesh, x: &[Vec3]) -> f64 {
    let rest = mesh.areas();
    let area = |triangle: &[u32; 3]| triangle_area_vector(&triangle.map(|i| x[i as usize])).norm();
    mesh.triangles().iter().zip(rest).map(|(t, rest)| area(t) / rest).fold(f64::INFINITY, f64::min)
}
