//! Making a Hessian positive semi-definite, so that Newton's direction descends.

/// What to do with the negative eigenvalues of a local Hessian.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Projection {
    /// Nothing: the true Hessian.
    None,
    /// Negative eigenvalues become zero (Teran et al. 2005).
    #[default]
    Clamp,
    /// Negative eigenvalues change sign (Chen et al. 2024): better near incompressibility.
    Absolute,
}

impl Projection {
    /// The eigenvalue to use instead of `eigenvalue`.
    #[inline(always)]
    pub fn apply(self, eigenvalue: f64) -> f64 {
        match self {
            Self::None => eigenvalue,
            Self::Clamp => eigenvalue.max(0.0),
            Self::Absolute => eigenvalue.abs(),
        }
    }
}
