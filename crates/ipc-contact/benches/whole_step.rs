//! Whole steps of a mat that is twisted into contact with itself, and where their time goes.
//!
//!     cargo bench -p ipc-contact --bench whole_step [-- ipc | ipc8k | stark] [STEPS]
//!
//! - `ipc`: 40×40×2 vertices (9,126 tetrahedra), 1 × 0.008 × 1 m, both ends turned against each other with 72°/s each, h = 0.04 s, d̂ = 10⁻³ of the
//!   diagonal, tolerance 10⁻² of the diagonal a second. Original IPC (C++): 3.7 iterations a step, 0.75 s each on one thread.
//! - `ipc8k`: the same with 46×4×46 vertices (8,464; 36,450 tetrahedra), 24 mm thick. Original IPC with 8,111 vertices: 1.76 s an iteration.
//! - `stark`: the first mat, d̂ = 1.4 mm, tolerance 10⁻³ m/s, steps 1–123. STARK (C++, no continuous detection): 861 ms a step on one thread,
//!   712 on two.
//!
//! Parts are those of the step report. Searches for candidates are in `limits`, or in `freezing`.
//!
//! # Measured
//! One thread: `ipc` 52 ms an iteration, 2.7 iterations a step in the first 40; `ipc8k` 203 ms an iteration in the first 20, which have no
//! contact (each solves 1.8 systems, because a step ends with a direction that is not gone); `stark` 806 ms a step, of which factoring and solving 75 %, limits 13 %, assembly
//! 6 %, contact sets and energies 2 %.

#![allow(clippy::print_stdout, clippy::unwrap_used, reason = "a benchmark prints")]

use ipc_contact::collision_mesh::{CollisionMeshBuilder, CollisionObject};
use ipc_contact::contact::{BarrierContact, ContactOptions, ContactReport};
use ipc_contact::intersection;
use ipc_contact::stiffness::{Scale, Stiffness};
use lagrangian::element::{Mass, MassDistribution, Tetrahedra};
use lagrangian::stepper::{StepReport, Stepper, StepperOptions};
use mechanics_core::law::{Lame, StableNeoHookean};
use mechanics_core::mesh::{BoxSplit, TetMesh, block};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::parallel::with_threads;
use mechanics_core::point_map::PointMap;
use mechanics_core::state::State;
use mechanics_core::stencil::StencilTerm;
use mechanics_core::tensor::Vec3;
use std::time::Duration;

/// Time of a step \[s\].
const STEP: f64 = 0.04;
/// Turning of each end [rad/s].
const RATE: f64 = 72.0 / 180.0 * std::f64::consts::PI;
/// Young's modulus \[Pa\].
const YOUNG: f64 = 2e4;
/// Steps printed together.
const STRETCH: usize = 20;

struct Mat {
    mesh: TetMesh,
    thickness: f64,
    elastic: StencilTerm<Tetrahedra<StableNeoHookean>, 4>,
    contact: BarrierContact,
    ends: Vec<(u32, f64)>,
    stepper: Stepper,
    state: State,
}

impl Mat {
    /// `cells` along the sides, the layers each 8 mm thick.
    fn new(cells: [u32; 3], tolerance: f64) -> Self {
        let thickness = 0.008 * f64::from(cells[1]);
        let mesh = block(&Vec3::zeros(), &Vec3::new(1.0, thickness, 1.0), cells, BoxSplit::Six).unwrap();
        let law = StableNeoHookean::new(Lame::from_young_poisson(YOUNG, 0.4).unwrap());
        let elastic = Tetrahedra::term("elastic", law, &mesh).unwrap();
        let mut mass = Mass::zeros(mesh.points().len());
        mass.add_tetrahedra(mesh.points(), mesh.cells(), 1000.0, MassDistribution::Lumped).unwrap();
        let ends = (0..).zip(mesh.points()).filter(|(_, x)| x.x == 0.0 || x.x == 1.0);
        let ends: Vec<(u32, f64)> = ends.map(|(i, x)| (i, if x.x == 0.0 { RATE } else { -RATE })).collect();
        let fixed: Vec<(u32, Vec3)> = ends.iter().map(|&(i, _)| (i, mesh.points()[i as usize])).collect();
        let map = PointMap::with_fixed(mesh.points().len(), &fixed).unwrap();
        let newton = NewtonOptions { tolerance, ..Default::default() };
        let stepper = Stepper::new(mass, map, StepperOptions { newton, ..Default::default() });
        let mut builder = CollisionMeshBuilder::new(mesh.points());
        builder.add_object(CollisionObject::of_tets(&mesh, 0).unwrap());
        let activation = 1.4e-3;
        let load = Scale::Load(0.5 * YOUNG * 0.008 * activation);
        let options = ContactOptions::new(activation, Stiffness::adaptive(load));
        let contact = BarrierContact::new(builder.build().unwrap(), options).unwrap();
        let state = State::at_rest(mesh.points().to_vec());
        Self { mesh, thickness, elastic, contact, ends, stepper, state }
    }

    fn step(&mut self) -> StepReport {
        let time = self.state.time + STEP;
        let centre = Vec3::new(0.0, 0.5 * self.thickness, 0.5);
        for &(point, rate) in &self.ends {
            let r = self.mesh.points()[point as usize] - centre;
            let (sin, cos) = (rate * time).sin_cos();
            let turned = Vec3::new(r.x, cos * r.y - sin * r.z, sin * r.y + cos * r.z);
            self.stepper.set_target(point, centre + turned).unwrap();
        }
        self.stepper.step(&mut self.state, &mut [&mut self.elastic, &mut self.contact], STEP).unwrap()
    }
}

/// Sums over some steps.
#[derive(Default)]
struct Sums {
    steps: usize,
    iterations: u64,
    directions: u64,
    pulls: u64,
    searches: u64,
    queries: u64,
    sets: u64,
    contacts: usize,
    /// The whole; factor and solve; assembly; of contact: energies, gradients, Hessians, limits, freezing.
    times: [Duration; 8],
}

impl Sums {
    fn add(&mut self, report: &StepReport, contact: &ContactReport) {
        let own = report.terms.last().unwrap().times;
        let newton = &report.newton;
        self.steps += 1;
        self.iterations += newton.iterations;
        self.directions += newton.directions;
        self.pulls += report.pulls;
        self.searches += contact.searches;
        self.queries += contact.detection_queries;
        self.sets += contact.sets;
        self.contacts = self.contacts.max(contact.contacts.total());
        let parts = [
            report.time,
            newton.times.solve,
            newton.times.assembly,
            own.value,
            own.gradient,
            own.hessian,
            own.limit_step,
            own.freeze,
        ];
        self.times.iter_mut().zip(parts).for_each(|(sum, part)| *sum += part);
    }

    fn print(&self, name: &str) {
        let per = |sum: Duration| sum.as_secs_f64() * 1e3 / self.steps as f64;
        let [whole, solve, assembly, value, gradient, hessian, limit, freeze] = self.times.map(per);
        let each = |count: u64| count as f64 / self.steps as f64;
        println!(
            "{name:>12}: {whole:6.0} ms a step, {:4.1} iterations of {:5.1} ms, {} contacts | factor and solve {:.0} %, assembly \
             {:.0} % | contact: sets and energies {:.0} %, gradients {:.0} %, Hessians {:.0} %, limits {:.0} %, freezing {:.0} % | a step: {:.1} \
             searches, {:.0} queries, {:.1} sets, {:.1} directions, {:.1} pulls",
            each(self.iterations),
            whole / each(self.iterations),
            self.contacts,
            100.0 * solve / whole,
            100.0 * assembly / whole,
            100.0 * value / whole,
            100.0 * gradient / whole,
            100.0 * hessian / whole,
            100.0 * limit / whole,
            100.0 * freeze / whole,
            each(self.searches),
            each(self.queries),
            each(self.sets),
            each(self.directions),
            each(self.pulls),
        );
    }
}

fn run(mut mat: Mat, steps: usize) {
    let mut whole = Sums::default();
    let mut part = Sums::default();
    for step in 1..=steps {
        let report = mat.step();
        let contact = mat.contact.report();
        whole.add(&report, &contact);
        part.add(&report, &contact);
        if step % STRETCH == 0 {
            part.print(&format!("to {step}"));
            part = Sums::default();
        }
    }
    whole.print("all");
    let meet = intersection::check(mat.contact.mesh(), &mat.state.position).unwrap();
    assert!(meet.is_empty(), "no intersections at the end");
}

/// A name, cells along the sides, the tolerance of a step [m/s], how many steps.
type Known = (&'static str, [u32; 3], f64, usize);

fn main() {
    let asked: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let steps = asked.iter().find_map(|a| a.parse().ok());
    let known: [Known; 3] = [
        ("ipc", [39, 1, 39], 0.0141, 123),
        ("ipc8k", [45, 3, 45], 0.0141, 60),
        ("stark", [39, 1, 39], 1e-3, 123),
    ];
    let is_named = |name: &str| asked.iter().any(|a| a == name);
    for (name, cells, tolerance, all) in known {
        if is_named(name) || !known.iter().any(|(name, ..)| is_named(name)) {
            for threads in [1, 2] {
                println!("\n{name}, {threads} thread(s)");
                with_threads(threads, || run(Mat::new(cells, tolerance), steps.unwrap_or(all)));
            }
        }
    }
}
