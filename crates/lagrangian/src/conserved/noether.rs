//! Charges of symmetries that a user hands over.

use super::{Invariant, Measured, gradient};
use crate::coordinates::{Coordinates, Phase};
use crate::error::LagrangianError;
use crate::system::System;
use mechanics_core::jet::Jet1;
use mechanics_core::scalar::Scalar;
use std::fmt;

/// A one-parameter family of motions of all coordinates, q → q + ε ξ(q, t), under which L changes by dK/dt.
///
/// ```
/// use lagrangian::conserved::Symmetry;
/// use mechanics_core::scalar::Scalar;
///
/// /// Rotation of the plane about the origin: its charge is angular momentum.
/// struct Rotation;
/// impl Symmetry for Rotation {
///     fn generator_into<S: Scalar>(&self, q: &[S], _t: S, direction: &mut [S]) {
///         direction[0] = -q[1];
///         direction[1] = q[0];
///     }
/// }
/// ```
pub trait Symmetry {
    /// Overwrites `direction`, which comes filled with zeros, by the generator ξ(q, t).
    fn generator_into<S: Scalar>(&self, q: &[S], t: S, direction: &mut [S]);

    /// K(q, t), whose time derivative L changes by; zero unless overridden. A Galilean boost ξ = t needs K = m q.
    fn boundary<S: Scalar>(&self, q: &[S], t: S) -> S {
        let _ = (q, t);
        S::constant(0.0)
    }
}

/// The charge Q = ∂L/∂v·ξ − K of a symmetry.
#[derive(Clone, PartialEq)]
pub struct Noether<G> {
    name: String,
    symmetry: G,
}

// Not derived, for symmetries that are not `Debug` themselves.
impl<G> fmt::Debug for Noether<G> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Noether").field("name", &self.name).finish_non_exhaustive()
    }
}

/// How small the change of L must be, in terms of the sum of the magnitudes of its terms.
const TOLERANCE: f64 = 1e-9;
/// States tried beside each one given.
const NEIGHBOURS: usize = 8;
/// How far from it, in terms of the largest coordinate, velocity and time given.
const REACH: f64 = 0.25;

impl<G: Symmetry> Noether<G> {
    /// The charge of `symmetry`, which is checked to be one: δL + ξ·F − D K must vanish at every one of `states`,
    /// and at eight states scattered about each of them, in time as well, up to 1e-9 of the sum of the magnitudes of
    /// its terms. (On one orbit alone it may vanish by chance: on a straight line through the centre, every rotation
    /// looks like a symmetry; at t = 0 alone, a field that is switched on with t looks like none.) States scattered
    /// to where L is not finite do not count. What breaks a symmetry by less than that, or only far from all the
    /// states given, is not seen.
    ///
    /// # Errors
    /// [`LagrangianError::NotASymmetry`] with the state where it fails worst; [`LagrangianError::NonFinite`] for a
    /// state given that is not finite, or has no finite derivatives; [`LagrangianError::FewSamples`] without
    /// states.
    pub fn new<S: System>(
        name: impl Into<String>,
        symmetry: G,
        system: &S,
        states: &[Phase<S::Coordinates>],
    ) -> Result<Self, LagrangianError> {
        let charge = Self { name: name.into(), symmetry };
        if states.is_empty() {
            return Err(LagrangianError::FewSamples { samples: 0, needed: 1 });
        }
        let (q_reach, v_reach) = (reach(states.iter().map(|s| &s.q)), reach(states.iter().map(|s| &s.v)));
        let latest = states.iter().fold(0.0f64, |most, s| most.max(s.time.abs()));
        let t_reach = REACH * if latest > 0.0 { latest } else { 1.0 };
        let mut random = Scatter(0x9e37_79b9_7f4a_7c15);
        let mut worst: Option<(f64, Change, Phase<S::Coordinates>)> = None;
        for state in states {
            state.validate()?;
            for neighbour in 0..=NEIGHBOURS {
                let mut at = state.clone();
                if neighbour > 0 {
                    at.time += t_reach * random.next();
                    at.q.as_mut().iter_mut().zip(&q_reach).for_each(|(x, r)| *x += r * random.next());
                    at.v.as_mut().iter_mut().zip(&v_reach).for_each(|(x, r)| *x += r * random.next());
                }
                let change = charge.change(system, &at);
                if !change.size.is_finite() {
                    if neighbour == 0 {
                        return Err(not_finite(system, &at, change));
                    }
                    continue;
                }
                let part = if change.size > 0.0 { change.value.abs() / change.size } else { 0.0 };
                if worst.as_ref().is_none_or(|(most, ..)| part > *most) {
                    worst = Some((part, change, at));
                }
            }
        }
        match worst {
            Some((part, change, at)) if part > TOLERANCE => Err(LagrangianError::NotASymmetry {
                name: charge.name,
                time: at.time,
                q: at.q.as_ref().to_vec(),
                v: at.v.as_ref().to_vec(),
                change: change.value,
                size: change.size,
            }),
            _ => Ok(charge),
        }
    }

    /// δL + ξ·F − D K at a state, the rate of the charge along a motion.
    fn change<S: System>(&self, system: &S, phase: &Phase<S::Coordinates>) -> Change {
        let at = gradient(system, phase);
        let (direction, boundary) = self.along(phase);
        let terms = direction.iter().enumerate().flat_map(|(i, xi)| {
            let force = at.slope.as_ref()[i] * xi.value;
            [force, at.applied.as_ref()[i] * xi.value, at.momentum.as_ref()[i] * xi.gradient[0]]
        });
        let mut change = Change { value: -boundary.gradient[0], size: boundary.gradient[0].abs() };
        for term in terms {
            change.value += term;
            change.size += term.abs();
        }
        change
    }

    /// ξ and K with their derivatives D = v·∂/∂q + ∂/∂t.
    fn along<C: Coordinates>(&self, phase: &Phase<C>) -> (Vec<Jet1<f64, 1>>, Jet1<f64, 1>) {
        let moving = |(&value, &rate): (&f64, &f64)| Jet1 { value, gradient: [rate] };
        let q: Vec<Jet1<f64, 1>> = phase.q.as_ref().iter().zip(phase.v.as_ref()).map(moving).collect();
        let now = Jet1 { value: phase.time, gradient: [1.0] };
        let mut direction = vec![Jet1::constant(0.0); q.len()];
        self.symmetry.generator_into(&q, now, &mut direction);
        (direction, self.symmetry.boundary(&q, now))
    }
}

impl<S: System, G: Symmetry> Invariant<S> for Noether<G> {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn measure(&self, system: &S, phase: &Phase<S::Coordinates>) -> Measured {
        let at = gradient(system, phase);
        let q = phase.q.as_ref();
        let mut direction = vec![0.0; q.len()];
        self.symmetry.generator_into(q, phase.time, &mut direction);
        let boundary = self.symmetry.boundary(q, phase.time);
        let terms = || at.momentum.as_ref().iter().zip(&direction).map(|(p, xi)| p * xi);
        Measured {
            value: terms().sum::<f64>() - boundary,
            size: terms().map(f64::abs).sum::<f64>() + boundary.abs(),
        }
    }
}

/// A rate that should vanish, and the sum of the magnitudes of its terms.
#[derive(Clone, Copy, Debug)]
struct Change {
    value: f64,
    size: f64,
}

/// A quarter of the largest magnitude of each entry; of entries that are zero everywhere, a quarter of the largest
/// of all, or of one.
fn reach<'a, C: Coordinates>(all: impl Iterator<Item = &'a C>) -> Vec<f64> {
    let mut largest: Vec<f64> = Vec::new();
    for x in all {
        largest.resize(x.as_ref().len(), 0.0);
        largest.iter_mut().zip(x.as_ref()).for_each(|(l, x)| *l = l.max(x.abs()));
    }
    let most = largest.iter().copied().fold(0.0, f64::max);
    let instead = if most > 0.0 { most } else { 1.0 };
    largest.into_iter().map(|l| REACH * if l > 0.0 { l } else { instead }).collect()
}

/// The derivative that is not finite at a state, or else the generator itself.
#[cold]
fn not_finite<S: System>(system: &S, phase: &Phase<S::Coordinates>, change: Change) -> LagrangianError {
    let at = gradient(system, phase);
    let time = phase.time;
    let lists = [
        (crate::error::Symbol::Momentum, at.momentum.as_ref()),
        (crate::error::Symbol::Slope, at.slope.as_ref()),
        (crate::error::Symbol::Force, at.applied.as_ref()),
    ];
    for (symbol, values) in lists {
        if let Some(index) = values.iter().position(|x| !x.is_finite()) {
            return LagrangianError::NonFinite { symbol, index, value: values[index], time };
        }
    }
    LagrangianError::NonFinite { symbol: crate::error::Symbol::Generator, index: 0, value: change.size, time }
}

/// Numbers in [−1, 1) that look random and are the same every time.
///
/// # Reference
/// Steele, Lea and Flood, *Fast splittable pseudorandom number generators*, OOPSLA 2014 (SplitMix64).
#[derive(Debug)]
struct Scatter(u64);

impl Scatter {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}
