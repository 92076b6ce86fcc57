//! Arbitrary bytes never panic a reader, and cost memory and time in proportion to their number only.
//!
//! Starts from the files in tests/corpus, which are replayed first, mutates them with a fixed seed and feeds every
//! reader. `FUZZ_SECONDS` sets the time for each reader (0.5 if unset); `FUZZ_SEED` another sequence. A failing input is
//! written to the temporary folder; it belongs into tests/corpus as `regression_…` when the bug is mended.
#![cfg(feature = "mesh-files")]
#![allow(clippy::unwrap_used)]
// A counting allocator is the only way to see what a reader asks for and does not touch; its trait is unsafe.
#![allow(unsafe_code)]

use mechanics_core::mesh::Surface;
use mechanics_core::mesh::io::{msh, obj, ply, stl};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Counts the bytes that the current thread holds, and their peak.
struct Counting;

thread_local! {
    static HELD: Cell<isize> = const { Cell::new(0) };
    static PEAK: Cell<isize> = const { Cell::new(0) };
}

fn count(change: isize) {
    // During a thread's end the counters may be gone.
    let _ = HELD.try_with(|held| {
        held.set(held.get() + change);
        let _ = PEAK.try_with(|peak| peak.set(peak.get().max(held.get())));
    });
}

unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size() as isize);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        count(-(layout.size() as isize));
        unsafe { System.dealloc(memory, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Sebastiano Vigna's splitmix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, bound: usize) -> usize {
        if bound == 0 { 0 } else { (self.next() % bound as u64) as usize }
    }

    fn range(&mut self, length: usize) -> std::ops::Range<usize> {
        let start = self.below(length + 1);
        // Mostly short pieces, sometimes long ones.
        let longest = if self.below(4) == 0 { length } else { 16 };
        start..(start + self.below(longest + 1)).min(length)
    }
}

/// One to six changes: flipped bits, truncation, numbers replaced by extreme ones, blocks doubled, removed, moved over from
/// another file.
fn mutate(random: &mut Random, seed: &[u8], other: &[u8]) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    for _ in 0..=random.below(6) {
        match random.below(8) {
            0 if !bytes.is_empty() => {
                let k = random.below(bytes.len());
                bytes[k] ^= 1 << random.below(8);
            }
            1 => bytes.truncate(random.below(bytes.len() + 1)),
            2 => replace_text_number(random, &mut bytes),
            3 => replace_binary_number(random, &mut bytes),
            4 => {
                let block = bytes[random.range(bytes.len())].to_vec();
                let at = random.below(bytes.len() + 1);
                bytes.splice(at..at, block);
            }
            5 => {
                let removed = random.range(bytes.len());
                bytes.drain(removed);
            }
            6 => {
                let (target, source) = (random.range(bytes.len()), random.range(other.len()));
                bytes.splice(target, other[source].iter().copied());
            }
            _ => {
                let k = random.below(bytes.len() + 1);
                bytes.insert(k, random.next() as u8);
            }
        }
    }
    bytes.truncate(1 << 16);
    bytes
}

fn replace_text_number(random: &mut Random, bytes: &mut Vec<u8>) {
    const EXTREME: [&str; 18] = [
        "0",
        "-1",
        "1",
        "2",
        "4",
        "127",
        "255",
        "65536",
        "2147483647",
        "-2147483648",
        "4294967295",
        "4294967296",
        "9223372036854775807",
        "-9223372036854775808",
        "18446744073709551615",
        "1e308",
        "nan",
        "-inf",
    ];
    let is_number = |b: &u8| b.is_ascii_digit() || b"+-.e".contains(b);
    let starts: Vec<usize> =
        (0..bytes.len()).filter(|&k| is_number(&bytes[k]) && (k == 0 || !is_number(&bytes[k - 1]))).collect();
    if starts.is_empty() {
        return;
    }
    let start = starts[random.below(starts.len())];
    let length = bytes[start..].iter().take_while(|b| is_number(b)).count();
    bytes.splice(start..start + length, EXTREME[random.below(EXTREME.len())].bytes());
}

fn replace_binary_number(random: &mut Random, bytes: &mut [u8]) {
    const EXTREME: [u64; 8] =
        [0, 1, u64::MAX, 1 << 31, (1 << 31) - 1, 1 << 63, u32::MAX as u64, 0x7ff0 << 48];
    let (value, width) = (EXTREME[random.below(8)], [1, 2, 4, 8][random.below(4)]);
    if bytes.len() >= width {
        let at = random.below(bytes.len() - width + 1);
        let mut piece = value.to_le_bytes();
        if random.below(2) == 0 {
            piece[..width].reverse();
        }
        bytes[at..at + width].copy_from_slice(&piece[..width]);
    }
}

/// Reads, and uses what was read, since a mesh that is valid must be usable. Answers whether it was valid.
type Target = fn(&[u8]) -> bool;

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
const LONGEST: Duration = Duration::from_secs(2);

fn feed(name: &str, target: Target, bytes: &[u8]) -> bool {
    let held = HELD.get();
    PEAK.set(held);
    let start = Instant::now();
    let outcome = std::panic::catch_unwind(|| target(bytes));
    let (peak, time) = (PEAK.get() - held, start.elapsed());
    let allowed = MEMORY_BASE + MEMORY_FACTOR * bytes.len() as isize;
    let complaint = match outcome {
        Err(_) => "panicked".to_string(),
        Ok(_) if peak > allowed => format!("held {peak} bytes for {} bytes of input", bytes.len()),
        Ok(_) if time > LONGEST => format!("took {time:?}"),
        Ok(valid) => return valid,
    };
    let path = std::env::temp_dir().join(format!("regression_{name}_{}", std::process::id()));
    std::fs::write(&path, bytes).unwrap();
    panic!("the {name} reader {complaint}; the input is in {}", path.display());
}

fn corpus(name: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus").join(name);
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files.into_iter().map(|path| (path.clone(), std::fs::read(path).unwrap())).collect()
}

/// Feeds a reader mutations of its corpus until the time is over; answers how many, and how many were valid.
fn fuzz(name: &str, target: Target, seed: u64, budget: Duration) -> (usize, usize) {
    let seeds: Vec<Vec<u8>> = corpus(name).into_iter().map(|(_, bytes)| bytes).collect();
    let mut random = Random(seed);
    let (mut runs, mut valid) = (0, 0);
    let start = Instant::now();
    while start.elapsed() < budget {
        let (seed, other) = (random.below(seeds.len()), random.below(seeds.len()));
        let bytes = mutate(&mut random, &seeds[seed], &seeds[other]);
        runs += 1;
        valid += usize::from(feed(name, target, &bytes));
    }
    (runs, valid)
}

fn from_environment<T: std::str::FromStr>(name: &str, default: T) -> T {
    match std::env::var(name) {
        Ok(text) => text.parse().unwrap_or_else(|_| panic!("{name} is {text:?}, which is not a number")),
        Err(_) => default,
    }
}

#[test]
fn corpus_replays() {
    for (name, target) in targets() {
        for (path, bytes) in corpus(name) {
            let valid = feed(name, target, &bytes);
            let regression = path.file_name().unwrap().to_string_lossy().starts_with("regression_");
            assert!(valid || regression, "{} is no longer read", path.display());
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
    let seconds: f64 = from_environment("FUZZ_SECONDS", 0.5);
    let seed: u64 = from_environment("FUZZ_SEED", 2026);
    for (name, target) in targets() {
        let (runs, valid) = fuzz(name, target, seed, Duration::from_secs_f64(seconds));
        println!("{name}: {runs} inputs, {valid} of them valid");
        assert!(runs > 100 && valid > 0 && valid < runs, "{name}: {valid} of {runs} inputs were valid");
    }
}
