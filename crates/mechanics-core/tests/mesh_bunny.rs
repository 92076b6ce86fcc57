//! The Stanford bunny (tests/assets/meshes at the top of the workspace) as a real input.
#![cfg(feature = "mesh-files")]
#![allow(clippy::unwrap_used)]

use mechanics_core::mesh::io::{msh, obj};
use mechanics_core::mesh::{Surface, TetMesh};
use std::path::PathBuf;

fn asset(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../tests/assets/meshes").join(name)
}

fn bunny_tets() -> TetMesh {
    msh::read_file(asset("bunny_tet.msh")).unwrap().tet_mesh().unwrap()
}

#[test]
fn bunny_surface_is_a_closed_sphere_in_topology() {
    let mesh = obj::read_file(asset("bunny.obj")).unwrap();
    assert_eq!((mesh.points().len(), mesh.triangles().len()), (1839, 3674));
    let surface = Surface::of_triangles(&mesh);
    surface.check_closed().unwrap();
    assert_eq!(surface.edges().len(), 3 * 3674 / 2);
    assert_eq!((surface.euler_characteristic(), surface.components().count()), (2, 1));
    assert!(surface.volume() > 0.0, "normals point outwards");
}

#[test]
fn bunny_tets_are_positive_conforming_and_fill_the_surface() {
    let mesh = bunny_tets();
    assert_eq!((mesh.points().len(), mesh.cells().len()), (2248, 7419));
    mesh.check_orientation().unwrap();
    mesh.check_conforming().unwrap();
    assert_eq!(mesh.clone().orient(), [], "nothing to turn");
    assert_eq!(mesh.unreferenced_points(), []);
    let skin = Surface::of_tets(&mesh).unwrap();
    skin.check_closed().unwrap();
    assert_eq!((skin.euler_characteristic(), skin.components().count()), (2, 1));
    assert!((skin.volume() - mesh.volume()).abs() < 1e-12 * mesh.volume());

    let surface = Surface::of_triangles(&obj::read_file(asset("bunny.obj")).unwrap());
    let ratio = mesh.volume() / surface.volume();
    println!(
        "volume of the surface {:.6}, of the tetrahedra {:.6}, ratio {ratio:.6}",
        surface.volume(),
        mesh.volume()
    );
    // fTetWild keeps the skin within an envelope of 1e-3 of the diagonal, so the volume within area × that.
    let envelope = 1e-3 * surface.mesh().bounding_box().unwrap().size().norm();
    assert!((mesh.volume() - surface.volume()).abs() < envelope * surface.area());
    let (a, b) = (mesh.bounding_box().unwrap(), surface.mesh().bounding_box().unwrap());
    assert!((a.min - b.min).amax() < envelope && (a.max - b.max).amax() < envelope);
}

#[test]
fn turned_tets_are_found_and_mended_not_hidden() {
    let (points, mut cells) = bunny_tets().into_parts();
    cells[17].swap(0, 1);
    cells[4000].swap(2, 3);
    let mut mesh = TetMesh::new(points, cells).unwrap();
    let error = mesh.check_orientation().unwrap_err().to_string();
    assert!(error.starts_with("tetrahedron 17 has the volume -"), "{error}");
    assert!(mesh.check_conforming().unwrap_err().to_string().contains("one of them is inverted"));
    assert_eq!(mesh.orient(), [17, 4000]);
    mesh.check_orientation().unwrap();
    mesh.check_conforming().unwrap();
}
