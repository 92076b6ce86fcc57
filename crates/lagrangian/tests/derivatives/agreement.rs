//! Expansions and curvatures against nested jets and against num-dual.

use crate::oracle;
use crate::systems::{FUNCTIONS, NFold, Random, Synthetic};
use lagrangian::{Coordinates, Curvature, EulerLagrange, Expansion, Gradient, Lagrangian, System};
use nalgebra::SVector;
use num_dual::{Dual2SVec64, DualNum};

/// Largest difference relative to the larger of the largest entry and one hundredth.
#[track_caller]
pub(crate) fn assert_close(ours: &[f64], reference: &[f64], tolerance: f64, what: &str) {
    let size = reference.iter().fold(1e-2, |size: f64, x| size.max(x.abs()));
    for (i, (x, y)) in ours.iter().zip(reference).enumerate() {
        let error = (x - y).abs() / size;
        assert!(error <= tolerance, "{what}, entry {i}: {x} against {y}, error {error:.1e}");
    }
}

#[track_caller]
pub(crate) fn assert_same_expansion<C: Coordinates, D: Coordinates>(
    ours: &Expansion<C>,
    reference: &Expansion<D>,
    tolerance: f64,
    what: &str,
) {
    let check = |ours: &[f64], reference: &[f64], part| {
        assert_close(ours, reference, tolerance, &format!("{what}: {part}"));
    };
    check(&[ours.kinetic, ours.potential], &[reference.kinetic, reference.potential], "energies");
    check(ours.momentum.as_ref(), reference.momentum.as_ref(), "momentum");
    check(ours.momentum_rate.as_ref(), reference.momentum_rate.as_ref(), "rate of momentum");
    check(ours.slope.as_ref(), reference.slope.as_ref(), "slope");
    check(ours.applied.as_ref(), reference.applied.as_ref(), "applied");
    check(C::entries(&ours.mass), D::entries(&reference.mass), "mass");
}

#[track_caller]
pub(crate) fn assert_same_curvature<C: Coordinates, D: Coordinates>(
    ours: &Curvature<C>,
    reference: &Curvature<D>,
    tolerance: f64,
    what: &str,
) {
    let check = |ours, reference, part| {
        assert_close(C::entries(ours), D::entries(reference), tolerance, &format!("{what}: {part}"));
    };
    check(&ours.qq, &reference.qq, "qq");
    check(&ours.vq, &reference.vq, "vq");
    check(&ours.vv, &reference.vv, "vv");
    check(&ours.applied_q, &reference.applied_q, "applied_q");
    check(&ours.applied_v, &reference.applied_v, "applied_v");
}

fn check_against_nested_jets<const N: usize>(l: impl Lagrangian<N>, random: &mut Random, what: &str) {
    let (t, q, v) = (random.number(), random.numbers::<N>(), random.numbers::<N>());
    let what = format!("{what} at t = {t}, q = {q:?}, v = {v:?}");
    let reference = oracle::expand(&l, t, &q, &v);
    let curved = oracle::curve(&l, t, &q, &v);
    let system = EulerLagrange::new(l);
    let (mut at, mut curvature) = (Expansion::zeros(N), Curvature::zeros(N));
    system.expand(t, &q, &v, &mut at);
    system.curve(t, &q, &v, &mut curvature);
    assert_same_expansion(&at, &reference, 2e-14, &what);
    assert_same_curvature(&curvature, &curved, 2e-14, &what);

    let mut gradient = Gradient::zeros(N);
    system.differentiate(t, &q, &v, &mut gradient);
    let Gradient { kinetic, potential, momentum, slope, applied } = gradient;
    let rest = Expansion { kinetic, potential, momentum, slope, applied, ..at };
    assert_same_expansion(&rest, &reference, 2e-14, &what);
}

#[test]
fn every_function_of_scalar_agrees_with_nested_jets() {
    let mut random = Random(7);
    for function in 0..FUNCTIONS {
        for _ in 0..40 {
            check_against_nested_jets::<3>(
                Synthetic { function },
                &mut random,
                &format!("function {function}"),
            );
            check_against_nested_jets::<1>(
                Synthetic { function },
                &mut random,
                &format!("function {function}"),
            );
        }
    }
}

#[test]
fn pendulums_of_one_to_seven_masses_agree_with_nested_jets() {
    let mut random = Random(11);
    for _ in 0..20 {
        check_against_nested_jets::<1>(NFold, &mut random, "1");
        check_against_nested_jets::<2>(NFold, &mut random, "2");
        check_against_nested_jets::<5>(NFold, &mut random, "5");
        check_against_nested_jets::<7>(NFold, &mut random, "7");
    }
}

/// A Lagrangian whose T is no polynomial in v, mentions time, and couples everything, once for us and once for num-dual.
struct Everything;

impl Lagrangian<2> for Everything {
    fn kinetic<S: mechanics_core::scalar::Scalar>(&self, q: &[S; 2], v: &[S; 2], t: S) -> S {
        let numerator = (v[0] * v[0] + v[1] * v[1] * q[0].cos() + (v[0] * v[1] * t).sin()).exp().sqrt();
        numerator / ((q[1] * v[0]).tanh() + t.cos() * q[0] * q[0]).offset(3.0) + q[1] * v[0]
    }
    fn potential<S: mechanics_core::scalar::Scalar>(&self, q: &[S; 2], t: S) -> S {
        (q[0] * q[1]).sinh() * t + q[1].atan2(q[0].exp())
    }
}

fn kinetic_over_num_dual<D: DualNum<Primitive = f64> + Copy>(z: &[D]) -> D {
    let [q0, q1, v0, v1, t] = [z[0], z[1], z[2], z[3], z[4]];
    let numerator = (v0 * v0 + v1 * v1 * q0.cos() + (v0 * v1 * t).sin()).exp().sqrt();
    numerator / ((q1 * v0).tanh() + t.cos() * q0 * q0 + 3.0) + q1 * v0
}

fn potential_over_num_dual<D: DualNum<Primitive = f64> + Copy>(z: &[D]) -> D {
    (z[0] * z[1]).sinh() * z[4] + z[1].atan2(z[0].exp())
}

#[test]
fn derivatives_are_num_duals() {
    let mut random = Random(3);
    for _ in 0..50 {
        let (t, q, v) = (random.number(), random.numbers::<2>(), random.numbers::<2>());
        let z = SVector::<f64, 5>::from([q[0], q[1], v[0], v[1], t]);
        let over = |formula: fn(&[Dual2SVec64<5>]) -> Dual2SVec64<5>| {
            num_dual::hessian(|z: SVector<_, 5>| formula(z.as_slice()), &z)
        };
        let (kinetic, slope, second) = over(kinetic_over_num_dual);
        let (potential, potential_slope, potential_second) = over(potential_over_num_dual);
        let block = |rows: usize, columns: usize| -> [[f64; 2]; 2] {
            std::array::from_fn(|i| std::array::from_fn(|j| second[(rows + i, columns + j)]))
        };
        let reference = Expansion::<[f64; 2]> {
            kinetic,
            potential,
            momentum: [slope[2], slope[3]],
            momentum_rate: std::array::from_fn(|i| {
                second[(2 + i, 0)] * v[0] + second[(2 + i, 1)] * v[1] + second[(2 + i, 4)]
            }),
            slope: std::array::from_fn(|i| slope[i] - potential_slope[i]),
            applied: [0.0; 2],
            mass: block(2, 2),
        };
        let mut qq = block(0, 0);
        for i in 0..2 {
            for j in 0..2 {
                qq[i][j] -= potential_second[(i, j)];
            }
        }
        let curved = Curvature { qq, vq: block(2, 0), vv: block(2, 2), ..Curvature::<[f64; 2]>::zeros(2) };
        let system = EulerLagrange::new(Everything);
        let (mut at, mut curvature) = (Expansion::zeros(2), Curvature::zeros(2));
        system.expand(t, &q, &v, &mut at);
        system.curve(t, &q, &v, &mut curvature);
        assert_same_expansion(&at, &reference, 1e-13, "num-dual");
        assert_same_curvature(&curvature, &curved, 1e-13, "num-dual");
    }
}
