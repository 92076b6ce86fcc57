//! A scene seen from places on an orbit around it.
//!
//! `cargo run -p gaussian-deform --example orbit` draws a ball of splats and prints colours and times;
//! `cargo run -p gaussian-deform --example orbit scene.ply folder` draws a scene and writes `orbit_0.png` … `orbit_3.png`. Which way is up in it, `-y` or
//! `+z` say, can be given as a third word; otherwise it is `+y`.

#![allow(clippy::print_stdout, reason = "an example prints")]

use gaussian_deform::camera::{Camera, Orbit};
use gaussian_deform::raster::{self, Mode, Picture, Settings};
use gaussian_deform::{Degree, Splat, Splats, file};
use mechanics_core::tensor::{Mat3, Vec3};
use std::path::Path;
use std::time::Instant;

type Failure = Box<dyn std::error::Error>;

/// Discs on a ball of radius one: red from the one side, blue from the other, wherever they are.
fn ball(count: usize) -> Splats {
    let mut splats = Splats::with_capacity(Degree::One, count);
    let spacing = (4.0 * std::f64::consts::PI / count as f64).sqrt();
    for i in 0..count {
        // A spiral that covers the sphere evenly.
        let z = 1.0 - (2 * i + 1) as f64 / count as f64;
        let (sin, cos) = (i as f64 * 2.399_963_229_728_653).sin_cos();
        let normal = Vec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z);
        let side = normal.cross(&Vec3::new(0.3, 0.5, 0.81)).normalize();
        let scales = Vec3::new(0.8, 0.8, 0.1) * spacing;
        let axes = Mat3::from_columns(&[side, normal.cross(&side), normal]) * Mat3::from_diagonal(&scales);
        let green = if i % 8 == 0 { 1.0 } else { -0.5 };
        let harmonics = [0.0, 0.0, 0.0, 0.8, green, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -0.8];
        splats.push(Splat { mean: normal.cast(), axes: axes.cast(), opacity: 0.95, harmonics: &harmonics });
    }
    splats
}

/// A camera position from which the bulk of a scene fills the picture: all but the outermost 2 % of the means at both ends of every axis.
fn orbit_around(splats: &Splats, up: Vec3) -> Orbit {
    let quantile = |k: usize, share: f64| {
        let mut along: Vec<f32> = splats.means().iter().map(|mean| mean[k]).collect();
        along.sort_by(f32::total_cmp);
        f64::from(along[((along.len() - 1) as f64 * share) as usize])
    };
    let low = Vec3::from_fn(|k, _| quantile(k, 0.02));
    let high = Vec3::from_fn(|k, _| quantile(k, 0.98));
    let distance = 1.7 * (high - low).norm();
    Orbit { target: (low + high) / 2.0, distance, azimuth: 0.0, elevation: 0.3, up, field_of_view: 0.7 }
}

fn up(word: &str) -> Result<Vec3, Failure> {
    let axis = match word.trim_start_matches(['+', '-']) {
        "x" => Vec3::x(),
        "y" => Vec3::y(),
        "z" => Vec3::z(),
        other => return Err(format!("`{other}` is not an axis").into()),
    };
    Ok(if word.starts_with('-') { -axis } else { axis })
}

fn write_png(path: &Path, picture: &Picture<f32>) -> Result<(), Failure> {
    let file = std::io::BufWriter::new(std::fs::File::create(path)?);
    let mut encoder = png::Encoder::new(file, picture.width() as u32, picture.height() as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header()?.write_image_data(&picture.to_rgb8())?;
    Ok(())
}

fn main() -> Result<(), Failure> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let scene = match words.first() {
        Some(path) => file::read_file(path)?,
        None => ball(20_000),
    };
    if scene.count() == 0 {
        return Err("the scene is empty".into());
    }
    let orbit = orbit_around(&scene, up(words.get(2).map_or("+y", String::as_str))?);
    let settings = Settings { mode: Mode::Tight, background: [1.0; 3], ..Settings::default() };
    let mut picture = Picture::empty();
    for view in 0..4 {
        let azimuth = f64::from(view) * std::f64::consts::FRAC_PI_2;
        let camera = Camera::on_orbit([800, 800], &Orbit { azimuth, ..orbit })?;
        let start = Instant::now();
        raster::render_into(&scene, &camera, &settings, &mut picture)?;
        let milliseconds = start.elapsed().as_secs_f64() * 1e3;
        let mean = picture.colours().iter().fold([0.0; 3], |mut sum, colour| {
            (0..3).for_each(|k| sum[k] += f64::from(colour[k]) / picture.colours().len() as f64);
            sum
        });
        println!("from {azimuth:.2} rad: mean colour {mean:.3?}, {milliseconds:.1} ms");
        if let Some(folder) = words.get(1) {
            write_png(&Path::new(folder).join(format!("orbit_{view}.png")), &picture)?;
        }
    }
    Ok(())
}
