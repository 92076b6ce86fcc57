//! Elastic bodies as energies of points: elements, mass, loads, damping.
//!
//! Every element here is a [`Stencil`](mechanics_core::stencil::Stencil) or a
//! [`Potential`](mechanics_core::potential::Potential): an energy of a few points with its gradient and Hessian. A
//! list of them is a term of the incremental potential, which [`crate::stepper`] minimises. Positions are in metres,
//! energies in joules.
//!
//! | element | energy |
//! |---|---|
//! | [`Tetrahedra`] | V ψ(F), linear shape functions, any [`Hyperelastic`](mechanics_core::law::Hyperelastic) law |
//! | [`Inertia`] of a [`Mass`] | ½ c ‖x − x̃‖²_M, lumped or consistent |
//! | [`DeadLoad`] | −Σ f · x: gravity, nodal forces |

mod error;
mod inertia;
mod load;
mod mass;
mod packets;
mod tetrahedron;

pub use error::ElementError;
pub use inertia::Inertia;
pub use load::{Amplitude, DeadLoad};
pub use mass::{Mass, MassDistribution};
pub use tetrahedron::Tetrahedra;
