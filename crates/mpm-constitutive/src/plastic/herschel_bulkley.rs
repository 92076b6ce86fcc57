//! Foams, pastes and gels.

use super::YieldStress;
use crate::error::{Parameter, positive};
use crate::logarithmic::{Flow, LogarithmicStrain, fraction};
use crate::{Curvature, PointLaw, PointLawError, Stress, TotalDeformation};
use mechanics_core::law::{self, Hyperelastic, Lame};
use mechanics_core::projection::Projection;
use mechanics_core::scalar::{Mask, Scalar};
use mechanics_core::tensor::{Mat3, Matrix3};

/// Newton steps at most; about six are taken.
const MOST_STEPS: usize = 80;

/// Herschel and Bulkley's viscoplasticity on the logarithmic strain.
///
/// In uniaxial measures (q = √(3/2)‖dev τ‖, ε̇ the equivalent rate of plastic strain):
///
/// q = σ_y + k ε̇ʰ where it flows, ε̇ = 0 where q ≤ σ_y.
///
/// h < 1 thins under shear (foam, paint), h = 1 is Bingham's fluid, h > 1 thickens (starch). In simple shear, with shear stress s = q/√3
/// and rate γ̇ = √3 ε̇, it reads s = s_y + κ γ̇ʰ with σ_y = √3 s_y and k = 3^((1+h)/2) κ: convert what a rheometer gives.
///
/// # Return map
/// Implicit Euler over the step Δt: e keeps its direction, the volume stays, and q′ = q_trial − 3μ Δt ε̇. With o = q′ − σ_y and Φ = q_trial − σ_y > 0
///
/// o + 3μΔt (o/k)^(1/h) = Φ.
///
/// For h ≤ 1 the power is convex in o; for h > 1 the same equation is taken in the drop d = Φ − o, d + k (d/3μΔt)ʰ = Φ, where it is
/// convex too. Either way z + b zⁿ = Φ with n ≥ 1. With z = Φ a v and a = (b Φⁿ⁻¹)^(−1/n), which neither overflows nor underflows,
///
/// a v + vⁿ = 1,  a = (k/Φ)(Φ/3μΔt)ʰ for h ≤ 1,  a = (3μΔt/Φ)(Φ/k)^(1/h) for h > 1.
///
/// The left side is convex and grows; at v = min(1, 1/a) it is at least 1, so that Newton's method falls monotonically to the root. Then
/// o = Φ a v, or o = Φ vⁿ. For h = 1, v = 1/(1 + a).
///
/// q′ → σ_y as Δt → ∞ (rate-independent plasticity), and the solid stays elastic as Δt → 0. A step of length zero does not flow.
///
/// Domain: det Fᵉ > 0.
///
/// # Reference
/// Herschel and Bulkley (1926), Konsistenzmessungen von Gummi-Benzollösungen; for material points Yue, Smith, Batty, Zheng, Grinspun,
/// Continuum foam: a material point method for shear-dependent flows (2015; there on the left Cauchy–Green tensor).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HerschelBulkley {
    lame: Lame,
    yield_stress: f64,
    consistency: f64,
    index: f64,
}

impl HerschelBulkley {
    /// From the elasticity, σ_y \[Pa\], k [Pa sʰ] and h.
    ///
    /// # Errors
    /// [`PointLawError::OutOfRange`] unless σ_y, k, h are positive and finite.
    pub fn new(
        lame: Lame,
        yield_stress: f64,
        consistency: f64,
        flow_index: f64,
    ) -> Result<Self, PointLawError> {
        YieldStress::perfect(yield_stress)?;
        positive(Parameter::Consistency, consistency)?;
        positive(Parameter::FlowIndex, flow_index)?;
        Ok(Self { lame, yield_stress, consistency, index: flow_index })
    }

    /// o for Φ on the lanes where it is positive; without meaning elsewhere.
    #[inline(always)]
    fn overstress<S: Scalar>(&self, trial: S, flows: S::Mask, step: f64) -> S {
        let drop = 3.0 * self.lame.mu() * step;
        if self.index > 1.0 {
            let power = trial.scale(1.0 / self.consistency).powf(1.0 / self.index);
            let v = scaled_root(power * trial.recip().scale(drop), self.index, flows);
            return trial * v.powf(self.index);
        }
        let a = trial.scale(1.0 / drop).powf(self.index) * trial.recip().scale(self.consistency);
        trial * a * scaled_root(a, 1.0 / self.index, flows)
    }
}

/// The root v of a v + vⁿ = 1, n ≥ 1, a > 0, on the active lanes.
#[inline(always)]
fn scaled_root<S: Scalar>(a: S, n: f64, active: S::Mask) -> S {
    let one = S::constant(1.0);
    if n == 1.0 {
        return a.offset(1.0).recip();
    }
    let (mut v, mut active) = (S::select(a.less(one), one, a.recip()), active);
    for _ in 0..MOST_STEPS {
        let power = v.powf(n - 1.0);
        let next = (v * power).mul_add(S::constant(n - 1.0), one) / (a + power.scale(n));
        let moves = v.scale(2.0 * S::EPSILON).less((next - v).abs());
        v = S::select(active, next, v);
        active = active.and(moves);
        if !active.any() {
            break;
        }
    }
    v
}

impl PointLaw for HerschelBulkley {
    type Strain<S: Scalar> = Matrix3<S>;
    type History<S: Scalar> = ();
    const TOTAL_DEFORMATION: TotalDeformation = TotalDeformation::Separate;

    #[inline(always)]
    fn energy_density<S: Scalar>(&self, f: &Matrix3<S>, _history: &()) -> S {
        law::Hencky::new(self.lame).energy_density(f)
    }

    fn energy_gradient(&self, f: &Mat3, _history: &()) -> Mat3 {
        law::Hencky::new(self.lame).first_piola(f)
    }

    fn energy_curvature(&self, f: &Mat3, _history: &(), projection: Projection) -> Curvature {
        Curvature::Deformation(law::Hencky::new(self.lame).stiffness(f, projection), 1.0)
    }

    #[inline(always)]
    fn stress<S: Scalar>(&self, f: &Matrix3<S>, _history: &()) -> Stress<S> {
        LogarithmicStrain::of(f).stress(self.lame)
    }

    #[inline(always)]
    fn return_map<S: Scalar>(
        &self,
        trial: &Matrix3<S>,
        _history: &mut (),
        step: f64,
    ) -> (Matrix3<S>, Stress<S>) {
        let (zero, strain) = (S::constant(0.0), LogarithmicStrain::of(trial));
        let q = strain.equivalent_stress(self.lame);
        let beyond = q.offset(-self.yield_stress);
        let flows = zero.less(beyond);
        if step <= 0.0 || !flows.any() {
            return (*trial, strain.stress(self.lame));
        }
        let after = self.overstress(beyond, flows, step).offset(self.yield_stress);
        let shorter = S::select(flows, fraction(after, q), S::constant(1.0));
        strain.returned(trial, Flow { shorter, expansion: zero }, self.lame)
    }
}
