//! Clamped rods and strips that bend far, against the elastica.

use super::{Equilibrium, Problem, area_load, counted};
use crate::experiment::random::Random;
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Positive;
use lagrangian::element::ThinError;
use lagrangian::element::hinge::{Hinges, RestAngle, flexural_rigidity};
use lagrangian::element::membrane::{Membranes, NeoHookeanSheet};
use lagrangian::element::plate::PlateBending;
use lagrangian::element::rod::{RodBending, RodStretching};
use mechanics_core::mesh::{Diagonals, MeshError, TriMesh, rod, sheet};
use mechanics_core::potential::Potential;
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

/// A cantilever of length 1 and flexural rigidity 1 under loads, as a rod or as a strip with ν = 0, 0.1 wide and 0.001
/// thick; the ladder is one over the number of cells along it.
///
/// The first cell is clamped with the wall in its middle: a joint stands for half a cell to either side, so the share of
/// the first joint that bends begins at the wall.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ElasticaCantilever {
    /// What bends it.
    load: Load,
    /// Loads with their deflections: one measure each.
    cases: Vec<Case>,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum Load {
    /// A force P at the tip; its strength is PL²/EI.
    Tip,
    /// A weight w an length; its strength is wL³/EI.
    OwnWeight,
}

#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Case {
    /// The dimensionless load.
    strength: Positive,
    /// How far the tip is lowered, over the length.
    deflection: Positive,
}

const WIDTH: f64 = 0.1;
const THICKNESS: f64 = 1e-3;
/// Axial stiffness over P of the rod: it does not stretch.
const AXIAL: f64 = 1e8;
/// Points of irregular meshes move by up to this part of a cell.
const DISORDER: f64 = 0.25;

impl Experiment for ElasticaCantilever {
    fn methods(&self) -> &'static [&'static str] {
        &[
            "rod",
            "shape-operators",
            "shape-operators-alternating",
            "shape-operators-irregular",
            "hinges",
            "hinges-irregular",
        ]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let cells = (1.0 / at.ladder).round() as u32;
        let mut outcome = Outcome::default();
        let mut found = Vec::new();
        for case in &self.cases {
            let strength = case.strength.value();
            let problem = match at.method {
                "rod" => self.rod(cells, strength),
                _ => self.strip(at, cells, strength),
            };
            let (problem, tip) = problem.map_err(ExperimentError::stopped)?;
            let equilibrium: Equilibrium = problem.solve(clock)?;
            let heights = tip.iter().map(|&i| -equilibrium.position[i as usize].z);
            let deflection = heights.sum::<f64>() / tip.len() as f64;
            let name = match self.load {
                Load::Tip => format!("deflection at PL²/EI = {strength}"),
                Load::OwnWeight => format!("deflection at wL³/EI = {strength}"),
            };
            outcome = outcome.error(&name, (deflection / case.deflection.value() - 1.0).abs());
            found.push(equilibrium);
        }
        Ok(counted(outcome, &found))
    }
}

#[derive(Debug, thiserror::Error)]
enum SetUpError {
    #[error(transparent)]
    Mesh(#[from] MeshError),
    #[error(transparent)]
    Thin(#[from] ThinError),
}

/// What is to be solved, and the points of the tip.
type Cantilever = Result<(Problem, Vec<u32>), SetUpError>;

impl ElasticaCantilever {
    fn rod(&self, n: u32, strength: f64) -> Cantilever {
        let h = 1.0 / (f64::from(n) - 0.5);
        let mesh = rod(&Vec3::new(-0.5 * h, 0.0, 0.0), &Vec3::x(), n)?;
        let mut forces = vec![Vec3::zeros(); mesh.points().len()];
        match self.load {
            Load::Tip => forces[n as usize].z = -strength,
            Load::OwnWeight => {
                forces.fill(-Vec3::z() * (strength * h));
                forces[n as usize] *= 0.5;
            }
        }
        let problem = Problem {
            terms: vec![
                Box::new(RodStretching::term("stretching", &mesh, AXIAL)?),
                Box::new(RodBending::new(&mesh, 1.0)?.term("bending")?),
            ],
            forces,
            held: vec![0, 1],
            start: mesh.points().to_vec(),
            tolerance: 1e-9,
        };
        Ok((problem, vec![n]))
    }

    /// A strip of square cells, of half the height where there would be fewer than two rows.
    fn strip(&self, at: &Point<'_>, n: u32, strength: f64) -> Cantilever {
        let rows = (n / 10).max(2);
        let mesh = strip_mesh(at, [n, rows])?;
        let young = 12.0 / (WIDTH * THICKNESS.powi(3));
        let law = NeoHookeanSheet::new(young, 0.0)?;
        let bending: Box<dyn Potential> = if at.method.starts_with("hinges") {
            let rigidity = flexural_rigidity(young, 0.0, THICKNESS)?;
            Box::new(Hinges::new(&mesh, rigidity, RestAngle::OfMesh)?.term("bending")?)
        } else {
            Box::new(PlateBending::new("bending", &mesh, young, 0.0, THICKNESS, RestAngle::OfMesh)?)
        };
        let tip: Vec<u32> = (0..=rows).map(|j| n + (n + 1) * j).collect();
        let forces = match self.load {
            Load::Tip => {
                let mut forces = vec![Vec3::zeros(); mesh.points().len()];
                for ends in tip.windows(2) {
                    ends.iter().for_each(|&i| forces[i as usize].z -= 0.5 * strength / f64::from(rows));
                }
                forces
            }
            Load::OwnWeight => area_load(&mesh, &(-Vec3::z() * (strength / WIDTH))),
        };
        let problem = Problem {
            terms: vec![Box::new(Membranes::term("membrane", &mesh, law, THICKNESS)?), bending],
            forces,
            held: (0..=rows).flat_map(|j| [(n + 1) * j, (n + 1) * j + 1]).collect(),
            start: mesh.points().to_vec(),
            tolerance: 1e-8,
        };
        Ok((problem, tip))
    }
}

/// The strip at rest; in irregular meshes points move within the plane, but not those of rims and of the clamped cells.
fn strip_mesh(at: &Point<'_>, cells: [u32; 2]) -> Result<TriMesh, MeshError> {
    let [n, rows] = cells.map(f64::from);
    let h = 1.0 / (n - 0.5);
    let alternating = at.method.ends_with("alternating");
    let diagonals = if alternating { Diagonals::Alternating } else { Diagonals::Rising };
    let mut mesh = sheet([h * n, WIDTH], cells, diagonals)?;
    let random = std::cell::RefCell::new(Random::new(at.seed));
    let disorder = if at.method.ends_with("irregular") { DISORDER } else { 0.0 };
    let within = |p: &Vec3| p.x > 1.01 * h && p.x < h * n - 1e-9 && p.y > 1e-9 && p.y < WIDTH - 1e-9;
    mesh.map_points(|p| {
        let number = || random.borrow_mut().symmetric();
        let moved = Vec3::new(h * number(), WIDTH / rows * number(), 0.0) * disorder;
        p - Vec3::x() * (0.5 * h) + if within(p) { moved } else { Vec3::zeros() }
    })?;
    Ok(mesh)
}
