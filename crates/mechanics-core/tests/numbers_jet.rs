//! Jets against num-dual (an independent automatic differentiation) and against closed forms.

use mechanics_core::jet::{Jet1, Jet2};
use mechanics_core::lanes::{LaneKernel, Packet, dispatch};
use mechanics_core::scalar::Scalar;
use nalgebra::{SVector, vector};
use num_dual::DualNum;

/// Relative to the larger of the two, or absolute below one hundredth.
#[track_caller]
fn assert_close(ours: f64, reference: f64, tolerance: f64, what: &str) {
    let error = (ours - reference).abs() / reference.abs().max(ours.abs()).max(1e-2);
    assert!(error <= tolerance, "{what}: {ours} against {reference}, error {error:.1e}");
}

type Third = Jet1<Jet2<f64, 1>, 1>;

/// Value and three derivatives at x: ours nested, num-dual's, and our plain first and second jets, at 61 points.
macro_rules! check_against_num_dual {
    ($($name:literal, $low:expr, $high:expr, |$x:ident| $formula:expr, $reference:expr;)*) => {
        $(
            for i in 0..=60 {
                let x = $low + ($high - $low) * (f64::from(i) + 0.37) / 61.0;
                let what = format!("{} at {x}", $name);
                let (value, first, second, third) = num_dual::third_derivative(|$x| $reference, x);
                let nested = {
                    let $x = Third::variable(Jet2::variable(x, 0), 0);
                    $formula
                };
                assert_close(nested.value.value, value, 1e-13, &what);
                assert_close(nested.gradient[0].value, first, 1e-12, &what);
                assert_close(nested.value.gradient[0], first, 1e-12, &what);
                assert_close(nested.value.hessian(0, 0), second, 1e-12, &what);
                assert_close(nested.gradient[0].gradient[0], second, 1e-12, &what);
                assert_close(nested.gradient[0].hessian(0, 0), third, 1e-11, &what);
                let second_order = { let $x = Jet2::<f64, 1>::variable(x, 0); $formula };
                let first_order = { let $x = Jet1::<f64, 1>::variable(x, 0); $formula };
                assert_eq!(second_order, nested.value, "{what}");
                assert_eq!((first_order.value, first_order.gradient), (second_order.value, second_order.gradient));
            }
        )*
    };
}

#[test]
fn functions_of_one_number_have_num_duals_derivatives() {
    check_against_num_dual! {
        "square", -2.0, 2.0, |x| x.square(), x.powi(2);
        "recip", 0.1, 3.0, |x| x.recip(), x.recip();
        "recip of a negative", -3.0, -0.1, |x| x.recip(), x.recip();
        "sqrt", 0.05, 4.0, |x| x.sqrt(), x.sqrt();
        "exp", -3.0, 3.0, |x| x.exp(), x.exp();
        "exp_m1", -3.0, 3.0, |x| x.exp_m1(), x.exp_m1();
        "ln", 0.05, 9.0, |x| x.ln(), x.ln();
        "ln_1p", -0.9, 9.0, |x| x.ln_1p(), x.ln_1p();
        "sin", -4.0, 4.0, |x| x.sin(), x.sin();
        "cos", -4.0, 4.0, |x| x.cos(), x.cos();
        "tan", -1.3, 1.3, |x| x.tan(), x.tan();
        "asin", -0.95, 0.95, |x| x.asin(), x.asin();
        "acos", -0.95, 0.95, |x| x.acos(), x.acos();
        "sinh", -3.0, 3.0, |x| x.sinh(), x.sinh();
        "cosh", -3.0, 3.0, |x| x.cosh(), x.cosh();
        "tanh", -2.0, 2.0, |x| x.tanh(), x.tanh();
        "powi 7", -2.0, 2.0, |x| x.powi(7), x.powi(7);
        "powi 3", -2.0, 2.0, |x| x.powi(3), x.powi(3);
        "powi -4", 0.2, 2.0, |x| x.powi(-4), x.powi(-4);
        "powf 2.7", 0.1, 3.0, |x| x.powf(2.7), x.powf(2.7);
        "powf -0.4", 0.1, 3.0, |x| x.powf(-0.4), x.powf(-0.4);
        "scale and offset", -2.0, 2.0, |x| x.scale(3.0).offset(-0.5).sin(), (x * 3.0 - 0.5).sin();
        "a composition", 0.1, 2.0,
            |x| (x.sin() / (x.exp() + x.sqrt())).ln_1p() * x - -x.tanh(),
            (x.sin() / (x.exp() + x.sqrt())).ln_1p() * x - -x.tanh();
    }
}

/// The same formula over num-dual and over jets.
macro_rules! formula_of_three {
    ($name:ident, |$x:ident, $y:ident, $z:ident| $ours:expr, $reference:expr) => {
        struct $name;
        impl $name {
            fn ours<S: Scalar>([$x, $y, $z]: [S; 3]) -> S {
                $ours
            }
            fn reference<D: DualNum<Primitive = f64> + Copy>([$x, $y, $z]: [D; 3]) -> D {
                $reference
            }
            fn check(points: &[[f64; 3]]) {
                for &p in points {
                    let what = format!("{} at {p:?}", stringify!($name));
                    let jet = Self::ours(Jet2::variables(p));
                    let first = Self::ours(Jet1::variables(p));
                    let (value, gradient, hessian) = num_dual::hessian(
                        |v: SVector<_, 3>| Self::reference([v[0], v[1], v[2]]),
                        &vector![p[0], p[1], p[2]],
                    );
                    assert_close(jet.value, value, 1e-14, &what);
                    assert_close(first.value, value, 1e-14, &what);
                    let matrix = jet.hessian_matrix();
                    for i in 0..3 {
                        assert_close(jet.gradient[i], gradient[i], 1e-12, &what);
                        assert_close(first.gradient[i], gradient[i], 1e-12, &what);
                        for j in 0..3 {
                            assert_close(jet.hessian(i, j), hessian[(i, j)], 1e-12, &what);
                            assert_eq!(matrix[i][j], jet.hessian(i, j));
                        }
                    }
                }
            }
        }
    };
}

formula_of_three!(Product, |x, y, z| x * y * z + x * x * z, x * y * z + x * x * z);
formula_of_three!(Quotient, |x, y, z| (x - y) / (z + x * y), (x - y) / (z + x * y));
formula_of_three!(Angle, |x, y, z| (y * z).atan2(x - z), (y * z).atan2(x - z));
formula_of_three!(
    Energy,
    |x, y, z| (x * y + z.square()).sqrt().ln() * (x / z).cos() - y.mul_add(z, x).powf(1.5),
    (x * y + z.powi(2)).sqrt().ln() * (x / z).cos() - (y * z + x).powf(1.5)
);

#[test]
fn gradients_and_hessians_in_three_variables_are_num_duals() {
    let mut points = Vec::new();
    for i in 0..4 {
        for j in 0..4 {
            for k in 0..4 {
                let [i, j, k] = [i, j, k].map(f64::from);
                points.push([0.3 + 0.41 * i, 0.2 + 0.53 * j, 0.7 + 0.37 * k]);
            }
        }
    }
    Product::check(&points);
    Quotient::check(&points);
    Energy::check(&points);
    // All quadrants, both branches of the division.
    let turned: Vec<_> = points.iter().map(|p| [p[0] - 1.1, p[1] - 1.2, p[2] - 0.9]).collect();
    Angle::check(&turned);
}

#[test]
fn angles_keep_their_derivatives_at_huge_and_tiny_radii() {
    // θ(y, x) on the circle of radius r: ∂θ/∂y = cos θ / r, ∂²θ/∂x∂y = −cos 2θ / r².
    for radius in [1e-150, 1e-100, 1e100, 1e150] {
        for i in 0..16 {
            let angle = 0.1 + 0.39 * f64::from(i);
            let [y, x] = Jet2::variables([radius * angle.sin(), radius * angle.cos()]);
            let theta = y.atan2(x);
            assert!((theta.gradient[0] * radius - angle.cos()).abs() < 1e-14);
            assert!((theta.gradient[1] * radius + angle.sin()).abs() < 1e-14);
            assert!((theta.hessian(0, 1) * radius * radius + (2.0 * angle).cos()).abs() < 1e-14);
        }
    }
}

#[test]
fn powers_at_zero_are_those_of_polynomials() {
    let x = Jet2::<f64, 1>::variable(0.0, 0);
    // xⁿ/n! has its n-th derivative one and the others zero.
    for (exponent, expected) in
        [(0, [1.0, 0.0, 0.0]), (1, [0.0, 1.0, 0.0]), (2, [0.0, 0.0, 2.0]), (3, [0.0; 3])]
    {
        for power in [x.powi(exponent), x.powf(f64::from(exponent))] {
            assert_eq!([power.value, power.gradient[0], power.hessian(0, 0)], expected, "x^{exponent}");
        }
    }
    let cube = Third::variable(Jet2::variable(0.0, 0), 0).powi(3);
    assert_eq!(cube.gradient[0].hessian(0, 0), 6.0);
    assert_eq!(x.square().hessian(0, 0), 2.0);
    assert_eq!(x.powi(-1).value, f64::INFINITY);
    // The extreme exponent neither overflows nor panics.
    assert_eq!(Jet2::<f64, 1>::variable(1.0, 0).powi(i32::MIN).value, 1.0);
}

#[test]
fn roots_at_zero_are_as_documented() {
    let x = Jet2::<f64, 1>::variable(0.0, 0);
    assert_eq!((x.sqrt().value, x.sqrt().gradient[0]), (0.0, f64::INFINITY));
    assert!(x.sqrt().hessian(0, 0).is_nan());
    assert_eq!((x.powf(1.5).gradient[0], x.powf(1.5).hessian(0, 0)), (0.0, f64::INFINITY));
    assert!((x * x).sqrt().gradient[0].is_nan());
}

#[test]
fn branches_follow_the_value() {
    let [x, y] = Jet1::variables([2.0, -3.0]);
    assert_eq!(x.min(y), y);
    assert_eq!(x.max(y), x);
    assert_eq!(y.abs(), -y);
    assert_eq!(x.abs(), x);
    assert_eq!(x.copysign(y), -x);
    assert_eq!(y.copysign(x), -y);
    assert_eq!(y.copysign(y), y);
    assert_eq!(Jet1::<f64, 1>::variable(-0.0, 0).abs().value.to_bits(), 0);
    assert_eq!(Jet1::select(x.less(y), x, y), y);
    assert!(y.less_equal(x) && !x.less_equal(y) && x.less_equal(x));
    assert!(x.is_finite() && !(x / Jet1::constant(0.0)).is_finite());
}

#[test]
fn tails_of_tanh_and_poles_of_arcs_keep_their_digits() {
    // tanh′(20) = 4 e⁻⁴⁰ (1 − 2 e⁻⁴⁰ …); asin′(1 − δ) = 1/√(2δ − δ²).
    let tail = Jet1::<f64, 1>::variable(20.0, 0).tanh();
    assert_close(tail.gradient[0] * 1e17, 4.0 * (-40.0_f64).exp() * 1e17, 1e-14, "tanh'");
    let delta = 2.0_f64.powi(-40);
    let pole = Jet1::<f64, 1>::variable(1.0 - delta, 0).asin();
    assert_close(pole.gradient[0], (2.0 * delta - delta * delta).sqrt().recip(), 1e-14, "asin'");
}

#[test]
#[should_panic(expected = "variable 2 of a jet in 2 variables")]
fn a_variable_beyond_the_last_panics() {
    let _ = Jet1::<f64, 2>::variable(0.0, 2);
}

/// Gradients of four points at once: jets whose entries are lanes.
struct Gradients([[f64; 4]; 3]);

impl LaneKernel<f64> for Gradients {
    type Output = [[f64; 4]; 3];
    #[inline(always)]
    fn run<P: Packet<Element = f64>>(self) -> Self::Output {
        let jet = Energy::ours(Jet1::variables(self.0.map(|lanes| P::load(&lanes))));
        jet.gradient.map(P::to_lanes)
    }
}

#[test]
fn jets_over_lanes_are_lanes_of_jets() {
    let columns = [[0.3, 0.9, 1.4, 0.5], [1.1, 0.2, 0.7, 2.0], [0.8, 1.9, 0.6, 1.0]];
    let gradients = dispatch(Gradients(columns));
    for lane in 0..4 {
        let point = columns.map(|column| column[lane]);
        let one = Energy::ours(Jet1::variables(point));
        for i in 0..3 {
            assert_close(gradients[i][lane], one.gradient[i], 1e-14, "lane of a gradient");
        }
    }
}
