//! One body of splats, moved by tetrahedra with contact and by particles.

use super::follow::Shooting;
use super::{SplatRun, SplatStep};
use crate::experiment::simulation::Step;
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::SceneFile;
use crate::scene::physics::MeshSource;
use crate::scene::quantity::{Count, Positive};
use crate::scene::splats::{ParticleLaw, Particles};
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

/// The scene's splats fall on its floor with its sphere of tetrahedra, or with particles that fill them. The ladder is the length of an edge or of a cell by the sphere's radius. Both are compared with
/// finer tetrahedra, frame by frame, and with the free fall until the floor is near.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SplatDrives {
    /// What the particles are; their cells are the ladder's.
    particles: Particles,
    /// Of the particles.
    law: ParticleLaw,
    /// Of the particles (kg/m³).
    density_kg_m3: Positive,
    /// The ladder's value of the tetrahedra that are compared with.
    reference: Positive,
    /// Until here nothing touches (s).
    free_s: Positive,
}

/// The number of frames and how long each stands (s).
#[derive(Clone, Copy)]
struct Frames {
    count: usize,
    seconds: f64,
}

/// What came of a run.
struct Found {
    /// Means of the splats, in metres, frame by frame.
    means: Vec<Vec<Vec3>>,
    smallest: f64,
    steps: u64,
}

impl SplatDrives {
    fn frames(&self) -> Frames {
        let rate = self.particles.frame_rate_hz.map_or(30.0, Positive::value);
        Frames { count: self.particles.frames.map_or(31, Count::value), seconds: 1.0 / rate }
    }

    /// The scene by tetrahedra with edges of so many radii.
    fn by_tets(&self, scene: &SceneFile, part: f64) -> Result<(SceneFile, f64), ExperimentError> {
        let mut scene = scene.clone();
        let Some(MeshSource::Sphere { radius_m, edge_m }) =
            scene.meshes.first_mut().map(|mesh| &mut mesh.source)
        else {
            return Err(refused("meshes.0.source", "must be a sphere"));
        };
        let radius = radius_m.value();
        *edge_m = Positive::try_from(part * radius).map_err(|error| refused("meshes.0.source", &error))?;
        Ok((scene, radius))
    }

    /// The same splats by particles in cells of so many radii.
    fn by_particles(&self, scene: &SceneFile, part: f64) -> Result<SceneFile, ExperimentError> {
        let cells = Count::try_from((2.0 / part).round());
        let cells = cells.map_err(|error| refused("validation.ladder", &error))?;
        let mut splats = scene.splats.clone().ok_or_else(|| refused("splats", "missing"))?;
        splats.particles = Some(Particles { cells: Some(cells), ..self.particles.clone() });
        splats.law = Some(self.law);
        splats.density_kg_m3 = Some(self.density_kg_m3);
        Ok(SceneFile {
            splats: Some(splats),
            meshes: Vec::new(),
            materials: Vec::new(),
            loads: Vec::new(),
            contact: None,
            integration: None,
            solver: None,
            ..scene.clone()
        })
    }
}

fn refused(key: &str, reason: &str) -> ExperimentError {
    super::refused(key, reason)
}

/// Runs to the end; `shooting` takes the frames.
fn followed(
    run: &mut SplatRun,
    frames: Frames,
    clock: &mut Clock,
    mut shooting: Option<&mut Shooting<'_>>,
) -> Result<Found, ExperimentError> {
    let mut found = Found { means: Vec::new(), smallest: f64::INFINITY, steps: 0 };
    let every = ((frames.seconds / run.seconds_a_frame(1)).round() as usize).max(1);
    loop {
        if run.done().is_multiple_of(every) {
            clock.time(|| run.carry())?;
            let means = run.transport.frame().means().iter();
            found.means.push(means.map(|x| run.place.point(&x.cast())).collect());
            if let Some(shooting) = &mut shooting {
                shooting.take(run)?;
            }
        }
        if found.means.len() == frames.count || run.done() == run.steps() {
            return Ok(found);
        }
        match clock.time(|| run.advance())? {
            SplatStep::Particles(step) => {
                found.smallest = found.smallest.min(step.smallest_volume_ratio);
                found.steps += step.steps;
            }
            SplatStep::Tets(step) => {
                found.smallest = found.smallest.min(step.smallest_volume_ratio());
                found.steps += 1;
                if let Step::Time(step) = *step {
                    clock.add_term("assembly", step.report.newton.times.assembly);
                    clock.add_term("linear solve", step.report.newton.times.solve);
                }
            }
        }
    }
}

fn centre(means: &[Vec3]) -> Vec3 {
    means.iter().sum::<Vec3>() / means.len() as f64
}

/// Root mean square of the distances of equal splats.
fn apart(a: &[Vec3], b: &[Vec3]) -> f64 {
    (a.iter().zip(b).map(|(a, b)| (a - b).norm_squared()).sum::<f64>() / a.len() as f64).sqrt()
}

impl Experiment for SplatDrives {
    fn methods(&self) -> &'static [&'static str] {
        &["tetrahedra", "particles"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let frames = self.frames();
        let (fine, radius) = self.by_tets(at.scene, self.reference.value())?;
        let scene = match at.method {
            "particles" => self.by_particles(at.scene, at.ladder)?,
            _ => self.by_tets(at.scene, at.ladder)?.0,
        };
        let mut run = SplatRun::new(&scene, at.folder)?;
        let mut shooting =
            Shooting::new(at, &run, (frames.seconds / run.seconds_a_frame(1)).round() as usize);
        let found = followed(&mut run, frames, clock, Some(&mut shooting))?;
        let mut other = SplatRun::new(&fine, at.folder)?;
        let truth = followed(&mut other, frames, &mut Clock::default(), None)?;

        let (start, free) = (centre(&found.means[0]), self.free_s.value());
        let mut fall = 0.0_f64;
        let (mut worst, mut sum) = (0.0_f64, 0.0);
        let (mut lowest, mut deepest) = (f64::INFINITY, f64::INFINITY);
        for (number, (means, true_means)) in found.means.iter().zip(&truth.means).enumerate() {
            let time = number as f64 * frames.seconds;
            if number > 0 && time < free {
                let way = 0.5 * 9.81 * time * time;
                fall = (centre(means) - start + Vec3::z() * way).norm() / way;
            }
            let off = apart(means, true_means) / radius;
            worst = worst.max(off);
            sum += off * off;
            lowest = lowest.min(centre(means).z);
            deepest = deepest.min(centre(true_means).z);
        }
        let count = found.means.len().min(truth.means.len()) as f64;
        let outcome = Outcome::default()
            .error("splats apart", (sum / count).sqrt())
            .error("splats apart at most", worst)
            .error("lowest centre", (lowest - deepest).abs() / radius)
            .error("free fall", fall)
            .invariant("smallest det F", found.smallest)
            .invariant("frames", count)
            .invariant("lowest centre by the radius", lowest / radius);
        let outcome = run.counted(outcome, found.steps);
        shooting.add_to(outcome)
    }
}
