//! Quasi-static solves: the state of rest under load, directly.

use super::implicit::Regime;
use super::{Simulation, compiled};
use crate::MpmError;
use crate::body::Travel;
use crate::implicit::{ImplicitError, ImplicitStep};
use crate::material::Stiffness;
use crate::particles::Particles;
use mechanics_core::lanes::Element;

/// How equilibrium is searched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equilibrium {
    /// How each step is solved.
    pub solve: ImplicitStep,
    /// The acceleration that forces may leave, as a part of the largest one met (gravity's at least).
    pub imbalance: f64,
    /// Steps after which not having arrived is an error.
    pub max_steps: u32,
}

impl Default for Equilibrium {
    /// One millionth, 100 steps.
    fn default() -> Self {
        Self { solve: ImplicitStep::default(), imbalance: 1e-6, max_steps: 100 }
    }
}

/// What a search for equilibrium did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EquilibriumReport {
    /// Steps made.
    pub steps: u32,
    /// Steps that failed and were tried again, shorter.
    pub retries: u32,
    /// Newton iterations of all.
    pub iterations: u64,
    /// Products of all.
    pub products: u64,
    /// The acceleration that is left \[m/s²\].
    pub imbalance: f64,
}

/// The first step, in explicit ones.
const FIRST: f64 = 10.0;
/// How much longer the next step is.
const GROWTH: f64 = 4.0;
/// Steps no longer than this many first ones: beyond, inertia holds nothing.
const LONGEST: f64 = 1e5;
/// How often a step is tried again.
const MOST_RETRIES: u32 = 30;

/// What is given back where something fails.
pub(super) struct Kept<E, const D: usize> {
    particles: Vec<Particles<E, D>>,
    sorted: bool,
    limits: Option<(Stiffness, Travel)>,
}

impl<E: Element, const D: usize> Simulation<E, D> {
    /// Moves all matter to rest under gravity, tractions and boundaries as they are now; time does not pass.
    ///
    /// From rest, implicit steps of growing length h, after each of which velocities are taken away: x minimises m‖Δx‖²/2h² plus the energy of
    /// stress and loads (a proximal point method: each step is a load step, and inertia only keeps it from going too far). What forces are left
    /// is m v/h, so the search ends when no particle has ‖v‖/h above [`Equilibrium::imbalance`] times the largest met. A step that fails is tried
    /// again at a quarter of its length. Plastic flow follows the path of the steps.
    ///
    /// # Errors
    /// [`ImplicitError::NoEquilibrium`] within [`MpmError::Implicit`] if steps run out, and what a step gives when shorter ones do not help. The
    /// state is then as it was.
    pub fn equilibrate(&mut self, options: &Equilibrium) -> Result<EquilibriumReport, MpmError> {
        let (what, value) = ("the imbalance of an equilibrium", options.imbalance);
        if !(value > 0.0 && value.is_finite()) {
            return Err(MpmError::Number { what, value });
        }
        if self.bodies.is_empty() {
            return Err(MpmError::EmptyBody);
        }
        let kept = self.keep();
        let found = self.relax(options);
        match &found {
            Ok(_) => self.stop(),
            Err(_) => self.put_back(kept),
        }
        found
    }

    fn relax(&mut self, options: &Equilibrium) -> Result<EquilibriumReport, MpmError> {
        self.stop();
        let first = FIRST * self.stable_step();
        if !first.is_finite() {
            return Err(self.culprit(None));
        }
        let mut step = first;
        let mut report = EquilibriumReport::default();
        let mut largest = self.gravity.iter().map(|g| g * g).sum::<f64>().sqrt();
        while report.steps < options.max_steps {
            self.stop();
            match compiled::implicit_step(self, step, &options.solve, Regime::Rest) {
                Ok(done) => {
                    report.steps += 1;
                    report.iterations += done.iterations;
                    report.products += done.products;
                    report.imbalance = done.step.speed / step;
                    largest = largest.max(report.imbalance);
                    if report.imbalance <= options.imbalance * largest {
                        return Ok(report);
                    }
                    step = (GROWTH * step).min(LONGEST * first);
                }
                Err(error) => {
                    report.retries += 1;
                    if report.retries > MOST_RETRIES {
                        return Err(error);
                    }
                    step /= GROWTH;
                }
            }
        }
        let wanted = options.imbalance * largest;
        let (steps, imbalance) = (report.steps, report.imbalance);
        Err(ImplicitError::NoEquilibrium { steps, imbalance, wanted }.into())
    }

    /// Takes all velocities away.
    fn stop(&mut self) {
        for body in &mut self.bodies {
            let layout = body.particles.layout;
            for slot in 0..body.particles.ids.len() {
                for k in layout.velocity..layout.strain {
                    body.particles.set_number(slot, k, E::default());
                }
            }
        }
        self.limits = None;
    }

    /// A copy of what changes.
    pub(super) fn keep(&self) -> Kept<E, D> {
        Kept {
            particles: self.bodies.iter().map(|body| body.particles.clone()).collect(),
            sorted: self.sorted,
            limits: self.limits,
        }
    }

    /// The state as it was.
    pub(super) fn put_back(&mut self, kept: Kept<E, D>) {
        for (body, particles) in self.bodies.iter_mut().zip(kept.particles) {
            body.particles = particles;
            body.place_pieces();
        }
        self.sorted = kept.sorted;
        if kept.sorted {
            self.rebuild();
        }
        self.limits = kept.limits;
    }
}
