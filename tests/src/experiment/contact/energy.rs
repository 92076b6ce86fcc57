//! Where the energy of a world with friction goes, for each time scheme that contact allows.

use ipc_friction::FrictionReport;
use lagrangian::element::Mass;
use lagrangian::stepper::TimeScheme;
use mechanics_core::potential::Potential;
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;

/// What became of energy since the start (J): each part is found by itself, and they add up to zero as far as the step's equation is
/// solved and what friction says it took out is what its forces did.
///
/// With T = ½ ‖v‖²_M, the energy E of elasticity, loads and contact, friction D, and the forces f on scripted points:
///
/// - **Backward Euler** solves M (v₁ − v₀)/h + ∇E(x₁) + ∇D(x₁) = f. Times h v₁ = x₁ − x₀ that is
///   T₁ − T₀ + ½ ‖v₁ − v₀‖²_M + h ∇E·v₁ + h ∇D·v₁ = h f·v₁.
/// - **BDF2**, equal steps, solves M (3v₁ − 4v₀ + v₋₁)/(2h) + ∇E(x₁) + ∇D(x₁) = f. Times h v₁, with G₁ = ½ (T(v₁) + T(2v₁ − v₀)) and
///   G₀ = ½ (T(v₀) + T(2v₀ − v₋₁)): G₁ − G₀ + ½ T(v₁ − 2v₀ + v₋₁) + h ∇E·v₁ + h ∇D·v₁ = h f·v₁ (Dahlquist's G-stability).
/// - **Average acceleration** has x₁ − x₀ = ½h (v₀ + v₁), v₁ − v₀ = ½h (a₀ + a₁) and M a + ∇E + ∇D = f at both ends. So
///   T₁ − T₀ + ½ (∇E₀ + ∇E₁)·(x₁ − x₀) + ½ (∇D₀ + ∇D₁)·(x₁ − x₀) = ½ (f₀ + f₁)·(x₁ − x₀).
///
/// What the scheme itself takes is what these have beyond T₁ − T₀ and E₁ − E₀. Of backward Euler it is at least zero where E is convex. Of BDF2 a
/// part, G − T, is lent and comes back. Of average acceleration it is the error of the trapezoidal rule in E.
///
/// # Reference
/// Hairer, Wanner, *Solving Ordinary Differential Equations II*, 1996, section V.6 (G-stability; equation 6.13 for BDF2).
#[derive(Clone, Debug, Default)]
pub(in crate::experiment) struct EnergyBalance {
    /// Kinetic energy at the start.
    pub(in crate::experiment) at_start: f64,
    /// Kinetic energy gained.
    pub(in crate::experiment) kinetic: f64,
    /// Potential energy gained: of elasticity, loads and contact.
    pub(in crate::experiment) potential: f64,
    /// Taken out by friction.
    pub(in crate::experiment) friction: f64,
    /// Taken out by the scheme itself.
    pub(in crate::experiment) numerical: f64,
    /// Put in by scripted points and moving surfaces.
    pub(in crate::experiment) work: f64,
    /// The heat that friction's reports say, less what moving surfaces put in.
    pub(in crate::experiment) heat: f64,
    largest_potential: f64,
    /// Of the end of the last step; average acceleration asks for them.
    last: Option<Forces>,
}

/// Gradients at an instant.
#[derive(Clone, Debug)]
struct Forces {
    keeping: Vec<Vec<Vec3>>,
    friction: Vec<Vec3>,
}

impl Forces {
    fn at(x: &[Vec3], keeping: &[&dyn Potential], friction: &dyn Potential) -> Self {
        let gradient = |term: &dyn Potential| {
            let mut gradient = vec![Vec3::zeros(); x.len()];
            term.add_gradient(x, &mut gradient);
            gradient
        };
        Self { keeping: keeping.iter().map(|term| gradient(*term)).collect(), friction: gradient(friction) }
    }

    /// The mean with those of another instant.
    fn mean(&self, other: &Self) -> Self {
        let mean = |a: &[Vec3], b: &[Vec3]| a.iter().zip(b).map(|(a, b)| (a + b) * 0.5).collect();
        let keeping = self.keeping.iter().zip(&other.keeping).map(|(a, b)| mean(a, b)).collect();
        Self { keeping, friction: mean(&self.friction, &other.friction) }
    }
}

/// What a step began with, and what it did.
pub(in crate::experiment) struct EnergyOfStep<'a> {
    pub(in crate::experiment) before: &'a State,
    pub(in crate::experiment) after: &'a State,
    pub(in crate::experiment) mass: &'a Mass,
    pub(in crate::experiment) scripted: &'a [u32],
    /// Step (s).
    pub(in crate::experiment) h: f64,
    pub(in crate::experiment) scheme: TimeScheme,
}

/// What BDF2 keeps of the step before.
const EARLIER_VELOCITY: &str = "bdf2 earlier velocity";

impl EnergyOfStep<'_> {
    /// v₋₁, in steps of BDF2 but the first.
    fn earlier_velocity(&self) -> Option<&[Vec3]> {
        self.before.history(EARLIER_VELOCITY).filter(|_| self.scheme == TimeScheme::Bdf2)
    }

    /// What the equation is multiplied with.
    fn way(&self) -> Vec<Vec3> {
        let ends = self.after.position.iter().zip(&self.before.position);
        match self.scheme {
            TimeScheme::Bdf2 => self.after.velocity.iter().map(|v| v * self.h).collect(),
            _ => ends.map(|(b, a)| b - a).collect(),
        }
    }

    /// The acceleration in the equation.
    fn acceleration(&self) -> Vec<Vec3> {
        let changes = self.after.velocity.iter().zip(&self.before.velocity);
        match self.earlier_velocity() {
            Some(earlier) => changes
                .zip(earlier)
                .map(|((new, old), earlier)| (new * 3.0 - old * 4.0 + earlier) / (2.0 * self.h))
                .collect(),
            None => changes.map(|(new, old)| (new - old) / self.h).collect(),
        }
    }

    fn kinetic(&self) -> [f64; 2] {
        [self.before, self.after].map(|state| self.mass.kinetic_energy(&state.velocity))
    }

    /// T of p v₁ + q v₀ + r v₋₁.
    fn kinetic_of(&self, [p, q, r]: [f64; 3], earlier: &[Vec3]) -> f64 {
        let velocities = self.after.velocity.iter().zip(&self.before.velocity).zip(earlier);
        let combined: Vec<Vec3> = velocities.map(|((v1, v0), v)| v1 * p + v0 * q + v * r).collect();
        self.mass.kinetic_energy(&combined)
    }

    /// What the scheme takes of the kinetic energy, by the formulas of [`EnergyBalance`].
    fn taken(&self) -> f64 {
        let [before, after] = self.kinetic();
        match (self.scheme, self.earlier_velocity()) {
            (TimeScheme::Newmark, _) => 0.0,
            (_, None) => self.kinetic_of([1.0, -1.0, 0.0], &self.before.velocity),
            (_, Some(earlier)) => {
                let stored = 0.5 * (after + self.kinetic_of([2.0, -1.0, 0.0], earlier))
                    - 0.5 * (before + self.kinetic_of([0.0, 2.0, -1.0], earlier));
                stored - (after - before) + 0.5 * self.kinetic_of([1.0, -2.0, 1.0], earlier)
            }
        }
    }
}

impl EnergyBalance {
    /// Takes what acts before the first step: terms that keep energy, and friction at that instant.
    pub(in crate::experiment) fn begin(
        &mut self,
        x: &[Vec3],
        keeping: &[&dyn Potential],
        friction: &dyn Potential,
    ) {
        self.last = Some(Forces::at(x, keeping, friction));
    }

    /// Adds a step with the terms that keep energy and with friction, which reported what it did.
    pub(in crate::experiment) fn add(
        &mut self,
        step: &EnergyOfStep<'_>,
        keeping: &[&dyn Potential],
        (friction, report): (&dyn Potential, &FrictionReport),
    ) {
        let [before, after] = step.kinetic();
        if step.before.step == 0 {
            self.at_start = before;
        }
        let (x0, x1) = (&step.before.position, &step.after.position);
        let at_end = Forces::at(x1, keeping, friction);
        let of_equation = match (step.scheme, &self.last) {
            (TimeScheme::Newmark, Some(last)) => last.mean(&at_end),
            _ => at_end.clone(),
        };
        let way = step.way();
        let gained: f64 = keeping.iter().map(|term| term.value(x1) - term.value(x0)).sum();
        let keeping_work: f64 = of_equation.keeping.iter().map(|gradient| product(gradient, &way)).sum();
        self.kinetic += after - before;
        self.potential += gained;
        self.numerical += step.taken() + keeping_work - gained;
        self.heat += report.dissipated - report.driven;
        let [lost, driven] = match step.scheme {
            // The forces that do this work are not those that the report is of.
            TimeScheme::Newmark => [product(&of_equation.friction, &way), 0.0],
            _ => [report.dissipated, report.driven],
        };
        self.friction += lost;
        self.work += driven + work_on(step, &of_equation, &way);
        self.largest_potential = self.largest_potential.max(self.potential.abs());
        self.last = Some(at_end);
    }

    /// What is not accounted for, in parts of what was turned over.
    pub(in crate::experiment) fn gap(&self) -> f64 {
        let found = self.kinetic + self.potential + self.friction + self.numerical;
        let whole = self.at_start + self.largest_potential + self.friction + self.work.abs();
        if whole > 0.0 { (found - self.work).abs() / whole } else { 0.0 }
    }
}

/// The work of the forces that hold scripted points.
fn work_on(step: &EnergyOfStep<'_>, forces: &Forces, way: &[Vec3]) -> f64 {
    let momenta = step.mass.momenta(&step.acceleration());
    let force = |point: usize| {
        forces.keeping.iter().map(|gradient| gradient[point]).sum::<Vec3>()
            + forces.friction[point]
            + momenta[point]
    };
    step.scripted.iter().map(|&point| force(point as usize).dot(&way[point as usize])).sum()
}

fn product(gradient: &[Vec3], way: &[Vec3]) -> f64 {
    gradient.iter().zip(way).map(|(g, w)| g.dot(w)).sum()
}
