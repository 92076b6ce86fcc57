//! One formula, written once over `Scalar`, run three ways: on one number, on eight lanes, and through jets.
//!
//! The formula is the neo-Hookean energy density of a bar stretched by λ along its axis and by μ across it,
//! ψ(λ, μ) = ½ (λ² + 2μ² − 3) − ln J + ½ ln² J with J = λμ² (shear modulus and first Lamé constant one).
//! At λ = 1.5, μ = 0.9 the closed forms give ∂ψ/∂λ = λ + (ln J − 1)/λ = 0.96313 and
//! ∂²ψ/∂λ² = 1 + (2 − ln J)/λ² = 1.80233.
//!
//! `cargo run -p mechanics-core --example one_formula_three_ways`

#![allow(clippy::print_stdout, reason = "an example prints")]

use mechanics_core::jet::Jet2;
use mechanics_core::lanes::{LaneKernel, Packet, dispatch};
use mechanics_core::scalar::Scalar;

/// ψ(λ, μ), see above.
#[inline(always)]
fn energy<S: Scalar>(along: S, across: S) -> S {
    let log_volume = (along * across.square()).ln();
    let shear = (along.square() + across.square().scale(2.0)).offset(-3.0).scale(0.5);
    shear - log_volume + log_volume.square().scale(0.5)
}

/// The energies of many bars.
struct Energies<'a> {
    along: &'a [f32],
    across: &'a [f32],
    energies: &'a mut [f32],
}

impl LaneKernel<f32> for Energies<'_> {
    /// How many bars moved together.
    type Output = usize;

    #[inline(always)]
    fn run<P: Packet<Element = f32>>(self) -> usize {
        let chunks = self.energies.chunks_mut(P::LANES);
        for ((result, a), b) in chunks.zip(self.along.chunks(P::LANES)).zip(self.across.chunks(P::LANES)) {
            energy(P::load_or(a, 1.0), P::load_or(b, 1.0)).store_prefix(result);
        }
        P::LANES
    }
}

fn main() {
    println!("one number:  psi(1.5, 0.9) = {:.6}", energy(1.5, 0.9));

    let along: Vec<f32> = (0..1001).map(|i| 1.0 + 0.001 * i as f32).collect();
    let across = vec![0.9; 1001];
    let mut energies = vec![0.0; 1001];
    let lanes = dispatch(Energies { along: &along, across: &across, energies: &mut energies });
    println!("{lanes} lanes:     psi({}, 0.9) = {:.6}", along[500], energies[500]);

    let [a, b] = Jet2::variables([1.5, 0.9]);
    let psi = energy(a, b);
    println!("jets:        dpsi/dlambda = {:.5}, closed form 0.96313", psi.gradient[0]);
    println!("             d2psi/dlambda2 = {:.5}, closed form 1.80233", psi.hessian(0, 0));
    println!(
        "             d2psi/dlambda dmu = {:.5}, closed form 2/(lambda mu) = 1.48148",
        psi.hessian(0, 1)
    );
}
