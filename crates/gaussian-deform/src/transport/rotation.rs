//! The rotation of a deformation gradient.

use mechanics_core::decomposition::polar;
use mechanics_core::scalar::{Mask, Scalar};
use mechanics_core::tensor::{self, Matrix3};

/// Below this det F / ‖F‖³ (a multiple of the identity has 0.19, stretches of 8 : 1 : 1/8 have 0.002) Newton's iteration is not trusted.
const WELL_SHAPED: f64 = 2e-3;

/// R of F = R S: the rotation nearest to F, det R = +1 for every F, as [`polar`] gives it.
///
/// # Derivation
/// For any a, b > 0 the matrix aX + bX⁻ᵀ has the polar factor of X, since with X = U diag(σ) Vᵀ it is U diag(aσ + b/σ) Vᵀ. Newton's iteration
/// X ← ½ (γX + X⁻ᵀ/γ) makes every σ one, quadratically; γ² = ‖X⁻¹‖/‖X‖ brings them together first. X⁻ᵀ = cof X / det X; an error of det X only
/// changes b. It is taken where det F is positive and not small (det F > 0.002 ‖F‖³), on five (`f32`) or seven (`f64`) passes, and if the
/// result is orthogonal; elsewhere [`polar`] through the singular values, which holds for every F at three times the cost. Which of the two a lane gets does not depend on
/// the other lanes.
///
/// # Reference
/// Higham (1986), *Computing the polar decomposition, with applications*, SIAM J. Sci. Stat. Comput. 7, section 3.
#[inline(always)]
pub fn rotation<S: Scalar>(f: &Matrix3<S>) -> Matrix3<S> {
    let (passes, scaled_passes) = if S::EPSILON > 1e-10 { (5, 3) } else { (7, 4) };
    let size = tensor::norm_squared(f).sqrt();
    let mut x = tensor::scaled(f, size.recip());
    let trusted = S::constant(WELL_SHAPED).less(tensor::determinant(&x));
    for pass in 0..passes {
        let cofactor = tensor::cofactor(&x);
        let columns = (tensor::columns(&x), tensor::columns(&cofactor));
        let inverse = tensor::dot(&columns.0[0], &columns.1[0]).recip();
        let mut near = S::constant(0.5);
        let mut far = inverse.scale(0.5);
        if pass < scaled_passes {
            let ratio = tensor::norm_squared(&cofactor) / tensor::norm_squared(&x);
            let square = ratio.sqrt() * inverse.abs();
            let gamma = square.sqrt();
            near = gamma.scale(0.5);
            far *= gamma.recip();
        }
        x = tensor::add_scaled(&tensor::scaled(&x, near), far, &cofactor);
    }
    let off = tensor::difference(
        &tensor::transpose_product(&x, &x),
        &tensor::multiple_of_identity(S::constant(1.0)),
    );
    let orthogonal = tensor::norm_squared(&off).less((S::constant(8.0 * S::EPSILON)).square());
    let trusted = trusted.and(orthogonal);
    if trusted.all() {
        return x;
    }
    let exact = polar(f).rotation;
    let (x, exact) = (tensor::columns(&x), tensor::columns(&exact));
    tensor::from_entries(|i, j| S::select(trusted, x[j][i], exact[j][i]))
}
