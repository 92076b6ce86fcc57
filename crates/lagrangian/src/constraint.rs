//! Holonomic constraints φ(q, t) = 0: reactions, projection, and integrators that stay on them.
//!
//! A user writes φ once over [`Scalar`], as [`Holonomic`] (sizes that the compiler knows) or [`SlicedHolonomic`]
//! (chains and networks); [`Constraints`] and [`SlicedConstraints`] differentiate it by jets. With G = ∂φ/∂q the
//! equations of motion are
//!
//! ```text
//! d/dt ∂L/∂v = ∂L/∂q + Q − ∂R/∂v + Gᵀ λ,    φ(q, t) = 0.
//! ```
//!
//! **Sign of λ**: the reaction +Gᵀλ stands on the side of the forces, so that a Cartesian particle obeys
//! m q̈ = F + λ ∇φ. For φ = (x² + y² − l²)/2 a pendulum's rod under tension T has λ = −T/l: the force points against
//! ∇φ. The unit of λᵢ is joule per unit of φᵢ.
//!
//! - [`Constrained`] answers questions at one state: is it on the constraints, which is the nearest that is, what are
//!   acceleration and λ there.
//! - [`Rattle`] steps: symplectic, symmetric, of order 2, 4, 6 or 8, on the constraints to rounding after every step.
//!
//! ```
//! use lagrangian::constraint::{Constraints, Holonomic, Rattle};
//! use lagrangian::integrator::Integrator;
//! use lagrangian::{EulerLagrange, Lagrangian, Phase};
//! use mechanics_core::scalar::Scalar;
//!
//! struct Particle; // of 1 kg, in the plane, y upwards
//! impl Lagrangian<2> for Particle {
//!     fn kinetic<S: Scalar>(&self, _: &[S; 2], v: &[S; 2], _: S) -> S {
//!         (v[0].square() + v[1].square()).scale(0.5)
//!     }
//!     fn potential<S: Scalar>(&self, q: &[S; 2], _: S) -> S {
//!         q[1].scale(9.81)
//!     }
//! }
//!
//! struct Rod; // of 1 m, from the origin
//! impl Holonomic<2, 1> for Rod {
//!     fn constraint<S: Scalar>(&self, [x, y]: &[S; 2], _: S) -> [S; 1] {
//!         [(x.square() + y.square()).offset(-1.0).scale(0.5)]
//!     }
//! }
//!
//! let system = EulerLagrange::new(Particle);
//! let mut rattle = Rattle::new(Constraints::new(Rod));
//! let mut phase = Phase::new(0.0, [1.0, 0.0], [0.0, 0.0]);
//! for _ in 0..100 {
//!     rattle.step(&system, &mut phase, 0.01)?;
//! }
//! let [x, y] = phase.q;
//! assert!((x * x + y * y - 1.0).abs() < 1e-14);
//! assert!(rattle.reaction().is_some_and(|r| r.mean[0] < 0.0)); // the rod is under tension
//! # Ok::<(), lagrangian::LagrangianError>(())
//! ```

mod compliance;
mod constrained;
mod linear;
mod rattle;
mod set;
mod sliced;

pub use constrained::{Constrained, Motion};
pub use linear::Layout;
pub use rattle::{Composition, Rattle, Reaction};
pub use set::{ConstraintExpansion, ConstraintSet, Constraints, ExpansionOf, Rows};
pub use sliced::SlicedConstraints;

use mechanics_core::scalar::Scalar;

/// `K` holonomic constraints on `N` coordinates, written once over any [`Scalar`].
pub trait Holonomic<const N: usize, const K: usize>: Send + Sync {
    /// φ(q, t); zero where the constraints hold.
    fn constraint<S: Scalar>(&self, q: &[S; N], t: S) -> [S; K];
}

/// [`Holonomic`] for sizes known at run time.
pub trait SlicedHolonomic: Send + Sync {
    /// The number of coordinates.
    fn dimension(&self) -> usize;

    /// The number of constraints.
    fn count(&self) -> usize;

    /// Overwrites `phi` with φ(q, t).
    fn constraint_into<S: Scalar>(&self, q: &[S], t: S, phi: &mut [S]);
}
