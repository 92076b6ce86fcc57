//! Motion in time, step by step.

use super::conditions::{self, Conditions, Held};
use super::{Bodies, contact, refused};
use crate::experiment::ExperimentError;
use crate::experiment::contact::term::ContactTerm;
use crate::experiment::solid::linear_method;
use crate::scene::SceneFile;
use crate::scene::physics::{Integration, Solver, TimeSpan};
use ipc_contact::contact::BarrierContact;
use lagrangian::element::{DeadLoad, Mass, MassDistribution};
use lagrangian::stepper::{Lagging, StepError, StepReport, Stepper, StepperOptions, TimeScheme};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::point_map::PointMap;
use mechanics_core::potential::Potential;
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;
use std::ops::Deref;
use std::path::Path;
use std::time::{Duration, Instant};

/// A scene on its way through time.
pub(crate) struct Motion {
    bodies: Bodies,
    held: Vec<(u32, Held)>,
    elastic: Vec<Box<dyn Potential>>,
    loads: DeadLoad,
    pub(super) contact: Option<ContactTerm>,
    stepper: Stepper,
    pub(super) state: State,
    /// h [s].
    step: f64,
    steps: usize,
}

/// What a time step did, and what is at its end.
#[derive(Clone, Debug)]
pub(crate) struct TimeStep {
    /// Its number, from one.
    pub(crate) number: usize,
    /// [s]
    pub(crate) time: f64,
    /// ½ vᵀMv [J].
    pub(crate) kinetic: f64,
    /// Of the bodies [J].
    pub(crate) elastic: f64,
    /// Of the loads: less their work from the origin on [J].
    pub(crate) load: f64,
    /// Of contact's barrier [J].
    pub(crate) contact: f64,
    /// What friction took out in this step [J].
    pub(crate) dissipated: f64,
    /// [kg m/s]
    pub(crate) momentum: Vec3,
    /// About the origin [kg m²/s].
    pub(crate) angular_momentum: Vec3,
    /// Pairs in contact.
    pub(crate) contacts: usize,
    /// Between surfaces in contact [m]; infinite where there are none.
    pub(crate) smallest_distance: f64,
    /// Times that contact searched for candidates in this step.
    pub(crate) contact_searches: u64,
    /// Pairs that it asked for their impact in this step.
    pub(crate) detection_queries: u64,
    /// What the stepper did.
    pub(crate) report: StepReport,
    /// The smallest det F [1].
    pub(crate) smallest_volume_ratio: f64,
    /// [m]
    pub(crate) largest_displacement: f64,
    /// Wall time.
    pub(crate) wall: Duration,
}

impl TimeStep {
    /// The names of what [`row`](Self::row) tells.
    pub(crate) const HEAD: &str = "step,time_s,kinetic_j,elastic_j,load_j,contact_j,friction_j,momentum_x_kg_m_s,\
        momentum_y_kg_m_s,momentum_z_kg_m_s,angular_momentum_x_kg_m2_s,angular_momentum_y_kg_m2_s,\
        angular_momentum_z_kg_m2_s,contacts,smallest_distance_m,newton_iterations,halvings,factorisations,\
        linear_iterations,lag_iterations,contact_searches,detection_queries,hessian_blocks,smallest_det_f,\
        largest_displacement_m,seconds";

    /// A row of the table. `{:?}` of a number reads back to the same bits.
    pub(crate) fn row(&self) -> String {
        let Self { number, time, kinetic, elastic, load, contact, dissipated, .. } = self;
        let ([px, py, pz], [lx, ly, lz]) =
            (<[f64; 3]>::from(self.momentum), <[f64; 3]>::from(self.angular_momentum));
        let newton = &self.report.newton;
        format!(
            "{number},{time:?},{kinetic:?},{elastic:?},{load:?},{contact:?},{dissipated:?},{px:?},{py:?},{pz:?},\
             {lx:?},{ly:?},{lz:?},{},{:?},{},{},{},{},{},{},{},{},{:?},{:?},{:.6}",
            self.contacts,
            self.smallest_distance,
            newton.iterations,
            newton.halvings,
            newton.factorisations,
            newton.linear_iterations,
            self.report.lag_iterations,
            self.contact_searches,
            self.detection_queries,
            self.report.hessian_blocks,
            self.smallest_volume_ratio,
            self.largest_displacement,
            self.wall.as_secs_f64()
        )
    }
}

/// A time step that could not be made.
#[derive(Debug, thiserror::Error)]
#[error("time step {number} of {of}, to {time} s: {source}. A shorter step makes each of them easier")]
pub(crate) struct TimeStepError {
    number: usize,
    of: usize,
    time: f64,
    source: StepError,
}

impl Motion {
    /// A scene, whose file is in `folder`, at time zero.
    pub(crate) fn new(scene: &SceneFile, folder: &Path) -> Result<Self, ExperimentError> {
        let (scheme, span) = scheme(scene.integration.as_ref())?;
        let steps = whole_steps(scene.integration.as_ref(), span)?;
        let solver = scene.solver.as_ref().ok_or_else(|| refused("solver", "missing"))?;
        let bodies = Bodies::new(scene, folder)?;
        let Conditions { held, forces } = Conditions::new(scene, &bodies)?;
        let rest = bodies.mesh().points();
        let mut state = State::at_rest(conditions::start(scene, &bodies)?);
        state.velocity = conditions::start_velocity(scene, &bodies, &state.position)?;
        for &(point, held) in &held {
            state.position[point as usize] = rest[point as usize];
            state.velocity[point as usize] = held.velocity();
        }
        let fixed: Vec<(u32, Vec3)> = held.iter().map(|&(i, _)| (i, rest[i as usize])).collect();
        let map = PointMap::with_fixed(rest.len(), &fixed).map_err(ExperimentError::stopped)?;
        let contact = match &scene.contact {
            Some(given) => Some(contact::term(given, &bodies, held.iter().map(|&(point, _)| point))?),
            None => None,
        };
        let loads = DeadLoad::new("loads", (0..).zip(forces).collect()).map_err(ExperimentError::stopped)?;
        let stepper = Stepper::new(mass(&bodies)?, map, options(scene, solver, scheme, span));
        let elastic = bodies.terms()?;
        let step = span.step_s.value();
        Ok(Self { bodies, held, elastic, loads, contact, stepper, state, step, steps })
    }

    /// Makes a step. On error the state is as it was.
    pub(crate) fn advance(&mut self) -> Result<TimeStep, ExperimentError> {
        let begin = Instant::now();
        let number = self.done() + 1;
        let time = number as f64 * self.step;
        for &(point, held) in &self.held {
            let target = held.at(&self.bodies.mesh().points()[point as usize], time);
            self.stepper.set_target(point, target).map_err(ExperimentError::stopped)?;
        }
        let mut terms: Vec<&mut dyn Potential> =
            self.elastic.iter_mut().map(|term| term.as_mut() as _).collect();
        terms.push(&mut self.loads);
        if let Some(contact) = &mut self.contact {
            terms.push(contact);
        }
        let report = self.stepper.step(&mut self.state, &mut terms, self.step).map_err(|source| {
            ExperimentError::stopped(TimeStepError { number, of: self.steps, time, source })
        })?;
        self.measure(number, report, begin)
    }

    /// What is at the end of step `number`.
    fn measure(
        &self,
        number: usize,
        report: StepReport,
        begin: Instant,
    ) -> Result<TimeStep, ExperimentError> {
        let (x, v, mass) = (&self.state.position, &self.state.velocity, self.stepper.mass());
        let contact = self.contact.as_ref();
        let friction = contact.and_then(ContactTerm::friction);
        let dissipated = match friction {
            Some(friction) => friction.report(x).map_err(ExperimentError::stopped)?.dissipated,
            None => 0.0,
        };
        let barrier = contact.map(Deref::deref);
        let detected = barrier.map(BarrierContact::report).unwrap_or_default();
        let rest = self.bodies.mesh().points();
        let volume_ratios = self.bodies.cell_fields(x).volume_ratio;
        Ok(TimeStep {
            number,
            time: self.state.time,
            kinetic: mass.kinetic_energy(v),
            elastic: self.elastic.iter().map(|term| term.value(x)).sum(),
            load: self.loads.value(x),
            contact: barrier.map_or(0.0, |barrier| barrier.value(x)),
            dissipated,
            momentum: mass.linear_momentum(v),
            angular_momentum: mass.angular_momentum(x, v, &Vec3::zeros()),
            contacts: barrier.map_or(0, |barrier| barrier.contact_counts(x).total()),
            smallest_distance: barrier.and_then(|b| b.smallest_distance(x)).unwrap_or(f64::INFINITY),
            contact_searches: detected.searches,
            detection_queries: detected.detection_queries,
            report,
            smallest_volume_ratio: volume_ratios.into_iter().fold(f64::INFINITY, f64::min),
            largest_displacement: x.iter().zip(rest).map(|(x, rest)| (x - rest).norm()).fold(0.0, f64::max),
            wall: begin.elapsed(),
        })
    }

    /// Steps that were made.
    pub(crate) fn done(&self) -> usize {
        self.state.step as usize
    }

    /// Steps to the end.
    pub(crate) fn steps(&self) -> usize {
        self.steps
    }

    /// h [s].
    pub(crate) fn step(&self) -> f64 {
        self.step
    }

    /// Where the points are, and how fast they move.
    pub(crate) fn state(&self) -> &State {
        &self.state
    }

    /// The bodies.
    pub(crate) fn bodies(&self) -> &Bodies {
        &self.bodies
    }

    /// Free coordinates.
    pub(crate) fn unknowns(&self) -> usize {
        3 * self.stepper.map().unknowns()
    }
}

fn scheme(integration: Option<&Integration>) -> Result<(TimeScheme, TimeSpan), ExperimentError> {
    match integration {
        Some(Integration::BackwardEuler(span)) => Ok((TimeScheme::BackwardEuler, *span)),
        Some(Integration::Bdf2(span)) => Ok((TimeScheme::Bdf2, *span)),
        Some(Integration::Newmark(span)) => Ok((TimeScheme::Newmark, *span)),
        Some(Integration::Static { .. }) | None => {
            Err(refused("integration", "an equilibrium does not move in time"))
        }
    }
}

/// How many steps there are to the end.
fn whole_steps(integration: Option<&Integration>, span: TimeSpan) -> Result<usize, ExperimentError> {
    let (step, end) = (span.step_s.value(), span.end_s.value());
    let steps = (end / step).round();
    if steps < 1.0 || (steps * step - end).abs() > 1e-9 * end {
        let key = format!("integration.{}.end_s", integration.map_or("", Integration::name));
        return Err(refused(key, format!("{end} s is no whole number of steps of {step} s")));
    }
    Ok(steps as usize)
}

/// A point may move by the tolerance in a step, whatever its length: as a velocity it is the tolerance over the step.
fn options(scene: &SceneFile, solver: &Solver, scheme: TimeScheme, span: TimeSpan) -> StepperOptions {
    let friction = scene.contact.as_ref().and_then(|contact| contact.friction);
    StepperOptions {
        scheme,
        newton: NewtonOptions {
            tolerance: solver.tolerance_m.value() / span.step_s.value(),
            max_iterations: solver.max_iterations.value() as u32,
            ..NewtonOptions::default()
        },
        method: linear_method(solver.linear),
        lagging: friction
            .map_or(Lagging::Once, |friction| Lagging::AtMost(friction.lag_iterations.value() as u64)),
        ..StepperOptions::default()
    }
}

fn mass(bodies: &Bodies) -> Result<Mass, ExperimentError> {
    let points = bodies.mesh().points();
    let mut mass = Mass::zeros(points.len());
    for body in bodies.each() {
        let cells: Vec<[u32; 4]> =
            body.mesh.cells().iter().map(|cell| cell.map(|node| node + body.points.start as u32)).collect();
        mass.add_tetrahedra(points, &cells, body.density, MassDistribution::Lumped)
            .map_err(ExperimentError::stopped)?;
    }
    Ok(mass)
}
