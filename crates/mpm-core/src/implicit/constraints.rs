//! Boundaries as conditions on the velocities of nodes: equalities that hold, inequalities that may.
//!
//! A held node has velocities u + span(free directions). With orthonormal directions q that are held, v = c + (I − Σ q qᵀ) v. An inequality
//! n·v ≥ n·u is one of the held directions or none at all; which ones is found by rounds, see [`Constraints::revise`].

use crate::boundary::{Boundary, PrescribedVelocity, Surface};
use mechanics_core::tensor::{Mat3, Vec3};

/// Normals closer to a plane of others than this are in it.
const PARALLEL: f64 = 1e-6;

/// One condition on the velocity of a node: n·v = s, or ≥ s.
#[derive(Clone, Copy, Debug)]
struct Condition {
    normal: Vec3,
    target: f64,
    holds: Holds,
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
                let velocity = embedded::<D>(&boundary.velocity);
                conditions.extend(normals.iter().map(|normal| {
                    let normal = embedded::<D>(normal);
                    Condition { normal, target: normal.dot(&velocity), holds }
                }));
            }
        }
        if let Some(velocity) = fixed {
            return (0..D)
                .map(|axis| Condition {
                    normal: Vec3::ith(axis, 1.0),
                    target: velocity[axis],
                    holds: Holds::Always,
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
        for condition in self.conditions.iter().filter(|condition| condition.holds != Holds::NotNow) {
            let rest = condition.normal - self.in_basis(&condition.normal);
            let length = rest.norm();
            if length > PARALLEL {
                let direction = rest / length;
                let speed = (condition.target - condition.normal.dot(&self.anchor)) / length;
                self.basis.push(direction);
                self.anchor += direction * speed;
            }
        }
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

/// When an inequality changes: how far a velocity may be beyond it \[m/s\].
#[derive(Clone, Copy, Debug)]
pub(super) struct Slack {
    pub(super) speed: f64,
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
                    condition.holds = Holds::Now;
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

    /// Changes which inequalities hold, by the velocities and the forces −∇Φ that the boundaries must balance; answers how many changed.
    ///
    /// At the minimum under the inequalities, ∇Φ = Σ λ n with λ ≥ 0 where one holds, and n·v ≥ s where none does: one with λ < 0 is let go,
    /// one that is broken holds. This is the primal-dual active set method (Hintermüller, Ito, Kunisch 2003), with whole solves in between.
    pub(super) fn revise(
        &mut self,
        velocities: &[f64],
        gradient: &[f64],
        blocks: &[Mat3],
        slack: Slack,
    ) -> usize {
        let mut changed = 0;
        for held in &mut self.held {
            let velocity = embedded::<D>(&velocities[held.node * D..]);
            let force = embedded::<D>(&gradient[held.node * D..]);
            let pulled = -slack.speed * blocks[held.node].trace() / 3.0;
            let before = changed;
            for (k, multiplier) in held.multipliers(&force) {
                if held.conditions[k].holds == Holds::Now && multiplier < pulled {
                    held.conditions[k].holds = Holds::NotNow;
                    changed += 1;
                }
            }
            let released = changed > before;
            for condition in &mut held.conditions {
                let broken = condition.normal.dot(&velocity) < condition.target - slack.speed;
                if !released && condition.holds == Holds::NotNow && broken {
                    condition.holds = Holds::Now;
                    changed += 1;
                }
            }
            if changed > before {
                held.update();
            }
        }
        changed
    }
}
