//! Rods, membranes and shells in equilibrium, against elastica, catenaries and Cook's membrane.

mod cable;
mod cantilever;
mod cook;
mod hanging;
mod twisted_rod;

pub(super) use cantilever::ElasticaCantilever;
pub(super) use cook::CooksMembrane;
pub(super) use hanging::HangingCable;
pub(super) use twisted_rod::TwistedRod;

use super::{Clock, ExperimentError, Outcome};
use lagrangian::element::{DeadLoad, Mass};
use lagrangian::stepper::{StepReport, Stepper, StepperOptions};
use mechanics_core::mesh::TriMesh;
use mechanics_core::newton::NewtonOptions;
use mechanics_core::point_map::PointMap;
use mechanics_core::potential::Potential;
use mechanics_core::projection::Projection;
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;

/// A body whose equilibrium is sought.
struct Problem {
    terms: Vec<Box<dyn Potential>>,
    /// A force on every point (N).
    forces: Vec<Vec3>,
    /// Points that stay where they start.
    held: Vec<u32>,
    /// Where the search starts (m).
    start: Vec<Vec3>,
    /// The largest last step of Newton's method (m).
    tolerance: f64,
}

/// An equilibrium, and what it took.
struct Equilibrium {
    position: Vec<Vec3>,
    iterations: u64,
    factorisations: u64,
}

impl Problem {
    /// Finds the equilibrium.
    ///
    /// Projected Hessians descend from anywhere, but converge linearly where an element's own Hessian is not definite at
    /// the minimum. So the end is made with the true ones, unless the minimum is degenerate.
    fn solve(mut self, clock: &mut Clock) -> Result<Equilibrium, ExperimentError> {
        let forces = (0..).zip(self.forces.iter().copied()).collect();
        self.terms.push(Box::new(DeadLoad::new("load", forces).map_err(ExperimentError::stopped)?));
        let mut state = State::at_rest(self.start.clone());
        clock.time(|| {
            let mut report = self.minimise(&mut state, Projection::Clamp, 1e-4, 1000)?;
            let last = self
                .minimise(&mut state, Projection::None, self.tolerance, 50)
                .or_else(|_| self.minimise(&mut state, Projection::Clamp, self.tolerance, 1000))?;
            report.newton.iterations += last.newton.iterations;
            report.newton.factorisations += last.newton.factorisations;
            Ok(Equilibrium {
                position: state.position,
                iterations: report.newton.iterations,
                factorisations: report.newton.factorisations,
            })
        })
    }

    fn minimise(
        &mut self,
        state: &mut State,
        projection: Projection,
        tolerance: f64,
        max_iterations: u32,
    ) -> Result<StepReport, ExperimentError> {
        let points = self.start.len();
        let held: Vec<(u32, Vec3)> = self.held.iter().map(|&i| (i, self.start[i as usize])).collect();
        let map = PointMap::with_fixed(points, &held).map_err(ExperimentError::stopped)?;
        let newton = NewtonOptions { tolerance, max_iterations, ..NewtonOptions::default() };
        let options = StepperOptions { newton, projection, ..StepperOptions::default() };
        let mut terms: Vec<&mut dyn Potential> =
            self.terms.iter_mut().map(|term| &mut **term as &mut dyn Potential).collect();
        Stepper::new(Mass::zeros(points), map, options)
            .equilibrium(state, &mut terms, 1)
            .map_err(ExperimentError::stopped)
    }
}

/// A load on the points of a sheet: `load` an area.
fn area_load(mesh: &TriMesh, load: &Vec3) -> Vec<Vec3> {
    let mut forces = vec![Vec3::zeros(); mesh.points().len()];
    for (triangle, area) in mesh.triangles().iter().zip(mesh.areas()) {
        triangle.iter().for_each(|&i| forces[i as usize] += load * (area / 3.0));
    }
    forces
}

/// `outcome` with the counts of several equilibria.
fn counted(outcome: Outcome, found: &[Equilibrium]) -> Outcome {
    let mut hash = mechanics_core::state::StateHash::new();
    found.iter().for_each(|one| hash.add_vectors("position", &one.position));
    outcome
        .count("points", found.iter().map(|one| one.position.len() as u64).sum())
        .count("Newton iterations", found.iter().map(|one| one.iterations).sum())
        .count("factorisations", found.iter().map(|one| one.factorisations).sum())
        .state(hash.value())
}
