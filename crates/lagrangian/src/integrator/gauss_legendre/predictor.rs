//! Start values of the stage velocities, from the step before.

use super::{Stages, Tableau};
use crate::coordinates::{Coordinates, Phase};

/// Extrapolates the velocity of the last step.
///
/// On the last step's scale, τ from 0 to 1, the polynomial of degree s + 1 with the stage velocities Vⱼ at cⱼ, the end
/// velocity v and the end acceleration a (as da/dτ = h a) is, with w(τ) = Πⱼ (τ − cⱼ) and k = Σⱼ 1/(1 − cⱼ),
///
/// Σⱼ Vⱼ ℓⱼ(τ) ((τ − 1)/(cⱼ − 1))² + (w(τ)/w(1)) (v (1 − k (τ − 1)) + h a (τ − 1)).
#[derive(Clone, Debug)]
pub(super) struct Predictor<const S: usize> {
    nodes: [f64; S],
    /// New step over old that `factors` are for.
    ratio: f64,
    /// For each new stage, the factors of the old stages, of the end velocity, and of h times the end acceleration.
    factors: [([f64; S], [f64; 2]); S],
    /// Factors of the stages and of the start velocity in the end velocity.
    end: ([f64; S], f64),
}

/// Beyond this ratio of step sizes a polynomial is no prediction.
const LARGEST_RATIO: f64 = 1.5;

impl<const S: usize> Predictor<S> {
    pub(super) fn new(tableau: &Tableau<S>) -> Self {
        let c = tableau.nodes;
        let end = (
            std::array::from_fn(|j| lagrange(&c, j, 1.0) / c[j]),
            (0..S).map(|k| (1.0 - c[k]) / (0.0 - c[k])).product(),
        );
        let mut predictor = Self { nodes: c, ratio: 1.0, factors: [([0.0; S], [0.0; 2]); S], end };
        predictor.prepare(1.0);
        predictor
    }

    fn prepare(&mut self, ratio: f64) {
        self.ratio = ratio;
        let c = self.nodes;
        let k: f64 = c.iter().map(|c| 1.0 / (1.0 - c)).sum();
        for i in 0..S {
            let beyond = ratio * c[i];
            let w: f64 = c.iter().map(|c| (1.0 + beyond - c) / (1.0 - c)).product();
            let old = |j: usize| lagrange(&c, j, 1.0 + beyond) * (beyond / (c[j] - 1.0)).powi(2);
            self.factors[i] = (std::array::from_fn(old), [w * (1.0 - k * beyond), w * beyond]);
        }
    }

    /// Overwrites the velocities of `stages` for a step `h` from `phase`, which a step `last_h` with the stage
    /// velocities `old` has led to.
    #[inline]
    pub(super) fn predict<C: Coordinates>(
        &mut self,
        last_h: f64,
        old: &[C; S],
        phase: &Phase<C>,
        acceleration: &C,
        h: f64,
        stages: &mut Stages<S, C>,
    ) {
        let (v, a, ratio) = (phase.v.as_ref(), acceleration.as_ref(), h / last_h);
        if ratio > LARGEST_RATIO {
            return stages.extrapolate_linearly(&self.nodes, v, a, h);
        }
        if ratio != self.ratio {
            self.prepare(ratio);
        }
        for (velocity, (stage_factors, end_factors)) in stages.velocities.iter_mut().zip(&self.factors) {
            for (j, velocity) in velocity.as_mut().iter_mut().enumerate() {
                let mut sum = end_factors[0] * v[j] + end_factors[1] * last_h * a[j];
                for k in 0..S {
                    sum += stage_factors[k] * old[k].as_ref()[j];
                }
                *velocity = sum;
            }
        }
    }

    /// The velocity at the end of a step, from its stages and its start, to order s.
    #[inline]
    pub(super) fn end_velocity<C: Coordinates>(&self, velocities: &[C; S], start: &C) -> C {
        let mut end = start.clone();
        for (j, end) in end.as_mut().iter_mut().enumerate() {
            *end *= self.end.1;
            for k in 0..S {
                *end += self.end.0[k] * velocities[k].as_ref()[j];
            }
        }
        end
    }
}

/// ℓⱼ(τ) for the nodes `c`.
fn lagrange<const S: usize>(c: &[f64; S], j: usize, at: f64) -> f64 {
    (0..S).filter(|&k| k != j).map(|k| (at - c[k]) / (c[j] - c[k])).product()
}
