//! A scene that is stretched uniformly, by whatever route, is the closed form.

use super::plain::{self, Rounding, Rules};
use super::portrait::camera_on;
use super::surface::{Painted, PaintedSurface, Place};
use crate::experiment::random::Random;
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::picture::{Size, colour_image, difference_image, splat_image};
use crate::scene::quantity::{Count, Positive, Vector};
use gaussian_deform::Splats;
use gaussian_deform::bind::{Moved, SampleBinding, TetBinding, TetGradients};
use gaussian_deform::raster::{self, Mode, Settings};
use gaussian_deform::similarity::Similarity;
use gaussian_deform::transport::{Colours, Transport, advance_axes, advance_covariance};
use mechanics_core::mesh::{BoundingBox, BoxSplit, block};
use mechanics_core::samples::DeformationSamples;
use mechanics_core::state::StateHash;
use mechanics_core::tensor::{Mat3, Vec3};
use nalgebra::Rotation3;
use schemars::JsonSchema;
use serde::Deserialize;

/// x = R U X, U = Q diag(s) Qᵀ, of a whole scene; the ladder is the length of an increment (1), of which those routes need many that add increments.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SplatStretch {
    painted: PaintedSurface,
    /// s.
    stretches: [Positive; 3],
    /// Q: axis times angle (rad).
    stretch_axes_rad: Vector,
    /// R: axis times angle (rad).
    rotation_rad: Vector,
    /// Pixels along a side of the picture.
    pixels: Count,
}

const METHODS: [&str; 6] = [
    "own samples",
    "few samples",
    "tetrahedra",
    "turned coordinates",
    "increments of half-axes",
    "increments of covariances",
];
const BACKGROUND: [f64; 3] = [1.0; 3];

/// R(t) = exp(t [ω]×) and U(t) = Q diag(sᵗ) Qᵀ from rest at t = 0 to the whole motion at t = 1.
struct Stretch {
    spin: Vec3,
    frame: Mat3,
    stretches: Vec3,
}

impl Stretch {
    fn rotation(&self, t: f64) -> Mat3 {
        Rotation3::new(self.spin * t).into_inner()
    }

    fn gradient(&self, t: f64) -> Mat3 {
        let stretches = Mat3::from_diagonal(&self.stretches.map(|s| s.powf(t)));
        self.rotation(t) * self.frame * stretches * self.frame.transpose()
    }

    /// Ḟ F⁻¹ = [ω]× + R Q diag(ln s) Qᵀ Rᵀ.
    fn velocity_gradient(&self, t: f64) -> Mat3 {
        let frame = self.rotation(t) * self.frame;
        self.spin.cross_matrix()
            + frame * Mat3::from_diagonal(&self.stretches.map(f64::ln)) * frame.transpose()
    }
}

impl Experiment for SplatStretch {
    fn methods(&self) -> &'static [&'static str] {
        &METHODS
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let painted = self.painted.painted(at.folder)?;
        let vector = |v: Vector| Vec3::from(v.map(|x| x.value()));
        let stretch = Stretch {
            spin: vector(self.rotation_rad),
            frame: Rotation3::new(vector(self.stretch_axes_rad)).into_inner(),
            stretches: Vec3::from(self.stretches.map(Positive::value)),
        };
        let (f, r) = (stretch.gradient(1.0), stretch.rotation(1.0));
        let frame = clock.time(|| by_route(at.method, &painted, &stretch, at.ladder))?;
        let (position, covariance) = errors(&painted, &frame, &f);
        let pixels = self.pixels.value();
        let corners = painted.mesh.points().iter().map(|x| f * x).collect::<Vec<_>>();
        let bounds = BoundingBox::of(&corners).unwrap_or(painted.bounds);
        let camera =
            camera_on(&bounds, [pixels, pixels], Vec3::y(), (0.5, 0.25)).map_err(ExperimentError::stopped)?;
        let settings = Settings { mode: Mode::Tight, background: BACKGROUND, ..Settings::default() };
        let picture = raster::render(&frame, &camera, &settings).map_err(ExperimentError::stopped)?;
        let closed = painted.seen(&camera, |x| Place { position: f * x, gradient: f, rotation: r });
        let truth = plain::draw(&closed, &camera, BACKGROUND, Rules::Of(Mode::Tight), &Rounding::DOUBLE);
        let found = plain::difference(&plain::colours(&picture), &truth.colours, &truth.fragile);
        let mut hash = StateHash::new();
        hash.add_vectors("means", frame.means());
        hash.add("picture", plain::colours(&picture).as_flattened());
        let outcome = Outcome::default()
            .error("covariance", covariance)
            .error("position", position)
            .error("picture", found.largest)
            .count("splats", frame.count() as u64)
            .invariant("share of pixels at a threshold", found.fragile)
            .state(hash.value());
        let caption = format!("{}: a scene at rest, stretched, and less the closed form", at.method);
        outcome.pictured(at, &caption, || {
            let rest =
                raster::render(&painted.splats, &camera, &settings).map_err(ExperimentError::stopped)?;
            let size = Size { width: pixels, height: pixels };
            let found = plain::colours(&picture);
            let difference =
                difference_image(size, (&found, &truth.colours), 4.0, "four times their difference");
            let truth = colour_image(size, &truth.colours, "closed form");
            Ok(splat_image(&rest, "at rest").beside(&[splat_image(&picture, at.method), truth, difference]))
        })
    }
}

/// The largest errors of a mean \[m\] and of a covariance, by its size.
fn errors(painted: &Painted, frame: &Splats<f64>, f: &Mat3) -> (f64, f64) {
    let (mut position, mut covariance) = (0.0_f64, 0.0_f64);
    for i in 0..frame.count() {
        let (mean, axes) = (painted.splats.means()[i], painted.splats.axes()[i]);
        position = position.max((frame.means()[i] - f * mean).norm());
        let truth = f * (axes * axes.transpose()) * f.transpose();
        let found = symmetric(frame.covariance(i));
        covariance = covariance.max((found - truth).norm() / truth.norm());
    }
    (position, covariance)
}

fn symmetric([xx, xy, xz, yy, yz, zz]: [f64; 6]) -> Mat3 {
    Mat3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
}

/// The stretched scene by one of the routes; increments are of the given length.
fn by_route(
    route: &str,
    painted: &Painted,
    stretch: &Stretch,
    increment: f64,
) -> Result<Splats<f64>, ExperimentError> {
    let means = painted.splats.means();
    let (f, mut moved) = (stretch.gradient(1.0), Moved::new());
    match route {
        "few samples" => {
            let (low, size) = (painted.bounds.min, painted.bounds.size());
            let mut random = Random::new(9);
            let mut place = || low + size.map(|side| 0.5 * side * (1.0 + random.symmetric()));
            let samples: Vec<Vec3> = (0..40).map(|_| place()).collect();
            let positions: Vec<Vec3> = samples.iter().map(|x| f * x).collect();
            let gradients = vec![f; samples.len()];
            SampleBinding::new(&samples, means, 8)
                .and_then(|bound| {
                    bound.move_into(DeformationSamples::new(&positions, &gradients), &mut moved)
                })
                .map_err(ExperimentError::stopped)?;
        }
        "tetrahedra" => {
            // Half of the body only: the other half hangs outside of the outermost tetrahedra.
            let (low, high) = (painted.bounds.min, painted.bounds.centre());
            let body = block(&low, &high, [3, 3, 3], BoxSplit::Six).map_err(ExperimentError::stopped)?;
            let positions: Vec<Vec3> = body.points().iter().map(|x| f * x).collect();
            TetBinding::new(&body, means, TetGradients::Smooth)
                .and_then(|bound| bound.move_into(&positions, &mut moved))
                .map_err(ExperimentError::stopped)?;
        }
        "turned coordinates" => {
            let turn = Rotation3::new(Vec3::new(0.4, -1.1, 0.7)).into_inner();
            let there =
                Similarity::new(3.0, turn, Vec3::new(5.0, 4.0, 3.0)).map_err(ExperimentError::stopped)?;
            let positions: Vec<Vec3> = means.iter().map(|x| there.point(&(f * x))).collect();
            let gradients = vec![turn * f * turn.transpose(); means.len()];
            there.motion_back_into(DeformationSamples::new(&positions, &gradients), &mut moved);
        }
        _ => {
            let positions: Vec<Vec3> = means.iter().map(|x| f * x).collect();
            return match route {
                "own samples" => transported(painted, &positions, &vec![f; means.len()]),
                route => incremented(route, painted, stretch, increment, &positions),
            };
        }
    }
    transported(painted, moved.samples().positions(), moved.samples().gradients())
}

fn transported(
    painted: &Painted,
    positions: &[Vec3],
    gradients: &[Mat3],
) -> Result<Splats<f64>, ExperimentError> {
    let all = (0..painted.splats.count() as u32).collect();
    let mut transport = Transport::new(painted.splats.clone(), all, Colours::RotateCoefficients)
        .map_err(ExperimentError::stopped)?;
    transport.deform(DeformationSamples::new(positions, gradients)).map_err(ExperimentError::stopped)?;
    Ok(transport.frame().clone())
}

/// Shapes from velocity gradients, one increment after the other; positions and rotations exact.
fn incremented(
    route: &str,
    painted: &Painted,
    stretch: &Stretch,
    increment: f64,
    positions: &[Vec3],
) -> Result<Splats<f64>, ExperimentError> {
    let mut frame = transported(painted, positions, &vec![stretch.rotation(1.0); positions.len()])?;
    let steps = (1.0 / increment).round() as usize;
    let rates: Vec<Mat3> = (0..steps).map(|k| stretch.velocity_gradient(k as f64 * increment)).collect();
    for (axes, rest) in frame.axes_mut().iter_mut().zip(painted.splats.axes()) {
        *axes = if route == "increments of half-axes" {
            rates.iter().fold(*rest, |axes, rate| advance_axes(&axes, rate, increment))
        } else {
            let covariance = gaussian_deform::splats::covariance(rest);
            let grown = |covariance, rate| advance_covariance(covariance, rate, increment);
            let eigen = symmetric(rates.iter().fold(covariance, grown)).symmetric_eigen();
            // The increments may have lost its definiteness.
            eigen.eigenvectors * Mat3::from_diagonal(&eigen.eigenvalues.map(|v| v.max(0.0).sqrt()))
        };
    }
    Ok(frame)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The velocity gradient is the derivative of the motion, by central differences.
    #[test]
    fn rates_are_those_of_the_motion() {
        let stretch = Stretch {
            spin: Vec3::new(0.3, -0.5, 0.9),
            frame: Rotation3::new(Vec3::new(0.2, 0.4, -0.1)).into_inner(),
            stretches: Vec3::new(1.7, 0.6, 1.1),
        };
        for t in [0.1, 0.5, 0.9] {
            let rate = (stretch.gradient(t + 1e-5) - stretch.gradient(t - 1e-5)) / 2e-5;
            let exact = stretch.velocity_gradient(t) * stretch.gradient(t);
            assert!((rate - exact).norm() < 1e-9, "{t}");
        }
    }
}
