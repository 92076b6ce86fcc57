//! Continuous collision detection on queries whose first contact is known: time against earliness.

use crate::experiment::random::Random;
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Count;
use ipc_contact::ccd::{Detection, Impact, Settings, edge_edge, point_triangle};
use ipc_contact::distance::{edge_edge_closest, point_triangle_closest};
use mechanics_core::tensor::Vec3;
use nalgebra::Rotation3;
use schemars::JsonSchema;
use serde::Deserialize;

/// Points and triangles, and pairs of edges, that move and deform at random and meet at a time that is planted; as many that come
/// close without meeting. The ladder is the part of the gap that a query is to leave.
///
/// The one feature stays in a plane, whatever its points do in there; the other (a point, or an edge in a parallel plane) passes
/// through that plane at the planted time, at a planted place inside both. Before it the planes are apart, so the planted time
/// is that of the first contact. All is then turned, scaled and set in motion together at random.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct PlantedContacts {
    /// How many queries there are of each kind.
    queries: Count,
}

enum Features {
    PointTriangle,
    EdgeEdge,
}

struct Query {
    features: Features,
    start: [Vec3; 4],
    end: [Vec3; 4],
    /// When they meet; `None` if they do not.
    contact: Option<f64>,
    /// The distance of their planes at the end.
    left: f64,
}

fn uniform(random: &mut Random, low: f64, high: f64) -> f64 {
    low + (high - low) * 0.5 * (random.symmetric() + 1.0)
}

fn in_plane(random: &mut Random) -> Vec3 {
    Vec3::new(random.symmetric(), random.symmetric(), 0.0)
}

fn anywhere(random: &mut Random) -> Vec3 {
    in_plane(random) + Vec3::z() * random.symmetric()
}

/// A query whose planes are `gap` apart at the start and meet at a time in (0, 1), or are `left` of that apart at the end.
fn query(random: &mut Random, features: Features, left: Option<f64>) -> Query {
    let (at, gap) = (uniform(random, 0.05, 0.95), uniform(random, 0.1, 1.0));
    let inside = |random: &mut Random| uniform(random, 0.1, 0.9);
    // Which points are of the feature that passes through the plane, and where all are at the planted time.
    let (passing, place) = match features {
        Features::PointTriangle => {
            let [a, b, c] = [0; 3].map(|_| in_plane(random));
            let (s, t) = (inside(random), inside(random));
            (&[0][..], [a * (1.0 - s) + (b * (1.0 - t) + c * t) * s, a, b, c])
        }
        Features::EdgeEdge => {
            let [a, b, along] = [0; 3].map(|_| in_plane(random));
            let (s, t) = (inside(random), inside(random));
            let p = a + (b - a) * s;
            (&[2, 3][..], [a, b, p - along * t, p + along * (1.0 - t)])
        }
    };
    let heights = match left {
        None => [gap, gap * (1.0 - 1.0 / at)],
        Some(left) => [gap, gap * left],
    };
    let velocity = [0; 4].map(|_| in_plane(random));
    let lift = |i: usize, height: f64| if passing.contains(&i) { height } else { 0.0 };
    let turn = Rotation3::from_scaled_axis(anywhere(random) * 3.0);
    let scale = 10.0_f64.powf(3.0 * random.symmetric());
    let drift = [0; 2].map(|_| anywhere(random));
    let moved = |t: f64, k: usize| {
        [0, 1, 2, 3].map(|i| {
            let x = place[i] + velocity[i] * (t - at) + Vec3::z() * lift(i, heights[k]) + drift[k];
            turn * x * scale
        })
    };
    let [start, end] = [moved(0.0, 0), moved(1.0, 1)];
    Query { features, start, end, contact: left.is_none().then_some(at), left: heights[1] * scale }
}

impl Query {
    fn answer(&self, settings: &Settings) -> Impact {
        match self.features {
            Features::PointTriangle => point_triangle(&self.start, &self.end, 0.0, settings),
            Features::EdgeEdge => edge_edge(&self.start, &self.end, 0.0, settings),
        }
    }

    /// Whether all of the motion must be free: the planes stay farther apart than a part of the distance at the start.
    fn is_free(&self, kept_gap: f64) -> bool {
        let squared = match self.features {
            Features::PointTriangle => point_triangle_closest(&self.start).1,
            Features::EdgeEdge => edge_edge_closest(&self.start).1,
        };
        self.contact.is_none() && self.left > 1.000_001 * kept_gap * squared.sqrt()
    }
}

impl Experiment for PlantedContacts {
    fn methods(&self) -> &'static [&'static str] {
        &["additive", "interval"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let detection = if at.method == "interval" { Detection::Interval } else { Detection::Additive };
        let settings = Settings { detection, kept_gap: at.ladder, ..Settings::default() };
        let mut random = Random::new(6);
        let mut queries = Vec::new();
        for _ in 0..self.queries.value() {
            let left = uniform(&mut random, at.ladder, 1.0);
            for left in [None, Some(left)] {
                queries.push(query(&mut random, Features::PointTriangle, left));
                queries.push(query(&mut random, Features::EdgeEdge, left));
            }
        }
        queries.retain(|query| query.contact.is_some() || query.is_free(at.ladder));
        let answers: Vec<Impact> =
            clock.time(|| queries.iter().map(|query| query.answer(&settings)).collect());
        let [mut missed, mut stopped, mut planted] = [0_u64; 3];
        let [mut early, mut earliest] = [0.0_f64; 2];
        for (query, answer) in queries.iter().zip(&answers) {
            let fraction = answer.fraction();
            match query.contact {
                Some(time) => {
                    planted += 1;
                    missed += u64::from(fraction > time);
                    early += (time - fraction) / time;
                    earliest = earliest.max((time - fraction) / time);
                }
                None => stopped += u64::from(*answer != Impact::Free),
            }
        }
        Ok(Outcome::default()
            .count("queries", queries.len() as u64)
            .count("contacts planted", planted)
            .error("mean earliness", early / planted as f64)
            .error("largest earliness", earliest)
            .invariant("contacts missed", missed as f64)
            .invariant("near misses stopped", stopped as f64))
    }
}
