//! What a step would do, before it does it: so that a step that cannot be finished leaves everything as it was.
//!
//! The gather writes particles in place. Where the velocities of the nodes rule out that a particle comes to harm, nothing is done
//! beforehand; the few blocks where they do not are moved on a copy, and their particles checked one by one.
//!
//! # When a block is safe
//! Let r_a be the largest less the smallest velocity component a over the nodes with mass around the block. Gradients of kernels
//! sum to zero, so a gathered gradient sees differences only: |∂v_a/∂x_b| ≤ ½ r_a Σᵢ|gᵢ|, where g = ∂w for true gradients and
//! g = D⁻¹ w (xᵢ − x) for moving least squares. Σ|gᵢ| is at most 2/Δx: 2 for linear weights, 1 + 2|f − 1| ≤ 2 for quadratic and
//! ≤ 3⁄2 for cubic ones; 4 · ½ for quadratic and 3 · 13⁄24 for cubic moments. (A node without mass has weight zero, and then slope zero, but for linear
//! weights: where those are used the velocity zero of such nodes is taken into the range.) Hence h‖∇v‖ ≤ h √D ‖r‖/Δx. Below one, I + h∇v is invertible
//! with a positive determinant (Neumann series); 0.9 is taken, so that no determinant rounds to zero. A strain that was admissible then
//! leaves the domain of its law only by leaving the range of numbers, which a law announces by its stiffness: particles that are
//! 10⁴ times stiffer than virgin ones are checked too. Positions are safe if h max‖v‖ cannot carry them out of the domain or beyond the
//! cells that have numbers.

use crate::body::StepSettings;
use crate::neighbourhood::NODE;
use crate::particles::FARTHEST_CELL;
use crate::{Kernel, MpmError};
use mechanics_core::lanes::Element;

/// The largest bound on h‖∇v‖ that needs no check.
const SAFE_INCREMENT: f64 = 0.9;

/// How much stiffer than virgin material particles are that need no check.
pub(crate) const SAFE_STIFFENING: f64 = 1e4;

/// Velocities of the nodes with mass of a block, or of several.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Span<const D: usize> {
    low: [f64; D],
    high: [f64; D],
    /// The largest changes in the step, where particles move with velocities of their own; else zero.
    change: [f64; D],
}

impl<const D: usize> Default for Span<D> {
    fn default() -> Self {
        Self { low: [f64::INFINITY; D], high: [f64::NEG_INFINITY; D], change: [0.0; D] }
    }
}

impl<const D: usize> Span<D> {
    /// Of the nodes of a block.
    pub(crate) fn of_nodes<E: Element>(nodes: &[E]) -> Self {
        let mut low = [E::constant(f64::INFINITY); NODE];
        let mut high = [E::constant(f64::NEG_INFINITY); NODE];
        for node in nodes.chunks_exact(NODE) {
            if node[0].less_equal(E::default()) {
                continue;
            }
            for c in 1..=D {
                low[c] = low[c].min(node[c]);
                high[c] = high[c].max(node[c]);
            }
        }
        Self {
            low: std::array::from_fn(|a| low[1 + a].into()),
            high: std::array::from_fn(|a| high[1 + a].into()),
            change: [0.0; D],
        }
    }

    /// Notes the changes of the nodes' velocities, zero at nodes without mass.
    pub(crate) fn note_changes<E: Element>(&mut self, changes: &[E]) {
        for node in changes.chunks_exact(NODE) {
            for a in 0..D {
                self.change[a] = self.change[a].max(node[1 + a].into().abs());
            }
        }
    }

    /// Of both.
    pub(crate) fn merged(&self, other: &Self) -> Self {
        Self {
            low: std::array::from_fn(|a| self.low[a].min(other.low[a])),
            high: std::array::from_fn(|a| self.high[a].max(other.high[a])),
            change: std::array::from_fn(|a| self.change[a].max(other.change[a])),
        }
    }

    /// Whether no gradient of these velocities can turn anything inside out.
    pub(crate) fn deforms_safely(&self, settings: &StepSettings) -> bool {
        // A particle at a node has the slope of a linear weight at the next one, which may have no mass.
        let (low, high) = match settings.kernel {
            Kernel::Linear => (self.low.map(|v| v.min(0.0)), self.high.map(|v| v.max(0.0))),
            Kernel::Quadratic | Kernel::Cubic => (self.low, self.high),
        };
        let range: f64 = (0..D).map(|a| (high[a] - low[a]).powi(2)).sum::<f64>().sqrt();
        settings.step * (D as f64).sqrt() * range / settings.spacing <= SAFE_INCREMENT
    }

    /// The most that particles whose velocities are at most `speed` move beyond [`reach`](Self::reach) with what the grid could not carry of
    /// them, |v − Σ w (v⁺ − Δv)| \[m\].
    pub(crate) fn stray(&self, speed: &[f64; D], step: f64) -> [f64; D] {
        let reach = self.reach(step);
        std::array::from_fn(|a| reach[a] + step * (speed[a] + self.change[a]))
    }

    /// The largest displacement along each axis \[m\].
    pub(crate) fn reach(&self, step: f64) -> [f64; D] {
        std::array::from_fn(|a| step * self.low[a].abs().max(self.high[a].abs()))
    }
}

/// Where particles may be \[m\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Domain<const D: usize> {
    pub(crate) low: [f64; D],
    pub(crate) high: [f64; D],
}

impl<const D: usize> Domain<D> {
    /// Whether a place belongs to it; a NaN does not.
    pub(crate) fn contains(&self, position: &[f64; D]) -> bool {
        (0..D).all(|a| self.low[a] <= position[a] && position[a] <= self.high[a])
    }

    /// All cells that have numbers.
    pub(crate) fn of_cells(spacing: f64) -> Self {
        let edge = (FARTHEST_CELL - 1.0) * spacing;
        Self { low: [-edge; D], high: [edge; D] }
    }

    /// Confirms that a particle is within.
    pub(crate) fn check(&self, body: usize, particle: usize, position: &[f64; D]) -> Result<(), MpmError> {
        if self.contains(position) {
            return Ok(());
        }
        let (position, low, high) = (position.to_vec(), self.low.to_vec(), self.high.to_vec());
        Err(MpmError::OutOfDomain { body, particle, position, low, high })
    }

    /// Whether everything between `low` and `high` stays within when it moves by up to `reach`.
    pub(crate) fn holds(&self, low: &[f64; D], high: &[f64; D], reach: &[f64; D]) -> bool {
        (0..D).all(|a| self.low[a] <= low[a] - reach[a] && high[a] + reach[a] <= self.high[a])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Transfer, kernel};

    /// Sums |g| Δx over a fine sweep of places: the constant 2 of the bound.
    fn largest<const W: usize>(moment: Option<f64>) -> f64 {
        let mut most = 0.0_f64;
        for k in 0..=10_000 {
            let x = f64::from(k) * 1e-4;
            let f = x - kernel::lowest_node::<f64, W>(x);
            let w = kernel::weights::<f64, W>(f);
            let slopes = kernel::slopes::<f64, W>(f);
            let sum: f64 = match moment {
                None => slopes.iter().map(|s| s.abs()).sum(),
                Some(moment) => (0..W).map(|i| (w[i] * (i as f64 - f)).abs() / moment).sum(),
            };
            most = most.max(sum);
        }
        most
    }

    #[test]
    fn gradients_weigh_nodes_by_two_at_most() {
        assert!((largest::<2>(None) - 2.0).abs() < 1e-12);
        assert!((largest::<3>(None) - 2.0).abs() < 1e-3 && largest::<3>(None) <= 2.0 + 1e-12);
        assert!((largest::<4>(None) - 1.5).abs() < 1e-6);
        assert!((largest::<3>(Kernel::Quadratic.second_moment()) - 2.0).abs() < 1e-3);
        assert!((largest::<4>(Kernel::Cubic.second_moment()) - 3.0 * 13.0 / 24.0).abs() < 1e-6);
    }

    #[test]
    fn spans_see_nodes_with_mass_only() {
        let nodes = [1.0, -3.0, 2.0, 0.0, 0.0, 9.0, 9.0, 9.0, 2.0, 5.0, 2.5, 0.0];
        let span = Span::<2>::of_nodes(&nodes);
        assert_eq!(span, Span { low: [-3.0, 2.0], high: [5.0, 2.5], change: [0.0; 2] });
        let settings =
            StepSettings { step: 0.1, spacing: 1.0, kernel: Kernel::Quadratic, transfer: Transfer::MlsApic };
        // 0.1 · √2 · √(8² + 0.5²) = 1.13.
        assert!(!span.deforms_safely(&settings));
        assert!(span.deforms_safely(&StepSettings { step: 0.07, ..settings }));
        assert_eq!(span.reach(0.1), [0.5, 0.25]);
    }
}
