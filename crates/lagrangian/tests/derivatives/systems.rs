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

/// A pendulum of `N` unit masses on unit rods, in absolute angles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NFold;

fn n_fold_kinetic<S: Scalar>(q: &[S], v: &[S]) -> S {
    let n = q.len();
    let mut sum = S::constant(0.0);
    for i in 0..n {
        for j in 0..n {
            sum += (v[i] * v[j] * (q[i] - q[j]).cos()).scale(0.5 * (n - i.max(j)) as f64);
        }
    }
    sum
}

fn n_fold_potential<S: Scalar>(q: &[S]) -> S {
    let n = q.len();
    (0..n).fold(S::constant(0.0), |sum, i| sum - q[i].cos().scale((n - i) as f64 * GRAVITY))
}

impl<const N: usize> Lagrangian<N> for NFold {
    fn kinetic<S: Scalar>(&self, q: &[S; N], v: &[S; N], _t: S) -> S {
        n_fold_kinetic(q, v)
    }
    fn potential<S: Scalar>(&self, q: &[S; N], _t: S) -> S {
        n_fold_potential(q)
    }
}

/// Numbers in [−1, 1), the same in every run.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
    pub(crate) fn numbers<const N: usize>(&mut self) -> [f64; N] {
        std::array::from_fn(|_| self.number())
    }
}

/// How many functions [`Synthetic`] knows.
pub(crate) const FUNCTIONS: usize = 34;

/// T, V, R and Q that are one function of `Scalar` of arguments in which everything is mixed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Synthetic {
    pub(crate) function: usize,
}

impl Synthetic {
    /// Function number `function` of two arguments in [−1, 1], moved into its domain.
    fn apply<S: Scalar>(&self, a: S, b: S) -> S {
        let positive = a.offset(1.5);
        match self.function {
            0 => a + b,
            1 => a - b,
            2 => a * b,
            3 => a / b.offset(2.0),
            4 => -a,
            5 => {
                let mut x = a;
                x += b;
                x -= a * b;
                x *= positive;
                x /= b.offset(3.0);
                x
            }
            6 => a.scale(-2.5),
            7 => a.offset(0.25),
            8 => a.mul_add(b, a),
            9 => a.square(),
            10 => positive.recip(),
            11 => positive.sqrt(),
            12 => a.exp(),
            13 => a.exp_m1(),
            14 => positive.ln(),
            15 => a.scale(0.5).ln_1p(),
            16 => a.sin(),
            17 => a.cos(),
            18 => a.tan(),
            19 => a.atan2(b),
            20 => a.scale(0.9).asin(),
            21 => a.scale(0.9).acos(),
            22 => a.sinh(),
            23 => a.cosh(),
            24 => a.tanh(),
            25 => a.powi(3),
            26 => positive.powi(-2),
            27 => positive.powf(1.7),
            28 => a.powi(1) * b.powi(0) + b.powi(2),
            29 => a.abs() * b,
            30 => a.square().copysign(b),
            31 => a.min(b).square() + a.max(b).exp(),
            32 => S::select(a.less_equal(b), a * b, a.sin()),
            _ => positive.reciprocal_power_of_two() * a * b,
        }
    }

    fn mixed<S: Scalar>(q: &[S], v: &[S], t: S) -> [S; 2] {
        let n = q.len();
        let (mut a, mut b) = (t.scale(0.1), t.square().scale(-0.1));
        for i in 0..n {
            a += (q[i] * v[(i + 1) % n] + v[i]).scale(0.3 / n as f64);
            b += (v[i] * v[(i + 1) % n] - q[i] * t + q[i]).scale(0.25 / n as f64);
        }
        [a, b]
    }
}

impl<const N: usize> Lagrangian<N> for Synthetic {
    fn kinetic<S: Scalar>(&self, q: &[S; N], v: &[S; N], t: S) -> S {
        let [a, b] = Self::mixed(q, v, t);
        self.apply(a, b)
    }
    fn potential<S: Scalar>(&self, q: &[S; N], t: S) -> S {
        let [a, b] = Self::mixed(q, &q.map(|q| q.scale(0.7)), t);
        self.apply(a, b)
    }
    fn rayleigh<S: Scalar>(&self, q: &[S; N], v: &[S; N], t: S) -> S {
        let [a, b] = Self::mixed(q, v, t);
        self.apply(b, a)
    }
    fn force<S: Scalar>(&self, q: &[S; N], v: &[S; N], t: S) -> [S; N] {
        let [a, b] = Self::mixed(v, q, t);
        std::array::from_fn(|i| self.apply(a, b) * q[i])
    }
}

/// A Lagrangian in `N` coordinates as one whose size is known at run time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AsSliced<L, const N: usize>(pub(crate) L);

fn array<S: Copy, const N: usize>(x: &[S]) -> [S; N] {
    std::array::from_fn(|i| x[i])
}

impl<const N: usize, L: Lagrangian<N>> SlicedLagrangian for AsSliced<L, N> {
    fn dimension(&self) -> usize {
        N
    }
    fn kinetic<S: Scalar>(&self, q: &[S], v: &[S], t: S) -> S {
        self.0.kinetic(&array(q), &array(v), t)
    }
    fn potential<S: Scalar>(&self, q: &[S], t: S) -> S {
        self.0.potential(&array(q), t)
    }
    fn rayleigh<S: Scalar>(&self, q: &[S], v: &[S], t: S) -> S {
        self.0.rayleigh(&array(q), &array(v), t)
    }
    fn add_force<S: Scalar>(&self, q: &[S], v: &[S], t: S, force: &mut [S]) {
        let added = self.0.force(&array::<S, N>(q), &array(v), t);
        force.iter_mut().zip(added).for_each(|(force, added)| *force += added);
    }
}
