//! Hyperelastic laws against automatic differentiation, closed forms, reference values and brute force.

mod cases;
mod derivatives;
mod exact;
mod invariance;
mod inversion;
mod lame;
mod lanes;
mod matrix_projection;
mod near_rest;
mod projection;
mod reference;
