//! The stable neo-Hookean law.

use super::stiffness::{UPPER_TRIANGLE, cross_matrix, outer};
use super::volume::Stretch;
use super::{Domain, Hyperelastic, Lame, PrincipalStiffness, Stiffness};
use crate::decomposition::svd;
use crate::projection::Projection;
use crate::scalar::Scalar;
use crate::tensor::{
    Matrix3, add_scaled, cofactor, columns, determinant, multiple_of_identity, norm_squared, scaled, sum,
    value, zero,
};

/// The stable neo-Hookean law of Smith, de Goes and Kim: defined and smooth for flat and inverted F, stress-free
/// only where it should be.
///
/// This is the form *with* the logarithm ln(tr FᵀF + 1), which keeps the collapse F = 0 from being a stable rest
/// state. It is no barrier: nothing here is singular. With J = det F, I = tr FᵀF and the law's own parameters
/// m and l, up to a constant that makes ψ(I) = 0:
///
/// - ψ = ½m(I − 3) + ½l(J − α)² − ½m ln(I + 1)
///
/// **Rest stability.** P(I) = m(1 − ¼)I + l(1 − α)I vanishes for α = 1 + ¾m/l.
///
/// **Reparametrisation.** Linearised at rest, dP = ¾m(dF + dFᵀ) + (l + m/8 − ¾m) tr(dF) I. This is linear
/// elasticity with Lamé's λ and μ for m = (4/3)μ and l = λ + (5/6)μ. Since K > 0, l > μ/6 > 0.
///
/// With g = m(1 − 1/(I + 1)), b = l(J − 1) − ¾m = l(J − α), C = cof F and columns fⱼ, cⱼ:
///
/// - P = g F + b C
/// - block (j, l) of ∂P/∂F: δⱼₗ g I + 2m/(I + 1)² fⱼ ⊗ fₗ + l cⱼ ⊗ cₗ + b [εⱼₗq f_q]ₓ, where
///   ∂Cᵢⱼ/∂Fₖₗ = εᵢₖₚ εⱼₗq Fₚq and (\[a\]ₓ)ᵢₖ = εᵢₖₚ aₚ
///
/// In principal stretches, with cᵢ = σⱼσₖ:
///
/// - ψᵢᵢ = g + 2mσᵢ²/(I + 1)² + l cᵢ²,  ψᵢⱼ = 2mσᵢσⱼ/(I + 1)² + l cᵢcⱼ + b σₖ
/// - (ψᵢ ∓ ψⱼ)/(σᵢ ∓ σⱼ) = g ∓ b σₖ
///
/// The energy is evaluated without cancellation near rest, from F − I, as
/// ½m[¾e + (w − ln(1 + w))] + ½l(J − 1)² with w = ¼(I − 3) and e = I − 3 − 2(J − 1), each of second order.
///
/// Domain: every F.
///
/// # Reference
/// Smith, de Goes, Kim, Stable Neo-Hookean Flesh Simulation (ACM Trans. Graph. 37(2), 2018), eq. 14 and
/// sections 3.4 and 4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StableNeoHookean {
    /// m = (4/3)μ.
    shear: f64,
    /// l = λ + (5/6)μ.
    dilation: f64,
}

impl StableNeoHookean {
    /// The law that agrees with linear elasticity of these parameters at rest.
    pub fn new(lame: Lame) -> Self {
        Self { shear: lame.mu() * (4.0 / 3.0), dilation: lame.lambda() + lame.mu() * (5.0 / 6.0) }
    }

    /// b = l(J − α).
    #[inline(always)]
    fn volume_stress<S: Scalar>(&self, volume_ratio: S) -> S {
        volume_ratio.offset(-1.0).scale(self.dilation).offset(-0.75 * self.shear)
    }

    /// g = m(1 − 1/(I + 1)) = m I/(I + 1), and 2m/(I + 1)².
    #[inline(always)]
    fn shear_factors<S: Scalar>(&self, squared_norm: S) -> (S, S) {
        let r = squared_norm.offset(1.0).recip();
        ((squared_norm * r).scale(self.shear), r.square().scale(2.0 * self.shear))
    }

    #[inline(always)]
    fn principal_stiffness<S: Scalar>(&self, f: &Matrix3<S>) -> PrincipalStiffness<S> {
        let svd = svd(f);
        let s = svd.sigma;
        let (g, curvature) = self.shear_factors(s[0].square() + s[1].square() + s[2].square());
        let b = self.volume_stress(s[0] * s[1] * s[2]);
        let c = [s[1] * s[2], s[2] * s[0], s[0] * s[1]];
        PrincipalStiffness::new(
            &svd,
            |i| g + s[i].square() * curvature + c[i].square().scale(self.dilation),
            |i, j| s[i] * s[j] * curvature + (c[i] * c[j]).scale(self.dilation) + b * s[3 - i - j],
            |i, j| g - b * s[3 - i - j],
            |i, j| g + b * s[3 - i - j],
        )
    }
}

impl Hyperelastic for StableNeoHookean {
    #[inline(always)]
    fn energy_density<S: Scalar>(&self, f: &Matrix3<S>) -> S {
        let stretch = Stretch::of(f);
        let shear = stretch.excess_over_volume_change().scale(0.75) + stretch.quarter_excess_over_log();
        shear.scale(0.5 * self.shear) + stretch.volume_change.square().scale(0.5 * self.dilation)
    }

    #[inline(always)]
    fn first_piola<S: Scalar>(&self, f: &Matrix3<S>) -> Matrix3<S> {
        let (g, _) = self.shear_factors(norm_squared(f));
        add_scaled(&scaled(f, g), self.volume_stress(determinant(f)), &cofactor(f))
    }

    #[inline(always)]
    fn stiffness<S: Scalar>(&self, f: &Matrix3<S>, projection: Projection) -> Stiffness<S> {
        if projection != Projection::None {
            return Stiffness::Principal(self.principal_stiffness(&value(f)).projected(projection).lifted());
        }
        let (g, curvature) = self.shear_factors(norm_squared(f));
        let b = self.volume_stress(determinant(f));
        let cofactor = cofactor(f);
        let (columns, cofactors) = (columns(f), columns(&cofactor));
        let diagonal = multiple_of_identity(g);
        let mut blocks = [zero(); 6];
        for (block, (j, l)) in blocks.iter_mut().zip(UPPER_TRIANGLE) {
            let sheared = scaled(&outer(&columns[j], &columns[l]), curvature);
            *block = add_scaled(&sheared, S::constant(self.dilation), &outer(&cofactors[j], &cofactors[l]));
            if j == l {
                *block = sum(block, &diagonal);
                continue;
            }
            // ε_jlq is +1 if l follows j cyclically.
            let sign = if (j + 1) % 3 == l { b } else { -b };
            *block = add_scaled(block, sign, &cross_matrix(&columns[3 - j - l]));
        }
        Stiffness::Fixed(blocks)
    }

    fn domain(&self) -> Domain {
        Domain::EveryDeformation
    }
}
