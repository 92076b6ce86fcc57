//! Splats in tetrahedra that contact stops.

use super::follow::{Deviation, Shooting};
use super::tets::TetDrive;
use super::{Drive, SplatRun, SplatStep, refused};
use crate::experiment::simulation::Step;
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use gaussian_deform::bind::{Moved, TetBinding, TetGradients};
use gaussian_deform::select;
use ipc_contact::collision_mesh::{CollisionMesh, CollisionMeshBuilder, CollisionObject};
use ipc_contact::intersection;
use mechanics_core::mesh::TetMesh;
use mechanics_core::tensor::{Mat3, Vec3};
use schemars::JsonSchema;
use serde::Deserialize;

/// The scene's splats move with its tetrahedra, which fall on its floor.
///
/// # What is checked
/// **Splats follow.** Which tetrahedron a splat is in is found anew, by trying all of them; its four vertices say where the splat is.
///
/// **An affine motion is reproduced**: vertices at A X + b give means A μ + b and gradients A, to rounding, for both choices of gradients.
///
/// **Contact**: surfaces keep a distance, and the exact test finds no two triangles that intersect, in any frame.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SplatsOnTets {}

impl Experiment for SplatsOnTets {
    fn methods(&self) -> &'static [&'static str] {
        &["tetrahedra"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let mut run = SplatRun::new(at.scene, at.folder)?;
        let Drive::Tets(drive) = &run.drive else {
            return Err(refused("meshes", "this experiment is about tetrahedra"));
        };
        let mesh = drive.course.bodies().mesh().clone();
        let means = select::means(run.transport.rest(), run.transport.matter());
        let means: Vec<Vec3> = means.iter().map(|x| run.place.point(x)).collect();
        let (places, outside) = places(&mesh, &means);
        let affine = affine(&mesh, &means)?;
        let skin = skin(drive)?;
        // A picture every tenth of a second at least.
        let every = ((0.04 / run.seconds_a_frame(1)).round() as usize).max(1);
        let mut shooting = Shooting::new(at, &run, every);
        run.carry()?;
        shooting.take(&mut run)?;
        let (mut deviation, mut intersections, mut gap, mut smallest) = (0.0_f64, 0, f64::INFINITY, 1.0_f64);
        let (mut iterations, mut touches) = (0, 0);
        while run.done() < run.steps() {
            let SplatStep::Tets(step) = clock.time(|| run.advance())? else { break };
            clock.time(|| run.carry())?;
            if run.done() % every == 0 {
                shooting.take(&mut run)?;
            }
            let Step::Time(step) = *step else {
                return Err(refused("integration", "this experiment is about motion in time"));
            };
            let Drive::Tets(drive) = &run.drive else { break };
            let x = drive.course.positions();
            let expected = places.iter().map(|(cell, weights)| {
                let corners = mesh.cells()[*cell].map(|v| x[v as usize]);
                ((0..4).map(|k| corners[k] * weights[k]).sum(), Mat3::identity())
            });
            deviation = deviation.max(Deviation::of(&run, expected).means);
            intersections += intersection::check(&skin, x).map_err(ExperimentError::stopped)?.len();
            gap = gap.min(step.smallest_distance);
            smallest = smallest.min(step.smallest_volume_ratio);
            iterations += step.report.newton.iterations;
            touches = touches.max(step.contacts);
        }
        let outcome = Outcome::default()
            .error("splats off their tetrahedra", deviation)
            .error("affine motion", affine)
            .invariant("intersections", intersections as f64)
            .invariant("smallest distance", gap)
            .invariant("smallest det F", smallest)
            .invariant("splats outside", outside as f64)
            .count("Newton iterations", iterations)
            .count("pairs in contact, at most", touches as u64);
        let outcome = run.counted(outcome, run.done() as u64);
        shooting.add_to(outcome)
    }
}

/// The tetrahedron of each mean and its barycentric coordinates there, by trying all; and how many are in none, which then get the one that they are least outside of.
pub(in crate::experiment) fn places(mesh: &TetMesh, means: &[Vec3]) -> (Vec<(usize, [f64; 4])>, usize) {
    let inverses: Vec<(Vec3, Mat3)> = (0..mesh.cells().len())
        .map(|cell| {
            let [a, b, c, d] = mesh.corners(cell);
            let edges = Mat3::from_columns(&[b - a, c - a, d - a]);
            (a, edges.try_inverse().unwrap_or_else(Mat3::zeros))
        })
        .collect();
    let mut outside = 0;
    let places = means
        .iter()
        .map(|mean| {
            let weights = |(origin, inverse): &(Vec3, Mat3)| {
                let [u, v, w] = (inverse * (mean - origin)).into();
                [1.0 - u - v - w, u, v, w]
            };
            let depth = |weights: &[f64; 4]| weights.iter().copied().fold(f64::INFINITY, f64::min);
            let all = inverses.iter().map(weights).enumerate();
            let best = all.max_by(|a, b| depth(&a.1).total_cmp(&depth(&b.1)));
            let best = best.unwrap_or((0, [1.0, 0.0, 0.0, 0.0]));
            // On a face rounding may say either side.
            outside += usize::from(depth(&best.1) < -1e-12);
            best
        })
        .collect();
    (places, outside)
}

/// How far an affine motion of the vertices is from that of the splats, relative to its own size.
fn affine(mesh: &TetMesh, means: &[Vec3]) -> Result<f64, ExperimentError> {
    let a = Mat3::new(1.3, 0.2, -0.1, -0.4, 0.8, 0.3, 0.1, -0.2, 1.1);
    let b = Vec3::new(0.3, -2.0, 1.0);
    let vertices: Vec<Vec3> = mesh.points().iter().map(|x| a * x + b).collect();
    let mut worst: f64 = 0.0;
    for gradients in [TetGradients::Constant, TetGradients::Smooth] {
        let binding = TetBinding::new(mesh, means, gradients).map_err(ExperimentError::stopped)?;
        let mut moved = Moved::new();
        binding.move_into(&vertices, &mut moved).map_err(ExperimentError::stopped)?;
        let samples = moved.samples();
        for ((mean, x), f) in means.iter().zip(samples.positions()).zip(samples.gradients()) {
            let expected = a * mean + b;
            worst = worst.max((x - expected).norm() / expected.norm());
            worst = worst.max((f - a).norm() / a.norm());
        }
    }
    Ok(worst)
}

/// The surfaces of all bodies, for the exact test.
fn skin(drive: &TetDrive) -> Result<CollisionMesh, ExperimentError> {
    let bodies = drive.course.bodies();
    let mut builder = CollisionMeshBuilder::new(bodies.mesh().points());
    for body in bodies.each() {
        let object = CollisionObject::of_tets(&body.mesh, body.points.start as u32);
        builder.add_object(object.map_err(ExperimentError::stopped)?);
    }
    builder.build().map_err(ExperimentError::stopped)
}
