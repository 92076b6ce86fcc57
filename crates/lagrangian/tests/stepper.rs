//! The stepper against closed forms, conservation laws and itself.

// In a test a panic is the report; the lint spares only functions marked as tests.
#![allow(clippy::unwrap_used)]
// The stepper needs the sparse solvers' feature.
#![cfg(feature = "bodies")]

use lagrangian::element::{DeadLoad, Mass, MassDistribution, Tetrahedra};
use lagrangian::stepper::{ExplicitScheme, ExplicitStepper, StepError, Stepper, StepperOptions, TimeScheme};
use mechanics_core::law::{Lame, NeoHookean, StableNeoHookean};
use mechanics_core::mesh::TetMesh;
use mechanics_core::mesh::{BoxSplit, block};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::parallel::with_threads;
use mechanics_core::point_map::PointMap;
use mechanics_core::potential::Potential;
use mechanics_core::state::State;
use mechanics_core::stencil::StencilTerm;
use mechanics_core::tensor::Vec3;

const SCHEMES: [TimeScheme; 4] =
    [TimeScheme::BackwardEuler, TimeScheme::Bdf2, TimeScheme::Newmark, TimeScheme::ImplicitMidpoint];

fn lame(young: f64, poisson: f64) -> Lame {
    Lame::from_young_poisson(young, poisson).unwrap()
}

fn bar(cells: [u32; 3]) -> TetMesh {
    let size = Vec3::new(0.1 * f64::from(cells[0]), 0.1 * f64::from(cells[1]), 0.1 * f64::from(cells[2]));
    block(&Vec3::zeros(), &size, cells, BoxSplit::Six).unwrap()
}

fn mass_of(mesh: &TetMesh, distribution: MassDistribution) -> Mass {
    let mut mass = Mass::zeros(mesh.points().len());
    mass.add_tetrahedra(mesh.points(), mesh.cells(), 1000.0, distribution).unwrap();
    mass
}

fn elastic(mesh: &TetMesh) -> StencilTerm<Tetrahedra<StableNeoHookean>, 4> {
    Tetrahedra::term("elastic", StableNeoHookean::new(lame(1e4, 0.4)), mesh).unwrap()
}

fn options(scheme: TimeScheme, tolerance: f64) -> StepperOptions {
    StepperOptions { scheme, newton: NewtonOptions { tolerance, ..Default::default() }, ..Default::default() }
}

/// A body falls as a point does, wherever it is and however it is stepped; the offset of each scheme from
/// x₀ + v₀t + ½gt² is known: ½ght for backward Euler, none for the others, but BDF2 for its first step of backward Euler.
#[test]
fn free_fall_has_the_offset_of_its_scheme() {
    let mesh = bar([2, 1, 1]);
    let (g, v0, h, steps) = (Vec3::new(0.0, 1.0, -9.81), Vec3::new(1.0, 2.0, 3.0), 0.02, 20);
    for scheme in SCHEMES {
        for distribution in [MassDistribution::Lumped, MassDistribution::Consistent] {
            let mass = mass_of(&mesh, distribution);
            let mut gravity = DeadLoad::gravity(&mass, &g).unwrap();
            let mut elastic = elastic(&mesh);
            let mut stepper =
                Stepper::new(mass, PointMap::identity(mesh.points().len()), options(scheme, 1e-9));
            let mut state = State::at_rest(mesh.points().to_vec());
            state.velocity.fill(v0);
            for _ in 0..steps {
                stepper.step(&mut state, &mut [&mut elastic, &mut gravity], h).unwrap();
            }
            let t = h * f64::from(steps);
            let lag = match scheme {
                TimeScheme::BackwardEuler => 0.5 * h * t,
                TimeScheme::Bdf2 => bdf2_offset(h, steps),
                _ => 0.0,
            };
            let expected = v0 * t + g * (0.5 * t * t + lag);
            for (x, start) in state.position.iter().zip(mesh.points()) {
                let error = (x - start - expected).norm();
                assert!(error < 1e-11, "{scheme:?} {distribution:?}: {error:e}");
            }
            for v in &state.velocity {
                assert!((v - v0 - g * t).norm() < 1e-9, "{scheme:?}: {v}");
            }
            assert!((state.time - t).abs() < 1e-12 && state.step == 20);
        }
    }
}

/// The scalar recursion of BDF2 on ẍ = 1 from rest, one step of backward Euler first, less ½t².
fn bdf2_offset(h: f64, steps: i32) -> f64 {
    let (mut x0, mut v0, mut x, mut v) = (0.0, 0.0, h * h, h);
    for _ in 1..steps {
        let nv = (4.0 * v - v0) / 3.0 + 2.0 / 3.0 * h;
        let nx = (4.0 * x - x0) / 3.0 + 2.0 / 3.0 * h * nv;
        (x0, v0, x, v) = (x, v, nx, nv);
    }
    x - 0.5 * (h * f64::from(steps)).powi(2)
}

fn twisted(mesh: &TetMesh, rate: f64) -> State {
    let mut state = State::at_rest(mesh.points().to_vec());
    for (v, x) in state.velocity.iter_mut().zip(mesh.points()) {
        *v = Vec3::new(0.0, -x.z, x.y) * (rate * x.x);
    }
    state
}

#[test]
fn steps_have_the_same_bits_for_any_number_of_threads() {
    let mesh = bar([14, 4, 4]);
    assert!(mesh.cells().len() > 1024, "several chunks");
    for scheme in SCHEMES {
        let run = || {
            let mass = mass_of(&mesh, MassDistribution::Consistent);
            let mut elastic = elastic(&mesh);
            let map = PointMap::with_fixed(mesh.points().len(), &[(0, mesh.points()[0])]).unwrap();
            let mut stepper = Stepper::new(mass, map, options(scheme, 1e-6));
            let mut state = twisted(&mesh, 20.0);
            for _ in 0..2 {
                stepper.step(&mut state, &mut [&mut elastic], 0.01).unwrap();
            }
            state.hash()
        };
        let [one, two, three, eight] = [1, 2, 3, 8].map(|threads| with_threads(threads, run));
        assert!(one == two && two == three && three == eight, "{scheme:?}");
    }
}

#[test]
fn equilibria_and_explicit_steps_have_the_same_bits_for_any_number_of_threads() {
    let mesh = bar([14, 4, 4]);
    let mass = mass_of(&mesh, MassDistribution::Lumped);
    let at_wall: Vec<(u32, Vec3)> =
        (0..).zip(mesh.points().iter().copied()).filter(|(_, x)| x.x == 0.0).collect();
    let map = PointMap::with_fixed(mesh.points().len(), &at_wall).unwrap();
    let run = || {
        let mut gravity = DeadLoad::gravity(&mass, &Vec3::new(0.0, 0.0, -0.1)).unwrap();
        let (mut elastic, mut state) = (elastic(&mesh), State::at_rest(mesh.points().to_vec()));
        let mut stepper = Stepper::new(mass.clone(), map.clone(), options(SCHEMES[0], 1e-6));
        stepper.equilibrium(&mut state, &mut [&mut elastic, &mut gravity], 1).unwrap();
        let equilibrium = state.hash();
        let explicit =
            ExplicitStepper::new(ExplicitScheme::CentralDifferences, mass.clone(), map.clone()).unwrap();
        state.velocity = twisted(&mesh, 20.0).velocity;
        for _ in 0..20 {
            explicit.step(&mut state, &mut [&mut elastic, &mut gravity], 1e-4).unwrap();
        }
        [equilibrium, state.hash()]
    };
    let [one, others @ ..] = [1, 2, 3, 8].map(|threads| with_threads(threads, run));
    assert_eq!(others, [one; 3]);
}

/// Momentum is kept by all schemes, angular momentum by the midpoint rule, to the tolerance of Newton's method.
#[test]
fn a_free_body_keeps_its_momenta() {
    let mesh = bar([4, 2, 2]);
    for scheme in SCHEMES {
        let mass = mass_of(&mesh, MassDistribution::Lumped);
        let mut elastic = elastic(&mesh);
        let mut stepper = Stepper::new(mass, PointMap::identity(mesh.points().len()), options(scheme, 1e-10));
        let mut state = twisted(&mesh, 30.0);
        state.velocity.iter_mut().for_each(|v| *v += Vec3::new(0.3, 0.1, -0.2));
        let about = Vec3::new(1.0, 2.0, 3.0);
        let p = stepper.mass().linear_momentum(&state.velocity);
        let l = stepper.mass().angular_momentum(&state.position, &state.velocity, &about);
        for _ in 0..10 {
            stepper.step(&mut state, &mut [&mut elastic], 0.02).unwrap();
        }
        let p1 = stepper.mass().linear_momentum(&state.velocity);
        let l1 = stepper.mass().angular_momentum(&state.position, &state.velocity, &about);
        assert!((p1 - p).norm() < 1e-9 * p.norm(), "{scheme:?} {:e}", (p1 - p).norm());
        if scheme == TimeScheme::ImplicitMidpoint {
            assert!((l1 - l).norm() < 1e-8 * l.norm(), "{:e} of {:e}", (l1 - l).norm(), l.norm());
        }
    }
}

#[test]
fn failures_name_the_culprit_and_leave_the_state() {
    let mesh = bar([2, 2, 2]);
    let n = mesh.points().len();
    let mass = mass_of(&mesh, MassDistribution::Lumped);
    let mut neo = Tetrahedra::term("rubber", NeoHookean::new(lame(1e4, 0.3)), &mesh).unwrap();
    let mut stepper = Stepper::new(mass.clone(), PointMap::identity(n), StepperOptions::default());
    let mut state = State::at_rest(mesh.points().to_vec());

    for h in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = stepper.step(&mut state, &mut [&mut neo], h).unwrap_err();
        assert!(matches!(error, StepError::StepSize { .. }), "{error}");
    }

    // An inverted start is refused by the index of an element that holds the point.
    state.position[13] = Vec3::new(1.0, 1.0, 1.0);
    let before = state.hash();
    let error = stepper.step(&mut state, &mut [&mut neo], 0.01).unwrap_err();
    let first = (0..mesh.cells().len()).find(|&e| {
        mechanics_core::mesh::tet_volume(&mesh.cells()[e].map(|i| state.position[i as usize])) <= 0.0
    });
    let text = chain(&error);
    assert!(text.contains("rubber") && text.contains(&format!("element {}", first.unwrap())), "{text}");
    assert_eq!(state.hash(), before);

    state.position[13] = Vec3::new(f64::NAN, 0.0, 0.0);
    let error = stepper.step(&mut state, &mut [&mut neo], 0.01).unwrap_err();
    assert!(matches!(error, StepError::NonFinite { point: 13, .. }), "{error}");

    // Too few iterations: term and element of the residual are named.
    let newton = NewtonOptions { max_iterations: 1, tolerance: 1e-12, ..Default::default() };
    let mut short =
        Stepper::new(mass.clone(), PointMap::identity(n), StepperOptions { newton, ..Default::default() });
    let mut state = twisted(&mesh, 100.0);
    let before = state.hash();
    let text = chain(&short.step(&mut state, &mut [&mut neo], 0.05).unwrap_err());
    assert!(text.contains("term \"rubber\", element") && text.contains("point"), "{text}");
    assert_eq!(state.hash(), before);

    let all: Vec<(u32, Vec3)> = mesh.points().iter().copied().zip(0..).map(|(x, i)| (i, x)).collect();
    let mut pinned = Stepper::new(mass, PointMap::with_fixed(n, &all).unwrap(), StepperOptions::default());
    let error = pinned.step(&mut state, &mut [&mut neo], 0.05).unwrap_err();
    assert!(matches!(error, StepError::NothingToSolve { points: 27 }), "{error}");

    let mut massless = Stepper::new(Mass::zeros(n), PointMap::identity(n), StepperOptions::default());
    let error = massless.step(&mut state, &mut [&mut neo], 0.05).unwrap_err();
    assert!(matches!(error, StepError::NoMass { point: 0, .. }), "{error}");
}

fn chain(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut source = error.source();
    while let Some(error) = source {
        text += &format!(" | {error}");
        source = error.source();
    }
    text
}

/// The middle of a neo-Hookean cube is shot so fast that inertia alone would carry it out through its elements: steps are
/// cut, and no element inverts.
#[test]
fn neo_hookean_elements_never_invert_within_a_step() {
    let mesh = bar([2, 2, 2]);
    let mut neo = Tetrahedra::term("rubber", NeoHookean::new(lame(1e5, 0.3)), &mesh).unwrap();
    let mass = mass_of(&mesh, MassDistribution::Lumped);
    let mut stepper = Stepper::new(mass, PointMap::identity(27), StepperOptions::default());
    let mut state = State::at_rest(mesh.points().to_vec());
    let (h, shot) = (0.01, Vec3::new(20.0, 5.0, 0.0));
    state.velocity[13] = shot;
    let mut carried = mesh.points().to_vec();
    carried[13] += shot * h;
    assert_eq!(neo.value(&carried), f64::INFINITY, "the scene is hard enough to show something");
    for _ in 0..10 {
        stepper.step(&mut state, &mut [&mut neo], h).unwrap();
        for cell in mesh.cells() {
            assert!(mechanics_core::mesh::tet_volume(&cell.map(|i| state.position[i as usize])) > 0.0);
        }
    }
}

/// A demanding term, as contact will be.
struct Barrier;

impl Potential for Barrier {
    fn name(&self) -> &str {
        "barrier"
    }
    fn value(&self, _: &[Vec3]) -> f64 {
        0.0
    }
    fn add_gradient(&self, _: &[Vec3], _: &mut [Vec3]) {}
    fn add_hessian(
        &self,
        _: &[Vec3],
        _: mechanics_core::projection::Projection,
        _: &mut mechanics_core::sparse::Assembler<'_>,
    ) {
    }
    fn demand(&self) -> mechanics_core::potential::Demand {
        mechanics_core::potential::Demand::EndPositions
    }
}

#[test]
fn the_midpoint_rule_refuses_a_barrier_and_the_others_take_it() {
    let mesh = bar([1, 1, 1]);
    for scheme in SCHEMES {
        let mass = mass_of(&mesh, MassDistribution::Lumped);
        let mut stepper = Stepper::new(mass, PointMap::identity(8), options(scheme, 1e-6));
        let mut state = State::at_rest(mesh.points().to_vec());
        let outcome = stepper.step(&mut state, &mut [&mut elastic(&mesh), &mut Barrier], 0.01);
        if scheme == TimeScheme::ImplicitMidpoint {
            assert!(matches!(outcome, Err(StepError::MidpointWithBarrier { term }) if term == "barrier"));
        } else {
            outcome.unwrap();
        }
    }
}
