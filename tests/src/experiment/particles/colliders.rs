//! Triangle meshes in material points: a bunny pushed into sand, a bunny under water, a sheet between two waters.

mod bed;
mod obstacle;
mod sheet;
mod water;

pub(in crate::experiment) use bed::BunnyInSand;
pub(in crate::experiment) use sheet::ThinSheet;
pub(in crate::experiment) use water::BunnyInWater;

use super::method::Method;
use crate::experiment::ExperimentError;
use mechanics_core::tensor::Vec3;
use mpm_core::{Simulation, SimulationOptions};

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
