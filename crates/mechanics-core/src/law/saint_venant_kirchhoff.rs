//! The St. Venant–Kirchhoff law.

use super::stiffness::{UPPER_TRIANGLE, outer};
use super::volume::metric_change;
use super::{Domain, Hyperelastic, Lame, PrincipalStiffness, Stiffness};
use crate::decomposition::svd;
use crate::projection::Projection;
use crate::scalar::Scalar;
use crate::tensor::{
    Mat3, Matrix3, add_scaled, columns, constant, difference, multiple_of_identity, norm_squared, product,
    product_transpose, scaled, sum, trace, transpose_product, value, zero,
};

/// St. Venant–Kirchhoff: linear elasticity in the Green strain.
///
/// With E = ½(FᵀF − I), S = 2μE + λ tr(E) I and the columns fⱼ of F:
///
/// - ψ = μ E:E + ½λ tr²E
/// - P = F S
/// - block (j, l) of ∂P/∂F: Sⱼₗ I + μ fₗ ⊗ fⱼ + λ fⱼ ⊗ fₗ + δⱼₗ μ FFᵀ, from ∂Eₘⱼ/∂Fₖₗ = ½(δₘₗ Fₖⱼ + Fₖₘ δⱼₗ)
///
/// In principal stretches, with t = ½λ(Σσₖ² − 3): ψᵢ = σᵢ(μ(σᵢ² − 1) + t), and
///
/// - ψᵢᵢ = μ(3σᵢ² − 1) + t + λσᵢ²,  ψᵢⱼ = λσᵢσⱼ
/// - (ψᵢ − ψⱼ)/(σᵢ − σⱼ) = μ(σᵢ² + σᵢσⱼ + σⱼ² − 1) + t
/// - (ψᵢ + ψⱼ)/(σᵢ + σⱼ) = μ(σᵢ² − σᵢσⱼ + σⱼ² − 1) + t
///
/// The energy is evaluated with 2E = H + Hᵀ + HᵀH, H = F − I, which does not cancel near rest.
///
/// The law softens in compression (under uniaxial stress below a stretch of 1/√3) and lets elements invert.
///
/// Domain: every F.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StVenantKirchhoff {
    lame: Lame,
}

impl StVenantKirchhoff {
    /// The law with the given parameters.
    pub fn new(lame: Lame) -> Self {
        Self { lame }
    }

    #[inline(always)]
    fn green_strain<S: Scalar>(f: &Matrix3<S>) -> Matrix3<S> {
        let excess = difference(&transpose_product(f, f), &constant(&Mat3::identity()));
        scaled(&excess, S::constant(0.5))
    }

    #[inline(always)]
    fn second_piola<S: Scalar>(&self, strain: &Matrix3<S>) -> Matrix3<S> {
        let pressure = multiple_of_identity(trace(strain).scale(self.lame.lambda()));
        add_scaled(&pressure, S::constant(2.0 * self.lame.mu()), strain)
    }

    #[inline(always)]
    fn principal_stiffness<S: Scalar>(&self, f: &Matrix3<S>) -> PrincipalStiffness<S> {
        let (lambda, mu) = (self.lame.lambda(), self.lame.mu());
        let svd = svd(f);
        let s = svd.sigma;
        let squares = s.map(|sigma| sigma.square());
        let t = (squares[0] + squares[1] + squares[2]).offset(-3.0).scale(0.5 * lambda);
        PrincipalStiffness::new(
            &svd,
            |i| squares[i].scale(3.0 * mu + lambda).offset(-mu) + t,
            |i, j| (s[i] * s[j]).scale(lambda),
            |i, j| (squares[i] + squares[j] + s[i] * s[j]).offset(-1.0).scale(mu) + t,
            |i, j| (squares[i] + squares[j] - s[i] * s[j]).offset(-1.0).scale(mu) + t,
        )
    }
}

impl Hyperelastic for StVenantKirchhoff {
    #[inline(always)]
    fn energy_density<S: Scalar>(&self, f: &Matrix3<S>) -> S {
        let twice = metric_change(f);
        norm_squared(&twice).scale(0.25 * self.lame.mu())
            + trace(&twice).square().scale(0.125 * self.lame.lambda())
    }

    #[inline(always)]
    fn first_piola<S: Scalar>(&self, f: &Matrix3<S>) -> Matrix3<S> {
        product(f, &self.second_piola(&Self::green_strain(f)))
    }

    #[inline(always)]
    fn stiffness<S: Scalar>(&self, f: &Matrix3<S>, projection: Projection) -> Stiffness<S> {
        if projection != Projection::None {
            return Stiffness::Principal(self.principal_stiffness(&value(f)).projected(projection).lifted());
        }
        let stress = self.second_piola(&Self::green_strain(f));
        let left_cauchy = scaled(&product_transpose(f, f), S::constant(self.lame.mu()));
        let (s, c) = (columns(&stress), columns(f));
        let mut blocks = [zero(); 6];
        for (block, (j, l)) in blocks.iter_mut().zip(UPPER_TRIANGLE) {
            let across = S::constant(self.lame.mu());
            *block = add_scaled(&multiple_of_identity(s[l][j]), across, &outer(&c[l], &c[j]));
            *block = add_scaled(block, S::constant(self.lame.lambda()), &outer(&c[j], &c[l]));
            if j == l {
                *block = sum(block, &left_cauchy);
            }
        }
        Stiffness::Fixed(blocks)
    }

    fn domain(&self) -> Domain {
        Domain::EveryDeformation
    }
}
