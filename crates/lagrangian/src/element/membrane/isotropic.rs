//! Laws in the two invariants of the surface strain.

use super::{Mat3x2, Principal, PrincipalStiffness, SheetLaw, SheetStiffness};
use mechanics_core::projection::Projection;

/// The strain of a surface, from the Green strain E = ½ (C − I), C = FᵀF (2×2), as isotropic laws read it. The parts
/// repeat each other in exact arithmetic; each is free of the cancellation that its relation to the others has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneStrain {
    /// tr E; I = tr C = 2 + 2 tr E.
    pub trace: f64,
    /// det E; det C = 1 + 2 tr E + 4 det E.
    pub determinant: f64,
    /// D = det C, the square of the area's ratio.
    pub area_ratio_squared: f64,
}

/// D over (tr C)² below which D is rounding.
const NO_AREA: f64 = 1e-30;

impl PlaneStrain {
    /// The strain of `f`.
    pub fn of(f: &Mat3x2) -> Self {
        let (a, b) = (f.column(0), f.column(1));
        let (e11, e22) = (0.5 * (a.norm_squared() - 1.0), 0.5 * (b.norm_squared() - 1.0));
        let e12 = 0.5 * a.dot(&b);
        Self {
            trace: e11 + e22,
            determinant: e11 * e22 - e12 * e12,
            area_ratio_squared: a.cross(&b).norm_squared(),
        }
    }

    /// ln of the area's ratio, ½ ln D, accurate for small strain and for collapsing triangles; −∞ for a triangle whose area
    /// is zero to rounding (√D ≤ 10⁻¹⁵ tr C).
    pub fn log_area_ratio(&self) -> f64 {
        let trace = 2.0 + 2.0 * self.trace;
        if self.area_ratio_squared <= NO_AREA * trace * trace {
            return f64::NEG_INFINITY;
        }
        let change = 2.0 * self.trace + 4.0 * self.determinant;
        0.5 * if change.abs() < 0.5 { change.ln_1p() } else { self.area_ratio_squared.ln() }
    }
}

/// Derivatives of W(I, D) by I = tr C and D = det C \[Pa\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InvariantDerivatives {
    /// W_I, W_D.
    pub first: [f64; 2],
    /// W_II, W_ID, W_DD.
    pub second: [f64; 3],
}

/// An isotropic sheet law W(I, D), I = tr C, D = det C, C = FᵀF (2×2).
///
/// Every such law is a [`SheetLaw`]. As ∂I/∂F = 2F and ∂D/∂F = 2F adj C,
///
/// - P = 2 F (W_I 1 + W_D adj C),  adj C = [[C₂₂, −C₁₂], [−C₁₂, C₁₁]].
///
/// In principal stretches I = σ₁² + σ₂² and D = σ₁²σ₂², hence W,₁ = 2σ₁ (W_I + σ₂² W_D) and likewise W,₂, and the
/// eigenvalues of the stiffness (see `principal.rs` beside this file) have no quotients left:
///
/// - W,₁₁ = 2 (W_I + σ₂² W_D) + 4σ₁² (W_II + 2σ₂² W_ID + σ₂⁴ W_DD),
/// - W,₁₂ = 4σ₁σ₂ (W_D + W_II + (σ₁² + σ₂²) W_ID + D W_DD),
/// - shear 2 (W_I − σ₁σ₂ W_D), rotation 2 (W_I + σ₁σ₂ W_D),
/// - tilting 2 (W_I + σ₂² W_D) and 2 (W_I + σ₁² W_D).
pub trait IsotropicSheet: Send + Sync {
    /// W [J/m³]; `+∞` outside the law's domain.
    fn energy(&self, strain: &PlaneStrain) -> f64;

    /// Its derivatives.
    fn derivatives(&self, strain: &PlaneStrain) -> InvariantDerivatives;
}

impl<L: IsotropicSheet> SheetLaw for L {
    fn energy_density(&self, f: &Mat3x2) -> f64 {
        self.energy(&PlaneStrain::of(f))
    }

    fn first_piola(&self, f: &Mat3x2) -> Mat3x2 {
        let [by_trace, by_determinant] = self.derivatives(&PlaneStrain::of(f)).first;
        let (a, b) = (f.column(0), f.column(1));
        let (c11, c12, c22) = (a.norm_squared(), a.dot(&b), b.norm_squared());
        let off = -by_determinant * c12;
        let stress = [
            a * (by_trace + by_determinant * c22) + b * off,
            b * (by_trace + by_determinant * c11) + a * off,
        ];
        Mat3x2::from_columns(&stress) * 2.0
    }

    fn stiffness(&self, f: &Mat3x2, projection: Projection) -> SheetStiffness {
        let InvariantDerivatives { first: [w_i, w_d], second: [w_ii, w_id, w_dd] } =
            self.derivatives(&PlaneStrain::of(f));
        let frame = Principal::of(f);
        let [s1, s2] = frame.stretches;
        let (p, q) = (s1 * s1, s2 * s2);
        let tilting = [2.0 * (w_i + q * w_d), 2.0 * (w_i + p * w_d)];
        let second = |other: f64| w_ii + 2.0 * other * w_id + other * other * w_dd;
        let values = PrincipalStiffness {
            scaling: [
                tilting[0] + 4.0 * p * second(q),
                4.0 * s1 * s2 * (w_d + w_ii + (p + q) * w_id + p * q * w_dd),
                tilting[1] + 4.0 * q * second(p),
            ],
            shear: 2.0 * (w_i - s1 * s2 * w_d),
            rotation: 2.0 * (w_i + s1 * s2 * w_d),
            tilting,
        };
        values.assembled(&frame, projection)
    }
}
