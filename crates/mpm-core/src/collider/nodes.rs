//! Colliders acting on nodes, and what blocks of nodes remember of them.

use super::motion::Moment;
use super::sheet::{NEUTRAL, Sheets, Sides};
use super::surface::{SignedDistance, TriangleSurface};
use super::{ColliderShape, Impulse, PlacedCollider};
use crate::boundary::Surface;
use crate::neighbourhood::{NODE, block_edge};
use mechanics_core::lanes::Element;
use mechanics_core::tensor::Vec3;

/// A place in the frame of a collider, and how it lies to the surface.
#[derive(Clone, Copy, Debug)]
struct Seen {
    place: Vec3,
    found: SignedDistance,
}

impl Seen {
    /// Looks a place up, no farther than it can be.
    fn look(surface: &TriangleSurface, place: &Vec3, before: Option<&Self>) -> Self {
        let within = before.map_or(f64::INFINITY, |seen| seen.found.distance.abs() + seen.moved(place));
        Self { place: *place, found: surface.signed_distance(place, within) }
    }

    fn moved(&self, place: &Vec3) -> f64 {
        (place - self.place).norm()
    }
}

/// What a block of nodes remembers of a collider, and what it gave to it in the last step.
#[derive(Clone, Debug, Default)]
pub(crate) struct BlockMemory {
    middle: Option<Seen>,
    nodes: Vec<Option<Seen>>,
    pub(crate) load: Impulse,
}

/// A place inside of a solid or on it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Touch {
    /// Its number.
    pub(crate) collider: usize,
    pub(crate) surface: Surface,
    /// Outward.
    pub(crate) normal: Vec3,
    /// Of the collider at the place \[m/s\].
    pub(crate) velocity: Vec3,
}

/// Of the radius of a block and of distances, what is left to rounding \[cells\].
const MARGIN: f64 = 1e-6;

/// The colliders at the end of a step.
pub(crate) struct ColliderStage<'a> {
    colliders: &'a [PlacedCollider],
    moments: Vec<Moment>,
    spacing: f64,
}

impl<'a> ColliderStage<'a> {
    pub(crate) fn new(colliders: &'a [PlacedCollider], time: f64, spacing: f64) -> Self {
        let moments = colliders.iter().map(|collider| collider.moment(time)).collect();
        Self { colliders, moments, spacing }
    }

    /// Whether there are none.
    pub(crate) fn is_empty(&self) -> bool {
        self.colliders.is_empty()
    }

    /// The solids that a place is inside of or on.
    pub(crate) fn touches(&self, place: &Vec3) -> impl Iterator<Item = Touch> {
        self.colliders.iter().zip(&self.moments).enumerate().filter_map(|(number, (collider, moment))| {
            let ColliderShape::Solid(solid) = &collider.collider.shape else { return None };
            let found = solid.0.signed_distance(&moment.placement.point_at(place), f64::INFINITY);
            (found.distance <= 0.0).then(|| Touch {
                collider: number,
                surface: collider.collider.surface,
                normal: moment.placement.rotation * found.normal,
                velocity: moment.velocity_at(place),
            })
        })
    }

    /// Acts on the nodes with mass of the block at `origin`.
    ///
    /// Answers how many places were looked up.
    pub(crate) fn act<E: Element, const D: usize>(
        &self,
        origin: &[i32; D],
        nodes: &mut [E],
        memories: &mut Vec<BlockMemory>,
    ) -> u64 {
        let mut queries = 0;
        memories.resize_with(self.colliders.len(), BlockMemory::default);
        for ((collider, moment), memory) in self.colliders.iter().zip(&self.moments).zip(memories) {
            memory.load = Impulse::default();
            if let ColliderShape::Solid(solid) = &collider.collider.shape
                && self.is_near(&solid.0, moment, origin, memory, &mut queries)
            {
                queries += self.act_as_solid(collider, moment, origin, nodes, memory);
            }
        }
        queries
    }

    /// Lets sheets act on the nodes with mass of a block that exists for particles of some sides; answers how many nodes that are.
    pub(crate) fn act_as_sheets<E: Element, const D: usize>(
        &self,
        sheets: &Sheets<'_>,
        sides: Sides,
        origin: &[i32; D],
        nodes: &mut [E],
        memories: &mut [BlockMemory],
    ) -> u64 {
        let mut queries = 0;
        if sides == NEUTRAL {
            return queries;
        }
        for (k, node) in nodes.chunks_exact_mut(NODE).enumerate() {
            if node[0].less_equal(E::default()) {
                continue;
            }
            queries += 1;
            let place = self.place(origin, k);
            let before = Vec3::from_fn(|a, _| node[1 + a].into());
            let mass: f64 = node[0].into();
            let after = sheets.constrain(&place, sides, &before, |collider, change| {
                memories[collider].load.add(&Impulse::at(&place, change * mass));
            });
            for a in 0..3 {
                node[1 + a] = E::constant(after[a]);
            }
        }
        queries
    }

    /// Where node `k` of a block is.
    fn place<const D: usize>(&self, origin: &[i32; D], k: usize) -> Vec3 {
        let edge = block_edge(D);
        let local = |axis: usize| (k / edge.pow((D - 1 - axis) as u32) % edge) as f64;
        Vec3::from_fn(|a, _| origin.get(a).map_or(0.0, |block| self.coordinate(*block, D, local(a))))
    }

    /// Whether a node of a block may be inside.
    fn is_near<const D: usize>(
        &self,
        surface: &TriangleSurface,
        moment: &Moment,
        origin: &[i32; D],
        memory: &mut BlockMemory,
        queries: &mut u64,
    ) -> bool {
        let half = 0.5 * (block_edge(D) - 1) as f64;
        let middle = Vec3::from_fn(|a, _| origin.get(a).map_or(0.0, |o| self.coordinate(*o, D, half)));
        let point = moment.placement.point_at(&middle);
        let radius = (half * (D as f64).sqrt() + MARGIN) * self.spacing;
        if memory.middle.is_some_and(|seen| seen.found.distance > seen.moved(&point) + radius) {
            return false;
        }
        *queries += 1;
        let seen = Seen::look(surface, &point, memory.middle.as_ref());
        memory.middle = Some(seen);
        seen.found.distance <= radius
    }

    fn coordinate(&self, block: i32, dimension: usize, node: f64) -> f64 {
        (f64::from(block) * block_edge(dimension) as f64 + node) * self.spacing
    }

    fn act_as_solid<E: Element, const D: usize>(
        &self,
        collider: &PlacedCollider,
        moment: &Moment,
        origin: &[i32; D],
        nodes: &mut [E],
        memory: &mut BlockMemory,
    ) -> u64 {
        let mut queries = 0;
        let surface = collider.collider.shape.triangles();
        let count = nodes.len() / NODE;
        memory.nodes.resize(count, None);
        for (k, node) in nodes.chunks_exact_mut(NODE).enumerate() {
            if node[0].less_equal(E::default()) {
                continue;
            }
            let place = self.place(origin, k);
            let point = moment.placement.point_at(&place);
            let seen = match &memory.nodes[k] {
                Some(seen) if seen.place == point => *seen,
                Some(seen) if seen.found.distance > seen.moved(&point) + MARGIN * self.spacing => continue,
                before => {
                    queries += 1;
                    Seen::look(surface, &point, before.as_ref())
                }
            };
            memory.nodes[k] = Some(seen);
            if seen.found.distance <= 0.0 {
                let normal = moment.placement.rotation * seen.found.normal;
                memory.load.add(&constrain(collider, moment, &place, &normal, node));
            }
        }
        queries
    }
}

/// Lets a collider act on a node; answers what it takes from the node.
fn constrain<E: Element>(
    collider: &PlacedCollider,
    moment: &Moment,
    place: &Vec3,
    normal: &Vec3,
    node: &mut [E],
) -> Impulse {
    let own = moment.velocity_at(place);
    let before = Vec3::from_fn(|a, _| node[1 + a].into());
    let relative = collider.collider.surface.relative(&(before - own).into(), &(*normal).into());
    let after = (Vec3::from(relative) + own).map(E::constant);
    for a in 0..3 {
        node[1 + a] = after[a];
    }
    let mass: f64 = node[0].into();
    Impulse::at(place, (before - after.map(Into::into)) * mass)
}

/// What blocks remember, for the blocks of a grid that was made anew: both lists of blocks ascend.
pub(crate) fn carried_over<const D: usize>(
    before: &[[i32; D]],
    memories: Vec<Vec<BlockMemory>>,
    after: &[[i32; D]],
) -> Vec<Vec<BlockMemory>> {
    let mut old = before.iter().zip(memories).peekable();
    let carry = |block: &[i32; D]| {
        while old.next_if(|(before, _)| *before < block).is_some() {}
        old.next_if(|(before, _)| *before == block).map(|(_, memory)| memory).unwrap_or_default()
    };
    after.iter().map(carry).collect()
}
