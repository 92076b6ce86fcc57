//! A path: piecewise polynomial in time.

use super::rule::Basis;
use crate::coordinates::{Coordinates, Phase};

/// A path q(t), continuous, and a polynomial on every interval; made by [`Action::path`](super::Action::path).
#[derive(Clone, Debug)]
pub struct Path<C> {
    pub(super) basis: Basis,
    pub(super) times: Vec<f64>,
    pub(super) positions: Vec<C>,
}

impl<C: Coordinates> Path<C> {
    /// The times of the nodes \[s\], increasing.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// The positions at the nodes.
    pub fn positions(&self) -> &[C] {
        &self.positions
    }

    /// The nodes between intervals, where the order of the method holds: every `degree`-th of all.
    pub fn joints(&self) -> impl Iterator<Item = (f64, &C)> {
        self.times.iter().copied().zip(&self.positions).step_by(self.basis.degree)
    }

    /// Position and velocity at a time; at a joint, those of the interval before it (after it at the start). Times
    /// outside are those of the polynomial at that end, continued.
    ///
    /// Velocities have the order of the polynomials' degree s only, at the joints too, where they jump by as much.
    pub fn at(&self, time: f64) -> Phase<C> {
        let degree = self.basis.degree;
        let intervals = (self.positions.len() - 1) / degree;
        let joints = |k: usize| self.times[k * degree];
        let mut interval = 0;
        let mut end = intervals;
        while end - interval > 1 {
            let middle = (interval + end) / 2;
            if time > joints(middle) { interval = middle } else { end = middle }
        }
        let step = joints(interval + 1) - joints(interval);
        let (values, slopes) = self.basis.at((time - joints(interval)) / step);
        let (q, v) = self.blend(interval * degree, &values, &slopes, step);
        Phase { time, q, v }
    }

    /// Σ wⱼ qⱼ and Σ sⱼ qⱼ / h over the nodes of one interval.
    pub(super) fn blend(&self, first: usize, values: &[f64], slopes: &[f64], step: f64) -> (C, C) {
        let dimension = self.positions[0].as_ref().len();
        let (mut q, mut v) = (C::zeros(dimension), C::zeros(dimension));
        // Slopes add up to zero: taken from the differences to the first node, velocities of far away paths keep
        // their digits.
        let origin = self.positions[first].as_ref();
        for (j, (value, slope)) in values.iter().zip(slopes).enumerate() {
            let node = self.positions[first + j].as_ref();
            for i in 0..dimension {
                let difference = node[i] - origin[i];
                q.as_mut()[i] += value * difference;
                v.as_mut()[i] += slope * difference;
            }
        }
        for i in 0..dimension {
            q.as_mut()[i] += origin[i];
            v.as_mut()[i] /= step;
        }
        (q, v)
    }

    /// The path with `step` times `correction` added to the nodes between the ends.
    pub(super) fn moved(&self, correction: &[f64], step: f64) -> Self {
        let mut out = self.clone();
        let last = out.positions.len() - 1;
        let numbers = out.positions[1..last].iter_mut().flat_map(|q| q.as_mut().iter_mut());
        numbers.zip(correction).for_each(|(x, c)| *x += step * c);
        out
    }

    /// The path that lies between this one and `other`, this one at `part` zero.
    pub(super) fn between(&self, other: &Self, part: f64) -> Self {
        let mut out = self.clone();
        for (q, end) in out.positions.iter_mut().zip(&other.positions) {
            q.as_mut().iter_mut().zip(end.as_ref()).for_each(|(x, y)| *x += part * (y - *x));
        }
        out
    }
}
