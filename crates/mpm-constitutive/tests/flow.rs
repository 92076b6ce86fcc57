//! Plastic flow against its equations, and against what is known of each material from elsewhere.

#![allow(clippy::unwrap_used, reason = "tests")]

#[path = "laws/flow_rules.rs"]
mod flow_rules;
#[path = "laws/materials.rs"]
mod materials;
#[path = "laws/sample.rs"]
mod sample;
