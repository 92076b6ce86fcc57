//! Coulomb's law: exact, as the principle of maximum dissipation states it, and smoothed, as a minimiser can use it.
//!
//! # Exact
//! Two bodies pressed together by the normal force λ, with the velocity v of the one relative to the other in the tangent plane,
//! dissipate what they can: the force β on the first minimises β·v over the disk ‖β‖ ≤ μ λ. For v ≠ 0 that is
//! β = −μ λ v/‖v‖; for v = 0 every force of the disk is as good, and which one acts follows from the balance with all other forces.
//! [`sliding_force`] and [`holding_force`] are the two cases. The law is a set, not a function, at v = 0: no Newton's method
//! can use it.
//!
//! # Smoothed
//! [`SmoothedCoulomb`] replaces it by β = −λ μ(y) v/y with y = ‖v‖ and, with z = y/εᵥ and s = (y − εᵥ)/δ,
//!
//! μ(y) = μ_s f₁(z) for y ≤ εᵥ, μ_s + (μ_k − μ_s) S(s) for εᵥ < y < εᵥ + δ, μ_k beyond.
//!
//! f₁ grows from 0 to 1 with slope zero at 1, S likewise with slope zero at both ends:
//!
//! | [`Smoothing`] | f₁(z) | S(s) | μ is |
//! |---|---|---|---|
//! | `Quadratic` | 2z − z² | 3s² − 2s³ | C¹ |
//! | `Quintic` | (15z − 10z³ + 3z⁵)/8 | 10s³ − 15s⁴ + 6s⁵ | C², and smooth at rest: f₁ is odd |
//!
//! So friction reaches exactly μ_s λ, at y = εᵥ, before anything slides faster, and falls to μ_k λ over the width δ after that; it
//! exceeds neither anywhere. What should stick creeps, at the speed y < εᵥ where λ μ(y) is the load. For the quadratic form and the load
//! τ λ that is y = εᵥ (1 − √(1 − τ/μ_s)). Smaller εᵥ: less creep, stiffer equations.
//!
//! The potential is P(y) = ∫ μ dy, with μ_s f₀ below εᵥ, f₀ = ∫ f₁ dy and f₀ = y from εᵥ on:
//! f₀ = εᵥ(z² − z³/3 + 1/3), or εᵥ(15z²/16 − 5z⁴/16 + z⁶/16 + 5/16).
//!
//! # Reference
//! J. J. Moreau, *On unilateral constraints, friction and plasticity*, 1973 (maximum dissipation). M. Li et al., *Incremental Potential
//! Contact*, ACM Trans. Graph. 39(4), 2020, section 5 (quadratic f₁, in displacements: there εᵥ h takes the place of εᵥ). The
//! quintic forms are the polynomials of least degree with the stated derivatives at their ends.

use crate::FrictionError;
use mechanics_core::scalar::{Mask, Scalar};

/// Static coefficient μ_s and kinetic coefficient μ_k ≤ μ_s of two surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrictionCoefficient {
    at_rest: f64,
    sliding: f64,
}

impl FrictionCoefficient {
    /// No friction.
    pub const NONE: Self = Self { at_rest: 0.0, sliding: 0.0 };

    /// The same coefficient at rest and sliding.
    ///
    /// # Errors
    /// If it is negative or not finite.
    pub fn new(friction_coefficient: f64) -> Result<Self, FrictionError> {
        Self::with_kinetic(friction_coefficient, friction_coefficient)
    }

    /// μ_s and μ_k.
    ///
    /// # Errors
    /// If one of them is negative or not finite, or if μ_k > μ_s.
    pub fn with_kinetic(at_rest: f64, sliding: f64) -> Result<Self, FrictionError> {
        for value in [at_rest, sliding] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(FrictionError::Coefficient { value });
            }
        }
        if sliding > at_rest {
            return Err(FrictionError::KineticAboveStatic { at_rest, sliding });
        }
        Ok(Self { at_rest, sliding })
    }

    /// μ_s.
    pub fn at_rest(&self) -> f64 {
        self.at_rest
    }

    /// μ_k.
    pub fn sliding(&self) -> f64 {
        self.sliding
    }
}

/// The force of maximum dissipation \[N\] on what slides with `velocity` ≠ 0, in a frame of the tangent plane, for the largest
/// force `bound` = μ λ \[N\]: the minimiser of β·v over ‖β‖ ≤ μ λ. `None` for a velocity of zero, where all of the disk minimises.
pub fn sliding_force(velocity: [f64; 2], bound: f64) -> Option<[f64; 2]> {
    let speed = velocity[0].hypot(velocity[1]);
    (speed > 0.0).then(|| velocity.map(|v| -bound * (v / speed)))
}

/// The force \[N\] on what is at rest under the tangential `load` \[N\] of all other forces: the one of the disk ‖β‖ ≤ μ λ =
/// `bound` that comes closest to holding it. It holds if ‖load‖ ≤ μ λ; else it begins to slide along the load.
pub fn holding_force(load: [f64; 2], bound: f64) -> [f64; 2] {
    let size = load[0].hypot(load[1]);
    if size <= bound { load.map(|f| -f) } else { load.map(|f| -bound * (f / size)) }
}

/// How μ goes from 0 to μ_s and from μ_s to μ_k; see the [module](self) page.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Smoothing {
    /// μ is C¹: the law of Li et al. 2020.
    #[default]
    Quadratic,
    /// μ is C², and the potential is smooth at rest.
    Quintic,
}

impl Smoothing {
    /// f₀ in parts of εᵥ, for z ≤ 1.
    #[inline(always)]
    fn f0<S: Scalar>(self, z: S) -> S {
        let square = z.square();
        match self {
            Self::Quadratic => square.mul_add(S::constant(1.0) - z.scale(1.0 / 3.0), S::constant(1.0 / 3.0)),
            Self::Quintic => {
                let inner = square.mul_add(S::constant(1.0 / 16.0), S::constant(-5.0 / 16.0));
                square.mul_add(square.mul_add(inner, S::constant(15.0 / 16.0)), S::constant(5.0 / 16.0))
            }
        }
    }

    /// f₁/z, for z ≤ 1.
    #[inline(always)]
    fn f1_over_z<S: Scalar>(self, z: S) -> S {
        match self {
            Self::Quadratic => S::constant(2.0) - z,
            Self::Quintic => {
                let square = z.square();
                let inner = square.mul_add(S::constant(3.0 / 8.0), S::constant(-10.0 / 8.0));
                square.mul_add(inner, S::constant(15.0 / 8.0))
            }
        }
    }

    /// df₁/dz, for z ≤ 1.
    #[inline(always)]
    fn f1_slope<S: Scalar>(self, z: S) -> S {
        match self {
            Self::Quadratic => S::constant(2.0) - z.scale(2.0),
            // (15 − 30z² + 15z⁴)/8
            Self::Quintic => (S::constant(1.0) - z.square()).square().scale(15.0 / 8.0),
        }
    }

    /// S, for s in [0, 1].
    #[inline(always)]
    fn fall<S: Scalar>(self, s: S) -> S {
        match self {
            Self::Quadratic => s.square() * (S::constant(3.0) - s.scale(2.0)),
            Self::Quintic => {
                let inner = s.mul_add(s.scale(6.0).offset(-15.0), S::constant(10.0));
                s.square() * s * inner
            }
        }
    }

    /// ∫₀ˢ S, for s in [0, 1]; ½ at 1.
    #[inline(always)]
    fn fall_integral<S: Scalar>(self, s: S) -> S {
        let cube = s.square() * s;
        match self {
            Self::Quadratic => cube * (S::constant(1.0) - s.scale(0.5)),
            Self::Quintic => cube * s * s.mul_add(s.offset(-3.0), S::constant(2.5)),
        }
    }

    /// dS/ds, for s in [0, 1].
    #[inline(always)]
    fn fall_slope<S: Scalar>(self, s: S) -> S {
        let hill = s * (S::constant(1.0) - s);
        match self {
            Self::Quadratic => hill.scale(6.0),
            Self::Quintic => hill.square().scale(30.0),
        }
    }
}

/// Coulomb's law, smoothed over small velocities; see the [module](self) page.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmoothedCoulomb {
    stick_velocity: f64,
    transition_velocity: f64,
    smoothing: Smoothing,
}

/// What a pair is pressed by, times its coefficients.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Strength<S> {
    /// μ_s λ \[N\].
    pub at_rest: S,
    /// (μ_k − μ_s) λ \[N\].
    pub fall: S,
}

impl Strength<f64> {
    /// Of the normal force λ \[N\].
    pub fn new(coefficient: FrictionCoefficient, magnitude: f64) -> Self {
        let FrictionCoefficient { at_rest, sliding } = coefficient;
        Self { at_rest: at_rest * magnitude, fall: (sliding - at_rest) * magnitude }
    }
}

impl SmoothedCoulomb {
    /// The quadratic law with the velocity εᵥ [m/s] below which friction is smoothed (in statics, where displacements take the
    /// place of velocities, a length \[m\]). Where μ_k < μ_s, μ falls between εᵥ and 2 εᵥ.
    ///
    /// # Errors
    /// If εᵥ is not positive and finite.
    pub fn new(stick_velocity: f64) -> Result<Self, FrictionError> {
        if !(stick_velocity.is_finite() && stick_velocity > 0.0) {
            return Err(FrictionError::StickVelocity { value: stick_velocity });
        }
        Ok(Self { stick_velocity, transition_velocity: stick_velocity, smoothing: Smoothing::default() })
    }

    /// The same with other polynomials.
    pub fn with_smoothing(self, smoothing: Smoothing) -> Self {
        Self { smoothing, ..self }
    }

    /// The same with the width δ [m/s] of velocities over which μ falls from μ_s to μ_k.
    ///
    /// # Errors
    /// If it is not positive and finite.
    pub fn with_transition(self, transition_velocity: f64) -> Result<Self, FrictionError> {
        if !(transition_velocity.is_finite() && transition_velocity > 0.0) {
            return Err(FrictionError::TransitionVelocity { value: transition_velocity });
        }
        Ok(Self { transition_velocity, ..self })
    }

    /// The same smoothed below `velocity` [m/s], if that is more than εᵥ.
    pub(crate) fn softened(self, velocity: f64) -> Self {
        Self { stick_velocity: self.stick_velocity.max(velocity), ..self }
    }

    /// εᵥ [m/s].
    pub fn stick_velocity(&self) -> f64 {
        self.stick_velocity
    }

    /// δ [m/s].
    pub fn transition_velocity(&self) -> f64 {
        self.transition_velocity
    }

    /// Which polynomials.
    pub fn smoothing(&self) -> Smoothing {
        self.smoothing
    }

    /// λ P(y) = ∫ λ μ dy [N m/s], `speed` y ≥ 0: convex in y where μ_k = μ_s.
    #[inline(always)]
    pub fn potential<S: Scalar>(&self, strength: Strength<S>, speed: S) -> S {
        let Self { stick_velocity, transition_velocity, smoothing } = *self;
        let z = speed.scale(1.0 / stick_velocity);
        let f0 = S::select(z.less(S::constant(1.0)), smoothing.f0(z).scale(stick_velocity), speed);
        let s = speed.offset(-stick_velocity).scale(1.0 / transition_velocity);
        let within = smoothing.fall_integral(clamp(s)).scale(transition_velocity);
        let beyond = s.offset(-0.5).scale(transition_velocity);
        let falling = S::select(s.less(S::constant(1.0)), within, beyond);
        strength.at_rest * f0 + strength.fall * falling
    }

    /// λ μ(y) \[N\], the size of the force.
    #[inline(always)]
    pub fn force<S: Scalar>(&self, strength: Strength<S>, speed: S) -> S {
        self.force_over_speed(strength, speed) * speed
    }

    /// λ μ(y)/y [N s/m], finite at y = 0: the viscosity that the law is like at rest.
    #[inline(always)]
    pub fn force_over_speed<S: Scalar>(&self, strength: Strength<S>, speed: S) -> S {
        let Self { stick_velocity, smoothing, .. } = *self;
        let slow = speed.less(S::constant(stick_velocity));
        let reciprocal = S::select(slow, S::constant(stick_velocity), speed).recip();
        let z = speed.scale(1.0 / stick_velocity);
        let f1 = S::select(slow, smoothing.f1_over_z(z).scale(1.0 / stick_velocity), reciprocal);
        let falling = smoothing.fall(self.fallen(speed)) * reciprocal;
        strength.at_rest * f1 + strength.fall * falling
    }

    /// λ dμ/dy [N s/m].
    #[inline(always)]
    pub fn slope<S: Scalar>(&self, strength: Strength<S>, speed: S) -> S {
        let Self { stick_velocity, transition_velocity, smoothing } = *self;
        let z = speed.scale(1.0 / stick_velocity);
        let slow = z.less(S::constant(1.0));
        let rising = S::select(slow, smoothing.f1_slope(z).scale(1.0 / stick_velocity), S::constant(0.0));
        let falling = smoothing.fall_slope(self.fallen(speed)).scale(1.0 / transition_velocity);
        strength.at_rest * rising + strength.fall * falling
    }

    /// s, within [0, 1].
    #[inline(always)]
    fn fallen<S: Scalar>(&self, speed: S) -> S {
        clamp(speed.offset(-self.stick_velocity).scale(1.0 / self.transition_velocity))
    }
}

/// The number, or the end of [0, 1] that it is beyond.
#[inline(always)]
fn clamp<S: Scalar>(s: S) -> S {
    let (zero, one) = (S::constant(0.0), S::constant(1.0));
    let inside = zero.less(s).and(s.less(one));
    let end = S::select(s.less(one), zero, one);
    S::select(inside, s, end)
}
