//! The implicit time-stepper.
