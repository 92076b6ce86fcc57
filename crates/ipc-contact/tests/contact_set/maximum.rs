//! Area weights with the improved maximum operator.

use crate::energy::{self, barrier};
use crate::peers::{self, PeerScene};
use crate::reference::{candidates_of, mesh_of};
use ipc_contact::collision_mesh::CollisionMesh;
use ipc_contact::contact_set::{ContactSet, Weighting};
use ipc_contact::distance::{EdgeEdgeMollifier, edge_edge, point_edge, point_triangle};
use mechanics_core::tensor::Vec3;
use std::collections::BTreeMap;

/// Two curved sheets, one turned by 0.3 rad, so that no edges are parallel.
fn turned_sheets() -> PeerScene {
    let n = 9;
    let grid = |k: usize| (0.1 * (k / n) as f64, 0.1 * (k % n) as f64);
    let (sine, cosine) = 0.3_f64.sin_cos();
    let lower = (0..n * n).map(grid).map(|(x, y)| Vec3::new(x, y, 0.004 * (7.0 * x + 3.0 * y).sin()));
    let upper = (0..n * n).map(grid).map(|(x, y)| {
        let height = 0.03 + 0.006 * (5.0 * x - 8.0 * y).cos();
        Vec3::new(cosine * x - sine * y + 0.1137, sine * x + cosine * y - 0.0871, height)
    });
    let start: Vec<Vec3> = lower.chain(upper).collect();
    let mut triangles = peers::sheet(n, 0);
    triangles.extend(peers::sheet(n, (n * n) as u32));
    PeerScene { end: start.clone(), start, triangles, activation_distance: 0.06 }
}

/// Features of a triangle mesh around each other, from its triangles alone.
struct Topology {
    triangles_of_edge: BTreeMap<[u32; 2], i32>,
    triangles_of_point: BTreeMap<u32, i32>,
    edges_of_point: BTreeMap<u32, Vec<[u32; 2]>>,
}

impl Topology {
    fn new(triangles: &[[u32; 3]]) -> Self {
        let mut topology = Self {
            triangles_of_edge: BTreeMap::new(),
            triangles_of_point: BTreeMap::new(),
            edges_of_point: BTreeMap::new(),
        };
        for &[a, b, c] in triangles {
            for point in [a, b, c] {
                *topology.triangles_of_point.entry(point).or_default() += 1;
            }
            for [a, b] in [[a, b], [b, c], [c, a]] {
                *topology.triangles_of_edge.entry([a.min(b), a.max(b)]).or_default() += 1;
            }
        }
        for &edge in topology.triangles_of_edge.keys() {
            for end in edge {
                topology.edges_of_point.entry(end).or_default().push(edge);
            }
        }
        topology
    }

    /// 1 − [n_v − Σ (m_e − 1)].
    fn corner_coefficient(&self, point: u32) -> i32 {
        let surplus = |edge: &[u32; 2]| self.triangles_of_edge[edge] - 1;
        1 - self.triangles_of_point[&point] + self.edges_of_point[&point].iter().map(surplus).sum::<i32>()
    }
}

/// The sum of barriers by its definition: every feature of one sheet with every one of the other, by bounded distances.
/// Points and edges apart.
fn by_definition(scene: &PeerScene, mesh: &CollisionMesh) -> [f64; 2] {
    let (x, activation) = (&scene.start, scene.activation_distance.powi(2));
    let topology = Topology::new(&scene.triangles);
    let half = x.len() as u32 / 2;
    let facing = |a: u32, b: u32| (a < half) != (b < half);
    let b = |squared: f64| barrier(squared, activation)[0];
    let at = |p: u32| x[p as usize];
    let mut of_points = 0.0;
    for &p in mesh.vertices() {
        let mut sum = 0.0;
        for &[i, j, k] in scene.triangles.iter().filter(|t| facing(p, t[0])) {
            sum += b(point_triangle(&[p, i, j, k].map(at)));
        }
        for (&[i, j], &count) in topology.triangles_of_edge.iter().filter(|(e, _)| facing(p, e[0])) {
            sum -= f64::from(count - 1) * b(point_edge(&[p, i, j].map(at)));
        }
        for &v in mesh.vertices().iter().filter(|&&v| facing(p, v)) {
            sum += f64::from(topology.corner_coefficient(v)) * b((at(v) - at(p)).norm_squared());
        }
        of_points += 0.25 * mesh.point_area(p) * sum;
    }
    let mut of_edges = 0.0;
    for (edge, &[i, j]) in (0..).zip(mesh.edges()) {
        let mollifier = |other: &[u32; 2]| {
            let points = [i, j, other[0], other[1]];
            EdgeEdgeMollifier::from_rest(&points.map(|p| mesh.rest()[p as usize])).value(&points.map(at))
        };
        let mut sum = 0.0;
        for other in mesh.edges().iter().filter(|e| facing(i, e[0])) {
            sum += mollifier(other) * b(edge_edge(&[i, j, other[0], other[1]].map(at)));
        }
        for (&v, edges) in topology.edges_of_point.iter().filter(|(v, _)| facing(i, **v)) {
            let count = edges.iter().map(mollifier).sum::<f64>();
            sum -= (count - 1.0) * b(point_edge(&[v, i, j].map(at)));
        }
        of_edges += 0.25 * mesh.edge_area(edge) * sum;
    }
    [of_points, of_edges]
}

fn area_weighted(scene: &PeerScene, mesh: &CollisionMesh) -> ContactSet {
    let activation = scene.activation_distance.powi(2);
    ContactSet::new(mesh, &candidates_of(scene, mesh), &scene.start, activation, Weighting::Area)
}

/// Two equal flat grids on each other: every edge has a parallel one. Moved by up to `jitter` aside.
fn aligned_sheets(gap: f64, jitter: f64) -> PeerScene {
    let n = 5;
    let wave = |k: usize, phase: f64| jitter * (37.0 * k as f64 + phase).sin();
    let point = |k: usize, height: f64| {
        let (x, y) = ((k / n) as f64, (k % n) as f64);
        Vec3::new(x + wave(k, height), y + wave(k, 1.0 + height), height + 0.1 * wave(k, 2.0 + height))
    };
    let start: Vec<Vec3> = [0.0, gap].iter().flat_map(|&h| (0..n * n).map(move |k| point(k, h))).collect();
    let mut triangles = peers::sheet(n, 0);
    triangles.extend(peers::sheet(n, (n * n) as u32));
    PeerScene { end: start.clone(), start, triangles, activation_distance: 0.1 }
}

#[test]
fn the_area_weighted_set_sums_to_its_definition() {
    let aligned = |gap| aligned_sheets(gap, 0.0);
    let nearly = |gap| aligned_sheets(gap, 0.003);
    for scene in [turned_sheets(), aligned(0.05), aligned(0.001), nearly(0.05), nearly(0.005)] {
        let mesh = mesh_of(&scene);
        let set = area_weighted(&scene, &mesh);
        let found = energy::sums(&set, &scene.start, scene.activation_distance.powi(2)).value;
        let expected: f64 = by_definition(&scene, &mesh).iter().sum();
        assert!(found > 0.0 && (found / expected - 1.0).abs() < 1e-11, "{found} instead of {expected}");
    }
}

/// Over the corners, edges and triangles of flat sheets the points' part is exactly half of ½ ∫ b over both sheets: here
/// both are right over each other, at their boundary, too.
#[test]
fn over_equal_sheets_points_count_each_area_once_and_edges_twice() {
    let scene = aligned_sheets(0.02, 0.0);
    let mesh = mesh_of(&scene);
    let b = barrier(0.02 * 0.02, 0.01)[0];
    let [of_points, of_edges] = by_definition(&scene, &mesh);
    assert!((of_points / (0.5 * 16.0 * b) - 1.0).abs() < 1e-12);
    // The edges' quadrature loses the parallel partner, which joins the neighbourhoods of its two ends: they count apart.
    assert!((of_edges / (0.5 * 16.0 * b) - 2.0).abs() < 1e-12);
}

/// ipctk 1.6.1 (area weights, IMPROVED_MAX_APPROX, the squared-distance barrier) adds b(p, v) for corners v at the boundary,
/// too, where two triangles less one edge count once already; with that added, its figure and ours agree.
#[test]
fn without_parallel_edges_the_sum_is_that_of_the_reference_library_but_for_boundary_corners() {
    let scene = turned_sheets();
    let mesh = mesh_of(&scene);
    let activation = scene.activation_distance.powi(2);
    let ours = energy::sums(&area_weighted(&scene, &mesh), &scene.start, activation).value;
    let topology = Topology::new(&scene.triangles);
    let boundary =
        |v: u32| topology.edges_of_point[&v].iter().any(|edge| topology.triangles_of_edge[edge] == 1);
    let mut surplus = 0.0;
    for p in 0..162_u32 {
        for v in (0..162).filter(|&v| (p < 81) != (v < 81) && boundary(v)) {
            let squared = (scene.start[p as usize] - scene.start[v as usize]).norm_squared();
            surplus += 0.25 * mesh.point_area(p) * barrier(squared, activation)[0];
        }
    }
    assert!(surplus > 0.01 * ours);
    assert!(((ours + surplus) / 1.071_773_368_375_434_6e-5 - 1.0).abs() < 1e-11);
}

/// Nearly parallel edges subtract with their mollifier: the gradient of the whole sum is that of its value.
#[test]
fn the_sum_has_the_gradient_of_its_value_next_to_parallel_edges() {
    let scene = aligned_sheets(0.01, 0.003);
    let mesh = mesh_of(&scene);
    let activation = scene.activation_distance.powi(2);
    let candidates = candidates_of(&scene, &mesh);
    let sums = |x: &[Vec3]| {
        energy::sums(&ContactSet::new(&mesh, &candidates, x, activation, Weighting::Area), x, activation)
    };
    let direction: Vec<Vec3> = (0..scene.start.len())
        .map(|k| Vec3::new((3.0 * k as f64).sin(), (5.0 * k as f64).cos(), (7.0 * k as f64).sin()))
        .collect();
    let slope: f64 = sums(&scene.start).gradient.iter().map(|(&p, g)| g.dot(&direction[p as usize])).sum();
    // The curvature jumps where closest features change, so the error is of the order h only.
    let at = |h: f64| {
        let x: Vec<Vec3> = scene.start.iter().zip(&direction).map(|(x, d)| x + d * h).collect();
        sums(&x).value
    };
    let h = 1e-7;
    let difference = (at(h) - at(-h)) / (2.0 * h);
    assert!((slope - difference).abs() < 1e-5 * slope.abs(), "{slope} {difference}");
}
