//! Motion of a solid with a manufactured solution: the schemes against each other at equal error.
//!
//! Choose x(t) = X + s(t) φ(X), s = sin(2πt/T + ½), for the nodes of a mesh and give them the forces f(t) = M ẍ + ∇E(x(t)), so that
//! it solves the equations M ẍ + ∇E(x) = f of the mesh exactly. What remains is the error of the time scheme.

use super::schemes::{Mover, SCHEMES, Scheme};
use super::solid::{Shape, Solid};
use crate::experiment::solid::material::lame;
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::physics::Isotropic;
use crate::scene::quantity::{Count, Positive};
use lagrangian::element::{Mass, MassDistribution};
use lagrangian::stepper::TimeScheme;
use mechanics_core::law::NeoHookean;
use mechanics_core::mesh::{BoxSplit, block};
use mechanics_core::point_map::PointMap;
use mechanics_core::potential::{Changed, Potential, PotentialError};
use mechanics_core::projection::Projection;
use mechanics_core::sparse::Assembler;
use mechanics_core::stage::{Moment, Stage};
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::{FRAC_PI_2, PI};

/// A neo-Hookean bar of linear tetrahedra, held at x = 0, swung back and forth; the ladder is the step h (s).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ManufacturedMotion {
    /// The material's constants.
    constants: Isotropic,
    /// [kg/m³]
    density_kg_m3: Positive,
    /// Edge lengths [m].
    size_m: [Positive; 3],
    /// Cells along each edge.
    cells: [Count; 3],
    /// How far the end swings, relative to the length [1].
    amplitude: Positive,
    /// T [s].
    period_s: Positive,
    /// Time to go to [s].
    duration_s: Positive,
    /// Explicit schemes make so many steps for each of the implicit ones.
    explicit_substeps: Count,
}

impl Experiment for ManufacturedMotion {
    fn methods(&self) -> &'static [&'static str] {
        SCHEMES
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let scheme = Scheme::named(at.method)?;
        let law = NeoHookean::new(lame(&self.constants).map_err(ExperimentError::stopped)?);
        let size = Vec3::from(self.size_m.map(Positive::value));
        let cells = self.cells.map(|count| count.value() as u32);
        let mesh = block(&Vec3::zeros(), &size, cells, BoxSplit::Six).map_err(ExperimentError::stopped)?;
        let mut solid = Solid::new(law, &mesh, Shape::Linear)?;
        let mass = solid.mass(self.density_kg_m3.value(), MassDistribution::Lumped)?;
        let map = PointMap::with_fixed(solid.points.len(), &solid.held(|x| x.x == 0.0))
            .map_err(ExperimentError::stopped)?;

        let substeps = if scheme.is_explicit() { self.explicit_substeps.value() } else { 1 };
        let steps = (self.duration_s.value() / at.ladder).round() as usize * substeps;
        let h = self.duration_s.value() / steps as f64;
        let first = match scheme {
            // The first force seen is at the start; the implicit schemes that see another one begin with that.
            Scheme::Explicit(_) | Scheme::Implicit(TimeScheme::Newmark) => 0.0,
            Scheme::Implicit(TimeScheme::ImplicitMidpoint) => 0.5 * h,
            Scheme::Implicit(_) => h,
        };
        let mut load = self.forces(&solid, &mass, first, h, steps + 1);
        let mut mover = Mover::new(scheme, mass, map, 1e-9)?;
        let [start, speed, _] = self.swing(0.0);
        let mut state = State::at_rest(solid.points.iter().map(|x| x + self.shape(x) * start).collect());
        state.velocity = solid.points.iter().map(|x| self.shape(x) * speed).collect();
        clock.time(|| {
            (0..steps).try_for_each(|_| mover.step(&mut state, &mut [solid.elastic.as_mut(), &mut load], h))
        })?;

        let end = self.swing(self.duration_s.value())[0];
        let exact = solid.points.iter().map(|x| x + self.shape(x) * end);
        let error = state.position.iter().zip(exact).map(|(x, exact)| (x - exact).norm()).fold(0.0, f64::max);
        let swing = solid.points.iter().map(|x| self.shape(x).norm()).fold(0.0, f64::max);
        let outcome = Outcome::default()
            .error("position", error / swing)
            .count("unknowns", 3 * (solid.points.len() - solid.held(|x| x.x == 0.0).len()) as u64)
            .invariant("smallest volume ratio", solid.smallest_volume_ratio(&state.position));
        Ok(mover.counted(outcome, &state, clock))
    }
}

impl ManufacturedMotion {
    /// φ [m]: bent to both sides and stretched, nothing at x = 0.
    fn shape(&self, x: &Vec3) -> Vec3 {
        let length = self.size_m[0].value();
        let s = x.x / length;
        let twist = s * s;
        Vec3::new(
            0.2 * length * (FRAC_PI_2 * s).sin() - 0.3 * s * x.z,
            0.5 * length * s * s - twist * x.z,
            length * (1.0 - (FRAC_PI_2 * s).cos()) + twist * x.y,
        ) * self.amplitude.value()
    }

    /// s, ds/dt, d²s/dt²; the phase keeps the start clear of zeros of s and of its derivatives, where errors cancel.
    fn swing(&self, t: f64) -> [f64; 3] {
        let omega = 2.0 * PI / self.period_s.value();
        let (sin, cos) = (omega * t + 0.5).sin_cos();
        [sin, omega * cos, -omega * omega * sin]
    }

    fn forces(&self, solid: &Solid, mass: &Mass, first: f64, h: f64, count: usize) -> TimedForces {
        let shape: Vec<Vec3> = solid.points.iter().map(|x| self.shape(x)).collect();
        let at = |k: usize| {
            let [s, _, acceleration] = self.swing(first + h * k as f64);
            let x: Vec<Vec3> = solid.points.iter().zip(&shape).map(|(x, shape)| x + shape * s).collect();
            let mut forces = vec![Vec3::zeros(); x.len()];
            solid.elastic.add_gradient(&x, &mut forces);
            mass.add_product(acceleration, &shape, &mut forces);
            forces
        };
        TimedForces { first, h, forces: (0..count).map(at).collect(), now: 0 }
    }
}

/// Forces on all points at times a step apart, known beforehand, so that their making is not timed.
struct TimedForces {
    first: f64,
    h: f64,
    forces: Vec<Vec<Vec3>>,
    now: usize,
}

impl Potential for TimedForces {
    fn name(&self) -> &str {
        "manufactured forces"
    }

    fn value(&self, x: &[Vec3]) -> f64 {
        -self.forces[self.now].iter().zip(x).map(|(force, x)| force.dot(x)).sum::<f64>()
    }

    fn add_gradient(&self, _: &[Vec3], gradient: &mut [Vec3]) {
        gradient.iter_mut().zip(&self.forces[self.now]).for_each(|(gradient, force)| *gradient -= force);
    }

    fn add_hessian(&self, _: &[Vec3], _: Projection, _: &mut Assembler<'_>) {}

    fn freeze(&mut self, stage: &Stage<'_>) -> Result<Changed, PotentialError> {
        if stage.moment != Moment::Step {
            return Ok(Changed::Nothing);
        }
        let number = ((stage.time - self.first) / self.h).round().max(0.0) as usize;
        self.now = number.min(self.forces.len() - 1);
        Ok(Changed::Energy)
    }
}
