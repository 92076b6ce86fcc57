//! Two bodies that touch and are pulled apart.

use crate::ladder::Cloud;
use mechanics_core::law::Lame;
use mechanics_core::parallel::with_threads;
use mpm_constitutive::elastic::NeoHookean;
use mpm_core::{Kernel, Samples, Simulation, SimulationOptions, Transfer};

const SPEED: f64 = 1.0;

/// Two blocks of 4 by 8 cells lie against each other and part with ±1 m/s: the part of their relative velocity that is left when they are 4 cells
/// apart, and the time that takes by 4 cells/2 m/s.
fn part(young: f64, transfer: Transfer) -> (f64, f64) {
    let spacing = 0.1;
    let options = SimulationOptions { spacing, kernel: Kernel::Quadratic, transfer };
    let mut simulation = Simulation::<f64, 2>::new(options).unwrap();
    let law = NeoHookean::new(Lame::from_young_poisson(young, 0.3).unwrap());
    for (low, speed) in [(-0.4, -SPEED), (0.0, SPEED)] {
        let cloud = Cloud::rectangle([low, 0.0], [low + 0.4, 0.8], [8, 16]);
        let velocities = vec![[speed, 0.0]; cloud.points.len()];
        let samples = Samples { positions: &cloud.points, velocities: &velocities, volumes: &cloud.volumes };
        simulation.add_body(law, 1000.0, samples).unwrap();
    }
    let apart = |simulation: &Simulation<f64, 2>| {
        let [left, right] = [0, 1].map(|body| simulation.positions(body));
        let mean = |x: &[[f64; 2]]| x.iter().map(|x| x[0]).sum::<f64>() / x.len() as f64;
        mean(&right) - mean(&left) - 0.4
    };
    while apart(&simulation) < 4.0 * spacing && simulation.time() < 2.0 {
        let step = simulation.stable_step().min(1e-3);
        simulation.step(step).unwrap();
    }
    let speed = |body| {
        let totals = simulation.totals(body);
        totals.momentum.x / totals.mass
    };
    let sum = simulation.totals(0).momentum + simulation.totals(1).momentum;
    assert!(sum.norm() < 1e-10, "momentum {sum}");
    (0.5 * (speed(1) - speed(0)) / SPEED, simulation.time() * 2.0 * SPEED / (4.0 * spacing))
}

/// The grid holds the blocks together until they are three cells apart. Their waves, of speed c, pull at each face with ρ c v meanwhile: a block that is four
/// cells long loses about 0.4 c.
#[test]
fn bodies_part_with_less_loss_under_asflip() {
    for young in [100.0, 300.0] {
        let run = |transfer| {
            let (left, time) = with_threads(1, || part(young, transfer));
            println!(
                "parting blocks of {young} Pa, {transfer:?}: {left:.3} of the velocity left, {time:.3} of the free time"
            );
            (left, time)
        };
        let (apic, asflip) = (run(Transfer::APIC), run(Transfer::ASFLIP));
        for transfer in [
            Transfer::Pic,
            Transfer::FLIP,
            Transfer::MlsApic,
            Transfer::Asflip { flip: 0.99, position: 0.0 },
            Transfer::Xpic { order: 5 },
        ] {
            run(transfer);
        }
        assert!(asflip.0 > apic.0 && asflip.1 < apic.1, "{asflip:?} {apic:?}");
        assert!(asflip.0 < 1.0 + 1e-9, "{asflip:?}");
    }
}
