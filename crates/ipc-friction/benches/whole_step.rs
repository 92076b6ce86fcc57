//! Whole steps with contact and friction, where their time goes, and what friction adds to a Newton iteration.
//!
//!     cargo bench -p ipc-friction --bench whole_step [-- cubes | cloth | cotton] [one | two] [first] [STEPS]
//!
//! `one` is one thread alone, `two` two threads alone, `first` the first way alone.
//!
//! - `cubes`: eight elastic cubes of 0.1 m (1,512 vertices, 6,144 tetrahedra; E = 10⁵ Pa, ν = 0.4, 1,000 kg/m³) thrown together above a
//!   floor; μ = 0.5, h = 0.01 s, d̂ = 1 mm, 100 steps. STARK (C++, no continuous detection): 180 ms a step on one thread, 137 on two.
//! - `cloth`: 100×100 vertices (1 m², 0.2 kg/m², E t = 1 kN/m, ν = 0.3, D = 10⁻⁵ J) falls on a fixed sphere of 642 vertices and
//!   0.25 m; μ = 0.5, h = 0.01 s, d̂ = 2 mm, 30 steps.
//! - `cotton`: the same with STARK's preset for cloth, a thousand times as soft (`scenes::cotton_on_sphere` says how). STARK's 2,275 and 1,506 ms a
//!   step are of this geometry; the record of its run does not name the material, and its preset is what its examples of cloth use.
//!
//! Tolerance 10⁻³ m/s, as STARK's. `as STARK` has εᵥ = 1 cm/s and takes normal forces from the start of the step; `εᵥ = 1 mm/s` the same with a
//! tenth of it; `settled` is the first with normal forces taken anew until friction agrees with them to 10⁻³ of its bound, at most 20 times.
//! Materials, heights and speeds that the record of STARK's runs does not state are ours.
//!
//! Then the last state of `as STARK` is stepped on, with friction and without, in turns: the ratio is that of the times of a Newton iteration. The bar
//! is 1.3.
//!
//! # Measured
//! One thread, `as STARK`: `cubes` 65 ms a step over 100 steps (0.36 of STARK's), 6.4 iterations of 10.2 ms, up to 507 pairs with friction; factoring and
//! solving 70 %, assembly 14 % (contact and friction 2 %), limits 7 %, sets and energies 1 %, gradients and freezing under 1 %. A direction
//! costs 0.94 of one without friction. `εᵥ = 1 mm/s`: 170 ms over the first 30 steps, 16 iterations, where `as STARK` has 11.5.
//! `cotton`, on a machine slower by a third than usual: 1,614 ms a step over 30 on one thread (0.71 of STARK's) and 1,381 on two (0.92), 9.7 iterations of 166 ms;
//! factoring and solving 62 %, assembly 18 %, limits 8 %, contact and friction 1 %. `cubes` there: 61 ms on one thread, 60 on two.
//! `cloth` 2,790 ms a step over the first 10 (1.2 of STARK's over 30), 18 iterations of 158 ms; factoring and solving 70 %, assembly 16 %, limits
//! 5 %, contact and friction 1 %. Without friction it takes as many iterations: they are those of the sheet.

#![allow(clippy::print_stdout, clippy::unwrap_used, reason = "a benchmark prints")]

#[path = "../../ipc-contact/tests/scenes/peers.rs"]
#[allow(dead_code, unreachable_pub, reason = "shared with contact's tests and benches")]
mod peers;
#[path = "whole_step/scenes.rs"]
#[allow(unreachable_pub, reason = "a part of this bench")]
mod scenes;

use ipc_contact::contact::ContactReport;
use ipc_contact::intersection;
use ipc_friction::FrictionReport;
use lagrangian::stepper::{Lagging, StepReport};
use mechanics_core::parallel::with_threads;
use scenes::{Scene, Solving, cloth_on_sphere, cotton_on_sphere, tumbling_cubes};
use std::time::{Duration, Instant};

/// Interleaved pairs of steps with friction and without.
const PAIRS: usize = 9;

/// Sums over some steps.
#[derive(Default)]
struct Sums {
    steps: usize,
    iterations: u64,
    directions: u64,
    lags: u64,
    halvings: u64,
    limited: u64,
    searches: u64,
    queries: u64,
    sets: u64,
    contacts: usize,
    pairs: usize,
    lag_residual: f64,
    slowest: Duration,
    /// The whole; factor and solve; assembly, contact's part of it; of contact and friction: energies, gradients, limits, freezing; line
    /// search without contact.
    times: [Duration; 8],
}

impl Sums {
    fn add(&mut self, report: &StepReport, contact: &ContactReport, friction: &FrictionReport) {
        let own = report.terms.last().unwrap().times;
        let newton = &report.newton;
        self.steps += 1;
        self.iterations += newton.iterations;
        self.directions += newton.directions;
        self.halvings += newton.halvings;
        self.limited += newton.limited_steps;
        self.lags += report.lag_iterations;
        self.searches += contact.searches;
        self.queries += contact.detection_queries;
        self.sets += contact.sets;
        self.contacts = self.contacts.max(contact.contacts.total());
        self.pairs = self.pairs.max(friction.pairs);
        self.lag_residual = self.lag_residual.max(friction.relative_lag_residual);
        self.slowest = self.slowest.max(report.time);
        let parts = [
            report.time,
            newton.times.solve,
            newton.times.assembly,
            own.hessian,
            own.value,
            own.gradient,
            own.limit_step,
            own.freeze,
        ];
        self.times.iter_mut().zip(parts).for_each(|(sum, part)| *sum += part);
    }

    fn print(&self, name: &str) {
        let per = |sum: Duration| sum.as_secs_f64() * 1e3 / self.steps as f64;
        let [whole, solve, assembly, hessian, value, gradient, limit, freeze] = self.times.map(per);
        let each = |count: u64| count as f64 / self.steps as f64;
        println!(
            "{name:>16}: {whole:6.1} ms a step (slowest {:.0}), {:4.1} iterations of {:5.2} ms, {:.1} lag passes (largest residual {:.1e}), up to {} \
             contacts, {} pairs with friction | factor and solve {:.0} %, assembly {:.0} % | of it contact and friction {:.0} %; their sets and \
             energies {:.0} %, gradients {:.0} %, limits {:.0} %, freezing {:.0} % | a step: {:.1} directions, {:.1} halvings, {:.1} limited, {:.1} searches, {:.0} \
             queries, {:.1} sets",
            self.slowest.as_secs_f64() * 1e3,
            each(self.iterations),
            whole / each(self.iterations),
            each(self.lags),
            self.lag_residual,
            self.contacts,
            self.pairs,
            100.0 * solve / whole,
            100.0 * assembly / whole,
            100.0 * hessian / whole,
            100.0 * value / whole,
            100.0 * gradient / whole,
            100.0 * limit / whole,
            100.0 * freeze / whole,
            each(self.directions),
            each(self.halvings),
            each(self.limited),
            each(self.searches),
            each(self.queries),
            each(self.sets),
        );
    }
}

fn run(scene: &mut Scene, steps: usize, name: &str) {
    let stretch = steps.div_ceil(5);
    let (mut whole, mut part) = (Sums::default(), Sums::default());
    for step in 1..=steps {
        let report = scene.step();
        let contact = scene.contact.contact().report();
        let friction = scene.contact.report(&scene.state.position).unwrap();
        whole.add(&report, &contact, &friction);
        part.add(&report, &contact, &friction);
        if step % stretch == 0 {
            std::mem::take(&mut part).print(&format!("to {step}"));
        }
    }
    whole.print(name);
    let meet = intersection::check(scene.contact.contact().mesh(), &scene.state.position).unwrap();
    assert!(meet.is_empty(), "no intersections at the end");
}

/// The median over pairs of steps from the same state of the ratio of the times of an iteration, with friction and without.
fn print_price(scene: &mut Scene) {
    let start = scene.state.clone();
    let mut pairs: Vec<[f64; 2]> = Vec::new();
    let mut iterations = [0; 2];
    for _ in 0..PAIRS {
        let mut pair = [0.0; 2];
        for (k, pair) in pair.iter_mut().enumerate() {
            scene.state = start.clone();
            let report = if k == 0 { scene.step() } else { scene.step_without_friction() };
            iterations[k] = report.newton.iterations;
            *pair = report.time.as_secs_f64() * 1e3 / report.newton.directions as f64;
        }
        pairs.push(pair);
    }
    pairs.sort_by(|a, b| (a[0] / a[1]).total_cmp(&(b[0] / b[1])));
    let [with, without] = pairs[PAIRS / 2];
    println!(
        "  from the same state: a direction takes {with:.2} ms with friction, {without:.2} without: {:.2}× ({} and {} iterations)",
        with / without,
        iterations[0],
        iterations[1]
    );
}

/// A name, the scene, how many steps.
type Known = (&'static str, fn(Solving) -> Scene, usize);

/// The ways, the first with its price.
const WAYS: [(&str, Solving); 3] = [
    ("as STARK", Solving { stick_velocity: 1e-2, lagging: Lagging::Once }),
    ("εᵥ = 1 mm/s", Solving { stick_velocity: 1e-3, lagging: Lagging::Once }),
    ("settled", Solving { stick_velocity: 1e-2, lagging: Lagging::AtMost(20) }),
];

/// The clock of the machine: absolute times mean something beside it.
fn print_calibration() {
    let (start, mut x) = (Instant::now(), 1.0_f64);
    for _ in 0..20_000_000 {
        x = std::hint::black_box(x * 0.999_999_9);
    }
    println!("calibration: {:.3} ns a dependent multiplication", start.elapsed().as_secs_f64() * 1e9 / 2e7);
}

fn main() {
    print_calibration();
    let asked: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let steps = asked.iter().find_map(|a| a.parse().ok());
    let known: [Known; 3] =
        [("cubes", tumbling_cubes, 100), ("cloth", cloth_on_sphere, 30), ("cotton", cotton_on_sphere, 30)];
    let is_named = |name: &str| asked.iter().any(|a| a == name);
    let threads: &[usize] = match [is_named("one"), is_named("two")] {
        [true, false] => &[1],
        [false, true] => &[2],
        _ => &[1, 2],
    };
    let ways = if is_named("first") { &WAYS[..1] } else { &WAYS[..] };
    for (name, scene, all) in known {
        if !is_named(name) && known.iter().any(|(name, ..)| is_named(name)) {
            continue;
        }
        for (&threads, (title, solving)) in threads.iter().flat_map(|t| ways.iter().map(move |way| (t, way)))
        {
            println!("\n{name}, {threads} thread(s), {title}");
            with_threads(threads, || {
                let mut scene = scene(*solving);
                run(&mut scene, steps.unwrap_or(all), title);
                print_calibration();
                if *title == WAYS[0].0 {
                    print_price(&mut scene);
                }
            });
        }
    }
}
