//! Continuous collision detection against exact arithmetic.
//!
//! `CCD_QUERIES=1000000` asks for more queries than usual, `CCD_QUERIES_DIR` names the folder of a public set of
//! queries with known answers.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test prints what it counted")]

mod hard_input;
mod oracle;
mod planted;
mod public_queries;
mod random;
mod statistics;
mod whole_mesh;

use ipc_contact::ccd::{self, Detection, Impact, Settings};
use mechanics_core::tensor::Vec3;
use oracle::Truth;
use planted::{FAMILIES, Pair, Query};
use random::Random;
use statistics::Statistics;
use std::time::Instant;

const BOTH: [Detection; 2] = [Detection::Additive, Detection::Interval];

fn settings(detection: Detection, kept_gap: f64) -> Settings {
    Settings { detection, kept_gap, ..Settings::default() }
}

/// The answer and the time it took in µs.
fn ask(query: &Query, settings: &Settings) -> (Impact, f64) {
    let start = Instant::now();
    let (from, to) = (&query.start, &query.end);
    let impact = match query.pair {
        Pair::PointPoint => {
            ccd::point_point(&[from[0], from[1]], &[to[0], to[1]], query.separation, settings)
        }
        Pair::PointEdge => {
            let [from, to] = [from, to].map(|x| [x[0], x[1], x[2]]);
            ccd::point_edge(&from, &to, query.separation, settings)
        }
        Pair::PointTriangle => ccd::point_triangle(&query.start, &query.end, query.separation, settings),
        Pair::EdgeEdge => ccd::edge_edge(&query.start, &query.end, query.separation, settings),
    };
    (impact, start.elapsed().as_secs_f64() * 1e6)
}

/// How many queries a test makes: more when `CCD_QUERIES` asks.
fn count(usual: u64) -> u64 {
    let factor =
        std::env::var("CCD_QUERIES").ok().and_then(|n| n.parse::<f64>().ok()).map_or(1.0, |n| n / 1e5);
    (usual as f64 * factor) as u64
}

/// Both methods on queries whose contact is known; the answer is no later than it.
fn no_contact_is_missed(name: &str, queries: impl Iterator<Item = Query>, settings: &Settings) {
    let mut statistics = Statistics::default();
    for query in queries {
        let (impact, time) = ask(&query, settings);
        statistics.add(impact, &Truth::Contact([query.contact; 2]), time);
        assert_eq!(statistics.missed, 0, "{}: {impact:?} {settings:?} {query:?}", query.family);
        if matches!(impact, Impact::StartsTooClose { .. }) {
            let query = query.clone().of_four_points();
            let across = (0..4).map(|k| (query.start[k] - query.start[0]).norm()).fold(0.0, f64::max);
            // The bound that is promised, and the rounding of the distance here.
            let is_close = |distance: f64| distance - query.separation <= 512.0 * f64::EPSILON * across;
            let exact = || oracle::inner_distance(query.pair, &query.start);
            assert!(
                is_close(distance(query.pair, &query.start)) || exact().is_some_and(is_close),
                "{query:?}"
            );
        }
    }
    statistics.print(name);
}

#[test]
fn additive_misses_no_planted_contact() {
    let each = count(100_000) / FAMILIES.len() as u64 + 1;
    for family in FAMILIES {
        let queries = (0..each).map(|seed| planted::query(family, seed));
        no_contact_is_missed(family, queries, &settings(Detection::Additive, 0.1));
    }
    // With nothing kept but the bound on rounding, answers touch the contact as closely as f64 can tell.
    for (kept_gap, name) in
        [(0.9, "0.9 of the gap kept"), (1e-6, "1e-6 of the gap kept"), (1e-18, "nothing kept")]
    {
        let queries = (0..each).map(|seed| planted::query(FAMILIES[seed as usize % FAMILIES.len()], !seed));
        no_contact_is_missed(name, queries, &settings(Detection::Additive, kept_gap));
    }
}

#[test]
fn interval_misses_no_planted_contact() {
    let each = count(10_000) / FAMILIES.len() as u64 + 1;
    for family in FAMILIES {
        let queries = (0..each).map(|seed| planted::query(family, seed));
        let settings = Settings { max_boxes: 1_000, ..settings(Detection::Interval, 0.1) };
        no_contact_is_missed(family, queries, &settings);
    }
}

/// A query near a planted one, moved so little that it may or may not touch.
fn near_miss(seed: u64) -> Query {
    let mut query = planted::query(FAMILIES[seed as usize % FAMILIES.len()], seed).of_four_points();
    let mut random = Random(seed);
    let size = query.start.iter().chain(&query.end).map(|p| p.amax()).fold(0.0, f64::max);
    let shift = size * 10.0_f64.powi(-random.integer(1, 17) as i32);
    for point in query.start.iter_mut().chain(&mut query.end) {
        *point += Vec3::from_fn(|_, _| shift * random.signed());
    }
    Query { separation: 0.0, ..query }
}

/// Two features at random, and a motion of their own size, or smaller.
fn at_random(seed: u64) -> Query {
    let mut random = Random(seed ^ 0xABCD);
    let pair = if random.one_in(2) { Pair::PointTriangle } else { Pair::EdgeEdge };
    let speed = 4.0_f64.powi(-random.integer(0, 3) as i32);
    let mut vector = || Vec3::from_fn(|_, _| random.signed());
    let start: [Vec3; 4] = std::array::from_fn(|_| vector());
    let end = start.map(|p| p + speed * vector());
    Query { pair, start, end, contact: f64::NAN, separation: 0.0, family: "at random" }
}

#[test]
fn answers_agree_with_exact_arithmetic() {
    for (name, query) in [("at random", at_random as fn(u64) -> Query), ("near miss", near_miss)] {
        let queries: Vec<Query> = (0..count(6_000)).map(query).collect();
        let truths: Vec<Truth> = queries.iter().map(|q| oracle::contact(q.pair, &q.start, &q.end)).collect();
        for detection in BOTH {
            let mut statistics = Statistics::default();
            let settings = Settings { max_boxes: 2_000, ..settings(detection, 1e-3) };
            for (query, truth) in queries.iter().zip(&truths) {
                let (impact, time) = ask(query, &settings);
                statistics.add(impact, truth, time);
                assert_eq!(statistics.missed, 0, "{impact:?} {truth:?} {query:?}");
            }
            statistics.print(&format!("{name}, {detection:?}"));
        }
    }
}

/// An earlier version laid every turning plane as far ahead as the secant said and crept when that was too far: hundreds
/// of advances for one in a thousand of these queries.
#[test]
fn no_query_runs_out_of_advances() {
    for kept_gap in [0.1, 1e-6] {
        for seed in 0..30_000 {
            let query = planted::query(FAMILIES[seed as usize % FAMILIES.len()], seed).of_four_points();
            let answer = |max_advances| {
                let settings = Settings { max_advances, ..settings(Detection::Additive, kept_gap) };
                ask(&query, &settings).0
            };
            // Where the gap itself is not far above rounding, planes can only creep.
            let across = (query.start[0] - query.start[2]).norm();
            if distance(query.pair, &query.start) > 256.0 * f64::EPSILON * across {
                assert_eq!(answer(100), answer(1_000_000), "{query:?}");
            }
        }
    }
}

/// Distance of two features in plain floating point: the least over corners, edges and, where the foot is inside, planes.
fn distance(pair: Pair, x: &[Vec3; 4]) -> f64 {
    let to_edge = |p: Vec3, a: Vec3, b: Vec3| {
        let e = b - a;
        let s = ((p - a).dot(&e) / e.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        (p - a - s * e).norm()
    };
    let [a, b, c, d] = *x;
    // The system of both parameters by Cramer's rule, and once more for what that leaves. NaN and anything outside are
    // no foot.
    let foot = |r: Vec3, e: Vec3, f: Vec3| {
        let (ee, ef, ff) = (e.norm_squared(), e.dot(&f), f.norm_squared());
        let determinant = ee * ff - ef * ef;
        let (mut s, mut t, mut left) = (0.0, 0.0, r);
        for _ in 0..2 {
            s += (ff * left.dot(&e) - ef * left.dot(&f)) / determinant;
            t += (ee * left.dot(&f) - ef * left.dot(&e)) / determinant;
            left = r - s * e - t * f;
        }
        (s, t, left.norm())
    };
    if pair == Pair::EdgeEdge {
        let rim = [to_edge(a, c, d), to_edge(b, c, d), to_edge(c, a, b), to_edge(d, a, b)];
        let (s, t, inner) = foot(c - a, b - a, c - d);
        let inside = (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t);
        rim.into_iter().fold(if inside { inner } else { f64::INFINITY }, f64::min)
    } else {
        let rim = [to_edge(a, b, c), to_edge(a, c, d), to_edge(a, d, b)];
        let (s, t, inner) = foot(a - b, c - b, d - b);
        let inside = s >= 0.0 && t >= 0.0 && s + t <= 1.0;
        rim.into_iter().fold(if inside { inner } else { f64::INFINITY }, f64::min)
    }
}

/// What [`Settings::kept_gap`] promises: at the answer more than half of the kept gap is left.
#[test]
fn the_gap_kept_is_what_was_asked_for() {
    for (kept_gap, d_min) in [(0.5, 0.0), (0.5, 1e-2), (0.1, 0.0), (0.1, 1e-2), (1e-3, 0.0), (1e-3, 1e-2)] {
        let (mut contacts, mut least) = (0, f64::INFINITY);
        for seed in 0..30_000 {
            let query = Query { separation: d_min, ..at_random(seed) };
            let gap = distance(query.pair, &query.start) - d_min;
            for detection in if seed.is_multiple_of(10) { &BOTH[..] } else { &BOTH[..1] } {
                let (Impact::At(t), _) = ask(&query, &settings(*detection, kept_gap)) else { continue };
                let x = std::array::from_fn(|k| (1.0 - t) * query.start[k] + t * query.end[k]);
                let part = (distance(query.pair, &x) - d_min) / gap / kept_gap;
                // The tolerance is what plain floating point makes of 1e-3 of a gap.
                assert!(part > 0.5 - 1e-6, "{part} of what should be kept, {query:?}");
                contacts += 1;
                least = least.min(part);
            }
        }
        println!(
            "{contacts} contacts, {kept_gap} of the gap to be kept, d_min {d_min}: {least:.3} of that is or more"
        );
        assert!(contacts > 100);
    }
}
