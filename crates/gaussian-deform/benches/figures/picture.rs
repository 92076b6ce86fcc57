//! Pictures of 800 × 800: what they take, and what speed costs in accuracy.

use super::scenes::{self, VIEW};
use super::{
    Bar, Time, interleaved, median, median_busiest, median_core, median_wall, print_calibration,
    print_figure, timed,
};
use gaussian_deform::bind::{Moved, SampleBinding};
use gaussian_deform::camera::{Camera, Orbit};
use gaussian_deform::raster::{self, Mode, Picture, Settings};
use gaussian_deform::select::bulk;
use gaussian_deform::transport::{Colours, Transport};
use gaussian_deform::{Splats, select};
use mechanics_core::parallel;
use mechanics_core::samples::DeformationSamples;
use mechanics_core::tensor::{Mat3, Vec3};

const REPEATS: usize = 9;

/// Bars of exact mode: milliseconds of one core, how much faster two threads are, milliseconds that pass with two.
type Bars = [Bar; 3];

const NONE: Bars = [Bar::Absent; 3];

pub(crate) fn figures() {
    if let Some(plant) = scenes::capture("plant.ply") {
        let mean = plant.means().iter().map(|m| m.cast::<f64>()).sum::<Vec3>() / plant.count() as f64;
        let orbit = Orbit { target: mean, distance: 1.4, up: scenes::CAPTURES_UP, ..VIEW };
        let bars = [Bar::AtMost(85.0), Bar::AtLeast(1.7), Bar::AtMost(50.0)];
        let camera = camera(&orbit);
        measure("plant.ply", &plant, &camera, bars);
        samples_against_pictures(&plant, &camera);
    }
    for name in ["playbot_31k_sh2.ply", "academic_tarot_cards.splat"] {
        if let Some(scene) = scenes::capture(name) {
            measure(name, &scene, &camera(&scenes::view_of(&scene)), NONE);
        }
    }
    let sphere = scenes::wavy_sphere(500_000);
    measure("wavy sphere (prototype: 303 ms)", &sphere, &camera(&VIEW), NONE);
}

fn camera(orbit: &Orbit) -> Camera {
    Camera::on_orbit([800, 800], orbit).unwrap()
}

fn settings(mode: Mode) -> Settings {
    Settings { mode, ..Settings::default() }
}

fn measure(title: &str, scene: &Splats, camera: &Camera, bars: Bars) {
    print_calibration();
    println!("{title}: {} Gaussians of degree {}", scene.count(), scene.degree().number());
    let modes = [("exact", Mode::Exact, bars), ("tight", Mode::Tight, NONE)];
    let draw = |mode, threads| {
        let mut picture = Picture::empty();
        Box::new(move || {
            parallel::with_threads(threads, || {
                timed(|| raster::render_into(scene, camera, &settings(mode), &mut picture).unwrap())
            })
        }) as Box<dyn FnMut() -> Time>
    };
    let mut cases: Vec<_> = modes.iter().flat_map(|&(_, mode, _)| [draw(mode, 1), draw(mode, 2)]).collect();
    let times = interleaved(REPEATS, &mut cases);
    for ((name, _, bars), times) in modes.iter().zip(times.chunks(2)) {
        let gain = |time: fn(&Time) -> f64| {
            median(times[0].iter().zip(&times[1]).map(|(one, two)| time(one) / time(two)))
        };
        print_figure(&format!("{name}, one thread, core"), median_core(&times[0]) * 1e3, "ms", bars[0]);
        print_figure(&format!("{name}, one thread, wall"), median_wall(&times[0]) * 1e3, "ms", Bar::Absent);
        print_figure(&format!("{name}, two threads, core"), median_core(&times[1]) * 1e3, "ms", Bar::Absent);
        print_figure(
            &format!("{name}, two threads, the busier"),
            median_busiest(&times[1]) * 1e3,
            "ms",
            bars[2],
        );
        print_figure(&format!("{name}, two threads, wall"), median_wall(&times[1]) * 1e3, "ms", bars[2]);
        print_figure(
            &format!("{name}, two threads faster, by the busier"),
            gain(|t| t.busiest),
            "times",
            bars[1],
        );
        print_figure(&format!("{name}, two threads faster, wall"), gain(|t| t.wall), "times", bars[1]);
    }
    let [exact, tight] =
        [Mode::Exact, Mode::Tight].map(|mode| raster::render(scene, camera, &settings(mode)).unwrap());
    println!("  exact: {:?}", exact.report());
    let wide = scene.cast::<f64>();
    let mut double = Picture::empty();
    let time = timed(|| raster::render_into(&wide, camera, &settings(Mode::Exact), &mut double).unwrap());
    print_figure("exact in f64, all threads, core", time.core * 1e3, "ms", Bar::Absent);
    print_figure("exact against tight", exact.signal_to_noise(&tight), "dB", Bar::Absent);
    print_figure("f32 against f64", exact.signal_to_noise(&double), "dB", Bar::Absent);
}

/// A twist about the vertical with a sway, and its gradient; lengths in units of the scene.
fn twist(x: &Vec3, centre: &Vec3, size: f64) -> (Vec3, Mat3) {
    let (d, rate) = (x - centre, 0.8 / size);
    let (sin, cos) = (rate * d.y).sin_cos();
    let sway = 0.5 * d.y * d.y / size;
    let position = centre + Vec3::new(cos * d.x + sin * d.z + sway, d.y, cos * d.z - sin * d.x);
    let by_y = Vec3::new((cos * d.z - sin * d.x) * rate + d.y / size, 1.0, -(sin * d.z + cos * d.x) * rate);
    let gradient = Mat3::from_columns(&[Vec3::new(cos, 0.0, -sin), by_y, Vec3::new(sin, 0.0, cos)]);
    (position, gradient)
}

/// A bent scene that a lattice of samples drives, against one sample for each Gaussian.
fn samples_against_pictures(scene: &Splats, camera: &Camera) {
    println!("number of samples against the picture of one sample for each Gaussian, bent and twisted");
    let matter: Vec<u32> = (0..scene.count() as u32).collect();
    let means = select::means(scene, &matter);
    let bounds = bulk(scene, 0.0, 0.0).unwrap();
    let (centre, sides) = (bounds.centre(), bounds.size());
    let moved = |x: &Vec3| twist(x, &centre, sides.max());
    let mut transport = Transport::new(scene.clone(), matter, Colours::RotateCoefficients).unwrap();
    let (positions, gradients): (Vec<Vec3>, Vec<Mat3>) = means.iter().map(moved).unzip();
    transport.deform(DeformationSamples::new(&positions, &gradients)).unwrap();
    let truth = raster::render(transport.frame(), camera, &settings(Mode::Exact)).unwrap();
    for n in [2_usize, 4, 8, 16, 32] {
        let place = |i: usize, k: usize| (i as f64 + 0.5) / n as f64 * sides[k] + bounds.min[k];
        let samples: Vec<Vec3> = (0..n * n * n)
            .map(|i| Vec3::new(place(i / n / n, 0), place(i / n % n, 1), place(i % n, 2)))
            .collect();
        let binding = SampleBinding::new(&samples, &means, 8).unwrap();
        let (positions, gradients): (Vec<Vec3>, Vec<Mat3>) = samples.iter().map(moved).unzip();
        let mut buffer = Moved::new();
        let time = timed(|| {
            binding.move_into(DeformationSamples::new(&positions, &gradients), &mut buffer).unwrap();
            transport.deform(buffer.samples()).unwrap();
        });
        let picture = raster::render(transport.frame(), camera, &settings(Mode::Exact)).unwrap();
        let name =
            format!("{} samples (binding and transport: {:.1} ms of a core)", samples.len(), time.core * 1e3);
        print_figure(&name, picture.signal_to_noise(&truth), "dB", Bar::Absent);
    }
}
