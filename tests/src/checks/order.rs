//! Observed order of convergence: least squares in log–log with a confidence interval.
//!
//! For points (hᵢ, eᵢ) with xᵢ = ln hᵢ, yᵢ = ln eᵢ the order is the slope p = Σ(xᵢ − x̄)(yᵢ − ȳ) / Σ(xᵢ − x̄)². With
//! residuals rᵢ = yᵢ − ȳ − p(xᵢ − x̄) its standard error is s = √(Σrᵢ² / (n − 2) / Σ(xᵢ − x̄)²), and the 95 % confidence
//! interval is p ± t·s, where t is the 0.975 quantile of Student's distribution with n − 2 degrees of freedom.
//!
//! **Round-off floor.** Points on it say nothing about the order and are left out. A point is on the floor when its
//! error is zero or at most the measure's stated `floor`; or when it is within a factor of 100 of that floor and
//! the error from the next coarser point to it fell by less than half the expected order. Without a stated floor
//! only exact zeros are left out, so that an error that stalls for any other reason is seen.
//!
//! # Reference
//! N. R. Draper, H. Smith, *Applied Regression Analysis*, 3rd ed., 1998, ch. 1 (slope and its interval);
//! M. Abramowitz, I. Stegun, *Handbook of Mathematical Functions*, 1964, 26.7.5 (the quantile).

use std::cmp::Ordering;

/// A fitted order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// The slope of log error over log ladder value.
    pub order: f64,
    /// Half-width of its 95 % confidence interval; 0 for two points.
    pub half_width: f64,
    /// Points used.
    pub points: usize,
}

/// One point of a line: the ladder's value and the error there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// The ladder's value.
    pub ladder: f64,
    /// The error.
    pub error: f64,
}

/// The samples, coarse to fine, that are not on the round-off floor.
pub fn above_floor(samples: &[Sample], floor: Option<f64>, expected_order: f64) -> Vec<Sample> {
    let floor = floor.unwrap_or(0.0);
    let stagnates = |i: usize| {
        let (coarse, fine) = (samples[i - 1], samples[i]);
        let slope = (coarse.error / fine.error).ln() / (coarse.ladder / fine.ladder).ln();
        // Orders in a rising ladder (cells, particles) are negative: what counts is the fall along the ladder.
        slope * expected_order.signum() < 0.5 * expected_order.abs()
    };
    let on_floor = |i: usize| {
        let error = samples[i].error;
        error <= floor || (i > 0 && error <= 100.0 * floor && stagnates(i))
    };
    (0..samples.len()).filter(|&i| !on_floor(i)).map(|i| samples[i]).collect()
}

/// Fits the order; `None` with fewer than two points.
pub fn fit(samples: &[Sample]) -> Option<Fit> {
    let count = samples.len();
    if count < 2 {
        return None;
    }
    let mean = |value: fn(&Sample) -> f64| samples.iter().map(value).sum::<f64>() / count as f64;
    let (x_mean, y_mean) = (mean(|s| s.ladder.ln()), mean(|s| s.error.ln()));
    let centred = || samples.iter().map(|s| (s.ladder.ln() - x_mean, s.error.ln() - y_mean));
    let x_spread: f64 = centred().map(|(x, _)| x * x).sum();
    let order = centred().map(|(x, y)| x * y).sum::<f64>() / x_spread;
    let residual: f64 = centred().map(|(x, y)| (y - order * x).powi(2)).sum();
    let half_width = match count.cmp(&2) {
        Ordering::Greater => {
            let freedom = count - 2;
            student_quantile(freedom) * (residual / freedom as f64 / x_spread).sqrt()
        }
        _ => 0.0,
    };
    Some(Fit { order, half_width, points: count })
}

/// The 0.975 quantile of Student's distribution, to four digits or better.
fn student_quantile(freedom: usize) -> f64 {
    const FIRST: [f64; 12] = [
        12.7062, 4.30265, 3.18245, 2.77645, 2.57058, 2.44691, 2.36462, 2.30600, 2.26216, 2.22814, 2.20099,
        2.17881,
    ];
    match FIRST.get(freedom - 1) {
        Some(&quantile) => quantile,
        None => {
            let (z, n) = (1.959_964_f64, freedom as f64);
            z + (z.powi(3) + z) / (4.0 * n)
                + (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / (96.0 * n * n)
                + (3.0 * z.powi(7) + 19.0 * z.powi(5) + 17.0 * z.powi(3) - 15.0 * z) / (384.0 * n.powi(3))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(values: &[(f64, f64)]) -> Vec<Sample> {
        values.iter().map(|&(ladder, error)| Sample { ladder, error }).collect()
    }

    #[test]
    fn an_exact_power_is_recovered_in_falling_and_rising_ladders() {
        for order in [0.5, 1.0, 2.0, 4.0, -2.0] {
            let line: Vec<_> = [0.8, 0.4, 0.2, 0.1, 0.05]
                .map(|h: f64| Sample { ladder: h, error: 3.0 * h.powf(order) })
                .to_vec();
            let fit = fit(&line).expect("five points");
            assert!(
                (fit.order - order).abs() < 1e-12 && fit.half_width < 1e-12 && fit.points == 5,
                "{fit:?}"
            );
        }
    }

    #[test]
    fn slope_and_interval_match_an_independent_calculation() {
        // Python's statistics.linear_regression on the logarithms; the standard error through its correlation,
        // |p|√((1/r² − 1)/3); t(0.975, 3) = 3.1824463 from tables.
        let line =
            samples(&[(0.5, 0.26), (0.25, 0.061), (0.125, 0.0152), (0.0625, 0.0036), (0.03125, 0.00093)]);
        let fit = fit(&line).expect("five points");
        assert!((fit.order - 2.033687081).abs() < 1e-6, "{fit:?}");
        assert!((fit.half_width - 3.182_446_3 * 0.012879280).abs() < 1e-6, "{fit:?}");
    }

    #[test]
    fn quantiles_match_tables() {
        for (freedom, quantile) in
            [(1, 12.7062), (6, 2.44691), (12, 2.17881), (13, 2.16037), (20, 2.08596), (60, 2.00030)]
        {
            assert!(
                (student_quantile(freedom) - quantile).abs() < 2e-4,
                "{freedom}: {}",
                student_quantile(freedom)
            );
        }
    }

    #[test]
    fn two_points_have_a_slope_and_no_interval_and_one_has_neither() {
        let two = fit(&samples(&[(0.2, 0.04), (0.1, 0.01)])).expect("two points");
        assert!((two.order - 2.0).abs() < 1e-12 && two.half_width == 0.0);
        assert_eq!(fit(&samples(&[(0.2, 0.04)])), None);
    }

    #[test]
    fn points_on_the_floor_are_left_out_and_a_stall_above_it_is_not() {
        // Order 4 down to round-off at 2e-15, where the error wanders.
        let line = samples(&[
            (0.1, 1e-8),
            (0.01, 1e-12),
            (0.001, 3e-14),
            (0.0001, 5e-14),
            (0.00001, 1e-15),
            (0.000001, 0.0),
        ]);
        let kept = above_floor(&line, Some(2e-15), 4.0);
        assert_eq!(kept, line[..2]);
        assert!((fit(&kept).expect("two points").order - 4.0).abs() < 1e-9);

        let stalled = samples(&[(0.1, 1e-2), (0.01, 1e-4), (0.001, 1e-4), (0.0001, 1e-4)]);
        assert_eq!(above_floor(&stalled, Some(1e-14), 2.0), stalled);
        assert!(fit(&stalled).expect("four points").order < 1.0);

        // A rising ladder: cells, negative order.
        let cells = samples(&[(10.0, 1e-6), (100.0, 1e-12), (1000.0, 2e-12)]);
        assert_eq!(above_floor(&cells, Some(1e-13), -6.0), cells[..2]);
        // Without a stated floor only exact zeros go.
        assert_eq!(above_floor(&line, None, 4.0), line[..5]);
    }
}
