//! Jets in the two kinds of arguments that a Lagrangian has: coordinates q and velocities v.
//!
//! A jet carries a number together with some of its derivatives, and every operation maps jets to jets by the chain
//! rule (see [`mechanics_core::jet`], whose rules for `abs`, `select`, `sqrt` at zero and so on hold here too). The three
//! jets differ in which derivatives they carry:
//!
//! | jet | carries | numbers | for |
//! |---|---|---|---|
//! | [`PhaseJet1`] | f, ∂f/∂q, ∂f/∂v | 1 + 2N | discrete Euler–Lagrange equations |
//! | [`EulerLagrangeJet`] | also D f, D ∂f/∂v, ∂²f/∂v∂v, with D = v·∂/∂q + ∂/∂t | 2 + 3N + N(N+1)/2 | q̈ |
//! | [`PhaseJet2`] | f and all first and second derivatives in (q, v) | 1 + 3N + 2N² | Newton's method on implicit steps |
//!
//! A second-order jet in (q, v, t) would carry 1 + (2N + 1) + (2N + 1)(N + 1) numbers to the same end as the
//! Euler–Lagrange jet: 21 in place of 11 for two coordinates, 36 in place of 17 for three.

mod euler_lagrange;
mod phase_first;
mod phase_second;

pub use euler_lagrange::EulerLagrangeJet;
pub use phase_first::PhaseJet1;
pub use phase_second::PhaseJet2;
