//! Decompositions of 3×3 matrices: accuracy on every kind of matrix, against products formed in higher precision.

use mechanics_core::decomposition::{polar, svd, symmetric_eigen};
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::{self, Mat3, Matrix3};

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

fn widened<S: Scalar + Into<f64>>(a: &Matrix3<S>) -> Mat3 {
    let c = tensor::columns(a);
    Mat3::from_fn(|i, j| c[j][i].into())
}

fn worst<S: Scalar + Into<f64>>(list: &[Mat3]) -> [f64; 5] {
    let mut w = [0.0_f64; 5];
    for m in list {
        let f: Matrix3<S> = tensor::constant(m);
        let exact = widened(&f);
        let d = svd(&f);
        let (u, v) = (widened(&d.u), widened(&d.v));
        let sigma = d.sigma.map(Into::into);
        let rebuilt = u * Mat3::from_diagonal(&sigma.into()) * v.transpose();
        let norm = exact.norm().max(f64::MIN_POSITIVE);
        let o = |q: &Mat3| (q.transpose() * q - Mat3::identity()).norm();
        let e = [(rebuilt - exact).norm() / norm, o(&u), o(&v)];
        assert!(sigma[0] >= sigma[1] && sigma[1] >= sigma[2].abs(), "{sigma:?}");
        assert!(u.determinant() > 0.9 && v.determinant() > 0.9);
        let sym: Matrix3<S> = tensor::symmetric_part(&f);
        let se = widened(&sym);
        let g = symmetric_eigen(&sym);
        let q = widened(&g.vectors);
        let l = g.values.map(Into::into);
        let back = q * Mat3::from_diagonal(&l.into()) * q.transpose();
        let ee = [(back - se).norm() / se.norm().max(f64::MIN_POSITIVE), o(&q)];
        assert!(l[0] >= l[1] && l[1] >= l[2], "{l:?}");
        for (a, b) in w.iter_mut().zip([e[0], e[1], e[2], ee[0], ee[1]]) {
            assert!(b.is_finite(), "{m} {d:?} {g:?}");
            *a = a.max(b);
        }
    }
    w
}

#[test]
fn explore() {
    let count = 20000;
    for (name, list) in families(&mut Random(1), count) {
        let (a, b) = (worst::<f64>(&list), worst::<f32>(&list));
        println!("{name:28} f64 {} f32 {}", show(&a), show(&b));
    }
    let _ = polar(&Mat3::identity());
}
fn show(a: &[f64]) -> String {
    a.iter().map(|x| format!("{x:.1e} ")).collect()
}
