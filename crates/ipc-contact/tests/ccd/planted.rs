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
    let pair = if r.one_in(2) { Pair::PointTriangle } else { Pair::EdgeEdge };
    let pair = if seed % 16 < 14 { pair } else { [Pair::PointPoint, Pair::PointEdge][seed as usize % 2] };
    let size = 1 << r.integer(1, 12);
    let x = [(); 4].map(|()| vector(r, size).map(|c| 8 * c));
    let u = [(); 4].map(|()| vector(r, size).map(|c| 8 * c));
    let mut draft = Draft { family, pair, x, u, offset: [0; 3], separation: 0 };
    draft.shape(size, r);
    draft.touch(r);
    let bits = if family == "starts close" { 36 } else { r.integer(1, 10) };
    let steps = 1_i64 << bits;
    let contact = if family == "starts close" { r.integer(1, 4) } else { r.integer(1, steps) };
    draft.place(contact, steps, r)
}

/// A query in whole numbers.
struct Draft {
    family: &'static str,
    pair: Pair,
    /// Positions at the time of contact, in units of 1/8.
    x: [[i64; 3]; 4],
    /// Displacements over the whole motion, in the same units.
    u: [[i64; 3]; 4],
    offset: [i64; 3],
    separation: i64,
}

impl Draft {
    /// What makes the family.
    fn shape(&mut self, size: i64, r: &mut Random) {
        let Self { x, u, .. } = self;
        match self.family {
            "slow" => *u = u.map(|d| d.map(|c| c / size)),
            "coplanar" => {
                x.iter_mut().for_each(|p| p[2] = 8 * size);
                u.iter_mut().for_each(|d| d[2] = 0);
            }
            "parallel" => {
                let factor = r.integer(1, 3);
                x[3] = std::array::from_fn(|c| x[2][c] + factor * (x[1][c] - x[0][c]));
                if r.one_in(2) {
                    (u[1], u[3]) = (u[0], u[2]);
                }
            }
            "grazing" => {
                x[1..].iter_mut().for_each(|p| p[2] = 0);
                u.iter_mut().for_each(|d| d[2] = 0);
            }
            "no area" => {
                x[3] = std::array::from_fn(|c| 2 * x[2][c] - x[1][c]);
                if r.one_in(2) {
                    u[3] = std::array::from_fn(|c| 2 * u[2][c] - u[1][c]);
                }
            }
            "no length" => {
                let (a, b) = if r.one_in(2) { (2, 3) } else { (1, 0) };
                x[a] = x[b];
                if !r.one_in(4) {
                    u[a] = u[b];
                }
            }
            "far from the origin" => self.offset = vector(r, 1 << 27).map(|c| 8 * c),
            "common motion" => {
                let common = vector(r, 1 << 24).map(|c| 8 * c);
                *u = u.map(|d| std::array::from_fn(|c| d[c] / size + common[c]));
            }
            "separated" => {
                x.iter_mut().for_each(|p| p[2] = 0);
                self.separation = 8 * r.integer(1, size);
            }
            _ => {}
        }
    }

    /// Moves the first feature to where it touches the second, or is a separation above it.
    fn touch(&mut self, r: &mut Random) {
        let x = &mut self.x;
        let (first, corners) = match self.pair {
            Pair::PointPoint => (1, 1),
            Pair::PointEdge => (1, 2),
            Pair::PointTriangle => (1, 3),
            Pair::EdgeEdge => (2, 2),
        };
        let w = if self.family == "at a corner" { [8, 0, 0] } else { weights(r, corners) };
        let target: [i64; 3] =
            std::array::from_fn(|c| (0..corners).map(|k| w[k] * (x[first + k][c] / 8)).sum());
        if self.pair == Pair::EdgeEdge {
            // The target halves the first edge or ends it.
            let reach: [i64; 3] = std::array::from_fn(|c| x[1][c] - x[0][c]);
            x[0] = std::array::from_fn(|c| target[c] - reach[c]);
            x[1] = if r.one_in(4) { target } else { std::array::from_fn(|c| target[c] + reach[c]) };
        } else {
            x[0] = target;
        }
        x[..first].iter_mut().for_each(|p| p[2] += self.separation);
    }

    /// Scales it by a power of two, with the contact at `contact` of `steps` parts of the motion.
    fn place(self, contact: i64, steps: i64, r: &mut Random) -> Query {
        let scale = 2.0_f64.powi(r.integer(-27, 27) as i32 - 3);
        let coordinate = |k: usize, c: usize, t: i64| {
            let moved = i128::from(t) * i128::from(self.u[k][c]);
            let scaled = i128::from(self.x[k][c] + self.offset[c]) * i128::from(steps) + moved;
            assert!(scaled.abs() < 1 << 53, "{}: a planted position must be exact", self.family);
            scaled as f64 / steps as f64 * scale
        };
        let at = |t: i64| std::array::from_fn(|k| Vec3::from_fn(|c, _| coordinate(k, c, t)));
        Query {
            pair: self.pair,
            start: at(-contact),
            end: at(steps - contact),
            contact: contact as f64 / steps as f64,
            separation: self.separation as f64 * scale,
            family: self.family,
        }
    }
}
