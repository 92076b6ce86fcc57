//! The neo-Hookean law with a logarithm of the volume ratio.

use super::stiffness::{UPPER_TRIANGLE, outer};
use super::volume::Stretch;
use super::{Domain, Hyperelastic, Lame, PrincipalStiffness, Stiffness};
use crate::decomposition::svd;
use crate::projection::Projection;
use crate::scalar::Scalar;
use crate::tensor::{
    Matrix3, add_scaled, cofactor, columns, determinant, multiple_of_identity, scaled, sum, value, zero,
};

/// The compressible neo-Hookean law with logarithmic volume terms.
///
/// With J = det F, H = F⁻ᵀ = cof(F)/J, its columns hⱼ, and p = μ − λ ln J:
///
/// - ψ = ½μ(tr FᵀF − 3) − μ ln J + ½λ ln²J
/// - P = μF − pH
/// - block (j, l) of ∂P/∂F: δⱼₗ μ I + p hₗ ⊗ hⱼ + λ hⱼ ⊗ hₗ, from ∂Hᵢⱼ/∂Fₖₗ = −Hᵢₗ Hₖⱼ
///
/// In principal stretches ψᵢ = μσᵢ − p/σᵢ, and
///
/// - ψᵢᵢ = μ + (p + λ)/σᵢ²,  ψᵢⱼ = λ/(σᵢσⱼ)
/// - (ψᵢ ∓ ψⱼ)/(σᵢ ∓ σⱼ) = μ ± p/(σᵢσⱼ)
///
/// so no divided difference is left. The energy is evaluated without cancellation near rest, from F − I: there
/// tr FᵀF − 3 − 2 ln J = e + 2(J − 1 − ln J) with e = tr FᵀF − 3 − 2(J − 1) from terms of second order.
///
/// Domain: det F > 0; ψ → ∞ at its border, ψ = +∞ beyond.
///
/// # Reference
/// Bonet and Wood, Nonlinear Continuum Mechanics for Finite Element Analysis (2nd ed., 2008), eq. 6.27.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NeoHookean {
    lame: Lame,
}

impl NeoHookean {
    /// The law with the given parameters.
    pub fn new(lame: Lame) -> Self {
        Self { lame }
    }

    /// p = μ − λ ln J.
    #[inline(always)]
    fn pressure<S: Scalar>(&self, volume_ratio: S) -> S {
        volume_ratio.ln().scale(-self.lame.lambda()).offset(self.lame.mu())
    }

    #[inline(always)]
    fn principal_stiffness<S: Scalar>(&self, f: &Matrix3<S>) -> PrincipalStiffness<S> {
        let (lambda, mu) = (self.lame.lambda(), self.lame.mu());
        let svd = svd(f);
        let p = self.pressure(svd.sigma[0] * svd.sigma[1] * svd.sigma[2]);
        let r = svd.sigma.map(|sigma| sigma.recip());
        PrincipalStiffness::new(
            &svd,
            |i| (r[i].square() * p.offset(lambda)).offset(mu),
            |i, j| (r[i] * r[j]).scale(lambda),
            |i, j| (r[i] * r[j] * p).offset(mu),
            |i, j| (r[i] * r[j] * -p).offset(mu),
        )
    }
}

impl Hyperelastic for NeoHookean {
    #[inline(always)]
    fn energy_density<S: Scalar>(&self, f: &Matrix3<S>) -> S {
        let stretch = Stretch::of(f);
        let (log, excess) = stretch.log_volume_and_excess();
        let energy = excess.scale(0.5 * self.lame.mu()) + log.square().scale(0.5 * self.lame.lambda());
        S::select(stretch.volume_ratio.less_equal(S::constant(0.0)), S::constant(f64::INFINITY), energy)
    }

    #[inline(always)]
    fn first_piola<S: Scalar>(&self, f: &Matrix3<S>) -> Matrix3<S> {
        let j = determinant(f);
        let factor = -self.pressure(j) / j;
        add_scaled(&scaled(f, S::constant(self.lame.mu())), factor, &cofactor(f))
    }

    #[inline(always)]
    fn stiffness<S: Scalar>(&self, f: &Matrix3<S>, projection: Projection) -> Stiffness<S> {
        if projection != Projection::None {
            return Stiffness::Principal(self.principal_stiffness(&value(f)).projected(projection).lifted());
        }
        let j = determinant(f);
        let p = self.pressure(j);
        let inverse_transpose = scaled(&cofactor(f), j.recip());
        let h = columns(&inverse_transpose);
        let diagonal = multiple_of_identity(S::constant(self.lame.mu()));
        let mut blocks = [zero(); 6];
        for (block, (j, l)) in blocks.iter_mut().zip(UPPER_TRIANGLE) {
            let across = scaled(&outer(&h[l], &h[j]), p);
            *block = add_scaled(&across, S::constant(self.lame.lambda()), &outer(&h[j], &h[l]));
            if j == l {
                *block = sum(block, &diagonal);
            }
        }
        Stiffness::Fixed(blocks)
    }

    fn domain(&self) -> Domain {
        Domain::PositiveVolume
    }
}
