//! The contact scenes on which other systems are timed: two stacked height fields and packed spheres, with noise from
//! splitmix64, so that any language makes the same ones (the last bit may differ where a sine does).

use mechanics_core::tensor::{Mat3, Vec3};
use std::collections::HashMap;
use std::f64::consts::TAU;

/// A surface that moves.
pub(crate) struct PeerScene {
    /// Where the points are first \[m\].
    pub(crate) start: Vec<Vec3>,
    /// Where they want to be at the end of a step \[m\].
    pub(crate) end: Vec<Vec3>,
    /// The triangles.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Distance at which contact begins \[m\].
    pub(crate) activation_distance: f64,
}

/// `count` numbers in [0, 1).
fn noise(count: usize, seed: u64) -> Vec<f64> {
    let number = |i: u64| {
        let mut z = seed.wrapping_add(i.wrapping_mul(0x9E37_79B9_7F4A_7C15));
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^= z >> 31;
        (z >> 11) as f64 * (-53.0_f64).exp2()
    };
    (1..=count as u64).map(number).collect()
}

/// Two n × n height fields over the unit square, 0.3 d̂ ± 0.1 d̂ apart for d̂ = 1 mm; the upper one is to move down by
/// 2 d̂ ± 20 %.
pub(crate) fn cloth(n: usize) -> PeerScene {
    let activation_distance = 1e-3;
    let (spacing, count) = (1.0 / (n - 1) as f64, n * n);
    let [lower, upper, down, x_jitter, y_jitter] = [1, 2, 3, 4, 5].map(|seed| noise(count, seed));
    let height = |x: f64, y: f64| 0.02 * (5.0 * x).sin() * (4.0 * y).cos();
    let centred = |u: f64| 0.1 * activation_distance * (2.0 * u - 1.0);
    let grid = |k: usize| ((k / n) as f64 * spacing, (k % n) as f64 * spacing);
    let mut start: Vec<Vec3> = (0..count)
        .map(|k| {
            let (x, y) = grid(k);
            Vec3::new(x, y, height(x, y) + centred(lower[k]))
        })
        .collect();
    start.extend((0..count).map(|k| {
        let (x, y) = (grid(k).0 + 0.37 * spacing, grid(k).1 + 0.21 * spacing);
        Vec3::new(x, y, height(x, y) + 0.3 * activation_distance + centred(upper[k]))
    }));
    let mut end = start.clone();
    for k in 0..count {
        let aside = |u: f64| 0.1 * spacing * (2.0 * u - 1.0);
        let fall = -2.0 * activation_distance * (0.8 + 0.4 * down[k]);
        end[count + k] += Vec3::new(aside(x_jitter[k]), aside(y_jitter[k]), fall);
    }
    let mut triangles = sheet(n, 0);
    triangles.extend(sheet(n, count as u32));
    PeerScene { start, end, triangles, activation_distance }
}

/// The triangles of an n × n grid of points from number `first` on.
pub(crate) fn sheet(n: usize, first: u32) -> Vec<[u32; 3]> {
    let n = n as u32;
    let corners = (0..n - 1).flat_map(|i| (0..n - 1).map(move |j| first + i * n + j));
    let lower = corners.clone().map(|a| [a, a + n, a + n + 1]);
    lower.chain(corners.map(|a| [a, a + n + 1, a + 1])).collect()
}

/// A sphere of radius 1 from an icosahedron, every triangle split in four `subdivisions` times.
pub(crate) fn icosphere(subdivisions: usize) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let t = (1.0 + 5f64.sqrt()) / 2.0;
    let plane = |s: f64, u: f64| [s, u];
    let signs = [plane(-1.0, t), plane(1.0, t), plane(-1.0, -t), plane(1.0, -t)];
    let mut points: Vec<Vec3> = (0..3)
        .flat_map(|shift| signs.map(|[s, u]| [[s, u, 0.0], [0.0, s, u], [u, 0.0, s]][shift]))
        .map(|p| Vec3::from(p) / (1.0 + t * t).sqrt())
        .collect();
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
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                points.push((points[a as usize] + points[b as usize]).normalize());
                points.len() as u32 - 1
            })
        };
        let split = |[a, b, c]: [u32; 3]| {
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
        };
        triangles = triangles.into_iter().flat_map(split).collect();
    }
    (points, triangles)
}

/// The rotation of a uniformly random unit quaternion, from three numbers in [0, 1).
fn rotation(u: &[f64]) -> Mat3 {
    let (a, b) = ((1.0 - u[0]).sqrt(), u[0].sqrt());
    let [x, y, z, w] =
        [a * (TAU * u[1]).sin(), a * (TAU * u[1]).cos(), b * (TAU * u[2]).sin(), b * (TAU * u[2]).cos()];
    Mat3::new(
        1.0 - 2.0 * (y * y + z * z),
        2.0 * (x * y - z * w),
        2.0 * (x * z + y * w),
        2.0 * (x * y + z * w),
        1.0 - 2.0 * (x * x + z * z),
        2.0 * (y * z - x * w),
        2.0 * (x * z - y * w),
        2.0 * (y * z + x * w),
        1.0 - 2.0 * (x * x + y * y),
    )
}

/// k³ unit spheres of 1,280 triangles, each turned at random and flattened towards its six neighbours, 0.3 d̂ apart for
/// d̂ = 2 cm; the pack is to be compressed by 3 % and jittered.
pub(crate) fn spheres(k: usize) -> PeerScene {
    let activation_distance = 0.02;
    let (sphere, faces) = icosphere(3);
    let turns = noise(3 * k * k * k, 7);
    let pitch = 2.0 * 0.97 + 0.3 * activation_distance;
    let (mut start, mut triangles) = (Vec::new(), Vec::new());
    for s in 0..k * k * k {
        let turn = rotation(&turns[3 * s..3 * s + 3]);
        let centre = Vec3::new((s / (k * k)) as f64, (s / k % k) as f64, (s % k) as f64) * pitch;
        let first = start.len() as u32;
        start.extend(sphere.iter().map(|p| (turn * p).map(|c| c.clamp(-0.97, 0.97)) + centre));
        triangles.extend(faces.iter().map(|t| t.map(|p| p + first)));
    }
    let centre = start.iter().sum::<Vec3>() / start.len() as f64;
    let jitter = noise(3 * start.len(), 8);
    let moved = |(i, p): (usize, &Vec3)| {
        let aside = Vec3::from_fn(|c, _| 2.0 * jitter[3 * i + c] - 1.0) * (0.2 * activation_distance);
        p - (p - centre) * 0.03 + aside
    };
    let end = start.iter().enumerate().map(moved).collect();
    PeerScene { start, end, triangles, activation_distance }
}
