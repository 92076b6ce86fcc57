//! Cook's membrane: a clamped, tapered panel in plane stress, sheared at its far edge.

use super::{Equilibrium, Problem, counted};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Positive;
use lagrangian::element::membrane::LinearMembranes;
use mechanics_core::mesh::{Diagonals, TriMesh, sheet};
use mechanics_core::projection::Projection;
use mechanics_core::stencil::{LocalHessian, Stencil, StencilTerm};
use mechanics_core::tensor::{Mat3, Vec3};
use schemars::JsonSchema;
use serde::Deserialize;

/// Linear membranes on the panel with corners (0, 0), (48, 44), (48, 60), (0, 44), E = 1, ν = ⅓, thickness 1, total load
/// 1; the ladder is one over the number of cells along an edge.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct CooksMembrane {
    /// The displacement of the middle of the loaded edge, across, in the limit (m).
    limit_m: Positive,
}

/// Springs that hold points in the plane z = 0, where nothing pulls them out of it.
struct InPlane;

impl Stencil<1> for InPlane {
    fn value(&self, _: usize, x: &[Vec3; 1]) -> f64 {
        0.5 * x[0].z * x[0].z
    }

    fn gradient(&self, _: usize, x: &[Vec3; 1]) -> [Vec3; 1] {
        [Vec3::z() * x[0].z]
    }

    fn hessian(&self, _: usize, _: &[Vec3; 1], _: Projection) -> LocalHessian<1> {
        [[Mat3::from_diagonal(&Vec3::z())]]
    }
}

impl Experiment for CooksMembrane {
    fn methods(&self) -> &'static [&'static str] {
        &["crossed", "alternating", "rising", "crossed-extrapolated"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let cells = (1.0 / at.ladder).round() as u32;
        let diagonals = match at.method {
            "alternating" => Diagonals::Alternating,
            "rising" => Diagonals::Rising,
            _ => Diagonals::Crossed,
        };
        let levels = if at.method == "crossed-extrapolated" { 4 } else { 1 };
        let mut found = Vec::new();
        let mut displacements = Vec::new();
        for level in (0..levels).rev() {
            let (displacement, equilibrium) = displacement(cells >> level, diagonals, clock)?;
            displacements.push(displacement);
            found.push(equilibrium);
        }
        let displacement = match displacements[..] {
            [a, b, c, d] => limit([a, b, c, d]),
            _ => displacements[0],
        };
        let error = (displacement - self.limit_m.value()).abs();
        Ok(counted(Outcome::default().error("mid-edge displacement", error), &found))
    }
}

/// The displacement of the middle of the loaded edge with n × n cells.
fn displacement(
    n: u32,
    diagonals: Diagonals,
    clock: &mut Clock,
) -> Result<(f64, Equilibrium), ExperimentError> {
    let mesh = panel(n, diagonals).map_err(ExperimentError::stopped)?;
    let points = mesh.points().len();
    let membrane = LinearMembranes::term("membrane", &mesh, 1.0, 1.0 / 3.0, 1.0);
    let plane = StencilTerm::new("in plane", InPlane, (0..points as u32).map(|i| [i]).collect());
    let mut forces = vec![Vec3::zeros(); points];
    for j in 0..n {
        for end in [j, j + 1] {
            forces[(n + (n + 1) * end) as usize].y += 0.5 / f64::from(n);
        }
    }
    let found = Problem {
        terms: vec![
            Box::new(membrane.map_err(ExperimentError::stopped)?),
            Box::new(plane.map_err(ExperimentError::stopped)?),
        ],
        forces,
        held: (0..=n).map(|j| (n + 1) * j).collect(),
        start: mesh.points().to_vec(),
        tolerance: 1e-8,
    }
    .solve(clock)?;
    let middle = (n + (n + 1) * (n / 2)) as usize;
    Ok((found.position[middle].y - mesh.points()[middle].y, found))
}

fn panel(n: u32, diagonals: Diagonals) -> Result<TriMesh, mechanics_core::mesh::MeshError> {
    let mut mesh = sheet([1.0, 1.0], [n, n], diagonals)?;
    mesh.map_points(|p| Vec3::new(48.0 * p.x, 44.0 * p.x + p.y * (44.0 - 28.0 * p.x), 0.0))?;
    Ok(mesh)
}

/// The limit of values on meshes halved three times, whose error is a h² + b hᵖ with 0 < p < 2 (smooth part and corner):
/// h² is eliminated between neighbours, the rest by Aitken's process.
fn limit(u: [f64; 4]) -> f64 {
    let smooth = |k: usize| (4.0 * u[k + 1] - u[k]) / 3.0;
    let (a, b, c) = (smooth(0), smooth(1), smooth(2));
    c - (c - b) * (c - b) / ((c - b) - (b - a))
}
