//! Consistency of hyperelastic laws: the stress is the derivative of the energy, the stiffness that of the stress.

use super::random::Random;
use super::solid::material::{energy_density, first_piola, lame, stiffness};
use super::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::physics::Isotropic;
use crate::scene::quantity::{Count, Positive};
use mechanics_core::law::{
    FixedCorotated, Hencky, Hyperelastic, NeoHookean, StVenantKirchhoff, StableNeoHookean,
};
use mechanics_core::projection::Projection;
use mechanics_core::state::StateHash;
use mechanics_core::tensor::Mat3;
use schemars::JsonSchema;
use serde::Deserialize;

/// Central differences with the ladder's step, in random directions at random deformations.
///
/// They differ from the derivative by h²/6 times the third derivative, so a consistent law shows order two.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct LawConsistency {
    /// The material's constants.
    constants: Isotropic,
    /// How many deformations.
    deformations: Count,
    /// The largest entry of F − 1 [1].
    largest_strain: Positive,
}

impl Experiment for LawConsistency {
    fn methods(&self) -> &'static [&'static str] {
        &["neo-hookean", "stable-neo-hookean", "fixed-corotated", "saint-venant-kirchhoff", "hencky"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let lame = lame(&self.constants).map_err(ExperimentError::stopped)?;
        Ok(match at.method {
            "neo-hookean" => self.differentiate(&NeoHookean::new(lame), at, clock),
            "stable-neo-hookean" => self.differentiate(&StableNeoHookean::new(lame), at, clock),
            "fixed-corotated" => self.differentiate(&FixedCorotated::new(lame), at, clock),
            "saint-venant-kirchhoff" => self.differentiate(&StVenantKirchhoff::new(lame), at, clock),
            // The only other method of the list.
            _ => self.differentiate(&Hencky::new(lame), at, clock),
        })
    }
}

impl LawConsistency {
    fn differentiate<L: Hyperelastic>(&self, law: &L, at: &Point<'_>, clock: &mut Clock) -> Outcome {
        let mut random = Random::new(at.seed);
        let mut case = || {
            let f = Mat3::identity() + random.matrix(self.largest_strain.value());
            (f, random.matrix(1.0).normalize())
        };
        let cases: Vec<(Mat3, Mat3)> = (0..self.deformations.value()).map(|_| case()).collect();
        let derivatives = |(f, direction): &(Mat3, Mat3)| {
            (first_piola(law, f), stiffness(law, f, Projection::None).apply(direction))
        };
        let found: Vec<(Mat3, Mat3)> = clock.time(|| cases.iter().map(derivatives).collect());
        let (mut stress_error, mut stiffness_error) = (0.0_f64, 0.0_f64);
        let mut hash = StateHash::new();
        for ((f, direction), (stress, stress_rate)) in cases.iter().zip(&found) {
            let (plus, minus) = (f + direction * at.ladder, f - direction * at.ladder);
            let energy_slope = (energy_density(law, &plus) - energy_density(law, &minus)) / (2.0 * at.ladder);
            let stress_slope = (first_piola(law, &plus) - first_piola(law, &minus)) / (2.0 * at.ladder);
            stress_error = stress_error.max((energy_slope - stress.dot(direction)).abs() / self.modulus());
            stiffness_error = stiffness_error.max((stress_slope - stress_rate).norm() / self.modulus());
            hash.add("stress", stress.as_slice());
            hash.add("stress rate", stress_rate.as_slice());
        }
        Outcome::default()
            .error("stress", stress_error)
            .error("stiffness", stiffness_error)
            .count("deformations", self.deformations.value() as u64)
            .state(hash.value())
    }

    fn modulus(&self) -> f64 {
        self.constants.young_modulus_pa.value()
    }
}
