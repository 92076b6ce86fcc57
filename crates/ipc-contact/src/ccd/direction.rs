//! The direction in which a polygon lies from the origin: the normal of the plane that separates two features best.
//!
//! Nothing here is safe or unsafe: a bad direction makes a certificate fail or weak, never wrong.

use mechanics_core::tensor::{cross, dot};

/// a − b.
#[inline(always)]
pub(super) fn minus(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// a + s b.
#[inline(always)]
fn plus(a: &[f64; 3], s: f64, b: &[f64; 3]) -> [f64; 3] {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}

/// The vector from the origin to the closest point of a convex polygon, or where that is inside the polygon a normal of
/// it, of any length, that points from the origin to the polygon.
#[inline]
pub(super) fn closest<const K: usize>(v: &[[f64; 3]; K]) -> [f64; 3] {
    match K {
        1 => v[0],
        2 => to_segment(&v[0], &v[1]),
        _ => to_polygon(v),
    }
}

/// The vector from the origin to the closest point of a segment. In the interior it is made normal to the segment a
/// second time: what rounding left of its part along the segment would tilt a plane close to the origin.
#[inline]
fn to_segment(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    let edge = minus(b, a);
    let squared = dot(&edge, &edge);
    let along = -dot(a, &edge);
    if !(along > 0.0) {
        return *a;
    }
    if along >= squared {
        return *b;
    }
    let foot = plus(a, along / squared, &edge);
    plus(&foot, -dot(&foot, &edge) / squared, &edge)
}

/// The same for a triangle or a parallelogram v₀ + α e + β f.
#[inline]
fn to_polygon<const K: usize>(v: &[[f64; 3]; K]) -> [f64; 3] {
    let e = minus(&v[1], &v[0]);
    let f = minus(&v[K - 1], &v[0]);
    let (ee, ef, ff) = (dot(&e, &e), dot(&e, &f), dot(&f, &f));
    let (ev, fv) = (-dot(&e, &v[0]), -dot(&f, &v[0]));
    // Cramer's rule for the foot of the origin in the plane, times the determinant.
    let determinant = ee * ff - ef * ef;
    let alpha = ev * ff - fv * ef;
    let beta = fv * ee - ev * ef;
    let outside = if K == 3 {
        [beta < 0.0, alpha + beta > determinant, alpha < 0.0, false]
    } else {
        [beta < 0.0, alpha > determinant, beta > determinant, alpha < 0.0]
    };
    if determinant > 0.0 && !outside.contains(&true) {
        return facing(cross(&e, &f), v);
    }
    // The closest point lies on an edge that the foot is outside of, or on any if the polygon is but a line.
    let mut best = v[0];
    let mut least = f64::INFINITY;
    for k in 0..K {
        if outside[k] || !(determinant > 0.0) {
            let vector = to_segment(&v[k], &v[(k + 1) % K]);
            let squared = dot(&vector, &vector);
            if squared < least {
                (best, least) = (vector, squared);
            }
        }
    }
    best
}

/// `normal` or its opposite, whichever points from the origin to the polygon.
#[inline]
fn facing<const K: usize>(normal: [f64; 3], v: &[[f64; 3]; K]) -> [f64; 3] {
    let mut sum = 0.0;
    for corner in v {
        sum += dot(&normal, corner);
    }
    if sum < 0.0 { normal.map(|c| -c) } else { normal }
}

/// How far the polygon lies beyond the origin in a direction: min over the corners of n · v / |n|.
#[inline]
pub(super) fn support<const K: usize>(n: &[f64; 3], v: &[[f64; 3]; K]) -> f64 {
    let mut least = f64::INFINITY;
    for corner in v {
        least = least.min(dot(n, corner));
    }
    least / dot(n, n).sqrt()
}

/// The direction with the largest [`support`] among all that a closest point can have, each computed with care for
/// cancellation: for polygons so thin or so close that [`closest`] takes the wrong one or loses its digits.
#[cold]
pub(super) fn best<const K: usize>(v: &[[f64; 3]; K]) -> [f64; 3] {
    let mut best = closest(v);
    let mut most = support(&best, v);
    let mut consider = |n: [f64; 3]| {
        let s = support(&n, v);
        // NaN never wins, and never stays.
        if s > most || most.is_nan() {
            (best, most) = (n, s);
        }
    };
    for k in 0..K {
        let next = (k + 1) % K;
        consider(v[k]);
        if K > 1 {
            consider(to_segment(&v[k], &v[next]));
        }
        if K > 2 {
            let normal = accurate_cross(&minus(&v[next], &v[k]), &minus(&v[(k + 2) % K], &v[k]));
            consider(normal);
            consider(normal.map(|c| -c));
        }
    }
    best
}

/// a × b, every component to a few units in its last place.
fn accurate_cross(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    let minor = |i: usize, j: usize| {
        let (p, p_error) = exact_product(a[i], b[j]);
        let (q, q_error) = exact_product(a[j], b[i]);
        (p - q) + (p_error - q_error)
    };
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}

/// a b as the sum of its rounded value and the error of that (T. J. Dekker, 1971), without a fused instruction.
fn exact_product(a: f64, b: f64) -> (f64, f64) {
    let split = |x: f64| {
        let scaled = 134_217_729.0 * x;
        let high = scaled - (scaled - x);
        (high, x - high)
    };
    let product = a * b;
    let ((ah, al), (bh, bl)) = (split(a), split(b));
    (product, ((ah * bh - product) + ah * bl + al * bh) + al * bl)
}
