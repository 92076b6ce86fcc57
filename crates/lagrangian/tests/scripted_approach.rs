//! Scripted points that cannot jump to their targets, because a barrier or an element is in the way.

// In a test a panic is the report; the lint spares only functions marked as tests.
#![allow(clippy::unwrap_used)]
// The stepper needs the sparse solvers' feature.
#![cfg(feature = "bodies")]

#[path = "scripted_approach/faults.rs"]
mod faults;
#[path = "../../mechanics-core/tests/optimise/lying.rs"]
mod lying;

use lagrangian::element::{Mass, MassDistribution, Tetrahedra};
use lagrangian::stepper::{StepError, Stepper, StepperOptions, TimeScheme};
use mechanics_core::law::{Hyperelastic, Lame, NeoHookean, StableNeoHookean};
use mechanics_core::mesh::{BoxSplit, TetMesh, block};
use mechanics_core::newton::{NewtonOptions, Proceed};
use mechanics_core::parallel::with_threads;
use mechanics_core::point_map::PointMap;
use mechanics_core::potential::{Demand, Potential, PotentialError, StepLimit};
use mechanics_core::projection::Projection;
use mechanics_core::sparse::Assembler;
use mechanics_core::state::State;
use mechanics_core::stencil::StencilTerm;
use mechanics_core::tensor::{Mat3, Vec3};

/// Points kept apart in height: κ Σ −(d − d̂)² ln(d/d̂) over pairs with d = z_upper − z_lower < d̂; a floor is a pair with a fixed point.
#[derive(Clone)]
struct Heights {
    pairs: Vec<[u32; 2]>,
    activation: f64,
    stiffness: f64,
}

impl Heights {
    fn gap(&self, pair: usize, x: &[Vec3]) -> f64 {
        let [upper, lower] = self.pairs[pair];
        x[upper as usize].z - x[lower as usize].z
    }

    fn gaps(&self, x: &[Vec3]) -> Vec<f64> {
        (0..self.pairs.len()).map(|pair| self.gap(pair, x)).collect()
    }

    fn active(&self, x: &[Vec3]) -> impl Iterator<Item = (usize, f64)> {
        self.gaps(x).into_iter().enumerate().filter(|&(_, d)| d < self.activation)
    }
}

impl Potential for Heights {
    fn name(&self) -> &'static str {
        "heights"
    }

    fn value(&self, x: &[Vec3]) -> f64 {
        let a = self.activation;
        let barrier = |d: f64| if d > 0.0 { -(d - a).powi(2) * (d / a).ln() } else { f64::INFINITY };
        self.active(x).map(|(_, d)| self.stiffness * barrier(d)).sum()
    }

    fn add_gradient(&self, x: &[Vec3], gradient: &mut [Vec3]) {
        for (pair, d) in self.active(x) {
            let a = self.activation;
            let slope = -2.0 * (d - a) * (d / a).ln() - (d - a).powi(2) / d;
            let [upper, lower] = self.pairs[pair];
            gradient[upper as usize].z += self.stiffness * slope;
            gradient[lower as usize].z -= self.stiffness * slope;
        }
    }

    fn add_hessian(&self, x: &[Vec3], _: Projection, hessian: &mut Assembler<'_>) {
        let active: Vec<(usize, f64)> = self.active(x).collect();
        let pairs: Vec<[u32; 2]> = active.iter().map(|&(pair, _)| self.pairs[pair]).collect();
        hessian.add(&pairs, |k| {
            let (a, d) = (self.activation, active[k].1);
            let second = -2.0 * (d / a).ln() - 4.0 * (d - a) / d + ((d - a) / d).powi(2);
            let block = Mat3::from_diagonal(&Vec3::new(0.0, 0.0, self.stiffness * second));
            [[block, -block], [-block, block]]
        });
    }

    /// No gap closes by more than nine tenths.
    fn limit_step(&mut self, x: &[Vec3], p: &[Vec3]) -> Result<StepLimit, PotentialError> {
        let (gaps, closing) = (self.gaps(x), self.gaps(p));
        let parts = gaps.iter().zip(&closing).map(|(d, p)| if *p < 0.0 { -0.9 * d / p } else { 1.0 });
        let (pair, part) = parts.enumerate().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        Ok(StepLimit::by_element(part, pair))
    }

    fn demand(&self) -> Demand {
        Demand::EndPositions
    }
}

/// A cube on a floor under a press: points of the cube, one of the floor, one of the press, apart by 0.01.
struct Press {
    mesh: TetMesh,
    elastic: StencilTerm<Tetrahedra<StableNeoHookean>, 4>,
    heights: Heights,
    mass: Mass,
    start: Vec<Vec3>,
    floor: u32,
    plate: u32,
}

const GAP: f64 = 0.01;

impl Press {
    fn new() -> Self {
        Self::of(3)
    }

    /// The cube in so many cells along an edge.
    fn of(cells: u32) -> Self {
        let mesh = block(&Vec3::zeros(), &Vec3::repeat(1.0), [cells; 3], BoxSplit::Six).unwrap();
        let law = StableNeoHookean::new(Lame::from_young_poisson(1e4, 0.4).unwrap());
        let elastic = Tetrahedra::term("elastic", law, &mesh).unwrap();
        let n = mesh.points().len();
        let mut mass = Mass::zeros(n + 2);
        mass.add_tetrahedra(mesh.points(), mesh.cells(), 1000.0, MassDistribution::Lumped).unwrap();
        let (floor, plate) = (n as u32, n as u32 + 1);
        let points = || mesh.points().iter().zip(0u32..);
        let below = points().filter(|(x, _)| x.z == 0.0).map(|(_, i)| [i, floor]);
        let above = points().filter(|(x, _)| x.z == 1.0).map(|(_, i)| [plate, i]);
        let pairs = below.chain(above).chain([[plate, floor]]).collect();
        let heights = Heights { pairs, activation: 0.02, stiffness: 1e5 };
        let ends = [Vec3::new(0.5, 0.5, -GAP), Vec3::new(0.5, 0.5, 1.0 + GAP)];
        let start: Vec<Vec3> = mesh.points().iter().copied().chain(ends).collect();
        Self { mesh, elastic, heights, mass, start, floor, plate }
    }

    fn stepper(&self, scheme: TimeScheme, tolerance: f64) -> Stepper {
        let ends = [self.floor, self.plate].map(|point| (point, self.start[point as usize]));
        let map = PointMap::with_fixed(self.start.len(), &ends).unwrap();
        let newton = NewtonOptions { tolerance, max_iterations: 200, ..Default::default() };
        Stepper::new(self.mass.clone(), map, StepperOptions { scheme, newton, ..Default::default() })
    }

    fn target(&self, height: f64) -> Vec3 {
        Vec3::new(0.5, 0.5, height)
    }
}

/// The plate's jump is thirty times its gap: the cube is pushed, no gap closes, and the end is the minimum of the step.
#[test]
fn a_press_pushes_the_body_instead_of_jumping_through() {
    let h = 0.02;
    for scheme in [TimeScheme::BackwardEuler, TimeScheme::Bdf2] {
        let mut press = Press::new();
        let mut stepper = press.stepper(scheme, 1e-9);
        let mut state = State::at_rest(press.start.clone());
        for height in [0.7, 0.4, 0.2] {
            stepper.set_target(press.plate, press.target(height)).unwrap();
            let before = state.clone();
            let report = stepper.step(&mut state, &mut [&mut press.elastic, &mut press.heights], h).unwrap();
            assert!(report.pulls > 0 && report.newton.iterations < 120, "{report:?}");
            assert_eq!(state.position[press.plate as usize], press.target(height));
            assert!(press.heights.gaps(&state.position).iter().all(|&d| d > 0.0));
            if scheme == TimeScheme::BackwardEuler {
                assert_minimum(&press, &before, &state, h);
            }
        }
    }
}

/// M (x − xₙ − h vₙ)/h² + ∇E = 0 at points that are not scripted.
fn assert_minimum(press: &Press, before: &State, after: &State, h: f64) {
    let mut forces = vec![Vec3::zeros(); press.start.len()];
    press.elastic.add_gradient(&after.position, &mut forces);
    press.heights.add_gradient(&after.position, &mut forces);
    let largest = forces.iter().map(|f| f.norm()).fold(0.0, f64::max);
    for i in 0..press.mesh.points().len() {
        let inertial = before.position[i] + before.velocity[i] * h;
        let residual = (after.position[i] - inertial) * (press.mass.diagonal()[i] / (h * h)) + forces[i];
        assert!(residual.norm() < 1e-6 * largest, "{i}: {residual} of {largest:e}");
    }
}

/// Times of terms are those of the whole step, pulling included: most of Newton's time for values is spent in the terms. A step
/// takes microseconds, and one that was interrupted says nothing: one of twenty must show it.
#[test]
fn the_times_of_terms_include_pulling() {
    let most_of_it_is_in_terms = || {
        let mut press = Press::new();
        let mut stepper = press.stepper(TimeScheme::BackwardEuler, 1e-6);
        let mut state = State::at_rest(press.start.clone());
        stepper.set_target(press.plate, press.target(0.4)).unwrap();
        let report = stepper.step(&mut state, &mut [&mut press.elastic, &mut press.heights], 0.02).unwrap();
        assert!(report.pulls > 1 && report.terms.len() == 3, "{report:?}");
        let in_terms: std::time::Duration = report.terms.iter().map(|term| term.times.value).sum();
        2 * in_terms > report.newton.times.value
    };
    assert!((0..20).any(|_| most_of_it_is_in_terms()));
}

/// Slower than the gap there is nothing to pull.
#[test]
fn an_admissible_jump_is_a_jump() {
    let mut press = Press::new();
    let mut stepper = press.stepper(TimeScheme::BackwardEuler, 1e-9);
    let mut state = State::at_rest(press.start.clone());
    stepper.set_target(press.plate, press.target(1.004)).unwrap();
    let report = stepper.step(&mut state, &mut [&mut press.elastic, &mut press.heights], 0.02).unwrap();
    assert_eq!(report.pulls, 0);
    assert_eq!(state.position[press.plate as usize], press.target(1.004));
}

/// Pressed in one load step the cube is where many small ones bring it.
#[test]
fn the_equilibrium_does_not_depend_on_how_it_was_reached() {
    let press = |load_steps: u32| {
        let mut press = Press::new();
        let mut stepper = press.stepper(TimeScheme::BackwardEuler, 1e-10);
        let mut state = State::at_rest(press.start.clone());
        stepper.set_target(press.plate, press.target(0.8)).unwrap();
        let terms: &mut [&mut dyn Potential] = &mut [&mut press.elastic, &mut press.heights];
        let report = stepper.equilibrium(&mut state, terms, load_steps).unwrap();
        (state, report.pulls, press.plate)
    };
    let (one, pulls, plate) = press(1);
    let (many, jumps, _) = press(100);
    assert!(pulls > 0 && jumps == 0, "{pulls} {jumps}");
    assert_eq!(one.position[plate as usize].z, 0.8);
    // Nothing holds the cube sideways: heights alone are determined.
    for (a, b) in one.position.iter().zip(&many.position) {
        assert!((a.z - b.z).abs() < 1e-7, "{a} {b}");
    }
}

/// Below the floor there is no place for the plate, and none for the cube between them.
#[test]
fn a_target_that_cannot_be_reached_is_an_error_with_its_name() {
    let mut press = Press::new();
    let mut stepper = press.stepper(TimeScheme::BackwardEuler, 1e-6);
    let mut state = State::at_rest(press.start.clone());
    let before = state.hash();
    for height in [-0.5, -GAP] {
        stepper.set_target(press.plate, press.target(height)).unwrap();
        let terms: &mut [&mut dyn Potential] = &mut [&mut press.elastic, &mut press.heights];
        let error = stepper.step(&mut state, terms, 0.02).unwrap_err();
        let StepError::Unreached { point, target, remaining, .. } = error else { panic!("{error}") };
        assert_eq!((point, target), (press.plate, [0.5, 0.5, height]));
        let least = -GAP - height;
        assert!(remaining > least && remaining < least + 0.2, "{remaining}");
        assert_eq!(state.hash(), before);
    }
    // The same stepper goes on from there as a new one would.
    let target = press.target(0.9);
    let terms: &mut [&mut dyn Potential] = &mut [&mut press.elastic, &mut press.heights];
    let mut fresh_state = state.clone();
    stepper.set_target(press.plate, target).unwrap();
    stepper.step(&mut state, terms, 0.02).unwrap();
    let mut fresh = press.stepper(TimeScheme::BackwardEuler, 1e-6);
    fresh.set_target(press.plate, target).unwrap();
    let terms: &mut [&mut dyn Potential] = &mut [&mut press.elastic, &mut press.heights];
    fresh.step(&mut fresh_state, terms, 0.02).unwrap();
    assert_eq!(state.hash(), fresh_state.hash());
}

#[test]
fn a_pulled_step_has_the_same_bits_for_any_number_of_threads() {
    let run = || {
        let mut press = Press::of(6);
        assert!(press.mesh.cells().len() > 1024, "several chunks");
        let mut stepper = press.stepper(TimeScheme::BackwardEuler, 1e-5);
        let mut state = State::at_rest(press.start.clone());
        stepper.set_target(press.plate, press.target(0.95)).unwrap();
        let report = stepper.step(&mut state, &mut [&mut press.elastic, &mut press.heights], 0.02).unwrap();
        assert!(report.pulls > 0);
        state.hash()
    };
    let [one, others @ ..] = [1, 2, 3, 8].map(|threads| with_threads(threads, run));
    assert_eq!(others, [one; 3]);
}

/// A plate that should be on the other side of a free particle takes it along, however light or heavy the particle is.
#[test]
fn a_plate_takes_a_particle_along() {
    for mass_of_particle in [1e-6, 1.0, 1e6] {
        let mut heights = Heights { pairs: vec![[1, 0]], activation: 0.01, stiffness: 1e3 };
        let mut mass = Mass::zeros(2);
        mass.add_point(0, mass_of_particle).unwrap();
        let x = vec![Vec3::zeros(), Vec3::new(0.0, 0.0, 1.0)];
        let map = PointMap::with_fixed(2, &[(1, x[1])]).unwrap();
        let mut stepper = Stepper::new(mass, map, StepperOptions::default());
        let mut state = State::at_rest(x);
        for k in 1..=3 {
            let target = Vec3::new(0.0, 0.0, 1.0 - 2.0 * f64::from(k));
            stepper.set_target(1, target).unwrap();
            let report = stepper.step(&mut state, &mut [&mut heights], 0.1).unwrap();
            assert!(report.newton.iterations < 150, "{mass_of_particle}: {}", report.newton.iterations);
            assert_eq!(state.position[1], target);
            let gap = target.z - state.position[0].z;
            assert!(gap > 0.0, "{gap}");
        }
    }
}

/// The driven end of a bar moves by more than two of its elements: they would be inside out, but the bar follows. It is too thick to
/// buckle (at 4π²/12 (H/L)² = 0.8 of its length), so there is one equilibrium.
#[test]
fn a_bar_is_compressed_by_more_than_an_element() {
    fn end<L: Hyperelastic>(law: L, load_steps: u32) -> (Vec<Vec3>, u64) {
        let mesh = block(&Vec3::zeros(), &Vec3::new(1.0, 0.5, 0.5), [20, 2, 2], BoxSplit::Six).unwrap();
        let mut elastic = Tetrahedra::term("elastic", law, &mesh).unwrap();
        let n = mesh.points().len();
        let is_end = |x: &Vec3| x.x == 0.0 || x.x == 1.0;
        let fixed: Vec<(u32, Vec3)> =
            mesh.points().iter().zip(0..).filter(|(x, _)| is_end(x)).map(|(x, i)| (i, *x)).collect();
        let newton = NewtonOptions { tolerance: 1e-11, ..Default::default() };
        let options = StepperOptions { newton, ..Default::default() };
        let mut stepper = Stepper::new(Mass::zeros(n), PointMap::with_fixed(n, &fixed).unwrap(), options);
        for (point, x) in fixed.iter().filter(|(_, x)| x.x == 1.0) {
            stepper.set_target(*point, x - Vec3::new(0.12, 0.0, 0.0)).unwrap();
        }
        let mut state = State::at_rest(mesh.points().to_vec());
        let report = stepper.equilibrium(&mut state, &mut [&mut elastic], load_steps).unwrap();
        (state.position, report.pulls)
    }
    let law = || NeoHookean::new(Lame::from_young_poisson(1e5, 0.3).unwrap());
    let (one, pulls) = end(law(), 1);
    let (many, jumps) = end(law(), 20);
    assert!(pulls > 0 && jumps == 0, "{pulls} {jumps}");
    for (a, b) in one.iter().zip(&many) {
        assert!((a - b).norm() < 1e-8, "{a} {b}");
    }
}

/// Cancelling while points are pulled is no failure to reach a target.
#[test]
fn pulling_can_be_cancelled() {
    let mut press = Press::new();
    let mut stepper = press.stepper(TimeScheme::BackwardEuler, 1e-6);
    let mut state = State::at_rest(press.start.clone());
    stepper.set_target(press.plate, press.target(0.5)).unwrap();
    let terms: &mut [&mut dyn Potential] = &mut [&mut press.elastic, &mut press.heights];
    let mut count = 0;
    let error = stepper.step_observed(&mut state, terms, 0.02, &mut |_| {
        count += 1;
        if count > 2 { Proceed::Cancel } else { Proceed::Continue }
    });
    assert!(matches!(error, Err(StepError::Newton { .. })));
    assert_eq!(state.position, press.start);
}
