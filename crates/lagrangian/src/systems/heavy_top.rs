//! Lagrange's top.

use super::elliptic::arithmetic_geometric_mean;
use super::parameter::{finite, positive};
use crate::error::LagrangianError;
use crate::system::Lagrangian;
use mechanics_core::scalar::Scalar;
use std::f64::consts::TAU;

/// The heavy symmetric top with a fixed point.
///
/// ```text
///        z ▲      ╱ axis, spin ψ
///          │ θ  ╱╲
///          │  ╱╲╱╱        centre of mass at l
///          │ ╱╲╱          │ g
///          │╱             ▼
///   ───────●───────  ↺ φ about z
/// ```
///
/// q = (θ, φ, ψ), Euler's angles (z, x, z); θ from the upward vertical.
///
/// T = ½ I₁ (θ̇² + φ̇² sin²θ) + ½ I₃ (ψ̇ + φ̇ cos θ)², V = m g l cos θ.
///
/// φ and ψ are cyclic: p_ψ = I₃ ω₃ with the spin ω₃ = ψ̇ + φ̇ cos θ, and p_φ = I₁ φ̇ sin²θ + p_ψ cos θ, are kept, and the energy. θ nutates
/// between two angles. Upright, the top sleeps if its spin is above 2 √(I₁ m g l)/I₃, and falls below it. At θ = 0 the
/// coordinates are singular.
///
/// # Reference
/// Goldstein, Classical Mechanics, § 5.7; Landau, Lifshitz, Mechanics, § 35, problem 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeavyTop {
    /// I₁ \[kg m²\], across the axis, about the fixed point.
    pub transverse_inertia: f64,
    /// I₃ \[kg m²\], about the axis.
    pub axial_inertia: f64,
    /// m \[kg\].
    pub mass: f64,
    /// l \[m\], from the fixed point to the centre of mass.
    pub length: f64,
    /// g \[m/s²\].
    pub gravity: f64,
}

/// How the axis of a top nods.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nutation {
    /// The smallest angle of the axis to the upward vertical \[rad\].
    pub least_angle: f64,
    /// The largest \[rad\].
    pub largest_angle: f64,
    /// The time from one to the other and back \[s\].
    pub period: f64,
}

impl HeavyTop {
    /// From the moments of inertia \[kg m²\], mass \[kg\], length \[m\] and gravity \[m/s²\].
    ///
    /// # Errors
    /// [`LagrangianError::Parameter`] if an inertia, the mass or the length is not positive, or one is not finite.
    pub fn new(
        transverse_inertia: f64,
        axial_inertia: f64,
        mass: f64,
        length: f64,
        gravity: f64,
    ) -> Result<Self, LagrangianError> {
        let name = "heavy top";
        Ok(Self {
            transverse_inertia: positive(name, "transverse_inertia", transverse_inertia)?,
            axial_inertia: positive(name, "axial_inertia", axial_inertia)?,
            mass: positive(name, "mass", mass)?,
            length: positive(name, "length", length)?,
            gravity: finite(name, "gravity", gravity)?,
        })
    }

    /// The spin 2 √(I₁ m g l)/I₃ \[rad/s\] above which an upright top sleeps.
    pub fn critical_spin(&self) -> f64 {
        let weight_moment = self.mass * self.gravity * self.length;
        2.0 * (self.transverse_inertia * weight_moment).sqrt() / self.axial_inertia
    }

    /// The nutation of a top released at the angle θ₀ \[rad\] with θ̇ = 0, φ̇ = `precession` and ψ̇ = `own_spin` \[rad/s\]. Needs g > 0.
    ///
    /// With u = cos θ, a = I₃ω₃/I₁ and β = 2 m g l/I₁, energy and the two momenta give u̇² = f(u), a cubic that vanishes at u₀ = cos θ₀.
    /// In d = u₀ − u, with s = sin θ₀, it is f = d (C + B d − β d²), where
    ///
    /// C = s² (2 u₀ φ̇² − 2 a φ̇ + β), B = 2 u₀ β − a² − φ̇² s².
    ///
    /// The motion is between d = 0 and the root of the quadratic on the side where f > 0 (downwards for C > 0), the nearer one if there are
    /// two. With the three roots u₁ ≤ u₂ ≤ u₃ of f the period is 2 ∫ du/√f from u₁ to u₂, which is
    /// 2π/agm(√(β(u₃ − u₁)), √(β(u₃ − u₂))).
    ///
    /// The angle follows without cancellation from sin² ½θ = sin² ½θ₀ + ½d.
    ///
    /// # Reference
    /// Whittaker 1937, Analytical Dynamics, § 72; the integral: Abramowitz, Stegun 1964, 17.4.63.
    pub fn nutation(&self, angle: f64, precession: f64, own_spin: f64) -> Nutation {
        let (sin, cos) = angle.sin_cos();
        let beta = 2.0 * self.mass * self.gravity * self.length / self.transverse_inertia;
        let spin = own_spin + precession * cos;
        let a = self.axial_inertia * spin / self.transverse_inertia;
        let c = sin * sin * (2.0 * precession * (cos * precession - a) + beta);
        let b = 2.0 * cos * beta - a * a - (precession * sin).powi(2);
        // Roots of C + B d − β d²: the one without cancellation, the other by their product −C/β.
        let steady = 0.5 * (b + (b * b + 4.0 * beta * c).max(0.0).sqrt().copysign(b)) / beta;
        let other = if steady == 0.0 { 0.0 } else { -c / (beta * steady) };
        let (above, below) = (steady.min(other), steady.max(other));
        // In d the roots of f are 0, `above` and `below`; u falls with d, so u₃ has the least d.
        let [third, second, first] = if c >= 0.0 { [above, 0.0, below] } else { [above, below, 0.0] };
        let half = |d: f64| ((0.5 * angle).sin().powi(2) + 0.5 * d).clamp(0.0, 1.0).sqrt().asin();
        let mean =
            arithmetic_geometric_mean((beta * (first - third)).sqrt(), (beta * (second - third)).sqrt());
        Nutation {
            least_angle: if c >= 0.0 { angle } else { 2.0 * half(second) },
            largest_angle: if c >= 0.0 { 2.0 * half(first) } else { angle },
            period: TAU / mean,
        }
    }
}

impl Lagrangian<3> for HeavyTop {
    #[inline]
    fn kinetic<S: Scalar>(&self, q: &[S; 3], v: &[S; 3], _: S) -> S {
        let [nutation, precession, own_spin] = *v;
        let (sin, cos) = (q[0].sin(), q[0].cos());
        let across = nutation.square() + (precession * sin).square();
        let spin = own_spin + precession * cos;
        across.scale(0.5 * self.transverse_inertia) + spin.square().scale(0.5 * self.axial_inertia)
    }

    #[inline]
    fn potential<S: Scalar>(&self, q: &[S; 3], _: S) -> S {
        q[0].cos().scale(self.mass * self.gravity * self.length)
    }
}
