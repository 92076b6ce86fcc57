//! Laws that answer NaN or infinity, at many calls in turn: a step says so and is not made.

#![allow(clippy::print_stdout, reason = "a test prints what it counted")]

use crate::{ball, falling, lame};
use mechanics_core::checkpoint::Checkpoint;
use mechanics_core::parallel::with_threads;
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::{multiple_of_identity, sum};
use mpm_constitutive::elastic::NeoHookean;
use mpm_constitutive::plastic::{VonMises, YieldStress};
use mpm_constitutive::{Curvature, Numbers, PointLaw, Stress, TotalDeformation};
use mpm_core::sampling::SampledBody;
use mpm_core::{Equilibrium, ImplicitStep, MpmError, Samples, Simulation, SimulationOptions};
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

#[derive(Debug, Default)]
struct Switch {
    /// At which calls, and which number.
    lies: Mutex<(Range<u64>, f64)>,
    asked: AtomicU64,
    told: AtomicU64,
}

impl Switch {
    fn set(&self, calls: Range<u64>, number: f64) {
        *self.lies.lock().unwrap() = (calls, number);
        self.asked.store(0, Ordering::Relaxed);
        self.told.store(0, Ordering::Relaxed);
    }

    /// Counts a call; answers the number that is told instead of the truth.
    fn lie(&self) -> Option<f64> {
        let call = self.asked.fetch_add(1, Ordering::Relaxed);
        let lies = self.lies.lock().unwrap();
        let due = lies.0.contains(&call);
        self.told.fetch_add(u64::from(due), Ordering::Relaxed);
        due.then_some(lies.1)
    }
}

/// A law that lies when its switch says so: about stress, energy and its derivatives.
struct Lying<L> {
    law: L,
    switch: Arc<Switch>,
}

impl<L> Lying<L> {
    fn spoilt<S: Scalar>(&self, mut stress: Stress<S>) -> Stress<S> {
        if let Some(number) = self.switch.lie() {
            stress.kirchhoff = sum(&stress.kirchhoff, &multiple_of_identity(S::constant(number)));
        }
        stress
    }
}

impl<L: PointLaw> PointLaw for Lying<L> {
    type Strain<S: Scalar> = L::Strain<S>;
    type History<S: Scalar> = L::History<S>;
    const TOTAL_DEFORMATION: TotalDeformation = L::TOTAL_DEFORMATION;

    fn energy_density<S: Scalar>(&self, strain: &Self::Strain<S>, history: &Self::History<S>) -> S {
        let energy = self.law.energy_density(strain, history);
        self.switch.lie().map_or(energy, |number| energy + S::constant(number))
    }

    fn stress<S: Scalar>(&self, strain: &Self::Strain<S>, history: &Self::History<S>) -> Stress<S> {
        self.spoilt(self.law.stress(strain, history))
    }

    fn return_map<S: Scalar>(
        &self,
        trial: &Self::Strain<S>,
        history: &mut Self::History<S>,
        step: f64,
    ) -> (Self::Strain<S>, Stress<S>) {
        let (strain, stress) = self.law.return_map(trial, history, step);
        (strain, self.spoilt(stress))
    }

    fn energy_gradient(&self, strain: &Self::Strain<f64>, history: &Self::History<f64>) -> Self::Strain<f64> {
        match self.switch.lie() {
            Some(number) => Self::Strain::<f64>::from_numbers(|_| number),
            None => self.law.energy_gradient(strain, history),
        }
    }

    fn energy_curvature(
        &self,
        strain: &Self::Strain<f64>,
        history: &Self::History<f64>,
        projection: mechanics_core::projection::Projection,
    ) -> Curvature {
        match self.switch.lie() {
            Some(number) => Curvature::Volume(number),
            None => self.law.energy_curvature(strain, history, projection),
        }
    }
}

/// A ball that falls and is turned, after a first step.
fn start<L: PointLaw + 'static>(law: L) -> Simulation<f64, 2> {
    let mut simulation = Simulation::new(SimulationOptions::new(0.1)).unwrap();
    simulation.set_gravity([0.0, -9.81]).unwrap();
    let SampledBody { positions, volumes } = ball::<2>([0.0, 0.5], 0.12);
    let mut velocities = falling::<2>(1.0, positions.len());
    velocities.iter_mut().zip(&positions).for_each(|(v, x)| v[0] += 20.0 * x[0]);
    let samples = Samples { positions: &positions, velocities: &velocities, volumes: &volumes };
    simulation.add_body(law, 1000.0, samples).unwrap();
    simulation.step_unchecked(1e-4).unwrap();
    simulation
}

type Step = fn(&mut Simulation<f64, 2>) -> Result<(), MpmError>;

/// Lies at up to `most` calls of a step, spread over all of them, once and from then on. Answers how many steps failed, and how many did not though they were lied to.
fn lie_in_turn<L: PointLaw + 'static>(
    law: L,
    most: u64,
    step: Step,
    survived: impl Fn(&mut Simulation<f64, 2>),
) -> [u32; 2] {
    let switch = Arc::new(Switch::default());
    let mut simulation = start(Lying { law, switch: switch.clone() });
    let before = simulation.checkpoint().to_bytes();
    let again = |simulation: &mut Simulation<f64, 2>| {
        simulation.resume(Checkpoint::from_bytes(&before).unwrap()).unwrap();
    };
    switch.set(0..0, 0.0);
    step(&mut simulation).unwrap();
    let calls = switch.asked.load(Ordering::Relaxed);
    let truth = simulation.checkpoint().to_bytes();
    again(&mut simulation);
    let mut counts = [0, 0];
    for call in (0..calls).step_by(calls.div_ceil(most) as usize) {
        let numbers = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
        for (lasting, number) in numbers.into_iter().flat_map(|number| [(1, number), (u64::MAX / 2, number)])
        {
            switch.set(call..call + lasting, number);
            let outcome = step(&mut simulation);
            let told = switch.told.load(Ordering::Relaxed);
            switch.set(0..0, 0.0);
            match outcome {
                Err(error) => {
                    assert!(told > 0, "{error}");
                    assert!(
                        simulation.checkpoint().to_bytes() == before,
                        "{number} at call {call}: {error} changed the state"
                    );
                    counts[0] += 1;
                }
                Ok(()) => {
                    counts[1] += u32::from(told > 0);
                    if told > 0 {
                        survived(&mut simulation);
                    }
                    again(&mut simulation);
                }
            }
            step(&mut simulation).unwrap();
            assert!(simulation.checkpoint().to_bytes() == truth, "call {call} is not forgotten");
            again(&mut simulation);
        }
    }
    println!("{calls} calls: {counts:?} steps failed and did not");
    counts
}

#[test]
fn explicit_steps_refuse_laws_that_are_no_number() {
    let step: Step = |simulation| simulation.step_unchecked(1e-4).map(drop);
    let [failed, survived] = with_threads(1, || {
        lie_in_turn(NeoHookean::new(lame()), u64::MAX, step, |_| panic!("a NaN of a stress is believed"))
    });
    assert!(failed > 0 && survived == 0);
}

/// The stress of a law that flows is made at the end of a step, in place, and read in the next: a law that fails there has spoilt its particle, and the next step says
/// which body's.
#[test]
fn a_flow_that_is_no_number_is_an_error_of_the_next_step() {
    let step: Step = |simulation| simulation.step_unchecked(1e-4).map(drop);
    let law = VonMises::new(lame(), YieldStress::perfect(1e3).unwrap()).unwrap();
    let [failed, survived] = with_threads(1, || {
        lie_in_turn(law, u64::MAX, step, |simulation| {
            let bytes = simulation.checkpoint().to_bytes();
            let error = simulation.step_unchecked(1e-4).unwrap_err();
            assert!(
                matches!(
                    error,
                    MpmError::Law { body: 0, .. }
                        | MpmError::Particle { body: 0, .. }
                        | MpmError::Node { .. }
                ),
                "{error}"
            );
            assert!(simulation.checkpoint().to_bytes() == bytes);
        })
    });
    assert!(survived > 0, "{failed} failed at once");
}

#[test]
fn implicit_steps_and_equilibria_refuse_laws_that_are_no_number() {
    let step: Step = |simulation| simulation.step_implicitly(5e-3, &ImplicitStep::default()).map(drop);
    let finite = |simulation: &mut Simulation<f64, 2>| {
        let numbers = simulation.positions(0).into_iter().chain(simulation.velocities(0)).flatten();
        assert!(numbers.into_iter().all(f64::is_finite));
        simulation.step_unchecked(1e-5).unwrap();
    };
    let [failed, _] = with_threads(1, || lie_in_turn(NeoHookean::new(lame()), 80, step, finite));
    assert!(failed > 0);
    let step: Step = |simulation| {
        simulation.set_gravity([0.0; 2])?;
        let done = simulation.equilibrate(&Equilibrium::default()).map(drop);
        simulation.set_gravity([0.0, -9.81])?;
        done
    };
    let [failed, survived] = with_threads(1, || lie_in_turn(NeoHookean::new(lame()), 20, step, finite));
    // A step that fails is tried again, shorter: one lie is no reason to give up.
    assert!(failed > 0 && survived > 0, "{failed} {survived}");
}
