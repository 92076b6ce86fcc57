//! Linking numbers.

use super::random::Random;
use ipc_contact::ContactError;
use ipc_contact::topology::linking_number;
use mechanics_core::tensor::{Mat3, Vec3};
use std::f64::consts::{PI, TAU};

fn sides(chain: &[Vec3]) -> Vec<[Vec3; 2]> {
    (0..chain.len()).map(|k| [chain[k], chain[(k + 1) % chain.len()]]).collect()
}

/// Gauss's integral: for two segments, x − y runs over a parallelogram, whose solid angle seen from the origin is the
/// double integral.
fn gauss_integral(first: &[Vec3], second: &[Vec3]) -> f64 {
    let triangle = |a: Vec3, b: Vec3, c: Vec3| {
        let [la, lb, lc] = [a, b, c].map(|side| side.norm());
        2.0 * a.dot(&b.cross(&c)).atan2(la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb)
    };
    let mut sum = 0.0;
    for [a, b] in sides(first) {
        for [p, q] in sides(second) {
            // Orientation of the parallelogram: (x − y)·(dx × dy), with d(x − y) = dx − dy.
            sum -= triangle(a - p, b - p, b - q) + triangle(a - p, b - q, a - q);
        }
    }
    sum / (4.0 * PI)
}

/// Closed chains of few points of a small grid: coplanar and collinear segments everywhere.
#[test]
fn grid_chains_agree_with_the_gauss_integral() {
    let mut random = Random(1);
    let (mut touching, mut counts) = (0, std::collections::BTreeMap::new());
    for k in 0..30000 {
        let range = [2, 2, 3, 5][k % 4];
        let mut chain =
            |count: i64| -> Vec<Vec3> { (0..count).map(|_| random.grid_point(-range, range)).collect() };
        let (first, second) = (chain(3 + k as i64 % 6), chain(3 + k as i64 % 5));
        match linking_number(&first, &second) {
            Err(ContactError::ChainsTouch { .. }) => touching += 1,
            found => {
                let found = found.unwrap();
                let integral = gauss_integral(&first, &second);
                assert!(
                    (f64::from(found) - integral).abs() < 1e-9,
                    "{found} {integral} {first:?} {second:?}"
                );
                assert_eq!(linking_number(&second, &first).unwrap(), found);
                let reversed: Vec<Vec3> = second.iter().rev().copied().collect();
                assert_eq!(linking_number(&first, &reversed).unwrap(), -found);
                *counts.entry(found).or_insert(0) += 1;
            }
        }
    }
    assert!(
        touching > 1000 && counts.len() >= 5 && counts[&1] > 500 && counts[&-1] > 500,
        "{touching} {counts:?}"
    );
}

/// Rational multiples of random numbers, at three scales: no near-coincidence confuses it.
#[test]
fn random_chains_agree_with_the_gauss_integral_at_every_scale() {
    let mut random = Random(2);
    for scale in [1e-8, 1.0, 1e8] {
        for _ in 0..200 {
            let mut chain = || -> Vec<Vec3> { (0..12).map(|_| random.point() * scale).collect() };
            let (first, second) = (chain(), chain());
            let integral = gauss_integral(&first, &second);
            let found = linking_number(&first, &second).unwrap();
            assert!((f64::from(found) - integral).abs() < 1e-9, "{found} {integral}");
        }
    }
}

/// The closed chains of a braid whose letters are ±1, ±2 … (strand k passes over or under strand k + 1), and for every
/// two chains half the sum of their crossings' signs.
fn closed_braid(strands: usize, word: &[i32]) -> (Vec<Vec<Vec3>>, Vec<Vec<i32>>) {
    let place = |level: f64, position: f64, height: f64| {
        let angle = TAU * level / word.len() as f64;
        Vec3::new((3.0 + position) * angle.cos(), (3.0 + position) * angle.sin(), height)
    };
    // Per strand by where it starts: its points, and where it is now.
    let mut paths = vec![Vec::new(); strands];
    let mut at: Vec<usize> = (0..strands).collect();
    let mut crossings = Vec::new();
    for (level, letter) in word.iter().enumerate() {
        let (lower, sign) = (letter.unsigned_abs() as usize - 1, letter.signum());
        let mut pair = [0; 2];
        for (strand, position) in at.iter_mut().enumerate() {
            let (from, height) = (*position as f64, 0.4 * f64::from(sign));
            paths[strand].push(place(level as f64, from, 0.0));
            if *position == lower {
                paths[strand].push(place(level as f64 + 0.5, from + 0.5, height));
                (*position, pair[0]) = (lower + 1, strand);
            } else if *position == lower + 1 {
                paths[strand].push(place(level as f64 + 0.5, from - 0.5, -height));
                (*position, pair[1]) = (lower, strand);
            } else {
                paths[strand].push(place(level as f64 + 0.5, from, 0.0));
            }
        }
        crossings.push((pair, sign));
    }
    let mut component = vec![usize::MAX; strands];
    let mut chains: Vec<Vec<Vec3>> = Vec::new();
    for first in 0..strands {
        let mut strand = first;
        while component[strand] == usize::MAX {
            if strand == first {
                chains.push(Vec::new());
            }
            component[strand] = chains.len() - 1;
            chains.last_mut().unwrap().append(&mut paths[strand]);
            strand = at[strand];
        }
    }
    let mut signs = vec![vec![0; chains.len()]; chains.len()];
    for ([a, b], sign) in crossings {
        let (a, b) = (component[a], component[b]);
        if a != b {
            (signs[a][b], signs[b][a]) = (signs[a][b] + sign, signs[b][a] + sign);
        }
    }
    let halved = signs.into_iter().map(|row| row.into_iter().map(|s| s / 2).collect()).collect();
    (chains, halved)
}

fn turned(chain: &[Vec3], turn: &Mat3, scale: f64) -> Vec<Vec3> {
    chain.iter().map(|p| turn * p * scale + Vec3::new(3.0, -7.0, 0.1) * scale).collect()
}

fn random_turn(random: &mut Random) -> Mat3 {
    let axis = nalgebra::Unit::new_normalize(random.point());
    nalgebra::Rotation3::from_axis_angle(&axis, TAU * random.unit()).into_inner()
}

/// Links with a name, each as a braid: with what is known of them, and in any position and size.
#[test]
fn braids_are_linked_as_their_crossings_say() {
    let mut random = Random(3);
    let torus = |crossings: usize| vec![1; crossings];
    let named: [(&str, usize, Vec<i32>, usize, i32); 7] = [
        ("two rings apart", 2, vec![1, -1], 2, 0),
        ("Hopf link", 2, torus(2), 2, 1),
        ("Solomon's knot", 2, torus(4), 2, 2),
        ("torus link T(2, 10)", 2, torus(10), 2, 5),
        ("trefoil, one chain only", 2, torus(3), 1, 0),
        // Both are linked, but not by this number: the limitation that the module states.
        ("Whitehead link", 3, vec![1, 1, 2, 2, -1, -2, -2], 2, 0),
        ("Borromean rings", 3, vec![1, -2, 1, -2, 1, -2], 3, 0),
    ];
    for (name, strands, word, components, number) in named {
        let (chains, expected) = closed_braid(strands, &word);
        assert_eq!(chains.len(), components, "{name}");
        if components > 1 {
            assert_eq!(expected[0][1].abs(), number, "{name}");
        }
        for scale in [1e-8, 1.0, 1e8] {
            let turn = random_turn(&mut random);
            for (i, j) in (0..components).flat_map(|i| (0..i).map(move |j| (i, j))) {
                let (a, b) = (turned(&chains[i], &turn, scale), turned(&chains[j], &turn, scale));
                assert_eq!(linking_number(&a, &b).unwrap(), expected[i][j], "{name}");
            }
        }
    }
}

#[test]
fn random_braids_are_linked_as_their_crossings_say() {
    let mut random = Random(4);
    let mut largest = 0;
    for _ in 0..60 {
        let strands = random.integer(2, 5);
        let word: Vec<i32> = (0..24)
            .map(|_| (random.integer(1, strands - 1) * (2 * random.integer(0, 2).min(1) - 1)) as i32)
            .collect();
        let (chains, expected) = closed_braid(strands as usize, &word);
        for (i, j) in (0..chains.len()).flat_map(|i| (0..i).map(move |j| (i, j))) {
            assert_eq!(linking_number(&chains[i], &chains[j]).unwrap(), expected[i][j], "{word:?}");
            largest = largest.max(expected[i][j].abs());
        }
    }
    assert!(largest >= 3, "{largest}");
}

/// Torus knots T(p, q) wind p times around the axis and q times around the core circle.
#[test]
fn torus_knots_are_linked_with_axis_and_core() {
    for (p, q) in [(2, 3), (2, 5), (2, 7), (3, 4), (5, 2)] {
        let knot: Vec<Vec3> = (0..400)
            .map(|k| {
                let t = TAU * f64::from(k) / 400.0;
                let (around, across) = (f64::from(p) * t, f64::from(q) * t);
                let radius = 2.0 + across.cos();
                Vec3::new(radius * around.cos(), radius * around.sin(), across.sin())
            })
            .collect();
        let core: Vec<Vec3> = (0..50)
            .map(|k| TAU * f64::from(k) / 50.0)
            .map(|t| Vec3::new(t.cos(), t.sin(), 0.0) * 2.0)
            .collect();
        let axis = [[0.0, 0.0, -9.0], [0.0, 0.0, 9.0], [9.0, 0.0, 9.0], [9.0, 0.0, -9.0]].map(Vec3::from);
        assert_eq!(linking_number(&axis, &knot).unwrap(), p);
        assert_eq!(linking_number(&core, &knot).unwrap().abs(), q);
        assert_eq!(linking_number(&core, &knot).unwrap(), gauss_integral(&core, &knot).round() as i32);
    }
}

/// Twenty links of a chain: each is linked with its neighbours and with no other; drawn out by one, it is not.
#[test]
fn each_link_of_a_chain_is_linked_with_its_neighbours_only() {
    let link = |k: usize| -> Vec<Vec3> {
        let corner = |t: usize| {
            let angle = TAU * t as f64 / 16.0;
            let (u, v) = (angle.cos(), 0.6 * angle.sin());
            let (y, z) = if k.is_multiple_of(2) { (v, 0.0) } else { (0.0, v) };
            Vec3::new(1.4 * k as f64 + u, y, z)
        };
        (0..16).map(corner).collect()
    };
    let links: Vec<Vec<Vec3>> = (0..20).map(link).collect();
    for i in 0..20 {
        for j in 0..i {
            let expected = i32::from(i - j == 1);
            assert_eq!(linking_number(&links[i], &links[j]).unwrap().abs(), expected, "{i} {j}");
        }
    }
    let away: Vec<Vec3> = links[1].iter().map(|p| p + Vec3::x()).collect();
    assert_eq!(linking_number(&links[0], &away).unwrap(), 0);
}

#[test]
fn chains_that_touch_or_are_nowhere_are_refused() {
    let square = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0]].map(Vec3::from);
    let touching = [[1.0, 2.0, 0.0], [1.0, 5.0, 1.0], [1.0, 5.0, -1.0]].map(Vec3::from);
    let error = linking_number(&square, &touching).unwrap_err();
    assert_eq!(error, ContactError::ChainsTouch { segments: [2, 0] });
    let apart = touching.map(|p| Vec3::new(p.x, p.y.next_up(), p.z));
    assert_eq!(linking_number(&square, &apart).unwrap(), 0);
    let through = touching.map(|p| Vec3::new(p.x, p.y - 1e-15, p.z + 1e-16));
    assert_eq!(linking_number(&square, &through).unwrap().abs(), 1);
    let nowhere = [Vec3::new(f64::NAN, 0.0, 0.0)];
    assert!(matches!(linking_number(&square, &nowhere), Err(ContactError::NonFiniteQuery { .. })));
    assert_eq!(linking_number(&square, &[]).unwrap(), 0);
    assert_eq!(linking_number(&[], &square).unwrap(), 0);
}
