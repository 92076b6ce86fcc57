//! Interval bisection of time and parameters.
//!
//! The polygon of differences is F(t, u, v) = v₀(t) + u e(t) + v f(t) over the unit cube (u + v ≤ 1 for a triangle), linear in
//! each of its arguments. Over a box of arguments it therefore stays within the bounds of its values at the eight
//! corners of the box: an exact inclusion up to rounding, by which the bounds are widened. Where they are farther than
//! the target distance from the origin, the box is free.

use super::sweep::Sweep;
use super::{Impact, Settings};

/// Halvings of one argument at most, so that every bound of a box is an exact binary fraction.
const MAX_DEPTH: i32 = 48;

/// A box of arguments: lower bounds, and how often each argument has been halved.
#[derive(Clone, Copy, Debug)]
struct Cell {
    lower: [f64; 3],
    depth: [i32; 3],
}

/// What is known of F over a cell.
struct Range {
    /// Lower bound on the squared distance from the origin.
    squared_distance: f64,
    /// Per argument: the largest change of a component of F along it.
    change: [f64; 3],
}

/// The earliest time at which the distance may be `target` or less, as far as `tolerance` \[m\] can tell; never later than
/// the true one. `after` is a time up to which the motion is known to be free.
///
/// Boxes are bisected breadth first, in the order of time within a level. A box too small to be bisected further that has
/// no undecided box before it gives the answer; one that has makes all boxes later than itself needless. After
/// `max_boxes` boxes the answer is the earliest undecided time.
pub(super) fn bisect<const K: usize>(
    sweep: &Sweep<K>,
    target: f64,
    tolerance: f64,
    after: f64,
    settings: &Settings,
) -> Impact {
    let map = Map::new(sweep, target);
    let mut level = vec![Cell { lower: [0.0; 3], depth: [0; 3] }];
    let mut cut = f64::INFINITY;
    let mut boxes = 0;
    while !level.is_empty() {
        level.sort_unstable_by(|a, b| a.lower.partial_cmp(&b.lower).unwrap_or(std::cmp::Ordering::Equal));
        let mut undecided: Vec<Cell> = Vec::with_capacity(2 * level.len());
        for cell in &level {
            let time = cell.lower[0];
            if time >= cut {
                break;
            }
            boxes += 1;
            if boxes > settings.max_boxes {
                let earliest = undecided.iter().map(|cell| cell.lower[0]).fold(time, f64::min);
                return Impact::At(earliest.max(after));
            }
            let range = map.range(cell);
            if range.squared_distance > map.squared_target {
                continue;
            }
            match cell.argument_to_halve(&range.change, tolerance) {
                Some(argument) => {
                    undecided.extend(cell.halves(argument).filter(|half| map.is_inside(half, after)))
                }
                None if undecided.is_empty() => return Impact::At(time.max(after)),
                None => {
                    cut = time;
                    break;
                }
            }
        }
        level = undecided;
    }
    if cut.is_finite() { Impact::At(cut.max(after)) } else { Impact::Free }
}

impl Cell {
    fn upper(&self, argument: usize) -> f64 {
        self.lower[argument] + 0.5_f64.powi(self.depth[argument])
    }

    /// The argument along which F changes most; none if that is less than the tolerance, or as fine as it gets.
    fn argument_to_halve(&self, change: &[f64; 3], tolerance: f64) -> Option<usize> {
        let mut chosen = None;
        let mut most = tolerance;
        for argument in 0..3 {
            if change[argument] > most && self.depth[argument] < MAX_DEPTH {
                (chosen, most) = (Some(argument), change[argument]);
            }
        }
        chosen
    }

    /// Both halves along an argument, the lower one first.
    fn halves(&self, argument: usize) -> impl Iterator<Item = Self> + use<> {
        let mut low = *self;
        low.depth[argument] += 1;
        let mut high = low;
        high.lower[argument] = low.upper(argument);
        [low, high].into_iter()
    }
}

/// F with the bound on the rounding of its components.
struct Map<'a, const K: usize> {
    sweep: &'a Sweep<K>,
    rounding: f64,
    squared_target: f64,
}

impl<'a, const K: usize> Map<'a, K> {
    /// Let M be the largest absolute component of a corner at either end and u = 2⁻⁵³. A corner at t is within 5 u M of
    /// the exact one, an edge e or f within 12 u M, u e within 14 u M, and the sum of the three within 41 u M.
    fn new(sweep: &'a Sweep<K>, target: f64) -> Self {
        let largest = sweep.start_size.max(sweep.end_size);
        let rounding = 24.0 * f64::EPSILON * largest + 64.0 * f64::MIN_POSITIVE;
        Self { sweep, rounding, squared_target: target * target * (1.0 + 8.0 * f64::EPSILON) }
    }

    /// Whether a cell has a part in the domain, later than `after`.
    fn is_inside(&self, cell: &Cell, after: f64) -> bool {
        cell.upper(0) > after && (K != 3 || cell.lower[1] + cell.lower[2] <= 1.0)
    }

    #[inline]
    fn range(&self, cell: &Cell) -> Range {
        let mut values = [[[0.0; 3]; 4]; 2];
        for (end, time) in [cell.lower[0], cell.upper(0)].into_iter().enumerate() {
            let v = self.sweep.at(time);
            for corner in 0..4 {
                let u = if corner & 1 == 0 { cell.lower[1] } else { cell.upper(1) };
                let w = if corner & 2 == 0 { cell.lower[2] } else { cell.upper(2) };
                for c in 0..3 {
                    let mut value = v[0][c];
                    if K > 1 {
                        value += u * (v[1][c] - v[0][c]);
                    }
                    if K > 2 {
                        value += w * (v[K - 1][c] - v[0][c]);
                    }
                    values[end][corner][c] = value;
                }
            }
        }
        self.bounds(&values)
    }

    #[inline]
    fn bounds(&self, values: &[[[f64; 3]; 4]; 2]) -> Range {
        let mut squared_distance = 0.0;
        let mut change = [0.0_f64; 3];
        for c in 0..3 {
            let at = |end: usize, corner: usize| values[end][corner][c];
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for corner in 0..4 {
                low = low.min(at(0, corner)).min(at(1, corner));
                high = high.max(at(0, corner)).max(at(1, corner));
                change[0] = change[0].max((at(1, corner) - at(0, corner)).abs());
            }
            for end in 0..2 {
                change[1] =
                    change[1].max((at(end, 1) - at(end, 0)).abs()).max((at(end, 3) - at(end, 2)).abs());
                change[2] =
                    change[2].max((at(end, 2) - at(end, 0)).abs()).max((at(end, 3) - at(end, 1)).abs());
            }
            let outside = (low - self.rounding).max(-high - self.rounding).max(0.0);
            squared_distance += outside * outside;
        }
        Range { squared_distance: squared_distance * (1.0 - 8.0 * f64::EPSILON), change }
    }
}
