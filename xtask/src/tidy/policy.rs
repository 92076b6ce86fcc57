//! What the rules allow: the architecture as data.

use super::Exception;

/// Files that may break a rule, each for its reason.
pub(crate) const EXCEPTIONS: &[Exception] = &[
    Exception {
        rule: "atomics",
        path: "crates/mechanics-core/src/checkpoint/file.rs",
        reason: "a counter in the names of temporary files; no result depends on it",
    },
    Exception {
        rule: "atomics",
        path: "crates/mechanics-core/src/mesh/io/atomic.rs",
        reason: "a counter in the names of temporary files; no result depends on it",
    },
    Exception {
        rule: "atomics",
        path: "crates/ipc-contact/src/broad_phase/pairs.rs",
        reason: "a count that ends a search with an error; that there are too many pairs does not depend on timing",
    },
    Exception {
        rule: "rows",
        path: "crates/mpm-core/src/body.rs",
        reason: "hands on the trait through which implicit steps see a law",
    },
    Exception {
        rule: "rows",
        path: "crates/mpm-core/src/material.rs",
        reason: "shows laws through the trait that implicit steps want",
    },
    Exception {
        rule: "unsafe",
        path: "crates/mechanics-core/tests/fuzz/fuzzing.rs",
        reason: "an allocator that counts, to test that readers allocate in proportion to their input",
    },
    Exception {
        rule: "unsafe",
        path: "crates/mechanics-core/src/lanes/avx2.rs",
        reason: "vector intrinsics: two to three times the speed of arrays that the compiler vectorises",
    },
];

/// The solver crates and the workspace crates that each may depend on.
pub(crate) const ARROWS: &[(&str, &[&str])] = &[
    ("mechanics-core", &[]),
    ("lagrangian", &["mechanics-core"]),
    ("ipc-contact", &["mechanics-core"]),
    ("ipc-friction", &["mechanics-core", "ipc-contact"]),
    ("mpm-constitutive", &["mechanics-core"]),
    ("mpm-core", &["mechanics-core", "mpm-constitutive"]),
    ("gaussian-deform", &["mechanics-core"]),
    (
        "validation",
        &[
            "mechanics-core",
            "lagrangian",
            "ipc-contact",
            "ipc-friction",
            "mpm-constitutive",
            "mpm-core",
            "gaussian-deform",
        ],
    ),
    ("xtask", &[]),
];

/// Programs outside of the workspace that depend on one solver crate each.
pub(crate) const DEPENDANTS: &str = "tests/dependants";

/// A dependency that is spoken to in few places only.
pub(super) struct Wall {
    /// The crate's name in code, or what it begins with.
    pub(super) prefix: &'static str,
    /// Which files may name it.
    pub(super) place: Place,
}

/// Where a [`Wall`] has its door.
pub(super) enum Place {
    /// In one file, whose path begins so.
    OneFileUnder(&'static str),
    /// In one file of each crate.
    OneFilePerCrate,
}

/// faer and rayon can be replaced by changing one file; parry speaks its own vector types.
pub(super) const WALLS: &[Wall] = &[
    Wall { prefix: "faer", place: Place::OneFileUnder("crates/mechanics-core/src/linear/") },
    Wall { prefix: "rayon", place: Place::OneFileUnder("crates/mechanics-core/src/parallel.rs") },
    Wall { prefix: "parry", place: Place::OneFilePerCrate },
];

/// Dependencies that only these packages may have.
pub(super) const HEAVY_DEPENDENCIES: &[(&str, &[&str])] =
    &[("faer", &["mechanics-core"]), ("rayon", &["mechanics-core"])];

/// The solver modules whose business is files.
pub(super) const FILE_MODULES: &[&str] = &[
    "crates/mechanics-core/src/mesh/io",
    "crates/mechanics-core/src/checkpoint",
    "crates/gaussian-deform/src/file",
];

/// Lints that no module of a solver crate lifts. (`missing_docs` and `unsafe_code` have rules of their own.)
pub(super) const LINTS_KEPT: &[&str] = &[
    "expect_used",
    "fn_params_excessive_bools",
    "print_stderr",
    "print_stdout",
    "struct_excessive_bools",
    "too_many_lines",
    "unwrap_used",
];

/// Module names that say nothing about their content.
pub(super) const EMPTY_NAMES: &[&str] = &["common", "helper", "helpers", "misc", "prelude", "util", "utils"];

/// Everything at the top but dotfiles.
pub(super) const TOP_LEVEL: &[&str] = &[
    "CHANGELOG.md",
    "CITATION.cff",
    "CONTRIBUTING.md",
    "Cargo.lock",
    "Cargo.toml",
    "LICENSE-APACHE",
    "LICENSE-MIT",
    "README.md",
    "crates",
    "docs",
    "target",
    "tests",
    "xtask",
];

/// The longest file, and the length that is worth a second look, in lines.
pub(super) const FILE_LINES: (usize, usize) = (800, 600);

/// The longest function body, blank lines and comments not counted, in lines.
pub(super) const FUNCTION_LINES: usize = 100;
