//! Hard cases of contact: no reference, but what must hold whatever happens. After every step nothing intersects by exact
//! predicates, and nobody is on the wrong side of anything; no tetrahedron is inside out. A step that does not converge ends
//! the row with the solver's own words.

mod blocks;
mod chain;
mod cloth;
mod drop;
mod impact;
mod mat;
pub(in crate::experiment) mod pairs;
mod pipe;
pub(in crate::experiment) mod shapes;

pub(crate) use blocks::TwoBlocks;
pub(crate) use chain::LinkedChain;
pub(crate) use cloth::FoldedCloth;
pub(crate) use drop::HardDrop;
pub(crate) use impact::FastImpact;
pub(crate) use mat::TwistedMat;
pub(crate) use pairs::DegeneratePair;
pub(crate) use pipe::NarrowPipe;

use super::world::Material;
use crate::experiment::random::Random;
use ipc_contact::ccd::Detection;
use ipc_contact::contact::ContactOptions;
use ipc_contact::stiffness::{Scale, Stiffness};
use lagrangian::stepper::StepperOptions;
use mechanics_core::newton::NewtonOptions;
use mechanics_core::tensor::Vec3;

pub(in crate::experiment) const GRAVITY: Vec3 = Vec3::new(0.0, 0.0, -9.81);

/// The way of detection that a method names.
fn detection(method: &str) -> Detection {
    if method == "interval" { Detection::Interval } else { Detection::Additive }
}

/// Contact that begins at `activation` (m), about as stiff as a body with edges of length `edge` (m), adaptive.
pub(in crate::experiment) fn contact(activation: f64, material: Material, edge: f64) -> ContactOptions {
    let load = Scale::Load(0.5 * material.young * edge * activation);
    ContactOptions::new(activation, Stiffness::adaptive(load))
}

/// Steps that end at Newton directions below `tolerance` (m/s).
pub(in crate::experiment) fn stepping(tolerance: f64) -> StepperOptions {
    let newton = NewtonOptions { tolerance, max_iterations: 2000, ..NewtonOptions::default() };
    StepperOptions { newton, ..StepperOptions::default() }
}

/// A vector with entries of up to `size`; exactly zero for seed 0, the aligned case.
pub(in crate::experiment) fn jitter(seed: u64, size: f64) -> Vec3 {
    if seed == 0 {
        return Vec3::zeros();
    }
    let mut random = Random::new(seed);
    Vec3::from_fn(|_, _| size * random.symmetric())
}
