//! Hard states of contact: gaps far below any tolerance, positions far out, energies beyond a number, runs that are interrupted.

// In a test a panic is the report; the lint spares only functions marked as tests.
#![allow(clippy::unwrap_used)]

#[path = "hard/far.rs"]
mod far;
#[path = "hard/fast.rs"]
mod fast;
#[path = "hard/resumed.rs"]
mod resumed;
#[path = "hard/squeezed.rs"]
mod squeezed;

use ipc_contact::ContactError;
use mechanics_core::potential::{Potential, PotentialError};
use mechanics_core::stage::{Moment, Scheme, Stage};
use mechanics_core::tensor::Vec3;

/// Tells a term where a step begins.
fn begin_step(term: &mut dyn Potential, x: &[Vec3]) -> Result<(), PotentialError> {
    let scheme = Scheme::statics(x);
    term.freeze(&Stage { moment: Moment::Step, x, time: 0.0, step: 0.0, scheme }).map(drop)
}

/// What contact itself says.
fn contact_error(error: PotentialError) -> ContactError {
    let PotentialError::Term { source, .. } = error else { panic!("{error}") };
    *source.downcast().unwrap()
}

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
