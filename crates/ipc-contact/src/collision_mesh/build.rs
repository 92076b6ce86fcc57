//! From what a user states to a checked mesh.

use super::{
    CollisionMesh, CollisionObject, Feature, Filters, Groups, HalfSpace, NO_OBJECT, Objects, SelfContact,
    sorted, sorted_edges,
};
use crate::error::ContactError;
use mechanics_core::mesh::triangle_area_vector;
use mechanics_core::tensor::Vec3;

/// Collects what may touch and what may not; [`build`](Self::build) checks it.
#[derive(Clone, Debug)]
pub struct CollisionMeshBuilder {
    rest: Vec<Vec3>,
    objects: Vec<CollisionObject>,
    half_spaces: Vec<HalfSpace>,
    excluded_objects: Vec<[u32; 2]>,
    excluded_half_spaces: Vec<[u32; 2]>,
    joined_points: Vec<[u32; 2]>,
    scripted_points: Vec<u32>,
}

impl CollisionMeshBuilder {
    /// A mesh over the potential's points at rest \[m\]; as yet without features.
    pub fn new(rest: &[Vec3]) -> Self {
        Self {
            rest: rest.to_vec(),
            objects: Vec::new(),
            half_spaces: Vec::new(),
            excluded_objects: Vec::new(),
            excluded_half_spaces: Vec::new(),
            joined_points: Vec::new(),
            scripted_points: Vec::new(),
        }
    }

    /// Adds an object; answers its number: 0, 1, 2, ….
    pub fn add_object(&mut self, object: CollisionObject) -> u32 {
        self.objects.push(object);
        self.objects.len() as u32 - 1
    }

    /// Adds a half-space that all points with unknowns are kept out of; answers its number: 0, 1, 2, ….
    pub fn add_half_space(&mut self, half_space: HalfSpace) -> u32 {
        self.half_spaces.push(half_space);
        self.half_spaces.len() as u32 - 1
    }

    /// Two objects may not touch. Of an object and itself: as
    /// [`SelfContact::Excluded`](super::SelfContact::Excluded).
    pub fn exclude_objects(&mut self, a: u32, b: u32) -> &mut Self {
        self.excluded_objects.push(sorted([a, b]));
        self
    }

    /// A half-space lets an object pass.
    pub fn exclude_half_space(&mut self, half_space: u32, object: u32) -> &mut Self {
        self.excluded_half_spaces.push([half_space, object]);
        self
    }

    /// Two points count as one in the question which features are neighbours: a feature with the one never touches a
    /// feature with the other. For parts that are tied together without sharing points.
    pub fn join_points(&mut self, a: u32, b: u32) -> &mut Self {
        self.joined_points.push(sorted([a, b]));
        self
    }

    /// These points have no unknowns: their motion is prescribed. Pairs of only such points are left out.
    pub fn script_points(&mut self, points: impl IntoIterator<Item = u32>) -> &mut Self {
        self.scripted_points.extend(points);
        self
    }

    /// The checked mesh.
    ///
    /// # Errors
    /// Each names the culprit: a rest position that is not finite; a feature, filter or list that names a point,
    /// object or half-space that does not exist; a feature with a repeated point; two features that are the same
    /// (a loose segment that is a triangle's edge, a loose point that is another feature's corner); a point of two
    /// objects; an edge of zero length or a triangle of zero area at rest (or one too large or small for its area
    /// to be a number); loose parts of an object without a positive thickness; a half-space without a normal of
    /// length one.
    pub fn build(&self) -> Result<CollisionMesh, ContactError> {
        self.check_numbers()?;
        let triangles: Vec<[u32; 3]> =
            self.objects.iter().flat_map(|o| o.triangles.iter().copied()).collect();
        check_repeated_triangles(&triangles)?;
        let (edges, loose_edges) = self.edges(&triangles)?;
        let triangle_edges = triangle_edges(&triangles, &edges);
        let object_of_point = self.objects_of_points()?;
        let loose_points = self.loose_points(&triangles, &edges)?;
        let mut vertices: Vec<u32> = (0..self.rest.len() as u32).collect();
        vertices.retain(|&p| object_of_point[p as usize] != NO_OBJECT);
        let mut scripted = vec![false; self.rest.len()];
        self.scripted_points.iter().for_each(|&p| scripted[p as usize] = true);
        let mut mesh = CollisionMesh {
            rest: self.rest.clone(),
            vertices,
            edges,
            triangles,
            triangle_edges,
            loose_edges,
            loose_points,
            object_of_point,
            scripted,
            joined: both_ways(&self.joined_points),
            half_spaces: self.half_spaces.clone(),
            excluded_half_spaces: ascending(&self.excluded_half_spaces),
            objects: self.object_filters(),
            filters: self.filters(),
            point_area: Vec::new(),
            edge_area: Vec::new(),
        };
        (mesh.point_area, mesh.edge_area) = self.areas(&mesh)?;
        Ok(mesh)
    }

    /// Positions, numbers of points and objects, thicknesses and normals.
    fn check_numbers(&self) -> Result<(), ContactError> {
        let finite = |p: &Vec3| p.iter().all(|x| x.is_finite());
        if let Some(point) = self.rest.iter().position(|p| !finite(p)) {
            return Err(ContactError::NonFinite { point, position: self.rest[point].into() });
        }
        let (mut triangle, mut segment) = (0, 0);
        for object in &self.objects {
            for t in &object.triangles {
                self.check_points(Feature::Triangle(triangle), t)?;
                triangle += 1;
            }
            for s in &object.segments {
                // Until edges are numbered, a segment goes by its place among the segments.
                self.check_points(Feature::Edge(segment), s)?;
                segment += 1;
            }
            for &p in &object.points {
                self.check_points(Feature::Point(p), &[p])?;
            }
        }
        let named = self.joined_points.iter().flatten().chain(&self.scripted_points);
        named.copied().try_for_each(|p| self.check_points(Feature::Point(p), &[p]))?;
        self.check_objects()?;
        self.check_half_spaces()
    }

    fn check_points(&self, feature: Feature, corners: &[u32]) -> Result<(), ContactError> {
        for (k, &point) in corners.iter().enumerate() {
            if point as usize >= self.rest.len() {
                return Err(ContactError::PointOutOfRange { feature, point, points: self.rest.len() });
            }
            if corners[..k].contains(&point) {
                return Err(ContactError::RepeatedPoint { feature, point });
            }
        }
        Ok(())
    }

    fn check_objects(&self) -> Result<(), ContactError> {
        let count = self.objects.len();
        let named =
            self.excluded_objects.iter().flatten().chain(self.excluded_half_spaces.iter().map(|e| &e[1]));
        if let Some(&object) = named.clone().find(|&&o| o as usize >= count) {
            return Err(ContactError::ObjectOutOfRange { object, objects: count });
        }
        for (number, object) in self.objects.iter().enumerate() {
            let loose = !(object.segments.is_empty() && object.points.is_empty());
            let thickness = object.thickness.unwrap_or(0.0);
            if (loose || object.thickness.is_some()) && !(thickness > 0.0 && thickness.is_finite()) {
                return Err(ContactError::BadThickness {
                    object: number as u32,
                    thickness: object.thickness,
                });
            }
        }
        Ok(())
    }

    fn check_half_spaces(&self) -> Result<(), ContactError> {
        let count = self.half_spaces.len();
        if let Some(&[half_space, _]) = self.excluded_half_spaces.iter().find(|e| e[0] as usize >= count) {
            return Err(ContactError::HalfSpaceOutOfRange { half_space, half_spaces: count });
        }
        // A normal that was normalised elsewhere is off by a few units in the last place, not more.
        let good = |h: &HalfSpace| (h.normal.norm() - 1.0).abs() <= 1e-12 && h.offset.is_finite();
        match self.half_spaces.iter().position(|h| !good(h)) {
            None => Ok(()),
            Some(k) => {
                let HalfSpace { normal, offset } = self.half_spaces[k];
                Err(ContactError::BadHalfSpace { half_space: k as u32, normal: normal.into(), offset })
            }
        }
    }

    /// Unique edges, ascending, and the numbers of those that are loose.
    fn edges(&self, triangles: &[[u32; 3]]) -> Result<(Vec<[u32; 2]>, Vec<u32>), ContactError> {
        let mut edges: Vec<[u32; 2]> = triangles.iter().flat_map(sorted_edges).collect();
        edges.sort_unstable();
        edges.dedup();
        let of_triangles = edges.clone();
        let mut segments: Vec<[u32; 2]> =
            self.objects.iter().flat_map(|o| o.segments.iter().map(|&s| sorted(s))).collect();
        segments.sort_unstable();
        edges.extend_from_slice(&segments);
        edges.sort_unstable();
        if let Some(k) = edges.windows(2).position(|w| w[0] == w[1]) {
            return Err(ContactError::RepeatedSegment { points: edges[k] });
        }
        let is_loose = |e: &[u32; 2]| of_triangles.binary_search(e).is_err();
        let loose = (0..edges.len()).filter(|&k| is_loose(&edges[k])).map(|k| k as u32).collect();
        Ok((edges, loose))
    }

    fn objects_of_points(&self) -> Result<Vec<u32>, ContactError> {
        let mut object_of_point = vec![NO_OBJECT; self.rest.len()];
        for (number, object) in (0..).zip(&self.objects) {
            let points = object.triangles.iter().flatten().chain(object.segments.iter().flatten());
            for &point in points.chain(&object.points) {
                let owner = &mut object_of_point[point as usize];
                if *owner != NO_OBJECT && *owner != number {
                    return Err(ContactError::PointOfTwoObjects { point, objects: [*owner, number] });
                }
                *owner = number;
            }
        }
        Ok(object_of_point)
    }

    /// Loose points, ascending.
    fn loose_points(&self, triangles: &[[u32; 3]], edges: &[[u32; 2]]) -> Result<Vec<u32>, ContactError> {
        let mut points: Vec<u32> = self.objects.iter().flat_map(|o| o.points.iter().copied()).collect();
        points.sort_unstable();
        if let Some(w) = points.windows(2).find(|w| w[0] == w[1]) {
            let point = Feature::Point(w[0]);
            return Err(ContactError::RepeatedFeature { feature: point, earlier: point });
        }
        let mut loose = vec![false; self.rest.len()];
        points.iter().for_each(|&p| loose[p as usize] = true);
        let of_triangles = (0..).zip(triangles).flat_map(|(k, t)| t.map(|p| (p, Feature::Triangle(k))));
        let of_edges = (0..).zip(edges).flat_map(|(k, e)| e.map(|p| (p, Feature::Edge(k))));
        match of_triangles.chain(of_edges).find(|&(p, _)| loose[p as usize]) {
            Some((point, feature)) => Err(ContactError::LoosePointInUse { point, feature }),
            None => Ok(points),
        }
    }

    fn object_filters(&self) -> Objects {
        let mut excluded = ascending(&self.excluded_objects);
        let alone = |o: u32| excluded.binary_search(&[o, o]).is_ok();
        let with_itself = (0..).zip(&self.objects);
        let self_contact =
            with_itself.map(|(k, o)| if alone(k) { SelfContact::Excluded } else { o.self_contact }).collect();
        excluded.retain(|e| e[0] != e[1]);
        Objects { self_contact, groups: self.objects.iter().map(|o| o.groups).collect(), excluded }
    }

    /// Is there any filter?
    fn filters(&self) -> Filters {
        let open =
            |o: &CollisionObject| o.self_contact == SelfContact::Allowed && o.groups == Groups::default();
        let named = self.excluded_objects.len() + self.joined_points.len() + self.scripted_points.len();
        if named == 0 && self.objects.iter().all(open) { Filters::None } else { Filters::Some }
    }

    /// Rest areas of points and of edges.
    fn areas(&self, mesh: &CollisionMesh) -> Result<(Vec<f64>, Vec<f64>), ContactError> {
        let position = |p: u32| self.rest[p as usize];
        let measured = |feature, size: f64| match size > 0.0 && size.is_finite() {
            true => Ok(size),
            false => Err(ContactError::ZeroSize { feature, size }),
        };
        let mut point_area = vec![0.0; self.rest.len()];
        let mut edge_area = vec![0.0; mesh.edges.len()];
        for (k, e) in (0..).zip(&mesh.edges) {
            measured(Feature::Edge(k), (position(e[1]) - position(e[0])).norm())?;
        }
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            let area = triangle_area_vector(&triangle.map(position)).norm();
            let third = measured(Feature::Triangle(t as u32), area)? / 3.0;
            triangle.iter().for_each(|&p| point_area[p as usize] += third);
            mesh.triangle_edges[t].iter().for_each(|&e| edge_area[e as usize] += third);
        }
        let thickness = |p: u32| self.objects[mesh.object_of(p) as usize].thickness.unwrap_or(0.0);
        for &e in &mesh.loose_edges {
            let [a, b] = mesh.edges[e as usize];
            let area = (position(b) - position(a)).norm() * thickness(a);
            edge_area[e as usize] = measured(Feature::Edge(e), area)?;
            [a, b].iter().for_each(|&p| point_area[p as usize] += 0.5 * area);
        }
        for &p in &mesh.loose_points {
            point_area[p as usize] = measured(Feature::Point(p), thickness(p) * thickness(p))?;
        }
        Ok((point_area, edge_area))
    }
}

/// No two triangles over the same points, whatever their order.
fn check_repeated_triangles(triangles: &[[u32; 3]]) -> Result<(), ContactError> {
    let mut numbered: Vec<([u32; 3], u32)> = triangles
        .iter()
        .zip(0..)
        .map(|(&t, k)| {
            let mut corners = t;
            corners.sort_unstable();
            (corners, k)
        })
        .collect();
    numbered.sort_unstable();
    match numbered.windows(2).find(|w| w[0].0 == w[1].0) {
        None => Ok(()),
        Some(w) => {
            let [earlier, feature] = [w[0].1, w[1].1].map(Feature::Triangle);
            Err(ContactError::RepeatedFeature { feature, earlier })
        }
    }
}

/// The numbers of each triangle's edges.
fn triangle_edges(triangles: &[[u32; 3]], edges: &[[u32; 2]]) -> Vec<[u32; 3]> {
    // The point where an edge would be inserted is its place: every edge of a triangle is in the list.
    let number = |e: [u32; 2]| edges.partition_point(|other| *other < e) as u32;
    triangles.iter().map(|t| sorted_edges(t).map(number)).collect()
}

fn ascending(pairs: &[[u32; 2]]) -> Vec<[u32; 2]> {
    let mut pairs = pairs.to_vec();
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

fn both_ways(pairs: &[[u32; 2]]) -> Vec<[u32; 2]> {
    ascending(&pairs.iter().flat_map(|&[a, b]| [[a, b], [b, a]]).collect::<Vec<_>>())
}
