//! One extrapolated central difference, its step chosen by a sweep.

/// Steps tried, relative to the size of the unknowns: 10^(−1 − k/2).
const STEPS: usize = 15;

/// A numeric derivative.
pub(super) struct Difference {
    pub(super) derivative: Vec<f64>,
    /// The step that showed it best.
    pub(super) step: f64,
    /// What rounding alone may make of it: that of the values, over the step, and that of what is varied, times the
    /// second derivative. Matters where the derivative vanishes.
    pub(super) noise: f64,
}

/// The derivative at zero of `function(offset, values)`. `unit` is the size of what is varied.
pub(super) fn differentiate(
    unit: f64,
    length: usize,
    mut function: impl FnMut(f64, &mut [f64]),
) -> Difference {
    let mut best: Option<(f64, Vec<f64>, f64)> = None;
    let mut before: Option<Vec<f64>> = None;
    for k in 0..STEPS {
        // A power of two moves the unknowns by exactly the step where they are of the same size.
        let step = (unit * 10f64.powf(-1.0 - 0.5 * k as f64)).log2().round().exp2();
        let (wide, _) = central(step, length, &mut function);
        let (narrow, size) = central(0.5 * step, length, &mut function);
        let now: Vec<f64> =
            wide.iter().zip(&narrow).map(|(wide, narrow)| (4.0 * narrow - wide) / 3.0).collect();
        if let Some(before) = &before {
            // Neighbours may agree by chance where both are rounding: nothing is better than its rounding.
            let doubt = distance(&now, before) + f64::EPSILON * size / step;
            if best.as_ref().is_none_or(|(least, ..)| doubt < *least) {
                best = Some((doubt, now.clone(), step));
            }
        }
        before = Some(now);
    }
    let (derivative, step) = match best {
        Some((_, derivative, step)) => (derivative, step),
        None => (before.unwrap_or_default(), unit),
    };
    let noise = noise(unit, step, length, &mut function);
    Difference { derivative, step, noise }
}

/// 16 ε (|f| / step + unit |f''|), the largest of each; zero where that is not finite.
fn noise(unit: f64, step: f64, length: usize, function: &mut impl FnMut(f64, &mut [f64])) -> f64 {
    let [behind, here, ahead] = [-step, 0.0, step].map(|offset| {
        let mut values = vec![0.0; length];
        function(offset, &mut values);
        values
    });
    let (mut size, mut curvature) = (0.0_f64, 0.0_f64);
    for ((behind, here), ahead) in behind.iter().zip(&here).zip(&ahead) {
        size = size.max(behind.abs()).max(ahead.abs());
        curvature = curvature.max((behind - 2.0 * here + ahead).abs() / (step * step));
    }
    let noise = 16.0 * f64::EPSILON * (size / step + unit * curvature);
    if noise.is_finite() { noise } else { 0.0 }
}

/// `(f(ε) − f(−ε)) / 2ε` with the step ε, and the largest value met.
fn central(step: f64, length: usize, function: &mut impl FnMut(f64, &mut [f64])) -> (Vec<f64>, f64) {
    let (mut ahead, mut behind) = (vec![0.0; length], vec![0.0; length]);
    function(step, &mut ahead);
    function(-step, &mut behind);
    let size = ahead.iter().chain(&behind).fold(0.0, |m: f64, v| m.max(v.abs()));
    (ahead.iter().zip(&behind).map(|(a, b)| (a - b) / (2.0 * step)).collect(), size)
}

/// The largest difference; infinite if there is a NaN.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |m: f64, (a, b)| {
        let difference = (a - b).abs();
        if difference.is_nan() { f64::INFINITY } else { m.max(difference) }
    })
}
