//! Implicit steps against closed forms, conservation laws and explicit steps.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs, reason = "tests")]

#[path = "implicit/block.rs"]
mod block;
#[path = "implicit/colliders.rs"]
mod colliders;
#[path = "implicit/contact.rs"]
mod contact;
#[path = "implicit/motion.rs"]
mod motion;
#[path = "implicit/refusals.rs"]
mod refusals;
#[path = "implicit/rest.rs"]
mod rest;
