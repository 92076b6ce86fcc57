//! Continuous collision detection against exact arithmetic.
#![allow(clippy::unwrap_used)]

mod planted;
mod random;

use ipc_contact::ccd::{self, Impact, Settings};
use planted::{FAMILIES, Pair, Query};
use std::time::Instant;

fn ask(query: &Query, settings: &Settings) -> Impact {
    match query.pair {
        Pair::PointTriangle => ccd::point_triangle(&query.start, &query.end, query.separation, settings),
        Pair::EdgeEdge => ccd::edge_edge(&query.start, &query.end, query.separation, settings),
    }
}

/// How many queries a test makes: more when `CCD_QUERIES` asks.
fn count(usual: u64) -> u64 {
    std::env::var("CCD_QUERIES").ok().and_then(|n| n.parse().ok()).unwrap_or(usual)
}

#[test]
fn no_planted_contact_is_missed() {
    let per_family = count(100_000) / FAMILIES.len() as u64 + 1;
    let settings = Settings::default();
    for family in FAMILIES {
        let (mut missed, mut close, mut times) = (0, 0, Vec::new());
        for seed in 0..per_family {
            let query = planted::query(family, seed);
            let start = Instant::now();
            let impact = ask(&query, &settings);
            times.push(start.elapsed().as_secs_f64() * 1e6);
            match impact {
                Impact::Free => missed += 1,
                Impact::At(t) => missed += u64::from(t > query.contact),
                Impact::StartsTooClose { .. } => close += 1,
                Impact::NonFinite => panic!("{query:?}"),
            }
            assert_eq!(missed, 0, "{seed}: {impact:?} {query:?}");
        }
        times.sort_by(f64::total_cmp);
        println!(
            "{family:20} {per_family} queries, {missed} missed, {close} start too close; mean {:.2} µs, 99 % {:.2}, worst {:.1}",
            times.iter().sum::<f64>() / per_family as f64,
            times[per_family as usize * 99 / 100],
            times[per_family as usize - 1]
        );
    }
}
