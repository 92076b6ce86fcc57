//! What used to pass in silence: states that no term admits, history of another scheme, data that makes no body.

// In a test a panic is the report; the lint spares only functions marked as tests.
#![allow(clippy::unwrap_used)]
// Bodies need the sparse solvers' feature.
#![cfg(feature = "bodies")]

use lagrangian::element::hinge::RestAngle;
use lagrangian::element::membrane::{Membranes, NeoHookeanSheet};
use lagrangian::element::plate::PlateBending;
use lagrangian::element::{Amplitude, Attachments, DeadLoad, Mass, MassDistribution, Springs, Tetrahedra};
use lagrangian::position_based::{ConstraintGroup, Distances, Particles, PositionBased, Response};
use lagrangian::stepper::{
    ExplicitScheme, ExplicitStepper, Lagging, Minimum, StepError, Stepper, StepperOptions, TimeScheme,
};
use mechanics_core::law::{Lame, NeoHookean};
use mechanics_core::mesh::{BoxSplit, TriMesh, block, tet_volume};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::point_map::{PointMap, PointSource};
use mechanics_core::potential::Potential;
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;

fn options(scheme: TimeScheme) -> StepperOptions {
    let newton = NewtonOptions { tolerance: 1e-9, ..Default::default() };
    StepperOptions { scheme, newton, ..Default::default() }
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

fn point_masses(masses: &[f64]) -> Mass {
    let mut mass = Mass::zeros(masses.len());
    masses.iter().zip(0..).for_each(|(&m, point)| mass.add_point(point, m).unwrap());
    mass
}

/// A spring between two masses on a line, at rest one apart.
fn pair() -> (mechanics_core::stencil::StencilTerm<Springs, 2>, Mass, State) {
    let points = vec![Vec3::zeros(), Vec3::x()];
    let spring = Springs::term("spring", 100.0, &points, vec![[0, 1]]).unwrap();
    let mut state = State::at_rest(points);
    state.velocity[1] = Vec3::x();
    (spring, point_masses(&[1.0, 1.0]), state)
}

/// The midpoint rule minimises over the middle of a step, where an element may be sound that is inside out at the end.
/// Sooner or later that happens to a cube shot into itself; whatever is accepted must be sound.
#[test]
fn the_midpoint_rule_accepts_no_inverted_end() {
    let mesh = block(&Vec3::zeros(), &Vec3::repeat(0.2), [2, 2, 2], BoxSplit::Six).unwrap();
    let law = NeoHookean::new(Lame::from_young_poisson(1e5, 0.3).unwrap());
    let mut rubber = Tetrahedra::term("rubber", law, &mesh).unwrap();
    let mut mass = Mass::zeros(27);
    mass.add_tetrahedra(mesh.points(), mesh.cells(), 1000.0, MassDistribution::Lumped).unwrap();
    let mut stepper = Stepper::new(mass, PointMap::identity(27), options(TimeScheme::ImplicitMidpoint));
    let mut refused = 0;
    for speed in [5.0, 10.0, 15.0, 20.0, 30.0, 40.0, 80.0] {
        let mut state = State::at_rest(mesh.points().to_vec());
        state.velocity[13] = Vec3::new(speed, 0.25 * speed, 0.0);
        let before = state.hash();
        match stepper.step(&mut state, &mut [&mut rubber], 0.01) {
            Err(error) => {
                let text = chain(&error);
                assert!(text.contains("rubber") && text.contains("element"), "{text}");
                assert_eq!(state.hash(), before);
                refused += 1;
            }
            Ok(_) => {
                let volume = |cell: &[u32; 4]| tet_volume(&cell.map(|i| state.position[i as usize]));
                let worst = mesh.cells().iter().map(volume).fold(f64::INFINITY, f64::min);
                assert!(worst > 0.0, "speed {speed}: {worst:e} m³");
            }
        }
    }
    assert!(refused > 0, "the scene is hard enough to show something");
}

/// A step by another scheme makes what a multistep scheme remembers stale: it starts anew, as from a fresh state.
#[test]
fn history_does_not_outlive_a_step_of_another_scheme() {
    for (own, other) in [
        (TimeScheme::Bdf2, TimeScheme::BackwardEuler),
        (TimeScheme::Newmark, TimeScheme::ImplicitMidpoint),
        (TimeScheme::Newmark, TimeScheme::Bdf2),
    ] {
        let (mut spring, mass, mut state) = pair();
        let mut one = Stepper::new(mass.clone(), PointMap::identity(2), options(own));
        let mut two = Stepper::new(mass, PointMap::identity(2), options(other));
        one.step(&mut state, &mut [&mut spring], 0.1).unwrap();
        two.step(&mut state, &mut [&mut spring], 0.1).unwrap();
        let mut fresh = state.clone();
        fresh.clear_history();
        one.step(&mut state, &mut [&mut spring], 0.1).unwrap();
        one.step(&mut fresh, &mut [&mut spring], 0.1).unwrap();
        assert_eq!(state.hash(), fresh.hash(), "{own:?} after {other:?}");
    }
    let (mut spring, mass, mut state) = pair();
    let explicit = |scheme| ExplicitStepper::new(scheme, mass.clone(), PointMap::identity(2)).unwrap();
    let central = explicit(ExplicitScheme::CentralDifferences);
    central.step(&mut state, &mut [&mut spring], 0.01).unwrap();
    explicit(ExplicitScheme::SymplecticEuler).step(&mut state, &mut [&mut spring], 0.01).unwrap();
    let mut fresh = state.clone();
    fresh.clear_history();
    central.step(&mut state, &mut [&mut spring], 0.01).unwrap();
    central.step(&mut fresh, &mut [&mut spring], 0.01).unwrap();
    assert_eq!(state.hash(), fresh.hash());
}

/// One stepper serves two lists of as many terms with different patterns: each has the bits of a stepper of its own.
#[test]
fn bits_do_not_depend_on_the_terms_of_earlier_steps() {
    let n = 60;
    let points: Vec<Vec3> =
        (0..n).map(|i| Vec3::new((f64::from(i) * 0.7).sin(), f64::from(i) * 0.1, 0.0)).collect();
    let path: Vec<[u32; 2]> = (1..n).map(|i| [i - 1, i]).collect();
    let far: Vec<[u32; 2]> = (0..n).map(|i| [i, (i * 7 + 3) % n]).filter(|[a, b]| a != b).collect();
    let mut near = Springs::term("near", 100.0, &points, path).unwrap();
    let mut wide = Springs::term("wide", 100.0, &points, far).unwrap();
    let stepper = || {
        let mass = point_masses(&vec![0.1; n as usize]);
        Stepper::new(mass, PointMap::identity(n as usize), options(TimeScheme::BackwardEuler))
    };
    let mut start = State::at_rest(points.clone());
    start.velocity.iter_mut().zip(&points).for_each(|(v, x)| *v = Vec3::new(x.y, -x.x, x.x * x.y));
    let mut used = stepper();
    used.step(&mut start.clone(), &mut [&mut near], 0.05).unwrap();
    let (mut one, mut two) = (start.clone(), start);
    used.step(&mut one, &mut [&mut wide], 0.05).unwrap();
    stepper().step(&mut two, &mut [&mut wide], 0.05).unwrap();
    assert_eq!(one.hash(), two.hash());
}

/// A target for a point that moves freely would be passed over in silence.
#[test]
fn only_fixed_points_have_targets() {
    let (_, mass, state) = pair();
    let map = PointMap::with_fixed(2, &[(0, state.position[0])]).unwrap();
    let mut stepper = Stepper::new(mass, map, options(TimeScheme::BackwardEuler));
    stepper.set_target(0, Vec3::y()).unwrap();
    let error = stepper.set_target(1, Vec3::y()).unwrap_err();
    assert!(error.to_string().contains("point 1"), "{error}");
    assert!(stepper.set_target(2, Vec3::y()).is_err());
}

/// A sheet without area is outside the law's domain, whether it rests or moves.
#[test]
fn an_inadmissible_start_is_refused_though_it_moves() {
    let points = vec![Vec3::zeros(), Vec3::x(), Vec3::y()];
    let mesh = TriMesh::new(points.clone(), vec![[0, 1, 2]]).unwrap();
    let law = NeoHookeanSheet::new(1e4, 0.3).unwrap();
    let mut sheet = Membranes::term("sheet", &mesh, law, 1e-3).unwrap();
    for speed in [0.0, 1.0] {
        let mut state = State::at_rest(points.clone());
        state.position[2] = Vec3::new(0.5, 0.0, 0.0);
        state.velocity[2] = Vec3::y() * speed;
        assert_eq!(sheet.value(&state.position), f64::INFINITY);
        let mut stepper =
            Stepper::new(point_masses(&[1.0; 3]), PointMap::identity(3), options(TimeScheme::BackwardEuler));
        let error = stepper.step(&mut state, &mut [&mut sheet], 0.1).unwrap_err();
        assert!(chain(&error).contains("element 0"), "{}", chain(&error));
    }
}

/// Two points that are one unknown move together, which an explicit scheme does not do: it refuses.
#[test]
fn explicit_schemes_refuse_points_tied_together() {
    let map = PointMap::new(1, [PointSource::Unknown(0), PointSource::Unknown(0)]).unwrap();
    let tied = ExplicitStepper::new(ExplicitScheme::SymplecticEuler, point_masses(&[1.0, 2.0]), map);
    assert!(tied.is_err());
}

/// Nothing that lags: one minimisation has settled it.
#[test]
fn a_step_without_lagged_terms_is_settled_at_once() {
    let (mut spring, mass, mut state) = pair();
    let options = StepperOptions { lagging: Lagging::Until(1), ..options(TimeScheme::BackwardEuler) };
    let mut stepper = Stepper::new(mass, PointMap::identity(2), options);
    let report = stepper.step(&mut state, &mut [&mut spring], 0.1).unwrap();
    assert_eq!(report.lag_iterations, 1);
}

#[test]
fn masses_that_are_none_are_refused_by_element() {
    let negative = [[-1.0, 1.0], [1.0, -1.0]];
    type Case = (&'static str, [[f64; 2]; 2], [u32; 2]);
    let cases: [Case; 4] = [
        ("negative diagonal", [[-1.0, 2.0], [2.0, -1.0]], [0, 1]),
        ("rigid", negative, [0, 1]),
        ("coupling", [[1.0, f64::NAN], [f64::NAN, 1.0]], [0, 1]),
        ("repeated", [[1.0, 0.5], [0.5, 1.0]], [1, 1]),
    ];
    for (case, local, corners) in cases {
        for distribution in [MassDistribution::Lumped, MassDistribution::Consistent] {
            let mut mass = Mass::zeros(2);
            let outcome = mass.add_elements(&[corners], distribution, |_| local);
            assert!(outcome.is_err(), "{case} {distribution:?}");
            assert!(outcome.unwrap_err().to_string().contains("element 0"), "{case}");
            assert_eq!(mass, Mass::zeros(2));
        }
    }
}

/// Four points in a plane, as far as their coordinates can say: the volume is rounding.
#[test]
fn a_tetrahedron_whose_volume_is_rounding_is_refused() {
    let law = NeoHookean::new(Lame::from_young_poisson(1e5, 0.3).unwrap());
    let (u, v) = (Vec3::new(0.1, 0.7, 0.3), Vec3::new(0.9, 0.2, 0.6));
    let mut positive = 0;
    for k in 1..40 {
        let (s, t) = (0.037 * f64::from(k), 0.91 - 0.053 * f64::from(k));
        let points = [Vec3::zeros(), u, v, u * s + v * t];
        positive += u32::from(tet_volume(&points) > 0.0);
        let mut mass = Mass::zeros(4);
        let cells = [[0, 1, 2, 3]];
        assert!(Tetrahedra::new(law, &points, &cells).is_err(), "{:e}", tet_volume(&points));
        let added = mass.add_tetrahedra(&points, &cells, 1000.0, MassDistribution::Lumped);
        assert!(added.is_err(), "{:e}", tet_volume(&points));
    }
    assert!(positive > 3, "some roundings are upwards");
    // Thin is not flat: a needle of 1 µm and a sliver of a thousandth of a degree are taken.
    let needle = [Vec3::zeros(), Vec3::x(), Vec3::new(1e-6, 1e-6, 0.0), Vec3::new(0.0, 0.0, 1e-6)];
    assert!(Tetrahedra::new(law, &needle, &[[0, 1, 2, 3]]).is_ok());
    let sliver = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::new(1.0, 1.0, 1e-5)];
    assert!(Tetrahedra::new(law, &sliver, &[[0, 1, 2, 3]]).is_ok());
}

/// A table that does not ascend, or holds what is no number, is named when the step begins.
#[test]
fn tables_of_amplitudes_are_checked() {
    let tables = [
        vec![(0.0, 1.0), (2.0, 0.0), (1.0, 1.0)],
        vec![(0.0, 1.0), (f64::NAN, 0.0)],
        vec![(0.0, f64::INFINITY)],
    ];
    for table in tables {
        let (mut spring, mass, mut state) = pair();
        let load = DeadLoad::new("push", vec![(0, Vec3::x())]).unwrap();
        let mut load = load.with_amplitude(Amplitude::Table(table.clone()));
        let mut stepper = Stepper::new(mass, PointMap::identity(2), options(TimeScheme::BackwardEuler));
        let before = state.hash();
        let error = stepper.step(&mut state, &mut [&mut spring, &mut load], 0.1).unwrap_err();
        assert!(chain(&error).contains("push") && chain(&error).contains("table"), "{}", chain(&error));
        assert_eq!(state.hash(), before);
    }
}

/// A rest shape folded flat has the rest angle π, where tan(θ/2) has no value.
#[test]
fn a_plate_folded_flat_at_rest_is_refused() {
    let points = vec![Vec3::zeros(), Vec3::x(), Vec3::new(0.4, 1.0, 0.0), Vec3::new(0.6, 1.0, 0.0)];
    let mesh = TriMesh::new(points, vec![[0, 1, 2], [1, 0, 3]]).unwrap();
    let plate = |rest| PlateBending::new("plate", &mesh, 1e6, 0.3, 1e-3, rest);
    let error = plate(RestAngle::OfMesh).unwrap_err();
    assert!(error.to_string().contains("fold"), "{error}");
    plate(RestAngle::Flat).unwrap();
}

/// After a failure the plate says which of its elements pulls most: they are counted list after list.
#[test]
fn a_plate_locates_its_elements() {
    let points = vec![Vec3::zeros(), Vec3::x(), Vec3::new(0.4, 1.0, 0.2), Vec3::new(0.6, -1.0, 0.3)];
    let mesh = TriMesh::new(points.clone(), vec![[0, 1, 2], [1, 0, 3]]).unwrap();
    let plate = PlateBending::new("plate", &mesh, 1e6, 0.3, 1e-3, RestAngle::Flat).unwrap();
    assert!(plate.locate(&points, 2).is_some());
}

/// A constraint may name any particle; only a step knows how many there are.
#[test]
fn a_particle_of_the_largest_number_costs_no_memory() {
    let points = [Vec3::zeros(), Vec3::x()];
    let distances = Distances::new(&points, &[[0, 1]]).unwrap();
    let mut group = ConstraintGroup::new("far", distances, vec![[0, u32::MAX]], Response::rigid(1)).unwrap();
    let mut particles = Particles::new(points.to_vec(), vec![1.0; 2]).unwrap();
    let solver = PositionBased { iterations: 1, acceleration: Vec3::zeros() };
    assert!(solver.step(&mut particles, &mut [&mut group], 0.1).is_err());
}

/// A force on a point that does not exist used to panic when the energy was evaluated.
#[test]
fn a_load_on_a_point_that_does_not_exist_is_refused() {
    let (mut spring, mass, mut state) = pair();
    let mut load = DeadLoad::new("push", vec![(1, Vec3::x()), (2, Vec3::x())]).unwrap();
    let before = state.hash();
    let mut stepper = Stepper::new(mass.clone(), PointMap::identity(2), options(TimeScheme::BackwardEuler));
    let error = stepper.step(&mut state, &mut [&mut spring, &mut load], 0.1).unwrap_err();
    assert!(chain(&error).contains("push") && chain(&error).contains("vertex 2"), "{}", chain(&error));
    let explicit =
        ExplicitStepper::new(ExplicitScheme::SymplecticEuler, mass, PointMap::identity(2)).unwrap();
    let error = explicit.step(&mut state, &mut [&mut spring, &mut load], 0.1).unwrap_err();
    assert!(chain(&error).contains("vertex 2"), "{}", chain(&error));
    assert_eq!(state.hash(), before);
}

#[test]
fn an_explicit_stepper_needs_something_to_move() {
    let (_, mass, state) = pair();
    let fixed: Vec<(u32, Vec3)> = (0..).zip(state.position.iter().copied()).collect();
    let map = PointMap::with_fixed(2, &fixed).unwrap();
    let error = ExplicitStepper::new(ExplicitScheme::CentralDifferences, mass, map).unwrap_err();
    assert!(matches!(error, StepError::NothingToSolve { points: 2 }), "{error}");
}

/// A grid of springs, either along its rows or along its columns, with a few across: other elements, the same name.
fn grid(along: [usize; 2]) -> (mechanics_core::stencil::StencilTerm<Springs, 2>, Vec<Vec3>) {
    const SIDE: usize = 12;
    let number = |i: usize, j: usize| (SIDE * i + j) as u32;
    let mut points = Vec::new();
    for i in 0..SIDE {
        points.extend((0..SIDE).map(|j| Vec3::new(i as f64, j as f64, 0.1 * ((i * j) as f64).sin())));
    }
    let mut springs = Vec::new();
    for (i, j) in (0..SIDE).flat_map(|i| (0..SIDE).map(move |j| (i, j))) {
        let far = [i + along[0], j + along[1]];
        if far[0] < SIDE && far[1] < SIDE {
            springs.push([number(i, j), number(far[0], far[1])]);
        }
        if j + 1 < SIDE && (i + j) % 3 == 0 {
            springs.push([number(i, j), number(i, j + 1)]);
        }
    }
    (Springs::term("springs", 100.0, &points, springs).unwrap(), points)
}

/// The order of elimination belongs to the elements, not to the names of terms: a stepper that has moved other springs of the
/// same name makes the same bits as a new one.
#[test]
fn terms_of_the_same_name_do_not_share_an_order() {
    let (mut rows, points) = grid([2, 3]);
    let (mut columns, _) = grid([5, 1]);
    let mass = point_masses(&vec![1.0; points.len()]);
    let stepper = || Stepper::new(mass.clone(), PointMap::identity(144), options(TimeScheme::BackwardEuler));
    let moving = || {
        let mut state = State::at_rest(points.clone());
        state.velocity.iter_mut().zip(0..).for_each(|(v, i)| *v = Vec3::new(f64::from(i).sin(), 0.3, 0.1));
        state
    };
    let (mut used, mut fresh) = (stepper(), stepper());
    used.step(&mut moving(), &mut [&mut rows], 0.1).unwrap();
    let (mut one, mut other) = (moving(), moving());
    used.step(&mut one, &mut [&mut columns], 0.1).unwrap();
    fresh.step(&mut other, &mut [&mut columns], 0.1).unwrap();
    assert_eq!(one.hash(), other.hash());
}

/// Two springs in line, pressed or pulled: pressed, the middle would leave the line if anything pushed it, and the start is a saddle
/// whose gradient vanishes exactly.
#[test]
fn an_equilibrium_says_whether_it_is_a_minimum() {
    for (length, expected) in [(0.8, Minimum::NotDefinite), (1.25, Minimum::Strict)] {
        let rest = vec![Vec3::zeros(), Vec3::x(), Vec3::x() * 2.0];
        let mut springs = Springs::term("springs", 100.0, &rest, vec![[0, 1], [1, 2]]).unwrap();
        let points: Vec<Vec3> = rest.iter().map(|x| x * length).collect();
        let map = PointMap::with_fixed(3, &[(0, points[0]), (2, points[2])]).unwrap();
        let mut stepper = Stepper::new(Mass::zeros(3), map, options(TimeScheme::BackwardEuler));
        let mut state = State::at_rest(points.clone());
        let report = stepper.equilibrium(&mut state, &mut [&mut springs], 1).unwrap();
        assert_eq!(report.minimum, expected);
        assert_eq!(state.position, points);
    }
}

/// A stiff chain on soft supports: rounding of the stiff forces moves the soft ones by more than the tolerance asks for. What was 100
/// iterations and an error is a minimum, as good as it can be told.
#[test]
fn a_tolerance_below_rounding_is_met_as_well_as_it_can_be() {
    let n = 30;
    let points: Vec<Vec3> = (0..n).map(|i| Vec3::x() * (1e3 + f64::from(i))).collect();
    let pairs = (1..n as u32).map(|i| [i - 1, i]).collect();
    let mut stiff = Springs::term("stiff", 1e9, &points, pairs).unwrap();
    let targets = points.iter().map(|x| x + Vec3::new(0.1, 0.2, 0.3)).collect();
    let held: Vec<u32> = (0..n as u32).collect();
    let mut soft = Attachments::term("soft", 1e-3, &held, targets).unwrap();
    let newton = NewtonOptions { tolerance: 1e-15, ..Default::default() };
    let options = StepperOptions { newton, ..Default::default() };
    let mut stepper = Stepper::new(Mass::zeros(n as usize), PointMap::identity(n as usize), options);
    let mut state = State::at_rest(points.clone());
    let report = stepper.equilibrium(&mut state, &mut [&mut stiff, &mut soft], 1).unwrap();
    assert!(report.newton.at_rounding == 1 && report.newton.iterations < 15, "{:?}", report.newton);
    // Forces of ε · 1e9 · 1e3 N over thirty supports of 1e-3 N/m.
    for (x, start) in state.position.iter().zip(&points) {
        assert!((x - start - Vec3::new(0.1, 0.2, 0.3)).norm() < 0.1, "{x}");
    }
    let newton = NewtonOptions { tolerance: 1e-2, ..Default::default() };
    let options = StepperOptions { newton, ..Default::default() };
    let mut stepper = Stepper::new(Mass::zeros(n as usize), PointMap::identity(n as usize), options);
    let mut state = State::at_rest(points);
    let report = stepper.equilibrium(&mut state, &mut [&mut stiff, &mut soft], 1).unwrap();
    assert_eq!(report.newton.at_rounding, 0);
}
