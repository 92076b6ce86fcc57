//! Twisted rods and rings at the moment at which they leave their shape.

use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Positive;
use lagrangian::element::ThinError;
use lagrangian::element::rod::{RodBending, RodStretching, RodTwist, TwistSection};
use mechanics_core::mesh::{PolylineEnds, TriMesh, polyline, rod};
use mechanics_core::point_map::PointMap;
use mechanics_core::potential::Potential;
use mechanics_core::projection::Projection;
use mechanics_core::sparse::Assembly;
use mechanics_core::tensor::Vec3;
use nalgebra::{Cholesky, DMatrix};
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::TAU;

/// The moment from which the Hessian of a twisted rod has a negative eigenvalue, relative to that of Kirchhoff's rod; EI = 1. The
/// ladder is one over the number of edges.
///
/// A straight rod between clamps in the middles of its end edges, a length of one apart, or a ring of radius one, bent from a straight rod.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct TwistedRod {
    /// GJ/EI.
    torsional_over_flexural: Positive,
}

/// It does not stretch.
const AXIAL: f64 = 1e6;
/// Eigenvalues of rigid motions are rounding; this lifts them.
const SHIFT: f64 = 1e-5;
/// Half of ML/EI for clamped ends: tan x = x.
const CLAMPED: f64 = 4.493_409_457_909_064;

impl Experiment for TwistedRod {
    fn methods(&self) -> &'static [&'static str] {
        &["clamped-rod", "ring"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let edges = (1.0 / at.ladder).round() as u32;
        let section = TwistSection { torsional: self.torsional_over_flexural.value(), gyration_radius: 0.1 };
        let (twisted, exact): (&dyn Fn(f64) -> Built, f64) = match at.method {
            "ring" => (&|moment| ring(edges, section, moment), 3_f64.sqrt()),
            _ => (&|moment| clamped(edges, section, moment), 2.0 * CLAMPED),
        };
        // At the same positions of points the Hessian is affine in the moment.
        let found = clock.time(|| -> Result<f64, ExperimentError> {
            let untwisted = twisted(0.0)?;
            let rate = (twisted(exact)? - &untwisted) / exact;
            critical([0.5 * exact, 2.0 * exact], |moment| &untwisted + &rate * moment)
        })?;
        Ok(Outcome::default().error("critical moment", (found / exact - 1.0).abs()))
    }
}

type Built = Result<DMatrix<f64>, ExperimentError>;

/// No moment of the interval is critical.
#[derive(Debug, thiserror::Error)]
#[error("the rod is not stable at {low} and unstable at {high}")]
struct NotBetween {
    low: f64,
    high: f64,
}

/// The least moment within bounds for which the matrix is not positive definite.
fn critical(
    [mut low, mut high]: [f64; 2],
    matrix: impl Fn(f64) -> DMatrix<f64>,
) -> Result<f64, ExperimentError> {
    let is_stable = |moment: f64| {
        let matrix = matrix(moment);
        let n = matrix.nrows();
        Cholesky::new(matrix + DMatrix::identity(n, n) * SHIFT).is_some()
    };
    if !is_stable(low) || is_stable(high) {
        return Err(ExperimentError::stopped(NotBetween { low, high }));
    }
    while high - low > 1e-7 * high {
        let middle = 0.5 * (low + high);
        if is_stable(middle) { low = middle } else { high = middle }
    }
    Ok(low)
}

fn clamped(edges: u32, section: TwistSection, moment: f64) -> Built {
    let h = 1.0 / (f64::from(edges) - 1.0);
    let mesh = rod(&Vec3::zeros(), &Vec3::new(h * f64::from(edges), 0.0, 0.0), edges)
        .map_err(ExperimentError::stopped)?;
    let turns = edges + 1..2 * edges + 1;
    let fixed = [0, 1, edges - 1, edges, turns.start, turns.end - 1];
    hessian(&mesh, section, moment, &fixed).map_err(ExperimentError::stopped)
}

fn ring(edges: u32, section: TwistSection, moment: f64) -> Built {
    let at = |i: u32| {
        let angle = TAU * f64::from(i) / f64::from(edges);
        Vec3::new(angle.cos(), angle.sin(), 0.0)
    };
    let mesh =
        polyline((0..edges).map(at).collect(), PolylineEnds::Joined).map_err(ExperimentError::stopped)?;
    hessian(&mesh, section, moment, &[]).map_err(ExperimentError::stopped)
}

#[derive(Debug, thiserror::Error)]
enum BuildError {
    #[error(transparent)]
    Rod(#[from] ThinError),
    #[error(transparent)]
    Map(#[from] mechanics_core::point_map::PointMapError),
}

/// The true Hessian of a rod in the shape of its mesh with the same twisting moment in every joint, by its free points.
fn hessian(
    mesh: &TriMesh,
    section: TwistSection,
    moment: f64,
    fixed: &[u32],
) -> Result<DMatrix<f64>, BuildError> {
    let points = mesh.points().len();
    let mut x = mesh.points().to_vec();
    x.resize(points + mesh.free_edges().len(), Vec3::zeros());
    // Turns at zero and a natural twist of the opposite sign: the same moment as the twist itself.
    let twist = RodTwist::new("twist", mesh, section, points as u32)?
        .with_natural_twist(-moment / section.torsional)?;
    let stretching = RodStretching::term("stretching", mesh, AXIAL)?;
    let bending = RodBending::new(mesh, 1.0)?.term("bending")?;
    let held: Vec<(u32, Vec3)> = fixed.iter().map(|&i| (i, x[i as usize])).collect();
    let map = PointMap::with_fixed(x.len(), &held)?;
    let mut assembly = Assembly::new(&map);
    let mut assembler = assembly.begin(&map);
    let terms: [&dyn Potential; 3] = [&stretching, &bending, &twist];
    for (k, term) in terms.into_iter().enumerate() {
        assembler.begin_term(k);
        term.add_hessian(&x, Projection::None, &mut assembler);
    }
    let matrix = assembler.finish();
    let entry = |row: usize, column: usize| {
        let (r, c) = (row.max(column), row.min(column));
        matrix.pattern().slot(r / 3, c / 3).map_or(0.0, |slot| matrix.blocks()[slot][(r % 3, c % 3)])
    };
    Ok(DMatrix::from_fn(3 * map.unknowns(), 3 * map.unknowns(), entry))
}
