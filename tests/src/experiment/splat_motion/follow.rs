//! Whether what is drawn is what was simulated, and films of it.

use super::particles::ParticleDrive;
use super::{Drive, ParticleStep, SplatRun, SplatStep, refused};
use crate::experiment::{Clock, ExperimentError, Outcome, Point};
use crate::picture::Film;
use mechanics_core::mesh::BoundingBox;
use mechanics_core::tensor::{Mat3, Vec3};

/// How far a frame's splats are from where they ought to be.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Deviation {
    /// Of means, in diagonals of the matter's box at rest.
    pub(super) means: f64,
    /// Of covariances A from F A₀ Fᵀ, relative.
    pub(super) covariances: f64,
}

impl Deviation {
    /// Of the frame of `run` from positions and total deformations of its matter in the simulation.
    ///
    /// The file's coordinates are a basis: with y = M x + t, x = M⁻¹ (y − t) and F becomes M⁻¹ F M, by an inverse matrix and not by a rotation's transpose;
    /// covariances, not half-axes, are multiplied. Both in `f64`, from the splats at rest.
    pub(super) fn of(run: &SplatRun, moved: impl Iterator<Item = (Vec3, Mat3)>) -> Self {
        let place = &run.place;
        let matrix = place.rotation() * place.scale();
        // A rotation and a scale above zero have one.
        let inverse = matrix.try_inverse().unwrap_or_else(Mat3::identity);
        let (rest, frame) = (run.transport.rest(), run.transport.frame());
        let matter = run.transport.matter();
        let means: Vec<Vec3> = matter.iter().map(|&i| rest.means()[i as usize].cast()).collect();
        let size = BoundingBox::of(&means).map_or(1.0, |bounds| bounds.size().norm());
        let mut worst = Self::default();
        for (&i, (y, f)) in matter.iter().zip(moved) {
            let i = i as usize;
            let mean = inverse * (y - place.translation());
            worst.means = worst.means.max((frame.means()[i].cast::<f64>() - mean).norm() / size);
            let at_rest = full(rest.covariance(i));
            let f = inverse * f * matrix;
            let expected = f * at_rest * f.transpose();
            let off = (full(frame.covariance(i)) - expected).norm() / expected.norm();
            worst.covariances = worst.covariances.max(off);
        }
        worst
    }

    /// The larger of each.
    pub(super) fn merged(self, other: Self) -> Self {
        Self { means: self.means.max(other.means), covariances: self.covariances.max(other.covariances) }
    }
}

/// The next frame of a run of particles, taken by the camera: what was measured, and how far its splats are off.
///
/// # Errors
/// Those of the run, and where no particles move it.
pub(super) fn particle_frame(
    run: &mut SplatRun,
    shooting: &mut Shooting<'_>,
    clock: &mut Clock,
) -> Result<(ParticleStep, Deviation), ExperimentError> {
    let SplatStep::Particles(step) = clock.time(|| run.advance())? else { return Err(no_particles()) };
    clock.time(|| run.carry())?;
    shooting.take(run)?;
    let samples = particles_of(run)?.all();
    let moved = samples.positions().iter().copied().zip(samples.gradients().iter().copied());
    Ok((step, Deviation::of(run, moved)))
}

/// The particles that move a run.
pub(super) fn particles_of(run: &SplatRun) -> Result<&ParticleDrive, ExperimentError> {
    match &run.drive {
        Drive::Particles(drive) => Ok(drive),
        Drive::Tets(_) => Err(no_particles()),
    }
}

fn no_particles() -> ExperimentError {
    refused("meshes", "this experiment is about particles")
}

/// The whole of a symmetric matrix of its upper triangle.
fn full(upper: [f32; 6]) -> Mat3 {
    let [xx, xy, xz, yy, yz, zz] = upper.map(f64::from);
    Mat3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
}

/// A film, made if pictures are wanted.
pub(super) struct Shooting<'a> {
    at: &'a Point<'a>,
    film: Film,
}

impl<'a> Shooting<'a> {
    /// Of a run of which every `every`-th step is a frame.
    pub(super) fn new(at: &'a Point<'a>, run: &SplatRun, every: usize) -> Self {
        Self { at, film: Film::new(run.seconds_a_frame(every)) }
    }

    /// Takes the splats as they are.
    pub(super) fn take(&mut self, run: &mut SplatRun) -> Result<(), ExperimentError> {
        if self.at.frames.is_some() {
            self.film.push(run.draw()?).map_err(ExperimentError::stopped)?;
        }
        Ok(())
    }

    /// `outcome` with the film and its last picture.
    pub(super) fn add_to(self, outcome: Outcome) -> Result<Outcome, ExperimentError> {
        outcome.filmed_to_the_end(self.at, &self.at.title(), &self.film)
    }
}
