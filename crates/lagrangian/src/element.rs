//! Elements: local energies of elastic bodies.
//!
//! Thin bodies: [`membrane`] (stretching of sheets), [`hinge`] and [`plate`] (their bending), [`rod`] (stretching and bending of
//! curves), [`strain_limit`] (a barrier on stretch).

pub mod hinge;
pub mod membrane;
pub mod plate;
pub mod rod;
pub mod strain_limit;
pub mod thin_error;

pub use thin_error::ThinError;
