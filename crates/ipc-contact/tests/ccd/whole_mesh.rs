//! The limit of a mesh against its pairs one by one, for any number of threads.

use crate::planted::{self, FAMILIES, Pair, Query};
use crate::{BOTH, ask, settings};
use ipc_contact::ccd::{self, Culprit, Impact, Pairs};
use ipc_contact::collision_mesh::{Feature, HalfSpace};
use mechanics_core::parallel;
use mechanics_core::tensor::Vec3;

/// The points of many queries beside each other, every four of them a pair of its own.
struct Many {
    x: Vec<Vec3>,
    p: Vec<Vec3>,
    edges: Vec<[u32; 2]>,
    triangles: Vec<[u32; 3]>,
    point_triangles: Vec<[u32; 2]>,
    edge_edges: Vec<[u32; 2]>,
    queries: Vec<Query>,
}

fn many(count: u64) -> Many {
    let (mut x, mut p, mut edges, mut triangles) = (vec![], vec![], vec![], vec![]);
    let (mut point_triangles, mut edge_edges, mut queries) = (vec![], vec![], vec![]);
    let all = (0..count)
        .map(|seed| planted::query(FAMILIES[seed as usize % FAMILIES.len()], seed).of_four_points());
    for mut query in all.filter(|query| query.separation == 0.0) {
        let n = x.len() as u32;
        x.extend(query.start);
        p.extend((0..4).map(|k| query.end[k] - query.start[k]));
        query.end = std::array::from_fn(|k| query.start[k] + p[n as usize + k]);
        if query.pair == Pair::PointTriangle {
            point_triangles.push([n, triangles.len() as u32]);
            triangles.push([n + 1, n + 2, n + 3]);
        } else {
            edge_edges.push([edges.len() as u32, edges.len() as u32 + 1]);
            edges.extend([[n, n + 1], [n + 2, n + 3]]);
        }
        queries.push(query);
    }
    Many { x, p, edges, triangles, point_triangles, edge_edges, queries }
}

impl Many {
    fn pairs(&self) -> Pairs<'_> {
        Pairs {
            edges: &self.edges,
            triangles: &self.triangles,
            point_triangles: &self.point_triangles,
            edge_edges: &self.edge_edges,
            ..Pairs::default()
        }
    }
}

#[test]
fn the_limit_is_that_of_its_first_smallest_pair_for_any_number_of_threads() {
    // Pairs that start far enough apart for the rounding of positions of the whole mesh: those of one scale.
    let mut many = many(4000);
    let rounding = 8.0
        * f64::EPSILON
        * many.x.iter().zip(&many.p).map(|(x, p)| x.amax().max((x + p).amax())).fold(0.0, f64::max);
    let scale = |k: usize| many.x[k..k + 4].iter().map(|x| x.amax()).fold(0.0, f64::max);
    let keep = |k: &u32| scale(*k as usize) > 1e6 * rounding;
    many.point_triangles.retain(|[n, _]| keep(n));
    let first_point = |e: u32| many.edges[e as usize][0];
    many.edge_edges.retain(|[e, _]| keep(&first_point(*e)));
    for detection in BOTH {
        let settings = settings(detection, 0.1);
        let limit = |threads| {
            parallel::with_threads(threads, || ccd::limit(&many.pairs(), &many.x, &many.p, 0.0, &settings))
        };
        let answer = limit(1);
        for threads in [2, 3, 8] {
            let other = limit(threads);
            assert_eq!(other.0.to_bits(), answer.0.to_bits());
            assert_eq!(other.1, answer.1);
        }
        // One by one, without pruning.
        let one_by_one = many
            .point_triangles
            .iter()
            .map(|[n, k]| (*n, [Feature::Point(*n), Feature::Triangle(*k)]))
            .chain(
                many.edge_edges
                    .iter()
                    .map(|[e, f]| (first_point(*e), [Feature::Edge(*e), Feature::Edge(*f)])),
            )
            .map(|(n, features)| {
                let query = Query { separation: rounding, ..many.queries[n as usize / 4].clone() };
                Culprit { features, impact: ask(&query, &settings).0 }
            })
            .reduce(|a, b| if b.impact.fraction() < a.impact.fraction() { b } else { a });
        assert_eq!(answer.1, one_by_one);
    }
}

#[test]
fn the_culprit_is_named_and_nothing_in_the_way_means_one() {
    let x = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::new(0.2, 0.2, 1.0)];
    let p = [Vec3::zeros(), Vec3::zeros(), Vec3::zeros(), Vec3::new(0.0, 0.0, -2.0)];
    let half_spaces = [HalfSpace { normal: Vec3::z(), offset: 0.6 }];
    let pairs = Pairs {
        triangles: &[[0, 1, 2]],
        point_triangles: &[[3, 0]],
        half_spaces: &half_spaces,
        ..Pairs::default()
    };
    let settings = settings(BOTH[0], 0.1);
    let (fraction, culprit) = ccd::limit(&pairs, &x, &p, 0.0, &settings);
    assert!(fraction > 0.4 && fraction < 0.5, "{fraction}");
    assert_eq!(culprit.unwrap().features, [Feature::Point(3), Feature::Triangle(0)]);

    let with_floor = Pairs { half_space_points: &[[0, 3]], ..pairs };
    let (fraction, culprit) = ccd::limit(&with_floor, &x, &p, 0.0, &settings);
    assert!(fraction > 0.18 && fraction < 0.2, "{fraction}");
    assert_eq!(culprit.unwrap().features, [Feature::HalfSpace(0), Feature::Point(3)]);

    assert_eq!(ccd::limit(&pairs, &x, &[Vec3::x(); 4], 0.0, &settings), (1.0, None));
    assert_eq!(ccd::limit(&Pairs::default(), &[], &[], 0.0, &settings), (1.0, None));
    let (fraction, culprit) = ccd::limit(&pairs, &x, &p.map(|p| p * f64::NAN), 0.0, &settings);
    assert_eq!((fraction, culprit.unwrap().impact), (0.0, Impact::NonFinite));
}

/// Positions as a solver computes them, rounded, stay on their side at the fraction answered and before, also far from
/// the origin, where the rounding is as large as the gap that is left.
#[test]
fn rounded_positions_are_on_the_right_side() {
    let far = Vec3::new(1e4, -3e4, 7e4);
    for height in [1e-3, 1e-7, 1e-9] {
        let x = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::new(0.3, 0.3, height)].map(|x| x + far);
        let p = [Vec3::zeros(), Vec3::zeros(), Vec3::zeros(), Vec3::new(0.1, 0.1, -1.0)];
        let pairs = Pairs { triangles: &[[0, 1, 2]], point_triangles: &[[3, 0]], ..Pairs::default() };
        let (fraction, _) = ccd::limit(&pairs, &x, &p, 0.0, &settings(BOTH[0], 1e-9));
        for step in 0..=1000 {
            let alpha = fraction * f64::from(step) / 1000.0;
            assert!((x[3] + alpha * p[3]).z > x[0].z, "{height:e}, {alpha:e}");
        }
        assert!(fraction > 0.0 || height < 1e-8, "{height:e}");
    }
}
