//! Position-based dynamics: motion by projecting positions onto constraints.
//!
//! A step of length h takes particles with positions xₙ, velocities vₙ and inverse masses w (zero for held ones) and
//!
//! 1. predicts: v = vₙ + h a (a the external acceleration), x = xₙ + h v;
//! 2. projects, `iterations` times, every constraint C(x) = 0 (or C(x) ≥ 0) in turn, the next seeing what the last one
//!    moved (Gauss and Seidel's way):
//!    - [`Response::Classic`] (Müller et al. 2007, equation (9)): Δxᵢ = −s wᵢ ∇ᵢC C/Σⱼ wⱼ|∇ⱼC|², 0 < s ≤ 1. A single
//!      constraint is left with the part (1 − s)ⁿ of its violation after n iterations: **how stiff it is depends on the
//!      number of iterations and on h**;
//!    - [`Response::Compliant`] (XPBD; Macklin et al. 2016, equation (18)): the constraint is a spring with the energy
//!      ½C²/α, α its compliance, and keeps its multiplier λ over the iterations of a step:
//!      Δλ = −(C + α̃ λ)/(Σⱼ wⱼ|∇ⱼC|² + α̃), Δxᵢ = wᵢ ∇ᵢC Δλ, α̃ = α/h². At C = −α̃ λ nothing moves any more, so
//!      the stiffness depends on neither. α = 0 is rigid;
//! 3. updates v = (x − xₙ)/h.
//!
//! # What it solves, and how well
//!
//! Implicit Euler minimises ½‖x − x̃‖²_M/h² + Σ C²/2α over x, x̃ the prediction. With λ = −C/α̃ its equations are
//!
//! - M(x − x̃) = Σ ∇C(x) λ  (1)   and   C(x) + α̃ λ = 0  (2).
//!
//! XPBD starts at x = x̃, λ = 0, where (1) holds, and its moves keep M(x − x̃) = Σₖ ∇C(xₖ) Δλₖ, with the gradients at the
//! iterates xₖ on the way. So where gradients do not turn — straight chains; one spring, whose ends move along its own
//! line — what it converges to *is* implicit Euler's step. **One spring needs one iteration**: the move along the unit
//! vector n changes C by (w₀ + w₁) Δλ, so that after it C + α̃ λ = C₀ + (w₀ + w₁ + α̃) Δλ = 0, which is (2), and (1) holds
//! because n is the same before and after. Otherwise (2) is met in the limit and (1) up to the turning of the gradients
//! within a step, an error that vanishes as h → 0; no number of iterations removes it. Gauss–Seidel converges as slowly
//! as it does for any stiff chain: by a factor about 1 − O(1/n²) an iteration for n links.
//!
//! Linear momentum is conserved to rounding by all constraints between particles. Angular momentum is as in implicit
//! Euler: moves turn nothing about the positions they are made at, but velocities refer to xₙ, so there is a drift that
//! vanishes as h does.
//!
//! # Order and threads
//!
//! Each group's constraints are coloured greedily in their order, so that those of one colour share no particle;
//! a sweep goes colour by colour, and groups go in the order given. The result depends on the input alone. Everything runs on
//! one thread.
//!
//! # Reference
//! M. Müller, B. Heidelberger, M. Hennix, J. Ratcliff, *Position based dynamics*, J. Vis. Commun. Image R. 18 (2007).
//! M. Macklin, M. Müller, N. Chentanez, *XPBD: position-based simulation of compliant constrained dynamics*, MIG 2016.

mod colouring;
mod constraint;
mod error;
mod group;

pub use constraint::{Bends, ConstraintKind, Distances, Ground, PositionConstraint, Volumes};
pub use error::PositionError;
pub use group::{ConstraintGroup, Constraints, GroupReport, Response};

use mechanics_core::tensor::Vec3;

/// Particles: positions \[m\], velocities [m/s], inverse masses [1/kg].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Particles {
    /// Positions \[m\].
    pub positions: Vec<Vec3>,
    /// Velocities [m/s].
    pub velocities: Vec<Vec3>,
    inverse_masses: Vec<f64>,
}

impl Particles {
    /// Particles at rest.
    ///
    /// # Errors
    /// A position that is not finite; an inverse mass that is negative or not finite (zero holds a particle).
    ///
    /// # Panics
    /// If there is not one inverse mass per position.
    pub fn new(positions: Vec<Vec3>, inverse_masses: Vec<f64>) -> Result<Self, PositionError> {
        assert_eq!(positions.len(), inverse_masses.len(), "one inverse mass per particle");
        for (particle, &value) in inverse_masses.iter().enumerate() {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(PositionError::InverseMass { particle, value });
            }
        }
        check_finite("position", &positions)?;
        let velocities = vec![Vec3::zeros(); positions.len()];
        Ok(Self { positions, velocities, inverse_masses })
    }

    /// Inverse masses [1/kg]; zero for held particles.
    pub fn inverse_masses(&self) -> &[f64] {
        &self.inverse_masses
    }

    /// ½ Σ m |v|² over the particles that move \[J\].
    pub fn kinetic_energy(&self) -> f64 {
        self.moving().map(|(i, m)| 0.5 * m * self.velocities[i].norm_squared()).sum()
    }

    /// Σ m v over the particles that move [kg m/s].
    pub fn momentum(&self) -> Vec3 {
        self.moving().map(|(i, m)| self.velocities[i] * m).sum()
    }

    /// Σ x × m v over the particles that move [kg m²/s].
    pub fn angular_momentum(&self) -> Vec3 {
        self.moving().map(|(i, m)| self.positions[i].cross(&(self.velocities[i] * m))).sum()
    }

    fn moving(&self) -> impl Iterator<Item = (usize, f64)> {
        let masses = self.inverse_masses.iter().enumerate();
        masses.filter(|(_, w)| **w > 0.0).map(|(i, w)| (i, 1.0 / w))
    }
}

/// How a step is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionBased {
    /// Sweeps over all constraints in a step.
    pub iterations: u32,
    /// The acceleration of all particles that move, gravity for example [m/s²].
    pub acceleration: Vec3,
}

/// What a step did.
#[derive(Clone, Debug, PartialEq)]
pub struct PositionReport {
    /// Constraints projected, over all iterations.
    pub projections: u64,
    /// Projections passed over because the constraint has no gradient there (coincident points, a collapsed triangle) or
    /// none of its particles can move.
    pub passed_over: u64,
    /// Where each group stands at the end.
    pub groups: Vec<GroupReport>,
    /// Kinetic energy at the end \[J\].
    pub kinetic_energy: f64,
}

impl PositionBased {
    /// Advances `particles` by `h` \[s\].
    ///
    /// # Errors
    /// A step that is not positive, no iterations, an acceleration, position or velocity that is not finite (before or
    /// after the step), a constraint that names a particle that does not exist. The particles are then as they were.
    pub fn step(
        &self,
        particles: &mut Particles,
        constraints: &mut [&mut dyn Constraints],
        h: f64,
    ) -> Result<PositionReport, PositionError> {
        self.check(particles, constraints, h)?;
        let w = &particles.inverse_masses;
        let start = &particles.positions;
        let predict = |i: usize| {
            let velocity = particles.velocities[i] + self.acceleration * h;
            if w[i] > 0.0 { start[i] + velocity * h } else { start[i] }
        };
        let mut x: Vec<Vec3> = (0..start.len()).map(predict).collect();
        constraints.iter_mut().for_each(|group| group.begin_step());
        let (mut projections, mut passed_over) = (0, 0);
        for _ in 0..self.iterations {
            for group in constraints.iter_mut() {
                let [done, passed] = group.sweep(&mut x, w, h);
                projections += done;
                passed_over += passed;
            }
        }
        check_finite("position after the step", &x)?;
        let velocities: Vec<Vec3> = x.iter().zip(start).map(|(end, start)| (end - start) / h).collect();
        check_finite("velocity after the step", &velocities)?;
        let groups = constraints.iter().map(|group| group.report(&x, h)).collect();
        (particles.positions, particles.velocities) = (x, velocities);
        Ok(PositionReport { projections, passed_over, groups, kinetic_energy: particles.kinetic_energy() })
    }

    fn check(
        &self,
        particles: &Particles,
        constraints: &[&mut dyn Constraints],
        h: f64,
    ) -> Result<(), PositionError> {
        if !(h > 0.0 && h.is_finite()) {
            return Err(PositionError::Step { step: h });
        }
        if self.iterations == 0 {
            return Err(PositionError::NoIterations);
        }
        let count = particles.inverse_masses.len();
        assert_eq!(particles.positions.len(), count, "one position per particle");
        assert_eq!(particles.velocities.len(), count, "one velocity per particle");
        check_finite("acceleration", &[self.acceleration])?;
        check_finite("position", &particles.positions)?;
        check_finite("velocity", &particles.velocities)?;
        constraints.iter().try_for_each(|group| group.check_particles(count))
    }
}

fn check_finite(what: &'static str, vectors: &[Vec3]) -> Result<(), PositionError> {
    for (particle, vector) in vectors.iter().enumerate() {
        if let Some(&value) = vector.iter().find(|entry| !entry.is_finite()) {
            return Err(PositionError::NonFinite { what, particle, value });
        }
    }
    Ok(())
}
