//! Lamé's parameters and their conversions.

use super::LawError;

/// Lamé's two parameters λ and μ [Pa] of an isotropic elastic material, with μ > 0 and bulk modulus
/// K = λ + ⅔μ > 0 (so that the small-strain energy is positive definite).
///
/// With Young's modulus E and Poisson's ratio ν:
///
/// - μ = E / (2(1 + ν)),  λ = E ν / ((1 + ν)(1 − 2ν)),  K = E / (3(1 − 2ν))
/// - E = μ(3λ + 2μ)/(λ + μ),  ν = λ / (2(λ + μ))
///
/// # Reference
/// Any textbook of elasticity, for instance Bower, Applied Mechanics of Solids (2009), table 3.1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lame {
    lambda: f64,
    mu: f64,
}

impl Lame {
    /// From Young's modulus E [Pa] and Poisson's ratio ν.
    ///
    /// # Errors
    /// [`LawError::YoungModulus`] unless 0 < E < ∞; [`LawError::PoissonRatio`] unless −1 < ν < ½ and λ is finite.
    pub fn from_young_poisson(young_modulus: f64, poisson_ratio: f64) -> Result<Self, LawError> {
        if !(young_modulus > 0.0 && young_modulus.is_finite()) {
            return Err(LawError::YoungModulus { value: young_modulus });
        }
        if !(poisson_ratio > -1.0 && poisson_ratio < 0.5) {
            return Err(LawError::PoissonRatio { value: poisson_ratio });
        }
        let mu = young_modulus / (2.0 * (1.0 + poisson_ratio));
        let lambda = young_modulus / (1.0 + poisson_ratio) * (poisson_ratio / (1.0 - 2.0 * poisson_ratio));
        if mu.is_finite() && lambda.is_finite() {
            Self::new(lambda, mu)
        } else {
            Err(LawError::PoissonRatio { value: poisson_ratio })
        }
    }

    /// From λ and μ themselves [Pa].
    ///
    /// # Errors
    /// [`LawError::ShearModulus`] unless 0 < μ < ∞; [`LawError::BulkModulus`] unless 0 < λ + ⅔μ < ∞.
    pub fn new(lambda: f64, mu: f64) -> Result<Self, LawError> {
        if !(mu > 0.0 && mu.is_finite()) {
            return Err(LawError::ShearModulus { value: mu });
        }
        let bulk = lambda + mu * (2.0 / 3.0);
        if !(bulk > 0.0 && bulk.is_finite()) {
            return Err(LawError::BulkModulus { value: bulk });
        }
        Ok(Self { lambda, mu })
    }

    /// From the bulk modulus K and the shear modulus μ [Pa].
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn from_bulk_shear(bulk_modulus: f64, shear_modulus: f64) -> Result<Self, LawError> {
        if !(bulk_modulus > 0.0 && bulk_modulus.is_finite()) {
            return Err(LawError::BulkModulus { value: bulk_modulus });
        }
        Self::new(bulk_modulus - shear_modulus * (2.0 / 3.0), shear_modulus)
    }

    /// Lamé's first parameter λ [Pa]; may be negative.
    pub fn lambda(&self) -> f64 {
        self.lambda
    }

    /// Lamé's second parameter, the shear modulus μ [Pa].
    pub fn mu(&self) -> f64 {
        self.mu
    }

    /// K = λ + ⅔μ [Pa].
    pub fn bulk_modulus(&self) -> f64 {
        self.lambda + self.mu * (2.0 / 3.0)
    }

    /// E = μ(3λ + 2μ)/(λ + μ) [Pa].
    pub fn young_modulus(&self) -> f64 {
        self.mu * ((3.0 * self.lambda + 2.0 * self.mu) / (self.lambda + self.mu))
    }

    /// ν = λ/(2(λ + μ)).
    pub fn poisson_ratio(&self) -> f64 {
        0.5 * self.lambda / (self.lambda + self.mu)
    }

    /// Speed of pressure waves √((λ + 2μ)/ρ) [m/s] at rest, for density ρ [kg/m³].
    pub fn pressure_wave_speed(&self, density: f64) -> f64 {
        ((self.lambda + 2.0 * self.mu) / density).sqrt()
    }

    /// Speed of shear waves √(μ/ρ) [m/s] at rest, for density ρ [kg/m³].
    pub fn shear_wave_speed(&self, density: f64) -> f64 {
        (self.mu / density).sqrt()
    }
}
