#![doc = include_str!("../README.md")]
//!
//! # Where to go next
//! A scene in memory: [`Splats`]; from files and back: [`file`](mod@file); what of it is matter: [`select`], [`fill`]; samples that move it: [`bind`], [`transport`]; a picture of it: [`camera`], [`raster`].
//! The examples `stretch_splats` and `orbit` run in seconds. Formulas with the places where they are in the code: `docs/theory/gaussian-deform.md` and `gaussian-picture.md` of the repository.

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
