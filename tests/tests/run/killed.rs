//! Runs that are killed at random moments and resumed, again and again: they end in the bits of a run that nobody disturbed.
//!
//! Every step is checkpointed, so that many moments fall into the writing of a file. `KILLS` sets how many kills there are for each scene (10 if
//! unset), `KILL_SEED` other moments.

#![allow(clippy::print_stdout, reason = "a test prints what it counted")]

use super::splats::{BALL, ball};
use super::{on_a_floor, temporary};
use mechanics_core::checkpoint::Checkpoint;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Numbers in [0, 1), the same everywhere.
struct Random(u64);

impl Random {
    fn part(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

fn from_environment(name: &str, default: u64) -> u64 {
    std::env::var(name).map_or(default, |text| text.parse().expect("a whole number"))
}

/// A scene in a folder of its own.
struct Story {
    folder: PathBuf,
}

impl Story {
    /// `text` beside what it needs.
    fn new(folder: PathBuf, text: &str) -> Self {
        std::fs::create_dir_all(&folder).expect("the folder is ours");
        ball(&folder);
        std::fs::write(folder.join("scene.toml"), text).expect("the folder is ours");
        Self { folder }
    }

    /// Starts the program, or goes on from the last checkpoint.
    fn start(&self) -> Child {
        let mut command = Command::new(env!("CARGO_BIN_EXE_validation"));
        command.arg("run").arg(self.folder.join("scene.toml")).arg("--out").arg(self.folder.join("out"));
        command.args(["--export", "ply", "--checkpoint-every", "1"]);
        if let Some(last) = self.checkpoints().last() {
            command.arg("--resume").arg(last);
        }
        command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("the program starts")
    }

    /// What a reader would resume from, oldest first.
    fn checkpoints(&self) -> Vec<PathBuf> {
        let folder = self.folder.join("out.checkpoints");
        let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
        let paths = entries.flatten().map(|entry| entry.path());
        let mut paths: Vec<PathBuf> =
            paths.filter(|path| path.extension().is_some_and(|ending| ending == "checkpoint")).collect();
        paths.sort();
        paths
    }

    /// Files that a killed writer has left: not whole, and not called checkpoints.
    fn half_written(&self) -> usize {
        let Ok(entries) = std::fs::read_dir(self.folder.join("out.checkpoints")) else { return 0 };
        entries
            .flatten()
            .filter(|entry| entry.path().extension().is_some_and(|ending| ending == "tmp"))
            .count()
    }

    fn finish(&self) {
        let output = self.start().wait_with_output().expect("the program ends");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }

    /// The bytes of the last checkpoint: the whole state.
    fn end(&self) -> Vec<u8> {
        std::fs::read(self.checkpoints().last().expect("a checkpoint")).expect("a file")
    }
}

/// What many kills found.
#[derive(Debug, Default)]
struct Tally {
    kills: u64,
    /// Runs that were over before their moment came.
    finished: u64,
    /// Kills that left a half-written checkpoint behind.
    in_writing: usize,
}

/// Kills a run at `kills` random moments, each within twice the mean that spreads them over the whole of it; what is there after each must be readable. Where a run is through
/// sooner, its end is compared and another begins.
fn kill_and_resume(root: &Path, text: &str, kills: u64) -> Tally {
    let whole = Story::new(root.join("undisturbed"), text);
    let begin = Instant::now();
    whole.finish();
    let length = begin.elapsed();
    let expected = whole.end();
    let mut random = Random(from_environment("KILL_SEED", 2026));
    let mut tally = Tally::default();
    let mut story = Story::new(root.join("story 0"), text);
    while tally.kills < kills {
        let left = story.half_written();
        let mut child = story.start();
        std::thread::sleep(length.mul_f64(random.part()) + Duration::from_millis(5));
        if child.try_wait().expect("a child").is_some() {
            assert!(child.wait_with_output().expect("a child").status.success());
            assert!(story.end() == expected, "other bits after {tally:?}");
            tally.finished += 1;
            story = Story::new(root.join(format!("story {}", tally.finished)), text);
            continue;
        }
        child.kill().expect("a child that runs");
        child.wait().expect("a child");
        tally.kills += 1;
        tally.in_writing += story.half_written() - left;
        for checkpoint in story.checkpoints() {
            if let Err(error) = Checkpoint::read(&checkpoint) {
                panic!("after kill {} at {}: {error}", tally.kills, checkpoint.display());
            }
        }
    }
    story.finish();
    assert!(story.end() == expected, "other bits after {tally:?}");
    tally
}

/// The cube with friction on a floor, BDF2 and its history; and a ball of splats that falls as material points.
#[test]
fn killed_runs_end_in_the_bits_of_undisturbed_ones() {
    let kills = from_environment("KILLS", 10);
    let sliding = on_a_floor()
        .replace("translation_m = [0, 0, 0.2]", "translation_m = [0, 0, 0.001]")
        .replace("end_s = 0.5", "end_s = 0.3");
    let falling =
        BALL.replace("frames = 5", "frames = 40").replace("frame_rate_hz = 20", "frame_rate_hz = 160");
    for (name, text) in [("bodies", sliding), ("splats", falling)] {
        let folder = temporary();
        let begin = Instant::now();
        let tally = kill_and_resume(folder.path(), &text, kills);
        println!("{name}: {tally:?} in {:.1} s", begin.elapsed().as_secs_f64());
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
