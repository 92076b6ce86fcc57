//! Statics of a symmetric arch of rigid stones: is there a line of thrust within it?
//!
//! Everything above a joint pushes on what is below with F = (H, −V): V is the weight above the joint on that side of the
//! crown, H the thrust, the same in all joints. The moment of F about the origin is M − S, S = Σ W x of the stones between the first joint and this one,
//! M the moment in the first joint. The resultant passes the joint between intrados a and extrados b if its moment about b is
//! not negative and that about a not positive:
//!
//! M − S + b_x V + b_z H ≥ 0 ≥ M − S + a_x V + a_z H.
//!
//! It does not slide if |H sin φ − V cos φ| ≤ μ (H cos φ + V sin φ) at the joint's angle φ from the crown. An arch stands if some (H, M)
//! satisfies all joints (the safe theorem; with friction it is a necessary condition only, which for semicircular arches is known to decide as
//! well). For a given H the moments that are allowed are an interval, whose length is concave in H.
//!
//! # Reference
//! M. Milankovitch, *Theorie der Druckkurven*, Z. Math. Phys. 55, 1907: without sliding a semicircular arch stands from thickness over
//! mean radius = 0.1075 on. J. Heyman, *The safety of masonry arches*, Int. J. Mech. Sci. 11, 1969.

use std::f64::consts::{FRAC_PI_2, PI};

/// A semicircular arch of equal stones with plane joints and straight sides; mean radius and specific weight are one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arch {
    pub(super) stones: u32,
    /// Over the mean radius.
    pub(super) thickness: f64,
}

/// A joint of the right half.
struct Joint {
    /// From the crown.
    angle: f64,
    /// V.
    weight: f64,
    /// S.
    moment: f64,
}

impl Arch {
    fn radii(&self) -> [f64; 2] {
        [1.0 - 0.5 * self.thickness, 1.0 + 0.5 * self.thickness]
    }

    /// The joints of one half, from the crown down to the floor.
    fn joints(&self) -> Vec<Joint> {
        let wedge = PI / f64::from(self.stones);
        let [a, b] = self.radii();
        let stone = 0.5 * (b * b - a * a) * wedge.sin();
        let centroid = 2.0 / 3.0 * (0.5 * wedge).cos() * (b.powi(3) - a.powi(3)) / (b * b - a * a);
        let count = self.stones / 2;
        let first = FRAC_PI_2 - f64::from(count) * wedge;
        let mut moment = 0.0;
        let joint = |k: u32| {
            let angle = first + f64::from(k) * wedge;
            if k > 0 {
                moment += stone * centroid * (angle - 0.5 * wedge).sin();
            }
            Joint { angle, weight: stone * angle / wedge, moment }
        };
        (0..=count).map(joint).collect()
    }

    /// Whether a line of thrust exists that needs no more friction than this.
    pub(super) fn stands(&self, friction: f64) -> bool {
        let joints = self.joints();
        let [mut low, mut high] = thrusts(&joints, friction);
        if low > high {
            return false;
        }
        let [a, b] = self.radii();
        let width = |thrust: f64| {
            let bound = |joint: &Joint, r: f64| {
                let (x, z) = (r * joint.angle.sin(), r * joint.angle.cos());
                joint.moment - x * joint.weight - z * thrust
            };
            let upper = joints.iter().map(|joint| bound(joint, a)).fold(f64::INFINITY, f64::min);
            let lower = joints.iter().map(|joint| bound(joint, b)).fold(f64::NEG_INFINITY, f64::max);
            upper - lower
        };
        for _ in 0..200 {
            let third = (high - low) / 3.0;
            if width(low + third) < width(high - third) { low += third } else { high -= third }
        }
        width(0.5 * (low + high)) >= 0.0
    }

    /// The least thickness of an arch of so many stones that stands, to 1e-6.
    pub(super) fn limit(stones: u32, friction: f64) -> f64 {
        let (mut falls, mut stands) = (1e-3, 1.0);
        while stands - falls > 1e-6 {
            let thickness = 0.5 * (falls + stands);
            let side = if (Self { stones, thickness }).stands(friction) { &mut stands } else { &mut falls };
            *side = thickness;
        }
        stands
    }
}

/// The least and the largest thrust that no joint slides under.
fn thrusts(joints: &[Joint], friction: f64) -> [f64; 2] {
    let weight = joints.last().map_or(0.0, |joint| joint.weight);
    joints.iter().fold([0.0, 10.0 * weight], |[low, high], joint| {
        let (s, c) = joint.angle.sin_cos();
        let least = joint.weight * (c - friction * s) / (s + friction * c).max(f64::MIN_POSITIVE);
        let grip = s - friction * c;
        let largest = if grip > 0.0 { joint.weight * (c + friction * s) / grip } else { f64::INFINITY };
        [low.max(least), high.min(largest)]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Milankovitch 1907, for infinitely many stones.
    #[test]
    fn the_limit_of_many_stones_is_milankovitchs() {
        let limit = Arch::limit(1001, 10.0);
        assert!((limit - 0.1075).abs() < 1e-4, "{limit}");
    }

    /// Below μ = 0.309 every semicircular arch slides apart, however thick (C. Casapulla, L. Lauro, *A simple computation tool for
    /// the limit-state analysis of masonry arches*, 2000).
    #[test]
    fn friction_that_is_too_low_lets_thick_arches_slide() {
        let thick = Arch { stones: 301, thickness: 0.25 };
        assert!(!thick.stands(0.0) && !thick.stands(0.308) && thick.stands(0.311));
        assert!(!(Arch { stones: 301, thickness: 0.10 }).stands(10.0));
    }
}
