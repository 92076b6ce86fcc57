//! `cargo xtask dependants`: programs that depend on one solver crate each, as a user's would.
//!
//! They stand in `tests/dependants/` and are no members of the workspace. Each is copied into the target folder together with the workspace's
//! `Cargo.lock`, so that it is built with the versions that the tests are run with, and nothing is written beside its source. What it compiles, `cargo tree`
//! tells, and on a build from nothing cargo itself; what came into the program, its symbols.

use crate::tidy::{ARROWS, DEPENDANTS};
use std::collections::BTreeSet;
use std::fmt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

/// How the programs are built.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Build {
    /// From nothing, each in a folder of its own, optimised: what a user waits for.
    Cold,
    /// In one folder, as debug builds: whether all is well.
    Shared,
}

/// One program, ready to be built.
struct Dependant {
    /// The crate that it depends on.
    name: &'static str,
    /// What else of the workspace that crate needs.
    needs: &'static [&'static str],
    /// A copy of its folder.
    folder: PathBuf,
    target: PathBuf,
    build: Build,
}

/// What building and running one took.
struct Made {
    name: &'static str,
    /// Of other people.
    packages: usize,
    /// Of the workspace.
    ours: Vec<String>,
    wall: Duration,
    /// Of all processors together, where the system tells.
    processors: Option<Duration>,
    bytes: u64,
    /// What the program printed.
    output: String,
}

/// What is wrong with a dependant, in a sentence.
pub(crate) struct Fault(String);

impl fmt::Display for Fault {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.0)
    }
}

/// Builds and runs the dependants of the named crates, or of all.
///
/// # Errors
/// The first that does not build, run, or keep to the architecture's arrows.
pub(crate) fn run(root: &Path, arguments: &[String]) -> Result<(), Fault> {
    let (options, names): (Vec<&String>, Vec<&String>) = arguments.iter().partition(|a| a.starts_with('-'));
    let build = match options[..] {
        [] => Build::Cold,
        [check] if check == "--check" => Build::Shared,
        _ => return Err(Fault(format!("unknown option among {options:?}; there is --check alone"))),
    };
    let solvers: Vec<_> = ARROWS.iter().filter(|(name, _)| root.join("crates").join(name).is_dir()).collect();
    if let Some(unknown) = names.iter().find(|name| !solvers.iter().any(|(solver, _)| solver == *name)) {
        return Err(Fault(format!("there is no solver crate `{unknown}`")));
    }
    cargo(root, &["fetch", "--quiet", "--locked"])?;
    let mut all = Vec::new();
    for &&(name, needs) in
        solvers.iter().filter(|(name, _)| names.is_empty() || names.iter().any(|n| n == name))
    {
        let made = Dependant::stage(root, name, needs, build)?.make()?;
        println!("{name}, with {} other packages: {}", made.packages, made.output.trim().replace('\n', "; "));
        all.push(made);
    }
    // In a shared folder times say what was there before.
    if build == Build::Cold {
        print_table(&all);
    }
    Ok(())
}

impl Dependant {
    /// Copies a program into the target folder.
    fn stage(
        root: &Path,
        name: &'static str,
        needs: &'static [&'static str],
        build: Build,
    ) -> Result<Self, Fault> {
        let source = root.join(DEPENDANTS).join(name);
        let base = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from);
        let base = base.join("dependants");
        let folder = base.join(name);
        if build == Build::Cold && folder.exists() {
            std::fs::remove_dir_all(&folder).map_err(|error| cannot("remove", &folder, &error))?;
        }
        let crates = format!("{}/crates/", root.display());
        let manifest = read(&source.join("Cargo.toml"))?.replace("../../../crates/", &crates);
        write(&folder.join("Cargo.toml"), &manifest)?;
        write(&folder.join("Cargo.lock"), &read(&root.join("Cargo.lock"))?)?;
        write(&folder.join("src/main.rs"), &read(&source.join("src/main.rs"))?)?;
        let target = if build == Build::Cold { folder.join("target") } else { base.join("shared") };
        Ok(Self { name, needs, folder, target, build })
    }

    /// Builds and runs it, and looks at what was compiled and linked.
    fn make(&self) -> Result<Made, Fault> {
        // The lock file of the workspace holds more than this program needs: cargo drops the rest.
        let tree = self
            .cargo(&["tree", "--offline", "--edges", "normal,build", "--prefix", "none", "--no-dedupe"])?
            .0;
        let expected: BTreeSet<String> =
            tree.lines().filter_map(package).filter(|name| *name != self.package()).collect();
        let (begin, before) = (Instant::now(), processor_time());
        let mut arguments = vec!["build", "--offline"];
        arguments.extend((self.build == Build::Cold).then_some("--release"));
        let messages = self.cargo(&arguments)?.1;
        let (wall, after) = (begin.elapsed(), processor_time());
        let packages = match self.build {
            Build::Shared => expected,
            Build::Cold => {
                let compiled =
                    messages.lines().filter_map(|line| package(line.trim().strip_prefix("Compiling ")?));
                compiled.filter(|name| *name != self.package()).collect()
            }
        };
        let ours = self.check_arrows(&packages)?;
        let program = self.program();
        self.check_symbols(&program)?;
        let output = spawn(Command::new(&program).current_dir(&self.folder), self.name)?.0;
        Ok(Made {
            name: self.name,
            packages: packages.len() - ours.len(),
            ours,
            wall,
            processors: before.zip(after).map(|(before, after)| after.saturating_sub(before)),
            bytes: std::fs::metadata(&program).map_or(0, |file| file.len()),
            output,
        })
    }

    fn package(&self) -> String {
        format!("dependant-of-{}", self.name)
    }

    fn program(&self) -> PathBuf {
        let profile = if self.build == Build::Cold { "release" } else { "debug" };
        self.target.join(profile).join(self.package())
    }

    /// The workspace's crates among `packages`, which are the crate itself and those that its arrows lead to.
    fn check_arrows(&self, packages: &BTreeSet<String>) -> Result<Vec<String>, Fault> {
        let ours: Vec<String> = packages
            .iter()
            .filter(|package| ARROWS.iter().any(|(name, _)| name == package))
            .cloned()
            .collect();
        if !packages.contains(self.name) {
            return Err(Fault(format!("the dependant of {} was built without it", self.name)));
        }
        match ours.iter().find(|package| *package != self.name && !self.needs.contains(&package.as_str())) {
            Some(stranger) => {
                let name = self.name;
                Err(Fault(format!("a program that needs {name} compiles {stranger}: no arrow leads there")))
            }
            None => Ok(ours),
        }
    }

    /// What `[package.metadata.dependant]` of the manifest says of the program's symbols: `linked` are names of types and modules that are there (else
    /// nothing could be found), `absent` those that are not.
    fn check_symbols(&self, program: &Path) -> Result<(), Fault> {
        let manifest = read(&self.folder.join("Cargo.toml"))?;
        let table: toml::Table =
            manifest.parse().map_err(|error| Fault(format!("{}: {error}", self.name)))?;
        let claims = table.get("package").and_then(|p| p.get("metadata")?.get("dependant"));
        let words = |key: &str| -> Vec<String> {
            let list = claims.and_then(|claims| claims.get(key)?.as_array());
            list.into_iter().flatten().filter_map(|word| Some(word.as_str()?.to_owned())).collect()
        };
        let symbols = std::fs::read(program).map_err(|error| cannot("read", program, &error))?;
        let is_there = |word: &String| {
            // As the mangling of symbols has it.
            let symbol = format!("{}{word}", word.len());
            symbols.windows(symbol.len()).any(|window| window == symbol.as_bytes())
        };
        let name = self.name;
        if let Some(word) = words("linked").into_iter().find(|word| !is_there(word)) {
            return Err(Fault(format!("the dependant of {name} should hold code of `{word}`, and does not")));
        }
        match words("absent").into_iter().find(is_there) {
            Some(word) => {
                Err(Fault(format!("the dependant of {name} holds code of `{word}`, which it does not use")))
            }
            None => Ok(()),
        }
    }

    fn cargo(&self, arguments: &[&str]) -> Result<(String, String), Fault> {
        let mut command = Command::new(env!("CARGO"));
        command
            .args(arguments)
            .current_dir(&self.folder)
            .env("CARGO_TARGET_DIR", &self.target)
            .env("CARGO_TERM_COLOR", "never")
            .env("CARGO_INCREMENTAL", "0")
            .env("CARGO_PROFILE_DEV_DEBUG", "0")
            // Symbols that name the types that generic code was compiled for.
            .env("RUSTFLAGS", "-C symbol-mangling-version=v0");
        spawn(&mut command, self.name)
    }
}

/// A line a crate, as a table of Markdown.
fn print_table(all: &[Made]) {
    println!(
        "\n| a program with | compiles of the workspace | other packages | from nothing \\[s\\] | on one processor \\[s\\] | size \\[MiB\\] |"
    );
    println!("|---|---|---|---|---|---|");
    for Made { name, packages, ours, wall, processors, bytes, .. } in all {
        let processors =
            processors.map_or_else(|| "?".to_owned(), |time| format!("{:.0}", time.as_secs_f64()));
        let ours = ours.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
        let size = *bytes as f64 / f64::from(1 << 20);
        println!("| `{name}` | {ours} | {packages} | {:.0} | {processors} | {size:.1} |", wall.as_secs_f64());
    }
}

/// The name before ` v1.2.3`.
fn package(line: &str) -> Option<String> {
    let (name, version) = line.split_once(' ')?;
    version.starts_with('v').then(|| name.to_owned())
}

/// Time that processors spent for programs this one has waited for, where there is `/proc`; in units of 10 ms, as Linux has them.
fn processor_time() -> Option<Duration> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    let (_, rest) = stat.rsplit_once(')')?;
    // Fields 16 and 17 of proc(5): user and system time of children; `rest` begins with field 3.
    let ticks: u64 =
        rest.split_whitespace().skip(13).take(2).filter_map(|field| field.parse::<u64>().ok()).sum();
    Some(Duration::from_millis(10 * ticks))
}

fn cargo(folder: &Path, arguments: &[&str]) -> Result<(), Fault> {
    spawn(Command::new(env!("CARGO")).args(arguments).current_dir(folder), "the workspace").map(|_| ())
}

/// Runs a program to its end, and answers what it wrote on both streams.
fn spawn(command: &mut Command, whose: &str) -> Result<(String, String), Fault> {
    let output =
        command.output().map_err(|error| Fault(format!("{whose}: cannot start {command:?}: {error}")))?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let (printed, messages) = (text(&output.stdout), text(&output.stderr));
    match output.status.success() {
        true => Ok((printed, messages)),
        false => Err(Fault(format!("{whose}: {command:?} failed\n{printed}{messages}"))),
    }
}

fn read(path: &Path) -> Result<String, Fault> {
    std::fs::read_to_string(path).map_err(|error| cannot("read", path, &error))
}

fn write(path: &Path, text: &str) -> Result<(), Fault> {
    let folder = path.parent().unwrap_or(path);
    std::fs::create_dir_all(folder).map_err(|error| cannot("make", folder, &error))?;
    std::fs::write(path, text).map_err(|error| cannot("write", path, &error))
}

fn cannot(what: &str, path: &Path, error: &std::io::Error) -> Fault {
    Fault(format!("cannot {what} {}: {error}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dependant(folder: PathBuf) -> Dependant {
        let target = folder.join("target");
        Dependant {
            name: "mpm-constitutive",
            needs: &["mechanics-core"],
            folder,
            target,
            build: Build::Shared,
        }
    }

    fn packages(names: &[&str]) -> BTreeSet<String> {
        names.iter().map(|name| (*name).to_owned()).collect()
    }

    #[test]
    fn packages_are_read_from_what_cargo_prints() {
        assert_eq!(
            package("mechanics-core v0.1.0 (/work/crates/mechanics-core)").as_deref(),
            Some("mechanics-core")
        );
        assert_eq!(package("syn v2.0.1 (*)").as_deref(), Some("syn"));
        for line in ["", "nalgebra", "target(s) in 3.2s", "[build-dependencies]"] {
            assert_eq!(package(line), None, "{line}");
        }
    }

    #[test]
    fn a_crate_to_which_no_arrow_leads_is_found() {
        let dependant = dependant(PathBuf::new());
        let ours = dependant.check_arrows(&packages(&["mechanics-core", "mpm-constitutive", "rayon"]));
        assert_eq!(ours.ok(), Some(vec!["mechanics-core".to_owned(), "mpm-constitutive".to_owned()]));
        let fault = dependant.check_arrows(&packages(&["mechanics-core", "mpm-constitutive", "mpm-core"]));
        assert!(fault.is_err_and(|fault| fault.0.contains("compiles mpm-core")));
        let fault = dependant.check_arrows(&packages(&["mechanics-core"]));
        assert!(fault.is_err_and(|fault| fault.0.contains("without it")));
    }

    #[test]
    fn symbols_are_compared_with_what_the_manifest_claims() {
        let folder = std::env::temp_dir().join(format!("dependants-{}", std::process::id()));
        let dependant = dependant(folder.clone());
        let claims = "[package.metadata.dependant]\nlinked = [\"Hencky\"]\nabsent = [\"Snow\"]\n";
        let (manifest, program) = (folder.join("Cargo.toml"), folder.join("program"));
        let mut answers = Vec::new();
        for symbols in ["_RN6HenckyE", "_RN6HenckyE_RN4SnowE", "_RN4TaitE"] {
            let written = write(&manifest, claims).and_then(|()| write(&program, symbols));
            answers.push(written.and_then(|()| dependant.check_symbols(&program)).err().map(|fault| fault.0));
        }
        let _ = std::fs::remove_dir_all(&folder);
        assert_eq!(answers[0], None);
        assert!(
            answers[1].as_ref().is_some_and(|fault| fault.contains("holds code of `Snow`")),
            "{answers:?}"
        );
        assert!(answers[2].as_ref().is_some_and(|fault| fault.contains("should hold code of `Hencky`")));
    }
}
