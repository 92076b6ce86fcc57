//! What accuracy costs: sentences that follow from the rows, and from nothing else.

use crate::fixture::{everything, report, row, scene};
use crate::fresh_folder;
use crate::markup::elements;
use std::path::Path;
use validation::record::{Exit, Line, SceneRecord, Verdict};
use validation::report::{answers, asked_scenes, page};
use validation::scene::selection::read_all;

/// A method with runs of these errors and times.
fn method(label: &str, runs: &[(f64, f64)]) -> Line {
    let rows = runs.iter().map(|&(error, seconds)| row(0.1, error, seconds)).collect();
    Line { label: label.into(), rows, orders: vec![] }
}

fn pendulum(lines: Vec<Line>) -> SceneRecord {
    SceneRecord { lines, ..scene("lagrangian", "double-pendulum-regular", "Two <rods>") }
}

fn words(scenes: &[SceneRecord]) -> Vec<String> {
    answers(scenes).into_iter().flat_map(|answer| answer.clauses).map(|clause| clause.words).collect()
}

#[test]
fn the_cheapest_run_that_is_exact_enough_is_named_with_what_the_others_take() {
    let lines = vec![
        method("rough", &[(0.5, 0.001), (0.04, 0.01)]),
        // The cheapest run that reaches 0.002 is its second one.
        method("slow", &[(0.009, 1.0), (2e-3, 3.0), (1e-7, 9.0)]),
        method("quick", &[(0.3, 0.1), (1.1e-3, 1.5), (1e-4, 1.6)]),
        method("exact", &[(1e-12, 6.0)]),
    ];
    // Three of four are more than half; the third best error is 1e-4.
    assert_eq!(
        words(&[pendulum(lines.clone())]),
        ["an error of 1·10⁻⁴ in displacement, which 3 of 4 methods reach, costs least with quick: 1.60 s; \
          the next, exact, takes 3.75 times that, the last, slow, 5.62 times (rough stops at 4.00 %)"]
    );
    let mut simulated = pendulum(lines[1..3].to_vec());
    simulated.lines.iter_mut().flat_map(|line| &mut line.rows).for_each(|row| {
        row.simulated_seconds = Some(10.0);
        row.threads = 2;
    });
    // A run with more threads is another one, and is not compared.
    let fewer = row(0.1, 0.5e-2, 20.0);
    simulated.lines[0].rows.push(fewer);
    assert_eq!(
        words(&[simulated]),
        [
            "an error of 0.5 % in displacement, which 2 of 2 methods reach, costs least with quick: 150 ms a simulated \
          second; the next, slow, takes 133 times that"
        ]
    );
}

#[test]
fn what_did_not_pass_or_cannot_be_compared_answers_nothing() {
    let two = || vec![method("a", &[(1e-3, 1.0)]), method("b", &[(1e-3, 2.0)])];
    assert_eq!(words(&[pendulum(two())]).len(), 1);
    for verdict in [Verdict::Failed, Verdict::Skipped { reason: "stopped".into() }] {
        assert!(answers(&[SceneRecord { verdict, ..pendulum(two()) }]).is_empty());
    }
    assert!(answers(&[scene("lagrangian", "unasked", "t")]).is_empty());
    assert!(answers(&[pendulum(two()[..1].to_vec())]).is_empty(), "one method is no choice");
    assert!(answers(&[pendulum(vec![])]).is_empty());
    let mut stopped = pendulum(two());
    stopped.lines[1].rows[0].exit = Exit::TimedOut { limit_seconds: 1 };
    assert!(answers(&[stopped]).is_empty(), "one that did not end is none");
    for error in [0.0, f64::INFINITY] {
        assert!(
            answers(&[pendulum(vec![method("a", &[(error, 1.0)]), method("b", &[(error, 2.0)])])]).is_empty()
        );
    }
    // The first of a choice's scenes that passed answers it.
    let second = SceneRecord { lines: two(), ..scene("lagrangian", "pendulum-large", "One rod") };
    let first = SceneRecord { verdict: Verdict::Failed, ..pendulum(two()) };
    let titles = |scenes: &[SceneRecord]| answers(scenes)[0].clauses[0].title.clone();
    assert_eq!(titles(&[second.clone(), first]), "One rod");
    assert_eq!(titles(&[second, pendulum(two())]), "Two <rods>");
}

#[test]
fn errors_are_asked_for_in_round_numbers_over_all_magnitudes() {
    for exponent in -14..6 {
        for digits in [1.0, 1.0000001, 1.9, 2.0, 3.0, 5.0, 6.0, 9.99] {
            let error: f64 = format!("{digits}e{exponent}").parse().unwrap();
            let mut scene = pendulum(vec![method("a", &[(error, 1.0)]), method("b", &[(error, 2.0)])]);
            scene.measures[0].unit = "m".into();
            let text = &words(&[scene])[0];
            let asked =
                text.strip_prefix("an error of ").and_then(|rest| rest.split(" m in ").next()).unwrap();
            let (digit, power) = match asked.split_once("·10") {
                Some((digit, power)) => (digit, power.chars().map(plain).collect::<String>()),
                None => (asked, "0".to_owned()),
            };
            let asked: f64 = format!("{digit}e{power}").parse().unwrap();
            assert!(asked >= error && asked < 2.5001 * error, "{error} became {asked}: {text}");
        }
    }
}

fn plain(raised: char) -> char {
    let digits = "⁰¹²³⁴⁵⁶⁷⁸⁹".chars().position(|c| c == raised);
    digits.map_or('-', |digit| char::from(b'0' + digit as u8))
}

#[test]
fn a_samples_answer_says_how_many_a_splat() {
    let mut samples = scene("gaussian-deform", "samples", "Samples");
    samples.lines = vec![method("near", &[(1e-3, 1.0)]), method("far", &[(1e-3, 2.0)])];
    for row in samples.lines.iter_mut().flat_map(|line| &mut line.rows) {
        row.counts = [("samples".to_owned(), 250), ("splats".to_owned(), 1000)].into();
    }
    assert!(
        words(&[samples])[0]
            .contains("near: 1.00 s and 0.25 samples a splat; the next, far, takes 2.00 times")
    );
}

#[test]
fn each_sentence_links_to_a_plot_of_its_scene() {
    let folder = fresh_folder("answers");
    let mut made = everything();
    made.scenes.push(pendulum(vec![method("a", &[(1e-3, 1.0)]), method("b", &[(1e-3, 2.0)])]));
    let html = page(&made, &folder);
    let found = elements(&html);
    let section = found.iter().position(|e| e.attribute("id") == Some("accuracy")).unwrap();
    let link = found[section..].iter().find_map(|e| e.attribute("href")).unwrap();
    let target = found.iter().find(|e| e.attribute("id") == link.strip_prefix('#')).unwrap();
    assert_eq!((target.name.as_str(), target.attribute("class")), ("figure", Some("plot")));
    assert!(html.contains("Two &lt;rods&gt;</a>”, an error of 0.1 % in displacement"));
    let without = page(&report(vec![scene("c", "s", "t")]), &folder);
    assert!(elements(&without).iter().all(|e| e.attribute("id") != Some("accuracy")), "nothing to say");
}

#[test]
fn every_scene_that_is_asked_exists_and_has_alternatives() {
    let scenes = read_all(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes")).unwrap();
    for name in asked_scenes() {
        let scene =
            scenes.iter().find(|scene| scene.name == name).unwrap_or_else(|| panic!("no scene {name}"));
        let validation = scene.file.validation.as_ref().unwrap();
        assert!(validation.methods.len() > 1 && !validation.measures.is_empty(), "{name}");
    }
}
