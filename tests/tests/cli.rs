//! The program `validation` from outside: every exit code, every option that changes what runs, bad input.
//!
//! The scenes in `tests/selftest` misbehave on demand, so that each test knows what must come out.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

fn scenes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/selftest")
}

fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_validation"))
}

/// `validate` on the selftest scenes with further arguments, into `out`.
fn validate(out: &Path, arguments: &[&str]) -> Command {
    let mut command = program();
    command
        .arg("validate")
        .arg("--scenes")
        .arg(scenes())
        .arg("--out")
        .arg(out)
        .arg("--no-plots")
        .args(arguments);
    command
}

struct Answer {
    code: Option<i32>,
    out: String,
    err: String,
}

fn answer(command: &mut Command) -> Answer {
    let Output { status, stdout, stderr } = command.output().expect("the program starts");
    let text = |bytes| String::from_utf8(bytes).expect("the program writes UTF-8");
    Answer { code: status.code(), out: text(stdout), err: text(stderr) }
}

fn temporary() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

fn report(folder: &Path) -> Value {
    let text = std::fs::read_to_string(folder.join("report.json")).expect("the report is there");
    serde_json::from_str(&text).expect("the report is JSON")
}

fn scene<'a>(report: &'a Value, name: &str) -> &'a Value {
    let scenes = report["scenes"].as_array().expect("a list of scenes");
    scenes.iter().find(|scene| scene["name"] == name).expect("the scene is in the report")
}

fn last_line(text: &str) -> &str {
    text.trim_end().lines().last().unwrap_or_default()
}

#[test]
fn scenes_that_hold_exit_0_and_the_last_line_counts_them() {
    let out = temporary();
    let answer = answer(&mut validate(out.path(), &["--scene", "ok/*"]));
    assert_eq!(answer.code, Some(0), "{}{}", answer.out, answer.err);
    assert_eq!(last_line(&answer.out), "4 passed, 0 failed, 0 skipped");
    let report = report(out.path());
    let order = &scene(&report, "ok/power")["lines"][0]["orders"][0];
    assert!((order["order"].as_f64().expect("an order") - 2.0).abs() < 1e-12);
    for file in ["rows.csv", "env.json", "index.html", "junit.xml", "logs/ok__power.log"] {
        assert!(out.path().join(file).is_file(), "{file}");
    }
}

#[test]
fn each_way_to_fail_has_its_exit_code_and_says_why() {
    for (name, arguments, code, words) in [
        ("wrong", &[][..], 1, "1.000e0, allowed 1.000e-2"),
        ("method", &[], 1, "second: order of error 2.00 ± 0.00 (95 %, 2 of 2 points), expected 3"),
        ("nan", &[], 1, "`error` is not finite: NaN"),
        ("error", &[], 1, "no convergence at element 12, residual 0.5 N"),
        ("random", &["--repeat", "2"], 1, "two runs of the same point differ"),
        ("hang", &["--ladder", "2"], 1, "the coarser point 0.4 ran over its time limit"),
        ("thread-dependent", &["--threads", "1,2"], 4, "with 1 threads"),
        ("panic", &[], 5, "selftest: index 7 is out of range"),
        ("abort", &[], 5, "signal 6"),
    ] {
        let out = temporary();
        let scene = format!("broken/{name}");
        let mut all = vec!["--scene", &scene];
        all.extend(arguments);
        let answer = answer(&mut validate(out.path(), &all));
        assert_eq!(answer.code, Some(code), "{name}: {}{}", answer.out, answer.err);
        let text = answer.out.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(text.contains(words), "{name}: {text}");
        assert_eq!(last_line(&answer.out), "0 passed, 1 failed, 0 skipped");
    }
}

#[test]
fn a_crash_does_not_keep_other_scenes_from_running() {
    let out = temporary();
    let answer = answer(&mut validate(out.path(), &["--scene", "broken/panic", "--scene", "ok/power"]));
    assert_eq!(answer.code, Some(5));
    assert_eq!(last_line(&answer.out), "1 passed, 1 failed, 0 skipped");
    let report = report(out.path());
    assert_eq!(scene(&report, "ok/power")["verdict"]["kind"], "passed");
    let rows = scene(&report, "broken/panic")["lines"][0]["rows"].as_array().expect("rows").len();
    assert_eq!(rows, 3, "the rows after a crash run too");
    let log = std::fs::read_to_string(out.path().join("logs/broken__panic.log")).expect("the log");
    assert!(
        log.contains("index 7 is out of range") && log.contains("== first at 0.4 with 1 threads"),
        "{log}"
    );
}

#[test]
fn equal_bits_for_any_number_of_threads_pass() {
    let out = temporary();
    let answer = answer(&mut validate(out.path(), &["--scene", "ok/power", "--threads", "1,2,3"]));
    assert_eq!(answer.code, Some(0));
    let report = report(out.path());
    let line = &scene(&report, "ok/power")["lines"][0];
    assert_eq!(line["rows"].as_array().expect("rows").len(), 9);
    let checks = scene(&report, "ok/power")["checks"].as_array().expect("checks");
    assert_eq!(checks.iter().filter(|check| check["kind"] == "threads").count(), 2, "one a method");
}

#[test]
fn a_row_has_its_repeats_and_its_peak_memory() {
    let out = temporary();
    answer(&mut validate(out.path(), &["--scene", "ok/again", "--repeat", "3"]));
    let report = report(out.path());
    let row = &scene(&report, "ok/again")["lines"][0]["rows"][0];
    assert_eq!(row["repeats"], 3);
    assert!(row["seconds"].as_f64() > Some(0.0) && row["seconds_spread"].as_f64() >= Some(0.0));
    if cfg!(target_os = "linux") {
        assert!(row["peak_memory_bytes"].as_u64() > Some(500_000), "{row}");
    }
}

#[test]
fn a_method_can_have_its_own_order_and_bound() {
    let out = temporary();
    let answer = answer(&mut validate(out.path(), &["--scene", "ok/methods"]));
    assert_eq!(answer.code, Some(0), "{}{}", answer.out, answer.err);
    let report = report(out.path());
    let lines = scene(&report, "ok/methods")["lines"].as_array().expect("lines");
    let expected: Vec<f64> = lines.iter().filter_map(|line| line["orders"][0]["expected"].as_f64()).collect();
    assert_eq!(expected, [2.0, 3.0]);
    let measure = &scene(&report, "ok/methods")["measures"][0];
    assert_eq!(
        (&measure["bound"], &measure["methods"]["second"]["bound"]),
        (&0.01000001.into(), &0.001000001.into())
    );
}

#[test]
fn the_quick_suite_runs_part_of_a_ladder_under_its_own_bound() {
    let out = temporary();
    let quick = answer(&mut validate(out.path(), &["--suite", "quick", "--scene", "ok/ladder"]));
    assert_eq!(quick.code, Some(0), "{}", quick.out);
    let quick = report(out.path());
    let rows = |report: &Value| scene(report, "ok/ladder")["lines"][0]["rows"].as_array().map(Vec::len);
    assert_eq!(rows(&quick), Some(3));
    assert_eq!(scene(&quick, "ok/ladder")["measures"][0]["bound"], 0.010000001);
    answer(&mut validate(out.path(), &["--suite", "full", "--scene", "ok/ladder"]));
    assert_eq!(rows(&report(out.path())), Some(4));

    // Cut where no bound is stated: the bound is not judged, and that is said.
    let cut = answer(&mut validate(out.path(), &["--scene", "ok/ladder", "--ladder", "2"]));
    assert_eq!(cut.code, Some(0));
    let cut = report(out.path());
    let checks = scene(&cut, "ok/ladder")["checks"].as_array().expect("checks");
    let accuracy = checks.iter().find(|check| check["kind"] == "accuracy").expect("an accuracy check");
    assert_eq!(accuracy["verdict"]["kind"], "skipped");
}

#[test]
fn two_shards_merged_are_the_whole() {
    let (whole, first, second, merged) = (temporary(), temporary(), temporary(), temporary());
    answer(&mut validate(whole.path(), &["--scene", "ok/*"]));
    for (shard, folder) in [("1/2", &first), ("2/2", &second)] {
        let answer = answer(&mut validate(folder.path(), &["--scene", "ok/*", "--shard", shard]));
        assert_eq!(answer.code, Some(0));
        assert_eq!(report(folder.path())["shard"], shard);
    }
    let mut merge = program();
    merge.arg("merge").args([first.path(), second.path()]).arg("--out").arg(merged.path());
    let answer = answer(&mut merge);
    assert_eq!(answer.code, Some(0), "{}", answer.err);
    assert_eq!(last_line(&answer.out), "4 passed, 0 failed, 0 skipped");
    assert_eq!(without_times(report(whole.path())), without_times(report(merged.path())));
    assert!(
        merged.path().join("logs/ok__again.log").is_file()
            && merged.path().join("logs/ok__power.log").is_file()
    );
}

/// The scenes of a report without what differs from run to run.
fn without_times(report: Value) -> Value {
    let mut scenes = report["scenes"].clone();
    for scene in scenes.as_array_mut().expect("scenes") {
        for line in scene["lines"].as_array_mut().expect("lines") {
            for row in line["rows"].as_array_mut().expect("rows") {
                for key in ["seconds", "seconds_spread", "peak_memory_bytes"] {
                    row[key] = Value::Null;
                }
            }
        }
    }
    scenes
}

#[test]
fn a_merge_of_nothing_that_fits_is_refused() {
    let (first, out) = (temporary(), temporary());
    answer(&mut validate(first.path(), &["--scene", "ok/again"]));
    let merge = |folders: &[&Path]| answer(program().arg("merge").args(folders).arg("--out").arg(out.path()));
    let twice = merge(&[first.path(), first.path()]);
    assert_eq!(twice.code, Some(2), "{}", twice.err);
    assert!(twice.err.contains("ok/again"), "{}", twice.err);
    assert_eq!(merge(&[Path::new("/nonexistent")]).code, Some(2));
    assert!(!out.path().join("report.json").exists());
}

#[test]
fn a_merge_keeps_the_gravest_exit_code() {
    let (good, bad, out) = (temporary(), temporary(), temporary());
    answer(&mut validate(good.path(), &["--scene", "ok/again"]));
    answer(&mut validate(bad.path(), &["--scene", "broken/panic"]));
    let merged = answer(program().arg("merge").args([good.path(), bad.path()]).arg("--out").arg(out.path()));
    assert_eq!(merged.code, Some(5));
}

#[test]
fn a_time_budget_skips_what_is_left_and_says_so() {
    let out = temporary();
    let arguments = ["--scene", "slow/*", "--scene", "ok/again", "--time-budget", "0s"];
    let answer = answer(&mut validate(out.path(), &arguments));
    assert_eq!(answer.code, Some(0));
    assert_eq!(last_line(&answer.out), "0 passed, 0 failed, 2 skipped");
    let report = report(out.path());
    let reason = scene(&report, "slow/sleeps")["verdict"]["reason"].as_str().expect("a reason");
    assert_eq!(reason, "the time budget of 0 s ended before it ran");
}

#[test]
fn resume_takes_over_finished_scenes_only_under_the_same_settings() {
    let out = temporary();
    answer(&mut validate(out.path(), &["--scene", "ok/again"]));
    let time = |folder: &Path| scene(&report(folder), "ok/again")["lines"][0]["rows"][0]["seconds"].clone();
    // A mark that only a result that was taken over can carry.
    let finished = out.path().join("finished/ok__again.json");
    let text = std::fs::read_to_string(&finished).expect("the finished scene");
    let mut value: Value = serde_json::from_str(&text).expect("JSON");
    value["record"]["lines"][0]["rows"][0]["seconds"] = 1234.5.into();
    std::fs::write(&finished, value.to_string()).expect("the folder is ours");

    let elsewhere = temporary();
    let folder = out.path().to_str().expect("a UTF-8 path");
    let resumed = answer(&mut validate(elsewhere.path(), &["--scene", "ok/*", "--resume", folder]));
    assert_eq!(resumed.code, Some(0), "{}", resumed.err);
    assert_eq!(last_line(&resumed.out), "4 passed, 0 failed, 0 skipped");
    assert_eq!(time(elsewhere.path()), 1234.5);

    answer(&mut validate(out.path(), &["--scene", "ok/again", "--resume", folder, "--repeat", "2"]));
    assert_ne!(time(out.path()), 1234.5, "other settings: the scene runs again");
}

/// How long to wait for what takes milliseconds: a busy machine is no failure.
const PATIENCE: Duration = Duration::from_secs(120);

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_a_readable_partial_report_that_can_be_resumed() {
    let out = temporary();
    let mut command = validate(out.path(), &["--scene", "ok/again", "--scene", "slow/sleeps"]);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the program starts");
    let finished = out.path().join("finished/ok__again.json");
    let start = Instant::now();
    while !finished.exists() && start.elapsed() < PATIENCE {
        std::thread::sleep(Duration::from_millis(5));
    }
    let signal = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill starts");
    assert!(signal.success());
    let status = child.wait().expect("the program ends");
    assert_eq!(status.code(), Some(130));
    let partial = report(out.path());
    assert_eq!(partial["interrupted"], true);
    assert_eq!(scene(&partial, "ok/again")["verdict"]["kind"], "passed");
    assert_eq!(scene(&partial, "slow/sleeps")["verdict"]["kind"], "skipped");

    let folder = out.path().to_str().expect("a UTF-8 path");
    let mut again =
        validate(out.path(), &["--scene", "ok/again", "--scene", "slow/sleeps", "--resume", folder]);
    assert_eq!(answer(&mut again).code, Some(0));
    assert_eq!(report(out.path())["interrupted"], false);
}

#[cfg(target_os = "linux")]
#[test]
fn no_child_outlives_its_parent() {
    let out = temporary();
    let mut command = validate(out.path(), &["--scene", "broken/hang"]);
    let mut parent = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the program starts");
    let children = format!("/proc/{0}/task/{0}/children", parent.id());
    let start = Instant::now();
    let child = loop {
        let text = std::fs::read_to_string(&children).unwrap_or_default();
        if let Some(child) = text.split_whitespace().next() {
            break child.to_owned();
        }
        assert!(start.elapsed() < PATIENCE, "no child was started");
        std::thread::sleep(Duration::from_millis(2));
    };
    parent.kill().expect("it is ours");
    parent.wait().expect("it was killed");
    let gone = || {
        // A zombie that nobody has collected yet is gone as well.
        let status = std::fs::read_to_string(format!("/proc/{child}/status")).unwrap_or_default();
        status.is_empty() || status.lines().any(|line| line.starts_with("State:\tZ"))
    };
    while !gone() {
        assert!(start.elapsed() < PATIENCE, "process {child} still runs");
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn the_baseline_gates_what_it_should() {
    let (out, folder) = (temporary(), temporary());
    let path = folder.path().join("baseline.json");
    let file = path.to_str().expect("a UTF-8 path");
    let run = |extra: &[&str]| {
        let mut arguments = vec!["--scene", "ok/again", "--baseline", file];
        arguments.extend(extra);
        answer(&mut validate(out.path(), &arguments))
    };
    assert_eq!(run(&[]).code, Some(2), "there is no such file");
    assert_eq!(run(&["--update-baseline"]).code, Some(0));
    let taken = std::fs::read_to_string(&path).expect("the baseline");
    assert_eq!(run(&[]).code, Some(0));

    let altered = |pointer: &str, value: Value| {
        let mut baseline: Value = serde_json::from_str(&taken).expect("JSON");
        *baseline.pointer_mut(pointer).expect("the baseline has it") = value;
        std::fs::write(&path, baseline.to_string()).expect("the folder is ours");
    };
    let row = "/scenes/ok~1again/lines/first/rows/2";
    for (key, value) in [
        (format!("{row}/errors/error"), 0.009.into()),
        (format!("{row}/counts/iterations"), 4.into()),
        (format!("{row}/state_hash"), "0000000000000000".into()),
        ("/scenes/ok~1again/lines/first/orders/error/order".to_owned(), 2.2.into()),
    ] {
        altered(&key, value);
        let answer = run(&[]);
        assert_eq!(answer.code, Some(3), "{key}: {}", answer.out);
    }
    altered(&format!("{row}/seconds"), 1e-12.into());
    assert_eq!(run(&[]).code, Some(0), "a time never gates");
    // A baseline of another machine: one iteration more or less is allowed, other bits are only mentioned.
    for (key, value, code) in [
        ("counts/iterations", Value::from(4), 0),
        ("counts/iterations", 5.into(), 3),
        ("state_hash", "00".into(), 0),
    ] {
        altered(&format!("{row}/{key}"), value);
        let text = std::fs::read_to_string(&path).expect("the baseline");
        let mut other: Value = serde_json::from_str(&text).expect("JSON");
        other["scenes"]["ok/again"]["fingerprint"] = "another".into();
        std::fs::write(&path, other.to_string()).expect("the folder is ours");
        assert_eq!(run(&[]).code, Some(code), "{key}");
    }
}

#[test]
fn a_scene_that_fails_is_not_taken_into_the_baseline() {
    let (out, folder) = (temporary(), temporary());
    let path = folder.path().join("baseline.json");
    let file = path.to_str().expect("a UTF-8 path");
    let arguments =
        ["--scene", "broken/wrong", "--scene", "ok/again", "--baseline", file, "--update-baseline"];
    let answer = answer(&mut validate(out.path(), &arguments));
    assert_eq!(answer.code, Some(1));
    assert!(answer.err.contains("broken/wrong did not pass"), "{}", answer.err);
    let text = std::fs::read_to_string(&path).expect("the baseline");
    assert!(text.contains("ok/again") && !text.contains("broken/wrong"));
}

#[test]
fn wrong_usage_exits_2_and_says_what_is_allowed() {
    let out = temporary();
    for (arguments, words) in [
        (&["--scene", "ok/nothing"][..], "no scene matches `ok/nothing`"),
        (&["--crate", "nothing"], "no scene matches `nothing/*`"),
        (&["--suite", "stress"], "selects no scene"),
        (&["--shard", "3/2"], "1 ≤ i ≤ n"),
        (&["--threads", "0"], "≥ 1"),
        (&["--ladder", "0"], "≥ 1"),
        (&["--time-budget", "soon"], "such as 90s"),
        (&["--format", "xml"], "possible values"),
        (&["--suite", "slow"], "possible values"),
        (&["--nonsense"], "unexpected argument"),
    ] {
        let answer = answer(&mut validate(out.path(), arguments));
        assert_eq!(answer.code, Some(2), "{arguments:?}: {}", answer.err);
        assert!(answer.err.contains(words), "{arguments:?}: {}", answer.err);
    }
    assert!(!out.path().join("report.json").exists());
}

#[test]
fn an_output_folder_that_cannot_be_written_exits_2() {
    let folder = temporary();
    let file = folder.path().join("file");
    std::fs::write(&file, "here first").expect("the folder is ours");
    for out in [file.join("below"), PathBuf::from("/proc/validation"), PathBuf::from("/dev/full/below")] {
        let answer = answer(&mut validate(&out, &["--scene", "ok/again"]));
        assert_eq!(answer.code, Some(2), "{}: {}", out.display(), answer.err);
        assert!(answer.err.contains("cannot write"), "{}", answer.err);
    }
    assert_eq!(std::fs::read(&file).expect("the file"), b"here first");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_exits_2_and_leaves_nothing_half_written() {
    let out = temporary();
    // A limit on the size of files stands in for a full disk: writes fail in their middle.
    let limited = "trap '' XFSZ; ulimit -f 2; exec \"$0\" \"$@\"";
    let mut command = Command::new("sh");
    command.args(["-c", limited, env!("CARGO_BIN_EXE_validation"), "validate", "--scenes"]).arg(scenes());
    command.arg("--out").arg(out.path()).args(["--scene", "ok/power"]);
    let answer = answer(&mut command);
    assert_eq!(answer.code, Some(2), "{}{}", answer.out, answer.err);
    assert!(answer.err.contains("cannot write"), "{}", answer.err);
    for folder in [out.path().to_owned(), out.path().join("finished")] {
        let left: Vec<_> =
            std::fs::read_dir(&folder).expect("the folder").flatten().map(|e| e.path()).collect();
        assert!(left.iter().all(|path| path.is_dir()), "{left:?}");
    }
    let full = std::fs::File::create("/dev/full").expect("the device is there");
    let status = validate(out.path(), &["--list"]).stdout(full).stderr(Stdio::null()).status();
    assert_eq!(status.expect("the program starts").code(), Some(2));
}

#[test]
fn scenes_are_listed_and_explained_without_running() {
    let out = temporary();
    let list = answer(&mut validate(out.path(), &["--list"]));
    assert_eq!(list.code, Some(0));
    assert!(list.out.contains("ok/power") && list.out.contains("broken/panic"), "{}", list.out);
    let explained = answer(&mut validate(out.path(), &["--explain", "ok/power"]));
    for words in
        ["e = h²", "by construction", "order 2 ± 0.05", "distance > 0", "0.4, 0.2, 0.1", "first, second"]
    {
        assert!(explained.out.contains(words), "{words}: {}", explained.out);
    }
    assert_eq!(answer(&mut validate(out.path(), &["--explain", "ok/none"])).code, Some(2));
    assert!(std::fs::read_dir(out.path()).expect("the folder").next().is_none());
}

#[test]
fn formats_are_what_they_say() {
    let out = temporary();
    let json = answer(&mut validate(out.path(), &["--scene", "ok/again", "--format", "json"]));
    let value: Value = serde_json::from_str(&json.out).expect("JSON on standard output");
    assert_eq!(value["scenes"][0]["name"], "ok/again");
    let junit = answer(&mut validate(out.path(), &["--scene", "ok/again", "--format", "junit"]));
    assert!(junit.out.starts_with("<?xml") && junit.out.contains("<testsuite"), "{}", junit.out);
}

#[test]
fn one_scene_file_runs_and_its_errors_exit_2() {
    let out = temporary();
    let run = |scene: &Path, extra: &[&str]| {
        answer(program().arg("run").arg(scene).arg("--out").arg(out.path()).args(extra))
    };
    let power = run(&scenes().join("ok/power.toml"), &[]);
    assert_eq!(power.code, Some(0), "{}", power.err);
    assert!(power.out.contains("error    1.000000e-2"), "{}", power.out);
    assert!(out.path().join("summary.txt").is_file());
    let error = run(&scenes().join("broken/error.toml"), &[]);
    assert!(error.code == Some(2) && error.err.contains("no convergence at element 12"), "{}", error.err);
    assert_eq!(run(Path::new("/nonexistent.toml"), &[]).code, Some(2));
    assert_eq!(run(&scenes().join("ok/power.toml"), &["--export", "bmp"]).code, Some(2));
}
