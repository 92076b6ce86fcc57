//! Million particle-steps a second, by law, dimension and precision; sorting included.
//!
//! A block of cells with 2^D jittered particles each, spinning and falling. Every figure is the median
//! of interleaved repeats, on one thread and on two in turns. With `TAICHI_PYTHON` (an interpreter that has taichi) and `PEERS_DIR` (a folder with a
//! `taichi_mpm.py` of the same scenes, which is not part of this repository) set, that script runs beside, on one thread. `--quick` leaves out what takes long; other words select the cases whose names hold one of them.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

mod machine;
mod scene;

use mpm_core::{StageTimes, Transfer};
use scene::{
    HUGE, Inert, LARGE, PLANE, SMALL, Size, Stepped, TINY, TINY_PLANE, jelly, metal, rubber, sand, scene,
    scene_with, water,
};

/// Pairs of runs on one and on two threads.
const PAIRS: usize = 7;

/// What is measured, and what the issue asks of it.
struct Case {
    name: &'static str,
    /// Million particle-steps a second.
    wanted: f64,
    /// What Taichi's script is asked for, and how many times as fast is wanted.
    taichi: Option<(&'static str, f64)>,
}

const CASES: [Case; 7] = [
    Case { name: "3D f32 fixed corotated", wanted: 10.0, taichi: Some(("--n 64 --prec f32", 11.0)) },
    Case { name: "3D f64 fixed corotated", wanted: 5.0, taichi: Some(("--n 64 --prec f64", 7.0)) },
    Case { name: "3D f32 fluid", wanted: 18.0, taichi: Some(("--n 64 --model fluid", 8.0)) },
    Case { name: "3D f32 neo-Hookean", wanted: 13.0, taichi: None },
    Case { name: "3D f32 von Mises", wanted: 7.0, taichi: None },
    Case { name: "3D f32 sand", wanted: 7.0, taichi: None },
    Case { name: "2D f32 fixed corotated", wanted: 40.0, taichi: Some(("--dim 2 --n 512 --cells 224", 5.0)) },
];

/// What other transfers cost, in 3D `f32` with a fixed corotated solid.
const TRANSFERS: [(&str, Transfer); 8] = [
    ("MLS-APIC", Transfer::MlsApic),
    ("PIC", Transfer::Pic),
    ("APIC", Transfer::APIC),
    ("FLIP", Transfer::FLIP),
    ("ASFLIP", Transfer::ASFLIP),
    ("XPIC(2)", Transfer::Xpic { order: 2 }),
    ("XPIC(3)", Transfer::Xpic { order: 3 }),
    ("XPIC(5)", Transfer::Xpic { order: 5 }),
];

/// The scene of a case, and how many particles it has in 3D and in 2D.
fn built(name: &str, size: Size, plane: Size) -> Box<dyn Stepped> {
    match name {
        "3D f32 fixed corotated" => scene::<f32, 3, _>(jelly(), size),
        "3D f64 fixed corotated" => scene::<f64, 3, _>(jelly(), size),
        "3D f32 neo-Hookean" => scene::<f32, 3, _>(rubber(), size),
        "3D f32 fluid" => scene::<f32, 3, _>(water(), size),
        "3D f32 von Mises" => scene::<f32, 3, _>(metal(), size),
        "3D f32 sand" => scene::<f32, 3, _>(sand(), size),
        "2D f32 fixed corotated" => scene::<f32, 2, _>(jelly(), plane),
        "3D f32 without law" => scene::<f32, 3, _>(Inert, size),
        "3D f64 without law" => scene::<f64, 3, _>(Inert, size),
        "2D f32 without law" => scene::<f32, 2, _>(Inert, plane),
        _ => match TRANSFERS.iter().find(|(other, _)| name == *other) {
            Some((_, transfer)) => scene_with::<f32, 3, _>(jelly(), size, *transfer),
            None => panic!("no case {name}"),
        },
    }
}

/// Medians of some runs.
struct Measured {
    /// Seconds a particle-step on one thread.
    time: f64,
    stages: StageTimes,
    /// How many times as fast two threads are.
    two_threads: f64,
}

fn median(numbers: impl Iterator<Item = f64>) -> f64 {
    let mut numbers: Vec<f64> = numbers.collect();
    numbers.sort_by(f64::total_cmp);
    numbers[numbers.len() / 2]
}

/// Runs of `steps` steps in turns on one and on two threads.
fn measure(scene: &mut dyn Stepped, steps: usize) -> Measured {
    scene.run(3, 1);
    let runs: Vec<_> = (0..PAIRS).map(|_| (scene.run(steps, 1), scene.run(steps, 2).0)).collect();
    let each = 1.0 / scene.particles() as f64;
    let of = |stage: fn(&StageTimes) -> f64| each * median(runs.iter().map(|((_, stages), _)| stage(stages)));
    Measured {
        time: each * median(runs.iter().map(|((one, _), _)| *one)),
        stages: StageTimes {
            sort: of(|s| s.sort),
            scatter: of(|s| s.scatter),
            nodes: of(|s| s.nodes),
            gather: of(|s| s.gather),
        },
        two_threads: median(runs.iter().map(|((one, _), two)| one / two)),
    }
}

/// Instructions that a processor of today can start a cycle, and does in loops like these at best.
const ISSUE: f64 = 4.0;

fn report(case: &Case, without_law: Option<&Measured>, bandwidth: Option<f64>) {
    let mut scene = built(case.name, SMALL, PLANE);
    let measured = measure(&mut *scene, 40);
    let (rate, count, memory) = (1e-6 / measured.time, scene.particles(), scene.memory());
    let StageTimes { sort, scatter, nodes, gather } = measured.stages;
    let bytes = memory.particles as f64 / count as f64;
    println!("{}, {count} particles", case.name);
    println!(
        "  {rate:.1} M/s (wanted {}), {:.1} ns; two threads {:.2}×, mere arithmetic {:.2}×",
        case.wanted,
        1e9 * measured.time,
        measured.two_threads,
        machine::two_threads()
    );
    print!(
        "  scatter {:.1}, nodes {:.1}, gather {:.1}, sort {:.1} ns",
        1e9 * scatter,
        1e9 * nodes,
        1e9 * gather,
        1e9 * sort
    );
    match without_law {
        Some(without) => println!("; of them law {:.1} ns", 1e9 * (measured.time - without.time)),
        None => println!(),
    }
    println!("  {bytes:.0} bytes a particle, and {:.0} of nodes", memory.nodes as f64 / count as f64);
    if let Some(bandwidth) = bandwidth {
        // Read by the scatter, read and written by the gather.
        println!("  memory alone: {:.0} M/s", 1e3 * bandwidth / (3.0 * bytes));
        let clock = machine::clock();
        match machine::instructions_a_particle(case.name, built(case.name, TINY, TINY_PLANE).particles()) {
            None => println!("  instructions: SKIPPED, no valgrind"),
            Some(count) => println!(
                "  {count:.0} instructions a particle, {:.1} a cycle at {clock:.1} GHz; {ISSUE} a cycle would give {:.1} M/s",
                count * rate * 1e-3 / clock,
                1e3 * ISSUE * clock / count
            ),
        }
    }
    if let Some((arguments, wanted)) = case.taichi {
        match machine::taichi(arguments) {
            None => println!("  Taichi: SKIPPED, TAICHI_PYTHON and PEERS_DIR do not say where it is"),
            Some(theirs) => {
                println!("  Taichi {theirs:.2} M/s: {:.1} times as fast (wanted {wanted})", rate / theirs)
            }
        }
    }
}

/// Nanoseconds a particle-step and bytes a particle by number of particles.
fn report_scaling(sizes: &[(Size, usize, usize)], built: fn(Size) -> Box<dyn Stepped>) {
    let mut first = None;
    for &(size, steps, runs) in sizes {
        let mut scene = built(size);
        scene.run(2, 1);
        let rounds: Vec<_> = (0..runs).map(|_| scene.run(steps, 1)).collect();
        let each = 1.0 / scene.particles() as f64;
        let of = |stage: fn(&StageTimes) -> f64| 1e9 * each * median(rounds.iter().map(|(_, s)| stage(s)));
        let time = each * median(rounds.iter().map(|(time, _)| *time));
        let memory = scene.memory();
        println!(
            "  {:>8} particles {:.1} ns a particle-step, {:.2} of the first; {:.0} bytes a particle with the nodes",
            scene.particles(),
            1e9 * time,
            time / *first.get_or_insert(time),
            (memory.particles + memory.nodes) as f64 * each
        );
        println!(
            "           scatter {:.1}, nodes {:.1}, gather {:.1}, sort {:.1} ns",
            of(|s| s.scatter),
            of(|s| s.nodes),
            of(|s| s.gather),
            of(|s| s.sort)
        );
    }
}

/// Medians of the transfers, in turns, and their instructions.
fn report_transfers() {
    let mut scenes = TRANSFERS.map(|(name, _)| built(name, SMALL, PLANE));
    scenes.iter_mut().for_each(|scene| {
        scene.run(2, 1);
    });
    let rounds: Vec<Vec<f64>> =
        (0..5).map(|_| scenes.iter_mut().map(|scene| scene.run(5, 1).0).collect()).collect();
    let tiny = built(TRANSFERS[0].0, TINY, TINY_PLANE).particles();
    for (k, (name, _)) in TRANSFERS.iter().enumerate() {
        let ratio = median(rounds.iter().map(|round| round[k] / round[0]));
        print!("  {name:>8} {ratio:.2} times as long as MLS-APIC");
        match machine::instructions_a_particle(name, tiny) {
            Some(count) => println!(", {count:.0} instructions a particle"),
            None => println!(", instructions: SKIPPED, no valgrind"),
        }
    }
}

/// What a product of the Hessian and a vector may cost, in explicit steps.
const PRODUCT: f64 = 2.5;

/// Products of implicit steps beside explicit steps of the same scene, in turns.
fn report_products(kinds: &[&str], size: Size, plane: Size) {
    for name in kinds {
        let mut scene = built(name, size, plane);
        scene.run(3, 1);
        let runs: Vec<_> = (0..3)
            .map(|_| {
                let (explicit, report) = (scene.run(5, 1).0, scene.implicit(30.0));
                (explicit, report.product_time / report.products.max(1) as f64, report)
            })
            .collect();
        let ratio = median(runs.iter().map(|(explicit, product, _)| product / explicit));
        let product = median(runs.iter().map(|(_, product, _)| *product)) / scene.particles() as f64;
        let (_, _, last) = &runs[2];
        println!(
            "  {name}: a product {:.1} ns a particle, {ratio:.2} explicit steps (wanted {PRODUCT}); a step of 30: {} Newton iterations, {} products",
            1e9 * product,
            last.iterations,
            last.products
        );
    }
}

fn main() {
    // Cargo adds `--bench`.
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    if let [flag, name, steps] = &words[..]
        && flag == "--walk"
    {
        built(name, TINY, TINY_PLANE).run(steps.parse().unwrap(), 1);
        return;
    }
    let quick = words.iter().any(|word| word == "--quick");
    let chosen: Vec<&String> = words.iter().filter(|word| !word.starts_with("--")).collect();
    let is_chosen = |name: &str| chosen.is_empty() || chosen.iter().any(|word| name.contains(*word));
    let bandwidth = (!quick).then(machine::bandwidth);
    println!("clock {:.2} GHz", machine::clock());
    if let Some(bandwidth) = bandwidth {
        println!("one thread copies {bandwidth:.1} GB/s");
    }
    for case in CASES.iter().filter(|case| is_chosen(case.name)) {
        let kind = format!("{} without law", &case.name[..6]);
        let without_law = (!quick).then(|| measure(&mut *built(&kind, SMALL, PLANE), 20));
        report(case, without_law.as_ref(), bandwidth);
    }
    if is_chosen("implicit") {
        println!("implicit steps");
        let kinds = ["3D f64 fixed corotated", "3D f32 fixed corotated", "2D f32 fixed corotated"];
        let (size, plane) = if quick { (TINY, TINY_PLANE) } else { (SMALL, PLANE) };
        report_products(&kinds, size, plane);
    }
    if !quick && is_chosen("scaling in single") {
        println!("3D f32 fixed corotated, scaling");
        report_scaling(&[(SMALL, 40, 5), (LARGE, 10, 5), (HUGE, 5, 1)], |size| {
            scene::<f32, 3, _>(jelly(), size)
        });
    }
    if !quick && is_chosen("scaling in double") {
        println!("3D f64 fixed corotated, scaling");
        report_scaling(&[(SMALL, 20, 5), (LARGE, 5, 5)], |size| scene::<f64, 3, _>(jelly(), size));
    }
    if !quick && is_chosen("transfers") {
        println!("3D f32 fixed corotated, by transfer");
        report_transfers();
    }
}
