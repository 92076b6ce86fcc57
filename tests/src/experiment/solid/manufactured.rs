//! Statics with a manufactured solution: order of convergence in the mesh size.
//!
//! Choose a motion φ(X) = X + u(X) of the unit cube. It is in equilibrium under the body force b = −Div P(∇φ), where
//! (Div P)ᵢ = Σⱼₖₗ ∂Pᵢⱼ/∂Fₖₗ ∂²φₖ/∂Xₗ∂Xⱼ, with φ prescribed on the boundary. Linear tetrahedra of size h then find φ up to
//! O(h²) in L² and its gradient up to O(h). Integrals over a tetrahedron use four points, exact for degree two.
//!
//! # Reference
//! P. G. Ciarlet, *The Finite Element Method for Elliptic Problems*, 1978, theorems 3.2.2 and 3.2.5 (orders);
//! P. C. Hammer, A. H. Stroud, *Numerical integration over simplexes*, 1956 (the four points).

use super::elastic_term;
use super::element::RestShapes;
use super::material::{lame, stiffness};
use super::statics::Statics;
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::physics::{Isotropic, Law};
use crate::scene::quantity::Positive;
use mechanics_core::law::{FixedCorotated, Hyperelastic, NeoHookean, StVenantKirchhoff, StableNeoHookean};
use mechanics_core::linear::Method;
use mechanics_core::mesh::{BoxSplit, TetMesh, block};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::projection::Projection;
use mechanics_core::state::StateHash;
use mechanics_core::tensor::{Mat3, Vec3};
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::PI;

/// The unit cube under the motion uᵢ = a sin(π wᵢ · X + i); the ladder is the size of the cells, 1/n.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ManufacturedStatics {
    /// The material's constants.
    constants: Isotropic,
    /// The amplitude a [m].
    amplitude_m: Positive,
}

/// The wave vectors wᵢ of the motion.
const WAVES: [[f64; 3]; 3] = [[0.6, 0.8, -0.4], [-0.5, 0.7, 0.9], [0.8, -0.3, 0.6]];

impl Experiment for ManufacturedStatics {
    fn methods(&self) -> &'static [&'static str] {
        &["neo-hookean", "stable-neo-hookean", "fixed-corotated", "saint-venant-kirchhoff"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let lame = lame(&self.constants).map_err(ExperimentError::stopped)?;
        match at.method {
            "neo-hookean" => self.solve(&NeoHookean::new(lame), Law::NeoHookean(self.constants), at, clock),
            "stable-neo-hookean" => {
                self.solve(&StableNeoHookean::new(lame), Law::StableNeoHookean(self.constants), at, clock)
            }
            "fixed-corotated" => {
                self.solve(&FixedCorotated::new(lame), Law::FixedCorotated(self.constants), at, clock)
            }
            // The only other method of the list.
            _ => self.solve(
                &StVenantKirchhoff::new(lame),
                Law::SaintVenantKirchhoff(self.constants),
                at,
                clock,
            ),
        }
    }
}

impl ManufacturedStatics {
    fn solve<L: Hyperelastic>(
        &self,
        law: &L,
        named: Law,
        at: &Point<'_>,
        clock: &mut Clock,
    ) -> Result<Outcome, ExperimentError> {
        let cells = [(1.0 / at.ladder).round() as u32; 3];
        let mesh = block(&Vec3::zeros(), &Vec3::repeat(1.0), cells, BoxSplit::Six)
            .map_err(ExperimentError::stopped)?;
        let rest = RestShapes::of(&mesh).map_err(ExperimentError::stopped)?;
        let term = elastic_term("elasticity", &named, &mesh, 0).map_err(ExperimentError::stopped)?;
        let on_boundary = |p: &Vec3| p.iter().any(|&c| c == 0.0 || c == 1.0);
        let numbered = || (0_u32..).zip(mesh.points());
        let mut statics = Statics {
            terms: vec![term],
            forces: self.forces(law, &mesh),
            held: numbered().filter(|(_, p)| on_boundary(p)).map(|(i, p)| (i, self.motion(p))).collect(),
            method: Method::default(),
            options: NewtonOptions { tolerance: 1e-10, ..NewtonOptions::default() },
            kept: None,
        };
        // Half the displacement in the middle, the whole at the boundary.
        let bubble = |p: &Vec3| p.iter().map(|c| 4.0 * c * (1.0 - c)).product::<f64>();
        let start = |p: &Vec3| p + (self.motion(p) - p) * (1.0 - 0.5 * bubble(p));
        let mut x: Vec<Vec3> = mesh.points().iter().map(start).collect();
        let report = clock.time(|| statics.solve(&mut x)).map_err(ExperimentError::stopped)?;
        clock.add_term("assembly", report.times.assembly);
        clock.add_term("linear solve", report.times.solve);
        let mut hash = StateHash::new();
        hash.add_vectors("position", &x);
        let (position, gradient) = self.errors(&mesh, &rest, &x);
        Ok(Outcome::default()
            .error("position", position)
            .error("gradient", gradient)
            .count("unknowns", 3 * mesh.points().len() as u64 - 3 * statics.held.len() as u64)
            .count("Newton iterations", report.iterations)
            .count("factorisations", report.factorisations)
            .invariant("smallest det F", smallest_volume_ratio(&mesh, &rest, &x))
            .state(hash.value()))
    }

    fn motion(&self, p: &Vec3) -> Vec3 {
        p + Vec3::from_fn(|i, _| self.amplitude_m.value() * phase(i, p).sin())
    }

    fn motion_gradient(&self, p: &Vec3) -> Mat3 {
        let a = self.amplitude_m.value();
        Mat3::identity() + Mat3::from_fn(|i, j| a * PI * WAVES[i][j] * phase(i, p).cos())
    }

    /// −Div P at `p` [N/m³].
    fn body_force<L: Hyperelastic>(&self, law: &L, p: &Vec3) -> Vec3 {
        let stiffness = stiffness(law, &self.motion_gradient(p), Projection::None);
        let a = self.amplitude_m.value();
        let mut force = Vec3::zeros();
        for j in 0..3 {
            // ∂F/∂Xⱼ
            let rate = Mat3::from_fn(|k, l| -a * PI * PI * WAVES[k][l] * WAVES[k][j] * phase(k, p).sin());
            force -= stiffness.apply(&rate).column(j);
        }
        force
    }

    /// The nodal forces ∫ N b dV [N].
    fn forces<L: Hyperelastic>(&self, law: &L, mesh: &TetMesh) -> Vec<Vec3> {
        let mut forces = vec![Vec3::zeros(); mesh.points().len()];
        for (cell, volume) in mesh.volumes().into_iter().enumerate() {
            for (point, weights) in quadrature(&mesh.corners(cell)) {
                let share = self.body_force(law, &point) * (0.25 * volume);
                for (&node, weight) in mesh.cells()[cell].iter().zip(weights) {
                    forces[node as usize] += share * weight;
                }
            }
        }
        forces
    }

    /// Root mean squares over the cube of the errors of positions [m] and of the deformation gradient [1].
    fn errors(&self, mesh: &TetMesh, rest: &RestShapes, x: &[Vec3]) -> (f64, f64) {
        let (mut position, mut gradient) = (0.0, 0.0);
        for (cell, volume) in mesh.volumes().into_iter().enumerate() {
            let nodes = mesh.cells()[cell].map(|node| x[node as usize]);
            let f = rest.deformation_gradient(cell, &nodes);
            for (point, weights) in quadrature(&mesh.corners(cell)) {
                let found: Vec3 = nodes.iter().zip(weights).map(|(node, weight)| node * weight).sum();
                position += 0.25 * volume * (found - self.motion(&point)).norm_squared();
                gradient += 0.25 * volume * (f - self.motion_gradient(&point)).norm_squared();
            }
        }
        (position.sqrt(), gradient.sqrt())
    }
}

fn phase(i: usize, p: &Vec3) -> f64 {
    PI * Vec3::from(WAVES[i]).dot(p) + i as f64
}

/// Four points of equal weight and their barycentric coordinates.
fn quadrature(corners: &[Vec3; 4]) -> [(Vec3, [f64; 4]); 4] {
    let near = 0.25 + 0.15 * 5.0_f64.sqrt();
    let far = (1.0 - near) / 3.0;
    std::array::from_fn(|a| {
        let weights: [f64; 4] = std::array::from_fn(|b| if a == b { near } else { far });
        (corners.iter().zip(weights).map(|(corner, weight)| corner * weight).sum(), weights)
    })
}

/// The smallest det F of all tetrahedra.
pub(crate) fn smallest_volume_ratio(mesh: &TetMesh, rest: &RestShapes, x: &[Vec3]) -> f64 {
    let ratio = |(cell, nodes): (usize, &[u32; 4])| {
        rest.deformation_gradient(cell, &nodes.map(|node| x[node as usize])).determinant()
    };
    mesh.cells().iter().enumerate().map(ratio).fold(f64::INFINITY, f64::min)
}
