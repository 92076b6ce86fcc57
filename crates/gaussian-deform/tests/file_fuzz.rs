//! Arbitrary bytes never panic a reader of scenes or cameras, and cost memory and time in proportion to their number only.
//!
//! As the readers of meshes are tried in mechanics-core: the files in tests/corpus are replayed, then mutated with a fixed seed.
//! `FUZZ_SECONDS` sets the time for each reader (0.5 if unset); `FUZZ_SEED` another sequence. A failing input is
//! written to the temporary folder; it belongs into tests/corpus as `regression_…` when the bug is mended.
#![cfg(feature = "spz")]
#![allow(clippy::unwrap_used)]

#[path = "../../mechanics-core/tests/fuzz/fuzzing.rs"]
mod fuzzing;

use fuzzing::Target;
use gaussian_deform::Splats;
use gaussian_deform::camera::{NamedCamera, cameras_from_json};
use gaussian_deform::file::{FileError, ply, splat, spz};
use mechanics_core::tensor::Vec3;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

fn targets() -> [(&'static str, Target); 5] {
    [
        ("ply", |bytes| is_usable(ply::read(bytes))),
        ("splat", |bytes| is_usable(splat::read(bytes))),
        ("spz", |bytes| is_usable(spz::read(bytes))),
        // Mutations of what is inside the compression.
        ("spz_plain", |bytes| is_usable(spz::read(&compressed(bytes)))),
        ("cameras", |bytes| std::str::from_utf8(bytes).is_ok_and(can_be_drawn_with)),
    ]
}

fn compressed(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::none());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// A camera that has been read projects every point in front of it somewhere.
fn can_be_drawn_with(text: &str) -> bool {
    let Ok(cameras) = cameras_from_json(text) else { return false };
    for NamedCamera { camera, .. } in cameras {
        let point = camera.eye() + camera.rotation().transpose() * Vec3::z();
        // Far away a step of one metre may vanish.
        assert!(camera.eye().amax() > 1e9 || camera.project(&point).is_some());
    }
    true
}

/// What has been read can be computed with, and written.
fn is_usable(scene: Result<Splats, FileError>) -> bool {
    let Ok(scene) = scene else { return false };
    scene.check().unwrap();
    // Scales up to 1e15 are read; what is written must be a little smaller.
    let _ = ply::write(&scene, ply::PlyEncoding::BinaryLittleEndian, &mut std::io::sink());
    true
}

/// Bytes of memory for each byte of input, and for an empty one.
const MEMORY_FACTOR: isize = 400;
/// For compressed input: a byte may stand for 1,032, and each makes up to four.
const COMPRESSED_FACTOR: isize = 8000;
/// The compressor and the decompressor take half a megabyte whatever they are given.
const MEMORY_BASE: isize = 800_000;
/// Zstandard may ask for a window of eight megabytes for any stream.
const WINDOW: isize = 20_000_000;

fn feed(name: &str, target: Target, bytes: &[u8]) -> bool {
    let (factor, base) =
        if name == "spz" { (COMPRESSED_FACTOR, WINDOW) } else { (MEMORY_FACTOR, MEMORY_BASE) };
    fuzzing::feed(name, target, bytes, base + factor * bytes.len() as isize)
}

fn corpus(name: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let folder = name.strip_suffix("_plain").unwrap_or(name);
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus").join(folder);
    let files = fuzzing::files(&folder).into_iter();
    files.filter_map(|path| content(name, &path).map(|bytes| (path, bytes))).collect()
}

fn content(name: &str, path: &Path) -> Option<Vec<u8>> {
    let bytes = std::fs::read(path).unwrap();
    if !name.ends_with("_plain") {
        return Some(bytes);
    }
    // Version 4 has nothing around it.
    let mut plain = Vec::new();
    flate2::read::GzDecoder::new(&bytes[..]).read_to_end(&mut plain).ok().map(|_| plain)
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

/// Inputs of a megabyte made to find loops within loops, and bytes that stand for many.
#[test]
fn large_hostile_inputs_take_linear_time() {
    let numbered = |piece: &str| (0..40_000).map(|k| piece.replace('#', &k.to_string())).collect::<String>();
    let start = "ply\nformat ascii 1.0\n";
    let inputs = [
        ("ply", format!("{start}{}end_header\n", numbered("element e# 0\nproperty float x\n")).into_bytes()),
        (
            "ply",
            format!("{start}element vertex 1\n{}end_header\n", numbered("property float p#\n")).into_bytes(),
        ),
        ("ply", format!("{start}{}end_header\n", "comment \n".repeat(100_000)).into_bytes()),
        (
            "ply",
            format!("{start}element e 99999999999\nelement vertex 99999999\nproperty float x\nend_header\n")
                .into_bytes(),
        ),
        ("ply", format!("{start}element vertex 1\n{}", "property float x ".repeat(60_000)).into_bytes()),
        ("splat", vec![0x80; 1_000_000]),
        ("spz", compressed_well(&vec![0; 100_000_000])),
        (
            "spz",
            compressed_well(
                &[b"NGSP\x02\0\0\0\xff\xff\xff\xff\x03\x0c\0\0", &vec![0; 100_000_000][..]].concat(),
            ),
        ),
        ("spz", version_4(u32::MAX, 1_000_000)),
        ("spz", version_4(40_000_000, 1_000_000)),
        ("cameras", vec![b'['; 1_000_000]),
        ("cameras", "[1,".repeat(300_000).into_bytes()),
    ];
    for (format, input) in inputs {
        let (name, target) = targets().into_iter().find(|(name, _)| *name == format).unwrap();
        feed(name, target, &input);
    }
}

/// A header of version 4 that claims so many Gaussians, a table that says the same, and zeros.
fn version_4(claimed: u32, size: usize) -> Vec<u8> {
    let mut bytes = [b"NGSP\x04\0\0\0", &claimed.to_le_bytes()[..], b"\0\x0c\0\x05\x20\0\0\0"].concat();
    bytes.resize(32, 0);
    for width in [9, 1, 3, 3, 4] {
        bytes.extend((size as u64 / 5).to_le_bytes());
        bytes.extend((u64::from(claimed) * width).to_le_bytes());
    }
    // The start of a frame with a window as large as can be written.
    bytes.extend(b"\x28\xb5\x2f\xfd\x00\xff");
    bytes.resize(size, 0);
    bytes
}

fn compressed_well(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

#[test]
fn mutations_are_survived() {
    for (name, target) in targets() {
        let corpus: Vec<Vec<u8>> = corpus(name).into_iter().map(|(_, bytes)| bytes).collect();
        fuzzing::mutations_are_survived(name, &corpus, |bytes| feed(name, target, bytes));
    }
}
