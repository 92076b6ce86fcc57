//! Quality measures against closed forms, topology of hard cases, what constructors refuse.
#![allow(clippy::unwrap_used)]

use mechanics_core::mesh::{
    BoxSplit, CellKind, MeshError, Surface, TetMesh, TriMesh, block, sphere, tet_quality, torus,
    triangle_quality,
};
use mechanics_core::tensor::Vec3;
use nalgebra::Rotation3;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_3, PI};

fn points(list: &[[f64; 3]]) -> Vec<Vec3> {
    list.iter().map(|&p| p.into()).collect()
}

fn regular() -> [Vec3; 4] {
    [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, -1.0, 1.0], [-1.0, 1.0, -1.0]].map(Vec3::from)
}

fn corner() -> [Vec3; 4] {
    [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()]
}

fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance * b.abs().max(1.0), "{a} is not {b}");
}

#[test]
fn regular_tetrahedron_has_its_closed_forms_at_every_size_and_place() {
    for exponent in [-100, -30, 0, 30, 100] {
        let size = 10.0_f64.powi(exponent);
        let turn = Rotation3::from_euler_angles(0.3, -1.1, 2.0);
        let q = tet_quality(&regular().map(|p| turn * p * size + Vec3::new(3.0, -2.0, 1.0) * size));
        let edge = 8.0_f64.sqrt();
        close(q.volume / size / size / size, edge.powi(3) / 72.0_f64.sqrt(), 1e-14);
        close(q.min_dihedral_angle, (1.0_f64 / 3.0).acos(), 1e-14);
        close(q.max_dihedral_angle, (1.0_f64 / 3.0).acos(), 1e-14);
        close(q.min_edge / size, edge, 1e-14);
        close(q.max_edge / size, edge, 1e-14);
        close(q.radius_ratio, 1.0, 1e-14);
        close(q.aspect_ratio, 1.0, 1e-14);
        close(q.mean_ratio, 1.0, 1e-14);
    }
}

#[test]
fn cube_corner_has_its_closed_forms() {
    let q = tet_quality(&corner());
    // r = 1/(3 + √3), R = √3/2, three right angles and three of arccos(1/√3).
    let (r, big_r) = (1.0 / (3.0 + 3.0_f64.sqrt()), 3.0_f64.sqrt() / 2.0);
    close(q.volume, 1.0 / 6.0, 1e-15);
    close(q.radius_ratio, 3.0 * r / big_r, 1e-14);
    close(q.aspect_ratio, 2.0_f64.sqrt() / (24.0_f64.sqrt() * r), 1e-14);
    close(q.mean_ratio, 12.0 * 0.5_f64.powf(2.0 / 3.0) / 9.0, 1e-14);
    close(q.min_dihedral_angle, (1.0 / 3.0_f64.sqrt()).acos(), 1e-14);
    close(q.max_dihedral_angle, FRAC_PI_2, 1e-14);
    let inverted = tet_quality(&[corner()[0], corner()[2], corner()[1], corner()[3]]);
    assert_eq!(inverted.mean_ratio, -q.mean_ratio);
    assert_eq!((inverted.radius_ratio, inverted.volume), (q.radius_ratio, -q.volume));
}

#[test]
fn slivers_tend_to_their_limits() {
    // A square's corners at heights ±e. The faces meet at the diagonals at π − 2 atan(2e), each has twice the area
    // 2 √(1 + 4e²), and 6V = 8e, so r = e / √(1 + 4e²).
    for exponent in 1..=12 {
        let e = 10.0_f64.powi(-exponent);
        let q =
            tet_quality(&[[1.0, 0.0, e], [0.0, 1.0, -e], [0.0, -1.0, -e], [-1.0, 0.0, e]].map(Vec3::from));
        let root = (1.0 + 4.0 * e * e).sqrt();
        close(q.volume, 8.0 * e / 6.0, 1e-15);
        close(q.max_dihedral_angle, PI - 2.0 * (2.0 * e).atan(), 1e-14);
        close(q.aspect_ratio * e, 2.0 * root / 24.0_f64.sqrt(), 1e-14);
        // Heights over the sides' midpoints: 2e over a distance that tends to 1/√2 from either side.
        assert!((q.min_dihedral_angle / e - 8.0_f64.sqrt()).abs() < 10.0 * e * e + 1e-12, "{q:?}");
        assert!(q.mean_ratio > 0.0 && q.radius_ratio > 0.0 && q.radius_ratio < 10.0 * e, "{q:?}");
    }
}

#[test]
fn degenerate_cells_have_defined_values() {
    let zero = Vec3::zeros();
    let cells = [
        [zero; 4],
        [zero, zero, Vec3::x(), Vec3::y()],
        [zero, Vec3::x(), Vec3::x() * 2.0, Vec3::x() * 3.0],
        [zero, Vec3::x(), Vec3::y(), Vec3::x() + Vec3::y()],
        [zero, Vec3::x() * f64::MIN_POSITIVE, Vec3::y() * 1e300, Vec3::z()],
        [Vec3::x() * 1e308, Vec3::x() * -1e308, Vec3::y() * 1e308, Vec3::z()],
    ];
    for cell in cells {
        let q = tet_quality(&cell);
        let all = [q.min_dihedral_angle, q.max_dihedral_angle, q.radius_ratio, q.aspect_ratio, q.mean_ratio];
        assert!(all.iter().all(|x| !x.is_nan()), "{q:?}");
        assert!(q.radius_ratio < 1e-7 && q.mean_ratio < 1e-7 && q.aspect_ratio > 1e7, "{q:?}");
    }
    for cell in [[zero; 3], [zero, zero, Vec3::x()], [zero, Vec3::x(), Vec3::x() * 2.0]] {
        let q = triangle_quality(&cell);
        assert_eq!((q.area, q.min_angle, q.radius_ratio, q.aspect_ratio), (0.0, 0.0, 0.0, f64::INFINITY));
        assert!(!q.max_angle.is_nan());
    }
}

#[test]
fn triangles_have_their_closed_forms() {
    let equilateral = triangle_quality(&[Vec3::x(), Vec3::y(), Vec3::z()]);
    close(equilateral.area, 3.0_f64.sqrt() / 2.0, 1e-15);
    for (value, exact) in [(equilateral.radius_ratio, 1.0), (equilateral.aspect_ratio, 1.0)] {
        close(value, exact, 1e-14);
    }
    close(equilateral.mean_ratio, 1.0, 1e-14);
    close(equilateral.min_angle, FRAC_PI_3, 1e-14);
    // 3-4-5: r = 1, R = 5/2.
    let q = triangle_quality(&[Vec3::zeros(), Vec3::x() * 3.0, Vec3::y() * 4.0]);
    assert_eq!((q.area, q.min_edge, q.max_edge), (6.0, 3.0, 5.0));
    close(q.radius_ratio, 0.8, 1e-14);
    close(q.aspect_ratio, 5.0 / 12.0_f64.sqrt(), 1e-14);
    close(q.mean_ratio, 24.0 * 3.0_f64.sqrt() / 50.0, 1e-14);
    close(q.min_angle, 0.75_f64.atan(), 1e-14);
    close(q.max_angle, FRAC_PI_2, 1e-14);
}

#[test]
fn summary_names_the_worst_cell() {
    let mut list = corner().to_vec();
    list.push(Vec3::new(0.3, 0.3, -1e-3));
    let mesh = TetMesh::new(list, vec![[0, 1, 2, 3], [0, 2, 1, 4]]).unwrap();
    let worst = mesh.quality_summary().unwrap();
    for (value, cell) in
        [(worst.volume, 1), (worst.mean_ratio, 1), (worst.aspect_ratio, 1), (worst.max_edge, 0)]
    {
        assert_eq!(value.cell, cell);
    }
    assert!((worst.volume.value - 1e-3 / 6.0).abs() < 1e-17);
    assert_eq!(TetMesh::default().quality_summary(), None);
}

#[test]
fn constructors_name_the_culprit() {
    let tets = |list: &[[f64; 3]], cells: Vec<[u32; 4]>| TetMesh::new(points(list), cells).unwrap_err();
    let unit = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let kind = CellKind::Tetrahedron;
    assert_eq!(
        tets(&unit, vec![[0, 1, 2, 3], [0, 1, 2, 4]]),
        MeshError::IndexOutOfRange { kind, cell: 1, index: 4, points: 4 }
    );
    assert_eq!(tets(&unit, vec![[0, 1, 0, 3]]), MeshError::RepeatedVertex { kind, cell: 0, vertex: 0 });
    let bad = tets(&[[0.0; 3], [0.0, f64::INFINITY, 0.0]], vec![]);
    assert_eq!(bad.to_string(), "point 1 is at (0, inf, 0), which is not finite");
    let flat = TetMesh::new(
        points(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]]),
        vec![[0, 1, 2, 3]],
    );
    assert_eq!(flat.unwrap().check_orientation(), Err(MeshError::NotPositive { tet: 0, volume: 0.0 }));
    let free = TriMesh::with_codimensional(points(&unit), vec![], vec![], vec![2, 2]).unwrap_err();
    assert_eq!(free, MeshError::RepeatedVertex { kind: CellKind::Point, cell: 1, vertex: 2 });
    let edge = TriMesh::with_codimensional(points(&unit), vec![], vec![[1, 1]], vec![]).unwrap_err();
    assert_eq!(edge, MeshError::RepeatedVertex { kind: CellKind::Edge, cell: 0, vertex: 1 });
    assert!(TetMesh::new(vec![], vec![]).is_ok());
}

#[test]
fn moves_keep_volume_and_failures_keep_the_mesh() {
    let mesh = block(&Vec3::zeros(), &Vec3::new(1.0, 2.0, 3.0), [2, 2, 2], BoxSplit::Five).unwrap();
    let mut moved = mesh.clone();
    moved.rotate(&Rotation3::from_euler_angles(1.0, 2.0, 3.0)).unwrap();
    moved.translate(&Vec3::new(1e3, -2e3, 5.0)).unwrap();
    close(moved.volume(), 6.0, 1e-11);
    moved.check_orientation().unwrap();
    moved.scale(0.5).unwrap();
    close(moved.volume(), 0.75, 1e-11);
    let before = moved.clone();
    assert!(matches!(moved.scale(-1.0), Err(MeshError::BadParameter { .. })));
    assert!(matches!(moved.scale(1e308), Err(MeshError::NonFinitePosition { .. })));
    assert!(matches!(
        moved.translate(&Vec3::new(f64::NAN, 0.0, 0.0)),
        Err(MeshError::NonFinitePosition { .. })
    ));
    assert_eq!(moved, before);
    moved.map_points(|p| Vec3::new(-p.x, p.y, p.z)).unwrap();
    assert_eq!(
        moved.check_orientation().unwrap_err(),
        MeshError::NotPositive { tet: 0, volume: moved.volumes()[0] }
    );
    assert_eq!(moved.orient().len(), 40);
    moved.check_orientation().unwrap();
}

#[test]
fn merged_meshes_weld_into_one() {
    let size = Vec3::new(1.0, 1.0, 1.0);
    let skin = |at: f64| {
        let cube =
            block(&Vec3::new(at, 0.0, 0.0), &(size + Vec3::x() * at), [1, 1, 1], BoxSplit::Six).unwrap();
        Surface::of_tets(&cube).unwrap().into_mesh()
    };
    let mut both = skin(0.0);
    assert_eq!(both.append(&skin(5.0)).unwrap(), 8);
    let components = Surface::of_triangles(&both).components();
    assert_eq!((components.count(), components.euler_characteristics), (2, vec![2, 2]));
    // Touching cubes: after welding, the common face's triangles coincide and its rim has four triangles an edge.
    let mut touching = skin(0.0);
    touching.append(&skin(1.0)).unwrap();
    let renumbered = touching.weld().unwrap();
    assert_eq!((touching.points().len(), renumbered.len()), (12, 16));
    let surface = Surface::of_triangles(&touching);
    // The four sides of the common face and its diagonal.
    assert_eq!(surface.non_manifold_edges().len(), 5);
    assert!(matches!(surface.check_manifold(), Err(MeshError::NonManifoldEdge { count: 4, .. })));
    let mut volume = block(&Vec3::zeros(), &size, [1, 1, 1], BoxSplit::Six).unwrap();
    assert_eq!(volume.append(&volume.clone()).unwrap(), 8);
    assert_eq!(volume.volume(), 2.0);
}

#[test]
fn topology_finds_what_is_wrong_with_a_surface() {
    let tetrahedron = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
    let mut list = corner().to_vec();
    let surface = |list: &[Vec3], t: &[[u32; 3]]| {
        Surface::of_triangles(&TriMesh::new(list.to_vec(), t.to_vec()).unwrap())
    };
    surface(&list, &tetrahedron).check_closed().unwrap();
    let open = surface(&list, &tetrahedron[..3]);
    assert_eq!(open.check_closed(), Err(MeshError::OpenEdge { edge: [0, 2], triangle: 0 }));
    assert_eq!((open.boundary_edges(), open.euler_characteristic()), (vec![[0, 2], [0, 3], [2, 3]], 1));
    let mut turned = tetrahedron.clone();
    turned[2] = [2, 1, 3];
    let opposed = surface(&list, &turned).check_closed().unwrap_err();
    assert_eq!(opposed, MeshError::OpposedTriangles { edge: [1, 2], triangles: [0, 2] });
    // A second tetrahedron that shares only point 0: two fans meet there.
    list.extend(points(&[[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]]));
    let mut bow_tie = tetrahedron.clone();
    bow_tie.extend(tetrahedron.iter().map(|t| t.map(|i| if i == 0 { 0 } else { i + 3 })));
    let bow_tie = surface(&list, &bow_tie);
    assert_eq!(bow_tie.non_manifold_points(), [(0, 2)]);
    assert_eq!(bow_tie.check_closed(), Err(MeshError::NonManifoldVertex { vertex: 0, fans: 2 }));
    assert_eq!(bow_tie.components().count(), 1);
}

#[test]
fn impossible_volume_meshes_have_no_boundary() {
    let mut list = corner().to_vec();
    list.extend(points(&[[1.0, 1.0, 1.0], [2.0, 2.0, 2.0]]));
    let overcrowded = TetMesh::new(list.clone(), vec![[0, 1, 2, 3], [1, 2, 3, 4], [1, 2, 3, 5]]).unwrap();
    assert_eq!(
        Surface::of_tets(&overcrowded).unwrap_err(),
        MeshError::OvercrowdedFace { face: [1, 2, 3], tets: [0, 1, 2] }
    );
    let opposed = TetMesh::new(list, vec![[0, 1, 2, 3], [1, 3, 2, 4]]).unwrap();
    assert_eq!(
        Surface::of_tets(&opposed).unwrap_err(),
        MeshError::OpposedTets { face: [1, 2, 3], tets: [0, 1] }
    );
}

#[test]
fn surfaces_lead_back_to_their_source() {
    let mesh = block(&Vec3::zeros(), &Vec3::new(1.0, 1.0, 1.0), [3, 3, 3], BoxSplit::Six).unwrap();
    let surface = Surface::of_tets(&mesh).unwrap();
    // 4³ points less the 2³ inside.
    assert_eq!((surface.points().len(), surface.source_points().len()), (56, 56));
    for (point, &source) in surface.points().iter().zip(surface.source_points()) {
        assert_eq!(*point, mesh.points()[source as usize]);
    }
    for (triangle, &tet) in surface.triangles().iter().zip(surface.source_cells()) {
        let sources = triangle.map(|i| surface.source_points()[i as usize]);
        assert!(sources.iter().all(|i| mesh.cells()[tet as usize].contains(i)));
    }
    let outward = (0..surface.triangles().len()).all(|t| {
        let [a, b, c] = surface.mesh().corners(t);
        (b - a).cross(&(c - a)).dot(&(a - Vec3::new(0.5, 0.5, 0.5))) > 0.0
    });
    assert!(outward);
    assert!(surface.edges().is_sorted() && surface.edges().iter().all(|e| e[0] < e[1]));
    assert!((surface.edge_areas().iter().sum::<f64>() - 6.0).abs() < 1e-13);
}

#[test]
fn codimensional_parts_are_edges_and_points_of_the_surface() {
    let mut list = corner().to_vec();
    list.extend(points(&[[2.0, 0.0, 0.0], [9.0; 3], [8.0; 3]]));
    let mesh = TriMesh::with_codimensional(list, vec![[0, 1, 2]], vec![[4, 1], [0, 1]], vec![6]).unwrap();
    assert_eq!(mesh.unreferenced_points(), [3, 5]);
    let surface = Surface::of_triangles(&mesh);
    assert_eq!(surface.source_points(), [0, 1, 2, 4, 6]);
    // The free edge 0–1 is one with the triangle's.
    assert_eq!(surface.edges(), [[0, 1], [0, 2], [1, 2], [1, 3]]);
    assert_eq!(surface.components().euler_characteristics, [1, 1]);
    assert_eq!(surface.point_areas(), [1.0 / 6.0, 1.0 / 6.0, 1.0 / 6.0, 0.0, 0.0]);
    assert_eq!(surface.edge_areas()[3], 0.0);
    let mut compact = mesh.clone();
    assert_eq!(compact.remove_unreferenced(), [0, 1, 2, 4, 6]);
    assert_eq!((compact.free_points(), compact.free_edges()), (&[4][..], &[[3, 1], [0, 1]][..]));
}

#[test]
fn volume_far_from_the_origin_loses_nothing_to_cancellation() {
    let mut mesh = sphere(1.0, 16).unwrap();
    let near = mesh.enclosed_volume();
    // 2⁻²² is the rounding of positions near 2³⁰: the volume can be no better than area × that.
    mesh.translate(&Vec3::new(1e9, 1e9, -1e9)).unwrap();
    let error = (mesh.enclosed_volume() - near).abs();
    assert!(error < 1e-6, "{error}");
    let mut ring = torus(1.0, 0.25, 24, 12).unwrap();
    let before = ring.enclosed_volume();
    ring.flip();
    assert_eq!(ring.enclosed_volume(), -before);
}
