//! Curves over two linear axes: stress against strain, position against time.

use super::colour::Rgb;
use super::font;
use super::image::{Image, Size};
use super::legend::ticks;
use super::raster::PAPER;

/// Curves in one frame. Points that are not finite interrupt a curve.
#[derive(Clone, Debug, Default)]
pub struct Chart {
    /// First line, above the frame.
    pub title: String,
    /// Under the horizontal axis: quantity and unit.
    pub x: String,
    /// Over the vertical axis: quantity and unit.
    pub y: String,
    /// The curves; more than six share colours.
    pub curves: Vec<Curve>,
}

/// One curve of a chart.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Its name, beside a swatch under the title; none if empty, and then it has the colour of the curve before it.
    pub label: String,
    /// Its points.
    pub points: Vec<[f64; 2]>,
    /// How they are drawn.
    pub mark: Mark,
}

/// How a curve's points are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// Linked.
    Line,
    /// A dot each.
    Dots,
}

impl Curve {
    /// A line.
    pub fn line(label: &str, points: Vec<[f64; 2]>) -> Self {
        Self { label: label.to_owned(), points, mark: Mark::Line }
    }

    /// Dots.
    pub fn dots(label: &str, points: Vec<[f64; 2]>) -> Self {
        Self { label: label.to_owned(), points, mark: Mark::Dots }
    }
}

const INK: Rgb = Rgb([40, 44, 51]);
const GRID: Rgb = Rgb([226, 229, 233]);
/// Told apart in grey and by most colour-blind eyes (after Okabe and Ito, 2008).
const COLOURS: [Rgb; 6] = [
    Rgb([0, 114, 178]),
    Rgb([213, 94, 0]),
    Rgb([0, 158, 115]),
    Rgb([204, 121, 167]),
    Rgb([86, 180, 233]),
    Rgb([100, 100, 100]),
];
/// Pixels of the font a pixel of a letter is wide.
const SCALE: i64 = 2;

/// A frame of pixels and the range of values in it.
struct Frame {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
    x: [f64; 2],
    y: [f64; 2],
}

impl Frame {
    fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let share = |value: f64, [low, high]: [f64; 2]| (value - low) / (high - low);
        [
            self.left + share(x, self.x) * (self.right - self.left),
            self.bottom + share(y, self.y) * (self.top - self.bottom),
        ]
    }
}

/// The picture of a chart.
pub fn draw_chart(chart: &Chart, size: Size) -> Image {
    let mut image = Image::filled(size, PAPER);
    let line = (font::HEIGHT + 5) * SCALE;
    let labels = chart.curves.iter().filter(|curve| !curve.label.is_empty()).count() as i64;
    let frame = Frame {
        left: (9 * font::ADVANCE * SCALE) as f64,
        right: (size.width as i64 - 4 * font::ADVANCE * SCALE) as f64,
        top: (line * (2 + (labels + 1) / 2) + 8) as f64,
        bottom: (size.height as i64 - 2 * line - 6) as f64,
        x: range(chart, 0),
        y: range(chart, 1),
    };
    font::write(&mut image, &chart.title, (8, 8), SCALE, INK);
    draw_axes(&mut image, chart, &frame);
    let mut named = 0;
    for curve in &chart.curves {
        if !curve.label.is_empty() {
            let at = (8 + (named % 2) * size.width as i64 / 2, 8 + line * (1 + named / 2));
            let colour = COLOURS[named as usize % COLOURS.len()];
            disk(&mut image, [at.0 as f64 + 6.0, at.1 as f64 + 7.0], 5.0, colour);
            font::write(&mut image, &curve.label, (at.0 + 18, at.1), SCALE, INK);
            named += 1;
        }
        let colour = COLOURS[(named.max(1) - 1) as usize % COLOURS.len()];
        draw_curve(&mut image, curve, &frame, colour);
    }
    image
}

/// What an axis spans: all finite values and a twentieth beyond.
fn range(chart: &Chart, axis: usize) -> [f64; 2] {
    let points = chart.curves.iter().flat_map(|curve| &curve.points);
    let values = points.filter(|p| p.iter().all(|x| x.is_finite())).map(|p| p[axis]);
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
    match high - low {
        extent if extent > 0.0 && extent.is_finite() => [low - 0.05 * extent, high + 0.05 * extent],
        _ if low.is_finite() => [low - 0.5 * low.abs().max(1.0), high + 0.5 * high.abs().max(1.0)],
        _ => [0.0, 1.0],
    }
}

fn draw_axes(image: &mut Image, chart: &Chart, frame: &Frame) {
    let mut free = 0;
    for (value, name) in ticks(frame.x[0], frame.x[1]) {
        let [x, _] = frame.place([value, frame.y[0]]);
        segment(image, [x, frame.top], [x, frame.bottom], 1.0, GRID);
        let left = x as i64 - font::width(&name, SCALE) / 2;
        // Numbers that would run into each other: every other one.
        if left >= free {
            font::write(image, &name, (left, frame.bottom as i64 + 6), SCALE, INK);
            free = left + font::width(&name, SCALE) + font::ADVANCE * SCALE;
        }
    }
    for (value, name) in ticks(frame.y[0], frame.y[1]) {
        let [_, y] = frame.place([frame.x[0], value]);
        segment(image, [frame.left, y], [frame.right, y], 1.0, GRID);
        let at = (frame.left as i64 - 6 - font::width(&name, SCALE), y as i64 - font::HEIGHT * SCALE / 2);
        font::write(image, &name, at, SCALE, INK);
    }
    let Frame { left, right, top, bottom, .. } = *frame;
    segment(image, [left, top], [left, bottom], 1.5, INK);
    segment(image, [left, bottom], [right, bottom], 1.5, INK);
    let below = frame.bottom as i64 + 6 + (font::HEIGHT + 4) * SCALE;
    font::write(image, &chart.x, (right as i64 - font::width(&chart.x, SCALE), below), SCALE, INK);
    let above = frame.top as i64 - (font::HEIGHT + 3) * SCALE;
    font::write(image, &chart.y, (left as i64 + 8, above), SCALE, INK);
}

fn draw_curve(image: &mut Image, curve: &Curve, frame: &Frame, colour: Rgb) {
    let finite = |p: &[f64; 2]| p.iter().all(|x| x.is_finite());
    match curve.mark {
        Mark::Line => {
            for pair in curve.points.windows(2).filter(|pair| pair.iter().all(finite)) {
                segment(image, frame.place(pair[0]), frame.place(pair[1]), 2.2, colour);
            }
        }
        Mark::Dots => {
            for point in curve.points.iter().filter(|point| finite(point)) {
                disk(image, frame.place(*point), 4.0, colour);
            }
        }
    }
}

fn disk(image: &mut Image, centre: [f64; 2], radius: f64, colour: Rgb) {
    segment(image, centre, centre, 2.0 * radius, colour);
}

/// A line with round ends; pixels on its rim are mixed by how much of them it covers.
fn segment(image: &mut Image, a: [f64; 2], b: [f64; 2], width: f64, colour: Rgb) {
    let reach = 0.5 * width + 1.0;
    let span = |k: usize, most: usize| {
        let low = (a[k].min(b[k]) - reach).clamp(0.0, most as f64) as usize;
        low..(a[k].max(b[k]) + reach).clamp(0.0, most as f64) as usize
    };
    let d = [b[0] - a[0], b[1] - a[1]];
    let length = d[0] * d[0] + d[1] * d[1];
    for y in span(1, image.size().height) {
        for x in span(0, image.size().width) {
            let from = [x as f64 + 0.5 - a[0], y as f64 + 0.5 - a[1]];
            let along =
                if length > 0.0 { ((from[0] * d[0] + from[1] * d[1]) / length).clamp(0.0, 1.0) } else { 0.0 };
            let distance = (from[0] - along * d[0]).hypot(from[1] - along * d[1]);
            let cover = (0.5 * width + 0.5 - distance).clamp(0.0, 1.0);
            if cover > 0.0 {
                let below = image.pixel(x, y);
                let mixed = |k: usize| {
                    (cover * f64::from(colour.0[k]) + (1.0 - cover) * f64::from(below.0[k])).round() as u8
                };
                image.set(x as i64, y as i64, Rgb(std::array::from_fn(mixed)));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The highest point of a curve is drawn above the lowest, the last to the right of the first, and odd input fails nothing.
    #[test]
    fn places_are_those_of_the_values() {
        let mut chart = Chart::default();
        let size = Size { width: 400, height: 300 };
        assert_eq!(draw_chart(&chart, size).size(), size);
        chart.curves.push(Curve::dots("one", vec![[0.0, 1.0], [2.0, 3.0], [f64::NAN, 7.0]]));
        let image = draw_chart(&chart, size);
        let coloured: Vec<(usize, usize)> = (0..size.width * size.height)
            .map(|k| (k % size.width, k / size.width))
            .filter(|&(x, y)| y > 60 && image.pixel(x, y) == COLOURS[0])
            .collect();
        let (top, bottom) = (coloured[0], coloured[coloured.len() - 1]);
        assert!(top.0 > 300 && bottom.0 < 160 && top.1 < 100 && bottom.1 > 200, "{top:?} {bottom:?}");
    }
}
