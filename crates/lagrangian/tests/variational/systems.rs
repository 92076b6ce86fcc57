//! The systems of the fixtures, written out here so that these tests stand alone.

use lagrangian::integrator::Integrator;
use lagrangian::{Coordinates, EulerLagrange, Lagrangian, Phase, System};
use mechanics_core::scalar::Scalar;
use serde_json::Value;

pub const G: f64 = 9.81;

/// T = θ̇²/2, V = −g cos θ.
#[derive(Clone, Debug)]
pub struct Pendulum;

impl Lagrangian<1> for Pendulum {
    fn kinetic<S: Scalar>(&self, _: &[S; 1], v: &[S; 1], _: S) -> S {
        v[0].square().scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 1], _: S) -> S {
        q[0].cos().scale(-G)
    }
}

/// Point masses on rods, absolute angles from the downward vertical.
#[derive(Clone, Debug)]
pub struct DoublePendulum {
    pub masses: [f64; 2],
    pub lengths: [f64; 2],
}

pub const CHAOTIC: DoublePendulum = DoublePendulum { masses: [1.0, 1.0], lengths: [1.0, 1.0] };
pub const REGULAR: DoublePendulum = DoublePendulum { masses: [2.0, 1.0], lengths: [1.0, 0.5] };

impl Lagrangian<2> for DoublePendulum {
    fn kinetic<S: Scalar>(&self, q: &[S; 2], v: &[S; 2], _: S) -> S {
        let ([m1, m2], [l1, l2]) = (self.masses, self.lengths);
        v[0].square().scale(0.5 * (m1 + m2) * l1 * l1)
            + v[1].square().scale(0.5 * m2 * l2 * l2)
            + (v[0] * v[1] * (q[0] - q[1]).cos()).scale(m2 * l1 * l2)
    }
    fn potential<S: Scalar>(&self, q: &[S; 2], _: S) -> S {
        let ([m1, m2], [l1, l2]) = (self.masses, self.lengths);
        q[0].cos().scale(-G * (m1 + m2) * l1) + q[1].cos().scale(-G * m2 * l2)
    }
}

/// −1/r.
#[derive(Clone, Debug)]
pub struct Kepler;

impl Lagrangian<2> for Kepler {
    fn kinetic<S: Scalar>(&self, _: &[S; 2], v: &[S; 2], _: S) -> S {
        (v[0].square() + v[1].square()).scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 2], _: S) -> S {
        -(q[0].square() + q[1].square()).sqrt().recip()
    }
}

/// (θ, φ), unit mass and length, θ from the downward vertical.
#[derive(Clone, Debug)]
pub struct SphericalPendulum;

impl Lagrangian<2> for SphericalPendulum {
    fn kinetic<S: Scalar>(&self, q: &[S; 2], v: &[S; 2], _: S) -> S {
        (v[0].square() + (v[1] * q[0].sin()).square()).scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 2], _: S) -> S {
        q[0].cos().scale(-G)
    }
}

/// (r, θ), unit mass, k = 40, rest length 1.
#[derive(Clone, Debug)]
pub struct SpringPendulum;

impl Lagrangian<2> for SpringPendulum {
    fn kinetic<S: Scalar>(&self, q: &[S; 2], v: &[S; 2], _: S) -> S {
        (v[0].square() + (q[0] * v[1]).square()).scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 2], _: S) -> S {
        q[0].offset(-1.0).square().scale(20.0) - q[0] * q[1].cos().scale(G)
    }
}

#[derive(Clone, Debug)]
pub struct HenonHeiles;

impl Lagrangian<2> for HenonHeiles {
    fn kinetic<S: Scalar>(&self, _: &[S; 2], v: &[S; 2], _: S) -> S {
        (v[0].square() + v[1].square()).scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 2], _: S) -> S {
        let (x, y) = (q[0], q[1]);
        (x.square() + y.square()).scale(0.5) + x.square() * y - y * y.square() / S::constant(3.0)
    }
}

/// Euler angles (θ, φ, ψ).
#[derive(Clone, Debug)]
pub struct Top;

impl Lagrangian<3> for Top {
    fn kinetic<S: Scalar>(&self, q: &[S; 3], v: &[S; 3], _: S) -> S {
        let across = (v[1] * q[0].sin()).square() + v[0].square();
        across.scale(0.125) + (v[1] * q[0].cos() + v[2]).square().scale(0.0625)
    }
    fn potential<S: Scalar>(&self, q: &[S; 3], _: S) -> S {
        q[0].cos().scale(0.5 * G)
    }
}

/// x″ + 0.3 x′ − x + x³ = 0.5 cos 1.2 t: damping as Rayleigh's function, the drive as a force.
#[derive(Clone, Debug)]
pub struct Duffing;

impl Lagrangian<1> for Duffing {
    fn kinetic<S: Scalar>(&self, _: &[S; 1], v: &[S; 1], _: S) -> S {
        v[0].square().scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 1], _: S) -> S {
        q[0].square().scale(-0.5) + q[0].square().square().scale(0.25)
    }
    fn rayleigh<S: Scalar>(&self, _: &[S; 1], v: &[S; 1], _: S) -> S {
        v[0].square().scale(0.15)
    }
    fn force<S: Scalar>(&self, _: &[S; 1], _: &[S; 1], t: S) -> [S; 1] {
        [t.scale(1.2).cos().scale(0.5)]
    }
}

/// x″ + ω² x = 0.
#[derive(Clone, Debug)]
pub struct Oscillator {
    pub frequency: f64,
}

impl Lagrangian<1> for Oscillator {
    fn kinetic<S: Scalar>(&self, _: &[S; 1], v: &[S; 1], _: S) -> S {
        v[0].square().scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 1], _: S) -> S {
        q[0].square().scale(0.5 * self.frequency * self.frequency)
    }
}

/// A reference trajectory.
pub struct Reference {
    pub samples: Vec<(f64, Vec<f64>, Vec<f64>)>,
    /// Error at the end per error at the start.
    pub growth: Option<f64>,
}

pub fn reference(name: &str) -> Reference {
    let path = format!("{}/tests/fixtures/{name}.json", env!("CARGO_MANIFEST_DIR"));
    let json: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let numbers = |value: &Value| -> Vec<f64> {
        value.as_array().unwrap().iter().map(|x| x.as_str().unwrap().parse().unwrap()).collect()
    };
    let samples = json["samples"].as_array().unwrap();
    let samples =
        samples.iter().map(|s| (s["t"].as_f64().unwrap(), numbers(&s["q"]), numbers(&s["qdot"]))).collect();
    Reference { samples, growth: json["perturbation_growth_to_T"].as_f64() }
}

impl Reference {
    /// The state at the start.
    pub fn start<const N: usize>(&self) -> Phase<[f64; N]> {
        let (t, q, v) = &self.samples[0];
        Phase::new(*t, q.clone().try_into().unwrap(), v.clone().try_into().unwrap())
    }

    /// The sample number `index`: time, and the state.
    pub fn at(&self, index: usize) -> (f64, Vec<f64>) {
        let (t, q, v) = &self.samples[index];
        (*t, q.iter().chain(v).copied().collect())
    }
}

/// The state after `steps` steps to time `end`.
pub fn run<S: System>(
    system: &S,
    integrator: &mut impl Integrator<S>,
    start: &Phase<S::Coordinates>,
    end: f64,
    steps: usize,
) -> Phase<S::Coordinates> {
    let mut phase = start.clone();
    let h = (end - start.time) / steps as f64;
    for _ in 0..steps {
        integrator.step(system, &mut phase, h).unwrap();
    }
    phase
}

/// The largest difference in q and v, relative to the largest entry of the reference of the same kind.
pub fn error<C: Coordinates>(phase: &Phase<C>, reference: &[f64]) -> f64 {
    let n = reference.len() / 2;
    let gap = |ours: &[f64], theirs: &[f64]| {
        let scale = theirs.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
        ours.iter().zip(theirs).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs())) / scale
    };
    gap(phase.q.as_ref(), &reference[..n]).max(gap(phase.v.as_ref(), &reference[n..]))
}

pub fn system<const N: usize, L: Lagrangian<N>>(lagrangian: L) -> EulerLagrange<L, N> {
    EulerLagrange::new(lagrangian)
}
