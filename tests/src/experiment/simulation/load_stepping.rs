//! Equilibria under a load that grows in equal steps.

use super::conditions::{self, Conditions};
use super::{Bodies, load_steps, refused};
use crate::experiment::ExperimentError;
use crate::experiment::solid::linear_method;
use crate::experiment::solid::statics::{Statics, StaticsError};
use crate::scene::SceneFile;
use mechanics_core::newton::{NewtonOptions, NewtonReport};
use mechanics_core::tensor::Vec3;
use std::path::Path;
use std::time::{Duration, Instant};

/// A scene on its way to its full load.
pub(crate) struct LoadStepping {
    bodies: Bodies,
    /// One force a point at the full load [N].
    forces: Vec<Vec3>,
    /// Held points and their displacements at the full load [m].
    displacements: Vec<(u32, Vec3)>,
    statics: Statics,
    positions: Vec<Vec3>,
    load_steps: usize,
    done: usize,
}

/// What a load step did.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LoadStep {
    /// Its number, from one.
    pub(crate) number: usize,
    /// The part of the full load [1].
    pub(crate) load_factor: f64,
    /// Of the bodies, less the work of the loads since rest [J].
    pub(crate) energy: f64,
    /// The largest force on a free point [N].
    pub(crate) residual: f64,
    /// What Newton's method did.
    pub(crate) report: NewtonReport,
    /// The smallest det F [1].
    pub(crate) smallest_volume_ratio: f64,
    /// [m]
    pub(crate) largest_displacement: f64,
    /// Wall time.
    pub(crate) time: Duration,
}

impl LoadStep {
    /// The names of what [`row`](Self::row) tells.
    pub(crate) const HEAD: &str = "load_step,load_factor,energy_j,newton_iterations,halvings,factorisations,\
        linear_iterations,residual_n,smallest_det_f,largest_displacement_m,seconds";

    /// A row of the table. `{:?}` of a number reads back to the same bits.
    pub(crate) fn row(&self) -> String {
        let Self { number, load_factor, energy, residual, report, .. } = self;
        format!(
            "{number},{load_factor:?},{energy:?},{},{},{},{},{residual:?},{:?},{:?},{:.6}",
            report.iterations,
            report.halvings,
            report.factorisations,
            report.linear_iterations,
            self.smallest_volume_ratio,
            self.largest_displacement,
            self.time.as_secs_f64()
        )
    }
}

/// A load step without an equilibrium.
#[derive(Debug, thiserror::Error)]
#[error(
    "load step {number} of {of} (load factor {factor:.4}) found no equilibrium: {source}. More load steps make each of \
     them easier"
)]
pub(crate) struct LoadStepError {
    number: usize,
    of: usize,
    factor: f64,
    source: StaticsError,
}

impl LoadStepping {
    /// A scene, whose file is in `folder`, before its first load step.
    pub(crate) fn new(scene: &SceneFile, folder: &Path) -> Result<Self, ExperimentError> {
        let load_steps = load_steps(scene.integration.as_ref())?;
        let solver = scene.solver.as_ref().ok_or_else(|| refused("solver", "missing"))?;
        let bodies = Bodies::new(scene, folder)?;
        conditions::refuse_velocities(scene)?;
        let full = Conditions::new(scene, &bodies)?;
        let displacements = full.displacements(scene, &bodies)?;
        let statics = Statics {
            terms: bodies.terms()?,
            forces: Vec::new(),
            held: Vec::new(),
            method: linear_method(solver.linear),
            options: NewtonOptions {
                tolerance: solver.tolerance_m.value(),
                max_iterations: solver.max_iterations.value() as u32,
                ..NewtonOptions::default()
            },
            kept: None,
        };
        let positions = conditions::start(scene, &bodies)?;
        Ok(Self { bodies, forces: full.forces, displacements, statics, positions, load_steps, done: 0 })
    }

    /// Goes on from positions after `done` load steps.
    pub(crate) fn resume(&mut self, done: usize, positions: Vec<Vec3>) {
        (self.done, self.positions) = (done, positions);
    }

    /// Finds the next equilibrium, from the last one. On error the state is as it was.
    pub(crate) fn advance(&mut self) -> Result<LoadStep, ExperimentError> {
        let begin = Instant::now();
        let number = self.done + 1;
        let load_factor = number as f64 / self.load_steps as f64;
        let rest = self.bodies.mesh().points();
        self.statics.forces = self.forces.iter().map(|force| force * load_factor).collect();
        self.statics.held =
            self.displacements.iter().map(|&(i, u)| (i, rest[i as usize] + u * load_factor)).collect();
        let report = self.statics.solve(&mut self.positions).map_err(|source| {
            let (of, factor) = (self.load_steps, load_factor);
            ExperimentError::stopped(LoadStepError { number, of, factor, source })
        })?;
        self.done = number;
        let x = &self.positions;
        let balance = self.statics.balance(rest, x);
        let volume_ratios = self.bodies.cell_fields(x).volume_ratio;
        Ok(LoadStep {
            number,
            load_factor,
            energy: balance.energy,
            residual: balance.residual,
            report,
            smallest_volume_ratio: volume_ratios.into_iter().fold(f64::INFINITY, f64::min),
            largest_displacement: x.iter().zip(rest).map(|(x, rest)| (x - rest).norm()).fold(0.0, f64::max),
            time: begin.elapsed(),
        })
    }

    /// Load steps that were made.
    pub(crate) fn done(&self) -> usize {
        self.done
    }

    /// Load steps to the full load.
    pub(crate) fn load_steps(&self) -> usize {
        self.load_steps
    }

    /// Where the points are [m].
    pub(crate) fn positions(&self) -> &[Vec3] {
        &self.positions
    }

    /// The bodies.
    pub(crate) fn bodies(&self) -> &Bodies {
        &self.bodies
    }

    /// Free coordinates.
    pub(crate) fn unknowns(&self) -> usize {
        3 * (self.positions.len() - self.displacements.len())
    }
}
