//! What a step must keep, and another solver's steps.
#![allow(
    clippy::print_stdout,
    clippy::fn_params_excessive_bools,
    clippy::unwrap_used,
    missing_docs,
    reason = "tests"
)]

#[path = "truth/conservation.rs"]
mod conservation;
#[path = "truth/determinism.rs"]
mod determinism;
#[path = "truth/fields.rs"]
mod fields;
#[path = "truth/reference.rs"]
mod reference;
