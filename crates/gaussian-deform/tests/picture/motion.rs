//! Moving the scene is moving the camera the other way; threads change nothing.

use crate::oracle;
use crate::scenes::{self, Numbers};
use gaussian_deform::camera::Camera;
use gaussian_deform::raster::{self, DepthChannel, Mode, Picture, Settings};
use gaussian_deform::transport::{Colours, Transport};
use gaussian_deform::{Degree, Splat, Splats};
use mechanics_core::lanes::Element;
use mechanics_core::parallel;
use mechanics_core::samples::DeformationSamples;
use mechanics_core::tensor::{Mat3, Vec3};

/// The scene after p ↦ R p + t, carried along by this crate's transport.
fn moved(scene: &Splats<f64>, rotation: &Mat3, translation: &Vec3, colours: Colours) -> Splats<f64> {
    let matter = (0..scene.count() as u32).collect();
    let mut transport = Transport::new(scene.clone(), matter, colours).unwrap();
    let positions: Vec<Vec3> = scene.means().iter().map(|mean| rotation * mean + translation).collect();
    let gradients = vec![*rotation; scene.count()];
    transport.deform(DeformationSamples::new(&positions, &gradients)).unwrap();
    transport.frame().clone()
}

/// The largest difference between the picture of the scene and that of the moved scene from the moved camera, pixels at a threshold apart, and
/// how many those are.
fn difference<E: Element>(
    scene: &Splats<f64>,
    moved_scene: &Splats<f64>,
    motion: (&Mat3, &Vec3),
    mode: Mode,
    threshold: f64,
) -> (f64, usize) {
    let camera = scenes::camera(120, 90);
    let settings = Settings { mode, background: [0.3, 0.1, 0.2], ..Settings::default() };
    let margin = oracle::truth(scene, &camera, &settings).margin;
    let here = raster::render(&scene.cast::<E>(), &camera, &settings).unwrap();
    let there = camera.moved(motion.0, motion.1).unwrap();
    let there = raster::render(&moved_scene.cast::<E>(), &there, &settings).unwrap();
    let (mut most, mut fragile) = (0.0_f64, 0);
    for (pixel, (a, b)) in here.colours().iter().zip(there.colours()).enumerate() {
        if margin[pixel] < threshold {
            fragile += 1;
            continue;
        }
        for k in 0..3 {
            most = most.max((a[k].into() - b[k].into()).abs());
        }
    }
    (most, fragile)
}

#[test]
fn a_rigid_motion_of_the_scene_is_the_opposite_motion_of_the_camera() {
    let mut numbers = Numbers(41);
    for (mode, colours) in [
        (Mode::Exact, Colours::RotateCoefficients),
        (Mode::Tight, Colours::RotateCoefficients),
        (Mode::Exact, Colours::TurnDirections),
        (Mode::Tight, Colours::TurnDirections),
    ] {
        let scene = scenes::mixed(Degree::Three, 150, numbers.0);
        let (rotation, translation) = (numbers.rotation(), numbers.vector() * 3.0);
        let motion = (&rotation, &translation);
        let turned = moved(&scene, &rotation, &translation, colours);
        let (double, fragile) = difference::<f64>(&scene, &turned, motion, mode, 1e-9);
        assert!(double < 1e-10 && fragile <= 1, "{double:e} but for {fragile} pixels");
        let (single, fragile) = difference::<f32>(&scene, &turned, motion, mode, 3e-4);
        assert!(single < 1e-4 && fragile < 120 * 90 / 20, "{single:e} but for {fragile} pixels");
    }
}

#[test]
fn a_moved_scene_whose_harmonics_stay_behind_is_wrong() {
    let mut numbers = Numbers(5);
    let scene = scenes::mixed(Degree::Three, 150, 8);
    let (rotation, translation) = (numbers.rotation(), numbers.vector());
    let mut stale = moved(&scene, &rotation, &translation, Colours::RotateCoefficients);
    stale.harmonics_mut().copy_from_slice(scene.harmonics());
    let (error, _) = difference::<f64>(&scene, &stale, (&rotation, &translation), Mode::Exact, 1e-9);
    assert!(error > 0.05, "{error:e}");
}

/// A ball straight ahead that is stretched across the line of sight is an ellipse whose profile has a closed form.
#[test]
fn a_stretched_ball_is_the_ellipse_of_the_closed_form() {
    let mut scene = Splats::<f64>::new(Degree::Zero);
    let (mean, axes) = (Vec3::new(0.0, 0.0, 2.0), Mat3::identity() * 0.1);
    scene.push(Splat { mean, axes, opacity: 0.7, harmonics: &[0.0; 3] });
    let mut transport = Transport::new(scene, vec![0], Colours::RotateCoefficients).unwrap();
    let stretch = Mat3::from_diagonal(&Vec3::new(3.0, 0.5, 1.7));
    transport.deform(DeformationSamples::new(&[mean], &[stretch])).unwrap();
    let camera = Camera::new([81, 61], [60.0, 50.0], Mat3::identity(), Vec3::zeros()).unwrap();
    let settings = Settings { mode: Mode::Tight, ..Settings::default() };
    let picture = raster::render(transport.frame(), &camera, &settings).unwrap();
    let variance = [(60.0 / 2.0 * 0.3_f64).powi(2) + 0.3, (50.0 / 2.0 * 0.05_f64).powi(2) + 0.3];
    for (pixel, &light) in picture.transmittance().iter().enumerate() {
        let (x, y) = ((pixel % 81) as f64 - 40.0, (pixel / 81) as f64 - 30.0);
        let alpha = 0.7 * (-0.5 * (x * x / variance[0] + y * y / variance[1])).exp();
        let expected = if alpha < 1.0 / 255.0 { 1.0 } else { 1.0 - alpha };
        assert!((light - expected).abs() < 1e-13, "{x} {y}: {light} for {expected}");
    }
}

#[test]
fn pictures_have_the_same_bits_for_any_number_of_threads() {
    fn check<E: Element>() {
        // More than one chunk of 4,096 Gaussians.
        let scene = scenes::mixed(Degree::One, 9_001, 77).cast::<E>();
        let camera = scenes::camera(210, 130);
        for mode in [Mode::Exact, Mode::Tight] {
            let settings = Settings { mode, depth: DepthChannel::Present, ..Settings::default() };
            let render = |threads| {
                parallel::with_threads(threads, || raster::render(&scene, &camera, &settings).unwrap())
            };
            let one: Picture<E> = render(1);
            for threads in [2, 3, 8] {
                assert!(render(threads) == one, "{threads} threads, {mode:?}");
            }
        }
    }
    check::<f32>();
    check::<f64>();
}

#[test]
fn a_picture_into_used_memory_equals_a_new_one() {
    let scene = scenes::mixed(Degree::Zero, 300, 3);
    let settings = Settings { depth: DepthChannel::Present, ..Settings::default() };
    let mut used = raster::render(&scene, &scenes::camera(90, 70), &settings).unwrap();
    for (size, settings) in [([33, 95], settings), ([20, 10], Settings::default())] {
        let camera = scenes::camera(size[0], size[1]);
        raster::render_into(&scene, &camera, &settings, &mut used).unwrap();
        assert!(used == raster::render(&scene, &camera, &settings).unwrap());
    }
}
