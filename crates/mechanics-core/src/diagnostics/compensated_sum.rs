//! Summation that carries its rounding errors along.

/// A sum whose error does not grow with the number of terms.
///
/// Beside the running sum s it keeps the sum c of what every addition rounded away: for t = fl(s + x) the loss is
/// exactly (s − t) + x if |s| ≥ |x|, else (x − t) + s. The result s + c has an error of at most about
/// ε|Σ xᵢ| + n²ε² Σ|xᵢ| (ε = 1.1e-16) where plain summation has nε Σ|xᵢ|. An infinite or NaN term gives an infinite
/// or NaN sum, as plain summation does.
///
/// # Reference
/// Neumaier 1974, *Rundungsfehleranalyse einiger Verfahren zur Summation endlicher Summen*, algorithm IV.
///
/// ```
/// use mechanics_core::diagnostics::CompensatedSum;
///
/// let mut sum = CompensatedSum::new();
/// for term in [1.0, 1e100, 1.0, -1e100] {
///     sum.add(term);
/// }
/// assert_eq!(sum.value(), 2.0);
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct CompensatedSum {
    sum: f64,
    lost: f64,
}

impl CompensatedSum {
    /// The sum of nothing: zero.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds one term.
    #[inline]
    pub fn add(&mut self, term: f64) {
        let total = self.sum + term;
        self.lost +=
            if self.sum.abs() >= term.abs() { (self.sum - total) + term } else { (term - total) + self.sum };
        self.sum = total;
    }

    /// Adds another sum, with what it carries.
    #[inline]
    pub fn add_sum(&mut self, other: &Self) {
        self.add(other.sum);
        self.lost += other.lost;
    }

    /// The sum of the terms so far.
    #[inline]
    pub fn value(&self) -> f64 {
        // Once the sum is infinite, what was lost is infinity minus infinity and means nothing.
        if self.sum.is_finite() { self.sum + self.lost } else { self.sum }
    }
}
