//! Small dense linear systems on the matrices of [`Coordinates`].

use crate::coordinates::Coordinates;
use crate::error::{LagrangianError, Symbol};

/// Solves M x = b for a symmetric positive definite M by the factorisation M = L D Lᵀ (without square roots), in
/// place: `mass` is overwritten by the factors, `b` by the solution.
///
/// # Errors
/// [`LagrangianError::SingularMass`] if a pivot is not above 4 n ε times the largest diagonal entry of its row before
/// elimination, with the velocity that has no inertia; [`LagrangianError::NonFinite`] if an entry or the right side is not finite.
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

/// Overwrites a symmetric positive definite M of `n` rows by the factors of M = L D Lᵀ, on and below the diagonal.
///
/// # Errors
/// As [`solve_mass`].
#[inline]
pub fn factor_mass<C: Coordinates>(time: f64, mass: &mut C::Matrix, n: usize) -> Result<(), LagrangianError> {
    let m = C::entries_mut(mass);
    for j in 0..n {
        let diagonal = m[j * n + j];
        for k in 0..j {
            m[j * n + j] -= m[j * n + k] * m[j * n + k] * m[k * n + k];
        }
        let pivot = m[j * n + j];
        if !pivot.is_finite() || pivot <= 4.0 * n as f64 * f64::EPSILON * diagonal.abs() {
            return Err(refusal(time, m, j, n));
        }
        for i in j + 1..n {
            let mut sum = m[j * n + i];
            for k in 0..j {
                sum -= m[i * n + k] * m[j * n + k] * m[k * n + k];
            }
            m[i * n + j] = sum / pivot;
        }
    }
    Ok(())
}

/// Overwrites `b` with M⁻¹ b, for the factors that [`factor_mass`] left.
#[inline]
pub fn solve_factored<C: Coordinates>(factors: &C::Matrix, b: &mut [f64]) {
    let (n, m) = (b.len(), C::entries(factors));
    for i in 0..n {
        for k in 0..i {
            b[i] -= m[i * n + k] * b[k];
        }
    }
    for i in (0..n).rev() {
        b[i] /= m[i * n + i];
        for k in i + 1..n {
            b[i] -= m[k * n + i] * b[k];
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
            null_direction[i] -= m[k * n + i] * null_direction[k];
        }
    }
    let length = null_direction.iter().map(|x| x * x).sum::<f64>().sqrt();
    null_direction.iter_mut().for_each(|x| *x /= length);
    LagrangianError::SingularMass { time, null_direction, pivot }
}
