//! Where the energy of a world with friction goes.

use lagrangian::element::Mass;
use mechanics_core::potential::Potential;
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;

/// What became of energy since the start (J).
///
/// A step of backward Euler solves M (v₁ − v₀)/h + ∇E(x₁) + ∇D(x₁) = f, with the forces f on scripted points. Times x₁ − x₀ = h v₁
/// that is T₁ − T₀ + ½‖v₁ − v₀‖²_M + E₁ − E₀ + [E₀ − E₁ + ∇E(x₁)·(x₁ − x₀)] + ∇D·(x₁ − x₀) = f·(x₁ − x₀): each part is found by itself,
/// and they add up to zero as far as the step's equation is solved and what friction says it took out is what its forces did.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::experiment) struct EnergyBalance {
    /// Kinetic energy at the start.
    pub(in crate::experiment) at_start: f64,
    /// Kinetic energy gained.
    pub(in crate::experiment) kinetic: f64,
    /// Potential energy gained: of elasticity, loads and contact.
    pub(in crate::experiment) potential: f64,
    /// Taken out by friction.
    pub(in crate::experiment) friction: f64,
    /// Taken out by backward Euler itself.
    pub(in crate::experiment) numerical: f64,
    /// Put in by scripted points and moving surfaces.
    pub(in crate::experiment) work: f64,
    largest_potential: f64,
}

/// What a step began with, and what it did.
pub(in crate::experiment) struct EnergyOfStep<'a> {
    pub(in crate::experiment) before: &'a State,
    pub(in crate::experiment) after: &'a State,
    pub(in crate::experiment) mass: &'a Mass,
    pub(in crate::experiment) scripted: &'a [u32],
    /// Step (s).
    pub(in crate::experiment) h: f64,
}

impl EnergyOfStep<'_> {
    fn way(&self) -> Vec<Vec3> {
        self.after.position.iter().zip(&self.before.position).map(|(b, a)| b - a).collect()
    }

    fn velocity_change(&self) -> Vec<Vec3> {
        self.after.velocity.iter().zip(&self.before.velocity).map(|(b, a)| b - a).collect()
    }

    fn kinetic(&self) -> [f64; 2] {
        [self.before, self.after].map(|state| self.mass.kinetic_energy(&state.velocity))
    }
}

impl EnergyBalance {
    /// Adds a step whose terms are those that keep energy, and friction, which took `dissipated` (J) out, and
    /// moving surfaces put `driven` (J) in.
    pub(in crate::experiment) fn add(
        &mut self,
        step: &EnergyOfStep<'_>,
        keeping: &[&dyn Potential],
        (friction, dissipated, driven): (&dyn Potential, f64, f64),
    ) {
        let (way, change) = (step.way(), step.velocity_change());
        let [before, after] = step.kinetic();
        if step.before.step == 0 {
            self.at_start = before;
        }
        self.kinetic += after - before;
        self.numerical += step.mass.kinetic_energy(&change);
        let (x0, x1) = (&step.before.position, &step.after.position);
        let mut forces: Vec<Vec3> = step.mass.momenta(&change).into_iter().map(|p| p / step.h).collect();
        for term in keeping {
            let gained = term.value(x1) - term.value(x0);
            self.potential += gained;
            self.numerical += add_force(*term, x1, &way, &mut forces) - gained;
        }
        add_force(friction, x1, &way, &mut forces);
        self.friction += dissipated;
        let scripted = step.scripted.iter().map(|&point| forces[point as usize].dot(&way[point as usize]));
        self.work += driven + scripted.sum::<f64>();
        self.largest_potential = self.largest_potential.max(self.potential.abs());
    }

    /// What is not accounted for, in parts of what was turned over.
    pub(in crate::experiment) fn gap(&self) -> f64 {
        let found = self.kinetic + self.potential + self.friction + self.numerical;
        let whole = self.at_start + self.largest_potential + self.friction + self.work.abs();
        if whole > 0.0 { (found - self.work).abs() / whole } else { 0.0 }
    }
}

/// Adds the gradient at `x` to `forces`; answers its product with the way (J).
fn add_force(term: &dyn Potential, x: &[Vec3], way: &[Vec3], forces: &mut [Vec3]) -> f64 {
    let mut gradient = vec![Vec3::zeros(); x.len()];
    term.add_gradient(x, &mut gradient);
    forces.iter_mut().zip(&gradient).for_each(|(force, g)| *force += g);
    gradient.iter().zip(way).map(|(g, w)| g.dot(w)).sum()
}
