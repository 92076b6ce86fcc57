//! The derivative of the stress, ∂P/∂F.

use super::PrincipalStiffness;
use crate::scalar::Scalar;
use crate::tensor::{
    Matrix3, Vector3, add_scaled, apply, columns, from_columns, from_entries, scaled, sum, transpose, vector,
    zero,
};
use nalgebra::SMatrix;

/// ∂P/∂F \[Pa\], a symmetric linear map from 3×3 matrices to 3×3 matrices.
///
/// It is kept in the form in which it was computed, since what is wanted of it is not its 81 entries but a few
/// contractions with shape-function gradients: [`contraction`](Self::contraction) and
/// [`tetrahedron`](Self::tetrahedron).
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "a value on the stack of one element, never stored")]
pub enum Stiffness<S> {
    /// In fixed axes: block (j, l) has ∂Pᵢⱼ/∂Fₖₗ in row i, column k. The blocks (0,0), (0,1), (0,2), (1,1),
    /// (1,2), (2,2); by symmetry block (l, j) is the transpose of block (j, l).
    Fixed([Matrix3<S>; 6]),
    /// In the principal axes of F, where an isotropic law has 15 numbers.
    Principal(PrincipalStiffness<S>),
}

impl<S: Scalar> Stiffness<S> {
    /// From `block(j, l)` with j ≤ l: the matrix with ∂Pᵢⱼ/∂Fₖₗ in row i, column k. The laws here fill [`Fixed`](Self::Fixed) themselves: a closure that long
    /// becomes a function of its own, without the lanes' instructions (see `lanes`).
    #[inline(always)]
    pub fn from_blocks(block: impl Fn(usize, usize) -> Matrix3<S>) -> Self {
        let mut blocks = [zero(); 6];
        for (target, (j, l)) in blocks.iter_mut().zip(UPPER_TRIANGLE) {
            *target = block(j, l);
        }
        Self::Fixed(blocks)
    }

    /// From the 9×9 matrix over vec(F) = (F₁₁, F₂₁, F₃₁, F₁₂, …), of which the upper triangle of blocks is read.
    pub fn from_matrix(matrix: &SMatrix<S, 9, 9>) -> Self {
        Self::from_blocks(|j, l| from_entries(|i, k| matrix[(3 * j + i, 3 * l + k)]))
    }

    /// The 9×9 matrix over vec(F) = (F₁₁, F₂₁, F₃₁, F₁₂, …) \[Pa\].
    pub fn to_matrix(&self) -> SMatrix<S, 9, 9> {
        let unit = |j: usize| {
            let mut e = [S::constant(0.0); 3];
            e[j] = S::constant(1.0);
            e
        };
        let block = |j, l| self.contraction(&unit(j), &unit(l));
        let blocks: [[Matrix3<S>; 3]; 3] = std::array::from_fn(|j| std::array::from_fn(|l| block(j, l)));
        SMatrix::from_fn(|row, column| blocks[row / 3][column / 3][(row % 3, column % 3)])
    }

    /// The matrix K with Kᵢₖ = Σⱼₗ aⱼ (∂Pᵢⱼ/∂Fₖₗ) bₗ.
    ///
    /// With the gradients a = ∇N_a, b = ∇N_b of two shape functions [1/m] this is the stiffness between their
    /// nodes, per rest volume [Pa/m²].
    #[inline(always)]
    pub fn contraction(&self, a: &[S; 3], b: &[S; 3]) -> Matrix3<S> {
        match self {
            Self::Fixed(blocks) => weighted_sum(a, &half_contractions(blocks, b)),
            Self::Principal(principal) => principal.contraction(a, b),
        }
    }

    /// dP for a change dF of the deformation gradient \[Pa\].
    #[inline(always)]
    pub fn apply(&self, df: &Matrix3<S>) -> Matrix3<S> {
        match self {
            Self::Fixed(blocks) => {
                let d = columns(df);
                let column = |j: usize| {
                    let terms: [Vector3<S>; 3] =
                        std::array::from_fn(|l| apply(&block(blocks, j, l), &vector(d[l])));
                    std::array::from_fn(|i| terms[0][i] + terms[1][i] + terms[2][i])
                };
                from_columns([column(0), column(1), column(2)])
            }
            Self::Principal(principal) => principal.apply(df),
        }
    }

    /// The stiffness of a linear tetrahedron [N/m]: the blocks (a, b) with a ≤ b, in the order (0,0), (0,1), (0,2),
    /// (0,3), (1,1), (1,2), (1,3), (2,2), (2,3), (3,3).
    ///
    /// `gradients` are the rest gradients ∇N₁, ∇N₂, ∇N₃ [1/m] of the last three nodes (the rows of Dₘ⁻¹ where the
    /// columns of Dₘ are the rest edges from node 0); `volume` is the rest volume \[m³\]. The gradients of all four
    /// nodes sum to zero, so the six blocks among the last three nodes are contracted and the rows of node 0 are
    /// minus the sums of theirs: K₀ᵦ = −Σₐ Kₐᵦ. A translation is force-free to rounding for the same reason.
    #[inline(always)]
    pub fn tetrahedron(&self, gradients: &[[S; 3]; 3], volume: S) -> [Matrix3<S>; 10] {
        let six = match self {
            Self::Fixed(blocks) => contractions(blocks, gradients, volume),
            Self::Principal(principal) => principal.contractions(gradients, volume),
        };
        with_first_node(&six)
    }
}

/// The ten blocks of four nodes from the six among the last three.
#[inline(always)]
fn with_first_node<S: Scalar>(six: &[Matrix3<S>; 6]) -> [Matrix3<S>; 10] {
    let [k11, k12, k13, k22, k23, k33] = six;
    let k01 = minus_sum(k11, &transpose(k12), &transpose(k13));
    let k02 = minus_sum(k12, k22, &transpose(k23));
    let k03 = minus_sum(k13, k23, k33);
    let k00 = minus_sum(&k01, &k02, &k03);
    [k00, k01, k02, k03, *k11, *k12, *k13, *k22, *k23, *k33]
}

/// The pairs of a symmetric 3×3 array of blocks that are kept.
pub(super) const UPPER_TRIANGLE: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];

/// `volume` times the contractions of three gradients with each other.
///
/// Loops instead of closures here and below: a long closure may not be inlined, and in lanes it would lose the
/// vector instructions of its caller (measured: ten times slower).
#[inline(always)]
fn contractions<S: Scalar>(blocks: &[Matrix3<S>; 6], gradients: &[[S; 3]; 3], volume: S) -> [Matrix3<S>; 6] {
    let mut contractions = [zero(); 6];
    for b in 0..3 {
        let half = half_contractions(blocks, &multiple(&gradients[b], volume));
        for n in 0..6 {
            if UPPER_TRIANGLE[n].1 == b {
                contractions[n] = weighted_sum(&gradients[UPPER_TRIANGLE[n].0], &half);
            }
        }
    }
    contractions
}

/// `entry(i)` for i = 0, 1, 2.
#[inline(always)]
pub(super) fn per_axis<T: Copy>(start: T, entry: impl Fn(usize) -> T) -> [T; 3] {
    let mut entries = [start; 3];
    for i in 0..3 {
        entries[i] = entry(i);
    }
    entries
}

/// `factor · v`.
#[inline(always)]
pub(super) fn multiple<S: Scalar>(v: &[S; 3], factor: S) -> [S; 3] {
    [v[0] * factor, v[1] * factor, v[2] * factor]
}

/// −(A + B + C).
#[inline(always)]
fn minus_sum<S: Scalar>(a: &Matrix3<S>, b: &Matrix3<S>, c: &Matrix3<S>) -> Matrix3<S> {
    scaled(&sum(&sum(a, b), c), S::constant(-1.0))
}

/// Block (j, l) for any order of j and l.
#[inline(always)]
fn block<S: Scalar>(blocks: &[Matrix3<S>; 6], j: usize, l: usize) -> Matrix3<S> {
    const INDEX: [[usize; 3]; 3] = [[0, 1, 2], [1, 3, 4], [2, 4, 5]];
    let stored = &blocks[INDEX[j][l]];
    if j <= l { *stored } else { transpose(stored) }
}

/// Σₗ bₗ · block (j, l), for j = 0, 1, 2.
#[inline(always)]
fn half_contractions<S: Scalar>(blocks: &[Matrix3<S>; 6], b: &[S; 3]) -> [Matrix3<S>; 3] {
    let mut rows = [zero(); 3];
    for j in 0..3 {
        rows[j] = weighted_sum(b, &[block(blocks, j, 0), block(blocks, j, 1), block(blocks, j, 2)]);
    }
    rows
}

/// Σⱼ wⱼ Mⱼ.
#[inline(always)]
fn weighted_sum<S: Scalar>(weights: &[S; 3], matrices: &[Matrix3<S>; 3]) -> Matrix3<S> {
    let first = scaled(&matrices[0], weights[0]);
    let second = add_scaled(&first, weights[1], &matrices[1]);
    add_scaled(&second, weights[2], &matrices[2])
}

/// a ⊗ b.
#[inline(always)]
pub(super) fn outer<S: Scalar>(a: &[S; 3], b: &[S; 3]) -> Matrix3<S> {
    from_entries(|i, k| a[i] * b[k])
}

/// The matrix with εᵢₖₚ aₚ in row i, column k.
#[inline(always)]
pub(super) fn cross_matrix<S: Scalar>(a: &[S; 3]) -> Matrix3<S> {
    let mut m = [[S::constant(0.0); 3]; 3];
    for p in 0..3 {
        let (i, k) = ((p + 1) % 3, (p + 2) % 3);
        m[k][i] = a[p];
        m[i][k] = -a[p];
    }
    from_columns(m)
}
