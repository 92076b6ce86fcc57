//! Derivatives of pairs against automatic differentiation of the textbook's formula, and projections against eigenvalues.

use crate::Random;
use crate::scene::mu;
use ipc_contact::normal_force::NormalForce;
use ipc_friction::basis::SlidingBasis;
use ipc_friction::lagged::LaggedFriction;
use ipc_friction::law::{FrictionCoefficient, SmoothedCoulomb, Smoothing, Strength};
use ipc_friction::pair::{FrictionPairs, LaggedPair};
use mechanics_core::jet::Jet2;
use mechanics_core::projection::{Projection, project_symmetric};
use mechanics_core::scalar::Scalar;
use mechanics_core::stage::{Coefficients, Scheme};
use mechanics_core::stencil::{LocalHessian, Stencil};
use mechanics_core::tensor::Vec3;
use nalgebra::SMatrix;

const A: f64 = 100.0;
const EPSILON: f64 = 1e-2;
const FALL: f64 = 2e-2;

fn law(smoothing: Smoothing) -> SmoothedCoulomb {
    let law = SmoothedCoulomb::new(EPSILON).unwrap().with_smoothing(smoothing);
    law.with_transition(FALL).unwrap()
}

/// A pair of N points with random weights that sum to zero, or one point.
struct Case<const N: usize> {
    force: NormalForce,
    coefficient: FrictionCoefficient,
    origin: Vec<Vec3>,
    x: [Vec3; N],
}

fn case<const N: usize>(random: &mut Random, speed: f64) -> Case<N> {
    let mut weights: [f64; N] = std::array::from_fn(|_| random.number());
    let sum: f64 = weights.iter().sum();
    weights[N - 1] -= if N == 1 { sum - 1.0 } else { sum };
    let normal = random.vector().normalize();
    let magnitude = if random.number() > 0.5 { -3.0 } else { 5.0 };
    let force = NormalForce::new(std::array::from_fn(|i| i as u32), weights, normal, 1e-3, magnitude);
    let size = 0.6 + 0.4 * random.number();
    let coefficient = FrictionCoefficient::with_kinetic(size, 0.5 * size).unwrap();
    let origin: Vec<Vec3> = (0..N).map(|_| random.vector()).collect();
    let x = std::array::from_fn(|i| origin[i] + random.vector() * (speed / A));
    Case { force, coefficient, origin, x }
}

fn pairs<const N: usize>(cases: &[Case<N>], smoothing: Smoothing) -> FrictionPairs<N> {
    let lagged = |case: &Case<N>| {
        let coefficients = Coefficients { inertia: A * A, velocity: A };
        let scheme = Scheme::new(coefficients, &case.origin, &case.origin);
        LaggedPair::new(&case.force, Strength::new(case.coefficient, case.force.magnitude), &scheme)
    };
    FrictionPairs {
        law: law(smoothing),
        velocity_factor: A,
        floor: 0.0,
        pairs: cases.iter().map(lagged).collect(),
    }
}

/// λ P(y)/a with u = a Tᵀ Σ w (x − x̂), T in columns, P as the integral of the law's formulas written out.
fn textbook<const N: usize, const M: usize>(
    case: &Case<N>,
    smoothing: Smoothing,
    x: &[Jet2<f64, M>; M],
) -> Jet2<f64, M> {
    let basis = SlidingBasis::of_pair(&case.force);
    let component = |column: &Vec3| {
        let mut sum = Jet2::from_value(0.0);
        for i in 0..N {
            for k in 0..3 {
                let moved = x[3 * i + k] - Jet2::from_value(case.origin[i][k]);
                sum += moved.scale(A * case.force.weights()[i] * column[k]);
            }
        }
        sum
    };
    let [u1, u2] = basis.columns().each_ref().map(component);
    let y = (u1.square() + u2.square()).sqrt();
    let (mu_s, mu_k) = (case.coefficient.at_rest(), case.coefficient.sliding());
    let f0 = |y: Jet2<f64, M>| match smoothing {
        Smoothing::Quadratic => {
            y.powi(2).scale(1.0 / EPSILON) - y.powi(3).scale(1.0 / (3.0 * EPSILON * EPSILON))
                + Jet2::from_value(EPSILON / 3.0)
        }
        Smoothing::Quintic => {
            let z = y.scale(1.0 / EPSILON);
            let polynomial = z.powi(2).scale(15.0) - z.powi(4).scale(5.0) + z.powi(6);
            (polynomial + Jet2::from_value(5.0)).scale(EPSILON / 16.0)
        }
    };
    let integral_of_fall = |s: Jet2<f64, M>| match smoothing {
        Smoothing::Quadratic => s.powi(3) - s.powi(4).scale(0.5),
        Smoothing::Quintic => s.powi(4).scale(2.5) - s.powi(5).scale(3.0) + s.powi(6),
    };
    let s = (y - Jet2::from_value(EPSILON)).scale(1.0 / FALL);
    let potential = if y.value < EPSILON {
        f0(y).scale(mu_s)
    } else if y.value < EPSILON + FALL {
        y.scale(mu_s) + integral_of_fall(s).scale((mu_k - mu_s) * FALL)
    } else {
        y.scale(mu_s) + (s - Jet2::from_value(0.5)).scale((mu_k - mu_s) * FALL)
    };
    potential.scale(case.force.magnitude / A)
}

fn compare<const N: usize, const M: usize>(smoothing: Smoothing) {
    assert_eq!(3 * N, M);
    let mut random = Random(11 + N as u64);
    for speed in [1e-7, 1e-3, 1e-2, 2e-2, 1.0] {
        let cases: Vec<Case<N>> = (0..13).map(|_| case(&mut random, speed)).collect();
        let pairs = pairs(&cases, smoothing);
        let x: Vec<[Vec3; N]> = cases.iter().map(|case| case.x).collect();
        let mut values = vec![0.0; x.len()];
        let mut gradients = vec![[Vec3::zeros(); N]; x.len()];
        let mut hessians: Vec<LocalHessian<N>> = vec![[[Default::default(); N]; N]; x.len()];
        pairs.values_into(0, &x, &mut values);
        pairs.gradients_into(0, &x, &mut gradients);
        pairs.hessians_into(0, &x, Projection::None, &mut hessians);
        for (k, case) in cases.iter().enumerate() {
            let flat: [f64; M] = std::array::from_fn(|i| case.x[i / 3][i % 3]);
            let expected = textbook(case, smoothing, &Jet2::variables(flat));
            // Sums of positions of size one are rounded; relative to the way, that is the error of the slip's direction.
            let slip_error = 1e-14 / (speed / A);
            let size = case.force.magnitude.abs();
            let rounding = 1e-15 * 4.0 * size;
            assert!((values[k] - expected.value).abs() < 1e-13 * expected.value.abs() + rounding);
            let stiff = A * size / EPSILON;
            for i in 0..M {
                let entry = gradients[k][i / 3][i % 3];
                assert!((entry - expected.gradient[i]).abs() < 1e-9 * size, "{speed} {entry}");
                for j in 0..=i {
                    let entry = hessians[k][i / 3][j / 3][(i % 3, j % 3)];
                    let allowed = stiff * (1e-12 + slip_error);
                    assert!((entry - expected.hessian(i, j)).abs() < allowed.max(1e-9 * stiff), "{speed}");
                }
            }
        }
    }
}

#[test]
fn derivatives_agree_with_automatic_differentiation() {
    for smoothing in [Smoothing::Quadratic, Smoothing::Quintic] {
        compare::<1, 3>(smoothing);
        compare::<2, 6>(smoothing);
        compare::<3, 9>(smoothing);
        compare::<4, 12>(smoothing);
    }
}

fn whole<const N: usize, const M: usize>(hessian: &LocalHessian<N>) -> SMatrix<f64, M, M> {
    SMatrix::from_fn(|i, j| {
        let (i, j) = (i.max(j), i.min(j));
        hessian[i / 3][j / 3][(i % 3, j % 3)]
    })
}

#[test]
fn the_projection_in_the_plane_is_that_of_the_whole_hessian() {
    let mut random = Random(5);
    let mut changed = 0;
    for speed in [0.0, 1e-3, 1.5e-2, 3e-2, 1.0] {
        let cases: Vec<Case<4>> = (0..40).map(|_| case(&mut random, speed)).collect();
        let pairs = pairs(&cases, Smoothing::Quadratic);
        for (k, case) in cases.iter().enumerate() {
            let raw = whole::<4, 12>(&pairs.hessian(k, &case.x, Projection::None));
            for projection in [Projection::Clamp, Projection::Absolute] {
                let expected = project_symmetric(&raw, projection);
                let projected = whole::<4, 12>(&pairs.hessian(k, &case.x, projection));
                assert!((projected - expected).amax() <= 1e-13 * raw.amax(), "{speed}");
                changed += u32::from((expected - raw).amax() > 1e-3 * raw.amax());
            }
        }
    }
    assert!(changed > 50, "{changed}");
}

#[test]
fn at_zero_slip_the_gradient_vanishes_and_the_hessian_is_that_of_a_dashpot() {
    let mut random = Random(6);
    let case: Case<4> = case(&mut random, 0.0);
    let pairs = pairs(std::slice::from_ref(&case), Smoothing::Quadratic);
    let gradient = pairs.gradient(0, &case.x);
    let size = (case.force.magnitude * case.coefficient.at_rest()).abs();
    // What rounding of positions leaves of the slip.
    assert!(gradient.iter().all(|g| g.norm() < 1e-15 * A * 2.0 / EPSILON * size));
    let n = case.force.normal;
    let plane = mechanics_core::tensor::Mat3::identity() - n * n.transpose();
    let factor = case.force.magnitude * case.coefficient.at_rest() * A * 2.0 / EPSILON;
    let hessian = pairs.hessian(0, &case.x, Projection::None);
    for i in 0..4 {
        for j in 0..=i {
            let weights = case.force.weights();
            let expected = plane * (factor * weights[i] * weights[j]);
            assert!((hessian[i][j] - expected).amax() < 1e-9 * factor.abs());
        }
    }
}

#[test]
fn forces_are_opposite_to_the_slip_within_the_cone_and_add_up_to_nothing() {
    let mut random = Random(7);
    for speed in [1e-9, 1e-4, 1e-2, 1.0, 1e3] {
        for _ in 0..50 {
            let case: Case<4> = case(&mut random, speed);
            let coefficients = Coefficients { inertia: A * A, velocity: A };
            let scheme = Scheme::new(coefficients, &case.origin, &case.origin);
            let mut force = case.force;
            force.magnitude = 5.0;
            let forces = [force];
            let friction =
                LaggedFriction::new(law(Smoothing::Quadratic), &forces, &[case.coefficient], &scheme)
                    .unwrap();
            let pair = friction.pairs(&case.x)[0];
            assert!(pair.force.norm() <= pair.bound * (1.0 + 1e-14));
            assert!(pair.bound == 5.0 * case.coefficient.at_rest());
            let cosine = pair.force.normalize().dot(&pair.slip_velocity.normalize());
            assert!((cosine + 1.0).abs() < 1e-14);
            assert!(pair.force.dot(&case.force.normal).abs() < 1e-6 * pair.bound);
            let all = friction.forces(&case.x);
            let (sum, size): (Vec3, f64) = (all.iter().sum(), all.iter().map(Vec3::norm).sum());
            assert!(sum.norm() <= 1e-15 * size.max(f64::MIN_POSITIVE) * 4.0, "{sum}");
            for (point, weight) in pair.points().iter().zip(pair.weights()) {
                let expected = pair.force * *weight;
                // Slips of positions of size one are rounded to A 1e-15.
                assert!((all[*point as usize] - expected).norm() < 2e-15 * A / EPSILON * pair.bound);
            }
            let power = pair.force.norm() * pair.slip_velocity.norm();
            assert!((friction.heat(&case.x, 3.0) - 3.0 * power).abs() <= 1e-13 * power);
        }
    }
}

#[test]
fn one_pair_alone_and_in_a_run_agree() {
    let mut random = Random(8);
    let cases: Vec<Case<3>> = (0..7).map(|_| case(&mut random, 5e-3)).collect();
    let pairs = pairs(&cases, Smoothing::Quintic);
    let x: Vec<[Vec3; 3]> = cases.iter().map(|case| case.x).collect();
    let mut gradients = vec![[Vec3::zeros(); 3]; 5];
    pairs.gradients_into(2, &x[2..], &mut gradients);
    for (k, gradient) in gradients.iter().enumerate() {
        assert_eq!(*gradient, pairs.gradient(2 + k, &x[2 + k]));
    }
}

#[test]
fn bases_are_orthonormal_and_the_energy_does_not_care_which() {
    let mut random = Random(9);
    for k in 0..1000 {
        let normal = match k {
            0 => Vec3::x(),
            1 => -Vec3::z(),
            2 => Vec3::new(1.0, 1.0, 1.0).normalize(),
            3 => Vec3::new(1e-200, 1.0, 0.0),
            _ => random.vector().normalize(),
        };
        let basis = SlidingBasis::across(&normal);
        let [a, b] = basis.columns();
        for (product, expected) in
            [(a.dot(a), 1.0), (b.dot(b), 1.0), (a.dot(b), 0.0), (a.dot(&normal), 0.0), (b.dot(&normal), 0.0)]
        {
            assert!((product - expected).abs() < 1e-15, "{normal}");
        }
        assert!((a.cross(b) - normal).norm() < 1e-15);
        let v = random.vector();
        let back = basis.vector(basis.components(&v)) + normal * normal.dot(&v);
        assert!((back - v).norm() < 2e-15);
    }
}

#[test]
fn a_rotating_sphere_drags_what_touches_it() {
    // A sphere about c that moves with ċ and turns with ω, seen by a particle at rest on top of it: the slip is the
    // surface's velocity with the other sign; at a pole of the rotation it is the translation alone.
    let (centre, velocity, omega) =
        (Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.5, 0.0, 0.2), Vec3::new(0.0, 2.0, 0.0));
    let particle = centre + Vec3::new(0.0, 0.0, 0.4);
    let basis = SlidingBasis::on_sphere(&particle, &centre).unwrap();
    let surface = ipc_friction::basis::sphere_surface_velocity(&particle, &centre, &velocity, &omega);
    let slip = basis.vector(basis.components(&-surface));
    assert!((slip - Vec3::new(-0.5 - 2.0 * 0.4, 0.0, 0.0)).norm() < 1e-15, "{slip}");
    assert_eq!(SlidingBasis::on_sphere(&centre, &centre), None);
}

#[test]
fn a_value_that_is_not_a_number_shows() {
    let mut random = Random(10);
    let case: Case<2> = case(&mut random, 1.0);
    let pairs = pairs(std::slice::from_ref(&case), Smoothing::Quadratic);
    let x = [case.x[0], Vec3::repeat(f64::NAN)];
    assert!(pairs.value(0, &x).is_nan());
    assert!(pairs.gradient(0, &x)[0].x.is_nan());
}

#[test]
fn the_floor_raises_the_curvature_along_the_slip_and_nothing_else() {
    let mut random = Random(12);
    for speed in [1e-3, 1.0] {
        let case: Case<1> = case(&mut random, speed);
        let mut pairs = pairs(std::slice::from_ref(&case), Smoothing::Quadratic);
        pairs.pairs[0].strength = Strength::new(mu(0.5), 5.0);
        let slip = pairs.slip_velocity(0, &case.x);
        let (along, across) = (slip.normalize(), case.force.normal.cross(&slip).normalize());
        let hessian = |pairs: &FrictionPairs<1>| pairs.hessian(0, &case.x, Projection::None)[0][0];
        let before = hessian(&pairs);
        pairs.floor = 0.25;
        let after = hessian(&pairs);
        let (stiff, soft) = (across.dot(&(before * across)), along.dot(&(before * along)));
        assert!((along.dot(&(after * along)) - soft.max(0.25 * stiff)).abs() < 1e-9 * stiff);
        assert!((after * across - before * across).norm() < 1e-9 * stiff);
        assert!((after * case.force.normal).norm() < 1e-9 * stiff);
    }
}
