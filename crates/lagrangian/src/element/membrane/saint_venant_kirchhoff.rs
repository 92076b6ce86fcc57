//! The St. Venant–Kirchhoff sheet.

use super::{InvariantDerivatives, IsotropicSheet, PlaneStrain};
use crate::element::thin_error::ThinError;
use mechanics_core::law::Lame;

/// The St. Venant–Kirchhoff law in plane stress: Hooke's law between the second Piola stress and the Green strain E.
///
/// In three dimensions ψ = μ E:E + ½λ (tr E)². Plane stress, λ (tr E + E₃₃) + 2μ E₃₃ = 0 with tr E now over the sheet
/// alone, gives E₃₃ = −λ/(λ + 2μ) tr E, and with it
///
/// - W = μ E:E + ½λ' (tr E)²,  λ' = 2λμ/(λ + 2μ) = E_Y ν/(1 − ν²),
///
/// E_Y Young's modulus. As E:E = (tr E)² − 2 det E and I = 2 + 2 tr E, D = 1 + 2 tr E + 4 det E:
///
/// - W_I = ½μ (1 + 2 tr E) + ½λ' tr E,  W_D = −½μ,  W_II = ½μ + ¼λ',  W_ID = W_DD = 0.
///
/// A polynomial in F: defined everywhere, even where the triangle has no area. As in three dimensions it softens under
/// compression and lets a triangle collapse at a finite force; the condensed strain E₃₃ > −½ only while
/// tr E < (λ + 2μ)/2λ, so it is a law for small strains at any rotation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SaintVenantKirchhoffSheet {
    mu: f64,
    lambda: f64,
}

impl SaintVenantKirchhoffSheet {
    /// From Young's modulus \[Pa\] and Poisson's ratio.
    ///
    /// # Errors
    /// Young's modulus not positive; Poisson's ratio not between −1 and ½.
    pub fn new(young_modulus: f64, poisson_ratio: f64) -> Result<Self, ThinError> {
        let lame = Lame::from_young_poisson(young_modulus, poisson_ratio)?;
        let lambda = young_modulus * poisson_ratio / (1.0 - poisson_ratio * poisson_ratio);
        Ok(Self { mu: lame.mu(), lambda })
    }
}

impl IsotropicSheet for SaintVenantKirchhoffSheet {
    fn energy(&self, strain: &PlaneStrain) -> f64 {
        let &PlaneStrain { trace, determinant, .. } = strain;
        let square = trace * trace;
        self.mu * (square - 2.0 * determinant) + 0.5 * self.lambda * square
    }

    fn derivatives(&self, strain: &PlaneStrain) -> InvariantDerivatives {
        let by_trace = 0.5 * (self.mu * (1.0 + 2.0 * strain.trace) + self.lambda * strain.trace);
        let curved = 0.5 * self.mu + 0.25 * self.lambda;
        InvariantDerivatives { first: [by_trace, -0.5 * self.mu], second: [curved, 0.0, 0.0] }
    }
}
