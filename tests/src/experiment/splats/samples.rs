//! How many simulated samples a picture needs.

use super::inside::inside;
use super::plain;
use super::portrait::camera_on;
use super::surface::{Painted, PaintedSurface};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::picture::{Size, difference_image, splat_image};
use crate::scene::quantity::{Count, Finite, Positive};
use gaussian_deform::Splats;
use gaussian_deform::bind::{Moved, SampleBinding, TetBinding, TetGradients};
use gaussian_deform::fill::CellGrid;
use gaussian_deform::raster::{self, Mode, Picture, Settings};
use gaussian_deform::transport::{Colours, Transport};
use mechanics_core::law::Lame;
use mechanics_core::mesh::{BoundingBox, BoxSplit, TetMesh, block};
use mechanics_core::samples::DeformationSamples;
use mechanics_core::state::StateHash;
use mechanics_core::tensor::{Mat3, Vec3};
use mpm_constitutive::elastic::NeoHookean;
use mpm_core::{Samples, Simulation, SimulationOptions};
use schemars::JsonSchema;
use serde::Deserialize;
use std::time::Instant;

/// A painted body that is bent and twisted, its splats bound to a coarser set of samples which move exactly; the ladder is their distance (m).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SplatSamples {
    painted: PaintedSurface,
    /// Curvature of the axis (rad/m).
    bend_rad_m: Finite,
    /// Twist around the axis (rad/m).
    twist_rad_m: Finite,
    /// Steps that a solver makes for a frame.
    steps_a_frame: Count,
    /// Pixels along a side of the picture.
    pixels: Count,
    /// Elastic constants of the particles whose step is timed.
    young_modulus_pa: Positive,
}

const METHODS: [&str; 5] =
    ["nearest particle", "8 particles", "27 particles", "tetrahedra", "smoothed tetrahedra"];

/// A body along y, foot at y = 0: cross-sections are turned by τ y around the axis, then the axis is bent to a circle of curvature κ.
#[derive(Clone, Copy, Debug)]
struct BendAndTwist {
    foot: f64,
    bend: f64,
    twist: f64,
}

impl BendAndTwist {
    /// x = c(s) + u n(s) + w e₃, s = y, (u, w) = (x, z) turned by τ s, c′ = (sin κs, cos κs, 0), n = (cos κs, −sin κs, 0); and its gradient
    /// ∂x/∂X = [n ∂u/∂x + e₃ ∂w/∂x, (1 − κu) c′ + n ∂u/∂s + e₃ ∂w/∂s, n ∂u/∂z + e₃ ∂w/∂z].
    fn place(&self, x: &Vec3) -> (Vec3, Mat3) {
        let s = x.y - self.foot;
        let ((sin_t, cos_t), (sin_b, cos_b)) = ((self.twist * s).sin_cos(), (self.bend * s).sin_cos());
        let (u, w) = (cos_t * x.x - sin_t * x.z, sin_t * x.x + cos_t * x.z);
        // (1 − cos κs)/κ and sin κs/κ, for κ = 0 too.
        let half = 0.5 * self.bend * s;
        let sinc = |a: f64| if a == 0.0 { 1.0 } else { a.sin() / a };
        let axis = Vec3::new(s * half.sin() * sinc(half), s * sinc(self.bend * s), 0.0);
        let (normal, tangent) = (Vec3::new(cos_b, -sin_b, 0.0), Vec3::new(sin_b, cos_b, 0.0));
        let across = |du: f64, dw: f64| normal * du + Vec3::z() * dw;
        let along = tangent * (1.0 - self.bend * u) + across(-self.twist * w, self.twist * u);
        let gradient = Mat3::from_columns(&[across(cos_t, sin_t), along, across(-sin_t, cos_t)]);
        (Vec3::y() * self.foot + axis + across(u, w), gradient)
    }

    fn moved(&self, points: &[Vec3]) -> (Vec<Vec3>, Vec<Mat3>) {
        points.iter().map(|x| self.place(x)).unzip()
    }
}

impl Experiment for SplatSamples {
    fn methods(&self) -> &'static [&'static str] {
        &METHODS
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let painted = self.painted.painted(at.folder)?;
        let motion = BendAndTwist {
            foot: painted.bounds.min.y,
            bend: self.bend_rad_m.value(),
            twist: self.twist_rad_m.value(),
        };
        let rest = painted.splats.cast::<f32>();
        let (positions, gradients) = motion.moved(painted.splats.means());
        let own = transported(&rest, DeformationSamples::new(&positions, &gradients))?;
        let samples = lattice(&painted, at.ladder);
        let mut moved = Moved::new();
        let count = match at.method {
            "tetrahedra" => {
                self.by_tets(&painted, &motion, at.ladder, TetGradients::Constant, clock, &mut moved)?
            }
            "smoothed tetrahedra" => {
                self.by_tets(&painted, &motion, at.ladder, TetGradients::Smooth, clock, &mut moved)?
            }
            method => {
                let neighbours = if method == "nearest particle" {
                    1
                } else if method == "8 particles" {
                    8
                } else {
                    27
                };
                let (to, f) = motion.moved(&samples);
                let bound = SampleBinding::new(&samples, painted.splats.means(), neighbours)
                    .map_err(ExperimentError::stopped)?;
                clock
                    .time(|| bound.move_into(DeformationSamples::new(&to, &f), &mut moved))
                    .map_err(ExperimentError::stopped)?;
                samples.len()
            }
        };
        let bound = clock.time(|| transported(&rest, moved.samples()))?;
        self.simulate(&samples, at.ladder, clock)?;
        let camera = self.camera(&positions, &painted)?;
        let settings = Settings { mode: Mode::Tight, background: [1.0; 3], ..Settings::default() };
        let draw = |splats: &Splats<f32>| {
            raster::render(splats, &camera, &settings).map_err(ExperimentError::stopped)
        };
        let (reference, picture): (Picture<f32>, Picture<f32>) = (draw(&own)?, draw(&bound)?);
        let noise = picture.signal_to_noise(&reference);
        let position = worst(moved.samples().positions(), &positions, |a, b| (a - b).norm());
        let gradient = worst(moved.samples().gradients(), &gradients, |a, b| (a - b).norm());
        let mut hash = StateHash::new();
        hash.add_vectors("positions", moved.samples().positions());
        hash.add("picture", plain::colours(&picture).as_flattened());
        let outcome = Outcome::default()
            .error("picture, root mean square", 10.0_f64.powf(-noise / 20.0))
            .error("position", position)
            .error("deformation gradient", gradient)
            .count("splats", rest.count() as u64)
            .count("samples", count as u64)
            .count("PSNR [dB]", noise.max(0.0) as u64)
            .state(hash.value());
        let caption = format!("{} every {} m: {noise:.1} dB to one particle a splat", at.method, at.ladder);
        outcome.pictured(at, &caption, || {
            let pixels = self.pixels.value();
            let size = Size { width: pixels, height: pixels };
            let (a, b) = (plain::colours(&picture), plain::colours(&reference));
            let difference = difference_image(size, (&a, &b), 4.0, "four times the difference");
            let label = format!("{}: {count} samples", at.method);
            Ok(splat_image(&reference, "one particle a splat")
                .beside(&[splat_image(&picture, &label), difference]))
        })
    }
}

impl SplatSamples {
    /// Splats in a block of tetrahedra with vertices as far apart as samples; answers how many vertices they need.
    fn by_tets(
        &self,
        painted: &Painted,
        motion: &BendAndTwist,
        distance: f64,
        gradients: TetGradients,
        clock: &mut Clock,
        moved: &mut Moved,
    ) -> Result<usize, ExperimentError> {
        let body = tets_around(painted, distance)?;
        let (to, _) = motion.moved(body.points());
        let bound =
            TetBinding::new(&body, painted.splats.means(), gradients).map_err(ExperimentError::stopped)?;
        clock.time(|| bound.move_into(&to, moved)).map_err(ExperimentError::stopped)?;
        Ok(body.points().len())
    }

    /// What a solver pays for a frame with these samples: steps of the material point method on a grid of twice their distance.
    fn simulate(&self, samples: &[Vec3], distance: f64, clock: &mut Clock) -> Result<(), ExperimentError> {
        let positions: Vec<[f64; 3]> = samples.iter().map(|x| (*x).into()).collect();
        let velocities = vec![[0.0; 3]; positions.len()];
        let volumes = vec![distance.powi(3); positions.len()];
        let mut simulation: Simulation<f32, 3> =
            Simulation::new(SimulationOptions::new(2.0 * distance)).map_err(ExperimentError::stopped)?;
        let lame =
            Lame::from_young_poisson(self.young_modulus_pa.value(), 0.3).map_err(ExperimentError::stopped)?;
        let body = Samples { positions: &positions, velocities: &velocities, volumes: &volumes };
        simulation.add_body(NeoHookean::new(lame), 1000.0, body).map_err(ExperimentError::stopped)?;
        let step = simulation.stable_step();
        let start = Instant::now();
        for _ in 0..self.steps_a_frame.value() {
            clock.time(|| simulation.step_unchecked(step)).map_err(ExperimentError::stopped)?;
        }
        clock.add_term("material point method", start.elapsed());
        Ok(())
    }

    fn camera(
        &self,
        positions: &[Vec3],
        painted: &Painted,
    ) -> Result<gaussian_deform::camera::Camera, ExperimentError> {
        let bounds = BoundingBox::of(positions).unwrap_or(painted.bounds);
        let pixels = self.pixels.value();
        camera_on(&bounds, [pixels, pixels], Vec3::y(), (0.4, 0.2)).map_err(ExperimentError::stopped)
    }
}

/// The middles of cells of a length that are inside or hold a splat.
fn lattice(painted: &Painted, distance: f64) -> Vec<Vec3> {
    let counts = [0, 1, 2].map(|k| (painted.bounds.size()[k] / distance).ceil() as usize + 1);
    let origin = painted.bounds.centre() - Vec3::from(counts.map(|count| 0.5 * count as f64)) * distance;
    let grid = CellGrid { origin, cell: distance, counts };
    let mut taken = inside(&painted.mesh, &grid);
    painted.splats.means().iter().filter_map(|x| grid.cell_of(x)).for_each(|cell| taken[cell] = true);
    let middle = |cell: usize| origin + Vec3::from(grid.indices(cell).map(|i| i as f64 + 0.5)) * distance;
    (0..grid.cells()).filter(|&cell| taken[cell]).map(middle).collect()
}

/// Cubes of an edge of which each holds a part of the body, six tetrahedra each.
fn tets_around(painted: &Painted, edge: f64) -> Result<TetMesh, ExperimentError> {
    let counts = [0, 1, 2].map(|k| (painted.bounds.size()[k] / edge).ceil() as u32);
    let half = Vec3::from(counts.map(|count| 0.5 * f64::from(count))) * edge;
    let (low, high) = (painted.bounds.centre() - half, painted.bounds.centre() + half);
    let whole = block(&low, &high, counts, BoxSplit::Six).map_err(ExperimentError::stopped)?;
    let grid = CellGrid { origin: low, cell: edge, counts: counts.map(|count| count as usize) };
    let mut taken = inside(&painted.mesh, &grid);
    painted.splats.means().iter().filter_map(|x| grid.cell_of(x)).for_each(|cell| taken[cell] = true);
    let centre = |tet: usize| whole.corners(tet).iter().sum::<Vec3>() * 0.25;
    let kept = |tet: &usize| grid.cell_of(&centre(*tet)).is_some_and(|cell| taken[cell]);
    let cells = (0..whole.cells().len()).filter(kept).map(|tet| whole.cells()[tet]).collect();
    let mut body = TetMesh::new(whole.points().to_vec(), cells).map_err(ExperimentError::stopped)?;
    body.remove_unreferenced();
    Ok(body)
}

fn transported(rest: &Splats<f32>, samples: DeformationSamples<'_>) -> Result<Splats<f32>, ExperimentError> {
    let all = (0..rest.count() as u32).collect();
    let mut transport =
        Transport::new(rest.clone(), all, Colours::TurnDirections).map_err(ExperimentError::stopped)?;
    transport.deform(samples).map_err(ExperimentError::stopped)?;
    Ok(transport.frame().clone())
}

fn worst<T>(found: &[T], truth: &[T], distance: impl Fn(&T, &T) -> f64) -> f64 {
    found.iter().zip(truth).map(|(a, b)| distance(a, b)).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The gradient is the derivative of the place, by central differences.
    #[test]
    fn gradients_are_those_of_the_motion() {
        let motion = BendAndTwist { foot: -0.5, bend: 0.9, twist: -1.3 };
        let x = Vec3::new(0.2, 0.3, -0.1);
        let (_, gradient) = motion.place(&x);
        for k in 0..3 {
            let step = Vec3::ith(k, 1e-5);
            let difference = (motion.place(&(x + step)).0 - motion.place(&(x - step)).0) / 2e-5;
            assert!((difference - gradient.column(k)).norm() < 1e-9, "{k}: {difference} {gradient}");
        }
        let straight = BendAndTwist { bend: 0.0, twist: 0.0, ..motion };
        assert!((straight.place(&x).0 - x).norm() < 1e-15);
    }
}
