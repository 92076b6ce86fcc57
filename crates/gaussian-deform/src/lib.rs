#![doc = include_str!("../README.md")]

pub mod error;
pub mod harmonics;
pub mod splats;

pub use error::SplatError;
pub use splats::{Degree, Splat, Splats};
