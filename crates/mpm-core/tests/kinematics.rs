//! Kinematics: material and spatial views of one motion, and body forces against the formulas that others derived by hand.
#![allow(clippy::unwrap_used, missing_docs, reason = "tests")]

#[path = "accuracy/motions.rs"]
mod motions;

use mechanics_core::law::Lame;
use mechanics_core::scalar::Scalar;
use motions::{AxisAligned, Ring, Vortex};
use mpm_constitutive::elastic::{Hencky, NeoHookean};
use mpm_core::MpmError;
use mpm_core::kinematics::{
    DeformationMap, Eulerian, VelocityField, at_material_point, at_place, body_force, eulerian_acceleration,
    first_piola, mass_residual, material_motion, material_point, momentum_residual,
};
use std::f64::consts::PI;

/// The largest difference relative to the size of `b`.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    let size = b.iter().fold(1e-300_f64, |m, x| m.max(x.abs()));
    a.iter().zip(b).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs())) / size
}

/// A channel that narrows from width w₀ as 1/(1 + x/L): v = (v₀ (1 + x/L), −v₀ y/L), steady and free of divergence.
struct River;

const SPEED: f64 = 2.0;
const LENGTH: f64 = 10.0;

impl DeformationMap<2> for River {
    fn place<S: Scalar>(&self, x: &[S; 2], t: S) -> [S; 2] {
        let growth = t.scale(SPEED / LENGTH).exp();
        [x[0].offset(LENGTH) * growth - S::constant(LENGTH), x[1] / growth]
    }
}

/// The same river as somebody on the bank sees it.
struct Bank;

impl VelocityField<2> for Bank {
    fn velocity<S: Scalar<Value = f64>>(&self, x: &[S; 2], _t: S) -> Result<[S; 2], MpmError> {
        Ok([x[0].scale(1.0 / LENGTH).offset(1.0).scale(SPEED), x[1].scale(-SPEED / LENGTH)])
    }
}

#[test]
fn a_steady_river_accelerates_its_water() {
    for (material, time) in [([3.0, 0.4], 0.0), ([3.0, 0.4], 2.5), ([-4.0, -1.0], 6.0)] {
        let motion = material_motion(&River, &material, time);
        let growth = (SPEED * time / LENGTH).exp();
        let place = [(material[0] + LENGTH) * growth - LENGTH, material[1] / growth];
        assert!(distance(&motion.position, &place) < 1e-14);
        // A = (v₀/L)² (X + L) e^{v₀t/L}, and y's the same with its own sign twice.
        let rate = SPEED / LENGTH;
        let expected = [rate * rate * (material[0] + LENGTH) * growth, rate * rate * place[1]];
        assert!(distance(&motion.acceleration, &expected) < 1e-14);
        let from_bank = eulerian_acceleration(&Bank, &motion.position, time).unwrap();
        let from_map = eulerian_acceleration(&Eulerian(River), &motion.position, time).unwrap();
        assert_eq!(from_bank.local, [0.0, 0.0]);
        assert!(distance(&from_bank.convective, &expected) < 1e-14);
        assert!(from_map.local.iter().all(|a| a.abs() < 1e-13), "{from_map:?}");
        assert!(distance(&from_map.total(), &expected) < 1e-12);
        // Water does not compress: R = R₀.
        assert!(mass_residual(&River, &material, time, 1000.0, 1000.0).abs() < 1e-10);
        assert!(mass_residual(&River, &material, time, 1001.0, 1000.0) > 0.9);
    }
}

/// Points of the unit square that are not special.
fn points() -> impl Iterator<Item = [f64; 2]> {
    (0..60).map(|k| [(f64::from(k) * 0.618_033_988).fract(), (f64::from(k) * 0.754_877_666).fract()])
}

#[test]
fn spatial_acceleration_through_the_inverse_is_the_material_one() {
    let solution = AxisAligned::standard();
    let vortex = Vortex { turn: 1.0, period: 1.0 };
    let ring = Ring { amplitude: 0.1, speed: 3.0, inner: 0.4, outer: 0.6 };
    let (mut worst, mut inverse, mut gradients) = (0.0_f64, 0.0_f64, 0.0_f64);
    for (k, x) in points().enumerate() {
        let part = 0.1 + 0.8 * (k as f64 * 0.41).fract();
        let polar = |inner: f64, outer: f64| {
            let (r, angle) = (inner + (outer - inner) * x[0], 2.0 * PI * x[1]);
            [r * angle.cos(), r * angle.sin()]
        };
        let mut check = |found: [[f64; 2]; 5], back: [f64; 2], material: [f64; 2]| {
            worst = worst.max(distance(&found[0], &found[1]));
            inverse = inverse.max(distance(&back, &material));
            gradients = gradients.max(distance(&found[2], &found[3]).max(distance(&found[4], &[1.0, 1.0])));
        };
        macro_rules! check_map {
            ($map:expr, $material:expr, $time:expr) => {{
                let (map, material, time) = ($map, $material, $time);
                let motion = material_motion(&map, &material, time);
                let spatial = eulerian_acceleration(&Eulerian(map), &motion.position, time).unwrap();
                // ∇v e₀ by the field, by Ḟ F⁻¹.
                let step = 1e-6;
                let field = |d: f64| {
                    Eulerian(map).velocity(&[motion.position[0] + d, motion.position[1]], time).unwrap()
                };
                let (plus, minus) = (field(step), field(-step));
                let slope: [f64; 2] = std::array::from_fn(|a| (plus[a] - minus[a]) / (2.0 * step));
                let own = motion.velocity_gradient().map(|row| row[0]);
                let scale = motion.velocity_gradient().iter().flatten().fold(1e-9_f64, |m, x| m.max(x.abs()));
                let near = [1.0 + (slope[0] - own[0]) / scale, 1.0 + (slope[1] - own[1]) / scale];
                let back = material_point(&map, &motion.position, time).unwrap();
                check([spatial.total(), motion.acceleration, motion.velocity,
                    Eulerian(map).velocity(&motion.position, time).unwrap(), near], back, material);
            }};
        }
        check_map!(solution, x, part * 0.9 / solution.speed);
        check_map!(vortex, polar(0.76, 1.24), part);
        check_map!(ring, polar(0.4, 0.6), part / ring.speed * 0.4);
    }
    println!("a = A: {worst:.1e}; X of x: {inverse:.1e}; v = V, grad v against differences: {gradients:.1e}");
    assert!(worst < 1e-11, "{worst}");
    assert!(inverse < 1e-13, "{inverse}");
    assert!(gradients < 1e-7, "{gradients}");
}

#[test]
fn quantities_travel_both_ways() {
    let vortex = Vortex { turn: 0.8, period: 1.0 };
    let material = [0.7, 0.6];
    let temperature = |x: &[f64; 2], t: f64| x[0] + 3.0 * x[1] * t;
    let place = material_motion(&vortex, &material, 0.3).position;
    let spatial = at_place(&vortex, temperature, &place, 0.3).unwrap();
    assert!((spatial - temperature(&material, 0.3)).abs() < 1e-14);
    assert_eq!(at_material_point(&vortex, temperature, &material, 0.3), temperature(&place, 0.3));
}

#[test]
fn a_place_without_material_is_an_error() {
    struct Flat;
    impl DeformationMap<2> for Flat {
        fn place<S: Scalar>(&self, x: &[S; 2], t: S) -> [S; 2] {
            [x[0].tanh() + t.scale(0.0), x[1]]
        }
    }
    let error = material_point(&Flat, &[1.5, 0.0], 1.0).unwrap_err();
    assert!(matches!(error, MpmError::NoMaterialPoint { time, .. } if time == 1.0), "{error}");
    assert!(material_point(&River, &[f64::NAN, 0.0], 1.0).is_err());
    assert!(Eulerian(Flat).velocity(&[1.5, 0.0], 1.0).is_err());
}

#[test]
fn the_axis_aligned_body_force_is_the_printed_one() {
    let solution = AxisAligned::standard();
    let law = NeoHookean::new(solution.lame);
    let mut worst = 0.0_f64;
    for (k, x) in points().enumerate() {
        let time = 2.0 / solution.speed * (k as f64 * 0.37).fract();
        let force = body_force(&solution, &law, solution.density, &x, time);
        let printed = solution.printed_force(&x, time);
        // Relative to the largest force of the solution.
        let largest = PI * PI * solution.amplitude * solution.speed.powi(2);
        worst = worst.max((0..2).map(|a| (force[a] - printed[a]).abs()).fold(0.0, f64::max) / largest);
        let rest = momentum_residual(&solution, &law, solution.density, (&x, time), &printed);
        assert!(rest.iter().all(|r| r.abs() < 1e-12 * solution.density * largest));
    }
    println!("axis-aligned solution, largest difference of body forces: {worst:.1e}");
    assert!(worst < 1e-13, "{worst}");
}

#[test]
fn the_vortex_body_force_is_the_printed_one_and_its_rims_are_free() {
    let vortex = Vortex { turn: 1.0, period: 1.0 };
    let lame = Lame::from_young_poisson(1000.0, 0.3).unwrap();
    let law = NeoHookean::new(lame);
    let mut worst = 0.0_f64;
    for (k, [a, b]) in points().enumerate() {
        let (r, angle) = (0.751 + 0.498 * a, 2.0 * PI * b);
        let (x, time) = ([r * angle.cos(), r * angle.sin()], (k as f64 * 0.37).fract());
        let force = body_force(&vortex, &law, 1000.0, &x, time);
        worst = worst.max(distance(&force, &vortex.printed_force(&x, time, lame.mu() / 1000.0)));
        assert!(mass_residual(&vortex, &x, time, 1000.0, 1000.0).abs() < 1e-9);
        for rim in [0.75 + 1e-12, 1.25 - 1e-12] {
            let normal = [angle.cos(), angle.sin()];
            let stress = first_piola(&vortex, &law, &normal.map(|n| n * rim), time);
            for row in 0..2 {
                let traction = stress[(row, 0)] * normal[0] + stress[(row, 1)] * normal[1];
                assert!(traction.abs() < 1e-6, "{rim} {traction}");
            }
        }
    }
    println!("vortex, largest relative difference of body forces: {worst:.1e}");
    assert!(worst < 1e-12, "{worst}");
}

#[test]
fn the_ring_body_force_is_the_printed_one() {
    let (young, density) = (1e7_f64, 1000.0);
    let ring = Ring { amplitude: 0.1, speed: (young / density).sqrt(), inner: 0.4, outer: 0.6 };
    let lame = Lame::from_young_poisson(young, 0.0).unwrap();
    let law = NeoHookean::new(lame);
    let mut worst = 0.0_f64;
    for (k, [a, b]) in points().enumerate() {
        let (r, angle) = (0.4 + 0.2 * a, 2.0 * PI * b);
        let time = (k as f64 * 0.37).fract() / ring.speed;
        let direction = [angle.cos(), angle.sin()];
        let force = body_force(&ring, &law, density, &direction.map(|d| d * r), time);
        let printed = ring.printed_radial_force(r, time, lame.mu() / density);
        // Relative to the largest force, 1e4 m/s²: all of them pass through zero together.
        worst = worst.max((0..2).map(|k| (force[k] - direction[k] * printed).abs() / 1e4).fold(0.0, f64::max));
    }
    println!("ring, largest difference of body forces: {worst:.1e}");
    assert!(worst < 1e-13, "{worst}");
}

/// Also for a law whose stress takes singular values.
#[test]
fn stress_divergence_agrees_with_differences_of_the_stress() {
    let law = Hencky::new(Lame::from_young_poisson(3e4, 0.25).unwrap());
    let solution = Vortex { turn: 0.5, period: 1.0 };
    let step = 1e-5;
    for [a, b] in points().take(12) {
        let (r, angle) = (0.8 + 0.4 * a, 2.0 * PI * b);
        let x = [r * angle.cos(), r * angle.sin()];
        let exact = mpm_core::kinematics::stress_divergence(&solution, &law, &x, 0.4);
        let mut rough = [0.0; 2];
        for axis in 0..2 {
            let at = |d: f64| {
                let mut moved = x;
                moved[axis] += d;
                first_piola(&solution, &law, &moved, 0.4)
            };
            let (plus, minus) = (at(step), at(-step));
            for (row, sum) in rough.iter_mut().enumerate() {
                *sum += (plus[(row, axis)] - minus[(row, axis)]) / (2.0 * step);
            }
        }
        assert!(distance(&rough, &exact) < 1e-6, "{rough:?} {exact:?}");
    }
}
