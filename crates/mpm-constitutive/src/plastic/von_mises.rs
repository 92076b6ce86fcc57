//! Metals, and plasticine.

use super::YieldStress;
use crate::logarithmic::{Flow, LogarithmicStrain, fraction};
use crate::root::decreasing_root;
use crate::{Curvature, Numbers, PointLaw, PointLawError, Stress, TotalDeformation};
use mechanics_core::jet::Jet1;
use mechanics_core::law::{self, Hyperelastic, Lame};
use mechanics_core::projection::Projection;
use mechanics_core::scalar::{Mask, Scalar};
use mechanics_core::tensor::{Mat3, Matrix3};

/// Von Mises' plasticity (J₂ flow) on the logarithmic strain, with isotropic hardening or softening.
///
/// - yield: q = √(3/2)‖dev τ‖ ≤ σ_y(α), that is ‖dev τ‖ ≤ √(2/3) σ_y
/// - flow, associative: the plastic strain grows along n = dev τ/‖dev τ‖ by Δγ; the volume is untouched
/// - hardening: α grows by √(2/3) Δγ, so that in uniaxial stress α is the plastic strain and q the stress
///
/// Return map (implicit Euler, exact for proportional loading): n is that of the trial, since flow only shortens e; with
/// ‖dev τ‖ = 2μ‖e‖, ‖e′‖ = ‖e‖ − Δγ and x = √(2/3) Δγ = Δα
///
/// q_trial − 3μx = σ_y(α + x),
///
/// x = (q_trial − σ_y(α))/(3μ + H) if σ_y is linear; otherwise the left side less the right one falls in x (3μ + σ_y′ > 0, see
/// [`new`](Self::new)) and is positive at 0, not positive at q_trial/3μ: one root.
///
/// *Plasticine* is this law with a saturation below the initial yield stress ([`YieldStress::saturating`]).
///
/// Domain: det Fᵉ > 0.
///
/// # Reference
/// Simo, Algorithms for static and dynamic multiplicative plasticity that preserve the classical return mapping schemes of the
/// infinitesimal theory (1992); de Souza Neto, Perić, Owen, Computational Methods for Plasticity (2008).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VonMises {
    lame: Lame,
    yield_stress: YieldStress,
}

/// The equivalent plastic strain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlasticStrain<S> {
    /// α, from 0.
    pub equivalent: S,
}

impl<S: Scalar> Numbers<S> for PlasticStrain<S> {
    const COUNT: usize = 1;

    #[inline(always)]
    fn from_numbers(mut number: impl FnMut(usize) -> S) -> Self {
        Self { equivalent: number(0) }
    }

    #[inline(always)]
    fn number(&self, k: usize) -> S {
        [self.equivalent][k]
    }
}

impl VonMises {
    /// The solid with the given elasticity and yield stress.
    ///
    /// # Errors
    /// [`PointLawError::Softening`] unless −σ_y′ < 3μ for every α: beyond, a strain has several stresses.
    pub fn new(lame: Lame, yield_stress: YieldStress) -> Result<Self, PointLawError> {
        let (slope, limit) = (yield_stress.steepest_fall(), 3.0 * lame.mu());
        if slope < limit {
            Ok(Self { lame, yield_stress })
        } else {
            Err(PointLawError::Softening { slope, limit })
        }
    }

    /// x = Δα on the lanes that flow, 0 elsewhere.
    #[inline(always)]
    fn plastic_increment<S: Scalar>(&self, trial: S, strain: S) -> S {
        let (zero, stiffness) = (S::constant(0.0), 3.0 * self.lame.mu());
        let beyond = trial - self.yield_stress.at(strain);
        let flows = zero.less(beyond);
        if self.yield_stress.is_linear() {
            return S::select(flows, beyond.scale(1.0 / (stiffness + self.yield_stress.modulus())), zero);
        }
        if !flows.any() {
            return zero;
        }
        let (whole, constant) = (trial.scale(1.0 / stiffness), Jet1::from_value);
        // From the side from which Newton's method is monotone: left if σ_y hardens (convex), right if it softens.
        let start = if self.yield_stress.steepest_fall() > 0.0 { whole } else { zero };
        let x = decreasing_root([zero, whole], start, flows, |x| {
            constant(trial) - x.scale(stiffness) - self.yield_stress.at(constant(strain) + x)
        });
        S::select(flows, x, zero)
    }
}

impl PointLaw for VonMises {
    type Strain<S: Scalar> = Matrix3<S>;
    type History<S: Scalar> = PlasticStrain<S>;
    const TOTAL_DEFORMATION: TotalDeformation = TotalDeformation::Separate;

    #[inline(always)]
    fn energy_density<S: Scalar>(&self, f: &Matrix3<S>, _history: &PlasticStrain<S>) -> S {
        law::Hencky::new(self.lame).energy_density(f)
    }

    fn energy_gradient(&self, f: &Mat3, _history: &PlasticStrain<f64>) -> Mat3 {
        law::Hencky::new(self.lame).first_piola(f)
    }

    fn energy_curvature(&self, f: &Mat3, _history: &PlasticStrain<f64>, projection: Projection) -> Curvature {
        Curvature::Deformation(law::Hencky::new(self.lame).stiffness(f, projection), 1.0)
    }

    #[inline(always)]
    fn stress<S: Scalar>(&self, f: &Matrix3<S>, _history: &PlasticStrain<S>) -> Stress<S> {
        LogarithmicStrain::of(f).stress(self.lame)
    }

    #[inline(always)]
    fn return_map<S: Scalar>(
        &self,
        trial: &Matrix3<S>,
        history: &mut PlasticStrain<S>,
        _step: f64,
    ) -> (Matrix3<S>, Stress<S>) {
        let strain = LogarithmicStrain::of(trial);
        let increment = self.plastic_increment(strain.equivalent_stress(self.lame), history.equivalent);
        history.equivalent += increment;
        // x = √(2/3) Δγ
        let left = strain.norm - increment.scale(1.5_f64.sqrt());
        let flow = Flow { shorter: fraction(left, strain.norm), expansion: S::constant(0.0) };
        strain.returned(trial, flow, self.lame)
    }
}
