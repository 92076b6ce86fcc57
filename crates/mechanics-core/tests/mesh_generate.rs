//! Generators against closed forms: counts, volumes, areas, topology, observed order of convergence.

#![allow(clippy::unwrap_used)]

use mechanics_core::mesh::{
    BoxSplit, CylinderEnds, Diagonals, MeshError, PolylineEnds, Surface, TetMesh, TriMesh, ball, block,
    cylinder, cylinder_surface, height_field, polyline, rod, sheet, sphere, torus,
};
use mechanics_core::tensor::Vec3;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Conformity by brute force: every face belongs to one or two tetrahedra, and those on one only close a surface.
fn assert_sound(mesh: &TetMesh) -> Surface {
    mesh.check_orientation().unwrap();
    mesh.check_conforming().unwrap();
    assert_eq!(mesh.unreferenced_points(), []);
    let mut count: BTreeMap<[u32; 3], usize> = BTreeMap::new();
    for &[a, b, c, d] in mesh.cells() {
        for mut face in [[a, b, c], [a, b, d], [a, c, d], [b, c, d]] {
            face.sort_unstable();
            *count.entry(face).or_default() += 1;
        }
    }
    let surface = Surface::of_tets(mesh).unwrap();
    let interior = count.values().filter(|&&n| n == 2).count();
    let outer = count.values().filter(|&&n| n == 1).count();
    assert_eq!(interior + outer, count.len());
    assert_eq!(outer, surface.triangles().len());
    // A hanging node would show as an inner crack: the boundary would have a larger area or not be closed.
    surface.check_closed().unwrap();
    assert!((surface.volume() - mesh.volume()).abs() <= 1e-13 * mesh.volume());
    surface
}

#[test]
fn block_fills_its_box_with_either_split() {
    let (min, max) = (Vec3::new(-1.0, 0.5, 2.0), Vec3::new(0.5, 3.0, 2.25));
    for (split, per_cell) in [(BoxSplit::Six, 6), (BoxSplit::Five, 5)] {
        for cells in [[1, 1, 1], [3, 2, 4], [2, 5, 1]] {
            let mesh = block(&min, &max, cells, split).unwrap();
            let [nx, ny, nz] = cells.map(|n| n as usize);
            assert_eq!(mesh.cells().len(), per_cell * nx * ny * nz);
            assert_eq!(mesh.points().len(), (nx + 1) * (ny + 1) * (nz + 1));
            let surface = assert_sound(&mesh);
            assert_eq!(surface.triangles().len(), 4 * (nx * ny + ny * nz + nz * nx));
            assert_eq!(surface.euler_characteristic(), 2);
            assert!((mesh.volume() - 1.5 * 2.5 * 0.25).abs() < 1e-14);
            assert!((surface.area() - 2.0 * (1.5 * 2.5 + 2.5 * 0.25 + 0.25 * 1.5)).abs() < 1e-13);
            let centre = mesh.centroid().unwrap();
            assert!((centre - (min + max) * 0.5).norm() < 1e-14);
            let bounds = mesh.bounding_box().unwrap();
            assert_eq!((bounds.min, bounds.max), (min, max));
        }
    }
}

#[test]
fn six_split_makes_equal_volumes_and_five_split_a_regular_tet() {
    let unit = |split| block(&Vec3::zeros(), &Vec3::new(1.0, 1.0, 1.0), [1, 1, 1], split).unwrap();
    assert!(unit(BoxSplit::Six).volumes().iter().all(|v| (v - 1.0 / 6.0).abs() < 1e-16));
    let five = unit(BoxSplit::Five);
    let q = five.qualities();
    assert!((q[0].mean_ratio - 1.0).abs() < 1e-15 && (q[0].volume - 1.0 / 3.0).abs() < 1e-16);
    assert!(q[1..].iter().all(|q| (q.volume - 1.0 / 6.0).abs() < 1e-16));
}

#[test]
fn sphere_volume_and_area_converge_with_second_order() {
    let radius = 0.7_f64;
    let errors = [4, 8, 16, 32].map(|f| {
        let mesh = sphere(radius, f).unwrap();
        assert_eq!(mesh.points().len(), 10 * (f * f) as usize + 2);
        assert_eq!(mesh.triangles().len(), 20 * (f * f) as usize);
        assert!(mesh.points().iter().all(|p| (p.norm() - radius).abs() < 1e-15));
        let surface = Surface::of_triangles(&mesh);
        surface.check_closed().unwrap();
        assert_eq!(surface.euler_characteristic(), 2);
        let (volume, area) = (4.0 / 3.0 * PI * radius.powi(3), 4.0 * PI * radius.powi(2));
        // Positive errors: inscribed polyhedra are smaller.
        [(volume - surface.volume()) / volume, (area - surface.area()) / area]
    });
    for k in 0..2 {
        let orders: Vec<f64> = errors.windows(2).map(|pair| (pair[0][k] / pair[1][k]).log2()).collect();
        println!("sphere: orders {orders:.3?}, relative error at f = 32 {:.2e}", errors[3][k]);
        assert!((1.98..2.02).contains(&orders[2]) && orders[0] > 1.8, "orders {orders:?}");
    }
}

#[test]
fn icosahedron_has_its_closed_form_volume() {
    // Edge a = 1 / sin(2π/5) for circumradius 1; V = 5 (3 + √5) a³ / 12.
    let a = 1.0 / (2.0 * PI / 5.0).sin();
    let exact = 5.0 * (3.0 + 5.0_f64.sqrt()) * a.powi(3) / 12.0;
    assert!((sphere(1.0, 1).unwrap().enclosed_volume() - exact).abs() < 1e-14);
    assert!((ball(1.0, 1).unwrap().volume() - exact).abs() < 1e-14);
}

#[test]
fn ball_is_sound_and_bounded_by_the_sphere() {
    let errors = [2, 4, 8, 16].map(|f| {
        let mesh = ball(2.0, f).unwrap();
        assert_eq!(mesh.cells().len(), 20 * (f * f * f) as usize);
        let surface = assert_sound(&mesh);
        assert_eq!(surface.triangles().len(), 20 * (f * f) as usize);
        assert_eq!(surface.euler_characteristic(), 2);
        assert!(surface.points().iter().all(|p| (p.norm() - 2.0).abs() < 1e-14));
        assert!((surface.area() - sphere(2.0, f).unwrap().area()).abs() < 1e-12);
        let exact = 32.0 / 3.0 * PI;
        (exact - mesh.volume()) / exact
    });
    let order = (errors[2] / errors[3]).log2();
    assert!((1.95..2.05).contains(&order), "order {order}");
    let worst = ball(1.0, 8).unwrap().quality_summary().unwrap();
    println!("ball, f = 8: {worst:?}");
    assert!(worst.mean_ratio.value > 0.5, "worst mean ratio {:?}", worst.mean_ratio);
}

#[test]
fn cylinder_has_the_polygonal_prism_volume() {
    let (radius, height) = (0.3_f64, 2.0);
    for (rings, layers) in [(1, 1), (2, 5), (6, 3)] {
        let n = f64::from(6 * rings);
        let polygon = 0.5 * n * (2.0 * PI / n).sin() * radius * radius;
        let side = n * 2.0 * radius * (PI / n).sin() * height;
        let mesh = cylinder(radius, height, rings, layers).unwrap();
        assert_eq!(mesh.cells().len(), (18 * rings * rings * layers) as usize);
        let surface = assert_sound(&mesh);
        assert_eq!(surface.euler_characteristic(), 2);
        assert!((mesh.volume() - polygon * height).abs() < 1e-14);
        assert!((surface.area() - 2.0 * polygon - side).abs() < 1e-13);
        let closed = cylinder_surface(radius, height, rings, layers, CylinderEnds::Closed).unwrap();
        let closed = Surface::of_triangles(&closed);
        closed.check_closed().unwrap();
        assert_eq!(closed.triangles().len(), surface.triangles().len());
        assert!((closed.volume() - polygon * height).abs() < 1e-14);
        assert!((closed.area() - surface.area()).abs() < 1e-13);
        let tube = cylinder_surface(radius, height, rings, layers, CylinderEnds::Open).unwrap();
        assert!((tube.area() - side).abs() < 1e-13);
        let tube = Surface::of_triangles(&tube);
        assert_eq!((tube.euler_characteristic(), tube.boundary_edges().len()), (0, 12 * rings as usize));
        tube.check_manifold().unwrap();
        tube.check_oriented().unwrap();
        assert!(matches!(tube.check_closed(), Err(MeshError::OpenEdge { .. })));
    }
}

#[test]
fn torus_has_one_handle_and_second_order() {
    let (major, minor) = (2.0, 0.5);
    let errors = [16, 32, 64].map(|n| {
        let surface = Surface::of_triangles(&torus(major, minor, 2 * n, n).unwrap());
        surface.check_closed().unwrap();
        assert_eq!(surface.euler_characteristic(), 0);
        let exact = 2.0 * PI * PI * major * minor * minor;
        (exact - surface.volume()) / exact
    });
    let order = (errors[1] / errors[2]).log2();
    assert!((1.95..2.05).contains(&order), "order {order}");
}

#[test]
fn sheets_are_discs_with_upward_normals() {
    let patterns = [Diagonals::Rising, Diagonals::Falling, Diagonals::Alternating, Diagonals::Crossed];
    for (diagonals, per_cell) in patterns.into_iter().zip([2, 2, 2, 4]) {
        let mesh = sheet([2.0, 3.0], [4, 5], diagonals).unwrap();
        assert_eq!(mesh.triangles().len(), per_cell * 20);
        assert!((mesh.area() - 6.0).abs() < 1e-14);
        let surface = Surface::of_triangles(&mesh);
        surface.check_manifold().unwrap();
        surface.check_oriented().unwrap();
        assert_eq!((surface.euler_characteristic(), surface.boundary_edges().len()), (1, 18));
        for t in 0..mesh.triangles().len() {
            let [a, b, c] = mesh.corners(t);
            assert!((b - a).cross(&(c - a)).z > 0.0);
        }
        assert!((surface.point_areas().iter().sum::<f64>() - 6.0).abs() < 1e-14);
        assert!((surface.edge_areas().iter().sum::<f64>() - 6.0).abs() < 1e-14);
    }
}

#[test]
fn diagonals_lie_as_their_names_say() {
    let has =
        |diagonals, edge: [u32; 2]| sheet([1.0, 1.0], [2, 1], diagonals).unwrap().edges().contains(&edge);
    // Points 0 1 2 below, 3 4 5 above.
    for (diagonals, rising) in [
        (Diagonals::Rising, [true, true]),
        (Diagonals::Falling, [false, false]),
        (Diagonals::Alternating, [true, false]),
    ] {
        assert_eq!([has(diagonals, [0, 4]), has(diagonals, [1, 5])], rising);
        assert_eq!([has(diagonals, [1, 3]), has(diagonals, [2, 4])], rising.map(|r| !r));
    }
}

#[test]
fn height_field_area_converges_to_the_paraboloid() {
    // z = (x² + y²)/2 over the unit square: area = ∫∫ √(1 + x² + y²) dx dy, by mpmath with 30 digits.
    let exact = 1.280_789_275_273_403_9;
    let errors = [8, 16, 32].map(|n| {
        let mesh =
            height_field([1.0, 1.0], [n, n], Diagonals::Alternating, |x, y| 0.5 * (x * x + y * y)).unwrap();
        (mesh.area() - exact).abs()
    });
    let order = (errors[1] / errors[2]).log2();
    assert!((1.9..2.1).contains(&order), "order {order}, errors {errors:?}");
    let hole = height_field([1.0, 1.0], [2, 2], Diagonals::Rising, |x, _| 1.0 / (x - 0.5));
    assert!(matches!(hole, Err(MeshError::NonFinitePosition { point: 1, .. })));
}

#[test]
fn rods_and_rings_are_free_edges() {
    let mesh = rod(&Vec3::new(1.0, 0.0, 0.0), &Vec3::new(1.0, 3.0, 4.0), 10).unwrap();
    assert_eq!((mesh.points().len(), mesh.free_edges().len(), mesh.triangles().len()), (11, 10, 0));
    assert!((mesh.free_length() - 5.0).abs() < 1e-14);
    let surface = Surface::of_triangles(&mesh);
    assert_eq!((surface.edges().len(), surface.euler_characteristic()), (10, 1));
    let n = 100;
    let circle = (0..n).map(|k| {
        let t = 2.0 * PI * f64::from(k) / f64::from(n);
        Vec3::new(t.cos(), t.sin(), 0.0)
    });
    let ring = polyline(circle.collect(), PolylineEnds::Joined).unwrap();
    assert!((ring.free_length() - 2.0 * f64::from(n) * (PI / f64::from(n)).sin()).abs() < 1e-13);
    assert_eq!(Surface::of_triangles(&ring).euler_characteristic(), 0);
}

#[test]
fn senseless_parameters_are_refused_by_name() {
    let bad = |result: Result<TriMesh, MeshError>, name: &str| match result {
        Err(MeshError::BadParameter { parameter, .. }) => assert_eq!(parameter, name),
        other => panic!("{other:?}"),
    };
    bad(sphere(-1.0, 3), "radius");
    bad(sphere(f64::NAN, 3), "radius");
    bad(sphere(1.0, 0), "frequency");
    bad(sheet([0.0, 1.0], [1, 1], Diagonals::Rising), "size");
    bad(rod(&Vec3::zeros(), &Vec3::x(), 0), "segments");
    bad(torus(1.0, 1.0, 8, 8), "minor radius");
    bad(torus(1.0, 0.5, 2, 8), "around or across");
    bad(polyline(vec![Vec3::zeros()], PolylineEnds::Open), "number of points");
    assert!(matches!(sphere(1.0, 1 << 20), Err(MeshError::TooLarge { .. })));
    assert!(matches!(ball(1.0, u32::MAX), Err(MeshError::TooLarge { .. })));
    let (zero, one) = (Vec3::zeros(), Vec3::new(1.0, 1.0, 1.0));
    assert!(matches!(block(&one, &zero, [1, 1, 1], BoxSplit::Six), Err(MeshError::BadParameter { .. })));
    assert!(matches!(block(&zero, &one, [u32::MAX; 3], BoxSplit::Six), Err(MeshError::TooLarge { .. })));
    assert!(matches!(sheet([1.0, 1.0], [u32::MAX; 2], Diagonals::Rising), Err(MeshError::TooLarge { .. })));
}
