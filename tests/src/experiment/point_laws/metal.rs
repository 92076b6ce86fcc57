//! Metal: tension and compression, a corner in the strain path, simple shear.

use super::drive::{Course, Largest, STATIONS, specimens, stress_hash};
use super::extrapolation::advanced;
use super::{stretched, zero_of_growing};
use crate::experiment::solid::material::lame;
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::picture::{Chart, Curve};
use crate::scene::physics::Isotropic;
use crate::scene::quantity::{Count, Positive};
use mechanics_core::tensor::Mat3;
use mpm_constitutive::plastic::{VonMises, YieldStress};
use schemars::JsonSchema;
use serde::Deserialize;

/// Von Mises' solid with linear and Voce hardening; the ladder is the part of the path that a step covers.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct MetalPoint {
    constants: Isotropic,
    yield_stress_pa: Positive,
    /// σ∞ of Voce's law.
    saturation_stress_pa: Positive,
    /// δ of Voce's law [1].
    saturation_rate: Positive,
    /// H.
    hardening_modulus_pa: Positive,
    /// The equivalent strain of the longest leg of a path [1].
    largest_strain: Positive,
    /// How many points, of which the last goes farthest.
    points: Count,
}

/// The exact law's constants.
#[derive(Clone, Copy, Debug)]
struct Metal {
    mu: f64,
    initial: f64,
    change: f64,
    rate: f64,
    modulus: f64,
}

impl Metal {
    fn yield_stress(&self, alpha: f64) -> f64 {
        self.initial + self.modulus * alpha + self.change * (1.0 - (-self.rate * alpha).exp())
    }

    fn slope(&self, alpha: f64) -> f64 {
        self.modulus + self.change * self.rate * (-self.rate * alpha).exp()
    }

    /// γ̇ from n : d on the yield surface: d‖dev τ‖ = 2μ (n : d − γ̇) = ⅔ σ_y′ γ̇.
    fn flow(&self, loading: f64, alpha: f64) -> f64 {
        (2.0 * self.mu * loading / (2.0 * self.mu + self.slope(alpha) / 1.5)).max(0.0)
    }
}

/// What is compared at a station.
#[derive(Clone, Copy, Debug)]
struct State {
    stress: Mat3,
    alpha: f64,
}

impl Experiment for MetalPoint {
    fn methods(&self) -> &'static [&'static str] {
        &["tension, f64", "tension, f32", "corner, f64", "corner, f32", "shear, f64", "shear, f32"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let lame = lame(&self.constants).map_err(ExperimentError::stopped)?;
        let (initial, modulus) = (self.yield_stress_pa.value(), self.hardening_modulus_pa.value());
        let (saturation, rate) = (self.saturation_stress_pa.value(), self.saturation_rate.value());
        let curve =
            YieldStress::linear(initial, modulus).and_then(|linear| linear.saturating(saturation, rate));
        let law = curve.and_then(|curve| VonMises::new(lame, curve)).map_err(ExperimentError::stopped)?;
        let metal = Metal { mu: lame.mu(), initial, change: saturation - initial, rate, modulus };
        let course = Course::new(self.points.value(), at.ladder, 1.0);
        let path = Path::of(at.method);
        let truth: Vec<Vec<State>> =
            (0..course.points).map(|point| path.states(&metal, self.reach(point))).collect();
        let mut specimens = specimens(law, at.method, course.points);
        let (mut stress_error, mut alpha_error) = (Largest::default(), Largest::default());
        let mut found = vec![[0.0, 0.0]];
        course.run(
            specimens.as_mut(),
            clock,
            |point, k| path.deformation(k as f64 / course.total() as f64, self.reach(point)),
            |station, point, stress, specimens| {
                let exact = truth[point][station - 1];
                stress_error.take((stress - exact.stress).norm() / initial);
                alpha_error.take((specimens.history(point, 0) - exact.alpha) / self.largest_strain.value());
                if point + 1 == course.points {
                    found.push(path.place(station, self.reach(point), stress));
                }
            },
        );
        let last = course.points - 1;
        let exact = |(k, state): (usize, &State)| path.place(k + 1, self.reach(last), &state.stress);
        let mut line = vec![[0.0, 0.0]];
        line.extend(truth[last].iter().enumerate().map(exact));
        let chart = Chart {
            title: format!("{}: {} steps", at.method, course.total()),
            x: path.name_of_abscissa().to_owned(),
            y: path.name_of_ordinate().to_owned(),
            curves: vec![Curve::line("exact flow, at the stations", line), Curve::dots("computed", found)],
        };
        let mut outcome = Outcome::default()
            .error("stress", stress_error.0)
            .error("plastic strain", alpha_error.0)
            .count("point updates", course.updates())
            .state(stress_hash(specimens.as_ref(), course.points));
        outcome = outcome.charted(at, "stress against strain of the point that goes farthest", &chart)?;
        Ok(outcome)
    }
}

impl MetalPoint {
    /// How far a point goes: from 40 % to all of the way.
    fn reach(&self, point: usize) -> f64 {
        let part = (point + 1) as f64 / self.points.value() as f64;
        self.largest_strain.value() * (0.4 + 0.6 * part)
    }
}

/// The paths of strain, of equivalent strain A a leg.
#[derive(Clone, Copy, Debug)]
enum Path {
    /// Isochoric stretch to ln λ = A, back to −A and to A: proportional, so that every step is exact.
    Tension,
    /// Isochoric stretch to A, then at right angles to it in the plane of deviators.
    Corner,
    /// Simple shear to γ = 2√3 A.
    Shear,
}

/// Stations at which tension turns, and the corner.
const TURNS: [usize; 2] = [5, 15];
const CORNER: usize = 10;
/// Steps of the reference from one station to the next.
const FINE: usize = 5;

/// Deviators of unit equivalent strain, at right angles.
const ALONG: [f64; 3] = [1.0, -0.5, -0.5];
const ACROSS: [f64; 3] = [0.0, 0.866_025_403_784_438_6, -0.866_025_403_784_438_6];

impl Path {
    fn of(method: &str) -> Self {
        match method.split(',').next() {
            Some("tension") => Self::Tension,
            Some("corner") => Self::Corner,
            // The only other one of the list.
            _ => Self::Shear,
        }
    }

    /// Strains along the path at s from 0 to 1: of both legs, or γ.
    fn strains(self, s: f64, reach: f64) -> [f64; 2] {
        let x = s * STATIONS as f64;
        match self {
            Self::Tension => {
                let [first, second] = TURNS.map(|station| station as f64);
                let unit = first;
                let signed = if x <= first {
                    x / unit
                } else if x <= second {
                    1.0 - (x - first) / unit
                } else {
                    -1.0 + (x - second) / unit
                };
                [reach * signed, 0.0]
            }
            Self::Corner => {
                let corner = CORNER as f64;
                let rest = (STATIONS - CORNER) as f64;
                [reach * (x / corner).min(1.0), reach * ((x - corner) / rest).max(0.0)]
            }
            Self::Shear => [2.0 * 3.0_f64.sqrt() * reach * s, 0.0],
        }
    }

    fn deformation(self, s: f64, reach: f64) -> Mat3 {
        let [first, second] = self.strains(s, reach);
        match self {
            Self::Shear => sheared(first),
            _ => stretched(std::array::from_fn(|i| first * ALONG[i] + second * ACROSS[i])),
        }
    }

    /// The exact states at the stations from 1.
    fn states(self, metal: &Metal, reach: f64) -> Vec<State> {
        match self {
            Self::Tension => {
                tension(metal, |station| self.strains(station as f64 / STATIONS as f64, reach)[0])
            }
            Self::Corner => corner(metal, reach),
            Self::Shear => shear(metal, reach),
        }
    }

    fn name_of_abscissa(self) -> &'static str {
        match self {
            Self::Tension => "axial logarithmic strain",
            Self::Corner => "deviatoric stress along the first leg [MPa]",
            Self::Shear => "shear",
        }
    }

    fn name_of_ordinate(self) -> &'static str {
        match self {
            Self::Tension => "axial less lateral stress [MPa]",
            Self::Corner => "deviatoric stress along the second leg [MPa]",
            Self::Shear => "shear stress [MPa]",
        }
    }

    /// Where a station stands in the picture.
    fn place(self, station: usize, reach: f64, stress: &Mat3) -> [f64; 2] {
        let strain = self.strains(station as f64 / STATIONS as f64, reach)[0];
        match self {
            Self::Tension => [strain, 1e-6 * (stress[(0, 0)] - stress[(1, 1)])],
            Self::Corner => [1e-6 * 1.5 * stress[(0, 0)], 1e-6 * (stress[(1, 1)] - stress[(2, 2)])],
            Self::Shear => [strain, 1e-6 * stress[(0, 1)]],
        }
    }
}

fn sheared(shear: f64) -> Mat3 {
    let mut f = Mat3::identity();
    f[(0, 1)] = shear;
    f
}

/// dε = dα + dq/3μ on the yield surface, so that a leg of travel x from (s₀, α₀) ends where x = x_y + Δα + Δσ_y/3μ.
fn tension(metal: &Metal, strain: impl Fn(usize) -> f64) -> Vec<State> {
    let (stiffness, mut stress, mut alpha) = (3.0 * metal.mu, 0.0, 0.0);
    (1..=STATIONS)
        .map(|station| {
            let travel = strain(station) - strain(station - 1);
            let direction = travel.signum();
            let rest = travel.abs() - (metal.yield_stress(alpha) - direction * stress) / stiffness;
            if rest <= 0.0 {
                stress += stiffness * travel;
            } else {
                let before = metal.yield_stress(alpha);
                alpha += zero_of_growing(rest, |flow| {
                    flow + (metal.yield_stress(alpha + flow) - before) / stiffness - rest
                });
                stress = direction * metal.yield_stress(alpha);
            }
            // Axial less lateral stress is q.
            State { stress: Mat3::from_diagonal(&ALONG.map(|x| x * stress / 1.5).into()), alpha }
        })
        .collect()
}

/// The first leg is proportional; on the second s′ = 2μ (e′ − γ̇ n), α′ = √⅔ γ̇.
fn corner(metal: &Metal, reach: f64) -> Vec<State> {
    let path = Path::Corner;
    let mut states = tension(metal, |station| path.strains(station as f64 / STATIONS as f64, reach)[0]);
    states.truncate(CORNER);
    let start = states[CORNER - 1];
    let rate = reach / (STATIONS - CORNER) as f64;
    let slope = |_: f64, y: &[f64; 4]| {
        let size = (y[0] * y[0] + y[1] * y[1] + y[2] * y[2]).sqrt();
        let loading: f64 = (0..3).map(|i| y[i] / size * rate * ACROSS[i]).sum();
        let flow = metal.flow(loading, y[3]);
        let stress = |i: usize| 2.0 * metal.mu * (rate * ACROSS[i] - flow * y[i] / size);
        [stress(0), stress(1), stress(2), (2.0_f64 / 3.0).sqrt() * flow]
    };
    let mut y = [start.stress[(0, 0)], start.stress[(1, 1)], start.stress[(2, 2)], start.alpha];
    for _ in CORNER..STATIONS {
        for _ in 0..FINE {
            y = advanced(&slope, 0.0, &y, 1.0 / FINE as f64);
        }
        states.push(State { stress: Mat3::from_diagonal(&[y[0], y[1], y[2]].into()), alpha: y[3] });
    }
    states
}

/// With b = Fᵉ Fᵉᵀ: b′ = L b + b Lᵀ − 2γ̇ n b, from yield at q = 2√3 μ arsinh(γ/2). Since n and b have the same axes,
/// d‖dev ½ ln b‖ = n : L − γ̇.
fn shear(metal: &Metal, reach: f64) -> Vec<State> {
    let yields = 2.0 * (metal.initial / (12.0_f64.sqrt() * metal.mu)).sinh();
    let step = Path::Shear.strains(1.0 / STATIONS as f64, reach)[0];
    let slope = |_: f64, y: &[f64; 10]| {
        let b = Mat3::from_column_slice(&y[..9]);
        let stress = hencky_deviator(metal, &b);
        let normal = stress / stress.norm();
        let mut gradient = Mat3::zeros();
        gradient[(0, 1)] = 1.0;
        let flow = metal.flow(normal[(0, 1)], y[9]);
        let rate = gradient * b + b * gradient.transpose() - normal * b * (2.0 * flow);
        std::array::from_fn(|k| if k < 9 { rate[(k % 3, k / 3)] } else { (2.0_f64 / 3.0).sqrt() * flow })
    };
    let mut gamma = yields;
    let mut y = [0.0; 10];
    y[..9].copy_from_slice((sheared(yields) * sheared(yields).transpose()).as_slice());
    (1..=STATIONS)
        .map(|station| {
            let end = step * station as f64;
            if end <= yields {
                let b = sheared(end) * sheared(end).transpose();
                return State { stress: hencky_deviator(metal, &b), alpha: 0.0 };
            }
            for k in 0..FINE {
                let length = (end - gamma) / (FINE - k) as f64;
                y = advanced(&slope, gamma, &y, length);
                gamma += length;
            }
            State { stress: hencky_deviator(metal, &Mat3::from_column_slice(&y[..9])), alpha: y[9] }
        })
        .collect()
}

/// 2μ dev ½ ln b, by eigenvectors.
fn hencky_deviator(metal: &Metal, b: &Mat3) -> Mat3 {
    let eigen = (0.5 * (b + b.transpose())).symmetric_eigen();
    let log = eigen.eigenvalues.map(|x| metal.mu * x.ln());
    let mean = log.sum() / 3.0;
    eigen.eigenvectors * Mat3::from_diagonal(&log.map(|x| x - mean)) * eigen.eigenvectors.transpose()
}
