//! The Hencky law.

use super::volume::Stretch;
use super::{Domain, Hyperelastic, Lame, PrincipalStiffness, Stiffness};
use crate::decomposition::{Svd, svd, symmetric_eigen};
use crate::projection::Projection;
use crate::scalar::{Mask, Scalar};
use crate::tensor::{
    Matrix3, add_scaled, difference, double_contraction, lift, product_diagonal_transpose, sum, value,
};

/// Hencky's law: the St. Venant–Kirchhoff energy in the logarithmic strain.
///
/// With F = U diag(σ) Vᵀ, lᵢ = ln σᵢ and L = Σlᵢ = ln J:
///
/// - ψ = μ Σlᵢ² + ½λL²
/// - τᵢ = σᵢψᵢ = 2μlᵢ + λL, the principal Kirchhoff stresses
/// - P = U diag(τᵢ/σᵢ) Vᵀ
///
/// and for the stiffness
///
/// - ψᵢᵢ = (2μ + λ − τᵢ)/σᵢ²,  ψᵢⱼ = λ/(σᵢσⱼ)
/// - (ψᵢ + ψⱼ)/(σᵢ + σⱼ) = (τᵢσⱼ + τⱼσᵢ)/(σᵢσⱼ(σᵢ + σⱼ))
/// - (ψᵢ − ψⱼ)/(σᵢ − σⱼ) = \[μ(σᵢ + σⱼ)D − ½(τᵢ + τⱼ)\]/(σᵢσⱼ), since
///   τᵢσⱼ − τⱼσᵢ = ½(σᵢ + σⱼ)(τᵢ − τⱼ) − ½(σᵢ − σⱼ)(τᵢ + τⱼ) and τᵢ − τⱼ = 2μ(lᵢ − lⱼ).
///
/// The one divided difference left, D = (lᵢ − lⱼ)/(σᵢ − σⱼ), is ln(1 + x)/(xσⱼ) with x = (σᵢ − σⱼ)/σⱼ, accurate for
/// every x ≠ 0; D = 1/σⱼ at x = 0.
///
/// The energy grows only like ln², so the law softens under large stretch, and its resistance to
/// crushing, though unbounded, is weak.
///
/// The singular values of F are rounded to ε. Near rest the energy takes lᵢ = ½ ln(1 + aᵢ) instead, with the eigenvalues a of
/// C − I, which are rounded to ε‖C − I‖.
///
/// Through jets, energy and stress are expanded about their value: ψ(F₀) + P(F₀):dF + ½dF:C:dF and P(F₀) + C:dF. That
/// is exact for second derivatives of the energy and first ones of the stress; **higher derivatives come out as
/// zero**.
///
/// Domain: det F > 0; ψ → ∞ at its border, ψ = +∞ beyond.
///
/// # Reference
/// Hencky (1928), Über die Form des Elastizitätsgesetzes bei ideal elastischen Stoffen; Xiao and Chen, Hencky's
/// elasticity model and linear stress–strain relations in isotropic finite hyperelasticity (Acta Mech. 157, 2002).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hencky {
    lame: Lame,
}

/// The law's quantities in principal axes.
struct Principal<S> {
    svd: Svd<S>,
    /// ln σᵢ.
    log: [S; 3],
    /// ln J.
    log_volume: S,
    /// 1/σᵢ.
    reciprocal: [S; 3],
    /// τᵢ \[Pa\].
    kirchhoff: [S; 3],
}

impl Hencky {
    /// The law with the given parameters.
    pub fn new(lame: Lame) -> Self {
        Self { lame }
    }

    #[inline(always)]
    fn principal<S: Scalar>(&self, f: &Matrix3<S>) -> Principal<S> {
        let svd = svd(f);
        // Loops: `map` is a function of its own, compiled without the lanes' instructions.
        let (mut log, mut reciprocal) = (svd.sigma, svd.sigma);
        for i in 0..3 {
            log[i] = svd.sigma[i].ln();
            reciprocal[i] = svd.sigma[i].recip();
        }
        let log_volume = log[0] + log[1] + log[2];
        let pressure = log_volume.scale(self.lame.lambda());
        let mut kirchhoff = log;
        for tau in &mut kirchhoff {
            *tau = tau.scale(2.0 * self.lame.mu()) + pressure;
        }
        Principal { svd, log, log_volume, reciprocal, kirchhoff }
    }

    #[inline(always)]
    fn energy_at<S: Scalar>(&self, f: &Matrix3<S>, p: &Principal<S>) -> S {
        let stretch = Stretch::of(f);
        let (mut log, mut log_volume) = (p.log, p.log_volume);
        if stretch.near_rest.any() {
            let eigen = symmetric_eigen(&stretch.metric_change).values;
            for i in 0..3 {
                log[i] = S::select(stretch.near_rest, eigen[i].ln_1p().scale(0.5), log[i]);
            }
            // Lane by lane: what one lane gives must not depend on its neighbours.
            log_volume = S::select(stretch.near_rest, stretch.log_volume_and_excess().0, log_volume);
        }
        let squares = log[0].square() + log[1].square() + log[2].square();
        let energy = squares.scale(self.lame.mu()) + log_volume.square().scale(0.5 * self.lame.lambda());
        let outside = p.svd.sigma[2].less_equal(S::constant(0.0));
        S::select(outside, S::constant(f64::INFINITY), energy)
    }

    #[inline(always)]
    fn stress_at<S: Scalar>(p: &Principal<S>) -> Matrix3<S> {
        let psi = |i: usize| p.kirchhoff[i] * p.reciprocal[i];
        product_diagonal_transpose(&p.svd.u, &[psi(0), psi(1), psi(2)], &p.svd.v)
    }

    #[inline(always)]
    fn stiffness_at<S: Scalar>(&self, p: &Principal<S>) -> PrincipalStiffness<S> {
        let (lambda, mu) = (self.lame.lambda(), self.lame.mu());
        let (s, r, tau) = (&p.svd.sigma, &p.reciprocal, &p.kirchhoff);
        PrincipalStiffness::new(
            &p.svd,
            |i| (-tau[i]).offset(2.0 * mu + lambda) * r[i].square(),
            |i, j| (r[i] * r[j]).scale(lambda),
            |i, j| {
                let shear = (s[i] + s[j]) * log_divided_difference(s[i], s[j], r[j]).scale(mu);
                (shear - (tau[i] + tau[j]).scale(0.5)) * r[i] * r[j]
            },
            |i, j| (tau[i] * s[j] + tau[j] * s[i]) * r[i] * r[j] / (s[i] + s[j]),
        )
    }
}

/// (ln a − ln b)/(a − b), given 1/b.
#[inline(always)]
fn log_divided_difference<S: Scalar>(a: S, b: S, reciprocal_of_b: S) -> S {
    let one = S::constant(1.0);
    let x = (a - b) * reciprocal_of_b;
    let equal = x.abs().less_equal(S::constant(S::MIN_POSITIVE));
    let safe = S::select(equal, one, x);
    S::select(equal, one, safe.ln_1p() / safe) * reciprocal_of_b
}

impl Hyperelastic for Hencky {
    #[inline(always)]
    fn energy_density<S: Scalar>(&self, f: &Matrix3<S>) -> S {
        let f0 = value(f);
        let p = self.principal(&f0);
        let energy = S::lift(self.energy_at(&f0, &p));
        if !S::DIFFERENTIATES {
            return energy;
        }
        let df = difference(f, &lift(&f0));
        let stress_change = self.stiffness_at(&p).lifted().apply(&df);
        let mean_stress = add_scaled(&lift(&Self::stress_at(&p)), S::constant(0.5), &stress_change);
        energy + double_contraction(&mean_stress, &df)
    }

    #[inline(always)]
    fn first_piola<S: Scalar>(&self, f: &Matrix3<S>) -> Matrix3<S> {
        let f0 = value(f);
        let p = self.principal(&f0);
        let stress = lift(&Self::stress_at(&p));
        if !S::DIFFERENTIATES {
            return stress;
        }
        let df = difference(f, &lift(&f0));
        sum(&stress, &self.stiffness_at(&p).lifted().apply(&df))
    }

    #[inline(always)]
    fn stiffness<S: Scalar>(&self, f: &Matrix3<S>, projection: Projection) -> Stiffness<S> {
        let principal = self.stiffness_at(&self.principal(&value(f)));
        Stiffness::Principal(principal.projected(projection).lifted())
    }

    fn domain(&self) -> Domain {
        Domain::PositiveVolume
    }
}
