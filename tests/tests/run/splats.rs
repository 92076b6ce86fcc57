//! `run` of scenes of splats, against closed forms, and what it refuses.

use super::{column, names, read, run, succeed, temporary};
use gaussian_deform::file::ply::{self, PlyEncoding};
use gaussian_deform::{Degree, Splat, Splats, file};
use mechanics_core::tensor::{Mat3, Vec3};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// Where the body of [`ball`] is in its file.
const MIDDLE: Vec3 = Vec3::new(3.0, -2.0, 5.0);

/// A ball of splats with radius 2 around [`MIDDLE`], and one far away, of opacity 0.01: 401 in all.
pub(super) fn ball(folder: &Path) {
    let mut splats = Splats::<f32>::new(Degree::Zero);
    let mut push = |mean: Vec3, opacity: f32| {
        let axes = Mat3::from_diagonal(&Vec3::new(0.2, 0.15, 0.1));
        splats.push(Splat { mean: mean.cast(), axes: axes.cast(), opacity, harmonics: &[0.3, 0.1, -0.4] });
    };
    for i in 0..400 {
        let z = 1.0 - (2 * i + 1) as f64 / 400.0;
        let (sin, cos) = (f64::from(i) * 2.399_963_229_728_653).sin_cos();
        let side = (1.0 - z * z).sqrt();
        push(MIDDLE + Vec3::new(side * cos, side * sin, z) * 2.0, 0.9);
    }
    push(Vec3::new(40.0, 0.0, 0.0), 0.01);
    ply::write_file(&splats, PlyEncoding::BinaryLittleEndian, folder.join("ball.ply"))
        .expect("the folder is ours");
}

/// As short as it may be, but for the last two tables: −y is up.
pub(super) const BALL: &str = r#"[splats]
file = "ball.ply"
up = "-y"
placement = { on-floor = { size_m = 1, height_m = 0.6 } }

[splats.particles]
cells = 8
frames = 5
frame_rate_hz = 20

[splats.camera]
size_px = [64, 48]
"#;

fn frame(out: &Path, number: usize) -> Splats {
    file::read_file(out.join(format!("frames/frame_{number:04}.ply"))).expect("a frame")
}

fn mean(splats: &Splats) -> Vec3 {
    splats.means()[..400].iter().map(|x| x.cast::<f64>()).sum::<Vec3>() / 400.0
}

#[test]
fn a_ball_of_splats_falls_in_its_own_frame_and_the_rest_stays() {
    let folder = temporary();
    ball(folder.path());
    let out = succeed(folder.path(), BALL, &[]);
    let rest = frame(&out, 1);
    assert_eq!(rest.count(), 401);
    // Four metres of the file are one of the simulation; the end is 0.2 s later, in steps so short that h/t is below 5 %.
    let way = mean(&frame(&out, 5)) - mean(&rest);
    let expected = Vec3::new(0.0, 4.0 * 0.5 * 9.81 * 0.04, 0.0);
    assert!((way - expected).norm() < 0.05 * expected.norm(), "{way} for {expected}");
    let far = frame(&out, 5).means()[400];
    assert!((far.cast::<f64>() - Vec3::new(40.0, 0.0, 0.0)).norm() < 1e-5, "what is faint is no matter");
    let wanted: Vec<String> =
        (1..=5).flat_map(|k| ["ply", "png"].map(|ending| format!("frame_{k:04}.{ending}"))).collect();
    assert_eq!(names(&out.join("frames")), wanted);
    assert!(read(&out.join("summary.txt")).contains("401, 400 of them matter"));
    assert_eq!(read(&out.join("diagnostics.csv")).lines().count(), 5);
    assert!(out.join("film.gif").is_file());
}

#[test]
fn what_is_held_turns_as_a_rigid_body_and_falls_when_it_is_let_go() {
    let folder = temporary();
    ball(folder.path());
    let held = "[[splats.particles.holds]]\nselect = { min_m = [-1, -1, 0], max_m = [1, 1, 2] }\n\
        angular_velocity_rad_s = [0, 0, 5]\nuntil_s = 0.1\n";
    let text = format!("{BALL}\n{held}")
        .replace("frame_rate_hz = 20", "frame_rate_hz = 20\ngravity_m_s2 = [0, 0, 0]");
    let out = succeed(folder.path(), &text, &["--export", "ply"]);
    let (rest, turned) = (frame(&out, 1), frame(&out, 3));
    // Half a radian about the file's −y, through the ball's middle.
    let (sin, cos) = 0.5_f64.sin_cos();
    let turn = Mat3::new(cos, 0.0, -sin, 0.0, 1.0, 0.0, sin, 0.0, cos);
    for i in 0..400 {
        let arm = rest.means()[i].cast::<f64>() - MIDDLE;
        let found = turned.means()[i].cast::<f64>() - MIDDLE;
        // The middle of the means is that of the ball but for 1e-2 of its radius.
        assert!((found - turn * arm).norm() < 0.05, "splat {i}: {found} for {}", turn * arm);
        let covariance = |splats: &Splats| {
            let [xx, xy, xz, yy, yz, zz] = splats.covariance(i).map(f64::from);
            Mat3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
        };
        let expected = turn * covariance(&rest) * turn.transpose();
        assert!((covariance(&turned) - expected).norm() < 1e-3 * expected.norm(), "splat {i}");
    }
    assert_eq!(names(&out), ["diagnostics.csv", "frames", "summary.txt"]);
}

#[test]
fn a_resumed_run_of_splats_goes_on_with_the_same_bits() {
    let folder = temporary();
    ball(folder.path());
    let struck = "[[splats.particles.impulses]]\nselect = { min_m = [0, -1, 0], max_m = [1, 1, 2] }\n\
        impulse_n_s = [0, 90, 0]\nat_s = 0.12\n";
    let text = format!("{BALL}\n{struck}");
    let out = succeed(folder.path(), &text, &["--export", "ply", "--checkpoint-every", "2"]);
    let bytes = || std::fs::read(out.join("frames/frame_0005.ply")).expect("a frame");
    let whole = bytes();
    let checkpoint = folder.path().join("out.checkpoints/step_00002.checkpoint");
    let checkpoint = checkpoint.to_str().expect("a plain path").to_owned();
    succeed(folder.path(), &text, &["--export", "ply", "--resume", &checkpoint]);
    assert_eq!(names(&out.join("frames")), ["frame_0003.ply", "frame_0004.ply", "frame_0005.ply"]);
    assert!(bytes() == whole, "the last frame has other bits");
    let other = run(folder.path(), &text.replace("cells = 8", "cells = 9"), &["--resume", &checkpoint]);
    assert!(other.code == Some(2) && other.err.contains("problem"), "{}", other.err);
}

#[test]
fn a_part_has_its_own_density_and_law() {
    let folder = temporary();
    ball(folder.path());
    // What is above the middle: −y is up.
    let part = "up = \"-y\"\nparts = [{ region = { box = { min = [0, -9, 0], max = [9, -2, 9] } }, material = \"sand\", density_kg_m3 = 3000 }]";
    let ends = [BALL.to_owned(), BALL.replace("up = \"-y\"", part)].map(|text| {
        let out = succeed(folder.path(), &text, &["--export", "ply"]);
        ["mass_kg", "centre_z_m", "momentum_z_kg_m_s"].map(|name| column(&out, name)[3])
    });
    let [[mass, height, _], [heavier, higher, momentum]] = ends;
    assert!((heavier / mass - 2.0).abs() < 0.06, "{mass} kg and {heavier} kg");
    // So few splats enclose nothing: they are a shell. A half one has its centre at half of the radius: (3 − 1)/(3 + 1) of it is left.
    let expected = 0.5 * 0.5 * 0.5;
    assert!((higher - height - expected).abs() < 0.03 * expected, "{height} m and {higher} m");
    assert!((momentum / (-9.81 * 0.2 * heavier) - 1.0).abs() < 1e-11, "it falls freely");
}

#[test]
fn matter_inside_a_sticky_collider_moves_with_it_whatever_the_shape() {
    let folder = temporary();
    ball(folder.path());
    for shape in [
        "half-space = { point_m = [0, 0, 5], normal = [0, 0, 2] }",
        "ball = { centre_m = [0, 0, 1], radius_m = 3 }",
        "box = { centre_m = [0, 0, 1], half_sides_m = [3, 3, 3] }",
        "capsule = { from_m = [-1, 0, 1], to_m = [1, 0, 1], radius_m = 3 }",
    ] {
        let collider = format!(
            "[[splats.particles.colliders]]\nshape = {{ {shape} }}\nsurface = \"sticky\"\nvelocity_m_s = [0.3, 0, 0.4]\n"
        );
        let text = format!("{BALL}\n{collider}").replace("frames = 5", "frames = 3");
        let out = succeed(folder.path(), &text, &["--export", "ply"]);
        let (rest, end) = (frame(&out, 1), frame(&out, 3));
        // The longest side of the means is one metre of the simulation, and the file's −y is up.
        let side = (0..3)
            .map(|axis| {
                let along = rest.means()[..400].iter().map(|x| f64::from(x[axis]));
                along.clone().fold(f64::MIN, f64::max) - along.fold(f64::MAX, f64::min)
            })
            .fold(0.0, f64::max);
        let expected = Vec3::new(0.3, -0.4, 0.0) * (0.1 * side);
        for i in 0..400 {
            let way = (end.means()[i] - rest.means()[i]).cast::<f64>();
            assert!((way - expected).norm() < 1e-5, "{shape}: splat {i} went {way}");
        }
    }
}

#[test]
fn embedded_splats_fall_with_the_particles_around_them() {
    let folder = temporary();
    ball(folder.path());
    let text = BALL.replace("cells = 8", "cells = 8\nbinding = \"embedded\"");
    let out = succeed(folder.path(), &text, &["--export", "ply"]);
    let summary = read(&out.join("summary.txt"));
    let particles = summary.lines().find_map(|line| line.strip_prefix("particles     ")).expect("their line");
    let count: usize = particles.split(',').next().and_then(|count| count.parse().ok()).expect("a count");
    // All are filling, one in each cell of half the size that the shell is in: about one for its area.
    let shell = 4.0 * std::f64::consts::PI * 64.0;
    assert!(particles.contains(&format!("{count}, {count} of them")), "{particles}");
    assert!((0.4..1.5).contains(&(count as f64 / shell)), "{particles}");
    let read = file::read_file(folder.path().join("ball.ply")).expect("ours");
    let (rest, end) = (frame(&out, 1), frame(&out, 5));
    let fallen = Vec3::new(0.0, 4.0 * 0.5 * 9.81 * 0.04, 0.0);
    for i in 0..400 {
        let still = (rest.means()[i] - read.means()[i]).norm();
        assert!(still < 1e-5, "splat {i} is {still} off at rest");
        let way = (end.means()[i] - rest.means()[i]).cast::<f64>();
        assert!((way - fallen).norm() < 0.05 * fallen.norm(), "splat {i} fell {way}");
    }
}

/// Width, height, and the box of what is not white: left, top, right, bottom.
fn seen(path: &Path) -> ([u32; 2], [usize; 4]) {
    let decoder = png::Decoder::new(BufReader::new(File::open(path).expect("a picture")));
    let mut reader = decoder.read_info().expect("a PNG");
    let mut pixels = vec![0; reader.output_buffer_size().expect("a small picture")];
    let info = reader.next_frame(&mut pixels).expect("a whole picture");
    let each = info.buffer_size() / (info.width * info.height) as usize;
    let (mut left, mut top, mut right, mut bottom) = (usize::MAX, usize::MAX, 0, 0);
    for (k, pixel) in pixels[..info.buffer_size()].chunks_exact(each).enumerate() {
        if pixel[..3].iter().any(|channel| *channel < 250) {
            let (x, y) = (k % info.width as usize, k / info.width as usize);
            (left, top) = (left.min(x), top.min(y));
            (right, bottom) = (right.max(x + 1), bottom.max(y + 1));
        }
    }
    ([info.width, info.height], [left, top, right, bottom])
}

#[test]
fn a_camera_of_a_file_sees_the_ball_where_its_formula_says() {
    let folder = temporary();
    ball(folder.path());
    // It looks along z, and is not in the middle: the ball is two metres to the left and one above.
    let cameras = "[{ \"img_name\": \"a\", \"width\": 8, \"height\": 8, \"position\": [0, 0, -90], \
        \"rotation\": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], \"fx\": 9, \"fy\": 9 }, \
        { \"img_name\": \"b\", \"width\": 160, \"height\": 120, \"position\": [5, -1, -15], \
        \"rotation\": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], \"fx\": 200, \"fy\": 200 }]";
    std::fs::write(folder.path().join("cameras.json"), cameras).expect("the folder is ours");
    let file = "file = \"cameras.json\"\npicture = \"b\"";
    for (size, times) in [("", 1.0), ("\nsize_px = [320, 240]", 2.0)] {
        let text = BALL.replace("size_px = [64, 48]", &format!("{file}{size}"));
        let out = succeed(folder.path(), &text, &["--export", "png", "--steps", "1"]);
        let (found, bounds) = seen(&out.join("frames/frame_0001.png"));
        assert_eq!(found, [160, 120].map(|side| (f64::from(side) * times) as u32));
        // f/z = 10 pixels a metre; splats reach up to three deviations beyond the ball, 0.6 of the file's metres.
        let middle = [80.0 - 20.0, 60.0 - 10.0].map(|x| x * times);
        for axis in 0..2 {
            let (low, high) = (bounds[axis] as f64, bounds[axis + 2] as f64);
            assert!((0.5 * (low + high) - middle[axis]).abs() < 1.5 * times, "{bounds:?} at {times}");
            assert!((40.0..56.0).contains(&((high - low) / times)), "{bounds:?} at {times}");
        }
    }
    let unknown = BALL.replace("size_px = [64, 48]", &file.replace("\"b\"", "\"c\""));
    let answer = run(folder.path(), &unknown, &[]);
    assert!(answer.code == Some(2) && answer.err.contains("there are: a, b"), "{}", answer.err);
}

/// A shell script stands for ffmpeg.
#[cfg(unix)]
#[test]
fn a_film_is_handed_to_ffmpeg_frame_by_frame_and_its_failure_is_told() {
    use std::os::unix::fs::PermissionsExt;
    use std::process::Command;
    let folder = temporary();
    ball(folder.path());
    let scene = folder.path().join("scene.toml");
    std::fs::write(&scene, BALL).expect("the folder is ours");
    let run = |ffmpeg: &str| {
        let program = folder.path().join("ffmpeg");
        std::fs::write(&program, ffmpeg).expect("the folder is ours");
        std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).expect("ours");
        let old = std::env::var("PATH").unwrap_or_default();
        let mut command = Command::new(env!("CARGO_BIN_EXE_validation"));
        command.env("PATH", format!("{}:{old}", folder.path().display()));
        command.arg("run").arg(&scene).args(["--export", "mp4", "--out"]).arg(folder.path().join("out"));
        command.output().expect("the program starts")
    };
    // Writes what it is given into its last argument.
    let keeps =
        "#!/bin/sh\nall=\"$*\"\nfor file; do :; done\ncat > \"$file\"\necho \"$all\" > \"$file.arguments\"\n";
    let answer = run(keeps);
    assert!(answer.status.success(), "{}", String::from_utf8_lossy(&answer.stderr));
    let film = folder.path().join("out/film.mp4");
    assert_eq!(std::fs::metadata(&film).expect("a film").len(), 5 * 64 * 48 * 3);
    let arguments = read(&folder.path().join("out/film.mp4.arguments"));
    assert!(arguments.contains("-s 64x48 -r 20.0 -i -"), "{arguments}");
    std::fs::remove_dir_all(folder.path().join("out")).expect("ours");
    let answer = run("#!/bin/sh\ncat > /dev/null\necho no such codec >&2\nexit 3\n");
    let told = String::from_utf8_lossy(&answer.stderr);
    assert!(!answer.status.success() && told.contains("no such codec"), "{told}");
    assert!(!folder.path().join("out").exists());
}

#[test]
fn splats_that_cannot_be_run_exit_2_with_file_and_line() {
    let particles = "[splats.particles]\n";
    for (good, bad, words) in [
        ("file = \"ball.ply\"", "file = \"none.ply\"", "there is no file"),
        ("file = \"ball.ply\"", "file = \"bar.toml\"", "scenes are read from .ply"),
        ("file = \"ball.ply\"", "file = \"broken.ply\"", "broken.ply"),
        ("up = \"-y\"", "up = \"y\"", "unknown variant `y`"),
        (
            "up = \"-y\"",
            "region = { box = { min = [9, 9, 9], max = [10, 10, 10] } }",
            "none of 401 Gaussians",
        ),
        ("up = \"-y\"", "region = { box = { min = [9, 9, 9], max = [8, 10, 10] } }", "is above max's 8"),
        (
            "up = \"-y\"",
            "opacity = 0.95",
            "none of the 401 Gaussians in the region has an opacity of 0.95 or more",
        ),
        ("up = \"-y\"", "opacity = 2", "must be from 0 to 1"),
        ("up = \"-y\"", "material = \"cheese\"", "unknown variant `cheese`, expected one of `jelly`"),
        (
            "up = \"-y\"",
            "law = { tait = { bulk_modulus_pa = -1, exponent = 7, viscosity_pa_s = 0 } }",
            "-1 is not allowed",
        ),
        (
            "up = \"-y\"",
            "law = { drucker-prager = { young_modulus_pa = 1e6, poisson_ratio = 0.3, friction_angle_rad = 2, cohesion_pa = 0 } }",
            "friction angle",
        ),
        (
            "up = \"-y\"",
            "parts = [{ region = { box = { min = [9, 9, 9], max = [10, 10, 10] } }, material = \"sand\" }]",
            "there is no matter in it",
        ),
        ("size_px = [64, 48]", "azimuth = 1", "unknown field `azimuth`"),
        // The far one: its mean is at (40 − 3)/4 and so on.
        (
            "size_px = [64, 48]",
            "target_m = [9.25, -1.25, 0.6]\ndistance = 0.005",
            "the eye is inside Gaussian 400",
        ),
        ("size_px = [64, 48]", "elevation_rad = 1.6", "elevation"),
        ("size_px = [64, 48]", "file = \"none.json\"", "there is no file"),
        ("size_px = [64, 48]", "file = \"broken.json\"", "a list of cameras"),
        ("size_px = [64, 48]", "picture = \"a\"", "no meaning without `file`"),
        (particles, "[splats.particles]\nfloor = { surface = \"ice\" }\n", "unknown variant `ice`"),
        (
            particles,
            "[splats.particles]\nholds = [{ select = { min_m = [5, 5, 5], max_m = [6, 6, 6] } }]\n",
            "there is no matter in the box; matter is between",
        ),
        (
            particles,
            "[splats.particles]\nholds = [{ select = { min_m = [-1, -1, 0], max_m = [1, 1, 2] }, from_s = 1, until_s = 0.5 }]\n",
            "must be after its begin",
        ),
        (
            particles,
            "[splats.particles]\ncolliders = [{ shape = { half-space = { point_m = [0, 0, 0], normal = [0, 0, 0] } } }]\n",
            "must not be zero",
        ),
        (
            particles,
            "[contact]\nactivation_distance_m = 1e-3\npair_force_n = 1\n\n[splats.particles]\n",
            "no `[[meshes]]`",
        ),
    ] {
        let folder = temporary();
        ball(folder.path());
        std::fs::write(
            folder.path().join("broken.ply"),
            "ply\nformat binary_little_endian 1.0\nelement vertex 99\n",
        )
        .expect("the folder is ours");
        std::fs::write(folder.path().join("broken.json"), "{}").expect("the folder is ours");
        let text = BALL.replace(good, bad);
        assert!(text.contains(bad), "{bad}");
        let answer = run(folder.path(), &text, &[]);
        assert_eq!(answer.code, Some(2), "{bad}: {}", answer.err);
        assert!(answer.err.contains("bar.toml:") && answer.err.contains(words), "{bad}: {}", answer.err);
        assert!(!folder.path().join("out").exists(), "{bad}");
    }
}
