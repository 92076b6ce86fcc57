//! Sizes known at run time against sizes known to the compiler, and against closed forms.

use crate::agreement::{assert_close, assert_same_curvature, assert_same_expansion};
use crate::systems::{AsSliced, Chain, FUNCTIONS, NFold, Random, Synthetic};
use lagrangian::{Curvature, EulerLagrange, Expansion, Gradient, Lagrangian, SlicedEulerLagrange, System};

fn check_against_fixed<const N: usize>(
    lagrangian: impl Lagrangian<N> + Copy,
    random: &mut Random,
    what: &str,
) {
    let (t, q, v) = (random.number(), random.numbers::<N>(), random.numbers::<N>());
    let (fixed, sliced) = (EulerLagrange::new(lagrangian), SlicedEulerLagrange::new(AsSliced(lagrangian)));
    let (q_sliced, v_sliced) = (q.to_vec(), v.to_vec());
    let (mut reference, mut ours) = (Expansion::zeros(N), Expansion::zeros(N));
    fixed.expand(t, &q, &v, &mut reference);
    sliced.expand(t, &q_sliced, &v_sliced, &mut ours);
    assert_same_expansion(&ours, &reference, 1e-14, what);

    let (mut reference, mut ours) = (Curvature::zeros(N), Curvature::zeros(N));
    fixed.curve(t, &q, &v, &mut reference);
    sliced.curve(t, &q_sliced, &v_sliced, &mut ours);
    assert_same_curvature(&ours, &reference, 1e-14, what);

    let (mut reference, mut ours) = (Gradient::zeros(N), Gradient::zeros(N));
    fixed.differentiate(t, &q, &v, &mut reference);
    sliced.differentiate(t, &q_sliced, &v_sliced, &mut ours);
    assert_close(&[ours.kinetic, ours.potential], &[reference.kinetic, reference.potential], 1e-14, what);
    assert_close(&ours.momentum, &reference.momentum, 1e-14, what);
    assert_close(&ours.slope, &reference.slope, 1e-14, what);
    assert_close(&ours.applied, &reference.applied, 1e-14, what);
}

#[test]
fn every_function_couples_windows_as_it_does_one_jet() {
    let mut random = Random(5);
    for function in 0..FUNCTIONS {
        for _ in 0..3 {
            check_against_fixed::<11>(Synthetic { function }, &mut random, &format!("function {function}"));
        }
    }
}

#[test]
fn pendulums_agree_whatever_the_number_of_windows() {
    let mut random = Random(6);
    check_against_fixed::<1>(NFold, &mut random, "1");
    check_against_fixed::<8>(NFold, &mut random, "8");
    check_against_fixed::<9>(NFold, &mut random, "9");
    check_against_fixed::<16>(NFold, &mut random, "16");
}

#[test]
fn a_long_chain_has_the_matrices_of_its_springs() {
    // 600 masses are more windows than the tracer of couplings tells apart.
    for n in [3, 40, 600] {
        let (damping, pull, t) = (0.25, 2.0, 0.7f64);
        let system = SlicedEulerLagrange::new(Chain { masses: n, damping, pull });
        let mut random = Random(n as u64);
        let q: Vec<f64> = (0..n).map(|_| random.number()).collect();
        let v: Vec<f64> = (0..n).map(|_| random.number()).collect();
        let laplacian = |x: &[f64], ends: f64, i: usize| {
            let left = if i == 0 { ends * x[i] } else { x[i] - x[i - 1] };
            let right = if i + 1 == n { ends * x[i] } else { x[i] - x[i + 1] };
            left + right
        };
        let acceleration: Vec<f64> = (0..n)
            .map(|i| {
                let pulled = if i + 1 == n { pull * t.sin() } else { 0.0 };
                pulled - laplacian(&q, 1.0, i) - 2.0 * damping * laplacian(&v, 0.0, i)
            })
            .collect();
        let mut ours = vec![0.0; n];
        system.acceleration(t, &q, &v, &mut ours).unwrap();
        assert_close(&ours, &acceleration, 1e-14, "acceleration");

        let mut curvature = Curvature::<Vec<f64>>::zeros(n);
        system.curve(t, &q, &v, &mut curvature);
        for i in 0..n {
            for j in 0..n {
                let identity = f64::from(i == j);
                let neighbours = f64::from(i.abs_diff(j) == 1);
                let ends = identity * f64::from([0, n - 1].iter().filter(|&&end| end == i).count() as u32);
                assert_eq!(curvature.vv[i * n + j], identity);
                assert_eq!(curvature.vq[i * n + j], 0.0);
                assert_eq!(curvature.qq[i * n + j], neighbours - 2.0 * identity);
                assert_eq!(curvature.applied_q[i * n + j], 0.0);
                let lost = 2.0 * damping * (2.0 * identity - ends - neighbours);
                assert_eq!(curvature.applied_v[i * n + j], -lost, "({i}, {j}) of {n}");
            }
        }
    }
}
