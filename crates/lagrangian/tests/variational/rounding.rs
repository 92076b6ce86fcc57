//! Where a solution, or a part of it, is as small as rounding: iterations must know, and neither give up nor be content
//! with what is not solved.

use lagrangian::integrator::{Bdf2, DiscreteEulerLagrange, GaussLegendre, ImplicitEuler, Integrator};
use lagrangian::{EulerLagrange, Lagrangian, Phase};
use mechanics_core::scalar::Scalar;

/// T = Σ v²/2, V = Σ k (q − c)²/2.
#[derive(Clone, Debug)]
struct Springs<const N: usize> {
    stiffness: [f64; N],
    centre: f64,
}

impl<const N: usize> Lagrangian<N> for Springs<N> {
    fn kinetic<S: Scalar>(&self, _: &[S; N], v: &[S; N], _: S) -> S {
        v.iter().fold(S::constant(0.0), |sum, v| sum + v.square().scale(0.5))
    }
    fn potential<S: Scalar>(&self, q: &[S; N], _: S) -> S {
        let energy = |(q, k): (&S, f64)| q.offset(-self.centre).square().scale(0.5 * k);
        q.iter().zip(self.stiffness).map(energy).fold(S::constant(0.0), |sum, energy| sum + energy)
    }
}

type Boxed<const N: usize> = Box<dyn Integrator<EulerLagrange<Springs<N>, N>>>;

/// A damped motion comes to rest at a point that is not the origin: its velocity there is far below the rounding of its
/// position, and its energy differs from the next state's by nothing.
#[test]
fn motion_dies_out_anywhere() {
    for (centre, h) in [1.0, 1e4, -1e8].into_iter().flat_map(|c| [0.75, 1.0, 1.5, 2.0].map(|h| (c, h))) {
        let system = EulerLagrange::new(Springs { stiffness: [1.0], centre });
        for (q, v) in [(0.0, 0.0), (0.0, 1.0), (-1.0, 1.0), (centre + 1.0, 0.0)] {
            for mut integrator in [Box::new(ImplicitEuler::new()) as Boxed<1>, Box::new(Bdf2::new())] {
                let mut phase = Phase::new(0.0, [q], [v]);
                for _ in 0..3000 {
                    integrator.step(&system, &mut phase, h).unwrap();
                }
                let rest = [(phase.q[0] - centre) / centre, phase.v[0] / centre];
                assert!(rest[0].abs() < 1e-15 && rest[1].abs() < 1e-15, "{centre}, {h}: {rest:?}");
            }
        }
    }
}

/// Towards the origin it can go on until its energy underflows, and then its coordinates.
#[test]
fn motion_dies_out_below_the_smallest_energy() {
    for h in [2.0, 10.0] {
        let system = EulerLagrange::new(Springs { stiffness: [1.0], centre: 0.0 });
        for mut integrator in [Box::new(ImplicitEuler::new()) as Boxed<1>, Box::new(Bdf2::new())] {
            let mut phase = Phase::new(0.0, [1e-150], [0.0]);
            for _ in 0..3000 {
                integrator.step(&system, &mut phase, h).unwrap();
            }
            assert!(phase.q[0].abs() < 1e-300 && phase.v[0].abs() < 1e-300, "{phase:?}");
        }
    }
}

/// A stiff oscillation of an amplitude far below that of another coordinate is solved for like any other: an iteration
/// that diverges in it must not pass for one that has arrived at the rounding of the other.
#[test]
fn a_stiff_oscillation_stays_small() {
    let h = 0.01;
    let make: [fn() -> Boxed<2>; 5] = [
        || Box::new(DiscreteEulerLagrange::midpoint()),
        || Box::new(GaussLegendre::<2, _>::new()),
        || Box::new(GaussLegendre::<3, _>::new()),
        || Box::new(GaussLegendre::<4, _>::new()),
        || Box::new(GaussLegendre::<6, _>::new()),
    ];
    for (amplitude, wh) in
        [1e-3, 1e-10, 1e-13, 1e-20].into_iter().flat_map(|a| [1.5, 3.0, 10.0].map(|w| (a, w)))
    {
        let stiffness = (wh / h) * (wh / h);
        let system = EulerLagrange::new(Springs { stiffness: [1.0, stiffness], centre: 0.0 });
        for make in make {
            let (mut integrator, mut phase) = (make(), Phase::new(0.0, [1.0, amplitude], [0.0, 0.0]));
            for _ in 0..1000 {
                integrator.step(&system, &mut phase, h).unwrap();
                let energy = phase.v[1] * phase.v[1] + stiffness * phase.q[1] * phase.q[1];
                // Gauss–Legendre keeps this quadratic invariant.
                let gap = (energy / (stiffness * amplitude * amplitude) - 1.0).abs();
                let name = integrator.method().name;
                assert!(gap < 1e-10, "{name}, amplitude {amplitude:e}, hω = {wh}: {gap:e}");
            }
        }
    }
}

/// T couples a coordinate that does not move to two that do, and is not quadratic.
#[derive(Clone, Debug)]
struct Still;

impl Lagrangian<3> for Still {
    fn kinetic<S: Scalar>(&self, _: &[S; 3], v: &[S; 3], _: S) -> S {
        let square = |x: S| x.square().scale(0.5);
        let sum = v.iter().fold(S::constant(0.0), |sum, v| sum + v.square());
        square(v[0] + v[1]) + square(v[1] - v[2]) + square(v[0] - v[2].scale(0.3))
            - (S::constant(1.0) - sum.scale(1e-3)).sqrt()
    }
    fn potential<S: Scalar>(&self, q: &[S; 3], _: S) -> S {
        (q[0] - q[2]).square()
    }
}

/// A velocity that is nothing but rounding never settles relative to itself: it must not cost iterations up to a limit.
#[test]
fn a_coordinate_at_rest_costs_nothing() {
    let system = EulerLagrange::new(Still);
    let (mut gauss, mut phase) = (GaussLegendre::<4, _>::new(), Phase::new(0.0, [0.0; 3], [1.0, 0.0, 1.0]));
    let mut evaluations = 0;
    for _ in 0..100 {
        evaluations += gauss.step(&system, &mut phase, 0.01).unwrap().evaluations;
    }
    assert!(evaluations < 3000, "{evaluations}");
    assert!(phase.v[1].abs() < 1e-14);
}
