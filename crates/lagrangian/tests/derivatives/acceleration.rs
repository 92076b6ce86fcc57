//! Accelerations against high-precision trajectories, and refusals.

use crate::agreement::assert_close;
use crate::systems::{AsSliced, DoublePendulum, GRAVITY, NFold};
use lagrangian::error::Symbol;
use lagrangian::{EulerLagrange, Expansion, Lagrangian, LagrangianError, SlicedEulerLagrange, System};
use mechanics_core::scalar::Scalar;
use serde_json::Value;

fn fixture(name: &str) -> Value {
    let path = format!("{}/tests/fixtures/{name}.json", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| value.as_str().unwrap().parse().unwrap())
}

fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    std::array::from_fn(|i| number(&value[i]))
}

/// q̈ and the energy at every sample; q̈ relative to the largest term that the sample's forces are sums of.
fn check<const N: usize>(name: &str, lagrangian: impl Lagrangian<N> + Copy, tolerance: f64) {
    let fixed = EulerLagrange::new(lagrangian);
    let sliced = SlicedEulerLagrange::new(AsSliced::<_, N>(lagrangian));
    let samples = fixture(name)["samples"].as_array().unwrap().clone();
    assert!(samples.len() > 20);
    for sample in samples {
        let t = number(&sample["t"]);
        let (q, v) = (numbers::<N>(&sample["q"]), numbers::<N>(&sample["qdot"]));
        let (mut acceleration, mut of_sliced) = ([0.0; N], vec![0.0; N]);
        fixed.acceleration(t, &q, &v, &mut acceleration).unwrap();
        sliced.acceleration(t, &q.to_vec(), &v.to_vec(), &mut of_sliced).unwrap();
        let what = format!("{name} at {t}");
        assert_close(&acceleration, &numbers::<N>(&sample["qddot"]), tolerance, &what);
        assert_close(&of_sliced, &acceleration, 1e-14, &what);
        let energy = number(&sample["energy"]);
        let error = (fixed.energy(t, &q, &v) - energy).abs() / energy.abs().max(1.0);
        assert!(error <= 1e-14, "{what}: energy off by {error:e}");
    }
}

#[test]
fn the_double_pendulum_accelerates_as_in_32_digits() {
    check::<2>("double_pendulum_regular", DoublePendulum { mass: [2.0, 1.0], length: [1.0, 0.5] }, 1e-13);
}

#[test]
fn the_triple_pendulum_accelerates_as_in_32_digits() {
    check::<3>("triple_pendulum", NFold, 1e-13);
}

/// The systems of the other fixtures.
#[derive(Clone, Copy, Debug)]
enum One {
    Parabola,
    Duffing,
}

impl Lagrangian<1> for One {
    fn kinetic<S: Scalar>(&self, q: &[S; 1], v: &[S; 1], _t: S) -> S {
        match self {
            Self::Parabola => (v[0].square() * q[0].square().offset(1.0)).scale(0.5),
            Self::Duffing => v[0].square().scale(0.5),
        }
    }
    fn potential<S: Scalar>(&self, q: &[S; 1], _t: S) -> S {
        let square = q[0].square();
        match self {
            Self::Parabola => square.scale(0.5 * GRAVITY),
            Self::Duffing => square.square().scale(0.25) - square.scale(0.5),
        }
    }
    fn rayleigh<S: Scalar>(&self, _q: &[S; 1], v: &[S; 1], _t: S) -> S {
        match self {
            Self::Parabola => S::constant(0.0),
            Self::Duffing => v[0].square().scale(0.15),
        }
    }
    fn force<S: Scalar>(&self, _q: &[S; 1], _v: &[S; 1], t: S) -> [S; 1] {
        match self {
            Self::Parabola => [S::constant(0.0)],
            Self::Duffing => [t.scale(1.2).cos().scale(0.5)],
        }
    }
}

#[derive(Clone, Copy, Debug)]
enum Two {
    Spherical,
    Spring,
    Kepler,
}

impl Lagrangian<2> for Two {
    fn kinetic<S: Scalar>(&self, q: &[S; 2], v: &[S; 2], _t: S) -> S {
        let twice = match self {
            Self::Spherical => v[0].square() + (v[1] * q[0].sin()).square(),
            Self::Spring => v[0].square() + (v[1] * q[0]).square(),
            Self::Kepler => v[0].square() + v[1].square(),
        };
        twice.scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 2], _t: S) -> S {
        match self {
            Self::Spherical => q[0].cos().scale(-GRAVITY),
            Self::Spring => q[0].offset(-1.0).square().scale(20.0) - (q[0] * q[1].cos()).scale(GRAVITY),
            Self::Kepler => -(q[0].square() + q[1].square()).sqrt().recip(),
        }
    }
}

/// Lagrange's top, angles (θ, φ, ψ) with θ from the upward vertical.
#[derive(Clone, Copy, Debug)]
struct Top;

impl Lagrangian<3> for Top {
    fn kinetic<S: Scalar>(&self, q: &[S; 3], v: &[S; 3], _t: S) -> S {
        let (sine, cosine) = (q[0].sin(), q[0].cos());
        let across = v[0].square() + (v[1] * sine).square();
        across.scale(0.125) + (v[2] + v[1] * cosine).square().scale(0.0625)
    }
    fn potential<S: Scalar>(&self, q: &[S; 3], _t: S) -> S {
        q[0].cos().scale(0.5 * GRAVITY)
    }
}

#[test]
fn one_coordinate_accelerates_as_in_32_digits() {
    check::<1>("bead_parabola", One::Parabola, 1e-13);
    check::<1>("duffing", One::Duffing, 1e-13);
}

#[test]
fn two_and_three_coordinates_accelerate_as_in_32_digits() {
    check::<2>("spherical_pendulum", Two::Spherical, 1e-13);
    check::<2>("spring_pendulum", Two::Spring, 1e-13);
    check::<2>("kepler_e09", Two::Kepler, 1e-13);
    check::<3>("top_nutating", Top, 1e-13);
}

fn refusal<const N: usize>(l: impl Lagrangian<N> + Copy, q: [f64; N], v: [f64; N]) -> LagrangianError {
    let refused = EulerLagrange::new(l).acceleration(0.5, &q, &v, &mut [0.0; N]).unwrap_err();
    let sliced = SlicedEulerLagrange::new(AsSliced::<_, N>(l));
    let again = sliced.acceleration(0.5, &q.to_vec(), &v.to_vec(), &mut vec![0.0; N]).unwrap_err();
    assert_eq!(format!("{refused:?}"), format!("{again:?}"));
    refused
}

#[track_caller]
fn assert_null_direction<const N: usize>(refused: LagrangianError, expected: [f64; N]) {
    let LagrangianError::SingularMass { null_direction, time, .. } = refused else {
        panic!("{refused:?}");
    };
    assert_eq!(time, 0.5);
    let sign = null_direction.iter().zip(expected).map(|(x, y)| x * y).sum::<f64>().signum();
    assert_close(&null_direction.iter().map(|x| sign * x).collect::<Vec<_>>(), &expected, 1e-12, "direction");
}

/// T = ½ Σ mᵢ (aᵢ · v)²: any mass matrix.
#[derive(Clone, Copy, Debug)]
struct Squares<const N: usize, const K: usize> {
    mass: [f64; K],
    along: [[f64; N]; K],
}

impl<const N: usize, const K: usize> Lagrangian<N> for Squares<N, K> {
    fn kinetic<S: Scalar>(&self, _q: &[S; N], v: &[S; N], _t: S) -> S {
        let mut sum = S::constant(0.0);
        for (mass, along) in self.mass.iter().zip(&self.along) {
            let speed = (0..N).fold(S::constant(0.0), |sum, i| sum + v[i].scale(along[i]));
            sum += speed.square().scale(0.5 * mass);
        }
        sum
    }
    fn potential<S: Scalar>(&self, q: &[S; N], _t: S) -> S {
        q.iter().fold(S::constant(0.0), |sum, q| sum + q.square())
    }
}

#[test]
fn a_singular_mass_matrix_is_refused_with_its_null_direction() {
    // The lower bob without mass.
    let pendulum = DoublePendulum { mass: [1.0, 0.0], length: [1.0, 1.0] };
    assert_null_direction(refusal(pendulum, [0.3, 0.4], [1.0, 2.0]), [0.0, 1.0]);
    // A coordinate that T does not mention.
    let massless = Squares { mass: [1.0, 3.0], along: [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]] };
    assert_null_direction(refusal(massless, [0.1; 3], [0.2; 3]), [0.0, 1.0, 0.0]);
    // T of rank one: nothing moves along the difference.
    let half = 0.5f64.sqrt();
    let rank_one = Squares { mass: [2.0], along: [[0.3, 0.3]] };
    assert_null_direction(refusal(rank_one, [0.1; 2], [0.2; 2]), [half, -half]);
    // Rank two of three, null along (1, −2, 1), over twelve decades of units.
    let root = 6.0f64.sqrt();
    for mass in [1e-12, 1.0, 1e12] {
        let plane = Squares { mass: [mass, mass], along: [[1.0, 1.0, 1.0], [1.0, 0.0, -1.0]] };
        assert_null_direction(refusal(plane, [0.1; 3], [0.2; 3]), [1.0 / root, -2.0 / root, 1.0 / root]);
    }
    // A negative mass: not singular, and not a mechanical system either.
    let negative = Squares { mass: [1.0, -2.0], along: [[1.0, 0.0], [0.0, 1.0]] };
    assert_null_direction(refusal(negative, [0.1; 2], [0.2; 2]), [0.0, 1.0]);
}

#[test]
fn a_regular_but_ill_conditioned_mass_matrix_is_solved() {
    // Masses of 1e-9 and 1e9 beside each other, and a needle of 1e8 across.
    let unequal = Squares { mass: [1e-9, 1e9], along: [[1.0, 0.0], [0.0, 1.0]] };
    let mut acceleration = [0.0; 2];
    EulerLagrange::new(unequal).acceleration(0.0, &[1.0, 1.0], &[0.0; 2], &mut acceleration).unwrap();
    assert_eq!(acceleration, [-2.0 / 1e-9, -2.0 / 1e9]);
    let needle = Squares { mass: [1e8, 1.0], along: [[1.0, 1.0], [1.0, -1.0]] };
    EulerLagrange::new(needle).acceleration(0.0, &[1.0, -1.0], &[0.0; 2], &mut acceleration).unwrap();
    // Along (1, −1) the mass is 2 · 1 a unit of q₀, the force −2: q̈ = (−1, 1). Conditioning costs eight digits.
    assert_close(&acceleration, &[-1.0, 1.0], 1e-7, "needle");
}

/// Lagrangians of which one derivative is not finite at q = 0, v = 0.
#[derive(Clone, Copy, Debug)]
enum Broken {
    Mass,
    Slope,
    Force,
    Rate,
    Overflow,
}

impl Lagrangian<2> for Broken {
    fn kinetic<S: Scalar>(&self, _q: &[S; 2], v: &[S; 2], t: S) -> S {
        let plain = (v[0].square() + v[1].square()).scale(0.5);
        match self {
            Self::Mass => plain + v[1].abs().powf(1.5),
            Self::Rate => plain + v[1] * t.offset(-2.0).scale(1e308).scale(10.0),
            Self::Overflow => plain.scale(1e-300),
            _ => plain,
        }
    }
    fn potential<S: Scalar>(&self, q: &[S; 2], _t: S) -> S {
        match self {
            Self::Slope => q[1].ln(),
            Self::Overflow => q[0].scale(1e300),
            _ => q[0].square(),
        }
    }
    fn force<S: Scalar>(&self, q: &[S; 2], _v: &[S; 2], _t: S) -> [S; 2] {
        match self {
            Self::Force => [q[0].recip(), S::constant(0.0)],
            _ => [S::constant(0.0); 2],
        }
    }
}

#[test]
fn a_derivative_that_is_not_finite_is_named() {
    for (broken, expected, position) in [
        (Broken::Mass, Symbol::Mass, 3),
        (Broken::Slope, Symbol::Slope, 1),
        (Broken::Force, Symbol::Force, 0),
        (Broken::Rate, Symbol::MomentumRate, 1),
        (Broken::Overflow, Symbol::Acceleration, 0),
    ] {
        let refused = EulerLagrange::new(broken).acceleration(2.0, &[0.0; 2], &[0.0, 0.0], &mut [0.0; 2]);
        match refused.unwrap_err() {
            LagrangianError::NonFinite { symbol, index, time, .. } => {
                assert_eq!((symbol, index, time), (expected, position, 2.0), "{broken:?}");
            }
            other => panic!("{broken:?}: {other:?}"),
        }
    }
    // A state that is not finite itself.
    let pendulum = DoublePendulum { mass: [1.0; 2], length: [1.0; 2] };
    for (q, v) in
        [([f64::NAN, 0.0], [0.0; 2]), ([0.0; 2], [f64::INFINITY, 1.0]), ([f64::INFINITY, 0.0], [0.0; 2])]
    {
        let refused = refusal(pendulum, q, v);
        assert!(matches!(refused, LagrangianError::NonFinite { .. }), "{refused:?}");
    }
}

/// T = ½ v₀² + ½ v₁² (1 + √q₁): the root has an infinite slope at zero, but T's mass is finite there.
#[derive(Clone, Copy, Debug)]
struct RootOfCoordinate;

impl Lagrangian<2> for RootOfCoordinate {
    fn kinetic<S: Scalar>(&self, q: &[S; 2], v: &[S; 2], _t: S) -> S {
        (v[0].square() + v[1].square() * q[1].sqrt().offset(1.0)).scale(0.5)
    }
    fn potential<S: Scalar>(&self, _q: &[S; 2], _t: S) -> S {
        S::constant(0.0)
    }
}

#[test]
fn a_singular_slope_in_a_coordinate_spoils_no_derivative_in_velocities() {
    let mut at = Expansion::zeros(2);
    EulerLagrange::new(RootOfCoordinate).expand(0.0, &[0.0; 2], &[1.0, 2.0], &mut at);
    assert_eq!((at.mass, at.momentum), ([[1.0, 0.0], [0.0, 1.0]], [1.0, 2.0]));
    assert_eq!(at.momentum_rate[1], f64::INFINITY);
    assert_eq!(at.slope[1], f64::INFINITY);
}

/// A charged relativistic particle in a plane: T = −√(1 − v²) + v·A(q), units with c = m = 1.
#[derive(Clone, Copy, Debug)]
struct Relativistic;

impl Lagrangian<2> for Relativistic {
    fn kinetic<S: Scalar>(&self, q: &[S; 2], v: &[S; 2], _t: S) -> S {
        let lorentz = (S::constant(1.0) - v[0].square() - v[1].square()).sqrt();
        (v[1] * q[0] - v[0] * q[1]).scale(0.5) - lorentz
    }
    fn potential<S: Scalar>(&self, q: &[S; 2], _t: S) -> S {
        q[0]
    }
}

#[test]
fn a_kinetic_energy_that_is_not_quadratic_has_its_own_mass_and_energy() {
    let system = EulerLagrange::new(Relativistic);
    let (q, v) = ([0.3, -0.8], [0.6, 0.5]);
    let gamma = 1.0 / (1.0f64 - 0.61).sqrt();
    // Jacobi's integral is γ + V, and not T + V.
    assert!((system.energy(0.0, &q, &v) - (gamma + 0.3)).abs() < 1e-15);
    // d(γ v)/dt = F with F = E + v × B, E = (−1, 0), B = 1: a = (F − v (v·F)) / γ.
    let force = [v[1] - 1.0, -v[0]];
    let power = v[0] * force[0] + v[1] * force[1];
    let expected = [(force[0] - v[0] * power) / gamma, (force[1] - v[1] * power) / gamma];
    let mut acceleration = [0.0; 2];
    system.acceleration(0.0, &q, &v, &mut acceleration).unwrap();
    assert_close(&acceleration, &expected, 1e-14, "Lorentz force");
    // Faster than light there is no number to give.
    let faster = system.acceleration(0.0, &q, &[0.9, 0.9], &mut acceleration).unwrap_err();
    assert!(matches!(faster, LagrangianError::NonFinite { symbol: Symbol::Mass, .. }));
}
