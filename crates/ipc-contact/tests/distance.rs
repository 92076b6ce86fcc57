//! Distances: derivatives against automatic differentiation, values and regions against brute-force oracles, hard input.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

#[path = "distance/derivatives.rs"]
mod derivatives;
#[path = "distance/double.rs"]
mod double;
#[path = "distance/oracle.rs"]
mod oracle;
#[path = "distance/states.rs"]
mod states;
