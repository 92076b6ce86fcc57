//! A point and a plane, and two lines: pairs whose gap is orthogonal to two tangents.

use super::run::{Primitive, Rule, Run, stencil};
use super::{PairLaw, eigen, minus, times};
use mechanics_core::projection::Projection;
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::{self, Matrix3};

/// Pairs of a point x₀ and the plane of the triangle x₁ x₂ x₃, closest within it.
///
/// With r = x₀ − x₁, e₁ = x₂ − x₁, e₂ = x₃ − x₁ and N = e₁ × e₂: d = r·N/|N|, and the weights are ω = (1, −β₀, −β₁, −β₂) with
/// the barycentric coordinates β₁ = (r × e₂)·N/|N|², β₂ = (e₁ × r)·N/|N|², β₀ = 1 − β₁ − β₂. See the
/// [module](super) page for the rest. Domain: s > 0, |N| > 0.
#[derive(Clone, Copy, Debug)]
pub struct PointTrianglePairs<'a, B: ?Sized> {
    /// Barrier and stiffness.
    pub law: PairLaw<'a, B>,
    /// One weight for each pair.
    pub weights: &'a [f64],
}

stencil!(PointTrianglePairs, PointPlane, 4);

/// Geometry of a point and a plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct PointPlane;

/// Geometry of two lines.
///
/// With r = x₀ − x₂, e₁ = x₁ − x₀, e₂ = x₃ − x₂ and N = e₁ × e₂: d = r·N/|N|, and the weights are
/// ω = (1 − μ, μ, ν − 1, −ν) with μ = −(r × e₂)·N/|N|², ν = −(r × e₁)·N/|N|².
#[derive(Clone, Copy, Debug)]
pub(super) struct LineLine;

/// What both kinds of pairs have in common.
struct Planar<S> {
    /// Edges e₁, e₂ that span the plane.
    edges: [[S; 3]; 2],
    /// N = e₁ × e₂.
    normal: [S; 3],
    /// |N|².
    area_squared: S,
    /// From a position on the one feature to one on the other.
    r: [S; 3],
}

impl<S: Scalar> Planar<S> {
    #[inline(always)]
    fn new(r: [S; 3], edges: [[S; 3]; 2]) -> Self {
        let normal = tensor::cross(&edges[0], &edges[1]);
        Self { edges, normal, area_squared: tensor::dot(&normal, &normal), r }
    }

    /// s = (r·N)²/|N|².
    #[inline(always)]
    fn squared_distance(&self) -> S {
        tensor::dot(&self.r, &self.normal).square() / self.area_squared
    }

    /// y = N (r·N)/|N|².
    #[inline(always)]
    fn gap(&self) -> [S; 3] {
        times(&self.normal, tensor::dot(&self.r, &self.normal) / self.area_squared)
    }

    /// (r × eₖ)·N/|N|², k = 1, 2.
    #[inline(always)]
    fn coordinates(&self) -> [S; 2] {
        times(&[self.volume(&self.edges[0]), self.volume(&self.edges[1])], self.area_squared.recip())
    }

    /// (r × e)·N.
    #[inline(always)]
    fn volume(&self, e: &[S; 3]) -> S {
        tensor::dot(&tensor::cross(&self.r, e), &self.normal)
    }
}

/// Weights by their components along the orthonormal z₀, z₁, z₂ of one kind of pair.
trait Shares: Primitive<4> {
    /// Point i of the three basis vectors.
    const BASIS: [[f64; 3]; 4];
    /// The component of every ω along z₀.
    const MEAN: f64;
    /// ∂ω/∂λ along z₁ and z₂ for positions that move along +e₁ and along +e₂ of [`Planar`].
    const TILTS: [[f64; 2]; 2];

    fn planar<S: Scalar>(x: &[[S; 3]; 4]) -> Planar<S>;
}

/// 1/√2, 1/√6 and 1/√12.
const HALF: f64 = std::f64::consts::FRAC_1_SQRT_2;
const SIXTH: f64 = 0.408_248_290_463_863_02;
const TWELFTH: f64 = 0.288_675_134_594_812_88;

impl Shares for PointPlane {
    const BASIS: [[f64; 3]; 4] = [
        [3.0 * TWELFTH, 0.0, 0.0],
        [-TWELFTH, HALF, SIXTH],
        [-TWELFTH, -HALF, SIXTH],
        [-TWELFTH, 0.0, -2.0 * SIXTH],
    ];
    const MEAN: f64 = 4.0 * TWELFTH;
    // (0, −1, 1, 0) and (0, −1, 0, 1).
    const TILTS: [[f64; 2]; 2] = [[-2.0 * HALF, 0.0], [-HALF, -3.0 * SIXTH]];

    #[inline(always)]
    fn planar<S: Scalar>(x: &[[S; 3]; 4]) -> Planar<S> {
        Planar::new(minus(&x[0], &x[1]), [minus(&x[2], &x[1]), minus(&x[3], &x[1])])
    }
}

impl Shares for LineLine {
    const BASIS: [[f64; 3]; 4] = [[0.5, HALF, 0.0], [0.5, -HALF, 0.0], [-0.5, 0.0, HALF], [-0.5, 0.0, -HALF]];
    const MEAN: f64 = 1.0;
    // (−1, 1, 0, 0) and (0, 0, −1, 1).
    const TILTS: [[f64; 2]; 2] = [[-2.0 * HALF, 0.0], [0.0, -2.0 * HALF]];

    #[inline(always)]
    fn planar<S: Scalar>(x: &[[S; 3]; 4]) -> Planar<S> {
        Planar::new(minus(&x[0], &x[2]), [minus(&x[1], &x[0]), minus(&x[3], &x[2])])
    }
}

macro_rules! planar_primitive {
    ($primitive:ident, $omega:expr) => {
        impl Primitive<4> for $primitive {
            #[inline(always)]
            fn squared_distance<S: Scalar>(x: &[[S; 3]; 4]) -> S {
                Self::planar(x).squared_distance()
            }

            #[inline(always)]
            fn closest<S: Scalar>(x: &[[S; 3]; 4]) -> ([S; 4], [S; 3]) {
                let planar = Self::planar(x);
                ($omega(planar.coordinates()), planar.gap())
            }

            #[inline(always)]
            fn hessian<S: Scalar>(
                x: &[[S; 3]; 4],
                coefficients: impl FnOnce(S) -> [S; 2],
                rule: Rule,
            ) -> [[Matrix3<S>; 4]; 4] {
                let planar = Self::planar(x);
                let omega = $omega(planar.coordinates());
                let coefficients = coefficients(planar.squared_distance());
                hessian::<Self, S>(&planar, &omega, coefficients, rule)
            }
        }
    };
}

planar_primitive!(PointPlane, |[along_second, along_first]: [S; 2]| {
    // (r × e₁)·N = −β₂|N|², (r × e₂)·N = β₁|N|².
    let (first, second) = (along_first, -along_second);
    [S::constant(1.0), (first + second).offset(-1.0), -first, -second]
});

planar_primitive!(LineLine, |[nu, mu]: [S; 2]| {
    // Both with the opposite sign.
    [mu.offset(1.0), -mu, -nu.offset(1.0), nu]
});

/// ∇²E, projected, by way of the basis ω̂⊗n, v₁⊗n, v₂⊗n, ω̂⊗t₁, ω̂⊗t₂.
#[inline(always)]
fn hessian<K: Shares, S: Scalar>(
    planar: &Planar<S>,
    omega: &[S; 4],
    [across, along]: [S; 2],
    rule: Rule,
) -> [[Matrix3<S>; 4]; 4] {
    let n = times(&planar.normal, planar.area_squared.sqrt().recip());
    let d = tensor::dot(&planar.r, &n);
    let basis = Basis::new::<K>(omega);
    let size_squared = basis.size.square();
    if rule.is_gauss_newton() {
        return gap_only(omega, &n, rule.projection.apply(along));
    }
    let [e1, e2] = &planar.edges;
    let length = tensor::dot(e1, e1).sqrt();
    let t1 = times(e1, length.recip());
    let t2 = tensor::cross(&n, &t1);
    // Tilts for steps along t₁ = e₁/ℓ and t₂ = (e₂ − p t₁)/q.
    let (p, q) = (tensor::dot(e2, &t1), tensor::dot(e2, &t2));
    let [first, second] = K::TILTS;
    let tilt1 = times(&[S::constant(first[0]), S::constant(first[1])], d / length);
    let tilt2 = minus_times(&times(&[S::constant(second[0]), S::constant(second[1])], d), p, &tilt1);
    let tilt2 = times(&tilt2, q.recip());
    let tilts = [basis.components(&tilt1), basis.components(&tilt2)];
    let zero = S::constant(0.0);
    let minus_across = -across;
    let mut small = [[zero; 5]; 5];
    for a in 0..3 {
        for b in a..3 {
            small[a][b] = minus_across * tilts[0][a].mul_add(tilts[0][b], tilts[1][a] * tilts[1][b]);
        }
        for k in 0..2 {
            small[a][3 + k] = minus_across * tilts[k][a] * basis.size;
        }
    }
    small[0][0] = along.mul_add(size_squared, small[0][0]);
    if rule.projection == Projection::None {
        for a in 0..5 {
            for b in 0..a {
                small[a][b] = small[b][a];
            }
        }
    } else {
        small = eigen::project(&small, rule.projection);
    }
    expand(&small, &basis.vectors, &tensor::from_columns([n, t1, t2]))
}

/// a − factor · b.
#[inline(always)]
fn minus_times<S: Scalar>(a: &[S; 2], factor: S, b: &[S; 2]) -> [S; 2] {
    [a[0] - factor * b[0], a[1] - factor * b[1]]
}

/// factor · (ω⊗n)(ω⊗n)ᵀ.
#[inline(always)]
fn gap_only<S: Scalar>(omega: &[S; 4], n: &[S; 3], factor: S) -> [[Matrix3<S>; 4]; 4] {
    let mut blocks = [[tensor::zero(); 4]; 4];
    for i in 0..4 {
        for j in 0..=i {
            let factor = factor * omega[i] * omega[j];
            blocks[i][j] = tensor::from_entries(|k, l| factor * n[k] * n[l]);
        }
    }
    blocks
}

/// Orthonormal weight vectors ω̂, v₁, v₂ by their components along z₀, z₁, z₂, and point by point.
struct Basis<S> {
    /// |ω|.
    size: S,
    /// Row a: components of vector a.
    rows: [[S; 3]; 3],
    /// Entry i of ω̂, v₁, v₂.
    vectors: [[S; 3]; 4],
}

impl<S: Scalar> Basis<S> {
    /// v₁ and v₂ are columns of the reflection that takes −z₀ to ω̂, I − 2uuᵀ/|u|² with u = ω̂ + z₀: nothing cancels, because the
    /// component of ω̂ along z₀ is positive.
    #[inline(always)]
    fn new<K: Shares>(omega: &[S; 4]) -> Self {
        let component = |k: usize| {
            let mut sum = omega[0].scale(K::BASIS[0][k]);
            for i in 1..4 {
                sum = omega[i].mul_add(S::constant(K::BASIS[i][k]), sum);
            }
            sum
        };
        let (g1, g2) = (component(1), component(2));
        let mean = S::constant(K::MEAN);
        let size = mean.mul_add(mean, g1.mul_add(g1, g2 * g2)).sqrt();
        let reciprocal = size.recip();
        let hat = [mean * reciprocal, g1 * reciprocal, g2 * reciprocal];
        // |u|²/2 = 1 + ω̂·z₀.
        let u0 = hat[0].offset(1.0);
        let factor = u0.recip();
        let (f1, f2) = (hat[1] * factor, hat[2] * factor);
        let one = S::constant(1.0);
        let v1 = [-hat[1], one - f1 * hat[1], -(f1 * hat[2])];
        let v2 = [-hat[2], -(f2 * hat[1]), one - f2 * hat[2]];
        let rows = [hat, v1, v2];
        let mut vectors = [[S::constant(0.0); 3]; 4];
        for i in 0..4 {
            for a in 0..3 {
                let mut sum = rows[a][0].scale(K::BASIS[i][0]);
                for k in 1..3 {
                    sum = rows[a][k].mul_add(S::constant(K::BASIS[i][k]), sum);
                }
                vectors[i][a] = sum;
            }
        }
        Self { size, rows, vectors }
    }

    /// Components along ω̂, v₁, v₂ of a vector in the span of z₁, z₂.
    #[inline(always)]
    fn components(&self, [first, second]: &[S; 2]) -> [S; 3] {
        let mut components = [S::constant(0.0); 3];
        for a in 0..3 {
            components[a] = self.rows[a][1].mul_add(*first, self.rows[a][2] * *second);
        }
        components
    }
}

/// Σ small[a][b] q_a q_bᵀ over the basis, block by block: block (i, j) is F K Fᵀ with F = `frame` and K the part of points i and j.
#[inline(always)]
fn expand<S: Scalar>(small: &[[S; 5]; 5], vectors: &[[S; 3]; 4], frame: &Matrix3<S>) -> [[Matrix3<S>; 4]; 4] {
    // Row a of the small matrix times the weight vectors at each point.
    let mut near = [[S::constant(0.0); 5]; 4];
    for i in 0..4 {
        for a in 0..5 {
            let [x, y, z] = vectors[i];
            near[i][a] = small[0][a].mul_add(x, small[1][a].mul_add(y, small[2][a] * z));
        }
    }
    let mut blocks = [[tensor::zero(); 4]; 4];
    for i in 0..4 {
        for j in 0..=i {
            let (a, b) = (&vectors[i], &near[j]);
            let normal = a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]));
            let both = vectors[i][0] * vectors[j][0];
            let off = small[3][4] * both;
            let columns = [
                [normal, vectors[i][0] * near[j][3], vectors[i][0] * near[j][4]],
                [near[i][3] * vectors[j][0], small[3][3] * both, off],
                [near[i][4] * vectors[j][0], off, small[4][4] * both],
            ];
            let k = tensor::from_columns(columns);
            blocks[i][j] = tensor::product(frame, &tensor::product_transpose(&k, frame));
        }
    }
    blocks
}
