#![doc = include_str!("../README.md")]

pub mod camera;
pub mod error;
pub mod harmonics;
pub mod raster;
pub mod splats;

pub use error::SplatError;
pub use splats::{Degree, Splat, Splats};
