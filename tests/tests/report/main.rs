//! The report's properties: well-formed, complete, escaped, whole.

mod answers;
mod browser;
mod fixture;
mod markup;
mod plots;

use fixture::{ODD, broken_scene, everything, report, scene};
use markup::elements;
use std::path::Path;
use validation::record::{Report, SCHEMA_VERSION, Verdict};
use validation::report::*;

#[test]
fn table_fits_a_hundred_columns_and_ends_with_the_counts() {
    let mut long = scene("a-crate-with-a-long-name", &"very_long_stem_".repeat(9), "t");
    long.lines[0].label = "a label that goes on and on and on and on, far beyond all columns".into();
    long.lines[0].orders[0].order = -1.2345e300;
    let mut scenes = everything().scenes;
    scenes.push(long);
    let text = table(&report(scenes));
    for line in text.lines() {
        assert!(line.chars().count() <= WIDTH, "{} columns: {line}", line.chars().count());
        assert!(line.chars().all(|c| !c.is_control()), "{line:?}");
    }
    assert_eq!(text.lines().last(), Some("4 passed, 1 failed, 1 skipped"));
    assert!(text.ends_with("skipped\n"));
    for reason in
        ["Newton stopped at iteration 50", "time limit of 60 s", "bunny.ply is not in this checkout"]
    {
        assert!(text.contains(reason), "{reason}");
    }
    let lines: usize = everything().scenes.iter().map(|scene| scene.lines.len().max(1)).sum();
    let listed = text.lines().skip(2).take_while(|line| !line.is_empty()).count();
    assert_eq!(listed, lines + 3, "one line a method");
}

#[test]
fn table_of_nothing_still_ends_with_the_counts() {
    assert_eq!(table(&report(vec![])).lines().last(), Some("0 passed, 0 failed, 0 skipped"));
    let mut stopped = report(vec![]);
    stopped.interrupted = true;
    assert!(table(&stopped).contains("--resume"));
}

#[test]
fn csv_reads_back_to_the_same_numbers() {
    let made = everything();
    let text = rows_csv(&made);
    let records = parsed_csv(&text);
    let width = records[0].len();
    assert!(records.iter().all(|record| record.len() == width), "every record has every column");
    let rows: Vec<_> = made
        .scenes
        .iter()
        .flat_map(|scene| {
            scene.lines.iter().flat_map(move |line| line.rows.iter().map(move |row| (scene, line, row)))
        })
        .collect();
    assert_eq!(records.len(), rows.len() + 1);
    let column =
        |name: &str| records[0].iter().position(|c| c == name).unwrap_or_else(|| panic!("no column {name}"));
    for ((scene, line, row), record) in rows.iter().zip(&records[1..]) {
        assert_eq!(record[column("scene")], scene.name);
        assert_eq!(record[column("method")], line.label);
        assert_eq!(record[column("seconds")].parse::<f64>().unwrap().to_bits(), row.seconds.to_bits());
        match row.errors.get("displacement") {
            Some(e) => assert_eq!(
                record[column("error:displacement")].parse::<f64>().unwrap().to_bits(),
                e.to_bits()
            ),
            None => assert_eq!(record[column("error:displacement")], ""),
        }
        assert_eq!(record[column("count:newton iterations")], "7");
    }
}

/// RFC 4180, written apart from the writer.
fn parsed_csv(text: &str) -> Vec<Vec<String>> {
    let (mut records, mut record, mut cell, mut quoted) = (vec![], vec![], String::new(), false);
    let mut letters = text.chars().peekable();
    while let Some(c) = letters.next() {
        match c {
            '"' if quoted && letters.peek() == Some(&'"') => cell.push(letters.next().expect("a quote")),
            '"' => quoted = !quoted,
            ',' if !quoted => record.push(std::mem::take(&mut cell)),
            '\r' if !quoted => {
                assert_eq!(letters.next(), Some('\n'));
                record.push(std::mem::take(&mut cell));
                records.push(std::mem::take(&mut record));
            }
            c => cell.push(c),
        }
    }
    assert!(!quoted && cell.is_empty() && record.is_empty());
    records
}

#[test]
fn junit_is_xml_whose_counts_agree_with_its_cases() {
    let made = everything();
    let found = elements(&junit(&made));
    let named = |name: &str| found.iter().filter(|e| e.name == name).count() as f64;
    assert_eq!(named("testcase"), made.scenes.len() as f64);
    assert_eq!(named("testsuite"), 3.0);
    let whole = &found[0];
    assert_eq!((whole.name.as_str(), whole.number("tests")), ("testsuites", 5.0));
    assert_eq!(whole.number("failures"), named("failure"));
    assert_eq!(whole.number("errors"), named("error"));
    assert_eq!(whole.number("errors"), 1.0, "a crash is an error, not a failure");
    assert_eq!(whole.number("skipped"), named("skipped"));
    let sum = |key: &str| found.iter().filter(|e| e.name == "testsuite").map(|e| e.number(key)).sum::<f64>();
    for key in ["tests", "failures", "errors", "skipped"] {
        assert_eq!(sum(key), whole.number(key), "{key}");
    }
    assert!(found.iter().any(|e| e.name == "error" && e.text.contains("<&>")), "messages survive escaping");
}

#[test]
fn json_reads_back_and_names_what_is_wrong() {
    let folder = fresh_folder("json");
    let made = everything();
    write_report(&made, &folder, PlotFiles::Write).unwrap();
    let path = folder.join("report.json");
    let back = read_report(&path).unwrap();
    // Without serde_json's `float_roundtrip` some numbers came back one bit off.
    let same = report_json(&back).unwrap() == report_json(&made).unwrap();
    assert!(same, "a report reads back to the same bits");
    let text = std::fs::read_to_string(&path).unwrap();
    write_file(&path, text.replacen("\"suite\"", "\"sweet\"", 1).as_bytes()).unwrap();
    let error = read_report(&path).unwrap_err().to_string();
    assert!(error.contains("sweet") && error.contains("line") && error.contains("report.json"), "{error}");
    let version =
        text.replacen(&format!("\"schema_version\": {SCHEMA_VERSION}"), "\"schema_version\": 999", 1);
    write_file(&path, version.replacen("\"suite\"", "\"sweet\"", 1).as_bytes()).unwrap();
    assert!(
        matches!(read_report(&path), Err(ReadError::Version { found: 999, .. })),
        "the version is named first"
    );
    assert!(matches!(read_report(&folder.join("none.json")), Err(ReadError::File { .. })));
}

/// `UPDATE=1 cargo test -p validation --test report schema` writes it anew.
#[test]
fn committed_schema_is_up_to_date() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("schema/report.schema.json");
    let made = report_schema().unwrap();
    if std::env::var_os("UPDATE").is_some() {
        write_file(&path, made.as_bytes()).unwrap();
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(committed == made, "{} is out of date: run this test with UPDATE=1", path.display());
}

#[test]
fn report_folder_is_complete_and_has_no_temporary_file() {
    let folder = fresh_folder("folder");
    write_report(&everything(), &folder, PlotFiles::Write).unwrap();
    let names = file_names(&folder);
    assert_eq!(names, ["env.json", "index.html", "junit.xml", "plots", "report.json", "rows.csv"]);
    // Four scenes have runs; kernels one measure, the others two.
    assert_eq!(file_names(&folder.join("plots")).len(), 4 + 1 + 3 * 2);
    let env: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(folder.join("env.json")).unwrap()).unwrap();
    assert_eq!(env["cores"], 2);
    let other = fresh_folder("no-plots");
    write_report(&everything(), &other, PlotFiles::Omit).unwrap();
    assert!(!other.join("plots").exists());
}

#[test]
fn a_full_disk_leaves_the_old_file_and_nothing_else() {
    let folder = fresh_folder("full");
    let path = folder.join("rows.csv");
    write_file(&path, b"old").unwrap();
    let full = write_file_with(&path, |out| {
        out.write_all(&[0; 100_000])?;
        Err(std::io::ErrorKind::StorageFull.into())
    });
    let words = full.unwrap_err().to_string();
    assert!(words.contains("rows.csv") && words.contains("no storage space"), "{words}");
    assert_eq!(std::fs::read(&path).unwrap(), b"old");
    assert_eq!(file_names(&folder), ["rows.csv"]);
    // A folder where the file should go: the rename fails, the temporary file goes.
    std::fs::create_dir(folder.join("index.html")).unwrap();
    assert!(write_file(&folder.join("index.html"), b"x").is_err());
    assert_eq!(file_names(&folder), ["index.html", "rows.csv"]);
    // A file where the folder should be.
    assert!(write_report(&everything(), &path, PlotFiles::Write).is_err());
}

#[test]
fn shards_merge_into_what_one_run_would_have_been() {
    let whole = everything();
    let part = |number: usize, scenes: &[usize]| {
        let scenes = scenes.iter().map(|&i| whole.scenes[i].clone()).collect();
        Report { shard: Some(format!("{number}/2")), scenes, seconds: 10.0, ..whole.clone() }
    };
    let (a, b) = (part(1, &[0, 2, 4]), part(2, &[1, 3]));
    let merged = merge(vec![b.clone(), a.clone()]).unwrap();
    assert!(merged.warnings.is_empty());
    let names: Vec<&str> = merged.report.scenes.iter().map(|scene| scene.name.as_str()).collect();
    assert!(names.is_sorted() && names.len() == 5, "{names:?}");
    assert_eq!((merged.report.seconds, merged.report.shard.clone()), (20.0, None));
    let in_order = |report: &Report| {
        let mut report = report.clone();
        report.scenes.sort_by(|a, b| a.name.cmp(&b.name));
        table(&report)
    };
    assert_eq!(table(&merged.report), in_order(&whole));
    let merged = merge(vec![a.clone()]).unwrap();
    assert_eq!(merged.warnings, [MergeWarning::ShardMissing { missing: 2, of: 2 }]);
}

#[test]
fn shards_that_do_not_belong_together_are_refused_or_reported() {
    let a = report(vec![scene("c", "one", "t")]);
    let mut b = report(vec![scene("c", "two", "t")]);
    assert_eq!(merge(vec![]).unwrap_err(), MergeError::Empty);
    let twice = merge(vec![a.clone(), b.clone(), a.clone()]).unwrap_err();
    assert_eq!(twice, MergeError::DuplicateScene { name: "c/one".into(), first: 0, second: 2 });
    b.environment.fingerprint = "other".into();
    let merged = merge(vec![a.clone(), b.clone()]).unwrap();
    assert!(matches!(merged.warnings[..], [MergeWarning::FingerprintsDiffer { .. }]));
    assert_eq!(merged.report.environment.fingerprint, "", "nothing is compared bit by bit");
    b.suite = "full".into();
    assert!(matches!(merge(vec![a.clone(), b.clone()]), Err(MergeError::SuitesDiffer { index: 1, .. })));
    b.schema_version += 1;
    assert!(matches!(merge(vec![a, b]), Err(MergeError::SchemaVersion { index: 1, .. })));
}

#[test]
fn page_is_well_formed_escaped_and_self_contained() {
    let folder = fresh_folder("page");
    let made = everything();
    let html = page(&made, &folder);
    let found = elements(&html);
    let ids: Vec<&str> = found.iter().filter_map(|e| e.attribute("id")).collect();
    let mut distinct = ids.clone();
    distinct.sort_unstable();
    distinct.dedup();
    assert_eq!(distinct.len(), ids.len(), "ids are unique");
    for link in found.iter().filter_map(|e| e.attribute("href")) {
        let inside = link.strip_prefix('#').map(|id| ids.contains(&id));
        assert!(inside == Some(true) || link == "data:,", "link {link} leads nowhere");
    }
    for source in found.iter().filter_map(|e| e.attribute("src")) {
        assert!(source.starts_with("data:"), "{source}");
    }
    assert_eq!(found.iter().filter(|e| e.name == "script").count(), 1, "a name cannot bring a script");
    assert!(!html.contains("<b>&amp;\"name"), "names are escaped");
    assert!(found.iter().any(|e| e.name == "summary" && e.text.contains("<b>&\"name\"</b>")));
    let details = found.iter().filter(|e| e.name == "details").count();
    assert_eq!(details, made.scenes.len());
    let summary = found.iter().position(|e| e.attribute("id") == Some("summary")).unwrap();
    let sentences =
        found[summary + 1..].iter().take_while(|e| e.name != "section").filter(|e| e.name == "li").count();
    assert_eq!(sentences, 5);
    assert!(html.contains("frames/none.gif"), "a missing picture is named");
}

#[test]
fn sentences_name_the_cheapest_method_that_reached_an_error() {
    let mut only = scene("c", "s", "Title");
    only.lines.truncate(2);
    let point = |label: &str, error: f64, seconds: f64, line: &mut validation::record::Line| {
        line.label = label.into();
        line.rows = vec![fixture::row(0.1, error, seconds)];
    };
    point("slow and exact", 5e-4, 2.0, &mut only.lines[0]);
    point("fast and rough", 5e-3, 0.5, &mut only.lines[1]);
    let cheapest = &sentences(&report(vec![only.clone()]))[2];
    let wanted = "1 % costs least with fast and rough (0.500 s), 0.1 % costs least with slow and exact (2.00 s), \
                  0.01 % was not reached";
    let wanted = wanted.replace("0.500 s", "500 ms");
    assert!(cheapest.contains(&wanted), "{cheapest}");
    only.verdict = Verdict::Failed;
    assert!(
        sentences(&report(vec![only]))[2].contains("No scene passed"),
        "a time counts only if its checks passed"
    );
}

#[test]
fn guide_lists_every_scene_and_depends_on_no_result() {
    let made = everything();
    let text = guide(&made.scenes);
    for scene in &made.scenes {
        assert!(text.contains(&format!("--scene {}`", scene.name)), "{}", scene.name);
    }
    assert!(!text.contains("<script>"), "names are escaped");
    let mut other = made.scenes.clone();
    for scene in &mut other {
        scene.verdict = Verdict::Failed;
        scene.checks.clear();
        scene.lines.iter_mut().for_each(|line| line.rows.clear());
    }
    assert_eq!(guide(&other), text);
}

#[test]
fn troubles_name_every_failure_and_group_what_is_the_same() {
    let mut other = broken_scene();
    other.name = "other/scene".into();
    let found = troubles(&report(vec![scene("c", "good", "t"), broken_scene(), other]));
    let kinds: Vec<TroubleKind> = found.iter().map(|trouble| trouble.kind).collect();
    assert!(kinds.is_sorted(), "failures first");
    // In each broken scene: a check, a time-out, an error, and six crashes that are one; the missing baseline is one.
    assert_eq!(kinds.iter().filter(|kind| **kind == TroubleKind::Failure).count(), 2 * 4);
    assert_eq!(found.len(), 9);
    assert_eq!(found[8].scenes, ["c/good", "mechanics-core/broken", "other/scene"]);
    let crashes = found.iter().find(|trouble| trouble.reason.starts_with("crashed")).unwrap();
    assert!(
        crashes.what.contains(ODD)
            && crashes.what.contains("0.200, 0.100")
            && crashes.what.contains("0.00625")
    );
}

pub(crate) fn fresh_folder(name: &str) -> std::path::PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("report").join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder for the test");
    folder
}

fn file_names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let mut names: Vec<String> =
        entries.map(|entry| entry.expect("an entry").file_name().into_string().expect("UTF-8")).collect();
    names.sort();
    names
}
