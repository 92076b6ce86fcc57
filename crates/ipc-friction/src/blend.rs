//! Averages of normal forces: what lagging goes on with where taking them anew as they are does not settle.
//!
//! With the list L of normal forces held and the list G(L) at the minimum with it, the next list is (1 − s) L + s G(L). The share s is
//! Aitken's: where G is linear along a line, of slope γ, differences r = G(L) − L follow r₊ = (1 − s (1 − γ)) r, and s = 1/(1 − γ)
//! would have ended it. That is s₊ = −s r·(r₊ − r)/‖r₊ − r‖², here with the pushes Σ μ_s λ w n on points for r.
//!
//! # Reference
//! B. M. Irons, R. C. Tuck, *A version of the Aitken accelerator for computer iteration*, Int. J. Numer. Meth. Eng. 1, 1969;
//! U. Küttler, W. A. Wall, *Fixed-point fluid–structure interaction solvers with dynamic relaxation*, Comput. Mech. 43, 2008,
//! equation 43.

use crate::law::FrictionCoefficient;
use ipc_contact::normal_force::NormalForce;
use mechanics_core::tensor::Vec3;
use std::collections::BTreeMap;

/// A normal force with all else that decides its friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pressing {
    pub(crate) force: NormalForce,
    /// Which half-space it is against; `None` between points.
    pub(crate) half_space: Option<u32>,
    pub(crate) coefficient: FrictionCoefficient,
    /// Of the material of the second surface beyond that of its points [m/s].
    pub(crate) surface_velocity: Vec3,
}

/// Less than this part of the largest normal force is forgotten.
const NEGLIGIBLE: f64 = 1e-9;

/// What is summed of pairs with the same points.
struct Sum {
    first: Pressing,
    /// Σ sᵢ λᵢ.
    magnitude: f64,
    /// Σ sᵢ |λᵢ|: what the sums below are divided by.
    size: f64,
    normal: Vec3,
    weights: [f64; 4],
    distance: f64,
}

impl Sum {
    fn new(first: Pressing) -> Self {
        Self { first, magnitude: 0.0, size: 0.0, normal: Vec3::zeros(), weights: [0.0; 4], distance: 0.0 }
    }

    fn add(&mut self, force: &NormalForce, share: f64) {
        let part = share * force.magnitude.abs();
        self.magnitude += share * force.magnitude;
        self.size += part;
        self.normal += force.normal * part;
        self.distance += force.distance * part;
        self.weights.iter_mut().zip(force.weights()).for_each(|(sum, weight)| *sum += weight * part);
    }

    /// `None` without a direction: where all forces are zero.
    fn mean(&self) -> Option<Pressing> {
        let normal = self.normal.try_normalize(0.0)?;
        let weights = self.weights.map(|weight| weight / self.size);
        let (distance, magnitude) = (self.distance / self.size, self.magnitude);
        let force = match *self.first.force.points() {
            [a] => NormalForce::new([a], [weights[0]], normal, distance, magnitude),
            [a, b] => NormalForce::new([a, b], [weights[0], weights[1]], normal, distance, magnitude),
            [a, b, c] => {
                NormalForce::new([a, b, c], [weights[0], weights[1], weights[2]], normal, distance, magnitude)
            }
            [a, b, c, d] => NormalForce::new([a, b, c, d], weights, normal, distance, magnitude),
            _ => return None,
        };
        Some(Pressing { force, ..self.first })
    }
}

/// (1 − s) `held` + s `anew`: λ of pairs with the same points is averaged, one that only one list has counting as zero in the
/// other; so are weights and normals, in proportion to λ. `share` s is in [0, 1].
pub(crate) fn blend(held: &[Pressing], anew: &[Pressing], share: f64) -> Vec<Pressing> {
    let mut sums = BTreeMap::new();
    for (list, share) in [(held, 1.0 - share), (anew, share)] {
        for pressing in list {
            let key = (pressing.force.points().to_vec(), pressing.half_space);
            sums.entry(key).or_insert_with(|| Sum::new(*pressing)).add(&pressing.force, share);
        }
    }
    let largest = sums.values().map(|sum| sum.size).fold(0.0, f64::max);
    let kept = sums.values().filter(|sum| sum.size > NEGLIGIBLE * largest);
    kept.filter_map(Sum::mean).collect()
}

/// What normal forces taken anew count for at least.
const LEAST_SHARE: f64 = 1.0 / 64.0;

/// Σ μ_s λ w n on each of so many points \[N\] of `anew`, less that of `held`.
pub(crate) fn difference(held: &[Pressing], anew: &[Pressing], points: usize) -> Vec<Vec3> {
    let mut sums = vec![Vec3::zeros(); points];
    for (list, sign) in [(held, -1.0), (anew, 1.0)] {
        for pressing in list {
            let factor = sign * pressing.coefficient.at_rest();
            pressing.force.forces().for_each(|(point, push)| sums[point as usize] += push * factor);
        }
    }
    sums
}

/// Aitken's share after one of `share`, which brought the difference from `last` to `now`.
pub(crate) fn relaxed(share: f64, last: &[Vec3], now: &[Vec3]) -> f64 {
    let (mut product, mut square) = (0.0, 0.0);
    for (last, now) in last.iter().zip(now) {
        let change = now - last;
        product += last.dot(&change);
        square += change.norm_squared();
    }
    if square > 0.0 { (-share * product / square).clamp(LEAST_SHARE, 1.0) } else { share }
}
