//! What acts on bodies from outside: boundaries, prescribed velocities, impulses, tractions, the end of the domain.

use super::Simulation;
use crate::MpmError;
use crate::boundary::{Boundary, PrescribedVelocity};
use crate::forecast::Domain;
use crate::grip::{Grip, PlacedGrip};
use crate::traction::{Piece, Traction};
use mechanics_core::lanes::Element;

impl<E: Element, const D: usize> Simulation<E, D> {
    /// Adds a boundary; boundaries act in the order in which they were added.
    ///
    /// # Errors
    /// [`MpmError::Number`] for a velocity that is not finite or a coefficient of friction below zero, [`MpmError::Shape`] for a shape
    /// without size or a normal that is not of unit length.
    pub fn add_boundary(&mut self, boundary: Boundary<D>) -> Result<(), MpmError> {
        boundary.check()?;
        self.boundaries.push(boundary);
        Ok(())
    }

    /// Adds a prescribed velocity; the last one that reaches a node counts.
    ///
    /// # Errors
    /// [`MpmError::Number`] for a velocity or a begin that is not finite, [`MpmError::Shape`] for a region without size or an end before the
    /// begin.
    pub fn add_prescribed_velocity(&mut self, prescribed: PrescribedVelocity<D>) -> Result<(), MpmError> {
        prescribed.check()?;
        self.prescribed.push(prescribed);
        Ok(())
    }

    /// Adds a grip; the last one that reaches a node counts.
    ///
    /// # Errors
    /// [`MpmError::Number`] for a centre, velocity or begin that is not finite, [`MpmError::Shape`] for a region without size, an end before the begin,
    /// and a turn out of the plane.
    pub fn add_grip(&mut self, grip: Grip<D>) -> Result<(), MpmError> {
        grip.check()?;
        self.grips.push(grip);
        Ok(())
    }

    /// The grips that act in a step of `step` from now on, whose middle is at `middle`.
    pub(super) fn placed_grips(&self, middle: f64, step: f64) -> Vec<PlacedGrip<D>> {
        let acting = self.grips.iter().filter(|grip| grip.acts_at(middle));
        acting.map(|grip| grip.placed(self.time, self.time + step)).collect()
    }

    /// Bounds the space where particles may be: from now on a step that would carry one out of it, by whatever force, fails and is not made. This is a
    /// guard, not a wall; for walls see [`Shape::Walls`](crate::Shape::Walls).
    ///
    /// # Errors
    /// [`MpmError::Shape`] unless `low` < `high`; [`MpmError::OutOfDomain`] with the first particle that is not inside now.
    pub fn set_domain(&mut self, low: [f64; D], high: [f64; D]) -> Result<(), MpmError> {
        for axis in 0..D {
            if !(low[axis] < high[axis]) {
                let (what, value) = ("the width of the domain", high[axis] - low[axis]);
                return Err(MpmError::Shape { what, value, wanted: "positive" });
            }
        }
        let cells = Domain::<D>::of_cells(self.options.spacing);
        let domain = Domain {
            low: std::array::from_fn(|a| low[a].max(cells.low[a])),
            high: std::array::from_fn(|a| high[a].min(cells.high[a])),
        };
        for (number, body) in self.bodies.iter().enumerate() {
            let outside = |slot: usize| {
                let particle = body.particles.ids[slot] as usize;
                domain.check(number, particle, &body.position(slot)).err().map(|error| (particle, error))
            };
            if let Some((_, error)) =
                body.live_slots().filter_map(outside).min_by_key(|(particle, _)| *particle)
            {
                return Err(error);
            }
        }
        self.domain = domain;
        Ok(())
    }

    /// Changes the momenta of particles by impulses \[N s\], at once.
    ///
    /// # Errors
    /// [`MpmError::NoParticle`], or [`MpmError::Particle`] for an impulse that is not finite or too large for its particle's mass. Nothing is changed then.
    ///
    /// # Panics
    /// If there is no such body.
    pub fn apply_impulses(&mut self, body: usize, impulses: &[(usize, [f64; D])]) -> Result<(), MpmError> {
        let particles = &mut self.bodies[body].particles;
        let slots = particles.slots();
        let (mass, first) = (particles.layout.mass, particles.layout.velocity);
        let mut changes = Vec::with_capacity(impulses.len());
        for (particle, impulse) in impulses {
            let particle = *particle;
            let Some(slot) = slots.get(particle).map(|slot| *slot as usize) else {
                return Err(MpmError::NoParticle { body, particle, particles: slots.len() });
            };
            let mass: f64 = particles.number(slot, mass).into();
            let change = impulse.map(|p| p / mass);
            if let Some(value) = change.into_iter().find(|v| !E::constant(*v).is_finite()) {
                let (what, wanted) = ("change of velocity by an impulse", "finite");
                return Err(MpmError::Particle { body, particle, what, value, wanted });
            }
            changes.push((slot, change));
        }
        for (slot, change) in changes {
            for axis in 0..D {
                let velocity = particles.number(slot, first + axis) + E::constant(change[axis]);
                particles.set_number(slot, first + axis, velocity);
            }
        }
        self.limits = None;
        Ok(())
    }

    /// Loads pieces of a body's surface: particles, each with the rest area vector of its piece (its length the area \[m²\], its direction
    /// outward; in the plane per unit of thickness). See [`Traction`] for the force of a piece. Tractions add up; they act
    /// until [`clear_tractions`](Self::clear_tractions), and they are not part of a checkpoint.
    ///
    /// # Errors
    /// [`MpmError::NoParticle`], [`MpmError::Particle`] for an area vector that is zero or not finite, [`MpmError::Number`] for a traction that
    /// is not finite, [`MpmError::NoTotalDeformation`] for a traction that follows a body which does not keep its total deformation. Nothing is
    /// added then.
    ///
    /// # Panics
    /// If there is no such body.
    pub fn add_traction(
        &mut self,
        body: usize,
        traction: Traction<D>,
        surface: &[(usize, [f64; D])],
    ) -> Result<(), MpmError> {
        let loaded = &mut self.bodies[body];
        let particles = loaded.particles.count;
        if let Some(value) = traction.not_finite() {
            return Err(MpmError::Number { what: "a traction", value });
        }
        if traction.follows() && loaded.total_deformation(0).is_none() {
            return Err(MpmError::NoTotalDeformation { body });
        }
        for &(particle, area) in surface {
            if particle >= particles {
                return Err(MpmError::NoParticle { body, particle, particles });
            }
            let value = area.iter().map(|a| a * a).sum::<f64>().sqrt();
            if !(value > 0.0 && value.is_finite()) {
                let (what, wanted) = ("area", "positive and finite");
                return Err(MpmError::Particle { body, particle, what, value, wanted });
            }
        }
        let piece = |&(particle, area): &(usize, [f64; D])| Piece {
            particle: particle as u32,
            slot: 0,
            area,
            traction,
        };
        loaded.pieces.extend(surface.iter().map(piece));
        loaded.place_pieces();
        Ok(())
    }

    /// Takes all tractions off a body.
    ///
    /// # Panics
    /// If there is no such body.
    pub fn clear_tractions(&mut self, body: usize) {
        self.bodies[body].pieces.clear();
    }
}
