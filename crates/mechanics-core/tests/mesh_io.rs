//! Readers on files that meshio wrote (tests/corpus), round trips through every writer, and messages of errors.
#![cfg(feature = "mesh-files")]
#![allow(clippy::unwrap_used)]

use mechanics_core::mesh::io::ply::{ByteOrder, PlyEncoding};
use mechanics_core::mesh::io::stl::StlEncoding;
use mechanics_core::mesh::io::{MeshFileError, Place, msh, obj, ply, stl};
use mechanics_core::mesh::{Surface, TriMesh, ball, sphere};
use mechanics_core::tensor::Vec3;
use std::path::PathBuf;

/// The mesh of tests/corpus/make_corpus.py.
const POINTS: [[f64; 3]; 5] =
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.5, 0.75, 1.25]];
const TETS: [[u32; 4]; 2] = [[0, 1, 2, 3], [1, 2, 3, 4]];
const TRIANGLES: [[u32; 3]; 6] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 4], [2, 3, 4], [3, 1, 4]];

fn corpus(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/corpus").join(name)
}

fn expected_points() -> Vec<Vec3> {
    POINTS.map(Vec3::from).to_vec()
}

/// The triangles as positions, because STL numbers points in its own way.
fn triangle_positions(mesh: &TriMesh) -> Vec<[Vec3; 3]> {
    (0..mesh.triangles().len()).map(|t| mesh.corners(t)).collect()
}

fn codimensional() -> TriMesh {
    let mut points = expected_points();
    points.extend([Vec3::new(1e-300, -1.0 / 3.0, 1e300), Vec3::new(0.1, 0.2, 0.3), Vec3::new(7.0, 8.0, 9.0)]);
    TriMesh::with_codimensional(points, TRIANGLES.to_vec(), vec![[0, 5], [5, 6]], vec![7]).unwrap()
}

#[test]
fn msh_files_of_meshio_are_read() {
    for name in ["meshio_22_ascii", "meshio_22_binary", "meshio_41_ascii", "meshio_41_binary"] {
        let file = msh::read_file(corpus(&format!("msh/{name}.msh"))).unwrap();
        assert_eq!(file.points, expected_points(), "{name}");
        assert_eq!(file.tets.vertices, TETS, "{name}");
        assert_eq!(file.skipped, []);
        if name.contains("22") {
            assert_eq!(file.triangles.vertices, TRIANGLES);
            assert_eq!((file.tets.groups, file.triangles.groups), (vec![7, 8], vec![3; 6]));
        }
    }
}

#[test]
fn msh_entities_give_groups_and_names_and_tags_may_be_sparse() {
    let file = msh::read_file(corpus("msh/hand_41_gmsh_style.msh")).unwrap();
    assert_eq!((&file.points, &file.tets.vertices[..]), (&expected_points(), &TETS[..]));
    assert_eq!((file.tets.groups.clone(), file.triangles.groups.clone()), (vec![7; 2], vec![3; 6]));
    assert_eq!((file.edges.vertices.clone(), file.edges.groups.clone()), (vec![[0, 1]], vec![0]));
    assert_eq!(file.vertices.vertices, [[0]]);
    let names: Vec<_> = file.groups.iter().map(|g| (g.dimension, g.number, g.name.as_str())).collect();
    assert_eq!(names, [(2, 3, "outer skin"), (3, 7, "body")]);
    // The line is an edge of a triangle and the point a corner of one, so neither is free.
    let mesh = file.tri_mesh().unwrap();
    assert_eq!((mesh.triangles(), mesh.free_edges().len(), mesh.free_points().len()), (&TRIANGLES[..], 0, 0));

    let file = msh::read_file(corpus("msh/hand_41_big_endian.msh")).unwrap();
    assert_eq!((file.points, file.tets.vertices), (expected_points(), TETS.to_vec()));
    assert_eq!(file.tets.groups, [9, 9], "the sign of a physical group is an orientation");
}

#[test]
fn msh_files_of_gmsh_are_read_with_entities_groups_and_parametric_nodes() {
    for name in ["gmsh_22_ascii", "gmsh_22_binary", "gmsh_41_ascii", "gmsh_41_binary"] {
        let file = msh::read_file(corpus(&format!("msh/{name}.msh"))).unwrap();
        let names: Vec<_> = file.groups.iter().map(|g| (g.dimension, g.number, g.name.as_str())).collect();
        assert_eq!(names, [(2, 12, "two sides"), (3, 11, "cube")], "{name}");
        assert_eq!((file.points.len(), file.skipped.len()), (14, 0), "{name}");
        let mut tets = file.tet_mesh().unwrap();
        assert!(file.tets.groups.iter().all(|&g| g == 11));
        tets.orient();
        assert!((tets.volume() - 1.0).abs() < 1e-14, "{name}");
        tets.check_conforming().unwrap();
        let skin = file.tri_mesh().unwrap();
        let sides: f64 =
            skin.areas().iter().zip(&file.triangles.groups).filter(|(_, g)| **g == 12).map(|(a, _)| a).sum();
        assert!((sides - 2.0).abs() < 1e-14, "{name}: {sides}");
        if name.contains("41") {
            // Gmsh wrote the cube's edges and corners as elements too; none of them is a free part.
            assert_eq!((file.vertices.vertices.len(), file.edges.vertices.len()), (8, 12), "{name}");
            assert_eq!((skin.free_edges().len(), skin.free_points().len()), (0, 0));
            assert!((skin.area() - 6.0).abs() < 1e-14);
            Surface::of_triangles(&skin).check_closed().unwrap();
        }
    }
}

#[test]
fn msh_elements_of_other_kinds_are_counted() {
    let file = msh::read_file(corpus("msh/meshio_22_hexahedron.msh")).unwrap();
    assert_eq!(file.skipped, [msh::MshSkipped { element_type: 5, count: 1 }]);
    assert_eq!((file.points.len(), file.triangles.vertices.len()), (8, 1));
}

#[test]
fn stl_files_of_meshio_are_read_and_solid_binary_is_binary() {
    let expected = TriMesh::new(expected_points(), TRIANGLES.to_vec()).unwrap();
    for name in ["meshio_ascii", "meshio_binary", "hand_solid_binary"] {
        let file = stl::read_file(corpus(&format!("stl/{name}.stl"))).unwrap();
        assert_eq!(file.mesh.points().len(), 5, "{name}: welded");
        assert_eq!(triangle_positions(&file.mesh), triangle_positions(&expected), "{name}");
        assert_eq!(file.dropped_facets, []);
        Surface::of_triangles(&file.mesh).check_closed().unwrap();
    }
}

#[test]
fn ply_files_are_read_by_property_name() {
    let expected = TriMesh::new(expected_points(), TRIANGLES.to_vec()).unwrap();
    for name in ["meshio_ascii", "meshio_binary"] {
        assert_eq!(ply::read_file(corpus(&format!("ply/{name}.ply"))).unwrap(), expected, "{name}");
    }
    let big_endian = ply::read_file(corpus("ply/hand_big_endian.ply")).unwrap();
    assert_eq!((big_endian.points(), big_endian.triangles()), (expected.points(), expected.triangles()));
    assert_eq!(big_endian.free_edges(), [[0, 4]]);
    let quads = ply::read_file(corpus("ply/meshio_quads.ply")).unwrap();
    assert_eq!(quads.triangles(), [[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]]);
    assert_eq!(quads.area(), 2.0);
}

#[test]
fn obj_files_are_read_with_every_form_of_index() {
    let expected = TriMesh::new(expected_points(), TRIANGLES.to_vec()).unwrap();
    assert_eq!(obj::read_file(corpus("obj/meshio.obj")).unwrap(), expected);
    let mesh = obj::read_file(corpus("obj/hand.obj")).unwrap();
    assert_eq!(mesh.points().len(), 6);
    assert_eq!(mesh.triangles(), [[0, 1, 2], [0, 2, 3], [4, 0, 1]]);
    assert_eq!((mesh.free_edges(), mesh.free_points()), (&[[0, 4], [4, 5]][..], &[5][..]));
}

#[test]
fn every_writer_reads_back_bit_by_bit() {
    let mesh = codimensional();
    let mut bytes = Vec::new();
    obj::write(&mesh, &mut bytes).unwrap();
    assert_eq!(obj::read(&bytes).unwrap(), mesh);

    let (points, triangles) = (mesh.points().to_vec(), mesh.triangles().to_vec());
    let edges = TriMesh::with_codimensional(points, triangles, mesh.free_edges().to_vec(), vec![]).unwrap();
    let encodings = [
        PlyEncoding::Ascii,
        PlyEncoding::Binary(ByteOrder::LittleEndian),
        PlyEncoding::Binary(ByteOrder::BigEndian),
    ];
    for encoding in encodings {
        let mut bytes = Vec::new();
        ply::write(&edges, encoding, &mut bytes).unwrap();
        assert_eq!(ply::read(&bytes).unwrap(), edges);
        assert!(matches!(
            ply::write(&mesh, encoding, &mut bytes),
            Err(MeshFileError::NotRepresentable { .. })
        ));
    }

    let mut file = msh::MshMesh::from(&mesh);
    file.tets.vertices = TETS.to_vec();
    file.tets.groups = vec![4, 0];
    file.groups = vec![msh::MshGroup { dimension: 3, number: 4, name: "ä b".into() }];
    for version in [msh::MshVersion::V2_2, msh::MshVersion::V4_1] {
        for encoding in [msh::MshEncoding::Ascii, msh::MshEncoding::Binary] {
            for grouped in [true, false] {
                file.tets.groups = if grouped { vec![0, 4] } else { vec![0, 0] };
                let mut bytes = Vec::new();
                msh::write(&file, version, encoding, &mut bytes).unwrap();
                let back = msh::read(&bytes).unwrap();
                assert_eq!(back, file, "{version:?} {encoding:?}");
                assert_eq!(back.tri_mesh().unwrap(), mesh);
            }
        }
    }
}

#[test]
fn stl_round_trips_and_drops_are_reported() {
    let mesh = sphere(0.37, 3).unwrap();
    let mut bytes = Vec::new();
    stl::write(&mesh, StlEncoding::Ascii, &mut bytes).unwrap();
    assert_eq!(triangle_positions(&stl::read(&bytes).unwrap().mesh), triangle_positions(&mesh));
    let mut bytes = Vec::new();
    stl::write(&mesh, StlEncoding::Binary, &mut bytes).unwrap();
    let back = stl::read(&bytes).unwrap().mesh;
    assert_eq!((back.points().len(), back.triangles().len()), (mesh.points().len(), mesh.triangles().len()));
    assert!((back.enclosed_volume() - mesh.enclosed_volume()).abs() < 1e-7 * mesh.enclosed_volume());

    // The second triangle collapses when coordinates are rounded to f32, and −0 is +0.
    let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1e-12, 0.0], [1.0 + 1e-12, 0.0, -0.0]];
    let mesh = TriMesh::new(points.map(Vec3::from).to_vec(), vec![[0, 1, 2], [1, 4, 2], [0, 2, 4]]).unwrap();
    let mut bytes = Vec::new();
    stl::write(&mesh, StlEncoding::Binary, &mut bytes).unwrap();
    let back = stl::read(&bytes).unwrap();
    assert_eq!((back.dropped_facets, back.mesh.points().len()), (vec![1], 3));

    let huge =
        TriMesh::new([[1e39, 0.0, 0.0], [0.0; 3], [0.0, 1.0, 0.0]].map(Vec3::from).to_vec(), vec![[0, 1, 2]]);
    let refused = stl::write(&huge.unwrap(), StlEncoding::Binary, &mut Vec::new());
    assert!(matches!(refused, Err(MeshFileError::NotRepresentable { .. })));
}

#[test]
fn errors_name_place_and_value() {
    let obj_error = |text: &str| obj::read(text.as_bytes()).unwrap_err().to_string();
    assert_eq!(
        obj_error("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n"),
        "OBJ, line 4: found \"4\" in a file of 3 vertices, expected the index of a vertex: from 1 up, or from −1 \
         down counting back from here"
    );
    assert_eq!(obj_error("v 0 x 0\n"), "OBJ, line 1: found \"x\", expected a finite number");
    assert_eq!(obj_error("v 0 1e999 0\n"), "OBJ, line 1: found \"1e999\", expected a finite number");
    assert_eq!(
        obj_error("\r\nv 0 1\r\n"),
        "OBJ, line 2: found 2 numbers, expected 3 coordinates of a vertex"
    );
    assert!(obj_error("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 2").contains("line 4: found vertex 2 twice"));
    assert!(obj_error("v 0 0 0\nf 0 0 0").contains("\"0\""));
    assert!(obj_error("v 0 0 0\nf -2 -1 -1").contains("\"-2\""));
    assert!(obj_error("curv 0 1 1 2").contains("free-form"));

    let stl_error = |text: &str| stl::read(text.as_bytes()).unwrap_err().to_string();
    let facet = "solid a\nfacet normal 0 0 nan\nouter loop\nvertex 0 0 0\nvertex 1 0 inf\n";
    assert_eq!(stl_error(facet), "STL, line 5: found \"inf\", expected a finite number");
    assert_eq!(stl_error("solid\nfoo"), "STL, line 2: found \"foo\", expected \"facet\" or \"endsolid\"");
    assert_eq!(
        stl_error("hello"),
        "STL, byte 0: found 5 bytes that do not begin with \"solid\", expected at least 84 bytes"
    );

    let ply_error = |text: &str| ply::read(text.as_bytes()).unwrap_err().to_string();
    let header =
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
    let face = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    assert_eq!(
        ply_error(&format!("{header}{face}0 0 0\n3 0 0 1\n")),
        "PLY, line 11: found the index 1 just before, with 1 vertices, expected the index of a vertex, from 0"
    );
    assert_eq!(
        ply_error(&format!("{header}{face}0 0 0\n300 0 0 1\n")),
        "PLY, line 11: found \"300\", expected an integer in the range of its type"
    );
    assert!(ply_error(&header.replace("float z", "float w")).contains("end_header"));
    let without_z = header.replace("float z", "float w") + face;
    assert!(ply_error(&without_z).contains("element \"vertex\" without a number \"z\""));

    let msh_error = |text: &str| msh::read(text.as_bytes()).unwrap_err().to_string();
    assert_eq!(
        msh_error("$MeshFormat\n4.0 0 8\n"),
        "MSH, line 2: version \"4.0\" is not supported; 2.2 and 4.1 are"
    );
    let nodes = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n1\n1 0 0 0\n$EndNodes\n";
    let missing = format!("{nodes}$Elements\n1\n1 15 0 2\n$EndElements\n");
    assert_eq!(
        msh_error(&missing),
        "MSH, line 10: found the node 2 in an element, expected the number of a node"
    );
    assert_eq!(
        msh_error(&nodes.replace("0 0 0", "0 0 ?")),
        "MSH, line 6: found \"?\", expected a coordinate"
    );
}

#[test]
fn claims_of_size_are_not_believed() {
    let huge = u32::MAX;
    let ply = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {huge}\nproperty float x\nproperty float y\nproperty float z\nend_header\nabc"
    );
    assert!(matches!(ply::read(ply.as_bytes()), Err(MeshFileError::Syntax { place: Place::Byte(_), .. })));
    let empty_rows = "ply\nformat ascii 1.0\nelement void 18446744073709551615\nend_header\n";
    assert!(ply::read(empty_rows.as_bytes()).is_err());
    for version in ["2.2", "4.1"] {
        let msh = format!("$MeshFormat\n{version} 0 8\n$EndMeshFormat\n$Nodes\n18446744073709551615\n");
        assert!(msh::read(msh.as_bytes()).is_err());
    }
    let mut stl = vec![0_u8; 84];
    stl[80..84].copy_from_slice(&huge.to_le_bytes());
    assert!(matches!(stl::read(&stl), Err(MeshFileError::Syntax { place: Place::Byte(80), .. })));
}

#[test]
fn files_appear_whole_or_not_at_all() {
    let folder = std::env::temp_dir().join(format!("mechanics-core-mesh-io-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("mesh.ply");
    let mesh = TriMesh::new(expected_points(), TRIANGLES.to_vec()).unwrap();
    ply::write_file(&mesh, PlyEncoding::Ascii, &path).unwrap();
    // Free points are refused after the file was begun: the old one stays, and nothing is left beside it.
    assert!(ply::write_file(&codimensional(), PlyEncoding::Ascii, &path).is_err());
    assert_eq!(ply::read_file(&path).unwrap(), mesh);
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1);
    let missing = ply::write_file(&mesh, PlyEncoding::Ascii, folder.join("no/such/folder.ply")).unwrap_err();
    assert!(missing.to_string().contains("no/such/folder.ply"), "{missing}");
    assert!(matches!(obj::read_file(folder.join("nothing.obj")), Err(MeshFileError::System { .. })));
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn large_meshes_survive_every_format() {
    let mesh = ball(1.0, 12).unwrap();
    let mut bytes = Vec::new();
    msh::write(&(&mesh).into(), msh::MshVersion::V4_1, msh::MshEncoding::Binary, &mut bytes).unwrap();
    assert_eq!(msh::read(&bytes).unwrap().tet_mesh().unwrap(), mesh);
    let skin = Surface::of_tets(&mesh).unwrap().into_mesh();
    let mut bytes = Vec::new();
    obj::write(&skin, &mut bytes).unwrap();
    assert_eq!(obj::read(&bytes).unwrap(), skin);
}
