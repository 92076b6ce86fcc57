//! Elements against closed forms, automatic differentiation and finite differences.

// In a test a panic is the report; the lint spares only functions marked as tests.
#![allow(clippy::unwrap_used)]
// Elements need the sparse solvers' feature.
#![cfg(feature = "bodies")]

#[path = "solids/closed_forms.rs"]
mod closed_forms;
#[path = "solids/loads.rs"]
mod loads;
#[path = "solids/quadratic.rs"]
mod quadratic;
#[path = "solids/spectrum.rs"]
mod spectrum;
#[path = "solids/tetrahedron.rs"]
mod tetrahedron;

use mechanics_core::stencil::LocalHessian;
use mechanics_core::tensor::Vec3;
use nalgebra::SMatrix;

/// Numbers in [−1, 1) that are the same everywhere.
struct Random(u64);

impl Random {
    fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.number(), self.number(), self.number())
    }
}

/// A Hessian as one matrix, from its lower triangle.
fn matrix<const N: usize, const M: usize>(h: &LocalHessian<N>) -> SMatrix<f64, M, M> {
    SMatrix::from_fn(|r, c| {
        if r / 3 >= c / 3 { h[r / 3][c / 3][(r % 3, c % 3)] } else { h[c / 3][r / 3][(c % 3, r % 3)] }
    })
}

/// The high-precision values of issue 5.
fn reference() -> serde_json::Value {
    serde_json::from_str(include_str!("fixtures/mechanics_reference.json")).unwrap()
}

/// A number of a fixture, written as a string.
fn number(value: &serde_json::Value) -> f64 {
    value.as_str().map_or_else(|| value.as_f64().unwrap(), |text| text.parse().unwrap())
}
