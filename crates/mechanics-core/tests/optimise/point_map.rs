use crate::samples::Random;
use mechanics_core::point_map::{PointMap, PointMapError, PointSource};
use mechanics_core::tensor::Vec3;

fn flat(random: &mut Random, n: usize) -> Vec<f64> {
    (0..3 * n).map(|_| random.number()).collect()
}

fn samples() -> Vec<PointMap> {
    let mut scripted = PointMap::with_fixed(5, &[(1, Vec3::new(1.0, 2.0, 3.0)), (4, Vec3::zeros())]).unwrap();
    scripted.set_offset(0, Vec3::new(0.5, 0.0, 0.0)).unwrap();
    let skin = [
        PointSource::Unknown(2),
        PointSource::Weighted(&[(0, 0.25), (1, 0.75)]),
        PointSource::Fixed,
        PointSource::Weighted(&[(2, -1.5)]),
        PointSource::Unknown(0),
        PointSource::Unknown(1),
    ];
    vec![PointMap::identity(4), scripted, PointMap::new(3, skin).unwrap()]
}

/// ⟨g, W q⟩ = ⟨Wᵀ g, q⟩ for all g and q.
#[test]
fn the_gradient_map_is_the_transpose_of_the_displacement_map() {
    let mut random = Random(1);
    for map in samples() {
        let (q, g) = (flat(&mut random, map.unknowns()), random.vectors(map.points()));
        let (mut dx, mut g_q) = (random.vectors(map.points()), flat(&mut random, map.unknowns()));
        map.displacements_into(&q, &mut dx);
        map.gradient_into(&g, &mut g_q);
        let over_points: f64 = g.iter().zip(&dx).map(|(g, dx)| g.dot(dx)).sum();
        let over_unknowns: f64 = g_q.iter().zip(&q).map(|(g, q)| g * q).sum();
        assert!((over_points - over_unknowns).abs() < 1e-14, "{over_points} {over_unknowns}");
    }
}

#[test]
fn points_are_weighted_unknowns_plus_offsets_and_can_be_read_back() {
    let mut random = Random(2);
    for map in samples() {
        let q = flat(&mut random, map.unknowns());
        let mut x = random.vectors(map.points());
        map.points_into(&q, &mut x);
        for (point, x) in x.iter().enumerate() {
            let mut expected = map.offset(point);
            map.for_each_unknown(point, |unknown, w| {
                let at = 3 * unknown as usize;
                expected += Vec3::from_column_slice(&q[at..at + 3]) * w;
            });
            assert!((x - expected).norm() < 1e-15);
        }
        let mut back = vec![f64::NAN; q.len()];
        map.unknowns_into(&x, &mut back).unwrap();
        assert!(back.iter().zip(&q).all(|(back, q)| (back - q).abs() < 1e-15));
    }
}

/// x = t + A X is exact for any affine motion, so four unknowns carry a whole body.
#[test]
fn an_affine_body_has_four_unknowns() {
    let mut random = Random(3);
    let rest = random.vectors(20);
    let weights: Vec<Vec<(u32, f64)>> =
        rest.iter().map(|r| vec![(0, 1.0), (1, r.x), (2, r.y), (3, r.z)]).collect();
    let map = PointMap::new(4, weights.iter().map(|w| PointSource::Weighted(w))).unwrap();
    assert!(!map.is_selection());
    let (t, a) = (random.vector(), random.matrix());
    let mut q = t.as_slice().to_vec();
    q.extend_from_slice(a.as_slice());
    let mut x = random.vectors(20);
    map.points_into(&q, &mut x);
    for (x, r) in x.iter().zip(&rest) {
        assert!((x - (t + a * r)).norm() < 1e-15);
    }
    let unreadable = map.unknowns_into(&x, &mut q);
    assert_eq!(unreadable, Err(PointMapError::NotReadable { unknown: 0 }));
}

#[test]
fn the_fastest_form_is_found() {
    let unknowns = |n: u32| (0..n).map(PointSource::Unknown);
    assert!(PointMap::new(6, unknowns(6)).unwrap().same_weights(&PointMap::identity(6)));
    let fixed = PointMap::with_fixed(3, &[(0, Vec3::x())]).unwrap();
    let same =
        PointMap::new(2, [PointSource::Fixed, PointSource::Unknown(0), PointSource::Weighted(&[(1, 1.0)])]);
    assert!(fixed.same_weights(&same.unwrap()), "offsets do not matter");
    assert!(!fixed.same_weights(&PointMap::identity(3)));
}

#[test]
fn wrong_maps_are_refused_by_name() {
    let one = |pairs: &[(u32, f64)]| {
        PointMap::new(1, [PointSource::Unknown(0), PointSource::Weighted(pairs)]).err()
    };
    let out_of_range = PointMapError::UnknownOutOfRange { point: 1, unknown: 1, unknowns: 1 };
    assert_eq!(one(&[(1, 1.0)]), Some(out_of_range));
    assert_eq!(one(&[(0, 1.0), (0, 1.0)]), Some(PointMapError::RepeatedUnknown { point: 1, unknown: 0 }));
    assert!(matches!(one(&[(0, f64::NAN)]), Some(PointMapError::Weight { point: 1, unknown: 0, .. })));
    let unused = PointMap::new(2, [PointSource::Unknown(1)]).err();
    assert_eq!(unused, Some(PointMapError::UnusedUnknown { unknown: 0 }));
    let beyond = PointMap::with_fixed(2, &[(2, Vec3::zeros())]).err();
    assert_eq!(beyond, Some(PointMapError::PointOutOfRange { point: 2, points: 2 }));
    let mut map = PointMap::identity(2);
    let nan = Vec3::new(0.0, f64::NAN, 0.0);
    assert!(matches!(map.set_offset(1, nan), Err(PointMapError::Offset { point: 1, .. })));
    assert_eq!(map.offset(1), Vec3::zeros());
    assert_eq!(PointMap::new(0, []).unwrap().points(), 0);
}

#[test]
fn an_unknown_that_is_only_read_with_weight_zero_moves_nothing() {
    let idle = PointMap::new(2, [PointSource::Unknown(0), PointSource::Weighted(&[(0, 1.0), (1, 0.0)])]);
    assert_eq!(idle.err(), Some(PointMapError::UnusedUnknown { unknown: 1 }));
}
