//! Roots of scalar equations, lane by lane.

use mechanics_core::jet::Jet1;
use mechanics_core::scalar::{Mask, Scalar};

/// Evaluations at most. Bisection alone would need as many as a number has digits, and it is taken every other time at the least.
const MOST_EVALUATIONS: usize = 120;

/// A root of f in [low, high], where f(low) ≥ 0 ≥ f(high), to the spacing of numbers there; `start` on the lanes that are not `active`.
///
/// Newton's method from `start`, with the derivative from a jet. A step that would leave the bracket, or is not shorter than half of the one
/// before, is replaced by bisection: the bracket is then halved, so that the method ends whatever f does. A lane stops when a step is
/// below 2ε|x|, or f = 0; what it gives does not depend on the other lanes.
///
/// # Reference
/// Dekker (1969), Finding a zero by means of successive linear interpolation, for the combination; here with Newton's step.
#[inline(always)]
pub(crate) fn decreasing_root<S: Scalar>(
    [mut low, mut high]: [S; 2],
    start: S,
    active: S::Mask,
    f: impl Fn(Jet1<S, 1>) -> Jet1<S, 1>,
) -> S {
    let zero = S::constant(0.0);
    let (mut x, mut active) = (start, active);
    let mut last_step = high - low;
    for _ in 0..MOST_EVALUATIONS {
        let y = f(Jet1::variable(x, 0));
        low = S::select(zero.less(y.value), x, low);
        high = S::select(y.value.less(zero), x, high);
        let newton = x - y.value / y.gradient[0];
        let short = (newton - x).abs().less_equal(last_step.abs().scale(0.5));
        let trusted = low.less_equal(newton).and(newton.less_equal(high)).and(short);
        let next = S::select(trusted, newton, (low + high).scale(0.5));
        let found = y.value.less_equal(zero).and(zero.less_equal(y.value));
        last_step = next - x;
        let moves = x.abs().scale(2.0 * S::EPSILON).less(last_step.abs());
        x = S::select(active.and(found.not()), next, x);
        active = active.and(moves).and(found.not());
        if !active.any() {
            break;
        }
    }
    x
}
