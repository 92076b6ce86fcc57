//! Two elastic disks that meet, bounce and part.

use super::cloud::Cloud;
use super::method::Method;
use super::portrait::{Portrait, filmed};
use super::solver::{Elasticity, Matter, Solver};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Positive;
use mpm_core::Samples;
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::PI;

/// Two disks of 0.2 m, E = 1000 Pa, ν = 0.3, ρ₀ = 1000 kg/m³, centres at (0.2, 0.2) and (0.8, 0.8), that fly at each other with
/// ±(0.1, 0.1) m/s.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct TwoDisks {
    /// What the ladder is.
    ladder: Ladder,
    /// Δx where the ladder is the step.
    spacing_m: Positive,
    /// h for Δx = 0.05 m where the ladder is Δx; it goes with Δx.
    step_s: Positive,
    /// Until they have parted.
    duration_s: Positive,
}

/// What a scene makes finer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum Ladder {
    /// Δx \[m\], and the step with it.
    Spacing,
    /// h \[s\].
    Step,
}

const RADIUS: f64 = 0.2;
const SPEED: f64 = 0.1;
const DENSITY: f64 = 1000.0;
/// (0.6 √2 − 0.4)/(0.2 √2): when rims touch \[s\].
const CONTACT: f64 = 1.585_786_437_626_905;
/// The part of a disk's momentum whose change is contact.
const TOUCH: f64 = 1e-6;
const FRAMES: usize = 24;

/// Of both disks.
#[derive(Clone, Copy, Debug)]
struct Balance {
    /// Of each.
    momenta: [[f64; 2]; 2],
    kinetic: f64,
    energy: f64,
}

impl Balance {
    fn of(solver: &Solver<2>) -> Self {
        let totals = [solver.totals(0), solver.totals(1)];
        let kinetic: f64 = totals.iter().map(|t| t.kinetic_energy).sum();
        Self {
            momenta: totals.map(|t| [t.momentum.x, t.momentum.y]),
            kinetic,
            energy: kinetic + totals.iter().map(|t| t.stored_energy + t.affine_energy).sum::<f64>(),
        }
    }
}

impl TwoDisks {
    fn start(&self, spacing: f64, method: Method) -> Result<Solver<2>, ExperimentError> {
        let matter = Matter::new(Elasticity::NeoHookean, (1000.0, 0.3), DENSITY)?;
        let parts = (2.0 * RADIUS / spacing * method.along as f64).round() as usize;
        let mut disk = Cloud::cuboid([-RADIUS; 2], [RADIUS; 2], [parts; 2]);
        disk.points.retain(|x| x[0].hypot(x[1]) <= RADIUS);
        // Of the true mass.
        disk.volumes = vec![PI * RADIUS * RADIUS / disk.points.len() as f64; disk.points.len()];
        let mut solver = Solver::new(method, spacing)?;
        for (centre, speed) in [(0.2, SPEED), (0.8, -SPEED)] {
            let positions: Vec<_> = disk.points.iter().map(|x| x.map(|x| centre + x)).collect();
            let velocities = vec![[speed; 2]; positions.len()];
            solver.add_body(
                &matter,
                Samples { positions: &positions, velocities: &velocities, volumes: &disk.volumes },
            )?;
        }
        Ok(solver)
    }
}

impl Experiment for TwoDisks {
    fn methods(&self) -> &'static [&'static str] {
        Method::names()
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let method = Method::named(at.method)?;
        let (spacing, step) = match self.ladder {
            Ladder::Spacing => (at.ladder, self.step_s.value() * at.ladder / 0.05),
            Ladder::Step => (self.spacing_m.value(), at.ladder),
        };
        let mut solver = self.start(spacing, method)?;
        let before = Balance::of(&solver);
        let size = SPEED * 2.0_f64.sqrt() * DENSITY * 2.0 * PI * RADIUS * RADIUS;
        let steps = (self.duration_s.value() / step).round() as usize;
        let (mut contact, mut drift, mut growth) = (f64::NAN, 0.0_f64, 0.0_f64);
        let mut film = Vec::new();
        for k in 1..=steps {
            clock.time(|| solver.step(step)).map_err(ExperimentError::stopped)?;
            let now = Balance::of(&solver);
            drift = drift.max(
                (now.momenta[0][0] + now.momenta[1][0]).hypot(now.momenta[0][1] + now.momenta[1][1]) / size,
            );
            growth = growth.max(now.energy / before.energy - 1.0);
            let change = now.momenta[0][0] - before.momenta[0][0];
            if contact.is_nan() && change.abs() > TOUCH * size {
                contact = solver.time();
            }
            if at.frames.is_some() && k * FRAMES / steps > (k - 1) * FRAMES / steps {
                film.push(portrait(&solver, spacing / method.along as f64, at.method));
            }
        }
        let after = Balance::of(&solver);
        let returned =
            -(after.momenta[0][0] + after.momenta[0][1]) / (before.momenta[0][0] + before.momenta[0][1]);
        let outcome = solver.counted(
            Outcome::default()
                .error("contact before rims touch", CONTACT - contact)
                .error("energy lost", 1.0 - after.energy / before.energy)
                .error("kinetic energy not recovered", 1.0 - after.kinetic / before.kinetic)
                .error("velocity not returned", 1.0 - returned)
                .invariant("momentum from nothing", drift)
                .invariant("largest growth of energy", growth),
        );
        filmed(outcome, at, "the encounter, coloured by speed", (&film, 4.0))
    }
}

fn portrait(solver: &Solver<2>, gap: f64, method: &str) -> Portrait<2> {
    let mut seen = Portrait {
        radius: 0.5 * gap,
        field: ("speed", "m/s"),
        range: Some((0.0, 0.2)),
        lines: vec![vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]]],
        label: format!("{method}, t = {:.2} s", solver.time()),
        ..Portrait::default()
    };
    for body in 0..2 {
        seen.positions.extend(solver.positions(body));
        seen.values.extend(solver.velocities(body).iter().map(|v| v[0].hypot(v[1])));
    }
    seen
}
