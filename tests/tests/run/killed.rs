//! Runs that are killed at random moments and resumed: they end in the bits of a run that nobody disturbed. The full suite does it two hundred times
//! (`whole/killed`).
//!
//! `KILLS` sets how many kills there are for each scene (5 if unset), `KILL_SEED` other moments.

#![allow(clippy::print_stdout, reason = "a test prints what it counted")]

use super::temporary;
use std::path::Path;
use std::process::Command;
use std::time::Instant;
use validation::experiment::killed::Trial;

fn from_environment(name: &str, default: u64) -> u64 {
    std::env::var(name).map_or(default, |text| text.parse().expect("a whole number"))
}

#[test]
fn killed_runs_end_in_the_bits_of_undisturbed_ones() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/whole/killed");
    for scene in super::names(&scenes) {
        let folder = temporary();
        let trial = Trial {
            program: Path::new(env!("CARGO_BIN_EXE_validation")),
            scene: &scenes.join(&scene),
            folder: folder.path(),
            kills: from_environment("KILLS", 5),
            seed: from_environment("KILL_SEED", 2026),
        };
        let begin = Instant::now();
        let tally = trial.run().unwrap_or_else(|error| panic!("{scene}: {error}"));
        println!("{scene}: {tally:?} in {:.1} s", begin.elapsed().as_secs_f64());
        assert_eq!((tally.kills, tally.other_ends, tally.unreadable), (trial.kills, 0, 0), "{scene}");
        assert_eq!(super::names(folder.path()), [""; 0], "what was killed leaves nothing in the end");
    }
}

/// Found by killing runs: their unfinished folders stay, named by the number of the process, and in a container that is the same every time. The next run
/// took over what it found in there.
#[test]
fn frames_of_a_killed_process_of_the_same_number_are_not_taken_over() {
    let folder = temporary();
    std::fs::write(folder.path().join("scene.toml"), super::CUBE).expect("the folder is ours");
    let script = r#"mkdir -p "$1/out.part.$$/frames" && echo old > "$1/out.part.$$/frames/frame_99999.vtu" &&
        exec "$0" run "$1/scene.toml" --out "$1/out" --export vtu"#;
    let mut shell = Command::new("sh");
    let shell = shell.args(["-c", script, env!("CARGO_BIN_EXE_validation")]).arg(folder.path());
    let output = shell.output().expect("a shell starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let frames = super::names(&folder.path().join("out/frames"));
    assert_eq!(frames, ["frame_00000.vtu", "frame_00005.vtu", "frame_00010.vtu"]);
}
