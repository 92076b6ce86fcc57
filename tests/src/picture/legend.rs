//! What explains a picture: colour bar, axes, caption.

use super::camera::{Seen, View};
use super::colour::Rgb;
use super::font;
use super::image::{Image, Size};
use super::raster::Canvas;
use super::scene3::Field;

const INK: Rgb = Rgb([40, 44, 51]);
const AXES: [(Rgb, &str); 3] =
    [(Rgb([192, 57, 43]), "x"), (Rgb([30, 125, 62]), "y"), (Rgb([38, 84, 172]), "z")];
/// Letters beside the bar.
const LABEL_LETTERS: i64 = 8;

/// How many pixels a pixel of the font is.
fn scale(size: Size) -> i64 {
    (size.height as i64 / 300).clamp(1, 8)
}

/// Width that the colour bar takes at the right \[pixels\]; nothing where the picture is too small for one.
pub(super) fn bar_width(size: Size) -> i64 {
    let width = (14 + 4 + 10 + LABEL_LETTERS * font::ADVANCE) * scale(size);
    if size.width as i64 >= 3 * width && size.height as i64 >= 12 * font::HEIGHT * scale(size) {
        width
    } else {
        0
    }
}

/// The bar with the field's name above and round numbers beside; the ends of its range are named where no round number is.
pub(super) fn draw_bar(image: &mut Image, field: &Field) {
    let (size, s) = (image.size(), scale(image.size()));
    let total = bar_width(size);
    if total == 0 {
        return;
    }
    let left = size.width as i64 - total;
    let (top, bottom) = (size.height as i64 / 6, size.height as i64 - size.height as i64 / 8);
    for y in top..bottom {
        let share = (bottom - 1 - y) as f64 / (bottom - 1 - top) as f64;
        for x in left..left + 14 * s {
            let rim = x < left + 1 || x >= left + 14 * s - 1 || y == top || y == bottom - 1;
            image.set(x, y, if rim { INK } else { field.map.colour(share) });
        }
    }
    draw_name(image, field, (top, total), s);
    let (low, high) = field.colour_range();
    for (value, name) in ticks(low, high) {
        let share = (0.5 * value - 0.5 * low) / (0.5 * high - 0.5 * low);
        let y = bottom - 1 - (share * (bottom - 1 - top) as f64).round() as i64;
        for x in left + 14 * s..left + 18 * s {
            image.set(x, y, INK);
        }
        font::write(image, &name, (left + 20 * s, y - 3 * s), s, INK);
    }
}

fn draw_name(image: &mut Image, field: &Field, (top, total): (i64, i64), s: i64) {
    let unit =
        if field.unit == "1" || field.unit.is_empty() { String::new() } else { format!(" [{}]", field.unit) };
    let name = format!("{}{unit}", field.name);
    let width = image.size().width as i64;
    let room = (width / 2 / (font::ADVANCE * s)).max(4) as usize;
    let name = crate::report::text::cut(&crate::report::text::one_line(&name), room);
    // From the bar's left end, but pushed inwards when it would leave the picture.
    let x = (width - total).min(width - font::width(&name, s) - 4 * s).max(0);
    font::write(image, &name, (x, top - 12 * s), s, INK);
}

/// Round numbers from `low` to `high`, four to nine of them, with their names.
pub(super) fn ticks(low: f64, high: f64) -> Vec<(f64, String)> {
    let step = round_step((high - low) / 5.0);
    if !(step > 0.0 && step.is_finite()) {
        return vec![(low, number(low)), (high, number(high))];
    }
    // A range far from zero and narrow: its numbers would all read the same, so the ends carry all digits they need.
    let (first, last) = ((low / step).ceil(), (high / step).floor());
    let digits = (low.abs().max(high.abs()) / step).log10().ceil();
    if digits > 5.0 || !(last - first).is_finite() {
        return vec![(low, number(low)), (high, number(high))];
    }
    let count = (last - first) as i64 + 1;
    let slack = 1e-9 * step;
    let values = (0..count.clamp(0, 12)).map(|k| (first + k as f64) * step);
    let values = values.map(|value| if value.abs() < slack { 0.0 } else { value });
    values.map(|value| (value, stepped(value, step, low.abs().max(high.abs())))).collect()
}

/// The largest of 1, 2, 5 times a power of ten that is at most a little above `step`.
pub(super) fn round_step(step: f64) -> f64 {
    if !(step > 0.0 && step.is_finite()) {
        return 0.0;
    }
    let decade = 10f64.powf(step.log10().floor());
    [5.0, 2.0, 1.0].into_iter().map(|m| m * decade).find(|round| *round <= 1.0001 * step).unwrap_or(decade)
}

/// `value`, a multiple of `step`, with just the digits that it needs; all ticks of a bar that reaches `largest` are written
/// the same way.
fn stepped(value: f64, step: f64, largest: f64) -> String {
    let decimals = -(step * 1.0001).log10().floor();
    if value == 0.0 {
        "0".into()
    } else if largest >= 1e5 || step < 9.99e-5 {
        let figures = (largest.log10().floor() + decimals).clamp(0.0, 3.0) as usize;
        format!("{value:.figures$e}")
    } else {
        format!("{value:.*}", decimals.max(0.0) as usize)
    }
}

fn number(value: f64) -> String {
    let plain = format!("{value}");
    if plain.len() <= LABEL_LETTERS as usize { plain } else { format!("{value:.1e}") }
}

/// Middle and length of the axes \[pixels\].
fn axes_place(size: Size) -> (f64, f64, f64) {
    let arm = 0.055 * size.height.min(size.width) as f64;
    (1.9 * arm, size.height as f64 - 1.9 * arm, arm)
}

pub(super) fn draw_axes(canvas: &mut Canvas, view: &View, size: Size, samples: usize) {
    let (x, y, arm) = axes_place(size);
    let at = |shift: [f64; 3]| Seen {
        x: samples as f64 * (x + arm * shift[0]),
        y: samples as f64 * (y - arm * shift[1]),
        // In front of everything; among themselves by depth.
        depth: -1e6 - shift[2],
        scale: 1.0,
    };
    for (axis, (colour, _)) in AXES.iter().enumerate() {
        let shift = view.turned(std::array::from_fn(|k| if k == axis { 1.0 } else { 0.0 }));
        let width = (0.12 * arm * samples as f64).max(1.0);
        canvas.line(view, (at([0.0; 3]), *colour), (at(shift), *colour), width);
    }
}

pub(super) fn name_axes(image: &mut Image, view: &View) {
    let (x, y, arm) = axes_place(image.size());
    let s = scale(image.size());
    for (axis, (colour, name)) in AXES.iter().enumerate() {
        let [right, up, _] = view.turned(std::array::from_fn(|k| if k == axis { 1.0 } else { 0.0 }));
        // An axis that points at the camera has no end to stand beside.
        if right.hypot(up) > 0.15 {
            let reach = arm + 6.0 * s as f64 / right.hypot(up).max(0.5);
            let at = ((x + reach * right) as i64 - 2 * s, (y - reach * up) as i64 - 3 * s);
            font::write(image, name, at, s, *colour);
        }
    }
}

pub(super) fn draw_caption(image: &mut Image, caption: &str) {
    let s = scale(image.size());
    for (row, line) in caption.lines().take(8).enumerate() {
        let y = 6 * s + row as i64 * (font::HEIGHT + 4) * s;
        font::write(image, &crate::report::text::one_line(line), (6 * s, y), s, INK);
    }
}
