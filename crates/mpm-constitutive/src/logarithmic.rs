//! The logarithmic strain in principal axes, where plastic flow is additive.

use crate::elastic::select;
use crate::elementary;
use crate::{StiffnessBound, Stress};
use mechanics_core::decomposition::{Svd, svd};
use mechanics_core::law::Lame;
use mechanics_core::scalar::{Mask, Scalar};
use mechanics_core::tensor::{Matrix3, dot, product_diagonal_transpose};

/// F = U diag(σ) Vᵀ with lᵢ = ln σᵢ, split into volume t = Σlᵢ = ln J and deviator eᵢ = lᵢ − t/3.
///
/// For Hencky's energy the Kirchhoff stress is U diag(2μlᵢ + λt) Uᵀ. In the measures of plasticity:
///
/// - pressure p = −⅓ tr τ = −K t, with K = λ + ⅔μ
/// - ‖dev τ‖ = 2μ‖e‖; von Mises' equivalent stress q = √(3/2)‖dev τ‖ = √6 μ‖e‖
///
/// A return map replaces t and shortens e: flow keeps the principal axes, because it is along ∂f/∂τ of an isotropic f.
///
/// The stiffness bound is derived at [`Hencky`](crate::elastic::Hencky).
///
/// Through jets values are right, derivatives zero.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LogarithmicStrain<S> {
    svd: Svd<S>,
    pub(crate) log: [S; 3],
    /// t = ln J.
    pub(crate) volume: S,
    /// eᵢ.
    pub(crate) deviator: [S; 3],
    /// ‖e‖.
    pub(crate) norm: S,
}

impl<S: Scalar> LogarithmicStrain<S> {
    #[inline(always)]
    pub(crate) fn of(f: &Matrix3<S>) -> Self {
        let svd = svd(f);
        let log = svd.sigma.map(elementary::ln);
        let volume = log[0] + log[1] + log[2];
        let mean = volume.scale(1.0 / 3.0);
        let deviator = log.map(|l| l - mean);
        Self { svd, log, volume, deviator, norm: dot(&deviator, &deviator).sqrt() }
    }

    /// q = √6 μ‖e‖ \[Pa\].
    #[inline(always)]
    pub(crate) fn equivalent_stress(&self, lame: Lame) -> S {
        self.norm.scale(6.0_f64.sqrt() * lame.mu())
    }

    #[inline(always)]
    pub(crate) fn stress(&self, lame: Lame) -> Stress<S> {
        self.stress_at(&self.log, lame)
    }

    #[inline(always)]
    fn stress_at(&self, log: &[S; 3], lame: Lame) -> Stress<S> {
        let pressure = (log[0] + log[1] + log[2]).scale(lame.lambda());
        let tau = log.map(|l| l.scale(2.0 * lame.mu()) + pressure);
        let largest = tau[0].abs().max(tau[1].abs()).max(tau[2].abs());
        let mu = (log[0] - log[2]).offset(1.0).scale(lame.mu()) + largest.scale(0.5);
        Stress {
            kirchhoff: product_diagonal_transpose(&self.svd.u, &tau, &self.svd.u),
            stiffness: StiffnessBound { lambda: S::constant(lame.lambda()), mu },
        }
    }

    /// The deformation and stress with eᵢ shortened to `shorter`·eᵢ and t increased by `expansion`; where `shorter` = 1 and
    /// `expansion` = 0 the deformation is the given `trial`, bit for bit.
    #[inline(always)]
    pub(crate) fn returned(&self, trial: &Matrix3<S>, flow: Flow<S>, lame: Lame) -> (Matrix3<S>, Stress<S>) {
        let (zero, one) = (S::constant(0.0), S::constant(1.0));
        let moved = flow.shorter.less(one).or(zero.less(flow.expansion.abs()));
        if !moved.any() {
            return (*trial, self.stress(lame));
        }
        let (loss, mean) = (one - flow.shorter, flow.expansion.scale(1.0 / 3.0));
        let change = self.deviator.map(|e| mean - e * loss);
        let log = [self.log[0] + change[0], self.log[1] + change[1], self.log[2] + change[2]];
        let svd = &self.svd;
        let stretch = log.map(elementary::exp);
        let flowed = product_diagonal_transpose(&svd.u, &stretch, &svd.v);
        (select(moved, &flowed, trial), self.stress_at(&log, lame))
    }
}

/// What plastic flow does to a logarithmic strain.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Flow<S> {
    /// ‖e′‖/‖e‖.
    pub(crate) shorter: S,
    /// t′ − t.
    pub(crate) expansion: S,
}

/// `part/whole` where `part < whole`, else 1: how much of a deviator a yield surface of that size leaves.
#[inline(always)]
pub(crate) fn fraction<S: Scalar>(part: S, whole: S) -> S {
    S::select(part.less(whole), part / whole, S::constant(1.0))
}
