//! The systems of these tests, and their fixtures.

use lagrangian::{EulerLagrange, Lagrangian, Phase, System};
use mechanics_core::scalar::Scalar;
use serde_json::Value;

/// L = ½ m l² θ̇² + m g l cos θ with m = l = 1.
pub(crate) struct Pendulum;

impl Lagrangian<1> for Pendulum {
    fn kinetic<S: Scalar>(&self, _q: &[S; 1], v: &[S; 1], _t: S) -> S {
        v[0].square().scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 1], _t: S) -> S {
        -q[0].cos().scale(9.81)
    }
}

/// Two point masses on rods, angles from the vertical, with the parameters of `double_pendulum_regular`.
pub(crate) struct DoublePendulum;

impl Lagrangian<2> for DoublePendulum {
    fn kinetic<S: Scalar>(&self, q: &[S; 2], v: &[S; 2], _t: S) -> S {
        v[0].square().scale(1.5) + v[1].square().scale(0.125) + ((q[0] - q[1]).cos() * v[0] * v[1]).scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 2], _t: S) -> S {
        -q[0].cos().scale(3.0 * 9.81) - q[1].cos().scale(0.5 * 9.81)
    }
}

/// V = −1/r.
pub(crate) struct Kepler;

impl Lagrangian<2> for Kepler {
    fn kinetic<S: Scalar>(&self, _q: &[S; 2], v: &[S; 2], _t: S) -> S {
        (v[0].square() + v[1].square()).scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 2], _t: S) -> S {
        -(q[0].square() + q[1].square()).sqrt().recip()
    }
}

/// V = (x² + y²)/2 + x² y − y³/3.
pub(crate) struct HenonHeiles;

impl Lagrangian<2> for HenonHeiles {
    fn kinetic<S: Scalar>(&self, _q: &[S; 2], v: &[S; 2], _t: S) -> S {
        (v[0].square() + v[1].square()).scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 2], _t: S) -> S {
        let [x, y] = *q;
        (x.square() + y.square()).scale(0.5) + x.square() * y - y.powi(3).scale(1.0 / 3.0)
    }
}

/// ẍ + 0.3 ẋ − x + x³ = 0.5 cos 1.2 t.
pub(crate) struct Duffing;

impl Lagrangian<1> for Duffing {
    fn kinetic<S: Scalar>(&self, _q: &[S; 1], v: &[S; 1], _t: S) -> S {
        v[0].square().scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 1], _t: S) -> S {
        q[0].powi(4).scale(0.25) - q[0].square().scale(0.5)
    }
    fn force<S: Scalar>(&self, _q: &[S; 1], v: &[S; 1], t: S) -> [S; 1] {
        [t.scale(1.2).cos().scale(0.5) - v[0].scale(0.3)]
    }
}

/// A mass of 1 that falls with g = 9.81.
pub(crate) struct FreeFall;

impl Lagrangian<1> for FreeFall {
    fn kinetic<S: Scalar>(&self, _q: &[S; 1], v: &[S; 1], _t: S) -> S {
        v[0].square().scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 1], _t: S) -> S {
        q[0].scale(9.81)
    }
}

/// ½ (v² − ω² q²).
pub(crate) struct Oscillator(pub(crate) f64);

impl Lagrangian<1> for Oscillator {
    fn kinetic<S: Scalar>(&self, _q: &[S; 1], v: &[S; 1], _t: S) -> S {
        v[0].square().scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 1], _t: S) -> S {
        q[0].square().scale(0.5 * self.0 * self.0)
    }
}

/// Unequal masses and springs in a row, the first and last fixed to walls, coupled inertia between the outer ones.
pub(crate) struct SpringChain;

impl Lagrangian<3> for SpringChain {
    fn kinetic<S: Scalar>(&self, _q: &[S; 3], v: &[S; 3], _t: S) -> S {
        v[0].square() + v[1].square().scale(0.25) + v[2].square().scale(1.5) + (v[0] * v[2]).scale(0.4)
    }
    fn potential<S: Scalar>(&self, q: &[S; 3], _t: S) -> S {
        let stretch = [q[0], q[1] - q[0], q[2] - q[1], -q[2]];
        let energy = |x: S| x.square().scale(2.0) + x.powi(4).scale(0.3);
        energy(stretch[0]) + energy(stretch[1]) + energy(stretch[2]) + energy(stretch[3])
    }
}

/// A trajectory of 32 digits.
pub(crate) struct Fixture<const N: usize> {
    pub(crate) times: Vec<f64>,
    pub(crate) q: Vec<[f64; N]>,
    pub(crate) v: Vec<[f64; N]>,
}

impl<const N: usize> Fixture<N> {
    pub(crate) fn read(name: &str) -> Self {
        let path = format!("{}/tests/fixtures/{name}.json", env!("CARGO_MANIFEST_DIR"));
        let file: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
        let samples = file["samples"].as_array().unwrap();
        let numbers = |sample: &Value, key: &str| {
            std::array::from_fn(|i| sample[key][i].as_str().unwrap().parse().unwrap())
        };
        Self {
            times: samples.iter().map(|sample| sample["t"].as_f64().unwrap()).collect(),
            q: samples.iter().map(|sample| numbers(sample, "q")).collect(),
            v: samples.iter().map(|sample| numbers(sample, "qdot")).collect(),
        }
    }

    pub(crate) fn start(&self) -> Phase<[f64; N]> {
        Phase::new(self.times[0], self.q[0], self.v[0])
    }

    /// The largest number in it: what errors are relative to.
    pub(crate) fn scale(&self) -> f64 {
        self.q.iter().chain(&self.v).flatten().fold(0.0, |most, x| x.abs().max(most))
    }

    /// The largest error of a state against sample `index`.
    pub(crate) fn error(&self, index: usize, phase: &Phase<[f64; N]>) -> f64 {
        let pairs = phase.q.iter().zip(&self.q[index]).chain(phase.v.iter().zip(&self.v[index]));
        pairs.fold(0.0, |most, (a, b)| (a - b).abs().max(most))
    }
}

/// T + V.
pub(crate) fn energy<S: System>(system: &S, phase: &Phase<S::Coordinates>) -> f64 {
    system.energy(phase.time, &phase.q, &phase.v)
}

pub(crate) fn of<const N: usize, L: Lagrangian<N>>(lagrangian: L) -> EulerLagrange<L, N> {
    EulerLagrange::new(lagrangian)
}
