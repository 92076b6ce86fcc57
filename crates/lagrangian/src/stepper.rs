//! Motion and equilibrium of bodies by minimising the incremental potential.
//!
//! One step of an implicit scheme finds the positions y that minimise ½ c ‖y − x̃‖²_M + Σ Eₖ(y): [`Inertia`] and the
//! terms given, elasticity, loads, damping, or contact from another crate. [`TimeScheme`] says what c and x̃ are and how
//! the end of the step follows from y. Newton's method of `mechanics-core` minimises; a step is accepted when
//! a ‖p‖∞ < tolerance for its last direction p, a velocity in m/s. The terms are borrowed for the step: they are anyone's.
//!
//! Scripted points, which the map fixes, are put at their targets for the step; where a term does not admit the way, they are pulled
//! there first ([`Stepper::set_target`]).
//!
//! The bits of a step depend on the state, the terms and the targets alone, not on the number of threads, nor on the steps
//! before. A step that fails leaves the state as it was.
//!
//! ```
//! use lagrangian::element::{DeadLoad, Mass, Tetrahedra, MassDistribution};
//! use lagrangian::stepper::{Stepper, StepperOptions};
//! use mechanics_core::law::{Lame, StableNeoHookean};
//! use mechanics_core::mesh::{BoxSplit, block};
//! use mechanics_core::point_map::PointMap;
//! use mechanics_core::state::State;
//! use mechanics_core::tensor::Vec3;
//!
//! let mesh = block(&Vec3::zeros(), &Vec3::new(0.1, 0.1, 0.1), [2, 2, 2], BoxSplit::Six)?;
//! let law = StableNeoHookean::new(Lame::from_young_poisson(1e5, 0.4)?);
//! let mut elastic = Tetrahedra::term("elastic", law, &mesh)?;
//! let mut mass = Mass::zeros(mesh.points().len());
//! mass.add_tetrahedra(mesh.points(), mesh.cells(), 1000.0, MassDistribution::Lumped)?;
//! let mut gravity = DeadLoad::gravity(&mass, &Vec3::new(0.0, 0.0, -9.81))?;
//!
//! let map = PointMap::identity(mesh.points().len());
//! let mut stepper = Stepper::new(mass, map, StepperOptions::default());
//! let mut state = State::at_rest(mesh.points().to_vec());
//! for _ in 0..10 {
//!     stepper.step(&mut state, &mut [&mut elastic, &mut gravity], 0.01)?;
//! }
//! // Backward Euler falls ½ g t (t + h) in the time t.
//! let fallen = mesh.points()[0].z - state.position[0].z;
//! assert!((fallen - 0.5 * 9.81 * 0.1 * 0.11).abs() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod approach;
mod equilibrium;
mod error;
mod explicit;
mod minimisation;
mod report;
mod scheme;
mod settling;

pub use error::{StateArray, StepError};
pub use explicit::{ExplicitScheme, ExplicitStepper, FrequencyBounds};
pub use report::{Minimum, StepReport, TermReport};
pub use scheme::TimeScheme;

use crate::element::{Inertia, Mass};
use mechanics_core::linear::{Method, Solver};
use mechanics_core::newton::{NewtonOptions, Proceed, Progress};
use mechanics_core::objective::{
    DirectionAccuracy, IncrementalPotential, Objective, ObjectiveError, Projecting, TimeStep,
};
use mechanics_core::point_map::{PointMap, PointMapError};
use mechanics_core::potential::{Changed, Demand, Potential, PotentialError};
use mechanics_core::projection::Projection;
use mechanics_core::sparse::Assembly;
use mechanics_core::stage::{Coefficients, Moment, Scheme, Stage};
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;
use minimisation::Minimisation;
use std::time::Instant;

/// How steps are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepperOptions {
    /// The time scheme.
    pub scheme: TimeScheme,
    /// When Newton's method stops and when it gives up. Its tolerance is a velocity [m/s], in statics a length \[m\].
    pub newton: NewtonOptions,
    /// What becomes of negative eigenvalues of element Hessians.
    pub projection: Projection,
    /// When it is done; on demand unless said.
    pub projecting: Projecting,
    /// The linear solver.
    pub method: Method,
    /// How often lagged data is refreshed within a step.
    pub lagging: Lagging,
}

impl Default for StepperOptions {
    /// Backward Euler, Newton's method as it is by default, negative eigenvalues clamped on demand, the solver that fits, lagging once.
    fn default() -> Self {
        Self {
            scheme: TimeScheme::default(),
            newton: NewtonOptions::default(),
            projection: Projection::default(),
            projecting: Projecting::OnDemand,
            method: Method::default(),
            lagging: Lagging::default(),
        }
    }
}

/// How often lagged data (friction's normal forces and sliding bases) is refreshed within a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lagging {
    /// Once, at the start of the step.
    #[default]
    Once,
    /// At the start, and again after every minimisation until no term answers that this changed its energy; at most so many
    /// times in all, then the step is taken as it is.
    ///
    /// A minimisation that makes no step is no end by itself: a term may hold data (averages over lag iterations) that are
    /// not those of the points where it stands, and only the term knows.
    AtMost(u64),
    /// The same, but not having settled after so many times is an error.
    Until(u64),
}

/// Moves a [`State`] through time; see the [module](self).
///
/// It keeps the matrix, its pattern and the order of elimination from step to step. The order is that of the elements of the
/// first step's terms (but those which demand end positions, whose elements come and go), and anew when these elements change.
#[derive(Debug)]
pub struct Stepper {
    options: StepperOptions,
    map: PointMap,
    /// Points without unknowns.
    scripted: Vec<u32>,
    inertia: Inertia,
    assembly: Assembly,
    solver: Solver,
    /// The fingerprint of the elements that stay, when the elimination was ordered.
    ordered_for: Option<u64>,
}

/// The terms of a step, inertia not among them.
type Terms<'a, 'b> = &'a mut [&'b mut dyn Potential];

impl Stepper {
    /// A stepper for points with this mass, whose unknowns are those of `map`. Points that the map fixes stay where the
    /// map has them, or follow [`set_target`](Self::set_target). Masses are checked by the first step, since statics needs none.
    ///
    /// # Panics
    /// If mass and map are not for the same number of points.
    pub fn new(mass: Mass, map: PointMap, options: StepperOptions) -> Self {
        assert_eq!(mass.points(), map.points(), "one mass per point of the map");
        let is_scripted = |point: &u32| {
            let mut unknowns = 0;
            map.for_each_unknown(*point as usize, |_, _| unknowns += 1);
            unknowns == 0
        };
        let scripted = (0..map.points() as u32).filter(is_scripted).collect();
        let assembly = Assembly::new(&map);
        let solver = Solver::new(options.method);
        Self { options, map, scripted, inertia: Inertia::new(mass), assembly, solver, ordered_for: None }
    }

    /// How steps are made.
    pub fn options(&self) -> &StepperOptions {
        &self.options
    }

    /// The mass.
    pub fn mass(&self) -> &Mass {
        self.inertia.mass()
    }

    /// The map from unknowns to points.
    pub fn map(&self) -> &PointMap {
        &self.map
    }

    /// The linear solver with its last factorisation.
    pub fn solver(&self) -> &Solver {
        &self.solver
    }

    /// Where a fixed point is to be at the end of the next step \[m\].
    ///
    /// At the start of the step it jumps there, if every term admits the straight way and has a finite energy at its end. Else it
    /// is pulled there and pushes what is in its way ([`StepReport::pulls`]); what cannot be pushed away is
    /// [`StepError::Unreached`]. Either way it ends at the target exactly, with the velocity that the scheme reads off: Newmark's average
    /// acceleration and the implicit midpoint rule have vₙ₊₁ = 2(xₙ₊₁ − xₙ)/h − vₙ, so that a script whose velocity jumps rings
    /// between ± the jump from step to step, undamped, at the point itself and in what hangs on it. Give such scripts a smooth
    /// start, or use backward Euler or BDF2.
    ///
    /// # Errors
    /// [`StepError`] if there is no such point, if it moves freely (nothing would come of its target), or if the target
    /// is not finite.
    pub fn set_target(&mut self, point: u32, target: Vec3) -> Result<(), StepError> {
        if (point as usize) < self.map.points() && self.scripted.binary_search(&point).is_err() {
            return Err(StepError::NotFixed { point });
        }
        Ok(self.map.set_offset(point as usize, target)?)
    }

    /// Moves `state` by `h` \[s\].
    ///
    /// # Errors
    /// [`StepError`] names the culprit; the state is then as it was.
    ///
    /// # Panics
    /// If the state is not for as many points as the mass.
    pub fn step(&mut self, state: &mut State, terms: Terms<'_, '_>, h: f64) -> Result<StepReport, StepError> {
        self.step_observed(state, terms, h, &mut |_| Proceed::Continue)
    }

    /// Moves `state` by `h` \[s\], asking `observer` before every Newton iteration whether to go on.
    ///
    /// # Errors
    /// [`StepError`] names the culprit; the state is then as it was.
    ///
    /// # Panics
    /// If the state is not for as many points as the mass.
    pub fn step_observed(
        &mut self,
        state: &mut State,
        terms: Terms<'_, '_>,
        h: f64,
        observer: &mut dyn FnMut(&Progress) -> Proceed,
    ) -> Result<StepReport, StepError> {
        let begin = Instant::now();
        self.check(state, terms, h)?;
        let scheme = self.options.scheme;
        let start_acceleration =
            if scheme.needs_acceleration(state) { self.acceleration(state, terms, h)? } else { Vec::new() };
        let plan = scheme.plan(state, h, &start_acceleration);
        let map = self.map_of_minimum(state)?;

        let mut report = StepReport::default();
        let mut q = vec![0.0; 3 * map.unknowns()];
        map.unknowns_into(&state.position, &mut q)?;
        let time_step = TimeStep { time: plan.time, step: h, scheme: plan.scheme() };
        let mut expected = vec![0.0; q.len()];
        map.unknowns_into(time_step.scheme.inertial_target, &mut expected)?;
        let minimisation = Minimisation { map: &map, start: &state.position, time_step, expected: &expected };
        self.minimise(terms, &minimisation, &mut q, observer, &mut report)?;

        let mut y = vec![Vec3::zeros(); map.points()];
        map.points_into(&q, &mut y);
        self.check_end(state, &y, terms, plan.time)?;
        scheme.finish(&plan, y, h, state);
        for &point in &self.scripted {
            state.position[point as usize] = self.map.offset(point as usize);
        }
        report.time = begin.elapsed();
        Ok(report)
    }

    /// Refuses what cannot be stepped.
    fn check(&self, state: &State, terms: &[&mut dyn Potential], h: f64) -> Result<(), StepError> {
        if !(h.is_finite() && h > 0.0) {
            return Err(StepError::StepSize { step: h });
        }
        self.check_state(state)?;
        self.check_mass()?;
        let barrier = terms.iter().find(|term| term.demand() == Demand::EndPositions);
        match barrier {
            Some(term) if self.options.scheme == TimeScheme::ImplicitMidpoint => {
                Err(StepError::MidpointWithBarrier { term: term.name().to_owned() })
            }
            _ => Ok(()),
        }
    }

    fn check_state(&self, state: &State) -> Result<(), StepError> {
        let points = self.map.points();
        assert_eq!(state.position.len(), points, "one position per point of the map");
        assert_eq!(state.velocity.len(), points, "one velocity per point of the map");
        if self.map.unknowns() == 0 {
            return Err(StepError::NothingToSolve { points });
        }
        let arrays = [(StateArray::Position, &state.position), (StateArray::Velocity, &state.velocity)];
        for (array, entries) in arrays {
            if let Some(point) = entries.iter().position(|v| !v.iter().all(|c| c.is_finite())) {
                return Err(StepError::NonFinite { array, point, value: entries[point].into() });
            }
        }
        Ok(())
    }

    /// Every unknown needs mass: that of the points it moves.
    fn check_mass(&self) -> Result<(), StepError> {
        let diagonal = self.mass().diagonal();
        let mut mass_of_unknown = vec![0.0; self.map.unknowns()];
        for (point, mass) in diagonal.iter().enumerate() {
            self.map.for_each_unknown(point, |unknown, w| mass_of_unknown[unknown as usize] += w * w * mass);
        }
        let is_massless = |mass: f64| mass.is_nan() || mass <= 0.0;
        if !mass_of_unknown.iter().any(|&mass| is_massless(mass)) {
            return Ok(());
        }
        let massless = |&point: &usize| {
            let mut found = false;
            self.map.for_each_unknown(point, |unknown, w| {
                found |= w != 0.0 && is_massless(mass_of_unknown[unknown as usize]);
            });
            found
        };
        let point = (0..diagonal.len()).find(massless).unwrap_or(0);
        Err(StepError::NoMass { point, mass: diagonal[point] })
    }

    /// The map to the positions that are minimised over: scripted points are where they are at that time.
    fn map_of_minimum(&self, state: &State) -> Result<PointMap, PointMapError> {
        let mut map = self.map.clone();
        if self.options.scheme == TimeScheme::ImplicitMidpoint {
            for &point in &self.scripted {
                let point = point as usize;
                let target = self.options.scheme.evaluated(&state.position[point], &self.map.offset(point));
                map.set_offset(point, target)?;
            }
        }
        Ok(map)
    }

    /// Refuses an end of the step that a term does not admit. Where the minimum is taken at the end, the line search has
    /// seen to that; the midpoint rule's end 2y − x nobody has looked at, and an element may be inside out there.
    fn check_end(
        &self,
        state: &State,
        y: &[Vec3],
        terms: &[&mut dyn Potential],
        time: f64,
    ) -> Result<(), StepError> {
        if self.options.scheme != TimeScheme::ImplicitMidpoint {
            return Ok(());
        }
        let mut end: Vec<Vec3> = y.iter().zip(&state.position).map(|(y, x)| y * 2.0 - x).collect();
        for &point in &self.scripted {
            end[point as usize] = self.map.offset(point as usize);
        }
        for term in terms {
            let value = term.value(&end);
            if !value.is_finite() {
                let culprit = term.diagnose(&end).map(Box::new);
                return Err(StepError::End { term: term.name().to_owned(), value, time, culprit });
            }
        }
        Ok(())
    }

    /// The accelerations at the start of a step, −M⁻¹ ∇E with the velocities of the state; zero at scripted points.
    fn acceleration(&mut self, state: &State, terms: Terms<'_, '_>, h: f64) -> Result<Vec<Vec3>, StepError> {
        let x = &state.position;
        let coefficients = Coefficients { inertia: 1.0, ..Coefficients::backward_euler(h) };
        // The origin from which the velocity at x is that of the state.
        let velocity_origin: Vec<Vec3> =
            x.iter().zip(&state.velocity).map(|(x, v)| x - v / coefficients.velocity).collect();
        let scheme = Scheme::new(coefficients, x, &velocity_origin);
        let time = state.time;
        let mut gradient = vec![Vec3::zeros(); x.len()];
        for term in terms.iter_mut() {
            for moment in [Moment::Step, Moment::Lag] {
                let _: Changed = term
                    .freeze(&Stage { moment, x, time, step: h, scheme })
                    .map_err(|source| StepError::Term { time, source })?;
            }
            term.add_gradient(x, &mut gradient);
        }
        let map = &self.map;
        let n = 3 * map.unknowns();
        let (mut q, mut g, mut p) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        map.unknowns_into(x, &mut q)?;
        map.gradient_into(&gradient, &mut g);
        let mut mass_alone: [&mut dyn Potential; 1] = [&mut self.inertia];
        let (mut assembly, mut solver) = (Assembly::new(map), Solver::new(self.options.method));
        let time_step = TimeStep { time, step: h, scheme };
        let mut objective =
            IncrementalPotential::new(&mut mass_alone, map, time_step, &mut assembly, &mut solver);
        let _: Changed =
            objective.freeze_at(Moment::Step, &q).map_err(|source| StepError::Term { time, source })?;
        if let Err(error) = objective.direction_into(&q, &g, DirectionAccuracy::Full, &mut p) {
            return Err(self.force_error(state, terms, &gradient, error));
        }
        let mut acceleration = vec![Vec3::zeros(); x.len()];
        map.displacements_into(&p, &mut acceleration);
        Ok(acceleration)
    }

    /// Names the point whose force has no acceleration.
    fn force_error(
        &self,
        state: &State,
        terms: &[&mut dyn Potential],
        gradient: &[Vec3],
        error: ObjectiveError,
    ) -> StepError {
        let time = state.time;
        match gradient.iter().position(|g| !g.iter().all(|c| c.is_finite())) {
            Some(point) => {
                let culprit = terms.iter().find_map(|term| term.diagnose(&state.position)).map(Box::new);
                StepError::Force { point, force: (-gradient[point]).into(), time, culprit }
            }
            None => {
                let term = "inertia".to_owned();
                StepError::Term { time, source: PotentialError::Term { term, source: Box::new(error) } }
            }
        }
    }
}
