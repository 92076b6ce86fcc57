//! Harmonics and their rotation against values of 50 digits and against each other.
#![allow(clippy::unwrap_used)]

use gaussian_deform::{Degree, Splats, harmonics};
use mechanics_core::lanes::Element;
use mechanics_core::tensor::{Mat3, Matrix3, Vec3, from_entries};
use serde_json::Value;

fn fixture() -> Value {
    serde_json::from_str(include_str!("fixtures/sh_rotation.json")).unwrap()
}

fn rows<const N: usize>(value: &Value) -> Vec<[f64; N]> {
    serde_json::from_value::<Vec<Vec<f64>>>(value.clone())
        .unwrap()
        .into_iter()
        .map(|row| row.try_into().unwrap())
        .collect()
}

fn matrix(value: &Value) -> Mat3 {
    let rows = rows::<3>(value);
    Mat3::from_fn(|i, j| rows[i][j])
}

/// Coefficients by k and channel to those by channel and k.
fn channel_major(by_coefficient: &[[f64; 3]]) -> Vec<f64> {
    (0..3).flat_map(|c| by_coefficient.iter().map(move |rgb| rgb[c])).collect()
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn the_basis_is_the_trained_scenes() {
    let fixture = fixture();
    let values = rows::<16>(&fixture["basis_at_dirs"]);
    for (direction, expected) in rows::<3>(&fixture["dirs"]).iter().zip(values) {
        let basis = harmonics::basis(Degree::Three, *direction);
        assert!(largest_difference(&basis, &expected) < 2e-15);
    }
}

#[test]
fn colours_are_one_half_more_than_the_sum() {
    let fixture = fixture();
    let coefficients = channel_major(&rows::<3>(&fixture["coef"]));
    let sums = rows::<3>(&fixture["eval_at_dirs_no_half"]);
    for (direction, sum) in rows::<3>(&fixture["dirs"]).iter().zip(sums) {
        let colour = harmonics::colour(Degree::Three, &coefficients, *direction);
        assert!(largest_difference(&colour, &sum.map(|s| s + 0.5)) < 4e-15);
    }
}

#[test]
fn sixteen_rotations_to_twelve_digits() {
    let fixture = fixture();
    let coefficients = channel_major(&rows::<3>(&fixture["coef"]));
    let cases = fixture["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 16);
    for case in cases {
        let mut rotated = coefficients.clone();
        harmonics::rotate(Degree::Three, &matrix(&case["R_row_major"]), &mut rotated);
        let expected = channel_major(&rows::<3>(&case["coef_rotated"]));
        let error = largest_difference(&rotated, &expected);
        assert!(error < 1e-14, "{}: {error:e}", case["name"]);
    }
}

#[test]
fn rotated_coefficients_are_the_turned_direction() {
    let fixture = fixture();
    let coefficients = channel_major(&rows::<3>(&fixture["coef"]));
    for case in fixture["cases"].as_array().unwrap() {
        let r = matrix(&case["R_row_major"]);
        for degree in Degree::ALL {
            let n = degree.coefficients();
            let part: Vec<f64> = coefficients.chunks(16).flat_map(|channel| channel[..n].to_vec()).collect();
            let mut rotated = part.clone();
            harmonics::rotate(degree, &r, &mut rotated);
            for direction in rows::<3>(&fixture["dirs"]) {
                let turned = r.transpose() * Vec3::from(direction);
                let by_direction = harmonics::colour(degree, &part, turned.into());
                let by_coefficients = harmonics::colour(degree, &rotated, direction);
                let error = largest_difference(&by_direction, &by_coefficients);
                assert!(error < 1e-14, "{} degree {degree:?}: {error:e}", case["name"]);
            }
        }
    }
}

fn turned_scene<E: Element>(degree: Degree, count: usize) -> Splats<E> {
    let fixture = fixture();
    let cases = fixture["cases"].as_array().unwrap();
    let mut splats = Splats::<E>::new(degree);
    for i in 0..count {
        let harmonics: Vec<E> =
            (0..degree.stride()).map(|k| E::constant((0.7 * (i * 48 + k) as f64).sin())).collect();
        splats.push(gaussian_deform::Splat {
            mean: Default::default(),
            axes: Matrix3::<E>::default(),
            opacity: E::constant(0.5),
            harmonics: &harmonics,
        });
    }
    for (i, orientation) in splats.orientations_mut().iter_mut().enumerate() {
        let r = matrix(&cases[i % 16]["R_row_major"]);
        *orientation = from_entries(|i, j| E::constant(r[(i, j)]));
    }
    splats
}

/// Lanes, the last incomplete packet and several chunks against one Gaussian at a time.
#[test]
fn settled_orientations_show_the_same_colours() {
    for degree in Degree::ALL {
        for count in [1, 3, 13, 1030] {
            let scene = turned_scene::<f64>(degree, count);
            let mut settled = scene.clone();
            harmonics::settle_orientations(&mut settled);
            assert!(settled.orientations().is_none());
            for i in 0..count {
                let mut expected = scene.harmonics_of(i).to_vec();
                harmonics::rotate(degree, &scene.orientations().unwrap()[i], &mut expected);
                assert!(largest_difference(settled.harmonics_of(i), &expected) < 1e-14);
            }
        }
    }
}

#[test]
fn single_precision_keeps_six_digits() {
    for count in [5, 64, 77] {
        let (mut narrow, mut wide) =
            (turned_scene::<f32>(Degree::Three, count), turned_scene::<f64>(Degree::Three, count));
        harmonics::settle_orientations(&mut narrow);
        harmonics::settle_orientations(&mut wide);
        let narrow = narrow.cast::<f64>();
        assert!(largest_difference(narrow.harmonics(), wide.harmonics()) < 3e-6);
    }
}

/// ∫ Yᵢ Yⱼ = δᵢⱼ over the sphere: the table of functions, checked by a quadrature that is exact for degree 6.
#[test]
fn the_basis_is_orthonormal() {
    // Gauss–Legendre with four points in z (exact to degree 7), eight equal steps of the azimuth.
    let nodes = [
        (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
        (0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
    ];
    let mut gram = [[0.0; 16]; 16];
    for (z, weight) in nodes.iter().flat_map(|&(z, w)| [(z, w), (-z, w)]) {
        for k in 0..8 {
            let angle = std::f64::consts::TAU * k as f64 / 8.0;
            let s = f64::sqrt(1.0 - z * z);
            let y = harmonics::basis(Degree::Three, [s * angle.cos(), s * angle.sin(), z]);
            for i in 0..16 {
                for j in 0..16 {
                    gram[i][j] += weight * std::f64::consts::TAU / 8.0 * y[i] * y[j];
                }
            }
        }
    }
    for i in 0..16 {
        for j in 0..16 {
            assert!((gram[i][j] - f64::from(u8::from(i == j))).abs() < 1e-14, "{i} {j}: {}", gram[i][j]);
        }
    }
}
