//! Random and near-degenerate states.

use mechanics_core::tensor::Vec3;

/// splitmix64 (Steele, Lea, Flood 2014).
pub(crate) struct Random(pub u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// In [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// 10^u, u uniform between the exponents.
    pub(crate) fn decade(&mut self, low: f64, high: f64) -> f64 {
        10.0_f64.powf(self.between(low, high))
    }

    pub(crate) fn vector(&mut self) -> Vec3 {
        Vec3::new(self.between(-1.0, 1.0), self.between(-1.0, 1.0), self.between(-1.0, 1.0))
    }

    pub(crate) fn direction(&mut self) -> Vec3 {
        loop {
            let v = self.vector();
            if v.norm() > 0.1 && v.norm() < 1.0 {
                return v.normalize();
            }
        }
    }
}

/// How a state is made hard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Generic,
    /// d from 1e-7 of the feature's size.
    Close,
    /// Angle from 1e-5.
    Flat,
    /// Both.
    CloseAndFlat,
}

pub(crate) const KINDS: [Kind; 4] = [Kind::Generic, Kind::Close, Kind::Flat, Kind::CloseAndFlat];

fn distance(random: &mut Random, kind: Kind) -> f64 {
    match kind {
        Kind::Close => random.decade(-7.0, -1.0),
        Kind::CloseAndFlat => random.decade(-4.0, -1.0),
        _ => random.between(0.1, 1.0),
    }
}

fn second_direction(random: &mut Random, u: &Vec3, kind: Kind) -> Vec3 {
    let other = random.direction();
    match kind {
        Kind::Flat => u + other * random.decade(-5.0, -1.0),
        Kind::CloseAndFlat => u + other * random.decade(-3.0, -1.0),
        _ => other,
    }
}

pub(crate) fn points(random: &mut Random, kind: Kind) -> [Vec3; 2] {
    let x = random.vector();
    [x, x + random.direction() * distance(random, kind)]
}

/// A point over the interior of an edge, at a planted distance.
pub(crate) fn point_over_edge(random: &mut Random, kind: Kind) -> [Vec3; 3] {
    let (a, t) = (random.vector(), random.direction() * random.decade(-1.0, 0.0));
    let normal = t.cross(&random.direction()).normalize();
    let foot = a + t * random.between(0.05, 0.95);
    [foot + normal * (t.norm() * distance(random, kind)), a, a + t]
}

/// A point over the interior of a triangle, at a planted distance.
pub(crate) fn point_over_triangle(random: &mut Random, kind: Kind) -> [Vec3; 4] {
    let (a, u) = (random.vector(), random.direction());
    let v = second_direction(random, &u, kind) * random.decade(-0.5, 0.5);
    let normal = u.cross(&v).normalize();
    let (mut s, mut t) = (random.between(0.02, 0.98), random.between(0.02, 0.98));
    if s + t > 0.99 {
        (s, t) = (0.5 * s, 0.5 * t);
    }
    [a + u * s + v * t + normal * distance(random, kind), a, a + u, a + v]
}

/// Two edges whose interiors cross at a planted distance.
pub(crate) fn crossing_edges(random: &mut Random, kind: Kind) -> [Vec3; 4] {
    let (a, u) = (random.vector(), random.direction());
    let v = second_direction(random, &u, kind) * random.decade(-0.5, 0.5);
    let normal = u.cross(&v).normalize();
    let (s, t) = (random.between(0.05, 0.95), random.between(0.05, 0.95));
    let b = a + u * s + normal * distance(random, kind) - v * t;
    [a, a + u, b, b + v]
}
