//! Transport against high-precision values, closed forms and itself.
#![allow(clippy::unwrap_used)]

#[path = "matter/random.rs"]
mod random;

use gaussian_deform::transport::{
    self, Colours, Transport, TransportReport, advance_axes, advance_covariance, advance_gradients,
};
use gaussian_deform::{Degree, Splat, SplatError, Splats, harmonics};
use mechanics_core::decomposition::polar;
use mechanics_core::lanes::Element;
use mechanics_core::parallel;
use mechanics_core::samples::DeformationSamples;
use mechanics_core::tensor::{Mat3, Matrix3, Vec3, from_entries, vector};
use random::Random;
use serde_json::Value;

fn matrix(value: &Value) -> Mat3 {
    let rows: Vec<[f64; 3]> = serde_json::from_value(value.clone()).unwrap();
    Mat3::from_fn(|i, j| rows[i][j])
}

fn upper(value: &Value) -> [f64; 6] {
    serde_json::from_value(value.clone()).unwrap()
}

fn scene<E: Element>(degree: Degree, count: usize) -> Splats<E> {
    let mut random = Random(7);
    let mut splats = Splats::new(degree);
    for _ in 0..count {
        let harmonics: Vec<E> = (0..degree.stride()).map(|_| E::constant(random.next())).collect();
        let axes = random.matrix() * 0.1;
        let mean = random.vector();
        splats.push(Splat {
            mean: vector([E::constant(mean.x), E::constant(mean.y), E::constant(mean.z)]),
            axes: from_entries(|i, j| E::constant(axes[(i, j)])),
            opacity: E::constant(0.5 + 0.5 * random.next()),
            harmonics: &harmonics,
        });
    }
    splats
}

#[test]
fn rotations_of_twenty_six_hard_gradients() {
    let fixture: Value = serde_json::from_str(include_str!("fixtures/polar.json")).unwrap();
    let cases = fixture["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 26);
    for case in cases {
        let (name, f) = (&case["name"], matrix(&case["F"]));
        let r = transport::rotation(&f);
        assert!((r.transpose() * r - Mat3::identity()).norm() < 1e-14, "{name} is not orthogonal");
        assert!((r.determinant() - 1.0).abs() < 1e-14, "{name} is no rotation");
        let s = r.transpose() * f;
        assert!((s - s.transpose()).norm() <= 1e-14 * f.norm(), "{name}: the stretch is not symmetric");
        if case["rotation_unique"].as_bool().unwrap() {
            let sigma: [f64; 3] = serde_json::from_value(case["singular_values"].clone()).unwrap();
            let condition = (sigma[0] / case["sigma2_plus_signed_sigma3"].as_f64().unwrap()).max(1.0);
            let error = (r - matrix(&case["R"])).norm();
            assert!(error <= 2e-15 * condition, "{name}: {error:e} for the condition {condition:e}");
        }
    }
}

/// Both ways to the rotation, and the border between them.
fn sweep_rotations<E: Element>(tolerance: f64) {
    let mut random = Random(11);
    for case in 0..20_000 {
        let spread = 0.1_f64.powf(4.0 * random.next().abs());
        let f = random.matrix() * Mat3::from_diagonal(&Vec3::new(1.0, 1.0, spread)) * random.matrix();
        let narrow = from_entries(|i, j| E::constant(f[(i, j)]));
        let wide: Mat3 = from_entries(|i, j| narrow[(i, j)].into());
        let r = transport::rotation::<E>(&narrow);
        let r: Mat3 = from_entries(|i, j| r[(i, j)].into());
        let exact = polar(&wide);
        let eigen = exact.stretch.symmetric_eigenvalues();
        let mut sigma: [f64; 3] = eigen.into();
        sigma.sort_by(|a, b| b.abs().total_cmp(&a.abs()));
        let condition = (sigma[0] / (sigma[1] + sigma[2])).max(1.0);
        let error = (r - exact.rotation).norm();
        assert!(error < tolerance * condition, "case {case}: {error:e} at condition {condition:e}");
    }
}

#[test]
fn rotations_agree_with_the_singular_values_in_double_precision() {
    sweep_rotations::<f64>(4e-15);
}

#[test]
fn rotations_agree_with_the_singular_values_in_single_precision() {
    sweep_rotations::<f32>(2e-6);
}

#[test]
fn covariances_of_ten_shapes_under_twelve_gradients() {
    let fixture: Value = serde_json::from_str(include_str!("fixtures/covariance.json")).unwrap();
    for case in fixture["cases"].as_array().unwrap() {
        let scale: [f64; 3] = serde_json::from_value(case["scale"].clone()).unwrap();
        let quaternion: [f64; 4] = serde_json::from_value(case["quat_wxyz_unnormalised"].clone()).unwrap();
        let axes = gaussian_deform::shape::axes(scale, quaternion).unwrap();
        let sigma = upper(&case["sigma_upper6"]);
        let size = |a: &[f64; 6]| a.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let rest = gaussian_deform::splats::covariance(&axes);
        assert!((0..6).all(|k| (rest[k] - sigma[k]).abs() <= 4e-15 * size(&sigma)), "{}", case["name"]);
        for moved in case["transformed"].as_array().unwrap() {
            let f = matrix(&moved["F"]);
            let mut splats = Splats::new(Degree::Zero);
            splats.push(Splat { mean: Vec3::zeros(), axes, opacity: 1.0, harmonics: &[0.0; 3] });
            let mut transport = Transport::new(splats, vec![0], Colours::RotateCoefficients).unwrap();
            transport.deform(DeformationSamples::new(&[Vec3::zeros()], &[f])).unwrap();
            let (found, expected) = (transport.frame().covariance(0), upper(&moved["FSFt_upper6"]));
            let bound = 1e-14 * f.norm_squared() * size(&sigma);
            let error = (0..6).map(|k| (found[k] - expected[k]).abs()).fold(0.0, f64::max);
            assert!(error <= bound, "{} {}: {error:e} of {bound:e}", case["name"], moved["F_name"]);
        }
    }
}

#[test]
fn increments_are_those_of_the_reference() {
    let fixture: Value = serde_json::from_str(include_str!("fixtures/covariance.json")).unwrap();
    let case = &fixture["constant_velocity_gradient"];
    let gradient = matrix(&case["grad_v"]);
    let [xx, xy, xz, yy, yz, zz] = upper(&case["sigma0_upper6"]);
    let start = Mat3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    let exact = upper(&case["exact_T=1_upper6"]);
    let mut errors = Vec::new();
    for run in case["runs"].as_array().unwrap() {
        let (step, steps) = (run["dt"].as_f64().unwrap(), run["steps"].as_u64().unwrap());
        let mut covariance = [xx, xy, xz, yy, yz, zz];
        let mut axes = start.cholesky().unwrap().l();
        for _ in 0..steps {
            covariance = advance_covariance(covariance, &gradient, step);
            axes = advance_axes(&axes, &gradient, step);
        }
        let product = gaussian_deform::splats::covariance(&axes);
        let distance = |a: [f64; 6], b: [f64; 6]| (0..6).map(|k| (a[k] - b[k]).abs()).fold(0.0, f64::max);
        assert!(distance(covariance, upper(&run["incremental_upper6"])) < 1e-13);
        assert!(distance(product, upper(&run["F_S_Ft_upper6"])) < 1e-13);
        errors.push(distance(product, exact) / step);
    }
    // First order: the error over the step tends to a constant.
    let [coarse, fine] = [errors[0], errors[errors.len() - 1]];
    assert!((coarse / fine - 1.0).abs() < 0.1, "{coarse} {fine}");
}

/// Total gradients from velocity gradients, lent to a transport: the reference's shapes, and the rotation of the whole motion, which the product of the steps' rotations is not.
#[test]
fn accumulated_increments_carry_shapes_and_colours() {
    let fixture: Value = serde_json::from_str(include_str!("fixtures/covariance.json")).unwrap();
    let case = &fixture["constant_velocity_gradient"];
    let rate = matrix(&case["grad_v"]);
    let [xx, xy, xz, yy, yz, zz] = upper(&case["sigma0_upper6"]);
    let axes = Mat3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz).cholesky().unwrap().l();
    let count = 5_000;
    let mut rest = Splats::<f64>::new(Degree::One);
    let coefficients: Vec<f64> = (0..12).map(|k| f64::from(k).cos()).collect();
    for _ in 0..count {
        rest.push(Splat { mean: Vec3::zeros(), axes, opacity: 0.5, harmonics: &coefficients });
    }
    let mut transport =
        Transport::new(rest, (0..count as u32).collect(), Colours::RotateCoefficients).unwrap();
    let run = &case["runs"][0];
    let (step, steps) = (run["dt"].as_f64().unwrap(), run["steps"].as_u64().unwrap());
    let (mut gradients, rates) = (vec![Mat3::identity(); count], vec![rate; count]);
    let mut product = Mat3::identity();
    for _ in 0..steps {
        advance_gradients(&mut gradients, &rates, step);
        product = polar(&(Mat3::identity() + rate * step)).rotation * product;
    }
    transport.deform(DeformationSamples::new(&vec![Vec3::zeros(); count], &gradients)).unwrap();
    let rotation = polar(&gradients[0]).rotation;
    assert!((rotation - product).norm() > 1e-3, "this motion does not tell them apart");
    let mut expected = coefficients;
    harmonics::rotate(Degree::One, &rotation, &mut expected);
    for i in [0, count - 1] {
        let (found, shape) = (transport.frame().covariance(i), upper(&run["F_S_Ft_upper6"]));
        assert!((0..6).all(|k| (found[k] - shape[k]).abs() < 1e-13), "{found:?}");
        let colours = transport.frame().harmonics_of(i).iter().zip(&expected);
        assert!(colours.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs())) < 1e-14);
    }
}

/// A motion of every Gaussian of a scene by one map x = F X + c.
fn affine<E: Element>(scene: &Splats<E>, matter: &[u32], f: &Mat3, c: &Vec3) -> (Vec<Vec3>, Vec<Mat3>) {
    let mean = |i: u32| {
        let m = &scene.means()[i as usize];
        f * Vec3::new(m[0].into(), m[1].into(), m[2].into()) + c
    };
    (matter.iter().map(|&i| mean(i)).collect(), vec![*f; matter.len()])
}

#[test]
fn a_rigid_motion_turns_everything_and_nothing_else_moves() {
    let r = transport::rotation(&Random(3).matrix());
    let shift = Vec3::new(1.0, -2.0, 0.5);
    for degree in Degree::ALL {
        let rest = scene::<f64>(degree, 5_003);
        let matter: Vec<u32> = (0..5_003).filter(|i| i % 3 != 1).collect();
        let (positions, gradients) = affine(&rest, &matter, &r, &shift);
        let mut transport =
            Transport::new(rest.clone(), matter.clone(), Colours::RotateCoefficients).unwrap();
        let report = transport.deform(DeformationSamples::new(&positions, &gradients)).unwrap();
        assert_eq!(report, TransportReport { inverted: 0 });
        let frame = transport.frame();
        assert!(frame.orientations().is_none());
        for i in 0..rest.count() {
            if matter.binary_search(&(i as u32)).is_err() {
                assert_eq!(frame.splat(i), rest.splat(i));
                continue;
            }
            assert!((frame.means()[i] - (r * rest.means()[i] + shift)).norm() < 1e-15);
            assert!((frame.axes()[i] - r * rest.axes()[i]).norm() < 1e-15);
            let d = Vec3::new(0.36, -0.48, 0.8);
            let before = harmonics::colour(degree, rest.harmonics_of(i), (r.transpose() * d).into());
            let after = harmonics::colour(degree, frame.harmonics_of(i), d.into());
            assert!((0..3).all(|c| (before[c] - after[c]).abs() < 2e-14));
        }
    }
}

#[test]
fn turned_directions_show_what_rotated_coefficients_show() {
    let mut random = Random(5);
    for degree in [Degree::One, Degree::Two, Degree::Three] {
        let rest = scene::<f64>(degree, 50);
        let matter: Vec<u32> = (0..50).collect();
        let positions: Vec<Vec3> = (0..50).map(|_| random.vector()).collect();
        let gradients: Vec<Mat3> = (0..50).map(|_| random.matrix()).collect();
        let samples = DeformationSamples::new(&positions, &gradients);
        let [rotated, turned] = [Colours::RotateCoefficients, Colours::TurnDirections].map(|colours| {
            let mut transport = Transport::new(rest.clone(), matter.clone(), colours).unwrap();
            transport.deform(samples).unwrap();
            transport.frame().clone()
        });
        assert_eq!(turned.harmonics(), rest.harmonics());
        let mut settled = turned.clone();
        harmonics::settle_orientations(&mut settled);
        let orientations = turned.orientations().unwrap();
        for i in 0..50 {
            let d = random.vector().normalize();
            let by_direction =
                harmonics::colour(degree, turned.harmonics_of(i), (orientations[i].transpose() * d).into());
            let by_coefficients = harmonics::colour(degree, rotated.harmonics_of(i), d.into());
            let unrotated = harmonics::colour(degree, rest.harmonics_of(i), d.into());
            assert!((0..3).all(|c| (by_direction[c] - by_coefficients[c]).abs() < 1e-14));
            assert!((0..3).any(|c| (unrotated[c] - by_coefficients[c]).abs() > 1e-3));
            assert_eq!(settled.harmonics_of(i), rotated.harmonics_of(i));
        }
    }
}

#[test]
fn single_precision_follows_double() {
    let wide = scene::<f32>(Degree::Three, 1_000).cast::<f64>();
    let matter: Vec<u32> = (0..1_000).collect();
    let f = Mat3::new(1.3, 0.2, -0.1, 0.0, 0.8, 0.3, 0.1, 0.0, 1.1);
    let (positions, gradients) = affine(&wide, &matter, &f, &Vec3::x());
    let samples = DeformationSamples::new(&positions, &gradients);
    let mut exact = Transport::new(wide.clone(), matter.clone(), Colours::RotateCoefficients).unwrap();
    let mut narrow = Transport::new(wide.cast::<f32>(), matter, Colours::RotateCoefficients).unwrap();
    exact.deform(samples).unwrap();
    narrow.deform(samples).unwrap();
    let (exact, narrow) = (exact.frame(), narrow.frame().cast::<f64>());
    for i in 0..1_000 {
        assert!((exact.means()[i] - narrow.means()[i]).norm() < 3e-7);
        assert!((exact.axes()[i] - narrow.axes()[i]).norm() < 1e-7);
        let worst = exact.harmonics_of(i).iter().zip(narrow.harmonics_of(i)).map(|(a, b)| (a - b).abs());
        assert!(worst.fold(0.0, f64::max) < 5e-6);
    }
}

/// A disc 1e-5 as thick as wide, stretched: stored as a covariance in f32 its thickness would be noise.
#[test]
fn thin_discs_keep_their_thickness_in_single_precision() {
    let r = transport::rotation(&Random(9).matrix());
    let axes = r * Mat3::from_diagonal(&Vec3::new(1.0, 1.0, 1e-5));
    let mut splats = Splats::<f32>::new(Degree::Zero);
    let axes = from_entries(|i, j| axes[(i, j)] as f32);
    splats.push(Splat { mean: Default::default(), axes, opacity: 1.0, harmonics: &[0.0; 3] });
    let mut transport = Transport::new(splats, vec![0], Colours::RotateCoefficients).unwrap();
    transport.deform(DeformationSamples::new(&[Vec3::zeros()], &[r * 2.0])).unwrap();
    let moved: Mat3 = from_entries(|i, j| f64::from(transport.frame().axes()[0][(i, j)]));
    let thickness = moved.singular_values()[2];
    assert!((thickness / 2e-5 - 1.0).abs() < 0.02, "{thickness:e}");
}

#[test]
fn degenerate_gradients_give_numbers() {
    let hard = [
        Mat3::zeros(),
        Mat3::from_diagonal(&Vec3::new(1.0, 0.0, 0.0)),
        Mat3::from_diagonal(&Vec3::new(1.0, 1.0, 0.0)),
        Mat3::from_diagonal(&Vec3::new(-1.0, 1.0, 1.0)),
        -Mat3::identity(),
        Mat3::repeat(1.0),
        Mat3::identity() * 1e14,
        Mat3::identity() * 1e-30,
        Mat3::identity() * 1e-44,
        Mat3::from_diagonal(&Vec3::new(1e10, 1.0, 1e-10)),
        Mat3::from_diagonal(&Vec3::new(1e10, -1e-10, 1e-30)),
    ];
    let matter: Vec<u32> = (0..hard.len() as u32).collect();
    let positions = vec![Vec3::zeros(); hard.len()];
    for colours in [Colours::RotateCoefficients, Colours::TurnDirections] {
        let mut transport =
            Transport::new(scene::<f32>(Degree::Three, hard.len()), matter.clone(), colours).unwrap();
        let report = transport.deform(DeformationSamples::new(&positions, &hard)).unwrap();
        assert_eq!(report.inverted, 3);
        transport.frame().check().unwrap();
        for r in transport.frame().orientations().unwrap_or_default() {
            assert!((r.transpose() * r - Matrix3::identity()).norm() < 2e-6);
        }
    }
}

#[test]
fn what_cannot_be_computed_with_is_refused_and_changes_nothing() {
    let matter: Vec<u32> = (0..10).collect();
    let rest = scene::<f32>(Degree::Two, 10);
    let mut transport = Transport::new(rest.clone(), matter, Colours::RotateCoefficients).unwrap();
    for bad in [f64::NAN, f64::INFINITY, -f64::INFINITY, 1e16] {
        for in_position in [false, true] {
            let (mut positions, mut gradients) = (vec![Vec3::zeros(); 10], vec![Mat3::identity() * 2.0; 10]);
            if in_position {
                positions[4].y = bad;
            } else {
                gradients[4][(1, 2)] = bad;
            }
            let error = transport.deform(DeformationSamples::new(&positions, &gradients)).unwrap_err();
            assert!(matches!(error, SplatError::BadSample { sample: 4, value, .. }
                if value.to_bits() == bad.to_bits()));
            assert_eq!(transport.frame(), &rest);
        }
    }
    let (positions, gradients) = (vec![Vec3::zeros(); 9], vec![Mat3::identity(); 9]);
    let error = transport.deform(DeformationSamples::new(&positions, &gradients)).unwrap_err();
    assert_eq!(error, SplatError::SampleCount { samples: 9, matter: 10 });
    for list in [vec![3, 3], vec![3, 2], vec![0, 10]] {
        let error = Transport::new(rest.clone(), list, Colours::RotateCoefficients).unwrap_err();
        assert!(matches!(error, SplatError::BadSelection { entry: 1, .. }));
    }
}

#[test]
fn the_bits_do_not_depend_on_threads_or_neighbours() {
    let rest = scene::<f32>(Degree::Three, 9_000);
    let mut random = Random(1);
    let matter: Vec<u32> = (0..9_000).filter(|i| i % 7 != 2).collect();
    let positions: Vec<Vec3> = matter.iter().map(|_| random.vector()).collect();
    let gradients: Vec<Mat3> = matter.iter().map(|_| random.matrix() + Mat3::identity()).collect();
    let run = |threads: usize| {
        parallel::with_threads(threads, || {
            let mut transport =
                Transport::new(rest.clone(), matter.clone(), Colours::RotateCoefficients).unwrap();
            transport.deform(DeformationSamples::new(&positions, &gradients)).unwrap();
            transport.frame().clone()
        })
    };
    let one = run(1);
    for threads in [2, 3, 8] {
        assert_eq!(run(threads), one);
    }
    // Every fifth alone: other neighbours in its packet.
    let few: Vec<usize> = (0..matter.len()).step_by(5).collect();
    let list = few.iter().map(|&k| matter[k]).collect();
    let mut transport = Transport::new(rest.clone(), list, Colours::RotateCoefficients).unwrap();
    let (positions, gradients): (Vec<Vec3>, Vec<Mat3>) =
        few.iter().map(|&k| (positions[k], gradients[k])).unzip();
    transport.deform(DeformationSamples::new(&positions, &gradients)).unwrap();
    for &k in &few {
        let i = matter[k] as usize;
        assert_eq!(transport.frame().splat(i), one.splat(i));
    }
}
