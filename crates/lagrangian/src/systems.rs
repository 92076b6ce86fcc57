//! Worked systems.
