//! A pendulum on a cart, damped and pushed.

use super::parameter::{finite, not_negative, positive};
use crate::error::LagrangianError;
use crate::system::Lagrangian;
use mechanics_core::scalar::Scalar;

/// A periodic force on the cart, F cos Ωt.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Drive {
    /// F \[N\].
    pub amplitude: f64,
    /// Ω \[rad/s\]; zero is a constant force.
    pub frequency: f64,
}

/// A pendulum hung on a cart that rolls on a rail.
///
/// ```text
///                 ┌───────┐
///   F cos Ωt ───▶ │   M   │        damper c of the cart
///   ──────────────o───●───o──────▶ x
///                     │╲
///                     │θ╲ l        damper d of the hinge
///                     │  ● m
/// ```
///
/// q = (x, θ), θ from the downward vertical.
///
/// T = ½ (M + m) ẋ² + m l ẋ θ̇ cos θ + ½ m l² θ̇², V = −m g l cos θ, R = ½ c ẋ² + ½ d θ̇², Q = (F cos Ωt, 0).
///
/// Without damper and drive x is cyclic: p_x = (M + m) ẋ + m l θ̇ cos θ is kept, and the energy. Then small swings have the frequency
/// √(g (M + m)/(l M)). With them the energy changes at the rate −2R + Q·q̇.
///
/// # Reference
/// Landau, Lifshitz, Mechanics, § 5, problem 2; R: § 25.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CartPendulum {
    /// M \[kg\].
    pub cart_mass: f64,
    /// m \[kg\].
    pub bob_mass: f64,
    /// l \[m\].
    pub length: f64,
    /// g \[m/s²\].
    pub gravity: f64,
    /// c \[N s/m\].
    pub cart_damping: f64,
    /// d \[N m s\].
    pub hinge_damping: f64,
    /// F, Ω.
    pub drive: Drive,
}

const NAME: &str = "cart-pendulum";

impl CartPendulum {
    /// From masses \[kg\], length \[m\] and gravity \[m/s²\]; without damping and drive.
    ///
    /// # Errors
    /// [`LagrangianError::Parameter`] if a mass or the length is not positive, or one is not finite.
    pub fn new(cart_mass: f64, bob_mass: f64, length: f64, gravity: f64) -> Result<Self, LagrangianError> {
        Ok(Self {
            cart_mass: positive(NAME, "cart_mass", cart_mass)?,
            bob_mass: positive(NAME, "bob_mass", bob_mass)?,
            length: positive(NAME, "length", length)?,
            gravity: finite(NAME, "gravity", gravity)?,
            cart_damping: 0.0,
            hinge_damping: 0.0,
            drive: Drive::default(),
        })
    }

    /// The same with dampers of the cart \[N s/m\] and of the hinge \[N m s\].
    ///
    /// # Errors
    /// [`LagrangianError::Parameter`] if one is negative or not finite.
    pub fn damped(self, cart: f64, hinge: f64) -> Result<Self, LagrangianError> {
        let cart_damping = not_negative(NAME, "cart_damping", cart)?;
        Ok(Self { cart_damping, hinge_damping: not_negative(NAME, "hinge_damping", hinge)?, ..self })
    }

    /// The same, pushed by `drive`.
    ///
    /// # Errors
    /// [`LagrangianError::Parameter`] if its amplitude or frequency is not finite.
    pub fn driven(self, drive: Drive) -> Result<Self, LagrangianError> {
        finite(NAME, "drive.amplitude", drive.amplitude)?;
        finite(NAME, "drive.frequency", drive.frequency)?;
        Ok(Self { drive, ..self })
    }

    /// The frequency √(g (M + m)/(l M)) \[rad/s\] of small swings without damping.
    pub fn frequency(&self) -> f64 {
        (self.gravity * (self.cart_mass + self.bob_mass) / (self.length * self.cart_mass)).sqrt()
    }
}

impl Lagrangian<2> for CartPendulum {
    #[inline]
    fn kinetic<S: Scalar>(&self, q: &[S; 2], v: &[S; 2], _: S) -> S {
        let Self { cart_mass, bob_mass, length, .. } = *self;
        v[0].square().scale(0.5 * (cart_mass + bob_mass))
            + v[1].square().scale(0.5 * bob_mass * length * length)
            + (v[0] * v[1] * q[1].cos()).scale(bob_mass * length)
    }

    #[inline]
    fn potential<S: Scalar>(&self, q: &[S; 2], _: S) -> S {
        q[1].cos().scale(-self.bob_mass * self.gravity * self.length)
    }

    #[inline]
    fn rayleigh<S: Scalar>(&self, _: &[S; 2], v: &[S; 2], _: S) -> S {
        v[0].square().scale(0.5 * self.cart_damping) + v[1].square().scale(0.5 * self.hinge_damping)
    }

    #[inline]
    fn force<S: Scalar>(&self, _: &[S; 2], _: &[S; 2], t: S) -> [S; 2] {
        [t.scale(self.drive.frequency).cos().scale(self.drive.amplitude), S::constant(0.0)]
    }
}
