//! What is seen of friction after each step.

use crate::experiment::{ExperimentError, Outcome};
use ipc_friction::{ContactWithFriction, FrictionReport};
use mechanics_core::tensor::Vec3;

/// What friction did, over all steps.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SlipAudit {
    lags: u64,
    most_lags: u64,
    most_pairs: u64,
    /// Relative.
    lag_residual: f64,
    /// Steps whose residual is above the tolerance.
    unsettled: u64,
    /// Largest ‖β‖/(μ_s |λ|).
    of_bound: f64,
    /// Pairs that friction pushed the way they slip.
    along: u64,
}

impl SlipAudit {
    /// Adds what friction did in the step that ended at `x`.
    pub(super) fn add(
        &mut self,
        friction: &ContactWithFriction,
        x: &[Vec3],
    ) -> Result<FrictionReport, ExperimentError> {
        let report = friction.report(x).map_err(ExperimentError::stopped)?;
        self.lags += report.lags;
        self.most_lags = self.most_lags.max(report.lags);
        self.most_pairs = self.most_pairs.max(report.pairs as u64);
        self.lag_residual = self.lag_residual.max(report.relative_lag_residual);
        self.unsettled += u64::from(report.relative_lag_residual > friction.options().lag_tolerance);
        for pair in friction.pairs(x) {
            self.of_bound = self.of_bound.max(pair.force.norm() / pair.bound);
            self.along += u64::from(pair.force.dot(&pair.slip_velocity) > 0.0);
        }
        Ok(report)
    }

    /// `outcome` with it.
    pub(super) fn reported(&self, outcome: Outcome) -> Outcome {
        outcome
            .count("most pairs with friction", self.most_pairs)
            .count("lag passes", self.lags)
            .count("most lag passes in a step", self.most_lags)
            .invariant("unsettled steps", self.unsettled as f64)
            .invariant("lag residual", self.lag_residual)
            .invariant("friction in parts of its bound", self.of_bound)
            .invariant("pairs pushed along their slip", self.along as f64)
    }
}
