//! A simulation of either precision, behind one name: what makes experiments free of generics over precisions and laws.

use super::cloud::Cloud;
use super::method::{Method, Precision};
use crate::experiment::{ExperimentError, Outcome};
use mechanics_core::diagnostics::CompensatedSum;
use mechanics_core::law::Lame;
use mechanics_core::samples::DeformationSamples;
use mechanics_core::tensor::Mat3;
use mpm_constitutive::elastic::{FixedCorotated, Hencky, NeoHookean};
use mpm_core::{
    Boundary, DeformationBuffer, Equilibrium, EquilibriumReport, ImplicitReport, ImplicitStep, MpmError,
    PointState, PrescribedVelocity, Samples, Simulation, SimulationOptions, StepReport, Totals, Traction,
};
use schemars::JsonSchema;
use serde::Deserialize;

/// An elastic law of large strains.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Elasticity {
    /// P = 2μ(F − R) + λ(J − 1)JF⁻ᵀ.
    FixedCorotated,
    /// τ = 2με + λ tr(ε) I, ε = ½ ln FFᵀ.
    Hencky,
    /// P = μ(F − F⁻ᵀ) + λ ln J F⁻ᵀ.
    NeoHookean,
}

/// What a body is made of.
#[derive(Clone, Copy, Debug)]
pub(super) struct Matter {
    pub(super) law: Elasticity,
    pub(super) lame: Lame,
    /// At rest \[kg/m³\].
    pub(super) density: f64,
}

impl Matter {
    /// Of Young's modulus \[Pa\] and Poisson's ratio.
    pub(super) fn new(
        law: Elasticity,
        (young, poisson): (f64, f64),
        density: f64,
    ) -> Result<Self, ExperimentError> {
        let lame = Lame::from_young_poisson(young, poisson).map_err(ExperimentError::stopped)?;
        Ok(Self { law, lame, density })
    }

    /// √((λ + 2μ)/ρ₀), the speed of longitudinal waves at rest \[m/s\].
    pub(super) fn wave_speed(&self) -> f64 {
        ((self.lame.lambda() + 2.0 * self.lame.mu()) / self.density).sqrt()
    }
}

/// A simulation in one of the precisions.
pub(super) enum Solver<const D: usize> {
    Double(Simulation<f64, D>),
    Single(Simulation<f32, D>),
}

/// The same work on either simulation.
macro_rules! each {
    ($solver:expr, $simulation:ident => $work:expr) => {
        match $solver {
            Solver::Double($simulation) => $work,
            Solver::Single($simulation) => $work,
        }
    };
}

impl<const D: usize> Solver<D> {
    /// An empty space with nodes `spacing` \[m\] apart.
    pub(super) fn new(method: Method, spacing: f64) -> Result<Self, ExperimentError> {
        let options = SimulationOptions { spacing, kernel: method.kernel, transfer: method.transfer };
        let solver = match method.precision {
            Precision::Double => Simulation::new(options).map(Self::Double),
            Precision::Single => Simulation::new(options).map(Self::Single),
        };
        solver.map_err(ExperimentError::stopped)
    }

    /// Adds a body, undeformed at its positions.
    pub(super) fn add_body(
        &mut self,
        matter: &Matter,
        samples: Samples<'_, D>,
    ) -> Result<usize, ExperimentError> {
        let Matter { law, lame, density } = *matter;
        let body = each!(self, simulation => match law {
            Elasticity::FixedCorotated => simulation.add_body(FixedCorotated::new(lame), density, samples),
            Elasticity::Hencky => simulation.add_body(Hencky::new(lame), density, samples),
            Elasticity::NeoHookean => simulation.add_body(NeoHookean::new(lame), density, samples),
        });
        body.map_err(ExperimentError::stopped)
    }

    /// Adds a body at rest.
    pub(super) fn add_cloud(&mut self, matter: &Matter, cloud: &Cloud<D>) -> Result<usize, ExperimentError> {
        let velocities = vec![[0.0; D]; cloud.points.len()];
        let samples = Samples { positions: &cloud.points, velocities: &velocities, volumes: &cloud.volumes };
        self.add_body(matter, samples)
    }

    pub(super) fn set_gravity(&mut self, gravity: [f64; D]) -> Result<(), ExperimentError> {
        each!(self, s => s.set_gravity(gravity)).map_err(ExperimentError::stopped)
    }

    pub(super) fn add_boundary(&mut self, boundary: Boundary<D>) -> Result<(), ExperimentError> {
        each!(self, s => s.add_boundary(boundary)).map_err(ExperimentError::stopped)
    }

    pub(super) fn add_prescribed_velocity(
        &mut self,
        prescribed: PrescribedVelocity<D>,
    ) -> Result<(), ExperimentError> {
        each!(self, s => s.add_prescribed_velocity(prescribed)).map_err(ExperimentError::stopped)
    }

    pub(super) fn add_traction(
        &mut self,
        body: usize,
        traction: Traction<D>,
        surface: &[(usize, [f64; D])],
    ) -> Result<(), ExperimentError> {
        each!(self, s => s.add_traction(body, traction, surface)).map_err(ExperimentError::stopped)
    }

    pub(super) fn set_velocity_gradients(
        &mut self,
        body: usize,
        gradients: &[[[f64; D]; D]],
    ) -> Result<(), ExperimentError> {
        each!(self, s => s.set_velocity_gradients(body, gradients)).map_err(ExperimentError::stopped)
    }

    pub(super) fn set_deformation_gradients(
        &mut self,
        body: usize,
        gradients: &[Mat3],
    ) -> Result<(), ExperimentError> {
        each!(self, s => s.set_deformation_gradients(body, gradients)).map_err(ExperimentError::stopped)
    }

    /// A body force for the step that follows: an acceleration \[m/s²\] a particle.
    pub(super) fn accelerate(
        &mut self,
        body: usize,
        accelerations: &[[f64; D]],
        step: f64,
    ) -> Result<(), ExperimentError> {
        each!(self, s => s.accelerate(body, accelerations, step)).map_err(ExperimentError::stopped)
    }

    /// A step of whatever length; [`stable_step`](Self::stable_step) is for the experiment to heed.
    pub(super) fn step(&mut self, step: f64) -> Result<StepReport, MpmError> {
        each!(self, s => s.step_unchecked(step))
    }

    /// An implicit step, solved to a millionth of the speed that matters.
    pub(super) fn step_implicitly(&mut self, step: f64) -> Result<ImplicitReport, ExperimentError> {
        each!(self, s => s.step_implicitly(step, &ImplicitStep::default())).map_err(ExperimentError::stopped)
    }

    /// Moves all matter to rest, by implicit steps: to within 1e-8 of its weight.
    pub(super) fn equilibrate(&mut self) -> Result<EquilibriumReport, ExperimentError> {
        let options = Equilibrium { imbalance: 1e-8, ..Equilibrium::default() };
        each!(self, s => s.equilibrate(&options)).map_err(ExperimentError::stopped)
    }

    /// The longest step that is stable now \[s\].
    pub(super) fn stable_step(&mut self) -> f64 {
        each!(self, s => s.stable_step())
    }

    pub(super) fn time(&self) -> f64 {
        each!(self, s => s.time())
    }

    pub(super) fn positions(&self, body: usize) -> Vec<[f64; D]> {
        each!(self, s => s.positions(body))
    }

    pub(super) fn velocities(&self, body: usize) -> Vec<[f64; D]> {
        each!(self, s => s.velocities(body))
    }

    pub(super) fn states(&self, body: usize) -> Vec<PointState> {
        each!(self, s => s.states(body))
    }

    pub(super) fn totals(&self, body: usize) -> Totals {
        each!(self, s => s.totals(body))
    }

    /// Places and total deformation gradients of a body's particles, in a buffer of the caller.
    pub(super) fn deformation_samples<'a>(
        &self,
        body: usize,
        buffer: &'a mut DeformationBuffer,
    ) -> Result<DeformationSamples<'a>, ExperimentError> {
        each!(self, s => s.deformation_samples(body, buffer)).map_err(ExperimentError::stopped)
    }

    fn state_hash(&self) -> u64 {
        each!(self, s => s.state_hash())
    }

    fn counts(&self) -> (usize, u64) {
        each!(self, s => ((0..s.body_count()).map(|body| s.particle_count(body)).sum(), s.steps()))
    }

    /// `outcome` with what every run has: steps, particles, simulated time, the state's hash, the smallest det F.
    pub(super) fn counted(&self, outcome: Outcome) -> Outcome {
        let (particles, steps) = self.counts();
        let bodies = each!(self, s => s.body_count());
        let smallest = (0..bodies)
            .flat_map(|body| self.states(body))
            .fold(f64::INFINITY, |smallest, state| smallest.min(state.volume_ratio));
        let mut outcome = outcome
            .count("particles", particles as u64)
            .count("steps", steps)
            .count("particle steps", particles as u64 * steps)
            .invariant("smallest det F", smallest)
            .state(self.state_hash());
        outcome.simulated_seconds = Some(self.time());
        outcome
    }
}

/// Mass, momentum and the length of steps, watched from the start of a run: what is kept whatever the error.
pub(super) struct Watch {
    mass: f64,
    momentum: [f64; 3],
    /// The largest √(2 M K) there has been, which is at least Σ m ‖v‖, and Σ m |b| h of what has acted \[kg m/s\].
    size: f64,
    impulses: [CompensatedSum; 3],
    worst_mass: f64,
    worst_momentum: f64,
    longest: f64,
}

impl Watch {
    /// From the state of body 0 now.
    pub(super) fn start<const D: usize>(solver: &Solver<D>) -> Self {
        let totals = solver.totals(0);
        let momentum: [f64; 3] = totals.momentum.into();
        Self {
            mass: totals.mass,
            momentum,
            size: bustle(&totals),
            impulses: [CompensatedSum::new(); 3],
            worst_mass: 0.0,
            worst_momentum: 0.0,
            longest: 0.0,
        }
    }

    /// That a body force acts: Σ m b h is what momentum must change by.
    pub(super) fn push<const D: usize>(
        &mut self,
        matter: &Matter,
        cloud: &Cloud<D>,
        accelerations: &[[f64; D]],
        step: f64,
    ) {
        for (volume, b) in cloud.volumes.iter().zip(accelerations) {
            let impulse = matter.density * volume * step;
            for axis in 0..D {
                self.impulses[axis].add(impulse * b[axis]);
                self.size += (impulse * b[axis]).abs();
            }
        }
    }

    /// Compares the state now, and `step` with the longest stable one.
    pub(super) fn look<const D: usize>(&mut self, solver: &mut Solver<D>, step: f64) {
        let totals = solver.totals(0);
        self.worst_mass = self.worst_mass.max((totals.mass / self.mass - 1.0).abs());
        let momentum: [f64; 3] = totals.momentum.into();
        self.size = self.size.max(bustle(&totals));
        let defect = |a: usize| momentum[a] - self.momentum[a] - self.impulses[a].value();
        let defect = (0..3).map(|a| defect(a).powi(2)).sum::<f64>().sqrt();
        self.worst_momentum = self.worst_momentum.max(defect / self.size.max(f64::MIN_POSITIVE));
        self.longest = self.longest.max(step / solver.stable_step());
    }

    /// `outcome` with the invariants of a body on which nothing acts but what was [pushed](Self::push).
    pub(super) fn free(&self, outcome: Outcome) -> Outcome {
        self.held(outcome).invariant("momentum that no force gave", self.worst_momentum)
    }

    /// `outcome` with the invariants of a body that something holds.
    pub(super) fn held(&self, outcome: Outcome) -> Outcome {
        outcome
            .invariant("change of mass", self.worst_mass)
            .invariant("longest step by the stable one", self.longest)
    }
}

/// √(2 M K) \[kg m/s\].
fn bustle(totals: &Totals) -> f64 {
    (2.0 * totals.mass * totals.kinetic_energy).sqrt()
}
