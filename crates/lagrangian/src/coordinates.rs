//! Arrays of one number per coordinate, and the state of motion made of them.

use crate::error::{LagrangianError, Symbol};
use std::fmt::Debug;

/// One number per generalised coordinate: `[f64; N]` for a size that the compiler knows, `Vec<f64>` for any other.
///
/// Integrators are written once over this trait; for arrays the compiler unrolls their loops.
pub trait Coordinates:
    Clone + Debug + PartialEq + Send + Sync + 'static + AsRef<[f64]> + AsMut<[f64]>
{
    /// A square matrix with one row and one column per coordinate.
    type Matrix: Clone + Debug + PartialEq + Send + Sync + 'static;

    /// Zeros.
    ///
    /// # Panics
    /// For an array type, if `dimension` is not its length.
    fn zeros(dimension: usize) -> Self;

    /// The zero matrix.
    ///
    /// # Panics
    /// For an array type, if `dimension` is not its length.
    fn zero_matrix(dimension: usize) -> Self::Matrix;

    /// The entries of a matrix, row by row.
    fn entries(matrix: &Self::Matrix) -> &[f64];

    /// The entries of a matrix, row by row.
    fn entries_mut(matrix: &mut Self::Matrix) -> &mut [f64];
}

impl<const N: usize> Coordinates for [f64; N] {
    type Matrix = [[f64; N]; N];

    #[inline]
    fn zeros(dimension: usize) -> Self {
        assert_eq!(dimension, N, "an array of {N} coordinates");
        [0.0; N]
    }

    #[inline]
    fn zero_matrix(dimension: usize) -> Self::Matrix {
        assert_eq!(dimension, N, "an array of {N} coordinates");
        [[0.0; N]; N]
    }

    #[inline]
    fn entries(matrix: &Self::Matrix) -> &[f64] {
        matrix.as_flattened()
    }

    #[inline]
    fn entries_mut(matrix: &mut Self::Matrix) -> &mut [f64] {
        matrix.as_flattened_mut()
    }
}

impl Coordinates for Vec<f64> {
    type Matrix = Vec<f64>;

    fn zeros(dimension: usize) -> Self {
        vec![0.0; dimension]
    }

    fn zero_matrix(dimension: usize) -> Self::Matrix {
        vec![0.0; dimension * dimension]
    }

    fn entries(matrix: &Self::Matrix) -> &[f64] {
        matrix
    }

    fn entries_mut(matrix: &mut Self::Matrix) -> &mut [f64] {
        matrix
    }
}

/// The state of motion: a time, coordinates and their velocities.
#[derive(Clone, Debug, PartialEq)]
pub struct Phase<C> {
    /// Time t \[s\].
    pub time: f64,
    /// Generalised coordinates q, each in its own unit.
    pub q: C,
    /// Generalised velocities q̇, the coordinates' units per second.
    pub v: C,
}

impl<C: Coordinates> Phase<C> {
    /// A state of motion from its parts.
    ///
    /// # Panics
    /// If there is not one velocity per coordinate.
    pub fn new(time: f64, q: C, v: C) -> Self {
        assert_eq!(q.as_ref().len(), v.as_ref().len(), "one velocity per coordinate");
        Self { time, q, v }
    }

    /// Whether a step of size `h` from here continues one that has left the state `left`: the same coordinates and
    /// velocities, and a time that differs by rounding only.
    #[inline]
    pub fn continues(&self, left: &Self, h: f64) -> bool {
        let rounding = 1e-6 * h.abs() + 4.0 * f64::EPSILON * self.time.abs();
        self.q == left.q && self.v == left.v && (self.time - left.time).abs() <= rounding
    }

    /// Refuses a state with a NaN or an infinity.
    ///
    /// # Errors
    /// [`LagrangianError::NonFinite`] names the first offending number.
    pub fn validate(&self) -> Result<(), LagrangianError> {
        let time = self.time;
        let check = |symbol, values: &[f64]| match values.iter().position(|x| !x.is_finite()) {
            Some(index) => Err(LagrangianError::NonFinite { symbol, index, value: values[index], time }),
            None => Ok(()),
        };
        check(Symbol::Time, &[time])?;
        check(Symbol::Coordinate, self.q.as_ref())?;
        check(Symbol::Velocity, self.v.as_ref())
    }
}
