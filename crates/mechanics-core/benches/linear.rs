//! Linear solvers: ordering, factorisation, iteration, and CHOLMOD beside them.
//!
//! `cargo bench -p mechanics-core --bench linear [-- CASE…]`, where a case is `cube-3k`, `mat-3k`, `cube-30k`,
//! `mat-30k` (these four by default), `cube-90k`, `mat-90k`. CHOLMOD runs on one thread as a C program that is
//! compiled here if `cc` finds `libsuitesparse-dev`.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

#[path = "../tests/linear/generators.rs"]
mod generators;

use generators::{ElasticBox, Random};
use mechanics_core::linear::{
    Accuracy, Factorization, LinearSolver, Method, Ordering, Preconditioner, Solver, predict_factor,
};
use mechanics_core::parallel;
use mechanics_core::sparse::BlockMatrix;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

const CASES: [(&str, [usize; 3]); 6] = [
    ("cube-3k", [10, 10, 10]),
    ("mat-3k", [22, 22, 2]),
    ("cube-30k", [22, 22, 21]),
    ("mat-30k", [71, 71, 2]),
    ("cube-90k", [31, 31, 31]),
    ("mat-90k", [122, 122, 2]),
];

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let yardstick = build_yardstick();
    println!("calibration: 1e8 dependent multiply-adds in {:.0} ms", calibration());
    for (name, nodes) in CASES {
        let wanted =
            if arguments.is_empty() { !name.ends_with("90k") } else { arguments.iter().any(|a| a == name) };
        if wanted {
            parallel::with_threads(1, || run(name, nodes, yardstick.as_deref()));
        }
    }
}

fn calibration() -> f64 {
    let start = Instant::now();
    let mut x = std::hint::black_box(1.0f64);
    for _ in 0..100_000_000 {
        x = x * 0.999_999 + 1e-6;
    }
    std::hint::black_box(x);
    milliseconds(start)
}

fn milliseconds(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}

fn run(name: &str, nodes: [usize; 3], yardstick: Option<&Path>) {
    let shape = ElasticBox { nodes, stiffness: 400.0 };
    let mut triplets = shape.triplets();
    compare(name, &triplets.matrix(), yardstick);
    let contacts = nodes[0] * nodes[1] / 20;
    shape.add_contacts(&mut triplets, contacts, 400.0 * 1e4, &mut Random(7));
    compare(&format!("{name} with {contacts} contacts"), &triplets.matrix(), yardstick);
}

fn compare(name: &str, matrix: &BlockMatrix, yardstick: Option<&Path>) {
    println!("\n== {name}: {} unknowns, {} blocks", matrix.dimension(), matrix.pattern().block_count());
    let nested = predict_factor(matrix.pattern(), Ordering::NestedDissection);
    let minimum = predict_factor(matrix.pattern(), Ordering::MinimumDegree);
    for (order, p) in [("nested dissection", nested), ("minimum degree", minimum)] {
        println!(
            "{order:>18}: {:7.1} ms, {:8.3} Gflop ({:.2} of nested dissection), {:.2} M entries",
            p.ordering_time.as_secs_f64() * 1e3,
            p.flops * 1e-9,
            p.flops / nested.flops,
            p.entries as f64 * 1e-6
        );
    }
    let b = Random(3).vector(matrix.dimension());
    compare_direct(matrix, &b, yardstick);
    for (label, preconditioner) in
        [("block Jacobi", Preconditioner::BlockJacobi), ("IC(0)", Preconditioner::IncompleteCholesky)]
    {
        iterate(label, matrix, &b, preconditioner);
    }
}

fn compare_direct(matrix: &BlockMatrix, b: &[f64], yardstick: Option<&Path>) {
    let mut solver = Solver::new(Method::Cholesky { ordering: Ordering::FewestFlops });
    let report = solver.factor(matrix).unwrap();
    let repeats = if report.flops > 5e10 { 1 } else { (2e10 / report.flops).clamp(3.0, 20.0) as usize };
    let mut best = (f64::INFINITY, f64::INFINITY);
    let mut x = vec![0.0; b.len()];
    let mut refinements = (0, 0.0);
    let mut ours = |solver: &mut Solver, best: &mut (f64, f64)| {
        for _ in 0..repeats {
            best.0 = best.0.min(solver.factor(matrix).unwrap().numeric_time.as_secs_f64() * 1e3);
            let solved = solver.solve_into(b, &mut x, Accuracy::Configured).unwrap();
            best.1 = best.1.min(solved.time.as_secs_f64() * 1e3);
            refinements = (solved.iterations, solved.residual);
        }
    };
    ours(&mut solver, &mut best);
    let theirs =
        yardstick.and_then(|program| run_yardstick(program, solver.factorization().unwrap(), b, repeats));
    ours(&mut solver, &mut best);
    println!(
        "          Cholesky: symbolic {:.1} ms, factor {:.1} ms ({:.1} GFLOP/s), solve {:.2} ms with {} refinements to {:.0e}; {} supernodes, {:.2} M stored",
        report.symbolic_time.as_secs_f64() * 1e3,
        best.0,
        report.flops * 1e-6 / best.0,
        best.1,
        refinements.0,
        refinements.1,
        report.supernodes,
        report.factor_entries as f64 * 1e-6,
    );
    for line in theirs.unwrap_or_default().lines() {
        let fields: Vec<&str> = line.split_whitespace().collect();
        let number = |k: usize| fields.get(k).and_then(|f| f.parse::<f64>().ok()).unwrap_or(f64::NAN);
        println!(
            "  CHOLMOD ({:>5}): analyse {:.1} ms, factor {:.1} ms, solve {:.2} ms, residual {:.0e}, {:.3} Gflop: our factor takes {:.2} of its time, our flops {:.2}",
            fields[0],
            number(3),
            number(4),
            number(5),
            number(6),
            number(1) * 1e-9,
            best.0 / number(4),
            report.flops / number(1),
        );
    }
}

fn iterate(label: &str, matrix: &BlockMatrix, b: &[f64], preconditioner: Preconditioner) {
    let max_iterations = 5000;
    let mut solver =
        Solver::new(Method::ConjugateGradient { preconditioner, tolerance: 1e-6, max_iterations });
    let mut x = vec![0.0; b.len()];
    let mut line = String::new();
    solver.factor(matrix).unwrap();
    let report = match solver.factor(matrix) {
        Ok(report) => report,
        Err(error) => return println!("{label:>18}: {error}"),
    };
    for tolerance in [1e-4, 1e-6, 1e-8] {
        let start = Instant::now();
        let part = match solver.solve_into(b, &mut x, Accuracy::Relative(tolerance)) {
            Ok(s) => format!("  {tolerance:.0e}: {} iterations {:.1} ms", s.iterations, milliseconds(start)),
            Err(error) => format!("  {tolerance:.0e}: {error} ({:.1} ms)", milliseconds(start)),
        };
        line += &part;
    }
    println!(
        "{label:>18}: structure {:.1} ms, factor {:.1} ms ({} failed attempts){line}",
        report.symbolic_time.as_secs_f64() * 1e3,
        report.numeric_time.as_secs_f64() * 1e3,
        report.failed_attempts
    );
}

/// The compiled C program, or why there is none.
fn build_yardstick() -> Option<PathBuf> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/cholmod/yardstick.c");
    let program = std::env::temp_dir().join(format!("cholmod-yardstick-{}", std::process::id()));
    let compiled = Command::new("cc")
        .args(["-O2", "-I/usr/include/suitesparse", "-o"])
        .arg(&program)
        .arg(source)
        .arg("-lcholmod")
        .output();
    match compiled {
        Ok(output) if output.status.success() => Some(program),
        _ => {
            println!("SKIPPED (no cholmod)");
            None
        }
    }
}

fn run_yardstick(program: &Path, factorization: &Factorization, b: &[f64], repeats: usize) -> Option<String> {
    let file = std::env::temp_dir().join(format!("cholmod-matrix-{}.bin", std::process::id()));
    write_system(&file, factorization, b).ok()?;
    let output = Command::new(program)
        .arg(&file)
        .arg((2 * repeats).to_string())
        .env("OPENBLAS_NUM_THREADS", "1")
        .env("OMP_NUM_THREADS", "1")
        // CHOLMOD frees its workspace after every call; without these its time is that of page faults.
        .env("MALLOC_MMAP_THRESHOLD_", "8589934592")
        .env("MALLOC_TRIM_THRESHOLD_", "17179869184")
        .env("MALLOC_TOP_PAD_", "268435456")
        .output()
        .ok()?;
    std::fs::remove_file(&file).ok()?;
    Some(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// The scalar lower triangle, our order and the right-hand side, in the form `yardstick.c` describes.
fn write_system(path: &Path, factorization: &Factorization, b: &[f64]) -> std::io::Result<()> {
    let matrix = factorization.matrix();
    let (mut start, mut rows, mut values) = (vec![0i64], Vec::new(), Vec::new());
    let pattern = matrix.pattern();
    for column in 0..pattern.columns() {
        for component in 0..3 {
            for slot in pattern.column(column) {
                for i in 0..3 {
                    let row = 3 * pattern.rows()[slot] as usize + i;
                    if row >= 3 * column + component {
                        rows.push(row as i64);
                        values.push(matrix.blocks()[slot][(i, component)]);
                    }
                }
            }
            start.push(rows.len() as i64);
        }
    }
    let order = factorization.elimination_order().unwrap_or_default();
    let order = order.iter().flat_map(|&block| (0..3).map(move |i| 3 * i64::from(block) + i));
    let mut bytes = Vec::new();
    for integer in [b.len() as i64, rows.len() as i64].into_iter().chain(start).chain(rows) {
        bytes.extend(integer.to_le_bytes());
    }
    values.iter().for_each(|value| bytes.extend(value.to_le_bytes()));
    order.for_each(|integer| bytes.extend(integer.to_le_bytes()));
    b.iter().for_each(|value| bytes.extend(value.to_le_bytes()));
    std::fs::File::create(path)?.write_all(&bytes)
}
