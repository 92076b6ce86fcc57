//! Friction: the law, its derivatives, conservation, scenes with closed forms.

// In a test a panic is the report; the lint spares only functions marked as tests.
#![allow(clippy::unwrap_used)]

#[path = "friction/bad_input.rs"]
mod bad_input;
#[path = "friction/bodies.rs"]
mod bodies;
#[path = "friction/derivatives.rs"]
mod derivatives;
#[path = "friction/faults.rs"]
mod faults;
#[path = "friction/lagging.rs"]
mod lagging;
#[path = "friction/law.rs"]
mod law;
#[path = "../../mechanics-core/tests/optimise/lying.rs"]
mod lying;
#[path = "friction/moving_surfaces.rs"]
mod moving_surfaces;
#[path = "friction/particles.rs"]
mod particles;
#[path = "friction/scene.rs"]
mod scene;
#[path = "friction/stages.rs"]
mod stages;

use mechanics_core::tensor::Vec3;

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
