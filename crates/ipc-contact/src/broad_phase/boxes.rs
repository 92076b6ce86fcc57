//! Boxes around points that move on straight lines, rounded outwards.

use crate::error::ContactError;
use mechanics_core::parallel;
use mechanics_core::tensor::Vec3;

/// Points of a parallel part.
const CHUNK: usize = 2048;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    pub(super) low: [f64; 3],
    pub(super) high: [f64; 3],
}

impl Bounds {
    /// Overlaps nothing, not even itself.
    pub(super) const NOTHING: Self = Self { low: [f64::NAN; 3], high: [f64::NAN; 3] };

    /// The box of a point on the way from `a` to `b`, larger by `inflation` on all sides.
    ///
    /// The exact box is inside: one rounding of each bound moves it by half a unit in the last place at most, and the
    /// bound is then moved outwards by a whole one.
    #[inline]
    pub(super) fn of_segment(a: &Vec3, b: &Vec3, inflation: f64) -> Self {
        Self {
            low: std::array::from_fn(|k| (a[k].min(b[k]) - inflation).next_down()),
            high: std::array::from_fn(|k| (a[k].max(b[k]) + inflation).next_up()),
        }
    }

    /// The smallest box around both.
    #[inline]
    pub(super) fn union(&self, other: &Self) -> Self {
        Self {
            low: std::array::from_fn(|k| self.low[k].min(other.low[k])),
            high: std::array::from_fn(|k| self.high[k].max(other.high[k])),
        }
    }

    /// Have the boxes a point in common?
    #[inline(always)]
    pub(super) fn overlaps(&self, other: &Self) -> bool {
        // Without short cuts: most boxes that are asked do overlap.
        let along = |k: usize| (self.low[k] <= other.high[k]) & (other.low[k] <= self.high[k]);
        along(0) & along(1) & along(2)
    }

    /// Is the other box inside this one? Not if a bound is NaN.
    pub(super) fn contains(&self, other: &Self) -> bool {
        (0..3).all(|k| self.low[k] <= other.low[k] && other.high[k] <= self.high[k])
    }

    /// The middle of the box.
    pub(super) fn centre(&self) -> [f64; 3] {
        std::array::from_fn(|k| 0.5 * self.low[k] + 0.5 * self.high[k])
    }
}

/// The boxes of all points on their way from `x0` to `x1`, inflated. Boxes of points that take no part may be
/// anything.
pub(super) fn bounds_into(
    boxes: &mut Vec<Bounds>,
    vertices: &[u32],
    x0: &[Vec3],
    x1: &[Vec3],
    inflation: f64,
) -> Result<(), ContactError> {
    if !(inflation >= 0.0 && inflation.is_finite()) {
        return Err(ContactError::BadInflation { inflation });
    }
    let culprits = parallel::map_chunks(vertices.len(), CHUNK, |range| {
        range.map(|v| vertices[v] as usize).find(|&p| !(is_finite(&x0[p]) && is_finite(&x1[p])))
    });
    if let Some(&point) = culprits.iter().flatten().next() {
        let position = if is_finite(&x0[point]) { x1[point] } else { x0[point] };
        return Err(ContactError::NonFinite { point, position: position.into() });
    }
    boxes.resize(x0.len(), Bounds::NOTHING);
    parallel::map_into(boxes, CHUNK, |p| Bounds::of_segment(&x0[p], &x1[p], inflation));
    Ok(())
}

/// Is the position a position?
pub(super) fn is_finite(x: &Vec3) -> bool {
    x.iter().all(|c| c.is_finite())
}
