//! Momentum, angular momentum and energy of a body in free flight.

use mechanics_core::lanes::Element;
use mechanics_core::law::Lame;
use mpm_constitutive::elastic::NeoHookean;
use mpm_core::{Kernel, Samples, Simulation, SimulationOptions, Transfer};

pub(crate) const SPACING: f64 = 0.1;
pub(crate) const DENSITY: f64 = 1000.0;

/// Repeatable numbers in [0, 1).
pub(crate) fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// A block of `cells` cells an edge, two particles a cell and axis, jittered; with place, velocity and volume of each particle.
pub(crate) struct Block<const D: usize> {
    pub(crate) positions: Vec<[f64; D]>,
    pub(crate) velocities: Vec<[f64; D]>,
    pub(crate) volumes: Vec<f64>,
}

impl<const D: usize> Block<D> {
    /// It turns by `spin` rad/s in the plane of the first two axes about its middle and flies.
    pub(crate) fn spinning(cells: usize, spin: f64) -> Self {
        let mut random = random(0x9e37_79b9_7f4a_7c15);
        let side = 2 * cells;
        let gap = 0.5 * SPACING;
        let middle = 0.5 * gap * side as f64;
        let positions: Vec<[f64; D]> = (0..side.pow(D as u32))
            .map(|k| {
                std::array::from_fn(|a| {
                    let along = (k / side.pow(a as u32) % side) as f64;
                    gap * (along + 0.5 + 0.4 * (random() - 0.5)) - middle
                })
            })
            .collect();
        let velocities = positions
            .iter()
            .map(|x| {
                let mut v = [0.7; D];
                v[0] -= spin * x[1];
                v[1] += spin * x[0];
                v
            })
            .collect();
        Self { volumes: vec![gap.powi(D as i32); positions.len()], positions, velocities }
    }

    pub(crate) fn simulation<E: Element>(&self, kernel: Kernel, transfer: Transfer) -> Simulation<E, D> {
        let options = SimulationOptions { spacing: SPACING, kernel, transfer };
        let mut simulation = Simulation::<E, D>::new(options).unwrap();
        let law = NeoHookean::new(Lame::from_young_poisson(1e5, 0.3).unwrap());
        let samples =
            Samples { positions: &self.positions, velocities: &self.velocities, volumes: &self.volumes };
        simulation.add_body(law, DENSITY, samples).unwrap();
        simulation
    }
}

/// Totals over the first body.
#[derive(Clone, Copy, Debug)]
struct Totals<const D: usize> {
    momentum: [f64; D],
    /// About the origin, of the first two axes; the affine velocities' part apart.
    orbital: f64,
    affine: f64,
    energy: f64,
}

fn totals<const D: usize>(simulation: &Simulation<f64, D>, volumes: &[f64], kernel: Kernel) -> Totals<D> {
    let moment = kernel.second_moment().unwrap_or(0.0) * SPACING * SPACING;
    let (x, v) = (simulation.positions(0), simulation.velocities(0));
    let (c, states) = (simulation.velocity_gradients(0), simulation.states(0));
    let mut sum = Totals { momentum: [0.0; D], orbital: 0.0, affine: 0.0, energy: 0.0 };
    for p in 0..x.len() {
        let mass = DENSITY * volumes[p];
        for a in 0..D {
            sum.momentum[a] += mass * v[p][a];
            sum.energy += 0.5 * mass * v[p][a].powi(2);
        }
        sum.orbital += mass * (x[p][0] * v[p][1] - x[p][1] * v[p][0]);
        sum.affine += mass * moment * (c[p][1][0] - c[p][0][1]);
        sum.energy += volumes[p] * states[p].energy_density;
    }
    sum
}

/// Relative changes of momentum, angular momentum and energy over 200 steps.
fn changes<const D: usize>(block: &Block<D>, kernel: Kernel, transfer: Transfer) -> (f64, f64, f64) {
    let mut simulation = block.simulation::<f64>(kernel, transfer);
    let affine = |t: &Totals<D>| match transfer {
        Transfer::Apic { .. } | Transfer::MlsApic => t.orbital + t.affine,
        _ => t.orbital,
    };
    let before = totals(&simulation, &block.volumes, kernel);
    let step = 0.5 * simulation.stable_step();
    let mut sorts = 0;
    for _ in 0..200 {
        let step = step.min(simulation.stable_step());
        sorts += u32::from(simulation.step(step).unwrap().sorted);
    }
    assert!(sorts > 1, "the block must cross cells: {sorts}");
    let after = totals(&simulation, &block.volumes, kernel);
    let mut momentum = 0.0_f64;
    for a in 0..D {
        momentum = momentum.max((after.momentum[a] - before.momentum[a]).abs() / before.momentum[a].abs());
    }
    let angular = (affine(&after) - affine(&before)) / affine(&before);
    (momentum, angular, after.energy / before.energy - 1.0)
}

fn check<const D: usize>(cells: usize) {
    let block = Block::<D>::spinning(cells, 4.0);
    let affine =
        [Transfer::APIC, Transfer::Apic { damping: 0.5 }, Transfer::Apic { damping: 1.0 }, Transfer::MlsApic];
    // Not linear: its forces tear a free surface apart at any step, because a node that is hardly touched is light and yet pushed.
    for kernel in [Kernel::Quadratic, Kernel::Cubic] {
        for transfer in [Transfer::Pic, Transfer::FLIP, Transfer::Flip { flip: 0.95 }].iter().chain(&affine) {
            let (momentum, angular, energy) = changes(&block, kernel, *transfer);
            println!("{D}D {kernel:?} {transfer:?}: p {momentum:.1e}, L {angular:+.1e}, E {energy:+.1e}");
            assert!(momentum < 1e-13, "{kernel:?} {transfer:?}: momentum changed by {momentum}");
            assert!(energy < 0.02, "{kernel:?} {transfer:?}: energy grew by {energy}");
            match transfer {
                // A twentieth of PIC a step is most of it after two hundred.
                Transfer::Pic | Transfer::Flip { flip: 0.95 } => {
                    assert!(angular < -0.1, "{kernel:?}: PIC loses angular momentum: {angular}");
                }
                // FLIP promises nothing: 4 % in the plane and 18 % in space were lost when this was written.
                Transfer::Flip { .. } => {}
                _ => assert!(angular.abs() < 1e-13, "{kernel:?} {transfer:?}: {angular}"),
            }
        }
    }
}

#[test]
fn free_flight_keeps_momentum_and_affine_transfers_keep_angular_momentum() {
    check::<2>(8);
    check::<3>(3);
}
