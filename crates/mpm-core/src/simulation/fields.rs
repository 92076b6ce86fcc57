//! Fields of the particles that a caller sets or reads: what manufactured solutions and conservation laws need.

use super::Simulation;
use crate::MpmError;
use mechanics_core::lanes::Element;
use mechanics_core::tensor::Mat3;

impl<E: Element, const D: usize> Simulation<E, D> {
    /// Adds h · acceleration to the velocities of a body's particles: a body force, one acceleration a particle \[m/s²\], for the step
    /// of h \[s\] that follows.
    ///
    /// Given before each step at the particles' present places, it is integrated as gravity is: symplectic Euler.
    ///
    /// # Errors
    /// [`MpmError::Count`] or [`MpmError::Particle`] for a wrong number of accelerations, or one that is not finite or whose change of velocity is not, in the particles'
    /// precision; [`MpmError::Step`] unless h is finite. Nothing is changed then.
    ///
    /// # Panics
    /// If there is no such body.
    pub fn accelerate(&mut self, body: usize, accelerations: &[[f64; D]], step: f64) -> Result<(), MpmError> {
        self.check_field(body, "accelerations", accelerations.len())?;
        if !step.is_finite() {
            return Err(MpmError::Step { value: step });
        }
        for (particle, acceleration) in accelerations.iter().enumerate() {
            check_finite::<E>(body, particle, "acceleration", acceleration)?;
            let change = acceleration.map(|a| step * a);
            check_finite::<E>(body, particle, "change of velocity by an acceleration", &change)?;
        }
        let particles = &mut self.bodies[body].particles;
        let first = particles.layout.velocity;
        for (slot, acceleration) in particles.slots().into_iter().zip(accelerations) {
            for (axis, a) in acceleration.iter().enumerate() {
                let before = particles.number(slot as usize, first + axis);
                particles.set_number(slot as usize, first + axis, before + E::constant(step * a));
            }
        }
        self.limits = None;
        Ok(())
    }

    /// The affine velocities C of a body's particles under APIC and MLS-APIC, else their velocity gradients ∇v, by their numbers: row a, column b
    /// is ∂v_a/∂x_b \[1/s\].
    ///
    /// # Panics
    /// If there is no such body.
    pub fn velocity_gradients(&self, body: usize) -> Vec<[[f64; D]; D]> {
        let particles = &self.bodies[body].particles;
        let first = particles.layout.gradient;
        let number =
            |slot: u32, a: usize, b: usize| particles.number(slot as usize, first + b * D + a).into();
        let matrix = |slot| std::array::from_fn(|a| std::array::from_fn(|b| number(slot, a, b)));
        particles.slots().into_iter().map(matrix).collect()
    }

    /// Sets what [`velocity_gradients`](Self::velocity_gradients) gives. Without it a body starts with zeros, and the first step filters its
    /// velocities as PIC does.
    ///
    /// # Errors
    /// [`MpmError::Count`] or [`MpmError::Particle`] for a wrong number of them, or one that is not finite in the particles' precision. Nothing is changed then.
    ///
    /// # Panics
    /// If there is no such body.
    pub fn set_velocity_gradients(
        &mut self,
        body: usize,
        gradients: &[[[f64; D]; D]],
    ) -> Result<(), MpmError> {
        self.check_field(body, "velocity gradients", gradients.len())?;
        for (particle, gradient) in gradients.iter().enumerate() {
            check_finite::<E>(body, particle, "velocity gradient", gradient.as_flattened())?;
        }
        let particles = &mut self.bodies[body].particles;
        let first = particles.layout.gradient;
        for (slot, gradient) in particles.slots().into_iter().zip(gradients) {
            for a in 0..D {
                for b in 0..D {
                    particles.set_number(slot as usize, first + b * D + a, E::constant(gradient[a][b]));
                }
            }
        }
        self.limits = None;
        Ok(())
    }

    /// Sets the strains of a body's particles from deformation gradients, with the history of virgin material.
    ///
    /// # Errors
    /// [`MpmError::Count`] for a wrong number of them, [`MpmError::Law`] with the first that the law refuses. Nothing is changed then.
    ///
    /// # Panics
    /// If there is no such body.
    pub fn set_deformation_gradients(&mut self, body: usize, gradients: &[Mat3]) -> Result<(), MpmError> {
        self.check_field(body, "deformation gradients", gradients.len())?;
        let Self { bodies, limits, .. } = self;
        let target = &mut bodies[body];
        for (particle, gradient) in gradients.iter().enumerate() {
            target.check_deformation(gradient).map_err(|source| MpmError::Law { body, particle, source })?;
        }
        for (slot, gradient) in target.particles.slots().into_iter().zip(gradients) {
            target.deform(slot as usize, gradient);
        }
        *limits = None;
        Ok(())
    }

    fn check_field(&self, body: usize, what: &'static str, count: usize) -> Result<(), MpmError> {
        let particles = self.particle_count(body);
        if count == particles { Ok(()) } else { Err(MpmError::Count { what, count, particles }) }
    }
}

/// In the precision of the particles: what a double holds may be beyond theirs.
fn check_finite<E: Element>(
    body: usize,
    particle: usize,
    what: &'static str,
    numbers: &[f64],
) -> Result<(), MpmError> {
    match numbers.iter().find(|x| !E::constant(**x).is_finite()) {
        Some(value) => Err(MpmError::Particle { body, particle, what, value: *value, wanted: "finite" }),
        None => Ok(()),
    }
}
