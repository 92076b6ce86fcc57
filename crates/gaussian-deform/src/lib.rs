#![doc = include_str!("../README.md")]

pub mod bind;
pub mod camera;
pub mod elongation;
pub mod error;
pub mod file;
pub mod fill;
pub mod harmonics;
mod precision;
pub mod raster;
pub mod select;
pub mod shape;
pub mod similarity;
pub mod splats;
pub mod transport;

pub use error::SplatError;
pub use mechanics_core;
pub use splats::{Degree, Splat, Splats};
