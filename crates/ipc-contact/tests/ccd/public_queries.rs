//! The sample queries with rational ground truth published with B. Wang et al. (2021), which are not part of the
//! repository: `CCD_QUERIES_DIR` names their folder.

use crate::oracle::{self, Truth};
use crate::planted::{Pair, Query};
use crate::statistics::Statistics;
use crate::{BOTH, ask, settings};
use mechanics_core::tensor::Vec3;
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, ToPrimitive};
use std::io::Write;
use std::path::Path;

/// A file holds eight rows a query, three fractions a row and the answer.
fn read(path: &Path, pair: Pair) -> Vec<(Query, bool)> {
    let text = std::fs::read_to_string(path).unwrap();
    let rows: Vec<Vec<BigInt>> = text.lines().map(|line| line.split(',').map(number).collect()).collect();
    rows.chunks(8)
        .map(|rows| {
            let points: Vec<Vec3> =
                rows.iter().map(|row| Vec3::from_fn(|c, _| quotient(&row[2 * c..]))).collect();
            let [start, end] = [0, 4].map(|k| points[k..k + 4].try_into().unwrap());
            let query = Query { pair, start, end, contact: f64::NAN, separation: 0.0, family: "public" };
            (query, rows[0][6].is_one())
        })
        .collect()
}

fn number(text: &str) -> BigInt {
    text.trim().parse().unwrap()
}

/// A fraction that f64 can hold.
fn quotient(fraction: &[BigInt]) -> f64 {
    let exact = BigRational::new(fraction[0].clone(), fraction[1].clone());
    let rounded = exact.to_f64().unwrap();
    assert_eq!(BigRational::from_float(rounded).unwrap(), exact, "not a double");
    rounded
}

/// Says it past the test harness, which shows what a test prints only if it fails: the gate counts these lines.
fn skipped(reason: &str) {
    std::io::stderr().write_all(format!("\nSKIPPED ({reason})\n").as_bytes()).unwrap();
}

#[test]
fn public_queries_are_answered() {
    let Some(folder) = std::env::var_os("CCD_QUERIES_DIR") else {
        skipped("public queries: CCD_QUERIES_DIR is not set");
        return;
    };
    let mut queries = Vec::new();
    for (name, pair) in [("vertex-face", Pair::PointTriangle), ("edge-edge", Pair::EdgeEdge)] {
        let files = std::fs::read_dir(Path::new(&folder).join("unit-tests").join(name)).unwrap();
        queries.extend(files.flat_map(|file| read(&file.unwrap().path(), pair)));
    }
    assert!(!queries.is_empty());
    for detection in BOTH {
        for kept_gap in [0.1, 1e-6] {
            let mut statistics = Statistics::default();
            for (query, touches) in &queries {
                // The set says whether, the oracle says when.
                let truth = match (oracle::contact(query.pair, &query.start, &query.end), touches) {
                    (Truth::Undecided, true) => Truth::Contact([0.0, 1.0]),
                    (Truth::Undecided, false) => Truth::Free,
                    (truth, _) => truth,
                };
                assert_eq!(truth != Truth::Free, *touches, "the oracle contradicts the set: {query:?}");
                let (impact, time) = ask(query, &settings(detection, kept_gap));
                statistics.add(impact, &truth, time);
                assert_eq!(statistics.missed, 0, "{impact:?} {truth:?} {query:?}");
            }
            statistics.print(&format!("public, {detection:?}, {kept_gap:e}"));
        }
    }
}
