//! Pendulums: as Lagrangians, and their accelerations by hand.

use lagrangian::Lagrangian;
use mechanics_core::scalar::Scalar;

pub(crate) const GRAVITY: f64 = 9.81;

/// The double pendulum of the fixture `double_pendulum_regular`, in absolute angles.
#[derive(Clone, Copy)]
pub(crate) struct Double {
    pub(crate) mass: [f64; 2],
    pub(crate) length: [f64; 2],
}

impl Double {
    /// As a person derives it on paper: two equations, sines and cosines shared, Cramer's rule.
    #[inline]
    pub(crate) fn by_hand(&self, q: &[f64; 2], v: &[f64; 2]) -> [f64; 2] {
        let ([m1, m2], [l1, l2]) = (self.mass, self.length);
        let (sine, cosine) = (q[0] - q[1]).sin_cos();
        let total = m1 + m2;
        let first = -m2 * l2 * v[1] * v[1] * sine - total * GRAVITY * q[0].sin();
        let second = l1 * v[0] * v[0] * sine - GRAVITY * q[1].sin();
        let determinant = l1 * l2 * (m1 + m2 * sine * sine);
        [
            (first * l2 - m2 * l2 * cosine * second) / determinant,
            (total * l1 * second - l1 * cosine * first) / determinant,
        ]
    }
}

impl Lagrangian<2> for Double {
    #[inline]
    fn kinetic<S: Scalar>(&self, q: &[S; 2], v: &[S; 2], _t: S) -> S {
        let ([m1, m2], [l1, l2]) = (self.mass, self.length);
        let coupling = (q[0] - q[1]).cos().scale(m2 * l1 * l2);
        v[0].square().scale(0.5 * (m1 + m2) * l1 * l1)
            + v[1].square().scale(0.5 * m2 * l2 * l2)
            + v[0] * v[1] * coupling
    }
    #[inline]
    fn potential<S: Scalar>(&self, q: &[S; 2], _t: S) -> S {
        let ([m1, m2], [l1, l2]) = (self.mass, self.length);
        q[0].cos().scale(-(m1 + m2) * GRAVITY * l1) + q[1].cos().scale(-m2 * GRAVITY * l2)
    }
}

/// The same from the velocities of the bobs in the plane, as a textbook writes it first.
#[derive(Clone, Copy)]
pub(crate) struct Cartesian(pub(crate) Double);

impl Lagrangian<2> for Cartesian {
    #[inline]
    fn kinetic<S: Scalar>(&self, q: &[S; 2], v: &[S; 2], _t: S) -> S {
        let (mut x, mut y, mut sum) = (S::constant(0.0), S::constant(0.0), S::constant(0.0));
        for i in 0..2 {
            x += (q[i].cos() * v[i]).scale(self.0.length[i]);
            y += (q[i].sin() * v[i]).scale(self.0.length[i]);
            sum += (x.square() + y.square()).scale(0.5 * self.0.mass[i]);
        }
        sum
    }
    #[inline]
    fn potential<S: Scalar>(&self, q: &[S; 2], _t: S) -> S {
        let (mut y, mut sum) = (S::constant(0.0), S::constant(0.0));
        for i in 0..2 {
            y -= q[i].cos().scale(self.0.length[i]);
            sum += y.scale(GRAVITY * self.0.mass[i]);
        }
        sum
    }
}

/// The triple pendulum of the fixture `triple_pendulum`, in absolute angles.
#[derive(Clone, Copy)]
pub(crate) struct Triple {
    pub(crate) mass: [f64; 3],
    pub(crate) length: [f64; 3],
}

impl Triple {
    /// Mass that hangs on joint `i`.
    #[inline]
    fn below(&self, i: usize) -> f64 {
        self.mass[i..].iter().sum()
    }

    /// Three equations with six sines and cosines, differences of angles by the addition theorems, elimination by hand.
    #[inline]
    pub(crate) fn by_hand(&self, q: &[f64; 3], v: &[f64; 3]) -> [f64; 3] {
        let l = self.length;
        let (sine, cosine) = (q.map(f64::sin), q.map(f64::cos));
        let mut m = [[0.0; 3]; 3];
        let mut b = [0.0; 3];
        for i in 0..3 {
            b[i] -= self.below(i) * GRAVITY * l[i] * sine[i];
            m[i][i] = self.below(i) * l[i] * l[i];
            for j in 0..i {
                let coupling = self.below(i) * l[i] * l[j];
                m[i][j] = coupling * (cosine[i] * cosine[j] + sine[i] * sine[j]);
                let turn = coupling * (sine[i] * cosine[j] - cosine[i] * sine[j]);
                b[i] -= turn * v[j] * v[j];
                b[j] += turn * v[i] * v[i];
            }
        }
        let (f10, f20) = (m[1][0] / m[0][0], m[2][0] / m[0][0]);
        let (m11, m21) = (m[1][1] - f10 * m[1][0], m[2][1] - f20 * m[1][0]);
        let f21 = m21 / m11;
        let m22 = m[2][2] - f20 * m[2][0] - f21 * m21;
        let b1 = b[1] - f10 * b[0];
        let x2 = (b[2] - f20 * b[0] - f21 * b1) / m22;
        let x1 = (b1 - m21 * x2) / m11;
        [(b[0] - m[1][0] * x1 - m[2][0] * x2) / m[0][0], x1, x2]
    }
}

impl Lagrangian<3> for Triple {
    #[inline]
    fn kinetic<S: Scalar>(&self, q: &[S; 3], v: &[S; 3], _t: S) -> S {
        let l = self.length;
        let mut sum = S::constant(0.0);
        for i in 0..3 {
            sum += v[i].square().scale(0.5 * self.below(i) * l[i] * l[i]);
            for j in 0..i {
                sum += (v[i] * v[j] * (q[i] - q[j]).cos()).scale(self.below(i) * l[i] * l[j]);
            }
        }
        sum
    }
    #[inline]
    fn potential<S: Scalar>(&self, q: &[S; 3], _t: S) -> S {
        let mut sum = S::constant(0.0);
        for i in 0..3 {
            sum += q[i].cos().scale(-self.below(i) * GRAVITY * self.length[i]);
        }
        sum
    }
}
