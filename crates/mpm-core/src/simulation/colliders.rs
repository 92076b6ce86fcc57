//! Colliders of a simulation: putting them in, moving them, what they take.

use super::Simulation;
use crate::MpmError;
use crate::collider::{
    Collider, ColliderLoad, Impulse, MOST_SHEETS, PlacedCollider, Placement, RigidMotion, carried_over,
};
use crate::traction::embedded;
use mechanics_core::lanes::Element;
use mechanics_core::mesh::TriMesh;

impl<E: Element> Simulation<E, 3> {
    /// Adds a collider where its mesh is; it begins to move now. Colliders act after the boundaries, in the order in which they were
    /// added. Answers its number.
    ///
    /// # Errors
    /// [`MpmError::Number`] for a motion that is not finite or a coefficient of friction below zero, [`MpmError::InCollider`] with the
    /// first particle that is inside of it, or in its sheet, [`MpmError::Shape`] for a 33rd sheet. Nothing is added then.
    pub fn add_collider(&mut self, collider: Collider) -> Result<usize, MpmError> {
        let placed = PlacedCollider::new(collider, self.time)?;
        let number = self.colliders.len();
        let sheets = self.colliders.iter().filter(|collider| collider.is_sheet()).count();
        if placed.is_sheet() && sheets == MOST_SHEETS {
            let (what, value) = ("the number of sheets", (sheets + 1) as f64);
            return Err(MpmError::Shape { what, value, wanted: "32 at most" });
        }
        for (body, particles) in self.bodies.iter().enumerate() {
            for (particle, slot) in particles.particles.slots().into_iter().enumerate() {
                let position = particles.position(slot as usize);
                self.check_place(&placed, number, (body, particle), &position)?;
            }
        }
        self.colliders.push(placed);
        // Particles have other sides now.
        self.sorted = false;
        Ok(number)
    }

    /// Gives a collider another motion from now on; it goes on from where it is. Seam for rigid bodies that feel what they touch.
    ///
    /// # Errors
    /// [`MpmError::Number`] for a motion that is not finite.
    ///
    /// # Panics
    /// If there is no such collider.
    pub fn set_collider_motion(&mut self, collider: usize, motion: RigidMotion) -> Result<(), MpmError> {
        self.colliders[collider].set_motion(motion, self.time)
    }

    /// Where a collider is now.
    ///
    /// # Panics
    /// If there is no such collider.
    pub fn collider_placement(&self, collider: usize) -> Placement {
        self.colliders[collider].placement(self.time)
    }

    /// The mesh of a collider where it is now.
    ///
    /// # Panics
    /// If there is no such collider.
    pub fn collider_mesh(&self, collider: usize) -> TriMesh {
        self.colliders[collider].placed_mesh(self.time)
    }

    /// The impulse that matter has given to a collider, in the last step and since it was added. Per time it is the force.
    ///
    /// # Panics
    /// If there is no such collider.
    pub fn collider_load(&self, collider: usize) -> ColliderLoad {
        self.colliders[collider].load
    }

    /// How many colliders there are.
    pub fn collider_count(&self) -> usize {
        self.colliders.len()
    }
}

impl<E: Element, const D: usize> Simulation<E, D> {
    /// Confirms that particles at these places are outside of all colliders.
    pub(super) fn check_outside(&self, body: usize, positions: &[[f64; D]]) -> Result<(), MpmError> {
        for (number, collider) in self.colliders.iter().enumerate() {
            for (particle, position) in positions.iter().enumerate() {
                self.check_place(collider, number, (body, particle), position)?;
            }
        }
        Ok(())
    }

    fn check_place(
        &self,
        collider: &PlacedCollider,
        number: usize,
        (body, particle): (usize, usize),
        position: &[f64; D],
    ) -> Result<(), MpmError> {
        match collider.depth(&embedded(position), self.time, self.options.spacing) {
            None => Ok(()),
            Some(depth) => Err(MpmError::InCollider { body, particle, collider: number, depth }),
        }
    }

    /// Makes what blocks of nodes remember of colliders fit the present blocks, which were `before`.
    pub(super) fn carry_colliders(&mut self, before: &[[i32; D]]) {
        let memories = self.results.drain(..).map(|result| result.memories).collect();
        let carried = carried_over(before, memories, self.grid.blocks());
        self.results.extend(
            carried
                .into_iter()
                .map(|memories| super::BlockResult { memories, ..super::BlockResult::default() }),
        );
    }

    /// Takes the loads of an implicit step, by collider: the step is made.
    pub(super) fn take_loads(&mut self, loads: &[(usize, Impulse)]) {
        for collider in &mut self.colliders {
            collider.load.step = Impulse::default();
        }
        for (collider, load) in loads {
            let taken = &mut self.colliders[*collider].load;
            taken.step.add(load);
            taken.total.add(load);
        }
    }

    /// Sums what the blocks of nodes gave to the colliders, in their order: the step is made.
    pub(super) fn load_colliders(&mut self) {
        for (number, collider) in self.colliders.iter_mut().enumerate() {
            let mut step = Impulse::default();
            for memory in self.results.iter().filter_map(|result| result.memories.get(number)) {
                step.add(&memory.load);
            }
            collider.load.step = step;
            collider.load.total.add(&step);
        }
    }
}
