//! Cameras and pictures: against fixtures, against a plain oracle, under rigid motions, for any number of threads, and with hard inputs.
#![allow(clippy::unwrap_used, reason = "a test may stop at once")]

#[path = "picture/cameras.rs"]
mod cameras;
#[path = "picture/fixtures.rs"]
mod fixtures;
#[path = "picture/hard.rs"]
mod hard;
#[path = "picture/motion.rs"]
mod motion;
#[path = "picture/oracle.rs"]
mod oracle;
#[path = "picture/scenes.rs"]
mod scenes;
