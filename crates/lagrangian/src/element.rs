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
//! | [`QuadraticTetrahedra`] | the same with ten nodes and four quadrature points |
//! | [`Springs`] | ½k(l − L)² |
//! | [`Attachments`] | ½k‖x − t‖² |
//! | [`Inertia`] of a [`Mass`] | ½ c ‖x − x̃‖²_M, lumped or consistent |
//! | [`membrane`], [`hinge`] and [`plate`], [`strain_limit`] | sheets: stretching, bending, a barrier on stretch |
//! | [`rod`] | curves: stretching, bending, twist |
//! | [`DeadLoad`] | −A(t) Σ f · x: gravity, nodal forces |
//! | [`Pressure`] | −A(t) p V |
//! | [`MassDamping`], [`DampingTerm`] of [`StiffnessDamping`] or [`Dashpots`] | ½ a (x − x̂)ᵀ C (x − x̂) |

mod attachment;
mod damping;
mod error;
pub mod hinge;
mod inertia;
mod load;
mod mass;
pub mod membrane;
mod packets;
pub mod plate;
mod pressure;
pub mod rod;
mod spring;
pub mod strain_limit;
mod tetrahedron;
mod tetrahedron10;
pub mod thin_error;

pub use attachment::Attachments;
pub use damping::{DampingTerm, Dissipation, MassDamping, StiffnessDamping};
pub use error::ElementError;
pub use inertia::Inertia;
pub use load::{Amplitude, DeadLoad};
pub use mass::{Mass, MassDistribution};
pub use pressure::{Border, Pressure};
pub use spring::{Dashpots, Springs};
pub use tetrahedron::Tetrahedra;
pub use tetrahedron10::{EDGES, QuadraticMesh, QuadraticTetrahedra, jacobian_lower_bound};
pub use thin_error::ThinError;
