//! What is drawn of a Gaussian, and where.

use super::projection::Projection;
use mechanics_core::lanes::{Element, Packet};
use mechanics_core::scalar::Scalar;

/// A Gaussian on the image plane, ready to be drawn.
///
/// With (x, y) from its middle, its opacity at a pixel is o e⁻⁸ˢ,
///
/// s = u² + v²,  u = `across` (x − `slope` y),  v = `down` y,
///
/// the quadratic form ½ (x, y) Σ⁻¹ (x, y)ᵀ = 8 s in Cholesky's factors: y has variance c, x for a given y the mean (b/c) y and the variance
/// det Σ/c, so that `slope` = b/c, `across` = √(c/det Σ)/4, `down` = 1/(4√c). A sum of two squares is never negative, whatever rounding does.
/// It is visible, o e⁻⁸ˢ ≥ 1/255, where s ≤ `reach` = ln(255 o)/8.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Footprint<S> {
    /// \[pixels\]
    pub middle: [S; 2],
    pub slope: S,
    /// \[1/pixel\]
    pub across: S,
    /// 1/`across` \[pixels\]
    pub breadth: S,
    /// \[1/pixel\]
    pub down: S,
    /// The largest s that is visible.
    pub reach: S,
    /// y at the rightmost visible point \[pixels\].
    pub tip: S,
    /// By how much bounds are widened, so that rounding cuts nothing off \[pixels\].
    pub margin: S,
    pub opacity: S,
    /// Red, green, blue.
    pub colour: [S; 3],
    /// \[m\]
    pub depth: S,
}

/// How far from its middle a Gaussian reaches \[pixels\].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent<S> {
    /// To the right and down, as far as it is visible.
    pub visible: [S; 2],
    /// To all sides under the original rules, before it is rounded up.
    pub three_sigma: S,
}

/// How many numbers a footprint has.
pub(crate) const NUMBERS: usize = 14;

impl<S: Copy> Footprint<S> {
    /// All numbers of it in a row.
    #[inline(always)]
    pub(crate) fn numbers(&self) -> [S; NUMBERS] {
        let Self { middle: [x, y], colour: [red, green, blue], slope, across, breadth, down, .. } = *self;
        let Self { reach, tip, margin, .. } = *self;
        [x, y, slope, across, breadth, down, reach, tip, margin, self.opacity, red, green, blue, self.depth]
    }

    /// The footprint whose [`numbers`](Self::numbers) these are.
    #[inline(always)]
    pub(crate) fn from_numbers(numbers: [S; NUMBERS]) -> Self {
        let [x, y, slope, across, breadth, down, reach, tip, margin, opacity, red, green, blue, depth] =
            numbers;
        let (middle, colour) = ([x, y], [red, green, blue]);
        Self { middle, slope, across, breadth, down, reach, tip, margin, opacity, colour, depth }
    }
}

impl<E: Element> Footprint<E> {
    /// The same on every lane.
    #[inline(always)]
    pub(crate) fn on_lanes<P: Packet<Element = E>>(&self) -> Footprint<P> {
        let numbers = self.numbers();
        let mut packets = [P::constant(0.0); NUMBERS];
        for k in 0..NUMBERS {
            packets[k] = P::splat(numbers[k]);
        }
        Footprint::from_numbers(packets)
    }
}

impl<S: Scalar> Footprint<S> {
    /// Of a projected Gaussian; without a colour.
    #[inline(always)]
    pub(crate) fn new(projection: &Projection<S>, opacity: S) -> (Self, Extent<S>) {
        let [a, b, c] = projection.covariance;
        let reach = visible_reach(opacity);
        let (deviation, area) = (c.sqrt(), projection.determinant.sqrt());
        let root = reach.max(S::constant(0.0)).sqrt().scale(4.0);
        let right = root * a.sqrt();
        let below = root * deviation;
        let middle = projection.place;
        let size = middle[0].abs() + middle[1].abs() + right + below;
        let footprint = Self {
            middle,
            slope: b / c,
            across: deviation.scale(0.25) / area,
            breadth: area.scale(4.0) / deviation,
            down: deviation.recip().scale(0.25),
            reach,
            tip: root * b / a.sqrt(),
            margin: size.scale(8.0 * S::EPSILON),
            opacity,
            colour: [S::constant(0.0); 3],
            depth: projection.position[2],
        };
        let visible = [right + footprint.margin, below + footprint.margin];
        (footprint, Extent { visible, three_sigma: projection.reach() })
    }

    /// The interval of x that is visible in the strip `top` ≤ y ≤ `bottom`, all in pixels of the picture; NaN or empty if nothing is.
    ///
    /// x = `slope` y ± `breadth` √(`reach` − (`down` y)²) bounds the visible ellipse. The right side is a concave function of y with its largest value
    /// at `tip`, so in a strip it is largest at the place of the strip that is nearest to the tip; so it is for the left side and −`tip`.
    #[inline(always)]
    pub(crate) fn visible_in_strip(&self, top: S, bottom: S) -> (S, S) {
        let (top, bottom) = (top - self.middle[1] - self.margin, bottom - self.middle[1] + self.margin);
        // A strip that touches the ellipse in its highest point has an argument of the root that may round to a negative one.
        let reach = self.reach.scale(1.0 + 16.0 * S::EPSILON);
        let side = |y: S| {
            let v = self.down * y;
            (reach - v * v).sqrt() * self.breadth
        };
        let (left, right) = ((-self.tip).max(top).min(bottom), self.tip.max(top).min(bottom));
        let from = self.slope.mul_add(left, self.middle[0]) - side(left) - self.margin;
        let to = self.slope.mul_add(right, self.middle[0]) + side(right) + self.margin;
        (from, to)
    }
}

/// ln(255 o)/8: the largest s at which o e⁻⁸ˢ is at least 1/255; negative for what is never visible.
#[inline(always)]
fn visible_reach<S: Scalar>(opacity: S) -> S {
    opacity.scale(255.0).ln().scale(0.125)
}
