//! Momentum, energy and centre of mass against rigid-body mechanics and exact sums.

use mechanics_core::diagnostics::{
    CompensatedSum, angular_momentum, centre_of_mass, kinetic_energy, linear_momentum, total_mass,
};
use mechanics_core::parallel::with_threads;
use mechanics_core::tensor::Vec3;

/// The corners of a box with sides 2a, 2b, 2c around `centre`, each of mass m: a body whose inertia is known,
/// J = 8 m diag(b² + c², a² + c², a² + b²).
fn corners(centre: Vec3) -> (Vec<f64>, Vec<Vec3>) {
    let sign = |i: usize, bit: usize| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
    let points = (0..8).map(|i| centre + Vec3::new(sign(i, 0), 2.0 * sign(i, 1), 3.0 * sign(i, 2)));
    (vec![0.5; 8], points.collect())
}

const CENTRE: Vec3 = Vec3::new(10.0, -20.0, 30.0);
const DRIFT: Vec3 = Vec3::new(0.5, 0.25, -1.0);
const SPIN: Vec3 = Vec3::new(0.75, -1.5, 2.0);

/// J ω for the box of `corners`.
fn inertia_times_spin() -> Vec3 {
    8.0 * 0.5 * Vec3::new(13.0 * SPIN.x, 10.0 * SPIN.y, 5.0 * SPIN.z)
}

#[test]
fn a_rigid_box_has_the_momenta_and_energy_of_rigid_body_mechanics() {
    let (masses, positions) = corners(CENTRE);
    let velocities: Vec<Vec3> = positions.iter().map(|x| DRIFT + SPIN.cross(&(x - CENTRE))).collect();
    let total = 4.0;
    // Every number here is a short binary fraction, so the sums are exact.
    assert_eq!(total_mass(&masses), total);
    assert_eq!(centre_of_mass(&masses, &positions), Some(CENTRE));
    assert_eq!(linear_momentum(&masses, &velocities), total * DRIFT);
    let about_centre = angular_momentum(&masses, &positions, &velocities, &CENTRE);
    assert_eq!(about_centre, inertia_times_spin());
    let about_origin = angular_momentum(&masses, &positions, &velocities, &Vec3::zeros());
    assert_eq!(about_origin, inertia_times_spin() + total * CENTRE.cross(&DRIFT));
    // König: T = ½ M |V|² + ½ ω·Jω.
    let energy = 0.5 * total * DRIFT.norm_squared() + 0.5 * SPIN.dot(&inertia_times_spin());
    assert_eq!(kinetic_energy(&masses, &velocities), energy);
}

#[test]
fn momentum_that_cancels_leaves_no_residue() {
    // 100,000 speeds, then the opposite ones, then one small push: plain summation drowns it in its own rounding.
    let pairs = 100_000;
    let speed = |i: usize| 1e3 * (1.5 + (i as f64 * 0.7).sin());
    let mut velocities: Vec<Vec3> = (0..pairs).map(|i| Vec3::new(speed(i), 0.1, -speed(i))).collect();
    velocities.extend((0..pairs).map(|i| Vec3::new(-speed(i), 0.1, speed(i))));
    velocities.push(Vec3::new(1e-9, 0.0, -1e-9));
    let count = velocities.len();
    let momentum = linear_momentum(&vec![1.0; count], &velocities);
    // The bound of `CompensatedSum`: n²ε² Σ|xᵢ| is 1.5e-13 here.
    let size: f64 = velocities.iter().map(|v| v.x.abs()).sum();
    let bound = (count as f64 * f64::EPSILON / 2.0).powi(2) * size;
    assert!(
        (momentum.x - 1e-9).abs() <= bound && (momentum.z + 1e-9).abs() <= bound,
        "{momentum}, bound {bound:e}"
    );
    // 200,000 × 0.1: the double nearest to 0.1 exceeds it by 5.6e-18, together less than one rounding of the total.
    assert_eq!(momentum.y, 20_000.0);
    let plain: f64 = velocities.iter().map(|v| v.x).sum();
    assert!((plain - 1e-9).abs() > 1e-8, "plain summation is good enough here, so the test shows nothing");
}

#[test]
fn bits_do_not_depend_on_the_number_of_threads() {
    let count = 50_021;
    let vector =
        |i: usize, k: f64| Vec3::new((i as f64 * k).sin(), (i as f64 * k).cos() * 1e5, 1.0 / (i + 1) as f64);
    let masses: Vec<f64> = (0..count).map(|i| 1.0 + (i as f64 * 0.3).sin()).collect();
    let positions: Vec<Vec3> = (0..count).map(|i| vector(i, 0.1)).collect();
    let velocities: Vec<Vec3> = (0..count).map(|i| vector(i, 1.7)).collect();
    let measure = || {
        let angular = angular_momentum(&masses, &positions, &velocities, &Vec3::new(1.0, 2.0, 3.0));
        let linear = linear_momentum(&masses, &velocities);
        let centre = centre_of_mass(&masses, &positions).expect("there is mass");
        let energy = kinetic_energy(&masses, &velocities);
        let mut bits: Vec<u64> = [angular, linear, centre].iter().flatten().map(|x| x.to_bits()).collect();
        bits.push(energy.to_bits());
        bits
    };
    let one = with_threads(1, measure);
    for threads in [2, 3, 8] {
        assert_eq!(with_threads(threads, measure), one, "{threads} threads");
    }
}

#[test]
fn nothing_has_no_mass_momentum_or_centre() {
    assert_eq!(total_mass(&[]), 0.0);
    assert_eq!(centre_of_mass(&[], &[]), None);
    assert_eq!(centre_of_mass(&[1.0, -1.0], &[Vec3::zeros(); 2]), None);
    assert_eq!(linear_momentum(&[], &[]), Vec3::zeros());
    assert_eq!(angular_momentum(&[], &[], &[], &CENTRE), Vec3::zeros());
    assert_eq!(kinetic_energy(&[], &[]), 0.0);
}

#[test]
fn nan_and_infinity_are_not_hidden() {
    let velocities = [Vec3::new(1.0, f64::NAN, 1.0), Vec3::new(f64::INFINITY, 0.0, 2.0)];
    let momentum = linear_momentum(&[1.0, 1.0], &velocities);
    assert_eq!(momentum.x, f64::INFINITY);
    assert!(momentum.y.is_nan());
    assert_eq!(momentum.z, 3.0);
    assert!(kinetic_energy(&[1.0, 1.0], &velocities).is_nan());
    let opposite = [Vec3::new(f64::INFINITY, 0.0, 0.0), Vec3::new(f64::NEG_INFINITY, 0.0, 0.0)];
    assert!(linear_momentum(&[1.0, 1.0], &opposite).x.is_nan());
}

#[test]
#[should_panic(expected = "one mass per velocity")]
fn unequal_lengths_are_refused() {
    linear_momentum(&[1.0], &[]);
}

#[test]
fn compensation_meets_its_bound_against_exact_integers() {
    // Multiples of 2⁻⁴⁰ up to 2⁴⁰, summed exactly in 128-bit integers.
    let mut state = 1u64;
    let mut sum = CompensatedSum::new();
    let (mut exact, mut size) = (0i128, 0i128);
    for n in 1..=300_000i128 {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let mantissa = i128::from((state >> 12) as i64 - (1 << 51));
        let shift = (state % 29) as u32;
        exact += mantissa << shift;
        size += mantissa.abs() << shift;
        sum.add((mantissa << shift) as f64 * 2f64.powi(-40));
        if n % 50_000 == 0 {
            // `exact` is compared in units of 2⁻⁴⁰ through the two leading doubles of its value.
            let high = exact as f64;
            let low = (exact - high as i128) as f64;
            let error = ((sum.value() * 2f64.powi(40) - high) - low).abs();
            let epsilon = f64::EPSILON / 2.0;
            let bound = epsilon * high.abs() + (n * n) as f64 * epsilon * epsilon * size as f64;
            assert!(error <= bound, "{n} terms: error {error:e}, bound {bound:e}");
        }
    }
}
