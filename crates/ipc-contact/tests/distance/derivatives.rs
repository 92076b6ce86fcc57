//! Gradients and Hessians against second-order jets over double-double numbers.
//!
//! How errors are measured: of a Hessian, the Frobenius norm of the difference over that of the Hessian. Of a value and a
//! gradient, the Euclidean norm of the difference over that of the value or gradient, *after* taking off what a rounding
//! of the positions would do to it: 16 ε L‖∇s‖ and 16 ε L‖∇∇s‖, with L the largest coordinate difference. (A distance of
//! 1e-7 L has a condition of 1e7, and the foot of a point over a sliver moves by d/sin² θ times such a rounding.) The
//! jets differentiate other formulas for s: ‖e × t‖²/‖t‖² for a line, (n·e)²/‖n‖² for a plane and for two lines. They run in
//! twice the precision, so that the whole error is that of the code under test.

use crate::double::Double;
use crate::states::{self, KINDS, Kind, Random};
use ipc_contact::distance::{
    EdgeEdgeMollifier, LineLine, PointLine, PointPlane, PointPoint, SquaredDistance,
};
use mechanics_core::jet::Jet2;
use mechanics_core::scalar::Scalar;
use mechanics_core::stencil::LocalHessian;
use mechanics_core::tensor::{Vec3, Vector3, components, cross, dot, vector};

fn minus<S: Scalar>(a: &Vector3<S>, b: &Vector3<S>) -> [S; 3] {
    let (a, b) = (components(a), components(b));
    std::array::from_fn(|i| a[i] - b[i])
}

fn square<S: Scalar>(a: &[S; 3]) -> S {
    dot(a, a)
}

/// Jets of all coordinates: `V` = 3`N`.
fn jets<const N: usize, const V: usize>(x: &[Vec3; N]) -> [Vector3<Jet2<Double, V>>; N] {
    let variables: [Jet2<Double, V>; V] = Jet2::variables(std::array::from_fn(|k| x[k / 3][k % 3].into()));
    std::array::from_fn(|i| vector([variables[3 * i], variables[3 * i + 1], variables[3 * i + 2]]))
}

/// Norms of the differences of gradient and Hessian, and of both.
struct Norms {
    error: [f64; 2],
    size: [f64; 2],
}

fn norms<const N: usize, const V: usize>(
    jet: &Jet2<Double, V>,
    gradient: &[Vec3; N],
    hessian: &LocalHessian<N>,
) -> Norms {
    let (mut error, mut size) = ([0.0; 2], [0.0; 2]);
    for i in 0..V {
        let expected = jet.gradient[i].high;
        error[0] += (gradient[i / 3][i % 3] - expected).powi(2);
        size[0] += expected.powi(2);
        for j in 0..V {
            let expected = jet.hessian(i, j).high;
            error[1] += (hessian[i / 3][j / 3][(i % 3, j % 3)] - expected).powi(2);
            size[1] += expected.powi(2);
        }
    }
    Norms { error: error.map(f64::sqrt), size: size.map(f64::sqrt) }
}

/// Errors of value, gradient and Hessian, as the top of this file says.
fn errors<P: SquaredDistance<N>, const N: usize, const V: usize>(
    x: &[Vec3; N],
    jet: &Jet2<Double, V>,
) -> [f64; 3] {
    let length = x.iter().map(|p| (p - x[0]).amax()).fold(0.0, f64::max);
    let rounding = 16.0 * f64::EPSILON * length;
    let Norms { error, size } = norms(jet, &P::gradient(x), &P::hessian(x));
    let of_value = (P::value(x) - jet.value.high).abs() - rounding * size[0];
    let of_gradient = error[0] - rounding * size[1];
    [of_value / jet.value.high, of_gradient / size[0], error[1] / size[1]].map(|error| error.max(0.0))
}

/// The worst errors of a primitive over many states of each kind.
fn worst<P: SquaredDistance<N>, const N: usize, const V: usize>(
    state: impl Fn(&mut Random, Kind) -> [Vec3; N],
    formula: impl Fn(&[Vector3<Jet2<Double, V>>; N]) -> Jet2<Double, V>,
) -> [f64; 3] {
    let mut random = Random(11);
    let mut worst = [0.0_f64; 3];
    for index in 0..25_000 {
        let x = state(&mut random, KINDS[index % KINDS.len()]);
        for (worst, error) in worst.iter_mut().zip(errors::<P, N, V>(&x, &formula(&jets(&x)))) {
            assert!(error.is_finite(), "{x:?}");
            *worst = worst.max(error);
        }
    }
    worst
}

#[test]
fn primitives_have_the_derivatives_of_automatic_differentiation() {
    let point_point = worst::<PointPoint, 2, 6>(states::points, |x| square(&minus(&x[0], &x[1])));
    let point_line = worst::<PointLine, 3, 9>(states::point_over_edge, |x| {
        let (t, e) = (minus(&x[2], &x[1]), minus(&x[0], &x[1]));
        square(&cross(&e, &t)) / square(&t)
    });
    let point_plane = worst::<PointPlane, 4, 12>(states::point_over_triangle, |x| {
        let n = cross(&minus(&x[2], &x[1]), &minus(&x[3], &x[1]));
        dot(&n, &minus(&x[0], &x[1])).square() / square(&n)
    });
    let line_line = worst::<LineLine, 4, 12>(states::crossing_edges, |x| {
        let n = cross(&minus(&x[1], &x[0]), &minus(&x[3], &x[2]));
        dot(&n, &minus(&x[0], &x[2])).square() / square(&n)
    });
    let worst = [point_point, point_line, point_plane, line_line];
    println!("worst relative errors of value, gradient, Hessian: {worst:?}");
    assert!(worst.iter().flatten().all(|error| *error < 1e-9), "{worst:?}");
}

#[test]
fn the_mollifier_has_the_derivatives_of_automatic_differentiation() {
    let mut random = Random(5);
    let (mut worst, mut active) = ([0.0_f64; 2], 0);
    for index in 0..20_000 {
        let x = states::crossing_edges(&mut random, KINDS[index % KINDS.len()]);
        let mollifier = EdgeEdgeMollifier::from_rest(&x);
        if !mollifier.is_active(&x) {
            assert_eq!(mollifier.value(&x), 1.0);
            assert_eq!(mollifier.gradient(&x), [Vec3::zeros(); 4]);
            continue;
        }
        active += 1;
        let jets: [Vector3<Jet2<Double, 12>>; 4] = jets(&x);
        let (u, v) = (minus(&jets[1], &jets[0]), minus(&jets[3], &jets[2]));
        let c = square(&cross(&u, &v));
        // As printed in the paper: −c²/ε² + 2c/ε.
        let epsilon = 1e-3 * (x[1] - x[0]).norm_squared() * (x[3] - x[2]).norm_squared();
        let expected = c.scale(2.0 / epsilon) - c.square().scale(1.0 / (epsilon * epsilon));
        let Norms { error, size } = norms(&expected, &mollifier.gradient(&x), &mollifier.hessian(&x));
        worst = [worst[0].max(error[0] / size[0]), worst[1].max(error[1] / size[1])];
        assert!((mollifier.value(&x) - expected.value.high).abs() < 1e-14);
    }
    println!("{active} active, worst relative errors of gradient and Hessian: {worst:?}");
    assert!(active > 5_000);
    assert!(worst.iter().all(|error| *error < 1e-9), "{worst:?}");
}
