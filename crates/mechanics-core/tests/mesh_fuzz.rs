//! Arbitrary bytes never panic a reader, and cost memory and time in proportion to their number only.
//!
//! Starts from the files in tests/corpus, which are replayed first, mutates them with a fixed seed and feeds every
//! reader. `FUZZ_SECONDS` sets the time for each reader (0.5 if unset); `FUZZ_SEED` another sequence. A failing input is
//! written to the temporary folder; it belongs into tests/corpus as `regression_…` when the bug is mended.
#![cfg(feature = "mesh-files")]
#![allow(clippy::unwrap_used)]

#[path = "fuzz/fuzzing.rs"]
mod fuzzing;

use fuzzing::Target;
use mechanics_core::mesh::Surface;
use mechanics_core::mesh::io::{msh, obj, ply, stl};
use std::path::{Path, PathBuf};

fn targets() -> [(&'static str, Target); 4] {
    [
        ("obj", |bytes| obj::read(bytes).is_ok_and(|mesh| use_surface(&Surface::of_triangles(&mesh)))),
        ("stl", |bytes| stl::read(bytes).is_ok_and(|file| use_surface(&Surface::of_triangles(&file.mesh)))),
        ("ply", |bytes| ply::read(bytes).is_ok_and(|mesh| use_surface(&Surface::of_triangles(&mesh)))),
        ("msh", |bytes| {
            msh::read(bytes).is_ok_and(|file| {
                let _ = file.tri_mesh().map(|mesh| use_surface(&Surface::of_triangles(&mesh)));
                file.tet_mesh().is_ok_and(|mesh| {
                    mesh.quality_summary();
                    let _ = Surface::of_tets(&mesh).map(|surface| use_surface(&surface));
                    true
                })
            })
        }),
    ]
}

fn use_surface(surface: &Surface) -> bool {
    let _ = surface.check_closed();
    surface.components().count() > 0
}

/// Bytes of memory for each byte of input, and for an empty one. A polygon of one-byte indices in a PLY file makes a triangle
/// of 12 bytes out of each byte, and vectors that grow hold up to three times what they need.
const MEMORY_FACTOR: isize = 400;
const MEMORY_BASE: isize = 100_000;

fn feed(name: &str, target: Target, bytes: &[u8]) -> bool {
    fuzzing::feed(name, target, bytes, MEMORY_BASE + MEMORY_FACTOR * bytes.len() as isize)
}

fn corpus(name: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus").join(name);
    fuzzing::files(&folder).into_iter().map(|path| (path.clone(), std::fs::read(path).unwrap())).collect()
}

#[test]
fn corpus_replays() {
    for (name, target) in targets() {
        for (path, bytes) in corpus(name) {
            let valid = feed(name, target, &bytes);
            assert!(valid || fuzzing::is_regression(&path), "{} is no longer read", path.display());
        }
    }
}

#[test]
fn every_prefix_of_the_corpus_is_survived_by_every_reader() {
    for (name, target) in targets() {
        for (_, bytes) in targets().iter().flat_map(|(name, _)| corpus(name)) {
            (0..bytes.len()).for_each(|length| {
                feed(name, target, &bytes[..length]);
            });
        }
    }
}

/// Inputs of a megabyte made to find loops within loops, which mutations of small files cannot show.
#[test]
fn large_hostile_inputs_take_linear_time() {
    let many = |piece: &str| piece.repeat(1_000_000 / piece.len());
    let numbered = |piece: &str| (0..40_000).map(|k| piece.replace('#', &k.to_string())).collect::<String>();
    let blanks = " ".repeat(500_000);
    let obj_points = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let ply = "ply\nformat ascii 1.0\n";
    let vertices = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
    let nodes = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";
    let inputs = [
        ("obj", format!("{obj_points}l {}", many("1 2 "))),
        ("obj", format!("{obj_points}f {}", many("1 2 3 "))),
        ("obj", many("\\\n")),
        ("obj", many("p 1\n")),
        ("obj", many("v 0 0 0\n")),
        ("obj", format!("{obj_points}{}", many("f 1 2 3\n"))),
        ("stl", format!("{}{blanks}", many("solid\nendsolid\n"))),
        (
            "stl",
            format!(
                "solid\n{}",
                many(
                    "facet normal 0 0 0 outer loop vertex 0 0 0 vertex 0 0 0 vertex 0 0 0 endloop endfacet "
                )
            ),
        ),
        ("ply", format!("{ply}{}end_header\n", numbered("element e# 0\nproperty float x\n"))),
        ("ply", format!("{ply}{vertices}{}end_header\n", numbered("property float p#\n"))),
        ("ply", format!("{ply}{}end_header\n", many("comment \n"))),
        (
            "ply",
            format!(
                "{ply}{vertices}element face 9999999\nproperty list uint uchar vertex_index\nend_header\n0 0 0 1 0 0 0 1 0 {}",
                many("3 0 1 2 ")
            ),
        ),
        ("msh", format!("{nodes}{}{blanks}", many("$A\n$EndA\n"))),
        ("msh", format!("{nodes}{}", many("$A\n"))),
        ("msh", format!("{nodes}$PhysicalNames\n99999999\n{}", many("1 1 \"a\"\n"))),
        ("msh", format!("{nodes}$Nodes\n99999999 0 0 0\n{}", many("0 1 0 0 "))),
    ];
    for (format, input) in inputs {
        let (name, target) = targets().into_iter().find(|(name, _)| *name == format).unwrap();
        feed(name, target, input.as_bytes());
    }
}

#[test]
fn mutations_are_survived() {
    for (name, target) in targets() {
        let corpus: Vec<Vec<u8>> = corpus(name).into_iter().map(|(_, bytes)| bytes).collect();
        fuzzing::mutations_are_survived(name, &corpus, |bytes| feed(name, target, bytes));
    }
}
