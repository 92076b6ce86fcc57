//! Bodies that collide: what scenes of contact are made of, and what is checked after every step.

use super::energy::{EnergyBalance, EnergyOfStep};
use super::slip::SlipAudit;
use super::term::ContactTerm;
use super::watch::{Unlimited, Watch};
use crate::experiment::{Clock, ExperimentError, Outcome};
use ipc_contact::collision_mesh::{CollisionMeshBuilder, CollisionObject, HalfSpace};
use ipc_contact::contact::{BarrierContact, ContactOptions};
use ipc_contact::intersection;
use ipc_friction::{FrictionOptions, FrictionReport};
use lagrangian::element::hinge::{Hinges, RestAngle, flexural_rigidity};
use lagrangian::element::membrane::{Membranes, NeoHookeanSheet};
use lagrangian::element::{DeadLoad, Mass, MassDistribution, Tetrahedra};
use lagrangian::stepper::{StepReport, Stepper, StepperOptions, TimeScheme};
use mechanics_core::law::{Hyperelastic, Lame, NeoHookean, StableNeoHookean};
use mechanics_core::mesh::{TetMesh, TriMesh};
use mechanics_core::point_map::{PointMap, PointMapError, PointSource};
use mechanics_core::potential::Potential;
use mechanics_core::state::State;
use mechanics_core::stencil::StencilTerm;
use mechanics_core::tensor::{Mat3, Vec3};
use std::ops::Range;

/// An elastic material.
#[derive(Clone, Copy, Debug)]
pub(in crate::experiment) struct Material {
    /// Young's modulus (Pa).
    pub(in crate::experiment) young: f64,
    /// Poisson's ratio.
    pub(in crate::experiment) poisson: f64,
    /// Density (kg/m³).
    pub(in crate::experiment) density: f64,
}

/// What solids are made of.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::experiment) enum SolidLaw {
    /// Stable neo-Hookean: tetrahedra may turn inside out.
    #[default]
    Stable,
    /// Neo-Hookean with a logarithm: they may not.
    Barrier,
}

/// Whether contact limits the steps of the minimiser.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::experiment) enum Limits {
    /// As it should.
    #[default]
    Kept,
    /// Its limit is asked for and ignored: what the check of the checks does.
    Ignored,
}

/// Collects bodies and obstacles; their points are numbered in the order they come.
#[derive(Default)]
pub(in crate::experiment) struct WorldBuilder {
    law: SolidLaw,
    rest: Vec<Vec3>,
    velocity: Vec<Vec3>,
    solids: Vec<(Vec<[u32; 4]>, f64)>,
    point_masses: Vec<(u32, f64)>,
    terms: Vec<Box<dyn Potential>>,
    objects: Vec<CollisionObject>,
    half_spaces: Vec<HalfSpace>,
    scripted: Vec<u32>,
    friction: Option<FrictionOptions>,
    /// Points of affine bodies, with their weights on the four points of the body's frame.
    embedded: Vec<(u32, [(u32, f64); 4])>,
}

impl WorldBuilder {
    /// A builder whose solids are made of `law`.
    pub(in crate::experiment) fn of_law(law: SolidLaw) -> Self {
        Self { law, ..Self::default() }
    }

    /// The same with friction. Without, nothing of `ipc-friction` runs.
    ///
    /// How often normal forces are taken anew within a step is the `lagging` of the stepper's options; how well they must agree
    /// is the `lag_tolerance` of these.
    pub(in crate::experiment) fn with_friction(self, friction: FrictionOptions) -> Self {
        Self { friction: Some(friction), ..self }
    }

    fn add_points(&mut self, points: &[Vec3], velocity: Vec3) -> Range<u32> {
        let first = self.rest.len() as u32;
        self.rest.extend_from_slice(points);
        self.velocity.resize(self.rest.len(), velocity);
        first..self.rest.len() as u32
    }

    /// Adds a neo-Hookean solid, at rest in its mesh; answers its points.
    pub(in crate::experiment) fn add_solid(
        &mut self,
        mesh: &TetMesh,
        material: Material,
        velocity: Vec3,
    ) -> Result<Range<u32>, ExperimentError> {
        let object = CollisionObject::of_tets(mesh, self.rest.len() as u32);
        self.add_solid_that_touches(mesh, material, velocity, object.map_err(ExperimentError::stopped)?)
    }

    /// The same with its own choice of what of it may touch, in the numbers of all points.
    pub(in crate::experiment) fn add_solid_that_touches(
        &mut self,
        mesh: &TetMesh,
        material: Material,
        velocity: Vec3,
        object: CollisionObject,
    ) -> Result<Range<u32>, ExperimentError> {
        let points = self.add_points(mesh.points(), velocity);
        let cells: Vec<[u32; 4]> = mesh.cells().iter().map(|c| c.map(|p| p + points.start)).collect();
        let lame =
            Lame::from_young_poisson(material.young, material.poisson).map_err(ExperimentError::stopped)?;
        let name = format!("solid {}", self.solids.len());
        let term = match self.law {
            SolidLaw::Stable => elastic(name, StableNeoHookean::new(lame), &self.rest, &cells)?,
            SolidLaw::Barrier => elastic(name, NeoHookean::new(lame), &self.rest, &cells)?,
        };
        self.terms.push(term);
        self.solids.push((cells, material.density));
        self.objects.push(object);
        Ok(points)
    }

    /// Adds a body that deforms by affine maps only, of which Young's modulus (Pa) makes all but rotations small: four unknowns
    /// move all its points, which have these masses (kg) and velocities (m/s). Answers its points; those of its frame come after them.
    pub(in crate::experiment) fn add_affine_body(
        &mut self,
        points: &[Vec3],
        masses: &[f64],
        young: f64,
        velocity: impl Fn(&Vec3) -> Vec3,
        object: impl FnOnce(u32) -> CollisionObject,
    ) -> Result<Range<u32>, ExperimentError> {
        let origin = points.iter().sum::<Vec3>() / points.len() as f64;
        let size = points.iter().map(|x| (x - origin).norm()).fold(0.0, f64::max);
        let frame = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()].map(|axis| origin + axis * size);
        let body = self.add_points(points, Vec3::zeros());
        let corners = self.add_points(&frame, Vec3::zeros()).start;
        for (i, x) in (body.start..).zip(points.iter().chain(&frame)) {
            self.velocity[i as usize] = velocity(x);
        }
        self.point_masses.extend(body.clone().zip(masses.iter().copied()));
        self.embedded.extend(body.clone().zip(points).map(|(point, x)| {
            let [a, b, c]: [f64; 3] = ((x - origin) / size).into();
            (point, [(corners, 1.0 - a - b - c), (corners + 1, a), (corners + 2, b), (corners + 3, c)])
        }));
        let lame = Lame::from_young_poisson(young, 0.0).map_err(ExperimentError::stopped)?;
        let cells = [[0, 1, 2, 3].map(|k| corners + k)];
        let name = format!("affine body {}", self.objects.len());
        self.terms.push(elastic(name, StableNeoHookean::new(lame), &self.rest, &cells)?);
        self.objects.push(object(body.start));
        Ok(body)
    }

    /// From unknowns to points: free ones, scripted ones, and those of affine bodies.
    fn point_map(&self) -> Result<PointMap, PointMapError> {
        let fixed: Vec<(u32, Vec3)> = self.scripted.iter().map(|&p| (p, self.rest[p as usize])).collect();
        if self.embedded.is_empty() {
            return PointMap::with_fixed(self.rest.len(), &fixed);
        }
        const FREE: u32 = 0;
        const BOUND: u32 = u32::MAX;
        let mut unknown_of = vec![FREE; self.rest.len()];
        let bound = self.scripted.iter().copied().chain(self.embedded.iter().map(|(point, _)| *point));
        bound.for_each(|point| unknown_of[point as usize] = BOUND);
        let mut unknowns = 0;
        for unknown in unknown_of.iter_mut().filter(|unknown| **unknown == FREE) {
            *unknown = unknowns;
            unknowns += 1;
        }
        let mut weights = vec![Vec::new(); self.rest.len()];
        for (point, frame) in &self.embedded {
            let nonzero = frame.iter().filter(|(_, weight)| *weight != 0.0);
            weights[*point as usize] =
                nonzero.map(|(corner, w)| (unknown_of[*corner as usize], *w)).collect();
        }
        let source = |(unknown, weights)| match (unknown, weights) {
            (&BOUND, weights) if Vec::is_empty(weights) => PointSource::Fixed,
            (&BOUND, weights) => PointSource::Weighted(weights),
            (&unknown, _) => PointSource::Unknown(unknown),
        };
        let mut map = PointMap::new(unknowns as usize, unknown_of.iter().zip(&weights).map(source))?;
        fixed.iter().try_for_each(|(point, x)| map.set_offset(*point as usize, *x))?;
        Ok(map)
    }

    /// Adds a cloth of neo-Hookean sheet with hinges, flat in its mesh; answers its points.
    pub(in crate::experiment) fn add_cloth(
        &mut self,
        mesh: &TriMesh,
        thickness: f64,
        material: Material,
        velocity: Vec3,
    ) -> Result<Range<u32>, ExperimentError> {
        let Material { young, poisson, density } = material;
        let points = self.add_points(mesh.points(), velocity);
        let triangles: Vec<[u32; 3]> = mesh.triangles().iter().map(|t| t.map(|p| p + points.start)).collect();
        for (triangle, area) in triangles.iter().zip(mesh.areas()) {
            self.point_masses.extend(triangle.map(|p| (p, density * thickness * area / 3.0)));
        }
        let whole = TriMesh::new(self.rest.clone(), triangles.clone()).map_err(ExperimentError::stopped)?;
        let law = NeoHookeanSheet::new(young, poisson).map_err(ExperimentError::stopped)?;
        let number = self.objects.len();
        let membrane = Membranes::term(format!("membrane {number}"), &whole, law, thickness)
            .map_err(ExperimentError::stopped)?;
        let rigidity = flexural_rigidity(young, poisson, thickness).map_err(ExperimentError::stopped)?;
        let bending = Hinges::new(&whole, rigidity, RestAngle::Flat)
            .and_then(|hinges| hinges.term(format!("bending {number}")))
            .map_err(ExperimentError::stopped)?;
        self.terms.push(Box::new(membrane));
        self.terms.push(Box::new(bending));
        self.objects.push(CollisionObject::new(triangles));
        Ok(points)
    }

    /// Adds points with mass and without elasticity of their own: for ropes and nets, whose springs
    /// [`add_term`](Self::add_term) adds.
    pub(in crate::experiment) fn add_masses(
        &mut self,
        points: &[Vec3],
        mass: f64,
        velocity: Vec3,
        object: impl FnOnce(u32) -> CollisionObject,
    ) -> Range<u32> {
        let points = self.add_points(points, velocity);
        self.point_masses.extend(points.clone().map(|p| (p, mass)));
        self.objects.push(object(points.start));
        points
    }

    /// Adds an obstacle whose points are scripted: they stay where they are, or follow [`World::move_to`].
    pub(in crate::experiment) fn add_obstacle(
        &mut self,
        points: &[Vec3],
        object: impl FnOnce(u32) -> CollisionObject,
    ) -> Range<u32> {
        let points = self.add_points(points, Vec3::zeros());
        self.objects.push(object(points.start));
        self.scripted.extend(points.clone());
        points
    }

    /// Adds a fixed half-space.
    pub(in crate::experiment) fn add_half_space(&mut self, half_space: HalfSpace) {
        self.half_spaces.push(half_space);
    }

    /// Adds an energy.
    pub(in crate::experiment) fn add_term(&mut self, term: impl Potential + 'static) {
        self.terms.push(Box::new(term));
    }

    /// Holds points; [`World::move_to`] may move them.
    pub(in crate::experiment) fn script(&mut self, points: impl IntoIterator<Item = u32>) {
        self.scripted.extend(points);
    }

    /// Where all points are.
    pub(in crate::experiment) fn rest(&self) -> &[Vec3] {
        &self.rest
    }

    /// The world, in a field of gravity (m/s²).
    pub(in crate::experiment) fn build(
        mut self,
        gravity: Vec3,
        contact: ContactOptions,
        stepper: StepperOptions,
    ) -> Result<World, ExperimentError> {
        let mut mass = Mass::zeros(self.rest.len());
        for (cells, density) in &self.solids {
            mass.add_tetrahedra(&self.rest, cells, *density, MassDistribution::Lumped)
                .map_err(ExperimentError::stopped)?;
        }
        for &(point, m) in &self.point_masses {
            mass.add_point(point, m).map_err(ExperimentError::stopped)?;
        }
        if gravity != Vec3::zeros() {
            let load = DeadLoad::gravity(&mass, &gravity).map_err(ExperimentError::stopped)?;
            self.terms.push(Box::new(load));
        }
        let map = self.point_map().map_err(ExperimentError::stopped)?;
        let mut builder = CollisionMeshBuilder::new(&self.rest);
        for object in self.objects {
            builder.add_object(object);
        }
        for half_space in self.half_spaces {
            builder.add_half_space(half_space);
        }
        builder.script_points(self.scripted.iter().copied());
        let mesh = builder.build().map_err(ExperimentError::stopped)?;
        let cells = self.solids.into_iter().flat_map(|(cells, _)| cells).collect();
        let mut state = State::at_rest(self.rest.clone());
        state.velocity = self.velocity;
        let contact = BarrierContact::new(mesh, contact).map_err(ExperimentError::stopped)?;
        Ok(World {
            stiffness_at_start: contact.stiffness(),
            contact: ContactTerm::new(contact, self.friction)?,
            friction_report: None,
            energy: EnergyBalance::default(),
            slip: SlipAudit::default(),
            scripted: self.scripted,
            stepper: Stepper::new(mass, map, stepper),
            state,
            terms: self.terms,
            limits: Limits::Kept,
            watches: Vec::new(),
            audit: Audit::new(&self.rest, cells),
        })
    }
}

fn elastic<L: Hyperelastic + 'static>(
    name: String,
    law: L,
    rest: &[Vec3],
    cells: &[[u32; 4]],
) -> Result<Box<dyn Potential>, ExperimentError> {
    let stencil = Tetrahedra::new(law, rest, cells).map_err(ExperimentError::stopped)?;
    let term = StencilTerm::new(name, stencil, cells.to_vec()).map_err(ExperimentError::stopped)?;
    Ok(Box::new(term))
}

/// What no step may end with.
#[derive(Debug, thiserror::Error)]
enum Broken {
    #[error("at {time} s the energy is {energy} J without contact and {contact} J of contact")]
    Energy { time: f64, energy: f64, contact: f64 },
}

/// Bodies that collide, and their state.
pub(in crate::experiment) struct World {
    /// With friction or without; what can be read of `BarrierContact` can be read of it.
    pub(in crate::experiment) contact: ContactTerm,
    pub(in crate::experiment) stepper: Stepper,
    pub(in crate::experiment) state: State,
    /// Whether contact limits steps.
    pub(in crate::experiment) limits: Limits,
    /// What must hold of who is on which side of what, after every step.
    pub(in crate::experiment) watches: Vec<Watch>,
    /// What friction did in the last step.
    pub(in crate::experiment) friction_report: Option<FrictionReport>,
    /// Where energy went, of worlds with friction.
    pub(in crate::experiment) energy: EnergyBalance,
    slip: SlipAudit,
    scripted: Vec<u32>,
    terms: Vec<Box<dyn Potential>>,
    stiffness_at_start: f64,
    audit: Audit,
}

impl World {
    /// Where a scripted point is to be at the end of the next step.
    pub(in crate::experiment) fn move_to(&mut self, point: u32, target: Vec3) -> Result<(), ExperimentError> {
        self.stepper.set_target(point, target).map_err(ExperimentError::stopped)
    }

    /// Makes a step of `h` (s) and checks it: no two features may intersect, by exact predicates; no tetrahedron may be
    /// inside out; the watches hold; positions and energies are finite.
    pub(in crate::experiment) fn step(
        &mut self,
        h: f64,
        clock: &mut Clock,
    ) -> Result<StepReport, ExperimentError> {
        let before = self.contact.friction().map(|_| self.state.clone());
        self.begin_balance()?;
        let Self { contact, stepper, state, terms, audit, limits, watches, .. } = self;
        let mut unlimited;
        let mut all: Vec<&mut dyn Potential> =
            terms.iter_mut().map(|term| &mut **term as &mut dyn Potential).collect();
        match limits {
            Limits::Kept => all.push(contact),
            Limits::Ignored => {
                unlimited = Unlimited(contact);
                all.push(&mut unlimited);
            }
        }
        let report = clock.time(|| stepper.step(state, &mut all, h)).map_err(ExperimentError::stopped)?;
        audit.add(contact, &state.position, &report)?;
        for watch in watches {
            let found = watch.check(&state.position)?;
            audit.note_sides(found.checks, found.failures);
        }
        if let Some(before) = before {
            self.note_friction(&before, h)?;
        }
        let (energy, contact) = self.potential_energy();
        if !(energy + contact).is_finite() {
            return Err(ExperimentError::stopped(Broken::Energy { time: self.state.time, energy, contact }));
        }
        Ok(report)
    }

    /// The terms that keep energy.
    fn keeping(&self) -> Vec<&dyn Potential> {
        let contact: &BarrierContact = &self.contact;
        self.terms.iter().map(|term| &**term as &dyn Potential).chain([contact as &dyn Potential]).collect()
    }

    /// Before the first step: average acceleration begins with what acts then.
    fn begin_balance(&mut self) -> Result<(), ExperimentError> {
        let is_first = self.state.step == 0 && self.stepper.options().scheme == TimeScheme::Newmark;
        let Some(friction) = self.contact.friction().filter(|_| is_first) else { return Ok(()) };
        let State { position, velocity, .. } = &self.state;
        let acting = friction.at_instant(position, velocity).map_err(ExperimentError::stopped)?;
        let mut energy = std::mem::take(&mut self.energy);
        energy.begin(position, &self.keeping(), &acting);
        self.energy = energy;
        Ok(())
    }

    /// Adds what friction did in the step from `before`, and where the energy went.
    fn note_friction(&mut self, before: &State, h: f64) -> Result<(), ExperimentError> {
        let ContactTerm::WithFriction(friction) = &self.contact else { return Ok(()) };
        let report = self.slip.add(friction, &self.state.position)?;
        self.friction_report = Some(report);
        let (mass, scripted) = (self.stepper.mass(), &self.scripted[..]);
        let scheme = self.stepper.options().scheme;
        let step = EnergyOfStep { before, after: &self.state, mass, scripted, h, scheme };
        let mut energy = std::mem::take(&mut self.energy);
        energy.add(&step, &self.keeping(), (friction.friction(), &report));
        self.energy = energy;
        Ok(())
    }

    /// Adds topological checks that the scene made itself.
    pub(in crate::experiment) fn note_sides(&mut self, checks: u64, failures: u64) {
        self.audit.note_sides(checks, failures);
    }

    /// How many checks of either kind have failed so far: by intersections, and by sides.
    pub(in crate::experiment) fn failures(&self) -> [u64; 2] {
        [self.audit.intersections, self.audit.wrong_sides]
    }

    /// Finds the equilibrium with scripted points at their targets, in `load_steps`, and checks it as a step is checked.
    pub(in crate::experiment) fn equilibrium(
        &mut self,
        load_steps: u32,
        clock: &mut Clock,
    ) -> Result<StepReport, ExperimentError> {
        let Self { contact, stepper, state, terms, audit, slip, .. } = self;
        let mut all: Vec<&mut dyn Potential> =
            terms.iter_mut().map(|term| &mut **term as &mut dyn Potential).collect();
        all.push(contact);
        let report = clock
            .time(|| stepper.equilibrium(state, &mut all, load_steps))
            .map_err(ExperimentError::stopped)?;
        audit.add(contact, &state.position, &report)?;
        if let Some(friction) = contact.friction() {
            self.friction_report = Some(slip.add(friction, &state.position)?);
        }
        Ok(report)
    }

    /// The energy of all terms but contact, and that of contact without friction (J).
    pub(in crate::experiment) fn potential_energy(&self) -> (f64, f64) {
        let x = &self.state.position;
        let contact: &BarrierContact = &self.contact;
        (self.terms.iter().map(|term| term.value(x)).sum(), contact.value(x))
    }

    /// What was counted and found so far.
    pub(in crate::experiment) fn outcome(&self) -> Outcome {
        let growth = self.contact.stiffness() / self.stiffness_at_start;
        let outcome = self.audit.outcome(&self.state).invariant("κ over that at the start", growth);
        if self.contact.friction().is_none() {
            return outcome;
        }
        let outcome = self.slip.reported(outcome).invariant("energy not accounted for", self.energy.gap());
        match self.stepper.options().scheme {
            TimeScheme::Newmark if self.energy.friction != 0.0 => outcome
                .invariant("heat reported over work of friction", self.energy.heat / self.energy.friction),
            _ => outcome,
        }
    }
}

/// What was seen after each step.
struct Audit {
    cells: Vec<[u32; 4]>,
    /// Of the rest edges of each cell.
    inverse: Vec<Mat3>,
    steps: u64,
    checks: u64,
    intersections: u64,
    iterations: u64,
    most_iterations: u64,
    halvings: u64,
    limited: u64,
    topological_checks: u64,
    /// Topological checks that failed.
    wrong_sides: u64,
    contacts: u64,
    smallest_distance: f64,
    /// Of contact on one point (N).
    largest_force: f64,
    smallest_determinant: f64,
}

impl Audit {
    fn new(rest: &[Vec3], cells: Vec<[u32; 4]>) -> Self {
        let inverse = cells.iter().map(|c| edges(c, rest).try_inverse().unwrap_or_default()).collect();
        Self {
            cells,
            inverse,
            steps: 0,
            checks: 0,
            intersections: 0,
            iterations: 0,
            most_iterations: 0,
            halvings: 0,
            limited: 0,
            topological_checks: 0,
            wrong_sides: 0,
            contacts: 0,
            smallest_distance: f64::INFINITY,
            largest_force: 0.0,
            smallest_determinant: f64::INFINITY,
        }
    }

    fn add(
        &mut self,
        contact: &BarrierContact,
        x: &[Vec3],
        report: &StepReport,
    ) -> Result<(), ExperimentError> {
        self.steps += 1;
        self.iterations += report.newton.iterations;
        self.most_iterations = self.most_iterations.max(report.newton.iterations);
        self.halvings += report.newton.halvings;
        self.limited += report.newton.limited_steps;
        self.contacts = self.contacts.max(contact.contact_counts(x).total() as u64);
        if let Some(distance) = contact.smallest_distance(x) {
            self.smallest_distance = self.smallest_distance.min(distance);
            let forces = contact.forces(x).into_iter().map(|force| force.norm());
            self.largest_force = forces.fold(self.largest_force, f64::max);
        }
        let found = intersection::check(contact.mesh(), x).map_err(ExperimentError::stopped)?;
        self.checks += 1;
        self.intersections += found.len() as u64;
        let determinants =
            self.cells.iter().zip(&self.inverse).map(|(c, inverse)| (edges(c, x) * inverse).determinant());
        self.smallest_determinant = determinants.fold(self.smallest_determinant, f64::min);
        Ok(())
    }

    fn note_sides(&mut self, checks: u64, failures: u64) {
        self.topological_checks += checks;
        self.wrong_sides += failures;
    }

    fn outcome(&self, state: &State) -> Outcome {
        let mut outcome = Outcome::default()
            .count("steps", self.steps)
            .count("exact checks", self.checks)
            .count("Newton iterations", self.iterations)
            .count("halvings", self.halvings)
            .count("limited steps", self.limited)
            .count("most contacts", self.contacts)
            .count("topological checks", self.topological_checks)
            .invariant("wrong sides", self.wrong_sides as f64)
            .invariant("intersections", self.intersections as f64)
            .invariant("most iterations in a step", self.most_iterations as f64)
            .state(state.hash());
        if !self.cells.is_empty() {
            outcome = outcome.invariant("smallest det F", self.smallest_determinant);
        }
        if self.smallest_distance.is_finite() {
            outcome = outcome
                .invariant("smallest distance (m)", self.smallest_distance)
                .invariant("largest force of contact on a point (N)", self.largest_force);
        }
        outcome.simulated_seconds = Some(state.time);
        outcome
    }
}

fn edges(cell: &[u32; 4], x: &[Vec3]) -> Mat3 {
    let [a, b, c, d] = cell.map(|p| x[p as usize]);
    Mat3::from_columns(&[b - a, c - a, d - a])
}
