//! Events: where a function of the state passes through zero.

use super::DenseStep;
use crate::coordinates::{Coordinates, Phase};
use crate::error::LagrangianError;

/// Which passages through zero count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Direction {
    /// From negative to positive.
    Rising,
    /// From positive to negative.
    Falling,
    /// Both, and touching without passing.
    #[default]
    Any,
}

/// What happens at an event.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Consequence {
    /// It is recorded.
    #[default]
    Record,
    /// It is recorded and ends the integration.
    Stop,
}

/// How a function meets zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Crossing {
    /// From negative to positive.
    Rising,
    /// From positive to negative.
    Falling,
    /// It comes to zero, up to rounding, and goes back to where it was.
    Touching,
}

type Function<'a, C> = dyn FnMut(f64, &C, &C) -> f64 + 'a;

/// A function g(t, q, v) whose zeros along the motion are wanted.
pub struct Event<'a, C> {
    function: Box<Function<'a, C>>,
    direction: Direction,
    consequence: Consequence,
}

impl<'a, C> Event<'a, C> {
    /// All zeros of `function`, recorded.
    pub fn new(function: impl FnMut(f64, &C, &C) -> f64 + 'a) -> Self {
        Self {
            function: Box::new(function),
            direction: Direction::default(),
            consequence: Consequence::default(),
        }
    }

    /// The same, in one direction.
    pub fn in_direction(mut self, direction: Direction) -> Self {
        self.direction = direction;
        self
    }

    /// The same, ending the integration.
    pub fn terminal(mut self) -> Self {
        self.consequence = Consequence::Stop;
        self
    }

    fn wants(&self, crossing: Crossing) -> bool {
        match self.direction {
            Direction::Any => true,
            Direction::Rising => crossing == Crossing::Rising,
            Direction::Falling => crossing == Crossing::Falling,
        }
    }
}

/// An event that has happened.
#[derive(Clone, Debug, PartialEq)]
pub struct Located<C> {
    /// The index of the event in the list handed in.
    pub event: usize,
    /// How its function met zero.
    pub crossing: Crossing,
    /// The state, at or by a rounding error after the zero.
    pub phase: Phase<C>,
}

/// Subintervals of a step at whose ends the functions are looked at.
const PARTS: usize = 8;
/// The part of a subinterval over which slopes are taken.
const SLOPE: f64 = 1.0 / 1024.0;
/// The part of a function's magnitude within a subinterval that counts as touching zero.
const TOUCH: f64 = 1e-10;

/// A function's value, and its change over a small interval, at a time.
#[derive(Clone, Copy, Debug)]
struct Sample {
    time: f64,
    value: f64,
    slope: f64,
}

/// What is known of one event so far.
struct Progress<C> {
    /// The sign of the function before now: zero if it has been zero since the start.
    sign: f64,
    /// A sample at which the function was exactly zero, with nothing but zeros since.
    zero: Option<Phase<C>>,
    value: f64,
}

/// All events of one integration.
pub(super) struct Watch<'e, 'a, C> {
    events: &'e mut [Event<'a, C>],
    progress: Vec<Progress<C>>,
}

/// −1, 0 or 1.
fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

impl<'e, 'a, C: Coordinates> Watch<'e, 'a, C> {
    pub(super) fn start(events: &'e mut [Event<'a, C>], phase: &Phase<C>) -> Result<Self, LagrangianError> {
        let progress = events
            .iter_mut()
            .enumerate()
            .map(|(index, event)| {
                let value = evaluate(event, index, phase)?;
                Ok(Progress { sign: sign(value), zero: None, value })
            })
            .collect::<Result<_, _>>()?;
        Ok(Self { events, progress })
    }

    /// Appends the events within `step`, in order of time, up to the first terminal one, whose state it returns.
    pub(super) fn step(
        &mut self,
        step: &DenseStep<C>,
        after: &Phase<C>,
        located: &mut Vec<Located<C>>,
    ) -> Result<Option<Phase<C>>, LagrangianError> {
        let mut found = Vec::new();
        for (index, (event, progress)) in self.events.iter_mut().zip(&mut self.progress).enumerate() {
            Scan { event, index, step, after }.run(progress, &mut found)?;
        }
        found.sort_by(|a: &Located<C>, b| a.phase.time.total_cmp(&b.phase.time));
        for event in found {
            let stops = self.events[event.event].consequence == Consequence::Stop;
            let phase = stops.then(|| event.phase.clone());
            located.push(event);
            if phase.is_some() {
                return Ok(phase);
            }
        }
        Ok(None)
    }

    /// A function that is exactly zero at the end has arrived there.
    pub(super) fn finish(self, located: &mut Vec<Located<C>>) {
        for (index, (event, progress)) in self.events.iter().zip(self.progress).enumerate() {
            let crossing = if progress.sign < 0.0 { Crossing::Rising } else { Crossing::Falling };
            if let Some(phase) = progress.zero.filter(|_| event.wants(crossing)) {
                located.push(Located { event: index, crossing, phase });
            }
        }
    }
}

/// The function at a state.
fn evaluate<C: Coordinates>(
    event: &mut Event<'_, C>,
    index: usize,
    phase: &Phase<C>,
) -> Result<f64, LagrangianError> {
    let value = (event.function)(phase.time, &phase.q, &phase.v);
    if value.is_finite() { Ok(value) } else { Err(LagrangianError::Event { index, time: phase.time, value }) }
}

/// One event in one step.
struct Scan<'s, 'a, C> {
    event: &'s mut Event<'a, C>,
    index: usize,
    step: &'s DenseStep<C>,
    after: &'s Phase<C>,
}

impl<C: Coordinates> Scan<'_, '_, C> {
    fn at(&mut self, t: f64) -> Result<f64, LagrangianError> {
        evaluate(self.event, self.index, &self.step.at(t))
    }

    fn push(&self, found: &mut Vec<Located<C>>, crossing: Crossing, phase: Phase<C>) {
        if self.event.wants(crossing) {
            found.push(Located { event: self.index, crossing, phase });
        }
    }

    fn run(
        &mut self,
        progress: &mut Progress<C>,
        found: &mut Vec<Located<C>>,
    ) -> Result<(), LagrangianError> {
        let (start, end) = (self.step.start(), self.step.end());
        let part = (end - start) / PARTS as f64;
        let little = SLOPE * part;
        let ahead = self.at(start + little)?;
        let mut left = Sample { time: start, value: progress.value, slope: ahead - progress.value };
        for k in 1..=PARTS {
            let right = if k == PARTS {
                let value = evaluate(self.event, self.index, self.after)?;
                Sample { time: end, value, slope: value - self.at(end - little)? }
            } else {
                let time = start + k as f64 * part;
                let value = self.at(time)?;
                Sample { time, value, slope: value - self.at(time - little)? }
            };
            let from = self.leave_zero(left, little, progress, found)?;
            self.between(from, right, progress, found)?;
            left = right;
        }
        progress.value = left.value;
        Ok(())
    }

    /// If the function is zero at `left`, looks a little ahead to learn on which side it leaves.
    fn leave_zero(
        &mut self,
        left: Sample,
        little: f64,
        progress: &mut Progress<C>,
        found: &mut Vec<Located<C>>,
    ) -> Result<Sample, LagrangianError> {
        if left.value != 0.0 {
            return Ok(left);
        }
        let time = left.time + little;
        let value = self.at(time)?;
        self.resolve_zero(value, progress, found);
        Ok(Sample { time, value, slope: left.slope })
    }

    /// Decides what an exact zero was, once the function is `value` after it.
    fn resolve_zero(&self, value: f64, progress: &mut Progress<C>, found: &mut Vec<Located<C>>) {
        if value == 0.0 {
            return;
        }
        if let Some(phase) = progress.zero.take() {
            let crossing = match (progress.sign < 0.0, value < 0.0) {
                (true, false) => Crossing::Rising,
                (false, true) => Crossing::Falling,
                _ => Crossing::Touching,
            };
            self.push(found, crossing, phase);
        }
        progress.sign = sign(value);
    }

    /// The events in the interval between two samples, its end included.
    fn between(
        &mut self,
        left: Sample,
        right: Sample,
        progress: &mut Progress<C>,
        found: &mut Vec<Located<C>>,
    ) -> Result<(), LagrangianError> {
        if right.value == 0.0 {
            if progress.sign != 0.0 && progress.zero.is_none() {
                progress.zero = Some(self.phase_at(right.time));
            }
        } else if left.value == 0.0 {
            self.resolve_zero(right.value, progress, found);
        } else if sign(left.value) != sign(right.value) {
            self.cross(left, right, found)?;
        } else {
            self.dip(left, right, found)?;
        }
        if right.value != 0.0 {
            progress.sign = sign(right.value);
        }
        Ok(())
    }

    fn phase_at(&self, time: f64) -> Phase<C> {
        if time == self.step.end() { self.after.clone() } else { self.step.at(time) }
    }

    /// The zero between samples of opposite sign.
    fn cross(
        &mut self,
        left: Sample,
        right: Sample,
        found: &mut Vec<Located<C>>,
    ) -> Result<(), LagrangianError> {
        let crossing = if right.value > 0.0 { Crossing::Rising } else { Crossing::Falling };
        let ends = [(left.time, left.value), (right.time, right.value)];
        let time = root(ends, |t| self.at(t))?;
        self.push(found, crossing, self.phase_at(time));
        Ok(())
    }

    /// Between samples of one sign: if the function comes towards zero on the left and goes away on the right, looks at the
    /// extremum between, and finds two zeros, one touch or nothing.
    fn dip(
        &mut self,
        left: Sample,
        right: Sample,
        found: &mut Vec<Located<C>>,
    ) -> Result<(), LagrangianError> {
        let side = sign(left.value);
        if side * left.slope >= 0.0 || side * right.slope <= 0.0 {
            return Ok(());
        }
        let touch = TOUCH * left.value.abs().max(right.value.abs());
        let (time, lowest) = minimum(left.time, right.time, -touch, |t| Ok(side * self.at(t)?))?;
        if lowest.abs() <= touch {
            self.push(found, Crossing::Touching, self.phase_at(time));
        } else if lowest < 0.0 {
            let bottom = Sample { time, value: side * lowest, slope: 0.0 };
            self.cross(left, bottom, found)?;
            self.cross(bottom, right, found)?;
        }
        Ok(())
    }
}

/// A zero of `g` between two points of opposite sign: a point on the side of the second that is a rounding error of the
/// times away from one on the side of the first, or at which g is exactly zero.
///
/// Inverse quadratic interpolation where the three latest points promise that it is monotone, bisection elsewhere.
///
/// # Reference
/// Chandrupatla 1997, "A new hybrid quadratic/bisection algorithm for finding the zero of a nonlinear function without
/// using derivatives", Advances in Engineering Software 28.
fn root(
    [first, second]: [(f64, f64); 2],
    mut g: impl FnMut(f64) -> Result<f64, LagrangianError>,
) -> Result<f64, LagrangianError> {
    let side = sign(second.1);
    let rounding = 2.0 * f64::EPSILON * first.0.abs().max(second.0.abs());
    // `newest` and `other` enclose the zero, `oldest` was dropped last.
    let (mut newest, mut other) = (first, second);
    let mut fraction = 0.5_f64;
    loop {
        let width = other.0 - newest.0;
        let least = rounding / width.abs();
        if least >= 0.5 {
            return Ok(if sign(newest.1) == side { newest.0 } else { other.0 });
        }
        let time = newest.0 + fraction.clamp(least, 1.0 - least) * width;
        let point = (time, g(time)?);
        if point.1 == 0.0 {
            return Ok(time);
        }
        let oldest =
            if sign(point.1) == sign(newest.1) { newest } else { std::mem::replace(&mut other, newest) };
        newest = point;
        fraction = interpolated(newest, other, oldest).unwrap_or(0.5);
    }
}

/// Where between `a` and `b` the inverse quadratic through three points has its zero, if it is monotone there.
fn interpolated(a: (f64, f64), b: (f64, f64), c: (f64, f64)) -> Option<f64> {
    let xi = (a.0 - b.0) / (c.0 - b.0);
    let phi = (a.1 - b.1) / (c.1 - b.1);
    if !(phi * phi < xi && (1.0 - phi).powi(2) < 1.0 - xi) {
        return None;
    }
    let toward_b = a.1 / (b.1 - a.1) * (c.1 / (b.1 - c.1));
    let toward_c = (c.0 - a.0) / (b.0 - a.0) * (a.1 / (c.1 - a.1)) * (b.1 / (c.1 - b.1));
    Some(toward_b + toward_c).filter(|fraction| fraction.is_finite())
}

/// The minimum of a unimodal `g` on an interval by the golden section, to 1e-9 of its length, or the first point found where
/// g is below `enough`.
fn minimum(
    mut a: f64,
    mut b: f64,
    enough: f64,
    mut g: impl FnMut(f64) -> Result<f64, LagrangianError>,
) -> Result<(f64, f64), LagrangianError> {
    const GOLDEN: f64 = 0.618_033_988_749_894_8;
    let (mut left, mut right) = (b - GOLDEN * (b - a), a + GOLDEN * (b - a));
    let (mut at_left, mut at_right) = (g(left)?, g(right)?);
    for _ in 0..42 {
        if at_left.min(at_right) < enough {
            break;
        }
        if at_left <= at_right {
            (b, right, at_right) = (right, left, at_left);
            left = b - GOLDEN * (b - a);
            at_left = g(left)?;
        } else {
            (a, left, at_left) = (left, right, at_right);
            right = a + GOLDEN * (b - a);
            at_right = g(right)?;
        }
    }
    Ok(if at_left <= at_right { (left, at_left) } else { (right, at_right) })
}
