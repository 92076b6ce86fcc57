//! A scene that flows: splats follow the total deformation, not the elastic part that a plastic law keeps.

use super::plain::{self, Rounding, Rules};
use super::portrait::camera_on;
use super::surface::{Painted, PaintedSurface, Place};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::picture::{Size, colour_image, difference_image, splat_image};
use crate::scene::physics::Isotropic;
use crate::scene::quantity::{Count, Positive};
use gaussian_deform::Splats;
use gaussian_deform::raster::{self, Mode, Settings};
use gaussian_deform::transport::{Colours, Transport};
use mechanics_core::law::Lame;
use mechanics_core::mesh::BoundingBox;
use mechanics_core::samples::DeformationSamples;
use mechanics_core::state::StateHash;
use mechanics_core::tensor::{Mat3, Vec3};
use mpm_constitutive::plastic::{VonMises, YieldStress};
use mpm_constitutive::{Motion, PointLaw, fresh_history};
use nalgebra::Rotation3;
use schemars::JsonSchema;
use serde::Deserialize;

/// A painted body that is sheared from its foot upwards, x ↦ x + ½ γ y² / H at the height y above the foot of H; the ladder is γ, the shear at its top.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SplatPlasticShear {
    painted: PaintedSurface,
    constants: Isotropic,
    /// Of von Mises' law, without hardening.
    yield_stress_pa: Positive,
    /// Steps of the law.
    steps: Count,
    /// Pixels along a side of the picture.
    pixels: Count,
}

const METHODS: [&str; 3] = ["total F", "elastic F", "positions only"];
const BACKGROUND: [f64; 3] = [1.0; 3];

/// The motion in closed form.
struct Shear {
    foot: f64,
    height: f64,
    top: f64,
}

impl Shear {
    /// γ y / H.
    fn amount(&self, x: &Vec3) -> f64 {
        self.top * (x.y - self.foot) / self.height
    }

    /// F = I + γ e₁e₂ᵀ, whose rotation turns by atan(γ/2) from y to x.
    fn place(&self, x: &Vec3) -> Place {
        let amount = self.amount(x);
        let mut gradient = Mat3::identity();
        gradient[(0, 1)] = amount;
        let rotation = Rotation3::from_axis_angle(&Vec3::z_axis(), -(0.5 * amount).atan()).into_inner();
        Place { position: x + Vec3::x() * (0.5 * amount * (x.y - self.foot)), gradient, rotation }
    }
}

impl Experiment for SplatPlasticShear {
    fn methods(&self) -> &'static [&'static str] {
        &METHODS
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let painted = self.painted.painted(at.folder)?;
        let (foot, height) = (painted.bounds.min.y, painted.bounds.size().y);
        let shear = Shear { foot, height, top: at.ladder };
        let kept = self.gradients(&painted, &shear)?;
        let frame = clock.time(|| deformed(&painted, &shear, &kept, at.method))?;
        let elastic = deformed(&painted, &shear, &kept, "elastic F")?;
        let pixels = self.pixels.value();
        let corners: Vec<Vec3> = painted.mesh.points().iter().map(|x| shear.place(x).position).collect();
        let bounds = BoundingBox::of(&corners).unwrap_or(painted.bounds);
        let camera =
            camera_on(&bounds, [pixels, pixels], Vec3::y(), (0.2, 0.15)).map_err(ExperimentError::stopped)?;
        let settings = Settings { mode: Mode::Tight, background: BACKGROUND, ..Settings::default() };
        let draw = |splats: &Splats<f64>| {
            raster::render(splats, &camera, &settings).map_err(ExperimentError::stopped)
        };
        let picture = draw(&frame)?;
        let closed = painted.seen(&camera, |x| shear.place(x));
        let truth = plain::draw(&closed, &camera, BACKGROUND, Rules::Of(Mode::Tight), &Rounding::DOUBLE);
        let less_truth = |colours: &[[f64; 3]]| plain::difference(colours, &truth.colours, &truth.fragile);
        let found = less_truth(&plain::colours(&picture));
        let stale = less_truth(&plain::colours(&draw(&elastic)?));
        let added = |(kept, x): (&Kept, &Vec3)| (kept.total - shear.place(x).gradient).norm();
        let total = kept.iter().zip(painted.splats.means()).map(added).fold(0.0, f64::max);
        let mut hash = StateHash::new();
        hash.add("picture", plain::colours(&picture).as_flattened());
        let outcome = Outcome::default()
            .error("picture, root mean square", found.root_mean_square)
            .error("covariance", covariance_error(&painted, &shear, &frame))
            .error("picture", found.largest)
            .count("splats", frame.count() as u64)
            .invariant("error of the total F that is added up", total)
            .invariant("what elastic F alone shows wrong, root mean square", stale.root_mean_square)
            .invariant("share of pixels at a threshold", found.fragile)
            .state(hash.value());
        let caption = format!("{}: sheared by {} at the top, plastically", at.method, at.ladder);
        outcome.pictured(at, &caption, || {
            let size = Size { width: pixels, height: pixels };
            let colours = plain::colours(&picture);
            let difference = difference_image(size, (&colours, &truth.colours), 1.0, "their difference");
            let truth = colour_image(size, &truth.colours, "closed form");
            Ok(truth.beside(&[splat_image(&picture, at.method), difference]))
        })
    }
}

/// What a plastic solver has of the deformation of a splat.
struct Kept {
    elastic: Mat3,
    total: Mat3,
}

impl SplatPlasticShear {
    /// The elastic F that the law keeps, and the total one as a solver adds it up beside, ΠΔF.
    fn gradients(&self, painted: &Painted, shear: &Shear) -> Result<Vec<Kept>, ExperimentError> {
        let (young, poisson) =
            (self.constants.young_modulus_pa.value(), self.constants.poisson_ratio.value());
        let lame = Lame::from_young_poisson(young, poisson).map_err(ExperimentError::stopped)?;
        let law = YieldStress::perfect(self.yield_stress_pa.value())
            .and_then(|curve| VonMises::new(lame, curve))
            .map_err(ExperimentError::stopped)?;
        let steps = self.steps.value();
        let sheared = |x: &Vec3| {
            let mut velocity_gradient = Mat3::zeros();
            velocity_gradient[(0, 1)] = shear.amount(x);
            let motion = Motion { velocity_gradient, step: 1.0 / steps as f64 };
            let increment = Mat3::identity() + velocity_gradient * motion.step;
            let (mut elastic, mut history, mut total) =
                (Mat3::identity(), fresh_history::<VonMises, f64>(), Mat3::identity());
            for _ in 0..steps {
                elastic = law.advance(&elastic, &mut history, &motion).0;
                total = increment * total;
            }
            Kept { elastic, total }
        };
        Ok(painted.splats.means().iter().map(sheared).collect())
    }
}

/// The scene where the motion takes it, with the shapes of a method.
fn deformed(
    painted: &Painted,
    shear: &Shear,
    kept: &[Kept],
    method: &str,
) -> Result<Splats<f64>, ExperimentError> {
    let positions: Vec<Vec3> = painted.splats.means().iter().map(|x| shear.place(x).position).collect();
    let gradient = |kept: &Kept| match method {
        "total F" => kept.total,
        "elastic F" => kept.elastic,
        _ => Mat3::identity(),
    };
    let gradients: Vec<Mat3> = kept.iter().map(gradient).collect();
    let all = (0..painted.splats.count() as u32).collect();
    let mut transport = Transport::new(painted.splats.clone(), all, Colours::RotateCoefficients)
        .map_err(ExperimentError::stopped)?;
    transport.deform(DeformationSamples::new(&positions, &gradients)).map_err(ExperimentError::stopped)?;
    Ok(transport.frame().clone())
}

/// The largest error of a covariance by its size, against F A Fᵀ.
fn covariance_error(painted: &Painted, shear: &Shear, frame: &Splats<f64>) -> f64 {
    let error = |i: usize| {
        let axes = shear.place(&painted.splats.means()[i]).gradient * painted.splats.axes()[i];
        let truth = axes * axes.transpose();
        let found = frame.axes()[i] * frame.axes()[i].transpose();
        (found - truth).norm() / truth.norm()
    };
    (0..frame.count()).map(error).fold(0.0, f64::max)
}
