//! What tests of readers share: an allocator that counts, mutations with a fixed seed, and the bounds of memory and time.
// A counting allocator is the only way to see what a reader asks for and does not touch; its trait is unsafe.
#![allow(unsafe_code)]
#![allow(clippy::print_stdout, reason = "how many inputs were tried")]

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

/// Reads, and uses what was read, since what is valid must be usable. Answers whether it was valid.
pub(crate) type Target = fn(&[u8]) -> bool;

/// Of the processor: on a busy machine waiting is no fault of the reader.
const LONGEST: Duration = Duration::from_secs(2);

/// How long this thread has run so far, where Linux tells (proc(5)).
fn processor_time() -> Option<Duration> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    text.split_whitespace().next()?.parse().ok().map(Duration::from_nanos)
}

/// Gives a reader these bytes: it must not panic, take long, or hold more than `allowed` bytes at once. Answers whether they were
/// valid.
pub(crate) fn feed(name: &str, target: Target, bytes: &[u8], allowed: isize) -> bool {
    let (start, ran) = (Instant::now(), processor_time());
    let held = HELD.get();
    PEAK.set(held);
    let outcome = std::panic::catch_unwind(|| target(bytes));
    let (peak, time) = (PEAK.get() - held, start.elapsed());
    let time = if time > LONGEST { ran.zip(processor_time()).map_or(time, |(a, b)| b - a) } else { time };
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

/// The files of a folder, by name.
pub(crate) fn files(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

/// Whether a file of a corpus once broke a reader, and need not be valid.
pub(crate) fn is_regression(path: &Path) -> bool {
    path.file_name().unwrap().to_string_lossy().starts_with("regression_")
}

/// Feeds mutations of a corpus for `FUZZ_SECONDS` (0.5 if unset), and 200 at least, from the seed `FUZZ_SEED`; some must be valid, and some not.
pub(crate) fn mutations_are_survived(name: &str, corpus: &[Vec<u8>], mut feed: impl FnMut(&[u8]) -> bool) {
    let budget = Duration::from_secs_f64(from_environment("FUZZ_SECONDS", 0.5));
    let mut random = Random(from_environment("FUZZ_SEED", 2026));
    let (mut runs, mut valid) = (0, 0);
    let start = Instant::now();
    while runs < 200 || start.elapsed() < budget {
        let (seed, other) = (random.below(corpus.len()), random.below(corpus.len()));
        let bytes = mutate(&mut random, &corpus[seed], &corpus[other]);
        runs += 1;
        valid += usize::from(feed(&bytes));
    }
    println!("{name}: {runs} inputs, {valid} of them valid");
    assert!(valid > 0 && valid < runs, "{name}: {valid} of {runs} inputs were valid");
}

fn from_environment<T: std::str::FromStr>(name: &str, default: T) -> T {
    match std::env::var(name) {
        Ok(text) => text.parse().unwrap_or_else(|_| panic!("{name} is {text:?}, which is not a number")),
        Err(_) => default,
    }
}
