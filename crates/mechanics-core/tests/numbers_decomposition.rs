//! Decompositions of 3×3 matrices: accuracy on every kind of matrix, against products formed in higher precision.

use mechanics_core::decomposition::{
    Polar, Svd, SymmetricEigen, polar_into, svd_into, svd_with_sweeps_into, symmetric_eigen,
};
use mechanics_core::lanes::{Element, LaneKernel, Packet, dispatch, load_matrices, store_matrices};
use mechanics_core::tensor::{self, Mat3, Matrix3};
use outlined::{eigen, polar, svd, svd_with_sweeps};

/// The decompositions compiled once for each number instead of into every call, for the time this file takes to build.
mod outlined {
    use mechanics_core::decomposition::{self, Polar, Svd, SymmetricEigen};
    use mechanics_core::scalar::Scalar;
    use mechanics_core::tensor::Matrix3;

    #[inline(never)]
    pub(super) fn svd<S: Scalar>(f: &Matrix3<S>) -> Svd<S> {
        decomposition::svd(f)
    }
    #[inline(never)]
    pub(super) fn svd_with_sweeps<S: Scalar>(f: &Matrix3<S>, sweeps: usize) -> Svd<S> {
        decomposition::svd_with_sweeps(f, sweeps)
    }
    #[inline(never)]
    pub(super) fn polar<S: Scalar>(f: &Matrix3<S>) -> Polar<S> {
        decomposition::polar(f)
    }
    #[inline(never)]
    pub(super) fn eigen<S: Scalar>(a: &Matrix3<S>) -> SymmetricEigen<S> {
        decomposition::symmetric_eigen(a)
    }
}

/// A small generator with a fixed seed (Steele, Lea, Flood 2014, SplitMix64).
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
    /// Uniform in [−1, 1).
    fn number(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
    fn matrix(&mut self) -> Mat3 {
        Mat3::from_fn(|_, _| self.number())
    }
    fn rotation(&mut self) -> Mat3 {
        let q = nalgebra::Quaternion::new(self.number(), self.number(), self.number(), self.number());
        nalgebra::UnitQuaternion::from_quaternion(q).to_rotation_matrix().into_inner()
    }
    fn with_singular_values(&mut self, s: [f64; 3]) -> Mat3 {
        let (u, v) = (self.rotation(), self.rotation());
        u * Mat3::from_diagonal(&s.into()) * v.transpose()
    }
}

/// Named lists of matrices, every kind that has ever hurt a decomposition.
fn families(r: &mut Random, count: usize) -> Vec<(String, Vec<Mat3>)> {
    let mut all = Vec::new();
    let mut add = |name: &str, make: &mut dyn FnMut(&mut Random) -> Mat3| {
        let list = (0..count).map(|_| make(r)).collect();
        all.push((name.to_string(), list));
    };
    add("random", &mut |r| r.matrix());
    add("identity", &mut |_| Mat3::identity());
    for size in [1e-1, 1e-3, 1e-6, 1e-9, 1e-15] {
        add(&format!("identity+{size:e}"), &mut |r| Mat3::identity() + r.matrix() * size);
        add(&format!("rotation+{size:e}"), &mut |r| r.rotation() + r.matrix() * size);
        add(&format!("rank1+{size:e}"), &mut |r| r.with_singular_values([1.0, 0.0, 0.0]) + r.matrix() * size);
    }
    for s in [
        [1.0, 1.0, 1.0],
        [1.0, 1.0, 0.5],
        [2.0, 1.0, 1.0],
        [1.0, 1.0, -1.0],
        [1.0, 0.5, -0.5],
        [1.0, 0.9, -0.1],
        [1.0, 1.0, 0.0],
        [1.0, 0.3, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1e-3, 1e-3],
        [1.0, 1e-4, -1e-4],
        [1e3, 1.0, 1e-3],
        [1e3, 1.0, -1e-3],
        [1e8, 1.0, 1e-8],
        [1e8, 1e8, 1e-8],
        [1e12, 1.0, 0.9],
        [1.0, 1.0, 1e-7],
        [1.0, 1.0 - 1e-9, 1.0 - 2e-9],
        [1.0, 1e-7, 1e-14],
        [1.0, 0.0, 0.0],
    ] {
        add(&format!("{s:?}"), &mut |r| r.with_singular_values(s));
    }
    add("integers", &mut |r| Mat3::from_fn(|_, _| (r.bits() % 5) as f64 - 2.0));
    add("zero", &mut |_| Mat3::zeros());
    add("one row", &mut |r| {
        let m = r.matrix();
        Mat3::from_fn(|i, j| if i == 0 { m[(i, j)] } else { 0.0 })
    });
    add("one column", &mut |r| {
        let m = r.matrix();
        Mat3::from_fn(|i, j| if j == 1 { m[(i, j)] } else { 0.0 })
    });
    add("permuted diagonal", &mut |r| {
        let k = (r.bits() % 3) as usize;
        Mat3::from_fn(|i, j| if (i + k) % 3 == j { r.number() } else { 0.0 })
    });
    add("log-uniform entries", &mut |r| Mat3::from_fn(|_, _| r.number() * (10.0 * r.number()).exp()));
    add("shear", &mut |r| {
        let mut m = Mat3::identity();
        m[(0, 1)] = 1e3 * r.number();
        m
    });
    all
}

fn widened<E: Element>(a: &Matrix3<E>) -> Mat3 {
    a.map(Into::into)
}

fn orthogonality(q: &Mat3) -> f64 {
    (q.transpose() * q - Mat3::identity()).norm()
}

/// The promised accuracy.
fn bar<E: Element>() -> f64 {
    if E::EPSILON < 1e-10 { 4e-15 } else { 1e-6 }
}

/// Divides by the norm, which is between 1e-150 and 1e153 here, or zero.
fn relative(error: &Mat3, norm: f64) -> f64 {
    error.norm() / norm.max(f64::MIN_POSITIVE)
}

#[track_caller]
fn check_svd<E: Element>(f: &Matrix3<E>, d: &Svd<E>, what: &str) {
    let (f, u, v) = (widened(f), widened(&d.u), widened(&d.v));
    let sigma = d.sigma.map(Into::into);
    let rebuilt = u * Mat3::from_diagonal(&sigma.into()) * v.transpose();
    let error = relative(&(rebuilt - f), f.norm());
    assert!(error <= bar::<E>(), "{what}: reconstruction {error:.1e} of {f}");
    let skew = orthogonality(&u).max(orthogonality(&v));
    assert!(skew <= bar::<E>(), "{what}: orthogonality {skew:.1e} of {f}");
    assert!(u.determinant() > 0.9 && v.determinant() > 0.9, "{what}: a reflection from {f}");
    assert!(sigma[0] >= sigma[1] && sigma[1] >= sigma[2].abs(), "{what}: order of {sigma:?}");
}

#[track_caller]
fn check_polar<E: Element>(f: &Matrix3<E>, d: &Polar<E>, what: &str) {
    assert_eq!(d.stretch, d.stretch.transpose(), "{what}: symmetry");
    let (f, r, s) = (widened(f), widened(&d.rotation), widened(&d.stretch));
    // Two roundings more than the decomposition it is made of: the products U Vᵀ and V Σ Vᵀ.
    let error = relative(&(r * s - f), f.norm()).max(orthogonality(&r));
    assert!(error <= 2.0 * bar::<E>(), "{what}: error {error:.1e} of {f}");
    assert!(r.determinant() > 0.9, "{what}: a reflection from {f}");
}

#[track_caller]
fn check_eigen<E: Element>(a: &Matrix3<E>, d: &SymmetricEigen<E>, what: &str) {
    let (a, q) = (widened(a), widened(&d.vectors));
    let values = d.values.map(Into::into);
    let error = relative(&(q * Mat3::from_diagonal(&values.into()) * q.transpose() - a), a.norm());
    assert!(error <= bar::<E>(), "{what}: reconstruction {error:.1e} of {a}");
    let skew = orthogonality(&q);
    assert!(skew <= bar::<E>() && q.determinant() > 0.9, "{what}: orthogonality {skew:.1e} of {a}");
    assert!(values[0] >= values[1] && values[1] >= values[2], "{what}: order of {values:?}");
}

/// Eigen-decompositions in lanes, as a user would write it.
struct Eigen<'a, E>(&'a [Matrix3<E>]);

impl<E: Element> LaneKernel<E> for Eigen<'_, E> {
    type Output = Vec<SymmetricEigen<E>>;
    #[inline(always)]
    fn run<P: Packet<Element = E>>(self) -> Self::Output {
        let zero = SymmetricEigen { values: [E::constant(0.0); 3], vectors: tensor::zero() };
        let mut all = vec![zero; self.0.len() / P::LANES * P::LANES];
        for (matrices, targets) in self.0.chunks_exact(P::LANES).zip(all.chunks_mut(P::LANES)) {
            let d = symmetric_eigen(&load_matrices::<P>(matrices));
            store_matrices(&d.vectors, targets.iter_mut().map(|t| &mut t.vectors));
            for (lane, target) in targets.iter_mut().enumerate() {
                target.values = d.values.map(|value| value.to_lanes().as_ref()[lane]);
            }
        }
        all
    }
}

fn check_all<E: Element>(matrices: &[Mat3], factor: f64, what: &str) {
    let list: Vec<Matrix3<E>> = matrices.iter().map(|m| tensor::constant(&(m * factor))).collect();
    let symmetric: Vec<Matrix3<E>> = list.iter().map(tensor::symmetric_part).collect();
    let (mut svds, mut polars) = (vec![Svd::identity(); list.len()], vec![Polar::identity(); list.len()]);
    svd_into(&list, &mut svds);
    polar_into(&list, &mut polars);
    for (i, f) in list.iter().enumerate() {
        check_svd(f, &svd(f), what);
        check_svd(f, &svds[i], &format!("{what}, lanes"));
        check_polar(f, &polar(f), what);
        check_polar(f, &polars[i], &format!("{what}, lanes"));
        check_eigen(&symmetric[i], &eigen(&symmetric[i]), what);
    }
    for (a, d) in symmetric.iter().zip(&dispatch(Eigen(&symmetric))) {
        check_eigen(a, d, &format!("{what}, lanes"));
    }
}

#[test]
fn every_kind_of_matrix_is_decomposed_to_the_promised_accuracy() {
    for (name, list) in families(&mut Random(1), 1500) {
        check_all::<f64>(&list, 1.0, &name);
        check_all::<f32>(&list, 1.0, &name);
    }
}

#[test]
fn magnitude_does_not_matter() {
    for (name, list) in families(&mut Random(2), 40) {
        // The widest families would leave the range of the format by themselves.
        let small: Vec<Mat3> = list.iter().map(|m| m / m.amax().max(1.0)).collect();
        for factor in [1e150, 1e-150] {
            check_all::<f64>(&small, factor, &format!("{name} times {factor:e}"));
        }
        for factor in [1e15, 1e-15] {
            check_all::<f32>(&small, factor, &format!("{name} times {factor:e}"));
        }
    }
    let f = Random(3).matrix();
    let (one, other) = (svd(&f), svd(&(f * 2.0_f64.powi(400))));
    assert_eq!((one.u, one.v), (other.u, other.v));
    assert_eq!(one.sigma.map(|s| s * 2.0_f64.powi(400)), other.sigma);
}

#[test]
fn a_million_random_matrices_hold_no_surprise() {
    let mut random = Random(4);
    for _ in 0..10 {
        let list: Vec<Mat3> = (0..100_000).map(|_| random.matrix()).collect();
        let mut svds = vec![Svd::identity(); list.len()];
        svd_into(&list, &mut svds);
        for (f, d) in list.iter().zip(&svds) {
            check_svd(f, d, "random");
        }
    }
}

/// Singular values known exactly: F = A D Bᵀ in integers, with AᵀA = 9 I and BᵀB = 49 I.
#[test]
fn singular_values_are_exact_to_a_fraction_of_the_largest() {
    let a = Mat3::new(2.0, -1.0, 2.0, 2.0, 2.0, -1.0, -1.0, 2.0, 2.0);
    let b = Mat3::new(2.0, 3.0, 6.0, 3.0, -6.0, 2.0, 6.0, 2.0, -3.0);
    assert_eq!((a.determinant(), b.determinant()), (27.0, 343.0));
    for d in [
        [3.0, 2.0, 1.0],
        [3.0, 2.0, -1.0],
        [1e3, 10.0, 1.0],
        [1e6, 1e3, -1.0],
        [1e12, 1e6, 1.0],
        [1e12, 1.0, -1.0],
        [1e12, 2.0, 1.0],
        [1e12, 1e12, 1.0],
        [1e9, 0.0, 0.0],
        [5.0, 5.0, -5.0],
    ] {
        let f = a * Mat3::from_diagonal(&d.into()) * b.transpose();
        let found = svd(&f).sigma;
        for i in 0..3 {
            let error = (found[i] - 21.0 * d[i]).abs() / (21.0 * d[0]);
            assert!(error <= 4e-15, "sigma {i} of {d:?}: {} error {error:.1e}", found[i]);
        }
    }
}

#[test]
fn the_smallest_singular_value_has_the_sign_of_the_determinant() {
    let mut random = Random(5);
    for _ in 0..20_000 {
        let f = random.matrix();
        let sigma = svd(&f).sigma;
        assert_eq!(sigma[2] < 0.0, f.determinant() < 0.0, "{f}");
        assert!((sigma[0] * sigma[1] * sigma[2] - f.determinant()).abs() < 1e-14);
    }
}

fn rows(value: &serde_json::Value) -> Mat3 {
    Mat3::from_fn(|i, j| value[i][j].as_f64().expect("a number"))
}

/// Shared with the Gaussian crate: mpmath with 50 digits.
#[test]
fn the_high_precision_fixture_is_met() {
    let text = include_str!("fixtures/polar.json");
    let fixture: serde_json::Value = serde_json::from_str(text).expect("valid JSON");
    let cases = fixture["cases"].as_array().expect("cases");
    assert_eq!(cases.len(), 26);
    for case in cases {
        let name = case["name"].as_str().expect("a name");
        let f = rows(&case["F"]);
        let mut batch = [Polar::identity()];
        polar_into(&[f], &mut batch);
        let sigma = svd(&f).sigma;
        for i in 0..3 {
            let exact = case["signed_singular_values"][i].as_f64().expect("a number");
            let error = (sigma[i] - exact).abs();
            assert!(error <= 4e-15 * sigma[0], "{name}: sigma {i} = {} against {exact}", sigma[i]);
        }
        for d in [polar(&f), batch[0]] {
            check_polar(&f, &d, name);
            if case["rotation_unique"].as_bool() == Some(true) {
                let gap = case["sigma2_plus_signed_sigma3"].as_f64().expect("a number");
                let tolerance = 1e-13 * (sigma[0] / gap).max(1.0);
                let error = (d.rotation - rows(&case["R"])).amax();
                assert!(error <= tolerance, "{name}: rotation off by {error:.1e}, allowed {tolerance:.1e}");
                let scale = sigma[0].max(f64::MIN_POSITIVE);
                let error = (d.stretch - rows(&case["S"])).amax() / scale;
                assert!(error <= tolerance, "{name}: stretch off by {error:.1e}");
            }
        }
    }
}

#[test]
fn the_polar_rotation_is_the_nearest() {
    let mut random = Random(6);
    for _ in 0..300 {
        let f = random.matrix();
        let distance = (polar(&f).rotation - f).norm();
        for _ in 0..30 {
            let axis = nalgebra::Vector3::new(random.number(), random.number(), random.number());
            let near = nalgebra::Rotation3::new(axis * 0.1) * polar(&f).rotation;
            assert!((random.rotation() - f).norm() >= distance && (near - f).norm() >= distance);
        }
    }
}

#[test]
fn the_rest_state_is_exact() {
    for factor in [1.0, 0.3, 1e-3, 1e100, 0.0] {
        let f = Mat3::identity() * factor;
        assert_eq!(svd(&f), Svd { sigma: [factor; 3], ..Svd::identity() });
        assert_eq!(polar(&f), Polar { stretch: f, ..Polar::identity() });
    }
    // And through lanes.
    let mut batch = [Svd::identity(); 3];
    svd_into(&[tensor::zero::<f32>(), tensor::multiple_of_identity(2.0), tensor::zero()], &mut batch);
    assert_eq!(batch[1], Svd { sigma: [2.0; 3], ..Svd::identity() });
    assert_eq!(batch[0], Svd { sigma: [0.0; 3], ..Svd::identity() });
}

fn all_nan<E: Element>(numbers: &[E]) -> bool {
    numbers.iter().all(|&x| x.into().is_nan())
}

fn non_finite_spreads<E: Element>() {
    let mut random = Random(7);
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for place in 0..9 {
            for start in [Mat3::identity(), Mat3::zeros(), random.matrix()] {
                let mut f: Matrix3<E> = tensor::constant(&start);
                f.as_mut_slice()[place] = E::constant(bad);
                let good: Matrix3<E> = tensor::constant(&random.matrix());
                let mut batch = [Svd::identity(); 3];
                svd_into(&[good, f, good], &mut batch);
                for d in [svd(&f), batch[1]] {
                    assert!(all_nan(d.u.as_slice()) && all_nan(&d.sigma) && all_nan(d.v.as_slice()), "{d:?}");
                }
                // The neighbours do not notice.
                assert_eq!(batch[0], batch[2]);
                check_svd(&good, &batch[0], "beside a NaN");
                let d = polar(&f);
                assert!(all_nan(d.rotation.as_slice()) && all_nan(d.stretch.as_slice()), "{d:?}");
                let upper = [0, 3, 4, 6, 7, 8].contains(&place);
                let d = eigen(&f);
                assert_eq!(all_nan(d.vectors.as_slice()), upper && all_nan(&d.values), "{d:?}");
            }
        }
    }
}

#[test]
fn a_number_that_is_not_finite_makes_every_factor_nan() {
    non_finite_spreads::<f64>();
    non_finite_spreads::<f32>();
    // Too large to be scaled: NaN rather than something wrong.
    let d = svd(&(Mat3::identity() * f64::MAX));
    assert!(all_nan(&d.sigma) && all_nan(d.u.as_slice()) && all_nan(d.v.as_slice()));
}

#[test]
fn a_batch_does_not_depend_on_order_or_length() {
    let mut random = Random(8);
    // Wide ranges beside easy matrices: some lanes need more sweeps than others.
    let list: Vec<Matrix3<f32>> = (0..200)
        .map(|i| {
            let wide = [1e3, 1.0, 1e-3];
            let f = if i % 7 == 0 { random.with_singular_values(wide) } else { random.matrix() };
            tensor::constant(&f)
        })
        .collect();
    let mut whole = vec![Svd::identity(); 200];
    svd_into(&list, &mut whole);
    let reversed: Vec<_> = list.iter().rev().copied().collect();
    let mut back = vec![Svd::identity(); 200];
    svd_into(&reversed, &mut back);
    back.reverse();
    assert_eq!(whole, back);
    for length in 0..=40 {
        let mut part = vec![Svd::identity(); length];
        svd_into(&list[3..3 + length], &mut part);
        assert_eq!(part, whole[3..3 + length]);
        let mut rotations = vec![Polar::identity(); length];
        polar_into(&list[3..3 + length], &mut rotations);
        for (f, d) in list[3..].iter().zip(&rotations) {
            check_polar(f, d, "part of a batch");
        }
    }
}

#[test]
#[should_panic(expected = "one decomposition for each matrix")]
fn a_batch_with_too_few_results_panics() {
    svd_into(&[Mat3::identity(); 3], &mut [Svd::identity(); 2]);
}

fn errors_of_fixed_sweeps(list: &[Mat3], sweeps: usize) -> (f64, f64) {
    let mut batch = vec![Svd::identity(); list.len()];
    svd_with_sweeps_into(list, sweeps, &mut batch);
    let mut errors = Vec::new();
    for (f, d) in list.iter().zip(&batch) {
        for d in [*d, svd_with_sweeps(f, sweeps)] {
            assert!(orthogonality(&d.u).max(orthogonality(&d.v)) <= 4e-15);
            errors.push((d.u * Mat3::from_diagonal(&d.sigma.into()) * d.v.transpose() - f).norm() / f.norm());
        }
    }
    errors.sort_by(f64::total_cmp);
    (errors[errors.len() / 2], errors[errors.len() - 1])
}

/// Each sweep cubes the error: medians and worst cases fall until rounding is all that is left.
#[test]
fn fixed_sweeps_trade_accuracy_for_time() {
    let mut random = Random(9);
    let list: Vec<Mat3> = (0..20_000).map(|_| random.matrix()).collect();
    let (two, four) = (errors_of_fixed_sweeps(&list, 2), errors_of_fixed_sweeps(&list, 4));
    assert!(two.0 < 1e-9 && four.0 < 4e-15, "medians {two:?}, {four:?}");
    assert!((1e-6..0.1).contains(&two.1) && four.1 <= 4e-15, "worst {two:?}, {four:?}");
}

/// Found by review: from the sixth sweep on, the growth of the unnormalised matrix overflowed in single precision for a few
/// matrices in a million, and all factors were NaN.
#[test]
fn eight_sweeps_do_not_overflow_in_single_precision() {
    let mut random = Random(10);
    let mut list = vec![Matrix3::new(
        0.274_643_66_f32,
        0.013_789_752,
        -0.650_083_6,
        -0.208_599_78,
        -0.180_181_86,
        -0.989_474_8,
        -0.330_899_7,
        -0.209_024_25,
        0.573_981_6,
    )];
    list.extend((0..300_000).map(|_| tensor::constant::<f32>(&random.matrix())));
    let mut batch = vec![Svd::identity(); list.len()];
    svd_with_sweeps_into(&list, 8, &mut batch);
    for (f, d) in list.iter().zip(&batch) {
        check_svd(f, d, "eight sweeps");
    }
}
