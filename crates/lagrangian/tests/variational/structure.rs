//! What the variational methods keep: the symplectic form, the arrow of time, momenta, quadratic invariants.

use crate::systems::{
    Duffing, HenonHeiles, Kepler, REGULAR, SphericalPendulum, SpringPendulum, Top, error, reference, run,
    system,
};
use lagrangian::integrator::{Bdf2, DiscreteEulerLagrange, GaussLegendre, Integrator};
use lagrangian::{
    EulerLagrange, Expansion, Lagrangian, Phase, SlicedEulerLagrange, SlicedLagrangian, System,
};
use mechanics_core::jet::Jet1;
use mechanics_core::scalar::Scalar;

type Boxed<L, const N: usize> = Box<dyn Integrator<EulerLagrange<L, N>>>;

fn methods<const N: usize, L: Lagrangian<N> + 'static>() -> Vec<fn() -> Boxed<L, N>> {
    vec![
        || Box::new(DiscreteEulerLagrange::midpoint()),
        || Box::new(DiscreteEulerLagrange::trapezoidal()),
        || Box::new(GaussLegendre::<2, _>::new()),
        || Box::new(GaussLegendre::<3, _>::new()),
        || Box::new(GaussLegendre::<4, _>::new()),
        || Box::new(GaussLegendre::<6, _>::new()),
    ]
}

fn momentum<const N: usize, S: System<Coordinates = [f64; N]>>(
    system: &S,
    phase: &Phase<[f64; N]>,
) -> [f64; N] {
    let mut at = Expansion::zeros(N);
    system.expand(phase.time, &phase.q, &phase.v, &mut at);
    at.momentum
}

/// v with ∂L/∂v(q, v) = p, for T of second degree in v.
fn velocity<const N: usize, S: System<Coordinates = [f64; N]>>(
    system: &S,
    q: &[f64; N],
    p: &[f64; N],
) -> [f64; N] {
    let mut at = Expansion::zeros(N);
    system.expand(0.0, q, &[0.0; N], &mut at);
    let mut v: [f64; N] = std::array::from_fn(|i| p[i] - at.momentum[i]);
    lagrangian::dense::solve_mass::<[f64; N]>(0.0, &mut at.mass, &mut v).unwrap();
    v
}

/// The largest entry of Jᵀ Ω J − Ω for one step's map (q, p) ↦ (q, p), J by fourth-order differences.
fn symplectic_defect<const N: usize, L: Lagrangian<N>>(
    system: &EulerLagrange<L, N>,
    integrator: fn() -> Boxed<L, N>,
    at: &Phase<[f64; N]>,
    h: f64,
) -> f64 {
    let p = momentum(system, at);
    let map = |shift: usize, by: f64| -> Vec<f64> {
        let (mut q, mut p) = (at.q, p);
        if shift < N {
            q[shift] += by
        } else {
            p[shift - N] += by
        }
        let mut phase = Phase::new(at.time, q, velocity(system, &q, &p));
        integrator().step(system, &mut phase, h).unwrap();
        phase.q.into_iter().chain(momentum(system, &phase)).collect()
    };
    let d = 1e-3;
    let columns: Vec<Vec<f64>> = (0..2 * N)
        .map(|j| {
            let values = [map(j, -2.0 * d), map(j, -d), map(j, d), map(j, 2.0 * d)];
            (0..2 * N)
                .map(|i| (values[0][i] - 8.0 * values[1][i] + 8.0 * values[2][i] - values[3][i]) / (12.0 * d))
                .collect()
        })
        .collect();
    let form = |a: &[f64], b: &[f64]| -> f64 { (0..N).map(|i| a[i] * b[N + i] - a[N + i] * b[i]).sum() };
    let mut worst = 0.0_f64;
    for i in 0..2 * N {
        for j in 0..2 * N {
            let exact = f64::from(u8::from(j == i + N)) - f64::from(u8::from(i == j + N));
            worst = worst.max((form(&columns[i], &columns[j]) - exact).abs());
        }
    }
    worst
}

/// Steps so large that the *solution* is wrong in its second digit: only structure keeps the form.
#[test]
fn one_step_keeps_the_symplectic_form() {
    fn check<const N: usize, L: Lagrangian<N> + 'static>(lagrangian: L, q: [f64; N], v: [f64; N], h: f64) {
        let system = system(lagrangian);
        for integrator in methods::<N, L>() {
            let defect = symplectic_defect(&system, integrator, &Phase::new(0.0, q, v), h);
            assert!(defect < 1e-8, "{}: {defect:e}", integrator().method().name);
        }
    }
    check(REGULAR, [1.0, -0.5], [1.0, 2.0], 0.1);
    check(SpringPendulum, [1.2, 0.8], [0.5, 1.5], 0.1);
    check(SphericalPendulum, [1.0, 0.0], [0.3, 2.0], 0.1);
    check(Kepler, [0.8, 0.1], [0.0, 1.1], 0.2);
    check(Top, [0.5, 0.1, 0.2], [0.3, 1.0, 10.0], 0.05);
}

/// Forwards, velocities turned round, forwards again: back at the start.
#[test]
fn steps_are_reversible() {
    for make in methods::<2, crate::systems::DoublePendulum>() {
        let system = system(REGULAR);
        let start = Phase::new(0.0, [1.0, -0.5], [1.0, 2.0]);
        let there = run(&system, &mut *make(), &start, 1.0, 20);
        let turned = Phase::new(0.0, there.q, there.v.map(|v| -v));
        let back = run(&system, &mut *make(), &turned, 1.0, 20);
        let gap = error(&back, &[1.0, -0.5, -1.0, -2.0]);
        assert!(gap < 2e-13, "{}: {gap:e}", make().method().name);
    }
}

/// Discrete Noether: the momentum of a coordinate that L does not mention is kept to rounding, with any step.
#[test]
fn momenta_of_cyclic_coordinates_are_kept() {
    for make in methods::<2, SphericalPendulum>() {
        let system = system(SphericalPendulum);
        let start = reference("spherical_pendulum").start::<2>();
        let end = run(&system, &mut *make(), &start, 100.0, 2000);
        let drift = (momentum(&system, &end)[1] / momentum(&system, &start)[1] - 1.0).abs();
        assert!(drift < 2e-15, "{}: {drift:e}", make().method().name);
    }
    for make in methods::<3, Top>() {
        let system = system(Top);
        let start = reference("top_nutating").start::<3>();
        let end = run(&system, &mut *make(), &start, 5.0, 500);
        let (p0, p1) = (momentum(&system, &start), momentum(&system, &end));
        for j in [1, 2] {
            let drift = (p1[j] / p0[j] - 1.0).abs();
            assert!(drift < 2e-15, "{}, p{j}: {drift:e}", make().method().name);
        }
    }
}

/// The trapezoidal rule on a separable Lagrangian is Störmer–Verlet, written out here.
#[test]
fn trapezoidal_is_verlet_where_t_is_separable() {
    let system = system(HenonHeiles);
    let start = reference("henon_heiles_regular").start::<2>();
    let (h, steps) = (0.1, 200);
    let ours = run(&system, &mut DiscreteEulerLagrange::trapezoidal(), &start, h * steps as f64, steps);
    let force = |[x, y]: [f64; 2]| [-x - 2.0 * x * y, -y - x * x + y * y];
    let (mut q, mut v) = (start.q, start.v);
    for _ in 0..steps {
        let kick = |v: &mut [f64; 2], q| (0..2).for_each(|i| v[i] += 0.5 * h * force(q)[i]);
        kick(&mut v, q);
        (0..2).for_each(|i| q[i] += h * v[i]);
        kick(&mut v, q);
    }
    assert!(error(&ours, &[q[0], q[1], v[0], v[1]]) < 1e-13, "{ours:?} {q:?} {v:?}");
}

/// p₀ = −D₁L_d − F_d⁻ and p₁ = D₂L_d + F_d⁺ with the discrete Lagrangian differentiated as one function of (q₀, q₁).
#[test]
fn steps_satisfy_the_discrete_euler_lagrange_equations() {
    let h = 0.1;
    let full = |q: [Jet1<f64, 4>; 2], v: [Jet1<f64, 4>; 2]| {
        let zero = Jet1::constant(0.0);
        REGULAR.kinetic(&q, &v, zero) - REGULAR.potential(&q, zero)
    };
    let start = Phase::new(0.0, [1.0, -0.5], [1.0, 2.0]);
    let system = system(REGULAR);
    for (mut integrator, trapezoidal) in
        [(DiscreteEulerLagrange::midpoint(), 0.0), (DiscreteEulerLagrange::trapezoidal(), 1.0)]
    {
        let mut end = start.clone();
        integrator.step(&system, &mut end, h).unwrap();
        let all = Jet1::<f64, 4>::variables([start.q[0], start.q[1], end.q[0], end.q[1]]);
        let (q0, q1) = ([all[0], all[1]], [all[2], all[3]]);
        let w: [_; 2] = std::array::from_fn(|i| (q1[i] - q0[i]).scale(1.0 / h));
        let middle: [_; 2] = std::array::from_fn(|i| (q0[i] + q1[i]).scale(0.5));
        let action = full(middle, w).scale(h * (1.0 - trapezoidal))
            + (full(q0, w) + full(q1, w)).scale(0.5 * h * trapezoidal);
        let (p0, p1) = (momentum(&system, &start), momentum(&system, &end));
        for i in 0..2 {
            assert!((p0[i] + action.gradient[i]).abs() < 4e-14, "D₁, {trapezoidal}");
            assert!((p1[i] - action.gradient[2 + i]).abs() < 4e-14, "D₂, {trapezoidal}");
        }
    }
}

/// A new integrator continues a motion as the old one does, but for rounding: history holds nothing else.
#[test]
fn history_changes_nothing_but_rounding() {
    fn check<const N: usize, L: Lagrangian<N> + Clone + 'static>(lagrangian: &L, start: &Phase<[f64; N]>) {
        for make in methods::<N, L>() {
            let system = system(lagrangian.clone());
            let whole = run(&system, &mut *make(), start, start.time + 1.0, 50);
            let mut phase = start.clone();
            for _ in 0..50 {
                make().step(&system, &mut phase, 0.02).unwrap();
            }
            let exact: Vec<f64> = whole.q.into_iter().chain(whole.v).collect();
            let gap = error(&phase, &exact);
            assert!(gap < 2e-13, "{}: {gap:e}", make().method().name);
        }
    }
    check(&REGULAR, &reference("double_pendulum_regular").start());
    check(&Duffing, &reference("duffing").start());
}

/// Changing steps: the start values are extrapolated by another ratio, and the answer is that of fresh integrators.
#[test]
fn steps_may_change() {
    for make in methods::<2, SpringPendulum>() {
        let system = system(SpringPendulum);
        let start = reference("spring_pendulum").start::<2>();
        let (mut kept, mut integrator, mut fresh) = (start.clone(), make(), start);
        for k in 0..60 {
            let h = [0.01, 0.012, 0.005, 0.03][k % 4];
            integrator.step(&system, &mut kept, h).unwrap();
            make().step(&system, &mut fresh, h).unwrap();
        }
        let exact: Vec<f64> = fresh.q.into_iter().chain(fresh.v).collect();
        assert!(error(&kept, &exact) < 2e-13);
    }
}

/// Hénon–Heiles with its size known at run time.
#[derive(Clone, Debug)]
struct Sliced;

impl SlicedLagrangian for Sliced {
    fn dimension(&self) -> usize {
        2
    }
    fn kinetic<S: Scalar>(&self, q: &[S], v: &[S], t: S) -> S {
        HenonHeiles.kinetic(&[q[0], q[1]], &[v[0], v[1]], t)
    }
    fn potential<S: Scalar>(&self, q: &[S], t: S) -> S {
        HenonHeiles.potential(&[q[0], q[1]], t)
    }
}

#[test]
fn sizes_known_at_run_time_move_the_same_way() {
    let start = reference("henon_heiles_regular").start::<2>();
    let sliced_start = Phase::new(0.0, start.q.to_vec(), start.v.to_vec());
    let sliced = SlicedEulerLagrange::new(Sliced);
    let check = |ours: Phase<Vec<f64>>, theirs: Phase<[f64; 2]>| {
        let exact: Vec<f64> = theirs.q.into_iter().chain(theirs.v).collect();
        assert!(error(&ours, &exact) < 1e-14, "{ours:?} {theirs:?}");
    };
    let fixed = system(HenonHeiles);
    check(
        run(&sliced, &mut GaussLegendre::<3, _>::new(), &sliced_start, 5.0, 25),
        run(&fixed, &mut GaussLegendre::<3, _>::new(), &start, 5.0, 25),
    );
    check(
        run(&sliced, &mut DiscreteEulerLagrange::trapezoidal(), &sliced_start, 5.0, 25),
        run(&fixed, &mut DiscreteEulerLagrange::trapezoidal(), &start, 5.0, 25),
    );
    check(
        run(&sliced, &mut Bdf2::new(), &sliced_start, 5.0, 25),
        run(&fixed, &mut Bdf2::new(), &start, 5.0, 25),
    );
}
