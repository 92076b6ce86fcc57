//! What all laws of solids promise: stress is the derivative of the energy, a rotation of space turns it and nothing else, energy is never made.

use crate::experiment::random::Random;
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::picture::{Chart, Curve};
use crate::scene::quantity::Positive;
use mechanics_core::jet::Jet1;
use mechanics_core::law::Lame;
use mechanics_core::state::StateHash;
use mechanics_core::tensor::{Mat3, Matrix3, from_entries};
use mpm_constitutive::elastic::{FixedCorotated, Hencky, NeoHookean};
use mpm_constitutive::plastic::{
    DruckerPrager, FrictionAngle, HerschelBulkley, ModifiedCamClay, NonAssociativeCamClay, Snow, VonMises,
    YieldStress,
};
use mpm_constitutive::{Motion, PointLaw, PointLawError, Strain, fresh_history};
use nalgebra::Rotation3;
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::TAU;

/// A closed path of F, gone round one and a half times; the ladder is the part of the whole way that a step covers.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct LawCycles {
    /// The size of F − I [1].
    strain: Positive,
    /// How long it takes.
    duration_s: Positive,
}

const YOUNG: f64 = 1e6;
const POISSON: f64 = 0.3;
/// How often the path is gone round; not whole, because errors of second order cancel in a round.
const ROUNDS: f64 = 1.5;
/// How often the turned copy is turned meanwhile.
const TURNS: f64 = 3.0;
/// Places along the path where stress is compared with the derivative of the energy.
const PROBES: usize = 20;

impl Experiment for LawCycles {
    fn methods(&self) -> &'static [&'static str] {
        &[
            "neo-Hookean",
            "fixed corotated",
            "Hencky",
            "von Mises",
            "softening",
            "sand",
            "cohesive sand",
            "snow",
            "Cam-Clay",
            "non-associative Cam-Clay",
            "foam",
        ]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        self.by_name(at, clock).map_err(ExperimentError::stopped)?
    }
}

impl LawCycles {
    fn by_name(
        &self,
        at: &Point<'_>,
        clock: &mut Clock,
    ) -> Result<Result<Outcome, ExperimentError>, PointLawError> {
        let lame = Lame::from_young_poisson(YOUNG, POISSON)?;
        let metal = YieldStress::linear(2e4, 1e5)?.saturating(5e4, 12.0)?;
        let plasticine = YieldStress::perfect(4e4)?.saturating(1e4, 8.0)?;
        let hardening = FrictionAngle::hardening([0.61, 0.157, 0.3, 0.174])?;
        let sand = DruckerPrager::new(lame, FrictionAngle::constant(0.6)?, 0.0)?;
        Ok(match at.method {
            "neo-Hookean" => self.round(&NeoHookean::new(lame), at, clock),
            "fixed corotated" => self.round(&FixedCorotated::new(lame), at, clock),
            "Hencky" => self.round(&Hencky::new(lame), at, clock),
            "von Mises" => self.round(&VonMises::new(lame, metal)?, at, clock),
            "softening" => self.round(&VonMises::new(lame, plasticine)?, at, clock),
            "sand" => self.round(&sand, at, clock),
            "cohesive sand" => self.round(&DruckerPrager::new(lame, hardening, 3e3)?, at, clock),
            "snow" => self.round(&Snow::new(lame, 2.5e-2, 7.5e-3, 10.0)?, at, clock),
            "Cam-Clay" => self.round(&ModifiedCamClay::new(lame, 1.1, 0.2, 5e4, 8.0)?, at, clock),
            "non-associative Cam-Clay" => {
                self.round(&NonAssociativeCamClay::new(lame, 1.85, 0.8, 1.5, 0.04)?, at, clock)
            }
            // The only other one of the list.
            _ => self.round(&HerschelBulkley::new(lame, 5e3, 2e3, 0.4)?, at, clock),
        })
    }

    fn round<L: PointLaw>(
        &self,
        law: &L,
        at: &Point<'_>,
        clock: &mut Clock,
    ) -> Result<Outcome, ExperimentError> {
        let steps = (1.0 / at.ladder).round().max(1.0) as usize;
        let path = Path::new(self.strain.value());
        let upright = |s: f64| path.deformation(s);
        let course = clock.time(|| go(law, upright, steps, self.duration_s.value()));
        let turned = go(law, |s| turn(s) * path.deformation(s), steps, self.duration_s.value());
        let (mut twist, mut hash) = (0.0_f64, StateHash::new());
        for (k, (a, b)) in course.stresses.iter().zip(&turned.stresses).enumerate() {
            let q = turn((k + 1) as f64 / steps as f64);
            twist = twist.max((q * a * q.transpose() - b).norm() / YOUNG);
            hash.add("stress", a.as_slice());
        }
        let derivative = (0..PROBES)
            .map(|k| derivative_error(law, &path.deformation(k as f64 / (PROBES as f64 * ROUNDS))))
            .fold(0.0, f64::max);
        // Of an elastic law nothing may be lost either.
        let scale = 0.5 * YOUNG * self.strain.value().powi(2);
        let least = course.dissipation.iter().copied().fold(0.0, f64::min);
        let most = course.dissipation.iter().copied().fold(0.0, f64::max);
        let elastic = ["neo-Hookean", "fixed corotated", "Hencky"].contains(&at.method);
        let energy = if elastic { most.max(-least) } else { least.abs() } / scale;
        let dissipation = course.dissipation[steps - 1] / scale;
        let mut outcome = Outcome::default()
            .error("energy from nothing", energy)
            .error("turned stress", twist)
            .error("stress less derivative of the energy", derivative)
            .count("steps", steps as u64)
            .invariant("dissipated in parts of ½ E ε²", dissipation)
            .state(hash.value());
        let curve = |values: &[f64]| {
            values.iter().enumerate().map(|(k, x)| [(k + 1) as f64 / steps as f64, x / scale]).collect()
        };
        let chart = Chart {
            title: format!("{}: {steps} steps", at.method),
            x: "part of the way".to_owned(),
            y: "in parts of E ε²/2".to_owned(),
            curves: vec![
                Curve::line("work done on the point", curve(&course.work)),
                Curve::line("stored energy", curve(&course.stored)),
                Curve::line("dissipated: work less stored", curve(&course.dissipation)),
            ],
        };
        outcome = outcome.charted(at, "energy along one and a half rounds", &chart)?;
        Ok(outcome)
    }
}

/// F(s) = I + ε [sin(2πrs) A + (1 − cos(2πrs)) B], the shapes A and B at random.
struct Path {
    shapes: [Mat3; 2],
}

impl Path {
    fn new(strain: f64) -> Self {
        let mut random = Random::new(7);
        Self { shapes: std::array::from_fn(|_| random.matrix(1.0).normalize() * strain) }
    }

    fn deformation(&self, s: f64) -> Mat3 {
        let (sine, cosine) = (TAU * ROUNDS * s).sin_cos();
        Mat3::identity() + self.shapes[0] * sine + self.shapes[1] * (1.0 - cosine)
    }
}

/// The rotation of the turned copy.
fn turn(s: f64) -> Mat3 {
    let angle = TAU * TURNS * s;
    Rotation3::from_euler_angles(angle, 0.3 * angle, -0.6 * angle).into_inner()
}

/// What happened along a path, after each step.
#[derive(Default)]
struct Record {
    stresses: Vec<Mat3>,
    work: Vec<f64>,
    stored: Vec<f64>,
    dissipation: Vec<f64>,
}

/// Takes a point along; the work is by the trapezoidal rule, ½(Pₙ + Pₙ₊₁) : (Fₙ₊₁ − Fₙ) with P = τF⁻ᵀ of the whole F.
fn go<L: PointLaw>(law: &L, path: impl Fn(f64) -> Mat3, steps: usize, duration: f64) -> Record {
    let mut strain = L::Strain::<f64>::undeformed();
    let mut history = fresh_history::<L, f64>();
    let (mut f, mut piola, mut work) = (path(0.0), Mat3::zeros(), 0.0);
    let start = law.energy_density(&strain, &history);
    let mut record = Record::default();
    let step = duration / steps as f64;
    for k in 1..=steps {
        let next = path(k as f64 / steps as f64);
        let increment = next * f.try_inverse().unwrap_or_else(Mat3::zeros) - Mat3::identity();
        let (moved, stress) =
            law.advance(&strain, &mut history, &Motion { velocity_gradient: increment / step, step });
        let inverse = next.try_inverse().unwrap_or_else(Mat3::zeros);
        let piola_next = stress.kirchhoff * inverse.transpose();
        work += 0.5 * (piola + piola_next).dot(&(next - f));
        (strain, f, piola) = (moved, next, piola_next);
        let stored = law.energy_density(&strain, &history) - start;
        record.stresses.push(stress.kirchhoff);
        record.work.push(work);
        record.stored.push(stored);
        record.dissipation.push(work - stored);
    }
    record
}

/// ‖τ − (∂ψ/∂F) Fᵀ‖ by E, the derivative by automatic differentiation, of virgin material.
fn derivative_error<L: PointLaw>(law: &L, f: &Mat3) -> f64 {
    let along = |i: usize, j: usize| {
        let moved: Matrix3<Jet1<f64, 1>> = from_entries(|a, b| match (a, b) == (i, j) {
            true => Jet1::variable(f[(a, b)], 0),
            false => Jet1::from_value(f[(a, b)]),
        });
        let strain = L::Strain::<Jet1<f64, 1>>::from_deformation_gradient(&moved);
        law.energy_density(&strain, &fresh_history::<L, Jet1<f64, 1>>()).gradient[0]
    };
    let piola = Mat3::from_fn(along);
    let strain = L::Strain::<f64>::from_deformation_gradient(f);
    let stress = law.stress(&strain, &fresh_history::<L, f64>()).kirchhoff;
    (stress - piola * f.transpose()).norm() / YOUNG
}
