//! The logarithmic strain in principal axes, where plastic flow is additive.

use crate::elastic::select;
use crate::elementary;
use crate::{StiffnessBound, Stress};
use mechanics_core::decomposition::{Svd, svd};
use mechanics_core::law::Lame;
use mechanics_core::scalar::{Mask, Scalar};
use mechanics_core::tensor::{Matrix3, dot, product, product_diagonal_transpose, sum};

/// |Δlᵢ| below which a flow is added to F.
const SLIGHT: f64 = 0.5;

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
        // Loops, here and below: what `map` calls is not always inlined, and then runs without vector instructions.
        let mut log = svd.sigma;
        for l in &mut log {
            *l = elementary::ln(*l);
        }
        let volume = log[0] + log[1] + log[2];
        let mean = volume.scale(1.0 / 3.0);
        let deviator = [log[0] - mean, log[1] - mean, log[2] - mean];
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
        let mut tau = *log;
        for l in &mut tau {
            *l = l.scale(2.0 * lame.mu()) + pressure;
        }
        let largest = tau[0].abs().max(tau[1].abs()).max(tau[2].abs());
        let mu = (log[0] - log[2]).offset(1.0).scale(lame.mu()) + largest.scale(0.5);
        Stress {
            kirchhoff: product_diagonal_transpose(&self.svd.u, &tau, &self.svd.u),
            stiffness: StiffnessBound { lambda: S::constant(lame.lambda()), mu },
        }
    }

    /// The deformation and stress with eᵢ shortened to `shorter`·eᵢ and t increased by `expansion`; where `shorter` = 1 and
    /// `expansion` = 0 the deformation is the given `trial`, bit for bit.
    ///
    /// The flow of a step is slight, and so it is added: F′ = F + U diag(e^Δl − 1) UᵀF. Put together anew, U diag(e^l′) Vᵀ, F′ would lose
    /// or gain about one rounding error of volume in every step, always in the same sense, because U and V are orthogonal to rounding only;
    /// now that error comes times Δl. Where the flow is not slight, putting together is the more exact one.
    #[inline(always)]
    pub(crate) fn returned(&self, trial: &Matrix3<S>, flow: Flow<S>, lame: Lame) -> (Matrix3<S>, Stress<S>) {
        let (zero, one) = (S::constant(0.0), S::constant(1.0));
        let moved = flow.shorter.less(one).or(zero.less(flow.expansion.abs()));
        if !moved.any() {
            return (*trial, self.stress(lame));
        }
        let (loss, mean) = (one - flow.shorter, flow.expansion.scale(1.0 / 3.0));
        let (svd, mut log, mut growth) = (&self.svd, self.log, self.log);
        let mut slight = moved.or(moved.not());
        for i in 0..3 {
            // In this order an unmoved strain keeps its bits.
            let change = mean - self.deviator[i] * loss;
            log[i] += change;
            growth[i] = elementary::exp_m1(change);
            slight = slight.and(change.abs().less(S::constant(SLIGHT)));
        }
        let change = product(&product_diagonal_transpose(&svd.u, &growth, &svd.u), trial);
        let mut flowed = sum(trial, &change);
        if !slight.all() {
            let mut stretch = log;
            for s in &mut stretch {
                *s = elementary::exp(*s);
            }
            flowed = select(slight, &flowed, &product_diagonal_transpose(&svd.u, &stretch, &svd.v));
        }
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
