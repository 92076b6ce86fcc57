//! A cantilever that bends far under its own weight, by finite elements and by particles.

use super::cloud::Cloud;
use super::method::Method;
use super::portrait::{Portrait, pictured};
use super::solver::{Elasticity, Matter, Solver, Watch};
use crate::experiment::bodies::solid::{Shape as ElementShape, Solid};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Positive;
use lagrangian::element::{Amplitude, DeadLoad, Mass, MassDistribution};
use lagrangian::stepper::{Stepper, StepperOptions};
use mechanics_core::law::NeoHookean;
use mechanics_core::mesh::{BoxSplit, block};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::point_map::PointMap;
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;
use mpm_core::{EquilibriumReport, PrescribedVelocity, Shape};
use schemars::JsonSchema;
use serde::Deserialize;
use std::sync::LazyLock;

/// A neo-Hookean beam of length L = 1 m and height H = 0.1 m, E = 1 MPa, ν = 0, 1000 kg/m³, at rest under its weight w a length; the ladder is the distance
/// of nodes by L.
///
/// Particles are half of a beam from −L to L, whose middle is held: no end of matter is at the clamp, where kernels would reach beyond it. They fall
/// with a drag, twice the lowest frequency, until they rest, or are brought to rest at once by implicit steps. Finite elements are minimised.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct HangingCantilever {
    /// wL³/EI [1].
    load: Positive,
    /// How far the end sinks, by L, from finer elements.
    tip_down: Positive,
    /// The same of the elastica, a beam without thickness.
    elastica_tip_down: Positive,
}

const LENGTH: f64 = 1.0;
const HEIGHT: f64 = 0.1;
const YOUNG: f64 = 1e6;
const DENSITY: f64 = 1000.0;
const ELEMENTS: [&str; 2] = ["linear elements", "ten-node elements"];
/// What the name of a method ends in whose particles are brought to rest at once.
const AT_ONCE: &str = ", equilibrium";
const LOAD_STEPS: u32 = 4;
/// The end of time by 1/ω₁: critically damped, (1 + ωt) e^(−ωt) of the fall is left, 3e-6.
const SETTLED: f64 = 15.5;

static NAMES: LazyLock<Vec<&'static str>> = LazyLock::new(|| {
    let at_once = Method::names().iter().map(|name| &*format!("{name}{AT_ONCE}").leak());
    ELEMENTS.iter().chain(Method::names()).copied().chain(at_once).collect()
});

impl HangingCantilever {
    /// g \[m/s²\]: w = ρ g H, I = H³/12.
    fn gravity(&self) -> f64 {
        self.load.value() * YOUNG * HEIGHT * HEIGHT / (12.0 * DENSITY * LENGTH.powi(3))
    }

    fn judged(&self, outcome: Outcome, found: f64) -> Outcome {
        outcome
            .error("tip", (found / self.tip_down.value() - 1.0).abs())
            .error("tip against the elastica", (found / self.elastica_tip_down.value() - 1.0).abs())
            .invariant("tip down (L)", found)
    }

    fn by_elements(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let shape = if at.method == ELEMENTS[0] { ElementShape::Linear } else { ElementShape::TenNode };
        // Ten-node elements have nodes in the middles of their edges.
        let cell = if shape == ElementShape::Linear { at.ladder } else { 2.0 * at.ladder };
        let [along, across] = [LENGTH, HEIGHT].map(|side| (side / cell).round().max(1.0) as u32);
        // As wide as high: a narrow one would buckle sideways.
        let size = Vec3::new(LENGTH, HEIGHT, HEIGHT);
        let mesh = block(&Vec3::zeros(), &size, [along, across, across], BoxSplit::Six)
            .map_err(ExperimentError::stopped)?;
        let matter = Matter::new(Elasticity::NeoHookean, (YOUNG, 0.0), DENSITY)?;
        let mut solid = Solid::new(NeoHookean::new(matter.lame), &mesh, shape)?;
        let count = solid.points.len();
        let mass = solid.mass(DENSITY, MassDistribution::Consistent)?;
        let load =
            DeadLoad::gravity(&mass, &(-Vec3::z() * self.gravity())).map_err(ExperimentError::stopped)?;
        let mut load = load.with_amplitude(Amplitude::Ramp);
        let held = solid.held(|x| x.x == 0.0);
        let map = PointMap::with_fixed(count, &held).map_err(ExperimentError::stopped)?;
        let newton = NewtonOptions { tolerance: 1e-9, ..NewtonOptions::default() };
        let options = StepperOptions { newton, ..StepperOptions::default() };
        let mut stepper = Stepper::new(Mass::zeros(count), map, options);
        let mut state = State::at_rest(solid.points.clone());
        let report = clock
            .time(|| stepper.equilibrium(&mut state, &mut [solid.elastic.as_mut(), &mut load], LOAD_STEPS))
            .map_err(ExperimentError::stopped)?;
        let end = solid.face_shares(|x| (x.x - LENGTH).abs() < 1e-9);
        let area: f64 = end.iter().map(|(_, share)| share).sum();
        let down = |&(i, share): &(u32, f64)| {
            share * (solid.points[i as usize].z - state.position[i as usize].z) / (area * LENGTH)
        };
        let found = end.iter().map(down).sum();
        let outcome = Outcome::default()
            .count("unknowns", 3 * (count - held.len()) as u64)
            .count("Newton iterations", report.newton.iterations)
            .count("factorisations", report.newton.factorisations)
            .invariant("smallest det F", solid.smallest_volume_ratio(&state.position))
            .state(state.hash());
        pictured(self.judged(outcome, found), at, "the beam at rest, nodes", || Portrait::<2> {
            positions: state.position.iter().map(|x| [x.x, x.z - 0.5 * HEIGHT]).collect(),
            values: state.position.iter().zip(&solid.points).map(|(x, rest)| rest.z - x.z).collect(),
            radius: 0.25 * at.ladder,
            field: ("sinks by", "m"),
            label: format!("{}, tip {found:.5} L", at.method),
            ..Portrait::default()
        })
    }

    fn by_particles(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let (name, at_once) = match at.method.strip_suffix(AT_ONCE) {
            Some(name) => (name, true),
            None => (at.method, false),
        };
        let method = Method::named(name)?;
        let spacing = at.ladder * LENGTH;
        let matter = Matter::new(Elasticity::NeoHookean, (YOUNG, 0.0), DENSITY)?;
        let counts =
            [2.0 * LENGTH, HEIGHT].map(|side| (side / spacing * method.along as f64).round() as usize);
        let [columns, rows] = counts;
        let cloud = Cloud::cuboid([-LENGTH, -0.5 * HEIGHT], [LENGTH, 0.5 * HEIGHT], counts);
        let mut solver = Solver::new(method, spacing)?;
        solver.add_cloud(&matter, &cloud)?;
        let middle = Shape::Cuboid { centre: [0.0; 2], half: [0.25 * spacing, HEIGHT] };
        solver.add_prescribed_velocity(PrescribedVelocity {
            region: middle,
            velocity: [0.0; 2],
            from: 0.0,
            until: f64::INFINITY,
        })?;
        solver.set_gravity([0.0, -self.gravity()])?;
        // (1.8751/L)² √(EI/ρA).
        let frequency = 3.516_015 * HEIGHT / (LENGTH * LENGTH) * (YOUNG / (12.0 * DENSITY)).sqrt();
        let duration = if at_once { 0.0 } else { SETTLED / frequency };
        let mut watch = Watch::start(&solver);
        let mut report = EquilibriumReport::default();
        if at_once {
            report = clock.time(|| solver.equilibrate())?;
        }
        let mut steps = 0_u64;
        while solver.time() < duration {
            let step = solver.stable_step().min(duration - solver.time());
            let drag: Vec<[f64; 2]> =
                solver.velocities(0).iter().map(|v| v.map(|v| -2.0 * frequency * v)).collect();
            solver.accelerate(0, &drag, step)?;
            clock.time(|| solver.step(step)).map_err(ExperimentError::stopped)?;
            steps += 1;
            if steps.is_multiple_of(256) {
                watch.look(&mut solver, 0.0);
            }
        }
        // The mean of the last two columns, carried on to the end.
        let places = solver.positions(0);
        let height =
            |column: usize| (0..rows).map(|row| places[column * rows + row][1]).sum::<f64>() / rows as f64;
        let end = |last: usize, before: usize| 1.5 * height(last) - 0.5 * height(before);
        let [left, right] = [end(0, 1), end(columns - 1, columns - 2)];
        let hold = 0.5 * (height(columns / 2) + height(columns / 2 - 1));
        let found = -0.5 * (left + right) / LENGTH;
        let speed = solver.velocities(0).iter().fold(0.0_f64, |m, v| m.max(v[0].hypot(v[1])));
        let outcome = Outcome::default()
            .count("Newton iterations", report.iterations)
            .count("products", report.products)
            .invariant("difference of the ends", (left - right).abs() / LENGTH)
            .invariant("middle sinks (L)", -hold / LENGTH)
            .invariant("largest speed at the end by ω L", speed / (frequency * LENGTH));
        let outcome = watch.held(solver.counted(self.judged(outcome, found)));
        pictured(outcome, at, "the beam and its mirror image at rest", || Portrait {
            positions: places.clone(),
            values: solver.states(0).iter().map(|state| 1e-3 * state.kirchhoff[(0, 0)]).collect(),
            radius: 0.25 * spacing,
            field: ("stress along x", "kPa"),
            label: format!("{}, tip {found:.5} L", at.method),
            ..Portrait::default()
        })
    }
}

impl Experiment for HangingCantilever {
    fn methods(&self) -> &'static [&'static str] {
        &NAMES
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        if ELEMENTS.contains(&at.method) { self.by_elements(at, clock) } else { self.by_particles(at, clock) }
    }
}
