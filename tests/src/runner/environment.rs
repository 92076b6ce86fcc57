//! Where a run took place.

use crate::record::Environment;
use std::path::Path;
use std::process::Command;

/// Describes this machine and program.
pub fn describe() -> Environment {
    let processor_features = processor_features();
    let compiler = env!("VALIDATION_COMPILER").to_owned();
    let profile = env!("VALIDATION_PROFILE").to_owned();
    let features = processor_features.join(",");
    let identity = format!("{features}\n{compiler}\n{profile}\n{}", env!("VALIDATION_TARGET"));
    Environment {
        fingerprint: format!("{:016x}", fnv1a(identity.as_bytes())),
        processor: field("/proc/cpuinfo", "model name").unwrap_or_else(|| std::env::consts::ARCH.to_owned()),
        processor_features,
        cores: std::thread::available_parallelism().map_or(1, usize::from),
        memory_bytes: kibibytes("/proc/meminfo", "MemTotal"),
        system: system(),
        compiler,
        profile,
        commit: commit(),
    }
}

/// Peak resident memory of this process so far (bytes); 0 where the system does not tell.
pub fn peak_memory_bytes() -> u64 {
    kibibytes("/proc/self/status", "VmHWM")
}

/// Resident memory of this process now (bytes); 0 where the system does not tell.
pub fn resident_memory_bytes() -> u64 {
    kibibytes("/proc/self/status", "VmRSS")
}

/// The 64-bit FNV-1a hash: a short name for a text, not a protection.
///
/// # Reference
/// G. Fowler, L. C. Noll, K.-P. Vo, 1991; draft-eastlake-fnv.
pub fn fnv1a(bytes: &[u8]) -> u64 {
    bytes
        .iter()
        .fold(0xcbf2_9ce4_8422_2325, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

fn system() -> String {
    let release = std::fs::read_to_string("/proc/sys/kernel/osrelease").unwrap_or_default();
    format!("{} {}", std::env::consts::OS, release.trim()).trim().to_owned()
}

fn commit() -> String {
    let git = |arguments: &[&str]| {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
        let output = Command::new("git").arg("-C").arg(folder).args(arguments).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    let Some(commit) = git(&["rev-parse", "HEAD"]) else { return String::new() };
    let changed = git(&["status", "--porcelain"]).is_some_and(|changes| !changes.is_empty());
    if changed { format!("{commit}-dirty") } else { commit }
}

/// The value of the first line `name: value` of a file.
fn field(file: &str, name: &str) -> Option<String> {
    let text = std::fs::read_to_string(file).ok()?;
    text.lines().find_map(|line| {
        let (key, value) = line.split_once(':')?;
        (key.trim() == name).then(|| value.trim().to_owned())
    })
}

fn kibibytes(file: &str, name: &str) -> u64 {
    let value = field(file, name).unwrap_or_default();
    value.trim_end_matches("kB").trim().parse::<u64>().map_or(0, |kibibytes| kibibytes * 1024)
}

#[cfg(target_arch = "x86_64")]
fn processor_features() -> Vec<String> {
    macro_rules! present {
        ($($feature:tt),*) => {
            [$(($feature, std::is_x86_feature_detected!($feature))),*]
        };
    }
    let mut features: Vec<String> =
        present!("avx", "avx2", "avx512f", "avx512vl", "bmi2", "fma", "sse4.1", "sse4.2")
            .into_iter()
            .filter(|(_, present)| *present)
            .map(|(feature, _)| feature.to_owned())
            .collect();
    features.sort();
    features
}

#[cfg(not(target_arch = "x86_64"))]
fn processor_features() -> Vec<String> {
    vec![std::env::consts::ARCH.to_owned()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fnv1a_matches_published_values() {
        // Test vectors of the FNV draft: "", "a", "foobar".
        assert_eq!(fnv1a(b""), 0xcbf2_9ce4_8422_2325);
        assert_eq!(fnv1a(b"a"), 0xaf63_dc4c_8601_ec8c);
        assert_eq!(fnv1a(b"foobar"), 0x8594_4171_f739_67e8);
    }

    #[test]
    fn the_fingerprint_is_stable_within_a_machine() {
        assert_eq!(describe(), describe());
        assert_eq!(describe().fingerprint.len(), 16);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn peak_memory_grows_with_what_is_touched() {
        let before = peak_memory_bytes();
        let block = std::hint::black_box(vec![1_u8; 64 << 20]);
        assert!(peak_memory_bytes() >= before.max(64 << 20), "{before}");
        drop(block);
    }
}
