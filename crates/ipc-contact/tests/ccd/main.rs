//! Continuous collision detection against exact arithmetic.
//!
//! `CCD_QUERIES=1000000` asks for more queries than usual, `CCD_QUERIES_DIR` names the folder of a public set of
//! queries with known answers.
#![allow(clippy::unwrap_used)]

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
        assert_eq!(statistics.missed, 0, "{impact:?} {settings:?} {query:?}");
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
    for (kept_gap, name) in [(0.9, "0.9 of the gap kept"), (1e-6, "1e-6 of the gap kept")] {
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
    let pair = if random.bits() % 2 == 0 { Pair::PointTriangle } else { Pair::EdgeEdge };
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
