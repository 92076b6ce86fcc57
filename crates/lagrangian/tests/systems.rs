//! Worked systems: accelerations, energies, momenta and closed forms against numbers of 32 digits, and against each other.

#![allow(clippy::unwrap_used)]

#[path = "systems/closed_forms.rs"]
mod closed_forms;
#[path = "systems/derivatives.rs"]
mod derivatives;
#[path = "fixture/reader.rs"]
mod fixture;
#[path = "systems/parameters.rs"]
mod parameters;
