//! Clay, snow and other porous solids that fracture, with a deviatoric flow.

use super::Compaction;
use super::modified_cam_clay::{Ellipse, require_ellipse};
use crate::error::{Parameter, not_negative, positive};
use crate::logarithmic::{Flow, LogarithmicStrain};
use crate::{Curvature, PointLaw, PointLawError, Stress, TotalDeformation};
use mechanics_core::law::{self, Hyperelastic, Lame};
use mechanics_core::projection::Projection;
use mechanics_core::scalar::{Mask, Scalar};
use mechanics_core::tensor::{Mat3, Matrix3};

/// The smallest p_c/K: a material that has lost all strength keeps this much.
const SMALLEST_STRENGTH: f64 = 1e-5;

/// Cam-Clay with a non-associative, deviatoric flow.
///
/// With p = −Kt, q = √6 μ‖e‖ and the ellipse of [`ModifiedCamClay`](super::ModifiedCamClay),
///
/// y = (1 + 2β) q² + M²(p + βp_c)(p − p_c) ≤ 0,  p_c = K (10⁻⁵ + sinh(ξ max(−α, 0))),
///
/// α = ln Jᵖ with its initial value α₀ < 0, positive when the material has been torn apart. With the p_c of the begin of the step a trial outside goes
///
/// 1. to the tip p = p_c, q = 0 if p > p_c, and α falls by the volume given up, Δα = (p′ − p_trial)/K: compaction hardens;
/// 2. to the tip p = −βp_c, q = 0 if p < −βp_c, and α grows likewise: tearing softens;
/// 3. otherwise straight down in q at the same p. No elastic volume is given up, yet α changes as if the return were towards the centre
///    p_m = (1 − β)p_c/2 of the ellipse: Δα = (pₓ − p_trial)/K with (pₓ, ·) the point where the segment from (p_m, 0) to the trial leaves the
///    ellipse. So shear compacts and hardens on the compressive side, dilates and softens on the other.
///
/// p_c is held during the step, as published; the return lands on the surface that the step began with.
///
/// Domain: det Fᵉ > 0.
///
/// # Reference
/// Wolper, Fang, Li, Lu, Gao, Jiang, CD-MPM: continuum damage material point methods for dynamic fracture animation (2019), with
/// its supplement (there on the left Cauchy–Green tensor, here on the logarithmic strain).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NonAssociativeCamClay {
    lame: Lame,
    ellipse: Ellipse,
    hardening: f64,
    initial: f64,
}

impl NonAssociativeCamClay {
    /// From the elasticity, the slope M of the critical state line, the tensile ratio β, the hardening ξ and the initial compaction −α₀.
    ///
    /// # Errors
    /// [`PointLawError::OutOfRange`] unless 0 < M, 0 ≤ β ≤ 1, 0 < ξ, 0 ≤ −α₀, all finite.
    pub fn new(
        lame: Lame,
        slope: f64,
        tensile_ratio: f64,
        hardening: f64,
        initial_compaction: f64,
    ) -> Result<Self, PointLawError> {
        let ellipse = require_ellipse(slope, tensile_ratio)?;
        positive(Parameter::ConsolidationRate, hardening)?;
        not_negative(Parameter::InitialCompaction, initial_compaction)?;
        Ok(Self { lame, ellipse, hardening, initial: initial_compaction })
    }

    /// p_c/K for a plastic change of volume since the start.
    #[inline(always)]
    pub(crate) fn strength<S: Scalar>(&self, history: &Compaction<S>) -> S {
        let compaction = (-history.log_volume).offset(self.initial).max(S::constant(0.0));
        compaction.scale(self.hardening).sinh().offset(SMALLEST_STRENGTH)
    }

    /// p_c \[Pa\], the pressure under which the material is crushed now.
    pub fn preconsolidation(&self, history: &Compaction<f64>) -> f64 {
        self.strength(history) * self.lame.bulk_modulus()
    }
}

impl PointLaw for NonAssociativeCamClay {
    type Strain<S: Scalar> = Matrix3<S>;
    type History<S: Scalar> = Compaction<S>;
    const TOTAL_DEFORMATION: TotalDeformation = TotalDeformation::Separate;

    #[inline(always)]
    fn energy_density<S: Scalar>(&self, f: &Matrix3<S>, _history: &Compaction<S>) -> S {
        law::Hencky::new(self.lame).energy_density(f)
    }

    fn energy_gradient(&self, f: &Mat3, _history: &Compaction<f64>) -> Mat3 {
        law::Hencky::new(self.lame).first_piola(f)
    }

    fn energy_curvature(&self, f: &Mat3, _history: &Compaction<f64>, projection: Projection) -> Curvature {
        Curvature::Deformation(law::Hencky::new(self.lame).stiffness(f, projection), 1.0)
    }

    #[inline(always)]
    fn stress<S: Scalar>(&self, f: &Matrix3<S>, _history: &Compaction<S>) -> Stress<S> {
        LogarithmicStrain::of(f).stress(self.lame)
    }

    #[inline(always)]
    fn return_map<S: Scalar>(
        &self,
        trial: &Matrix3<S>,
        history: &mut Compaction<S>,
        _step: f64,
    ) -> (Matrix3<S>, Stress<S>) {
        let (zero, one, strain) = (S::constant(0.0), S::constant(1.0), LogarithmicStrain::of(trial));
        let (c, p) = (self.strength(history), -strain.volume);
        let q = strain.equivalent_stress(self.lame).scale(1.0 / self.lame.bulk_modulus());
        let (crushed, torn) = (c.less(p), p.less(c.scale(-self.ellipse.tensile_ratio)));
        let tip = S::select(crushed, c, c.scale(-self.ellipse.tensile_ratio));
        let beyond_tip = crushed.or(torn);
        let sheared = zero.less(self.ellipse.value(p, q, c)).and(beyond_tip.not());
        // Half the axis along p, the centre, and how far outside the trial is along the ray from there.
        let half = c.scale(0.5 * (1.0 + self.ellipse.tensile_ratio));
        let centre = c.scale(0.5 * (1.0 - self.ellipse.tensile_ratio));
        let height = (half.square() - (p - centre).square()).max(zero).sqrt().scale(self.ellipse.height());
        let outside = ((p - centre) / half).square() + (q / half.scale(self.ellipse.height())).square();
        let crossing = centre + (p - centre) / outside.sqrt();
        let change = S::select(beyond_tip, tip - p, S::select(sheared, crossing - p, zero));
        history.log_volume += change;
        let shorter = S::select(beyond_tip, zero, S::select(sheared, height / q, one));
        let expansion = S::select(beyond_tip, p - tip, zero);
        strain.returned(trial, Flow { shorter, expansion }, self.lame)
    }
}
