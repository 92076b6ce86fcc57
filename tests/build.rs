//! Tells the suite which toolchain and profile built it: they are part of the machine's fingerprint.

use std::process::Command;

fn main() {
    let variable = |name: &str| std::env::var(name).unwrap_or_default();
    let version = Command::new(variable("RUSTC")).arg("--version").output();
    let compiler =
        version.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_owned()).unwrap_or_default();
    println!("cargo::rustc-env=VALIDATION_COMPILER={compiler}");
    println!("cargo::rustc-env=VALIDATION_TARGET={}", variable("TARGET"));
    println!(
        "cargo::rustc-env=VALIDATION_PROFILE={} (opt-level {})",
        variable("PROFILE"),
        variable("OPT_LEVEL")
    );
    println!("cargo::rerun-if-changed=build.rs");
}
