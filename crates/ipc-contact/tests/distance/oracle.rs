//! Bounded distances against brute force, and what they must not depend on.
//!
//! The oracle knows nothing of regions: a pair of convex hulls of points is closest at the minimum of a convex quadratic
//! over a product of simplices, and that minimum is the unconstrained one on the affine hull of *some* product of faces,
//! where it is feasible. It tries all faces, in double-double arithmetic, and takes the smallest.

use crate::double::Double;
use crate::states::{self, KINDS, Random};
use ipc_contact::distance::{self, FLATNESS, Region};
use mechanics_core::tensor::Vec3;

type Wide = [Double; 3];

fn wide(x: &Vec3) -> Wide {
    [x[0].into(), x[1].into(), x[2].into()]
}

fn minus(a: &Wide, b: &Wide) -> Wide {
    std::array::from_fn(|k| a[k] - b[k])
}

fn dot(a: &Wide, b: &Wide) -> Double {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Solves G u = b for at most three unknowns by Gaussian elimination with complete pivoting; `None` if singular.
fn solve(mut g: Vec<Vec<Double>>, mut b: Vec<Double>) -> Option<Vec<Double>> {
    let n = b.len();
    let largest = g.iter().flatten().map(|e| e.high.abs()).fold(0.0, f64::max);
    let mut order: Vec<usize> = (0..n).collect();
    for k in 0..n {
        let pivots = (k..n).flat_map(|i| (k..n).map(move |j| (i, j)));
        let (i, j) = pivots.max_by(|p, q| g[p.0][p.1].high.abs().total_cmp(&g[q.0][q.1].high.abs()))?;
        g.swap(i, k);
        b.swap(i, k);
        g.iter_mut().for_each(|row| row.swap(j, k));
        order.swap(j, k);
        if g[k][k].high.abs() <= 1e-28 * largest {
            return None;
        }
        for i in k + 1..n {
            let factor = g[i][k] / g[k][k];
            for j in k..n {
                let part = factor * g[k][j];
                g[i][j] -= part;
            }
            let part = factor * b[k];
            b[i] -= part;
        }
    }
    let mut u = vec![Double::from(0.0); n];
    for k in (0..n).rev() {
        let rest = (k + 1..n).fold(b[k], |rest, j| rest - g[k][j] * u[order[j]]);
        u[order[k]] = rest / g[k][k];
    }
    Some(u)
}

/// All non-empty subsets.
fn faces(points: &[Wide]) -> Vec<Vec<Wide>> {
    (1..1_usize << points.len())
        .map(|mask| (0..points.len()).filter(|k| mask >> k & 1 == 1).map(|k| points[k]).collect())
        .collect()
}

/// The squared distance of the affine hulls of two faces, if their closest points lie within the faces.
fn within(a: &[Wide], b: &[Wide]) -> Option<f64> {
    // r = (a₀ + Σ uₖ(aₖ − a₀)) − (b₀ + Σ vₖ(bₖ − b₀)).
    let mut tangents: Vec<Wide> = a[1..].iter().map(|p| minus(p, &a[0])).collect();
    tangents.extend(b[1..].iter().map(|p| minus(&b[0], p)));
    let mut r = minus(&a[0], &b[0]);
    let gram = tangents.iter().map(|s| tangents.iter().map(|t| dot(s, t)).collect()).collect();
    let u = solve(gram, tangents.iter().map(|t| -dot(t, &r)).collect())?;
    let feasible = |u: &[Double]| {
        let rest = u.iter().fold(Double::from(1.0), |rest, &u| rest - u);
        u.iter().all(|u| u.high >= 0.0) && rest.high >= 0.0
    };
    if !feasible(&u[..a.len() - 1]) || !feasible(&u[a.len() - 1..]) {
        return None;
    }
    for (u, t) in u.iter().zip(&tangents) {
        (0..3).for_each(|k| r[k] += *u * t[k]);
    }
    Some(dot(&r, &r).high)
}

/// Squared distance of the hulls of the first `split` points and of the rest.
fn brute_force(x: &[Vec3], split: usize) -> f64 {
    let x: Vec<Wide> = x.iter().map(wide).collect();
    let (a, b) = (faces(&x[..split]), faces(&x[split..]));
    a.iter().flat_map(|a| b.iter().filter_map(|b| within(a, b))).fold(f64::INFINITY, f64::min)
}

fn longest_edge(x: &[Vec3]) -> f64 {
    x.iter().flat_map(|a| x.iter().map(move |b| (a - b).norm())).fold(0.0, f64::max)
}

/// Points anywhere: every region. Some coincide, some are on a line or in a plane, some nearly.
fn anywhere(random: &mut Random, index: usize) -> [Vec3; 4] {
    let mut x: [Vec3; 4] = std::array::from_fn(|_| random.vector());
    let (i, j, k) = (index % 4, (index / 4) % 3, (index / 12) % 2);
    let others: Vec<usize> = (0..4).filter(|&o| o != i).collect();
    let (a, b, c) = (x[others[j]], x[others[(j + 1 + k) % 3]], x[others[(j + 2 - k) % 3]]);
    let noise = random.direction() * random.decade(-16.0, -2.0);
    match (index / 24) % 8 {
        0 => x[i] = a,
        1 => x[i] = a + noise,
        2 => x[i] = a + (b - a) * random.between(-1.0, 2.0),
        3 => x[i] = a + (b - a) * random.between(-1.0, 2.0) + noise,
        4 => x[i] = a + (b - a) * random.between(-1.0, 1.0) + (c - a) * random.between(-1.0, 1.0),
        5 => x[i] = b + c - a,
        6 => x[i] = b + c - a + noise,
        _ => {}
    }
    x
}

/// Errors of √s over the largest distance among the points: at most 1e-14, but for flat triangles and nearly parallel
/// edges, which may be too large by the stated flatness.
#[test]
fn bounded_distances_are_those_of_brute_force() {
    let mut random = Random(3);
    let (mut worst, mut worst_flat, mut regions) = (0.0_f64, 0.0_f64, std::collections::BTreeSet::new());
    for index in 0..48_000 {
        let x = anywhere(&mut random, index);
        let size = longest_edge(&x);
        let point_edge = distance::point_edge_closest(&[x[0], x[1], x[2]]);
        let pairs = [
            (point_edge, brute_force(&x[..3], 1)),
            (distance::point_triangle_closest(&x), brute_force(&x, 1)),
            (distance::edge_edge_closest(&x), brute_force(&x, 2)),
        ];
        for (kind, ((region, found), expected)) in pairs.into_iter().enumerate() {
            regions.insert((kind, region));
            let error = (found.sqrt() - expected.sqrt()) / size;
            if error > 1e-14 {
                worst_flat = worst_flat.max(error);
            } else {
                worst = worst.max(error.abs());
            }
            assert!((-1e-14..FLATNESS).contains(&error), "{x:?}: {region:?} {found} instead of {expected}");
        }
    }
    println!("worst error {worst:e}, of flat features {worst_flat:e}");
    assert_eq!(regions.len(), 3 + 7 + 9);
}

/// s is right to 1e-8 relative for d from 1e-7 of the size on: a rounding of the positions does a fifth of that to it.
#[test]
fn small_distances_are_right_relative_to_themselves() {
    let mut random = Random(9);
    let mut worst = 0.0_f64;
    for index in 0..20_000 {
        let kind = KINDS[index % KINDS.len()];
        let triangle = states::point_over_triangle(&mut random, kind);
        let edges = states::crossing_edges(&mut random, kind);
        for (found, expected) in [
            (distance::point_triangle(&triangle), brute_force(&triangle, 1)),
            (distance::edge_edge(&edges), brute_force(&edges, 2)),
        ] {
            worst = worst.max((found / expected - 1.0).abs());
        }
    }
    println!("worst relative error of s: {worst:e}");
    assert!(worst < 1e-8);
}

#[test]
fn distances_scale_with_the_unit_of_length() {
    let mut random = Random(21);
    for index in 0..4_000 {
        let x = anywhere(&mut random, index);
        for exponent in [-8, -5, -2, 3, 8] {
            let unit = 10.0_f64.powi(exponent);
            let scaled = x.map(|x| x * unit);
            for (there, here) in [
                (distance::point_triangle(&scaled), distance::point_triangle(&x)),
                (distance::edge_edge(&scaled), distance::edge_edge(&x)),
            ] {
                let error = (there.sqrt() / unit - here.sqrt()).abs();
                // Features at the limit of flatness may fall on either side of it.
                assert!(
                    error < 1e-14 * longest_edge(&x) || error < FLATNESS * longest_edge(&x) && is_flat(&x)
                );
            }
        }
    }
}

/// Is some angle among the points small?
fn is_flat(x: &[Vec3; 4]) -> bool {
    let areas = [[x[2] - x[1], x[3] - x[1]], [x[1] - x[0], x[3] - x[2]]];
    areas.iter().any(|[u, v]| u.cross(v).norm() < 1e-6 * longest_edge(x).powi(2))
}

#[test]
fn distances_do_not_depend_on_labels() {
    let mut random = Random(33);
    for index in 0..4_000 {
        let x = anywhere(&mut random, index);
        let size = longest_edge(&x);
        let triangle = distance::point_triangle(&x).sqrt();
        for [a, b, c] in [[1, 3, 2], [2, 1, 3], [2, 3, 1], [3, 1, 2], [3, 2, 1]] {
            let other = distance::point_triangle(&[x[0], x[a], x[b], x[c]]).sqrt();
            assert!((other - triangle).abs() < 1e-14 * size || is_flat(&x), "{x:?}");
        }
        let edges = distance::edge_edge(&x).sqrt();
        for [a, b, c, d] in [[1, 0, 2, 3], [0, 1, 3, 2], [2, 3, 0, 1], [3, 2, 1, 0]] {
            let other = distance::edge_edge(&[x[a], x[b], x[c], x[d]]).sqrt();
            assert!((other - edges).abs() < 1e-14 * size || is_flat(&x), "{x:?}");
        }
    }
}

#[test]
fn degenerate_features_fall_to_lower_ones() {
    let [o, a, b, p] =
        [Vec3::zeros(), Vec3::new(1.0, 0.0, 0.0), Vec3::new(2.0, 0.0, 0.0), Vec3::new(0.5, 3.0, 4.0)];
    // An edge of no length is its first point.
    assert_eq!(distance::point_edge_closest(&[p, a, a]), (Region::PointPoint([0, 1]), 25.25));
    // A triangle of no area is its edges, or its point.
    assert_eq!(distance::point_triangle_closest(&[p, o, a, b]).1, 25.0);
    assert!(matches!(distance::point_triangle_region(&[p, o, a, b]), Region::PointEdge(_)));
    assert_eq!(distance::point_triangle_closest(&[p, a, a, a]), (Region::PointPoint([0, 1]), 25.25));
    // Edges of no length: a point and an edge, two points.
    assert_eq!(distance::edge_edge_closest(&[p, p, o, b]), (Region::PointEdge([0, 2, 3]), 25.0));
    assert_eq!(distance::edge_edge_closest(&[p, p, a, a]), (Region::PointPoint([0, 2]), 25.25));
    // Parallel edges with an overlap are closest at the first end that lies beside the other edge; collinear ones at ends.
    let up = Vec3::new(0.0, 0.0, 1.0);
    assert_eq!(distance::edge_edge_closest(&[o, b, a + up, b + a + up]), (Region::PointEdge([1, 2, 3]), 1.0));
    assert_eq!(distance::edge_edge_closest(&[o, a, b, b + a]), (Region::PointPoint([1, 2]), 1.0));
}

#[test]
fn positions_that_are_not_numbers_give_no_number_and_do_not_panic() {
    let mut random = Random(8);
    for index in 0..1_000 {
        let clean = anywhere(&mut random, index);
        for place in 0..12 {
            let mut x = clean;
            x[place / 3][place % 3] = f64::NAN;
            assert!(distance::point_triangle(&x).is_nan() && distance::edge_edge(&x).is_nan(), "{x:?}");
            assert!(place >= 9 || distance::point_edge(&[x[0], x[1], x[2]]).is_nan());
            x[place / 3][place % 3] = f64::INFINITY;
            let _ = (distance::point_triangle_region(&x), distance::edge_edge_region(&x));
        }
    }
}

/// What a region says fits together: r is the weighted sum of positions, s = ‖r‖², weights sum to zero, and the closest
/// points are within the features.
#[test]
fn closest_points_have_barycentric_weights() {
    let mut random = Random(17);
    for index in 0..8_000 {
        let x = if index % 2 == 0 {
            states::crossing_edges(&mut random, KINDS[index / 2 % 2])
        } else {
            states::point_over_triangle(&mut random, KINDS[index / 2 % 2])
        };
        for (split, (region, squared)) in
            [(2, distance::edge_edge_closest(&x)), (1, distance::point_triangle_closest(&x))]
        {
            let (r, weights) = region.weights(&x);
            let sum: Vec3 = x.iter().zip(weights).map(|(x, w)| x * w).sum();
            assert!((sum - r).norm() < 1e-14 * (1.0 + sum.norm()), "{region:?} {sum} {r}");
            assert!((r.norm_squared() / squared - 1.0).abs() < 1e-12 && region.value(&x) == squared);
            assert!(weights.iter().sum::<f64>().abs() < 1e-15);
            assert!((weights[..split].iter().sum::<f64>().abs() - 1.0).abs() < 1e-15);
            let sign = weights[..split].iter().sum::<f64>();
            assert!(weights[..split].iter().all(|w| w * sign >= 0.0));
            assert!(weights[split..].iter().all(|w| w * sign <= 0.0));
        }
    }
}
