//! States of motion, sampled.

use crate::coordinates::{Coordinates, Phase};

/// The states of one motion at increasing times.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory<C> {
    /// Times \[s\].
    pub times: Vec<f64>,
    /// The coordinates at each time.
    pub q: Vec<C>,
    /// The velocities at each time.
    pub v: Vec<C>,
}

impl<C> Default for Trajectory<C> {
    fn default() -> Self {
        Self { times: Vec::new(), q: Vec::new(), v: Vec::new() }
    }
}

impl<C: Coordinates> Trajectory<C> {
    /// No state, with room for `capacity` of them.
    pub fn with_capacity(capacity: usize) -> Self {
        Self {
            times: Vec::with_capacity(capacity),
            q: Vec::with_capacity(capacity),
            v: Vec::with_capacity(capacity),
        }
    }

    /// Appends a state.
    pub fn push(&mut self, phase: &Phase<C>) {
        self.times.push(phase.time);
        self.q.push(phase.q.clone());
        self.v.push(phase.v.clone());
    }

    /// The number of states.
    pub fn len(&self) -> usize {
        self.times.len()
    }

    /// Whether there is no state.
    pub fn is_empty(&self) -> bool {
        self.times.is_empty()
    }

    /// The state at `index`.
    ///
    /// # Panics
    /// If there are not that many.
    pub fn phase(&self, index: usize) -> Phase<C> {
        Phase { time: self.times[index], q: self.q[index].clone(), v: self.v[index].clone() }
    }

    /// All states, in order.
    pub fn phases(&self) -> impl Iterator<Item = Phase<C>> + '_ {
        (0..self.len()).map(|index| self.phase(index))
    }
}
