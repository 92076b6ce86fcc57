//! The barrier: an energy that is zero beyond an activation distance and infinite at contact.
//!
//! A [`Barrier`] is a function b of the *squared* distance s = d², because squared distances are rational functions
//! of the points and their derivatives exist at every s > 0. It is zero for s ≥ ŝ, where it ends with two continuous
//! derivatives (b, b′ and b″ vanish as (s − ŝ)³, (s − ŝ)² and s − ŝ), positive, decreasing and convex in s below,
//! and +∞ at contact.
//!
//! With r = s/ŝ, u = r − 1 and L = ln r the forms here are
//!
//! | form | b | unit of κ, so that κ b is in joules |
//! |---|---|---|
//! | [`SquaredDistanceBarrier`] | −(s − ŝ)² ln(s/ŝ) = −ŝ² u² L | N/m³ |
//! | [`DistanceBarrier`] | −(d − d̂)² ln(d/d̂) | N/m |
//! | [`PhysicalBarrier`] | −d̂ (s/ŝ − 1)² ln(s/ŝ) = −d̂ u² L | Pa, with weights in m²; N/m without |
//!
//! [`MinimumSeparation`] shifts any of them by a thickness. Adhesion would be one more implementor.
//!
//! # Accuracy
//!
//! Every value and derivative is within a few units in the last place for every 0 < s < ŝ, however close to either
//! end. u = (s − ŝ)/ŝ has one rounding, because the difference is exact for s ≥ ŝ/2 (Sterbenz). The logarithm near ŝ
//! is taken of 1 + u, rounded to v, and what the rounding lost is put back: L = ln v + (u − (v − 1))/v, where v − 1 is
//! exact. The derivatives are sums of terms of one sign (u < 0 and L < 0 below ŝ), so nothing cancels:
//!
//! - with respect to r of −u² L: first −(2 u L + u²/r), second −(2 L + 4 u/r − u²/r²);
//! - with respect to d, see [`DistanceBarrier`].
//!
//! At s ≤ 0 the value is +∞, the first derivative −∞, the second +∞; quantities beyond the range of numbers become
//! those infinities, never NaN. NaN stays NaN.

use crate::error::ContactError;

/// A function of the squared distance that keeps pairs apart; see the [module](self) page.
///
/// Implementors promise: zero for s ≥ [`activation_squared`](Self::activation_squared); below it, positive,
/// decreasing and convex in s; +∞ (value and second derivative) and −∞ (first) at s ≤ 0 or below the minimum
/// separation; twice continuously differentiable between.
pub trait Barrier: Send + Sync + std::fmt::Debug {
    /// ŝ: the squared distance from which on the barrier is zero \[m²\].
    fn activation_squared(&self) -> f64;

    /// b(s), `squared_distance` in m².
    fn value(&self, squared_distance: f64) -> f64;

    /// b′(s) ≤ 0 [1/m² times the unit of b].
    fn first(&self, squared_distance: f64) -> f64;

    /// b″(s) ≥ 0 [1/m⁴ times the unit of b].
    fn second(&self, squared_distance: f64) -> f64;

    /// `[b′(s), b″(s)]`, for less than the sum of their costs if they share a logarithm.
    fn first_and_second(&self, squared_distance: f64) -> [f64; 2] {
        [self.first(squared_distance), self.second(squared_distance)]
    }
}

impl<B: Barrier + ?Sized> Barrier for Box<B> {
    fn activation_squared(&self) -> f64 {
        (**self).activation_squared()
    }
    fn value(&self, squared_distance: f64) -> f64 {
        (**self).value(squared_distance)
    }
    fn first(&self, squared_distance: f64) -> f64 {
        (**self).first(squared_distance)
    }
    fn second(&self, squared_distance: f64) -> f64 {
        (**self).second(squared_distance)
    }
    fn first_and_second(&self, squared_distance: f64) -> [f64; 2] {
        (**self).first_and_second(squared_distance)
    }
}

/// A barrier that stays the same function when its range is moved: what [`MinimumSeparation`] can shift.
pub trait Widen: Barrier + Sized {
    /// The same form, active below another squared distance \[m²\]; scales that belong to d̂ stay.
    #[must_use]
    fn with_activation_squared(self, activation_squared: f64) -> Self;

    /// d̂ as given \[m\].
    fn activation_distance(&self) -> f64;
}

/// Activation distances lie between this and its reciprocal \[m\], so that d̂⁴ is an ordinary number.
const SMALLEST_DISTANCE: f64 = 1e-60;

/// d̂ and ŝ.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Activation {
    distance: f64,
    squared: f64,
}

impl Activation {
    fn new(distance: f64) -> Result<Self, ContactError> {
        if !(SMALLEST_DISTANCE..=SMALLEST_DISTANCE.recip()).contains(&distance) {
            return Err(ContactError::ActivationDistance { distance });
        }
        Ok(Self { distance, squared: distance * distance })
    }
}

/// Where s lies below ŝ.
#[derive(Clone, Copy)]
enum Range {
    /// s ≥ ŝ.
    Inactive,
    /// 0 < s < ŝ.
    Active,
    /// s ≤ 0.
    Contact,
    /// s is NaN.
    Undefined,
}

#[inline(always)]
fn range(squared_distance: f64, activation_squared: f64) -> Range {
    if squared_distance > 0.0 && squared_distance < activation_squared {
        Range::Active
    } else if squared_distance >= activation_squared {
        Range::Inactive
    } else if squared_distance <= 0.0 {
        Range::Contact
    } else {
        Range::Undefined
    }
}

/// Evaluates `active` below ŝ and gives `contact` (an infinity) at contact.
#[inline(always)]
fn by_range(squared_distance: f64, activation_squared: f64, contact: f64, active: impl Fn() -> f64) -> f64 {
    match range(squared_distance, activation_squared) {
        Range::Active => active(),
        Range::Inactive => 0.0,
        Range::Contact => contact,
        Range::Undefined => f64::NAN,
    }
}

/// r = s/ŝ, u = r − 1 and L = ln r for 0 < s < ŝ.
#[derive(Clone, Copy)]
struct Ratio {
    r: f64,
    u: f64,
    ln: f64,
}

impl Ratio {
    #[inline(always)]
    fn new(squared_distance: f64, activation_squared: f64) -> Self {
        let r = squared_distance / activation_squared;
        let u = (squared_distance - activation_squared) / activation_squared;
        let far = r < 0.5;
        let v = if far { r } else { 1.0 + u };
        let lost = if far { 0.0 } else { u - (v - 1.0) };
        // v may have underflowed to zero, where nothing was lost.
        Self { r, u, ln: v.ln() + lost / v.max(0.5) }
    }

    /// −u² L and its first two derivatives with respect to r.
    #[inline(always)]
    fn shape(self) -> f64 {
        -(self.u * self.u) * self.ln
    }

    #[inline(always)]
    fn shape_first(self) -> f64 {
        let Self { r, u, ln } = self;
        -(2.0 * u * ln + u * u / r)
    }

    #[inline(always)]
    fn shape_second(self) -> f64 {
        let Self { r, u, ln } = self;
        let q = u / r;
        -2.0 * ln - 4.0 * q + q * q
    }
}

/// The shape −u² L in r = s/ŝ, times `scale`.
macro_rules! squared_shape {
    ($barrier:ident, $scale:expr) => {
        impl Barrier for $barrier {
            #[inline]
            fn activation_squared(&self) -> f64 {
                self.activation.squared
            }
            #[inline]
            fn value(&self, squared_distance: f64) -> f64 {
                let squared = self.activation.squared;
                by_range(squared_distance, squared, f64::INFINITY, || {
                    $scale(self.activation)[0] * Ratio::new(squared_distance, squared).shape()
                })
            }
            #[inline]
            fn first(&self, squared_distance: f64) -> f64 {
                let squared = self.activation.squared;
                by_range(squared_distance, squared, f64::NEG_INFINITY, || {
                    $scale(self.activation)[1] * Ratio::new(squared_distance, squared).shape_first()
                })
            }
            #[inline]
            fn second(&self, squared_distance: f64) -> f64 {
                let squared = self.activation.squared;
                by_range(squared_distance, squared, f64::INFINITY, || {
                    $scale(self.activation)[2] * Ratio::new(squared_distance, squared).shape_second()
                })
            }
            #[inline]
            fn first_and_second(&self, squared_distance: f64) -> [f64; 2] {
                let squared = self.activation.squared;
                if !matches!(range(squared_distance, squared), Range::Active) {
                    return [self.first(squared_distance), self.second(squared_distance)];
                }
                let ratio = Ratio::new(squared_distance, squared);
                let [_, first, second] = $scale(self.activation);
                [first * ratio.shape_first(), second * ratio.shape_second()]
            }
        }

        impl $barrier {
            /// The barrier that is active below `activation_distance` d̂ \[m\].
            ///
            /// # Errors
            /// If d̂ is not a number between 1e-60 and 1e60.
            pub fn new(activation_distance: f64) -> Result<Self, ContactError> {
                Ok(Self { activation: Activation::new(activation_distance)? })
            }
        }

        widen!($barrier);
    };
}

macro_rules! widen {
    ($barrier:ident) => {
        impl Widen for $barrier {
            fn with_activation_squared(mut self, activation_squared: f64) -> Self {
                self.activation.squared = activation_squared;
                self
            }
            fn activation_distance(&self) -> f64 {
                self.activation.distance
            }
        }
    };
}

/// b = −(s − ŝ)² ln(s/ŝ), ŝ = d̂² \[m⁴\]; κ in N/m³.
///
/// # Reference
/// Li et al. 2020, eq. 6, applied to squared distances, as in their implementation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SquaredDistanceBarrier {
    activation: Activation,
}

squared_shape!(SquaredDistanceBarrier, |a: Activation| [a.squared * a.squared, a.squared, 1.0]);

/// b = −d̂ (s/ŝ − 1)² ln(s/ŝ), ŝ = d̂² \[m\]: a number without unit times d̂, so that the energy of a weight in m² is
/// that of a layer of thickness d̂ with the energy density κ (−u² L), κ in Pa.
///
/// # Reference
/// M. Li, Z. Ferguson, T. Schneider, T. Langlois, D. Zorin, D. Panozzo, C. Jiang, D. M. Kaufman, *Convergent
/// Incremental Potential Contact*, arXiv 2307.15908, 2023: physical units and area weights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhysicalBarrier {
    activation: Activation,
}

squared_shape!(PhysicalBarrier, |a: Activation| {
    [a.distance, a.distance / a.squared, a.distance / (a.squared * a.squared)]
});

/// b = −(d − d̂)² ln(d/d̂) with d = √s \[m²\]; κ in N/m.
///
/// With ρ = d/d̂, υ = ρ − 1 = u/(1 + ρ) and Λ = ln ρ = L/2 the shape −υ² Λ has the derivatives of the
/// [module](self) page with respect to ρ, f₁ < 0 and f₂ > 0, and by the chain rule ∂d/∂s = 1/(2d)
///
/// - b′ = d̂ f₁ / (2 d)
/// - b″ = (f₂ − f₁/ρ) / (4 s), a sum of two positive terms.
///
/// # Reference
/// Li et al. 2020, eq. 6.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistanceBarrier {
    activation: Activation,
}

impl DistanceBarrier {
    /// The barrier that is active below `activation_distance` d̂ \[m\].
    ///
    /// # Errors
    /// If d̂ is not a number between 1e-60 and 1e60.
    pub fn new(activation_distance: f64) -> Result<Self, ContactError> {
        Ok(Self { activation: Activation::new(activation_distance)? })
    }

    /// The same for d/d̂.
    #[inline(always)]
    fn ratio(&self, squared_distance: f64) -> Ratio {
        let of_squares = Ratio::new(squared_distance, self.activation.squared);
        let r = of_squares.r.sqrt();
        Ratio { r, u: of_squares.u / (1.0 + r), ln: 0.5 * of_squares.ln }
    }

    #[inline(always)]
    fn first_of(&self, ratio: Ratio) -> f64 {
        0.5 * ratio.shape_first() / ratio.r
    }

    #[inline(always)]
    fn second_of(&self, ratio: Ratio, squared_distance: f64) -> f64 {
        0.25 * (ratio.shape_second() - ratio.shape_first() / ratio.r) / squared_distance
    }
}

impl Barrier for DistanceBarrier {
    #[inline]
    fn activation_squared(&self) -> f64 {
        self.activation.squared
    }
    #[inline]
    fn value(&self, squared_distance: f64) -> f64 {
        let squared = self.activation.squared;
        by_range(squared_distance, squared, f64::INFINITY, || squared * self.ratio(squared_distance).shape())
    }
    #[inline]
    fn first(&self, squared_distance: f64) -> f64 {
        by_range(squared_distance, self.activation.squared, f64::NEG_INFINITY, || {
            self.first_of(self.ratio(squared_distance))
        })
    }
    #[inline]
    fn second(&self, squared_distance: f64) -> f64 {
        by_range(squared_distance, self.activation.squared, f64::INFINITY, || {
            self.second_of(self.ratio(squared_distance), squared_distance)
        })
    }
    #[inline]
    fn first_and_second(&self, squared_distance: f64) -> [f64; 2] {
        if !matches!(range(squared_distance, self.activation.squared), Range::Active) {
            return [self.first(squared_distance), self.second(squared_distance)];
        }
        let ratio = self.ratio(squared_distance);
        [self.first_of(ratio), self.second_of(ratio, squared_distance)]
    }
}

widen!(DistanceBarrier);

/// A barrier that is infinite already at the distance d_min: surfaces with a thickness.
///
/// The barrier b is evaluated at s − d_min² with the activation ŝ = 2 d_min d̂ + d̂² = (d_min + d̂)² − d_min²: it is
/// active below d = d_min + d̂ and infinite at d = d_min. Scales that belong to d̂ (the factor d̂ of
/// [`PhysicalBarrier`]) stay. Of [`DistanceBarrier`] the argument is √(s − d_min²), not d − d_min. A gap g = d − d_min is
/// known through s to about ε d_min, so relative errors grow to ε d_min/g when g is small.
///
/// # Reference
/// M. Li, D. M. Kaufman, C. Jiang, *Codimensional Incremental Potential Contact*, ACM Trans. Graph. 40(4), 2021: the
/// barrier of objects with a thickness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MinimumSeparation<B> {
    barrier: B,
    squared: f64,
}

impl<B: Widen> MinimumSeparation<B> {
    /// `barrier`, shifted outwards by `separation` d_min \[m\].
    ///
    /// # Errors
    /// If d_min is negative, NaN or above 1e60.
    pub fn new(barrier: B, separation: f64) -> Result<Self, ContactError> {
        if !(0.0..=SMALLEST_DISTANCE.recip()).contains(&separation) {
            return Err(ContactError::MinimumSeparation { distance: separation });
        }
        let activation = barrier.activation_distance();
        let barrier = barrier.with_activation_squared(activation * (2.0 * separation + activation));
        Ok(Self { barrier, squared: separation * separation })
    }
}

impl<B: Barrier> Barrier for MinimumSeparation<B> {
    #[inline]
    fn activation_squared(&self) -> f64 {
        self.squared + self.barrier.activation_squared()
    }
    #[inline]
    fn value(&self, squared_distance: f64) -> f64 {
        self.barrier.value(squared_distance - self.squared)
    }
    #[inline]
    fn first(&self, squared_distance: f64) -> f64 {
        self.barrier.first(squared_distance - self.squared)
    }
    #[inline]
    fn second(&self, squared_distance: f64) -> f64 {
        self.barrier.second(squared_distance - self.squared)
    }
    #[inline]
    fn first_and_second(&self, squared_distance: f64) -> [f64; 2] {
        self.barrier.first_and_second(squared_distance - self.squared)
    }
}
