//! Energies of pairs against automatic differentiation, finite differences, and the eigen-decomposition of the whole Hessian.
#![allow(clippy::unwrap_used)]

use ipc_contact::barrier::SquaredDistanceBarrier;
use ipc_contact::distance::EdgeEdgeMollifier;
use ipc_contact::pair::{
    Curvature, EdgeEdgePairs, PairLaw, PointEdgePairs, PointPointPairs, PointTrianglePairs,
};
use mechanics_core::jet::Jet2;
use mechanics_core::projection::{Projection, project_symmetric};
use mechanics_core::scalar::Scalar;
use mechanics_core::stencil::{LocalHessian, Stencil};
use mechanics_core::tensor::{Vec3, cross, dot};
use nalgebra::SMatrix;

/// Activation distance of all tests.
const ACTIVATION: f64 = 1e-3;
/// Stiffness of all tests.
const STIFFNESS: f64 = 3e7;

/// Numbers in [−1, 1), the same in every run.
struct Random(u64);

impl Random {
    fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
    fn share(&mut self) -> f64 {
        0.5 + 0.5 * self.number()
    }
    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.number(), self.number(), self.number())
    }
    fn direction(&mut self) -> Vec3 {
        loop {
            let v = self.vector();
            if (0.01..1.0).contains(&v.norm_squared()) {
                return v.normalize();
            }
        }
    }
}

type Row<const N: usize> = [[f64; 3]; N];

fn minus<S: Scalar>(a: &[S; 3], b: &[S; 3]) -> [S; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Squared distances in textbook form, for jets: |a × b|²/|b|² and the like, none of the code under test.
fn textbook<S: Scalar, const N: usize>(kind: Kind, x: &[[S; 3]; N]) -> S {
    let square = |a: &[S; 3]| dot(a, a);
    match kind {
        Kind::PointPoint => square(&minus(&x[0], &x[1])),
        Kind::PointLine => {
            let e = minus(&x[2], &x[1]);
            square(&cross(&minus(&x[0], &x[1]), &e)) / square(&e)
        }
        Kind::PointPlane => {
            let normal = cross(&minus(&x[2], &x[1]), &minus(&x[3], &x[1]));
            dot(&minus(&x[0], &x[1]), &normal).square() / square(&normal)
        }
        Kind::LineLine => {
            let normal = cross(&minus(&x[1], &x[0]), &minus(&x[3], &x[2]));
            dot(&minus(&x[0], &x[2]), &normal).square() / square(&normal)
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    PointPoint,
    PointLine,
    PointPlane,
    LineLine,
}

/// w κ b by the textbook.
fn energy<S: Scalar, const N: usize>(kind: Kind, weight: f64, x: &[[S; 3]; N]) -> S {
    let activation = ACTIVATION * ACTIVATION;
    let s = textbook(kind, x);
    let below = s.offset(-activation);
    -(below.square() * s.scale(1.0 / activation).ln()).scale(weight * STIFFNESS)
}

fn jets<const N: usize, const M: usize>(x: &[Vec3; N]) -> [[Jet2<f64, M>; 3]; N] {
    let mut flat = [0.0; M];
    for (k, entry) in x.iter().flatten().enumerate() {
        flat[k] = *entry;
    }
    let variables = Jet2::variables(flat);
    std::array::from_fn(|i| std::array::from_fn(|k| variables[3 * i + k]))
}

fn flatten<const N: usize, const M: usize>(hessian: &LocalHessian<N>) -> SMatrix<f64, M, M> {
    SMatrix::from_fn(|row, column| {
        let (row, column) = (row.max(column), row.min(column));
        hessian[row / 3][column / 3][(row % 3, column % 3)]
    })
}

fn check<const N: usize, const M: usize>(
    kind: Kind,
    stencil: &impl Stencil<N>,
    x: &[Vec3; N],
    weight: f64,
) -> [f64; 4] {
    let exact = energy(kind, weight, &jets::<N, M>(x));
    let value = stencil.value(0, x);
    let value_error = (value - exact.value).abs() / exact.value.abs();
    let gradient = stencil.gradient(0, x);
    let largest = exact.gradient.iter().fold(0.0_f64, |m, g| m.max(g.abs()));
    let gradient_error =
        (0..M).map(|k| (gradient[k / 3][k % 3] - exact.gradient[k]).abs()).fold(0.0, f64::max) / largest;
    let hessian: SMatrix<f64, M, M> = flatten(&stencil.hessian(0, x, Projection::None));
    let whole: SMatrix<f64, M, M> = SMatrix::from_fn(|i, j| exact.hessian(i, j));
    let hessian_error = (hessian - whole).amax() / whole.amax();
    let mut projection_error = 0.0_f64;
    for projection in [Projection::Clamp, Projection::Absolute] {
        let projected: SMatrix<f64, M, M> = flatten(&stencil.hessian(0, x, projection));
        let expected = project_symmetric(&hessian, projection);
        projection_error = projection_error.max((projected - expected).amax() / whole.amax());
    }
    [value_error, gradient_error, hessian_error, projection_error]
}

#[test]
fn random_pairs() {
    let barrier = SquaredDistanceBarrier::new(ACTIVATION).unwrap();
    let mut random = Random(1);
    let mut worst = [[0.0_f64; 4]; 4];
    for k in 0..2000 {
        let weight = if k % 2 == 0 { 0.7 } else { -0.3 };
        let weights = [weight];
        let law = PairLaw { barrier: &barrier, stiffness: STIFFNESS, curvature: Curvature::Full };
        let d = ACTIVATION * (0.01 + 0.98 * random.share());
        let scale = 1e-2;
        let n = random.direction();
        let t = n.cross(&random.direction()).normalize();
        let q = n.cross(&t);
        let origin = random.vector() * scale;
        let triangle: [Vec3; 3] =
            std::array::from_fn(|_| origin + (t * random.number() + q * random.number()) * scale);
        let (a, b) = (random.share(), random.share());
        let foot = |a: f64, b: f64| triangle[0] * (1.0 - a) + (triangle[1] * (1.0 - b) + triangle[2] * b) * a;
        let p = foot(a, b) + n * d;
        let (u, v) = (triangle[0] - origin, triangle[1] - origin);
        let lines =
            [origin - u * a, origin + u * (1.0 - a), origin - v * b + n * d, origin + v * (1.0 - b) + n * d];
        let mollifiers = [EdgeEdgeMollifier { threshold: 0.0 }];
        let errors = [
            check::<2, 6>(
                Kind::PointPoint,
                &PointPointPairs { law, weights: &weights },
                &[p, p - n * d],
                weight,
            ),
            check::<3, 9>(
                Kind::PointLine,
                &PointEdgePairs { law, weights: &weights },
                &[triangle[0] * (1.0 - a) + triangle[1] * a + n * d, triangle[0], triangle[1]],
                weight,
            ),
            check::<4, 12>(
                Kind::PointPlane,
                &PointTrianglePairs { law, weights: &weights },
                &[p, triangle[0], triangle[1], triangle[2]],
                weight,
            ),
            check::<4, 12>(
                Kind::LineLine,
                &EdgeEdgePairs { law, weights: &weights, mollifiers: &mollifiers, regions: &[] },
                &lines,
                weight,
            ),
        ];
        for (worst, errors) in worst.iter_mut().zip(errors) {
            for (worst, error) in worst.iter_mut().zip(errors) {
                *worst = worst.max(if error.is_nan() { f64::INFINITY } else { error });
            }
        }
    }
    for errors in worst {
        assert!(errors.into_iter().all(|error| error < 1e-9), "{worst:?}");
    }
}
