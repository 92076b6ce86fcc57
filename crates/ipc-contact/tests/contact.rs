//! Contact as a term of the incremental potential: derivatives, conservation, gaps, guarantees.

// In a test a panic is the report; the lint spares only functions marked as tests.
#![allow(clippy::unwrap_used)]

#[path = "contact/dynamics.rs"]
mod dynamics;
#[path = "contact/energy.rs"]
mod energy;
#[path = "contact/guarantees.rs"]
mod guarantees;
#[path = "contact/scene.rs"]
mod scene;

/// Numbers in [−1, 1) that are the same everywhere.
struct Random(u64);

impl Random {
    fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
    fn vector(&mut self) -> mechanics_core::tensor::Vec3 {
        mechanics_core::tensor::Vec3::new(self.number(), self.number(), self.number())
    }
}
