//! Holonomic constraints.
