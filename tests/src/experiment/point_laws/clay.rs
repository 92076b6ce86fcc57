//! Clay: isotropic compression, and triaxial compression to the critical state, undrained and drained.

use super::drive::{Course, Largest, STATIONS, specimens, stress_hash};
use super::extrapolation::advanced;
use super::{deviator, pressure, stretched, zero_of_growing};
use crate::experiment::solid::material::lame;
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::picture::{Chart, Curve};
use crate::scene::physics::Isotropic;
use crate::scene::quantity::{Count, Positive};
use mechanics_core::tensor::Mat3;
use mpm_constitutive::plastic::ModifiedCamClay;
use schemars::JsonSchema;
use serde::Deserialize;

/// Modified Cam-Clay; the ladder is the part of the path that a step covers.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ClayPoint {
    constants: Isotropic,
    /// M.
    critical_state_slope: Positive,
    /// p_c at the start.
    preconsolidation_pa: Positive,
    /// ζ, by which p_c grows with the plastic compaction [1].
    consolidation_rate: Positive,
    /// The compaction of isotropic compression [1].
    isotropic_strain: Positive,
    /// The shear of undrained compression [1].
    undrained_strain: Positive,
    /// The shear of drained compression [1].
    drained_strain: Positive,
    /// How many points: clays consolidated to 1.1 to 1.8 times the pressure at which they are sheared.
    points: Count,
}

/// The stations before shear.
const ISOTROPIC: usize = 5;
/// The stations at which isotropic compression turns.
const TURNS: [usize; 2] = [10, 15];
/// Steps of the reference: this many for a step of the path, or more on coarse ladders.
const FINE: usize = 100;

/// The exact law: compression positive, p and q of triaxial compression, w the plastic compaction.
#[derive(Clone, Copy, Debug)]
struct Clay {
    bulk: f64,
    mu: f64,
    slope: f64,
    initial: f64,
    rate: f64,
}

/// A point of the path: strains to be prescribed, and stress.
#[derive(Clone, Copy, Debug, Default)]
struct Place {
    /// The whole compaction, −ln J.
    compaction: f64,
    /// The axial compression less a third of the compaction.
    shear: f64,
    p: f64,
    q: f64,
}

impl Clay {
    /// dε_q = dq/3μ + 2q dw/(M² h), h = 2p − p_c, is the whole shear; so dy/dε_q = h/(h (dq/dy)/3μ + (2q/M²) dw/dy) for y = w or q, which is
    /// regular at the critical state h = 0.
    fn rate(&self, h: f64, q: f64, q_slope: f64, w_slope: f64) -> f64 {
        h / (h * q_slope / (3.0 * self.mu) + 2.0 * q / self.slope.powi(2) * w_slope)
    }

    /// At constant volume p = p₀ − K w, so that q = M √(p(p_c − p)) follows from w.
    fn undrained(&self, start: f64, w: f64) -> Place {
        let p = start - self.bulk * w;
        let q = self.slope * (p * (self.initial * (self.rate * w).exp() - p)).max(0.0).sqrt();
        Place { compaction: start / self.bulk, shear: 0.0, p, q }
    }

    fn undrained_rate(&self, start: f64, w: f64) -> f64 {
        let Place { p, q, .. } = self.undrained(start, w);
        let strength = self.initial * (self.rate * w).exp();
        // 2q dq = M² d(p(p_c − p))
        let q_slope = self.slope.powi(2) / (2.0 * q)
            * (p * (self.rate * strength + self.bulk) - self.bulk * (strength - p));
        self.rate(2.0 * p - strength, q, q_slope, 1.0)
    }

    /// At constant lateral stress p = p₀ + q/3, so that p_c = p + q²/(M²p) and w follow from q.
    fn drained(&self, start: f64, q: f64) -> Place {
        let p = start + q / 3.0;
        let strength = p + q * q / (self.slope.powi(2) * p);
        let w = (strength / self.initial).ln().max(0.0) / self.rate;
        Place { compaction: p / self.bulk + w, shear: 0.0, p, q }
    }

    fn drained_rate(&self, start: f64, q: f64) -> f64 {
        let (p, squared) = (start + q / 3.0, self.slope.powi(2));
        let strength = p + q * q / (squared * p);
        let growth = 1.0 / 3.0 + 2.0 * q / (squared * p) - q * q / (3.0 * squared * p * p);
        self.rate(2.0 * p - strength, q, 1.0, growth / (self.rate * strength))
    }

    /// q at which shear at p = p₀ + q `gain` begins to flow.
    fn yields(&self, start: f64, gain: f64) -> f64 {
        zero_of_growing(2.0 * self.slope * self.initial, |q| {
            let p = start + gain * q;
            q * q + self.slope.powi(2) * p * (p - self.initial)
        })
    }

    /// All places of a sheared point, `count` steps of `strain`: elastic to the yield surface, then by the equation of `y`.
    fn sheared(
        &self,
        [strain, yields]: [f64; 2],
        count: usize,
        place: impl Fn(f64) -> Place,
        begin: f64,
        rate: impl Fn(f64) -> f64,
    ) -> Vec<Place> {
        let elastic = yields / (3.0 * self.mu);
        let fine = FINE.div_ceil(count).max(1);
        let (mut reached, mut y) = (elastic, [begin]);
        (1..=count)
            .map(|k| {
                let end = strain * k as f64 / count as f64;
                for part in 0..fine {
                    let length = (end - reached) / (fine - part) as f64;
                    if length > 0.0 {
                        y = advanced(&|_, y: &[f64; 1]| [rate(y[0])], 0.0, &y, length);
                        reached += length;
                    }
                }
                Place { shear: end, ..place(y[0]) }
            })
            .collect()
    }
}

impl Experiment for ClayPoint {
    fn methods(&self) -> &'static [&'static str] {
        &[
            "isotropic, f64",
            "isotropic, f32",
            "undrained, f64",
            "undrained, f32",
            "drained, f64",
            "drained, f32",
        ]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let lame = lame(&self.constants).map_err(ExperimentError::stopped)?;
        let (slope, initial) = (self.critical_state_slope.value(), self.preconsolidation_pa.value());
        let rate = self.consolidation_rate.value();
        let law = ModifiedCamClay::new(lame, slope, 0.0, initial, rate).map_err(ExperimentError::stopped)?;
        let clay = Clay { bulk: lame.bulk_modulus(), mu: lame.mu(), slope, initial, rate };
        let course = Course::new(self.points.value(), at.ladder, 1.0);
        let truth: Vec<Vec<Place>> =
            (0..course.points).map(|point| self.places(at.method, &clay, &course, point)).collect();
        let mut specimens = specimens(law, at.method, course.points);
        let mut stress_error = Largest::default();
        let mut state_error = Largest::default();
        let shown = 0;
        let (mut line, mut found) = (vec![[0.0, 0.0]], vec![[0.0, 0.0]]);
        course.run(
            specimens.as_mut(),
            clock,
            |point, k| {
                let Place { compaction, shear, .. } = truth[point][k - 1];
                let lateral = -compaction / 3.0 + 0.5 * shear;
                stretched([-compaction / 3.0 - shear, lateral, lateral])
            },
            |station, point, stress, _| {
                let exact = truth[point][station * course.steps - 1];
                let tensor = [-exact.p - exact.q / 1.5, -exact.p + exact.q / 3.0, -exact.p + exact.q / 3.0];
                stress_error.take((stress - Mat3::from_diagonal(&tensor.into())).norm() / initial);
                let (p, q) = (pressure(stress), 1.5_f64.sqrt() * deviator(stress).norm());
                if station == STATIONS && !at.method.starts_with("isotropic") {
                    state_error.take(q / p / slope - 1.0);
                }
                if point == shown {
                    line.push(picture_place(at.method, &exact, exact.p, exact.q));
                    found.push(picture_place(at.method, &exact, p, q));
                }
            },
        );
        let isotropic = at.method.starts_with("isotropic");
        let mut curves =
            vec![Curve::line("exact, at the stations", line), Curve::dots("computed", found.clone())];
        if !isotropic {
            let farthest = found.iter().fold(0.0, |x: f64, place| x.max(place[0]));
            curves
                .push(Curve::line("critical state q = M p", vec![[0.0, 0.0], [farthest, slope * farthest]]));
        }
        let chart = Chart {
            title: format!("{}: {} steps", at.method, course.total()),
            x: if isotropic { "compaction" } else { "p [kPa]" }.to_owned(),
            y: if isotropic { "p [kPa]" } else { "q [kPa]" }.to_owned(),
            curves,
        };
        let mut outcome = Outcome::default()
            .error("stress", stress_error.0)
            .error("critical state", state_error.0)
            .count("point updates", course.updates())
            .state(stress_hash(specimens.as_ref(), course.points));
        outcome = outcome.charted(at, "the point that was consolidated least", &chart)?;
        Ok(outcome)
    }
}

fn picture_place(method: &str, place: &Place, p: f64, q: f64) -> [f64; 2] {
    if method.starts_with("isotropic") { [place.compaction, 1e-3 * p] } else { [1e-3 * p, 1e-3 * q] }
}

impl ClayPoint {
    /// The exact path of a point, step by step.
    fn places(&self, method: &str, clay: &Clay, course: &Course, point: usize) -> Vec<Place> {
        let part = point as f64 / self.points.value() as f64;
        if method.starts_with("isotropic") {
            return self.isotropic(clay, course, 0.5 + 0.5 * part);
        }
        let start = clay.initial / (1.1 + 0.7 * part);
        let first = ISOTROPIC * course.steps;
        let squeezed = |k: usize| {
            let p = start * k as f64 / first as f64;
            Place { compaction: p / clay.bulk, shear: 0.0, p, q: 0.0 }
        };
        let count = course.total() - first;
        let drained = method.starts_with("drained");
        let yields = clay.yields(start, if drained { 1.0 / 3.0 } else { 0.0 });
        let sheared = if drained {
            let strain = self.drained_strain.value();
            clay.sheared(
                [strain, yields],
                count,
                |q| clay.drained(start, q),
                yields,
                |q| clay.drained_rate(start, q),
            )
        } else {
            let strain = self.undrained_strain.value();
            clay.sheared(
                [strain, yields],
                count,
                |w| clay.undrained(start, w),
                0.0,
                |w| clay.undrained_rate(start, w),
            )
        };
        let elastic = sheared.into_iter().map(|place| {
            let q = 3.0 * clay.mu * place.shear;
            if q >= yields {
                return place;
            }
            let p = if drained { start + q / 3.0 } else { start };
            Place { compaction: if drained { p / clay.bulk } else { place.compaction }, p, q, ..place }
        });
        (1..=first).map(squeezed).chain(elastic).collect()
    }

    /// Compressed, unloaded by two thirds of the pressure, compressed further: x = p/K + ln(p/p_c₀)/ζ on the virgin line, dp = K dx below it.
    fn isotropic(&self, clay: &Clay, course: &Course, part: f64) -> Vec<Place> {
        let whole = part * self.isotropic_strain.value();
        let virgin = |x: f64| {
            zero_of_growing(clay.bulk * x, |p| {
                p / clay.bulk + (p / clay.initial).max(1.0).ln() / clay.rate - x
            })
        };
        let [top, bottom] = TURNS.map(|station| (station * course.steps) as f64);
        let (last, highest) = (course.total() as f64, virgin(whole));
        let unloaded = highest / clay.bulk / 1.5;
        (1..=course.total())
            .map(|k| {
                let k = k as f64;
                let x = if k <= top {
                    whole * k / top
                } else if k <= bottom {
                    whole - unloaded * (k - top) / (bottom - top)
                } else {
                    whole - unloaded + (0.5 * whole + unloaded) * (k - bottom) / (last - bottom)
                };
                let elastic = highest + clay.bulk * (x - whole);
                let p = if k <= top { virgin(x) } else { elastic.min(virgin(x)) };
                Place { compaction: x, shear: 0.0, p, q: 0.0 }
            })
            .collect()
    }
}
