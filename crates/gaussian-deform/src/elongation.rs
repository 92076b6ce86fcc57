//! Over-stretched Gaussians: an upper limit of their elongation, or pieces in their place.
//!
//! Stretched by much, a Gaussian becomes a needle that sticks out of the body and shows as a spike. Its elongation is e = σ₀/σ₁, the largest standard deviation over the middle one
//! (discs, which captures are full of, have 1). Both remedies are options, applied to a frame; neither is physics.

use crate::splats::{Splat, Splats};
use mechanics_core::decomposition::{Svd, svd};
use mechanics_core::lanes::Element;
use mechanics_core::tensor::{self, Matrix3, Vector3};

/// Shortens every Gaussian to an elongation of at most `most`: σ₀ ← min(σ₀, most σ₁). Answers how many were shortened.
///
/// # Panics
/// If `most` is less than one.
pub fn limit_elongation<E: Element>(splats: &mut Splats<E>, most: f64) -> usize {
    assert!(most >= 1.0, "the largest deviation is not below the middle one");
    let mut shortened = 0;
    for axes in splats.axes_mut() {
        let mut svd = svd(axes);
        let limit = svd.sigma[1].scale(most);
        if limit.less(svd.sigma[0]) {
            svd.sigma[0] = limit;
            *axes = tensor::product_diagonal_transpose(&svd.u, &svd.sigma, &svd.v);
            shortened += 1;
        }
    }
    shortened
}

/// Pieces of one Gaussian at most.
pub const MOST_PIECES: usize = 65;

/// How far the pieces' places reach, in deviations of their weights.
const REACH: f64 = 4.0;
/// Distance of pieces in units of the width s.
const SPACING: f64 = 1.5;

/// Cuts every Gaussian whose elongation is above `most` into shorter ones along its longest half-axis. Gaussian i becomes the middle piece; the others come at the end. Answers how many
/// Gaussians were cut.
///
/// # Derivation
/// Along the long axis exp(−x²/2σ₀²) is a mixture of exp(−(x − t)²/2σ²) with weights K exp(−t²/2τ²), τ² = σ₀² − σ², K = σ₀/(√(2π) τ σ). The
/// integral over t becomes a sum over t = j h with weights h K exp(−t²/2τ²). Its integrand has the width s = στ/σ₀ in t, and the trapezoidal rule an error of 2 exp(−2π² s²/h²), 3e-4 at h = 1.5 s. Cut off at
/// 4 τ. σ = `most` σ₁, but not above 0.8 σ₀ (so that τ is not small), and not below what needs [`MOST_PIECES`]: longer needles are cut into
/// so many pieces and stay longer than `most`.
///
/// The *sum* of the pieces, with α times the weights as opacities, is the Gaussian. A picture does not add, it covers: pieces of great opacity together are a little fainter than what they replace.
///
/// # Panics
/// If `most` is less than one.
pub fn split_elongated<E: Element>(splats: &mut Splats<E>, most: f64) -> usize {
    assert!(most >= 1.0, "the largest deviation is not below the middle one");
    let mut cut = 0;
    for i in 0..splats.count() {
        let decomposition = svd(&splats.axes()[i]);
        let sigma = decomposition.sigma.map(Into::into);
        if sigma[0] > most * sigma[1] {
            split(splats, i, &decomposition, (most * sigma[1], sigma[0]));
            cut += 1;
        }
    }
    cut
}

/// Cuts Gaussian i, of deviation `long`, into pieces of the deviation `short` if that is possible.
fn split<E: Element>(splats: &mut Splats<E>, i: usize, svd: &Svd<E>, (short, long): (f64, f64)) {
    let side = (MOST_PIECES / 2) as f64;
    // h ≥ REACH τ / side, and h ≤ SPACING σ.
    let short = short.clamp(long * REACH / (side * SPACING), 0.8 * long);
    let spread = (long * long - short * short).sqrt();
    let step = SPACING * short * spread / long;
    // h K, of which everything else cancels.
    let constant = SPACING / std::f64::consts::TAU.sqrt();
    let [_, middle, small] = svd.sigma;
    let axes = tensor::product_diagonal_transpose(&svd.u, &[E::constant(short), middle, small], &svd.v);
    let parent = splats.splat(i);
    let (mean, opacity) = (parent.mean, parent.opacity);
    let harmonics = parent.harmonics.to_vec();
    let orientation = splats.orientations().map(|all| all[i]);
    let along = tensor::columns(&svd.u)[0];
    let number = (REACH * spread / step).floor().min(side) as i32;
    for j in (-number..=number).filter(|&j| j != 0) {
        let t = f64::from(j) * step;
        let weight = constant * (-0.5 * (t / spread).powi(2)).exp();
        let mean = shifted(&mean, &along, t);
        splats.push(Splat { mean, axes, opacity: opacity.scale(weight), harmonics: &harmonics });
        if let (Some(orientation), Some(last)) = (orientation, splats.count().checked_sub(1)) {
            splats.orientations_mut()[last] = orientation;
        }
    }
    splats.axes_mut()[i] = axes;
    splats.opacities_mut()[i] = opacity.scale(constant);
}

fn shifted<E: Element>(mean: &Vector3<E>, along: &[E; 3], by: f64) -> Vector3<E> {
    let mean = tensor::components(mean);
    tensor::vector([0, 1, 2].map(|k| along[k].scale(by) + mean[k]))
}

/// The elongation σ₀/σ₁ of half-axes; infinite for a needle without width, NaN for a point.
pub fn elongation<E: Element>(axes: &Matrix3<E>) -> f64 {
    let sigma: [f64; 3] = svd(axes).sigma.map(Into::into);
    sigma[0] / sigma[1]
}
