//! Motions with a body force that makes them solutions: large strain, rotation and free surfaces, with the exact place of every particle.

use super::cloud::Cloud;
use super::known_motion::KnownMotion;
use super::method::Method;
use super::portrait::{Portrait, pictured};
use super::solver::{Elasticity, Matter, Solver, Watch};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Positive;
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::{PI, TAU};

/// A neo-Hookean body in a manufactured motion; the ladder is the distance of nodes Δx (m).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ManufacturedParticles {
    /// The motion.
    motion: Motion,
    /// The step: this times Δx by the speed of longitudinal waves at rest.
    courant_number: Positive,
}

/// The motions.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
enum Motion {
    /// Stretches along the axes, periodic in the unit square, until t = 0.3/c when F runs from 0.75 to 1.25. The body is larger, and only what
    /// no wave from its rim has reached is measured.
    AxisAligned,
    /// Rings that turn, until they have turned by up to this angle.
    Vortex {
        /// (rad).
        turn_rad: Positive,
    },
    /// A ring that breathes, with free rims, for half a period.
    ExpandingRing {
        /// A: how much larger it is at first (m).
        amplitude_m: Positive,
    },
}

/// A motion with what moves.
struct Problem {
    motion: KnownMotion,
    matter: Matter,
    duration: f64,
}

impl Problem {
    fn of(motion: Motion) -> Result<Self, ExperimentError> {
        let neo_hookean = |young, poisson| Matter::new(Elasticity::NeoHookean, (young, poisson), 1000.0);
        Ok(match motion {
            Motion::AxisAligned => {
                let frequency = PI * (1e7_f64 / 1000.0).sqrt();
                let motion = KnownMotion::AxisAligned { amplitude: 0.05, frequency };
                Self { motion, matter: neo_hookean(1e7, 0.3)?, duration: 0.3 * PI / frequency }
            }
            Motion::Vortex { turn_rad } => {
                let motion = KnownMotion::Vortex { turn: turn_rad.value(), period: 1.0 };
                Self { motion, matter: neo_hookean(1000.0, 0.3)?, duration: 0.5 }
            }
            Motion::ExpandingRing { amplitude_m } => {
                let frequency = PI * (1e7_f64 / 1000.0).sqrt();
                let amplitude = amplitude_m.value();
                let motion = KnownMotion::Ring { amplitude, frequency, inner: 0.4, outer: 0.6 };
                Self { motion, matter: neo_hookean(1e7, 0.0)?, duration: PI / frequency }
            }
        })
    }

    /// Particles, `along` an axis of a cell of `spacing`.
    fn cloud(&self, spacing: f64, along: usize) -> Cloud<2> {
        let gap = spacing / along as f64;
        match self.motion {
            KnownMotion::Vortex { .. } => Cloud::annulus(0.75, 1.25, gap),
            KnownMotion::Ring { inner, outer, .. } => Cloud::annulus(inner, outer, gap),
            _ => Cloud::cuboid([-0.25; 2], [1.25; 2], [(1.5 / gap).round() as usize; 2]),
        }
    }

    /// Whether a particle is measured.
    fn measures(&self, x: &[f64; 2]) -> bool {
        match self.motion {
            KnownMotion::AxisAligned { .. } => x.iter().all(|x| (x - 0.5).abs() < 0.25),
            _ => true,
        }
    }

    /// Errors of places and of stresses \[Pa\], a mean square by volume over what is measured, relative to displacements and stresses.
    fn errors(&self, cloud: &Cloud<2>, solver: &Solver<2>) -> [f64; 2] {
        let mut sums = [0.0; 4];
        let time = solver.time();
        let (positions, states) = (solver.positions(0), solver.states(0));
        for (p, rest) in cloud.points.iter().enumerate().filter(|(_, x)| self.measures(x)) {
            let place = self.motion.at(rest, time).position;
            let stress = self.motion.stress(&self.matter, rest, time);
            let terms = [
                distance_squared(&positions[p], &place),
                distance_squared(rest, &place),
                (states[p].kirchhoff - stress).norm_squared(),
                stress.norm_squared(),
            ];
            for (sum, term) in sums.iter_mut().zip(terms) {
                *sum += cloud.volumes[p] * term;
            }
        }
        [(sums[0] / sums[1]).sqrt(), (sums[2] / sums[3]).sqrt()]
    }

    /// Whether a particle is drawn: in every other sector, so that shear is seen, or what is measured.
    fn shows(&self, x: &[f64; 2]) -> bool {
        match self.motion {
            KnownMotion::Vortex { .. } | KnownMotion::Ring { .. } => {
                (x[1].atan2(x[0]) / TAU * SECTORS).floor().rem_euclid(2.0) < 1.0
            }
            _ => self.measures(x),
        }
    }

    /// Where a straight line of material points is.
    fn line(&self, from: [f64; 2], to: [f64; 2], time: f64) -> Vec<[f64; 2]> {
        let point = |k: usize| {
            let part = k as f64 / 60.0;
            let x = std::array::from_fn(|a| from[a] + part * (to[a] - from[a]));
            self.motion.at(&x, time).position
        };
        (0..=60).map(point).collect()
    }

    /// Where the sides of the sectors are, or the lines of a lattice.
    fn lines(&self, time: f64) -> Vec<Vec<[f64; 2]>> {
        let spokes = |inner: f64, outer: f64| {
            let spoke = |k: usize| {
                let (sine, cosine) = (TAU * k as f64 / SECTORS).sin_cos();
                self.line([inner * cosine, inner * sine], [outer * cosine, outer * sine], time)
            };
            (0..SECTORS as usize).map(spoke).collect()
        };
        match self.motion {
            KnownMotion::Vortex { .. } => spokes(0.75, 1.25),
            KnownMotion::Ring { inner, outer, .. } => spokes(inner, outer),
            _ => (0..=8)
                .map(|k| 0.25 + 0.0625 * f64::from(k))
                .flat_map(|c| [self.line([c, 0.25], [c, 0.75], time), self.line([0.25, c], [0.75, c], time)])
                .collect(),
        }
    }

    /// Particles, coloured by how far they are from their exact places, and where lines of material points should be.
    fn portrait(&self, cloud: &Cloud<2>, solver: &Solver<2>, spacing: f64, label: String) -> Portrait<2> {
        let time = solver.time();
        let mut portrait = Portrait {
            radius: 0.35 * (cloud.volume() / cloud.points.len() as f64).sqrt(),
            field: ("off by", "Δx"),
            lines: self.lines(time),
            label,
            ..Portrait::default()
        };
        let seen = solver.positions(0).into_iter().zip(&cloud.points).filter(|(_, rest)| self.shows(rest));
        for (position, rest) in seen {
            let place = self.motion.at(rest, time).position;
            portrait.positions.push(position);
            portrait.values.push(distance_squared(&position, &place).sqrt() / spacing);
        }
        portrait
    }
}

/// Parts of a ring; every other one is drawn.
const SECTORS: f64 = 24.0;

fn distance_squared(a: &[f64; 2], b: &[f64; 2]) -> f64 {
    (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)
}

impl Experiment for ManufacturedParticles {
    fn methods(&self) -> &'static [&'static str] {
        Method::names()
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let method = Method::named(at.method)?;
        let problem = Problem::of(self.motion)?;
        let Problem { motion, matter, duration } = &problem;
        let spacing = at.ladder;
        let cloud = problem.cloud(spacing, method.along);
        let longest = self.courant_number.value() * spacing / matter.wave_speed();
        let steps = (duration / longest).ceil().max(1.0);
        let step = duration / steps;
        let mut solver = motion.start(matter, &cloud, method, (spacing, step))?;
        let mut watch = Watch::start(&solver);
        let steps = steps as usize;
        for k in 0..steps {
            if k % steps.div_ceil(16) == 0 {
                watch.look(&mut solver, step);
            }
            let forces = motion.forces(matter, &cloud, solver.time());
            solver.accelerate(0, &forces, step)?;
            watch.push(matter, &cloud, &forces, step);
            clock.time(|| solver.step(step)).map_err(ExperimentError::stopped)?;
        }
        watch.look(&mut solver, step);
        let [position, stress] = problem.errors(&cloud, &solver);
        let outcome = Outcome::default().error("position", position).error("stress", stress);
        let outcome = watch.free(solver.counted(outcome));
        let caption = format!("{}, Δx = {spacing:.4} m; lines: where material lines should be", at.method);
        pictured(outcome, at, &caption, || {
            let label = format!("{}, Δx = {spacing:.4} m, t = {:.4} s", at.method, solver.time());
            problem.portrait(&cloud, &solver, spacing, label)
        })
    }
}
