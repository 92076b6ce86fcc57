//! Masses in a row, joined by springs.

use super::parameter::{not_negative, positive};
use crate::error::LagrangianError;
use crate::system::SlicedLagrangian;
use mechanics_core::scalar::Scalar;
use std::f64::consts::PI;

/// n masses in a row between two walls, joined by n + 1 springs.
///
/// ```text
///   |  k₀  ┌──┐  k₁  ┌──┐  k₂       ┌────┐  kₙ  |
///   |─/\/\─┤m₀├─/\/\─┤m₁├─/\/\─ … ──┤mₙ₋₁├─/\/\─|
///   |      └──┘      └──┘           └────┘      |
/// ```
///
/// qᵢ is the displacement of mass i from rest. T = ½ Σ mᵢ q̇ᵢ², V = ½ Σ kᵢ (qᵢ − qᵢ₋₁)² with q₋₁ = qₙ = 0. Springs of stiffness
/// zero are allowed: a chain with k₀ = kₙ = 0 is free. Equal masses and springs have the modes
/// sin(jπ(i + 1)/(n + 1)), j = 1 … n, with the frequencies ωⱼ = 2√(k/m) sin(jπ/(2(n + 1))).
///
/// # Reference
/// Goldstein, Classical Mechanics, chapter 6 and § 13.1.
#[derive(Clone, Debug, PartialEq)]
pub struct SpringChain {
    /// mᵢ \[kg\], n of them.
    pub masses: Vec<f64>,
    /// kᵢ \[N/m\], n + 1 of them.
    pub stiffnesses: Vec<f64>,
}

const NAME: &str = "spring chain";

impl SpringChain {
    /// From n masses \[kg\] and n + 1 stiffnesses \[N/m\].
    ///
    /// # Errors
    /// [`LagrangianError::Parameter`] if a mass is not positive, a stiffness is negative, or one is not finite.
    ///
    /// # Panics
    /// If there is not one spring more than there are masses.
    pub fn new(masses: Vec<f64>, stiffnesses: Vec<f64>) -> Result<Self, LagrangianError> {
        assert_eq!(stiffnesses.len(), masses.len() + 1, "one spring more than masses");
        masses.iter().try_for_each(|&mass| positive(NAME, "masses", mass).map(drop))?;
        stiffnesses.iter().try_for_each(|&k| not_negative(NAME, "stiffnesses", k).map(drop))?;
        Ok(Self { masses, stiffnesses })
    }

    /// `count` equal masses \[kg\], joined by equal springs \[N/m\].
    ///
    /// # Errors
    /// [`LagrangianError::Parameter`] if one is not positive and finite.
    pub fn uniform(count: usize, mass: f64, stiffness: f64) -> Result<Self, LagrangianError> {
        positive(NAME, "stiffnesses", stiffness)?;
        Self::new(vec![mass; count], vec![stiffness; count + 1])
    }

    /// The frequencies ωⱼ = 2√(k/m) sin(jπ/(2(n + 1))), j = 1 … n \[rad/s\], of a uniform chain.
    pub fn uniform_frequencies(count: usize, mass: f64, stiffness: f64) -> Vec<f64> {
        let scale = 2.0 * (stiffness / mass).sqrt();
        (1..=count).map(|j| scale * (0.5 * PI * j as f64 / (count + 1) as f64).sin()).collect()
    }

    /// The exact displacements and velocities of a uniform chain a time `t` \[s\] after `q`, `v`, by its modes.
    ///
    /// The error is about ε (1 + ωₙ t) times the amplitude: that of a phase whose frequency is rounded.
    ///
    /// # Panics
    /// If `q` and `v` have different lengths.
    pub fn uniform_motion(mass: f64, stiffness: f64, q: &[f64], v: &[f64], t: f64) -> [Vec<f64>; 2] {
        let n = q.len();
        assert_eq!(n, v.len(), "one velocity per coordinate");
        // Reduced by integers first: the argument of the sine stays below π.
        let mode = |j: usize, i: usize| {
            let turns = (j * (i + 1)) % (2 * (n + 1));
            (PI * turns as f64 / (n + 1) as f64).sin()
        };
        let (mut q_end, mut v_end) = (vec![0.0; n], vec![0.0; n]);
        let norm = 2.0 / (n + 1) as f64;
        for (index, omega) in Self::uniform_frequencies(n, mass, stiffness).into_iter().enumerate() {
            let j = index + 1;
            let amplitude: f64 = (0..n).map(|i| mode(j, i) * q[i]).sum();
            let rate: f64 = (0..n).map(|i| mode(j, i) * v[i]).sum();
            let (sin, cos) = (omega * t).sin_cos();
            for i in 0..n {
                q_end[i] += norm * mode(j, i) * (amplitude * cos + rate / omega * sin);
                v_end[i] += norm * mode(j, i) * (rate * cos - omega * amplitude * sin);
            }
        }
        [q_end, v_end]
    }
}

impl SlicedLagrangian for SpringChain {
    fn dimension(&self) -> usize {
        self.masses.len()
    }

    #[inline]
    fn kinetic<S: Scalar>(&self, _: &[S], v: &[S], _: S) -> S {
        let mut twice = S::constant(0.0);
        for (&v, &mass) in v.iter().zip(&self.masses) {
            twice += v.square().scale(mass);
        }
        twice.scale(0.5)
    }

    #[inline]
    fn potential<S: Scalar>(&self, q: &[S], _: S) -> S {
        let (mut twice, mut before) = (S::constant(0.0), S::constant(0.0));
        for (&q, &stiffness) in q.iter().zip(&self.stiffnesses) {
            twice += (q - before).square().scale(stiffness);
            before = q;
        }
        twice += before.square().scale(self.stiffnesses[q.len()]);
        twice.scale(0.5)
    }
}
