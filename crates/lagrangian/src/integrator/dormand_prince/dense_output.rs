//! The motion within a step, as a polynomial.

use crate::coordinates::{Coordinates, Phase};

/// The motion from the start to the end of one step, to order 7: for θ = (t − t₀)/h and each coordinate and velocity
///
/// ```text
/// y(θ) = r₀ + θ (r₁ + (1−θ)(r₂ + θ (r₃ + (1−θ)(r₄ + θ (r₅ + (1−θ)(r₆ + θ r₇))))))
/// ```
///
/// r₀ … r₃ match values and slopes at both ends, so that consecutive steps join with continuous first derivatives;
/// r₄ … r₇ are combinations of the stages.
///
/// # Reference
/// Hairer, Nørsett, Wanner 1993, *Solving Ordinary Differential Equations I*, section II.6.
#[derive(Clone, Debug, PartialEq)]
pub struct DenseStep<C> {
    pub(super) start: f64,
    pub(super) end: f64,
    pub(super) q: [C; 8],
    pub(super) v: [C; 8],
}

impl<C: Coordinates> DenseStep<C> {
    /// Where the step begins \[s\].
    pub fn start(&self) -> f64 {
        self.start
    }

    /// Where the step ends \[s\].
    pub fn end(&self) -> f64 {
        self.end
    }

    /// The state at time `t` \[s\], which should lie within the step: outside, this extrapolates.
    pub fn at(&self, t: f64) -> Phase<C> {
        let theta = (t - self.start) / (self.end - self.start);
        Phase { time: t, q: blend(&self.q, theta), v: blend(&self.v, theta) }
    }
}

/// The polynomial with coefficients `r` at θ.
fn blend<C: Coordinates>(r: &[C; 8], theta: f64) -> C {
    let rest = 1.0 - theta;
    let mut y = r[7].clone();
    for (i, y) in y.as_mut().iter_mut().enumerate() {
        for k in (0..7).rev() {
            *y = r[k].as_ref()[i] + if k % 2 == 0 { theta } else { rest } * *y;
        }
    }
    y
}

/// A motion that can be asked for the state at any time in it.
#[derive(Clone, Debug, PartialEq)]
pub struct DenseTrajectory<C> {
    steps: Vec<DenseStep<C>>,
}

impl<C: Coordinates> DenseTrajectory<C> {
    pub(super) fn new(steps: Vec<DenseStep<C>>) -> Self {
        Self { steps }
    }

    /// The steps, in order; none if the motion had no length.
    pub fn steps(&self) -> &[DenseStep<C>] {
        &self.steps
    }

    /// The state at time `t` \[s\], if that is in the motion.
    pub fn at(&self, t: f64) -> Option<Phase<C>> {
        let index = self.steps.partition_point(|step| step.end < t);
        self.steps.get(index).filter(|step| step.start <= t).map(|step| step.at(t))
    }
}
