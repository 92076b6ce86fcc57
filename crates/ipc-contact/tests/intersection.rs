//! The exact check against rational arithmetic: predicates on random, degenerate and extreme points, whole meshes against
//! every pair, and inputs that must be refused.

#![allow(clippy::unwrap_used, reason = "a test stops where it fails")]

#[path = "intersection/meshes.rs"]
mod meshes;
#[path = "intersection/oracle.rs"]
mod oracle;
#[path = "intersection/pairs.rs"]
mod pairs;
#[path = "scenes/peers.rs"]
#[allow(dead_code, reason = "shared with benches")]
mod peers;
#[path = "scenes/random.rs"]
mod random;
