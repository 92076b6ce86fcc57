//! Lagrangians that the tests differentiate.

use lagrangian::{Lagrangian, SlicedLagrangian};
use mechanics_core::scalar::Scalar;

/// The double pendulum in absolute angles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DoublePendulum {
    pub(crate) mass: [f64; 2],
    pub(crate) length: [f64; 2],
}

pub(crate) const GRAVITY: f64 = 9.81;

impl Lagrangian<2> for DoublePendulum {
    fn kinetic<S: Scalar>(&self, q: &[S; 2], v: &[S; 2], _t: S) -> S {
        let ([m1, m2], [l1, l2]) = (self.mass, self.length);
        let coupling = (q[0] - q[1]).cos().scale(m2 * l1 * l2);
        v[0].square().scale(0.5 * (m1 + m2) * l1 * l1)
            + v[1].square().scale(0.5 * m2 * l2 * l2)
            + v[0] * v[1] * coupling
    }
    fn potential<S: Scalar>(&self, q: &[S; 2], _t: S) -> S {
        let ([m1, m2], [l1, l2]) = (self.mass, self.length);
        q[0].cos().scale(-(m1 + m2) * GRAVITY * l1) + q[1].cos().scale(-m2 * GRAVITY * l2)
    }
}

/// A chain of unit masses and springs between two walls, with damping of every spring and a pull at the last mass.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Chain {
    pub(crate) masses: usize,
    pub(crate) damping: f64,
    pub(crate) pull: f64,
}

impl SlicedLagrangian for Chain {
    fn dimension(&self) -> usize {
        self.masses
    }
    fn kinetic<S: Scalar>(&self, _q: &[S], v: &[S], _t: S) -> S {
        v.iter().fold(S::constant(0.0), |sum, v| sum + v.square().scale(0.5))
    }
    fn potential<S: Scalar>(&self, q: &[S], _t: S) -> S {
        let ends = q[0].square() + q[q.len() - 1].square();
        q.windows(2).fold(ends, |sum, pair| sum + (pair[1] - pair[0]).square()).scale(0.5)
    }
    fn rayleigh<S: Scalar>(&self, _q: &[S], v: &[S], _t: S) -> S {
        v.windows(2)
            .fold(S::constant(0.0), |sum, pair| sum + (pair[1] - pair[0]).square())
            .scale(self.damping)
    }
    fn add_force<S: Scalar>(&self, _q: &[S], _v: &[S], t: S, force: &mut [S]) {
        force[self.masses - 1] += t.sin().scale(self.pull);
    }
}
