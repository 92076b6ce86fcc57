//! What is drawn.

use super::camera::Bounds;
use super::colour::{ColourMap, Rgb};

/// Things to draw. Triangles, points and segments index `positions`; indices out of range are left out.
#[derive(Clone, Debug, Default)]
pub struct Scene3 {
    /// Positions \[m\]; z is up.
    pub positions: Vec<[f64; 3]>,
    /// Triangles, seen from both sides.
    pub triangles: Vec<[usize; 3]>,
    /// Points, drawn as shaded spheres.
    pub points: Vec<usize>,
    /// Radius of all points.
    pub point_size: PointSize,
    /// Line segments.
    pub segments: Vec<[usize; 2]>,
    /// The scalar that colours everything; without it all is of one colour.
    pub field: Option<Field>,
    /// How triangles are lit.
    pub shading: Shading,
    /// Ground, axes, outlines.
    pub decorations: Vec<Decoration>,
    /// Text in the upper left corner; lines are separated by `\n`.
    pub caption: String,
}

/// A scalar field that colours the scene.
#[derive(Clone, Debug)]
pub struct Field {
    /// Its name, shown above the bar.
    pub name: String,
    /// Its unit; `1` for a ratio.
    pub unit: String,
    /// Its values; one that is not finite is drawn grey.
    pub values: FieldValues,
    /// The range of the colours; `None` takes the finite values' own. Give it for films, or colours change their meaning.
    pub range: Option<(f64, f64)>,
    /// The colours.
    pub map: ColourMap,
}

/// Where a field has its values.
#[derive(Clone, Debug)]
pub enum FieldValues {
    /// One value a position, interpolated inside triangles.
    Positions(Vec<f64>),
    /// One value a triangle, constant on it; points and segments are then of the plain colour.
    Triangles(Vec<f64>),
}

/// Radius of a scene's points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PointSize {
    /// In the scene's own length \[m\].
    World(f64),
    /// In pixels of the picture.
    Pixels(f64),
}

impl Default for PointSize {
    fn default() -> Self {
        Self::Pixels(3.0)
    }
}

/// How triangles are lit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shading {
    /// With the triangle's own normal: every facet is seen.
    #[default]
    Flat,
    /// With normals averaged at positions, weighted by area.
    Smooth,
}

/// Things beside the result that help to read it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Decoration {
    /// A grid of round spacing in the plane z = this height \[m\], under the scene.
    Ground(f64),
    /// The directions of x, y and z in the lower left corner.
    Axes,
    /// The edges of triangles.
    Edges,
}

/// The colour of what has no field.
pub(super) const PLAIN: Rgb = Rgb([120, 150, 190]);
/// The colour of a value that is not finite.
pub(super) const NO_VALUE: Rgb = Rgb([150, 150, 150]);

impl Field {
    /// The range that colours span: as given, or that of the finite values; widened where it has no extent.
    pub(super) fn colour_range(&self) -> (f64, f64) {
        let (FieldValues::Positions(values) | FieldValues::Triangles(values)) = &self.values;
        let own = || {
            let finite = values.iter().copied().filter(|value| value.is_finite());
            finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
        };
        match self
            .range
            .filter(|(low, high)| low.is_finite() && high.is_finite() && low <= high)
            .unwrap_or_else(own)
        {
            (low, high) if low < high => (low, high),
            (low, high) if low == high => {
                (low - (0.5 * low.abs()).max(0.5), high + (0.5 * high.abs()).max(0.5))
            }
            _ => (0.0, 1.0),
        }
    }

    /// The colour of `value` when colours span `range`.
    pub(super) fn colour(&self, value: f64, range: (f64, f64)) -> Rgb {
        if !value.is_finite() {
            return NO_VALUE;
        }
        // Halves first: the difference of two huge values may overflow.
        let share = (0.5 * value - 0.5 * range.0) / (0.5 * range.1 - 0.5 * range.0);
        self.map.colour(share)
    }
}

impl Scene3 {
    /// The box of all finite positions that something uses; `None` when there is none.
    pub fn bounds(&self) -> Option<Bounds> {
        let triangles = self.triangles.iter().flatten();
        let used = triangles.chain(&self.points).chain(self.segments.iter().flatten());
        Bounds::of(used.filter_map(|&index| self.position(index)))
    }

    /// A position that is there and finite.
    pub(super) fn position(&self, index: usize) -> Option<[f64; 3]> {
        self.positions.get(index).copied().filter(|p| p.iter().all(|c| c.is_finite() && c.abs() < 1e150))
    }

    /// The colour of a position.
    pub(super) fn position_colour(&self, index: usize, range: (f64, f64)) -> Rgb {
        match &self.field {
            Some(field) => match &field.values {
                FieldValues::Positions(values) => {
                    field.colour(values.get(index).copied().unwrap_or(f64::NAN), range)
                }
                FieldValues::Triangles(_) => PLAIN,
            },
            None => PLAIN,
        }
    }
}
