//! Free motion.

use crate::block::{Block, DENSITY, SPACING, TRANSFERS, lame};
use mechanics_core::parallel::with_threads;
use mpm_constitutive::elastic::{Linear, NeoHookean};
use mpm_constitutive::fluid::{Tait, Tension};
use mpm_constitutive::plastic::{VonMises, YieldStress};
use mpm_constitutive::{PointLaw, Viscosity, Viscous};
use mpm_core::{ImplicitStep, Samples, Simulation, SimulationOptions, Totals};

fn exact() -> ImplicitStep {
    ImplicitStep { tolerance: 1e-9, ..ImplicitStep::default() }
}

#[test]
fn a_body_falls_as_a_point_does() {
    for transfer in TRANSFERS {
        let block = Block::<2>::new([3, 2], SPACING);
        let mut simulation = block.rubber(transfer, |_| [0.7, 0.3]);
        simulation.set_gravity([0.0, -9.81]).unwrap();
        let h = 0.05;
        for _ in 0..4 {
            let report = simulation.step_implicitly(h, &ImplicitStep::default()).unwrap();
            assert_eq!(report.iterations, 0, "{transfer:?}");
        }
        for (x, start) in simulation.positions(0).iter().zip(&block.positions) {
            // Symplectic Euler: h² g (1 + 2 + 3 + 4).
            let fallen = 4.0 * h * 0.3 - 9.81 * h * h * 10.0;
            assert!((x[1] - start[1] - fallen).abs() < 1e-12, "{transfer:?} {}", x[1] - start[1] - fallen);
        }
    }
}

#[test]
fn momentum_is_kept_in_steps_twenty_times_the_explicit_ones() {
    for transfer in TRANSFERS {
        let block = Block::<2>::new([5, 5], SPACING);
        let mut simulation = block.rubber(transfer, |x| [1.0 - 4.0 * x[1], 4.0 * x[0] + 2.0 * x[1]]);
        let before = simulation.totals(0);
        let h = 20.0 * simulation.stable_step();
        let (mut products, mut iterations) = (0, 0);
        for _ in 0..10 {
            let report = simulation.step_implicitly(h, &exact()).unwrap();
            products += report.products;
            iterations += report.iterations;
        }
        let after = simulation.totals(0);
        let lost = (after.momentum - before.momentum).norm() / before.momentum.norm();
        let turned =
            (after.angular_momentum - before.angular_momentum).norm() / before.angular_momentum.norm();
        println!("{transfer:?}: {iterations} iterations, {products} products, p {lost:.1e}, L {turned:.1e}");
        // What Newton leaves.
        assert!(lost < 1e-7, "{transfer:?}: momentum changed by {lost:e}");
        let energy = |t: &Totals| t.kinetic_energy + t.affine_energy + t.stored_energy;
        assert!(energy(&after) < energy(&before), "{transfer:?}: {} {}", energy(&before), energy(&after));
    }
}

/// A particle alone under MLS sees affine velocities only, so the nodes' minimum is that of one number: with V₀ ψ = ½ V₀ E (F − 1)² along an
/// axis and the affine inertia m D, D = Δx²/4, m D (c′ − c) = −h V₀ E (F′ − 1) F, F′ = (1 + h c′) F. Small amplitudes then fall by
/// 1/√(1 + h²ω²) a step, ω² = E/(ρ D).
#[test]
fn a_particle_alone_is_an_oscillator_in_backward_euler() {
    let (young, spacing) = (1e5, SPACING);
    let mut simulation = Simulation::<f64, 2>::new(SimulationOptions::new(spacing)).unwrap();
    let samples =
        Samples { positions: &[[0.512, 0.283]], velocities: &[[0.0; 2]], volumes: &[0.2 * spacing.powi(2)] };
    simulation.add_body(Linear::new(lame(young, 0.0)), DENSITY, samples).unwrap();
    let mut c = 1e-3;
    simulation.set_velocity_gradients(0, &[[[c, 0.0], [0.0, 0.0]]]).unwrap();
    let kappa = 4.0 * young / (DENSITY * spacing * spacing);
    let h = 30.0 * simulation.stable_step();
    let (mut f, start): (f64, f64) = (1.0, c);
    let steps = 4;
    for _ in 0..steps {
        simulation.step_implicitly(h, &ImplicitStep { tolerance: 1e-7, ..exact() }).unwrap();
        c = (c - h * kappa * (f - 1.0) * f) / (1.0 + h * h * kappa * f * f);
        f *= 1.0 + h * c;
        let found = simulation.velocity_gradients(0)[0][0][0];
        assert!((found - c).abs() < 1e-6 * start, "{found} {c}");
        assert!((simulation.states(0)[0].volume_ratio - f).abs() < 1e-9);
    }
    let amplitude = (c * c + kappa * (f - 1.0) * (f - 1.0)).sqrt() / start;
    let expected = (1.0 + h * h * kappa).powf(-0.5 * f64::from(steps));
    println!("hω = {:.1}, amplitude {amplitude:.6e}, closed form {expected:.6e}", h * kappa.sqrt());
    assert!((amplitude / expected - 1.0).abs() < 1e-3);
}

/// RMS differences of places from those of as many explicit steps, which filter velocities as often, for steps h, h/2, h/4.
fn differences<L: PointLaw + Copy + 'static>(law: L) -> [f64; 3] {
    let block = Block::<2>::new([4, 3], SPACING);
    let options = SimulationOptions::new(SPACING);
    let moving = |x: &[f64; 2]| [2.0 * (x[0] - 0.2) - 1.0 * x[1], -1.5 * (x[1] - 0.15)];
    let duration = 0.02;
    [16, 32, 64].map(|steps| {
        let (mut simulation, mut explicit) =
            (block.simulation(options, law, moving), block.simulation(options, law, moving));
        for _ in 0..steps {
            simulation.step_implicitly(duration / f64::from(steps), &exact()).unwrap();
            explicit.step(duration / f64::from(steps)).unwrap();
        }
        let square: f64 = simulation
            .positions(0)
            .iter()
            .zip(explicit.positions(0))
            .map(|(a, b)| (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2))
            .sum();
        (square / block.positions.len() as f64).sqrt()
    })
}

#[test]
fn steps_converge_to_the_explicit_motion_with_order_one() {
    let check = |name: &str, found: [f64; 3]| {
        let orders = [0, 1].map(|k| (found[k] / found[k + 1]).log2());
        println!("{name}: {found:?}, orders {orders:.2?}");
        assert!(orders.iter().all(|order| (0.8..1.3).contains(order)), "{name}: {found:?}");
    };
    check("neo-Hookean", differences(NeoHookean::new(lame(1e5, 0.3))));
    let metal = VonMises::new(lame(1e5, 0.3), YieldStress::linear(2e3, 5e3).unwrap()).unwrap();
    check("von Mises", differences(metal));
    let water = Tait::new(1e5, 7.0, Tension::Carried).unwrap();
    check("viscous fluid", differences(Viscous::new(water, Viscosity::new(20.0, 5.0).unwrap())));
}

#[test]
fn threads_do_not_change_bits() {
    let run = |threads| {
        with_threads(threads, || {
            // Sixteen blocks of nodes and more, so that threads have something to share.
            let block = Block::<2>::new([18, 18], SPACING);
            let mut simulation = block.rubber(TRANSFERS[0], |x| [1.0 - 4.0 * x[1], 4.0 * x[0]]);
            let h = 30.0 * simulation.stable_step();
            for _ in 0..2 {
                simulation.step_implicitly(h, &ImplicitStep::default()).unwrap();
            }
            simulation.state_hash()
        })
    };
    let one = run(1);
    assert!([2, 3, 8].into_iter().all(|threads| run(threads) == one));
}

/// In space, in single precision: the same motion as in double precision, to single rounding.
#[test]
fn single_precision_follows_double() {
    let block = Block::<3>::new([3, 3, 2], SPACING);
    let velocities: Vec<_> = block.positions.iter().map(|x| [-3.0 * x[1], 3.0 * x[0], 2.0 * x[2]]).collect();
    let law = NeoHookean::new(lame(1e5, 0.3));
    let samples = Samples { positions: &block.positions, velocities: &velocities, volumes: &block.volumes };
    let mut single = Simulation::<f32, 3>::new(SimulationOptions::new(SPACING)).unwrap();
    let mut double = Simulation::<f64, 3>::new(SimulationOptions::new(SPACING)).unwrap();
    single.add_body(law, DENSITY, samples).unwrap();
    double.add_body(law, DENSITY, samples).unwrap();
    let h = 30.0 * double.stable_step();
    for _ in 0..3 {
        single.step_implicitly(h, &ImplicitStep::default()).unwrap();
        let report = double.step_implicitly(h, &ImplicitStep::default()).unwrap();
        assert!(report.iterations > 0 && report.step.blocks > 0);
    }
    for (a, b) in single.positions(0).iter().zip(double.positions(0)) {
        assert!((0..3).all(|k| (a[k] - b[k]).abs() < 1e-5), "{a:?} {b:?}");
    }
}
