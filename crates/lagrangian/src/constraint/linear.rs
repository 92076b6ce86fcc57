//! Factorisations of the small matrices of a constrained step, full or with their leading zeros left out.

use crate::coordinates::Coordinates;
use std::ops::Range;

/// How zeros of a matrix are treated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// As any number: for sizes that the compiler knows, where loops unroll.
    Dense,
    /// Zeros left of a row's first entry (and outside the band) are left out of all loops: a chain's matrices are
    /// then factored in linear time.
    Envelope,
}

/// A pivot of G M⁻¹ Gᵀ or M is taken for zero below this fraction of its diagonal entry.
pub(super) const SINGULAR: f64 = 1e-13;

/// A symmetric positive definite matrix as L D Lᵀ.
#[derive(Clone, Debug)]
pub(super) struct Symmetric<C: Coordinates> {
    layout: Layout,
    /// Strict lower triangle: L; diagonal: D⁻¹.
    factors: C::Matrix,
    /// For every row its first entry; empty for a dense layout.
    first: Vec<usize>,
    /// For every row the range of rows that it is coupled to through any others; empty for a dense layout.
    block: Vec<Range<usize>>,
}

impl<C: Coordinates> Symmetric<C> {
    pub(super) fn zeros(n: usize, layout: Layout) -> Self {
        let rows = if layout == Layout::Dense { 0 } else { n };
        Self { layout, factors: C::zero_matrix(n), first: vec![0; rows], block: vec![0..n; rows] }
    }

    /// The factors; a caller overwrites their lower triangle with a matrix and then calls [`Self::factor`].
    #[inline(always)]
    pub(super) fn entries_mut(&mut self) -> &mut [f64] {
        C::entries_mut(&mut self.factors)
    }

    #[inline(always)]
    fn first(&self, i: usize) -> usize {
        if self.layout == Layout::Dense { 0 } else { self.first[i] }
    }

    /// All rows that an entry in `range` of a right side reaches in a solution.
    #[inline(always)]
    pub(super) fn reach(&self, range: Range<usize>, n: usize) -> Range<usize> {
        match self.layout {
            Layout::Dense => 0..n,
            Layout::Envelope if range.is_empty() => range,
            Layout::Envelope => self.block[range.start].start..self.block[range.end - 1].end,
        }
    }

    /// Factors in place, reading the lower triangle.
    ///
    /// Row i: yⱼ = aᵢⱼ − Σₖ yₖ Lⱼₖ for j < i, then Lᵢⱼ = yⱼ dⱼ⁻¹ and dᵢ = aᵢᵢ − Σⱼ yⱼ Lᵢⱼ; sums start where both rows
    /// have entries.
    ///
    /// # Errors
    /// The row whose pivot is not above [`SINGULAR`] times its diagonal entry (or is no number), and the pivot.
    #[inline]
    pub(super) fn factor(&mut self, n: usize) -> Result<(), (usize, f64)> {
        if self.layout == Layout::Envelope {
            self.find_envelope(n);
        }
        for i in 0..n {
            let from = self.first(i);
            for j in from..i {
                let start = from.max(self.first(j));
                let a = C::entries_mut(&mut self.factors);
                let mut y = a[i * n + j];
                for k in start..j {
                    y -= a[i * n + k] * a[j * n + k];
                }
                a[i * n + j] = y;
            }
            let a = C::entries_mut(&mut self.factors);
            let diagonal = a[i * n + i];
            let mut pivot = diagonal;
            for j in from..i {
                let y = a[i * n + j];
                a[i * n + j] = y * a[j * n + j];
                pivot -= y * a[i * n + j];
            }
            a[i * n + i] = pivot.recip();
            let regular = pivot > SINGULAR * diagonal.abs() && pivot.is_finite();
            if !regular {
                return Err((i, pivot));
            }
        }
        Ok(())
    }

    fn find_envelope(&mut self, n: usize) {
        let a = C::entries(&self.factors);
        for i in 0..n {
            self.first[i] = (0..i).find(|j| a[i * n + j] != 0.0).unwrap_or(i);
        }
        let mut end = n;
        let mut start = n;
        for i in (0..n).rev() {
            start = start.min(self.first[i]);
            if start == i {
                self.block[i..end].fill(i..end);
                end = i;
            }
        }
    }

    /// Overwrites `b` with the solution; `range` is the [`Self::reach`] of the entries of b that are not zero.
    #[inline(always)]
    pub(super) fn solve(&self, b: &mut [f64], range: Range<usize>) {
        let (a, n) = (C::entries(&self.factors), b.len());
        for i in range.clone() {
            for k in self.first(i)..i {
                b[i] -= a[i * n + k] * b[k];
            }
        }
        for i in range.clone() {
            b[i] *= a[i * n + i];
        }
        for i in range.rev() {
            for k in self.first(i)..i {
                b[k] -= a[i * n + k] * b[i];
            }
        }
    }

    /// After [`Self::factor`] failed at row `pivot`: x of length one with xᵀ A x = that pivot, from Lᵀ x = e_pivot.
    pub(super) fn null_direction(&self, pivot: usize, n: usize) -> Vec<f64> {
        let a = C::entries(&self.factors);
        let mut x = vec![0.0; n];
        x[pivot] = 1.0;
        for i in (0..=pivot).rev() {
            for k in self.first(i)..i {
                x[k] -= a[i * n + k] * x[i];
            }
        }
        let length = x.iter().map(|x| x * x).sum::<f64>().sqrt();
        x.iter_mut().for_each(|x| *x /= length);
        x
    }
}

/// A square matrix as P A = L U with row pivoting; in the envelope layout within its band.
#[derive(Clone, Debug)]
pub(super) struct General<C: Coordinates> {
    layout: Layout,
    factors: C::Matrix,
    /// The row that was exchanged with row j before its elimination.
    exchanged: Vec<usize>,
    /// The largest |i − j| of an entry.
    band: usize,
}

impl<C: Coordinates> General<C> {
    pub(super) fn zeros(n: usize, layout: Layout) -> Self {
        Self { layout, factors: C::zero_matrix(n), exchanged: vec![0; n], band: n }
    }

    /// The factors; a caller overwrites them with a matrix and then calls [`Self::factor`].
    #[inline(always)]
    pub(super) fn entries_mut(&mut self) -> &mut [f64] {
        C::entries_mut(&mut self.factors)
    }

    /// Factors in place.
    ///
    /// # Errors
    /// The column without a pivot.
    #[inline]
    pub(super) fn factor(&mut self, n: usize) -> Result<(), usize> {
        self.band = self.find_band(n);
        let a = C::entries_mut(&mut self.factors);
        for j in 0..n {
            let below = (j + self.band + 1).min(n);
            let right = (j + 2 * self.band + 1).min(n);
            let mut pivot = j;
            for i in j + 1..below {
                if a[i * n + j].abs() > a[pivot * n + j].abs() {
                    pivot = i;
                }
            }
            self.exchanged[j] = pivot;
            if pivot != j {
                for k in j..right {
                    a.swap(j * n + k, pivot * n + k);
                }
            }
            let diagonal = a[j * n + j];
            if diagonal == 0.0 || !diagonal.is_finite() {
                return Err(j);
            }
            for i in j + 1..below {
                let factor = a[i * n + j] / diagonal;
                a[i * n + j] = factor;
                if factor != 0.0 {
                    for k in j + 1..right {
                        a[i * n + k] -= factor * a[j * n + k];
                    }
                }
            }
        }
        Ok(())
    }

    #[inline]
    fn find_band(&self, n: usize) -> usize {
        let a = C::entries(&self.factors);
        match self.layout {
            Layout::Dense => n,
            Layout::Envelope => {
                // No early exits: the compiler then compares several entries at once.
                let any = |row: &[f64]| row.iter().fold(false, |any, x| any | (*x != 0.0));
                let mut band = 0;
                for (i, row) in a.chunks_exact(n.max(1)).enumerate() {
                    while any(&row[..i.saturating_sub(band)]) || any(&row[(i + band + 1).min(n)..]) {
                        band += 1;
                    }
                }
                band
            }
        }
    }

    /// Overwrites `b` with the solution.
    #[inline(always)]
    pub(super) fn solve(&self, b: &mut [f64]) {
        let (a, n) = (C::entries(&self.factors), b.len());
        for j in 0..n {
            b.swap(j, self.exchanged[j]);
            for i in j + 1..(j + self.band + 1).min(n) {
                b[i] -= a[i * n + j] * b[j];
            }
        }
        for j in (0..n).rev() {
            for k in j + 1..(j + 2 * self.band + 1).min(n) {
                b[j] -= a[j * n + k] * b[k];
            }
            b[j] /= a[j * n + j];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed;
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        }
    }

    /// Entries within `band` of the diagonal, which `shift` is added to.
    fn banded(n: usize, band: usize, shift: f64, seed: u64) -> Vec<f64> {
        let mut next = numbers(seed);
        let entry = |i: usize, j: usize, x: f64| if i.abs_diff(j) <= band { x } else { 0.0 } + if i == j { shift } else { 0.0 };
        (0..n * n).map(|ij| entry(ij / n, ij % n, next())).collect()
    }

    fn product(a: &[f64], x: &[f64]) -> Vec<f64> {
        a.chunks(x.len()).map(|row| row.iter().zip(x).map(|(a, x)| a * x).sum()).collect()
    }

    #[test]
    fn lu_solves_dense_and_banded_systems_that_need_pivoting() {
        for (n, band) in [(1, 0), (2, 1), (7, 2), (9, 8), (30, 3)] {
            for layout in [Layout::Dense, Layout::Envelope] {
                let mut a = banded(n, band, 0.0, n as u64);
                if n > 1 {
                    a[0] = 0.0;
                }
                let x: Vec<f64> = (0..n).map(|i| 1.0 + i as f64).collect();
                let mut b = product(&a, &x);
                let mut lu = General::<Vec<f64>>::zeros(n, layout);
                lu.entries_mut().copy_from_slice(&a);
                assert_eq!(lu.factor(n), Ok(()));
                lu.solve(&mut b);
                let error = b.iter().zip(&x).map(|(b, x)| (b - x).abs()).fold(0.0, f64::max);
                assert!(error < 1e-10, "{n} {band} {layout:?}: {error:e}");
            }
        }
    }

    #[test]
    fn symmetric_factors_solve_blocks_and_bands() {
        for (n, band) in [(1, 0), (5, 0), (8, 1), (20, 3), (6, 5)] {
            for layout in [Layout::Dense, Layout::Envelope] {
                let half = banded(n, band, 0.0, 7);
                let mut a = vec![0.0; n * n];
                for i in 0..n {
                    for j in 0..n {
                        a[i * n + j] = half[i * n + j] + half[j * n + i] + if i == j { 8.0 } else { 0.0 };
                    }
                }
                let x: Vec<f64> = (0..n).map(|i| 1.0 - i as f64).collect();
                let mut b = product(&a, &x);
                let mut ldl = Symmetric::<Vec<f64>>::zeros(n, layout);
                ldl.entries_mut().copy_from_slice(&a);
                assert_eq!(ldl.factor(n), Ok(()));
                ldl.solve(&mut b, 0..n);
                let error = b.iter().zip(&x).map(|(b, x)| (b - x).abs()).fold(0.0, f64::max);
                assert!(error < 1e-13, "{n} {band} {layout:?}: {error:e}");
            }
        }
    }

    #[test]
    fn reach_of_a_block_diagonal_matrix_is_the_block() {
        let mut ldl = Symmetric::<Vec<f64>>::zeros(4, Layout::Envelope);
        ldl.entries_mut().copy_from_slice(&[2., 0., 0., 0., 1., 2., 0., 0., 0., 0., 2., 0., 0., 0., 1., 2.]);
        assert_eq!(ldl.factor(4), Ok(()));
        assert_eq!(ldl.reach(1..2, 4), 0..2);
        assert_eq!(ldl.reach(2..3, 4), 2..4);
        assert_eq!(ldl.reach(1..3, 4), 0..4);
    }

    #[test]
    fn a_singular_matrix_names_its_null_direction() {
        let mut ldl = Symmetric::<[f64; 2]>::zeros(2, Layout::Dense);
        ldl.entries_mut().copy_from_slice(&[1., 2., 2., 4.]);
        let (row, _) = ldl.factor(2).expect_err("a singular matrix");
        assert_eq!(row, 1);
        let x = ldl.null_direction(1, 2);
        assert!((x[0] + 2.0 * x[1]).abs() < 1e-15, "{x:?}");
    }
}
