//! Contact and friction as one term of the incremental potential.
//!
//! # What is lagged, and when it has settled
//! At [`Moment::Step`] and at [`Moment::Lag`] the normal forces of contact at the stage's positions are taken, with their weights
//! and normals, and held constant while positions are sought. What a minimisation finds is then consistent only with the normal forces
//! it began with. The *lag residual* at x is the largest difference, over the points, between the friction force at x that was
//! used and the one with normal forces taken anew at x; relative to the larger of the two's largest bound Σ |wᵢ| μ_s |λ| on a
//! point.
//!
//! At a later [`Moment::Lag`] of the same step a relative residual within [`FrictionOptions::lag_tolerance`] ends lagging: nothing
//! changes then, and the caller is told so. So with a stepper that repeats until nothing changes (`Lagging::Until` of
//! `lagrangian`, an error if too often; `AtMost`, which takes what it has), the forces of a step are consistent to the
//! tolerance. With a single pass they are those of the step's start. What it came to is in [`ContactWithFriction::report`].
//!
//! # Averages
//! Taken anew as they are, normal forces may come in a cycle: where features meet exactly, they jump from pair to pair and back as
//! friction moves the closest points by less than d̂. So from the 24th pass of a step on, the next friction is of (1 − s) times the normal
//! forces held and s times those taken anew, pair by pair; a pair that one of them has not counts as λ = 0. The share s is Aitken's, by how the difference of
//! the two lists changed in the pass before, between 1/64 and 1. Whether it *has* settled is asked of the forces
//! taken anew as they are, never of averages, and also where no point moves any more: averages then still approach what is
//! taken anew there.
//!
//! # Solved as it is
//! A cycle, or a jump between two minima of the lagged energies, has no end by averages, though the step may have a solution: positions where
//! forces balance with friction of the normal forces *there*. They need not be a minimum of the lagged energy. So after 24 passes, 48, 96, …
//! `lagrangian`'s stepper also tries to solve ∇E(x) − β(x; λ(x), w(x), n(x)) = 0 as it is, by Newton's method with its own Jacobian
//! ([`Potential::add_settled_gradient`] is the left side), and where that fails from a law that is smoothed below a larger velocity and becomes this one
//! in stages ([`Potential::soften`]). Normal forces are taken as they are there ([`Moment::Settling`]), and the next minimisation and the
//! question for the residual confirm it. `docs/theory/ipc-friction.md` follows two such steps. What does not settle even so stays as it is, with
//! its residual said.
//!
//! # Hard steps
//! The first eight Newton iterations of a minimisation use the true Hessian of friction, which is all that most need. After
//! that, in every other iteration, the curvature along the slip has a [floor](crate::pair) of a tenth of that across. Without it, steps of
//! many pairs that are about to stick at a tiny εᵥ may not converge: Newton's method jumps over the kink at rest. With it in every iteration
//! they converge only linearly, and the slower the nearer a slip is to εᵥ and the longer the step, so that many took more than a
//! hundred iterations. In turns, the one finds what sticks, and the other ends quadratically. Values and gradients, and so the minimum,
//! know nothing of it.
//!
//! | Newton iterations (steps) | never | always | in turns |
//! |---|---|---|---|
//! | two cubes collide, 36 cases: μ of 0.5 and 2, εᵥ 1e-2 to 1e-6 m/s, h 1 to 100 ms, tolerance 1e-6 m/s | 5 cases fail | 3327 | 3362 |
//! | two cubes rub, μ = 1.5, εᵥ = 1e-5 m/s, h = 4 ms, tolerance 1e-9 m/s (8 steps) | | 468 | 296 |
//! | the same, h = 1 ms (30 steps) | | fails | 738 |
//! | elastic block that creeps on a slope, εᵥ = 1e-4 m/s, h = 50 ms (600 steps) | | 581 | 486 |
//! | the same, εᵥ = 1e-5 m/s | | fails | 901 |

use crate::FrictionError;
use crate::blend::{Pressing, blend, difference, relaxed};
use crate::coefficients::CoefficientTable;
use crate::lagged::{LaggedFriction, PairFriction};
use crate::law::{FrictionCoefficient, SmoothedCoulomb};
use crate::surface_motion::SurfaceMotion;
use ipc_contact::collision_mesh::CollisionMesh;
use ipc_contact::contact::BarrierContact;
use ipc_contact::normal_force::NormalForce;
use mechanics_core::potential::{Changed, Demand, Potential, PotentialError, StepLimit};
use mechanics_core::projection::Projection;
use mechanics_core::sparse::Assembler;
use mechanics_core::stage::{Coefficients, Moment, Scheme, Stage};
use mechanics_core::tensor::Vec3;
use std::collections::BTreeMap;

/// The name of the term.
const NAME: &str = "contact with friction";

/// Newton iterations of a minimisation with the true Hessian.
const PATIENCE: u64 = 8;
/// θ in every other iteration after that.
const FLOOR: f64 = 0.1;
/// Passes of a step that take normal forces anew as they are.
const PLAIN_PASSES: u64 = 24;

/// What friction is to be like.
#[derive(Clone, Debug, PartialEq)]
pub struct FrictionOptions {
    /// The smoothed law.
    pub law: SmoothedCoulomb,
    /// Which surfaces have which coefficient.
    pub coefficients: CoefficientTable,
    /// Half-spaces whose material moves, by number.
    pub half_space_motions: BTreeMap<u32, SurfaceMotion>,
    /// The relative lag residual within which lagging has settled; 1e-3 unless said.
    pub lag_tolerance: f64,
}

impl FrictionOptions {
    /// The law and the coefficients, else as the fields say.
    pub fn new(law: SmoothedCoulomb, coefficients: CoefficientTable) -> Self {
        Self { law, coefficients, half_space_motions: BTreeMap::new(), lag_tolerance: 1e-3 }
    }

    /// The same with a half-space whose material moves.
    pub fn with_half_space_motion(mut self, half_space: u32, motion: SurfaceMotion) -> Self {
        self.half_space_motions.insert(half_space, motion);
        self
    }

    /// One coefficient μ for all surfaces, the quadratic law smoothed below `stick_velocity` [m/s].
    ///
    /// # Errors
    /// If one of them is out of range.
    pub fn uniform(friction_coefficient: f64, stick_velocity: f64) -> Result<Self, FrictionError> {
        let coefficient = FrictionCoefficient::new(friction_coefficient)?;
        Ok(Self::new(SmoothedCoulomb::new(stick_velocity)?, CoefficientTable::uniform(coefficient)))
    }
}

/// What friction did in a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrictionReport {
    /// Pairs with friction.
    pub pairs: usize,
    /// Those that slip slower than εᵥ.
    pub sticking: usize,
    /// The fastest slip [m/s].
    pub largest_slip: f64,
    /// Times that normal forces were taken in the step.
    pub lags: u64,
    /// The largest difference of a point's friction force from that with normal forces taken anew \[N\].
    pub lag_residual: f64,
    /// The same relative to the largest bound on a point; zero without friction.
    pub relative_lag_residual: f64,
    /// What friction turned into heat in the step \[J\]: h times force times slip velocity at its end, never less than zero. See
    /// [`LaggedFriction::heat`].
    pub dissipated: f64,
    /// The part of it that moving surfaces put in \[J\]; the points lost the rest.
    pub driven: f64,
}

/// Contact and friction of the features of a mesh; see the [module](self) page.
#[derive(Debug)]
pub struct ContactWithFriction {
    contact: BarrierContact,
    options: FrictionOptions,
    friction: LaggedFriction,
    /// The normal forces that it is of.
    pressings: Vec<Pressing>,
    /// What normal forces taken anew count for: 1, or less where that does not settle.
    share: f64,
    /// By how much those taken last in this step differed from those held.
    difference: Vec<Vec3>,
    /// Where normal forces were taken last.
    lagged_at: Vec<Vec3>,
    coefficients: Coefficients,
    /// Step \[s\]; in statics one part of the load.
    duration: f64,
    velocity_origin: Vec<Vec3>,
    lags: u64,
    /// Below which velocity the law is smoothed at least [m/s].
    softening: f64,
    /// Newton iterations since normal forces were last taken, or found to be settled.
    iterations: u64,
}

impl ContactWithFriction {
    /// `contact`, with friction. There is none before the first step.
    ///
    /// # Errors
    /// If the coefficients or motions name an object or a half-space that the mesh has not, a motion is not finite, or the
    /// tolerance is negative.
    pub fn new(contact: BarrierContact, options: FrictionOptions) -> Result<Self, FrictionError> {
        options.coefficients.check(contact.mesh())?;
        if options.lag_tolerance.is_nan() || options.lag_tolerance < 0.0 {
            return Err(FrictionError::LagTolerance { value: options.lag_tolerance });
        }
        for (&half_space, motion) in &options.half_space_motions {
            check_motion(contact.mesh(), half_space, motion)?;
        }
        let friction = LaggedFriction::new(options.law, &[], &[], &Scheme::statics(&[]))?;
        Ok(Self {
            contact,
            options,
            friction,
            pressings: Vec::new(),
            share: 1.0,
            difference: Vec::new(),
            lagged_at: Vec::new(),
            coefficients: Coefficients::STATICS,
            duration: 1.0,
            velocity_origin: Vec::new(),
            lags: 0,
            softening: 0.0,
            iterations: 0,
        })
    }

    /// Contact.
    pub fn contact(&self) -> &BarrierContact {
        &self.contact
    }

    /// Contact, to set its stiffness.
    pub fn contact_mut(&mut self) -> &mut BarrierContact {
        &mut self.contact
    }

    /// Sets how the material of a half-space moves from the next step on.
    ///
    /// # Errors
    /// If there is no such half-space, or the motion is not finite; nothing changes then.
    pub fn set_half_space_motion(
        &mut self,
        half_space: u32,
        motion: SurfaceMotion,
    ) -> Result<(), FrictionError> {
        check_motion(self.contact.mesh(), half_space, &motion)?;
        self.options.half_space_motions.insert(half_space, motion);
        Ok(())
    }

    /// What friction is like.
    pub fn options(&self) -> &FrictionOptions {
        &self.options
    }

    /// Friction with the normal forces taken last.
    pub fn friction(&self) -> &LaggedFriction {
        &self.friction
    }

    /// What friction does to each pair at `x`.
    pub fn pairs(&self, x: &[Vec3]) -> Vec<PairFriction> {
        self.friction.pairs(x)
    }

    /// The friction of points at `x` that have these velocities [m/s], with the normal forces there: what acts at an instant, of no step.
    ///
    /// # Errors
    /// If the normal forces at `x` are not finite.
    ///
    /// # Panics
    /// If there is not one velocity for each point.
    pub fn at_instant(&self, x: &[Vec3], velocity: &[Vec3]) -> Result<LaggedFriction, FrictionError> {
        assert_eq!(x.len(), velocity.len(), "one velocity for each point");
        let origin: Vec<Vec3> = x.iter().zip(velocity).map(|(x, v)| x - v).collect();
        self.friction_of(&self.pressings(x), &Scheme::statics(&origin))
    }

    /// What friction did in the step that ended at `x`.
    ///
    /// # Errors
    /// If the normal forces at `x` are not finite.
    pub fn report(&self, x: &[Vec3]) -> Result<FrictionReport, FrictionError> {
        if self.velocity_origin.is_empty() {
            return Ok(FrictionReport::default());
        }
        let scheme = Scheme::new(self.coefficients, &self.velocity_origin, &self.velocity_origin);
        let anew = self.friction_of(&self.pressings(x), &scheme)?;
        let [lag_residual, relative_lag_residual] = residual(&self.friction, &anew, x);
        let pairs = self.friction.pairs(x);
        let driven = self.friction.driven(x, self.duration);
        let slips = || pairs.iter().map(|pair| pair.slip_velocity.norm());
        Ok(FrictionReport {
            pairs: pairs.len(),
            sticking: slips().filter(|&slip| slip < self.options.law.stick_velocity()).count(),
            largest_slip: slips().fold(0.0, f64::max),
            lags: self.lags,
            lag_residual,
            relative_lag_residual,
            dissipated: self.friction.heat(x, self.duration),
            driven,
        })
    }

    /// The normal forces at `x`.
    fn pressings(&self, x: &[Vec3]) -> Vec<Pressing> {
        // Those of one point come first.
        let half_spaces = self.contact.half_space_numbers(x);
        let pressing = |(number, force): (usize, NormalForce)| {
            let half_space = half_spaces.get(number).copied();
            let coefficient = self.coefficient_of(&force, half_space);
            let surface_velocity = self.surface_velocity(&force, half_space, x);
            Pressing { force, half_space, coefficient, surface_velocity }
        };
        self.contact.normal_forces(x).into_iter().enumerate().map(pressing).collect()
    }

    /// Friction of these normal forces.
    fn friction_of(
        &self,
        pressings: &[Pressing],
        scheme: &Scheme<'_>,
    ) -> Result<LaggedFriction, FrictionError> {
        let forces: Vec<NormalForce> = pressings.iter().map(|pressing| pressing.force).collect();
        let coefficients: Vec<_> = pressings.iter().map(|pressing| pressing.coefficient).collect();
        let velocities: Vec<Vec3> = pressings.iter().map(|pressing| pressing.surface_velocity).collect();
        let law = self.options.law.softened(self.softening);
        LaggedFriction::on_moving_surfaces(law, &forces, &coefficients, &velocities, scheme)
    }

    /// The velocity of the half-space's material where the point is; zero for other pairs.
    fn surface_velocity(&self, force: &NormalForce, half_space: Option<u32>, x: &[Vec3]) -> Vec3 {
        let motion = half_space.and_then(|number| self.options.half_space_motions.get(&number));
        match (motion, force.points()) {
            (Some(motion), &[point, ..]) => motion.at(&x[point as usize]),
            _ => Vec3::zeros(),
        }
    }

    fn coefficient_of(&self, force: &NormalForce, half_space: Option<u32>) -> FrictionCoefficient {
        let mesh: &CollisionMesh = self.contact.mesh();
        let table = &self.options.coefficients;
        match (half_space, force.points()) {
            (Some(half_space), &[point]) => table.of_half_space(half_space, mesh.object_of(point)),
            (_, &[first, .., last]) => table.of_objects(mesh.object_of(first), mesh.object_of(last)),
            _ => FrictionCoefficient::NONE,
        }
    }

    /// Takes the normal forces at the start of a step.
    fn begin_step(&mut self, stage: &Stage<'_>) -> Result<Changed, FrictionError> {
        self.pressings = self.pressings(stage.x);
        self.friction = self.friction_of(&self.pressings, &stage.scheme)?;
        self.velocity_origin = stage.scheme.velocity_origin.to_vec();
        self.coefficients = stage.scheme.coefficients;
        self.duration = if stage.step > 0.0 { stage.step } else { 1.0 };
        self.lagged_at = stage.x.to_vec();
        self.lags = 1;
        self.share = 1.0;
        Ok(Changed::Energy)
    }

    /// Takes the normal forces anew, whatever they were.
    fn take_as_they_are(&mut self, stage: &Stage<'_>) -> Result<Changed, FrictionError> {
        self.pressings = self.pressings(stage.x);
        self.friction = self.friction_of(&self.pressings, &stage.scheme)?;
        self.lagged_at = stage.x.to_vec();
        self.share = 1.0;
        Ok(Changed::Energy)
    }

    /// Takes the normal forces anew, unless friction has settled.
    fn lag(&mut self, stage: &Stage<'_>) -> Result<Changed, FrictionError> {
        // Averages are not the normal forces of where they were taken last: they go on approaching those though nothing moves.
        if self.share == 1.0 && self.lagged_at == stage.x {
            return Ok(Changed::Nothing);
        }
        let anew = self.pressings(stage.x);
        let friction_anew = self.friction_of(&anew, &stage.scheme)?;
        let [_, relative] = residual(&self.friction, &friction_anew, stage.x);
        if relative <= self.options.lag_tolerance {
            return Ok(Changed::Nothing);
        }
        // The pass before the first average is the first whose difference is asked for.
        if self.lags + 1 >= PLAIN_PASSES {
            let difference = difference(&self.pressings, &anew, stage.x.len());
            if self.lags >= PLAIN_PASSES {
                self.share = relaxed(self.share, &self.difference, &difference);
            }
            self.difference = difference;
        }
        if self.share < 1.0 {
            self.pressings = blend(&self.pressings, &anew, self.share);
            self.friction = self.friction_of(&self.pressings, &stage.scheme)?;
        } else {
            (self.pressings, self.friction) = (anew, friction_anew);
        }
        self.lagged_at = stage.x.to_vec();
        self.lags += 1;
        Ok(Changed::Energy)
    }
}

fn check_motion(mesh: &CollisionMesh, half_space: u32, motion: &SurfaceMotion) -> Result<(), FrictionError> {
    let half_spaces = mesh.half_spaces().len();
    if half_space as usize >= half_spaces {
        return Err(FrictionError::MotionOutOfRange { half_space, half_spaces });
    }
    if !motion.is_finite() {
        return Err(FrictionError::Motion { half_space, motion: *motion });
    }
    Ok(())
}

/// The lag residual \[N\], and relative to the largest bound.
fn residual(used: &LaggedFriction, anew: &LaggedFriction, x: &[Vec3]) -> [f64; 2] {
    let differences = used.forces(x).into_iter().zip(anew.forces(x)).map(|(used, anew)| (used - anew).norm());
    let largest = differences.fold(0.0, f64::max);
    let bound = used.largest_bound(x.len()).max(anew.largest_bound(x.len()));
    [largest, if bound > 0.0 { largest / bound } else { 0.0 }]
}

impl Potential for ContactWithFriction {
    fn name(&self) -> &str {
        NAME
    }

    fn value(&self, x: &[Vec3]) -> f64 {
        self.contact.value(x) + self.friction.value(x)
    }

    fn add_gradient(&self, x: &[Vec3], gradient: &mut [Vec3]) {
        self.contact.add_gradient(x, gradient);
        self.friction.add_gradient(x, gradient);
    }

    /// That of contact, and of friction with the normal forces at the stage's points.
    fn add_settled_gradient(&self, stage: &Stage<'_>, gradient: &mut [Vec3]) {
        self.contact.add_gradient(stage.x, gradient);
        match self.friction_of(&self.pressings(stage.x), &stage.scheme) {
            Ok(friction) => friction.add_gradient(stage.x, gradient),
            Err(_) => gradient.iter_mut().for_each(|g| g.fill(f64::NAN)),
        }
    }

    fn soften(&mut self, velocity: f64) {
        self.softening = velocity;
    }

    /// Nine lists, always: the five of contact, the four of friction.
    fn add_hessian(&self, x: &[Vec3], projection: Projection, hessian: &mut Assembler<'_>) {
        self.contact.add_hessian(x, projection, hessian);
        self.friction.add_hessian(x, projection, hessian);
    }

    /// Freezes contact; takes normal forces at the start of a step, and again at a lag iteration where friction has not settled.
    ///
    /// # Errors
    /// Those of contact; [`FrictionError::NormalForce`] if a normal force is not finite.
    fn freeze(&mut self, stage: &Stage<'_>) -> Result<Changed, PotentialError> {
        let contact = self.contact.freeze(stage)?;
        let friction = match stage.moment {
            Moment::Step => self.begin_step(stage)?,
            Moment::Lag => self.lag(stage)?,
            Moment::Settling => self.take_as_they_are(stage)?,
            Moment::Iteration => {
                self.iterations += 1;
                Changed::Nothing
            }
        };
        if stage.moment != Moment::Iteration {
            self.iterations = 0;
        }
        let floored = self.iterations > PATIENCE && !(self.iterations - PATIENCE).is_multiple_of(2);
        self.friction.set_floor(if floored { FLOOR } else { 0.0 });
        Ok(contact.or(friction))
    }

    fn limit_step(&mut self, x: &[Vec3], p: &[Vec3]) -> Result<StepLimit, PotentialError> {
        self.contact.limit_step(x, p)
    }

    fn is_settled(&self, x: &[Vec3], p: &[Vec3]) -> bool {
        self.contact.is_settled(x, p)
    }

    fn demand(&self) -> Demand {
        self.contact.demand()
    }

    /// The number of the pair among the normal forces of contact at `x`.
    fn locate(&self, x: &[Vec3], point: usize) -> Option<usize> {
        self.contact.locate(x, point)
    }

    fn diagnose(&self, x: &[Vec3]) -> Option<PotentialError> {
        self.contact.diagnose(x).or_else(|| self.friction.diagnose(x))
    }
}
