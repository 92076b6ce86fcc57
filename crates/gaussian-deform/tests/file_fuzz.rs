//! Arbitrary bytes never panic a reader of scenes, and cost memory and time in proportion to their number only.
//!
//! As the readers of meshes are tried in mechanics-core: the files in tests/corpus are replayed, then mutated with a fixed seed.
//! `FUZZ_SECONDS` sets the time for each reader (0.5 if unset); `FUZZ_SEED` another sequence. A failing input is
//! written to the temporary folder; it belongs into tests/corpus as `regression_…` when the bug is mended.
#![cfg(feature = "spz")]
#![allow(clippy::unwrap_used)]
// A counting allocator is the only way to see what a reader asks for and does not touch; its trait is unsafe.
#![allow(unsafe_code)]

use gaussian_deform::Splats;
use gaussian_deform::file::{FileError, ply, splat, spz};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::io::{Read, Write};
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

/// Reads, and uses what was read. Answers whether it was valid.
type Target = fn(&[u8]) -> bool;

fn targets() -> [(&'static str, Target); 4] {
    [
        ("ply", |bytes| is_usable(ply::read(bytes))),
        ("splat", |bytes| is_usable(splat::read(bytes))),
        ("spz", |bytes| is_usable(spz::read(bytes))),
        // Mutations of what is inside the compression.
        ("spz_plain", |bytes| is_usable(spz::read(&compressed(bytes)))),
    ]
}

fn compressed(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::none());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
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
const LONGEST: Duration = Duration::from_secs(2);

fn feed(name: &str, target: Target, bytes: &[u8]) -> bool {
    let held = HELD.get();
    PEAK.set(held);
    let start = Instant::now();
    let outcome = std::panic::catch_unwind(|| target(bytes));
    let (peak, time) = (PEAK.get() - held, start.elapsed());
    let factor = if name == "spz" { COMPRESSED_FACTOR } else { MEMORY_FACTOR };
    let allowed = MEMORY_BASE + factor * bytes.len() as isize;
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
    let folder = name.strip_suffix("_plain").unwrap_or(name);
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus").join(folder);
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files.into_iter().map(|path| (path.clone(), content(name, &path))).collect()
}

fn content(name: &str, path: &Path) -> Vec<u8> {
    let bytes = std::fs::read(path).unwrap();
    if !name.ends_with("_plain") {
        return bytes;
    }
    let mut plain = Vec::new();
    flate2::read::GzDecoder::new(&bytes[..]).read_to_end(&mut plain).unwrap();
    plain
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
    ];
    for (format, input) in inputs {
        let (name, target) = targets().into_iter().find(|(name, _)| *name == format).unwrap();
        feed(name, target, &input);
    }
}

fn compressed_well(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
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
