//! The active pairs at one x: energy, derivatives, normal forces.

use super::report::{CloseFeatures, ContactCounts};
use crate::barrier::Barrier;
use crate::broad_phase::Candidates;
use crate::collision_mesh::{CollisionMesh, Feature};
use crate::contact_set::{ContactPairs, ContactSet, EdgeEdgeContacts, Weighting};
use crate::distance::Region;
use crate::normal_force::NormalForce;
use crate::pair::{
    EdgeEdgePairs, HalfSpacePairs, PairLaw, PointEdgePairs, PointPointPairs, PointTrianglePairs,
};
use mechanics_core::parallel;
use mechanics_core::projection::Projection;
use mechanics_core::sparse::Assembler;
use mechanics_core::stencil::StencilLists;
use mechanics_core::tensor::Vec3;

/// A contact set, laid out for the sums.
#[derive(Clone, Debug, Default)]
pub(super) struct ActivePairs {
    set: ContactSet,
    /// Of each point near a half-space.
    planes: Vec<(Vec3, f64)>,
}

type Law<'a> = PairLaw<'a, dyn Barrier>;

/// Normal forces found by one task.
const CHUNK: usize = 512;

impl ActivePairs {
    pub(super) fn new(
        mesh: &CollisionMesh,
        candidates: &Candidates,
        x: &[Vec3],
        activation_squared: f64,
        weighting: Weighting,
    ) -> Self {
        let set = ContactSet::new(mesh, candidates, x, activation_squared, weighting);
        let plane = |&number: &u32| {
            let plane = &mesh.half_spaces()[number as usize];
            (plane.normal, plane.offset)
        };
        let planes = set.half_space_numbers.iter().map(plane).collect();
        Self { set, planes }
    }

    pub(super) fn counts(&self) -> ContactCounts {
        ContactCounts {
            half_spaces: self.set.half_spaces.len(),
            point_points: self.set.point_points.len(),
            point_edges: self.set.point_edges.len(),
            point_triangles: self.set.point_triangles.len(),
            edge_edges: self.set.edge_edges.len(),
        }
    }

    /// The half-space of each point near one, in the order of the sums.
    pub(super) fn half_space_numbers(&self) -> &[u32] {
        &self.set.half_space_numbers
    }

    /// The smallest distance \[m\], NaN if any is.
    pub(super) fn smallest_distance(&self) -> Option<f64> {
        self.set.smallest_squared_distance().map(f64::sqrt)
    }

    /// Σ w κ m b \[J\].
    pub(super) fn value(&self, law: Law<'_>, x: &[Vec3]) -> f64 {
        // Infinities of both signs must not meet where weights are negative.
        let smallest = self.set.smallest_squared_distance();
        if smallest.is_some_and(|smallest| law.barrier.value(smallest) == f64::INFINITY) {
            return f64::INFINITY;
        }
        self.lists(law).value(x)
    }

    pub(super) fn add_gradient(&self, law: Law<'_>, x: &[Vec3], gradient: &mut [Vec3]) {
        self.lists(law).add_gradient(x, gradient);
    }

    pub(super) fn add_hessian(
        &self,
        law: Law<'_>,
        x: &[Vec3],
        projection: Projection,
        hessian: &mut Assembler<'_>,
    ) {
        self.lists(law).add_hessian(x, projection, hessian);
    }

    /// The pairs and what computes them: five lists, empty or not.
    fn lists<'a>(&'a self, law: Law<'a>) -> StencilLists<'a> {
        let ContactSet { half_spaces, point_points, point_edges, point_triangles, edge_edges, .. } =
            &self.set;
        let EdgeEdgeContacts { points, weights, mollifiers, regions } = edge_edges;
        StencilLists::new()
            .with(
                HalfSpacePairs { law, weights: &half_spaces.weights, planes: &self.planes },
                &half_spaces.points,
            )
            .with(PointPointPairs { law, weights: &point_points.weights }, &point_points.points)
            .with(PointEdgePairs { law, weights: &point_edges.weights }, &point_edges.points)
            .with(PointTrianglePairs { law, weights: &point_triangles.weights }, &point_triangles.points)
            .with(EdgeEdgePairs { law, weights, mollifiers, regions }, points)
    }

    /// One for each active pair, in the order of the sums.
    pub(super) fn normal_forces(&self, law: Law<'_>, x: &[Vec3]) -> Vec<NormalForce> {
        let none = NormalForce::new([0], [0.0], Vec3::zeros(), 0.0, 0.0);
        let mut forces = vec![none; self.counts().total()];
        let set = &self.set;
        let rest = fill(&mut forces, set.half_spaces.len(), |k| {
            let ([point], (normal, offset)) = (set.half_spaces.points[k], self.planes[k]);
            let distance = normal.dot(&x[point as usize]) - offset;
            let magnitude = push(law, set.half_spaces.weights[k], distance);
            NormalForce::new([point], [1.0], normal, distance, magnitude)
        });
        let rest = fill_with(law, &set.point_points, Region::PointPoint([0, 1]), x, rest);
        let rest = fill_with(law, &set.point_edges, Region::PointEdge([0, 1, 2]), x, rest);
        let rest = fill_with(law, &set.point_triangles, Region::PointTriangle([0, 1, 2, 3]), x, rest);
        let EdgeEdgeContacts { points, weights, mollifiers, regions } = &set.edge_edges;
        fill(rest, points.len(), |k| {
            let weight = weights[k] * mollifiers[k].value(&points[k].map(|point| x[point as usize]));
            normal_force(law, &points[k], weight, regions[k], x)
        });
        forces
    }

    /// All pairs at or within the minimum separation, by name.
    pub(super) fn infinite_pairs(
        &self,
        law: Law<'_>,
        mesh: &CollisionMesh,
        x: &[Vec3],
    ) -> Vec<CloseFeatures> {
        self.pairs_where(law, mesh, x, |pair| !barrier(law, pair).is_finite())
    }

    /// The pairs whose barrier, times κ and any weight that an active pair has, may alone or with the others' be more than a number can
    /// hold: by name.
    ///
    /// If a sum of n numbers overflows, one of them at least is 1/n of the largest number or more.
    pub(super) fn strongest_pairs(
        &self,
        law: Law<'_>,
        mesh: &CollisionMesh,
        x: &[Vec3],
    ) -> Vec<CloseFeatures> {
        let set = &self.set;
        let weights = [&set.half_spaces.weights, &set.point_points.weights, &set.point_edges.weights];
        let weights = weights.into_iter().chain([&set.point_triangles.weights, &set.edge_edges.weights]);
        let largest = weights.flatten().fold(0.0_f64, |largest, weight| largest.max(weight.abs()));
        let bound = f64::MAX / self.counts().total() as f64;
        self.pairs_where(law, mesh, x, |pair| barrier(law, pair) * law.stiffness * largest >= bound)
    }

    fn pairs_where(
        &self,
        law: Law<'_>,
        mesh: &CollisionMesh,
        x: &[Vec3],
        is_meant: impl Fn(&NormalForce) -> bool,
    ) -> Vec<CloseFeatures> {
        let forces = self.normal_forces(law, x);
        let names = Names::new(mesh);
        let edge_edges = forces.len() - self.counts().edge_edges;
        let meant = forces.iter().enumerate().filter(|(_, force)| is_meant(force));
        let features = |index: usize, force: &NormalForce| match *force.points() {
            [point] => [Feature::Point(point), Feature::HalfSpace(self.set.half_space_numbers[index])],
            [a, b] => [Feature::Point(a), Feature::Point(b)],
            [point, a, b] => [Feature::Point(point), names.edge(a, b)],
            [a, b, c, d] if index >= edge_edges => [names.edge(a, b), names.edge(c, d)],
            [point, a, b, c, ..] => [Feature::Point(point), names.triangle([a, b, c])],
            [] => unreachable!("a pair has points"),
        };
        meant.map(|(index, force)| CloseFeatures::new(mesh, features(index, force), force.distance)).collect()
    }
}

/// Numbers of features by their points.
struct Names<'a> {
    mesh: &'a CollisionMesh,
    /// Corners of all triangles, ascending, and which they are; ascending.
    triangles: Vec<([u32; 3], u32)>,
}

impl<'a> Names<'a> {
    fn new(mesh: &'a CollisionMesh) -> Self {
        let numbered =
            mesh.triangles().iter().zip(0..).map(|(corners, number)| (ascending(*corners), number));
        let mut triangles: Vec<([u32; 3], u32)> = numbered.collect();
        triangles.sort_unstable();
        Self { mesh, triangles }
    }

    fn edge(&self, a: u32, b: u32) -> Feature {
        let number = self.mesh.edges().binary_search(&[a.min(b), a.max(b)]).unwrap_or_default();
        Feature::Edge(number as u32)
    }

    fn triangle(&self, corners: [u32; 3]) -> Feature {
        let corners = ascending(corners);
        let found = self.triangles.binary_search_by_key(&corners, |(corners, _)| *corners);
        Feature::Triangle(found.map_or(0, |place| self.triangles[place].1))
    }
}

fn ascending(mut corners: [u32; 3]) -> [u32; 3] {
    corners.sort_unstable();
    corners
}

/// b of a pair.
fn barrier(law: Law<'_>, pair: &NormalForce) -> f64 {
    law.barrier.value(if pair.distance <= 0.0 { 0.0 } else { pair.distance * pair.distance })
}

/// −∂E/∂d = −w κ b′ ∂s/∂d \[N\].
fn push(law: Law<'_>, weight: f64, distance: f64) -> f64 {
    -weight * law.stiffness * law.barrier.first(distance * distance) * 2.0 * distance
}

fn normal_force<const N: usize>(
    law: Law<'_>,
    points: &[u32; N],
    weight: f64,
    region: Region,
    x: &[Vec3],
) -> NormalForce {
    let (difference, weights) = region.weights(&points.map(|point| x[point as usize]));
    let distance = difference.norm();
    NormalForce::new(*points, weights, difference / distance, distance, push(law, weight, distance))
}

/// Overwrites the first `count` forces, in parallel; answers the others.
fn fill(
    forces: &mut [NormalForce],
    count: usize,
    force: impl Fn(usize) -> NormalForce + Sync,
) -> &mut [NormalForce] {
    let (own, rest) = forces.split_at_mut(count);
    parallel::map_into(own, CHUNK, force);
    rest
}

fn fill_with<'a, const N: usize>(
    law: Law<'_>,
    pairs: &ContactPairs<N>,
    region: Region,
    x: &[Vec3],
    forces: &'a mut [NormalForce],
) -> &'a mut [NormalForce] {
    let ContactPairs { points, weights } = pairs;
    fill(forces, points.len(), |k| normal_force(law, &points[k], weights[k], region, x))
}
