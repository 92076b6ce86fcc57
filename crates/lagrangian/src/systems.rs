//! Worked systems: kinetic and potential energies that one would otherwise type from a textbook, each with a figure,
//! its parameters in units, what is known of it in closed form, and where that stands.
//!
//! | system | coordinates | what it is good for |
//! |---|---|---|
//! | [`MassOnSpring`] | x | everything in closed form, the action between two points included |
//! | [`Projectile`] | x, y | the parabola is the stationary path |
//! | [`Duffing`] | x | forced, damped, chaotic |
//! | [`SpringChain`] | x₀ … | any number of coordinates; exact modes |
//! | [`Pendulum`] | θ | exact period at any amplitude |
//! | [`CartesianPendulum`] | x, y | the same motion, as a constraint |
//! | [`SphericalPendulum`] | θ, φ | a cyclic coordinate |
//! | [`SpringPendulum`] | r, θ | 2 : 1 resonance |
//! | [`DoublePendulum`], [`TriplePendulum`] | θ₁, θ₂ (, θ₃) | regular and chaotic motion; M depends on q |
//! | [`PendulumChain`] | θ₁ … | any number of links |
//! | [`Kepler`], [`PerturbedKepler`] | x, y | exact orbit; exact advance of the perihelion |
//! | [`HenonHeiles`] | x, y | from order to chaos with the energy |
//! | [`HeavyTop`] | θ, φ, ψ | nutation, precession, the sleeping top |
//! | [`FreeBody`] | a quaternion | the flip about the middle axis, without a singularity of coordinates |
//! | [`BeadOnHoop`] | θ | a Lagrangian whose energy function is not T + V |
//! | [`BeadOnWire`] | x | any curve y = f(x), differentiated by the crate |
//! | [`CartesianBead`] | x, y | the same motion, and the force of the wire |
//! | [`CartPendulum`] | x, θ | damping by Rayleigh's function, a driving force |
//!
//! Angles are in radians. Pendulum angles are absolute, from the downward vertical; those of the top are Euler's (z, x, z), with θ
//! from the upward vertical. Constructors refuse what has no inertia: a mass or length that is not positive is a
//! [`LagrangianError::Parameter`](crate::LagrangianError::Parameter) that names it. Fields are public and not checked again.

mod cart_pendulum;
mod chain;
pub mod elliptic;
mod free_body;
mod guided;
mod heavy_top;
mod multiple_pendulum;
mod orbit;
mod oscillator;
mod parameter;
mod pendulum;
mod projectile;

pub use cart_pendulum::{CartPendulum, Drive};
pub use chain::SpringChain;
pub use free_body::FreeBody;
pub use guided::{BeadOnHoop, BeadOnWire, CartesianBead, Curve, Parabola};
pub use heavy_top::{HeavyTop, Nutation};
pub use multiple_pendulum::{DoublePendulum, PendulumChain, TriplePendulum};
pub use orbit::{HenonHeiles, Kepler, PerturbedKepler, eccentric_anomaly};
pub use oscillator::{Duffing, MassOnSpring};
pub use pendulum::{CartesianPendulum, Pendulum, SphericalPendulum, SpringPendulum};
pub use projectile::Projectile;
