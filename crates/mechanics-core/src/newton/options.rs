//! How to minimise.

/// How long and how exactly to minimise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewtonOptions {
    /// Converged when the step norm is below: `a ‖p‖∞` [m/s], `‖p‖∞` [m] in statics.
    pub tolerance: f64,
    /// Steps after which not having converged is an error.
    pub max_iterations: u32,
    /// How accurately directions are solved.
    pub forcing: Forcing,
    /// A step norm this many times the first one is an error.
    pub divergence: f64,
}

impl Default for NewtonOptions {
    /// Tolerance 1e-6, 100 iterations, exact directions, divergence at 1e12.
    fn default() -> Self {
        Self { tolerance: 1e-6, max_iterations: 100, forcing: Forcing::Exact, divergence: 1e12 }
    }
}

/// How accurately the linear system of each direction is solved: ‖g + H p‖ ≤ η ‖g‖.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Forcing {
    /// As well as the solver does by itself.
    #[default]
    Exact,
    /// The same η always; convergence is linear with it.
    Constant(f64),
    /// Choice 2 of Eisenstat and Walker (1996), η = 0.9 (‖g‖ / ‖g before‖)², with their safeguard: η is not let
    /// fall below 0.9 times the square of its last value while that is above 0.1. Convergence is of order two.
    EisenstatWalker {
        /// η of the first direction.
        first: f64,
        /// η is never larger.
        largest: f64,
    },
}

/// Which option is out of range.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum OptionsError {
    /// A tolerance is positive and finite.
    #[error("the tolerance must be positive and finite, not {0}")]
    Tolerance(f64),
    /// A forcing term lies between zero and one.
    #[error("a forcing term must lie between 0 and 1, not at {0}")]
    Forcing(f64),
    /// A divergence factor is larger than one.
    #[error("the divergence factor must be larger than one, not {0}")]
    Divergence(f64),
}

impl NewtonOptions {
    /// Checks the ranges of all options.
    ///
    /// # Errors
    /// The first option that is out of range.
    pub fn validate(&self) -> Result<(), OptionsError> {
        if !(self.tolerance.is_finite() && self.tolerance > 0.0) {
            return Err(OptionsError::Tolerance(self.tolerance));
        }
        if self.divergence.is_nan() || self.divergence <= 1.0 {
            return Err(OptionsError::Divergence(self.divergence));
        }
        let terms = match self.forcing {
            Forcing::Exact => [0.5, 0.5],
            Forcing::Constant(term) => [term, term],
            Forcing::EisenstatWalker { first, largest } => [first, largest],
        };
        match terms.into_iter().find(|term| !(*term > 0.0 && *term < 1.0)) {
            Some(term) => Err(OptionsError::Forcing(term)),
            None => Ok(()),
        }
    }
}

impl Forcing {
    /// η of the next direction from the last one and ‖g‖ / ‖g before‖; zero for an exact solve.
    pub(super) fn next(self, last: f64, ratio: Option<f64>) -> f64 {
        match (self, ratio) {
            (Self::Exact, _) => 0.0,
            (Self::Constant(term), _) => term,
            (Self::EisenstatWalker { first, largest }, None) => first.min(largest),
            (Self::EisenstatWalker { largest, .. }, Some(ratio)) => {
                let wanted = 0.9 * ratio * ratio;
                let guard = 0.9 * last * last;
                let term = if guard > 0.1 { wanted.max(guard) } else { wanted };
                term.clamp(f64::EPSILON, largest)
            }
        }
    }
}
