//! A particle alone among its nodes, at steps below and above the limit of stability.

use super::super::solver::{Elasticity, Matter};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::picture::{Chart, Curve};
use mechanics_core::tensor::Mat3;
use mpm_constitutive::elastic::NeoHookean;
use mpm_core::{Kernel, MpmError, Samples, Simulation, SimulationOptions, Transfer};
use schemars::JsonSchema;
use serde::Deserialize;

/// One neo-Hookean particle in space, E = 1e5 Pa, ν = 0.3, 1000 kg/m³, a quarter of a cell from a node, swollen by a millionth. With MLS-APIC its strain
/// is an undamped oscillator of ω² = (2μ + 3λ)/(ρ₀ D), D the kernel's second moment; the ladder is h by 2/ω.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ParticleAlone {}

const SPACING: f64 = 0.1;
const DENSITY: f64 = 1000.0;
const SWELLING: f64 = 1e-6;
const STEPS: usize = 20_000;
/// Steps in the picture.
const SEEN: usize = 200;
/// A strain of this size is no vibration any more.
const BROKEN: f64 = 0.1;

/// The particle and 2/ω \[s\].
fn start(kernel: Kernel) -> Result<(Simulation<f64, 3>, f64), ExperimentError> {
    let matter = Matter::new(Elasticity::NeoHookean, (1e5, 0.3), DENSITY)?;
    let moment = if kernel == Kernel::Cubic { 1.0 / 3.0 } else { 0.25 } * SPACING * SPACING;
    let stiffness = 2.0 * matter.lame.mu() + 3.0 * matter.lame.lambda();
    let options = SimulationOptions { spacing: SPACING, kernel, transfer: Transfer::MlsApic };
    let mut simulation = Simulation::new(options).map_err(ExperimentError::stopped)?;
    let samples =
        Samples { positions: &[[0.025, 0.325, -0.075]], velocities: &[[0.0; 3]], volumes: &[1.25e-4] };
    let law = NeoHookean::new(matter.lame);
    let body = simulation.add_body(law, DENSITY, samples).map_err(ExperimentError::stopped)?;
    let swollen = Mat3::identity() * (1.0 + SWELLING);
    simulation.set_deformation_gradients(body, &[swollen]).map_err(ExperimentError::stopped)?;
    Ok((simulation, 2.0 * (DENSITY * moment / stiffness).sqrt()))
}

/// What came of some steps.
#[derive(Default)]
struct Swing {
    /// The largest |J − 1|/3.
    largest: f64,
    /// What stopped them, with whether the state was as before the step that failed.
    stopped: Option<(MpmError, bool)>,
    /// (J − 1)/3 after the first steps.
    seen: Vec<f64>,
}

fn run(simulation: &mut Simulation<f64, 3>, step: f64, clock: &mut Clock) -> Swing {
    let mut swing = Swing::default();
    for _ in 0..STEPS {
        let before = simulation.state_hash();
        if let Err(error) = clock.time(|| simulation.step_unchecked(step)) {
            swing.stopped = Some((error, simulation.state_hash() == before));
            return swing;
        }
        let strain = (simulation.states(0)[0].volume_ratio - 1.0) / 3.0;
        swing.largest = swing.largest.max(strain.abs());
        if swing.seen.len() < SEEN {
            swing.seen.push(strain);
        }
    }
    swing
}

impl Experiment for ParticleAlone {
    fn methods(&self) -> &'static [&'static str] {
        &["quadratic MLS-APIC", "cubic MLS-APIC"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let kernel = if at.method.starts_with("cubic") { Kernel::Cubic } else { Kernel::Quadratic };
        let (mut simulation, limit) = start(kernel)?;
        let stable = simulation.stable_step();
        // What is refused before it is tried.
        let hash = simulation.state_hash();
        let refused = matches!(simulation.step(1.01 * stable), Err(MpmError::Unstable { .. }));
        let untouched = simulation.state_hash() == hash;
        let step = at.ladder * limit;
        let Swing { largest, stopped, seen } = run(&mut simulation, step, clock);
        // Symplectic Euler: ε = A sin(…), A² (1 − (ωh/2)²) is kept where ωh < 2.
        let allowed = SWELLING / (1.0 - at.ladder * at.ladder).max(0.0).sqrt() * 1.001;
        let bounded = largest <= allowed;
        let broken = largest > BROKEN || stopped.is_some();
        let named = stopped.as_ref().is_none_or(|(error, kept)| {
            let culprit = matches!(
                error,
                MpmError::Law { body: 0, particle: 0, .. }
                    | MpmError::Particle { body: 0, particle: 0, .. }
                    | MpmError::OutOfDomain { body: 0, particle: 0, .. }
                    | MpmError::TooFar { body: 0, particle: 0, .. }
            );
            *kept && culprit
        });
        let flag = |holds: bool| f64::from(u8::from(holds));
        let as_theory = if at.ladder < 1.0 { bounded && stopped.is_none() } else { broken };
        let mut outcome = Outcome::default()
            .count("steps", simulation.steps())
            .invariant("kept below the limit, broken above", flag(as_theory))
            .invariant("error names the particle, state as before", flag(named))
            .invariant("stable step by the limit", stable / limit)
            .invariant("a step above the stable one is refused, state as before", flag(refused && untouched))
            .invariant("ended in an error", flag(stopped.is_some()))
            .state(simulation.state_hash());
        if bounded {
            outcome = outcome.invariant("largest strain by the first", largest / SWELLING);
        }
        outcome.simulated_seconds = Some(simulation.time());
        let strains = (1..).zip(&seen).map(|(step, strain)| [f64::from(step), strain / SWELLING]);
        let chart = Chart {
            // The font of pictures has no ω.
            title: format!("{}, {} of the limit of stability", at.method, at.ladder),
            x: "steps".to_owned(),
            y: "strain by the first".to_owned(),
            curves: vec![Curve::line("", strains.collect())],
        };
        outcome.charted(at, "the strain of the particle in its first steps", &chart)
    }
}
