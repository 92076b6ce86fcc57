#![doc = include_str!("../README.md")]

pub mod basis;
pub mod coefficients;
pub mod coupling;
mod error;
pub mod lagged;
pub mod law;
pub mod pair;

pub use coupling::{ContactWithFriction, FrictionOptions, FrictionReport};
pub use error::FrictionError;
