//! A number that keeps track of the arguments it was made from.
//!
//! Formulas run on [`Trace`] once to find out which arguments they mention, and of which degree in the velocities
//! their terms are. The answer errs on the safe side only:
//!
//! - what cancels (v − v) is still mentioned, but a product with the constant zero mentions nothing;
//! - [`select`](Scalar::select) mentions what both branches and the comparison mention;
//! - a formula that turns a comparison into control flow ([`Mask::any`], [`Mask::all`], `==`) has branches that were not
//!   seen: it is taken to mention everything.

use crate::system::Dependence;
use mechanics_core::scalar::{Mask, Scalar};
use std::cell::Cell;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// Arguments that a window of the tracer tells apart; larger systems take several passes.
const WINDOW: usize = 64;

thread_local! {
    /// Whether a comparison of arguments has become control flow since [`watched`] began.
    static BRANCHED: Cell<bool> = const { Cell::new(false) };
}

/// A set of arguments. Bit k of `q` and `v` is coordinate k of the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Mentions {
    q: u64,
    v: u64,
    /// Any coordinate, in the window or not.
    coordinate: bool,
    /// Any velocity, in the window or not.
    velocity: bool,
    time: bool,
}

impl Mentions {
    const NOTHING: Self = Self { q: 0, v: 0, coordinate: false, velocity: false, time: false };
    const EVERYTHING: Self = Self { q: u64::MAX, v: u64::MAX, coordinate: true, velocity: true, time: true };

    fn union(self, other: Self) -> Self {
        Self {
            q: self.q | other.q,
            v: self.v | other.v,
            coordinate: self.coordinate | other.coordinate,
            velocity: self.velocity | other.velocity,
            time: self.time | other.time,
        }
    }

    fn is_nothing(self) -> bool {
        !(self.coordinate | self.velocity | self.time)
    }
}

/// A set of degrees in the velocities: bit k < 3 for terms that are homogeneous of degree k, bit 3 for anything else.
/// The empty set is the constant zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Degrees(u8);

impl Degrees {
    const NONE: Self = Self(0);
    const ZERO: Self = Self(1);
    const ONE: Self = Self(1 << 1);
    const TWO: Self = Self(1 << 2);
    const OTHER: Self = Self(1 << 3);

    fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Degrees of a product: sums of a degree of each.
    fn plus(self, other: Self) -> Self {
        let mut sum = Self::NONE;
        for i in (0..4).filter(|i| self.0 >> i & 1 == 1) {
            // From degree 3 on, and whatever is no polynomial, all is one class.
            let shifted = u32::from(other.0) << i;
            sum.0 |= (shifted & 7) as u8 | if shifted > 7 { Self::OTHER.0 } else { 0 };
        }
        sum
    }

    /// Degrees of a function that is not a polynomial.
    fn of_function(self) -> Self {
        if self.0 & !Self::ZERO.0 == 0 { Self::ZERO } else { Self::OTHER }
    }
}

/// A value, the arguments it was made from, and the degrees in v of its terms.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trace {
    value: f64,
    mentions: Mentions,
    degrees: Degrees,
}

impl Trace {
    fn new(value: f64, mentions: Mentions, degrees: Degrees) -> Self {
        // Without arguments it is a constant, whatever it was computed from.
        let degrees = match mentions.is_nothing() {
            true if value == 0.0 => Degrees::NONE,
            true => Degrees::ZERO,
            false => degrees,
        };
        Self { value, mentions, degrees }
    }

    fn coordinate(value: f64, index: Option<usize>) -> Self {
        let q = index.map_or(0, |k| 1 << k);
        Self::new(value, Mentions { q, coordinate: true, ..Mentions::NOTHING }, Degrees::ZERO)
    }

    fn velocity(value: f64, index: Option<usize>) -> Self {
        let v = index.map_or(0, |k| 1 << k);
        Self::new(value, Mentions { v, velocity: true, ..Mentions::NOTHING }, Degrees::ONE)
    }

    fn time(value: f64) -> Self {
        Self::new(value, Mentions { time: true, ..Mentions::NOTHING }, Degrees::ZERO)
    }

    fn is_zero(self) -> bool {
        self.degrees == Degrees::NONE
    }

    fn spoilt(self) -> Self {
        Self::new(self.value, Mentions::EVERYTHING, Degrees::OTHER)
    }

    fn function(self, value: f64) -> Self {
        Self::new(value, self.mentions, self.degrees.of_function())
    }

    fn function_of_two(self, other: Self, value: f64) -> Self {
        let degrees = self.degrees.union(other.degrees).of_function();
        Self::new(value, self.mentions.union(other.mentions), degrees)
    }

    fn power(self, value: f64, exponent: i32) -> Self {
        match exponent {
            0 => Self::constant(1.0),
            1 => self,
            2 => Self::new(value, self.mentions, self.degrees.plus(self.degrees)),
            _ => self.function(value),
        }
    }
}

impl Add for Trace {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let degrees = self.degrees.union(other.degrees);
        Self::new(self.value + other.value, self.mentions.union(other.mentions), degrees)
    }
}

impl Neg for Trace {
    type Output = Self;
    fn neg(self) -> Self {
        Self { value: -self.value, ..self }
    }
}

impl Sub for Trace {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Trace {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        if self.is_zero() || other.is_zero() {
            return Self::constant(0.0);
        }
        let degrees = self.degrees.plus(other.degrees);
        Self::new(self.value * other.value, self.mentions.union(other.mentions), degrees)
    }
}

impl Div for Trace {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        if self.is_zero() {
            return Self::constant(0.0);
        }
        let degrees = self.degrees.plus(other.degrees.of_function());
        Self::new(self.value / other.value, self.mentions.union(other.mentions), degrees)
    }
}

macro_rules! assigning {
    ($($trait:ident $method:ident $operator:tt),*) => { $(
        impl $trait for Trace {
            fn $method(&mut self, other: Self) {
                *self = *self $operator other;
            }
        }
    )* };
}

assigning!(AddAssign add_assign +, SubAssign sub_assign -, MulAssign mul_assign *, DivAssign div_assign /);

/// `==` decides control flow.
impl PartialEq for Trace {
    fn eq(&self, other: &Self) -> bool {
        Question::about(*self, *other, f64::eq).decided()
    }
}

/// The answer to a comparison, and the arguments that were compared.
#[derive(Clone, Copy, Debug)]
pub(super) struct Question {
    truth: bool,
    mentions: Mentions,
}

impl Question {
    fn about(left: Trace, right: Trace, compare: impl FnOnce(&f64, &f64) -> bool) -> Self {
        Self { truth: compare(&left.value, &right.value), mentions: left.mentions.union(right.mentions) }
    }

    /// Hands the truth to control flow.
    fn decided(self) -> bool {
        if !self.mentions.is_nothing() {
            BRANCHED.set(true);
        }
        self.truth
    }
}

impl Mask for Question {
    fn and(self, other: Self) -> Self {
        Self { truth: self.truth & other.truth, mentions: self.mentions.union(other.mentions) }
    }
    fn or(self, other: Self) -> Self {
        Self { truth: self.truth | other.truth, mentions: self.mentions.union(other.mentions) }
    }
    fn not(self) -> Self {
        Self { truth: !self.truth, ..self }
    }
    fn any(self) -> bool {
        self.decided()
    }
    fn all(self) -> bool {
        self.decided()
    }
}

macro_rules! functions {
    ($($name:ident),*) => { $(
        fn $name(self) -> Self {
            self.function(f64::$name(self.value))
        }
    )* };
}

impl Scalar for Trace {
    type Mask = Question;
    type Value = Self;
    const EPSILON: f64 = f64::EPSILON;
    const MIN_POSITIVE: f64 = f64::MIN_POSITIVE;
    // Derivatives are what the formula is traced for, so it must take the branch that jets take.
    const DIFFERENTIATES: bool = true;

    fn value(self) -> Self {
        self
    }
    fn lift(value: Self) -> Self {
        value
    }
    fn constant(value: f64) -> Self {
        Self::new(value, Mentions::NOTHING, Degrees::ZERO)
    }

    functions!(sqrt, exp, exp_m1, ln, ln_1p, sin, cos, tan, asin, acos, sinh, cosh, tanh, abs);

    fn atan2(self, x: Self) -> Self {
        self.function_of_two(x, self.value.atan2(x.value))
    }
    fn powi(self, exponent: i32) -> Self {
        self.power(self.value.powi(exponent), exponent)
    }
    fn powf(self, exponent: f64) -> Self {
        let whole = exponent as i32;
        let value = self.value.powf(exponent);
        if f64::from(whole) == exponent { self.power(value, whole) } else { self.function(value) }
    }
    fn reciprocal_power_of_two(self) -> Self {
        self.function(self.value.reciprocal_power_of_two())
    }
    fn copysign(self, sign: Self) -> Self {
        self.function_of_two(sign, self.value.copysign(sign.value))
    }
    fn less(self, other: Self) -> Question {
        Question::about(self, other, f64::lt)
    }
    fn less_equal(self, other: Self) -> Question {
        Question::about(self, other, f64::le)
    }
    fn is_finite(self) -> Question {
        Question::about(self, self, |x, _| x.is_finite())
    }
    fn select(mask: Question, yes: Self, no: Self) -> Self {
        let taken = if mask.truth { yes } else { no };
        if mask.mentions.is_nothing() {
            return taken;
        }
        let both = yes.degrees.union(no.degrees);
        let degrees = if mask.mentions.velocity { both.union(Degrees::OTHER) } else { both };
        Self::new(taken.value, yes.mentions.union(no.mentions).union(mask.mentions), degrees)
    }
}

/// The four formulas of a Lagrangian, evaluated on [`Trace`].
pub(super) trait Formulas {
    fn kinetic(&self, q: &[Trace], v: &[Trace], t: Trace) -> Trace;
    fn potential(&self, q: &[Trace], t: Trace) -> Trace;
    fn rayleigh(&self, q: &[Trace], v: &[Trace], t: Trace) -> Trace;
    fn force(&self, q: &[Trace], v: &[Trace], t: Trace) -> Vec<Trace>;
}

/// Runs a formula; if comparisons of arguments became control flow in it, its results mention everything.
fn watched(formula: impl FnOnce() -> Vec<Trace>) -> Vec<Trace> {
    BRANCHED.set(false);
    let mut results = formula();
    if BRANCHED.get() {
        results.iter_mut().for_each(|result| *result = result.spoilt());
    }
    results
}

/// What `formulas` mention at (t, q, v), [`WINDOW`] coordinates at a time.
pub(super) fn dependence(formulas: &impl Formulas, t: f64, q: &[f64], v: &[f64]) -> Dependence {
    let n = q.len();
    let mut found = Dependence {
        kinetic_on_q: vec![false; n],
        potential_on_q: vec![false; n],
        applied_on: vec![false; n],
        kinetic_on_time: false,
        potential_on_time: false,
        kinetic_quadratic: false,
    };
    // One window even without coordinates, because formulas may mention time.
    for start in (0..n.max(1)).step_by(WINDOW) {
        add_window(formulas, start, (t, q, v), &mut found);
    }
    found
}

fn add_window(
    formulas: &impl Formulas,
    start: usize,
    (t, q, v): (f64, &[f64], &[f64]),
    found: &mut Dependence,
) {
    let bit = |i: usize| (start..start + WINDOW).contains(&i).then(|| i - start);
    let coordinates: Vec<Trace> = q.iter().enumerate().map(|(i, &x)| Trace::coordinate(x, bit(i))).collect();
    let velocities: Vec<Trace> = v.iter().enumerate().map(|(i, &x)| Trace::velocity(x, bit(i))).collect();
    let (q, v, t) = (&coordinates[..], &velocities[..], Trace::time(t));

    let kinetic = watched(|| vec![formulas.kinetic(q, v, t)])[0];
    let potential = watched(|| vec![formulas.potential(q, t)])[0];
    let lost = watched(|| vec![formulas.rayleigh(q, v, t)])[0];
    let force = watched(|| formulas.force(q, v, t));
    let applied = force.iter().fold(lost.mentions, |all, f| all.union(f.mentions));

    for i in start..q.len().min(start + WINDOW) {
        let has = |set: u64| set >> (i - start) & 1 == 1;
        found.kinetic_on_q[i] = has(kinetic.mentions.q);
        found.potential_on_q[i] = has(potential.mentions.q);
        found.applied_on[i] = has(applied.q | applied.v) || !force[i].is_zero();
    }
    found.kinetic_on_time = kinetic.mentions.time;
    found.potential_on_time = potential.mentions.time;
    found.kinetic_quadratic = kinetic.degrees == Degrees::TWO;
}
