//! Queries whose first contact is known to be no later than a planted time, exactly: all coordinates are integers
//! times powers of two, so that f64 holds every position without rounding.

use crate::random::Random;
use mechanics_core::tensor::Vec3;

/// Which two features.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Pair {
    /// The first two points.
    PointPoint,
    /// The first three.
    PointEdge,
    PointTriangle,
    EdgeEdge,
}

/// A query of four points, and the time at which its features touch.
#[derive(Clone, Debug)]
pub(crate) struct Query {
    pub(crate) pair: Pair,
    pub(crate) start: [Vec3; 4],
    pub(crate) end: [Vec3; 4],
    /// A time at which the distance is exactly `separation`.
    pub(crate) contact: f64,
    pub(crate) separation: f64,
    pub(crate) family: &'static str,
}

impl Query {
    /// The same contact as one of four points: of a point with a triangle that it meets on its rim.
    pub(crate) fn of_four_points(mut self) -> Self {
        if self.pair != Pair::EdgeEdge {
            self.pair = Pair::PointTriangle;
        }
        self
    }
}

pub(crate) const FAMILIES: [&str; 12] = [
    "general",
    "slow",
    "coplanar",
    "parallel",
    "grazing",
    "at a corner",
    "no area",
    "no length",
    "starts close",
    "far from the origin",
    "common motion",
    "separated",
];

/// An integer vector with entries up to `size`.
fn vector(random: &mut Random, size: i64) -> [i64; 3] {
    std::array::from_fn(|_| random.integer(-size, size))
}

/// Weights in eighths that are not negative and sum to eight.
fn weights(random: &mut Random, corners: usize) -> [i64; 3] {
    let a = if corners > 1 { random.integer(0, 8) } else { 0 };
    let b = if corners > 2 { random.integer(0, 8 - a) } else { 0 };
    [8 - a - b, a, b]
}

/// The query number `seed` of a family.
pub(crate) fn query(family: &'static str, seed: u64) -> Query {
    let mut random = Random(seed.wrapping_mul(0x1234_5678_9ABC_DEF1) ^ family.len() as u64);
    let r = &mut random;
    let pair = [Pair::PointTriangle, Pair::EdgeEdge][(r.bits() % 2) as usize];
    let pair = if seed % 16 < 14 { pair } else { [Pair::PointPoint, Pair::PointEdge][seed as usize % 2] };
    let size = 1 << r.integer(1, 12);
    // Positions at the time of contact and displacements over the whole motion, in units of 1/8.
    let mut x = [(); 4].map(|()| vector(r, size).map(|c| 8 * c));
    let mut u = [(); 4].map(|()| vector(r, size).map(|c| 8 * c));
    let mut offset = [0; 3];
    let mut separation = 0;
    match family {
        "slow" => u = u.map(|d| d.map(|c| c / size)),
        "coplanar" => {
            x.iter_mut().for_each(|p| p[2] = 8 * size);
            u.iter_mut().for_each(|d| d[2] = 0);
        }
        "parallel" => {
            let along: [i64; 3] = std::array::from_fn(|c| x[1][c] - x[0][c]);
            let factor = r.integer(1, 3);
            x[3] = std::array::from_fn(|c| x[2][c] + factor * along[c]);
            if r.bits() % 2 == 0 {
                u[1] = u[0];
                u[3] = u[2];
            }
        }
        "grazing" => {
            x[1..].iter_mut().for_each(|p| p[2] = 0);
            u[1..].iter_mut().for_each(|d| d[2] = 0);
            u[0][2] = 0;
        }
        "no area" => {
            x[3] = std::array::from_fn(|c| 2 * x[2][c] - x[1][c]);
            if r.bits() % 2 == 0 {
                u[3] = std::array::from_fn(|c| 2 * u[2][c] - u[1][c]);
            }
        }
        "no length" => {
            let (a, b) = if r.bits() % 2 == 0 { (2, 3) } else { (1, 0) };
            x[a] = x[b];
            if r.bits() % 4 != 0 {
                u[a] = u[b];
            }
        }
        "far from the origin" => offset = vector(r, 1 << 27).map(|c| 8 * c),
        "common motion" => {
            let common = vector(r, 1 << 24).map(|c| 8 * c);
            u.iter_mut().for_each(|d| (0..3).for_each(|c| d[c] = d[c] / size + common[c]));
        }
        "separated" => {
            x.iter_mut().for_each(|p| p[2] = 0);
            separation = 8 * r.integer(1, size);
        }
        _ => {}
    }
    // The contact: the point on the triangle, or the point with weights on the one edge on the other edge's point.
    let on_corner = family == "at a corner";
    match pair {
        Pair::PointPoint | Pair::PointEdge | Pair::PointTriangle => {
            let corners = 1 + (pair == Pair::PointEdge) as usize + 2 * (pair == Pair::PointTriangle) as usize;
            let w = if on_corner { [8, 0, 0] } else { weights(r, corners) };
            let target: [i64; 3] = std::array::from_fn(|c| (0..3).map(|k| w[k] * (x[k + 1][c] / 8)).sum());
            x[0] = target;
            x[0][2] += separation;
        }
        Pair::EdgeEdge => {
            let w = if on_corner { [8, 0, 0] } else { weights(r, 2) };
            let target: [i64; 3] = std::array::from_fn(|c| (0..2).map(|k| w[k] * (x[k + 2][c] / 8)).sum());
            // The first edge goes through the target, which halves it or ends it.
            let reach: [i64; 3] = std::array::from_fn(|c| x[1][c] - x[0][c]);
            x[0] = std::array::from_fn(|c| target[c] - reach[c]);
            x[1] = if r.bits() % 4 == 0 { target } else { std::array::from_fn(|c| target[c] + reach[c]) };
            (0..2).for_each(|k| x[k][2] += separation);
        }
    }
    let bits = if family == "starts close" { 36 } else { r.integer(1, 10) };
    let steps = 1_i64 << bits;
    let contact = if family == "starts close" { r.integer(1, 4) } else { r.integer(1, steps) };
    place(pair, &x, &u, offset, separation, (contact, steps), family, r)
}

#[allow(clippy::too_many_arguments, reason = "one place that scales all of them")]
fn place(
    pair: Pair,
    x: &[[i64; 3]; 4],
    u: &[[i64; 3]; 4],
    offset: [i64; 3],
    separation: i64,
    (contact, steps): (i64, i64),
    family: &'static str,
    random: &mut Random,
) -> Query {
    let scale = 2.0_f64.powi(random.integer(-27, 27) as i32 - 3);
    let at = |t: i64| -> [Vec3; 4] {
        std::array::from_fn(|k| {
            Vec3::from_fn(|c, _| {
                let scaled =
                    i128::from(x[k][c] + offset[c]) * i128::from(steps) + i128::from(t) * i128::from(u[k][c]);
                assert!(scaled.abs() < 1 << 53, "{family}: a planted position must be exact");
                scaled as f64 / steps as f64 * scale
            })
        })
    };
    Query {
        pair,
        start: at(-contact),
        end: at(steps - contact),
        contact: contact as f64 / steps as f64,
        separation: separation as f64 * scale,
        family,
    }
}
