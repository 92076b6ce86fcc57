//! Ordinary differential equations to the last digits.

/// Substeps of the modified midpoint rule, of which the results are extrapolated.
const COUNTS: [usize; 7] = [2, 4, 6, 8, 10, 12, 14];

/// y(t + h) from y(t), y′ = f(t, y), by Gragg's extrapolated midpoint rule of order 14.
///
/// The rule's error is a series in (h/n)², so that polynomial extrapolation by the scheme of Aitken and Neville gains two orders a column.
///
/// # Reference
/// E. Hairer, S. P. Nørsett, G. Wanner, *Solving Ordinary Differential Equations I*, 2nd ed., 1993, section II.9.
pub(super) fn advanced<const N: usize>(
    f: &impl Fn(f64, &[f64; N]) -> [f64; N],
    t: f64,
    y: &[f64; N],
    h: f64,
) -> [f64; N] {
    let mut table: Vec<[f64; N]> = Vec::new();
    for (j, &count) in COUNTS.iter().enumerate() {
        let mut value = midpoint(f, t, y, h, count);
        // table[k] holds column k of the row before.
        for k in 0..j {
            let ratio = (count as f64 / COUNTS[j - k - 1] as f64).powi(2) - 1.0;
            let finer = std::array::from_fn(|i| value[i] + (value[i] - table[k][i]) / ratio);
            table[k] = value;
            value = finer;
        }
        table.push(value);
    }
    table[COUNTS.len() - 1]
}

/// The midpoint rule with Euler's first step; without smoothing at the end, which the even counts do not need.
fn midpoint<const N: usize>(
    f: &impl Fn(f64, &[f64; N]) -> [f64; N],
    t: f64,
    y: &[f64; N],
    h: f64,
    count: usize,
) -> [f64; N] {
    let step = h / count as f64;
    let slope = f(t, y);
    let mut before = *y;
    let mut now: [f64; N] = std::array::from_fn(|i| y[i] + step * slope[i]);
    for k in 1..count {
        let slope = f(t + k as f64 * step, &now);
        let next = std::array::from_fn(|i| before[i] + 2.0 * step * slope[i]);
        before = std::mem::replace(&mut now, next);
    }
    now
}

#[cfg(test)]
mod tests {
    use super::advanced;

    /// The weights of the last column, Π n²ⱼ/(n²ⱼ − n²ₖ), have magnitudes of 56 in all: so much of the rounding of a value, of the size of one,
    /// may come into a step.
    const ROUNDING: f64 = 56.0 * f64::EPSILON;

    /// y″ = −y over a turn in 16 steps of 0.4, and y′ = −y² from 1 in 20 steps, whose solution is 1/(1 + t).
    #[test]
    fn known_solutions_to_the_last_digits() {
        let mut y = [1.0, 0.0];
        for k in 0..16 {
            y = advanced(&|_, y: &[f64; 2]| [y[1], -y[0]], 0.4 * f64::from(k), &y, 0.4);
        }
        let (sine, cosine) = 6.4_f64.sin_cos();
        let bound = 16.0 * ROUNDING;
        assert!((y[0] - cosine).abs() < bound && (y[1] + sine).abs() < bound, "{y:?}");
        let mut y = [1.0];
        for k in 0..20 {
            y = advanced(&|_, y: &[f64; 1]| [-y[0] * y[0]], 0.1 * f64::from(k), &y, 0.1);
        }
        assert!((y[0] - 1.0 / 3.0).abs() < 20.0 * ROUNDING, "{y:?}");
    }
}
