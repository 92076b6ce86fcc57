//! A disk that turns freely: what each transfer leaves of its angular momentum.

use super::cloud::Cloud;
use super::method::Method;
use super::portrait::{Portrait, pictured};
use super::solver::{Elasticity, Matter, Solver, Watch};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Positive;
use mpm_core::{Samples, Transfer};
use schemars::JsonSchema;
use serde::Deserialize;

/// A stiff disk of 1 m that turns; the ladder is Δx (m). It makes ½ (R/Δx)² steps, in which PIC loses a part of its angular momentum
/// that does not depend on Δx.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct FreeRotation {
    young_modulus_pa: Positive,
    /// At first.
    spin_rad_s: Positive,
    /// The step: this times Δx by the wave speed.
    courant_number: Positive,
}

const RADIUS: f64 = 1.0;
const DENSITY: f64 = 1000.0;

impl Experiment for FreeRotation {
    fn methods(&self) -> &'static [&'static str] {
        Method::names()
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let method = Method::named(at.method)?;
        let (spacing, spin) = (at.ladder, self.spin_rad_s.value());
        let matter = Matter::new(Elasticity::NeoHookean, (self.young_modulus_pa.value(), 0.3), DENSITY)?;
        let cloud = disk(spacing / method.along as f64);
        let velocities: Vec<_> = cloud.points.iter().map(|x| [-spin * x[1], spin * x[0]]).collect();
        let mut solver = Solver::new(method, spacing)?;
        let body = solver.add_body(
            &matter,
            Samples { positions: &cloud.points, velocities: &velocities, volumes: &cloud.volumes },
        )?;
        solver.set_velocity_gradients(body, &vec![[[0.0, -spin], [spin, 0.0]]; cloud.points.len()])?;
        let mut watch = Watch::start(&solver);
        let before = solver.totals(0).angular_momentum.z;
        let step = self.courant_number.value() * spacing / matter.wave_speed();
        let steps = (0.5 * (RADIUS / spacing).powi(2)).round() as usize;
        for _ in 0..steps {
            clock.time(|| solver.step(step)).map_err(ExperimentError::stopped)?;
        }
        watch.look(&mut solver, step);
        let left = solver.totals(0).angular_momentum.z / before;
        // PIC forgets Σ m D ‖ε:C‖ = 2 M D ω in every step, of ½ M R² ω.
        let moment = method.kernel.second_moment().unwrap_or(f64::NAN) * spacing * spacing;
        let kept = (1.0 - 4.0 * moment / (RADIUS * RADIUS)).powi(steps as i32);
        let expected = if method.transfer == Transfer::Pic { kept } else { 1.0 };
        let outcome = solver.counted(
            Outcome::default()
                .error("angular momentum lost", (1.0 - left).abs())
                .error("angular momentum less theory", (left - expected).abs()),
        );
        pictured(watch.free(outcome), at, "the disk after the last step", || Portrait {
            positions: solver.positions(0),
            values: solver.velocities(0).iter().map(|v| v[0].hypot(v[1]) / spin).collect(),
            radius: 0.5 * spacing / method.along as f64,
            field: ("speed by the first of the rim", "1"),
            range: Some((0.0, 1.0)),
            lines: Vec::new(),
            label: format!("{}: {:.4} of the angular momentum after {steps} steps", at.method, left),
        })
    }
}

/// Of rings that exactly tile it.
fn disk(gap: f64) -> Cloud<2> {
    Cloud::annulus(0.0, RADIUS, gap)
}
