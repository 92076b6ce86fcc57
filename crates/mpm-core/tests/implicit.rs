//! Implicit steps against closed forms, conservation laws and explicit steps.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs, reason = "tests")]

use mechanics_core::law::Lame;
use mpm_constitutive::elastic::NeoHookean;
use mpm_core::{ImplicitStep, Samples, Simulation, SimulationOptions, Transfer};

const SPACING: f64 = 0.1;
const DENSITY: f64 = 1000.0;

/// A block of `cells` cells an edge, two particles a cell and axis, whose middle is the origin.
struct Block<const D: usize> {
    positions: Vec<[f64; D]>,
    volumes: Vec<f64>,
}

impl<const D: usize> Block<D> {
    fn new(cells: [usize; D]) -> Self {
        let gap = 0.5 * SPACING;
        let count: usize = cells.iter().map(|c| 2 * c).product();
        let positions: Vec<[f64; D]> = (0..count)
            .map(|mut k| {
                std::array::from_fn(|a| {
                    let along = k % (2 * cells[a]);
                    k /= 2 * cells[a];
                    gap * (along as f64 + 0.5 - cells[a] as f64)
                })
            })
            .collect();
        Self { volumes: vec![gap.powi(D as i32); positions.len()], positions }
    }

    /// Rubber that moves as `velocity` says.
    fn rubber(
        &self,
        transfer: Transfer,
        young: f64,
        velocity: impl Fn(&[f64; D]) -> [f64; D],
    ) -> Simulation<f64, D> {
        let options = SimulationOptions { transfer, ..SimulationOptions::new(SPACING) };
        let mut simulation = Simulation::new(options).unwrap();
        let law = NeoHookean::new(Lame::from_young_poisson(young, 0.3).unwrap());
        let velocities: Vec<_> = self.positions.iter().map(velocity).collect();
        let samples =
            Samples { positions: &self.positions, velocities: &velocities, volumes: &self.volumes };
        simulation.add_body(law, DENSITY, samples).unwrap();
        simulation
    }
}

const TRANSFERS: [Transfer; 4] = [Transfer::MlsApic, Transfer::APIC, Transfer::FLIP, Transfer::Pic];

#[test]
fn a_body_falls_as_a_point_does() {
    for transfer in TRANSFERS {
        let block = Block::<3>::new([3, 2, 2]);
        let mut simulation = block.rubber(transfer, 1e5, |_| [0.7, 0.0, 0.3]);
        simulation.set_gravity([0.0, 0.0, -9.81]).unwrap();
        let h = 0.05;
        for _ in 0..4 {
            let report = simulation.step_implicitly(h, &ImplicitStep::default()).unwrap();
            assert_eq!(report.iterations, 0);
        }
        for (x, start) in simulation.positions(0).iter().zip(&block.positions) {
            // Symplectic Euler: h² g (1 + 2 + 3 + 4).
            let fallen = 4.0 * h * 0.3 - 9.81 * h * h * 10.0;
            assert!((x[2] - start[2] - fallen).abs() < 1e-12, "{transfer:?} {}", x[2] - start[2] - fallen);
        }
    }
}

#[test]
fn momentum_is_kept_in_steps_twenty_times_the_explicit_ones() {
    for transfer in TRANSFERS {
        let block = Block::<2>::new([6, 6]);
        let mut simulation = block.rubber(transfer, 1e5, |x| [1.0 - 4.0 * x[1], 4.0 * x[0] + 2.0 * x[1]]);
        let before = simulation.totals(0);
        let h = 20.0 * simulation.stable_step();
        for _ in 0..20 {
            let report = simulation.step_implicitly(h, &ImplicitStep::default()).unwrap();
            println!("{h} {report:?}");
        }
        let after = simulation.totals(0);
        println!("{transfer:?} {before:?} {after:?}");
        let lost = (after.momentum - before.momentum).norm() / before.momentum.norm();
        assert!(lost < 1e-6, "{transfer:?}: momentum changed by {lost:e}");
        let energy = |t: &mpm_core::Totals| t.kinetic_energy + t.stored_energy;
        assert!(energy(&after) < energy(&before), "{transfer:?}: dissipation");
    }
}
