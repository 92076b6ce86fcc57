//! Clay.

use super::Compaction;
use crate::PointLawError;
use crate::error::{Parameter, not_negative, positive, require};
use crate::logarithmic::{Flow, LogarithmicStrain};
use crate::root::decreasing_root;
use crate::{Curvature, PointLaw, Stress, TotalDeformation};
use mechanics_core::jet::Jet1;
use mechanics_core::law::{self, Hyperelastic, Lame};
use mechanics_core::projection::Projection;
use mechanics_core::scalar::{Mask, Scalar};
use mechanics_core::tensor::{Mat3, Matrix3};

/// The yield surface of the Cam-Clay models, all pressures divided by K.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ellipse {
    /// M.
    slope: f64,
    /// β.
    pub(super) tensile_ratio: f64,
}

pub(super) fn require_ellipse(slope: f64, tensile_ratio: f64) -> Result<Ellipse, PointLawError> {
    positive(Parameter::CriticalStateSlope, slope)?;
    require(Parameter::TensileRatio, tensile_ratio, |v| (0.0..=1.0).contains(&v), "between 0 and 1")?;
    Ok(Ellipse { slope, tensile_ratio })
}

impl Ellipse {
    /// M/√(1 + 2β), the ratio of its axes.
    #[inline(always)]
    pub(super) fn height(&self) -> f64 {
        self.slope / (1.0 + 2.0 * self.tensile_ratio).sqrt()
    }

    /// (1 + 2β) q²/M² + (p + βp_c)(p − p_c).
    #[inline(always)]
    pub(super) fn value<S: Scalar>(&self, p: S, q: S, preconsolidation: S) -> S {
        let tensile = preconsolidation.mul_add(S::constant(self.tensile_ratio), p);
        q.scale(1.0 / self.height()).square() + tensile * (p - preconsolidation)
    }
}

/// Modified Cam-Clay: critical-state plasticity with an associative flow, and a tensile strength if wanted.
///
/// With p = −Kt, q = √6 μ‖e‖, the preconsolidation pressure p_c and α = ln Jᵖ since the start:
///
/// - yield: f = (1 + 2β) q² + M²(p + βp_c)(p − p_c) ≤ 0, an ellipse from p = −βp_c to p = p_c, in whose middle q = Mp for β = 0
/// - flow, associative: Δεᵖ = Δφ ∂f/∂τ. In (p, q): ∂f/∂p = M²(2p − (1 − β)p_c), ∂f/∂q = 2(1 + 2β) q; ∂p/∂τ = −⅓I, ∂q/∂τ = √(3/2) n
/// - hardening: p_c = p_c₀ e^(−ζα), compaction hardens, dilation softens; on the ellipse's left half it therefore softens towards
///   the critical state, where it flows at constant volume
///
/// # Return map
/// Implicit Euler. Let w = −Δα = Δφ ∂f/∂p, the plastic compaction of the step, and P = p/K, Q = q/K, C = p_c/K. Volume and deviator give
///
/// - P = P_trial − w,  C = C₀ e^(ζw)
/// - Q = Q_trial/(1 + 6μ(1 + 2β)Δφ), since ‖e‖ falls by √(3/2) Δφ ∂f/∂q
/// - Δφ = w/(M²K h),  h(w) = 2P − (1 − β)C
///
/// so that all follows from w, and f = 0 is one equation. h falls in w; let w* be its root (between 0 and h(0)/2), the flow that
/// reaches the critical state. w lies between 0 and w*: w = θw*, 0 ≤ θ < 1. With the divided difference
/// D = (h(w) − 0)/(w* − w) = 2 + (1 − β) C ζ φ₁(ζ(w* − w)), φ₁(x) = (eˣ − 1)/x,
///
/// Q = Q_trial (1 − θ)D / [(1 − θ)D + θ · 6μ(1 + 2β)/(M²K)],
///
/// which holds at the critical state too, where w* = 0 and w/h is 0/0. f > 0 at θ = 0; f = −M²p_c²(1 + β)²/4 < 0 at θ = 1.
/// On the compressive side (w* > 0) f falls in θ, and the root is the only one; where it softens there may be several, and one is found.
///
/// The searches look at flows far beyond the one they find, and a fast hardening is beyond all numbers there: for β = 1, w* = P_trial whatever ζ is.
/// So p_c is held at e³⁰ K. No pressure gets there, −ln J being below 745, and no result is changed.
///
/// The stored energy does not grow: the surface is convex and holds the origin, so that τ : Δεᵖ ≥ 0.
///
/// Domain: det Fᵉ > 0.
///
/// # Reference
/// Roscoe and Burland (1968), On the generalised stress–strain behaviour of wet clay; the finite-strain form Borja and Tamagnini,
/// Cam-Clay plasticity part III (1998); the tensile ratio β Gaume, Gast, Teran, van Herwijnen, Jiang, Dynamic anticrack propagation
/// in snow (2018). The reduction to one equation is ours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModifiedCamClay {
    lame: Lame,
    ellipse: Ellipse,
    /// p_c₀/K.
    initial: f64,
    rate: f64,
    /// ln of the most that p_c₀ grows by.
    most: f64,
}

/// ln of the largest p_c/K.
const MOST_STRENGTH: f64 = 30.0;

/// Exponents beyond are taken for this one: with the largest strength it makes a number in single precision too.
const MOST_EXPONENT: f64 = 50.0;

/// The state of a step before its flow is known.
struct Trial<S> {
    p: S,
    q: S,
    /// α.
    log_volume: S,
}

impl ModifiedCamClay {
    /// From the elasticity, the slope M of the critical state line, the tensile ratio β, the initial p_c₀ \[Pa\] and the rate ζ.
    ///
    /// With the slopes λ̃, κ̃ of virgin compression and swelling in ln specific volume over ln p, ζ = 1/(λ̃ − κ̃).
    ///
    /// # Errors
    /// [`PointLawError::OutOfRange`] unless 0 < M, 0 ≤ β ≤ 1, 0 < p_c₀, 0 ≤ ζ, all finite.
    pub fn new(
        lame: Lame,
        slope: f64,
        tensile_ratio: f64,
        preconsolidation: f64,
        rate: f64,
    ) -> Result<Self, PointLawError> {
        let ellipse = require_ellipse(slope, tensile_ratio)?;
        positive(Parameter::Preconsolidation, preconsolidation)?;
        not_negative(Parameter::ConsolidationRate, rate)?;
        let initial = preconsolidation / lame.bulk_modulus();
        Ok(Self { lame, ellipse, initial, rate, most: MOST_STRENGTH - initial.ln() })
    }

    /// p_c \[Pa\], the pressure under which the material compacts now.
    pub fn preconsolidation(&self, history: &Compaction<f64>) -> f64 {
        self.strength(history.log_volume) * self.lame.bulk_modulus()
    }

    /// p_c/K.
    #[inline(always)]
    fn strength<S: Scalar>(&self, log_volume: S) -> S {
        log_volume.scale(-self.rate).min(S::constant(self.most)).exp().scale(self.initial)
    }

    /// w*, at which the flow would reach the critical state.
    #[inline(always)]
    fn critical_compaction<S: Scalar>(&self, trial: &Trial<S>, flows: S::Mask) -> S {
        let (zero, weight) = (S::constant(0.0), 1.0 - self.ellipse.tensile_ratio);
        let farthest = trial.p - self.strength(trial.log_volume).scale(0.5 * weight);
        let bracket = [farthest.min(zero), farthest.max(zero)];
        decreasing_root(bracket, zero, flows, |w| {
            let strength = self.strength(Jet1::from_value(trial.log_volume) - w);
            (Jet1::from_value(trial.p) - w).scale(2.0) - strength.scale(weight)
        })
    }

    /// Q/Q_trial, w and C at θ.
    #[inline(always)]
    fn flowed<S: Scalar>(&self, critical: S, log_volume: S, theta: S) -> [S; 3] {
        let (weight, rest) = (1.0 - self.ellipse.tensile_ratio, (-theta).offset(1.0));
        let w = critical * theta;
        let strength = self.strength(log_volume - w);
        let exponent = (critical * rest).scale(self.rate).min(S::constant(MOST_EXPONENT));
        let difference = (exponential_quotient(exponent) * strength).scale(self.rate * weight).offset(2.0);
        let stiffness = 6.0 * self.lame.mu() / (self.ellipse.height().powi(2) * self.lame.bulk_modulus());
        let remaining = rest * difference;
        [remaining / (remaining + theta.scale(stiffness)), w, strength]
    }

    /// Q/Q_trial and w on the lanes that flow; 1 and 0 elsewhere.
    #[inline(always)]
    fn flow<S: Scalar>(&self, trial: &Trial<S>) -> (S, S) {
        let (zero, one, lift) = (S::constant(0.0), S::constant(1.0), Jet1::from_value);
        let flows = zero.less(self.ellipse.value(trial.p, trial.q, self.strength(trial.log_volume)));
        if !flows.any() {
            return (one, zero);
        }
        let critical = self.critical_compaction(trial, flows);
        let theta = decreasing_root([zero, one], zero, flows, |theta| {
            let [shorter, w, strength] = self.flowed(lift(critical), lift(trial.log_volume), theta);
            self.ellipse.value(lift(trial.p) - w, lift(trial.q) * shorter, strength)
        });
        let [shorter, w, _] = self.flowed(critical, trial.log_volume, theta);
        (S::select(flows, shorter, one), S::select(flows, w, zero))
    }
}

/// (eˣ − 1)/x.
#[inline(always)]
fn exponential_quotient<S: Scalar>(x: S) -> S {
    let small = x.abs().less(S::constant(1e-5));
    let safe = S::select(small, S::constant(1.0), x);
    let series = (x.square().scale(1.0 / 6.0) + x.scale(0.5)).offset(1.0);
    S::select(small, series, safe.exp_m1() / safe)
}

impl PointLaw for ModifiedCamClay {
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
        let strain = LogarithmicStrain::of(trial);
        let q = strain.equivalent_stress(self.lame).scale(1.0 / self.lame.bulk_modulus());
        let (shorter, compaction) =
            self.flow(&Trial { p: -strain.volume, q, log_volume: history.log_volume });
        history.log_volume -= compaction;
        strain.returned(trial, Flow { shorter, expansion: compaction }, self.lame)
    }
}
