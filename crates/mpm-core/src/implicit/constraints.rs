//! Boundaries as conditions on the velocities of nodes: equalities that hold, inequalities that may.
//!
//! A held node has velocities u + span(free directions). With orthonormal directions q that are held, v = c + (I − Σ q qᵀ) v. An inequality
//! n·v ≥ n·u is one of the held directions or none at all; which ones is found by rounds, see [`Constraints::revise`].

use crate::boundary::{Boundary, PrescribedVelocity, Surface};
use crate::collider::{ColliderStage, Impulse};
use crate::grip::PlacedGrip;
use mechanics_core::tensor::{Mat3, Vec3};

/// Sliding velocities below this many creep velocities are near sticking.
const NEAR_STICKING: f64 = 10.0;

/// The least curvature along the sliding there, as a part of that across.
const LEAST_CURVATURE: f64 = 0.3;

/// Rounds in which the limits of friction follow the normal impulses and what is pulled is let go; later ones keep both, so that they end.
const LAGGED_ROUNDS: u64 = 12;

/// Changes of brakes below this part of the largest are none.
const FRICTION_TOLERANCE: f64 = 1e-3;

/// Normals closer to a plane of others than this are in it.
const PARALLEL: f64 = 1e-6;

/// One condition on the velocity of a node: n·v = s, or ≥ s.
#[derive(Clone, Copy, Debug)]
struct Condition {
    normal: Vec3,
    target: f64,
    holds: Holds,
    /// Coefficient of friction.
    friction: f64,
    /// Velocity of the boundary \[m/s\].
    velocity: Vec3,
    /// What friction does while the condition holds.
    grip: Grip,
    /// The collider that asks for it.
    collider: Option<usize>,
}

/// Coulomb friction of a node that a boundary pushes with the normal impulse λ.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Grip {
    /// There is none.
    Loose,
    /// It is braked by at most `limit` = μλ \[N s\] of the round before (zero in the first one), less below the creep velocity \[m/s\].
    Braked { limit: f64, creep: f64 },
}

/// Whether a condition is an equality now.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Holds {
    /// It is one for ever.
    Always,
    /// An inequality that is one now.
    Now,
    /// An inequality with room.
    NotNow,
}

/// The conditions of a node.
#[derive(Clone, Debug)]
struct Held {
    node: usize,
    conditions: Vec<Condition>,
    /// Orthonormal directions that are held now.
    basis: Vec<Vec3>,
    /// The velocity in their span.
    anchor: Vec3,
}

/// What acts on nodes at the end of a step.
pub(super) struct Sources<'a, const D: usize> {
    pub(super) grips: &'a [PlacedGrip<D>],
    pub(super) prescribed: &'a [PrescribedVelocity<D>],
    pub(super) boundaries: &'a [Boundary<D>],
    pub(super) colliders: &'a ColliderStage<'a>,
    /// Middle and end of the step \[s\].
    pub(super) middle: f64,
    pub(super) end: f64,
    /// Factor of all given velocities: one, or zero where there is no motion.
    pub(super) speed: f64,
}

/// The conditions of all nodes.
pub(super) struct Constraints<const D: usize> {
    held: Vec<Held>,
}

fn embedded<const D: usize>(v: &[f64]) -> Vec3 {
    Vec3::from_fn(|k, _| if k < D { v[k] } else { 0.0 })
}

/// What is asked of a node, by one after the other.
#[derive(Default)]
struct Asked {
    /// Its whole velocity, and by which collider, if one.
    fixed: Option<(Vec3, Option<usize>)>,
    conditions: Vec<Condition>,
}

impl Asked {
    /// By a surface of this velocity, on which outward normals the node is.
    fn by_surface(&mut self, surface: Surface, normals: &[Vec3], velocity: Vec3, collider: Option<usize>) {
        if surface == Surface::Sticky {
            self.fixed = Some((velocity, collider));
            self.conditions.clear();
        } else if let Some((fixed, _)) = &mut self.fixed {
            for normal in normals {
                let relative: [f64; 3] = (*fixed - velocity).into();
                *fixed = Vec3::from(surface.relative(&relative, &(*normal).into())) + velocity;
            }
        } else {
            let asked = normals.iter().map(|normal| condition(surface, normal, velocity, collider));
            self.conditions.extend(asked);
        }
    }

    fn into_conditions(self, dimension: usize) -> Vec<Condition> {
        let Some((velocity, collider)) = self.fixed else { return self.conditions };
        let along = |axis: usize| Condition {
            normal: Vec3::ith(axis, 1.0),
            target: velocity[axis],
            holds: Holds::Always,
            friction: 0.0,
            velocity: Vec3::zeros(),
            grip: Grip::Loose,
            collider,
        };
        (0..dimension).map(along).collect()
    }
}

impl<const D: usize> Sources<'_, D> {
    fn are_none(&self) -> bool {
        let Self { grips, prescribed, boundaries, colliders, .. } = self;
        grips.is_empty() && prescribed.is_empty() && boundaries.is_empty() && colliders.is_empty()
    }

    /// The conditions of a node.
    fn conditions(&self, point: &[f64; D]) -> Vec<Condition> {
        let mut asked = Asked::default();
        for velocity in self.grips.iter().filter_map(|grip| grip.velocity_at(point)) {
            asked.fixed = Some((embedded::<D>(&velocity) * self.speed, None));
        }
        for prescribed in self.prescribed.iter().filter(|one| one.reaches(point, self.middle)) {
            asked.fixed = Some((embedded::<D>(&prescribed.velocity) * self.speed, None));
        }
        for boundary in self.boundaries {
            let normals: Vec<Vec3> =
                boundary.normals(point, self.end).iter().map(|n| embedded::<D>(n)).collect();
            if !normals.is_empty() {
                let velocity = embedded::<D>(&boundary.velocity) * self.speed;
                asked.by_surface(boundary.surface, &normals, velocity, None);
            }
        }
        for touch in self.colliders.touches(&embedded::<D>(point)) {
            let velocity = touch.velocity * self.speed;
            asked.by_surface(touch.surface, &[touch.normal], velocity, Some(touch.collider));
        }
        asked.into_conditions(D)
    }
}

/// What a surface of outward normal `normal` and this velocity asks of a node.
fn condition(surface: Surface, normal: &Vec3, velocity: Vec3, collider: Option<usize>) -> Condition {
    let holds = if surface == Surface::Slip { Holds::Always } else { Holds::NotNow };
    let friction = match surface {
        Surface::Friction(coefficient) => coefficient,
        _ => 0.0,
    };
    let target = normal.dot(&velocity);
    Condition { normal: *normal, target, holds, friction, velocity, grip: Grip::Loose, collider }
}

impl Held {
    /// Finds the basis of what holds: Gram and Schmidt's.
    fn update(&mut self) {
        self.basis.clear();
        self.anchor = Vec3::zeros();
        for k in 0..self.conditions.len() {
            let Condition { normal, target, holds, .. } = self.conditions[k];
            if holds != Holds::NotNow {
                self.hold(&normal, target);
            }
        }
    }

    /// Holds n·v = s.
    fn hold(&mut self, normal: &Vec3, target: f64) {
        let rest = normal - self.in_basis(normal);
        let length = rest.norm();
        if length > PARALLEL {
            let direction = rest / length;
            let speed = (target - normal.dot(&self.anchor)) / length;
            self.basis.push(direction);
            self.anchor += direction * speed;
        }
    }

    /// Lets go of what is pulled (λ < −`pull`) or else holds what is broken by more than `slack`; answers how many changed.
    fn revise(&mut self, velocity: &Vec3, multipliers: &[(usize, f64)], pull: f64, slack: f64) -> usize {
        let mut changed = 0;
        for (k, multiplier) in multipliers {
            let condition = &mut self.conditions[*k];
            if condition.holds == Holds::Now && *multiplier < -pull {
                (condition.holds, condition.grip) = (Holds::NotNow, Grip::Loose);
                changed += 1;
            }
        }
        if changed > 0 {
            return changed;
        }
        for condition in &mut self.conditions {
            let broken = condition.normal.dot(velocity) < condition.target - slack;
            if condition.holds == Holds::NotNow && broken {
                condition.take_hold();
                changed += 1;
            }
        }
        changed
    }

    fn in_basis(&self, v: &Vec3) -> Vec3 {
        self.basis.iter().map(|q| q * q.dot(v)).sum()
    }

    /// The multipliers λ of what holds: Σ λ n next to `force`.
    fn multipliers(&self, force: &Vec3) -> Vec<(usize, f64)> {
        let holding: Vec<usize> =
            (0..self.conditions.len()).filter(|k| self.conditions[*k].holds != Holds::NotNow).collect();
        let (mut gram, mut right) = (Mat3::identity(), Vec3::zeros());
        for (i, k) in holding.iter().take(3).enumerate() {
            right[i] = self.conditions[*k].normal.dot(force);
            for (j, l) in holding.iter().take(3).enumerate() {
                gram[(i, j)] = self.conditions[*k].normal.dot(&self.conditions[*l].normal);
            }
        }
        let solved = gram.try_inverse().map_or(right, |inverse| inverse * right);
        holding.iter().take(3).enumerate().map(|(i, k)| (*k, solved[i])).collect()
    }
}

impl Condition {
    /// Holds from now on.
    fn take_hold(&mut self) {
        self.holds = Holds::Now;
        if self.friction > 0.0 {
            self.grip = Grip::Braked { limit: 0.0, creep: 1.0 };
        }
    }

    /// Friction at the multiplier λ; answers whether it changed by more than `noise` \[N s\].
    fn revise_grip(&mut self, multiplier: f64, creep: f64, noise: f64) -> bool {
        let limit = self.friction * multiplier.max(0.0);
        let changed = match self.grip {
            Grip::Loose => return false,
            Grip::Braked { limit: before, .. } => (limit - before).abs() > noise,
        };
        if changed {
            self.grip = Grip::Braked { limit, creep };
        }
        changed
    }

    /// Sliding velocity and its length.
    fn sliding(&self, velocity: &Vec3) -> (Vec3, f64) {
        let relative = velocity - self.velocity;
        let sliding = relative - self.normal * self.normal.dot(&relative);
        (sliding, sliding.norm())
    }

    /// μλ ε ln cosh(‖t‖/ε) \[J\].
    fn friction_energy(&self, velocity: &Vec3) -> f64 {
        let Grip::Braked { limit, creep } = self.grip else { return 0.0 };
        let z = self.sliding(velocity).1 / creep;
        limit * creep * (z + (-2.0 * z).exp().ln_1p() - std::f64::consts::LN_2)
    }

    /// Its gradient, μλ tanh(‖t‖/ε) along t \[N s\].
    fn friction_gradient(&self, velocity: &Vec3) -> Vec3 {
        let Grip::Braked { limit, creep } = self.grip else { return Vec3::zeros() };
        let (sliding, speed) = self.sliding(velocity);
        sliding * (limit * mean_slope(speed, creep))
    }

    /// Its Hessian \[kg\]; along t not less than a part of that across, as long as t is small, lest Newton's method jumps to and fro across rest.
    fn friction_hessian(&self, velocity: &Vec3) -> Mat3 {
        let Grip::Braked { limit, creep } = self.grip else { return Mat3::zeros() };
        let (sliding, speed) = self.sliding(velocity);
        let surface = Mat3::identity() - self.normal * self.normal.transpose();
        let across = mean_slope(speed, creep);
        if speed == 0.0 {
            return surface * (limit * across);
        }
        let (z, direction) = (speed / creep, sliding / speed);
        let least = if z < NEAR_STICKING { LEAST_CURVATURE * across } else { 0.0 };
        let along = ((1.0 - z.tanh().powi(2)) / creep).max(least);
        (surface * across + direction * direction.transpose() * (along - across)) * limit
    }
}

/// tanh(s/ε)/s.
fn mean_slope(speed: f64, creep: f64) -> f64 {
    if speed > 0.0 { (speed / creep).tanh() / speed } else { 1.0 / creep }
}

/// How rounds are compared.
pub(super) struct Round {
    /// Velocities below this are none \[m/s\].
    pub(super) slack: f64,
    /// Where friction is smoothed \[m/s\].
    pub(super) creep: f64,
    /// Rounds so far.
    pub(super) number: u64,
}

impl<const D: usize> Constraints<D> {
    /// Of the nodes at `places`; inequalities that `velocities` break hold.
    pub(super) fn new(sources: &Sources<'_, D>, places: &[[f64; D]], velocities: &[f64]) -> Self {
        let mut held = Vec::new();
        if !sources.are_none() {
            for (node, place) in places.iter().enumerate() {
                let conditions = sources.conditions(place);
                if !conditions.is_empty() {
                    held.push(Held { node, conditions, basis: Vec::new(), anchor: Vec3::zeros() });
                }
            }
        }
        for one in &mut held {
            let velocity = embedded::<D>(&velocities[one.node * D..]);
            for condition in &mut one.conditions {
                if condition.holds == Holds::NotNow && condition.normal.dot(&velocity) < condition.target {
                    condition.take_hold();
                }
            }
            one.update();
        }
        Self { held }
    }

    /// Whether nothing is to be found out by rounds.
    pub(super) fn are_equalities(&self) -> bool {
        self.held.iter().all(|held| held.conditions.iter().all(|condition| condition.holds == Holds::Always))
    }

    /// What the colliders take at the minimum, of which the whole gradient is Σ λ n: the opposite of λ n less friction's part, by collider.
    pub(super) fn loads(
        &self,
        places: &[[f64; D]],
        velocities: &[f64],
        gradient: &[f64],
    ) -> Vec<(usize, Impulse)> {
        let mut loads = Vec::new();
        for held in self.held.iter().filter(|held| held.conditions.iter().any(|c| c.collider.is_some())) {
            let part = |vector: &[f64]| embedded::<D>(&vector[held.node * D..]);
            for (k, multiplier) in held.multipliers(&part(gradient)) {
                let condition = &held.conditions[k];
                if let Some(collider) = condition.collider {
                    let friction = condition.friction_gradient(&part(velocities));
                    let taken = friction - condition.normal * multiplier;
                    loads.push((collider, Impulse::at(&embedded::<D>(&places[held.node]), taken)));
                }
            }
        }
        loads
    }

    /// Whether a collider asks something of a node.
    pub(super) fn touch_colliders(&self) -> bool {
        self.held.iter().any(|held| held.conditions.iter().any(|condition| condition.collider.is_some()))
    }

    /// Takes what is held out of a change of velocities, or of forces.
    pub(super) fn project(&self, vector: &mut [f64]) {
        for held in &self.held {
            let part = held.in_basis(&embedded::<D>(&vector[held.node * D..]));
            for axis in 0..D {
                vector[held.node * D + axis] -= part[axis];
            }
        }
    }

    /// Gives the held velocities to what is held.
    pub(super) fn place(&self, velocities: &mut [f64]) {
        self.project(velocities);
        for held in &self.held {
            for axis in 0..D {
                velocities[held.node * D + axis] += held.anchor[axis];
            }
        }
    }

    /// Replaces blocks of nodes by (I − Σqqᵀ) B (I − Σqqᵀ) + t Σqqᵀ, with t of the size of B.
    pub(super) fn project_blocks(&self, blocks: &mut [Mat3]) {
        for held in &self.held {
            let block = &mut blocks[held.node];
            let basis: Mat3 = held.basis.iter().map(|q| q * q.transpose()).sum();
            let free = Mat3::identity() - basis;
            *block = free * *block * free + basis * (block.trace() / 3.0);
        }
    }

    /// Σ of the brakes' potentials \[J\].
    pub(super) fn friction_energy(&self, velocities: &[f64]) -> f64 {
        self.brakes()
            .map(|(node, brake)| brake.friction_energy(&embedded::<D>(&velocities[node * D..])))
            .sum()
    }

    fn brakes(&self) -> impl Iterator<Item = (usize, &Condition)> + '_ {
        let braked = |condition: &&Condition| matches!(condition.grip, Grip::Braked { .. });
        self.held
            .iter()
            .flat_map(move |held| held.conditions.iter().filter(braked).map(|brake| (held.node, brake)))
    }

    /// Lets all that is braked stick: where the first round with friction starts, because what sticks is found from below in few iterations and what slides
    /// in one, but not the other way round.
    pub(super) fn stick(&self, velocities: &mut [f64]) {
        for (node, brake) in self.brakes() {
            let (sliding, _) = brake.sliding(&embedded::<D>(&velocities[node * D..]));
            for axis in 0..D {
                velocities[node * D + axis] -= sliding[axis];
            }
        }
    }

    /// Adds their gradients.
    pub(super) fn add_friction(&self, velocities: &[f64], gradient: &mut [f64]) {
        for (node, brake) in self.brakes() {
            let part = brake.friction_gradient(&embedded::<D>(&velocities[node * D..]));
            for axis in 0..D {
                gradient[node * D + axis] += part[axis];
            }
        }
    }

    /// Their Hessians, by node.
    pub(super) fn friction_blocks(&self, velocities: &[f64]) -> Vec<(usize, Mat3)> {
        let block = |(node, brake): (usize, &Condition)| {
            (node, brake.friction_hessian(&embedded::<D>(&velocities[node * D..])))
        };
        self.brakes().map(block).collect()
    }

    /// Changes which inequalities hold, and the limits of friction, by the velocities at a minimum and its whole gradient; answers how many
    /// changed. `blocks` tell which impulses velocities below the slack make.
    ///
    /// At the minimum under the inequalities, ∇Φ = Σ λ n with λ ≥ 0 where one holds, and n·v ≥ s where none does: one with λ < 0 is let go,
    /// one that is broken holds (Hintermüller, Ito, Kunisch 2003, with whole solves in between).
    pub(super) fn revise(
        &mut self,
        velocities: &[f64],
        gradient: &[f64],
        blocks: &[Mat3],
        round: &Round,
    ) -> usize {
        let force = |held: &Held| embedded::<D>(&gradient[held.node * D..]);
        let found: Vec<Vec<(usize, f64)>> =
            self.held.iter().map(|held| held.multipliers(&force(held))).collect();
        let most = found.iter().flatten().fold(0.0, |most: f64, (_, multiplier)| most.max(*multiplier));
        let mut changed = 0;
        for (held, multipliers) in self.held.iter_mut().zip(&found) {
            let velocity = embedded::<D>(&velocities[held.node * D..]);
            let lagging = round.number < LAGGED_ROUNDS;
            let pull = if lagging { round.slack * blocks[held.node].trace() / 3.0 } else { f64::INFINITY };
            let before = changed;
            for (k, multiplier) in multipliers {
                let condition = &mut held.conditions[*k];
                let noise = FRICTION_TOLERANCE * condition.friction * most;
                changed += usize::from(lagging && condition.revise_grip(*multiplier, round.creep, noise));
            }
            changed += held.revise(&velocity, multipliers, pull, round.slack);
            if changed > before {
                held.update();
            }
        }
        changed
    }
}
