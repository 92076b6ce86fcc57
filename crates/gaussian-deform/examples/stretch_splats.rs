//! A ball of splats is pulled to one and a half of its length and turned, frame by frame, and written as a sequence that splat editors import.
//!
//! `cargo run -p gaussian-deform --example stretch_splats [folder]`

#![allow(clippy::print_stdout, reason = "an example prints")]

use gaussian_deform::file::{read_file, sequence};
use gaussian_deform::select::{Criteria, means, select};
use gaussian_deform::transport::{Colours, Transport};
use gaussian_deform::{Degree, Splat, Splats};
use mechanics_core::mesh::sphere;
use mechanics_core::samples::DeformationSamples;
use mechanics_core::tensor::{Mat3, Vec3};

/// Discs on a sphere of radius 0.5 m, red from above, blue from below.
fn ball() -> Result<Splats<f64>, Box<dyn std::error::Error>> {
    let mesh = sphere(0.5, 16)?;
    let mut splats = Splats::new(Degree::One);
    for (triangle, area) in mesh.areas().into_iter().enumerate() {
        let [a, b, c] = mesh.corners(triangle);
        let normal = (b - a).cross(&(c - a)).normalize();
        let along = (b - a).normalize();
        let radius = area.sqrt();
        let columns = [along * radius, normal.cross(&along) * radius, normal * (0.1 * radius)];
        // Red, green, blue: constant, and how it changes along y, z, x.
        let harmonics = [0.5, 0.0, 0.8, 0.0, -1.0, 0.0, 0.0, 0.0, 0.5, 0.0, -0.8, 0.0];
        let mean = (a + b + c) / 3.0;
        splats.push(Splat { mean, axes: Mat3::from_columns(&columns), opacity: 0.95, harmonics: &harmonics });
    }
    Ok(splats)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder =
        std::env::args().nth(1).map_or_else(|| std::env::temp_dir().join("stretched_splats"), Into::into);
    let scene = ball()?;
    let matter = select(&scene, &Criteria::default())?;
    let rest = means(&scene, &matter);
    let mut transport = Transport::new(scene, matter, Colours::RotateCoefficients)?;
    let frames = 24;
    for frame in 1..=frames {
        let share = f64::from(frame) / f64::from(frames);
        let (sin, cos) = (share * std::f64::consts::FRAC_PI_2).sin_cos();
        let turn = Mat3::new(cos, 0.0, sin, 0.0, 1.0, 0.0, -sin, 0.0, cos);
        let (long, thin) = (1.0 + 0.5 * share, (1.0 + 0.5 * share).powf(-0.5));
        let f = turn * Mat3::from_diagonal(&Vec3::new(long, thin, thin));
        let positions: Vec<Vec3> = rest.iter().map(|x| f * x).collect();
        transport.deform(DeformationSamples::new(&positions, &vec![f; positions.len()]))?;
        sequence::write_frame(transport.frame(), &folder, frame as usize)?;
    }
    // Read again, the last frame is 1.5 m long, along −z after the quarter turn.
    let last = read_file(sequence::frame_path(&folder, frames as usize))?;
    let length = last.means().iter().map(|m| f64::from(m.z)).fold(0.0, f64::max) * 2.0;
    println!(
        "{} Gaussians, {frames} frames in {}; the last is {length:.3} m long",
        last.count(),
        folder.display()
    );
    assert!((length - 1.5).abs() < 0.01);
    Ok(())
}
