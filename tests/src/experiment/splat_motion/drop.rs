//! A body of splats falls and bounces.

use super::follow::{Deviation, Shooting, particle_frame, particles_of};
use super::{ParticleStep, SplatRun};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

/// The scene's splats, which particles move, fall on its floor.
///
/// # Closed form
/// Until it touches the floor, the centre of mass has fallen by g t²/2, and the momentum is m g t. The symplectic Euler method falls by g t (t + h)/2 in steps of h: its
/// error is h/t of the way. The floor does no work, so that the energy does not grow.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SplatDrop {}

/// Matter farther from the floor than so many cells does not know of it.
const FAR: f64 = 2.0;

/// Whether the floor has been felt: what bounces is off the floor again, and its centre does not fall from the start then.
#[derive(PartialEq)]
enum Flight {
    Free,
    Over,
}

/// What was seen on the way.
struct Watch {
    start: ParticleStep,
    fall: f64,
    free_momentum: f64,
    free_frames: u64,
    flight: Flight,
    energy: f64,
    sideways: f64,
    mass: f64,
    smallest: f64,
}

impl Watch {
    fn new(start: ParticleStep) -> Self {
        let smallest = start.smallest_volume_ratio;
        Self {
            start,
            fall: 0.0,
            free_momentum: 0.0,
            free_frames: 0,
            flight: Flight::Free,
            energy: 0.0,
            sideways: 0.0,
            mass: 0.0,
            smallest,
        }
    }

    /// Compares a frame; `lowest` is the height of the lowest particle, `free` what it must be above to be in free fall \[m\].
    fn look(&mut self, step: &ParticleStep, gravity: &Vec3, (lowest, free): (f64, f64)) {
        let (t, start) = (step.time, &self.start);
        let energy = |step: &ParticleStep| step.kinetic + step.stored + step.weight;
        // Of what there is to fall, from the start to the floor.
        self.energy = self.energy.max((energy(step) - energy(start)) / start.weight);
        self.mass = self.mass.max((step.mass / start.mass - 1.0).abs());
        let speed = (2.0 * start.weight / start.mass).sqrt();
        self.sideways = self.sideways.max(step.momentum.xy().norm() / (start.mass * speed));
        self.smallest = self.smallest.min(step.smallest_volume_ratio);
        if lowest <= free {
            self.flight = Flight::Over;
        }
        if self.flight == Flight::Free {
            let way = gravity * (0.5 * t * t);
            self.fall = (step.centre - start.centre - way).norm() / way.norm();
            let momentum = gravity * (start.mass * t);
            self.free_momentum = self.free_momentum.max((step.momentum - momentum).norm() / momentum.norm());
            self.free_frames += 1;
        }
    }
}

impl Experiment for SplatDrop {
    fn methods(&self) -> &'static [&'static str] {
        &["particles"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let mut run = SplatRun::new(at.scene, at.folder)?;
        let mut shooting = Shooting::new(at, &run, 1);
        run.carry()?;
        shooting.take(&mut run)?;
        let start = run.measured()?;
        let (mut watch, mut deviation) = (Watch::new(start), Deviation::default());
        let mut steps = 0;
        while run.done() < run.steps() {
            let (step, off) = particle_frame(&mut run, &mut shooting, clock)?;
            deviation = deviation.merged(off);
            let drive = particles_of(&run)?;
            let lowest = drive.all().positions().iter().map(|x| x.z).fold(f64::INFINITY, f64::min);
            watch.look(&step, &drive.gravity, (lowest, FAR * drive.made.spacing));
            steps += step.steps;
        }
        let outcome = Outcome::default()
            .error("fall", watch.fall)
            .error("momentum in fall", watch.free_momentum)
            .error("splats off the particles", deviation.means)
            .error("covariances off F A Fᵀ", deviation.covariances)
            .invariant("energy gained", watch.energy)
            .invariant("change of mass", watch.mass)
            .invariant("sideways momentum", watch.sideways)
            .invariant("smallest det F", watch.smallest)
            .count("frames in free fall", watch.free_frames);
        let outcome = run.counted(outcome, steps);
        shooting.add_to(outcome)
    }
}
