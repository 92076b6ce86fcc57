//! Chains and cloth that hang between two ends, against catenaries.

use super::{Problem, area_load, cable, counted};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Positive;
use lagrangian::element::ThinError;
use lagrangian::element::membrane::{Membranes, NeoHookeanSheet};
use lagrangian::element::rod::RodStretching;
use mechanics_core::mesh::{Diagonals, MeshError, rod, sheet};
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

/// A chain, or a cloth strip with ν = 0, between ends one apart, with unit weight a length; the ladder is one over the
/// number of cells along it.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct HangingCable {
    /// The unstretched length over the span.
    length: Positive,
    /// The sag over the span of a cable that does not stretch.
    stiff_sag: Positive,
    /// Axial stiffness over the weight of a unit length, where the body is to stretch.
    axial_stiffness: Positive,
}

/// Axial stiffness in the stiff limit: the sag changes by a millionth.
const STIFF: f64 = 1e7;
const WIDTH: f64 = 0.25;
const THICKNESS: f64 = 0.01;

#[derive(Debug, thiserror::Error)]
enum SetUpError {
    #[error(transparent)]
    Mesh(#[from] MeshError),
    #[error(transparent)]
    Thin(#[from] ThinError),
}

impl Experiment for HangingCable {
    fn methods(&self) -> &'static [&'static str] {
        &["chain-stiff", "chain-elastic", "cloth-stiff", "cloth-elastic"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let cells = (1.0 / at.ladder).round() as u32;
        let length = self.length.value();
        let stiff = at.method.ends_with("stiff");
        let axial = if stiff { STIFF } else { self.axial_stiffness.value() };
        let is_chain = at.method.starts_with("chain");
        let set_up = if is_chain { chain(cells, length, axial) } else { cloth(cells, length, axial) };
        let (problem, lowest) = set_up.map_err(ExperimentError::stopped)?;
        let found = problem.solve(clock)?;
        let expected = match (stiff, is_chain) {
            (true, _) => self.stiff_sag.value(),
            (false, true) => cable::sag(1.0, length, &|tension| 1.0 + tension / axial),
            // The law of the sheet with ν = 0: T = ½ EA (λ − 1/λ).
            (false, false) => cable::sag(1.0, length, &|tension| {
                let t = tension / axial;
                t + (1.0 + t * t).sqrt()
            }),
        };
        let sag = -found.position[lowest as usize].z;
        Ok(counted(Outcome::default().error("sag", (sag / expected - 1.0).abs()), &[found]))
    }
}

/// What is to be solved, and the lowest point.
type Hanging = Result<(Problem, u32), SetUpError>;

fn chain(n: u32, length: f64, axial: f64) -> Hanging {
    let mesh = rod(&Vec3::zeros(), &(Vec3::x() * length), n)?;
    let problem = Problem {
        terms: vec![Box::new(RodStretching::term("stretching", &mesh, axial)?)],
        forces: vec![-Vec3::z() * (length / f64::from(n)); mesh.points().len()],
        held: vec![0, n],
        start: folded(mesh.points(), length),
        tolerance: 1e-9,
    };
    Ok((problem, n / 2))
}

fn cloth(n: u32, length: f64, axial: f64) -> Hanging {
    let rows = 2;
    let mesh = sheet([length, WIDTH], [n, rows], Diagonals::Rising)?;
    let law = NeoHookeanSheet::new(axial / (WIDTH * THICKNESS), 0.0)?;
    let problem = Problem {
        terms: vec![Box::new(Membranes::term("membrane", &mesh, law, THICKNESS)?)],
        forces: area_load(&mesh, &(-Vec3::z() / WIDTH)),
        held: (0..=rows).flat_map(|j| [(n + 1) * j, (n + 1) * j + n]).collect(),
        start: folded(mesh.points(), length),
        tolerance: 1e-9,
    };
    Ok((problem, n / 2 + (n + 1)))
}

/// A fold that is a little too long, to start from.
fn folded(points: &[Vec3], length: f64) -> Vec<Vec3> {
    let depth = 0.5 * (length * length - 1.0).sqrt();
    let place = |p: &Vec3| {
        let s = p.x / length;
        Vec3::new(s, p.y, -1.01 * depth * (1.0 - (2.0 * s - 1.0).abs()))
    };
    points.iter().map(place).collect()
}
