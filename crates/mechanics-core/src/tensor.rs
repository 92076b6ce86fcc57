//! The vector vocabulary: nalgebra's fixed-size types, and 3×3 kernels over any [`Scalar`].
//!
//! Public interfaces speak [`Vec3`] and [`Mat3`], which *are* nalgebra's `Vector3<f64>` and `Matrix3<f64>`. The
//! functions below do the arithmetic that formulas need on `Matrix3<S>` for any [`Scalar`] `S`. They exist beside
//! nalgebra's operators because those ask for traits that lanes and jets do not have, and because a kernel
//! compiled for AVX2 must have all of its arithmetic inlined into it (every function here is `inline(always)`).

use crate::scalar::Scalar;
use nalgebra::ArrayStorage;

/// A point or vector in space, metres unless said otherwise.
pub type Vec3 = nalgebra::Vector3<f64>;
/// A second-order tensor: deformation gradient, stress, rotation.
pub type Mat3 = nalgebra::Matrix3<f64>;
/// A 3×3 matrix over any [`Scalar`]; column-major storage.
pub type Matrix3<S> = nalgebra::Matrix3<S>;
/// A 3-vector over any [`Scalar`].
pub type Vector3<S> = nalgebra::Vector3<S>;

/// The matrix with the given columns.
#[inline(always)]
pub fn from_columns<S: Scalar>(columns: [[S; 3]; 3]) -> Matrix3<S> {
    Matrix3::from_array_storage(ArrayStorage(columns))
}

/// The columns of a matrix.
#[inline(always)]
pub fn columns<S: Scalar>(a: &Matrix3<S>) -> &[[S; 3]; 3] {
    &a.data.0
}

/// The matrix whose entry in row `i`, column `j` is `entry(i, j)`.
#[inline(always)]
pub fn from_entries<S: Scalar>(entry: impl Fn(usize, usize) -> S) -> Matrix3<S> {
    from_columns([
        [entry(0, 0), entry(1, 0), entry(2, 0)],
        [entry(0, 1), entry(1, 1), entry(2, 1)],
        [entry(0, 2), entry(1, 2), entry(2, 2)],
    ])
}

/// The vector with the given components.
#[inline(always)]
pub fn vector<S: Scalar>(components: [S; 3]) -> Vector3<S> {
    Vector3::from_array_storage(ArrayStorage([components]))
}

/// The components of a vector.
#[inline(always)]
pub fn components<S: Scalar>(a: &Vector3<S>) -> &[S; 3] {
    &a.data.0[0]
}

/// The zero matrix.
#[inline(always)]
pub fn zero<S: Scalar>() -> Matrix3<S> {
    from_columns([[S::constant(0.0); 3]; 3])
}

/// `factor · I`.
#[inline(always)]
pub fn multiple_of_identity<S: Scalar>(factor: S) -> Matrix3<S> {
    diagonal([factor; 3])
}

/// The diagonal matrix with the given entries.
#[inline(always)]
pub fn diagonal<S: Scalar>(entries: [S; 3]) -> Matrix3<S> {
    let zero = S::constant(0.0);
    let [a, b, c] = entries;
    from_columns([[a, zero, zero], [zero, b, zero], [zero, zero, c]])
}

/// The same matrix over another scalar, every entry a constant.
#[inline(always)]
pub fn constant<S: Scalar>(a: &Mat3) -> Matrix3<S> {
    let c = columns(a);
    from_entries(|i, j| S::constant(c[j][i]))
}

/// The values of all entries, without their derivatives.
#[inline(always)]
pub fn value<S: Scalar>(a: &Matrix3<S>) -> Matrix3<S::Value> {
    let c = columns(a);
    from_entries(|i, j| c[j][i].value())
}

/// The same matrix with zero derivatives.
#[inline(always)]
pub fn lift<S: Scalar>(a: &Matrix3<S::Value>) -> Matrix3<S> {
    let c = columns(a);
    from_entries(|i, j| S::lift(c[j][i]))
}

/// `A + B`.
#[inline(always)]
pub fn sum<S: Scalar>(a: &Matrix3<S>, b: &Matrix3<S>) -> Matrix3<S> {
    let (a, b) = (columns(a), columns(b));
    from_entries(|i, j| a[j][i] + b[j][i])
}

/// `A − B`.
#[inline(always)]
pub fn difference<S: Scalar>(a: &Matrix3<S>, b: &Matrix3<S>) -> Matrix3<S> {
    let (a, b) = (columns(a), columns(b));
    from_entries(|i, j| a[j][i] - b[j][i])
}

/// `factor · A`.
#[inline(always)]
pub fn scaled<S: Scalar>(a: &Matrix3<S>, factor: S) -> Matrix3<S> {
    let a = columns(a);
    from_entries(|i, j| a[j][i] * factor)
}

/// `A + factor · B`.
#[inline(always)]
pub fn add_scaled<S: Scalar>(a: &Matrix3<S>, factor: S, b: &Matrix3<S>) -> Matrix3<S> {
    let (a, b) = (columns(a), columns(b));
    from_entries(|i, j| b[j][i].mul_add(factor, a[j][i]))
}

/// `A B`.
#[inline(always)]
pub fn product<S: Scalar>(a: &Matrix3<S>, b: &Matrix3<S>) -> Matrix3<S> {
    let (a, b) = (columns(a), columns(b));
    from_entries(|i, j| a[2][i].mul_add(b[j][2], a[1][i].mul_add(b[j][1], a[0][i] * b[j][0])))
}

/// `Aᵀ B`.
#[inline(always)]
pub fn transpose_product<S: Scalar>(a: &Matrix3<S>, b: &Matrix3<S>) -> Matrix3<S> {
    let (a, b) = (columns(a), columns(b));
    from_entries(|i, j| a[i][2].mul_add(b[j][2], a[i][1].mul_add(b[j][1], a[i][0] * b[j][0])))
}

/// `A Bᵀ`.
#[inline(always)]
pub fn product_transpose<S: Scalar>(a: &Matrix3<S>, b: &Matrix3<S>) -> Matrix3<S> {
    let (a, b) = (columns(a), columns(b));
    from_entries(|i, j| a[2][i].mul_add(b[2][j], a[1][i].mul_add(b[1][j], a[0][i] * b[0][j])))
}

/// `A diag(d) Bᵀ`, as in a singular value decomposition.
#[inline(always)]
pub fn product_diagonal_transpose<S: Scalar>(a: &Matrix3<S>, d: &[S; 3], b: &Matrix3<S>) -> Matrix3<S> {
    let a = columns(a);
    let scaled = from_entries(|i, j| a[j][i] * d[j]);
    product_transpose(&scaled, b)
}

/// `Aᵀ`.
#[inline(always)]
pub fn transpose<S: Scalar>(a: &Matrix3<S>) -> Matrix3<S> {
    let a = columns(a);
    from_entries(|i, j| a[i][j])
}

/// `A v`.
#[inline(always)]
pub fn apply<S: Scalar>(a: &Matrix3<S>, v: &Vector3<S>) -> Vector3<S> {
    let (a, v) = (columns(a), components(v));
    let row = |i: usize| a[2][i].mul_add(v[2], a[1][i].mul_add(v[1], a[0][i] * v[0]));
    vector([row(0), row(1), row(2)])
}

/// `tr A`.
#[inline(always)]
pub fn trace<S: Scalar>(a: &Matrix3<S>) -> S {
    let a = columns(a);
    a[0][0] + a[1][1] + a[2][2]
}

/// `A : B = Σ Aᵢⱼ Bᵢⱼ`.
#[inline(always)]
pub fn double_contraction<S: Scalar>(a: &Matrix3<S>, b: &Matrix3<S>) -> S {
    let (a, b) = (columns(a), columns(b));
    let column = |j: usize| a[j][2].mul_add(b[j][2], a[j][1].mul_add(b[j][1], a[j][0] * b[j][0]));
    column(0) + column(1) + column(2)
}

/// `‖A‖² = A : A`, the squared Frobenius norm.
#[inline(always)]
pub fn norm_squared<S: Scalar>(a: &Matrix3<S>) -> S {
    double_contraction(a, a)
}

/// `a · b`.
#[inline(always)]
pub fn dot<S: Scalar>(a: &[S; 3], b: &[S; 3]) -> S {
    a[2].mul_add(b[2], a[1].mul_add(b[1], a[0] * b[0]))
}

/// `a × b`.
#[inline(always)]
pub fn cross<S: Scalar>(a: &[S; 3], b: &[S; 3]) -> [S; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The cofactor matrix ∂(det A)/∂A: `det(A) A⁻ᵀ` where the inverse exists, defined everywhere.
#[inline(always)]
pub fn cofactor<S: Scalar>(a: &Matrix3<S>) -> Matrix3<S> {
    let [a, b, c] = columns(a);
    from_columns([cross(b, c), cross(c, a), cross(a, b)])
}

/// `det A`.
#[inline(always)]
pub fn determinant<S: Scalar>(a: &Matrix3<S>) -> S {
    let [a, b, c] = columns(a);
    dot(a, &cross(b, c))
}

/// `½ (A + Aᵀ)`.
#[inline(always)]
pub fn symmetric_part<S: Scalar>(a: &Matrix3<S>) -> Matrix3<S> {
    let a = columns(a);
    let off = |i: usize, j: usize| (a[j][i] + a[i][j]).scale(0.5);
    let (p, q, r) = (off(0, 1), off(0, 2), off(1, 2));
    from_columns([[a[0][0], p, q], [p, a[1][1], r], [q, r, a[2][2]]])
}
