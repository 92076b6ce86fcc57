//! When element Hessians are projected: always or on demand, negative eigenvalues clamped or made absolute. Iterations, factorisations
//! and times of whole runs on one thread; times are the least of three interleaved runs.
//!
//! `cargo bench -p lagrangian --bench projecting [-- mat | cantilever | incompressible | stretched | crushed | scrambled | easy]`

#![allow(missing_docs, clippy::print_stdout, clippy::unwrap_used)]

use lagrangian::element::{Amplitude, DeadLoad, Mass, MassDistribution, Tetrahedra};
use lagrangian::stepper::{StepError, StepReport, Stepper, StepperOptions};
use mechanics_core::law::{Lame, StableNeoHookean};
use mechanics_core::mesh::{BoxSplit, TetMesh, block};
use mechanics_core::newton::{NewtonOptions, NewtonReport};
use mechanics_core::objective::Projecting;
use mechanics_core::parallel::with_threads;
use mechanics_core::point_map::PointMap;
use mechanics_core::projection::Projection;
use mechanics_core::state::State;
use mechanics_core::stencil::StencilTerm;
use mechanics_core::tensor::Vec3;
use std::time::Instant;

const WAYS: [(Projecting, Projection); 4] = [
    (Projecting::Always, Projection::Clamp),
    (Projecting::Always, Projection::Absolute),
    (Projecting::OnDemand, Projection::Clamp),
    (Projecting::OnDemand, Projection::Absolute),
];

struct Body {
    mesh: TetMesh,
    elastic: StencilTerm<Tetrahedra<StableNeoHookean>, 4>,
    mass: Mass,
    stepper: Stepper,
    state: State,
    total: NewtonReport,
    steps: u32,
}

impl Body {
    /// A block of stable neo-Hookean material, held where `is_held`.
    fn new(
        way: (Projecting, Projection),
        size: [f64; 3],
        cells: [u32; 3],
        [young, poisson, tolerance]: [f64; 3],
        is_held: impl Fn(&Vec3) -> bool,
    ) -> Self {
        let mesh = block(&Vec3::zeros(), &Vec3::from(size), cells, BoxSplit::Six).unwrap();
        let law = StableNeoHookean::new(Lame::from_young_poisson(young, poisson).unwrap());
        let elastic = Tetrahedra::term("elastic", law, &mesh).unwrap();
        let mut mass = Mass::zeros(mesh.points().len());
        mass.add_tetrahedra(mesh.points(), mesh.cells(), 1000.0, MassDistribution::Lumped).unwrap();
        let points = mesh.points().iter().zip(0u32..);
        let held: Vec<(u32, Vec3)> = points.filter(|(x, _)| is_held(x)).map(|(x, i)| (i, *x)).collect();
        let map = PointMap::with_fixed(mesh.points().len(), &held).unwrap();
        let newton = NewtonOptions { tolerance, max_iterations: 2000, ..Default::default() };
        let options = StepperOptions { newton, projecting: way.0, projection: way.1, ..Default::default() };
        let stepper = Stepper::new(mass.clone(), map, options);
        let state = State::at_rest(mesh.points().to_vec());
        Self { mesh, elastic, mass, stepper, state, total: NewtonReport::default(), steps: 0 }
    }

    fn count(&mut self, report: &StepReport) {
        self.total.iterations += report.newton.iterations;
        self.total.factorisations += report.newton.factorisations;
        self.total.halvings += report.newton.halvings;
        self.total.times.assembly += report.newton.times.assembly;
        self.total.times.solve += report.newton.times.solve;
        self.steps += 1;
    }

    fn run(&mut self, steps: u32, h: f64) -> Result<(), StepError> {
        for _ in 0..steps {
            let report = self.stepper.step(&mut self.state, &mut [&mut self.elastic], h)?;
            self.count(&report);
        }
        Ok(())
    }
}

type Way = (Projecting, Projection);
type Run = fn(Way) -> Result<Body, StepError>;

/// The mat of the bench `bodies`, its ends turned against each other.
fn mat(way: Way) -> Result<Body, StepError> {
    let ends = |x: &Vec3| x.x == 0.0 || x.x == 1.0;
    let mut body = Body::new(way, [1.0, 0.008, 1.0], [39, 1, 39], [2e4, 0.4, 1e-3], ends);
    for step in 1..=20 {
        for (x, i) in body.mesh.points().iter().zip(0u32..).filter(|(x, _)| ends(x)) {
            let rate = 72.0 / 180.0 * std::f64::consts::PI;
            let (sin, cos) = (f64::from(step) * 0.04 * if x.x == 0.0 { rate } else { -rate }).sin_cos();
            let (y, z) = (x.y - 0.004, x.z - 0.5);
            let target = Vec3::new(x.x, 0.004 + cos * y - sin * z, 0.5 + sin * y + cos * z);
            body.stepper.set_target(i, target)?;
        }
        body.run(1, 0.04)?;
    }
    Ok(body)
}

/// Statics of a cantilever whose tip is loaded with PL²/EI = 5 at once.
fn cantilever(way: Way) -> Result<Body, StepError> {
    let mut body = Body::new(way, [1.0, 0.1, 0.1], [40, 4, 4], [1e6, 0.3, 1e-8], |x| x.x == 0.0);
    let tip: Vec<u32> =
        body.mesh.points().iter().zip(0..).filter(|(x, _)| x.x == 1.0).map(|(_, i)| i).collect();
    let force = Vec3::new(0.0, 0.0, -5.0 * 1e6 * 1e-4 / 12.0 / tip.len() as f64);
    let mut load = DeadLoad::new("tip", tip.into_iter().map(|i| (i, force)).collect())
        .unwrap()
        .with_amplitude(Amplitude::Ramp);
    let report = body.stepper.equilibrium(&mut body.state, &mut [&mut body.elastic, &mut load], 2)?;
    body.count(&report);
    Ok(body)
}

/// A beam that sags under its weight, nearly incompressible.
fn incompressible(way: Way) -> Result<Body, StepError> {
    let mut body = Body::new(way, [1.0, 0.1, 0.1], [30, 3, 3], [1e5, 0.4999, 1e-5], |x| x.x == 0.0);
    let mut gravity = DeadLoad::gravity(&body.mass, &Vec3::new(0.0, 0.0, -9.81)).unwrap();
    for _ in 0..10 {
        let report = body.stepper.step(&mut body.state, &mut [&mut body.elastic, &mut gravity], 0.05)?;
        body.count(&report);
    }
    Ok(body)
}

fn stretched(way: Way) -> Result<Body, StepError> {
    let mut body = Body::new(way, [1.0, 0.2, 0.2], [20, 4, 4], [1e4, 0.4, 1e-4], |x| x.x == 0.0);
    body.state.position.iter_mut().for_each(|x| x.x *= 5.0);
    body.run(20, 0.02)?;
    Ok(body)
}

fn crushed(way: Way) -> Result<Body, StepError> {
    let mut body = Body::new(way, [1.0; 3], [8; 3], [1e4, 0.4, 1e-4], |_| false);
    body.state.position.iter_mut().for_each(|x| x.z *= 0.1);
    body.run(20, 0.02)?;
    Ok(body)
}

/// Every point anywhere in the unit cube.
fn scrambled(way: Way) -> Result<Body, StepError> {
    let mut body = Body::new(way, [1.0; 3], [6; 3], [1e4, 0.4, 1e-4], |_| false);
    let number = |k: usize| (k as f64 * 0.618_033_988_749_894_9).fract();
    let place = |i: usize| Vec3::new(number(3 * i), number(7 * i + 1), number(11 * i + 2));
    body.state.position.iter_mut().enumerate().for_each(|(i, x)| *x = place(i));
    body.run(20, 0.02)?;
    Ok(body)
}

/// Small steps of a soft beam: every one of them is easy.
fn easy(way: Way) -> Result<Body, StepError> {
    let mut body = Body::new(way, [1.0, 0.1, 0.1], [40, 4, 4], [1e5, 0.4, 1e-4], |x| x.x == 0.0);
    body.state.velocity.iter_mut().zip(body.mesh.points()).for_each(|(v, x)| v.z = -x.x);
    body.run(20, 1e-3)?;
    Ok(body)
}

fn compare(name: &str, run: Run) {
    println!("\n{name}: iterations, factorisations, halvings, ms (assembly, solve)");
    let mut least = [f64::INFINITY; 4];
    let mut lines = [const { String::new() }; 4];
    for _ in 0..3 {
        for (k, &way) in WAYS.iter().enumerate() {
            let begin = Instant::now();
            let outcome = run(way);
            let time = begin.elapsed().as_secs_f64() * 1e3;
            if time < least[k] {
                least[k] = time;
                lines[k] = match outcome {
                    Ok(Body { total: t, .. }) => format!(
                        "{:6} {:6} {:5} {time:9.1} ({:.1}, {:.1})",
                        t.iterations,
                        t.factorisations,
                        t.halvings,
                        t.times.assembly.as_secs_f64() * 1e3,
                        t.times.solve.as_secs_f64() * 1e3
                    ),
                    Err(error) => format!("fails: {error}"),
                };
            }
        }
    }
    for ((way, line), time) in WAYS.iter().zip(&lines).zip(least) {
        println!("  {:<22} {line}  {:.2}×", format!("{:?} {:?}", way.0, way.1), least[0] / time);
    }
}

fn main() {
    let wanted: Vec<String> = std::env::args().skip(1).filter(|arg| !arg.starts_with('-')).collect();
    let scenes: [(&str, Run); 7] = [
        ("mat", mat),
        ("cantilever", cantilever),
        ("incompressible", incompressible),
        ("stretched", stretched),
        ("crushed", crushed),
        ("scrambled", scrambled),
        ("easy", easy),
    ];
    with_threads(1, || {
        for (name, run) in scenes {
            if wanted.is_empty() || wanted.iter().any(|w| w == name) {
                compare(name, run);
            }
        }
    });
}
