//! The stage of the nodes: momenta become velocities, forces and boundaries act.

use crate::boundary::{Boundary, PrescribedVelocity};
use crate::grip::PlacedGrip;
use crate::neighbourhood::{NODE, block_edge};
use mechanics_core::lanes::{Element, LaneKernel, Packet};

/// What a block of nodes says of its step.
#[derive(Clone, Copy, Debug)]
pub(super) struct NodeReport<const D: usize> {
    pub(super) origin: [i32; D],
    /// Whether something is not finite.
    pub(super) broken: bool,
}

impl<const D: usize> Default for NodeReport<D> {
    fn default() -> Self {
        Self { origin: [0; D], broken: false }
    }
}

/// Momenta become velocities; impulses, if they come apart, and gravity act.
pub(super) struct NodeUpdate<'a, E, const D: usize> {
    pub(super) nodes: &'a mut [E],
    pub(super) changes: &'a mut [E],
    pub(super) gain: [f64; D],
}

impl<E: Element, const D: usize> LaneKernel<E> for NodeUpdate<'_, E, D> {
    type Output = NodeReport<D>;

    #[inline(always)]
    fn run<P: Packet<Element = E>>(self) -> NodeReport<D> {
        let zero = E::default();
        let mut gain = [zero; NODE];
        for axis in 0..D {
            gain[1 + axis] = E::constant(self.gain[axis]);
        }
        let mut broken = false;
        for (k, node) in self.nodes.chunks_exact_mut(NODE).enumerate() {
            let mass = node[0];
            // Inert without mass; a mass that is NaN must not hide.
            if mass.less_equal(zero) {
                continue;
            }
            for c in 1..NODE {
                let before = node[c] / mass;
                node[c] = before + gain[c];
                if !self.changes.is_empty() {
                    // An impulse becomes the velocity before it.
                    node[c] += self.changes[NODE * k + c] / mass;
                    self.changes[NODE * k + c] = before;
                }
                broken |= !node[c].is_finite();
            }
        }
        NodeReport { broken, ..NodeReport::default() }
    }
}

/// What sets the velocities of nodes, at one moment.
pub(super) struct Constraints<'a, const D: usize> {
    pub(super) grips: &'a [PlacedGrip<D>],
    pub(super) prescribed: &'a [PrescribedVelocity<D>],
    pub(super) boundaries: &'a [Boundary<D>],
    /// Middle of the step \[s\].
    pub(super) middle: f64,
    /// End of the step \[s\].
    pub(super) end: f64,
    pub(super) spacing: f64,
}

impl<const D: usize> Constraints<'_, D> {
    /// Acts on the nodes with mass of the block at `origin`.
    pub(super) fn act<E: Element>(&self, origin: &[i32; D], nodes: &mut [E]) {
        if self.boundaries.is_empty() && self.prescribed.is_empty() && self.grips.is_empty() {
            return;
        }
        let edge = block_edge(D);
        for (k, node) in nodes.chunks_exact_mut(NODE).enumerate() {
            if node[0].less_equal(E::default()) {
                continue;
            }
            let point: [f64; D] = std::array::from_fn(|axis| {
                let local = k / edge.pow((D - 1 - axis) as u32) % edge;
                (f64::from(origin[axis]) * edge as f64 + local as f64) * self.spacing
            });
            let before: [f64; D] = std::array::from_fn(|axis| node[1 + axis].into());
            let mut velocity = before;
            for grip in self.grips {
                velocity = grip.velocity_at(&point).unwrap_or(velocity);
            }
            for prescribed in self.prescribed {
                velocity = prescribed.act(&point, self.middle, &velocity);
            }
            for boundary in self.boundaries {
                velocity = boundary.act(&point, self.end, &velocity);
            }
            if velocity != before {
                for axis in 0..D {
                    node[1 + axis] = E::constant(velocity[axis]);
                }
            }
        }
    }
}
