//! The closed-form eigen-system of isotropic laws.

use super::stiffness::{UPPER_TRIANGLE, multiple, per_axis};
use crate::decomposition::{Svd, symmetric_eigen};
use crate::projection::Projection;
use crate::scalar::{Mask, Scalar};
use crate::tensor::{
    Matrix3, apply, columns, from_columns, from_entries, lift, product, product_diagonal_transpose,
    product_transpose, transpose, transpose_product, vector, zero,
};

/// Pair k holds the axes other than k.
const PAIRS: [(usize, usize); 3] = [(1, 2), (0, 2), (0, 1)];

/// ∂P/∂F of an isotropic law in the principal axes of F = U diag(σ) Vᵀ.
///
/// Let ψ(σ₀, σ₁, σ₂) be the energy density in signed principal stretches, ψᵢ and ψᵢⱼ its derivatives. For
/// dF = U X Vᵀ the stress changes by dP = U Y Vᵀ, where
///
/// - Yᵢᵢ = Σⱼ ψᵢⱼ Xⱼⱼ, the *scaling* block;
/// - for i ≠ j, Yᵢⱼ = a Xᵢⱼ + b Xⱼᵢ with a + b = (ψᵢ − ψⱼ)/(σᵢ − σⱼ) and a − b = (ψᵢ + ψⱼ)/(σᵢ + σⱼ).
///
/// So three eigen-matrices are U(eᵢeⱼᵀ + eⱼeᵢᵀ)Vᵀ/√2 (*flip*, eigenvalue a + b), three are
/// U(eᵢeⱼᵀ − eⱼeᵢᵀ)Vᵀ/√2 (*twist*, eigenvalue a − b), and the last three come from the 3×3 scaling block.
/// Projection replaces nine eigenvalues and needs no 9×9 eigen-solve.
///
/// Each law supplies the two quotients in a form without 0/0: this type divides by no difference.
///
/// # Reference
/// Smith, de Goes, Kim, Analytic Eigensystems for Isotropic Distortion Energies (ACM Trans. Graph. 38(1), 2019);
/// Sifakis and Barbič, FEM Simulation of 3D Deformable Solids (SIGGRAPH course, 2012), part I.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrincipalStiffness<S> {
    u: Matrix3<S>,
    v: Matrix3<S>,
    /// ψᵢⱼ, symmetric.
    scaling: Matrix3<S>,
    /// Eigenvalues of the flip modes; number k belongs to the pair of axes other than k.
    flip: [S; 3],
    /// Eigenvalues of the twist modes, in the same order.
    twist: [S; 3],
}

impl<S: Scalar> PrincipalStiffness<S> {
    /// From ψᵢᵢ = `second(i)`, ψᵢⱼ = `mixed(i, j)`, (ψᵢ − ψⱼ)/(σᵢ − σⱼ) = `flip(i, j)` and
    /// (ψᵢ + ψⱼ)/(σᵢ + σⱼ) = `twist(i, j)` \[Pa\]; the last three are called with (i, j) = (1, 2), (0, 2), (0, 1).
    ///
    /// σ is sorted and signed as [`svd`](crate::decomposition::svd) returns it, so σᵢ ≥ |σⱼ| in these calls.
    #[inline(always)]
    pub fn new(
        svd: &Svd<S>,
        second: impl Fn(usize) -> S,
        mixed: impl Fn(usize, usize) -> S,
        flip: impl Fn(usize, usize) -> S,
        twist: impl Fn(usize, usize) -> S,
    ) -> Self {
        let zero = S::constant(0.0);
        let diagonal = per_axis(zero, second);
        let [m12, m02, m01] = per_axis(zero, |k| mixed(PAIRS[k].0, PAIRS[k].1));
        Self {
            u: svd.u,
            v: svd.v,
            scaling: from_columns([
                [diagonal[0], m01, m02],
                [m01, diagonal[1], m12],
                [m02, m12, diagonal[2]],
            ]),
            flip: per_axis(zero, |k| flip(PAIRS[k].0, PAIRS[k].1)),
            twist: per_axis(zero, |k| twist(PAIRS[k].0, PAIRS[k].1)),
        }
    }

    /// The same with its eigenvalues replaced as `projection` says.
    #[inline(always)]
    pub fn projected(self, projection: Projection) -> Self {
        if projection == Projection::None {
            return self;
        }
        let scaling = projected_symmetric(&self.scaling, projection);
        let flip = per_axis(self.flip[0], |k| projection.apply(self.flip[k]));
        let twist = per_axis(self.twist[0], |k| projection.apply(self.twist[k]));
        Self { scaling, flip, twist, ..self }
    }

    /// The nine eigenvalues \[Pa\]: three of the scaling block, descending, three flips, three twists.
    pub fn eigenvalues(&self) -> [S; 9] {
        let [a, b, c] = symmetric_eigen(&self.scaling).values;
        let ([d, e, f], [g, h, i]) = (self.flip, self.twist);
        [a, b, c, d, e, f, g, h, i]
    }

    /// The same over a scalar with derivatives, all of them zero.
    #[inline(always)]
    pub(super) fn lifted<J: Scalar<Value = S>>(&self) -> PrincipalStiffness<J> {
        PrincipalStiffness {
            u: lift(&self.u),
            v: lift(&self.v),
            scaling: lift(&self.scaling),
            flip: self.flip.map(J::lift),
            twist: self.twist.map(J::lift),
        }
    }

    /// a and b of Yᵢⱼ = a Xᵢⱼ + b Xⱼᵢ for the pairs of axes other than 0, 1, 2.
    #[inline(always)]
    fn shears(&self) -> ([S; 3], [S; 3]) {
        let zero = S::constant(0.0);
        let along = per_axis(zero, |k| (self.flip[k] + self.twist[k]).scale(0.5));
        let across = per_axis(zero, |k| (self.flip[k] - self.twist[k]).scale(0.5));
        (along, across)
    }

    /// Kᵢₖ = Σⱼₗ aⱼ (∂Pᵢⱼ/∂Fₖₗ) bₗ, see [`Stiffness::contraction`](super::Stiffness::contraction).
    #[inline(always)]
    pub fn contraction(&self, a: &[S; 3], b: &[S; 3]) -> Matrix3<S> {
        let (a, b) = (self.principal_components(a), self.principal_components(b));
        self.back(&self.principal_contraction(&self.shears(), &a, &b))
    }

    /// `volume` times the contractions of three gradients with each other: pairs (0,0), (0,1), (0,2), (1,1),
    /// (1,2), (2,2).
    #[inline(always)]
    pub(super) fn contractions(&self, gradients: &[[S; 3]; 3], volume: S) -> [Matrix3<S>; 6] {
        let rotated = [
            self.principal_components(&gradients[0]),
            self.principal_components(&gradients[1]),
            self.principal_components(&gradients[2]),
        ];
        let shears = self.shears();
        let mut contractions = [zero(); 6];
        for (target, (a, b)) in contractions.iter_mut().zip(UPPER_TRIANGLE) {
            let weighted = multiple(&rotated[a], volume);
            *target = self.back(&self.principal_contraction(&shears, &weighted, &rotated[b]));
        }
        contractions
    }

    /// Vᵀ g.
    #[inline(always)]
    fn principal_components(&self, g: &[S; 3]) -> [S; 3] {
        into_array(&apply(&transpose(&self.v), &vector(*g)))
    }

    /// The contraction in principal axes, where of 81 coefficients 21 differ from zero:
    /// Kᵢᵢ = ψᵢᵢ aᵢbᵢ + Σⱼ≠ᵢ a⁽ⁱʲ⁾ aⱼbⱼ and Kᵢₖ = ψᵢₖ aᵢbₖ + b⁽ⁱᵏ⁾ aₖbᵢ.
    #[inline(always)]
    fn principal_contraction(&self, shears: &([S; 3], [S; 3]), a: &[S; 3], b: &[S; 3]) -> Matrix3<S> {
        let (along, across) = shears;
        let scaling = columns(&self.scaling);
        let products = [a[0] * b[0], a[1] * b[1], a[2] * b[2]];
        let mut contraction = [[S::constant(0.0); 3]; 3];
        for k in 0..3 {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            let shear = along[j].mul_add(products[i], along[i] * products[j]);
            contraction[k][k] = scaling[k][k].mul_add(products[k], shear);
            contraction[j][i] = (scaling[j][i] * a[i]).mul_add(b[j], across[k] * a[j] * b[i]);
            contraction[i][j] = (scaling[j][i] * a[j]).mul_add(b[i], across[k] * a[i] * b[j]);
        }
        from_columns(contraction)
    }

    /// U K Uᵀ.
    #[inline(always)]
    fn back(&self, k: &Matrix3<S>) -> Matrix3<S> {
        product_transpose(&product(&self.u, k), &self.u)
    }

    /// dP for a change dF of the deformation gradient \[Pa\].
    #[inline(always)]
    pub fn apply(&self, df: &Matrix3<S>) -> Matrix3<S> {
        let (along, across) = self.shears();
        let x = product(&transpose_product(&self.u, df), &self.v);
        let (x, scaling) = (columns(&x), columns(&self.scaling));
        let y = from_entries(|i, j| {
            if i == j {
                scaling[i][0] * x[0][0] + scaling[i][1] * x[1][1] + scaling[i][2] * x[2][2]
            } else {
                let pair = 3 - i - j;
                along[pair] * x[j][i] + across[pair] * x[i][j]
            }
        });
        product_transpose(&product(&self.u, &y), &self.v)
    }
}

/// The symmetric `a` with its eigenvalues replaced. Lanes on which it is positive definite keep it bit by bit, whatever
/// their neighbours hold; if all lanes do, which is the common case, there is no eigen-solve.
#[inline(always)]
fn projected_symmetric<S: Scalar>(a: &Matrix3<S>, projection: Projection) -> Matrix3<S> {
    let definite = is_positive_definite(a);
    if definite.all() {
        return *a;
    }
    let eigen = symmetric_eigen(a);
    let values = per_axis(eigen.values[0], |i| projection.apply(eigen.values[i]));
    let replaced = product_diagonal_transpose(&eigen.vectors, &values, &eigen.vectors);
    let (kept, replaced) = (columns(a), columns(&replaced));
    from_entries(|i, j| S::select(definite, kept[j][i], replaced[j][i]))
}

/// Whether the pivots of A = L D Lᵀ are positive.
///
/// The factorisation is backward stable, so a matrix that passes has no eigenvalue below some −ε‖A‖. The signs of the
/// leading minors (Sylvester's criterion) promise less: rounding of a determinant hides −10⁻⁹‖A‖ between ‖A‖ and
/// 10⁻⁸‖A‖.
#[inline(always)]
fn is_positive_definite<S: Scalar>(a: &Matrix3<S>) -> S::Mask {
    let zero = S::constant(0.0);
    let m = columns(a);
    let reciprocal = m[0][0].recip();
    let (l1, l2) = (m[0][1] * reciprocal, m[0][2] * reciprocal);
    let pivot = m[1][1] - l1 * m[0][1];
    let rest = m[1][2] - l1 * m[0][2];
    let last = m[2][2] - l2 * m[0][2] - rest * (rest / pivot);
    zero.less(m[0][0]).and(zero.less(pivot)).and(zero.less(last))
}

#[inline(always)]
fn into_array<S: Scalar>(v: &crate::tensor::Vector3<S>) -> [S; 3] {
    *crate::tensor::components(v)
}
