//! Sand.

use crate::error::{Parameter, not_negative, require};
use crate::logarithmic::{Flow, LogarithmicStrain, fraction};
use crate::{Curvature, Numbers, PointLaw, PointLawError, Stress, TotalDeformation};
use mechanics_core::law::{self, Hyperelastic, Lame};
use mechanics_core::projection::Projection;
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::{Mat3, Matrix3, dot};
use std::f64::consts::FRAC_PI_2;

/// The angle of internal friction φ(q) = φ∞ + (b q − d) e^(−c q) \[rad\] of the plastic flow q.
///
/// q = 0 gives φ∞ − d; φ rises with b and decays to φ∞ at the rate c. Klár et al. write h₀, h₁, h₂, h₃ for φ∞, b, c, d.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionAngle {
    residual: f64,
    rise: f64,
    decay: f64,
    initial_drop: f64,
}

impl FrictionAngle {
    /// φ, the same for ever \[rad\].
    ///
    /// # Errors
    /// [`PointLawError::OutOfRange`] unless 0 < φ < π/2.
    pub fn constant(angle: f64) -> Result<Self, PointLawError> {
        require_angle(angle)?;
        Ok(Self { residual: angle, rise: 0.0, decay: 0.0, initial_drop: 0.0 })
    }

    /// φ(q) = φ∞ + (b q − d) e^(−c q), from [φ∞, b, c, d] (angles in radians).
    ///
    /// # Errors
    /// [`PointLawError::OutOfRange`] unless b ≥ 0, c > 0 (c ≥ 0 if b = d = 0) and the extremes of φ, at q = 0, at q → ∞ and where b = c (b q − d),
    /// lie between 0 and π/2.
    pub fn hardening([residual, rise, decay, initial_drop]: [f64; 4]) -> Result<Self, PointLawError> {
        require_angle(residual)?;
        require_angle(residual - initial_drop)?;
        not_negative(Parameter::FrictionHardeningRate, rise)?;
        if rise != 0.0 || initial_drop != 0.0 {
            require(Parameter::FrictionHardeningRate, decay, |c| c > 0.0, "positive and finite")?;
        }
        let angle = Self { residual, rise, decay, initial_drop };
        if rise > 0.0 {
            // φ′ = (b − c (b q − d)) e^(−c q)
            require_angle(angle.at((1.0 / decay + initial_drop / rise).max(0.0)))?;
        }
        Ok(angle)
    }

    /// φ(q) \[rad\].
    #[inline(always)]
    pub fn at<S: Scalar>(&self, flow: S) -> S {
        if self.is_constant() {
            return S::constant(self.residual);
        }
        let change = flow.scale(self.rise).offset(-self.initial_drop);
        (change * flow.scale(-self.decay).exp()).offset(self.residual)
    }

    #[inline(always)]
    fn is_constant(&self) -> bool {
        self.rise == 0.0 && self.initial_drop == 0.0
    }
}

fn require_angle(angle: f64) -> Result<(), PointLawError> {
    require(
        Parameter::FrictionAngle,
        angle,
        |v| v > 0.0 && v < FRAC_PI_2,
        "between 0 and π/2, both excluded, at all times",
    )
}

/// Drucker and Prager's plasticity with a volume correction: sand, dry or cohesive.
///
/// With p = −⅓ tr τ = −Kt (t = ln Jᵉ) and the friction angle φ:
///
/// - yield: ‖dev τ‖ ≤ 3a p + k, a cone about the hydrostatic axis with a = √(2/3) · 2 sin φ/(3 − sin φ) and
///   k = √(2/3) · 6c cos φ/(3 − sin φ): Mohr and Coulomb's surface in triaxial compression. Its apex is at p = −c cot φ.
/// - flow: along dev τ, without dilation (non-associative). The return keeps t and shortens e to 2μ‖e′‖ = k − 3aKt.
/// - beyond the apex, t > t_a = c cot φ/K: the material opens. No stress is left, e′ = 0, t′ = 0.
///
/// # Volume correction
/// Opening takes volume out of Fᵉ. If nothing remembered it, closing the gap again would count as compression: the sand would swell.
/// The history keeps the opening v ≥ 0, the logarithm of the volume so taken, and the trial is judged by t̃ = t + v:
///
/// - open, t̃ > t_a (t̃ > 0 once v > 0: torn material has no cohesion until it is closed): e′ = 0, t′ = 0, v′ = t̃
/// - closed: t′ = t̃, v′ = 0, e shortened to the cone at t̃ if it is outside
///
/// In every case **t′ + v′ = t + v**: volume is conserved exactly. The stored energy does not grow. Letting go of tension
/// beyond the apex is sudden where c > 0.
///
/// # Hardening
/// q grows by the length of the flow (‖e‖ − ‖e′‖, or the whole ‖l‖ when opening), and the cone of a step is that of q at its begin.
///
/// # Reference
/// Klár, Gast, Pradhana, Fu, Schroeder, Jiang, Teran, Drucker–Prager elastoplasticity for sand animation (2016), with its
/// supplement; the volume correction: Tampubolon et al., Multi-species simulation of porous sand and water mixtures (2017). Losing
/// cohesion while open is ours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DruckerPrager {
    lame: Lame,
    angle: FrictionAngle,
    cohesion: f64,
}

/// The history of sand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SandHistory<S> {
    /// v ≥ 0, logarithm of the volume by which the sand has opened.
    pub opening: S,
    /// q ≥ 0, the length of all plastic flow.
    pub flow: S,
}

impl<S: Scalar> Numbers<S> for SandHistory<S> {
    const COUNT: usize = 2;

    #[inline(always)]
    fn from_numbers(mut number: impl FnMut(usize) -> S) -> Self {
        Self { opening: number(0), flow: number(1) }
    }

    #[inline(always)]
    fn number(&self, k: usize) -> S {
        [self.opening, self.flow][k]
    }
}

/// The yield cone of a step: ‖e‖ ≤ `slope` · (`apex` − t).
#[derive(Clone, Copy, Debug)]
struct Cone<S> {
    /// 3aK/2μ.
    slope: S,
    /// t_a = c cot φ/K.
    apex: S,
}

impl DruckerPrager {
    /// From the elasticity, the friction angle, and the cohesion c \[Pa\], 0 for dry sand.
    ///
    /// # Errors
    /// [`PointLawError::OutOfRange`] unless 0 ≤ c < ∞.
    pub fn new(lame: Lame, angle: FrictionAngle, cohesion: f64) -> Result<Self, PointLawError> {
        not_negative(Parameter::Cohesion, cohesion)?;
        Ok(Self { lame, angle, cohesion })
    }

    #[inline(always)]
    fn cone<S: Scalar>(&self, flow: S) -> Cone<S> {
        if self.angle.is_constant() {
            let Cone { slope, apex } = self.cone_at(self.angle.residual);
            return Cone { slope: S::constant(slope), apex: S::constant(apex) };
        }
        self.cone_at(self.angle.at(flow))
    }

    #[inline(always)]
    fn cone_at<S: Scalar>(&self, angle: S) -> Cone<S> {
        let (sine, bulk) = (angle.sin(), self.lame.bulk_modulus());
        let friction = sine.scale(8.0_f64.sqrt() / 3.0_f64.sqrt()) / (-sine).offset(3.0);
        Cone {
            slope: friction.scale(1.5 * bulk / self.lame.mu()),
            apex: (angle.cos() / sine).scale(self.cohesion / bulk),
        }
    }
}

impl PointLaw for DruckerPrager {
    type Strain<S: Scalar> = Matrix3<S>;
    type History<S: Scalar> = SandHistory<S>;
    const TOTAL_DEFORMATION: TotalDeformation = TotalDeformation::Separate;

    #[inline(always)]
    fn energy_density<S: Scalar>(&self, f: &Matrix3<S>, _history: &SandHistory<S>) -> S {
        law::Hencky::new(self.lame).energy_density(f)
    }

    fn energy_gradient(&self, f: &Mat3, _history: &SandHistory<f64>) -> Mat3 {
        law::Hencky::new(self.lame).first_piola(f)
    }

    fn energy_curvature(&self, f: &Mat3, _history: &SandHistory<f64>, projection: Projection) -> Curvature {
        Curvature::Deformation(law::Hencky::new(self.lame).stiffness(f, projection), 1.0)
    }

    #[inline(always)]
    fn stress<S: Scalar>(&self, f: &Matrix3<S>, _history: &SandHistory<S>) -> Stress<S> {
        LogarithmicStrain::of(f).stress(self.lame)
    }

    #[inline(always)]
    fn return_map<S: Scalar>(
        &self,
        trial: &Matrix3<S>,
        history: &mut SandHistory<S>,
        _step: f64,
    ) -> (Matrix3<S>, Stress<S>) {
        let (zero, strain) = (S::constant(0.0), LogarithmicStrain::of(trial));
        let cone = self.cone(history.flow);
        let volume = strain.volume + history.opening;
        let torn = zero.less(history.opening);
        let opens = S::select(torn, zero, cone.apex).less(volume);
        let radius = S::select(opens, zero, cone.slope * (cone.apex - volume));
        let shorter = S::select(opens, zero, fraction(radius, strain.norm));
        let expansion = S::select(opens, -strain.volume, history.opening);
        let length = dot(&strain.log, &strain.log).sqrt();
        let flowed = S::select(opens, length, strain.norm - strain.norm * shorter);
        let opening = S::select(opens, volume, zero);
        *history = SandHistory { opening, flow: history.flow + flowed };
        strain.returned(trial, Flow { shorter, expansion }, self.lame)
    }
}
