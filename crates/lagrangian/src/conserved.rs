//! Conserved quantities.
