//! Checkpoints: the state as arrays, as it lies in memory.

use super::Simulation;
use crate::body::Travel;
use crate::collider::NEUTRAL;
use crate::material::Stiffness;
use crate::particles::Order;
use crate::particles::{ParticleBlock, Stored};
use mechanics_core::checkpoint::{self, Checkpoint, CheckpointError};
use mechanics_core::lanes::Element;
use mechanics_core::state::StateHash;

/// Why a checkpoint cannot be resumed from. The simulation is as it was.
#[derive(Debug, thiserror::Error)]
pub enum ResumeError {
    /// Something is missing, too much, or of another kind: the checkpoint is not one of a simulation of this set-up.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// The arrays contradict each other.
    #[error("the checkpoint's body {body} is not a state of such a body: {what}")]
    Body {
        /// The body's number.
        body: usize,
        /// What is wrong.
        what: &'static str,
    },
    /// A collider's numbers are too many or too few.
    #[error("the checkpoint's collider {collider} is none")]
    Collider {
        /// Its number.
        collider: usize,
    },
    /// The simulation has other bodies.
    #[error("the checkpoint has {stored} bodies, the simulation {wanted}")]
    Bodies {
        /// Bodies in the checkpoint.
        stored: u64,
        /// Bodies here.
        wanted: u64,
    },
}

/// What a checkpoint of this crate calls itself.
const SCHEME: &str = "mpm-core, explicit";

impl<E: Element + checkpoint::Element, const D: usize> Simulation<E, D> {
    /// The state: time, particles, and their order in memory, on which the last bits of later sums depend.
    ///
    /// The set-up (options, laws, gravity, boundaries, prescribed velocities, grips, colliders but their places and loads, tractions, domain) is not in it: whoever resumes makes
    /// the same one first.
    pub fn checkpoint(&self) -> Checkpoint {
        let mut checkpoint = Checkpoint::new();
        checkpoint.put_text("scheme", SCHEME);
        checkpoint.put_one("bodies", self.bodies.len() as u64);
        checkpoint.put_one("time", self.time);
        checkpoint.put_one("steps", self.steps);
        checkpoint.put_one("sorted", u64::from(self.sorted));
        let limits = self.limits.map(|(stiffness, travel)| {
            [stiffness.expansion, stiffness.wave, travel.speed_squared, travel.rate_squared]
        });
        checkpoint.put("limits", limits.as_ref().map_or(&[][..], |limits| limits));
        for (number, collider) in self.colliders.iter().enumerate() {
            checkpoint.put(&format!("collider {number}"), &collider.numbers());
        }
        for (number, body) in self.bodies.iter().enumerate() {
            let particles = &body.particles;
            let name = |what: &str| format!("body {number}/{what}");
            checkpoint.put(&name("numbers"), &particles.data);
            checkpoint.put(&name("particles"), &particles.ids);
            let origins: Vec<u32> =
                particles.blocks.iter().flat_map(|block| block.origin.map(i32::cast_unsigned)).collect();
            checkpoint.put(&name("block origins"), &origins);
            let ends: Vec<u64> =
                particles.blocks.iter().flat_map(|block| [block.end as u64, block.count as u64]).collect();
            checkpoint.put(&name("block ends"), &ends);
        }
        checkpoint
    }

    /// Goes on from a checkpoint of a simulation of the same set-up, as if that had never stopped: the same bits.
    ///
    /// # Errors
    /// [`ResumeError`] if the checkpoint is not one of such a simulation.
    pub fn resume(&mut self, mut checkpoint: Checkpoint) -> Result<(), ResumeError> {
        checkpoint.take_matching_text("scheme", SCHEME)?;
        let (stored, wanted) = (checkpoint.take_one::<u64>("bodies")?, self.bodies.len() as u64);
        if stored != wanted {
            return Err(ResumeError::Bodies { stored, wanted });
        }
        let time = checkpoint.take_one::<f64>("time")?;
        let steps = checkpoint.take_one::<u64>("steps")?;
        let sorted = checkpoint.take_one::<u64>("sorted")? != 0;
        let limits = checkpoint.take::<f64>("limits")?;
        let limits = match limits[..] {
            [expansion, wave, speed_squared, rate_squared] => {
                let travel = Travel { speed_squared, rate_squared, left: !sorted };
                Some((Stiffness { expansion, wave }, travel))
            }
            _ => None,
        };
        let mut colliders = Vec::with_capacity(self.colliders.len());
        for (number, collider) in self.colliders.iter().enumerate() {
            let numbers = checkpoint.take::<f64>(&format!("collider {number}"))?;
            colliders
                .push(collider.with_numbers(&numbers).ok_or(ResumeError::Collider { collider: number })?);
        }
        let mut bodies = Vec::with_capacity(self.bodies.len());
        for (number, body) in self.bodies.iter().enumerate() {
            let stored = take_particles(&mut checkpoint, number)?;
            let check = body.particles.check_stored(
                &stored,
                self.options.spacing,
                self.options.kernel.width(),
                if sorted { Order::Fresh } else { Order::Stale },
            );
            check.map_err(|what| ResumeError::Body { body: number, what })?;
            bodies.push(stored);
        }
        checkpoint.finish()?;
        self.colliders = colliders;
        for (body, stored) in self.bodies.iter_mut().zip(bodies) {
            body.particles.restore(stored);
            body.place_pieces();
        }
        (self.time, self.steps, self.limits) = (time, steps, limits);
        self.sorted = false;
        if sorted {
            self.find_sides();
            self.rebuild();
        }
        Ok(())
    }

    /// A fingerprint of the state: equal for equal bits of time, particles and their order.
    pub fn state_hash(&self) -> u64 {
        let mut hash = StateHash::new();
        hash.add("time", &[self.time]);
        hash.add_integers("steps", &[self.steps]);
        for body in &self.bodies {
            let numbers: Vec<f64> = body.particles.data.iter().map(|x| (*x).into()).collect();
            hash.add("numbers", &numbers);
            let particles: Vec<u64> = body.particles.ids.iter().map(|id| u64::from(*id)).collect();
            hash.add_integers("particles", &particles);
        }
        hash.value()
    }
}

fn take_particles<E: Element + checkpoint::Element, const D: usize>(
    checkpoint: &mut Checkpoint,
    body: usize,
) -> Result<Stored<E, D>, ResumeError> {
    let name = |what: &str| format!("body {body}/{what}");
    let data = checkpoint.take::<E>(&name("numbers"))?;
    let ids = checkpoint.take::<u32>(&name("particles"))?;
    let origins = checkpoint.take::<u32>(&name("block origins"))?;
    let ends = checkpoint.take::<u64>(&name("block ends"))?;
    if origins.len() * 2 != ends.len() * D {
        return Err(ResumeError::Body { body, what: "blocks without origin or end" });
    }
    let block = |(origin, end): (&[u32], &[u64])| ParticleBlock {
        origin: std::array::from_fn(|axis| origin[axis].cast_signed()),
        // Found again from the particles' places.
        sides: NEUTRAL,
        end: usize::try_from(end[0]).unwrap_or(usize::MAX),
        count: usize::try_from(end[1]).unwrap_or(usize::MAX),
    };
    let blocks = origins.chunks_exact(D).zip(ends.chunks_exact(2)).map(block).collect();
    Ok(Stored { data, ids, blocks })
}
