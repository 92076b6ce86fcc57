//! Jets of a Lagrangian.
