//! The drawing itself.

use super::axis::{LogAxis, Tick};
use super::marker::{cross, marker};
use super::place::{Drawn, HEIGHT, Label, Rect, labels, text_width};
use super::{ErrorAxis, Plot, Point, PointState, Series};
use crate::report::text::{cut, escaped, shortest};

const WIDTH: f64 = 640.0;
const TOTAL_HEIGHT: f64 = 420.0;
/// The area of the axes; to the right of it is room for labels.
const FRAME: Rect = Rect { left: 82.0, right: 450.0, top: 62.0, bottom: 366.0 };
/// The strip at the bad end of the error axis, for runs without an error, and at the good end for those without any error.
const STRIP: f64 = 26.0;
const LONGEST_LABEL: usize = 24;

/// Colours for a file of its own; a page brings the same variables.
pub(super) const OWN_STYLE: &str = "<style>svg{--ink:#1d2126;--faint:#5c6670;--rule:#d9dde2;--paper:#fff;--bad:#b3261e;\
--line-1:#0b63a5;--line-2:#b04a00;--line-3:#00735a;--line-4:#9c3a78;--line-5:#7a5c00;--line-6:#4b5563;\
background:var(--paper);font-family:system-ui,-apple-system,\"Segoe UI\",Roboto,\"Noto Sans\",\"DejaVu Sans\",sans-serif}\
@media(prefers-color-scheme:dark){svg{--ink:#e6e8eb;--faint:#a3acb6;--rule:#363c44;--paper:#15181c;--bad:#ff8a80;\
--line-1:#62b5f5;--line-2:#ff9d5c;--line-3:#3ccfa4;--line-4:#ee9fcb;--line-5:#e3c24d;--line-6:#c3c9d1}}</style>";

pub(super) fn drawing(plot: &Plot, style: &str) -> String {
    let sheet = Sheet::of(plot);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {TOTAL_HEIGHT}\" role=\"img\" \
         font-size=\"13\" fill=\"var(--ink)\" aria-label=\"{}\">{style}\n",
        escaped(&description(plot))
    );
    out += &titles(plot);
    out += &sheet.axes(plot);
    let mut drawn = sheet.obstacles(plot);
    out += &sheet.bound_line(plot, &mut drawn);
    let lines: Vec<Vec<(f64, f64)>> = plot.series.iter().map(|series| sheet.path(series)).collect();
    for (index, (series, line)) in plot.series.iter().zip(&lines).enumerate() {
        out += &sheet.series(index, series, line);
    }
    out += &line_labels(plot, &mut drawn, &sheet);
    out += &sheet.slope_triangle(plot, &mut drawn);
    if plot.series.iter().flat_map(|series| &series.points).all(|point| point.state == PointState::Failed) {
        out += &text((FRAME.left + FRAME.right) / 2.0, 215.0, "middle", "var(--faint)", "no run completed");
    }
    out + "</svg>\n"
}

/// What the drawing shows, in words, for readers who do not see it.
fn description(plot: &Plot) -> String {
    let names: Vec<&str> = plot.series.iter().map(|series| series.label.as_str()).collect();
    format!("{}. {} over {}. Lines: {}.", plot.title, plot.y, plot.x, names.join(", "))
}

fn text(x: f64, y: f64, anchor: &str, fill: &str, content: &str) -> String {
    format!(
        "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"{fill}\">{}</text>\n",
        escaped(content)
    )
}

fn titles(plot: &Plot) -> String {
    let title = cut(&plot.title, 72);
    let mut out = format!(
        "<text x=\"14\" y=\"22\" font-size=\"14.5\" font-weight=\"600\">{}</text>\n",
        escaped(&title)
    );
    if !plot.note.is_empty() {
        out += &text(14.0, 41.0, "start", "var(--faint)", &cut(&plot.note, 86));
    }
    let middle = (FRAME.left + FRAME.right) / 2.0;
    out += &text(middle, 408.0, "middle", "var(--ink)", &cut(&plot.x, 60));
    let y = (FRAME.top + FRAME.bottom) / 2.0;
    let label = escaped(&cut(&plot.y, 46));
    out + &format!(
        "<text transform=\"translate(17 {y:.1}) rotate(-90)\" text-anchor=\"middle\">{label}</text>\n"
    )
}

/// The axes and the strips at their ends.
struct Sheet {
    x: LogAxis,
    y: LogAxis,
    error_axis: ErrorAxis,
    /// Where runs without any error stand on the error axis, if there are such.
    exact: Option<f64>,
    /// Where runs without an error stand, if there are such.
    failed: Option<f64>,
}

impl Sheet {
    fn of(plot: &Plot) -> Self {
        let points = || plot.series.iter().flat_map(|series| &series.points);
        let error = |point: &Point| match plot.error_axis {
            ErrorAxis::Horizontal => point.x,
            ErrorAxis::Vertical => point.y,
        };
        let has_exact = points().any(|point| error(point) == 0.0);
        let has_failed = points().any(|point| !(error(point) >= 0.0 && error(point).is_finite()));
        let (low, high) = (if has_exact { STRIP } else { 0.0 }, if has_failed { STRIP } else { 0.0 });
        let bound = plot.bound.into_iter();
        let half = STRIP / 2.0;
        let horizontal = plot.error_axis == ErrorAxis::Horizontal;
        let (xs, ys) = (points().map(|point| point.x), points().map(|point| point.y).chain(bound));
        let (x, y) = if horizontal {
            (
                LogAxis::over(xs, FRAME.left + low, FRAME.right - high),
                LogAxis::over(ys, FRAME.bottom, FRAME.top),
            )
        } else {
            (
                LogAxis::over(xs, FRAME.left, FRAME.right),
                LogAxis::over(ys, FRAME.bottom - low, FRAME.top + high),
            )
        };
        let exact = if horizontal { FRAME.left + half } else { FRAME.bottom - half };
        let failed = if horizontal { FRAME.right - half } else { FRAME.top + half };
        Self {
            x,
            y,
            error_axis: plot.error_axis,
            exact: has_exact.then_some(exact),
            failed: has_failed.then_some(failed),
        }
    }

    /// Where a point is drawn. A completed run without an error has no place; a failed one always has.
    fn place(&self, point: &Point) -> Option<(f64, f64)> {
        let (error, other) = match self.error_axis {
            ErrorAxis::Horizontal => (point.x, point.y),
            ErrorAxis::Vertical => (point.y, point.x),
        };
        let (error_axis, other_axis) = match self.error_axis {
            ErrorAxis::Horizontal => (&self.x, &self.y),
            ErrorAxis::Vertical => (&self.y, &self.x),
        };
        let error_at = match error {
            e if e > 0.0 && e.is_finite() => error_axis.at(e),
            0.0 => self.exact?,
            _ if point.state == PointState::Failed => self.failed?,
            _ => return None,
        };
        let usable = other > 0.0 && other.is_finite();
        if !usable && point.state == PointState::Completed {
            return None;
        }
        let other_at = other_axis.at(other);
        Some(match self.error_axis {
            ErrorAxis::Horizontal => (error_at, other_at),
            ErrorAxis::Vertical => (other_at, error_at),
        })
    }

    fn path(&self, series: &Series) -> Vec<(f64, f64)> {
        let completed = series.points.iter().filter(|point| point.state == PointState::Completed);
        completed.filter_map(|point| self.place(point)).collect()
    }

    fn obstacles(&self, plot: &Plot) -> Drawn {
        let mut drawn = Drawn::default();
        for series in &plot.series {
            drawn.add_polyline(&self.path(series));
            series.points.iter().filter_map(|point| self.place(point)).for_each(|at| drawn.add_marker(at));
        }
        drawn
    }

    fn axes(&self, plot: &Plot) -> String {
        let Rect { left, right, top, bottom } = FRAME;
        let mut out = String::from("<g stroke=\"var(--rule)\" stroke-width=\"1\">\n");
        let (across, up) = (self.x.ticks(6), self.y.ticks(7));
        let mut names = String::new();
        for Tick { value, label } in across {
            let x = self.x.at(value);
            match label {
                Some(label) => {
                    out += &line((x, top), (x, bottom + 5.0), "");
                    names += &text(x, bottom + 20.0, "middle", "var(--ink)", &label);
                }
                None => out += &line((x, bottom), (x, bottom + 3.0), ""),
            }
        }
        for Tick { value, label } in up {
            let y = self.y.at(value);
            match label {
                Some(label) => {
                    out += &line((left - 5.0, y), (right, y), "");
                    names += &text(left - 9.0, y + 4.5, "end", "var(--ink)", &label);
                }
                None => out += &line((left - 3.0, y), (left, y), ""),
            }
        }
        out += &line((left, top), (left, bottom), " stroke=\"var(--faint)\"");
        out += &line((left, bottom), (right, bottom), " stroke=\"var(--faint)\"");
        out + "</g>\n" + &names + &self.strips(plot)
    }

    fn strips(&self, plot: &Plot) -> String {
        let Rect { left, right, top, bottom } = FRAME;
        let mut out = String::new();
        let dashed = " stroke=\"var(--faint)\" stroke-dasharray=\"2 4\"";
        for (at, name) in [(self.exact, "exact (0)"), (self.failed, "no result")] {
            let Some(at) = at else { continue };
            let fill = if name == "no result" { "var(--bad)" } else { "var(--faint)" };
            if plot.error_axis == ErrorAxis::Horizontal {
                out += &line((at, top), (at, bottom), dashed);
                out += &text(at, top - 5.0, "middle", fill, name);
            } else {
                out += &line((left, at), (right, at), dashed);
                out += &text(right + 5.0, at + 4.5, "start", fill, name);
            }
        }
        out
    }

    fn bound_line(&self, plot: &Plot, drawn: &mut Drawn) -> String {
        let Some(bound) = plot.bound else { return String::new() };
        let y = self.y.at(bound);
        let name = format!("bound {}", shortest(bound));
        let rect = |left: f64, bottom: f64| Rect {
            left,
            right: left + text_width(&name),
            top: bottom - HEIGHT,
            bottom,
        };
        let places: Vec<Rect> = [FRAME.left + 6.0, 200.0, FRAME.right - text_width(&name) - 4.0]
            .into_iter()
            .flat_map(|left| [rect(left, y - 2.0), rect(left, y + HEIGHT + 1.0)])
            .filter(|rect| rect.top >= FRAME.top && rect.bottom <= FRAME.bottom)
            .collect();
        drawn.add_polyline(&[(FRAME.left, y), (FRAME.right, y)]);
        let mut out =
            line((FRAME.left, y), (FRAME.right, y), " stroke=\"var(--faint)\" stroke-dasharray=\"6 4\"");
        if let Some(best) = places.iter().min_by_key(|rect| drawn.conflicts(rect)) {
            out += &text(best.left, best.bottom - 4.0, "start", "var(--faint)", &name);
            drawn.add_rect(*best);
        }
        out
    }

    fn series(&self, index: usize, series: &Series, path: &[(f64, f64)]) -> String {
        let colour = format!("var(--line-{})", index % 6 + 1);
        let mut out = format!("<g fill=\"{colour}\" stroke=\"none\">\n");
        if path.len() > 1 {
            let points: Vec<String> = path.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
            let style =
                format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\" stroke-linejoin=\"round\"");
            out += &format!("<polyline points=\"{}\" {style}/>\n", points.join(" "));
        }
        for point in &series.points {
            let Some((x, y)) = self.place(point) else { continue };
            let shape = match point.state {
                PointState::Completed => format!("<g class=\"point\">{}", marker(index, x, y)),
                PointState::Failed => format!(
                    "<g class=\"failed\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.3\">{}",
                    cross(x, y)
                ),
            };
            let detail = format!("{}: {}", series.label, point.detail);
            out += &format!("{shape}<title>{}</title></g>\n", escaped(&detail));
        }
        out + "</g>\n"
    }

    /// A right triangle whose hypotenuse has the slope of the expected order, where it covers least.
    fn slope_triangle(&self, plot: &Plot, drawn: &mut Drawn) -> String {
        let Some(order) = plot.order else { return String::new() };
        // As wide as fits: half a decade to a fifth of the frame, at most a third of its height.
        let slope = order * self.y.decade() / self.x.decade();
        let run = (0.22 * (FRAME.right - FRAME.left)).min(0.33 * (FRAME.bottom - FRAME.top) / slope.abs());
        let rise = slope.abs() * run;
        let mut places = Vec::new();
        for across in 0..12 {
            for down in 0..10 {
                let left = FRAME.left + 12.0 + f64::from(across) * 30.0;
                let bottom = FRAME.bottom - 22.0 - f64::from(down) * 26.0;
                let rect =
                    Rect { left, right: left + run + 34.0, top: bottom - rise - 6.0, bottom: bottom + 18.0 };
                if rect.right <= FRAME.right && rect.top >= FRAME.top {
                    places.push(rect);
                }
            }
        }
        let right_first = |a: &&Rect, b: &&Rect| {
            drawn
                .conflicts(a)
                .cmp(&drawn.conflicts(b))
                .then(b.left.total_cmp(&a.left))
                .then(b.bottom.total_cmp(&a.bottom))
        };
        let Some(&rect) = places.iter().min_by(right_first) else { return String::new() };
        drawn.add_rect(rect);
        let (left, right, foot, head) = (rect.left, rect.left + run, rect.bottom - 18.0, rect.top + 6.0);
        // A rising order has its upright side to the right, a falling one to the left.
        let (upright, far) = if order > 0.0 { (right, left) } else { (left, right) };
        let points = format!("{far:.1},{foot:.1} {upright:.1},{foot:.1} {upright:.1},{head:.1}");
        let mut out = format!(
            "<polygon class=\"slope\" points=\"{points}\" fill=\"none\" stroke=\"var(--faint)\" stroke-width=\"1.3\"/>\n"
        );
        out += &text((left + right) / 2.0, foot + 14.0, "middle", "var(--faint)", "1");
        let beside = if order > 0.0 { upright + 5.0 } else { far + 5.0 };
        out += &text(
            beside,
            (foot + head) / 2.0 + 4.5,
            "start",
            "var(--faint)",
            &format!("{order}").replace('-', "−"),
        );
        out
    }
}

fn line_labels(plot: &Plot, drawn: &mut Drawn, sheet: &Sheet) -> String {
    let names: Vec<String> = plot.series.iter().map(|series| cut(&series.label, LONGEST_LABEL)).collect();
    let widths: Vec<f64> = names.iter().map(|name| text_width(name)).collect();
    // A line without a completed run is labelled at its crosses.
    let ends: Vec<Vec<(f64, f64)>> = plot
        .series
        .iter()
        .map(|series| {
            let path = sheet.path(series);
            if path.is_empty() {
                series.points.iter().filter_map(|point| sheet.place(point)).collect()
            } else {
                path
            }
        })
        .collect();
    // Above the frame is room for a label, unless a strip's name stands there.
    let named_above =
        plot.error_axis == ErrorAxis::Horizontal && (sheet.exact.is_some() || sheet.failed.is_some());
    let top = if named_above { FRAME.top } else { FRAME.top - 15.0 };
    let bounds = Rect { left: FRAME.left + 3.0, right: WIDTH - 2.0, top, bottom: FRAME.bottom - 2.0 };
    if sheet.failed.is_some() && plot.error_axis == ErrorAxis::Vertical {
        // The strip's own name stands in the margin.
        drawn.add_rect(Rect { left: FRAME.right, right: WIDTH, top: FRAME.top, bottom: FRAME.top + STRIP });
    }
    if sheet.exact.is_some() && plot.error_axis == ErrorAxis::Vertical {
        drawn.add_rect(Rect {
            left: FRAME.right,
            right: WIDTH,
            top: FRAME.bottom - STRIP,
            bottom: FRAME.bottom,
        });
    }
    let placed = labels(drawn, &ends, &widths, &bounds, FRAME.right + 12.0);
    placed
        .iter()
        .zip(&names)
        .enumerate()
        .map(|(index, (label, name))| label_markup(index, label, name))
        .collect()
}

fn label_markup(index: usize, label: &Label, name: &str) -> String {
    let colour = format!("var(--line-{})", index % 6 + 1);
    let mut out = String::new();
    if let Some([from, to]) = label.tie {
        out += &line(from, to, &format!(" stroke=\"{colour}\" stroke-width=\"0.8\" stroke-opacity=\"0.7\""));
    }
    let (x, y) = label.at;
    let halo = "paint-order=\"stroke\" stroke=\"var(--paper)\" stroke-width=\"3\" stroke-linejoin=\"round\"";
    out += &format!(
        "<text class=\"label\" x=\"{x:.1}\" y=\"{y:.1}\" fill=\"{colour}\" font-size=\"12.5\" font-weight=\"500\" {halo}>{}</text>\n",
        escaped(name)
    );
    out
}

fn line(from: (f64, f64), to: (f64, f64), style: &str) -> String {
    let ((x1, y1), (x2, y2)) = (from, to);
    format!("<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\"{style}/>\n")
}
