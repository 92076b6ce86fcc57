use crate::samples::{Random, Springs, Volumes};
use mechanics_core::derivatives::{
    Derivative, DerivativeError, check_gradient, check_hessian, check_objective_direction,
    check_objective_gradient, check_potential_gradient, check_potential_hessian, check_stencil,
};
use mechanics_core::objective::{DenseObjective, DenseProblem};
use mechanics_core::projection::Projection;
use mechanics_core::stencil::{LocalHessian, Stencil, StencilTerm};
use mechanics_core::tensor::{Mat3, Vec3};
use nalgebra::DMatrix;

fn springs(n: usize) -> Springs {
    Springs { stiffness: vec![3.0; n], rest_length: vec![0.5; n] }
}

#[test]
fn right_stencils_pass_at_1e_8() {
    let mut random = Random(21);
    for scale in [1e-3, 1.0, 1e3_f64] {
        // Both parts of the energy are of the size of scale².
        let (weight, volume) = (4.0 * scale.powi(-4), vec![0.2 * scale.powi(3)]);
        let volumes = Volumes { weight, stiffness: 0.3, volume };
        for _ in 0..20 {
            let x: [Vec3; 4] = std::array::from_fn(|_| random.vector() * scale);
            check_stencil(&volumes, 0, &x).require(1e-8).unwrap();
            check_stencil(&springs(1), 0, &[x[0], x[1]]).require(1e-8).unwrap();
        }
    }
}

/// The mistakes that are made, planted in a right stencil: `entry` is 3 point + component.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Mistake {
    GradientSign,
    GradientFactor,
    GradientEntry(usize, f64),
    HessianSign,
    HessianEntry(usize, usize, f64),
    HessianForgetsTerm,
}

struct Mistaken(Volumes, Mistake);

impl Stencil<4> for Mistaken {
    fn value(&self, e: usize, x: &[Vec3; 4]) -> f64 {
        self.0.value(e, x)
    }
    fn gradient(&self, e: usize, x: &[Vec3; 4]) -> [Vec3; 4] {
        let mut g = self.0.gradient(e, x);
        match self.1 {
            Mistake::GradientSign => g.iter_mut().for_each(|g| *g = -*g),
            Mistake::GradientFactor => g.iter_mut().for_each(|g| *g *= 2.0),
            Mistake::GradientEntry(entry, relative) => {
                let largest = g.iter().map(|g| g.amax()).fold(0.0, f64::max);
                g[entry / 3][entry % 3] += relative * largest;
            }
            _ => {}
        }
        g
    }
    fn hessian(&self, e: usize, x: &[Vec3; 4], projection: Projection) -> LocalHessian<4> {
        let mut h = self.0.hessian(e, x, projection);
        match self.1 {
            Mistake::HessianSign => h[2][1] = -h[2][1],
            Mistake::HessianEntry(row, column, relative) => {
                let largest = h.iter().flatten().map(Mat3::amax).fold(0.0, f64::max);
                h[row / 3][column / 3][(row % 3, column % 3)] += relative * largest;
            }
            Mistake::HessianForgetsTerm => {
                (0..4).for_each(|i| h[i][i] -= Mat3::from_diagonal_element(3.0 * self.0.stiffness));
            }
            _ => {}
        }
        h
    }
}

#[test]
fn planted_mistakes_are_caught_and_located() {
    let volumes = Volumes { weight: 4.0, stiffness: 0.3, volume: vec![0.2] };
    let mut random = Random(22);
    let x: [Vec3; 4] = std::array::from_fn(|_| random.vector());
    let check = |mistake| check_stencil(&Mistaken(volumes.clone(), mistake), 0, &x);
    for mistake in [
        Mistake::GradientSign,
        Mistake::GradientFactor,
        Mistake::GradientEntry(7, 1e-4),
        Mistake::GradientEntry(0, -1e-7),
    ] {
        let DerivativeError::Wrong { derivative, entry, .. } = check(mistake).require(1e-8).unwrap_err()
        else {
            panic!("{mistake:?} is not about symmetry");
        };
        assert_eq!(derivative, Derivative::Gradient, "{mistake:?}");
        if let Mistake::GradientEntry(row, _) = mistake {
            assert_eq!(entry.row, row);
        }
    }
    for mistake in [
        Mistake::HessianSign,
        Mistake::HessianForgetsTerm,
        Mistake::HessianEntry(7, 2, 1e-4),
        Mistake::HessianEntry(10, 9, -1e-7),
        Mistake::HessianEntry(3, 3, 1e-4),
    ] {
        let outcome = check(mistake);
        outcome.gradient.require(1e-8).unwrap();
        assert_eq!(outcome.hessian.derivative, Derivative::Hessian, "{mistake:?}");
        assert!(outcome.require(1e-8).is_err(), "{mistake:?}");
        if let Mistake::HessianEntry(row, column, _) = mistake {
            let Err(DerivativeError::Wrong { entry, .. }) = outcome.hessian.require(1e-8) else { panic!() };
            let found = (entry.row.max(entry.column), entry.row.min(entry.column));
            assert_eq!(found, (row.max(column), row.min(column)), "{mistake:?}");
        }
    }
}

#[test]
fn terms_are_checked_through_assembly() {
    let mut random = Random(23);
    let elements = random.elements::<4>(30, 12);
    let volumes = Volumes { weight: 4.0, stiffness: 0.3, volume: vec![0.2; 30] };
    let x = random.vectors(12);
    let right = StencilTerm::new("volumes", volumes.clone(), elements.clone()).unwrap();
    check_potential_gradient(&right, &x).require(1e-8).unwrap();
    check_potential_hessian(&right, &x).require(1e-8).unwrap();
    let wrong =
        StencilTerm::new("wrong", Mistaken(volumes, Mistake::HessianEntry(7, 2, 1e-4)), elements).unwrap();
    check_potential_gradient(&wrong, &x).require(1e-8).unwrap();
    assert!(check_potential_hessian(&wrong, &x).require(1e-8).is_err());
}

/// The accuracy of the differences themselves, swept over functions whose derivatives are known: the sweep must find
/// a good step without being told the function's scale.
#[test]
fn differences_are_accurate_over_scales_of_argument_and_value() {
    for scale in [1e-9, 1e-3, 1.0, 1e4, 1e9] {
        for factor in [1e-150, 1e-12, 1.0, 1e12, 1e150] {
            let x = [0.3 * scale, 0.7 * scale, 0.9 * scale];
            let value =
                |x: &[f64]| factor * ((x[0] / scale).sin() * (x[1] / scale).exp() + (x[2] / scale).powi(5));
            let gradient = |x: &[f64], g: &mut [f64]| {
                let [a, b, c] = [x[0] / scale, x[1] / scale, x[2] / scale];
                g[0] = factor * a.cos() * b.exp() / scale;
                g[1] = factor * a.sin() * b.exp() / scale;
                g[2] = factor * 5.0 * c.powi(4) / scale;
            };
            let check = check_gradient(&x, value, gradient);
            assert!(check.worst.error < 1e-10, "scale {scale:e}, factor {factor:e}: {:?}", check.worst);
            let hessian = |i: usize, j: usize| {
                let [a, b, c] = x.map(|x| x / scale);
                let entry = match (i, j) {
                    (0, 0) => -a.sin() * b.exp(),
                    (1, 1) => a.sin() * b.exp(),
                    (2, 2) => 20.0 * c.powi(3),
                    (0, 1) | (1, 0) => a.cos() * b.exp(),
                    _ => 0.0,
                };
                factor * entry / scale / scale
            };
            let check = check_hessian(&x, gradient, hessian);
            assert!(check.worst.error < 1e-10, "scale {scale:e}, factor {factor:e}: {:?}", check.worst);
        }
    }
}

#[test]
fn hard_cases_are_not_passed_over() {
    let nan = check_gradient(&[1.0], |x| x[0] * x[0], |_, g| g[0] = f64::NAN);
    assert!(nan.require(f64::MAX).is_err(), "NaN is never right");
    let infinite = check_gradient(&[1.0], |_| f64::INFINITY, |_, g| g[0] = 0.0);
    assert!(infinite.require(1.0).is_err(), "nothing is known of a function that is infinite all around");
    let zero = check_gradient(&[0.0, 0.0], |_| 5.0, |_, g| g.fill(0.0));
    assert!(zero.require(1e-15).is_ok(), "a constant has no gradient");
    // A wall a thousandth away: wide steps see it, narrow ones do not.
    let wall = |x: &[f64]| if x[0] > 0.0 { -x[0].ln() } else { f64::INFINITY };
    check_gradient(&[1e-3, 1.0], wall, |x, g| g.copy_from_slice(&[-1.0 / x[0], 0.0])).require(1e-8).unwrap();
    let asymmetric = |i: usize, j: usize| if i < j { 1.0 } else { 0.0 };
    let check = check_hessian(&[1.0, 2.0], |_, g| g.fill(0.0), asymmetric);
    assert_eq!(check.asymmetry, 1.0);
}

struct Wavy {
    wrong_hessian: f64,
}

impl DenseProblem for Wavy {
    fn dimension(&self) -> usize {
        2
    }
    fn value(&self, x: &[f64]) -> f64 {
        x[0].cosh() + (x[0] * x[1]).exp() + x[1].powi(2)
    }
    fn gradient_into(&self, x: &[f64], g: &mut [f64]) {
        let e = (x[0] * x[1]).exp();
        g.copy_from_slice(&[x[0].sinh() + x[1] * e, x[0] * e + 2.0 * x[1]]);
    }
    fn hessian_into(&self, x: &[f64], h: &mut DMatrix<f64>) {
        let e = (x[0] * x[1]).exp();
        let mixed = e * (1.0 + x[0] * x[1]) * (1.0 + self.wrong_hessian);
        h.copy_from_slice(&[x[0].cosh() + x[1].powi(2) * e, mixed, mixed, x[0].powi(2) * e + 2.0]);
    }
}

#[test]
fn objectives_are_checked_through_their_direction() {
    let x = [0.4, 0.8];
    let mut right = DenseObjective::new(Wavy { wrong_hessian: 0.0 });
    check_objective_gradient(&mut right, &x).require(1e-10).unwrap();
    check_objective_direction(&mut right, &x).unwrap().require(1e-9).unwrap();
    let mut wrong = DenseObjective::new(Wavy { wrong_hessian: 1e-4 });
    let caught = check_objective_direction(&mut wrong, &x).unwrap().require(1e-7);
    assert!(matches!(caught, Err(DerivativeError::Wrong { derivative: Derivative::Direction, .. })));
}

/// At rest the gradient vanishes and differences are rounding; a wrong gradient is still seen there, and hardly off
/// rest too.
#[test]
fn a_rest_state_passes_and_a_wrong_gradient_there_does_not() {
    for (scale, stiffness) in [(1.0, 1.0), (1e-3, 1e7), (1e4, 1e-5)] {
        let mut random = Random(77);
        let x = [random.vector() * scale, random.vector() * scale];
        let length = (x[1] - x[0]).norm();
        let springs = Springs { stiffness: vec![stiffness], rest_length: vec![length] };
        check_stencil(&springs, 0, &x).require(1e-8).unwrap();
        let flat: Vec<f64> = x.iter().flatten().copied().collect();
        for (strain, wrong) in [(0.0, 1e-6), (1e-6, 1e-9)] {
            let springs = Springs { rest_length: vec![length * (1.0 - strain)], ..springs.clone() };
            let at = |q: &[f64]| [Vec3::new(q[0], q[1], q[2]), Vec3::new(q[3], q[4], q[5])];
            let check = mechanics_core::derivatives::check_gradient(
                &flat,
                |q| springs.value(0, &at(q)),
                |q, g| {
                    let [a, b] = springs.gradient(0, &at(q));
                    g[..3].copy_from_slice(a.as_slice());
                    g[3..].copy_from_slice(b.as_slice());
                    g[4] += wrong * stiffness * length;
                },
            );
            assert_eq!(check.worst.row, 4);
            assert!(check.require(1e-4).is_err(), "{scale} {strain} {check:?}");
        }
    }
}

/// Near the end of its domain a function is NaN or infinite at the wide steps of the sweep, the first comparisons among them; the
/// narrow ones tell the derivative all the same. Where all are NaN nothing passes.
#[test]
fn wide_steps_out_of_the_domain_do_not_spoil_the_difference() {
    let logarithm = |x: &[f64]| x[0].ln() + 0.5 * x[1];
    let root = |x: &[f64]| if x[0] > 0.0 { x[0].sqrt() + x[1] } else { f64::INFINITY };
    let x = [1e-3, 1.0];
    check_gradient(&x, logarithm, |x, g| g.copy_from_slice(&[1.0 / x[0], 0.5])).require(1e-7).unwrap();
    check_gradient(&x, root, |x, g| g.copy_from_slice(&[0.5 / x[0].sqrt(), 1.0])).require(1e-7).unwrap();
    let wrong = check_gradient(&x, logarithm, |x, g| g.copy_from_slice(&[1.01 / x[0], 0.5]));
    assert!(wrong.require(1e-3).is_err() && wrong.worst.row == 0, "{wrong:?}");
    let hessian = |row: usize, column: usize| if row + column == 0 { -1e6 } else { 0.0 };
    let gradient = |x: &[f64], g: &mut [f64]| {
        g.copy_from_slice(&[if x[0] > 0.0 { 1.0 / x[0] } else { f64::NAN }, 0.5]);
    };
    check_hessian(&x, gradient, hessian).require(1e-7).unwrap();
    let never = check_gradient(&x, |_| f64::NAN, |_, g| g.copy_from_slice(&[0.0, 0.0]));
    assert!(never.require(1e300).is_err(), "{never:?}");
}
