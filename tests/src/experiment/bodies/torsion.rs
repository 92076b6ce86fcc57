//! A neo-Hookean cylinder twisted between two clamps.
//!
//! Turned by ψ per length and held at its length, a cylinder of radius a keeps plane and round sections if it is incompressible. Its
//! torque is M = ½πμψa⁴, and it pushes its clamps apart by N = ¼πμψ²a⁴ (Poynting's effect).
//!
//! Reference: R. S. Rivlin, *Large elastic deformations of isotropic materials VI*, Phil. Trans. R. Soc. A 242 (1949).

use super::counted;
use super::portrait::pictured;
use super::solid::{Shape, Solid};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{Count, Finite, PoissonRatio, Positive};
use lagrangian::element::{EDGES, Mass, QuadraticMesh};
use lagrangian::stepper::{Stepper, StepperOptions};
use mechanics_core::law::{Lame, NeoHookean};
use mechanics_core::mesh::{TetMesh, cylinder};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::point_map::PointMap;
use mechanics_core::projection::Projection;
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::PI;

/// What the ladder is.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
enum Ladder {
    /// The distance of nodes along the radius (m), of a material with this ν.
    NodeDistance {
        /// ν [1].
        poisson_ratio: PoissonRatio,
    },
    /// 1 − 2ν, with so many cells along the radius.
    Compressibility {
        /// Cells along the radius.
        rings: Count,
    },
}

/// The cylinder.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Torsion {
    /// What the ladder is.
    ladder: Ladder,
    /// a [m].
    radius_m: Positive,
    /// [m]
    length_m: Positive,
    /// μ [Pa].
    shear_modulus_pa: Positive,
    /// ψ [rad/m].
    twist_rad_m: Finite,
    /// The twist is put on in so many steps.
    load_steps: Count,
}

impl Experiment for Torsion {
    fn methods(&self) -> &'static [&'static str] {
        &["linear", "ten-node, straight edges", "ten-node, curved edges"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let (mut solid, mu) = self.solid(at)?;
        let (a, length, twist) = (self.radius_m.value(), self.length_m.value(), self.twist_rad_m.value());
        let top = |x: &Vec3| (x.z - length).abs() < 1e-9 * length;
        let turned = |x: &Vec3| {
            let (sin, cos) = (twist * x.z).sin_cos();
            Vec3::new(cos * x.x - sin * x.y, sin * x.x + cos * x.y, x.z)
        };
        let mut clamped = solid.held(|x| x.z == 0.0 || top(x));
        clamped.iter_mut().for_each(|(_, x)| *x = turned(x));
        let count = solid.points.len();
        let map = PointMap::with_fixed(count, &clamped).map_err(ExperimentError::stopped)?;
        let newton = NewtonOptions { tolerance: 1e-10, ..NewtonOptions::default() };
        // The body is stable all the way, so that the true Hessian serves, with fewer iterations than a projected one.
        let options = StepperOptions { newton, projection: Projection::None, ..StepperOptions::default() };
        let mut stepper = Stepper::new(Mass::zeros(count), map, options);
        let mut state = State::at_rest(solid.points.clone());
        let load_steps = self.load_steps.value() as u32;
        let report = clock
            .time(|| stepper.equilibrium(&mut state, &mut [solid.elastic.as_mut()], load_steps))
            .map_err(ExperimentError::stopped)?;

        let mut forces = vec![Vec3::zeros(); count];
        solid.elastic.add_gradient(&state.position, &mut forces);
        let (mut torque, mut push) = (0.0, 0.0);
        for ((rest, force), x) in solid.points.iter().zip(&forces).zip(&state.position) {
            if top(rest) {
                torque += x.x * force.y - x.y * force.x;
                push -= force.z;
            }
        }
        let exact_torque = 0.5 * PI * mu * twist * a.powi(4);
        let exact_push = 0.25 * PI * mu * twist * twist * a.powi(4);
        let outcome = Outcome::default()
            .error("torque", (torque / exact_torque - 1.0).abs())
            .error("push", (push / exact_push - 1.0).abs())
            .count("unknowns", 3 * (count - clamped.len()) as u64)
            .invariant("smallest volume ratio", solid.smallest_volume_ratio(&state.position))
            .invariant("torque ratio", torque / exact_torque)
            .invariant("push ratio", push / exact_push)
            .state(state.hash());
        let outcome = pictured(outcome, at, &solid, &state.position, "the twisted cylinder")?;
        Ok(counted(outcome, &report, clock))
    }
}

impl Torsion {
    /// The cylinder at rest, and its μ [Pa].
    fn solid(&self, at: &Point<'_>) -> Result<(Solid, f64), ExperimentError> {
        let (a, length) = (self.radius_m.value(), self.length_m.value());
        let is_linear = at.method == "linear";
        let (rings, poisson) = match self.ladder {
            Ladder::NodeDistance { poisson_ratio } => {
                let cell = if is_linear { at.ladder } else { 2.0 * at.ladder };
                ((a / cell).round().max(1.0) as u32, poisson_ratio.value())
            }
            Ladder::Compressibility { rings } => (rings.value() as u32, 0.5 * (1.0 - at.ladder)),
        };
        let layers = (f64::from(rings) * length / a).round().max(1.0) as u32;
        let mu = self.shear_modulus_pa.value();
        let lame = Lame::from_young_poisson(2.0 * mu * (1.0 + poisson), poisson)
            .map_err(ExperimentError::stopped)?;
        let law = NeoHookean::new(lame);
        let mesh = cylinder(a, length, rings, layers).map_err(ExperimentError::stopped)?;
        let solid = if is_linear {
            Solid::new(law, &mesh, Shape::Linear)?
        } else if at.method.ends_with("curved edges") {
            Solid::of_ten_nodes(law, rounded(&mesh, a))?
        } else {
            Solid::new(law, &mesh, Shape::TenNode)?
        };
        Ok((solid, lame.mu()))
    }
}

/// Ten-node tetrahedra whose nodes at the middle of the rim's chords are moved out onto the circle.
fn rounded(mesh: &TetMesh, a: f64) -> QuadraticMesh {
    let mut mesh = QuadraticMesh::new(mesh);
    let radius = |x: &Vec3| x.x.hypot(x.y);
    for cell in &mesh.cells {
        for (edge, &node) in EDGES.iter().zip(&cell[4..]) {
            if edge.iter().all(|&corner| radius(&mesh.points[cell[corner] as usize]) > 0.999 * a) {
                let x = mesh.points[node as usize];
                let stretch = a / radius(&x);
                mesh.points[node as usize] = Vec3::new(x.x * stretch, x.y * stretch, x.z);
            }
        }
    }
    mesh
}
