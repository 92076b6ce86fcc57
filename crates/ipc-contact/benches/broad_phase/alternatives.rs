//! Other ways to find overlapping boxes, on the same boxes with the same filter and the same sorted answer.

use ipc_contact::collision_mesh::CollisionMesh;
use mechanics_core::tensor::Vec3;
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy, BvhWorkspace};
use std::collections::HashMap;

/// A box.
#[derive(Clone, Copy)]
pub struct Bounds {
    low: Vec3,
    high: Vec3,
}

impl Bounds {
    fn overlaps(&self, other: &Self) -> bool {
        (0..3).all(|k| self.low[k] <= other.high[k] && other.low[k] <= self.high[k])
    }

    fn aabb(&self) -> Aabb {
        let vector = |v: &Vec3| Vector::new(v.x, v.y, v.z);
        Aabb::new(vector(&self.low), vector(&self.high))
    }
}

/// Boxes of all vertices, edges and triangles.
pub struct Boxes {
    pub points: Vec<Bounds>,
    pub edges: Vec<Bounds>,
    pub triangles: Vec<Bounds>,
}

impl Boxes {
    /// Of features on their way.
    pub fn new(mesh: &CollisionMesh, x0: &[Vec3], x1: &[Vec3], inflation: f64) -> Self {
        let point = |p: u32| {
            let (a, b) = (x0[p as usize], x1[p as usize]);
            Bounds { low: a.inf(&b).add_scalar(-inflation), high: a.sup(&b).add_scalar(inflation) }
        };
        let points: Vec<Bounds> = (0..mesh.point_count() as u32).map(point).collect();
        let union = |corners: &[u32]| {
            corners[1..].iter().fold(points[corners[0] as usize], |b, &p| Bounds {
                low: b.low.inf(&points[p as usize].low),
                high: b.high.sup(&points[p as usize].high),
            })
        };
        let edges = mesh.edges().iter().map(|e| union(e)).collect();
        let triangles = mesh.triangles().iter().map(|t| union(t)).collect();
        Self { points, edges, triangles }
    }
}

/// Pairs of points and triangles, and of edges.
pub type Found = [Vec<[u32; 2]>; 2];

fn sorted(mut pairs: Vec<[u32; 2]>) -> Vec<[u32; 2]> {
    pairs.sort_unstable();
    pairs
}

/// parry's trees: one of edges, one of triangles.
pub struct Parry {
    edges: Bvh,
    triangles: Bvh,
    workspace: BvhWorkspace,
}

impl Parry {
    /// Two trees, binned.
    pub fn build(boxes: &Boxes) -> Self {
        let tree = |boxes: &[Bounds]| {
            Bvh::from_iter(BvhBuildStrategy::Binned, boxes.iter().enumerate().map(|(k, b)| (k, b.aabb())))
        };
        Self {
            edges: tree(&boxes.edges),
            triangles: tree(&boxes.triangles),
            workspace: BvhWorkspace::default(),
        }
    }

    /// New boxes in the old trees.
    pub fn refit(&mut self, boxes: &Boxes) {
        for (tree, boxes) in [(&mut self.edges, &boxes.edges), (&mut self.triangles, &boxes.triangles)] {
            for (k, b) in boxes.iter().enumerate() {
                tree.insert_or_update_partially(b.aabb(), k as u32, 0.0);
            }
            tree.refit(&mut self.workspace);
        }
    }

    /// Points one by one against the triangles; edges one by one against the edges.
    pub fn query(&self, mesh: &CollisionMesh, boxes: &Boxes) -> Found {
        let mut found = Found::default();
        for &p in mesh.vertices() {
            for t in self.triangles.intersect_aabb(&boxes.points[p as usize].aabb()) {
                if mesh.features_may_touch(&[p], &mesh.triangles()[t as usize]) {
                    found[0].push([p, t]);
                }
            }
        }
        for (e, b) in (0..).zip(&boxes.edges) {
            for f in self.edges.intersect_aabb(&b.aabb()) {
                if e < f && mesh.features_may_touch(&mesh.edges()[e as usize], &mesh.edges()[f as usize]) {
                    found[1].push([e, f]);
                }
            }
        }
        found.map(sorted)
    }

    /// Both trees at once: edges against edges from the root down.
    pub fn query_pairs(&self, mesh: &CollisionMesh, boxes: &Boxes) -> Found {
        let mut found = Found::default();
        for &p in mesh.vertices() {
            for t in self.triangles.intersect_aabb(&boxes.points[p as usize].aabb()) {
                if mesh.features_may_touch(&[p], &mesh.triangles()[t as usize]) {
                    found[0].push([p, t]);
                }
            }
        }
        for (e, f) in self.edges.leaf_pairs(&self.edges, |a, b| a.intersects(b)) {
            if e < f && mesh.features_may_touch(&mesh.edges()[e as usize], &mesh.edges()[f as usize]) {
                found[1].push([e, f]);
            }
        }
        found.map(sorted)
    }
}

/// Sort along the axis on which the boxes are spread most; sweep.
pub fn sweep(mesh: &CollisionMesh, boxes: &Boxes) -> Found {
    let axis = widest(&boxes.edges);
    let order = |b: &[Bounds]| {
        let mut order: Vec<u32> = (0..b.len() as u32).collect();
        order.sort_unstable_by(|&i, &j| b[i as usize].low[axis].total_cmp(&b[j as usize].low[axis]));
        order
    };
    let mut found = Found::default();
    let edges = order(&boxes.edges);
    for (k, &e) in edges.iter().enumerate() {
        let b = &boxes.edges[e as usize];
        for &f in &edges[k + 1..] {
            let c = &boxes.edges[f as usize];
            if c.low[axis] > b.high[axis] {
                break;
            }
            if b.overlaps(c) && mesh.features_may_touch(&mesh.edges()[e as usize], &mesh.edges()[f as usize])
            {
                found[1].push([e.min(f), e.max(f)]);
            }
        }
    }
    let (points, triangles) = (order(&boxes.points), order(&boxes.triangles));
    let mut add = |p: u32, t: u32| {
        if boxes.points[p as usize].overlaps(&boxes.triangles[t as usize])
            && mesh.features_may_touch(&[p], &mesh.triangles()[t as usize])
        {
            found[0].push([p, t]);
        }
    };
    let (mut first_triangle, mut first_point) = (0, 0);
    for &p in &points {
        let b = &boxes.points[p as usize];
        while first_triangle < triangles.len()
            && boxes.triangles[triangles[first_triangle] as usize].low[axis] < b.low[axis]
        {
            first_triangle += 1;
        }
        let after = triangles[first_triangle..].iter();
        after
            .take_while(|&&t| boxes.triangles[t as usize].low[axis] <= b.high[axis])
            .for_each(|&t| add(p, t));
    }
    for &t in &triangles {
        let b = &boxes.triangles[t as usize];
        while first_point < points.len()
            && boxes.points[points[first_point] as usize].low[axis] <= b.low[axis]
        {
            first_point += 1;
        }
        let after = points[first_point..].iter();
        after.take_while(|&&p| boxes.points[p as usize].low[axis] <= b.high[axis]).for_each(|&p| add(p, t));
    }
    found.map(sorted)
}

fn widest(boxes: &[Bounds]) -> usize {
    let low = boxes.iter().map(|b| b.low).reduce(|a, b| a.inf(&b)).unwrap_or_default();
    let high = boxes.iter().map(|b| b.low).reduce(|a, b| a.sup(&b)).unwrap_or_default();
    (high - low).imax()
}

/// A hash grid whose cells are as large as the mean edge box's longest side, doubled.
pub fn grid(mesh: &CollisionMesh, boxes: &Boxes) -> Found {
    let side = boxes.edges.iter().map(|b| (b.high - b.low).max()).sum::<f64>() / boxes.edges.len() as f64;
    let cell = |x: &Vec3| x.map(|c| (c / (2.0 * side)).floor() as i32);
    let fill = |boxes: &[Bounds]| {
        let mut cells: HashMap<[i32; 3], Vec<u32>> = HashMap::new();
        for (k, b) in (0..).zip(boxes) {
            visit(&cell(&b.low), &cell(&b.high), |c| cells.entry(c).or_default().push(k));
        }
        cells
    };
    let mut found = Found::default();
    let edges = fill(&boxes.edges);
    for members in edges.values() {
        for (k, &e) in members.iter().enumerate() {
            for &f in &members[k + 1..] {
                let (b, c) = (&boxes.edges[e as usize], &boxes.edges[f as usize]);
                if b.overlaps(c)
                    && mesh.features_may_touch(&mesh.edges()[e as usize], &mesh.edges()[f as usize])
                {
                    found[1].push([e, f]);
                }
            }
        }
    }
    let triangles = fill(&boxes.triangles);
    for &p in mesh.vertices() {
        let b = &boxes.points[p as usize];
        visit(&cell(&b.low), &cell(&b.high), |c| {
            for &t in triangles.get(&c).map_or(&[][..], |m| m) {
                if b.overlaps(&boxes.triangles[t as usize])
                    && mesh.features_may_touch(&[p], &mesh.triangles()[t as usize])
                {
                    found[0].push([p, t]);
                }
            }
        });
    }
    found.map(|mut pairs| {
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    })
}

fn visit(low: &nalgebra::Vector3<i32>, high: &nalgebra::Vector3<i32>, mut each: impl FnMut([i32; 3])) {
    for x in low.x..=high.x {
        for y in low.y..=high.y {
            for z in low.z..=high.z {
                each([x, y, z]);
            }
        }
    }
}
