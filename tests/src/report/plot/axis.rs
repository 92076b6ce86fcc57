//! A logarithmic axis: its range in whole decades or a little more, its ticks.

/// A logarithmic axis from `low` to `high` drawn between `from` and `to`.
#[derive(Clone, Copy, Debug)]
pub(super) struct LogAxis {
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

/// A tick of an axis.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tick {
    /// Where it is.
    pub(super) value: f64,
    /// What it is called; `None` for a minor tick.
    pub(super) label: Option<String>,
}

/// Decades an axis spans at least: a single point stands in the middle of one.
const LEAST_DECADES: f64 = 1.0;

impl LogAxis {
    /// The axis that shows all positive finite `values` with a margin, drawn between `from` and `to`.
    pub(super) fn over(values: impl Iterator<Item = f64>, from: f64, to: f64) -> Self {
        let logs = values.filter(|x| *x > 0.0 && x.is_finite()).map(f64::log10);
        let (low, high) = logs.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        let (low, high) = if low <= high { (low, high) } else { (-3.0, 0.0) };
        let margin = (0.06 * (high - low)).max((LEAST_DECADES - (high - low)) / 2.0).max(0.1);
        Self { low: low - margin, high: high + margin, from, to }
    }

    /// Where `value` is drawn; outside the range, or not positive, at the nearer end.
    pub(super) fn at(&self, value: f64) -> f64 {
        let log = if value > 0.0 { value.log10().clamp(self.low, self.high) } else { self.low };
        self.from + (log - self.low) / (self.high - self.low) * (self.to - self.from)
    }

    /// Length of a decade in drawing units.
    pub(super) fn decade(&self) -> f64 {
        (self.to - self.from).abs() / (self.high - self.low)
    }

    /// Ticks: decades, thinned so that at most `most` are labelled; between them the multiples 2 to 9, or the decades
    /// that were thinned out. Where fewer than two decades are in range, 2 and 5 are labelled too.
    pub(super) fn ticks(&self, most: usize) -> Vec<Tick> {
        let (first, last) = (self.low.ceil() as i32, self.high.floor() as i32);
        let decades = (last - first + 1).max(0) as usize;
        let step = decades.div_ceil(most.max(1)).max(1) as i32;
        let mut ticks = Vec::new();
        for decade in first - 1..=last {
            let multiples = if step == 1 { 1..10 } else { 1..2 };
            for multiple in multiples {
                let log = f64::from(multiple).log10() + f64::from(decade);
                if !(self.low..=self.high).contains(&log) {
                    continue;
                }
                let labelled = match multiple {
                    1 => decade.rem_euclid(step) == 0,
                    2 | 5 => decades < 2,
                    _ => false,
                };
                let value = f64::from(multiple) * 10f64.powi(decade);
                ticks.push(Tick { value, label: labelled.then(|| name(multiple, decade)) });
            }
        }
        ticks
    }
}

/// `0.01`, `5`, `100`, `10⁻⁵`, `2·10⁻⁵`.
fn name(multiple: i32, decade: i32) -> String {
    if (-2..=3).contains(&decade) {
        return format!("{}", f64::from(multiple) * 10f64.powi(decade));
    }
    let power = format!("10{}", crate::report::text::superscript(&decade.to_string()));
    if multiple == 1 { power } else { format!("{multiple}·{power}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(values: &[f64]) -> Vec<String> {
        let axis = LogAxis::over(values.iter().copied(), 0.0, 400.0);
        axis.ticks(7).into_iter().filter_map(|tick| tick.label).collect()
    }

    #[test]
    fn every_range_has_two_to_eight_labels() {
        for exponent in -40..40 {
            for span in [0.0, 0.3, 1.0, 2.5, 6.0, 20.0, 90.0] {
                let low = 1.7 * 10f64.powi(exponent);
                let found = labels(&[low, low * 10f64.powf(span)]);
                assert!((2..=8).contains(&found.len()), "1e{exponent} + {span}: {found:?}");
            }
        }
        assert_eq!(labels(&[]).len(), 4);
        assert_eq!(labels(&[0.0, f64::NAN, f64::INFINITY]).len(), 4);
    }

    #[test]
    fn a_decade_is_as_long_everywhere() {
        let axis = LogAxis::over([1e-7, 1e3].into_iter(), 300.0, 20.0);
        for exponent in -7..3 {
            let length = axis.at(10f64.powi(exponent)) - axis.at(10f64.powi(exponent + 1));
            assert!((length - axis.decade()).abs() < 1e-9);
        }
        assert_eq!(axis.at(0.0), 300.0);
    }

    #[test]
    fn names_are_plain_where_short() {
        assert_eq!(
            ["0.01", "50", "1000", "10⁻⁵", "2·10⁴"].map(String::from),
            [name(1, -2), name(5, 1), name(1, 3), name(1, -5), name(2, 4)]
        );
    }
}
