//! What is stepped: the scenes of `peers/taichi_mpm.py`, and the laws that are compared.

use mechanics_core::lanes::Element;
use mechanics_core::law::Lame;
use mechanics_core::parallel::with_threads;
use mpm_constitutive::PointLaw;
use mpm_constitutive::elastic::{FixedCorotated, NeoHookean};
use mpm_constitutive::fluid::{Tait, Tension};
use mpm_constitutive::plastic::{DruckerPrager, FrictionAngle, VonMises, YieldStress};
use mpm_core::sampling::{Pattern, SampledBody, sample_shape};
use mpm_core::{Samples, Shape, Simulation, SimulationOptions};
use std::time::Instant;

/// Nodes along the unit box, and the block's edge in cells.
#[derive(Clone, Copy, Debug)]
pub struct Size {
    pub nodes: usize,
    pub cells: usize,
}

/// 110,592 particles.
pub const SMALL: Size = Size { nodes: 64, cells: 24 };
/// 1,000,000 particles.
pub const LARGE: Size = Size { nodes: 128, cells: 50 };
/// 200,704 particles.
pub const PLANE: Size = Size { nodes: 512, cells: 224 };

fn lame() -> Lame {
    Lame::from_young_poisson(1e5, 0.3).unwrap()
}

pub fn jelly() -> FixedCorotated {
    FixedCorotated::new(lame())
}

pub fn rubber() -> NeoHookean {
    NeoHookean::new(lame())
}

pub fn water() -> Tait {
    Tait::new(1e5, 7.0, Tension::Carried).unwrap()
}

pub fn metal() -> VonMises {
    VonMises::new(lame(), YieldStress::perfect(1e3).unwrap()).unwrap()
}

pub fn sand() -> DruckerPrager {
    DruckerPrager::new(lame(), FrictionAngle::constant(0.52).unwrap(), 0.0).unwrap()
}

/// A simulation that can be stepped and timed, whatever its law, precision and dimension.
pub trait Stepped {
    fn particles(&self) -> usize;

    /// Makes so many steps on so many threads; the time of one \[s\].
    fn run(&mut self, steps: usize, threads: usize) -> f64;
}

struct Scene<E: Element, const D: usize> {
    simulation: Simulation<E, D>,
    step: f64,
}

/// A block of cells with 2^D jittered particles each, spinning and falling.
pub fn scene<E: Element, const D: usize, L: PointLaw + 'static>(law: L, size: Size) -> Box<dyn Stepped> {
    let spacing = 1.0 / size.nodes as f64;
    let shape = Shape::Cuboid { centre: [0.5; D], half: [0.5 * size.cells as f64 * spacing; D] };
    let SampledBody { positions, volumes } = sample_shape(&shape, Pattern::per_cell(spacing, 2), 7).unwrap();
    let velocity = |x: &[f64; D]| {
        let mut v = [0.0; D];
        v[D - 1] = -1.0;
        (v[0], v[1]) = (2.0 * (x[1] - 0.5), -2.0 * (x[0] - 0.5));
        v
    };
    let velocities: Vec<_> = positions.iter().map(velocity).collect();
    let mut simulation = Simulation::<E, D>::new(SimulationOptions::new(spacing)).unwrap();
    let samples = Samples { positions: &positions, velocities: &velocities, volumes: &volumes };
    simulation.add_body(law, 1000.0, samples).unwrap();
    let step = 0.3 * spacing / (1e5_f64 * 1.346 / 1000.0).sqrt();
    Box::new(Scene { simulation, step })
}

impl<E: Element, const D: usize> Stepped for Scene<E, D> {
    fn particles(&self) -> usize {
        self.simulation.particle_count(0)
    }

    fn run(&mut self, steps: usize, threads: usize) -> f64 {
        with_threads(threads, || {
            let start = Instant::now();
            for _ in 0..steps {
                self.simulation.step_unchecked(self.step).unwrap();
            }
            start.elapsed().as_secs_f64() / steps as f64
        })
    }
}
