//! Readers and the writer against files made apart from the crate, against each other, and against wrong files.
#![allow(clippy::unwrap_used)]

use gaussian_deform::file::ply::{self, PlyEncoding};
use gaussian_deform::file::{FileError, read_file, sequence, splat};
use gaussian_deform::{Degree, Splat, Splats, harmonics, shape};
use mechanics_core::tensor::{Mat3, Matrix3, Vec3};
use serde_json::Value;
use std::io::Write;
use std::path::{Path, PathBuf};

fn corpus(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus").join(name)
}

fn numbers(value: &Value) -> Vec<f64> {
    serde_json::from_value(value.clone()).unwrap()
}

/// How far what was read may be from what was encoded: of means, of covariances relative to their size, of opacities, of c₀, of the other coefficients.
struct Tolerance {
    mean: f64,
    covariance: f64,
    opacity: f64,
    constant: f64,
    rest: f64,
}

const FLOATS: Tolerance =
    Tolerance { mean: 2e-7, covariance: 3e-6, opacity: 2e-7, constant: 1e-7, rest: 1e-7 };

fn assert_is_the_truth(name: &str, degree: Degree, tolerance: &Tolerance) {
    let truth: Value = serde_json::from_str(&std::fs::read_to_string(corpus("truth.json")).unwrap()).unwrap();
    let truth = truth[degree.number().to_string()].as_array().unwrap();
    let splats = read_file(corpus(name)).unwrap().cast::<f64>();
    assert_eq!((splats.degree(), splats.count()), (degree, truth.len()), "{name}");
    for (i, expected) in truth.iter().enumerate() {
        let close = |found: &[f64], key: &str, bound: f64| {
            let expected = numbers(&expected[key]);
            let size =
                if key == "covariance" { expected.iter().fold(0.0_f64, |m, x| m.max(x.abs())) } else { 1.0 };
            for (k, (a, b)) in found.iter().zip(&expected).enumerate() {
                assert!((a - b).abs() <= bound * size, "{name}, {i}, {key} {k}: {a} and {b}");
            }
            assert_eq!(found.len(), expected.len());
        };
        close(splats.means()[i].as_slice(), "mean", tolerance.mean);
        close(&splats.covariance(i), "covariance", tolerance.covariance);
        assert!((splats.opacities()[i] - expected["opacity"].as_f64().unwrap()).abs() <= tolerance.opacity);
        close(splats.harmonics_of(i), "harmonics", tolerance.constant.max(tolerance.rest));
        let constants = numbers(&expected["harmonics"]).into_iter().step_by(degree.coefficients());
        for (found, expected) in splats.harmonics_of(i).iter().step_by(degree.coefficients()).zip(constants) {
            assert!((found - expected).abs() <= tolerance.constant, "{name}, {i}: {found} and {expected}");
        }
    }
}

#[test]
fn ply_of_every_degree_order_encoding_and_type() {
    for degree in Degree::ALL {
        for kind in ["little", "big", "shuffled", "ascii"] {
            assert_is_the_truth(&format!("ply/{kind}_{}.ply", degree.number()), degree, &FLOATS);
        }
    }
}

#[test]
fn splat_to_half_a_step_of_its_bytes() {
    let step = 0.5 / 255.0;
    let tolerance =
        Tolerance { mean: 2e-7, covariance: 0.05, opacity: 1.01 * step, constant: 3.6 * step, rest: 0.0 };
    assert_is_the_truth("splat/hand.splat", Degree::Zero, &tolerance);
    // Means and scales are stored as they are, not rounded.
    let bytes = std::fs::read(corpus("splat/hand.splat")).unwrap();
    for (row, axes) in bytes.chunks_exact(32).zip(read_file(corpus("splat/hand.splat")).unwrap().axes()) {
        for k in 0..3 {
            let scale = f32::from_le_bytes(row[12 + 4 * k..16 + 4 * k].try_into().unwrap());
            assert!((axes.column(k).norm() / scale - 1.0).abs() < 3e-7);
        }
    }
}

#[cfg(feature = "spz")]
#[test]
fn spz_of_every_version_and_degree_to_half_a_step() {
    let step = 0.5 / 255.0;
    for degree in Degree::ALL {
        for version in 1..=4 {
            let tolerance = Tolerance {
                mean: if version == 1 { 5e-4 } else { 0.5001 / 4096.0 },
                // Half a step of ln s is 1/32, and rotations have eight to ten bits.
                covariance: 0.12,
                opacity: 1.01 * step,
                constant: 1.01 * step / 0.15,
                rest: 0.5001 / 128.0,
            };
            let name = format!("spz/version{version}_{}.spz", degree.number());
            assert_is_the_truth(&name, degree, &tolerance);
        }
    }
}

/// What follows the last Gaussian, or stands between header and table, is passed over; streams of a length that the header does not tell are read.
#[cfg(feature = "spz")]
#[test]
fn spz_with_extensions_and_compressed_blocks() {
    let file = |name: &str| read_file(corpus(&format!("spz/{name}.spz"))).unwrap();
    for version in [3, 4] {
        assert_eq!(
            file(&format!("version{version}_extended_1")),
            file(&format!("version{version}_1")),
            "version {version}"
        );
    }
    let lattice = file("version4_lattice_1");
    assert_eq!(lattice.count(), 216);
    // Bytes mean the same in versions 3 and 4; what compressed them does not.
    assert_eq!(lattice, file("version3_lattice_1"));
    assert!((lattice.means()[215] - Vec3::repeat(0.5).cast::<f32>()).norm() < 3e-4);
}

/// A change of a file of version 4, byte by byte, and what the complaint says.
#[cfg(feature = "spz")]
#[test]
fn spz_complaints_name_what_is_wrong() {
    use gaussian_deform::file::spz;
    let valid = std::fs::read(corpus("spz/version4_extended_1.spz")).unwrap();
    let changed = |at: usize, value: &[u8]| {
        let mut bytes = valid.clone();
        bytes[at..at + value.len()].copy_from_slice(value);
        spz::read(&bytes).unwrap_err().to_string()
    };
    assert_eq!(spz::read(&valid).unwrap().count(), 6);
    let table = u32::from_le_bytes(valid[16..20].try_into().unwrap()) as usize;
    let cases: [(usize, &[u8], &str); 14] = [
        (0, b"n", "damaged"),
        (4, &[5], "version 5"),
        (4, &[3], "version 3"),
        (8, &[7], "54 bytes"),
        (8, &[255; 4], "4294967295 Gaussians"),
        (12, &[4], "degree 4"),
        (13, &[24], "24 fractional bits"),
        (15, &[5], "5 streams"),
        (16, &[31], "byte 31"),
        (16, &[255; 4], "byte 4294967295"),
        (32, &[1, 0], "0xADBE0001"),
        (36, &[255; 4], "extension 0xADBE0002"),
        (table, &[255; 8], "6 Gaussians"),
        (table + 6 * 16, &[0; 4], "damaged"),
    ];
    for (at, value, expected) in cases {
        let error = changed(at, value);
        assert!(error.contains(expected), "{at}: {error}");
    }
    for length in 0..valid.len() {
        spz::read(&valid[..length]).unwrap_err();
    }
    // A stream that holds less than, or more than, its row says.
    for other in [0, 2] {
        let file = std::fs::read(corpus(&format!("spz/version4_{other}.spz"))).unwrap();
        let mut mixed = valid.clone();
        let opacities = |bytes: &[u8], table: usize| {
            let length = |k: usize| {
                u64::from_le_bytes(bytes[table + 16 * k..table + 16 * k + 8].try_into().unwrap()) as usize
            };
            (length(0), length(1), length(2))
        };
        let (means, _, colours) = opacities(&file, 32);
        let streams = 32 + 16 * usize::from(file[15]);
        let (ours, alpha, _) = opacities(&valid, table);
        // The stream of opacities becomes one of colours or of means.
        let (start, length) =
            if other == 0 { (streams, means) } else { (streams + means + opacities(&file, 32).1, colours) };
        let place = table + 6 * 16 + ours;
        mixed.splice(place..place + alpha, file[start..start + length].iter().copied());
        mixed[table + 16..table + 24].copy_from_slice(&(length as u64).to_le_bytes());
        let error = spz::read(&mixed).unwrap_err();
        assert!(matches!(error, FileError::Truncated { claimed: 6, .. }), "{error}");
    }
}

fn deformed_scene(degree: Degree) -> Splats<f32> {
    let mut state = 1_u64;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / (1_u64 << 30) as f64 - 1.0
    };
    let mut splats = Splats::<f64>::new(degree);
    for k in 0..40 {
        let axes = Mat3::from_fn(|_, _| next()) * Mat3::from_diagonal(&Vec3::new(1.0, 0.1, 0.01)) * next();
        let coefficients: Vec<f64> = (0..degree.stride()).map(|_| next()).collect();
        let mean = Vec3::from_fn(|_, _| next());
        splats.push(Splat { mean, axes, opacity: f64::from(k) / 39.0, harmonics: &coefficients });
    }
    splats.cast()
}

fn written(splats: &Splats<f32>, encoding: PlyEncoding) -> Vec<u8> {
    let mut bytes = Vec::new();
    ply::write(splats, encoding, &mut bytes).unwrap();
    bytes
}

const ENCODINGS: [PlyEncoding; 3] =
    [PlyEncoding::Ascii, PlyEncoding::BinaryLittleEndian, PlyEncoding::BinaryBigEndian];

#[test]
fn what_is_written_is_read_again() {
    for degree in Degree::ALL {
        let scene = deformed_scene(degree);
        let wide = scene.cast::<f64>();
        for encoding in ENCODINGS {
            let again = ply::read(&written(&scene, encoding)).unwrap();
            assert_eq!(again.means(), scene.means());
            assert_eq!(again.harmonics(), scene.harmonics());
            let again = again.cast::<f64>();
            for i in 0..scene.count() {
                assert!((again.opacities()[i] - wide.opacities()[i]).abs() < 2e-7);
                let (a, b) = (again.covariance(i), wide.covariance(i));
                let size = b.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
                assert!((0..6).all(|k| (a[k] - b[k]).abs() < 5e-6 * size), "{degree:?} {i}: {a:?} {b:?}");
                let r = again.axes()[i];
                assert!(r.determinant() > 0.0, "a mirrored Gaussian was written with a mirror");
            }
        }
    }
}

/// Singular values of the half-axes keep thickness that eigenvalues of the covariance would lose in `f32`.
#[test]
fn thin_gaussians_are_written_as_thin() {
    let r = shape::axes([1.0_f64; 3], [0.3, -0.5, 0.2, 0.7]).unwrap();
    let sheared = Mat3::new(1.0, 0.7, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
    for thickness in [1e-2, 1e-3, 1e-4, 1e-5] {
        let mut splats = Splats::<f64>::new(Degree::Zero);
        let axes = r * Mat3::from_diagonal(&Vec3::new(1.0, 1.0, thickness)) * sheared;
        splats.push(Splat { mean: Vec3::zeros(), axes, opacity: 0.5, harmonics: &[0.0; 3] });
        let again = ply::read(&written(&splats.cast(), PlyEncoding::BinaryLittleEndian)).unwrap();
        let (scales, _) = shape::scales_and_quaternion(&again.axes()[0]);
        let smallest = f64::from(scales.into_iter().fold(f32::MAX, f32::min));
        let exact = axes.singular_values()[2];
        assert!((smallest / exact - 1.0).abs() < 1e-6 + 4e-7 / thickness, "{smallest:e} {exact:e}");
    }
}

#[test]
fn shapes_and_quaternions_go_both_ways() {
    let quaternions = [
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, -1.0, 0.0],
        [0.0, 0.0, 0.0, 1.0],
        [1e-9, 1.0, 1.0, 1.0],
        [0.5, -0.5, 0.5, 0.5],
        [-3.0, 1.0, 2.0, -0.1],
        [1e-200, 2e-200, 0.0, 1e-200],
        [1e200, 2e200, 0.0, -1e200],
    ];
    for q in quaternions {
        let scales = [0.1, 2.0, 1e-6];
        let axes: Mat3 = shape::axes(scales, q).unwrap();
        let (s, found) = shape::scales_and_quaternion(&axes);
        let size = q.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let norm = q.iter().map(|x| (x / size).powi(2)).sum::<f64>().sqrt() * size;
        let dot: f64 = found.iter().zip(q).map(|(a, b)| a * (b / norm)).sum();
        assert!((dot.abs() - 1.0).abs() < 1e-14, "{q:?} {found:?}");
        assert!(found[0] >= 0.0);
        assert!((0..3).all(|k| (s[k] / scales[k] - 1.0).abs() < 1e-14), "{s:?}");
    }
    let bad = [[0.0; 4], [f64::NAN, 0.0, 0.0, 1.0], [f64::INFINITY, 0.0, 0.0, 0.0]];
    assert!(bad.iter().all(|&q| shape::axes([1.0; 3], q).is_none()));
}

#[test]
fn orientations_are_written_as_rotated_coefficients() {
    let mut scene = deformed_scene(Degree::Three);
    let turn: Matrix3<f32> = shape::axes([1.0; 3], [0.3, -0.5, 0.2, 0.7]).unwrap();
    scene.orientations_mut().fill(turn);
    let again = ply::read(&written(&scene, PlyEncoding::BinaryLittleEndian)).unwrap();
    harmonics::settle_orientations(&mut scene);
    assert_eq!(again.harmonics(), scene.harmonics());
}

#[test]
fn extreme_but_legal_numbers_are_written() {
    let mut splats = Splats::<f64>::new(Degree::Zero);
    for (opacity, axes) in [
        (0.0, Mat3::zeros()),
        (1.0, Mat3::identity() * 1e-300),
        (1e-30, Mat3::identity() * 1e13),
        (1.0 - 1e-12, Mat3::from_diagonal(&Vec3::new(1.0, 0.0, 0.0))),
        (0.5, Mat3::from_diagonal(&Vec3::new(1.0, -2.0, 3.0))),
    ] {
        splats.push(Splat { mean: Vec3::zeros(), axes, opacity, harmonics: &[0.0; 3] });
    }
    let mut bytes = Vec::new();
    ply::write(&splats, PlyEncoding::Ascii, &mut bytes).unwrap();
    let again = ply::read(&bytes).unwrap();
    assert_eq!([0, 1, 3].map(|i| again.opacities()[i]), [0.0, 1.0, 1.0]);
    assert!((again.axes()[2].norm() / (1e13 * 3.0_f32.sqrt()) - 1.0).abs() < 1e-5);
    splats.axes_mut()[3][(0, 1)] = 1e30;
    let error = ply::write(&splats, PlyEncoding::Ascii, &mut Vec::new()).unwrap_err();
    assert!(matches!(error, FileError::BadValue { splat: 3, .. }), "{error}");
}

/// A file of one Gaussian of degree 0 as text, changed.
fn text(from: &str, to: &str) -> String {
    let names =
        ["x", "y", "z", "opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"];
    let mut text = "ply\nformat ascii 1.0\nelement vertex 1\n".to_string();
    for name in names.iter().chain(&["f_dc_0", "f_dc_1", "f_dc_2"]) {
        text += &format!("property float {name}\n");
    }
    text += "end_header\n0.5 1.5 2.5 0 -1 -2 -3 1 0 0 0 0.1 0.2 0.3\n";
    assert!(text.contains(from));
    text.replacen(from, to, 1)
}

#[test]
fn complaints_name_what_is_wrong() {
    assert_eq!(ply::read(text("ply", "ply").as_bytes()).unwrap().count(), 1);
    let rest = |count: usize| {
        (0..count).map(|k| format!("property float f_rest_{k}\n")).collect::<String>() + "end_header"
    };
    let cases: [(&str, String, &str); 22] = [
        ("ply\n", "plx\n".into(), "line 1"),
        ("format ascii 1.0\n", String::new(), "format"),
        ("format ascii 1.0", "format ascii 2.0".into(), "line 2"),
        ("ascii", "utf8".into(), "binary_little_endian"),
        ("element vertex 1", "element vertex -1".into(), "number of rows"),
        ("element vertex 1", "element vertex 18446744073709551615".into(), "18446744073709551615"),
        ("element vertex 1", "element vertex 2".into(), "2 Gaussians"),
        ("element vertex", "element points".into(), "property x"),
        ("element vertex 1", "element vertex 1\nelement vertex 1".into(), "twice"),
        ("property float x", "property float x\nproperty float x".into(), "property x is declared twice"),
        ("property float scale_1\n", String::new(), "scale_1"),
        ("property float rot_3\n", "property quad rot_3\n".into(), "quad"),
        ("property float rot_3\n", "property list uchar int rot_3\n".into(), "list"),
        ("end_header", rest(72), "degree 4"),
        ("end_header", rest(10), "10 properties"),
        ("end_header\n", String::new(), "a line of a PLY header"),
        ("0.5 1.5", "nan 1.5".into(), "vertex 0: x"),
        ("0.5 1.5", "0.5 inf".into(), "vertex 0: y"),
        ("0.5 1.5", "0.5 many".into(), "many"),
        ("0 -1 -2", "0 -1 90".into(), "scale_1"),
        (" 1 0 0 0 ", " 0 0 0 0 ".into(), "quaternion"),
        ("0.2 0.3", "0.2 1e30".into(), "f_dc_2"),
    ];
    for (from, to, expected) in cases {
        let error = ply::read(text(from, &to).as_bytes()).unwrap_err().to_string();
        assert!(error.contains(expected), "{from:?} → {to:?}: {error}");
    }
    let error = splat::read(&[0; 33]).unwrap_err().to_string();
    assert!(error.contains("33 bytes"), "{error}");
    let error = splat::read(&[0xff; 32]).unwrap_err().to_string();
    assert!(error.contains("coordinate 0"), "{error}");
    for (scale, expected) in
        [(f32::INFINITY, "scale_1 is inf"), (-1.0, "scale_1 is -1;"), (2e15, "scale_1 is 2000")]
    {
        let mut bytes = [1_u8; 32];
        bytes[16..20].copy_from_slice(&scale.to_le_bytes());
        let error = splat::read(&bytes).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    let mut bytes = [1_u8; 32];
    bytes[28..].fill(128);
    let error = splat::read(&bytes).unwrap_err().to_string();
    assert!(error.contains("vertex 0: rotation") && error.contains("not zero"), "{error}");
}

#[test]
fn files_are_named() {
    for (name, expected) in [("nowhere.ply", "cannot read"), ("scene.obj", ".spz"), ("truth", ".ply")] {
        let error = read_file(corpus(name)).unwrap_err().to_string();
        assert!(error.contains(name) && error.contains(expected), "{error}");
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("broken.PLY");
    std::fs::write(&path, text("0.5 1.5", "0.5 nan")).unwrap();
    let error = read_file(&path).unwrap_err().to_string();
    assert!(error.contains("broken.PLY") && error.contains("vertex 0: y"), "{error}");
}

#[test]
fn sequences_are_numbered_and_appear_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path().join("frames");
    let mut scene = deformed_scene(Degree::One);
    for number in [1, 2, 10_000] {
        sequence::write_frame(&scene, &folder, number).unwrap();
    }
    let before = std::fs::read(sequence::frame_path(&folder, 2)).unwrap();
    scene.opacities_mut()[3] = f32::NAN;
    let error = sequence::write_frame(&scene, &folder, 2).unwrap_err();
    assert!(matches!(error, FileError::BadValue { splat: 3, .. }));
    assert_eq!(std::fs::read(sequence::frame_path(&folder, 2)).unwrap(), before);
    let mut names: Vec<String> = std::fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names, ["frame_0001.ply", "frame_0002.ply", "frame_10000.ply"]);
}

/// Says it past the test harness, which shows what a test prints only if it fails: the gate counts these lines.
fn skipped(reason: &str) {
    std::io::stderr().write_all(format!("\nSKIPPED ({reason})\n").as_bytes()).unwrap();
}

/// Captures of SPLAT_SCENES_DIR, which are not part of the repository.
#[test]
fn real_captures_are_read_and_written() {
    let Some(folder) = std::env::var_os("SPLAT_SCENES_DIR") else {
        skipped("SPLAT_SCENES_DIR is not set");
        return;
    };
    let known = [
        ("plant.ply", 113_648, Degree::Zero),
        ("academic_tarot_cards.splat", 114_865, Degree::Zero),
        ("playbot_31k_sh2.ply", 31_000, Degree::Two),
    ];
    for (name, count, degree) in known {
        let path = Path::new(&folder).join(name);
        if !path.exists() {
            skipped(&format!("{} is not there", path.display()));
            continue;
        }
        let scene = read_file(&path).unwrap();
        assert_eq!((scene.count(), scene.degree()), (count, degree), "{name}");
        scene.check().unwrap();
        let again = ply::read(&written(&scene, PlyEncoding::BinaryLittleEndian)).unwrap();
        assert_eq!(again.means(), scene.means());
        assert_eq!(again.harmonics(), scene.harmonics());
        for i in 0..count {
            let (a, b) = (again.covariance(i), scene.covariance(i));
            let size = b.iter().fold(0.0_f32, |m, x| m.max(x.abs()));
            assert!((0..6).all(|k| (a[k] - b[k]).abs() <= 2e-5 * size), "{name} {i}");
        }
    }
}
