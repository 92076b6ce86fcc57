//! Triangle meshes in material points: a bunny pushed into sand, a bunny under water, a sheet between two waters.

mod bed;
mod obstacle;
mod sheet;
mod water;

pub(in crate::experiment) use bed::BunnyInSand;
pub(in crate::experiment) use sheet::ThinSheet;
pub(in crate::experiment) use water::BunnyInWater;

use super::cloud::Cloud;
use super::method::Method;
use crate::experiment::ExperimentError;
use mechanics_core::tensor::{Mat3, Vec3};
use mpm_constitutive::PointLaw;
use mpm_core::{Samples, Simulation, SimulationOptions};

const GRAVITY: f64 = 9.81;

/// Of water, in its equation of state.
const EXPONENT: f64 = 7.0;

type Space = Simulation<f64, 3>;

/// J of water at rest under `depth` \[m\] of itself. With p = (K/γ)(J⁻ᵞ − 1) and dp = ρ g/J dz: J¹⁻ᵞ = 1 + (γ − 1) ρ g z/K.
fn ratio_at(depth: f64, density: f64, bulk_modulus: f64) -> f64 {
    let rest = EXPONENT - 1.0;
    (1.0 + rest * density * GRAVITY * depth / bulk_modulus).powf(-1.0 / rest)
}

/// Its pressure \[Pa\].
fn pressure_at(depth: f64, density: f64, bulk_modulus: f64) -> f64 {
    bulk_modulus / EXPONENT * (ratio_at(depth, density, bulk_modulus).powf(-EXPONENT) - 1.0)
}

/// An empty space with gravity along −z.
fn space(method: Method, spacing: f64) -> Result<Space, ExperimentError> {
    let options = SimulationOptions { spacing, kernel: method.kernel, transfer: method.transfer };
    let mut space = Simulation::new(options).map_err(ExperimentError::stopped)?;
    space.set_gravity([0.0, 0.0, -GRAVITY]).map_err(ExperimentError::stopped)?;
    Ok(space)
}

/// Adds a body at rest that its own weight presses together, each particle in height only, by F₃₃ = `stretch` of its place; with V₀ of its particles \[m³\].
fn add_pressed<L: PointLaw + 'static>(
    space: &mut Space,
    (law, density): (L, f64),
    cloud: &Cloud<3>,
    stretch: impl Fn(&[f64; 3]) -> f64,
) -> Result<Vec<f64>, ExperimentError> {
    let stretches: Vec<f64> = cloud.points.iter().map(stretch).collect();
    let volumes: Vec<f64> = cloud.volumes.iter().zip(&stretches).map(|(v, j)| v / j).collect();
    let velocities = vec![[0.0; 3]; volumes.len()];
    let samples = Samples { positions: &cloud.points, velocities: &velocities, volumes: &volumes };
    let body = space.add_body(law, density, samples).map_err(ExperimentError::stopped)?;
    let pressed: Vec<Mat3> = stretches.iter().map(|j| Mat3::from_diagonal(&[1.0, 1.0, *j].into())).collect();
    space.set_deformation_gradients(body, &pressed).map_err(ExperimentError::stopped)?;
    Ok(volumes)
}

/// What is left of the momentum of all bodies, gravity's impulse and what the colliders took: nothing, whatever the error.
struct Balance {
    mass: f64,
    start: Vec3,
    worst: f64,
    worst_mass: f64,
}

impl Balance {
    fn start(space: &Space) -> Self {
        let (mass, start) = sums(space);
        Self { mass, start, worst: 0.0, worst_mass: 0.0 }
    }

    /// Compares momenta by the largest of what gravity and the colliders have given.
    fn look(&mut self, space: &Space, gravity: f64) {
        let (mass, momentum) = sums(space);
        self.worst_mass = self.worst_mass.max((mass / self.mass - 1.0).abs());
        let loads = (0..space.collider_count()).map(|k| space.collider_load(k).total.linear);
        let (taken, size) =
            loads.fold((Vec3::zeros(), 0.0_f64), |(sum, size), load| (sum + load, size.max(load.norm())));
        let weight = Vec3::new(0.0, 0.0, -gravity * self.mass * space.time());
        let left = momentum - self.start + taken - weight;
        self.worst = self.worst.max(left.norm() / size.max(weight.norm()).max(f64::MIN_POSITIVE));
    }
}

/// Mass and momentum of all bodies.
fn sums(space: &Space) -> (f64, Vec3) {
    (0..space.body_count())
        .map(|body| space.totals(body))
        .fold((0.0, Vec3::zeros()), |(mass, momentum), t| (mass + t.mass, momentum + t.momentum))
}
