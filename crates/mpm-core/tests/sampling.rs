//! Sampling: counts, distances, volumes, inside and outside.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

use mechanics_core::mesh::{MeshError, TriMesh, sphere, torus};
use mechanics_core::tensor::Vec3;
use mpm_core::sampling::{Pattern, SampledBody, SamplingError, sample_mesh, sample_shape};
use mpm_core::{Shape, SolidMesh};

fn unit_box<const D: usize>() -> Shape<D> {
    Shape::Cuboid { centre: [0.5; D], half: [0.5; D] }
}

fn nearest<const D: usize>(positions: &[[f64; D]], x: &[f64; D]) -> f64 {
    let square = |y: &[f64; D]| (0..D).map(|k| (x[k] - y[k]).powi(2)).sum::<f64>();
    positions.iter().map(square).filter(|s| *s > 0.0).fold(f64::INFINITY, f64::min).sqrt()
}

#[test]
fn a_lattice_has_as_many_places_a_cell_as_asked() {
    for along in 1..=4_u32 {
        let samples = sample_shape(&unit_box::<3>(), Pattern::per_cell(0.1, along), 3).unwrap();
        assert_eq!(samples.positions.len(), 1000 * (along as usize).pow(3));
        let total: f64 = samples.volumes.iter().sum();
        assert!((total - 1.0).abs() < 1e-11);
        for cell in 0..1000 {
            let cell = [cell / 100, cell / 10 % 10, cell % 10].map(f64::from);
            let inside = |x: &&[f64; 3]| (0..3).all(|a| (x[a] / 0.1).floor() == cell[a]);
            if cell[0] == 7.0 {
                assert_eq!(samples.positions.iter().filter(inside).count(), (along as usize).pow(3));
            }
        }
    }
}

/// Neighbouring boxes of one seed share a lattice: together they are the lattice of the whole, and seeds differ.
#[test]
fn lattices_are_seeded_by_place() {
    let shape = |low: f64, high: f64| Shape::Cuboid {
        centre: [0.5 * (low + high), 0.0],
        half: [0.5 * (high - low), 0.5],
    };
    let places = |shape, seed| sample_shape::<2>(&shape, Pattern::per_cell(0.1, 2), seed).unwrap().positions;
    let mut parts = [places(shape(-0.5, 0.2), 9), places(shape(0.2, 1.0), 9)].concat();
    let mut whole = places(shape(-0.5, 1.0), 9);
    parts.sort_by(|a, b| a.partial_cmp(b).unwrap());
    whole.sort_by(|a, b| a.partial_cmp(b).unwrap());
    assert_eq!(parts, whole);
    assert_ne!(places(shape(-0.5, 1.0), 10), places(shape(-0.5, 1.0), 9));
}

/// No two places are closer than the distance, no place of the box is two distances from all of them.
#[test]
fn poisson_disks_are_maximal() {
    fn check<const D: usize>(distance: f64) {
        let SampledBody { positions, volumes } =
            sample_shape(&unit_box::<D>(), Pattern::PoissonDisk { distance }, 11).unwrap();
        assert!(positions.iter().all(|x| nearest(&positions, x) >= distance));
        assert!((volumes.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        let steps = 20_usize;
        for k in 0..steps.pow(D as u32) {
            let x: [f64; D] =
                std::array::from_fn(|a| (k / steps.pow(a as u32) % steps) as f64 / (steps - 1) as f64);
            assert!(nearest(&positions, &x) < 2.0 * distance, "a hole at {x:?}");
        }
        let again = sample_shape(&unit_box::<D>(), Pattern::PoissonDisk { distance }, 11).unwrap();
        assert_eq!(again.positions, positions);
        // Random disks of half the distance fill between 0.4 and 0.6 of the plane, 0.25 and 0.4 of space.
        let ball = if D == 2 { std::f64::consts::PI / 4.0 } else { std::f64::consts::PI / 6.0 };
        let filled = positions.len() as f64 * ball * distance.powi(D as i32);
        assert!((0.25..0.75).contains(&filled), "{filled}");
    }
    check::<2>(0.03);
    check::<3>(0.1);
}

#[test]
fn volumes_are_those_of_the_shapes() {
    let pi = std::f64::consts::PI;
    let cases: [(Shape<3>, f64); 3] = [
        (Shape::Ball { centre: [0.3; 3], radius: 0.5 }, 4.0 / 3.0 * pi * 0.125),
        (
            Shape::Capsule { from: [0.0; 3], to: [0.0, 3.0, 4.0], radius: 0.5 },
            pi * 0.25 * 5.0 + 4.0 / 3.0 * pi * 0.125,
        ),
        (Shape::Cuboid { centre: [1.0; 3], half: [0.1, 0.2, 0.3] }, 0.048),
    ];
    for (shape, volume) in cases {
        let samples = sample_shape(&shape, Pattern::per_cell(0.1, 2), 1).unwrap();
        assert!((samples.volumes.iter().sum::<f64>() - volume).abs() < 1e-12 * volume.max(1.0));
        // The lattice counts the volume to a few per cent.
        let counted = samples.positions.len() as f64 * 0.05_f64.powi(3);
        assert!((counted / volume - 1.0).abs() < 0.02, "{shape:?}: {counted} for {volume}");
    }
}

/// Against the closed forms of a sphere and a torus, whichever way their triangles are turned; with a hole of opposite orientation.
#[test]
fn meshes_are_filled() {
    let ball = sphere(1.0, 16).unwrap();
    let pattern = Pattern::per_cell(0.1, 1);
    let samples = sample_mesh(&ball, pattern, 2).unwrap();
    assert!((samples.volumes.iter().sum::<f64>() - ball.enclosed_volume()).abs() < 1e-12);
    let whole = sample_shape(&Shape::Ball { centre: [0.0; 3], radius: 1.0 }, pattern, 2).unwrap();
    let radius = |x: &[f64; 3]| Vec3::from(*x).norm();
    // The icosphere lies between the sphere and one of radius 0.98.
    let sure = |samples: &[[f64; 3]]| samples.iter().filter(|x| radius(x) < 0.98).count();
    assert!(samples.positions.iter().all(|x| radius(x) <= 1.0));
    assert_eq!(sure(&samples.positions), sure(&whole.positions));
    let mut turned = ball.clone();
    turned.flip();
    assert_eq!(sample_mesh(&turned, pattern, 2).unwrap(), samples);

    let mut hollow = ball.clone();
    let mut hole = sphere(0.5, 12).unwrap();
    hole.flip();
    hollow.append(&hole).unwrap();
    let shell = sample_mesh(&hollow, pattern, 2).unwrap();
    let between = |x: &&[f64; 3]| (0.5..0.98).contains(&radius(x));
    assert!(shell.positions.iter().all(|x| radius(x) > 0.45));
    assert_eq!(
        shell.positions.iter().filter(between).count(),
        samples.positions.iter().filter(between).count()
    );

    let ring = torus(1.0, 0.3, 48, 24).unwrap();
    let samples = sample_mesh(&ring, Pattern::PoissonDisk { distance: 0.08 }, 2).unwrap();
    let across = |x: &[f64; 3]| {
        // Whichever axis the torus has: the one along which it is thin.
        let size = ring.bounding_box().unwrap().size();
        let axis = (0..3).min_by(|a, b| size[*a].total_cmp(&size[*b])).unwrap();
        let around: f64 = (0..3).filter(|k| *k != axis).map(|k| x[k] * x[k]).sum::<f64>().sqrt();
        (around - 1.0).hypot(x[axis])
    };
    assert!(samples.positions.len() > 1000 && samples.positions.iter().all(|x| across(x) <= 0.3));
}

/// Five a cell are five a cell, in the plane and in space.
#[test]
fn any_number_of_places_a_cell() {
    fn check<const D: usize>(count: f64) {
        let samples = sample_shape(&unit_box::<D>(), Pattern::of_count::<D>(0.05, count), 3).unwrap();
        let cells = 20_f64.powi(D as i32);
        assert!((samples.positions.len() as f64 / cells / count - 1.0).abs() < 0.05, "{D}, {count}");
    }
    for count in [1.0, 5.0, 8.0, 12.5] {
        check::<2>(count);
        check::<3>(count);
    }
    let none = sample_shape(&unit_box::<3>(), Pattern::of_count::<3>(0.05, 0.0), 3);
    assert!(matches!(none, Err(SamplingError::Pattern { .. })));
}

/// One random place a cube counts a volume without bias: a cube of which the part p is inside counts with the variance p(1 − p), in the mean 1/6 of
/// the cubes on a plane along the axes. The error of the volume is therefore h² √(A/6), of second order, for any surface about so much.
#[test]
fn counted_volumes_converge_with_second_order() {
    let mesh = sphere(1.0, 6).unwrap();
    let (volume, area) = (mesh.enclosed_volume(), mesh.area());
    for spacing in [0.2, 0.1, 0.05_f64] {
        let error = |seed| {
            let pattern = Pattern::Lattice { spacing, jitter: 1.0 };
            let count = sample_mesh(&mesh, pattern, seed).unwrap().positions.len();
            count as f64 * spacing.powi(3) - volume
        };
        let squares: Vec<f64> = (0..12).map(|seed| error(seed).powi(2)).collect();
        let found = (squares.iter().sum::<f64>() / 12.0).sqrt();
        let expected = spacing.powi(2) * (area / 6.0).sqrt();
        println!("{spacing}: {found:.2e} m³ of {expected:.2e}");
        // Three standard deviations, 1/√24 each, of a root mean square of twelve.
        assert!((0.39..1.61).contains(&(found / expected)), "{spacing}: {found} instead of {expected}");
    }
}

/// The bunny, by winding numbers; the distance of its surface as a collider agrees on what is inside.
#[test]
fn the_bunny_is_filled() {
    let assets = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/assets/meshes");
    let bunny = mechanics_core::mesh::io::obj::read_file(assets.join("bunny.obj")).unwrap();
    let solid = SolidMesh::new(&bunny).unwrap();
    let size = bunny.bounding_box().unwrap().size().max();
    for pattern in [Pattern::regular(size / 16.0, 2), Pattern::PoissonDisk { distance: size / 24.0 }] {
        let samples = sample_mesh(&bunny, pattern, 4).unwrap();
        let outside = samples.positions.iter().filter(|x| solid.signed_distance(**x).distance > 0.0).count();
        assert_eq!(outside, 0, "of {}", samples.positions.len());
        let volume: f64 = samples.volumes.iter().sum();
        assert!((volume / bunny.enclosed_volume() - 1.0).abs() < 1e-12);
        if let Pattern::Lattice { spacing, .. } = pattern {
            let counted = samples.positions.len() as f64 * spacing.powi(3);
            // 2 √(A/6) h² as above.
            let margin = 2.0 * (bunny.area() / 6.0).sqrt() * spacing.powi(2);
            assert!((counted - volume).abs() < margin, "{counted} for {volume}");
        }
    }
}

#[test]
fn what_cannot_be_filled_is_refused() {
    let pattern = Pattern::per_cell(0.1, 2);
    let half_space = Shape::HalfSpace { point: [0.0; 3], normal: [0.0, 0.0, 1.0] };
    assert_eq!(sample_shape(&half_space, pattern, 1), Err(SamplingError::Unbounded));
    let shape = Shape::Ball { centre: [0.0; 3], radius: -1.0 };
    assert!(matches!(sample_shape(&shape, pattern, 1), Err(SamplingError::Shape(_))));
    for pattern in [
        Pattern::Lattice { spacing: 0.0, jitter: 0.0 },
        Pattern::Lattice { spacing: f64::NAN, jitter: 0.0 },
        Pattern::Lattice { spacing: 0.1, jitter: 1.5 },
        Pattern::per_cell(0.1, 0),
        Pattern::PoissonDisk { distance: -1.0 },
    ] {
        assert!(matches!(sample_shape(&unit_box::<2>(), pattern, 1), Err(SamplingError::Pattern { .. })));
    }
    let fine = Pattern::Lattice { spacing: 1e-9, jitter: 0.0 };
    assert!(matches!(sample_shape(&unit_box::<3>(), fine, 1), Err(SamplingError::TooMany { .. })));
    let small = Shape::Ball { centre: [0.01; 3], radius: 1e-3 };
    assert_eq!(sample_shape(&small, pattern, 1), Err(SamplingError::Empty));
    let ball = sphere(1.0, 4).unwrap();
    let open = TriMesh::new(ball.points().to_vec(), ball.triangles()[1..].to_vec()).unwrap();
    assert!(matches!(sample_mesh(&open, pattern, 1), Err(SamplingError::Mesh(_))));
    let mut turned = ball.triangles().to_vec();
    turned[0].swap(0, 1);
    let twisted = TriMesh::new(ball.points().to_vec(), turned).unwrap();
    assert!(matches!(
        sample_mesh(&twisted, pattern, 1),
        Err(SamplingError::Mesh(MeshError::OpposedTriangles { .. }))
    ));
    let nothing = TriMesh::new(Vec::new(), Vec::new()).unwrap();
    assert!(sample_mesh(&nothing, pattern, 1).is_err());
}
