//! Reports made up to hold everything a real one can: all verdicts, all ways to end, odd names, odd numbers.

use std::collections::BTreeMap;
use validation::record::*;

/// A name that breaks markup, CSV and terminals that do not guard against it.
pub(crate) const ODD: &str = "odd <b>&\"name\"</b>, 'x' </script><script>alert(1)</script>\u{1b}[31m";

pub(crate) fn row(ladder: f64, error: f64, seconds: f64) -> Row {
    Row {
        ladder,
        threads: 1,
        errors: BTreeMap::from([("displacement".into(), error), ("energy".into(), error * error)]),
        seconds,
        seconds_spread: 0.1 * seconds,
        simulated_seconds: None,
        repeats: 5,
        counts: BTreeMap::from([("newton iterations".into(), 7)]),
        invariants: BTreeMap::from([("smallest det F".into(), 0.83)]),
        terms: vec![
            TermCost { name: "elastic".into(), seconds: 0.7 * seconds },
            TermCost { name: "gravity".into(), seconds: 0.01 * seconds },
        ],
        peak_memory_bytes: 48 << 20,
        state_hash: "00f1e2d3c4b5a697".into(),
        exit: Exit::Completed,
    }
}

/// A method of `order` whose error begins at `start`, and whose time grows as h⁻³ from `seconds`.
pub(crate) fn line(label: &str, order: f64, start: f64, seconds: f64, points: usize) -> Line {
    let rows = (0..points).map(|k| {
        let h = 0.2 * 0.5f64.powi(k as i32);
        let wobble = 1.0 + 0.07 * ((k as f64 + order) * 2.3).sin();
        row(h, start * (h / 0.2).powf(order) * wobble, seconds * (0.2 / h).powi(3))
    });
    let fitted = |measure: &str, order: f64| ObservedOrder {
        measure: measure.into(),
        order: order + 0.02,
        expected: if measure == "energy" { 4.0 } else { 2.0 },
        half_width: 0.05,
        points,
    };
    Line {
        label: label.into(),
        rows: rows.collect(),
        orders: vec![fitted("displacement", order), fitted("energy", 2.0 * order)],
    }
}

pub(crate) fn check(kind: CheckKind, name: &str, verdict: Verdict, detail: &str) -> Check {
    Check { kind, name: name.into(), verdict, detail: detail.into() }
}

pub(crate) fn scene(crate_name: &str, stem: &str, title: &str) -> SceneRecord {
    let measure = |name: &str, unit: &str, order: f64| Measure {
        name: name.into(),
        unit: unit.into(),
        bound: Some(2e-3),
        order: Some(order),
        order_tolerance: Some(0.2),
        methods: BTreeMap::new(),
    };
    SceneRecord {
        name: format!("{crate_name}/{stem}"),
        crate_name: crate_name.into(),
        title: title.into(),
        claim: "A cube of neo-Hookean material under a smooth body force takes the displacement the force was made from. \
                The error of linear tetrahedra falls with the square of the edge length."
            .into(),
        formula: "u(x) = A sin(πx₁) sin(πx₂) sin(πx₃),   f = −∇·P(∇u)".into(),
        reference: Reference {
            kind: ReferenceKind::Manufactured,
            citation: "Roache 2002, Code verification by the method of manufactured solutions, section 2".into(),
        },
        measures: vec![measure("displacement", "1", 2.0), Measure { bound: None, ..measure("energy", "J", 4.0) }],
        ladder: Quantity { name: "edge length".into(), unit: "m".into() },
        lines: vec![
            line("Newton, direct solver", 2.0, 3e-2, 2e-3, 6),
            line("Newton, conjugate gradients", 2.0, 3.2e-2, 1.1e-3, 6),
            line("quadratic tetrahedra", 3.0, 9e-3, 9e-3, 5),
        ],
        checks: vec![
            check(
                CheckKind::Accuracy,
                "displacement at the finest point",
                Verdict::Passed,
                "3.1e-5 of at most 2e-3",
            ),
            check(CheckKind::Order, "order of displacement", Verdict::Passed, "2.02 ± 0.05, expected 2 ± 0.2"),
            check(
                CheckKind::Baseline,
                "baseline",
                Verdict::Skipped { reason: "no baseline is committed for this scene".into() },
                "",
            ),
        ],
        verdict: Verdict::Passed,
        pictures: vec![],
        log: "logs/x.log".into(),
    }
}

pub(crate) fn report(scenes: Vec<SceneRecord>) -> Report {
    Report {
        schema_version: SCHEMA_VERSION,
        suite: "quick".into(),
        command: ["cargo", "xtask", "validate"].map(String::from).to_vec(),
        started_unix_seconds: 1_790_000_000,
        seconds: 83.4,
        interrupted: false,
        shard: None,
        environment: Environment {
            fingerprint: "9f1c2ab84e".into(),
            processor: "Example 9000 at 3 GHz".into(),
            processor_features: ["avx2", "fma"].map(String::from).to_vec(),
            cores: 2,
            memory_bytes: 8 << 30,
            system: "Linux 6.1".into(),
            compiler: "rustc 1.95.0".into(),
            profile: "release".into(),
            commit: "2da3626-dirty".into(),
        },
        scenes,
    }
}

/// A scene with a crash, a time-out, a typed failure, an exact result and a missing measure.
pub(crate) fn broken_scene() -> SceneRecord {
    let mut broken = scene("mechanics-core", "broken", ODD);
    broken.verdict = Verdict::Failed;
    let rows = &mut broken.lines[0].rows;
    rows[5].exit =
        Exit::Failed { message: "Newton stopped at iteration 50: residual 3.2e1 N, tolerance 1e-8 N".into() };
    rows[5].errors.clear();
    rows[4].exit = Exit::TimedOut { limit_seconds: 60 };
    rows[4].errors.clear();
    rows[3].errors.insert("displacement".into(), 0.0);
    broken.lines[1].label = ODD.into();
    broken.lines[1].rows.iter_mut().for_each(|row| {
        row.exit = Exit::Crashed { message: "thread panicked: index out of bounds: \u{7}<&> \"7\"".into() };
        row.errors.clear();
        row.seconds = 0.0;
    });
    broken.lines[1].orders.clear();
    broken.checks.push(check(
        CheckKind::Completion,
        ODD,
        Verdict::Failed,
        "8 of 17 runs did not end: see the rows. This sentence is long enough that a terminal of one hundred columns has to \
         wrap it somewhere.",
    ));
    broken.log.clear();
    broken
}

/// Everything at once.
pub(crate) fn everything() -> Report {
    let mut kernels = scene("mechanics-core", "svd", "Singular values of 3×3 matrices");
    kernels.ladder = Quantity { name: "sweeps".into(), unit: "1".into() };
    kernels.lines = (0..8)
        .map(|k| {
            let mut line =
                line(&format!("method {k}"), 1.0 + 0.5 * f64::from(k), 1e-1, 1e-7 * f64::from(k + 1), 5);
            line.rows.iter_mut().enumerate().for_each(|(i, row)| row.ladder = 1.0 + i as f64);
            line
        })
        .collect();
    kernels.measures.truncate(1);
    kernels.measures[0].order = None;
    let mut drop = scene("lagrangian", "pendulum", "Double pendulum against a solution of 30 digits");
    drop.lines.iter_mut().flat_map(|line| &mut line.rows).for_each(|row| row.simulated_seconds = Some(10.0));
    drop.reference.kind = ReferenceKind::HighPrecision;
    let mut threads = drop.lines[0].rows.clone();
    threads.iter_mut().for_each(|row| row.threads = 2);
    drop.lines[0].rows.extend(threads);
    let mut idle = scene("gaussian-deform", "bunny", "Splats on the bunny");
    idle.lines.clear();
    idle.checks.clear();
    idle.verdict = Verdict::Skipped { reason: "tests/assets/bunny.ply is not in this checkout".into() };
    let mut manufactured = scene("lagrangian", "manufactured", "Cube under a manufactured load");
    manufactured
        .pictures
        .push(Picture { path: "frames/cube.png".into(), caption: "Displacement of the cube".into() });
    manufactured
        .pictures
        .push(Picture { path: "frames/none.gif".into(), caption: "A film that is not there".into() });
    report(vec![idle, manufactured, drop, broken_scene(), kernels])
}
