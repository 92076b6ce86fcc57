//! Signed distances of meshes against closed forms and another library; meshes that are no colliders.

use crate::parry::Parry;
use mechanics_core::mesh::{
    BoxSplit, Diagonals, MeshError, Surface, TriMesh, block, io, sheet, sphere, torus,
};
use mechanics_core::tensor::Vec3;
use mpm_core::collider::{Side, SignedDistance};
use mpm_core::{ColliderError, SheetMesh, SolidMesh};
use std::path::Path;

pub(crate) fn bunny() -> TriMesh {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/assets/meshes");
    io::obj::read_file(assets.join("bunny.obj")).unwrap()
}

/// The surface of a box.
pub(crate) fn cuboid(low: Vec3, high: Vec3, cells: u32) -> TriMesh {
    Surface::of_tets(&block(&low, &high, [cells; 3], BoxSplit::default()).unwrap()).unwrap().into_mesh()
}

/// Places in a box, by a sequence that fills it evenly.
pub(crate) fn places(count: usize, middle: Vec3, half: Vec3) -> Vec<Vec3> {
    // The roots of x⁴ = x + 1.
    let steps = Vec3::new(0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_2);
    let unit = |k: usize| (steps * (k as f64 + 1.0)).map(|x| 2.0 * x.fract() - 1.0);
    (0..count).map(|k| middle + unit(k).component_mul(&half)).collect()
}

#[test]
fn distances_are_those_of_another_library() {
    let tiny = |mut mesh: TriMesh, factor: f64| {
        mesh.scale(factor).unwrap();
        mesh
    };
    let meshes = [
        (torus(1.0, 0.3, 24, 12).unwrap(), "torus"),
        (bunny(), "bunny"),
        (tiny(sphere(1.0, 6).unwrap(), 1e-6), "tiny ball"),
        (tiny(torus(1.0, 0.3, 24, 12).unwrap(), 1e6), "huge torus"),
    ];
    for (mesh, name) in meshes {
        let (solid, parry) = (SolidMesh::new(&mesh).unwrap(), Parry::new(&mesh));
        let bounds = mesh.bounding_box().unwrap();
        let size = bounds.size().norm();
        let (mut off, mut turned) = (0.0_f64, 0.0_f64);
        for place in places(4000, bounds.centre(), bounds.size() * 0.8) {
            let found = solid.signed_distance(place.into());
            let (distance, normal) = parry.signed_distance(&place);
            off = off.max((found.distance - distance).abs() / size);
            // Near the medial axis the nearest points differ, and normals with them.
            let ahead = solid.signed_distance((place + found.normal * 1e-3 * size).into()).distance;
            if (ahead - found.distance - 1e-3 * size).abs() < 1e-9 * size && distance.abs() > 1e-6 * size {
                turned = turned.max((found.normal - normal).norm());
            }
        }
        println!("{name}: distances differ by {off:.1e} of the size, normals by {turned:.1e}");
        assert!(off < 1e-12 && turned < 1e-6, "{name}: {off:e}, {turned:e}");
    }
}

/// Of a box, inside and outside, and on faces, edges and corners.
#[test]
fn the_distance_of_a_box_is_its_closed_form() {
    let half = Vec3::new(0.5, 0.3, 0.7);
    let solid = SolidMesh::new(&cuboid(-half, half, 3)).unwrap();
    let exact = |place: &Vec3| {
        let q = place.abs() - half;
        q.sup(&Vec3::zeros()).norm() + q.max().min(0.0)
    };
    for place in places(2000, Vec3::zeros(), half * 2.0) {
        let found = solid.signed_distance(place.into());
        assert!((found.distance - exact(&place)).abs() < 1e-14, "{place}: {found:?}");
        assert!((found.normal.norm() - 1.0).abs() < 1e-14);
    }
    for place in [Vec3::new(0.5, 0.1, 0.1), Vec3::new(0.5, 0.3, 0.05), half, -half] {
        let SignedDistance { distance, normal, nearest } = solid.signed_distance(place.into());
        assert!(distance.abs() < 1e-15 && nearest == Side::Surface);
        assert!(normal.dot(&place) > 0.0 && (normal.norm() - 1.0).abs() < 1e-12, "{place}: {normal}");
    }
}

/// Beyond its rim a sheet has no sides; else the side is that of the triangles' normals.
#[test]
fn sheets_have_two_sides_and_a_rim() {
    let sheet = SheetMesh::new(&sheet([2.0, 1.0], [4, 3], Diagonals::Alternating).unwrap()).unwrap();
    for place in places(500, Vec3::new(1.0, 0.5, 0.0), Vec3::new(2.0, 1.0, 1.0)) {
        let found = sheet.signed_distance(place.into());
        let over = (0.0..=2.0).contains(&place.x) && (0.0..=1.0).contains(&place.y);
        assert_eq!(found.nearest == Side::Surface, over, "{place}");
        if over {
            assert!((found.distance - place.z).abs() < 1e-15);
            assert!((found.normal - Vec3::z()).norm() < 1e-12);
        }
    }
}

#[test]
fn meshes_that_are_no_colliders_are_refused_by_their_culprits() {
    let ball = sphere(1.0, 4).unwrap();
    let moved = |mesh: &TriMesh, by: f64| {
        let mut mesh = mesh.clone();
        mesh.translate(&Vec3::new(by, 0.0, 0.0)).unwrap();
        mesh
    };
    let both = |first: &TriMesh, second: &TriMesh| {
        let mut both = first.clone();
        both.append(second).unwrap();
        both
    };
    let flipped = |mesh: &TriMesh| {
        let mut mesh = mesh.clone();
        mesh.flip();
        mesh
    };
    let solid = |mesh: &TriMesh| SolidMesh::new(mesh).map(|_| ()).unwrap_err();

    let open = TriMesh::new(ball.points().to_vec(), ball.triangles()[1..].to_vec()).unwrap();
    let hole = ball.triangles()[0];
    match solid(&open) {
        ColliderError::Mesh(MeshError::OpenEdge { edge, .. }) => {
            assert!(edge.iter().all(|point| hole.contains(point)));
        }
        other => panic!("{other}"),
    }
    assert!(SheetMesh::new(&open).is_ok());
    let nan = TriMesh::new(vec![Vec3::repeat(f64::NAN); 3], vec![[0, 1, 2]]);
    assert!(matches!(nan, Err(MeshError::NonFinitePosition { point: 0, .. })));
    let none = TriMesh::new(Vec::new(), Vec::new()).unwrap();
    assert_eq!(solid(&none), ColliderError::Empty);
    let flat = vec![Vec3::zeros(), Vec3::x(), Vec3::x() * 2.0];
    let flat = SheetMesh::new(&TriMesh::new(flat, vec![[0, 1, 2]]).unwrap()).map(|_| ());
    assert!(matches!(flat, Err(ColliderError::Flat { triangle: 0, area: 0.0 })));

    // Two balls: apart, through each other, one in the other; the same point twice.
    assert!(SolidMesh::new(&both(&ball, &moved(&ball, 2.5))).is_ok());
    let count = ball.triangles().len();
    match solid(&both(&ball, &moved(&ball, 0.5))) {
        ColliderError::SelfIntersection { triangles: [first, second] } => {
            assert!(first < count && second >= count);
        }
        other => panic!("{other}"),
    }
    let small = {
        let mut small = ball.clone();
        small.scale(0.5).unwrap();
        small
    };
    assert!(SolidMesh::new(&both(&ball, &flipped(&small))).is_ok());
    assert!(
        matches!(solid(&both(&ball, &small)), ColliderError::InsideOut { triangle, .. } if triangle == count)
    );
    let turned = both(&ball, &flipped(&moved(&small, 3.0)));
    assert!(matches!(solid(&turned), ColliderError::InsideOut { triangle, .. } if triangle == count));
    // Wholly inside out is only the other way round.
    let inverse = SolidMesh::new(&flipped(&ball)).unwrap();
    assert!(inverse.signed_distance([0.0; 3]).distance < -0.9);

    // Boxes that share a face, an edge, a corner: they lie on each other.
    let cube = cuboid(Vec3::zeros(), Vec3::repeat(1.0), 1);
    for by in [Vec3::x(), Vec3::new(1.0, 1.0, 0.0), Vec3::repeat(1.0), Vec3::new(1.0, 0.5, 0.0)] {
        let mut other = cube.clone();
        other.translate(&by).unwrap();
        assert!(matches!(solid(&both(&cube, &other)), ColliderError::SelfIntersection { .. }), "{by}");
    }
    // A fold, and a triangle through another one of its corner.
    let points = |list: &[[f64; 3]]| list.iter().map(|p| Vec3::from(*p)).collect::<Vec<_>>();
    let folded = points(&[[0.0; 3], [1.0, 0.0, 0.0], [0.3, 1.0, 0.0], [0.5, 0.6, 0.0]]);
    let folded = TriMesh::new(folded, vec![[0, 1, 2], [1, 0, 3]]).unwrap();
    let pierced = points(&[
        [0.0; 3],
        [2.0, 0.0, 0.0],
        [0.0, 2.0, 0.0],
        [1.0, 1.0, 1.0],
        [0.4, 0.4, -1.0],
        [3.0, 3.0, 1.0],
    ]);
    let pierced = TriMesh::new(pierced, vec![[0, 1, 2], [3, 5, 4]]).unwrap();
    let around = points(&[[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [1.0, 0.2, 0.5], [0.2, 1.0, -0.5]]);
    let around = TriMesh::new(around, vec![[0, 1, 2], [0, 3, 4]]).unwrap();
    for mesh in [folded, pierced, around] {
        let error = SheetMesh::new(&mesh).map(|_| ()).unwrap_err();
        assert!(
            matches!(error, ColliderError::SelfIntersection { triangles: [0, 1] })
                || matches!(error, ColliderError::Mesh(MeshError::NonManifoldVertex { .. })),
            "{error}"
        );
    }
}
