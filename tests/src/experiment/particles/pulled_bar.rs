//! A bar that is pulled at both ends at once, by tractions on the particles there: d'Alembert's waves, and the stretch about which it swings.

use super::cloud::Cloud;
use super::method::Method;
use super::portrait::{Portrait, filmed};
use super::solver::{Elasticity, Matter, Solver, Watch};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Positive;
use mpm_core::Traction;
use schemars::JsonSchema;
use serde::Deserialize;

/// A bar from −L to L with ν = 0, for one period 4L/c after the ends are loaded; the ladder is Δx/L. P of fixed corotated matter is then
/// E (F − 1): waves are exact for any load.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct PulledBar {
    /// The load: traction by Young's modulus.
    strain: Positive,
    /// How the load follows the bar.
    load: Load,
    /// The step: this times Δx by the wave speed.
    courant_number: Positive,
}

/// What pulls.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum Load {
    /// A force per rest area.
    Nominal,
    /// A force per present area.
    Cauchy,
    /// A negative pressure, against the present surface.
    Suction,
}

impl Load {
    fn traction(self, stress: f64) -> Traction<2> {
        match self {
            Self::Nominal => Traction::Nominal([stress, 0.0]),
            Self::Cauchy => Traction::Cauchy([stress, 0.0]),
            Self::Suction => Traction::Pressure(-stress),
        }
    }
}

/// L \[m\].
const LENGTH: f64 = 1.0;
const YOUNG: f64 = 1e4;
const DENSITY: f64 = 1000.0;

/// u/L of the point X at time t, both in units of L and L/c, under a load of `strain`: waves from the end, and their reflections, the one
/// at the middle with another sign. For X < 0 by symmetry.
fn displacement(strain: f64, x: f64, t: f64) -> f64 {
    let ramp = |at: f64| (t - at).max(0.0);
    let reflections = (0..8_i32).map(|k| {
        let far = f64::from(2 * k + 1);
        (ramp(far - x.abs()) - ramp(far + x.abs())) * f64::from(1 - 2 * (k % 2))
    });
    strain * reflections.sum::<f64>().copysign(x)
}

/// ∂u/∂X at the point X and time t, in the same units: the stress by Young's modulus.
fn strain(strain: f64, x: f64, t: f64) -> f64 {
    let passed = |at: f64| f64::from(u8::from(t > at));
    let reflections = (0..8_i32).map(|k| {
        let far = f64::from(2 * k + 1);
        (passed(far - x.abs()) + passed(far + x.abs())) * f64::from(1 - 2 * (k % 2))
    });
    strain * reflections.sum::<f64>()
}

impl PulledBar {
    /// Stress by the load, upwards, along the bar at rest: of the particles and exact.
    fn portrait(&self, cloud: &Cloud<2>, solver: &Solver<2>, time: f64, label: String) -> Portrait<2> {
        let load = self.strain.value();
        let height = |stress: f64| 0.35 * LENGTH * stress;
        let exact = |x: f64| strain(load, x / LENGTH, time) / load;
        let mut portrait = Portrait {
            radius: 0.008 * LENGTH,
            field: ("error", "1"),
            range: Some((-0.5, 0.5)),
            label,
            ..Portrait::default()
        };
        for (state, rest) in solver.states(0).iter().zip(&cloud.points) {
            // σ = P: the bar keeps its width.
            let stress = state.kirchhoff[(0, 0)] / state.volume_ratio / (load * YOUNG);
            portrait.positions.push([rest[0], height(stress)]);
            portrait.values.push(stress - exact(rest[0]));
        }
        let point = |k: i32| {
            let x = 0.0025 * LENGTH * f64::from(k);
            [x, height(exact(x))]
        };
        portrait.lines = vec![
            (-400..=400).map(point).collect(),
            vec![[-LENGTH, 0.0], [LENGTH, 0.0]],
            // The room that all frames need.
            vec![[-LENGTH, height(-0.3)], [-LENGTH, height(2.5)]],
        ];
        portrait
    }

    /// Loads the outermost particles, at rest half a gap below the ends.
    fn load(
        &self,
        solver: &mut Solver<2>,
        cloud: &Cloud<2>,
        gap: f64,
        stress: f64,
    ) -> Result<(), ExperimentError> {
        let traction = self.load.traction(stress);
        for side in [-1.0, 1.0] {
            let end = |p: &usize| side * cloud.points[*p][0] > LENGTH - gap;
            let area = [side * gap, 0.0];
            let pieces: Vec<_> = (0..cloud.points.len()).filter(end).map(|p| (p, area)).collect();
            let traction = match traction {
                Traction::Nominal(t) => Traction::Nominal(t.map(|t| side * t)),
                Traction::Cauchy(t) => Traction::Cauchy(t.map(|t| side * t)),
                following => following,
            };
            solver.add_traction(0, traction, &pieces)?;
        }
        Ok(())
    }
}

impl Experiment for PulledBar {
    fn methods(&self) -> &'static [&'static str] {
        Method::names()
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let method = Method::named(at.method)?;
        let matter = Matter::new(Elasticity::FixedCorotated, (YOUNG, 0.0), DENSITY)?;
        let (strain, spacing) = (self.strain.value(), at.ladder * LENGTH);
        let cells = (1.0 / at.ladder).round() as usize;
        let along = method.along;
        let gap = spacing / along as f64;
        let cloud = Cloud::cuboid([-LENGTH, 0.0], [LENGTH, spacing], [2 * along * cells, along]);
        let mut solver = Solver::new(method, spacing)?;
        solver.add_cloud(&matter, &cloud)?;
        self.load(&mut solver, &cloud, gap, strain * YOUNG)?;
        let unit = LENGTH / matter.wave_speed();
        let steps = (4.0 / (self.courant_number.value() * at.ladder)).ceil() as usize;
        let step = 4.0 * unit / steps as f64;
        let mut watch = Watch::start(&solver);
        let (mut square, mut mean) = (0.0, 0.0);
        // In the middle of the half that the waves cross.
        let pick = |x: f64| -> usize {
            let far = |p: &usize| (cloud.points[*p][0] - x * LENGTH).abs();
            (0..cloud.points.len()).min_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or_default()
        };
        let (left, right) = (pick(-0.5), pick(0.5));
        let rest = cloud.points[right][0] - cloud.points[left][0];
        let mut frames = Vec::new();
        for k in 1..=steps {
            clock.time(|| solver.step(step)).map_err(ExperimentError::stopped)?;
            let x = solver.positions(0);
            let time = solver.time() / unit;
            mean += (x[right][0] - x[left][0]) / rest - 1.0;
            let error = |(x, rest): (&[f64; 2], &[f64; 2])| {
                (x[0] - rest[0]) / LENGTH - displacement(strain, rest[0] / LENGTH, time)
            };
            let errors = x.iter().zip(&cloud.points).map(error);
            square += errors.map(|e| (e / strain).powi(2)).sum::<f64>() / x.len() as f64;
            if k % steps.div_ceil(16) == 0 {
                watch.look(&mut solver, step);
            }
            if at.frames.is_some() && k % steps.div_ceil(40) == 0 {
                let label = format!("{}, Δx = {:.4} L, t = {time:.2} L/c", at.method, at.ladder);
                frames.push(self.portrait(&cloud, &solver, time, label));
            }
        }
        let outcome = Outcome::default()
            .error("wave", (square / steps as f64).sqrt())
            .error("mean stretch", (mean / steps as f64 / strain - 1.0).abs());
        let outcome = watch.free(solver.counted(outcome));
        let caption = format!("{}: stress by the load along the bar, for a period; line: exact", at.method);
        filmed(outcome, at, &caption, (&frames, 6.0))
    }
}
