//! First and second variation of the action.

use super::Action;
use super::block::BlockTridiagonal;
use super::path::Path;
use crate::coordinates::Coordinates;
use crate::system::{Curvature, Expansion, System};

/// The first variation of the action at a path.
#[derive(Clone, Debug)]
pub(super) struct Variation {
    /// A \[J s\].
    pub(super) action: f64,
    /// Σ |h b L|: what the action's rounding is measured against.
    pub(super) size: f64,
    /// ∂A/∂q of the nodes between the ends.
    pub(super) gradient: Vec<f64>,
    /// How far each entry of the gradient may be wrong by rounding.
    pub(super) rounding: Vec<f64>,
}

impl Variation {
    /// The entry of the gradient that is largest.
    pub(super) fn worst(&self) -> usize {
        let larger =
            |best: usize, i: usize| if self.gradient[i].abs() > self.gradient[best].abs() { i } else { best };
        (0..self.gradient.len()).reduce(larger).unwrap_or(0)
    }

    /// Whether all of it is a number.
    pub(super) fn is_finite(&self) -> bool {
        self.action.is_finite() && self.gradient.iter().all(|g| g.is_finite())
    }

    /// Whether no entry stands out of rounding by more than `factor`.
    pub(super) fn is_rounding(&self, factor: f64) -> bool {
        self.gradient.iter().zip(&self.rounding).all(|(g, r)| g.abs() <= factor * r)
    }
}

impl<S: System> Action<'_, S> {
    /// Unknowns of each block: the inner nodes of an interval and the joint at its end; of the last one the inner
    /// nodes.
    pub(super) fn blocks(&self) -> Vec<usize> {
        let (dimension, degree) = (self.system.dimension(), self.basis.degree);
        let mut sizes = vec![dimension * degree; self.intervals];
        sizes[self.intervals - 1] -= dimension;
        sizes.retain(|&size| size > 0);
        sizes
    }

    /// ∂A/∂qⱼ = Σ h b (ℓⱼ ∂L/∂q + ℓⱼ′/h ∂L/∂v), and A itself.
    pub(super) fn variation(&self, path: &Path<S::Coordinates>) -> Variation {
        let (dimension, degree, h) = (self.system.dimension(), self.basis.degree, self.step());
        let unknowns = (self.node_count() - 2) * dimension;
        let mut out = Variation {
            action: 0.0,
            size: 0.0,
            gradient: vec![0.0; unknowns],
            rounding: vec![0.0; unknowns],
        };
        let mut at = Expansion::zeros(dimension);
        for interval in 0..self.intervals {
            for (index, point) in self.basis.points.iter().enumerate() {
                let (t, q, v) = self.state(path, interval, index);
                self.system.expand(t, &q, &v, &mut at);
                out.action += h * point.weight * (at.kinetic - at.potential);
                out.size += h * point.weight * (at.kinetic.abs() + at.potential.abs());
                let mass = S::Coordinates::entries(&at.mass);
                let slopes: f64 = point.slopes.iter().map(|slope| slope.abs()).sum();
                for j in 0..=degree {
                    let Some(node) = self.unknown(interval * degree + j) else { continue };
                    let (value, slope) = (h * point.weight * point.values[j], point.weight * point.slopes[j]);
                    for i in 0..dimension {
                        let (force, momentum) = (at.slope.as_ref()[i], at.momentum.as_ref()[i]);
                        out.gradient[node + i] += value * force + slope * momentum;
                        // Velocities are differences of positions over h, and carry their rounding through the mass.
                        let spoilt: f64 = (0..dimension)
                            .map(|k| (mass[i * dimension + k] * q.as_ref()[k]).abs() * slopes / h)
                            .sum();
                        out.rounding[node + i] +=
                            f64::EPSILON * ((value * force).abs() + slope.abs() * (momentum.abs() + spoilt));
                    }
                }
            }
        }
        out
    }

    /// The Hessian of A: blocks (a, b) of an interval's nodes are
    /// Σ h b [ℓₐℓ_b L_qq + (ℓₐ′ℓ_b L_vq + ℓₐℓ_b′ L_vqᵀ)/h + ℓₐ′ℓ_b′ L_vv/h²].
    pub(super) fn hessian_into(&self, path: &Path<S::Coordinates>, out: &mut BlockTridiagonal) {
        let (dimension, degree, h) = (self.system.dimension(), self.basis.degree, self.step());
        out.clear();
        let mut at = Curvature::zeros(dimension);
        for interval in 0..self.intervals {
            for (index, point) in self.basis.points.iter().enumerate() {
                let (t, q, v) = self.state(path, interval, index);
                self.system.curve(t, &q, &v, &mut at);
                let (qq, vq, vv) = (
                    S::Coordinates::entries(&at.qq),
                    S::Coordinates::entries(&at.vq),
                    S::Coordinates::entries(&at.vv),
                );
                for (a, b) in (0..=degree).flat_map(|a| (0..=degree).map(move |b| (a, b))) {
                    let (qa, qb) = (point.values[a], point.values[b]);
                    let (va, vb) = (point.slopes[a] / h, point.slopes[b] / h);
                    for (i, j) in (0..dimension).flat_map(|i| (0..dimension).map(move |j| (i, j))) {
                        let (e, f) = (i * dimension + j, j * dimension + i);
                        let entry = qa * qb * qq[e] + va * qb * vq[e] + qa * vb * vq[f] + va * vb * vv[e];
                        self.add_entry(out, interval, (a, i), (b, j), h * point.weight * entry);
                    }
                }
            }
        }
    }

    /// Adds to the entry of coordinate i of node a and coordinate j of node b, both nodes of one interval.
    fn add_entry(
        &self,
        out: &mut BlockTridiagonal,
        interval: usize,
        (a, i): (usize, usize),
        (b, j): (usize, usize),
        entry: f64,
    ) {
        let (n, degree) = (self.system.dimension(), self.basis.degree);
        let last = interval + 1 == self.intervals;
        if last && (a == degree || b == degree) || interval == 0 && (a == 0 || b == 0) {
            return;
        }
        match (a, b) {
            (0, 0) => {
                let (m, first) = (out.sizes[interval - 1], (degree - 1) * n);
                out.diagonal[interval - 1][(first + i) * m + first + j] += entry;
            }
            (0, _) => {
                let m = out.sizes[interval];
                out.coupling[interval - 1][i * m + (b - 1) * n + j] += entry;
            }
            (_, 0) => {}
            _ => {
                let m = out.sizes[interval];
                out.diagonal[interval][((a - 1) * n + i) * m + (b - 1) * n + j] += entry;
            }
        }
    }

    /// The first unknown of a node; none for an end.
    fn unknown(&self, node: usize) -> Option<usize> {
        (node > 0 && node + 1 < self.node_count()).then(|| (node - 1) * self.system.dimension())
    }
}
