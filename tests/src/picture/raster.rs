//! The drawing itself: depth buffer, triangles, spheres, lines.

use super::camera::{Bounds, Camera, Seen, View, cross, dot, unit};
use super::colour::Rgb;
use super::image::{Image, Size};
use super::legend;
use super::scene3::{Decoration, Field, FieldValues, NO_VALUE, PLAIN, PointSize, Scene3, Shading};

/// Samples a pixel along each side.
const SAMPLES: usize = 2;
const LARGEST_SIDE: usize = 8192;
pub(super) const PAPER: Rgb = Rgb([255, 255, 255]);
const LINE: Rgb = Rgb([45, 50, 58]);
const GROUND: Rgb = Rgb([214, 218, 223]);

/// The picture of `scene` from `camera`, `size` pixels large (held to 1–8192 a side).
///
/// The camera's box, or the scene's own, fills the picture but for a border and the colour bar. The cost is linear in the
/// number of elements and in the pixels they cover.
pub fn render(scene: &Scene3, camera: &Camera, size: Size) -> Image {
    let side = |pixels: usize| pixels.clamp(1, LARGEST_SIDE);
    let size = Size { width: side(size.width), height: side(size.height) };
    let fine = Size { width: SAMPLES * size.width, height: SAMPLES * size.height };
    let mut canvas = Canvas::new(fine);
    let bounds = camera.frame.or_else(|| scene.bounds()).unwrap_or(Bounds { low: [0.0; 3], high: [0.0; 3] });
    let margin = if scene.field.is_some() { legend::bar_width(size) } else { 0 };
    let view = camera.view(bounds, fine, (SAMPLES as i64 * margin) as f64);
    draw_scene(&mut canvas, scene, &view, &bounds);
    let axes = scene.decorations.contains(&Decoration::Axes);
    if axes {
        legend::draw_axes(&mut canvas, &view, size, SAMPLES);
    }
    let mut image = canvas.averaged(size);
    if axes {
        legend::name_axes(&mut image, &view);
    }
    if let Some(field) = &scene.field {
        legend::draw_bar(&mut image, field);
    }
    legend::draw_caption(&mut image, &scene.caption);
    image
}

fn draw_scene(canvas: &mut Canvas, scene: &Scene3, view: &View, bounds: &Bounds) {
    let seen: Vec<Option<Seen>> =
        (0..scene.positions.len()).map(|index| scene.position(index).and_then(|p| view.seen(p))).collect();
    let width = line_width(canvas.size);
    for decoration in &scene.decorations {
        if let Decoration::Ground(height) = decoration {
            draw_ground(canvas, view, bounds, *height, 0.6 * width);
        }
    }
    draw_triangles(canvas, scene, view, &seen);
    let range = scene.field.as_ref().map_or((0.0, 1.0), Field::colour_range);
    if scene.decorations.contains(&Decoration::Edges) {
        for triangle in &scene.triangles {
            for side in 0..3 {
                let ends = [triangle[side], triangle[(side + 1) % 3]].map(|i| seen.get(i).copied().flatten());
                if let [Some(a), Some(b)] = ends {
                    canvas.line(view, (a, LINE), (b, LINE), 0.6 * width);
                }
            }
        }
    }
    for segment in &scene.segments {
        let ends = segment.map(|i| seen.get(i).copied().flatten());
        if let [Some(a), Some(b)] = ends {
            let colour =
                |i: usize| if scene.field.is_some() { scene.position_colour(i, range) } else { LINE };
            canvas.line(view, (a, colour(segment[0])), (b, colour(segment[1])), width);
        }
    }
    for &index in &scene.points {
        if let Some(Some(at)) = seen.get(index) {
            let radius = match scene.point_size {
                PointSize::World(radius) => radius * at.scale,
                PointSize::Pixels(radius) => radius * SAMPLES as f64,
            };
            canvas.sphere(view, at, radius, scene.position_colour(index, range));
        }
    }
}

/// Width of lines in samples: 1.3 pixels of a picture 600 pixels high.
fn line_width(fine: Size) -> f64 {
    (1.3 / 600.0 * fine.height as f64).max(1.0)
}

/// The lamp over the left shoulder, in the camera's frame.
const LAMP: [f64; 3] = [-0.37, 0.48, 0.795];

/// How bright a surface is that faces the lamp with this cosine. Light comes from everywhere too, so that no colour is lost
/// in the dark.
fn brightness(cosine: f64) -> f64 {
    0.45 + 0.55 * (0.5 + 0.5 * cosine).clamp(0.0, 1.0).powi(2)
}

/// A corner of a triangle as it is drawn.
#[derive(Clone, Copy)]
struct Corner {
    seen: Seen,
    /// Share of the colour range.
    share: f64,
    light: f64,
}

fn draw_triangles(canvas: &mut Canvas, scene: &Scene3, view: &View, seen: &[Option<Seen>]) {
    let range = scene.field.as_ref().map_or((0.0, 1.0), Field::colour_range);
    let cosine = |normal: [f64; 3]| unit(normal).map(|normal| dot(view.turned(normal), LAMP));
    let cosines: Vec<Option<f64>> = match scene.shading {
        Shading::Smooth => position_normals(scene).into_iter().map(cosine).collect(),
        Shading::Flat => Vec::new(),
    };
    let shares = position_shares(scene, range);
    for (number, triangle) in scene.triangles.iter().enumerate() {
        let [Some(a), Some(b), Some(c)] = triangle.map(|index| seen.get(index).copied().flatten()) else {
            continue;
        };
        let area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        // Both sides are lit: from behind the normals are turned round. The picture's y points down.
        let side = if area < 0.0 { 1.0 } else { -1.0 };
        let facet = match scene.shading {
            Shading::Smooth => None,
            Shading::Flat => facet_normal(scene, triangle).and_then(cosine),
        };
        let light = triangle.map(|index| {
            let own = cosines.get(index).copied().flatten().or(facet);
            brightness(side * own.unwrap_or(0.0))
        });
        let (paint, share) = paint(scene, number, triangle, &shares, range);
        let corner = |seen: Seen, k: usize| Corner { seen, share: share[k], light: light[k] };
        canvas.triangle(view, [corner(a, 0), corner(b, 1), corner(c, 2)], area, paint);
    }
}

/// What colours the inside of a triangle.
#[derive(Clone, Copy)]
enum Paint<'a> {
    One(Rgb),
    Field(&'a Field),
}

/// Shares of the colour range at positions; none where the field is not given there.
fn position_shares(scene: &Scene3, range: (f64, f64)) -> Vec<f64> {
    let Some(Field { values: FieldValues::Positions(values), .. }) = &scene.field else { return Vec::new() };
    let width = 0.5 * range.1 - 0.5 * range.0;
    values.iter().map(|value| (0.5 * value - 0.5 * range.0) / width).collect()
}

/// The paint of a triangle and the shares of the colour range at its corners.
fn paint<'a>(
    scene: &'a Scene3,
    number: usize,
    triangle: &[usize; 3],
    shares: &[f64],
    range: (f64, f64),
) -> (Paint<'a>, [f64; 3]) {
    let Some(field) = &scene.field else { return (Paint::One(PLAIN), [0.0; 3]) };
    match &field.values {
        FieldValues::Triangles(values) => {
            let value = values.get(number).copied().unwrap_or(f64::NAN);
            (Paint::One(field.colour(value, range)), [0.0; 3])
        }
        FieldValues::Positions(_) => {
            let shares = triangle.map(|index| shares.get(index).copied().unwrap_or(f64::NAN));
            let finite = shares.iter().all(|share| share.is_finite());
            (if finite { Paint::Field(field) } else { Paint::One(NO_VALUE) }, shares)
        }
    }
}

/// Normal of a triangle, as long as twice its area; `None` where a position is not usable.
fn facet_normal(scene: &Scene3, triangle: &[usize; 3]) -> Option<[f64; 3]> {
    let [a, b, c] = triangle.map(|index| scene.position(index));
    let (a, b, c) = (a?, b?, c?);
    let edge = |p: [f64; 3]| [0, 1, 2].map(|k| p[k] - a[k]);
    Some(cross(edge(b), edge(c)))
}

/// Normals at positions: the sum of the normals of triangles around, each as long as its area.
fn position_normals(scene: &Scene3) -> Vec<[f64; 3]> {
    let mut normals = vec![[0.0; 3]; scene.positions.len()];
    for triangle in &scene.triangles {
        if let Some(normal) = facet_normal(scene, triangle) {
            for &index in triangle {
                (0..3).for_each(|k| normals[index][k] += normal[k]);
            }
        }
    }
    normals
}

fn draw_ground(canvas: &mut Canvas, view: &View, bounds: &Bounds, height: f64, width: f64) {
    let extent = |axis: usize| bounds.high[axis] - bounds.low[axis];
    let largest = extent(0).max(extent(1)).max(extent(2));
    if !(largest > 0.0 && largest.is_finite() && height.is_finite()) {
        return;
    }
    let spacing = legend::round_step(largest / 6.0);
    let ends = |axis: usize| {
        let (low, high) = (bounds.low[axis] - 0.08 * largest, bounds.high[axis] + 0.08 * largest);
        ((low / spacing).floor() * spacing, (high / spacing).ceil() * spacing)
    };
    let ((x0, x1), (y0, y1)) = (ends(0), ends(1));
    let mut line = |a: [f64; 3], b: [f64; 3]| {
        if let (Some(a), Some(b)) = (view.seen(a), view.seen(b)) {
            canvas.line(view, (a, GROUND), (b, GROUND), width);
        }
    };
    // Far from the origin a step may be too small to change x; the number of lines is bounded all the same.
    for k in 0..=(((x1 - x0) / spacing).round().min(60.0) as usize) {
        let x = x0 + k as f64 * spacing;
        line([x, y0, height], [x, y1, height]);
    }
    for k in 0..=(((y1 - y0) / spacing).round().min(60.0) as usize) {
        let y = y0 + k as f64 * spacing;
        line([x0, y, height], [x1, y, height]);
    }
}

/// Samples with their depths.
pub(super) struct Canvas {
    pub(super) size: Size,
    colours: Vec<Rgb>,
    depths: Vec<f32>,
}

impl Canvas {
    fn new(size: Size) -> Self {
        let samples = size.width * size.height;
        Self { size, colours: vec![PAPER; samples], depths: vec![f32::INFINITY; samples] }
    }

    fn put(&mut self, at: usize, depth: f32, colour: Rgb) {
        if depth < self.depths[at] {
            self.depths[at] = depth;
            self.colours[at] = colour;
        }
    }

    /// The samples from `low` to `high` along a side of `side` samples, whose centres lie at half numbers.
    fn covered(low: f64, high: f64, side: usize) -> std::ops::Range<usize> {
        let first = (low - 0.5).ceil().max(0.0);
        let last = (high - 0.5).floor().min(side as f64 - 1.0);
        if first <= last { first as usize..last as usize + 1 } else { 0..0 }
    }

    /// `area` is twice that in the picture, signed. Barycentric coordinates are linear in the picture; divided by the distance so are share and light, which makes them
    /// right in perspective.
    fn triangle(&mut self, view: &View, corners: [Corner; 3], area: f64, paint: Paint<'_>) {
        let [a, b, c] = corners.map(|corner| corner.seen);
        if !(area.abs() > 1e-12 && area.is_finite()) {
            return;
        }
        let least = |f: fn(&Seen) -> f64| f(&a).min(f(&b)).min(f(&c));
        let most = |f: fn(&Seen) -> f64| f(&a).max(f(&b)).max(f(&c));
        let rows = Self::covered(least(|s| s.y), most(|s| s.y), self.size.height);
        let columns = Self::covered(least(|s| s.x), most(|s| s.x), self.size.width);
        let nearness = [a, b, c].map(|seen| view.nearness(&seen));
        // Weight of a corner: value at the first column's centre, and its step a column.
        let edge = |p: &Seen, q: &Seen, y: f64| {
            let start = (q.x - p.x) * (y - p.y) - (q.y - p.y) * (columns.start as f64 + 0.5 - p.x);
            (start / area, -(q.y - p.y) / area)
        };
        let blend = |w: [f64; 3], v: [f64; 3]| w[0] * v[0] + w[1] * v[1] + w[2] * v[2];
        let depth = [a.depth, b.depth, c.depth];
        let light: [f64; 3] = std::array::from_fn(|k| corners[k].light * nearness[k]);
        let share: [f64; 3] = std::array::from_fn(|k| corners[k].share * nearness[k]);
        for row in rows {
            let y = row as f64 + 0.5;
            let weights = [edge(&b, &c, y), edge(&c, &a, y), edge(&a, &b, y)];
            for (step, column) in columns.clone().enumerate() {
                let w = weights.map(|(start, slope)| start + step as f64 * slope);
                if w[0] < 0.0 || w[1] < 0.0 || w[2] < 0.0 {
                    continue;
                }
                let (at, depth) = (row * self.size.width + column, blend(w, depth) as f32);
                if depth >= self.depths[at] {
                    continue;
                }
                let near = blend(w, nearness);
                let base = match paint {
                    Paint::One(colour) => colour,
                    Paint::Field(field) => field.map.colour(blend(w, share) / near),
                };
                self.depths[at] = depth;
                self.colours[at] = lit(base, blend(w, light) / near);
            }
        }
    }

    /// A lit sphere whose outline is a disc of `radius` samples.
    fn sphere(&mut self, view: &View, centre: &Seen, radius: f64, colour: Rgb) {
        if !(radius > 0.0 && radius.is_finite()) {
            return;
        }
        let bulge = view.nearer(centre, radius / centre.scale);
        for row in Self::covered(centre.y - radius, centre.y + radius, self.size.height) {
            for column in Self::covered(centre.x - radius, centre.x + radius, self.size.width) {
                let (x, y) =
                    ((column as f64 + 0.5 - centre.x) / radius, (centre.y - row as f64 - 0.5) / radius);
                let rest = 1.0 - x * x - y * y;
                if rest >= 0.0 {
                    let z = rest.sqrt();
                    let depth = (centre.depth + bulge * z) as f32;
                    self.put(
                        row * self.size.width + column,
                        depth,
                        lit(colour, brightness(dot([x, y, z], LAMP))),
                    );
                }
            }
        }
    }

    /// A line of `width` samples, drawn a little nearer than it is, so that it is seen on a surface that it lies in.
    pub(super) fn line(&mut self, view: &View, (a, from): (Seen, Rgb), (b, to): (Seen, Rgb), width: f64) {
        let bias = view.depth_bias();
        let flat = (b.x - a.x).abs() >= (b.y - a.y).abs();
        // `u` runs along the longer side, `v` across.
        let split = |s: &Seen| if flat { (s.x, s.y) } else { (s.y, s.x) };
        let ((ua, va), (ub, vb)) = (split(&a), split(&b));
        let (along, across) = match flat {
            true => (self.size.width, self.size.height),
            false => (self.size.height, self.size.width),
        };
        let length = (ub - ua).hypot(vb - va);
        if !length.is_finite() {
            return;
        }
        // Width across the line, measured along v.
        let half = if ub == ua { 0.5 * width } else { 0.5 * width * length / (ub - ua).abs() };
        let (low, high) = (ua.min(ub).min(ua.max(ub) - 1.0), ua.max(ub));
        for u in Self::covered(low, high, along) {
            let t = if ub == ua { 0.0 } else { ((u as f64 + 0.5 - ua) / (ub - ua)).clamp(0.0, 1.0) };
            let (v, depth) = (va + t * (vb - va), (a.depth + t * (b.depth - a.depth) + bias) as f32);
            let colour = mixed(from, to, t);
            for v in Self::covered(v - half, v + half, across) {
                let at = if flat { v * self.size.width + u } else { u * self.size.width + v };
                self.put(at, depth, colour);
            }
        }
    }

    /// The picture: every pixel the mean of its samples.
    fn averaged(&self, size: Size) -> Image {
        let mut image = Image::filled(size, PAPER);
        let share = (SAMPLES * SAMPLES) as u32;
        for (row, pixels) in image.pixels_mut().chunks_exact_mut(size.width).enumerate() {
            for (column, pixel) in pixels.iter_mut().enumerate() {
                let mut sum = [share / 2; 3];
                for dy in 0..SAMPLES {
                    let first = (row * SAMPLES + dy) * self.size.width + column * SAMPLES;
                    for Rgb(sample) in &self.colours[first..first + SAMPLES] {
                        (0..3).for_each(|c| sum[c] += u32::from(sample[c]));
                    }
                }
                *pixel = Rgb(sum.map(|c| (c / share) as u8));
            }
        }
        image
    }
}

fn lit(Rgb(colour): Rgb, light: f64) -> Rgb {
    Rgb(colour.map(|c| (f64::from(c) * light + 0.5) as u8))
}

fn mixed(Rgb(from): Rgb, Rgb(to): Rgb, t: f64) -> Rgb {
    Rgb([0, 1, 2].map(|c| (f64::from(from[c]) + t * (f64::from(to[c]) - f64::from(from[c])) + 0.5) as u8))
}
