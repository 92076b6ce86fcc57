//! Time of continuous collision detection: all candidates of two stacked height fields, query by query and as a whole,
//! and single queries of degenerate families.
//!
//! `cargo bench -p ipc-contact --bench ccd`
//!
//! The height fields are those of `shared/peers/scenes.py` (`cloth100`), on which ipctk 1.6.1 finds 68,178 and
//! 241,160 candidates and takes 0.36 µs (additive) and 6.1 µs (tight inclusion) a candidate on a quiet core.

#![allow(clippy::print_stdout, reason = "a benchmark prints")]
#![allow(dead_code, reason = "the bench uses a part of the tests' modules")]

#[path = "../tests/ccd/planted.rs"]
mod planted;
#[path = "../tests/ccd/random.rs"]
mod random;

#[path = "../../mechanics-core/benches/timing/timing.rs"]
mod timing;

use ipc_contact::ccd::{self, Detection, Impact, Pairs, Settings};
use mechanics_core::parallel;
use mechanics_core::tensor::Vec3;
use planted::{FAMILIES, Pair, Query};
use random::Random;
use std::hint::black_box;
use std::time::Instant;
use timing::median;

/// Interleaved repeats, of which the median counts.
const REPEATS: usize = 7;

struct Scene {
    x: Vec<Vec3>,
    p: Vec<Vec3>,
    edges: Vec<[u32; 2]>,
    triangles: Vec<[u32; 3]>,
    point_triangles: Vec<[u32; 2]>,
    edge_edges: Vec<[u32; 2]>,
}

impl Scene {
    fn pairs(&self) -> Pairs<'_> {
        Pairs {
            edges: &self.edges,
            triangles: &self.triangles,
            point_triangles: &self.point_triangles,
            edge_edges: &self.edge_edges,
            ..Pairs::default()
        }
    }

    fn count(&self) -> usize {
        self.point_triangles.len() + self.edge_edges.len()
    }
}

/// Numbers in [0, 1), as `scenes.py` makes them.
fn noise(count: usize, seed: u64) -> Vec<f64> {
    let mut random = Random(seed);
    (0..count).map(|_| (random.bits() >> 11) as f64 * 0.5_f64.powi(53)).collect()
}

/// Two n × n height fields, the upper one moving down by about 2 d̂.
fn cloth(n: usize) -> Scene {
    let (activation, spacing, points) = (1e-3, 1.0 / (n - 1) as f64, n * n);
    let [lower, upper, down, aside, along] = [1, 2, 3, 4, 5].map(|seed| noise(points, seed));
    let height = |x: f64, y: f64| 0.02 * (5.0 * x).sin() * (4.0 * y).cos();
    let at = |k: usize| ((k / n) as f64 * spacing, (k % n) as f64 * spacing);
    let mut x = Vec::new();
    x.extend((0..points).map(|k| {
        let (a, b) = at(k);
        Vec3::new(a, b, height(a, b) + 0.1 * activation * (2.0 * lower[k] - 1.0))
    }));
    x.extend((0..points).map(|k| {
        let (a, b) = (at(k).0 + 0.37 * spacing, at(k).1 + 0.21 * spacing);
        Vec3::new(a, b, height(a, b) + 0.3 * activation + 0.1 * activation * (2.0 * upper[k] - 1.0))
    }));
    let mut p = vec![Vec3::zeros(); points];
    p.extend((0..points).map(|k| {
        let sideways = |noise: f64| 0.1 * spacing * (2.0 * noise - 1.0);
        Vec3::new(sideways(aside[k]), sideways(along[k]), -2.0 * activation * (0.8 + 0.4 * down[k]))
    }));
    let triangles: Vec<[u32; 3]> = (0..2).flat_map(|sheet| grid(n, sheet * points)).collect();
    let mut edges: Vec<[u32; 2]> = triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    edges.sort_unstable();
    edges.dedup();
    let point_triangles =
        overlapping(&x, &p, &(0..2 * points as u32).map(|i| [i]).collect::<Vec<_>>(), &triangles);
    let edge_edges = overlapping(&x, &p, &edges, &edges).into_iter().filter(|[e, f]| e < f).collect();
    Scene { x, p, edges, triangles, point_triangles, edge_edges }
}

fn grid(n: usize, offset: usize) -> impl Iterator<Item = [u32; 3]> {
    let corner = move |k: usize| {
        let a = (k / (n - 1)) * n + k % (n - 1) + offset;
        [a, a + n, a + n + 1, a + 1].map(|i| i as u32)
    };
    let cells: Vec<[u32; 4]> = (0..(n - 1) * (n - 1)).map(corner).collect();
    let halves = [[0, 1, 2], [0, 2, 3]];
    halves
        .into_iter()
        .flat_map(move |half| cells.iter().map(|cell| half.map(|k| cell[k])).collect::<Vec<_>>())
}

/// Pairs of features without a common point whose swept boxes overlap, found by sorting along the first axis.
fn overlapping<const N: usize, const M: usize>(
    x: &[Vec3],
    p: &[Vec3],
    a: &[[u32; N]],
    b: &[[u32; M]],
) -> Vec<[u32; 2]> {
    let (first, second) = (swept_boxes(x, p, a), swept_boxes(x, p, b));
    let mut order: Vec<usize> = (0..b.len()).collect();
    order.sort_by(|&i, &j| second[i].0.x.total_cmp(&second[j].0.x));
    let widest = second.iter().map(|(low, high)| high.x - low.x).fold(0.0, f64::max);
    let mut pairs = Vec::new();
    for (i, (low, high)) in first.iter().enumerate() {
        let from = order.partition_point(|&j| second[j].0.x < low.x - widest);
        for &j in order[from..].iter().take_while(|&&j| second[j].0.x <= high.x) {
            let apart = (0..3).any(|c| second[j].0[c] > high[c] || low[c] > second[j].1[c]);
            if !apart && !a[i].iter().any(|point| b[j].contains(point)) {
                pairs.push([i as u32, j as u32]);
            }
        }
    }
    pairs.sort_unstable();
    pairs
}

fn swept_boxes<const N: usize>(x: &[Vec3], p: &[Vec3], features: &[[u32; N]]) -> Vec<(Vec3, Vec3)> {
    let ends = |i: &u32| [x[*i as usize], x[*i as usize] + p[*i as usize]];
    let corners = |feature: &[u32; N]| feature.iter().flat_map(ends).collect::<Vec<_>>();
    let bounds = |all: Vec<Vec3>| {
        all.iter().fold((all[0], all[0]), |(low, high), point| (low.inf(point), high.sup(point)))
    };
    features.iter().map(|feature| bounds(corners(feature))).collect()
}

/// Seconds that a fixed loop of dependent multiplications takes: how fast the machine is at the moment.
fn calibration() -> f64 {
    let start = Instant::now();
    let mut x = black_box(1.0_f64);
    for _ in 0..10_000_000 {
        x = x * 0.999_999 + 1e-6;
    }
    black_box(x);
    start.elapsed().as_secs_f64()
}

fn whole_mesh(scene: &Scene, additive: &Settings, interval: &Settings) {
    let run = |settings: &Settings, threads: usize| {
        let start = Instant::now();
        let answer =
            parallel::with_threads(threads, || ccd::limit(&scene.pairs(), &scene.x, &scene.p, 0.0, settings));
        (start.elapsed().as_secs_f64() * 1e9 / scene.count() as f64, answer.0)
    };
    let mut times = [(); 4].map(|()| Vec::new());
    for _ in 0..REPEATS {
        for (k, threads) in [1, 2].into_iter().enumerate() {
            times[k].push(run(additive, threads).0);
        }
        let start = Instant::now();
        black_box(alone(scene, additive));
        times[2].push(start.elapsed().as_secs_f64() * 1e9 / scene.count() as f64);
        times[3].push(calibration());
    }
    let [one, two, alone, loop_time] = times.map(median);
    println!(
        "two sheets: {} point-triangle and {} edge-edge candidates",
        scene.point_triangles.len(),
        scene.edge_edges.len()
    );
    println!(
        "  additive, the limit of the mesh      {one:8.1} ns a candidate (two threads {two:.1}), fraction {:.4}",
        run(additive, 1).1
    );
    println!("  additive, every query to its end     {alone:8.1} ns a candidate");
    let (time, fraction) = run(interval, 1);
    println!("  interval, the limit of the mesh      {time:8.1} ns a candidate, fraction {fraction:.4}");
    println!("  calibration loop                     {:8.3} ns a turn", loop_time * 100.0);
}

/// Every candidate on its own: the smallest fraction.
fn alone(scene: &Scene, settings: &Settings) -> f64 {
    let mut least: f64 = 1.0;
    let at = |i: u32| [scene.x[i as usize], scene.x[i as usize] + scene.p[i as usize]];
    for &[i, k] in &scene.point_triangles {
        let [a, b, c] = scene.triangles[k as usize];
        let points = [i, a, b, c].map(at);
        least = least
            .min(ccd::point_triangle(&points.map(|p| p[0]), &points.map(|p| p[1]), 0.0, settings).fraction());
    }
    for &[e, f] in &scene.edge_edges {
        let ([a, b], [c, d]) = (scene.edges[e as usize], scene.edges[f as usize]);
        let points = [a, b, c, d].map(at);
        least =
            least.min(ccd::edge_edge(&points.map(|p| p[0]), &points.map(|p| p[1]), 0.0, settings).fraction());
    }
    least
}

fn ask(query: &Query, settings: &Settings) -> Impact {
    match query.pair {
        Pair::PointPoint | Pair::PointEdge | Pair::PointTriangle => {
            ccd::point_triangle(&query.start, &query.end, query.separation, settings)
        }
        Pair::EdgeEdge => ccd::edge_edge(&query.start, &query.end, query.separation, settings),
    }
}

/// Mean, 99 % and worst time of a family; each query counts with its fastest of five, so that what the machine does
/// beside does not count as ours.
fn family(name: &'static str, count: u64, settings: &Settings) {
    let mut times = Vec::new();
    for seed in 0..count {
        let query = planted::query(name, seed).of_four_points();
        let time = |_| {
            let start = Instant::now();
            black_box(ask(black_box(&query), settings));
            start.elapsed().as_secs_f64() * 1e6
        };
        times.push((0..5).map(time).fold(f64::INFINITY, f64::min));
    }
    times.sort_by(f64::total_cmp);
    let mean = times.iter().sum::<f64>() / times.len() as f64;
    let (most, worst) = (times[times.len() * 99 / 100], times[times.len() - 1]);
    println!("  {name:20} mean {mean:8.3} µs, 99 % {most:9.3}, worst {worst:9.2}");
}

fn main() {
    let additive = Settings::default();
    let interval = Settings { detection: Detection::Interval, ..additive };
    whole_mesh(&cloth(100), &additive, &interval);
    for (title, settings, count) in [
        ("additive, 0.1 of the gap kept (bars: mean 5 µs, worst 100 µs)", additive, 4000),
        ("additive, 1e-6 of the gap kept", Settings { kept_gap: 1e-6, ..additive }, 4000),
        ("interval, 0.1 of the gap kept", interval, 40),
    ] {
        println!("planted contacts, {title}");
        for name in FAMILIES {
            family(name, count, &settings);
        }
    }
}
