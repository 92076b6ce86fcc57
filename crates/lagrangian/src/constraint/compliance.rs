//! What the constraints feel of the masses: M⁻¹Gᵀ and G M⁻¹ Gᵀ.

use super::linear::Symmetric;
use super::{ConstraintSet, Layout, Rows};
use crate::coordinates::Coordinates;
use crate::error::{LagrangianError, Symbol};
use std::ops::Range;

/// Factors of M and of G M⁻¹ Gᵀ.
#[derive(Clone, Debug)]
pub(super) struct Compliance<C: ConstraintSet> {
    /// The mass matrix whose factors are held.
    mass: <C::Coordinates as Coordinates>::Matrix,
    /// Whether `mass` was ever factored.
    factored: bool,
    masses: Symmetric<C::Coordinates>,
    schur: Symmetric<C::Multipliers>,
    /// For every constraint the coordinates that its response reaches; empty for a dense layout.
    reach: Vec<Range<usize>>,
}

/// Σⱼ aⱼ bⱼ over a range.
#[inline(always)]
fn dot(a: &[f64], b: &[f64], range: Range<usize>) -> f64 {
    let mut sum = 0.0;
    for j in range {
        sum += a[j] * b[j];
    }
    sum
}

impl<C: ConstraintSet> Compliance<C> {
    pub(super) fn new(constraints: &C) -> Self {
        let (n, count) = constraints.shape();
        Self {
            mass: C::Coordinates::zero_matrix(n),
            factored: false,
            masses: Symmetric::zeros(n, C::LAYOUT),
            schur: Symmetric::zeros(count, C::LAYOUT),
            reach: if C::LAYOUT == Layout::Dense { Vec::new() } else { vec![0..n; count] },
        }
    }

    /// The coordinates outside which the response to constraint k is zero.
    #[inline(always)]
    pub(super) fn reach(&self, k: usize, n: usize) -> Range<usize> {
        if C::LAYOUT == Layout::Dense { 0..n } else { self.reach[k].clone() }
    }

    /// Takes over M at `time`; factors it unless it is the one held.
    ///
    /// # Errors
    /// [`LagrangianError::SingularMass`], [`LagrangianError::NonFinite`].
    #[inline]
    pub(super) fn hold_mass(
        &mut self,
        time: f64,
        mass: &<C::Coordinates as Coordinates>::Matrix,
        n: usize,
    ) -> Result<(), LagrangianError> {
        if self.factored && self.mass == *mass {
            return Ok(());
        }
        self.factored = false;
        self.mass.clone_from(mass);
        self.masses.entries_mut().copy_from_slice(C::Coordinates::entries(mass));
        self.masses.factor(n).map_err(|(row, pivot)| {
            let entries = C::Coordinates::entries(mass);
            match entries.iter().position(|x| !x.is_finite()) {
                Some(index) => {
                    LagrangianError::NonFinite { symbol: Symbol::Mass, index, value: entries[index], time }
                }
                None => LagrangianError::SingularMass {
                    time,
                    null_direction: self.masses.null_direction(row, n),
                    pivot,
                },
            }
        })?;
        self.factored = true;
        Ok(())
    }

    /// b ← M⁻¹ b.
    #[inline(always)]
    pub(super) fn divide_by_mass(&self, b: &mut [f64]) {
        let n = b.len();
        self.masses.solve(b, 0..n);
    }

    /// Takes over G at `time`: overwrites row k of `response` with M⁻¹ ∇φₖ and factors G M⁻¹ Gᵀ.
    ///
    /// # Errors
    /// [`LagrangianError::RedundantConstraint`], [`LagrangianError::NonFinite`].
    #[inline]
    pub(super) fn hold_jacobian(
        &mut self,
        time: f64,
        constraints: &C,
        jacobian: &C::Jacobian,
        response: &mut C::Jacobian,
    ) -> Result<(), LagrangianError> {
        let (n, count) = constraints.shape();
        for (k, reach) in self.reach.iter_mut().enumerate() {
            *reach = self.masses.reach(constraints.support(k), n);
        }
        copy_rows::<C>(jacobian, response, |k| self.reach(k, n), n);
        let (g, w) = (jacobian.entries(), response.entries_mut());
        for k in 0..count {
            self.masses.solve(&mut w[k * n..(k + 1) * n], self.reach(k, n));
        }
        for k in 0..count {
            let support = constraints.support(k);
            for l in 0..=k {
                let common = overlap(&support, &self.reach(l, n));
                let entry = dot(&g[k * n..(k + 1) * n], &w[l * n..(l + 1) * n], common);
                self.schur.entries_mut()[k * count + l] = entry;
            }
        }
        self.schur.factor(count).map_err(|(index, pivot)| match g.iter().position(|x| !x.is_finite()) {
            Some(entry) => LagrangianError::NonFinite {
                symbol: Symbol::Constraint,
                index: entry / n,
                value: g[entry],
                time,
            },
            // Squares of finite gradients may overflow.
            None if !pivot.is_finite() => {
                LagrangianError::NonFinite { symbol: Symbol::Constraint, index, value: pivot, time }
            }
            None => LagrangianError::RedundantConstraint {
                index,
                combination: self.schur.null_direction(index, count),
                pivot,
                time,
            },
        })
    }

    /// b ← (G M⁻¹ Gᵀ)⁻¹ b.
    #[inline(always)]
    pub(super) fn divide_by_compliance(&self, b: &mut [f64]) {
        let count = b.len();
        self.schur.solve(b, 0..count);
    }

    /// Overwrites `product` with `left` · `right`ᵀ · factor, rows of `right` being responses to constraints.
    #[inline]
    pub(super) fn couple_into(
        &self,
        constraints: &C,
        left: &C::Jacobian,
        right: &C::Jacobian,
        factor: f64,
        product: &mut [f64],
    ) {
        let (n, count) = constraints.shape();
        let (g, w) = (left.entries(), right.entries());
        for k in 0..count {
            let support = constraints.support(k);
            for l in 0..count {
                let common = overlap(&support, &self.reach(l, n));
                product[k * count + l] = factor * dot(&g[k * n..(k + 1) * n], &w[l * n..(l + 1) * n], common);
            }
        }
    }

    /// x += Σₖ `weights`ₖ · row k of `rows`, which are responses to constraints.
    #[inline]
    pub(super) fn add_responses(&self, constraints: &C, rows: &C::Jacobian, weights: &[f64], x: &mut [f64]) {
        let n = x.len();
        for (k, &weight) in weights.iter().enumerate() {
            let row = &rows.entries()[k * n..(k + 1) * n];
            for j in self.masses.reach(constraints.support(k), n) {
                x[j] += weight * row[j];
            }
        }
    }
}

/// What two ranges have in common.
#[inline(always)]
fn overlap(a: &Range<usize>, b: &Range<usize>) -> Range<usize> {
    a.start.max(b.start)..a.end.min(b.end)
}

/// Overwrites `to` with `from`, of which row k is zero outside `range`(k), except in dense layouts.
#[inline(always)]
pub(super) fn copy_rows<C: ConstraintSet>(
    from: &C::Jacobian,
    to: &mut C::Jacobian,
    range: impl Fn(usize) -> Range<usize>,
    n: usize,
) {
    if C::LAYOUT == Layout::Dense {
        to.clone_from(from);
        return;
    }
    let rows = from.entries().chunks(n.max(1)).zip(to.entries_mut().chunks_mut(n.max(1)));
    for (k, (from, to)) in rows.enumerate() {
        to[range(k)].copy_from_slice(&from[range(k)]);
    }
}

/// Overwrites `out` with G x.
#[inline]
pub(super) fn multiply_into<C: ConstraintSet>(
    constraints: &C,
    jacobian: &C::Jacobian,
    x: &[f64],
    out: &mut [f64],
) {
    let n = x.len();
    for (k, out) in out.iter_mut().enumerate() {
        *out = dot(&jacobian.entries()[k * n..(k + 1) * n], x, constraints.support(k));
    }
}

/// x += Gᵀ `weights`.
#[inline]
pub(super) fn add_transposed<C: ConstraintSet>(
    constraints: &C,
    jacobian: &C::Jacobian,
    weights: &[f64],
    x: &mut [f64],
) {
    let n = x.len();
    for (k, &weight) in weights.iter().enumerate() {
        let row = &jacobian.entries()[k * n..(k + 1) * n];
        for j in constraints.support(k) {
            x[j] += weight * row[j];
        }
    }
}

/// The largest absolute value; NaN if there is one.
#[inline]
pub(super) fn largest(x: &[f64]) -> f64 {
    let mut largest = 0.0;
    for x in x {
        let x = x.abs();
        if x > largest || x.is_nan() {
            largest = x;
        }
    }
    largest
}

/// Which bounds φ has met.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Met {
    /// As near to zero as its rounding errors let it come.
    Tight,
    /// Within a safe multiple of that: good enough when corrections no longer help.
    Loose,
    /// Not zero.
    Not,
}

/// How near φ is to zero: [`Met::Tight`] if every |φₖ| ≤ 4 ε ‖∇φₖ‖₁ ‖q‖∞, what one rounding of q makes of it;
/// [`Met::Loose`] if every |φₖ| ≤ 64 ε (1 + ‖∇φₖ‖₁ ‖q‖∞); and the largest |φₖ| relative to the loose bound.
#[inline]
pub(super) fn measure<C: ConstraintSet>(
    constraints: &C,
    value: &[f64],
    jacobian: &C::Jacobian,
    q: &[f64],
) -> (Met, f64) {
    let size = f64::EPSILON * largest(q);
    let mut tight = true;
    for (k, phi) in value.iter().enumerate() {
        tight &= phi.abs() <= 4.0 * size * steepness(constraints, jacobian, k, q.len());
    }
    if tight {
        return (Met::Tight, 0.0);
    }
    let mut worst = 0.0;
    for (k, phi) in value.iter().enumerate() {
        let rounding = f64::EPSILON + size * steepness(constraints, jacobian, k, q.len());
        let relative = phi.abs() / (64.0 * rounding);
        if relative > worst || relative.is_nan() {
            worst = relative;
        }
    }
    (if worst <= 1.0 { Met::Loose } else { Met::Not }, worst)
}

/// ‖∇φₖ‖₁.
#[inline(always)]
fn steepness<C: ConstraintSet>(constraints: &C, jacobian: &C::Jacobian, k: usize, n: usize) -> f64 {
    let row = &jacobian.entries()[k * n..(k + 1) * n];
    let mut sum = 0.0;
    for j in constraints.support(k) {
        sum += row[j].abs();
    }
    sum
}
