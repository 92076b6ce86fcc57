//! The orthotropic sheet: warp and weft.

use super::{Mat3x2, SheetLaw, SheetStiffness};
use crate::element::thin_error::{ThinError, positive};
use mechanics_core::projection::{Projection, project_symmetric};
use nalgebra::Matrix2;

/// A sheet with different stiffness along two perpendicular fibre directions, t₁ and t₂ of the rest triangle
/// ([`Membranes::with_fibre`](super::Membranes::with_fibre)): W = ½ E:ℂ:E in the Green strain E, that is
///
/// - S₁₁ = c₁₁ E₁₁ + c₁₂ E₂₂,  S₂₂ = c₁₂ E₁₁ + c₂₂ E₂₂,  S₁₂ = 2 G E₁₂,
/// - c₁₁ = E₁/(1 − ν₁₂ν₂₁),  c₂₂ = E₂/(1 − ν₁₂ν₂₁),  c₁₂ = ν₁₂ E₂/(1 − ν₁₂ν₂₁),  ν₂₁ = ν₁₂ E₂/E₁.
///
/// It is positive definite when E₁, E₂, G > 0 and ν₁₂² < E₁/E₂. With E₁ = E₂, G = E/2(1 + ν) it is
/// [`SaintVenantKirchhoffSheet`](super::SaintVenantKirchhoffSheet).
///
/// P = F S and dP = dF S + F (ℂ:sym(Fᵀ dF)). The projection is by the eigenvalues of the 6×6 matrix.
///
/// # Reference
/// R. M. Jones, *Mechanics of Composite Materials*, 2nd ed., 1999, section 2.5 (plane-stress stiffnesses).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrthotropicSheet {
    c11: f64,
    c22: f64,
    c12: f64,
    shear: f64,
}

impl OrthotropicSheet {
    /// From E₁, E₂ \[Pa\], ν₁₂ (contraction along t₂ when pulled along t₁) and G \[Pa\].
    ///
    /// # Errors
    /// A modulus that is not positive; ν₁₂² not below E₁/E₂.
    pub fn new(young_moduli: [f64; 2], poisson_ratio: f64, shear_modulus: f64) -> Result<Self, ThinError> {
        let one = positive("Young's modulus along the first fibre", young_moduli[0])?;
        let two = positive("Young's modulus along the second fibre", young_moduli[1])?;
        let shear = positive("the shear modulus", shear_modulus)?;
        let factor = 1.0 - poisson_ratio * poisson_ratio * two / one;
        if !(factor > 0.0 && factor.is_finite()) {
            return Err(ThinError::Parameter {
                parameter: "Poisson's ratio of the orthotropic sheet",
                value: poisson_ratio,
                expected: "smaller in magnitude than √(E₁/E₂)",
            });
        }
        Ok(Self { c11: one / factor, c22: two / factor, c12: poisson_ratio * two / factor, shear })
    }

    /// ℂ:E.
    fn stress(&self, e: &Matrix2<f64>) -> Matrix2<f64> {
        let shear = self.shear * (e[(0, 1)] + e[(1, 0)]);
        let [one, two] = [e[(0, 0)], e[(1, 1)]];
        Matrix2::new(self.c11 * one + self.c12 * two, shear, shear, self.c12 * one + self.c22 * two)
    }

    fn green_strain(f: &Mat3x2) -> Matrix2<f64> {
        (f.transpose() * f - Matrix2::identity()) * 0.5
    }
}

impl SheetLaw for OrthotropicSheet {
    fn energy_density(&self, f: &Mat3x2) -> f64 {
        let strain = Self::green_strain(f);
        0.5 * self.stress(&strain).dot(&strain)
    }

    fn first_piola(&self, f: &Mat3x2) -> Mat3x2 {
        f * self.stress(&Self::green_strain(f))
    }

    fn stiffness(&self, f: &Mat3x2, projection: Projection) -> SheetStiffness {
        let stress = self.stress(&Self::green_strain(f));
        let mut k = SheetStiffness::zeros();
        for j in 0..2 {
            for i in 0..3 {
                let mut change = Mat3x2::zeros();
                change[(i, j)] = 1.0;
                let stretched = f.transpose() * change;
                let strain = (stretched + stretched.transpose()) * 0.5;
                let column = change * stress + f * self.stress(&strain);
                k.column_mut(3 * j + i).copy_from_slice(column.as_slice());
            }
        }
        project_symmetric(&k, projection)
    }
}
