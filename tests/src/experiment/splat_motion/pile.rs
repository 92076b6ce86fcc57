//! A body of splats that flows apart.

use super::follow::{Deviation, Shooting, particle_frame, particles_of};
use super::particles::ParticleDrive;
use super::{ParticleStep, SplatRun, refused};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Positive;
use mechanics_core::tensor::{Mat3, Vec3};
use schemars::JsonSchema;
use serde::Deserialize;

/// The scene's splats, of sand, flow apart and come to rest as a pile.
///
/// # What is checked
/// **F is total.** The motion alone tells the deformation: for a particle k and those near it at rest, L = argmin Σⱼ ‖xⱼ − xₖ − L (Xⱼ − Xₖ)‖². Where the median of ‖L − I‖ first exceeds
/// [`FLOWN`], the median of ‖F − L‖/‖L − I‖ is taken. The elastic part of sand's deformation is nearly I: splats that are carried by it have 1 there.
///
/// **A pile** of dry sand of friction angle φ is nowhere steeper than φ in the large: tan of its slope over tan φ is at most one.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SplatPile {
    /// φ (rad).
    friction_angle_rad: Positive,
}

/// Median of ‖L − I‖ at which deformations are compared.
const FLOWN: f64 = 0.5;
/// Radius of neighbourhoods at rest, in cells.
const NEAR: f64 = 1.0;

impl Experiment for SplatPile {
    fn methods(&self) -> &'static [&'static str] {
        &["particles"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let mut run = SplatRun::new(at.scene, at.folder)?;
        let mut shooting = Shooting::new(at, &run, 1);
        run.carry()?;
        shooting.take(&mut run)?;
        let start = run.measured()?;
        let neighbourhoods = Neighbourhoods::new(particles_of(&run)?);
        let (mut fit, mut deviation, mut steps) = (None, Deviation::default(), 0);
        let mut last = start;
        while run.done() < run.steps() {
            let (step, off) = particle_frame(&mut run, &mut shooting, clock)?;
            deviation = deviation.merged(off);
            if fit.is_none() {
                fit = neighbourhoods.compare(particles_of(&run)?);
            }
            steps += step.steps;
            last = step;
        }
        let fit =
            fit.ok_or_else(|| refused("splats.particles.frames", "it does not flow apart in this time"))?;
        let outcome =
            self.judged(particles_of(&run)?, (&start, &last)).error("F off the neighbours' motion", fit);
        let outcome = outcome
            .error("splats off the particles", deviation.means)
            .error("covariances off F A Fᵀ", deviation.covariances);
        let outcome = run.counted(outcome, steps);
        shooting.add_to(outcome)
    }
}

impl SplatPile {
    /// What is said of the end.
    fn judged(&self, drive: &ParticleDrive, (start, last): (&ParticleStep, &ParticleStep)) -> Outcome {
        let samples = drive.all();
        let volumes = || drive.volumes().iter().zip(samples.gradients());
        let (before, after) = volumes().fold((0.0, 0.0), |(b, a), (v, f)| (b + v, a + v * f.determinant()));
        let slope = slope(samples.positions()) / self.friction_angle_rad.value().tan();
        Outcome::default()
            .error("volume", (after / before - 1.0_f64).abs())
            .invariant("slope over tan φ", slope)
            .invariant("kinetic energy left", last.kinetic / start.weight)
            .invariant("change of mass", (last.mass / start.mass - 1.0).abs())
            .invariant("smallest det F", last.smallest_volume_ratio)
    }
}

/// The slope of a pile: heights are the 95 % quantile of what lies in each of rings of equal area around the middle, and the slope that of the line of
/// least squares from the ring with three quarters of the greatest height to that with one quarter.
fn slope(positions: &[Vec3]) -> f64 {
    const RINGS: usize = 40;
    let middle = positions.iter().sum::<Vec3>() / positions.len() as f64;
    let mut all: Vec<(f64, f64)> = positions.iter().map(|x| ((x - middle).xy().norm(), x.z)).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    // The outermost hundredth are grains that rolled away.
    let reach = all[all.len() * 99 / 100].0;
    let ring = |r: f64| ((r / reach).powi(2) * RINGS as f64) as usize;
    let mut heights = vec![Vec::new(); RINGS];
    for (r, z) in all.into_iter().filter(|(r, _)| *r < reach) {
        heights[ring(r).min(RINGS - 1)].push(z);
    }
    let profile: Vec<(f64, f64)> = heights
        .iter_mut()
        .enumerate()
        .filter(|(_, ring)| !ring.is_empty())
        .map(|(k, ring)| {
            ring.sort_by(f64::total_cmp);
            (reach * ((k as f64 + 0.5) / RINGS as f64).sqrt(), ring[ring.len() * 95 / 100])
        })
        .collect();
    let top = profile.iter().map(|(_, z)| *z).fold(0.0, f64::max);
    let flank: Vec<(f64, f64)> =
        profile.into_iter().filter(|(_, z)| (0.25 * top..0.75 * top).contains(z)).collect();
    let count = flank.len() as f64;
    let (r, z) = flank.iter().fold((0.0, 0.0), |(a, b), (r, z)| (a + r / count, b + z / count));
    let (up, across) =
        flank.iter().fold((0.0, 0.0), |(u, a), p| (u + (p.0 - r) * (p.1 - z), a + (p.0 - r).powi(2)));
    -up / across
}

/// Which particles are near to which at rest: every few of them, for which that is enough to tell a deformation.
struct Neighbourhoods {
    rest: Vec<Vec3>,
    near: Vec<(usize, Vec<usize>)>,
}

impl Neighbourhoods {
    fn new(drive: &ParticleDrive) -> Self {
        const CENTRES: usize = 400;
        let rest = drive.all().positions().to_vec();
        let radius = NEAR * drive.made.spacing;
        let every = rest.len().div_ceil(CENTRES);
        let near = (0..rest.len())
            .step_by(every)
            .map(|k| {
                let near = |&j: &usize| j != k && (rest[j] - rest[k]).norm() < radius;
                (k, (0..rest.len()).filter(near).collect::<Vec<_>>())
            })
            .filter(|(_, near)| near.len() >= 8)
            .collect();
        Self { rest, near }
    }

    /// The median of ‖F − L‖/‖L − I‖, once that of ‖L − I‖ is large enough.
    fn compare(&self, drive: &ParticleDrive) -> Option<f64> {
        let samples = drive.all();
        let (mut sizes, mut errors) = (Vec::new(), Vec::new());
        for (k, near) in &self.near {
            let (mut moved, mut square) = (Mat3::zeros(), Mat3::zeros());
            for &j in near {
                let rest = self.rest[j] - self.rest[*k];
                moved += (samples.positions()[j] - samples.positions()[*k]) * rest.transpose();
                square += rest * rest.transpose();
            }
            // Neighbours in one plane do not tell.
            let Some(inverse) = square.try_inverse() else { continue };
            let fitted = moved * inverse;
            let size = (fitted - Mat3::identity()).norm();
            sizes.push(size);
            errors.push((samples.gradients()[*k] - fitted).norm() / size);
        }
        (median(&mut sizes)? > FLOWN).then(|| median(&mut errors)).flatten()
    }
}

fn median(values: &mut [f64]) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}
