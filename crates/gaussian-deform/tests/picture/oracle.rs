//! A plain rasteriser that looks at every Gaussian on every pixel, written from the papers' formulas, and pictures against it.

use crate::scenes;
use gaussian_deform::camera::Camera;
use gaussian_deform::raster::{self, Antialiasing, DepthChannel, Mode, Settings};
use gaussian_deform::{Degree, Splats, file, harmonics};
use mechanics_core::lanes::Element;
use mechanics_core::tensor::{Mat3, Vec3};
use std::io::Write;

/// What the oracle knows of a Gaussian.
struct Flat {
    place: [f64; 2],
    conic: [f64; 3],
    tiles: [[i64; 2]; 2],
    opacity: f64,
    colour: [f64; 3],
    depth: f64,
}

pub(crate) struct Truth {
    pub(crate) colours: Vec<[f64; 3]>,
    pub(crate) transmittance: Vec<f64>,
    pub(crate) depth: Vec<f64>,
    /// By how much each pixel's closest decision was from going the other way, relatively.
    pub(crate) margin: Vec<f64>,
}

fn flatten(splats: &Splats<f64>, camera: &Camera, antialiasing: Antialiasing) -> Vec<Flat> {
    let size = [camera.width() as f64, camera.height() as f64];
    let ([fx, fy], [cx, cy]) = (camera.focal(), camera.principal_point());
    let mut flats = Vec::new();
    for i in 0..splats.count() {
        let view = camera.view(&splats.means()[i]);
        if view.z <= 0.2 {
            continue;
        }
        // From 0.15 of a side before the first pixel to as far behind the last one.
        let clamped = |slope: f64, f: f64, c: f64, size: f64| {
            slope.clamp((-0.15 * size - c) / f, (1.15 * size - c) / f)
        };
        let z = view.z;
        let x = clamped(view.x / z, fx, cx, size[0]) * z;
        let y = clamped(view.y / z, fy, cy, size[1]) * z;
        let jacobian =
            Mat3::new(fx / z, 0.0, -fx * x / (z * z), 0.0, fy / z, -fy * y / (z * z), 0.0, 0.0, 0.0);
        let axes = splats.axes()[i];
        let map = jacobian * camera.rotation();
        let covariance = map * (axes * axes.transpose()) * map.transpose();
        let (a, b, c) = (covariance[(0, 0)] + 0.3, covariance[(0, 1)], covariance[(1, 1)] + 0.3);
        let determinant = a * c - b * b;
        let mean = 0.5 * (a + c);
        let largest = mean + (mean * mean - determinant).max(0.1).sqrt();
        let radius = (3.0 * largest.sqrt()).ceil();
        let place = [fx * view.x / z + cx - 0.5, fy * view.y / z + cy - 0.5];
        let tiles = [0, 1].map(|k| {
            let count = (size[k] as i64 + 15) / 16;
            let tile = |x: f64| ((x / 16.0) as i64).clamp(0, count);
            [tile(place[k] - radius), tile(place[k] + radius + 15.0)]
        });
        let towards = (splats.means()[i] - camera.eye()).normalize();
        let towards = match splats.orientations() {
            None => towards,
            Some(all) => all[i].transpose() * towards,
        };
        let colour =
            harmonics::colour(splats.degree(), splats.harmonics_of(i), towards.into()).map(|c| c.max(0.0));
        let conic = [c / determinant, -b / determinant, a / determinant];
        let mut opacity = splats.opacities()[i];
        if antialiasing == Antialiasing::Present {
            let sharp = covariance.fixed_view::<2, 2>(0, 0).determinant();
            opacity *= (sharp / determinant).max(0.005 * 0.005).sqrt();
        }
        flats.push(Flat { place, conic, tiles, opacity, colour, depth: z });
    }
    flats.sort_by(|a, b| a.depth.total_cmp(&b.depth));
    flats
}

/// Every Gaussian on every pixel, in double precision.
pub(crate) fn truth(splats: &Splats<f64>, camera: &Camera, settings: &Settings) -> Truth {
    let Settings { mode, background, antialiasing, .. } = *settings;
    let flats = flatten(splats, camera, antialiasing);
    let mut truth = Truth { colours: vec![], transmittance: vec![], depth: vec![], margin: vec![] };
    for row in 0..camera.height() {
        for column in 0..camera.width() {
            let tile = [column as i64 / 16, row as i64 / 16];
            let (mut light, mut colour, mut depth, mut margin) = (1.0, [0.0; 3], 0.0, f64::INFINITY);
            for flat in &flats {
                let inside = |k: usize| (flat.tiles[k][0]..flat.tiles[k][1]).contains(&tile[k]);
                if mode == Mode::Exact && !(inside(0) && inside(1)) {
                    continue;
                }
                let [dx, dy] = [flat.place[0] - column as f64, flat.place[1] - row as f64];
                let [a, b, c] = flat.conic;
                let alpha = flat.opacity * (-0.5 * (a * dx * dx + c * dy * dy) - b * dx * dy).exp();
                margin = f64::min(margin, (alpha * 255.0 - 1.0).abs());
                let alpha = alpha.min(0.99);
                if alpha < 1.0 / 255.0 {
                    continue;
                }
                let rest = light * (1.0 - alpha);
                margin = margin.min((rest / 1e-4 - 1.0).abs());
                if rest < 1e-4 {
                    break;
                }
                for k in 0..3 {
                    colour[k] += flat.colour[k] * alpha * light;
                }
                depth += flat.depth * alpha * light;
                light = rest;
            }
            truth.colours.push([0, 1, 2].map(|k| colour[k] + light * background[k]));
            truth.transmittance.push(light);
            truth.depth.push(depth);
            truth.margin.push(margin);
        }
    }
    truth
}

/// Compares all but pixels with a decision within `threshold`; answers how many those are.
fn check<E: Element>(
    splats: &Splats<f64>,
    camera: &Camera,
    (mode, antialiasing): (Mode, Antialiasing),
    tolerance: f64,
    threshold: f64,
) -> usize {
    let settings = Settings { mode, background: [0.2, 0.5, 0.1], depth: DepthChannel::Present, antialiasing };
    let truth = truth(splats, camera, &settings);
    let picture = raster::render(&splats.cast::<E>(), camera, &settings).unwrap();
    let mut fragile = 0;
    for (pixel, &margin) in truth.margin.iter().enumerate() {
        if margin < threshold {
            fragile += 1;
            continue;
        }
        let mut pairs = vec![(picture.transmittance()[pixel], truth.transmittance[pixel])];
        pairs.push((picture.depth().unwrap()[pixel], truth.depth[pixel]));
        pairs.extend(picture.colours()[pixel].into_iter().zip(truth.colours[pixel]));
        for (ours, theirs) in pairs {
            let error = (ours.into() - theirs).abs();
            assert!(error <= tolerance, "{mode:?}, pixel {pixel}: {ours:?} for {theirs}, {error:e}");
        }
    }
    fragile
}

const RULES: [(Mode, Antialiasing); 4] = [
    (Mode::Exact, Antialiasing::Absent),
    (Mode::Tight, Antialiasing::Absent),
    (Mode::Exact, Antialiasing::Present),
    (Mode::Tight, Antialiasing::Present),
];

/// Pictures whose sides are no multiples of sixteen, and smaller than a tile.
const SIZES: [[usize; 2]; 5] = [[75, 53], [64, 48], [16, 1], [1, 33], [7, 9]];

#[test]
fn double_precision_agrees_with_every_gaussian_on_every_pixel() {
    for (seed, size) in SIZES.into_iter().enumerate() {
        let camera = scenes::camera(size[0], size[1]);
        for (degree, rules) in Degree::ALL.into_iter().zip(RULES) {
            let scene = scenes::mixed(degree, 403, seed as u64);
            let fragile = check::<f64>(&scene, &camera, rules, 1e-11, 1e-9);
            assert!(fragile <= 1, "{fragile} pixels");
        }
    }
}

#[test]
fn single_precision_agrees_too() {
    for (seed, size) in SIZES.into_iter().enumerate() {
        let camera = scenes::camera(size[0], size[1]);
        for rules in &RULES[1..3] {
            let scene = scenes::mixed(Degree::Three, 403, seed as u64 + 100).cast::<f32>().cast();
            let fragile = check::<f32>(&scene, &camera, *rules, 5e-5, 1e-4);
            assert!(fragile * 20 <= size[0] * size[1], "{fragile} pixels");
        }
    }
}

/// Axes that meet the picture off its middle, and beside it.
#[test]
fn off_centre_cameras_agree_too() {
    for (seed, principal) in [[10.0, 40.0], [-30.5, 20.0], [37.5, 90.0]].into_iter().enumerate() {
        let camera = scenes::camera(75, 53).with_principal_point(principal).unwrap();
        let scene = scenes::mixed(Degree::One, 403, seed as u64 + 7);
        let fragile = check::<f64>(&scene, &camera, RULES[seed], 1e-11, 1e-9);
        assert!(fragile <= 1, "{fragile} pixels");
    }
}

/// A part of a picture is the picture of a camera whose axis passes elsewhere: at whole tiles in exact mode.
#[test]
fn a_part_of_a_picture_is_an_off_centre_picture() {
    let whole = scenes::camera(144, 112);
    let mut scene = scenes::mixed(Degree::Two, 300, 21);
    // None so far out that the part would linearise its projection elsewhere.
    scene.means_mut().iter_mut().for_each(|mean| *mean *= 0.3);
    for (mode, corner) in [(Mode::Exact, [48, 32]), (Mode::Tight, [37, 31])] {
        let settings = Settings { mode, background: [0.1, 0.2, 0.3], ..Settings::default() };
        let all = raster::render(&scene, &whole, &settings).unwrap();
        let principal = [72.0 - corner[0] as f64, 56.0 - corner[1] as f64];
        let part = Camera::new([64, 48], whole.focal(), *whole.rotation(), *whole.eye()).unwrap();
        let part = part.with_principal_point(principal).unwrap();
        let part = raster::render(&scene, &part, &settings).unwrap();
        let mut seen = 0;
        for (pixel, colour) in part.colours().iter().enumerate() {
            let there = (corner[1] + pixel / 64) * 144 + corner[0] + pixel % 64;
            let difference = Vec3::from(*colour) - Vec3::from(all.colours()[there]);
            assert!(difference.amax() < 1e-10, "{mode:?}, pixel {pixel}: {difference:?}");
            seen += usize::from(part.transmittance()[pixel] < 0.5);
        }
        assert!(seen > 500, "{seen}");
    }
}

/// What a small Gaussian takes of the light all over the picture is its volume 2π o √det Σ₀, whatever the low-pass does to it: a sum over pixels of a Gaussian of
/// variance 0.3 at least misses its integral by 4 exp(−2π² 0.3) = 1 %, and less than 1/255 of opacity is cut off. From twice as far it is a quarter; without antialiasing it is not.
#[test]
fn antialiasing_keeps_the_light_that_small_gaussians_take() {
    let taken = |distance: f64, antialiasing| {
        let mut scene = Splats::<f64>::new(Degree::Zero);
        // 0.8 and 0.5 pixels from ten metres, 1000 pixels of focal length.
        let axes = Mat3::from_diagonal(&Vec3::new(0.008, 0.005, 0.003));
        scene.push(gaussian_deform::Splat {
            mean: Vec3::z() * distance,
            axes,
            opacity: 0.9,
            harmonics: &[0.0; 3],
        });
        let camera = Camera::new([31, 33], [1000.0; 2], Mat3::identity(), Vec3::zeros()).unwrap();
        let settings = Settings { antialiasing, ..Settings::default() };
        let picture = raster::render(&scene, &camera, &settings).unwrap();
        picture.transmittance().iter().map(|t| 1.0 - t).sum::<f64>()
    };
    let volume = std::f64::consts::TAU * 0.9 * 0.8 * 0.5;
    for (distance, share) in [(10.0, 1.0), (20.0, 0.25)] {
        let kept = taken(distance, Antialiasing::Present) / (volume * share);
        assert!((0.95..1.02).contains(&kept), "{distance} m: {kept}");
    }
    assert!(taken(20.0, Antialiasing::Absent) > 2.0 * 0.25 * volume);
}

#[test]
fn only_opacities_above_the_stated_one_are_cut_off_by_three_sigma() {
    let camera = scenes::camera(200, 160);
    let settings = |mode| Settings { mode, ..Settings::default() };
    let mut scene = scenes::mixed(Degree::Zero, 60, 5);
    let difference = |scene: &Splats<f64>| {
        let [exact, tight] =
            [Mode::Exact, Mode::Tight].map(|mode| raster::render(scene, &camera, &settings(mode)).unwrap());
        let pixels = exact.transmittance().iter().zip(tight.transmittance());
        pixels.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    assert!(difference(&scene) > 1.0 / 255.0);
    scene.opacities_mut().iter_mut().for_each(|o| *o = o.min(4.5_f64.exp() / 255.0));
    assert_eq!(difference(&scene), 0.0);
}

#[test]
fn three_gaussians_on_one_axis_blend_in_closed_form() {
    // Straight ahead: opacity 0.5 each, red before green before blue, given in another order.
    let mut scene = Splats::<f64>::new(Degree::Zero);
    for (channel, depth) in [(2, 4.0), (0, 2.0), (1, 3.0)] {
        let half = 0.5 / 0.28209479177387814;
        let harmonics: Vec<f64> = (0..3).map(|k| if k == channel { half } else { -half }).collect();
        let mean = Vec3::new(0.0, 0.0, depth);
        scene.push(gaussian_deform::Splat {
            mean,
            axes: Mat3::identity() * 0.1,
            opacity: 0.5,
            harmonics: &harmonics,
        });
    }
    let camera = Camera::new([33, 33], [100.0, 100.0], Mat3::identity(), Vec3::zeros()).unwrap();
    let settings = Settings { background: [1.0; 3], depth: DepthChannel::Present, ..Settings::default() };
    let picture = raster::render(&scene, &camera, &settings).unwrap();
    let middle = 16 * 33 + 16;
    for (k, expected) in [0.625, 0.375, 0.25].into_iter().enumerate() {
        assert!((picture.colours()[middle][k] - expected).abs() < 1e-14);
    }
    assert!((picture.transmittance()[middle] - 0.125).abs() < 1e-14);
    assert!((picture.depth().unwrap()[middle] - (1.0 + 0.75 + 0.5)).abs() < 1e-13);
}

/// Says it past the test harness, which shows what a test prints only if it fails: the gate counts these lines.
fn skipped(reason: &str) {
    std::io::stderr().write_all(format!("\nSKIPPED ({reason})\n").as_bytes()).unwrap();
}

/// A whole capture on a few pixels, each of which hundreds of Gaussians reach.
#[test]
fn a_real_capture_agrees_too() {
    let Some(folder) = std::env::var_os("SPLAT_SCENES_DIR") else {
        skipped("SPLAT_SCENES_DIR names no folder with plant.ply");
        return;
    };
    let scene = file::read_file(std::path::Path::new(&folder).join("plant.ply")).unwrap().cast::<f64>();
    let middle = scene.means().iter().sum::<Vec3>() / scene.count() as f64;
    let eye = middle + Vec3::new(0.5, -0.4, 1.2);
    let camera = Camera::look_at([21, 18], 0.8, eye, middle, -Vec3::y()).unwrap();
    for rules in RULES {
        let fragile = check::<f64>(&scene, &camera, rules, 1e-10, 1e-10);
        assert!(fragile <= 1, "{fragile} pixels");
    }
}
