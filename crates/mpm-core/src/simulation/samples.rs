//! What a body is made of at the start.

use crate::MpmError;
use crate::forecast::Domain;
use mechanics_core::lanes::Element;

/// The particles of a body at the start.
#[derive(Clone, Copy, Debug)]
pub struct Samples<'a, const D: usize> {
    /// Where they are \[m\].
    pub positions: &'a [[f64; D]],
    /// How they move \[m/s\].
    pub velocities: &'a [[f64; D]],
    /// Which part of the body each one stands for \[m³\], in the plane per unit of thickness.
    pub volumes: &'a [f64],
}

impl<const D: usize> Samples<'_, D> {
    /// Confirms that particles of precision `E` can be made.
    pub(super) fn check<E: Element>(
        &self,
        body: usize,
        density: f64,
        domain: &Domain<D>,
    ) -> Result<(), MpmError> {
        let particles = self.positions.len();
        if particles == 0 {
            return Err(MpmError::EmptyBody);
        }
        for (what, count) in [("velocities", self.velocities.len()), ("volumes", self.volumes.len())] {
            if count != particles {
                return Err(MpmError::Count { what, count, particles });
            }
        }
        if !(density > 0.0 && density.is_finite()) {
            return Err(MpmError::Number { what: "a density", value: density });
        }
        (0..particles).try_for_each(|particle| self.check_particle::<E>(body, particle, density, domain))
    }

    fn check_particle<E: Element>(
        &self,
        body: usize,
        particle: usize,
        density: f64,
        domain: &Domain<D>,
    ) -> Result<(), MpmError> {
        let wrong = |what, value, wanted| MpmError::Particle { body, particle, what, value, wanted };
        // A double may be beyond the range of the particles' precision.
        let finite = |value: &f64| E::constant(*value).is_finite();
        let position = self.positions[particle];
        if let Some(value) = position.into_iter().find(|x| !finite(x)) {
            return Err(wrong("position", value, "finite"));
        }
        if let Some(value) = self.velocities[particle].into_iter().find(|x| !finite(x)) {
            return Err(wrong("velocity", value, "finite"));
        }
        let volume = self.volumes[particle];
        for (what, value) in [("volume", volume), ("mass", density * volume)] {
            if E::constant(value).less_equal(E::default()) || !finite(&value) {
                return Err(wrong(what, value, "positive and finite"));
            }
        }
        domain.check(body, particle, &position)
    }
}
