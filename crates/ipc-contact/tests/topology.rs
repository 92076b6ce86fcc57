//! Winding numbers against counting boxes, crossings of a sheet against integers, linking numbers against Gauss's integral
//! and against the crossings of braids.

#![allow(clippy::unwrap_used, reason = "a test stops where it fails")]

#[path = "topology/chains.rs"]
mod chains;
#[path = "scenes/peers.rs"]
#[allow(dead_code, reason = "shared with benches")]
mod peers;
#[path = "scenes/random.rs"]
mod random;
#[path = "topology/surfaces.rs"]
mod surfaces;
