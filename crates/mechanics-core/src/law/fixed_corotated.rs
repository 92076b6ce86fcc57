//! The fixed corotated law.

use super::volume::Stretch;
use super::{Domain, Hyperelastic, Lame, PrincipalStiffness, Stiffness};
use crate::decomposition::{polar, svd};
use crate::projection::Projection;
use crate::scalar::Scalar;
use crate::tensor::{
    Matrix3, add_scaled, apply, cofactor, columns, components, cross, determinant, difference, dot,
    from_columns, lift, multiple_of_identity, norm_squared, product, scaled, sum, transpose_product, value,
    vector,
};

/// Fixed corotated elasticity, with the volume term ½λ(J − 1)² of Stomakhin et al.
///
/// With F = R S, det R = 1, J = det F and signed singular values σ:
///
/// - ψ = μ ‖F − R‖² + ½λ(J − 1)² = μ ‖S − I‖² + ½λ(J − 1)² = μ Σ(σᵢ − 1)² + ½λ(J − 1)²
/// - P = 2μ(F − R) + λ(J − 1) cof F (the derivative of R drops out: R minimises ‖F − R‖² among rotations)
///
/// In principal stretches, with cᵢ = σⱼσₖ and b = λ(J − 1): ψᵢ = 2μ(σᵢ − 1) + b cᵢ, and
///
/// - ψᵢᵢ = 2μ + λcᵢ²,  ψᵢⱼ = λcᵢcⱼ + bσₖ
/// - (ψᵢ − ψⱼ)/(σᵢ − σⱼ) = 2μ − bσₖ
/// - (ψᵢ + ψⱼ)/(σᵢ + σⱼ) = 2μ − 4μ/(σᵢ + σⱼ) + bσₖ
///
/// R is not unique where σ₁ + σ₂ = 0, a mirror image with two equal small stretches; the energy has a crest there,
/// and the curvature across it is −∞. The sum is kept above √ε in the last line (ε: [`Scalar::EPSILON`]), so that the
/// coefficient is finite, −4μ/√ε at worst; `Projection::Clamp` makes it zero.
///
/// RᵀF − I is rounded to ε. Near rest the energy takes X = S − I from X = ½(C − I − X²) instead, C = S², where the rounding of X
/// on the right is multiplied by X.
///
/// Through jets, R follows from its implicit equation Rᵀ F = Fᵀ R, solved by Newton steps from its value.
///
/// Domain: every F.
///
/// # Reference
/// Stomakhin, Howes, Schroeder, Teran, Energetically Consistent Invertible Elasticity (SCA 2012), section 3.4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixedCorotated {
    lame: Lame,
}

impl FixedCorotated {
    /// The law with the given parameters.
    pub fn new(lame: Lame) -> Self {
        Self { lame }
    }

    /// b = λ(J − 1).
    #[inline(always)]
    fn volume_stress<S: Scalar>(&self, volume_ratio: S) -> S {
        volume_ratio.offset(-1.0).scale(self.lame.lambda())
    }
}

impl Hyperelastic for FixedCorotated {
    #[inline(always)]
    fn energy_density<S: Scalar>(&self, f: &Matrix3<S>) -> S {
        let stretch = Stretch::of(f);
        // As ‖S − I‖²: through jets a derivative of R then cancels to rounding of S, not of R, which matters for small F.
        let excess = difference(&transpose_product(&rotation(f), f), &multiple_of_identity(S::constant(1.0)));
        let near = scaled(
            &difference(&stretch.metric_change, &transpose_product(&excess, &excess)),
            S::constant(0.5),
        );
        let shear = S::select(stretch.near_rest, norm_squared(&near), norm_squared(&excess));
        let volume = stretch.volume_change.square();
        shear.scale(self.lame.mu()) + volume.scale(0.5 * self.lame.lambda())
    }

    #[inline(always)]
    fn first_piola<S: Scalar>(&self, f: &Matrix3<S>) -> Matrix3<S> {
        let shear = scaled(&difference(f, &rotation(f)), S::constant(2.0 * self.lame.mu()));
        add_scaled(&shear, self.volume_stress(determinant(f)), &cofactor(f))
    }

    #[inline(always)]
    fn stiffness<S: Scalar>(&self, f: &Matrix3<S>, projection: Projection) -> Stiffness<S> {
        let (lambda, mu) = (self.lame.lambda(), self.lame.mu());
        let svd = svd(&value(f));
        let s = svd.sigma;
        let c = [s[1] * s[2], s[2] * s[0], s[0] * s[1]];
        let b = self.volume_stress(s[0] * s[1] * s[2]);
        let floor = S::Value::constant(S::EPSILON.sqrt());
        let reciprocal_sum = |i: usize, j: usize| {
            let sum = s[i] + s[j];
            S::Value::select(sum.less(floor), floor, sum).recip()
        };
        let principal = PrincipalStiffness::new(
            &svd,
            |i| c[i].square().scale(lambda).offset(2.0 * mu),
            |i, j| (c[i] * c[j]).scale(lambda) + b * s[3 - i - j],
            |i, j| (-b * s[3 - i - j]).offset(2.0 * mu),
            |i, j| (b * s[3 - i - j]).offset(2.0 * mu) - reciprocal_sum(i, j).scale(4.0 * mu),
        );
        Stiffness::Principal(principal.projected(projection).lifted())
    }

    fn domain(&self) -> Domain {
        Domain::EveryDeformation
    }
}

/// The rotation nearest to F, with its derivatives through jets.
#[inline(always)]
fn rotation<S: Scalar>(f: &Matrix3<S>) -> Matrix3<S> {
    let nearest = lift(&polar(&value(f)).rotation);
    if !S::DIFFERENTIATES {
        return nearest;
    }
    // Each step doubles the order up to which derivatives are right: 1, then 3.
    let once = polar_newton_step(f, &nearest);
    polar_newton_step(f, &once)
}

/// A Newton step for RᵀF = FᵀR over rotations.
///
/// With B = RᵀF and R' = R Q, Q = exp \[ω\]ₓ: to first order QᵀB is symmetric if \[ω\]ₓB + B\[ω\]ₓ = B − Bᵀ, where
/// B may be replaced by its symmetric part S on the left, and \[ω\]ₓS + S\[ω\]ₓ = \[(tr(S)I − S)ω\]ₓ. Q is taken as the Cayley
/// transform of ω, I + (\[ω\]ₓ + ½\[ω\]ₓ²)/(1 + ¼ω·ω), a rotation exactly.
#[inline(always)]
fn polar_newton_step<S: Scalar>(f: &Matrix3<S>, r: &Matrix3<S>) -> Matrix3<S> {
    let b = transpose_product(r, f);
    let m = columns(&b);
    let axial = [m[1][2] - m[2][1], m[2][0] - m[0][2], m[0][1] - m[1][0]];
    let stretch = crate::tensor::symmetric_part(&b);
    let operator = difference(&multiple_of_identity(crate::tensor::trace(&stretch)), &stretch);
    let adjugate = cofactor(&operator);
    let inverse = scaled(&adjugate, determinant(&operator).recip());
    let omega = *components(&apply(&inverse, &vector(axial)));
    let unit = |i: usize| std::array::from_fn(|k| S::constant(if i == k { 1.0 } else { 0.0 }));
    let skew = from_columns([cross(&omega, &unit(0)), cross(&omega, &unit(1)), cross(&omega, &unit(2))]);
    let half_square = scaled(&product(&skew, &skew), S::constant(0.5));
    let weight = dot(&omega, &omega).scale(0.25).offset(1.0).recip();
    let change = scaled(&sum(&skew, &half_square), weight);
    sum(r, &product(r, &change))
}
