//! Machines that work by friction, impacts, and hard cases: grippers, rollers, knots.
