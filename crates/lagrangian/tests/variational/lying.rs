//! Fault injection for functions of generalised coordinates: they tell the truth but for some calls.

use mechanics_core::scalar::Scalar;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

/// At which calls functions lie, by which factor, and how often they have been asked.
#[derive(Debug, Default)]
pub(crate) struct Switch {
    lies: Mutex<(Range<u64>, f64)>,
    asked: AtomicU64,
}

impl Switch {
    /// From now on the calls of these numbers answer `factor` times the truth; the next call is number 0.
    pub(crate) fn set(&self, calls: Range<u64>, factor: f64) {
        *self.lies.lock().unwrap_or_else(PoisonError::into_inner) = (calls, factor);
        self.asked.store(0, Ordering::Relaxed);
    }

    /// Calls since.
    pub(crate) fn asked(&self) -> u64 {
        self.asked.load(Ordering::Relaxed)
    }

    pub(crate) fn answer<S: Scalar>(&self, truth: S) -> S {
        let number = self.asked.fetch_add(1, Ordering::Relaxed);
        let lies = self.lies.lock().unwrap_or_else(PoisonError::into_inner);
        // Scaled, so that its derivatives lie too: a constant of NaN would have derivatives of zero.
        if lies.0.contains(&number) { truth.scale(lies.1) } else { truth }
    }
}
