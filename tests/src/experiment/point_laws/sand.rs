//! Sand: triaxial compression, confined compression and unloading, opening and closing.

use super::drive::{Course, Largest, STATIONS, specimens, stress_hash};
use super::{pressure, stretched, zero_of_growing};
use crate::experiment::solid::material::lame;
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::picture::{Chart, Curve};
use crate::scene::physics::Isotropic;
use crate::scene::quantity::{Count, Positive};
use mechanics_core::law::Lame;
use mechanics_core::tensor::Mat3;
use mpm_constitutive::plastic::{DruckerPrager, FrictionAngle};
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::FRAC_PI_4;

/// Drucker and Prager's sand; the ladder is the part of the path that a step covers.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SandPoint {
    constants: Isotropic,
    /// φ of the sand that does not harden.
    friction_angle_rad: Positive,
    /// φ∞, b, c, d of φ(q) = φ∞ + (b q − d) e^(−c q), of the sand that hardens.
    hardening: [Positive; 4],
    /// The pressure of triaxial compression of the last point.
    pressure_pa: Positive,
    /// The largest strain [1].
    largest_strain: Positive,
    /// How many points, of which the last goes farthest.
    points: Count,
}

/// The paths.
#[derive(Clone, Copy, Debug)]
enum Path {
    /// Compressed to a pressure, then sheared at constant volume: triaxial compression at constant pressure.
    Triaxial,
    /// Compressed along one axis and unloaded.
    Confined,
    /// Compressed, expanded, compressed, expanded and compressed, sheared all the time.
    Opened,
}

/// The first stations of triaxial compression, without shear.
const ISOTROPIC: usize = 5;
/// The stations of confined compression before it is unloaded.
const LOADING: usize = 15;
/// Volumes at the turns of the third path, five stations apart, in parts of its largest strain.
const VOLUMES: [f64; 6] = [0.0, -0.4, 0.6, -0.5, 0.8, -1.0];

/// The exact law.
struct Sand {
    lame: Lame,
    /// φ(q).
    angle: Box<dyn Fn(f64) -> f64>,
}

impl Sand {
    /// q/p at which it slides, by Mohr and Coulomb's law in triaxial compression, σ₁ = N σ₃.
    fn slope(&self, flow: f64) -> f64 {
        let ratio = (FRAC_PI_4 + 0.5 * (self.angle)(flow)).tan().powi(2);
        3.0 * (ratio - 1.0) / (ratio + 2.0)
    }

    /// q after the axial compression ε at constant volume and pressure p: √1.5 (ε − q/3μ) is the length of the flow, on which the
    /// slope depends.
    fn triaxial(&self, strain: f64, p: f64) -> f64 {
        let (root, stiffness) = (1.5_f64.sqrt(), 3.0 * self.lame.mu());
        if stiffness * strain <= self.slope(0.0) * p {
            return stiffness * strain;
        }
        let total = root * strain;
        let flow = zero_of_growing(total, |flow| flow + root * self.slope(flow) * p / stiffness - total);
        self.slope(flow) * p
    }
}

/// τ of pressure p and σ₁ − σ₃ = q, compression along the first axis.
fn axial(p: f64, q: f64) -> Mat3 {
    Mat3::from_diagonal(&[-p - q / 1.5, -p + q / 3.0, -p + q / 3.0].into())
}

impl Experiment for SandPoint {
    fn methods(&self) -> &'static [&'static str] {
        &[
            "perfect, f64",
            "perfect, f32",
            "hardening, f64",
            "hardening, f32",
            "confined, f64",
            "opened and closed, f64",
            "opened and closed, f32",
        ]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let lame = lame(&self.constants).map_err(ExperimentError::stopped)?;
        let (path, sand, angle) = self.case(at.method, lame)?;
        let law = DruckerPrager::new(lame, angle, 0.0).map_err(ExperimentError::stopped)?;
        let course = Course::new(self.points.value(), at.ladder, 1.0);
        let unit = self.pressure_pa.value();
        let mut specimens = specimens(law, at.method, course.points);
        let (mut stress_error, mut volume_error) = (Largest::default(), Largest::default());
        // By how much the volume of the elastic strain alone would be wrong.
        let mut forgotten = Largest::default();
        let (mut line, mut found) = (Vec::new(), Vec::new());
        course.run(
            specimens.as_mut(),
            clock,
            |point, k| stretched(self.strain(path, k as f64 / course.total() as f64, point, lame)),
            |station, point, stress, specimens| {
                let strain = self.strain(path, station as f64 / STATIONS as f64, point, lame);
                let total: f64 = strain.iter().sum();
                let kept = specimens.volume_ratio(point).ln();
                volume_error.take(kept + specimens.history(point, 0) - total);
                forgotten.take(kept - total);
                let exact = self.exact(path, &sand, station, point);
                let differs = match path {
                    // What is sheared while it opens and closes is compared by its pressure.
                    Path::Opened => pressure(stress) - pressure(&exact),
                    _ => (stress - exact).norm(),
                };
                stress_error.take(differs / unit);
                if point + 1 == course.points {
                    line.push(path.place(&strain, &exact));
                    found.push(path.place(&strain, stress));
                }
            },
        );
        let [x, y] = path.names();
        let chart = Chart {
            title: format!("{}: {} steps", at.method, course.total()),
            x: x.to_owned(),
            y: y.to_owned(),
            curves: vec![Curve::line("exact, at the stations", line), Curve::dots("computed", found)],
        };
        let mut outcome = Outcome::default()
            .error("stress", stress_error.0)
            .error("volume", volume_error.0)
            .count("point updates", course.updates())
            .state(stress_hash(specimens.as_ref(), course.points));
        if let Path::Opened = path {
            outcome = outcome.invariant("volume that only the history knows", forgotten.0);
        }
        outcome = outcome.charted(at, "the point that goes farthest", &chart)?;
        Ok(outcome)
    }
}

impl SandPoint {
    fn case(&self, method: &str, lame: Lame) -> Result<(Path, Sand, FrictionAngle), ExperimentError> {
        let path = match method.split(',').next() {
            Some("perfect" | "hardening") => Path::Triaxial,
            Some("confined") => Path::Confined,
            _ => Path::Opened,
        };
        let constant = self.friction_angle_rad.value();
        if method.starts_with("hardening") {
            let [residual, rise, decay, drop] = self.hardening.map(Positive::value);
            let angle = FrictionAngle::hardening([residual, rise, decay, drop]);
            let exact = move |q: f64| residual + (rise * q - drop) * (-decay * q).exp();
            let sand = Sand { lame, angle: Box::new(exact) };
            return Ok((path, sand, angle.map_err(ExperimentError::stopped)?));
        }
        let angle = FrictionAngle::constant(constant).map_err(ExperimentError::stopped)?;
        Ok((path, Sand { lame, angle: Box::new(move |_| constant) }, angle))
    }

    /// How far a point goes: from 40 % to all of the way.
    fn part(&self, point: usize) -> f64 {
        0.4 + 0.6 * (point + 1) as f64 / self.points.value() as f64
    }

    /// Logarithmic strains at s from 0 to 1.
    fn strain(&self, path: Path, s: f64, point: usize, lame: Lame) -> [f64; 3] {
        let x = s * STATIONS as f64;
        let strain = self.largest_strain.value() * self.part(point);
        match path {
            Path::Triaxial => {
                let start = ISOTROPIC as f64;
                let volume = -self.part(point) * self.pressure_pa.value() / lame.bulk_modulus();
                let compressed = volume * (x / start).min(1.0) / 3.0;
                let sheared = strain * ((x - start) / (STATIONS as f64 - start)).max(0.0);
                [compressed - sheared, compressed + 0.5 * sheared, compressed + 0.5 * sheared]
            }
            Path::Confined => {
                let top = LOADING as f64;
                let axial = if x <= top { x / top } else { 1.0 - (x - top) / (STATIONS as f64) };
                [-strain * axial, 0.0, 0.0]
            }
            Path::Opened => {
                let leg = ((x / 5.0) as usize).min(VOLUMES.len() - 2);
                let along = x / 5.0 - leg as f64;
                let volume = strain * (VOLUMES[leg] + along * (VOLUMES[leg + 1] - VOLUMES[leg]));
                let sheared = 0.5 * strain * s;
                [volume / 3.0 - sheared, volume / 3.0 + sheared, volume / 3.0]
            }
        }
    }

    fn exact(&self, path: Path, sand: &Sand, station: usize, point: usize) -> Mat3 {
        let at = |station: usize| self.strain(path, station as f64 / STATIONS as f64, point, sand.lame);
        let strain = at(station);
        let p = -sand.lame.bulk_modulus() * strain.iter().sum::<f64>();
        match path {
            Path::Triaxial => axial(p, sand.triaxial(strain[2] / 1.5 - strain[0] / 1.5, p)),
            Path::Confined => {
                // It slides from the start, as 2μ/K exceeds the slope; unloaded elastically until it slides the other way.
                let (slope, top) = (sand.slope(0.0), at(LOADING)[0]);
                let loaded = slope * p;
                let highest = -slope * sand.lame.bulk_modulus() * top;
                let unloaded = highest - 2.0 * sand.lame.mu() * (strain[0] - top);
                axial(p, if station <= LOADING { loaded } else { unloaded.max(-loaded) })
            }
            Path::Opened => axial(p.max(0.0), 0.0),
        }
    }
}

impl Path {
    fn place(self, strain: &[f64; 3], stress: &Mat3) -> [f64; 2] {
        let volume: f64 = strain.iter().sum();
        match self {
            Self::Triaxial => [strain[2] / 1.5 - strain[0] / 1.5, stress[(0, 0)] / stress[(1, 1)]],
            Self::Confined => [-1e-3 * stress[(1, 1)], -1e-3 * stress[(0, 0)]],
            Self::Opened => [volume, 1e-3 * pressure(stress)],
        }
    }

    fn names(self) -> [&'static str; 2] {
        match self {
            Self::Triaxial => ["axial less volumetric compression", "axial by lateral stress"],
            Self::Confined => ["lateral pressure [kPa]", "axial pressure [kPa]"],
            Self::Opened => ["logarithm of the volume", "pressure [kPa]"],
        }
    }
}
