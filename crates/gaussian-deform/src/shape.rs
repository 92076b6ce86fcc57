//! The shape of one Gaussian: scales and a quaternion, as files have them, and half-axes.

use mechanics_core::decomposition::svd;
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::{self, Matrix3};

/// B = R(q) diag(s) of scales s \[m\] and a quaternion q = (w, x, y, z) of any length; `None` if q is zero or not finite.
///
/// q is brought near length one by a power of two first, so that no q that can be normalised is refused.
pub fn axes<S: Scalar<Mask = bool>>(scales: [S; 3], quaternion: [S; 4]) -> Option<Matrix3<S>> {
    let size = quaternion.iter().fold(S::constant(0.0), |sum, q| sum + q.abs());
    let unit = size.reciprocal_power_of_two();
    if !(S::constant(0.0).less(size) && S::constant(0.0).less(unit) && size.is_finite()) {
        return None;
    }
    let [w, x, y, z] = quaternion.map(|q| q * unit);
    let two = (w * w + x * x + y * y + z * z).recip().scale(2.0);
    let [a, b, c] = scales;
    let off = |p: S, q: S, r: S, s: S| (p * q + r * s) * two;
    let one = |p: S, q: S| S::constant(1.0) - (p * p + q * q) * two;
    let scaled = |column: [S; 3], s: S| column.map(|entry| entry * s);
    Some(tensor::from_columns([
        scaled([one(y, z), off(x, y, w, z), off(x, z, -w, y)], a),
        scaled([off(x, y, -w, z), one(x, z), off(y, z, w, x)], b),
        scaled([off(x, z, w, y), off(y, z, -w, x), one(x, y)], c),
    ]))
}

/// Scales s and a unit quaternion q = (w, x, y, z), w ≥ 0, with R(q) diag(s)² R(q)ᵀ = B Bᵀ.
///
/// Where the columns of B are orthogonal to rounding, as those of every Gaussian that has not been deformed, s are their lengths, in their order, and R is B without
/// them. Otherwise B = U diag(s) Vᵀ, and R = U: the eigenvalues of B Bᵀ are s², without ever being formed, so that small scales are as accurate as
/// ε times the largest. R is always a rotation; a mirrored B (det B < 0) has the covariance of its mirror image.
pub fn scales_and_quaternion<S: Scalar<Mask = bool>>(axes: &Matrix3<S>) -> ([S; 3], [S; 4]) {
    match scaled_frame(axes) {
        Some((scales, rotation)) => (scales, quaternion(&rotation)),
        None => {
            let svd = svd(axes);
            (svd.sigma.map(Scalar::abs), quaternion(&svd.u))
        }
    }
}

/// The lengths of B's columns and their directions as a rotation, if they are orthogonal.
fn scaled_frame<S: Scalar<Mask = bool>>(axes: &Matrix3<S>) -> Option<([S; 3], Matrix3<S>)> {
    let columns = tensor::columns(axes);
    let lengths = columns.map(|c| length(&c));
    let mut unit = [0, 1, 2].map(|j| columns[j].map(|entry| entry / lengths[j]));
    let tolerance = S::constant(8.0 * S::EPSILON);
    // A length of zero makes NaN, for which no comparison holds.
    let across = |i: usize, j: usize| tensor::dot(&unit[i], &unit[j]).abs().less(tolerance);
    if !(across(0, 1) && across(0, 2) && across(1, 2)) {
        return None;
    }
    let mirrored = tensor::dot(&tensor::cross(&unit[0], &unit[1]), &unit[2]).less(S::constant(0.0));
    if mirrored {
        unit[2] = unit[2].map(|entry| -entry);
    }
    Some((lengths, tensor::from_columns(unit)))
}

/// |a|, for every length whose square would not be a normal number too.
fn length<S: Scalar<Mask = bool>>(a: &[S; 3]) -> S {
    let size = a[0].abs() + a[1].abs() + a[2].abs();
    let unit = size.reciprocal_power_of_two();
    let a = a.map(|x| x * unit);
    tensor::dot(&a, &a).sqrt() / unit
}

/// The unit quaternion (w, x, y, z) of a rotation, w ≥ 0.
///
/// 4q² of the largest component is 1 plus the fitting signs of the diagonal, at least one, so nothing cancels.
///
/// # Reference
/// Shepperd (1978), *Quaternion from rotation matrix*, J. Guidance and Control 1.
pub fn quaternion<S: Scalar<Mask = bool>>(rotation: &Matrix3<S>) -> [S; 4] {
    let c = tensor::columns(rotation);
    let (xx, yy, zz) = (c[0][0], c[1][1], c[2][2]);
    let one = S::constant(1.0);
    let squares = [one + xx + yy + zz, one + xx - yy - zz, one - xx + yy - zz, one - xx - yy + zz];
    let differences = [c[1][2] - c[2][1], c[2][0] - c[0][2], c[0][1] - c[1][0]];
    let sums = [c[1][2] + c[2][1], c[2][0] + c[0][2], c[0][1] + c[1][0]];
    let largest = (1..4).fold(0, |best, k| if squares[best].less(squares[k]) { k } else { best });
    let raw = match largest {
        0 => [squares[0], differences[0], differences[1], differences[2]],
        1 => [differences[0], squares[1], sums[2], sums[1]],
        2 => [differences[1], sums[2], squares[2], sums[0]],
        _ => [differences[2], sums[1], sums[0], squares[3]],
    };
    let norm = raw.iter().fold(S::constant(0.0), |sum, &q| q.mul_add(q, sum)).sqrt();
    let sign = one.copysign(raw[0]);
    raw.map(|q| q * sign / norm)
}
