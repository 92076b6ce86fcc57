//! Equilibrium of bodies under forces that do not change.

use super::element::DeadForces;
use mechanics_core::linear::{Method, Solver};
use mechanics_core::newton::{NewtonError, NewtonOptions, NewtonReport, minimise};
use mechanics_core::objective::{IncrementalPotential, TimeStep};
use mechanics_core::point_map::{PointMap, PointMapError};
use mechanics_core::potential::Potential;
use mechanics_core::sparse::Assembly;
use mechanics_core::stage::Scheme;
use mechanics_core::stencil::{StencilError, StencilTerm};
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
}

/// Why there is no equilibrium.
#[derive(Debug, thiserror::Error)]
pub(crate) enum StaticsError {
    #[error(transparent)]
    Map(#[from] PointMapError),
    #[error(transparent)]
    Forces(#[from] StencilError),
    #[error(transparent)]
    Newton(#[from] Box<NewtonError>),
}

impl Statics {
    /// Moves the points from `x` into equilibrium. On error `x` is as it was.
    pub(crate) fn solve(&mut self, x: &mut [Vec3]) -> Result<NewtonReport, StaticsError> {
        let points = (0..x.len() as u32).map(|point| [point]).collect();
        let mut forces = StencilTerm::new("forces", DeadForces { forces: self.forces.clone() }, points)?;
        let map = PointMap::with_fixed(x.len(), &self.held)?;
        let mut unknowns = vec![0.0; 3 * map.unknowns()];
        map.unknowns_into(x, &mut unknowns)?;
        // Held points start where they are held.
        let mut start = x.to_vec();
        map.points_into(&unknowns, &mut start);
        let (mut assembly, mut solver) = (Assembly::new(&map), Solver::new(self.method));
        let mut terms: Vec<&mut dyn Potential> =
            self.terms.iter_mut().map(|term| term.as_mut() as _).collect();
        terms.push(&mut forces);
        let time_step = TimeStep { time: 0.0, step: 0.0, scheme: Scheme::statics(&start) };
        let mut objective =
            IncrementalPotential::new(&mut terms, &map, time_step, &mut assembly, &mut solver);
        let report = minimise(&mut objective, &mut unknowns, &self.options)?;
        map.points_into(&unknowns, x);
        Ok(report)
    }
}
