//! Splats in motion: what runs where a scene has `[splats]`, and experiments with it.
//!
//! The coupling is three lines, [`SplatRun::carry`]: whoever simulates lends positions and total deformation gradients in the simulation's coordinates, the similarity
//! takes them to the file's, and `gaussian-deform` moves the splats. [`particles`] are material points, [`tets`] a [`Course`] of tetrahedra with contact.

mod drives;
mod drop;
pub(super) mod embedded;
mod follow;
mod material;
mod matter;
mod particles;
mod pile;
mod tets;
mod view;

use super::simulation::{Course, Step};
use super::{ExperimentError, Outcome};
use crate::picture::Image;
use crate::scene::SceneFile;
use crate::scene::quantity::{Count, Positive};
use crate::scene::splats::{Elongation, SplatScene};
pub(super) use drives::SplatDrives;
pub(super) use drop::SplatDrop;
pub(super) use embedded::SplatsOnTets;
use gaussian_deform::Splats;
use gaussian_deform::bind::Moved;
use gaussian_deform::elongation::{limit_elongation, split_elongated};
use gaussian_deform::similarity::Similarity;
use gaussian_deform::transport::{Colours, Transport};
use matter::Matter;
use mechanics_core::checkpoint::{Checkpoint, CheckpointError};
use mechanics_core::state::StateHash;
use mechanics_core::tensor::Vec3;
use mpm_core::ResumeError;
use particles::{Made, ParticleDrive};
pub(super) use pile::SplatPile;
use std::borrow::Cow;
use std::path::Path;
use std::time::{Duration, Instant};
use tets::TetDrive;
use view::View;

/// A scene of splats on its way through time.
pub(crate) struct SplatRun {
    transport: Transport<f32>,
    place: Similarity,
    drive: Drive,
    moved: Moved,
    view: View,
    elongation: Option<Elongation>,
    /// Steps to the end, and that were made: frames of particles, time steps of tetrahedra.
    steps: usize,
    done: usize,
    /// Length of a step \[s\].
    step: f64,
    inverted: usize,
}

enum Drive {
    Particles(Box<ParticleDrive>),
    Tets(Box<TetDrive>),
}

/// What a step did, and what is at its end.
#[derive(Clone, Debug)]
pub(crate) enum SplatStep {
    /// Of particles.
    Particles(ParticleStep),
    /// Of tetrahedra.
    Tets(Box<Step>),
}

/// What the particles' way to the next frame was, and where it led.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ParticleStep {
    /// The number of the frame at its end, from one for that at rest.
    pub(crate) frame: usize,
    /// \[s\]
    pub(crate) time: f64,
    /// Steps of the simulation.
    pub(crate) steps: u64,
    /// \[kg\]
    pub(crate) mass: f64,
    /// Of particles and of the motion around them \[J\].
    pub(crate) kinetic: f64,
    /// \[J\]
    pub(crate) stored: f64,
    /// Of gravity, zero at the origin \[J\].
    pub(crate) weight: f64,
    /// \[kg m/s\]
    pub(crate) momentum: Vec3,
    /// Of mass \[m\].
    pub(crate) centre: Vec3,
    /// Of the total deformation.
    pub(crate) smallest_volume_ratio: f64,
    /// Wall time of the simulation.
    pub(crate) wall: Duration,
}

impl ParticleStep {
    /// The names of what [`row`](Self::row) tells.
    const HEAD: &str = "frame,time_s,steps,mass_kg,kinetic_j,stored_j,weight_j,momentum_x_kg_m_s,momentum_y_kg_m_s,\
        momentum_z_kg_m_s,centre_x_m,centre_y_m,centre_z_m,smallest_det_f,seconds";

    fn row(&self) -> String {
        let Self { frame, time, steps, mass, kinetic, stored, weight, momentum, centre, .. } = self;
        format!(
            "{frame},{time:?},{steps},{mass:?},{kinetic:?},{stored:?},{weight:?},{:?},{:?},{:?},{:?},{:?},{:?},{:?},{:.6}",
            momentum.x,
            momentum.y,
            momentum.z,
            centre.x,
            centre.y,
            centre.z,
            self.smallest_volume_ratio,
            self.wall.as_secs_f64()
        )
    }
}

impl SplatStep {
    /// A row of the table.
    pub(crate) fn row(&self) -> String {
        match self {
            Self::Particles(step) => step.row(),
            Self::Tets(step) => step.row(),
        }
    }
}

/// A checkpoint that cannot be gone on from.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ResumeFault {
    /// It cannot be read, or is of another problem.
    #[error("checkpoint {}: {source}", path.display())]
    File {
        /// The file.
        path: std::path::PathBuf,
        /// Why.
        source: CheckpointError,
    },
    /// It is not a state of these particles.
    #[error("checkpoint {}: {source}", path.display())]
    Particles {
        /// The file.
        path: std::path::PathBuf,
        /// Why.
        source: ResumeError,
    },
    /// It is not a state of these tetrahedra.
    #[error(transparent)]
    Tets(#[from] super::simulation::CheckpointFault),
}

/// Frames, where a scene does not say.
const FRAMES: usize = 61;
/// Frames a second, where a scene does not say.
const FRAME_RATE: f64 = 30.0;

impl SplatRun {
    /// A scene, whose file is in `folder`, at rest.
    ///
    /// # Errors
    /// What cannot be: splats, matter, bodies, conditions, a camera.
    pub(crate) fn new(scene: &SceneFile, folder: &Path) -> Result<Self, ExperimentError> {
        let given = scene.splats.as_ref().ok_or_else(|| refused("splats", "missing"))?;
        let course = match scene.meshes.is_empty() {
            true => None,
            false => Some(Course::new(scene, folder)?),
        };
        let meshes = course.as_ref().and_then(|course| course.bodies().mesh().bounding_box());
        let matter = Matter::new(given, folder, meshes)?;
        let view = View::new(given, folder, &matter)?;
        let particles = given.particles.as_ref();
        let rate = particles.and_then(|p| p.frame_rate_hz).map_or(FRAME_RATE, Positive::value);
        let (drive, steps, step) = match course {
            None => {
                let frames = particles.and_then(|p| p.frames).map_or(FRAMES, Count::value);
                let drive = Drive::Particles(Box::new(ParticleDrive::new(given, &matter)?));
                (drive, frames - 1, 1.0 / rate)
            }
            Some(course) => {
                let (steps, step) = (course.steps(), course.seconds_a_frame(1));
                (Drive::Tets(Box::new(TetDrive::new(course, &matter)?)), steps, step)
            }
        };
        let Matter { splats, list, place, .. } = matter;
        let transport = Transport::new(splats, list, Colours::RotateCoefficients)
            .map_err(|error| refused("splats", error))?;
        let (moved, elongation) = (Moved::new(), given.elongation);
        Ok(Self { transport, place, drive, moved, view, elongation, steps, done: 0, step, inverted: 0 })
    }

    /// Goes on by a step.
    pub(crate) fn advance(&mut self) -> Result<SplatStep, ExperimentError> {
        let begin = Instant::now();
        let next = self.done + 1;
        let step = match &mut self.drive {
            Drive::Particles(drive) => {
                let time = next as f64 * self.step;
                let steps = drive.advance_to(time)?;
                drive.samples()?;
                SplatStep::Particles(ParticleStep {
                    frame: next + 1,
                    wall: begin.elapsed(),
                    ..measure(drive, time, steps)
                })
            }
            Drive::Tets(drive) => SplatStep::Tets(Box::new(drive.course.advance()?)),
        };
        self.done = next;
        Ok(step)
    }

    /// Carries the splats to where the simulation is.
    pub(crate) fn carry(&mut self) -> Result<(), ExperimentError> {
        let samples = match &mut self.drive {
            Drive::Particles(drive) => drive.samples()?,
            Drive::Tets(drive) => drive.samples()?,
        };
        self.place.motion_back_into(samples, &mut self.moved);
        let report = self.transport.deform(self.moved.samples()).map_err(ExperimentError::stopped)?;
        self.inverted = self.inverted.max(report.inverted);
        Ok(())
    }

    /// The splats as they were [carried](Self::carry), in the file's coordinates.
    pub(crate) fn frame(&self) -> Cow<'_, Splats<f32>> {
        let mut frame = Cow::Borrowed(self.transport.frame());
        match self.elongation {
            None => {}
            Some(Elongation::Limit(most)) => {
                limit_elongation(frame.to_mut(), most.value());
            }
            Some(Elongation::Split(most)) => {
                split_elongated(frame.to_mut(), most.value());
            }
        }
        frame
    }

    /// Their picture.
    pub(crate) fn draw(&mut self) -> Result<Image, ExperimentError> {
        let frame = self.frame().into_owned();
        self.view.draw(&frame, self.time())
    }

    /// Time \[s\], or a load's part.
    pub(crate) fn time(&self) -> f64 {
        match &self.drive {
            Drive::Particles(_) => self.done as f64 * self.step,
            Drive::Tets(drive) => drive.course.progress(),
        }
    }

    /// Steps that were made.
    pub(crate) fn done(&self) -> usize {
        self.done
    }

    /// Steps to the end.
    pub(crate) fn steps(&self) -> usize {
        self.steps
    }

    /// How long a frame of every `every` steps stands in a film \[s\].
    pub(crate) fn seconds_a_frame(&self, every: usize) -> f64 {
        self.step * every as f64
    }

    /// The names of the table's columns.
    pub(crate) fn head(&self) -> &'static str {
        match &self.drive {
            Drive::Particles(_) => ParticleStep::HEAD,
            Drive::Tets(drive) => drive.course.head(),
        }
    }

    /// The scene at rest, its matter, and the frame.
    pub(crate) fn transport(&self) -> &Transport<f32> {
        &self.transport
    }

    /// The largest number of splats that were turned inside out at once.
    pub(crate) fn inverted(&self) -> usize {
        self.inverted
    }

    /// What the particles are; `None` for tetrahedra.
    pub(crate) fn made(&self) -> Option<Made> {
        match &self.drive {
            Drive::Particles(drive) => Some(drive.made),
            Drive::Tets(_) => None,
        }
    }

    /// What particles are now, as after a step of none.
    fn measured(&self) -> Result<ParticleStep, ExperimentError> {
        match &self.drive {
            Drive::Particles(drive) => Ok(measure(drive, self.time(), 0)),
            Drive::Tets(_) => Err(refused("meshes", "this is about particles, and there are tetrahedra")),
        }
    }

    /// `outcome` with what every run has.
    fn counted(&self, outcome: Outcome, steps: u64) -> Outcome {
        let mut hash = StateHash::new();
        let means = self.transport.frame().means();
        hash.add_vectors("means", &means.iter().map(|x| x.cast()).collect::<Vec<Vec3>>());
        let particles = self.made().map_or(0, |made| made.particles);
        let mut outcome = outcome
            .count("splats", self.transport.matter().len() as u64)
            .count("particles", particles as u64)
            .count("steps", steps)
            .state(hash.value());
        outcome.simulated_seconds = Some(self.time());
        outcome
    }

    /// Writes what is needed to go on to `path`, whole or not at all.
    pub(crate) fn write_checkpoint(&self, scene: &SceneFile, path: &Path) -> Result<(), ResumeFault> {
        match &self.drive {
            Drive::Particles(drive) => {
                let mut checkpoint = drive.checkpoint();
                checkpoint.put_text("problem", &problem(scene));
                checkpoint.put_one("frames done", self.done as u64);
                let fault = |source| ResumeFault::File { path: path.to_owned(), source };
                checkpoint.write(path).map_err(fault)
            }
            Drive::Tets(drive) => Ok(drive.course.write_checkpoint(scene, path)?),
        }
    }

    /// Goes on from a checkpoint of the same problem; camera and output may differ.
    pub(crate) fn read_checkpoint(&mut self, scene: &SceneFile, path: &Path) -> Result<(), ResumeFault> {
        match &mut self.drive {
            Drive::Particles(drive) => {
                let fault = |source| ResumeFault::File { path: path.to_owned(), source };
                let mut checkpoint = Checkpoint::read(path).map_err(fault)?;
                checkpoint.take_matching_text("problem", &problem(scene)).map_err(fault)?;
                let done: u64 = checkpoint.take_one("frames done").map_err(fault)?;
                drive
                    .resume(checkpoint)
                    .map_err(|source| ResumeFault::Particles { path: path.to_owned(), source })?;
                self.done = done as usize;
            }
            Drive::Tets(drive) => {
                drive.course.read_checkpoint(scene, path)?;
                self.done = drive.course.done();
            }
        }
        Ok(())
    }
}

/// What is at the end of a step of particles.
fn measure(drive: &ParticleDrive, time: f64, steps: u64) -> ParticleStep {
    let totals = drive.totals();
    let sum = |value: fn(&mpm_core::Totals) -> f64| totals.iter().map(value).sum::<f64>();
    let (mass, centre) = (sum(|t| t.mass), drive.centre());
    ParticleStep {
        frame: 0,
        time,
        steps,
        mass,
        kinetic: sum(|t| t.kinetic_energy + t.affine_energy),
        stored: sum(|t| t.stored_energy),
        weight: -mass * drive.gravity.dot(&centre),
        momentum: totals.iter().map(|t| t.momentum).sum(),
        centre,
        smallest_volume_ratio: drive.smallest_volume_ratio(),
        wall: Duration::ZERO,
    }
}

/// What must be equal for a state to be one of the same problem.
fn problem(scene: &SceneFile) -> String {
    let without_output =
        scene.splats.as_ref().map(|given| SplatScene { camera: None, elongation: None, ..given.clone() });
    format!("{without_output:?}")
}

/// The error of a scene that asks for something that cannot be done, by the key that asks.
fn refused(key: impl Into<String>, reason: impl std::fmt::Display) -> ExperimentError {
    ExperimentError::Refused { key: key.into(), reason: reason.to_string() }
}
