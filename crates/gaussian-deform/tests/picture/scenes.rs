//! Scenes and cameras that several tests look at.

use gaussian_deform::camera::Camera;
use gaussian_deform::{Degree, Splat, Splats};
use mechanics_core::tensor::{Mat3, Vec3};

/// Numbers from −1 to 1, the same in every run.
pub(crate) struct Numbers(pub(crate) u64);

impl Numbers {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    pub(crate) fn vector(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }

    pub(crate) fn rotation(&mut self) -> Mat3 {
        let [w, x, y, z] = [self.next(), self.next(), self.next(), self.next()];
        rotation([w, x, y, z])
    }
}

/// Of a quaternion w, x, y, z of any length.
pub(crate) fn rotation(quaternion: [f64; 4]) -> Mat3 {
    let length = quaternion.iter().map(|a| a * a).sum::<f64>().sqrt();
    let [w, x, y, z] = quaternion.map(|a| a / length);
    // I + 2 w [v]× + 2 [v]×²
    let cross = Mat3::new(0.0, -z, y, z, 0.0, -x, -y, x, 0.0);
    Mat3::identity() + cross * (2.0 * w) + cross * cross * 2.0
}

/// Gaussians in a ball of radius one: round ones, discs and needles from a tenth of a pixel to half of the picture, of all opacities.
pub(crate) fn mixed(degree: Degree, count: usize, seed: u64) -> Splats<f64> {
    let mut numbers = Numbers(seed);
    let mut splats = Splats::new(degree);
    for _ in 0..count {
        let scales = [0.1_f64, 0.1, 0.1].map(|s| s * 10_f64.powf(1.2 * numbers.next() - 0.6));
        let axes = numbers.rotation() * Mat3::from_diagonal(&Vec3::from(scales));
        let opacity = match numbers.next() {
            x if x > 0.8 => 1.0,
            x if x > 0.2 => 0.9 + 0.1 * x,
            x => (0.5 + 0.5 * x).max(0.001),
        };
        let per_channel = degree.coefficients();
        let harmonics: Vec<f64> = (0..degree.stride())
            .map(|k| numbers.next() * if k % per_channel == 0 { 2.0 } else { 0.5 })
            .collect();
        splats.push(Splat { mean: numbers.vector(), axes, opacity, harmonics: &harmonics });
    }
    splats
}

/// From three metres away, with no symmetry.
pub(crate) fn camera(width: usize, height: usize) -> Camera {
    let (eye, target) = (Vec3::new(1.4, 0.9, 2.5), Vec3::new(0.05, -0.1, 0.02));
    Camera::look_at([width, height], 0.7, eye, target, Vec3::new(0.1, 1.0, -0.2)).unwrap()
}
