//! A bead on a wire in Cartesian coordinates: position, reaction and constraint.

use super::reference::read_json;
use super::{counted, unknown_method};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use lagrangian::constraint::{Composition, Constraints, Holonomic, Rattle};
use lagrangian::integrator::drive;
use lagrangian::systems::Projectile;
use lagrangian::{EulerLagrange, Phase};
use mechanics_core::scalar::Scalar;
use mechanics_core::state::StateHash;
use schemars::JsonSchema;
use serde::Deserialize;

/// A bead on the parabola y = x²/2 under gravity; the ladder is the step h (s).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct BeadOnWire {
    /// A JSON file with samples of 32 digits, relative to the scene.
    reference: String,
}
