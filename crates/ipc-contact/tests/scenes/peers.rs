//! The contact scenes that other systems are measured on, regenerated from their definition in the peers' scripts.
//!
//! Noise is splitmix64, so it has the same bits in any language; sines may differ in their last bit.
#![allow(dead_code, unreachable_pub, reason = "each test and bench that includes this uses a part of it")]

use ipc_contact::collision_mesh::{CollisionMesh, CollisionMeshBuilder, CollisionObject};
use mechanics_core::tensor::Vec3;
use std::collections::HashMap;

/// Triangles at the start and at the end of a step, and the distance at which contact begins.
pub struct PeerScene {
    /// Positions at the start \[m\].
    pub start: Vec<Vec3>,
    /// Positions at the end \[m\].
    pub end: Vec<Vec3>,
    /// Triangles.
    pub triangles: Vec<[u32; 3]>,
    /// d̂ \[m\].
    pub activation_distance: f64,
}

impl PeerScene {
    /// The scene as one object.
    pub fn mesh(&self) -> CollisionMesh {
        let mut builder = CollisionMeshBuilder::new(&self.start);
        builder.add_object(CollisionObject::new(self.triangles.clone()));
        builder.build().expect("the scenes are valid")
    }
}

/// Entry `i` of the noise with this seed, in [0, 1).
pub fn noise(i: usize, seed: u64) -> f64 {
    let mut z = seed.wrapping_add((i as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15));
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^= z >> 31;
    (z >> 11) as f64 * 2.0_f64.powi(-53)
}

/// Noise in [−1, 1).
fn symmetric(i: usize, seed: u64) -> f64 {
    2.0 * noise(i, seed) - 1.0
}

fn grid_faces(n: u32, offset: u32) -> Vec<[u32; 3]> {
    let cells = || (0..n - 1).flat_map(move |i| (0..n - 1).map(move |j| i * n + j + offset));
    cells().map(|a| [a, a + n, a + n + 1]).chain(cells().map(|a| [a, a + n + 1, a + 1])).collect()
}

/// Two n × n height fields over the unit square, a gap of 0.3 d̂ ± 0.1 d̂ apart, the upper one shifted in its plane; at the end it
/// is 2 d̂ (± 20 %) lower, with a jitter in the plane.
pub fn cloth(n: u32) -> PeerScene {
    let (activation_distance, seed) = (1e-3, 1);
    let (h, count) = (1.0 / f64::from(n - 1), (n * n) as usize);
    let height = |x: f64, y: f64| 0.02 * (5.0 * x).sin() * (4.0 * y).cos();
    let place = |k: usize| (f64::from(k as u32 / n) * h, f64::from(k as u32 % n) * h);
    let mut start = Vec::with_capacity(2 * count);
    for k in 0..count {
        let (x, y) = place(k);
        start.push(Vec3::new(x, y, height(x, y) + 0.1 * activation_distance * symmetric(k, seed)));
    }
    for k in 0..count {
        let (x, y) = place(k);
        let (x, y) = (x + 0.37 * h, y + 0.21 * h);
        let gap = 0.3 * activation_distance + 0.1 * activation_distance * symmetric(k, seed + 1);
        start.push(Vec3::new(x, y, height(x, y) + gap));
    }
    let mut end = start.clone();
    for k in 0..count {
        let down = -2.0 * activation_distance * (0.8 + 0.4 * noise(k, seed + 2));
        end[count + k] += Vec3::new(0.1 * h * symmetric(k, seed + 3), 0.1 * h * symmetric(k, seed + 4), down);
    }
    let mut triangles = grid_faces(n, 0);
    triangles.extend(grid_faces(n, n * n));
    PeerScene { start, end, triangles, activation_distance }
}

/// The unit icosahedron, subdivided.
fn icosphere(subdivisions: usize) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let t = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let corners = [
        [-1.0, t, 0.0],
        [1.0, t, 0.0],
        [-1.0, -t, 0.0],
        [1.0, -t, 0.0],
        [0.0, -1.0, t],
        [0.0, 1.0, t],
        [0.0, -1.0, -t],
        [0.0, 1.0, -t],
        [t, 0.0, -1.0],
        [t, 0.0, 1.0],
        [-t, 0.0, -1.0],
        [-t, 0.0, 1.0],
    ];
    let mut points: Vec<Vec3> = corners.iter().map(|&c| Vec3::from(c) / (1.0 + t * t).sqrt()).collect();
    let mut triangles: Vec<[u32; 3]> = vec![
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    for _ in 0..subdivisions {
        let mut middles: HashMap<[u32; 2], u32> = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                let sum = points[a as usize] + points[b as usize];
                points.push(sum / sum.norm());
                points.len() as u32 - 1
            })
        };
        let mut finer = Vec::with_capacity(4 * triangles.len());
        for &[a, b, c] in &triangles {
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            finer.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    (points, triangles)
}

/// The rotation of a uniformly distributed quaternion, from three numbers in [0, 1).
fn rotation([u, v, w]: [f64; 3]) -> [Vec3; 3] {
    let turn = 2.0 * std::f64::consts::PI;
    let (x, y) = ((1.0 - u).sqrt() * (turn * v).sin(), (1.0 - u).sqrt() * (turn * v).cos());
    let (z, w) = (u.sqrt() * (turn * w).sin(), u.sqrt() * (turn * w).cos());
    [
        Vec3::new(1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)),
        Vec3::new(2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)),
        Vec3::new(2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)),
    ]
}

/// k³ icospheres with six flat caps each, packed on a cubic lattice so that the caps nearly touch; at the end the pack is 3 % smaller,
/// with a jitter of 0.2 d̂.
pub fn spheres(k: usize) -> PeerScene {
    let (activation_distance, seed) = (0.02, 7);
    let (ball, faces) = icosphere(3);
    let pitch = 2.0 * 0.97 + 0.3 * activation_distance;
    let (mut start, mut triangles) = (Vec::new(), Vec::new());
    for s in 0..k * k * k {
        let rows = rotation(std::array::from_fn(|i| noise(3 * s + i, seed)));
        let cell = Vec3::new((s / (k * k)) as f64, (s / k % k) as f64, (s % k) as f64) * pitch;
        start.extend(ball.iter().map(|p| {
            Vec3::from(std::array::from_fn::<f64, 3, _>(|i| rows[i].dot(p).clamp(-0.97, 0.97))) + cell
        }));
        let first = (s * ball.len()) as u32;
        triangles.extend(faces.iter().map(|t| t.map(|p| p + first)));
    }
    let centre = start.iter().sum::<Vec3>() / start.len() as f64;
    let jitter = |i: usize| 0.2 * activation_distance * symmetric(i, seed + 1);
    let moved = |(i, p): (usize, &Vec3)| {
        p + (p - centre) * -0.03 + Vec3::new(jitter(3 * i), jitter(3 * i + 1), jitter(3 * i + 2))
    };
    let end = start.iter().enumerate().map(moved).collect();
    PeerScene { start, end, triangles, activation_distance }
}
