//! One material point under each law, driven along paths of deformation, against closed forms and differential equations.
//!
//! Along a path F(s) the points get the exact increments F(s + Δs) F(s)⁻¹, so that what is measured is the law's own integration of
//! the flow. Where the axes stay, logarithmic strains are additive and the exact flow is an ordinary differential equation in them.

mod clay;
mod cycles;
mod drive;
mod extrapolation;
mod fluid;
mod foam;
mod metal;
mod sand;
mod snow;

pub(super) use clay::ClayPoint;
pub(super) use cycles::LawCycles;
pub(super) use fluid::FluidPoint;
pub(super) use foam::FoamPoint;
pub(super) use metal::MetalPoint;
pub(super) use sand::SandPoint;
pub(super) use snow::SnowPoint;

use mechanics_core::tensor::Mat3;

/// exp of logarithmic strains along the axes.
fn stretched(logarithms: [f64; 3]) -> Mat3 {
    Mat3::from_diagonal(&logarithms.map(f64::exp).into())
}

/// −⅓ tr τ.
fn pressure(tau: &Mat3) -> f64 {
    -tau.trace() / 3.0
}

/// τ without its pressure.
fn deviator(tau: &Mat3) -> Mat3 {
    tau + Mat3::identity() * pressure(tau)
}

/// The x in [0, most] at which a growing `f` is zero, to the last bits, by bisection; 0 or `most` where it has no zero between.
fn zero_of_growing(most: f64, f: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, most);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        *(if f(middle) > 0.0 { &mut high } else { &mut low }) = middle;
    }
    0.5 * (low + high)
}
