//! What Störmer–Verlet keeps.

use crate::systems::{HenonHeiles, Kepler, Pendulum, SpringChain, of};
use lagrangian::integrator::{Integrator, StormerVerlet, drive};
use lagrangian::{Phase, System};
use std::ops::ControlFlow;

/// ∂(q', p')/∂(q, p) of one step by central differences of fourth order. M is constant, so p = M v needs M only.
fn jacobian<const N: usize, S: System<Coordinates = [f64; N]>>(
    system: &S,
    mass: [[f64; N]; N],
    phase: &Phase<[f64; N]>,
    h: f64,
) -> Vec<Vec<f64>> {
    let momenta =
        |v: &[f64; N]| -> [f64; N] { std::array::from_fn(|i| (0..N).map(|j| mass[i][j] * v[j]).sum()) };
    // The velocity for a momentum, by Gauss–Seidel: these masses are diagonally dominant.
    let velocities = |p: &[f64; N]| {
        let mut v = [0.0; N];
        for _ in 0..200 {
            for i in 0..N {
                let others: f64 = (0..N).filter(|&j| j != i).map(|j| mass[i][j] * v[j]).sum();
                v[i] = (p[i] - others) / mass[i][i];
            }
        }
        v
    };
    let image = |x: &[f64]| -> Vec<f64> {
        let q: [f64; N] = std::array::from_fn(|i| x[i]);
        let p: [f64; N] = std::array::from_fn(|i| x[N + i]);
        let mut phase = Phase::new(phase.time, q, velocities(&p));
        StormerVerlet::new(system).step(system, &mut phase, h).unwrap();
        phase.q.iter().copied().chain(momenta(&phase.v)).collect()
    };
    let base: Vec<f64> = phase.q.iter().copied().chain(momenta(&phase.v)).collect();
    let little = 1e-3;
    (0..2 * N)
        .map(|k| {
            let at = |shift: f64| {
                let mut x = base.clone();
                x[k] += shift;
                image(&x)
            };
            let (near, far) = ((at(little), at(-little)), (at(2.0 * little), at(-2.0 * little)));
            (0..2 * N)
                .map(|i| (8.0 * (near.0[i] - near.1[i]) - (far.0[i] - far.1[i])) / (12.0 * little))
                .collect()
        })
        .collect()
}

/// The largest entry of JᵀΩJ − Ω; `columns[k]` is the k-th column of J.
fn defect(columns: &[Vec<f64>]) -> f64 {
    let n = columns.len() / 2;
    let form = |a: &[f64], b: &[f64]| -> f64 { (0..n).map(|i| a[i] * b[n + i] - a[n + i] * b[i]).sum() };
    let mut worst = 0.0_f64;
    for (k, a) in columns.iter().enumerate() {
        for (l, b) in columns.iter().enumerate() {
            let exact = if l == k + n {
                1.0
            } else if k == l + n {
                -1.0
            } else {
                0.0
            };
            worst = worst.max((form(a, b) - exact).abs());
        }
    }
    worst
}

#[test]
fn a_step_is_symplectic() {
    let unit = [[1.0, 0.0], [0.0, 1.0]];
    let of_kepler = jacobian(&of(Kepler), unit, &Phase::new(0.0, [0.8, 0.3], [0.2, 1.1]), 0.2);
    assert!(defect(&of_kepler) < 1e-9, "{:e}", defect(&of_kepler));
    let of_henon = jacobian(&of(HenonHeiles), unit, &Phase::new(0.0, [0.2, 0.1], [0.3, -0.2]), 0.5);
    assert!(defect(&of_henon) < 1e-11, "{:e}", defect(&of_henon));
    let mass = [[2.0, 0.0, 0.4], [0.0, 0.5, 0.0], [0.4, 0.0, 3.0]];
    let start = Phase::new(0.0, [0.5, -0.2, 0.1], [0.0, 1.0, -0.3]);
    let of_chain = jacobian(&of(SpringChain), mass, &start, 0.3);
    assert!(defect(&of_chain) < 1e-10, "{:e}", defect(&of_chain));
    // The steps above are far from the identity, so this is no accident of small h.
    assert!((of_chain[0][0] - 1.0).abs() > 0.1);
}

#[test]
fn motion_reversed_returns() {
    let there_and_back = |steps: u64| {
        let system = of(Pendulum);
        let mut phase = Phase::new(0.0, [2.5], [0.3]);
        let go = |phase: &mut Phase<[f64; 1]>| {
            drive::advance(&system, &mut StormerVerlet::new(&system), phase, 0.02, steps, |_, _| {
                ControlFlow::Continue(())
            })
            .unwrap();
        };
        go(&mut phase);
        phase.v[0] = -phase.v[0];
        go(&mut phase);
        (phase.q[0] - 2.5).abs().max((phase.v[0] + 0.3).abs())
    };
    // Rounding, times the growth of a disturbance, which is linear for a pendulum.
    assert!(there_and_back(10) < 2e-15, "{:e}", there_and_back(10));
    assert!(there_and_back(5000) < 2e-12, "{:e}", there_and_back(5000));
}

#[test]
fn angular_momentum_is_kept() {
    let system = of(Kepler);
    let mut phase = Phase::new(0.0, [0.4, 0.0], [0.0, 2.0]);
    let moment = |phase: &Phase<[f64; 2]>| phase.q[0] * phase.v[1] - phase.q[1] * phase.v[0];
    let (start, mut worst) = (moment(&phase), 0.0_f64);
    drive::advance(&system, &mut StormerVerlet::new(&system), &mut phase, 0.01, 200_000, |phase, _| {
        worst = worst.max((moment(phase) - start).abs());
        ControlFlow::Continue(())
    })
    .unwrap();
    assert!(worst < 1e-13, "{worst:e}");
}
