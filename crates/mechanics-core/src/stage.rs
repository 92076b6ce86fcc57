//! Time in one place: what a term of the incremental potential may know of the time step.
//!
//! Every implicit scheme of this workspace minimises inertia `½ c ‖x − x̃‖²_M` plus the other terms over the end
//! positions `x`, and reads the end velocity as the affine function `v(x) = a (x − x̂)`. The two numbers `c` and `a`
//! and the two arrays `x̃` and `x̂` are all that differs between schemes. Friction and damping read the velocity
//! only through [`Scheme::velocity`]; no other term knows the step size.

use crate::tensor::Vec3;

/// The numbers `c` and `a` of an implicit scheme with step `h`: inertia `½ c ‖x − x̃‖²_M`, velocity `a (x − x̂)`.
///
/// | scheme | c | a | x̃ | x̂ |
/// |---|---|---|---|---|
/// | statics | 0 | 1 | not read | start |
/// | backward Euler | 1/h² | 1/h | xₙ + h vₙ | xₙ |
/// | BDF2 (Curtiss, Hirschfelder 1952) | 9/(4h²) | 3/(2h) | ⅓(4xₙ − xₙ₋₁) + ⅔h · ⅓(4vₙ − vₙ₋₁) | ⅓(4xₙ − xₙ₋₁) |
/// | average acceleration (Newmark 1959, β = ¼, γ = ½) | 4/h² | 2/h | xₙ + h vₙ + ¼h² aₙ | xₙ + ½h vₙ |
///
/// The last row follows from `xₙ₊₁ = xₙ + h vₙ + ¼h²(aₙ + aₙ₊₁)` solved for `aₙ₊₁` and
/// `vₙ₊₁ = vₙ + ½h(aₙ + aₙ₊₁)` with it inserted, which gives `vₙ₊₁ = (2/h)(xₙ₊₁ − xₙ) − vₙ`. The BDF2 row is the
/// formula `yₙ₊₁ = ⅓(4yₙ − yₙ₋₁) + ⅔h ẏₙ₊₁` applied to positions and to velocities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coefficients {
    /// Factor of the inertia, `c` [1/s²]; zero in statics.
    pub inertia: f64,
    /// Factor of the velocity, `a` [1/s]; one (without unit) in statics, so that "velocities" are displacements.
    pub velocity: f64,
}

impl Coefficients {
    /// No inertia; displacements \[m\] take the place of velocities.
    pub const STATICS: Self = Self { inertia: 0.0, velocity: 1.0 };

    /// Backward Euler with step `h` \[s\].
    pub fn backward_euler(h: f64) -> Self {
        Self { inertia: 1.0 / (h * h), velocity: 1.0 / h }
    }

    /// Second-order backward differentiation with constant step `h` \[s\].
    pub fn bdf2(h: f64) -> Self {
        Self { inertia: 9.0 / (4.0 * h * h), velocity: 3.0 / (2.0 * h) }
    }

    /// Whether they are what a scheme with a positive step (or statics) has: finite, `c ≥ 0`, `a > 0`.
    pub fn are_valid(&self) -> bool {
        let Self { inertia: c, velocity: a } = *self;
        c.is_finite() && c >= 0.0 && a.is_finite() && a > 0.0
    }

    /// Newmark's average acceleration (β = ¼, γ = ½) with step `h` \[s\].
    pub fn average_acceleration(h: f64) -> Self {
        Self { inertia: 4.0 / (h * h), velocity: 2.0 / h }
    }
}

/// An implicit scheme at one time step: its coefficients and its two position arrays, one entry per *point*.
#[derive(Clone, Copy, Debug)]
pub struct Scheme<'a> {
    /// The numbers `c` and `a`.
    pub coefficients: Coefficients,
    /// Positions that inertia pulls to, `x̃` \[m\].
    pub inertial_target: &'a [Vec3],
    /// Positions at which the end velocity is zero, `x̂` \[m\].
    pub velocity_origin: &'a [Vec3],
}

impl<'a> Scheme<'a> {
    /// A scheme from its parts.
    ///
    /// # Panics
    /// If the arrays differ in length.
    pub fn new(coefficients: Coefficients, inertial_target: &'a [Vec3], velocity_origin: &'a [Vec3]) -> Self {
        assert_eq!(inertial_target.len(), velocity_origin.len(), "x̃ and x̂ hold one position per point");
        Self { coefficients, inertial_target, velocity_origin }
    }

    /// Statics: no inertia, and "velocities" are displacements from `start` \[m\].
    pub fn statics(start: &'a [Vec3]) -> Self {
        Self::new(Coefficients::STATICS, start, start)
    }

    /// The end velocity of a point at `x`: `a (x − x̂)` [m/s], a displacement \[m\] in statics.
    ///
    /// # Panics
    /// If `point` is out of range.
    #[inline]
    pub fn velocity(&self, point: usize, x: &Vec3) -> Vec3 {
        (x - self.velocity_origin[point]) * self.coefficients.velocity
    }
}

/// When a term is asked to freeze.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Moment {
    /// Once at the start of a time step.
    Step,
    /// At the start of every lag iteration: lagged data (normal forces, sliding bases) is refreshed here.
    Lag,
    /// Where lagged data is to be that of the points, whatever it was before: no average, and no question whether it has settled.
    Settling,
    /// Before every Newton iteration: stiffnesses and multipliers may change here, lagged data may not.
    Iteration,
}

/// What a term learns when it is asked to freeze: the moment, the points now, and the time step.
#[derive(Clone, Copy, Debug)]
pub struct Stage<'a> {
    /// Why freezing happens.
    pub moment: Moment,
    /// The points now \[m\].
    pub x: &'a [Vec3],
    /// Time at the end of the step \[s\].
    pub time: f64,
    /// Step size `h` \[s\]; zero in statics.
    pub step: f64,
    /// The scheme: the only way to a velocity.
    pub scheme: Scheme<'a>,
}
