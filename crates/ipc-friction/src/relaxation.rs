//! Lagging that would not settle by itself.
//!
//! Lagging is a fixed-point iteration: with the normal forces λ a minimisation finds positions, at which contact has the normal forces
//! F(λ); it settles where λ = F(λ). Where friction is strong and a blow hard, more friction slows a body so much that the normal
//! force falls, which makes friction weaker, and the plain iteration λ ← F(λ) goes to and fro for ever: an eigenvalue of F′ is below −1.
//! λ ← λ + ω (F(λ) − λ) with 0 < ω ≤ 1 has the same fixed points and damps that. ω is found by Aitken's rule for vectors, from the
//! differences r of friction forces before and after normal forces are taken anew, in two successive passes:
//!
//! ω ← −ω r₀·(r₁ − r₀)/‖r₁ − r₀‖², within [1/64, 1],
//!
//! which is 1/(1 + k) for a single eigenvalue −k, where one more pass ends it. The first passes are plain.
//!
//! # Reference
//! B. M. Irons, R. C. Tuck, *A version of the Aitken accelerator for computer iteration*, Int. J. Numer. Methods Eng. 1, 1969.
//! U. Küttler, W. A. Wall, *Fixed-point fluid–structure interaction solvers with dynamic relaxation*, Comput. Mech. 43, 2008, equation 44.

use crate::law::FrictionCoefficient;
use ipc_contact::normal_force::NormalForce;
use mechanics_core::tensor::Vec3;
use std::collections::BTreeMap;

/// Passes before anything is relaxed.
const PLAIN: u64 = 5;
/// ω is at least this.
const LEAST: f64 = 1.0 / 64.0;
/// A normal force that was given up fades out; below this part of the largest it is gone.
const GONE: f64 = 1e-9;

/// A normal force as friction holds it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Held {
    pub(crate) force: NormalForce,
    pub(crate) coefficient: FrictionCoefficient,
    /// Of the half-space's material [m/s].
    pub(crate) surface_velocity: Vec3,
    /// The half-space of a pair of one point.
    pub(crate) half_space: Option<u32>,
}

/// Which pair it is: its points, and its half-space; and which of those with the same.
type Key = ([u32; 4], Option<u32>, u32);

fn keys(list: &[Held]) -> Vec<Key> {
    let mut seen = BTreeMap::new();
    let key = |held: &Held| {
        let mut points = [u32::MAX; 4];
        points[..held.force.points().len()].copy_from_slice(held.force.points());
        let occurrence: &mut u32 = seen.entry((points, held.half_space)).or_insert(0);
        *occurrence += 1;
        (points, held.half_space, *occurrence)
    };
    list.iter().map(key).collect()
}

/// λ + ω (F(λ) − λ) for `used` λ and F(λ) taken `anew`: magnitudes are blended, weights and normals are the new ones. Pairs of only one
/// list count as zero in the other.
pub(crate) fn blend(used: &[Held], anew: &[Held], part: f64) -> Vec<Held> {
    let mut before: BTreeMap<Key, &Held> = keys(used).into_iter().zip(used).collect();
    let with = |held: &Held, magnitude: f64| {
        let mut blended = *held;
        blended.force.magnitude = magnitude;
        blended
    };
    let mut blended: Vec<Held> = Vec::with_capacity(anew.len());
    for (key, held) in keys(anew).into_iter().zip(anew) {
        let from = before.remove(&key).map_or(0.0, |held| held.force.magnitude);
        blended.push(with(held, from + part * (held.force.magnitude - from)));
    }
    let largest = used.iter().chain(anew).map(|held| held.force.magnitude.abs()).fold(0.0, f64::max);
    let fading = before.into_values().map(|held| with(held, (1.0 - part) * held.force.magnitude));
    blended.extend(fading.filter(|held| held.force.magnitude.abs() > GONE * largest));
    blended
}

/// ω, and what it is found from.
#[derive(Clone, Debug, Default)]
pub(crate) struct Relaxation {
    part: f64,
    last: Vec<Vec3>,
}

impl Relaxation {
    /// For a new step.
    pub(crate) fn restart(&mut self) {
        self.part = 1.0;
        self.last.clear();
    }

    /// ω of the pass with this number, counted from 1, in which friction forces change by `differences` \[N\].
    pub(crate) fn part(&mut self, pass: u64, differences: Vec<Vec3>) -> f64 {
        if pass > PLAIN && self.last.len() == differences.len() {
            let (mut product, mut square) = (0.0, 0.0);
            for (now, last) in differences.iter().zip(&self.last) {
                product += last.dot(&(now - last));
                square += (now - last).norm_squared();
            }
            let part = -self.part * product / square;
            // Not so where nothing changed: then there is nothing to learn from.
            if part.is_finite() {
                self.part = part.clamp(LEAST, 1.0);
            }
        }
        self.last = differences;
        self.part
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn held(point: u32, magnitude: f64) -> Held {
        Held {
            force: NormalForce::new([point], [1.0], Vec3::z(), 1e-3, magnitude),
            coefficient: FrictionCoefficient::NONE,
            surface_velocity: Vec3::zeros(),
            half_space: Some(0),
        }
    }

    fn magnitudes(list: &[Held]) -> Vec<(u32, f64)> {
        list.iter().map(|held| (held.force.points()[0], held.force.magnitude)).collect()
    }

    #[test]
    fn blending_keeps_what_both_have_and_fades_what_one_has() {
        let used = [held(0, 4.0), held(1, 8.0), held(3, 1e-12)];
        let anew = [held(2, 16.0), held(0, 2.0)];
        assert_eq!(magnitudes(&blend(&used, &anew, 0.25)), [(2, 4.0), (0, 3.5), (1, 6.0)]);
        // All of the new ones, and nothing else.
        assert_eq!(magnitudes(&blend(&used, &anew, 1.0)), [(2, 16.0), (0, 2.0)]);
        // The same pair twice, as the lists have it, is two pairs.
        let twice = [held(0, 1.0), held(0, 3.0)];
        assert_eq!(magnitudes(&blend(&twice, &twice, 0.5)), [(0, 1.0), (0, 3.0)]);
    }

    #[test]
    fn an_iteration_that_goes_to_and_fro_ends() {
        // F(λ) = c − k λ, which λ ← F(λ) never solves for k ≥ 1.
        for k in [1.0, 3.0, 20.0] {
            let mut relaxation = Relaxation::default();
            relaxation.restart();
            let (mut lambda, fixed) = (1.0, 5.0 / (1.0 + k));
            for pass in 1..=8 {
                let difference = 5.0 - k * lambda - lambda;
                lambda += relaxation.part(pass, vec![Vec3::x() * difference]) * difference;
            }
            assert!((lambda / fixed - 1.0_f64).abs() < 1e-9, "{k} {lambda} {fixed}");
        }
    }
}
