//! Boundaries inside the solve.

use crate::block::{Block, DENSITY, SPACING, lame};
use mpm_constitutive::elastic::NeoHookean;
use mpm_core::{Boundary, ImplicitStep, PrescribedVelocity, Shape, Simulation, SimulationOptions, Surface};

const GRAVITY: f64 = 9.81;
const DURATION: f64 = 0.2;

/// A stiff block on an incline of `angle` (gravity turned instead): mean velocity along it after a fifth of a second in steps of `h`.
fn slide(angle: f64, surface: Surface, h: f64) -> f64 {
    let block = Block::<2>::new([4, 2], SPACING);
    let law = NeoHookean::new(lame(1e6, 0.3));
    let mut simulation = block.simulation(SimulationOptions::new(SPACING), law, |_| [0.0; 2]);
    simulation.set_gravity([GRAVITY * angle.sin(), -GRAVITY * angle.cos()]).unwrap();
    let floor = Shape::HalfSpace { point: [0.0; 2], normal: [0.0, 1.0] };
    simulation.add_boundary(Boundary::at_rest(floor, surface)).unwrap();
    let mut rounds = 0;
    for _ in 0..(DURATION / h).round() as usize {
        let report = simulation.step_implicitly(h, &ImplicitStep::default()).unwrap();
        rounds = rounds.max(report.rounds);
    }
    println!("{rounds} rounds at most");
    simulation.totals(0).momentum.x / simulation.totals(0).mass
}

#[test]
fn a_block_slides_or_sticks_by_coulombs_law() {
    let h = 0.01;
    for (degrees, friction) in [(30.0_f64, 0.2), (30.0, 0.4), (30.0, 0.7), (45.0, 0.5), (30.0, 0.0)] {
        let angle = degrees.to_radians();
        let expected = DURATION * GRAVITY * (angle.sin() - friction * angle.cos()).max(0.0);
        let found = slide(angle, Surface::Friction(friction), h);
        println!("{degrees}°, μ = {friction}: {found:.6} m/s, closed form {expected:.6}");
        // The block comes to rest on the floor first, and friction brakes it as much as it is pushed.
        assert!((found - expected).abs() < 2e-3 * GRAVITY * DURATION * angle.sin(), "{found} {expected}");
    }
    let angle = 30.0_f64.to_radians();
    let slip = slide(angle, Surface::Slip, h);
    assert!((slip - DURATION * GRAVITY * angle.sin()).abs() < 1e-6, "{slip}");
    let sticky = slide(angle, Surface::Sticky, h);
    assert!(sticky.abs() < 1e-3, "{sticky}");
}

/// What hits a separating floor leaves it; a slip floor keeps it.
#[test]
fn separating_floors_let_go_and_slip_floors_do_not() {
    let run = |surface| {
        let block = Block::<2>::new([4, 4], SPACING);
        let mut simulation = block.rubber(mpm_core::Transfer::MlsApic, |_| [0.3, -2.0]);
        let floor = Shape::HalfSpace { point: [0.0; 2], normal: [0.0, 1.0] };
        simulation.add_boundary(Boundary::at_rest(floor, surface)).unwrap();
        let mut pushed = 0.0_f64;
        for _ in 0..60 {
            let before = simulation.totals(0).momentum.y;
            simulation.step_implicitly(2e-3, &ImplicitStep::default()).unwrap();
            pushed = pushed.min(simulation.totals(0).momentum.y - before);
        }
        let totals = simulation.totals(0);
        (totals.momentum.y / totals.mass, pushed / totals.mass, totals.momentum.x / totals.mass)
    };
    let (up, pulled, along) = run(Surface::Separating);
    println!("separating: {up:.3} m/s, pulled {pulled:.1e}");
    assert!(up > 0.5 && pulled > -1e-6, "{up} {pulled}");
    assert!((along - 0.3).abs() < 1e-5, "{along}");
    let (kept, _, along) = run(Surface::Slip);
    assert!(kept < 0.3 * up && (along - 0.3).abs() < 1e-5, "{kept} {along}");
}

/// Grips that move apart stretch a bar: with long steps its middle moves with their mean.
#[test]
fn grips_carry_what_they_hold() {
    let block = Block::<2>::new([8, 2], SPACING);
    let options = SimulationOptions::new(SPACING);
    let mut simulation: Simulation<f64, 2> =
        block.simulation(options, NeoHookean::new(lame(1e5, 0.0)), |_| [0.1, 0.0]);
    for (centre, velocity) in [(0.0, 0.0), (0.8, 0.2)] {
        let region = Shape::Cuboid { centre: [centre, 0.1], half: [0.11, 1.0] };
        let grip = PrescribedVelocity { region, velocity: [velocity, 0.0], from: 0.0, until: f64::INFINITY };
        simulation.add_prescribed_velocity(grip).unwrap();
    }
    for _ in 0..20 {
        simulation.step_implicitly(0.02, &ImplicitStep::default()).unwrap();
    }
    let (x, v) = (simulation.positions(0), simulation.velocities(0));
    for p in 0..x.len() {
        let start = block.positions[p][0];
        if start < 0.05 {
            assert!(v[p][0].abs() < 1e-12 && (x[p][0] - start).abs() < 1e-12);
        }
    }
    let mean = v.iter().map(|v| v[0]).sum::<f64>() / v.len() as f64;
    assert!((mean - 0.1).abs() < 0.02, "{mean}");
    let total = DENSITY * block.volumes.iter().sum::<f64>();
    assert!((simulation.totals(0).mass / total - 1.0).abs() < 1e-12);
}
