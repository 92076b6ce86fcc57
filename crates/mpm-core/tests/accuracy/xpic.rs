//! What XPIC and ASFLIP keep and what they forget, in steps without stress: the operators alone.

use crate::ladder::Cloud;
use crate::noise::Constant;
use mechanics_core::lanes::Element;
use mpm_core::{Kernel, MpmError, Samples, Simulation, SimulationOptions, Transfer};

/// A square of 6 cells with two particles an axis and cell, off the nodes.
fn square() -> Cloud {
    Cloud::rectangle([0.17, 0.31], [6.17, 6.31], [12; 2])
}

fn weightless<E: Element>(
    kernel: Kernel,
    transfer: Transfer,
    cloud: &Cloud,
    velocities: &[[f64; 2]],
) -> Simulation<E, 2> {
    let mut simulation = Simulation::new(SimulationOptions { spacing: 1.0, kernel, transfer }).unwrap();
    let samples = Samples { positions: &cloud.points, velocities, volumes: &cloud.volumes };
    simulation.add_body(Constant { stress: 0.0 }, 1.0, samples).unwrap();
    simulation
}

/// Velocities after a step that is too short to move anything.
fn filtered(kernel: Kernel, transfer: Transfer, cloud: &Cloud, velocities: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut simulation = weightless::<f64>(kernel, transfer, cloud, velocities);
    simulation.step(1e-9).unwrap();
    simulation.velocities(0)
}

fn white(count: usize) -> Vec<[f64; 2]> {
    let mut state = 0x1234_5678_9abc_def1_u64;
    let mut random = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    (0..count).map(|_| [random(), random()]).collect()
}

fn energy(velocities: &[[f64; 2]]) -> f64 {
    velocities.iter().flatten().map(|v| v * v).sum()
}

fn momentum(velocities: &[[f64; 2]]) -> [f64; 2] {
    velocities.iter().fold([0.0; 2], |sum, v| [sum[0] + v[0], sum[1] + v[1]])
}

fn spin(cloud: &Cloud, velocities: &[[f64; 2]]) -> f64 {
    cloud.points.iter().zip(velocities).map(|(x, v)| x[0] * v[1] - x[1] * v[0]).sum()
}

fn distance(a: &[[f64; 2]], b: &[[f64; 2]]) -> f64 {
    let difference: Vec<_> = a.iter().zip(b).map(|(a, b)| [a[0] - b[0], a[1] - b[1]]).collect();
    energy(&difference).sqrt()
}

/// XPIC(1) is PIC, APIC is ASFLIP without coefficients: the same operations.
#[test]
fn the_ends_of_the_families_are_the_transfers_that_they_extend() {
    let cloud = square();
    let noise = white(cloud.points.len());
    for (one, other) in [
        (Transfer::Xpic { order: 1 }, Transfer::Pic),
        (Transfer::Asflip { flip: 0.0, position: 1.0 }, Transfer::APIC),
    ] {
        let states = [one, other].map(|transfer| {
            let mut simulation = weightless::<f32>(Kernel::Cubic, transfer, &cloud, &noise);
            simulation.set_gravity([0.3, -9.81]).unwrap();
            (0..20).for_each(|_| {
                simulation.step(1e-2).unwrap();
            });
            (simulation.positions(0), simulation.velocities(0))
        });
        assert_eq!(states[0], states[1], "{one:?} and {other:?}");
    }
}

/// Velocities that a grid made (the output of many passes) come back, ever better; of white noise the grid's part stays, which is the
/// projection, and no energy is ever added.
#[test]
fn higher_orders_keep_more_of_what_the_grid_can_carry_and_nothing_of_the_rest() {
    for kernel in [Kernel::Linear, Kernel::Quadratic, Kernel::Cubic] {
        let cloud = square();
        let noise = white(cloud.points.len());
        let of_order = |order, v: &[[f64; 2]]| filtered(kernel, Transfer::Xpic { order }, &cloud, v);
        let representable = of_order(1, &noise);
        let orders = [1, 2, 3, 5, 10, 30, 100];
        let errors = orders.map(|order| distance(&of_order(order, &representable), &representable));
        let kept = orders.map(|order| energy(&of_order(order, &noise)) / energy(&noise));
        println!("{kernel:?}: error of what the grid can carry {errors:?}, energy left of noise {kept:.3?}");
        assert!(errors.windows(2).all(|pair| pair[1] < pair[0]), "{kernel:?} {errors:?}");
        assert!(kept.windows(2).all(|pair| pair[1] > pair[0]), "{kernel:?} {kept:?}");
        // Fewer nodes than particles: some of the noise is gone whatever the order.
        assert!(errors[6] < 0.1 * errors[0] && kept[6] < 0.7, "{kernel:?} {errors:?} {kept:?}");
        // A projection, nearly: what it kept it keeps again, and what it took was orthogonal to that.
        let once = of_order(3000, &noise);
        let taken: f64 = (0..noise.len())
            .map(|p| (0..2).map(|a| once[p][a] * (noise[p][a] - once[p][a])).sum::<f64>())
            .sum();
        let total = energy(&noise);
        assert!(taken >= -1e-12 * total && taken < 0.02 * total, "{kernel:?}: {}", taken / total);
        // FLIP keeps everything.
        let flip = filtered(kernel, Transfer::FLIP, &cloud, &noise);
        assert!(distance(&flip, &noise) < 1e-12);
        for v in [&representable, &once] {
            let (p, q) = (momentum(v), momentum(&noise));
            assert!((p[0] - q[0]).abs() < 1e-12 && (p[1] - q[1]).abs() < 1e-12, "{kernel:?}: {p:?} {q:?}");
        }
    }
}

/// Of a rigid rotation ⟨ω×x, (I − SS⁺)ᵐ ω×x⟩ is lost: less in every pass.
#[test]
fn the_angular_momentum_that_xpic_loses_vanishes_with_its_order() {
    let cloud = square();
    let rotation: Vec<[f64; 2]> = cloud.points.iter().map(|x| [-(x[1] - 3.3), x[0] - 3.2]).collect();
    let before = spin(&cloud, &rotation);
    for kernel in [Kernel::Quadratic, Kernel::Cubic] {
        let lost = [1, 2, 3, 5, 10, 100].map(|order| {
            1.0 - spin(&cloud, &filtered(kernel, Transfer::Xpic { order }, &cloud, &rotation)) / before
        });
        println!("{kernel:?}: angular momentum lost in a step by order {lost:?}");
        assert!(
            lost[0] > 1e-3 && lost.windows(2).all(|pair| pair[1] < pair[0] && pair[1] > -1e-14),
            "{lost:?}"
        );
        assert!(lost[5] < 0.02 * lost[0], "{lost:?}");
    }
}

/// ΔL = α Σ m D ε:(C⁰ − C) + h α Σ m (1 − γ) u × d, without forces: C⁰ and u are what APIC brings back.
#[test]
fn asflip_changes_angular_momentum_by_what_is_derived() {
    let cloud = square();
    let noise = white(cloud.points.len());
    let gradients: Vec<[[f64; 2]; 2]> = white(2 * noise.len()).chunks(2).map(|c| [c[0], c[1]]).collect();
    let (mass, moment, step) = (0.25, 0.25, 0.05);
    let run = |transfer| {
        let mut simulation = weightless::<f64>(Kernel::Quadratic, transfer, &cloud, &noise);
        simulation.set_velocity_gradients(0, &gradients).unwrap();
        let before = simulation.totals(0);
        simulation.step_unchecked(step).unwrap();
        (before, simulation)
    };
    let grid = run(Transfer::APIC).1;
    let (u, c) = (grid.velocities(0), grid.velocity_gradients(0));
    let turn = |c: &[[f64; 2]; 2]| c[1][0] - c[0][1];
    for (flip, position) in [(0.9, 1.0), (0.6, 0.3), (1.0, 0.0)] {
        let (before, simulation) = run(Transfer::Asflip { flip, position });
        let after = simulation.totals(0);
        let (mut expected, mut held) = (0.0, 0);
        for (p, x) in simulation.positions(0).iter().enumerate() {
            let d: [f64; 2] = std::array::from_fn(|a| noise[p][a] - u[p][a]);
            // Where matter is under compression particles move with the grid.
            let with_grid = (0..2).all(|a| (x[a] - cloud.points[p][a] - step * u[p][a]).abs() < 1e-12);
            held += usize::from(with_grid);
            let part = if with_grid { 0.0 } else { position };
            expected += flip * mass * moment * (turn(&c[p]) - turn(&gradients[p]));
            expected += step * flip * (1.0 - part) * mass * (u[p][0] * d[1] - u[p][1] * d[0]);
        }
        assert!(position == 0.0 || (10..noise.len() - 10).contains(&held), "{held} of {}", noise.len());
        let change = after.angular_momentum.z - before.angular_momentum.z;
        assert!(expected.abs() > 1e-2 && (change - expected).abs() < 1e-12, "{change} {expected}");
        assert!((after.momentum - before.momentum).norm() < 1e-13, "{} {}", after.momentum, before.momentum);
    }
}

/// A body in free fall is one velocity: nothing is filtered, and places are those of symplectic Euler.
#[test]
fn free_fall_is_exact() {
    let cloud = square();
    let velocities = vec![[0.7, -0.2]; cloud.points.len()];
    let (g, h, steps) = (-9.81, 0.01, 50);
    for transfer in [Transfer::Xpic { order: 2 }, Transfer::Xpic { order: 7 }, Transfer::ASFLIP] {
        let mut simulation = weightless::<f64>(Kernel::Quadratic, transfer, &cloud, &velocities);
        simulation.set_gravity([0.0, g]).unwrap();
        (0..steps).for_each(|_| {
            simulation.step(h).unwrap();
        });
        let (n, t) = (f64::from(steps), f64::from(steps) * h);
        let fallen = -0.2 * t + 0.5 * g * h * h * n * (n + 1.0);
        for ((x, v), start) in simulation.positions(0).iter().zip(simulation.velocities(0)).zip(&cloud.points)
        {
            assert!((x[0] - start[0] - 0.7 * t).abs() < 1e-12 && (v[0] - 0.7).abs() < 1e-12, "{transfer:?}");
            assert!((x[1] - start[1] - fallen).abs() < 1e-12 && (v[1] + 0.2 - g * t).abs() < 1e-11);
        }
    }
}

/// Affine velocities with their gradients pass through an affine transfer as they are, so ASFLIP has nothing to give back.
#[test]
fn asflip_carries_a_rigid_rotation_exactly() {
    let cloud = square();
    let rotation: Vec<[f64; 2]> = cloud.points.iter().map(|x| [-(x[1] - 3.3), x[0] - 3.2]).collect();
    let mut simulation = weightless::<f64>(Kernel::Quadratic, Transfer::ASFLIP, &cloud, &rotation);
    simulation.set_velocity_gradients(0, &vec![[[0.0, -1.0], [1.0, 0.0]]; rotation.len()]).unwrap();
    simulation.step(1e-3).unwrap();
    assert!(distance(&simulation.velocities(0), &rotation) < 1e-13);
    for (x, (start, v)) in simulation.positions(0).iter().zip(cloud.points.iter().zip(&rotation)) {
        assert!((x[0] - start[0] - 1e-3 * v[0]).hypot(x[1] - start[1] - 1e-3 * v[1]) < 1e-15);
    }
}

#[test]
fn coefficients_out_of_range_are_refused() {
    let new = |transfer| {
        Simulation::<f64, 2>::new(SimulationOptions { transfer, ..SimulationOptions::new(1.0) }).err()
    };
    assert_eq!(new(Transfer::Xpic { order: 0 }), Some(MpmError::Order));
    for (flip, position) in [(-0.1, 0.5), (0.5, 1.1), (f64::NAN, 0.0), (0.5, f64::NAN)] {
        let refused = new(Transfer::Asflip { flip, position });
        assert!(matches!(refused, Some(MpmError::Part { .. })), "{flip} {position}: {refused:?}");
    }
    let linear = SimulationOptions { spacing: 1.0, kernel: Kernel::Linear, transfer: Transfer::ASFLIP };
    assert_eq!(Simulation::<f64, 2>::new(linear).err(), Some(MpmError::SingularMoment));
}
