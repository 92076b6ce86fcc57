//! The moments at which twisted rods and rings leave their shape.

use crate::samples::{SECTION, hessian, orders};
use crate::statics::Body;
use mechanics_core::mesh::{PolylineEnds, polyline, rod};
use mechanics_core::potential::Potential;
use mechanics_core::tensor::Vec3;
use nalgebra::{Cholesky, DMatrix};
use std::f64::consts::{PI, TAU};

/// The moment between `low` and `high` from which the matrix has a negative eigenvalue; rigid motions, whose eigenvalues are
/// rounding, are lifted by `shift`.
fn critical(mut low: f64, mut high: f64, shift: f64, matrix: impl Fn(f64) -> DMatrix<f64>) -> f64 {
    let is_stable = |moment: f64| {
        let m = matrix(moment);
        let n = m.nrows();
        Cholesky::new(m + DMatrix::identity(n, n) * shift).is_some()
    };
    assert!(is_stable(low) && !is_stable(high), "the critical moment lies between");
    while high - low > 1e-6 * high {
        let middle = 0.5 * (low + high);
        if is_stable(middle) { low = middle } else { high = middle }
    }
    low
}

/// A straight rod between clamps, one free to move along. Of B w'''' = i M w''' with w = w' = 0 at both ends what is left is
/// tan(ML/2B) = ML/2B: M = 8.98682 B/L (Greenhill 1883 has 2π B/L for ends that are pinned; Timoshenko and Gere, Theory of
/// Elastic Stability, 1961, section 2.21).
#[test]
fn greenhills_rod() {
    let exact = 2.0 * 4.493_409_457_909_064;
    let found = |n: u32| {
        // Clamped edges, the clamps in their middles, a length of one apart.
        let h = 1.0 / (f64::from(n) - 1.0);
        let mesh = rod(&Vec3::zeros(), &Vec3::new(h * f64::from(n), 0.0, 0.0), n).unwrap();
        let mut body = Body::new(&mesh, 1e3, 1.0, SECTION);
        let turns = body.twist.turns();
        let fixed = [0, 1, n - 1, n, turns.start, turns.end - 1];
        let untwisted = hessian(&[&body.stretching, &body.bending, &body.twist], &body.x, &fixed);
        for j in turns.clone() {
            let angle = f64::from(j - turns.start) * h / SECTION.torsional;
            body.x[j as usize] = body.twist.turn(angle);
        }
        let twisted = hessian(&[&body.stretching, &body.bending, &body.twist], &body.x, &fixed);
        let rate = twisted - &untwisted;
        critical(5.0, 12.0, 0.0, |moment| &untwisted + &rate * moment)
    };
    let errors = [20, 40, 80].map(|n| found(n) / exact - 1.0);
    println!("Greenhill: errors {errors:?}, orders {:?}", orders(&errors));
    assert!(orders(&errors).iter().all(|order| (order - 2.0).abs() < 0.15) && errors[2].abs() < 2e-3);
}

/// A naturally straight rod bent to a ring and closed with the twist Θ stays plane up to Θ = 2π√3 B/C (Michell 1889; Zajac 1962;
/// Goriely, J. Elasticity 84, 2006).
#[test]
fn michells_ring() {
    let exact = 3.0_f64.sqrt() * TAU / SECTION.torsional;
    let found = |n: u32| {
        let at = |i: u32| {
            let angle = TAU * f64::from(i) / f64::from(n);
            Vec3::new(angle.cos(), angle.sin(), 0.0)
        };
        let mesh = polyline((0..n).map(at).collect(), PolylineEnds::Joined).unwrap();
        let length = 2.0 * f64::from(n) * (PI / f64::from(n)).sin();
        let matrix = |angle: f64| {
            let mut body = Body::new(&mesh, 1e6, 1.0, SECTION);
            body.twist = body.twist.with_natural_twist(-angle / length).unwrap();
            hessian(&[&body.stretching, &body.bending, &body.twist], &body.x, &[])
        };
        // At rest otherwise: nothing moves.
        let untwisted = matrix(0.0);
        let rate = matrix(1.0) - &untwisted;
        critical(0.5 * exact, 2.0 * exact, 1e-5, |angle| &untwisted + &rate * angle)
    };
    let errors = [16, 32, 64].map(|n| found(n) / exact - 1.0);
    println!("Michell: errors {errors:?}, orders {:?}", orders(&errors));
    assert!(orders(&errors).iter().all(|order| (order - 2.0).abs() < 0.15) && errors[2].abs() < 1e-2);
}

/// The twisted ring below the critical twist is in equilibrium.
#[test]
fn a_twisted_ring_is_in_equilibrium() {
    let at = |i: u32| Vec3::new((TAU * f64::from(i) / 12.0).cos(), (TAU * f64::from(i) / 12.0).sin(), 0.0);
    let mesh = polyline((0..12).map(at).collect(), PolylineEnds::Joined).unwrap();
    let mut body = Body::new(&mesh, 1e3, 1.0, SECTION);
    body.twist = body.twist.with_natural_twist(-2.0).unwrap();
    let terms: [&dyn Potential; 3] = [&body.stretching, &body.bending, &body.twist];
    let mut force = vec![Vec3::zeros(); body.x.len()];
    terms.iter().for_each(|term| term.add_gradient(&body.x, &mut force));
    assert!(force.iter().all(|f| f.norm() < 1e-11), "{force:?}");
    assert!(body.value(&body.x) > 1.0);
}
