//! Cables of unit weight a length between two ends at the same height: the reference of hanging bodies.

/// How much a cable is longer under a tension than unstretched.
pub(super) type Stretch<'a> = dyn Fn(f64) -> f64 + 'a;

/// The sag of a cable of unstretched length `length` between ends `span` apart, by bisection for the horizontal tension.
pub(super) fn sag(span: f64, length: f64, stretch: &Stretch<'_>) -> f64 {
    let (mut low, mut high) = (1e-3, 1e3);
    for _ in 0..100 {
        let middle = f64::sqrt(low * high);
        if half_span_and_sag(0.5 * length, middle, stretch)[0] < 0.5 * span {
            low = middle;
        } else {
            high = middle;
        }
    }
    half_span_and_sag(0.5 * length, low, stretch)[1]
}

/// dx/ds = λ(T) H/T, dz/ds = λ(T) s/T with T = √(H² + s²), s from the lowest point, by Simpson's rule.
fn half_span_and_sag(half: f64, horizontal: f64, stretch: &Stretch<'_>) -> [f64; 2] {
    let cells = 2000;
    let step = half / f64::from(cells);
    let slope = |s: f64| {
        let tension = horizontal.hypot(s);
        [horizontal, s].map(|part| stretch(tension) * part / tension)
    };
    let mut sums = [0.0; 2];
    for k in 0..cells {
        let s = step * f64::from(k);
        let parts = [slope(s), slope(s + 0.5 * step), slope(s + step)];
        for i in 0..2 {
            sums[i] += step / 6.0 * (parts[0][i] + 4.0 * parts[1][i] + parts[2][i]);
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For a linear cable (Irvine, *Cable Structures*, 1981, section 1.3): half the span is HL/2EA + H asinh v and the sag
    /// L²/8EA + H(√(1 + v²) − 1), v = L/2H.
    #[test]
    fn the_quadrature_agrees_with_the_elastic_catenary() {
        let (length, axial, h) = (1.25, 20.0, 0.45);
        let [half_span, depth] = half_span_and_sag(0.5 * length, h, &|tension| 1.0 + tension / axial);
        let v = 0.5 * length / h;
        assert!((half_span - 0.5 * h * length / axial - h * v.asinh()).abs() < 1e-12);
        let expected = length * length / (8.0 * axial) + h * ((1.0 + v * v).sqrt() - 1.0);
        assert!((depth - expected).abs() < 1e-12);
        assert!((sag(2.0 * half_span, length, &|tension| 1.0 + tension / axial) - depth).abs() < 1e-12);
    }

    /// The stiff limit, sag = a (cosh(1/2a) − 1) with 2a sinh(1/2a) = L, to 20 digits for L = 1.25.
    #[test]
    fn without_stretch_it_is_the_catenary() {
        assert!((sag(1.0, 1.25, &|_| 1.0) - 0.331_796_886_424_779_64).abs() < 1e-12);
    }
}
