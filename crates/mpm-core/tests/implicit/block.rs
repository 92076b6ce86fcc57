//! Blocks of cells.

use mechanics_core::law::Lame;
use mpm_constitutive::PointLaw;
use mpm_constitutive::elastic::NeoHookean;
use mpm_core::{Samples, Simulation, SimulationOptions, Transfer};

pub(crate) const SPACING: f64 = 0.1;
pub(crate) const DENSITY: f64 = 1000.0;

pub(crate) const TRANSFERS: [Transfer; 4] =
    [Transfer::MlsApic, Transfer::APIC, Transfer::FLIP, Transfer::Pic];

/// Two particles a cell and axis.
pub(crate) struct Block<const D: usize> {
    pub(crate) positions: Vec<[f64; D]>,
    pub(crate) volumes: Vec<f64>,
}

impl<const D: usize> Block<D> {
    /// From the origin on.
    pub(crate) fn new(cells: [usize; D], spacing: f64) -> Self {
        let gap = 0.5 * spacing;
        let count: usize = cells.iter().map(|c| 2 * c).product();
        let positions: Vec<[f64; D]> = (0..count)
            .map(|mut k| {
                std::array::from_fn(|a| {
                    let along = k % (2 * cells[a]);
                    k /= 2 * cells[a];
                    gap * (along as f64 + 0.5)
                })
            })
            .collect();
        Self { volumes: vec![gap.powi(D as i32); positions.len()], positions }
    }

    pub(crate) fn simulation<L: PointLaw + 'static>(
        &self,
        options: SimulationOptions,
        law: L,
        velocity: impl Fn(&[f64; D]) -> [f64; D],
    ) -> Simulation<f64, D> {
        let mut simulation = Simulation::new(options).unwrap();
        let velocities: Vec<_> = self.positions.iter().map(velocity).collect();
        let samples = Samples { positions: &self.positions, velocities: &velocities, volumes: &self.volumes };
        simulation.add_body(law, DENSITY, samples).unwrap();
        simulation
    }

    /// Rubber of E = 1e5 Pa.
    pub(crate) fn rubber(
        &self,
        transfer: Transfer,
        velocity: impl Fn(&[f64; D]) -> [f64; D],
    ) -> Simulation<f64, D> {
        let options = SimulationOptions { transfer, ..SimulationOptions::new(SPACING) };
        self.simulation(options, NeoHookean::new(lame(1e5, 0.3)), velocity)
    }
}

pub(crate) fn lame(young: f64, poisson: f64) -> Lame {
    Lame::from_young_poisson(young, poisson).unwrap()
}
