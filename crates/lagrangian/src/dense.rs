//! Small dense linear systems on the matrices of [`Coordinates`].

use crate::coordinates::Coordinates;
use crate::error::{LagrangianError, Symbol};

/// Solves M x = b for a symmetric positive definite M, in place: `mass` is overwritten by its factors (see
/// [`factor_mass`]), `b` by the solution. Nothing is allocated unless it fails.
///
/// # Errors
/// As [`factor_mass`]; [`LagrangianError::NonFinite`] if an entry of the solution is not finite.
#[inline]
pub fn solve_mass<C: Coordinates>(
    time: f64,
    mass: &mut C::Matrix,
    b: &mut [f64],
) -> Result<(), LagrangianError> {
    factor_mass::<C>(time, mass, b.len())?;
    solve_factored::<C>(mass, b);
    match b.iter().position(|x| !x.is_finite()) {
        Some(index) => {
            Err(LagrangianError::NonFinite { symbol: Symbol::Acceleration, index, value: b[index], time })
        }
        None => Ok(()),
    }
}

/// Overwrites a symmetric positive definite n × n matrix by its factors M = L D Lᵀ, L with ones on its diagonal.
///
/// Row j of D Lᵀ is row j of M less those above it, each times the entry that it has in column j:
///
/// c_ji = m_ji − Σ_{k<j} l_jk c_ki for i ≥ j, then d_j = c_jj and l_ij = c_ji / d_j.
///
/// All of it runs along rows. Stored are 1/d_j on the diagonal, l_ij above it at (j, i), and c_ji below it at (i, j).
///
/// # Errors
/// [`LagrangianError::SingularMass`] if a pivot d_j is not above 4 n ε |m_jj|, which is the size of its rounding error,
/// with the velocity that has no inertia; [`LagrangianError::NonFinite`] if a pivot is not finite.
#[inline]
pub fn factor_mass<C: Coordinates>(time: f64, mass: &mut C::Matrix, n: usize) -> Result<(), LagrangianError> {
    let m = &mut C::entries_mut(mass)[..n * n];
    for j in 0..n {
        let diagonal = m[j * n + j];
        for k in 0..j {
            let c = m[j * n + k];
            // A long chain's mass matrix is mostly zeros; for few coordinates the question costs more than it saves.
            if n > 8 && c == 0.0 {
                continue;
            }
            for i in j..n {
                m[j * n + i] -= c * m[k * n + i];
            }
        }
        let pivot = m[j * n + j];
        let positive = pivot > 4.0 * n as f64 * f64::EPSILON * diagonal.abs() && pivot.is_finite();
        if !positive {
            return Err(refusal(time, m, j, n));
        }
        let reciprocal = 1.0 / pivot;
        m[j * n + j] = reciprocal;
        for i in j + 1..n {
            let c = m[j * n + i];
            m[i * n + j] = c;
            m[j * n + i] = c * reciprocal;
        }
    }
    Ok(())
}

/// Overwrites b by M⁻¹ b, from the factors that [`factor_mass`] has left in `mass`.
#[inline]
pub fn solve_factored<C: Coordinates>(mass: &C::Matrix, b: &mut [f64]) {
    let n = b.len();
    let m = &C::entries(mass)[..n * n];
    for j in 0..n {
        for i in j + 1..n {
            b[i] -= m[j * n + i] * b[j];
        }
    }
    for i in (0..n).rev() {
        b[i] *= m[i * n + i];
        for k in i + 1..n {
            b[i] -= m[i * n + k] * b[k];
        }
    }
}

/// Overwrites `bounds` by |M| |w|, or a little more, from the factors that [`factor_mass`] has left in `mass`: rounding of the
/// product M w is a few ε of that. (It is |D Lᵀ|ᵀ |Lᵀ| |w|.)
pub(crate) fn bound_momentum<C: Coordinates>(mass: &C::Matrix, w: &[f64], bounds: &mut [f64]) {
    let n = w.len();
    let m = &C::entries(mass)[..n * n];
    for k in 0..n {
        bounds[k] = w[k].abs() + (k + 1..n).map(|l| (m[k * n + l] * w[l]).abs()).sum::<f64>();
    }
    for j in (0..n).rev() {
        bounds[j] /= m[j * n + j];
        for k in 0..j {
            bounds[j] += m[j * n + k].abs() * bounds[k];
        }
    }
}

/// Solves A x = b by elimination with partial pivoting, in place: `a`, row by row, is overwritten by the factors, `b`
/// by the solution.
///
/// Answers `None` if a column has no finite pivot other than zero; `a` and `b` are then spoilt.
///
/// # Panics
/// If `a` does not have one row and one column per entry of `b`.
pub fn solve_general(a: &mut [f64], b: &mut [f64]) -> Option<()> {
    let n = b.len();
    assert_eq!(a.len(), n * n, "a square matrix with one row per right-side entry");
    for j in 0..n {
        let pivot_row = (j..n).max_by(|&r, &s| a[r * n + j].abs().total_cmp(&a[s * n + j].abs()))?;
        let pivot = a[pivot_row * n + j];
        if pivot == 0.0 || !pivot.is_finite() {
            return None;
        }
        if pivot_row != j {
            (0..n).for_each(|k| a.swap(j * n + k, pivot_row * n + k));
            b.swap(j, pivot_row);
        }
        for i in j + 1..n {
            let factor = a[i * n + j] / pivot;
            if factor != 0.0 {
                for k in j + 1..n {
                    a[i * n + k] -= factor * a[j * n + k];
                }
                b[i] -= factor * b[j];
            }
        }
    }
    for i in (0..n).rev() {
        for k in i + 1..n {
            b[i] -= a[i * n + k] * b[k];
        }
        b[i] /= a[i * n + i];
    }
    b.iter().all(|x| x.is_finite()).then_some(())
}

/// The error for pivot `j`: the null direction solves Lᵀ x = e_j within the first j + 1 coordinates.
#[cold]
fn refusal(time: f64, m: &[f64], j: usize, n: usize) -> LagrangianError {
    let pivot = m[j * n + j];
    if !pivot.is_finite() {
        return LagrangianError::NonFinite { symbol: Symbol::Mass, index: j * n + j, value: pivot, time };
    }
    let mut null_direction = vec![0.0; n];
    null_direction[j] = 1.0;
    for i in (0..j).rev() {
        for k in i + 1..=j {
            null_direction[i] -= m[i * n + k] * null_direction[k];
        }
    }
    let length = null_direction.iter().map(|x| x * x).sum::<f64>().sqrt();
    null_direction.iter_mut().for_each(|x| *x /= length);
    LagrangianError::SingularMass { time, null_direction, pivot }
}
