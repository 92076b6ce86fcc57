//! The same in lanes and in single precision, and for deformations that break careless code.

#![allow(clippy::unwrap_used, reason = "tests")]

#[path = "laws/hard.rs"]
mod hard;
#[path = "laws/materials.rs"]
mod materials;
#[path = "laws/packets.rs"]
mod packets;
#[path = "laws/sample.rs"]
mod sample;
