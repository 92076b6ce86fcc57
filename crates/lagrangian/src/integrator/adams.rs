//! Adams' multistep methods for second-order equations.

mod coefficients;

use super::dormand_prince::DormandPrince853;
use super::remainder::Remainder;
use super::{Cost, Integrator, Method, StepReport, Structure, admit};
use crate::coordinates::{Coordinates, Phase};
use crate::error::LagrangianError;
use crate::system::System;
use coefficients::COEFFICIENTS;

/// Adams' predictor–corrector method of `STEPS` steps (1 to 15), of order `STEPS` + 1, with steps of equal size, for q̇ = v,
/// v̇ = a(t, q, v): one or two evaluations of a step, whatever the order.
///
/// **When to use it.** For long smooth arcs at high accuracy, where evaluations are dear: 1e-11 on the regular double
/// pendulum takes a third of the evaluations that [`DormandPrince853`] takes. Not for forces with kinks, events, constraints or stiff
/// springs; and a change of the step size starts it anew, which costs `STEPS` − 1 steps of 24 evaluations.
///
/// **Derivation.** Through the accelerations of the last k = `STEPS` states goes a polynomial of degree k − 1; integrated once it moves the
/// velocity, twice the coordinates (Falkner's formula). With backward differences ∇ʲa, γ_j = ∫₀¹ s(s+1)…(s+j−1)/j! ds and
/// σ_j = ∫₀¹ (1−s) s(s+1)…(s+j−1)/j! ds,
///
/// ```text
/// predict:   v* = v + h Σ_{j<k} γ_j ∇ʲa,    q* = q + h v + h² Σ_{j<k} σ_j ∇ʲa
/// evaluate:  a* = a(t + h, q*, v*)
/// correct:   v' = v* + h γ_k δ,             q' = q* + h² σ_k δ,        δ = a* − (a extrapolated) = ∇ᵏa*
/// ```
///
/// The corrector is Moulton's: its polynomial goes through a* too, and differs from the predictor's by one term. The history keeps a*
/// ([`Evaluations::One`]: predict, evaluate, correct) or is given a(t + h, q', v') instead ([`Evaluations::Two`]).
///
/// **Differences.** With the extrapolated differences ∇ʲâ = Σ_{i≥j} ∇ⁱa, those at t + h are ∇ʲâ + δ: sums of numbers that fall with j, without
/// the large coefficients of alternating sign of the ordinate form. Increments go to the state by compensated sums. So
/// errors of 1e-13 are reached.
///
/// **Start.** The first k − 1 steps are each two half steps of [`DormandPrince853`], whose error, made k − 1 times only, is far below
/// that of the steps that follow.
///
/// **Stability.** The largest ω h for a = −ω² q and the largest c h for a = −c v at which no other root of the method's
/// characteristic polynomial than those of the motion exceeds one:
///
/// | order | ω h, PEC | ω h, PECE | c h, PEC | c h, PECE |
/// |---|---|---|---|---|
/// | 4 | 1.04 | 1.89 | 0.30 | 1.93 |
/// | 6 | 0.60 | 1.59 | 0.086 | 1.04 |
/// | 8 | 0.32 | 1.26 | 0.024 | 0.58 |
/// | 10 | 0.17 | 0.99 | 0.006 | 0.34 |
/// | 11 | 0.12 | 0.87 | 0.002 | 0.26 |
/// | 12 | 0.088 | 0.78 | < 0.002 | 0.21 |
/// | 13 | 0.062 | 0.70 | < 0.002 | 0.060 |
/// | 14 | 0.044 | 0.63 | < 0.002 | 0.026 |
///
/// Beyond it errors grow from step to step, without an error, until numbers overflow: halve h if in doubt and compare. With damping, or
/// velocities in the forces, take [`Evaluations::Two`].
///
/// # Reference
/// Hairer, Nørsett, Wanner 1993, *Solving Ordinary Differential Equations I*, sections III.1 (Adams methods, differences, γ_j),
/// III.5 (extrapolated differences) and III.10 (second-order equations). Falkner 1936, "A method of numerical solution of
/// differential equations", Phil. Mag. 21. Berry, Healy 2004, "Implementation of Gauss–Jackson integration for orbit
/// propagation", J. Astronaut. Sci. 52, on starting, evaluating once or twice, and rounding.
#[derive(Clone, Debug)]
pub struct AdamsBashforthMoulton<const STEPS: usize, C> {
    evaluations: Evaluations,
    starter: DormandPrince853<C>,
    remainder: Remainder<C>,
    history: History<STEPS, C>,
    /// Room for the differences after the step, as extrapolated.
    extrapolated: [C; STEPS],
    /// Room for the next step's Σ γ_j ∇ʲ and Σ σ_j ∇ʲ, as extrapolated.
    slopes: [C; 2],
    /// Room for q* and v*, then for Δq and Δv.
    dq: C,
    dv: C,
    /// Room for a.
    a: C,
}

/// How often a step evaluates the acceleration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Evaluations {
    /// At the predicted state: predict, evaluate, correct (PEC). The cheapest way where h is small for the sake of accuracy; stable
    /// for small h only, where forces depend on velocities.
    One,
    /// At the predicted and at the corrected state (PECE). The robust one.
    #[default]
    Two,
}

/// What a method knows of the steps behind it.
#[derive(Clone, Debug)]
struct History<const STEPS: usize, C> {
    /// Accelerations known, up to STEPS.
    known: usize,
    /// The size of the last step.
    step: f64,
    /// ∇ʲa for j below `known`.
    differences: [C; STEPS],
    /// Σ γ_j ∇ʲa and Σ σ_j ∇ʲa, once all are known.
    slopes: [C; 2],
}

/// Half steps of the starting method in a step.
const SUBSTEPS: u32 = 2;

const NAMES: [&str; 16] = [
    "Adams–Bashforth–Moulton",
    "Adams–Bashforth–Moulton 2",
    "Adams–Bashforth–Moulton 3",
    "Adams–Bashforth–Moulton 4",
    "Adams–Bashforth–Moulton 5",
    "Adams–Bashforth–Moulton 6",
    "Adams–Bashforth–Moulton 7",
    "Adams–Bashforth–Moulton 8",
    "Adams–Bashforth–Moulton 9",
    "Adams–Bashforth–Moulton 10",
    "Adams–Bashforth–Moulton 11",
    "Adams–Bashforth–Moulton 12",
    "Adams–Bashforth–Moulton 13",
    "Adams–Bashforth–Moulton 14",
    "Adams–Bashforth–Moulton 15",
    "Adams–Bashforth–Moulton 16",
];

impl<const STEPS: usize, C: Coordinates> AdamsBashforthMoulton<STEPS, C> {
    /// γ_j or σ_j summed over the differences: what one δ, added to all of them, adds to their weighted sum.
    const SUMS: [f64; 2] = [sum(&COEFFICIENTS.velocity, STEPS), sum(&COEFFICIENTS.position, STEPS)];

    /// The method with two evaluations a step, with room for the coordinates of `system`.
    ///
    /// # Panics
    /// If `STEPS` is zero or above 15.
    pub fn new<S: System<Coordinates = C>>(system: &S) -> Self {
        assert!((1..=15).contains(&STEPS), "Adams methods have 1 to 15 steps");
        let zeros = || C::zeros(system.dimension());
        Self {
            evaluations: Evaluations::Two,
            starter: DormandPrince853::new(system),
            remainder: Remainder::new(system.dimension()),
            history: History {
                known: 0,
                step: 0.0,
                differences: std::array::from_fn(|_| zeros()),
                slopes: [zeros(), zeros()],
            },
            extrapolated: std::array::from_fn(|_| zeros()),
            slopes: [zeros(), zeros()],
            dq: zeros(),
            dv: zeros(),
            a: zeros(),
        }
    }

    /// The same with one or two evaluations a step.
    pub fn with_evaluations(mut self, evaluations: Evaluations) -> Self {
        self.evaluations = evaluations;
        self
    }

    /// Whether a step `h` from `phase` can use the history: it continues the last step, and is as long but for rounding of
    /// times.
    #[inline]
    fn continues(&self, phase: &Phase<C>, h: f64) -> bool {
        let rounding = 4.0 * f64::EPSILON * (phase.time.abs() + h);
        self.history.known > 0
            && (h - self.history.step).abs() <= rounding
            && self.remainder.continues(phase, h)
    }

    /// A step of the starting method, and one more acceleration for the history.
    #[cold]
    fn start<S: System<Coordinates = C>>(
        &mut self,
        system: &S,
        phase: &mut Phase<C>,
        h: f64,
        known: usize,
    ) -> Result<StepReport, LagrangianError> {
        let mut report = StepReport::default();
        let (mut moving, mut starter) = (phase.clone(), self.starter.clone());
        for _ in 0..SUBSTEPS {
            report += starter.step(system, &mut moving, h / f64::from(SUBSTEPS))?;
        }
        moving.time = phase.time + h;
        system.acceleration(moving.time, &moving.q, &moving.v, &mut self.a)?;
        report.evaluations += 1;
        if known == 0 {
            system.acceleration(phase.time, &phase.q, &phase.v, &mut self.dq)?;
            report.evaluations += 1;
            self.history.differences[0].clone_from(&self.dq);
        }
        let known = known.max(1);
        self.history.push(known, &mut self.a);
        (self.history.known, self.history.step) = ((known + 1).min(STEPS), h);
        self.starter = starter;
        self.remainder.restart(&moving);
        *phase = moving;
        Ok(report)
    }

    /// The extrapolated differences and their weighted sums, which do not wait for an evaluation.
    #[inline]
    fn extrapolate(&mut self) {
        for i in 0..self.a.as_ref().len() {
            let (mut sum, mut velocity, mut position) = (0.0, 0.0, 0.0);
            for j in (0..STEPS).rev() {
                sum += self.history.differences[j].as_ref()[i];
                self.extrapolated[j].as_mut()[i] = sum;
                velocity += COEFFICIENTS.velocity[j] * sum;
                position += COEFFICIENTS.position[j] * sum;
            }
            self.slopes[0].as_mut()[i] = velocity;
            self.slopes[1].as_mut()[i] = position;
        }
    }

    /// Sets q* and v*.
    #[inline]
    fn predict(&mut self, phase: &Phase<C>, h: f64) {
        let [velocity, position] = &self.history.slopes;
        for i in 0..self.a.as_ref().len() {
            let v = phase.v.as_ref()[i];
            self.dq.as_mut()[i] = phase.q.as_ref()[i] + h * (v + h * position.as_ref()[i]);
            self.dv.as_mut()[i] = v + h * velocity.as_ref()[i];
        }
    }

    /// Sets the increments Δq and Δv from a*.
    #[inline]
    fn correct(&mut self, phase: &Phase<C>, h: f64) {
        let [velocity, position] = &self.history.slopes;
        for i in 0..self.a.as_ref().len() {
            let delta = self.a.as_ref()[i] - self.extrapolated[0].as_ref()[i];
            let of_q = position.as_ref()[i] + COEFFICIENTS.position[STEPS] * delta;
            let of_v = velocity.as_ref()[i] + COEFFICIENTS.velocity[STEPS] * delta;
            self.dq.as_mut()[i] = h * (phase.v.as_ref()[i] + h * of_q);
            self.dv.as_mut()[i] = h * of_v;
        }
    }

    /// Takes the acceleration at the end of the step into the history.
    #[inline]
    fn remember(&mut self) {
        let History { differences, slopes, .. } = &mut self.history;
        for i in 0..self.a.as_ref().len() {
            let delta = self.a.as_ref()[i] - self.extrapolated[0].as_ref()[i];
            for j in 0..STEPS {
                differences[j].as_mut()[i] = self.extrapolated[j].as_ref()[i] + delta;
            }
            for k in 0..2 {
                slopes[k].as_mut()[i] = self.slopes[k].as_ref()[i] + Self::SUMS[k] * delta;
            }
        }
    }
}

impl<const STEPS: usize, C: Coordinates> History<STEPS, C> {
    /// Takes in one more acceleration after the first `known` ones: ∇ʲ⁺¹a' = ∇ʲa' − ∇ʲa. `a` is overwritten.
    fn push(&mut self, known: usize, a: &mut C) {
        for j in 0..(known + 1).min(STEPS) {
            for (new, old) in a.as_mut().iter_mut().zip(self.differences[j].as_mut()) {
                let difference = if j < known { *new - *old } else { 0.0 };
                *old = std::mem::replace(new, difference);
            }
        }
        for i in 0..a.as_ref().len() {
            let weigh = |weights: &[f64]| {
                let terms = self.differences.iter().zip(weights).rev();
                terms.map(|(difference, weight)| weight * difference.as_ref()[i]).sum()
            };
            let (velocity, position) = (weigh(&COEFFICIENTS.velocity), weigh(&COEFFICIENTS.position));
            self.slopes[0].as_mut()[i] = velocity;
            self.slopes[1].as_mut()[i] = position;
        }
    }
}

/// The sum of the first `count`.
const fn sum(terms: &[f64], count: usize) -> f64 {
    let (mut sum, mut j) = (0.0, count);
    while j > 0 {
        j -= 1;
        sum += terms[j];
    }
    sum
}

impl<const STEPS: usize, C: Coordinates, S: System<Coordinates = C>> Integrator<S>
    for AdamsBashforthMoulton<STEPS, C>
{
    fn method(&self) -> Method {
        Method {
            name: NAMES[STEPS],
            order: STEPS as u32 + 1,
            structure: Structure::General,
            cost: Cost::Explicit {
                evaluations: match self.evaluations {
                    Evaluations::One => 1,
                    Evaluations::Two => 2,
                },
            },
        }
    }

    fn step(&mut self, system: &S, phase: &mut Phase<C>, h: f64) -> Result<StepReport, LagrangianError> {
        admit(phase, h)?;
        let known = if self.continues(phase, h) { self.history.known } else { 0 };
        if known < STEPS {
            return self.start(system, phase, h, known);
        }
        self.predict(phase, h);
        self.extrapolate();
        let end = phase.time + h;
        system.acceleration(end, &self.dq, &self.dv, &mut self.a)?;
        self.correct(phase, h);
        let sum = self.remainder.sum(phase, h, &self.dq, &self.dv)?;
        let mut report = StepReport { evaluations: 1, ..StepReport::default() };
        if self.evaluations == Evaluations::Two {
            system.acceleration(end, &sum.phase.q, &sum.phase.v, &mut self.a)?;
            report.evaluations = 2;
        }
        self.remainder.keep(sum, end, phase);
        self.remember();
        self.history.step = h;
        Ok(report)
    }
}
