//! The state that a time-stepping scheme carries from step to step.
//!
//! A [`State`] holds what every scheme has (time, step index, positions, velocities) and, by name, what only some
//! have: the positions and velocities of earlier steps for BDF2, the accelerations for Newmark. It goes into a
//! [`Checkpoint`] and comes back bit by bit, and [`State::hash`] tells whether two runs agree.

mod hash;

pub use hash::StateHash;

use crate::checkpoint::{Checkpoint, CheckpointError};
use crate::tensor::Vec3;
use std::collections::BTreeMap;

/// Positions and velocities of points at one time, with the history of the scheme that moves them.
///
/// ```
/// use mechanics_core::checkpoint::Checkpoint;
/// use mechanics_core::state::State;
/// use mechanics_core::tensor::Vec3;
///
/// let mut state = State::at_rest(vec![Vec3::new(0.0, 0.0, 1.0)]);
/// state.set_history("earlier position", state.position.clone());
/// let mut checkpoint = Checkpoint::new();
/// state.save(&mut checkpoint, "body");
/// let resumed = State::load(&mut checkpoint, "body")?;
/// assert_eq!(resumed.hash(), state.hash());
/// # Ok::<(), mechanics_core::checkpoint::CheckpointError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// Time since the start \[s\].
    pub time: f64,
    /// How many steps have been taken.
    pub step: u64,
    /// Where the points are \[m\].
    pub position: Vec<Vec3>,
    /// How fast they move \[m/s\]; as many as there are positions.
    pub velocity: Vec<Vec3>,
    history: BTreeMap<String, Vec<Vec3>>,
}

impl State {
    /// Points at rest at time zero, without history.
    pub fn at_rest(position: Vec<Vec3>) -> Self {
        let velocity = vec![Vec3::zeros(); position.len()];
        Self { position, velocity, ..Self::default() }
    }

    /// The number of points.
    pub fn point_count(&self) -> usize {
        self.position.len()
    }

    /// The scheme's array called `name`, one vector per point; `None` before the first step that stores it.
    pub fn history(&self, name: &str) -> Option<&[Vec3]> {
        self.history.get(name).map(Vec::as_slice)
    }

    /// Stores the scheme's array called `name`, replacing an earlier one.
    ///
    /// # Panics
    /// If there is not one vector per point.
    pub fn set_history(&mut self, name: &str, values: Vec<Vec3>) {
        assert_eq!(values.len(), self.point_count(), "one vector of {name:?} per point");
        self.history.insert(name.to_owned(), values);
    }

    /// Forgets the scheme's history: after a jump (a restart from edited positions, a changed step size that the
    /// scheme cannot bridge) it starts anew.
    pub fn clear_history(&mut self) {
        self.history.clear();
    }

    /// Puts everything into `checkpoint`, under names that begin with `prefix/`.
    ///
    /// # Panics
    /// If there is not one velocity per position, if the checkpoint already has a state under this prefix, or if a
    /// name grows longer than [`LONGEST_NAME`](crate::checkpoint::LONGEST_NAME).
    pub fn save(&self, checkpoint: &mut Checkpoint, prefix: &str) {
        assert_eq!(self.velocity.len(), self.point_count(), "one velocity per point");
        checkpoint.put_one(&format!("{prefix}/time"), self.time);
        checkpoint.put_one(&format!("{prefix}/step"), self.step);
        checkpoint.put(&format!("{prefix}/position"), &self.position);
        checkpoint.put(&format!("{prefix}/velocity"), &self.velocity);
        for (name, values) in &self.history {
            checkpoint.put(&format!("{}{name}", history_prefix(prefix)), values);
        }
    }

    /// Takes a saved state out of `checkpoint`. After an error the checkpoint is as it was.
    ///
    /// # Errors
    /// [`CheckpointError`] names the section that is missing, of the wrong type, or whose length differs from that
    /// of the positions.
    pub fn load(checkpoint: &mut Checkpoint, prefix: &str) -> Result<Self, CheckpointError> {
        let [time, step] = ["time", "step"].map(|name| format!("{prefix}/{name}"));
        let [position, velocity] = ["position", "velocity"].map(|name| format!("{prefix}/{name}"));
        let start = history_prefix(prefix);
        let names: Vec<String> = checkpoint
            .sections()
            .filter_map(|(name, ..)| name.strip_prefix(&start))
            .map(str::to_owned)
            .collect();

        checkpoint.require_length::<f64>(&time, 1)?;
        checkpoint.require_length::<u64>(&step, 1)?;
        let points = checkpoint.length::<Vec3>(&position)?;
        checkpoint.require_length::<Vec3>(&velocity, points)?;
        for name in &names {
            checkpoint.require_length::<Vec3>(&format!("{start}{name}"), points)?;
        }

        let mut history = BTreeMap::new();
        for name in names {
            let values = checkpoint.take(&format!("{start}{name}"))?;
            history.insert(name, values);
        }
        Ok(Self {
            time: checkpoint.take_one(&time)?,
            step: checkpoint.take_one(&step)?,
            position: checkpoint.take(&position)?,
            velocity: checkpoint.take(&velocity)?,
            history,
        })
    }

    /// The fingerprint of everything in this state, see [`StateHash`].
    pub fn hash(&self) -> u64 {
        let mut hash = StateHash::new();
        hash.add("time", &[self.time]);
        hash.add_integers("step", &[self.step]);
        hash.add_vectors("position", &self.position);
        hash.add_vectors("velocity", &self.velocity);
        for (name, values) in &self.history {
            hash.add_vectors(&format!("history/{name}"), values);
        }
        hash.value()
    }
}

fn history_prefix(prefix: &str) -> String {
    format!("{prefix}/history/")
}
