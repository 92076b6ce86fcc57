//! Inputs that are degenerate, extreme or wrong.

use crate::scenes;
use gaussian_deform::camera::Camera;
use gaussian_deform::error::{Property, SplatError};
use gaussian_deform::raster::{self, DepthChannel, Mode, Picture, RasterError, Settings};
use gaussian_deform::{Degree, Splat, Splats};
use mechanics_core::lanes::Element;
use mechanics_core::tensor::{Mat3, Vec3};

/// From the origin along z.
fn camera(width: usize, height: usize) -> Camera {
    Camera::new([width, height], [50.0, 50.0], Mat3::identity(), Vec3::zeros()).unwrap()
}

fn one<E: Element>(mean: Vec3, axes: Mat3, opacity: f64) -> Splats<E> {
    let mut splats = Splats::new(Degree::Zero);
    splats.push(Splat { mean, axes, opacity, harmonics: &[1.0, 1.0, 1.0] });
    splats.cast()
}

fn both_modes() -> [Settings; 2] {
    [Mode::Exact, Mode::Tight].map(|mode| Settings { mode, background: [0.25; 3], ..Settings::default() })
}

fn is_background<E: Element>(picture: &Picture<E>) -> bool {
    let background = [E::constant(0.25); 3];
    picture.colours().iter().all(|c| *c == background)
        && picture.transmittance().iter().all(|&t| t == E::constant(1.0))
}

fn finite<E: Element>(picture: &Picture<E>) -> bool {
    let good = |x: &E| Into::<f64>::into(*x).is_finite();
    picture.colours().iter().flatten().all(good) && picture.transmittance().iter().all(good)
}

#[test]
fn nothing_is_seen_of_what_is_behind_at_the_eye_transparent_or_absent() {
    fn check<E: Element>() {
        let unit = Mat3::identity() * 0.1;
        let scenes = [
            Splats::<E>::new(Degree::Three),
            one(Vec3::new(0.0, 0.0, -2.0), unit, 0.9),
            one(Vec3::zeros(), unit, 0.9),
            one(Vec3::new(0.0, 0.0, 0.2 - 1e-7), unit, 0.9),
            one(Vec3::new(0.0, 0.0, 2.0), unit, 0.0),
            one(Vec3::new(0.0, 0.0, 2.0), unit, 0.0039),
            one(Vec3::new(50.0, 0.0, 2.0), unit, 0.9),
            one(Vec3::new(0.0, -50.0, 2.0), unit, 0.9),
        ];
        for scene in &scenes {
            for settings in both_modes() {
                for size in [[1, 1], [17, 16], [40, 33]] {
                    let picture = raster::render(scene, &camera(size[0], size[1]), &settings).unwrap();
                    assert!(is_background(&picture));
                    assert_eq!((picture.width(), picture.height()), (size[0], size[1]));
                    assert_eq!(picture.report().visible, 0);
                }
            }
        }
    }
    check::<f32>();
    check::<f64>();
}

#[test]
fn a_point_is_as_large_as_the_low_pass() {
    fn check<E: Element>(tolerance: f64) {
        for settings in both_modes() {
            let scene = one::<E>(Vec3::new(0.0, 0.0, 2.0), Mat3::zeros(), 0.8);
            let picture = raster::render(&scene, &camera(17, 17), &settings).unwrap();
            for (pixel, &light) in picture.transmittance().iter().enumerate() {
                let (x, y) = ((pixel % 17) as f64 - 8.0, (pixel / 17) as f64 - 8.0);
                let alpha = 0.8 * (-0.5 * (x * x + y * y) / 0.3).exp();
                let expected = if alpha < 1.0 / 255.0 { 1.0 } else { 1.0 - alpha };
                assert!((light.into() - expected).abs() < tolerance, "{x} {y}: {light:?} for {expected}");
            }
        }
    }
    check::<f32>(1e-6);
    check::<f64>(1e-14);
}

#[test]
fn an_opaque_gaussian_lets_one_per_cent_through() {
    let scene = one::<f64>(Vec3::new(0.0, 0.0, 2.0), Mat3::identity(), 1.0);
    for settings in both_modes() {
        let picture = raster::render(&scene, &camera(1, 1), &settings).unwrap();
        assert!((picture.transmittance()[0] - 0.01).abs() < 1e-15);
        let colour = 0.99 * (0.5 + 0.28209479177387814) + 0.01 * 0.25;
        assert!((picture.colours()[0][1] - colour).abs() < 1e-15);
    }
}

#[test]
fn huge_gaussians_cover_the_picture() {
    fn check<E: Element>(scales: &[f64]) {
        for &scale in scales {
            for settings in both_modes() {
                let scene = one::<E>(Vec3::new(0.1, 0.2, 2.0), Mat3::identity() * scale, 0.5);
                let picture = raster::render(&scene, &camera(50, 35), &settings).unwrap();
                for &light in picture.transmittance() {
                    assert!((light.into() - 0.5).abs() < 1e-3, "{scale:e}: {light:?}");
                }
            }
        }
    }
    check::<f32>(&[1e3, 1e8, 1e12]);
    check::<f64>(&[1e3, 1e8, 1e100]);
}

/// A needle from the lower left to the upper right, ten thousand pixels long and thinner than one: its profile across is that of the low-pass, also in
/// single precision, where the determinant of its covariance would be lost in a difference.
#[test]
fn a_needle_is_as_thin_as_it_should_be() {
    fn check<E: Element>(tolerance: f64) {
        let direction = Vec3::new(1.0, 0.5, 0.0).normalize();
        let axes = Mat3::from_columns(&[direction * 400.0, Vec3::zeros(), Vec3::zeros()]);
        let scene = one::<E>(Vec3::new(0.0, 0.0, 2.0), axes, 0.9);
        let picture = raster::render(&scene, &camera(61, 41), &both_modes()[1]).unwrap();
        for (pixel, &light) in picture.transmittance().iter().enumerate() {
            let (x, y) = ((pixel % 61) as f64 - 30.0, (pixel / 61) as f64 - 20.0);
            let across = direction.x * y - direction.y * x;
            let alpha = 0.9 * (-0.5 * across * across / 0.3).exp();
            let expected = if alpha < 1.0 / 255.0 { 1.0 } else { 1.0 - alpha };
            assert!((light.into() - expected).abs() < tolerance, "{x} {y}: {light:?} for {expected}");
        }
    }
    // Along 30 pixels the opacity falls by less than 1e-5.
    check::<f64>(1e-4);
    check::<f32>(1e-3);
}

#[test]
fn gaussians_just_in_front_of_the_near_plane_and_far_away_are_finite() {
    let mut scene = scenes::mixed(Degree::Two, 200, 9);
    for (i, mean) in scene.means_mut().iter_mut().enumerate() {
        mean.z = if i % 2 == 0 { 0.2 + 1e-6 * i as f64 } else { 10_f64.powi(i as i32 % 12) };
    }
    for settings in both_modes() {
        assert!(finite(&raster::render(&scene, &camera(70, 50), &settings).unwrap()));
        assert!(finite(&raster::render(&scene.cast::<f32>(), &camera(70, 50), &settings).unwrap()));
    }
}

/// Spoils one number of Gaussian 11 of 20 and says what the rasteriser thinks of it.
fn spoiled<E: Element>(spoil: impl Fn(&mut Splats<E>)) -> RasterError {
    let mut scene = Splats::<E>::new(Degree::One);
    let axes = Mat3::identity() * 0.1;
    for k in 0..20 {
        let mean = Vec3::new(0.01 * f64::from(k), 0.0, 2.0);
        let harmonics = [0.1; 12].map(E::constant);
        let splat = one::<E>(mean, axes, 0.5);
        scene.push(Splat { harmonics: &harmonics, ..splat.splat(0) });
    }
    spoil(&mut scene);
    let settings = both_modes()[0];
    let before = raster::render(&one::<E>(Vec3::z(), axes, 0.7), &camera(20, 20), &settings).unwrap();
    let mut picture = before.clone();
    let error = raster::render_into(&scene, &camera(30, 10), &settings, &mut picture).unwrap_err();
    assert!(picture == before, "an error leaves the picture as it was");
    error
}

#[test]
fn bad_numbers_are_refused_by_gaussian_and_property() {
    fn check<E: Element>() {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let bad = E::constant(value);
            let mean = spoiled::<E>(|scene| scene.means_mut()[11].y = bad);
            let axes = spoiled::<E>(|scene| scene.axes_mut()[11][(2, 1)] = bad);
            let opacity = spoiled::<E>(|scene| scene.opacities_mut()[11] = bad);
            let expected = [Property::Mean, Property::Axes, Property::Opacity];
            for (error, expected) in [mean, axes, opacity].into_iter().zip(expected) {
                match error {
                    RasterError::Splat(SplatError::BadValue { splat: 11, property, value: found }) => {
                        assert_eq!(property, expected);
                        assert!(found == value || found.is_nan() && value.is_nan());
                    }
                    other => panic!("{other}"),
                }
            }
            let colour = spoiled::<E>(|scene| scene.harmonics_mut()[11 * 12 + 7] = bad);
            assert_eq!(colour, RasterError::BadColour { splat: 11 });
            let orientation = spoiled::<E>(|scene| scene.orientations_mut()[11][(0, 0)] = bad);
            assert_eq!(orientation, RasterError::BadColour { splat: 11 });
        }
        for opacity in [-0.1, 1.1] {
            let error = spoiled::<E>(|scene| scene.opacities_mut()[11] = E::constant(opacity));
            assert!(matches!(error, RasterError::Splat(SplatError::BadValue { splat: 11, .. })), "{error}");
        }
    }
    check::<f32>();
    check::<f64>();
}

#[test]
fn bad_numbers_are_refused_where_nobody_sees_them() {
    let mut scene = one::<f32>(Vec3::new(0.0, 0.0, -5.0), Mat3::identity(), 0.5);
    scene.axes_mut()[0][(0, 0)] = f32::NAN;
    assert!(raster::render(&scene, &camera(8, 8), &Settings::default()).is_err());
}

#[test]
fn overflowing_projections_are_refused() {
    let error = spoiled::<f32>(|scene| scene.axes_mut()[11][(0, 0)] = 1e30);
    assert_eq!(error, RasterError::Overflow { splat: 11 });
    let error = spoiled::<f32>(|scene| scene.means_mut()[11].x = f32::MAX);
    assert_eq!(error, RasterError::Overflow { splat: 11 });
    let error = spoiled::<f64>(|scene| scene.axes_mut()[11][(0, 0)] = 1e200);
    assert_eq!(error, RasterError::Overflow { splat: 11 });
}

#[test]
fn a_background_that_is_no_colour_is_refused() {
    let settings = Settings { background: [0.0, f64::NAN, 0.0], ..Settings::default() };
    let error = raster::render(&Splats::<f32>::new(Degree::Zero), &camera(8, 8), &settings).unwrap_err();
    assert!(matches!(error, RasterError::BadBackground { channel: 1, .. }), "{error}");
}

#[test]
fn bytes_are_cut_and_rounded() {
    let scene = Splats::<f32>::new(Degree::Zero);
    let settings =
        Settings { background: [-0.5, 0.5, 3.0], depth: DepthChannel::Present, ..Settings::default() };
    let picture = raster::render(&scene, &camera(2, 1), &settings).unwrap();
    assert_eq!(picture.to_rgb8(), [0, 128, 255, 0, 128, 255]);
    assert_eq!(picture.depth().unwrap(), [0.0, 0.0]);
    // One level of 0.1 in one of three channels: −10 log₁₀(0.01/3).
    let brighter = Settings { background: [-0.5, 0.6, 3.0], ..settings };
    let other = raster::render(&scene.cast::<f64>(), &camera(2, 1), &brighter).unwrap();
    assert!((picture.signal_to_noise(&other) - 24.7712).abs() < 1e-3);
    assert_eq!(picture.signal_to_noise(&picture), f64::INFINITY);
}
