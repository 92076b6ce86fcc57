//! Scenes that are measured.

use gaussian_deform::camera::Orbit;
use gaussian_deform::select::bulk;
use gaussian_deform::{Degree, Splat, Splats, file};
use mechanics_core::tensor::{Mat3, Matrix3, Vec3, vector};
use std::path::Path;

/// Numbers from −1 to 1.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// A real capture, if the folder of captures has it.
pub(crate) fn capture(name: &str) -> Option<Splats> {
    let Some(folder) = std::env::var_os("SPLAT_SCENES_DIR") else {
        println!("\n{name}: SKIPPED, SPLAT_SCENES_DIR is not set");
        return None;
    };
    let path = Path::new(&folder).join(name);
    if !path.exists() {
        println!("\n{name}: SKIPPED, {} is not there", path.display());
        return None;
    }
    Some(file::read_file(path).unwrap())
}

/// Gaussians anywhere in a cube, of any colours.
pub(crate) fn cloud(degree: Degree, count: usize) -> Splats {
    let mut random = Random(1);
    let mut splats = Splats::with_capacity(degree, count);
    let mut harmonics = vec![0.0; degree.stride()];
    for _ in 0..count {
        harmonics.fill_with(|| random.next() as f32);
        splats.push(Splat {
            mean: vector([0.0; 3].map(|_: f32| random.next() as f32)),
            axes: Matrix3::from_fn(|_, _| 0.01 * random.next() as f32),
            opacity: 0.5,
            harmonics: &harmonics,
        });
    }
    splats
}

/// Discs on a wavy sphere of radius one: colours of degree 2, every other one half transparent.
pub(crate) fn wavy_sphere(count: usize) -> Splats {
    let mut random = Random(1);
    let mut splats = Splats::with_capacity(Degree::Two, count);
    let spacing = (4.0 * std::f64::consts::PI / count as f64).sqrt();
    for i in 0..count {
        // A spiral that covers the sphere evenly.
        let z = 1.0 - (2 * i + 1) as f64 / count as f64;
        let (sin, cos) = (i as f64 * 2.399_963_229_728_653).sin_cos();
        let across = (1.0 - z * z).sqrt();
        let normal = Vec3::new(across * cos, across * sin, z);
        let radius = 1.0 + 0.1 * (9.0 * normal.x).sin() * (7.0 * normal.y).cos();
        let side = normal.cross(&Vec3::new(0.3, 0.5, 0.81)).normalize();
        let rotation = Mat3::from_columns(&[side, normal.cross(&side), normal]);
        let scales = [1.0, 1.0, 0.2].map(|s| s * spacing * (1.0 + 0.5 * random.next()));
        let axes = rotation * Mat3::from_diagonal(&Vec3::from(scales));
        let harmonics: [f32; 27] =
            std::array::from_fn(|k| (random.next() * if k % 9 == 0 { 1.5 } else { 0.2 }) as f32);
        splats.push(Splat {
            mean: (normal * radius).cast(),
            axes: axes.cast(),
            opacity: if i % 2 == 0 { 0.95 } else { 0.5 },
            harmonics: &harmonics,
        });
    }
    splats
}

/// From where the plant and the sphere are measured.
pub(crate) const VIEW: Orbit = Orbit {
    target: Vec3::new(0.0, 0.0, 0.0),
    distance: 3.2,
    azimuth: 0.6,
    elevation: 0.3,
    up: Vec3::new(0.0, 1.0, 0.0),
    field_of_view: 0.8,
};

/// Trained scenes have y down.
pub(crate) const CAPTURES_UP: Vec3 = Vec3::new(0.0, -1.0, 0.0);

/// From where the bulk of a capture fills the picture.
pub(crate) fn view_of(splats: &Splats) -> Orbit {
    let bounds = bulk(splats, 0.0, 0.02).unwrap();
    let distance = 1.4 * bounds.size().norm();
    Orbit { target: bounds.centre(), distance, up: CAPTURES_UP, ..VIEW }
}
