//! Cameras from parameters and from files.

use crate::scenes::{self, Numbers};
use gaussian_deform::camera::{Camera, CameraError, CameraProperty, MOST_PIXELS, Orbit, cameras_from_json};
use gaussian_deform::{Degree, Splat, Splats};
use mechanics_core::tensor::{Mat3, Vec3};
use std::f64::consts::{FRAC_PI_2, PI};

const ORBIT: Orbit = Orbit {
    target: Vec3::new(1.0, 2.0, 3.0),
    distance: 4.0,
    azimuth: 0.0,
    elevation: 0.0,
    up: Vec3::new(0.0, 2.0, 0.0),
    field_of_view: FRAC_PI_2,
};

#[test]
fn an_orbit_stands_where_it_says() {
    let at = |azimuth, elevation| Camera::on_orbit([40, 30], &Orbit { azimuth, elevation, ..ORBIT }).unwrap();
    let near = |eye: &Vec3, expected: [f64; 3]| assert!((eye - Vec3::from(expected)).norm() < 1e-14);
    near(at(0.0, 0.0).eye(), [1.0, 2.0, 7.0]);
    near(at(FRAC_PI_2, 0.0).eye(), [5.0, 2.0, 3.0]);
    near(at(PI, PI / 6.0).eye(), [1.0, 4.0, 3.0 - 12_f64.sqrt()]);
    let upwards = Orbit { up: Vec3::z(), ..ORBIT };
    near(Camera::on_orbit([40, 30], &upwards).unwrap().eye(), [5.0, 2.0, 3.0]);
    for (azimuth, elevation) in [(0.3, 0.2), (-2.0, -1.5), (9.0, 1.5)] {
        let camera = at(azimuth, elevation);
        assert!((camera.view(&ORBIT.target) - Vec3::new(0.0, 0.0, 4.0)).norm() < 1e-14);
        let [x, y] = camera.project(&ORBIT.target).unwrap();
        assert!((x - 19.5).abs() < 1e-12 && (y - 14.5).abs() < 1e-12);
        // What is up in the world is up in the picture, and not sideways; y counts rows from the top.
        let above = camera.view(&(ORBIT.target + Vec3::y()));
        assert!(above.y < 0.0 && above.x.abs() < 1e-14);
        assert!((camera.rotation().determinant() - 1.0).abs() < 1e-14);
    }
    // A right angle from edge to edge: 15 rows are as long as the focal length.
    assert!((at(0.0, 0.0).focal()[0] - 15.0).abs() < 1e-14);
}

#[test]
fn points_behind_the_eye_are_not_seen() {
    let camera = Camera::on_orbit([40, 30], &ORBIT).unwrap();
    assert_eq!(camera.project(&Vec3::new(1.0, 2.0, 8.0)), None);
    assert_eq!(camera.project(camera.eye()), None);
}

#[test]
fn a_moved_camera_sees_the_moved_world_as_before() {
    let mut numbers = Numbers(3);
    let camera = scenes::camera(50, 40);
    let (rotation, translation) = (numbers.rotation(), numbers.vector());
    let moved = camera.moved(&rotation, &translation).unwrap();
    for _ in 0..10 {
        let point = numbers.vector();
        let difference = moved.view(&(rotation * point + translation)) - camera.view(&point);
        assert!(difference.norm() < 1e-14);
    }
}

#[test]
fn another_size_shows_the_same() {
    let camera = scenes::camera(50, 40);
    let large = camera.resized([100, 120]).unwrap();
    let point = Vec3::new(0.3, 0.4, -0.2);
    let (small, large) = (camera.project(&point).unwrap(), large.project(&point).unwrap());
    assert!(((small[0] + 0.5) * 2.0 - (large[0] + 0.5)).abs() < 1e-12);
    assert!(((small[1] + 0.5) * 3.0 - (large[1] + 0.5)).abs() < 1e-12);
}

#[test]
fn the_axis_meets_the_picture_in_the_principal_point() {
    let camera = scenes::camera(50, 40);
    assert_eq!(camera.principal_point(), [25.0, 20.0]);
    let ahead = camera.eye() + camera.rotation().transpose() * Vec3::z();
    let near = |camera: &Camera, point: &Vec3, expected: [f64; 2]| {
        let found = camera.project(point).unwrap();
        assert!((0..2).all(|k| (found[k] - expected[k]).abs() < 1e-12), "{found:?}");
    };
    near(&camera, &ahead, [24.5, 19.5]);
    let moved = camera.clone().with_principal_point([-3.0, 12.25]).unwrap();
    near(&moved, &ahead, [-3.5, 11.75]);
    // Everything is seen as far aside.
    let (point, here) = (Vec3::new(0.3, 0.4, -0.2), camera.project(&Vec3::new(0.3, 0.4, -0.2)).unwrap());
    near(&moved, &point, [here[0] - 28.0, here[1] - 7.75]);
    // Another size and another place keep it.
    assert_eq!(moved.resized([100, 120]).unwrap().principal_point(), [-6.0, 36.75]);
    let rotation = scenes::rotation([0.3, 0.2, 0.5, 0.7]);
    assert_eq!(moved.moved(&rotation, &Vec3::x()).unwrap().principal_point(), [-3.0, 12.25]);
    for bad in [f64::NAN, f64::INFINITY] {
        let error = camera.clone().with_principal_point([1.0, bad]).unwrap_err();
        let CameraError::BadValue { property: CameraProperty::PrincipalPoint, .. } = error else {
            panic!("{error}");
        };
    }
}

#[test]
fn cameras_are_refused_with_a_reason() {
    let orbit = |orbit: Orbit| Camera::on_orbit([40, 30], &orbit).unwrap_err();
    let names = |error: CameraError, expected: CameraProperty| match error {
        CameraError::BadValue { property, .. } | CameraError::NoDirection { property } => {
            assert_eq!(property, expected);
        }
        other => panic!("{other}"),
    };
    names(orbit(Orbit { distance: 0.0, ..ORBIT }), CameraProperty::Distance);
    names(orbit(Orbit { distance: f64::NAN, ..ORBIT }), CameraProperty::Distance);
    names(orbit(Orbit { azimuth: f64::INFINITY, ..ORBIT }), CameraProperty::Angle);
    names(orbit(Orbit { elevation: FRAC_PI_2, ..ORBIT }), CameraProperty::Angle);
    names(orbit(Orbit { up: Vec3::zeros(), ..ORBIT }), CameraProperty::Up);
    names(orbit(Orbit { up: Vec3::new(f64::NAN, 1.0, 0.0), ..ORBIT }), CameraProperty::Up);
    names(orbit(Orbit { target: Vec3::new(f64::NAN, 1.0, 0.0), ..ORBIT }), CameraProperty::Position);
    names(orbit(Orbit { field_of_view: PI, ..ORBIT }), CameraProperty::FieldOfView);
    names(orbit(Orbit { field_of_view: f64::NAN, ..ORBIT }), CameraProperty::FieldOfView);
    let look = |eye, up| Camera::look_at([4, 4], 1.0, eye, Vec3::zeros(), up).unwrap_err();
    names(look(Vec3::zeros(), Vec3::y()), CameraProperty::Target);
    names(look(Vec3::y(), Vec3::y()), CameraProperty::Up);
    let new = |size, focal, rotation| Camera::new(size, focal, rotation, Vec3::zeros()).unwrap_err();
    names(new([0, 4], [1.0; 2], Mat3::identity()), CameraProperty::Width);
    names(new([4, MOST_PIXELS + 1], [1.0; 2], Mat3::identity()), CameraProperty::Height);
    names(new([4, 4], [1.0, -1.0], Mat3::identity()), CameraProperty::FocalLength);
    names(new([4, 4], [1.0; 2], Mat3::identity() * f64::NAN), CameraProperty::Rotation);
    for skewed in [Mat3::identity() * 1.01, -Mat3::identity(), Mat3::zeros()] {
        assert!(matches!(new([4, 4], [1.0; 2], skewed), CameraError::NotARotation { .. }));
    }
}

const FILE: &str = r#"[
  {"id": 0, "img_name": "first", "width": 64, "height": 48, "position": [1.0, 2.0, 3.0],
   "rotation": [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], "fy": 70, "fx": 80.5},
  {"width": 8, "height": 9, "position": [0, 0, 0], "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "fx": 5, "fy": 6}
]"#;

#[test]
fn a_camera_of_a_file_looks_along_the_third_column() {
    let cameras = cameras_from_json(FILE).unwrap();
    assert_eq!(cameras.len(), 2);
    let camera = &cameras[0].camera;
    assert_eq!((cameras[0].name.as_str(), cameras[1].name.as_str()), ("first", ""));
    assert_eq!((camera.width(), camera.height(), camera.focal()), (64, 48, [80.5, 70.0]));
    assert_eq!(camera.eye(), &Vec3::new(1.0, 2.0, 3.0));
    // Columns of the file's matrix: right, down and forward in the world.
    assert_eq!(camera.view(&Vec3::new(1.0, 3.0, 3.0)), Vec3::new(1.0, 0.0, 0.0));
    assert_eq!(camera.view(&Vec3::new(1.0, 2.0, 4.0)), Vec3::new(0.0, 1.0, 0.0));
    assert_eq!(camera.view(&Vec3::new(2.0, 2.0, 3.0)), Vec3::new(0.0, 0.0, 1.0));
    assert_eq!(camera.principal_point(), [32.0, 24.0]);
    let off_centre = cameras_from_json(&FILE.replace("\"fx\": 5", "\"fx\": 5, \"cy\": -1.5")).unwrap();
    assert_eq!(off_centre[1].camera.principal_point(), [4.0, -1.5]);
    assert_eq!(cameras_from_json("[]").unwrap(), []);
}

#[test]
fn files_are_refused_by_camera_and_property() {
    assert!(matches!(
        cameras_from_json("[\n{]").unwrap_err(),
        CameraError::Syntax { line: 2, column: 2, .. }
    ));
    assert_eq!(cameras_from_json("{}").unwrap_err(), CameraError::NotAList);
    for (from, to, key) in [
        ("\"fx\": 5", "\"fx\": \"5\"", "fx"),
        ("\"fy\": 6", "\"gy\": 6", "fy"),
        ("\"fy\": 6", "\"fy\": 6, \"cx\": \"7\"", "cx"),
        ("\"width\": 8", "\"width\": -8", "width"),
        ("\"height\": 9", "\"height\": 9.5", "height"),
        ("\"position\": [0, 0, 0]", "\"position\": [0, 0]", "position"),
        ("[0, 0, 1]]", "[0, 0, 1], []]", "rotation"),
        ("[0, 0, 1]]", "[0, 0, null]]", "rotation"),
    ] {
        let error = cameras_from_json(&FILE.replace(from, to)).unwrap_err();
        assert!(
            matches!(error, CameraError::BadEntry { index: 1, key: found, .. } if found == key),
            "{error}"
        );
    }
    let error = cameras_from_json(&FILE.replace("\"height\": 9", "\"height\": 123456789")).unwrap_err();
    assert!(matches!(&error, CameraError::InFile { index: 1, .. }), "{error}");
    assert!(cameras_from_json("[3]").is_err());
    let deep = "[".repeat(100_000);
    assert!(matches!(cameras_from_json(&deep).unwrap_err(), CameraError::Syntax { .. }));
}

/// No bytes make the reader panic, and what it accepts can be drawn with.
#[test]
fn spoiled_files_are_read_or_refused() {
    let mut numbers = Numbers(19);
    let mut random = |most: usize| ((numbers.next() + 1.0) / 2.0 * most as f64) as usize;
    let pieces =
        ["[", "]", "{", "}", "1e999", "-1", "null", "\"", "0.5", ",", "[[", "1e-320", "99999999999999999999"];
    let mut refused = 0;
    for _ in 0..3000 {
        let mut text = FILE.to_string();
        for _ in 0..1 + random(3) {
            let place = random(text.len());
            match random(3) {
                0 => text.truncate(place),
                1 => text.insert_str(place, pieces[random(pieces.len())]),
                _ => text
                    .replace_range(place..(place + random(9)).min(text.len()), pieces[random(pieces.len())]),
            }
            if text.is_empty() {
                break;
            }
        }
        match cameras_from_json(&text) {
            Ok(cameras) => assert!(cameras.iter().all(|c| c.camera.focal().iter().all(|f| *f > 0.0))),
            Err(_) => refused += 1,
        }
    }
    assert!(refused > 1000 && refused < 3000, "{refused}");
}

#[test]
fn an_eye_within_a_gaussian_is_reported() {
    let mut splats = Splats::<f32>::new(Degree::Zero);
    let tilted = scenes::rotation([1.0, 0.2, 0.3, 0.4]) * Mat3::from_diagonal(&Vec3::new(2.0, 0.5, 0.01));
    for (mean, axes) in [(Vec3::new(9.0, 0.0, 0.0), Mat3::identity()), (Vec3::zeros(), tilted)] {
        splats.push(Splat { mean: mean.cast(), axes: axes.cast(), opacity: 0.5, harmonics: &[0.0; 3] });
    }
    let camera_at = |eye: Vec3| Camera::new([4, 4], [4.0; 2], Mat3::identity(), eye).unwrap();
    let inside = camera_at(tilted * Vec3::new(1.0, -2.0, 0.5));
    match inside.require_outside(&splats, 3.0).unwrap_err() {
        CameraError::InsideSplat { splat: 1, deviations } => {
            assert!((deviations - 5.25_f64.sqrt()).abs() < 1e-4, "{deviations}");
        }
        other => panic!("{other}"),
    }
    assert_eq!(inside.require_outside(&splats, 2.0), Ok(()));
    assert_eq!(camera_at(tilted * Vec3::new(0.0, 0.0, 3.1)).require_outside(&splats, 3.0), Ok(()));
    let flat =
        Splats::from_arrays(Degree::Zero, vec![Vec3::zeros()], vec![Mat3::zeros()], vec![0.5], vec![0.0; 3]);
    assert_eq!(inside.require_outside(&flat, 3.0), Ok(()));
}
