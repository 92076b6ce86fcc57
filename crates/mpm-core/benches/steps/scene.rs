//! What is stepped: the scenes of `peers/taichi_mpm.py`, and the laws that are compared.

use mechanics_core::lanes::Element;
use mechanics_core::law::Lame;
use mechanics_core::parallel::with_threads;
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::{Matrix3, multiple_of_identity};
use mpm_constitutive::elastic::{FixedCorotated, NeoHookean};
use mpm_constitutive::fluid::{Tait, Tension};
use mpm_constitutive::plastic::{DruckerPrager, FrictionAngle, VonMises, YieldStress};
use mpm_constitutive::{Numbers, PointLaw, StiffnessBound, Strain, Stress, TotalDeformation};
use mpm_core::sampling::{Pattern, SampledBody, sample_shape};
use mpm_core::{
    ImplicitReport, ImplicitStep, MemoryUse, Samples, Shape, Simulation, SimulationOptions, StageTimes,
    Transfer,
};
use std::time::Instant;

/// Nodes along the unit box, and the block's edge in cells.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Size {
    pub(crate) nodes: usize,
    pub(crate) cells: usize,
}

/// 13,824 particles.
pub(crate) const TINY: Size = Size { nodes: 24, cells: 12 };
/// 12,544 particles.
pub(crate) const TINY_PLANE: Size = Size { nodes: 128, cells: 56 };
/// 110,592 particles.
pub(crate) const SMALL: Size = Size { nodes: 64, cells: 24 };
/// 1,000,000 particles.
pub(crate) const LARGE: Size = Size { nodes: 128, cells: 50 };
/// 10,077,696 particles.
pub(crate) const HUGE: Size = Size { nodes: 256, cells: 108 };
/// 200,704 particles.
pub(crate) const PLANE: Size = Size { nodes: 512, cells: 224 };

fn lame() -> Lame {
    Lame::from_young_poisson(1e5, 0.3).unwrap()
}

pub(crate) fn jelly() -> FixedCorotated {
    FixedCorotated::new(lame())
}

pub(crate) fn rubber() -> NeoHookean {
    NeoHookean::new(lame())
}

pub(crate) fn water() -> Tait {
    Tait::new(1e5, 7.0, Tension::Carried).unwrap()
}

pub(crate) fn metal() -> VonMises {
    VonMises::new(lame(), YieldStress::perfect(1e3).unwrap()).unwrap()
}

pub(crate) fn sand() -> DruckerPrager {
    DruckerPrager::new(lame(), FrictionAngle::constant(0.52).unwrap(), 0.0).unwrap()
}

/// A simulation that can be stepped and timed, whatever its law, precision and dimension.
pub(crate) trait Stepped {
    fn particles(&self) -> usize;

    fn memory(&self) -> MemoryUse;

    /// Makes an implicit step of `length` explicit ones on one thread.
    fn implicit(&mut self, length: f64) -> ImplicitReport;

    /// Makes so many steps on so many threads; the time of one and of its stages \[s\].
    fn run(&mut self, steps: usize, threads: usize) -> (f64, StageTimes);
}

struct Scene<E: Element, const D: usize> {
    simulation: Simulation<E, D>,
    step: f64,
}

/// A block of cells with 2^D jittered particles each, spinning and falling.
pub(crate) fn scene<E: Element, const D: usize, L: PointLaw + 'static>(
    law: L,
    size: Size,
) -> Box<dyn Stepped> {
    scene_with::<E, D, L>(law, size, Transfer::default())
}

/// The same with another transfer.
pub(crate) fn scene_with<E: Element, const D: usize, L: PointLaw + 'static>(
    law: L,
    size: Size,
    transfer: Transfer,
) -> Box<dyn Stepped> {
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
    let mut simulation =
        Simulation::<E, D>::new(SimulationOptions { transfer, ..SimulationOptions::new(spacing) }).unwrap();
    let samples = Samples { positions: &positions, velocities: &velocities, volumes: &volumes };
    simulation.add_body(law, 1000.0, samples).unwrap();
    let step = 0.3 * spacing / (1e5_f64 * 1.346 / 1000.0).sqrt();
    Box::new(Scene { simulation, step })
}

impl<E: Element, const D: usize> Stepped for Scene<E, D> {
    fn particles(&self) -> usize {
        self.simulation.particle_count(0)
    }

    fn memory(&self) -> MemoryUse {
        self.simulation.memory_use()
    }

    fn implicit(&mut self, length: f64) -> ImplicitReport {
        let step = length * self.step;
        with_threads(1, || self.simulation.step_implicitly(step, &ImplicitStep::default()).unwrap())
    }

    fn run(&mut self, steps: usize, threads: usize) -> (f64, StageTimes) {
        with_threads(threads, || {
            let mut sum = StageTimes::default();
            let (start, part) = (Instant::now(), 1.0 / steps as f64);
            for _ in 0..steps {
                self.simulation.step_unchecked(self.step).unwrap();
                let stages = self.simulation.stage_times();
                sum.sort += part * stages.sort;
                sum.scatter += part * stages.scatter;
                sum.nodes += part * stages.nodes;
                sum.gather += part * stages.gather;
            }
            (start.elapsed().as_secs_f64() * part, sum)
        })
    }
}

/// Nine numbers that never change, and no stress: what a step costs without a law.
pub(crate) struct Inert;

#[derive(Clone, Copy)]
pub(crate) struct Nine<S>([S; 9]);

impl<S: Scalar> Numbers<S> for Nine<S> {
    const COUNT: usize = 9;

    #[inline(always)]
    fn from_numbers(mut number: impl FnMut(usize) -> S) -> Self {
        let mut numbers = [S::constant(0.0); 9];
        for k in 0..9 {
            numbers[k] = number(k);
        }
        Self(numbers)
    }

    #[inline(always)]
    fn number(&self, k: usize) -> S {
        self.0[k]
    }
}

impl<S: Scalar> Strain<S> for Nine<S> {
    #[inline(always)]
    fn undeformed() -> Self {
        Self([S::constant(0.0); 9])
    }

    #[inline(always)]
    fn advanced(&self, _increment: &Matrix3<S>) -> Self {
        *self
    }

    #[inline(always)]
    fn from_deformation_gradient(_f: &Matrix3<S>) -> Self {
        Self::undeformed()
    }

    #[inline(always)]
    fn volume_ratio(&self) -> S {
        S::constant(1.0)
    }
}

impl PointLaw for Inert {
    type Strain<S: Scalar> = Nine<S>;
    type History<S: Scalar> = ();
    const TOTAL_DEFORMATION: TotalDeformation = TotalDeformation::Meaningless;

    #[inline(always)]
    fn energy_density<S: Scalar>(&self, _strain: &Nine<S>, _history: &()) -> S {
        S::constant(0.0)
    }

    #[inline(always)]
    fn stress<S: Scalar>(&self, _strain: &Nine<S>, _history: &()) -> Stress<S> {
        let zero = S::constant(0.0);
        let stiffness = StiffnessBound { lambda: zero, mu: zero };
        Stress { kirchhoff: multiple_of_identity(zero), stiffness }
    }
}
