//! The neo-Hookean sheet.

use super::{InvariantDerivatives, IsotropicSheet, PlaneStrain};
use crate::element::thin_error::ThinError;
use mechanics_core::law::Lame;

/// The neo-Hookean law ψ = ½μ (tr C₃ − 3) − μ ln J + ½λ ln² J (C₃ and J in three dimensions) in plane stress.
///
/// The sheet is free to change its thickness: with the thickness stretch ς = √y, C₃ has the trace I + y and
/// J = √(D y). Plane stress is ∂ψ/∂y = 0:
///
/// - y − 1 + r (½ ln D + ½ ln y) = 0,  r = λ/μ,
///
/// and W(I, D) = ψ at that y. Because ψ is stationary there, W_D = ∂ψ/∂D = (−μ + λ ln J)/(2D), which by the equation
/// above is −μ y/(2D). Differentiating the equation, ∂y/∂D = −r y/((2y + r) D). So
///
/// - W_I = ½μ,  W_D = −μ y/(2D),  W_DD = μ y/(2D²) (1 + r/(2y + r)),  W_II = W_ID = 0.
///
/// For ν ≥ 0 a solution y exists for every D > 0 and is found by Newton's method from y = 1: on the equation in y if it
/// is larger than one (concave there, so that iterates rise to the root), in ½ ln y if it is smaller (convex, so that
/// they fall). For ν < 0 the three-dimensional law itself has no minimum in y below
/// ln √D = μ/λ + ½ − ½ ln(−λ/2μ); the energy is `+∞` there. It is `+∞` also for a triangle without area.
///
/// # Reference
/// Bonet and Wood (2008), section 6.4.3 (the law), section 6.6.2 (plane stress, for the incompressible case).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NeoHookeanSheet {
    lame: Lame,
}

impl NeoHookeanSheet {
    /// From Young's modulus \[Pa\] and Poisson's ratio.
    ///
    /// # Errors
    /// Young's modulus not positive; Poisson's ratio not between −1 and ½.
    pub fn new(young_modulus: f64, poisson_ratio: f64) -> Result<Self, ThinError> {
        Ok(Self { lame: Lame::from_young_poisson(young_modulus, poisson_ratio)? })
    }

    /// The thickness stretch √y of a strained sheet; `None` where there is no equilibrium.
    pub fn thickness_stretch(&self, strain: &PlaneStrain) -> Option<f64> {
        self.log_thickness(strain.log_area_ratio()).map(f64::exp)
    }

    /// ½ ln y for a given ln √D: from it both y − 1 and y are had without cancellation.
    fn log_thickness(&self, log_area: f64) -> Option<f64> {
        let ratio = self.lame.lambda() / self.lame.mu();
        if !log_area.is_finite() {
            return None;
        }
        if ratio > 0.0 && log_area > 0.0 {
            fall_to_root(ratio, log_area)
        } else {
            rise_to_root(ratio, log_area)
        }
    }
}

/// Iterations allowed; fewer than ten are needed for strains of ordinary size.
const MAX_ITERATIONS: usize = 100;

/// Whether a correction is what rounding makes of sums whose parts have the given size.
fn is_rounding(step: f64, parts: f64, slope: f64) -> bool {
    step.abs() * slope <= 4.0 * f64::EPSILON * parts
}

/// ½ ln(1 + z) at the root of z + r (a + ½ ln(1 + z)), a = ln √D, by Newton's method.
fn rise_to_root(r: f64, a: f64) -> Option<f64> {
    let mut z = 0.0_f64;
    for _ in 0..MAX_ITERATIONS {
        let slope = 1.0 + 0.5 * r / (1.0 + z);
        if slope.is_nan() || slope <= 0.0 {
            return None;
        }
        let log = 0.5 * z.ln_1p();
        let step = (z + r * (a + log)) / slope;
        z -= step;
        if z <= -1.0 {
            return None;
        }
        if is_rounding(step, z.abs() + r.abs() * (a.abs() + log.abs()), slope) {
            return Some(0.5 * z.ln_1p());
        }
    }
    None
}

/// The root of e²ˢ − 1 + r (a + s), by Newton's method.
fn fall_to_root(r: f64, a: f64) -> Option<f64> {
    let mut s = 0.0_f64;
    for _ in 0..MAX_ITERATIONS {
        let growth = (2.0 * s).exp_m1();
        let slope = 2.0 * (growth + 1.0) + r;
        let step = (growth + r * (a + s)) / slope;
        s -= step;
        if is_rounding(step, growth.abs() + r * (a.abs() + s.abs()), slope) {
            return Some(s);
        }
    }
    None
}

impl IsotropicSheet for NeoHookeanSheet {
    fn energy(&self, strain: &PlaneStrain) -> f64 {
        let log_area = strain.log_area_ratio();
        let Some(s) = self.log_thickness(log_area) else { return f64::INFINITY };
        let log_volume = log_area + s;
        self.lame.mu() * (strain.trace + 0.5 * (2.0 * s).exp_m1() - log_volume)
            + 0.5 * self.lame.lambda() * log_volume * log_volume
    }

    fn derivatives(&self, strain: &PlaneStrain) -> InvariantDerivatives {
        let mu = self.lame.mu();
        let y = self.log_thickness(strain.log_area_ratio()).map_or(f64::NAN, |s| (2.0 * s).exp());
        let ratio = self.lame.lambda() / mu;
        let d = strain.area_ratio_squared;
        let by_determinant = -0.5 * mu * y / d;
        let curved = -by_determinant / d * (1.0 + ratio / (2.0 * y + ratio));
        InvariantDerivatives { first: [0.5 * mu, by_determinant], second: [0.0, 0.0, curved] }
    }
}
