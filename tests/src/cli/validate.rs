//! `validate` and `merge`.

use super::arguments::{Format, MergeOptions, ValidateOptions};
use super::{CliError, note, print};
use crate::baseline::Baseline;
use crate::record::{Check, Report, SceneRecord};
use crate::report::{self, PlotFiles};
use crate::runner::output::{self, OutputError};
use crate::runner::progress::Progress;
use crate::runner::{self, Earlier, Pictures, Settings, environment, exit_code};
use crate::scene::Scene;
use crate::scene::selection::{Selection, read_all, select};
use crate::scene::validation::{Expectation, Suite, Validation};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The committed scenes and baseline stand beside this package's manifest.
fn package() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The folder of the workspace's own scenes.
pub(super) fn committed_scenes() -> PathBuf {
    package().join("scenes")
}

/// The workspace's documentation.
pub(super) fn documentation() -> PathBuf {
    package().parent().unwrap_or(package()).join("docs")
}

fn default_output() -> PathBuf {
    package().parent().unwrap_or(package()).join("target/validation")
}

pub(crate) fn validate(options: &ValidateOptions) -> Result<u8, CliError> {
    let root = options.scenes.clone().unwrap_or_else(committed_scenes);
    let all = read_all(&root)?;
    if let Some(name) = &options.explain {
        let selection = Selection { patterns: vec![name.clone()], ..Selection::default() };
        let texts: Vec<String> = select(all, &selection)?.iter().filter_map(explanation).collect();
        print(&texts.join("\n"))?;
        return Ok(0);
    }
    // A scene that is asked for by name runs whole, whatever suite it is in.
    let picked = options.list || !options.scene.is_empty();
    let suite = options.suite.or(if picked { None } else { Some(Suite::Quick) });
    let selection = Selection { suite, patterns: options.scene.clone(), crates: options.crates.clone() };
    let known = all.len();
    let mut scenes = select(all, &selection)?;
    if options.list {
        print(&list(&scenes))?;
        return Ok(0);
    }
    if scenes.is_empty() {
        let asked = suite.map_or_else(|| "this".to_owned(), |suite| format!("--suite {suite}"));
        return Err(CliError::NothingSelected { asked, known });
    }
    if let Some(shard) = options.shard {
        scenes = shard.of(scenes);
    }
    run(options, suite, &scenes)
}

fn run(options: &ValidateOptions, suite: Option<Suite>, scenes: &[Scene]) -> Result<u8, CliError> {
    let baseline_path = baseline_path(options);
    let baseline = match &baseline_path {
        Some(path) if path.exists() || !options.update_baseline => Some(Baseline::read(path)?),
        Some(_) => Some(Baseline::default()),
        None => None,
    };
    let settings = settings(options, suite)?;
    let fingerprint = environment::describe().fingerprint;
    let compare = |record: &SceneRecord| -> Vec<Check> {
        let validation =
            scenes.iter().find(|scene| scene.name == record.name).and_then(|s| s.file.validation.as_ref());
        let floor = |line: &str, measure: &str| stated_floor(validation, line, measure);
        baseline.as_ref().map(|baseline| baseline.compare(record, &fingerprint, &floor)).unwrap_or_default()
    };
    let interrupted = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&interrupted);
    if let Err(error) = ctrlc::set_handler(move || flag.store(true, Ordering::Relaxed)) {
        note(&format!("Ctrl-C will not leave a partial report: {error}"));
    }
    let report = runner::run(scenes, &settings, &compare, &interrupted, Progress::on_standard_error)?;
    let plots = if options.no_plots { PlotFiles::Omit } else { PlotFiles::Write };
    report::write_report(&report, &settings.output, plots)?;
    show(&report, options.format)?;
    note(&format!("report: {}", settings.output.join("index.html").display()));
    if options.update_baseline
        && let (Some(path), Some(baseline)) = (&baseline_path, baseline)
    {
        update(baseline, &report, path)?;
    }
    if options.open {
        open(&settings.output.join("index.html"));
    }
    Ok(exit_code(&report))
}

fn settings(options: &ValidateOptions, suite: Option<Suite>) -> Result<Settings, CliError> {
    let output = options.out.clone().or_else(|| options.resume.clone()).unwrap_or_else(default_output);
    if let Some(earlier) = options.resume.as_ref().filter(|earlier| **earlier != output) {
        copy_folders(earlier, &output, &["finished", "logs", "frames"])?;
    }
    Ok(Settings {
        suite,
        ladder_points: options.ladder,
        repeats: options.repeat,
        threads: (!options.threads.is_empty()).then(|| options.threads.clone()),
        time_budget: options.time_budget,
        shard: options.shard,
        output,
        earlier: if options.resume.is_some() { Earlier::Keep } else { Earlier::Replace },
        pictures: if options.no_plots { Pictures::Omitted } else { Pictures::Made },
        program: std::env::current_exe().map_err(CliError::Program)?,
        command: std::env::args().collect(),
    })
}

/// Scenes of another folder are compared with a baseline only when one is named.
fn baseline_path(options: &ValidateOptions) -> Option<PathBuf> {
    match &options.baseline {
        Some(path) if path == Path::new("none") => None,
        Some(path) => Some(path.clone()),
        None if options.scenes.is_some() => None,
        None => Some(package().join("baseline.json")),
    }
}

fn stated_floor(validation: Option<&Validation>, line: &str, measure: &str) -> f64 {
    let spec = validation.and_then(|validation| validation.measures.iter().find(|spec| spec.name == measure));
    spec.and_then(|spec| spec.expectation(line).floor).map_or(0.0, |floor| floor.value())
}

fn update(mut baseline: Baseline, report: &Report, path: &Path) -> Result<(), CliError> {
    for scene in baseline.update(report) {
        note(&format!("baseline: {scene} did not pass and keeps what it had"));
    }
    baseline.write(path)?;
    note(&format!("baseline: {} written", path.display()));
    Ok(())
}

fn show(report: &Report, format: Format) -> Result<(), CliError> {
    print(&match format {
        Format::Human => report::table(report),
        Format::Json => report::report_json(report)?,
        Format::Junit => report::junit(report),
    })
}

fn open(page: &Path) {
    let program = if cfg!(target_os = "macos") { "open" } else { "xdg-open" };
    if let Err(error) = std::process::Command::new(program).arg(page).spawn() {
        note(&format!("{program} cannot open the report: {error}"));
    }
}

pub(crate) fn merge(options: &MergeOptions) -> Result<u8, CliError> {
    let output = options.out.clone().unwrap_or_else(default_output);
    output::make_folder(&output)?;
    let mut reports = Vec::new();
    for folder in &options.reports {
        reports.push(report::read_report(&folder.join("report.json"))?);
    }
    let merged = report::merge(reports)?;
    for warning in &merged.warnings {
        note(&format!("warning: {warning}"));
    }
    for folder in &options.reports {
        copy_folders(folder, &output, &["logs", "frames"])?;
    }
    let plots = if options.no_plots { PlotFiles::Omit } else { PlotFiles::Write };
    report::write_report(&merged.report, &output, plots)?;
    show(&merged.report, options.format)?;
    note(&format!("report: {}", output.join("index.html").display()));
    Ok(exit_code(&merged.report))
}

/// Copies the files of named folders, where there are such folders.
fn copy_folders(from: &Path, to: &Path, names: &[&str]) -> Result<(), OutputError> {
    for name in names {
        let source = from.join(name);
        let target = to.join(name);
        if !source.is_dir() || source == target {
            continue;
        }
        output::make_folder(&target)?;
        let unreadable = |error| OutputError::Read { path: source.clone(), source: error };
        for entry in std::fs::read_dir(&source).map_err(unreadable)? {
            let entry = entry.map_err(unreadable)?;
            if entry.path().is_file() {
                let bytes = std::fs::read(entry.path()).map_err(unreadable)?;
                output::write_file(&target.join(entry.file_name()), &bytes)?;
            }
        }
    }
    Ok(())
}

fn list(scenes: &[Scene]) -> String {
    let mut text = String::new();
    let width = scenes.iter().map(|scene| scene.name.len()).max().unwrap_or(0);
    for scene in scenes {
        if let Some(validation) = &scene.file.validation {
            let suites: Vec<String> = validation.suites.iter().map(Suite::to_string).collect();
            let (name, title) = (&scene.name, &validation.title);
            // Writing to a string does not fail.
            let _ = writeln!(text, "{name:width$}  {:17}  {title}", suites.join(", "));
        }
    }
    let _ = writeln!(text, "{} scenes", scenes.len());
    text
}

fn explanation(scene: &Scene) -> Option<String> {
    let validation = scene.file.validation.as_ref()?;
    let mut text = String::new();
    let mut line = |label: &str, content: &str| {
        if !content.is_empty() {
            // Writing to a string does not fail.
            let _ = writeln!(text, "{label:10} {content}");
        }
    };
    line(&scene.name, &validation.title);
    line("claim", &validation.claim);
    line("formula", &validation.formula);
    line("reference", &validation.reference.citation);
    for spec in &validation.measures {
        let name = format!("{} [{}]", spec.name, spec.unit);
        line("measure", &format!("{name}{}", expectation_text(&spec.expectation(""))));
        for method in spec.methods.keys() {
            line("", &format!("{method}{}", expectation_text(&spec.expectation(method))));
        }
    }
    for (name, bounds) in &validation.invariants {
        line("invariant", &format!("{name} {}", crate::checks::describe(bounds)));
    }
    let ladder = &validation.ladder;
    let values: Vec<String> = ladder.values.iter().map(|value| value.value().to_string()).collect();
    line("ladder", &format!("{} [{}]: {}", ladder.name, ladder.unit, values.join(", ")));
    line("methods", &validation.methods.join(", "));
    line("limit", &format!("{} s a row", validation.time_limit_s.value()));
    line("file", &scene.path.display().to_string());
    Some(text)
}

fn expectation_text(expected: &Expectation) -> String {
    let bound = expected.bound.map(|bound| format!(" ≤ {:e} at the last point", bound.value()));
    let order = expected.order.zip(expected.order_tolerance);
    let order = order.map(|(order, band)| format!(", order {} ± {}", order.value(), band.value()));
    format!("{}{}", bound.unwrap_or_default(), order.unwrap_or_default())
}
