//! Energies of pairs against automatic differentiation, finite differences, and the eigen-decomposition of the whole
//! Hessian.
#![allow(clippy::unwrap_used)]

use ipc_contact::barrier::{Barrier, DistanceBarrier, PhysicalBarrier, SquaredDistanceBarrier};
use ipc_contact::distance::{EdgeEdgeMollifier, Region, edge_edge_region};
use ipc_contact::pair::{
    Curvature, EdgeEdgePairs, HalfSpacePairs, PairLaw, PointEdgePairs, PointPointPairs, PointTrianglePairs,
};
use mechanics_core::derivatives::check_stencil;
use mechanics_core::jet::Jet2;
use mechanics_core::projection::{Projection, project_symmetric};
use mechanics_core::scalar::Scalar;
use mechanics_core::stencil::{LocalHessian, Stencil};
use mechanics_core::tensor::{Mat3, Vec3, cross, dot};
use nalgebra::SMatrix;

/// Activation distance of all tests \[m\]; features have lengths of about a centimetre.
const ACTIVATION: f64 = 1e-3;
const STIFFNESS: f64 = 3e7;
const LENGTH: f64 = 1e-2;

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
    /// Log-uniform.
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.share())
    }
    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.number(), self.number(), self.number())
    }
    /// Three orthonormal vectors.
    fn frame(&mut self) -> [Vec3; 3] {
        loop {
            let (a, b) = (self.vector(), self.vector());
            let n = a.cross(&b);
            if n.norm() > 0.1 {
                return [a.normalize(), n.normalize(), a.cross(&n).normalize()];
            }
        }
    }
    fn weight(&mut self) -> f64 {
        let size = self.between(0.1, 10.0);
        if self.number() < -0.4 { -size } else { size }
    }
}

/// A gap and the sine of the angle of two edges of a feature: ordinary, or one of three degeneracies.
///
/// Rounding of the positions changes derivatives by ε (L/d)/sin θ + ε (d/L)/sin²θ relatively, in any formula, so the
/// ranges are those where that is below 1e-10.
fn gap_and_sine(random: &mut Random) -> (f64, f64) {
    let ordinary = (ACTIVATION * (0.05 + 0.9 * random.share()), 0.2 + 0.8 * random.share());
    match (random.share() * 4.0) as u32 {
        0 => (ACTIVATION * random.between(1e-4, 0.05), ordinary.1),
        1 => (ACTIVATION * (1.0 - random.between(1e-4, 0.05)), ordinary.1),
        2 => (ordinary.0, random.between(5e-4, 0.2)),
        _ => ordinary,
    }
}

fn two_points(random: &mut Random) -> [Vec3; 2] {
    let (gap, _) = gap_and_sine(random);
    let x = random.vector() * LENGTH;
    [x, x + random.frame()[0] * gap]
}

fn point_and_edge(random: &mut Random) -> [Vec3; 3] {
    let (gap, sine) = gap_and_sine(random);
    let [t, n, _] = random.frame();
    let a = random.vector() * LENGTH;
    let edge = t * (LENGTH * sine);
    [a + edge * random.share() + n * gap, a, a + edge]
}

/// The triangle's smallest height over its longest edge is about the sine.
fn point_and_triangle(random: &mut Random) -> [Vec3; 4] {
    let (gap, sine) = gap_and_sine(random);
    let [t, n, q] = random.frame();
    let a = random.vector() * LENGTH;
    let (e1, e2) = (t * LENGTH, (t * random.number() + q * sine) * LENGTH);
    let (u, v) = (random.share(), random.share());
    let foot = a + (e1 * (1.0 - v) + e2 * v) * u;
    let corners = [a, a + e1, a + e2];
    let turn = (random.share() * 3.0) as usize;
    [foot + n * gap, corners[turn % 3], corners[(turn + 1) % 3], corners[(turn + 2) % 3]]
}

fn two_edges(random: &mut Random) -> [Vec3; 4] {
    let (gap, sine) = gap_and_sine(random);
    let [t, n, q] = random.frame();
    let a = random.vector() * LENGTH;
    let (e1, e2) =
        (t * LENGTH, (t * (1.0 - sine * sine).sqrt() + q * sine) * LENGTH * random.between(0.1, 1.0));
    let (u, v) = (random.share(), random.share());
    [a - e1 * u, a + e1 * (1.0 - u), a - e2 * v + n * gap, a + e2 * (1.0 - v) + n * gap]
}

/// Edges below the mollifier's threshold that need not be closest between their ends.
fn parallel_edges(random: &mut Random) -> [Vec3; 4] {
    let [t, n, q] = random.frame();
    let a = random.vector() * LENGTH;
    let sine = random.between(1e-4, 0.02);
    let (e1, e2) = (t * LENGTH, (t + q * sine) * LENGTH * random.between(0.3, 1.0));
    let b = a + e1 * (0.8 * random.number()) + n * (ACTIVATION * (0.1 + 0.5 * random.share()));
    if random.number() < 0.0 { [a, a + e1, b, b + e2] } else { [a, a + e1, b + e2, b] }
}

fn minus<S: Scalar>(a: &[S; 3], b: &[S; 3]) -> [S; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Squared distances in textbook form, for jets: |a × b|²/|b|² and the like.
fn textbook<S: Scalar>(region: Region, x: &[[S; 3]]) -> S {
    let square = |a: &[S; 3]| dot(a, a);
    let at = |place: u8| &x[usize::from(place)];
    match region {
        Region::PointPoint([p, a]) => square(&minus(at(p), at(a))),
        Region::PointEdge([p, a, b]) => {
            let e = minus(at(b), at(a));
            square(&cross(&minus(at(p), at(a)), &e)) / square(&e)
        }
        Region::PointTriangle([p, a, b, c]) => {
            let normal = cross(&minus(at(b), at(a)), &minus(at(c), at(a)));
            dot(&minus(at(p), at(a)), &normal).square() / square(&normal)
        }
        Region::EdgeEdge([a, b, c, d]) => {
            let normal = cross(&minus(at(b), at(a)), &minus(at(d), at(c)));
            dot(&minus(at(a), at(c)), &normal).square() / square(&normal)
        }
    }
}

/// −(s − ŝ)² ln(s/ŝ) by the textbook.
fn squared_form<S: Scalar>(s: S) -> S {
    let activation = ACTIVATION * ACTIVATION;
    -(s.offset(-activation).square() * s.scale(1.0 / activation).ln())
}

/// Li et al. 2020, equation 24.
fn mollifier<S: Scalar>(threshold: f64, x: &[[S; 3]]) -> S {
    let n = cross(&minus(&x[1], &x[0]), &minus(&x[3], &x[2]));
    let part = dot(&n, &n).scale(1.0 / threshold);
    S::select(part.less(S::constant(1.0)), part.scale(2.0) - part.square(), S::constant(1.0))
}

fn jets<const N: usize, const M: usize>(x: &[Vec3; N]) -> [[Jet2<f64, M>; 3]; N] {
    let mut flat = [0.0; M];
    for (flat, entry) in flat.iter_mut().zip(x.iter().flatten()) {
        *flat = *entry;
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

/// The largest relative errors met: value, gradient, Hessian, projected Hessian.
#[derive(Debug, Default)]
struct Worst([f64; 4]);

impl Worst {
    fn add<const N: usize, const M: usize>(
        &mut self,
        stencil: &impl Stencil<N>,
        x: &[Vec3; N],
        exact: &Jet2<f64, M>,
        projection: Projection,
    ) {
        let value = (stencil.value(0, x) - exact.value).abs() / exact.value.abs();
        let gradient = stencil.gradient(0, x);
        let largest = exact.gradient.iter().fold(0.0_f64, |m, g| m.max(g.abs()));
        let difference = (0..M).map(|k| (gradient[k / 3][k % 3] - exact.gradient[k]).abs());
        let gradient = difference.fold(0.0, f64::max) / largest;
        let hessian: SMatrix<f64, M, M> = flatten(&stencil.hessian(0, x, Projection::None));
        let whole: SMatrix<f64, M, M> = SMatrix::from_fn(|i, j| exact.hessian(i, j));
        let curved = (hessian - whole).amax() / whole.amax();
        let projected: SMatrix<f64, M, M> = flatten(&stencil.hessian(0, x, projection));
        let projected = (projected - project_symmetric(&hessian, projection)).amax() / whole.amax();
        for (worst, error) in self.0.iter_mut().zip([value, gradient, curved, projected]) {
            *worst = worst.max(if error.is_nan() { f64::INFINITY } else { error });
        }
    }

    /// 1e-9 for the derivatives, 1e-10 for the projection.
    fn require(&self) {
        let allowed = [1e-9, 1e-9, 1e-9, 1e-10];
        assert!(self.0.iter().zip(allowed).all(|(&error, allowed)| error < allowed), "{self:?}");
    }
}

/// States of every kind of pair, near-degenerate ones among them; the figure promised is 1e5.
const STATES: usize = 20_000;

fn compare<const N: usize, const M: usize>(
    region: Region,
    make: impl Fn(&mut Random) -> [Vec3; N],
    check: impl Fn(PairLaw<'_, SquaredDistanceBarrier>, &[f64], &[Vec3; N], &Jet2<f64, M>, Projection, &mut Worst),
) {
    let barrier = SquaredDistanceBarrier::new(ACTIVATION).unwrap();
    let law = PairLaw { barrier: &barrier, stiffness: STIFFNESS, curvature: Curvature::Full };
    let (mut random, mut worst) = (Random(N as u64), Worst::default());
    for k in 0..STATES {
        let (x, weight) = (make(&mut random), random.weight());
        let exact = squared_form(textbook(region, &jets::<N, M>(&x))).scale(weight * STIFFNESS);
        let projection = if k % 2 == 0 { Projection::Clamp } else { Projection::Absolute };
        check(law, &[weight], &x, &exact, projection, &mut worst);
    }
    worst.require();
}

#[test]
fn two_points_agree_with_automatic_differentiation_and_the_whole_projection() {
    compare::<2, 6>(Region::PointPoint([0, 1]), two_points, |law, weights, x, exact, projection, worst| {
        worst.add(&PointPointPairs { law, weights }, x, exact, projection);
    });
}

#[test]
fn a_point_and_an_edge_agree_with_automatic_differentiation_and_the_whole_projection() {
    compare::<3, 9>(
        Region::PointEdge([0, 1, 2]),
        point_and_edge,
        |law, weights, x, exact, projection, worst| {
            worst.add(&PointEdgePairs { law, weights }, x, exact, projection);
        },
    );
}

#[test]
fn a_point_and_a_triangle_agree_with_automatic_differentiation_and_the_whole_projection() {
    let region = Region::PointTriangle([0, 1, 2, 3]);
    compare::<4, 12>(region, point_and_triangle, |law, weights, x, exact, projection, worst| {
        worst.add(&PointTrianglePairs { law, weights }, x, exact, projection);
    });
}

#[test]
fn two_edges_agree_with_automatic_differentiation_and_the_whole_projection() {
    let mollifiers = &[EdgeEdgeMollifier { threshold: 0.0 }];
    let region = Region::EdgeEdge([0, 1, 2, 3]);
    compare::<4, 12>(region, two_edges, |law, weights, x, exact, projection, worst| {
        worst.add(&EdgeEdgePairs { law, weights, mollifiers, regions: &[] }, x, exact, projection);
    });
}

#[test]
fn nearly_parallel_edges_agree_with_automatic_differentiation_in_every_region() {
    let barrier = SquaredDistanceBarrier::new(ACTIVATION).unwrap();
    let law = PairLaw { barrier: &barrier, stiffness: STIFFNESS, curvature: Curvature::Full };
    let (mut random, mut worst) = (Random(9), Worst::default());
    let mut met = [0; 3];
    for k in 0..STATES {
        let (x, weight) = (parallel_edges(&mut random), random.weight());
        let mollifiers = &[EdgeEdgeMollifier::from_rest(&x)];
        assert!(mollifiers[0].is_active(&x));
        let region = edge_edge_region(&x);
        if region.value(&x) > 0.99 * ACTIVATION * ACTIVATION {
            continue;
        }
        met[match region {
            Region::PointPoint(_) => 0,
            Region::PointEdge(_) => 1,
            _ => 2,
        }] += 1;
        let jets = jets::<4, 12>(&x);
        let exact = squared_form(textbook(region, &jets)).scale(weight * STIFFNESS)
            * mollifier(mollifiers[0].threshold, &jets);
        let projection = if k % 2 == 0 { Projection::Clamp } else { Projection::Absolute };
        worst.add(
            &EdgeEdgePairs { law, weights: &[weight], mollifiers, regions: &[] },
            &x,
            &exact,
            projection,
        );
    }
    worst.require();
    assert!(met.iter().all(|&count| count > 100), "regions met: {met:?}");
}

#[test]
fn derivatives_agree_with_finite_differences_for_every_barrier() {
    let barriers: [Box<dyn Barrier>; 3] = [
        Box::new(SquaredDistanceBarrier::new(ACTIVATION).unwrap()),
        Box::new(DistanceBarrier::new(ACTIVATION).unwrap()),
        Box::new(PhysicalBarrier::new(ACTIVATION).unwrap()),
    ];
    let mut random = Random(5);
    for barrier in &barriers {
        let law = PairLaw { barrier: &**barrier, stiffness: STIFFNESS, curvature: Curvature::GaussNewton };
        for weight in [1.3, -0.4] {
            let weights = &[weight];
            let [t, n, q] = random.frame();
            let (e1, e2) = (t * 2e-3, (t * 0.3 + q) * 2e-3);
            let [a, b] = [Vec3::zeros(), n * (0.4 * ACTIVATION)];
            check_stencil(&PointPointPairs { law, weights }, 0, &[a, b]).require(1e-7).unwrap();
            let x = [b + e1 * 0.3, a, a + e1];
            check_stencil(&PointEdgePairs { law, weights }, 0, &x).require(1e-7).unwrap();
            let x = [b + e1 * 0.3 + e2 * 0.4, a, a + e1, a + e2];
            check_stencil(&PointTrianglePairs { law, weights }, 0, &x).require(1e-7).unwrap();
            let x = [a - e1 * 0.4, a + e1, b - e2, b + e2 * 0.5];
            let mollifiers = &[EdgeEdgeMollifier::from_rest(&x)];
            check_stencil(&EdgeEdgePairs { law, weights, mollifiers, regions: &[] }, 0, &x)
                .require(1e-7)
                .unwrap();
            let e2 = e1 + q * 2e-5;
            let x = [a - e1 * 0.4, a + e1, b - e2, b + e2 * 0.5];
            let mollifiers = &[EdgeEdgeMollifier::from_rest(&x)];
            check_stencil(&EdgeEdgePairs { law, weights, mollifiers, regions: &[] }, 0, &x)
                .require(1e-7)
                .unwrap();
            let planes = &[(n, -0.1 * ACTIVATION)];
            check_stencil(&HalfSpacePairs { law, weights, planes }, 0, &[b + t]).require(1e-7).unwrap();
        }
    }
}

#[test]
fn a_half_space_has_an_inside() {
    let barrier = SquaredDistanceBarrier::new(ACTIVATION).unwrap();
    let law = PairLaw { barrier: &barrier, stiffness: STIFFNESS, curvature: Curvature::Full };
    let pairs = HalfSpacePairs { law, weights: &[2.0], planes: &[(Vec3::z(), 0.5)] };
    let at = |gap: f64| [Vec3::new(3.0, -1.0, 0.5 + gap)];
    let s = (0.5 + 0.3 * ACTIVATION - 0.5_f64).powi(2);
    assert_eq!(pairs.value(0, &at(0.3 * ACTIVATION)), 2.0 * STIFFNESS * barrier.value(s));
    assert_eq!(pairs.value(0, &at(0.0)), f64::INFINITY);
    assert_eq!(pairs.value(0, &at(-0.3 * ACTIVATION)), f64::INFINITY);
    assert_eq!(pairs.value(0, &at(-1.0)), f64::INFINITY);
    assert_eq!(pairs.value(0, &at(2.0 * ACTIVATION)), 0.0);
    assert!(pairs.gradient(0, &at(0.3 * ACTIVATION))[0].z < 0.0);
}

/// The smallest and largest eigenvalue.
fn extremes(hessian: &LocalHessian<4>) -> [f64; 2] {
    let values = flatten::<4, 12>(hessian).symmetric_eigenvalues();
    [values.min(), values.max()]
}

#[test]
fn gauss_newton_is_the_curvature_along_the_gap_and_semi_definite() {
    let barrier = SquaredDistanceBarrier::new(ACTIVATION).unwrap();
    let full = PairLaw { barrier: &barrier, stiffness: STIFFNESS, curvature: Curvature::Full };
    let law = PairLaw { curvature: Curvature::GaussNewton, ..full };
    let mut random = Random(11);
    for _ in 0..1000 {
        let x = two_points(&mut random);
        let [exact, rank_one] = [full, law].map(|law| {
            flatten::<2, 6>(&PointPointPairs { law, weights: &[1.0] }.hessian(0, &x, Projection::Clamp))
        });
        assert!((exact - rank_one).amax() < 1e-12 * exact.amax(), "two points: it is the clamped Hessian");
        let x = point_and_triangle(&mut random);
        let pairs = PointTrianglePairs { law, weights: &[1.0] };
        let hessian = flatten::<4, 12>(&pairs.hessian(0, &x, Projection::Clamp));
        let [smallest, largest] = extremes(&pairs.hessian(0, &x, Projection::Clamp));
        assert!(smallest > -1e-13 * largest);
        // Along p = ∂x/∂d (the point moves along the gap) it is w κ d²b/dd², which is the true second derivative.
        let truth = flatten::<4, 12>(&pairs.hessian(0, &x, Projection::None));
        assert!((hessian - truth).fixed_view::<3, 3>(0, 0).amax() < 1e-9 * truth.amax());
        let negative = PointTrianglePairs { law, weights: &[-1.0] };
        assert_eq!(extremes(&negative.hessian(0, &x, Projection::Clamp))[1], 0.0);
        let mirrored = flatten::<4, 12>(&negative.hessian(0, &x, Projection::Absolute));
        assert!((mirrored - hessian).amax() < 1e-12 * hessian.amax());
    }
}

#[test]
fn projected_hessians_are_semi_definite_for_weights_of_either_sign() {
    let barrier = PhysicalBarrier::new(ACTIVATION).unwrap();
    let law = PairLaw { barrier: &barrier, stiffness: STIFFNESS, curvature: Curvature::Full };
    let mut random = Random(12);
    for _ in 0..2000 {
        let weights = &[random.weight()];
        let (crossing, parallel) = (two_edges(&mut random), parallel_edges(&mut random));
        for x in [crossing, parallel] {
            let mollifiers = &[EdgeEdgeMollifier::from_rest(&x)];
            let pairs = EdgeEdgePairs { law, weights, mollifiers, regions: &[] };
            for projection in [Projection::Clamp, Projection::Absolute] {
                let [smallest, largest] = extremes(&pairs.hessian(0, &x, projection));
                assert!(smallest >= -1e-13 * largest, "{smallest:e} of {largest:e}");
            }
        }
    }
}

#[test]
fn a_run_gives_what_its_pairs_give_one_by_one() {
    let barrier = SquaredDistanceBarrier::new(ACTIVATION).unwrap();
    let law = PairLaw { barrier: &barrier, stiffness: STIFFNESS, curvature: Curvature::Full };
    let mut random = Random(13);
    let make = |k: usize, random: &mut Random| {
        if k.is_multiple_of(3) { parallel_edges(random) } else { two_edges(random) }
    };
    let x: Vec<[Vec3; 4]> = (0..41).map(|k| make(k, &mut random)).collect();
    let weights: Vec<f64> = x.iter().map(|_| random.weight()).collect();
    let mollifiers: Vec<EdgeEdgeMollifier> = x.iter().map(EdgeEdgeMollifier::from_rest).collect();
    let pairs = EdgeEdgePairs { law, weights: &weights, mollifiers: &mollifiers, regions: &[] };
    for (first, length) in [(0, 41), (1, 1), (3, 2), (5, 3), (8, 32), (7, 0)] {
        let run = &x[first..first + length];
        let mut values = vec![f64::NAN; length];
        let mut gradients = vec![[Vec3::zeros(); 4]; length];
        let mut hessians = vec![[[Mat3::zeros(); 4]; 4]; length];
        pairs.values_into(first, run, &mut values);
        pairs.gradients_into(first, run, &mut gradients);
        pairs.hessians_into(first, run, Projection::Clamp, &mut hessians);
        for k in 0..length {
            assert_eq!(values[k], pairs.value(first + k, &run[k]));
            assert_eq!(gradients[k], pairs.gradient(first + k, &run[k]));
            let alone = flatten::<4, 12>(&pairs.hessian(first + k, &run[k], Projection::Clamp));
            // Lanes wait for each other, and what they do meanwhile is rounding of the unprojected Hessian.
            let whole = flatten::<4, 12>(&pairs.hessian(first + k, &run[k], Projection::None));
            assert!((flatten::<4, 12>(&hessians[k]) - alone).amax() <= 1e-13 * whole.amax());
        }
    }
}

#[test]
fn at_contact_the_energy_is_infinite_and_beyond_activation_nothing_is_left() {
    let barrier = SquaredDistanceBarrier::new(ACTIVATION).unwrap();
    let law = PairLaw { barrier: &barrier, stiffness: STIFFNESS, curvature: Curvature::Full };
    let (a, b, c) = (Vec3::zeros(), Vec3::x(), Vec3::y());
    let foot = Vec3::new(0.25, 0.25, 0.0);
    let pairs = PointTrianglePairs { law, weights: &[1.0] };
    assert_eq!(pairs.value(0, &[foot, a, b, c]), f64::INFINITY);
    let far = [foot + Vec3::z() * 0.1, a, b, c];
    assert_eq!(pairs.value(0, &far), 0.0);
    assert!(pairs.gradient(0, &far).iter().all(|g| *g == Vec3::zeros()));
    assert_eq!(flatten::<4, 12>(&pairs.hessian(0, &far, Projection::Clamp)).amax(), 0.0);
    // The whole range down to where b″ overflows: finite or infinite, never NaN.
    for exponent in 4..150 {
        let x = [foot + Vec3::z() * 10.0_f64.powi(-exponent), a, b, c];
        assert!(pairs.value(0, &x) > 0.0);
        let hessian = flatten::<4, 12>(&pairs.hessian(0, &x, Projection::Clamp));
        assert!(exponent > 70 || hessian.iter().all(|entry| entry.is_finite()), "d = 1e-{exponent}");
    }
}
