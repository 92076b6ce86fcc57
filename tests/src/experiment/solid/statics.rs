//! Equilibrium of bodies under forces that do not change.

use lagrangian::element::{DeadLoad, ElementError};
use mechanics_core::linear::{Method, Solver};
use mechanics_core::newton::{NewtonError, NewtonOptions, NewtonReport, minimise};
use mechanics_core::objective::{IncrementalPotential, TimeStep};
use mechanics_core::point_map::{PointMap, PointMapError};
use mechanics_core::potential::Potential;
use mechanics_core::sparse::Assembly;
use mechanics_core::stage::Scheme;
use mechanics_core::tensor::Vec3;

/// What is to be in equilibrium.
pub(crate) struct Statics {
    /// The bodies' energies.
    pub(crate) terms: Vec<Box<dyn Potential>>,
    /// One force a point [N].
    pub(crate) forces: Vec<Vec3>,
    /// Points that are held, and where [m].
    pub(crate) held: Vec<(u32, Vec3)>,
    /// The linear solver.
    pub(crate) method: Method,
    /// When Newton's method stops, and when it gives up.
    pub(crate) options: NewtonOptions,
    /// What one solution leaves for the next: as long as the same points are held, the matrix keeps its pattern.
    pub(crate) kept: Option<(Assembly, Solver)>,
}

/// How far from equilibrium, and at what energy.
pub(crate) struct Balance {
    /// Of the bodies, less the work of the forces since rest [J].
    pub(crate) energy: f64,
    /// The largest force on a point that is not held [N].
    pub(crate) residual: f64,
}

/// Why there is no equilibrium.
#[derive(Debug, thiserror::Error)]
pub(crate) enum StaticsError {
    #[error(transparent)]
    Map(#[from] PointMapError),
    #[error(transparent)]
    Forces(#[from] ElementError),
    #[error(transparent)]
    Newton(#[from] Box<NewtonError>),
}

impl Statics {
    /// Moves the points from `x` into equilibrium. On error `x` is as it was.
    pub(crate) fn solve(&mut self, x: &mut [Vec3]) -> Result<NewtonReport, StaticsError> {
        let mut forces = DeadLoad::new("forces", (0..).zip(self.forces.iter().copied()).collect())?;
        let map = PointMap::with_fixed(x.len(), &self.held)?;
        let mut unknowns = vec![0.0; 3 * map.unknowns()];
        map.unknowns_into(x, &mut unknowns)?;
        // Held points start where they are held.
        let mut start = x.to_vec();
        map.points_into(&unknowns, &mut start);
        let method = self.method;
        let (assembly, solver) = self.kept.get_or_insert_with(|| (Assembly::new(&map), Solver::new(method)));
        let mut terms: Vec<&mut dyn Potential> =
            self.terms.iter_mut().map(|term| term.as_mut() as _).collect();
        terms.push(&mut forces);
        let time_step = TimeStep { time: 0.0, step: 0.0, scheme: Scheme::statics(&start) };
        let mut objective = IncrementalPotential::new(&mut terms, &map, time_step, assembly, solver);
        let report = minimise(&mut objective, &mut unknowns, &self.options)?;
        map.points_into(&unknowns, x);
        Ok(report)
    }

    /// The balance at `x`, for bodies at rest in `rest`.
    pub(crate) fn balance(&self, rest: &[Vec3], x: &[Vec3]) -> Balance {
        let elastic: f64 = self.terms.iter().map(|term| term.value(x)).sum();
        let work: f64 =
            self.forces.iter().zip(x.iter().zip(rest)).map(|(f, (x, rest))| f.dot(&(x - rest))).sum();
        let mut gradient: Vec<Vec3> = self.forces.iter().map(|force| -force).collect();
        self.terms.iter().for_each(|term| term.add_gradient(x, &mut gradient));
        for &(point, _) in &self.held {
            gradient[point as usize] = Vec3::zeros();
        }
        Balance { energy: elastic - work, residual: gradient.iter().map(Vec3::norm).fold(0.0, f64::max) }
    }
}
