//! Boundaries as conditions on the velocities of nodes: equalities that hold, inequalities that may.
//!
//! A held node has velocities u + span(free directions). With orthonormal directions q that are held, v = c + (I − Σ q qᵀ) v. An inequality
//! n·v ≥ n·u is one of the held directions or none at all; which ones is found by rounds, see [`Constraints::revise`].

use crate::boundary::{Boundary, PrescribedVelocity, Surface};
use mechanics_core::tensor::{Mat3, Vec3};

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
}

/// Coulomb friction of a node that a boundary pushes with the normal impulse λ.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Grip {
    /// There is none.
    Loose,
    /// The node moves with the boundary.
    Sticks,
    /// It moves along `direction` and is braked by the impulse `limit` = μλ \[N s\] of the round before.
    Slides { direction: Vec3, limit: f64 },
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
    pub(super) prescribed: &'a [PrescribedVelocity<D>],
    pub(super) boundaries: &'a [Boundary<D>],
    /// Begin and end of the step \[s\].
    pub(super) begin: f64,
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

impl<const D: usize> Sources<'_, D> {
    /// The conditions of a node.
    fn conditions(&self, point: &[f64; D]) -> Vec<Condition> {
        let mut fixed: Option<[f64; D]> = None;
        for prescribed in self.prescribed {
            let velocity = prescribed.act(point, self.begin, &[f64::INFINITY; D]);
            if velocity[0].is_finite() {
                fixed = Some(velocity);
            }
        }
        let mut conditions = Vec::new();
        for boundary in self.boundaries {
            let normals = boundary.normals(point, self.end);
            if normals.is_empty() {
                continue;
            }
            if boundary.surface == Surface::Sticky {
                fixed = Some(boundary.velocity);
                conditions.clear();
            } else if let Some(velocity) = &mut fixed {
                *velocity = boundary.act(point, self.end, velocity);
            } else {
                let holds = if boundary.surface == Surface::Slip { Holds::Always } else { Holds::NotNow };
                let velocity = embedded::<D>(&boundary.velocity) * self.speed;
                let friction = match boundary.surface {
                    Surface::Friction(coefficient) => coefficient,
                    _ => 0.0,
                };
                conditions.extend(normals.iter().map(|normal| {
                    let normal = embedded::<D>(normal);
                    let (target, grip) = (normal.dot(&velocity), Grip::Loose);
                    Condition { normal, target, holds, friction, velocity, grip }
                }));
            }
        }
        if let Some(velocity) = fixed {
            return (0..D)
                .map(|axis| Condition {
                    normal: Vec3::ith(axis, 1.0),
                    target: self.speed * velocity[axis],
                    holds: Holds::Always,
                    friction: 0.0,
                    velocity: Vec3::zeros(),
                    grip: Grip::Loose,
                })
                .collect();
        }
        conditions
    }
}

impl Held {
    /// Finds the basis of what holds: Gram and Schmidt's.
    fn update(&mut self) {
        self.basis.clear();
        self.anchor = Vec3::zeros();
        for k in 0..self.conditions.len() {
            let Condition { normal, target, holds, velocity, grip, .. } = self.conditions[k];
            if holds == Holds::NotNow {
                continue;
            }
            self.hold(&normal, target);
            if grip == Grip::Sticks {
                for axis in 0..3 {
                    self.hold(&Vec3::ith(axis, 1.0), velocity[axis]);
                }
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
    /// Holds from now on; what can stick does at first.
    fn take_hold(&mut self) {
        self.holds = Holds::Now;
        if self.friction > 0.0 {
            self.grip = Grip::Sticks;
        }
    }

    /// Friction at the multiplier λ and the impulse along the surface that a sticking node needs; `most` is the largest λ of all nodes.
    /// Answers whether it changed.
    fn revise_grip(&mut self, velocity: &Vec3, multiplier: f64, needed: &Vec3, measure: &Measure) -> bool {
        let limit = self.friction * multiplier.max(0.0);
        let noise = FRICTION_TOLERANCE * self.friction * measure.most;
        let next = match self.grip {
            Grip::Loose => Grip::Loose,
            Grip::Sticks if needed.norm() <= limit + noise => Grip::Sticks,
            Grip::Sticks => Grip::Slides { direction: -needed.normalize(), limit },
            Grip::Slides { direction, limit: before } => {
                let relative = velocity - self.velocity;
                let sliding = relative - self.normal * self.normal.dot(&relative);
                let speed = sliding.norm();
                let turned = speed > measure.slack && (sliding / speed - direction).norm() > FRICTION_TOLERANCE;
                if sliding.dot(&direction) < -measure.slack {
                    Grip::Sticks
                } else if turned {
                    Grip::Slides { direction: sliding / speed, limit }
                } else if (limit - before).abs() > noise {
                    Grip::Slides { direction, limit }
                } else {
                    return false;
                }
            }
        };
        let changed = next != self.grip;
        self.grip = next;
        changed
    }
}

/// What changes are measured by.
struct Measure {
    /// The largest multiplier \[N s\].
    most: f64,
    /// Velocities below this are none \[m/s\].
    slack: f64,
}

impl<const D: usize> Constraints<D> {
    /// Of the nodes at `places`; inequalities that `velocities` break hold.
    pub(super) fn new(sources: &Sources<'_, D>, places: &[[f64; D]], velocities: &[f64]) -> Self {
        let mut held = Vec::new();
        if !(sources.boundaries.is_empty() && sources.prescribed.is_empty()) {
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

    /// Nodes that slide: node, direction and impulse of friction, velocity of the boundary.
    fn sliding(&self) -> impl Iterator<Item = (usize, Vec3, Vec3)> + '_ {
        self.held.iter().flat_map(|held| {
            held.conditions.iter().filter_map(|condition| match condition.grip {
                Grip::Slides { direction, limit } => {
                    Some((held.node, direction * limit, condition.velocity))
                }
                _ => None,
            })
        })
    }

    /// The work of friction, μλ d·(v − u), whose derivative is its impulse \[J\].
    pub(super) fn friction_energy(&self, velocities: &[f64]) -> f64 {
        let work = |(node, impulse, velocity): (usize, Vec3, Vec3)| {
            impulse.dot(&(embedded::<D>(&velocities[node * D..]) - velocity))
        };
        self.sliding().map(work).sum()
    }

    /// Adds its gradient.
    pub(super) fn add_friction(&self, gradient: &mut [f64]) {
        for (node, impulse, _) in self.sliding() {
            for axis in 0..D {
                gradient[node * D + axis] += impulse[axis];
            }
        }
    }

    /// Changes which inequalities hold and which nodes stick, by the velocities at a minimum and its whole gradient; answers how many changed.
    /// Velocities below `slack` are none; `blocks` tell which impulses that makes none.
    ///
    /// At the minimum under the inequalities, ∇Φ = Σ λ n with λ ≥ 0 where one holds, and n·v ≥ s where none does: one with λ < 0 is let go,
    /// one that is broken holds (Hintermüller, Ito, Kunisch 2003, with whole solves in between). A node that sticks and needs more than μλ along the
    /// surface slides from now on, against that impulse; one that slides backwards sticks.
    pub(super) fn revise(
        &mut self,
        velocities: &[f64],
        gradient: &[f64],
        blocks: &[Mat3],
        slack: f64,
    ) -> usize {
        let force = |held: &Held| embedded::<D>(&gradient[held.node * D..]);
        let found: Vec<Vec<(usize, f64)>> = self.held.iter().map(|held| held.multipliers(&force(held))).collect();
        let most = found.iter().flatten().fold(0.0, |most: f64, (_, multiplier)| most.max(*multiplier));
        let mut changed = 0;
        for (held, multipliers) in self.held.iter_mut().zip(&found) {
            let velocity = embedded::<D>(&velocities[held.node * D..]);
            let pull = slack * blocks[held.node].trace() / 3.0;
            let pushed: Vec3 = multipliers.iter().map(|(k, m)| held.conditions[*k].normal * *m).sum();
            let needed = force(held) - pushed;
            let before = changed;
            for (k, multiplier) in multipliers {
                let condition = &mut held.conditions[*k];
                let grips = condition.revise_grip(&velocity, *multiplier, &needed, &Measure { most, slack });
                changed += usize::from(grips);
            }
            changed += held.revise(&velocity, multipliers, pull, slack);
            if changed > before {
                held.update();
            }
        }
        changed
    }
}
