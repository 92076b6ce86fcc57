//! Values computed elsewhere, in 50 digits: see `fixtures/README.md`.

use crate::scenes;
use gaussian_deform::camera::Camera;
use gaussian_deform::raster::{self, Mode, Projection, Settings, View};
use gaussian_deform::transport::{Colours, Transport};
use gaussian_deform::{Degree, Splat, Splats, harmonics};
use mechanics_core::lanes::Element;
use mechanics_core::samples::DeformationSamples;
use mechanics_core::tensor::{Mat3, Vec3};
use serde_json::Value;

fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(entries) => entries.iter().flat_map(numbers).collect(),
        number => vec![number.as_f64().unwrap()],
    }
}

fn read(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

/// From W and t with p' = W p + t.
fn camera(of: &Value, rotation: &str) -> Camera {
    let size = ["width", "height"].map(|key| of[key].as_u64().unwrap() as usize);
    let focal = ["fx", "fy"].map(|key| of[key].as_f64().unwrap());
    let rotation = Mat3::from_row_slice(&numbers(&of[rotation]));
    let eye = -(rotation.transpose() * Vec3::from_column_slice(&numbers(&of["t"])));
    Camera::new(size, focal, rotation, eye).unwrap()
}

fn axes(of: &Value, quaternion: &str) -> Mat3 {
    let scales = Vec3::from_column_slice(&numbers(&of["scale"]));
    scenes::rotation(numbers(&of[quaternion]).try_into().unwrap()) * Mat3::from_diagonal(&scales)
}

fn project(camera: &Camera, mean: Vec3, axes: &Mat3) -> Projection<f64> {
    let view = View::new(camera);
    view.project(view.offset(mean.into()), axes)
}

/// All to `tolerance` of the largest of the expected numbers.
fn near(ours: &[f64], theirs: &[f64], tolerance: f64, what: &str) {
    let scale = theirs.iter().fold(1.0, |most: f64, x| most.max(x.abs()));
    for (a, b) in ours.iter().zip(theirs) {
        assert!((a - b).abs() <= tolerance * scale, "{what}: {ours:?} for {theirs:?}");
    }
    assert_eq!(ours.len(), theirs.len());
}

#[test]
fn projections_have_the_values_of_the_fixture() {
    let file = read(include_str!("../fixtures/ewa.json"));
    for case in file["cases"].as_array().unwrap() {
        let camera = camera(case, "W_world_to_cam");
        let mean = Vec3::from_column_slice(&numbers(&case["mean"]));
        let ours = project(&camera, mean, &axes(case, "quat_wxyz_unnormalised"));
        near(&ours.position, &numbers(&case["p_view"]), 1e-14, "position");
        near(&ours.place, &numbers(&case["pixel_center"]), 1e-13, "place");
        near(&ours.covariance, &numbers(&case["cov2d_abc"]), 1e-12, "covariance");
        let [a, b, c] = ours.covariance;
        near(&[c, -b, a].map(|x| x / ours.determinant), &numbers(&case["conic"]), 1e-12, "conic");
        near(&[ours.reach().ceil()], &numbers(&case["radius_px"]), 0.0, "radius");
        near(&[ours.sharpness()], &numbers(&case["det_ratio_antialias_sqrt"]), 1e-12, "sharpness");
    }
}

/// The Gaussians of a scene of the fixture, all of degree 3; deformed where it says so, with rotated coefficients or without.
fn scene(of: &Value, deformed: Deformed) -> Splats<f64> {
    let mut splats = Splats::new(Degree::Three);
    for (i, gaussian) in of["gaussians"].as_array().unwrap().iter().enumerate() {
        let mut mean = Vec3::from_column_slice(&numbers(&gaussian["mean"]));
        let mut axes = axes(gaussian, "quat_wxyz");
        let mut coefficients = numbers(&gaussian["coef"]);
        if let (Some(motion), true) = (of["deformation"].get(i), deformed != Deformed::Not) {
            mean = Vec3::from_column_slice(&numbers(&motion["x_p"]));
            axes = Mat3::from_row_slice(&numbers(&motion["F"])) * axes;
            if deformed == Deformed::Wholly {
                coefficients = numbers(&motion["coef_rotated"]);
            }
        }
        // The fixture has red, green, blue of every coefficient.
        let used = (gaussian["sh_degree"].as_u64().unwrap() as usize + 1).pow(2);
        let by_channel = |k: usize| if k % 16 < used { coefficients[k % 16 * 3 + k / 16] } else { 0.0 };
        let harmonics: Vec<f64> = (0..48).map(by_channel).collect();
        let opacity = gaussian["opacity"].as_f64().unwrap();
        splats.push(Splat { mean, axes, opacity, harmonics: &harmonics });
    }
    splats
}

#[derive(Clone, Copy, PartialEq)]
enum Deformed {
    Not,
    /// Without rotating the harmonics.
    InPlaceOnly,
    Wholly,
}

/// The largest difference of a channel or the transmittance, pixels apart that the fixture calls fragile.
fn difference<E: Element>(of: &Value, splats: &Splats<f64>, mode: Mode) -> f64 {
    let camera = camera(&of["camera"], "W");
    let background = numbers(&of["background"]).try_into().unwrap();
    let settings = Settings { mode, background, ..Settings::default() };
    let picture = raster::render(&splats.cast::<E>(), &camera, &settings).unwrap();
    let fragile: Vec<usize> = numbers(&of["rule_counters"]["fragile_pixels_xy"])
        .chunks(2)
        .map(|xy| xy[1] as usize * camera.width() + xy[0] as usize)
        .collect();
    let colours = numbers(&of["image_rgb_row_major"]);
    let light = numbers(&of["final_T"]);
    assert_eq!(light.len(), picture.transmittance().len());
    let mut most = 0.0_f64;
    for pixel in (0..light.len()).filter(|pixel| !fragile.contains(pixel)) {
        for k in 0..3 {
            most = most.max((picture.colours()[pixel][k].into() - colours[3 * pixel + k]).abs());
        }
        most = most.max((picture.transmittance()[pixel].into() - light[pixel]).abs());
    }
    most
}

#[test]
fn pictures_in_exact_mode_have_the_values_of_the_fixture() {
    let file = read(include_str!("../fixtures/raster.json"));
    let scenes = file["scenes"].as_array().unwrap();
    assert_eq!(scenes.len(), 4);
    for of in scenes {
        let splats = scene(of, Deformed::Wholly);
        let name = of["name"].as_str().unwrap();
        let double = difference::<f64>(of, &splats, Mode::Exact);
        assert!(double < 1e-12, "{name}: {double:e}");
        let single = difference::<f32>(of, &splats, Mode::Exact);
        assert!(single < 1e-5, "{name} in single precision: {single:e}");
    }
}

#[test]
fn gaussians_of_the_pictures_have_the_values_of_the_fixture_one_by_one() {
    let file = read(include_str!("../fixtures/raster.json"));
    for of in file["scenes"].as_array().unwrap() {
        let (camera, splats) = (camera(&of["camera"], "W"), scene(of, Deformed::Wholly));
        for (i, expected) in of["per_gaussian"].as_array().unwrap().iter().enumerate() {
            let mean = splats.means()[i];
            let ours = project(&camera, mean, &splats.axes()[i]);
            near(&ours.position, &numbers(&expected["p_view"]), 1e-14, "position");
            if expected["culled"] == "near" {
                assert!(ours.position[2] <= raster::NEAR);
                continue;
            }
            near(&ours.place, &numbers(&expected["center"]), 1e-13, "place");
            near(&ours.covariance, &numbers(&expected["cov2d"]), 1e-12, "covariance");
            let [a, b, c] = ours.covariance;
            near(&[c, -b, a].map(|x| x / ours.determinant), &numbers(&expected["conic"]), 1e-12, "conic");
            near(&[ours.reach().ceil()], &numbers(&expected["radius"]), 0.0, "radius");
            let towards = (mean - camera.eye()).normalize();
            let colour = harmonics::colour(Degree::Three, splats.harmonics_of(i), towards.into());
            near(&colour, &numbers(&expected["rgb_unclamped"]), 1e-13, "colour");
        }
    }
}

#[test]
fn a_deformed_scene_whose_harmonics_do_not_rotate_is_wrong() {
    let file = read(include_str!("../fixtures/raster.json"));
    let of = &file["scenes"][3];
    let expected = numbers(&of["max_abs_difference_if_sh_not_rotated"])[0];
    let skipped = difference::<f64>(of, &scene(of, Deformed::InPlaceOnly), Mode::Exact);
    assert!((skipped - expected).abs() < 1e-12, "{skipped} for {expected}");
}

#[test]
fn looking_up_in_the_turned_direction_equals_rotating_coefficients() {
    let file = read(include_str!("../fixtures/raster.json"));
    let of = &file["scenes"][3];
    let mut splats = scene(of, Deformed::InPlaceOnly);
    let motions = of["deformation"].as_array().unwrap();
    let rotations = motions.iter().map(|motion| Mat3::from_row_slice(&numbers(&motion["R_polar"])));
    splats.set_orientations(Some(rotations.collect()));
    let turned = difference::<f64>(of, &splats, Mode::Exact);
    assert!(turned < 1e-12, "{turned:e}");
}

#[test]
fn a_scene_that_is_transported_has_the_picture_of_the_fixture() {
    let file = read(include_str!("../fixtures/raster.json"));
    let of = &file["scenes"][3];
    let motions = of["deformation"].as_array().unwrap();
    let gradients: Vec<Mat3> = motions.iter().map(|m| Mat3::from_row_slice(&numbers(&m["F"]))).collect();
    let positions: Vec<Vec3> = motions.iter().map(|m| Vec3::from_column_slice(&numbers(&m["x_p"]))).collect();
    for colours in [Colours::RotateCoefficients, Colours::TurnDirections] {
        let rest = scene(of, Deformed::Not);
        let mut transport = Transport::new(rest, (0..motions.len() as u32).collect(), colours).unwrap();
        transport.deform(DeformationSamples::new(&positions, &gradients)).unwrap();
        let error = difference::<f64>(of, transport.frame(), Mode::Exact);
        assert!(error < 1e-12, "{colours:?}: {error:e}");
    }
}
