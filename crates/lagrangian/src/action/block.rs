//! Symmetric block-tridiagonal matrices: factors, solutions, inertia.
//!
//! **Elimination with delayed pivots.** Block after block is eliminated. Before the first conjugate point every
//! pivot block is positive definite, and Cholesky's factors serve. Past it a pivot block may be singular or nearly
//! so although the matrix is not: where a conjugate point falls on a node, the path up to there has a singular
//! Hessian. Dividing by such a block would destroy all digits. So a pivot block F, coupled to the next block by C,
//! is accepted as it is only if F is positive definite and Cᵀ F⁻¹ C does not exceed ‖C‖/τ. Otherwise F = Q Λ Qᵀ is
//! diagonalised by Jacobi's rotations, the directions with |λᵢ| ≥ τ ‖Cᵀ qᵢ‖ are eliminated, and the others join the
//! next block, in which their coupling makes pivots of its own size. The update of a block is then bounded by
//! ‖C‖/τ, once, not once per block: the elimination is backward stable. This is the delayed pivoting of
//! multifrontal solvers (Duff and Reid, *The multifrontal solution of indefinite sparse symmetric linear
//! equations*, ACM TOMS 9 (1983)) with the 2 × 2 pivots of Bunch and Kaufman replaced by eigenvectors.
//!
//! **Inertia.** Every eliminated direction is one eigenvalue of a matrix congruent to the whole; by Sylvester's law
//! the signs of all of them are the signs of the eigenvalues of the whole.
//!
//! **Units.** Row and column j are first multiplied by a power of two near (max_i |aᵢⱼ|)^(−1/2), so that
//! coordinates in different units do not hide each other; the inertia does not change by that.

/// The factor τ below which a pivot is delayed: growth by 1/τ loses one digit at most.
const THRESHOLD: f64 = 0.1;

/// A scaled pivot up to this is zero. The last pivot of a path that ends δt after a conjugate point is about δt/h
/// (for the oscillator it is sin(nθ)/sin((n − 1)θ) with θ = ωh), so this is a part of the interval in time;
/// rounding of the entries, adding up over the unknowns, comes on top.
const CONJUGATE: f64 = 1e-10;

/// A symmetric block-tridiagonal matrix. Only the last rows of a block, as many as `coupled`, couple to the next
/// block.
#[derive(Clone, Debug)]
pub(super) struct BlockTridiagonal {
    /// The number of unknowns of every block.
    pub(super) sizes: Vec<usize>,
    /// How many of a block's last unknowns are coupled to the next block.
    pub(super) coupled: usize,
    /// Diagonal blocks, row by row.
    pub(super) diagonal: Vec<Vec<f64>>,
    /// Of block k, its coupled rows by the columns of block k + 1.
    pub(super) coupling: Vec<Vec<f64>>,
}

/// The numbers of negative, zero and positive eigenvalues.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Inertia {
    /// Negative eigenvalues.
    pub negative: usize,
    /// Eigenvalues too small to trust their sign: the end is conjugate to the start up to 1e-10 of an interval and
    /// rounding.
    pub zero: usize,
    /// Positive eigenvalues.
    pub positive: usize,
}

/// What a solution does with negative pivots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Signs {
    /// Divides by them: Newton's step to a stationary point.
    Kept,
    /// Divides by their magnitudes, (L |D| Lᵀ)⁻¹ b: a descent direction.
    Positive,
}

/// The eliminated block, with the delayed unknowns of the block before it in front.
#[derive(Debug)]
struct Front {
    /// Unknowns delayed from the block before.
    delayed: usize,
    /// All unknowns.
    size: usize,
    pivots: Pivots,
    /// F⁻¹ C for Cholesky's factors; qᵢᵀ C / λᵢ of the eliminated directions otherwise. Row by row.
    reach: Vec<f64>,
}

#[derive(Debug)]
enum Pivots {
    /// F = L D Lᵀ, D on the diagonal.
    Cholesky(Vec<f64>),
    /// F = Q Λ Qᵀ with eigenvectors in the columns of Q; the first `eliminated` of them are pivots.
    Eigen { vectors: Vec<f64>, values: Vec<f64>, eliminated: usize },
}

/// The factors of a [`BlockTridiagonal`].
#[derive(Debug)]
pub(super) struct Factors {
    fronts: Vec<Front>,
    sizes: Vec<usize>,
    scales: Vec<f64>,
    pub(super) inertia: Inertia,
    /// For every negative pivot, the block in which it was eliminated.
    pub(super) negative_in: Vec<usize>,
    /// Pivots with magnitudes up to this are zero.
    zero: f64,
}

impl BlockTridiagonal {
    /// A matrix of zeros.
    pub(super) fn zeros(sizes: Vec<usize>, coupled: usize) -> Self {
        let diagonal = sizes.iter().map(|m| vec![0.0; m * m]).collect();
        let coupling = sizes.iter().skip(1).map(|m| vec![0.0; coupled * m]).collect();
        Self { sizes, coupled, diagonal, coupling }
    }

    /// Sets every entry to zero.
    pub(super) fn clear(&mut self) {
        self.diagonal.iter_mut().chain(&mut self.coupling).for_each(|block| block.fill(0.0));
    }

    /// Powers of two near (max_i |aᵢⱼ|)^(−1/2), one per unknown; one for a column of zeros.
    fn scales(&self) -> Vec<f64> {
        let mut largest = vec![0.0f64; self.sizes.iter().sum()];
        let mut start = 0;
        for (k, &m) in self.sizes.iter().enumerate() {
            for (e, a) in self.diagonal[k].iter().enumerate() {
                largest[start + e / m] = largest[start + e / m].max(a.abs());
            }
            if let Some(coupling) = self.coupling.get(k) {
                let (next, rows) = (self.sizes[k + 1], start + m - self.coupled);
                for (e, a) in coupling.iter().enumerate() {
                    let (i, j) = (rows + e / next, start + m + e % next);
                    largest[i] = largest[i].max(a.abs());
                    largest[j] = largest[j].max(a.abs());
                }
            }
            start += m;
        }
        let near = |a: f64| if a > 0.0 && a.is_finite() { (-0.5 * a.log2()).round().exp2() } else { 1.0 };
        largest.into_iter().map(near).collect()
    }

    /// The factors. Entries must be finite.
    pub(super) fn factor(&self) -> Factors {
        let scales = self.scales();
        let zero = CONJUGATE + 1e3 * f64::EPSILON * scales.len() as f64;
        let mut out = Factors {
            fronts: Vec::with_capacity(self.sizes.len()),
            sizes: self.sizes.clone(),
            zero,
            inertia: Inertia::default(),
            negative_in: Vec::new(),
            scales,
        };
        let mut carry = Carry::default();
        let mut start = 0;
        for (k, &m) in self.sizes.iter().enumerate() {
            let scale = &out.scales[start..];
            let front = assemble(&self.diagonal[k], m, &carry, scale);
            let next = self.sizes.get(k + 1).copied().unwrap_or(0);
            let size = carry.delayed + m;
            let mut coupling = vec![0.0; size * next];
            if let Some(c) = self.coupling.get(k) {
                let first = m - self.coupled;
                for (e, a) in c.iter().enumerate() {
                    let (i, j) = (first + e / next, e % next);
                    coupling[(carry.delayed + i) * next + j] = a * scale[i] * scale[m + j];
                }
            }
            carry = out.eliminate(k, carry.delayed, front, size, &coupling, next);
            start += m;
        }
        out
    }
}

/// What an eliminated block leaves to the next one.
#[derive(Debug, Default)]
struct Carry {
    /// How many unknowns are delayed.
    delayed: usize,
    /// Their pivots λ.
    values: Vec<f64>,
    /// Their coupling to the next block, row by row.
    rows: Vec<f64>,
    /// −Cᵀ F⁻¹ C over what was eliminated, an update of the next diagonal block.
    update: Vec<f64>,
}

/// The matrix of a front: delayed unknowns first, then those of the block.
fn assemble(diagonal: &[f64], m: usize, carry: &Carry, scale: &[f64]) -> Vec<f64> {
    let d = carry.delayed;
    let size = d + m;
    let mut front = vec![0.0; size * size];
    for i in 0..d {
        front[i * size + i] = carry.values[i];
        for j in 0..m {
            front[i * size + d + j] = carry.rows[i * m + j];
            front[(d + j) * size + i] = carry.rows[i * m + j];
        }
    }
    for i in 0..m {
        for j in 0..m {
            let update = carry.update.get(i * m + j).copied().unwrap_or(0.0);
            front[(d + i) * size + d + j] = diagonal[i * m + j] * scale[i] * scale[j] + update;
        }
    }
    front
}

impl Factors {
    /// Eliminates a front, and hands over what is left.
    fn eliminate(
        &mut self,
        block: usize,
        delayed: usize,
        front: Vec<f64>,
        size: usize,
        coupling: &[f64],
        next: usize,
    ) -> Carry {
        if let Some((front, carry)) = by_cholesky(delayed, &front, size, (coupling, next), self.zero) {
            self.inertia.positive += size;
            self.fronts.push(front);
            return carry;
        }
        let (front, carry) = by_rotations(delayed, front, size, coupling, next);
        if let Pivots::Eigen { values, eliminated, .. } = &front.pivots {
            for value in &values[..*eliminated] {
                if value.abs() <= self.zero {
                    self.inertia.zero += 1;
                } else if *value > 0.0 {
                    self.inertia.positive += 1;
                } else {
                    self.inertia.negative += 1;
                    self.negative_in.push(block);
                }
            }
        }
        self.fronts.push(front);
        carry
    }

    /// Overwrites `b` by the solution of A x = b. Directions with zero pivots are left out: there x has no component.
    ///
    /// # Panics
    /// If `b` does not have one entry per unknown.
    pub(super) fn solve(&self, b: &mut [f64], signs: Signs) {
        assert_eq!(b.len(), self.scales.len(), "one entry per unknown");
        b.iter_mut().zip(&self.scales).for_each(|(b, s)| *b *= s);
        let mut kept = Vec::with_capacity(self.fronts.len());
        let mut start = 0;
        let mut carried: Vec<f64> = Vec::new();
        for (k, front) in self.fronts.iter().enumerate() {
            let mut right = std::mem::take(&mut carried);
            right.extend_from_slice(&b[start..start + self.sizes[k]]);
            start += self.sizes[k];
            let next = self.sizes.get(k + 1).copied().unwrap_or(0);
            carried = self.forward(front, &mut right, &mut b[start..start + next], signs);
            kept.push(right);
        }
        let mut delayed: Vec<f64> = Vec::new();
        for (k, front) in self.fronts.iter().enumerate().rev() {
            let next = &b[start..start + self.sizes.get(k + 1).copied().unwrap_or(0)];
            let solution = backward(front, &kept[k], &delayed, next);
            start -= self.sizes[k];
            b[start..start + self.sizes[k]].copy_from_slice(&solution[front.delayed..]);
            delayed = solution[..front.delayed].to_vec();
        }
        b.iter_mut().zip(&self.scales).for_each(|(b, s)| *b *= s);
    }

    /// 1/λ with the sign asked for; zero for a zero pivot.
    fn reciprocal(&self, value: f64, signs: Signs) -> f64 {
        match signs {
            _ if value.abs() <= self.zero => 0.0,
            Signs::Kept => value.recip(),
            Signs::Positive => value.abs().recip(),
        }
    }

    /// Forward elimination: `right` becomes the eliminated part divided by its pivots, `next` is updated; the delayed
    /// part is handed over.
    fn forward(&self, front: &Front, right: &mut Vec<f64>, next: &mut [f64], signs: Signs) -> Vec<f64> {
        let size = front.size;
        let columns = next.len();
        match &front.pivots {
            Pivots::Cholesky(factors) => {
                for i in 0..size {
                    for j in 0..columns {
                        next[j] -= front.reach[i * columns + j] * right[i];
                    }
                }
                solve_cholesky(factors, size, right);
                Vec::new()
            }
            Pivots::Eigen { vectors, values, eliminated } => {
                let mut turned: Vec<f64> =
                    (0..size).map(|i| (0..size).map(|r| vectors[r * size + i] * right[r]).sum()).collect();
                let left = turned.split_off(*eliminated);
                for i in 0..*eliminated {
                    for j in 0..columns {
                        next[j] -= front.reach[i * columns + j] * turned[i];
                    }
                    turned[i] *= self.reciprocal(values[i], signs);
                }
                *right = turned;
                left
            }
        }
    }
}

/// Back substitution: the unknowns of a front from those of the next one.
fn backward(front: &Front, kept: &[f64], delayed: &[f64], next: &[f64]) -> Vec<f64> {
    let (size, columns) = (front.size, next.len());
    let reached = |i: usize| -> f64 { (0..columns).map(|j| front.reach[i * columns + j] * next[j]).sum() };
    match &front.pivots {
        Pivots::Cholesky(_) => (0..size).map(|i| kept[i] - reached(i)).collect(),
        Pivots::Eigen { vectors, eliminated, .. } => {
            let mut turned: Vec<f64> = (0..*eliminated).map(|i| kept[i] - reached(i)).collect();
            turned.extend_from_slice(delayed);
            (0..size).map(|r| (0..size).map(|i| vectors[r * size + i] * turned[i]).sum()).collect()
        }
    }
}

/// Elimination by F = L D Lᵀ, if F is safely positive definite and the update of the next block stays bounded.
fn by_cholesky(
    delayed: usize,
    front: &[f64],
    size: usize,
    (coupling, next): (&[f64], usize),
    zero: f64,
) -> Option<(Front, Carry)> {
    let mut factors = front.to_vec();
    for j in 0..size {
        let mut pivot = factors[j * size + j];
        let whole = pivot;
        for k in 0..j {
            pivot -= factors[j * size + k].powi(2) * factors[k * size + k];
        }
        // A pivot near zero is for the eigenvalues to judge: they may be smaller still.
        if pivot.is_nan() || pivot <= 1e2 * zero * whole.abs() {
            return None;
        }
        factors[j * size + j] = pivot;
        for i in j + 1..size {
            let mut sum = factors[i * size + j];
            for k in 0..j {
                sum -= factors[i * size + k] * factors[j * size + k] * factors[k * size + k];
            }
            factors[i * size + j] = sum / pivot;
        }
    }
    let mut reach = vec![0.0; size * next];
    let mut column = vec![0.0; size];
    for j in 0..next {
        (0..size).for_each(|i| column[i] = coupling[i * next + j]);
        solve_cholesky(&factors, size, &mut column);
        (0..size).for_each(|i| reach[i * next + j] = column[i]);
    }
    let update = negative_product(coupling, &reach, size, next);
    let bound = norm(coupling) / THRESHOLD;
    if !update.iter().all(|x| x.abs() <= bound) {
        return None;
    }
    let front = Front { delayed, size, pivots: Pivots::Cholesky(factors), reach };
    Some((front, Carry { update, ..Carry::default() }))
}

/// Elimination by F = Q Λ Qᵀ, small pivots delayed.
fn by_rotations(
    delayed: usize,
    mut front: Vec<f64>,
    size: usize,
    coupling: &[f64],
    next: usize,
) -> (Front, Carry) {
    let vectors = diagonalise(&mut front, size);
    let turned_row = |i: usize| -> Vec<f64> {
        (0..next).map(|j| (0..size).map(|r| vectors[r * size + i] * coupling[r * next + j]).sum()).collect()
    };
    let rows: Vec<Vec<f64>> = (0..size).map(turned_row).collect();
    let value = |i: usize| front[i * size + i];
    let (pivots, late): (Vec<usize>, Vec<usize>) = (0..size)
        .partition(|&i| next == 0 || value(i).abs() >= THRESHOLD * norm(&rows[i]) && value(i) != 0.0);
    let mut reach = Vec::with_capacity(pivots.len() * next);
    let mut straight = Vec::with_capacity(pivots.len() * next);
    for &i in &pivots {
        straight.extend_from_slice(&rows[i]);
        reach.extend(rows[i].iter().map(|c| c / value(i)));
    }
    let carry = Carry {
        delayed: late.len(),
        values: late.iter().map(|&i| value(i)).collect(),
        rows: late.iter().flat_map(|&i| rows[i].clone()).collect(),
        update: negative_product(&straight, &reach, pivots.len(), next),
    };
    let order: Vec<usize> = pivots.iter().chain(&late).copied().collect();
    let values = order.iter().map(|&i| value(i)).collect();
    let sorted =
        (0..size).flat_map(|r| order.iter().map(move |&i| (r, i))).map(|(r, i)| vectors[r * size + i]);
    let pivots = Pivots::Eigen { vectors: sorted.collect(), values, eliminated: pivots.len() };
    (Front { delayed, size, pivots, reach }, carry)
}

fn solve_cholesky(factors: &[f64], size: usize, b: &mut [f64]) {
    for i in 0..size {
        for k in 0..i {
            b[i] -= factors[i * size + k] * b[k];
        }
    }
    for i in (0..size).rev() {
        b[i] /= factors[i * size + i];
        for k in i + 1..size {
            b[i] -= factors[k * size + i] * b[k];
        }
    }
}

/// −Aᵀ B of two matrices with `rows` rows and `columns` columns, made symmetric.
fn negative_product(a: &[f64], b: &[f64], rows: usize, columns: usize) -> Vec<f64> {
    let mut out = vec![0.0; columns * columns];
    for r in 0..rows {
        for i in 0..columns {
            for j in 0..columns {
                out[i * columns + j] -=
                    0.5 * (a[r * columns + i] * b[r * columns + j] + b[r * columns + i] * a[r * columns + j]);
            }
        }
    }
    out
}

fn norm(a: &[f64]) -> f64 {
    a.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Diagonalises a symmetric matrix in place by Jacobi's cyclic rotations; answers with the eigenvectors as columns.
///
/// # Reference
/// Golub and Van Loan, *Matrix Computations*, 4th ed. (2013), algorithms 8.5.1 and 8.5.3.
fn diagonalise(a: &mut [f64], n: usize) -> Vec<f64> {
    let mut vectors = vec![0.0; n * n];
    (0..n).for_each(|i| vectors[i * n + i] = 1.0);
    // Convergence is quadratic in the end: six to ten sweeps do for the largest matrices; NaN ends by the bound.
    for _ in 0..30 {
        let mut turned = false;
        for p in 0..n {
            for q in p + 1..n {
                let off = a[p * n + q];
                let floor = f64::EPSILON * 1e-2 * (a[p * n + p].abs() + a[q * n + q].abs());
                if off.is_nan() || off.abs() <= floor {
                    continue;
                }
                turned = true;
                let tau = (a[q * n + q] - a[p * n + p]) / (2.0 * off);
                let t = 1f64.copysign(tau) / (tau.abs() + tau.hypot(1.0));
                let c = 1.0 / t.hypot(1.0);
                rotate(a, &mut vectors, n, (p, q), (c, t * c));
            }
        }
        if !turned {
            break;
        }
    }
    vectors
}

/// A ← Jᵀ A J and V ← V J for the rotation with cosine c and sine s in the plane (p, q).
fn rotate(a: &mut [f64], vectors: &mut [f64], n: usize, (p, q): (usize, usize), (c, s): (f64, f64)) {
    for r in 0..n {
        let (x, y) = (a[r * n + p], a[r * n + q]);
        (a[r * n + p], a[r * n + q]) = (c * x - s * y, s * x + c * y);
        let (x, y) = (vectors[r * n + p], vectors[r * n + q]);
        (vectors[r * n + p], vectors[r * n + q]) = (c * x - s * y, s * x + c * y);
    }
    for r in 0..n {
        let (x, y) = (a[p * n + r], a[q * n + r]);
        (a[p * n + r], a[q * n + r]) = (c * x - s * y, s * x + c * y);
    }
    (a[p * n + q], a[q * n + p]) = (0.0, 0.0);
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};

    /// Entries in [−1, 1) by a linear congruence; the first blocks zero, every third seed nearer to positive
    /// definite.
    fn random(sizes: &[usize], coupled: usize, seed: u64, zero_blocks: usize) -> BlockTridiagonal {
        let mut state = seed;
        let mut next = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        };
        let mut out = BlockTridiagonal::zeros(sizes.to_vec(), coupled);
        for (k, &m) in sizes.iter().enumerate() {
            for (i, j) in (0..m).flat_map(|i| (0..=i).map(move |j| (i, j))) {
                let shift = if i == j && seed.is_multiple_of(3) { 1.5 } else { 0.0 };
                let entry = if k < zero_blocks { 0.0 } else { next() + shift };
                out.diagonal[k][i * m + j] = entry;
                out.diagonal[k][j * m + i] = entry;
            }
        }
        out.coupling.iter_mut().flatten().for_each(|c| *c = next());
        out
    }

    fn dense(a: &BlockTridiagonal) -> DMatrix<f64> {
        let n: usize = a.sizes.iter().sum();
        let mut out = DMatrix::zeros(n, n);
        let mut start = 0;
        for (k, &m) in a.sizes.iter().enumerate() {
            (0..m * m).for_each(|e| out[(start + e / m, start + e % m)] = a.diagonal[k][e]);
            if let Some(c) = a.coupling.get(k) {
                let next = a.sizes[k + 1];
                for e in 0..c.len() {
                    let (i, j) = (start + m - a.coupled + e / next, start + m + e % next);
                    (out[(i, j)], out[(j, i)]) = (c[e], c[e]);
                }
            }
            start += m;
        }
        out
    }

    #[test]
    fn indefinite_matrices_are_solved_and_counted_as_dense_ones_are() {
        for seed in 1..=60 {
            for (sizes, coupled) in
                [(vec![1; 9], 1), (vec![2; 6], 2), (vec![6, 6, 6, 6, 4], 2), (vec![3; 4], 3)]
            {
                for zero_blocks in [0, 1, sizes.len() - 1] {
                    // Blocks of zeros with fewer couplings than unknowns make the whole singular.
                    if zero_blocks > 0 && sizes[0] > coupled {
                        continue;
                    }
                    let a = random(&sizes, coupled, seed, zero_blocks);
                    let whole = dense(&a);
                    let values = whole.symmetric_eigenvalues();
                    let condition =
                        values.amax() / values.iter().map(|x| x.abs()).fold(f64::INFINITY, f64::min);
                    if condition > 1e6 {
                        continue;
                    }
                    let factors = a.factor();
                    let negative = values.iter().filter(|x| **x < 0.0).count();
                    let positive = values.len() - negative;
                    assert_eq!(
                        factors.inertia,
                        Inertia { negative, zero: 0, positive },
                        "{sizes:?}, seed {seed}"
                    );
                    let exact = DVector::from_fn(values.len(), |i, _| 1.0 + i as f64);
                    let mut x: Vec<f64> = (&whole * &exact).iter().copied().collect();
                    factors.solve(&mut x, Signs::Kept);
                    let error = x.iter().zip(exact.iter()).map(|(x, e)| (x - e).abs()).fold(0.0, f64::max);
                    assert!(
                        error < 1e-12 * condition,
                        "{sizes:?}, seed {seed}: {error:e}, condition {condition:e}"
                    );
                    let right: Vec<f64> = exact.iter().copied().collect();
                    let mut down = right.clone();
                    factors.solve(&mut down, Signs::Positive);
                    let slope: f64 = right.iter().zip(&down).map(|(b, x)| b * x).sum();
                    assert!(slope > 0.0, "(L |D| Lᵀ)⁻¹ is positive definite");
                }
            }
        }
    }

    #[test]
    fn nan_ends_and_zero_is_counted() {
        let mut a = random(&[2, 2, 2], 2, 7, 0);
        a.diagonal[1][0] = f64::NAN;
        let mut x = vec![1.0; 6];
        a.factor().solve(&mut x, Signs::Kept);
        assert!(x.iter().any(|x| !x.is_finite()));
        let nothing = BlockTridiagonal::zeros(vec![2, 2], 2);
        assert_eq!(nothing.factor().inertia, Inertia { negative: 0, zero: 4, positive: 0 });
        let mut x = vec![1.0; 4];
        nothing.factor().solve(&mut x, Signs::Kept);
        assert_eq!(x, [0.0; 4]);
    }
}
