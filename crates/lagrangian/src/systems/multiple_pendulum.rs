//! Pendulums that hang on pendulums.

use super::parameter::{finite, positive};
use crate::error::LagrangianError;
use crate::system::{Lagrangian, SlicedLagrangian};
use mechanics_core::scalar::Scalar;

/// The double pendulum: point masses on massless rods.
///
/// ```text
///   ────●────
///       │╲
///       │θ₁╲ l₁
///           ● m₁
///           │╲
///           │θ₂╲ l₂       │ g
///               ● m₂      ▼
/// ```
///
/// q = (θ₁, θ₂), both from the downward vertical.
///
/// T = ½ (m₁ + m₂) l₁² θ̇₁² + ½ m₂ l₂² θ̇₂² + m₂ l₁ l₂ θ̇₁ θ̇₂ cos(θ₁ − θ₂)
///
/// V = −(m₁ + m₂) g l₁ cos θ₁ − m₂ g l₂ cos θ₂
///
/// The mass matrix depends on q, so splitting methods do not apply. Only the energy is kept. Small motions about the
/// hanging rest have two [`frequencies`](Self::frequencies); large ones are chaotic.
///
/// # Reference
/// Landau, Lifshitz, Mechanics, § 5, problem 1 and § 23, problem 2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DoublePendulum {
    /// m₁, m₂ \[kg\].
    pub masses: [f64; 2],
    /// l₁, l₂ \[m\].
    pub lengths: [f64; 2],
    /// g \[m/s²\].
    pub gravity: f64,
}

impl DoublePendulum {
    /// From masses \[kg\], lengths \[m\] and gravity \[m/s²\].
    ///
    /// # Errors
    /// [`LagrangianError::Parameter`] if a mass or length is not positive, or one is not finite.
    pub fn new(masses: [f64; 2], lengths: [f64; 2], gravity: f64) -> Result<Self, LagrangianError> {
        let name = "double pendulum";
        check(name, &masses, &lengths)?;
        Ok(Self { masses, lengths, gravity: finite(name, "gravity", gravity)? })
    }

    /// The frequencies of small motions about the hanging rest \[rad/s\], the lower one first.
    ///
    /// With x = ω² they solve m₁ l₁ l₂ x² − (m₁ + m₂) g (l₁ + l₂) x + (m₁ + m₂) g² = 0.
    pub fn frequencies(&self) -> [f64; 2] {
        let ([m1, m2], [l1, l2], g) = (self.masses, self.lengths, self.gravity);
        let (total, a) = (m1 + m2, m1 * l1 * l2);
        let half = 0.5 * total * g * (l1 + l2);
        // Both squares are positive: (m₁ + m₂)(l₁ + l₂)² ≥ 4 m₁ l₁ l₂.
        let larger = half + (half * half - a * total * g * g).sqrt();
        [(total * g * g / larger).sqrt(), (larger / a).sqrt()]
    }
}

fn check(name: &'static str, masses: &[f64], lengths: &[f64]) -> Result<(), LagrangianError> {
    masses.iter().try_for_each(|&mass| positive(name, "masses", mass).map(drop))?;
    lengths.iter().try_for_each(|&length| positive(name, "lengths", length).map(drop))
}

impl Lagrangian<2> for DoublePendulum {
    #[inline]
    fn kinetic<S: Scalar>(&self, q: &[S; 2], v: &[S; 2], _: S) -> S {
        let ([m1, m2], [l1, l2]) = (self.masses, self.lengths);
        v[0].square().scale(0.5 * (m1 + m2) * l1 * l1)
            + v[1].square().scale(0.5 * m2 * l2 * l2)
            + (v[0] * v[1] * (q[0] - q[1]).cos()).scale(m2 * l1 * l2)
    }

    #[inline]
    fn potential<S: Scalar>(&self, q: &[S; 2], _: S) -> S {
        let ([m1, m2], [l1, l2], g) = (self.masses, self.lengths, self.gravity);
        q[0].cos().scale(-(m1 + m2) * g * l1) - q[1].cos().scale(m2 * g * l2)
    }
}

/// The triple pendulum: as [`DoublePendulum`], with one more.
///
/// q = (θ₁, θ₂, θ₃). With μᵢⱼ = the sum of the masses from max(i, j) downwards, T = ½ Σᵢⱼ μᵢⱼ lᵢ lⱼ θ̇ᵢ θ̇ⱼ cos(θᵢ − θⱼ) and
/// V = −g Σᵢ μᵢᵢ lᵢ cos θᵢ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriplePendulum {
    /// m₁, m₂, m₃ \[kg\].
    pub masses: [f64; 3],
    /// l₁, l₂, l₃ \[m\].
    pub lengths: [f64; 3],
    /// g \[m/s²\].
    pub gravity: f64,
}

impl TriplePendulum {
    /// From masses \[kg\], lengths \[m\] and gravity \[m/s²\].
    ///
    /// # Errors
    /// [`LagrangianError::Parameter`] if a mass or length is not positive, or one is not finite.
    pub fn new(masses: [f64; 3], lengths: [f64; 3], gravity: f64) -> Result<Self, LagrangianError> {
        let name = "triple pendulum";
        check(name, &masses, &lengths)?;
        Ok(Self { masses, lengths, gravity: finite(name, "gravity", gravity)? })
    }
}

impl Lagrangian<3> for TriplePendulum {
    #[inline]
    fn kinetic<S: Scalar>(&self, q: &[S; 3], v: &[S; 3], _: S) -> S {
        let ([m1, m2, m3], [l1, l2, l3]) = (self.masses, self.lengths);
        let coupling = |i: usize, j: usize| v[i] * v[j] * (q[i] - q[j]).cos();
        v[0].square().scale(0.5 * (m1 + m2 + m3) * l1 * l1)
            + v[1].square().scale(0.5 * (m2 + m3) * l2 * l2)
            + v[2].square().scale(0.5 * m3 * l3 * l3)
            + coupling(0, 1).scale((m2 + m3) * l1 * l2)
            + coupling(0, 2).scale(m3 * l1 * l3)
            + coupling(1, 2).scale(m3 * l2 * l3)
    }

    #[inline]
    fn potential<S: Scalar>(&self, q: &[S; 3], _: S) -> S {
        let ([m1, m2, m3], [l1, l2, l3], g) = (self.masses, self.lengths, self.gravity);
        q[0].cos().scale(-(m1 + m2 + m3) * g * l1)
            - q[1].cos().scale((m2 + m3) * g * l2)
            - q[2].cos().scale(m3 * g * l3)
    }
}

/// Any number of pendulums, each hanging on the one before.
///
/// ```text
///   ───●───
///       ╲ l₁
///        ● m₁
///         ╲ l₂
///          ● m₂
///           ╲ …
///            ● mₙ
/// ```
///
/// qᵢ = θᵢ from the downward vertical. Bob i moves with ṙᵢ = Σⱼ≤ᵢ lⱼ θ̇ⱼ (cos θⱼ, sin θⱼ), so T = ½ Σ mᵢ |ṙᵢ|² takes one pass along the
/// chain; V = −g Σᵢ mᵢ Σⱼ≤ᵢ lⱼ cos θⱼ.
///
/// For n equal masses and lengths the squares of the small frequencies are g/l times the zeros of the Laguerre polynomial Lₙ.
///
/// # Reference
/// The frequencies: Braun 2003, Arch. Appl. Mech. 72, 899.
#[derive(Clone, Debug, PartialEq)]
pub struct PendulumChain {
    /// mᵢ \[kg\].
    pub masses: Vec<f64>,
    /// lᵢ \[m\].
    pub lengths: Vec<f64>,
    /// g \[m/s²\].
    pub gravity: f64,
}

impl PendulumChain {
    /// From masses \[kg\], as many lengths \[m\], and gravity \[m/s²\].
    ///
    /// # Errors
    /// [`LagrangianError::Parameter`] if a mass or length is not positive, or one is not finite.
    ///
    /// # Panics
    /// If there are not as many lengths as masses.
    pub fn new(masses: Vec<f64>, lengths: Vec<f64>, gravity: f64) -> Result<Self, LagrangianError> {
        assert_eq!(masses.len(), lengths.len(), "one length per mass");
        let name = "pendulum chain";
        check(name, &masses, &lengths)?;
        Ok(Self { masses, lengths, gravity: finite(name, "gravity", gravity)? })
    }

    /// `count` pendulums of equal mass \[kg\] and length \[m\].
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn uniform(count: usize, mass: f64, length: f64, gravity: f64) -> Result<Self, LagrangianError> {
        Self::new(vec![mass; count], vec![length; count], gravity)
    }
}

impl SlicedLagrangian for PendulumChain {
    fn dimension(&self) -> usize {
        self.masses.len()
    }

    #[inline]
    fn kinetic<S: Scalar>(&self, q: &[S], v: &[S], _: S) -> S {
        let [mut along, mut across, mut twice] = [S::constant(0.0); 3];
        for i in 0..q.len() {
            let speed = v[i].scale(self.lengths[i]);
            along += speed * q[i].cos();
            across += speed * q[i].sin();
            twice += (along.square() + across.square()).scale(self.masses[i]);
        }
        twice.scale(0.5)
    }

    #[inline]
    fn potential<S: Scalar>(&self, q: &[S], _: S) -> S {
        let [mut depth, mut sum] = [S::constant(0.0); 2];
        for i in 0..q.len() {
            depth += q[i].cos().scale(self.lengths[i]);
            sum += depth.scale(self.masses[i]);
        }
        sum.scale(-self.gravity)
    }
}
