//! What a law remembers of the motion: the whole deformation gradient, or only the change of volume.

use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::{
    Matrix3, add_scaled, columns, determinant, from_columns, multiple_of_identity, product, trace,
};

/// A fixed number of scalars, so that a grid code can store them one array a number.
///
/// ```
/// use mechanics_core::tensor::Mat3;
/// use mpm_constitutive::Numbers;
///
/// let f = Mat3::identity();
/// let stored: Vec<f64> = (0..<Mat3 as Numbers<f64>>::COUNT).map(|k| f.number(k)).collect();
/// assert_eq!(Mat3::from_numbers(|k| stored[k]), f);
/// ```
pub trait Numbers<S: Scalar>: Copy + Send + Sync + 'static {
    /// How many numbers there are.
    const COUNT: usize;

    /// The value whose number `k` is `number(k)`, asked in the order of k.
    fn from_numbers(number: impl FnMut(usize) -> S) -> Self;

    /// Number `k`.
    ///
    /// # Panics
    /// If `k ≥ COUNT`.
    fn number(&self, k: usize) -> S;
}

/// No numbers: the history of a material that has none.
impl<S: Scalar> Numbers<S> for () {
    const COUNT: usize = 0;

    #[inline(always)]
    fn from_numbers(_number: impl FnMut(usize) -> S) -> Self {}

    #[inline(always)]
    fn number(&self, k: usize) -> S {
        panic!("number {k} of none")
    }
}

/// The nine entries, column by column.
impl<S: Scalar> Numbers<S> for Matrix3<S> {
    const COUNT: usize = 9;

    #[inline(always)]
    fn from_numbers(mut number: impl FnMut(usize) -> S) -> Self {
        // Without a closure of its own, which would not be compiled for AVX2.
        from_columns([[number(0), number(1), number(2)], [number(3), number(4), number(5)], [number(6), number(7), number(8)]])
    }

    #[inline(always)]
    fn number(&self, k: usize) -> S {
        columns(self)[k / 3][k % 3]
    }
}

/// The measure of deformation that a law needs: [`Matrix3`], the (elastic) deformation gradient F, or
/// [`VolumeChange`], J − 1 alone.
pub trait Strain<S: Scalar>: Numbers<S> {
    /// No deformation: F = I, J = 1.
    fn undeformed() -> Self;

    /// The strain after the further displacement gradient G (of the present shape; h ∇v in a step h):
    /// F ← (I + G) F. By volume alone J ← (1 + tr G) J: the part of det(I + G) that is linear in G, so that momentum balance, whose
    /// forces are the derivative by G, conserves energy with it.
    fn advanced(&self, increment: &Matrix3<S>) -> Self;

    /// The strain of material whose total deformation gradient F is elastic.
    fn from_deformation_gradient(f: &Matrix3<S>) -> Self;

    /// J.
    fn volume_ratio(&self) -> S;
}

impl<S: Scalar> Strain<S> for Matrix3<S> {
    #[inline(always)]
    fn undeformed() -> Self {
        multiple_of_identity(S::constant(1.0))
    }

    #[inline(always)]
    fn advanced(&self, increment: &Matrix3<S>) -> Self {
        add_scaled(self, S::constant(1.0), &product(increment, self))
    }

    #[inline(always)]
    fn from_deformation_gradient(f: &Matrix3<S>) -> Self {
        *f
    }

    #[inline(always)]
    fn volume_ratio(&self) -> S {
        determinant(self)
    }
}

/// J − 1, for fluids. The difference is stored, because a nearly incompressible fluid lives on its last digits: a pressure
/// of 1e-4 of the bulk modulus keeps all seven digits of an `f32`, where J itself would leave three.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeChange<S>(pub S);

impl<S: Scalar> Numbers<S> for VolumeChange<S> {
    const COUNT: usize = 1;

    #[inline(always)]
    fn from_numbers(mut number: impl FnMut(usize) -> S) -> Self {
        Self(number(0))
    }

    #[inline(always)]
    fn number(&self, k: usize) -> S {
        assert!(k == 0, "number {k} of one");
        self.0
    }
}

impl<S: Scalar> Strain<S> for VolumeChange<S> {
    #[inline(always)]
    fn undeformed() -> Self {
        Self(S::constant(0.0))
    }

    #[inline(always)]
    fn advanced(&self, increment: &Matrix3<S>) -> Self {
        let growth = trace(increment);
        Self(self.0 + self.0.mul_add(growth, growth))
    }

    #[inline(always)]
    fn from_deformation_gradient(f: &Matrix3<S>) -> Self {
        Self(determinant(f).offset(-1.0))
    }

    #[inline(always)]
    fn volume_ratio(&self) -> S {
        self.0.offset(1.0)
    }
}
