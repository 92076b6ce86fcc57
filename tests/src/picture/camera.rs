//! Where the picture is taken from.

use super::image::Size;

/// A box with edges along the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Its least corner.
    pub low: [f64; 3],
    /// Its greatest corner.
    pub high: [f64; 3],
}

impl Bounds {
    /// The least box around `points`; `None` when there is none.
    pub fn of(points: impl Iterator<Item = [f64; 3]>) -> Option<Self> {
        points.fold(None, |found: Option<Self>, p| {
            let Self { low, high } = found.unwrap_or(Self { low: p, high: p });
            let along = |axis: usize| (low[axis].min(p[axis]), high[axis].max(p[axis]));
            Some(Self { low: [0, 1, 2].map(|a| along(a).0), high: [0, 1, 2].map(|a| along(a).1) })
        })
    }

    fn centre(&self) -> [f64; 3] {
        [0, 1, 2].map(|a| 0.5 * self.low[a] + 0.5 * self.high[a])
    }

    /// Half the diagonal: the radius of the ball around the box.
    fn radius(&self) -> f64 {
        (0..3).map(|a| (0.5 * self.high[a] - 0.5 * self.low[a]).powi(2)).sum::<f64>().sqrt()
    }

    fn corners(&self) -> [[f64; 3]; 8] {
        std::array::from_fn(|i| [0, 1, 2].map(|a| if i >> a & 1 == 0 { self.low[a] } else { self.high[a] }))
    }
}

/// How depth is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lens {
    /// Parallel rays: lengths can be compared all over the picture.
    Orthographic,
    /// Rays through one point; the vertical angle of view \[degrees\], held to 5–120.
    Perspective(f64),
}

/// A camera that looks along a direction and frames what it sees.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// From the scene towards the camera; need not be a unit vector.
    pub towards: [f64; 3],
    /// What is up in the picture.
    pub up: [f64; 3],
    /// How depth is shown.
    pub lens: Lens,
    /// The box that fills the picture; `None` takes the scene's own. Give it for films, or the camera breathes.
    pub frame: Option<Bounds>,
}

impl Default for Camera {
    fn default() -> Self {
        Self { towards: [0.55, -1.0, 0.45], up: [0.0, 0.0, 1.0], lens: Lens::Perspective(28.0), frame: None }
    }
}

/// A camera in place: it maps positions to pixels and depths.
#[derive(Clone, Debug)]
pub(super) struct View {
    /// Rows: right, up, towards the camera; orthonormal.
    axes: [[f64; 3]; 3],
    centre: [f64; 3],
    /// Pixels a unit of length: at the centre's depth.
    scale: f64,
    middle: [f64; 2],
    /// Distance of the eye from the centre; infinite when orthographic.
    distance: f64,
    /// Half the extent of what is framed.
    radius: f64,
}

/// A position in the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Seen {
    /// Pixels from the left.
    pub(super) x: f64,
    /// Pixels from the top.
    pub(super) y: f64,
    /// Larger is farther; linear in the picture along straight edges (so that it can be interpolated there).
    pub(super) depth: f64,
    /// Pixels a unit of length at this depth.
    pub(super) scale: f64,
}

impl Camera {
    /// This camera, framing `bounds` whatever the scene is.
    pub fn framing(self, bounds: Bounds) -> Self {
        Self { frame: Some(bounds), ..self }
    }

    /// The camera put so that `bounds` fills the part of a picture of `size` pixels that lies left of `right_margin`.
    pub(super) fn view(&self, bounds: Bounds, size: Size, right_margin: f64) -> View {
        let towards = unit(self.towards).unwrap_or([0.0, -1.0, 0.0]);
        // Looking along `up` itself, any other direction serves.
        let right = [self.up, [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]
            .into_iter()
            .find_map(|up| unit(cross(up, towards)))
            .unwrap_or([1.0, 0.0, 0.0]);
        let axes = [right, cross(towards, right), towards];
        let (width, height) = ((size.width as f64 - right_margin).max(1.0), size.height as f64);
        let centre = bounds.centre();
        let radius = bounds.radius();
        let radius = if radius > 0.0 && radius.is_finite() { radius } else { 1.0 };
        let distance = match self.lens {
            Lens::Orthographic => f64::INFINITY,
            Lens::Perspective(angle) => {
                let angle = if angle.is_finite() { angle.clamp(5.0, 120.0) } else { 28.0 };
                // The eye stays outside the ball around the box.
                1.1 * radius / (0.5 * angle.to_radians()).sin()
            }
        };
        let mut view = View { axes, centre, scale: 1.0, middle: [0.0; 2], distance, radius };
        view.fill(&bounds, width, height);
        view
    }
}

/// Share of the picture that the scene leaves free at each side.
const BORDER: f64 = 0.08;

impl View {
    /// Chooses scale and middle so that the corners of `bounds` fill the picture but for its border.
    fn fill(&mut self, bounds: &Bounds, width: f64, height: f64) {
        let corners: Vec<Seen> = bounds.corners().iter().filter_map(|corner| self.seen(*corner)).collect();
        let range = |of: fn(&Seen) -> f64| {
            let all = corners.iter().map(of);
            all.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)))
        };
        let ((left, right), (top, bottom)) = (range(|seen| seen.x), range(|seen| seen.y));
        let room = 1.0 - 2.0 * BORDER;
        let fit =
            |pixels: f64, extent: f64| if extent > 0.0 { room * pixels / extent } else { f64::INFINITY };
        let scale = fit(width, right - left).min(fit(height, bottom - top));
        let scale = if scale.is_finite() { scale } else { room * width.min(height) / (2.0 * self.radius) };
        self.scale = scale;
        self.middle =
            [0.5 * width - 0.5 * scale * (left + right), 0.5 * height - 0.5 * scale * (top + bottom)];
    }

    /// Where `position` is in the picture; `None` for one behind the eye or too near to it.
    pub(super) fn seen(&self, position: [f64; 3]) -> Option<Seen> {
        let offset = [0, 1, 2].map(|a| position[a] - self.centre[a]);
        let [x, y, z] = self.axes.map(|axis| dot(axis, offset));
        let (shrink, depth) = if self.distance.is_finite() {
            let before = self.distance - z;
            if before < 0.02 * self.distance {
                return None;
            }
            // 1/before is linear in the picture; negated, larger is farther.
            (self.distance / before, -self.distance / before)
        } else {
            (1.0, -z / self.radius)
        };
        let scale = self.scale * shrink;
        let seen = Seen { x: self.middle[0] + scale * x, y: self.middle[1] - scale * y, depth, scale };
        (seen.x.is_finite() && seen.y.is_finite() && seen.depth.is_finite()).then_some(seen)
    }

    /// How near a position is, in proportion to the inverse of its distance; 1 at the centre.
    pub(super) fn nearness(&self, seen: &Seen) -> f64 {
        seen.scale / self.scale
    }

    /// Change of depth that brings a line before the surface it lies in: a five-hundredth of the scene.
    pub(super) fn depth_bias(&self) -> f64 {
        if self.distance.is_finite() { -0.002 * self.radius / self.distance } else { -0.002 }
    }

    /// Change of [`Seen::depth`] for a step of `length` towards the camera, from a position seen at `seen`.
    pub(super) fn nearer(&self, seen: &Seen, length: f64) -> f64 {
        if self.distance.is_finite() {
            let before = -self.distance / seen.depth;
            -self.distance / (before - length).max(1e-3 * self.distance) - seen.depth
        } else {
            -length / self.radius
        }
    }

    /// A direction in the camera's frame: right, up, towards the camera.
    pub(super) fn turned(&self, direction: [f64; 3]) -> [f64; 3] {
        self.axes.map(|axis| dot(axis, direction))
    }
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `v` at length 1; `None` when it has none.
pub(super) fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    let largest = v.iter().fold(0.0f64, |m, c| m.max(c.abs()));
    if !(largest > 0.0 && largest.is_finite()) {
        return None;
    }
    let v = v.map(|c| c / largest);
    let length = dot(v, v).sqrt();
    (length > 1e-9).then(|| v.map(|c| c / length))
}
