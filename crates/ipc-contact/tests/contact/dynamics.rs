//! Scenes in motion against closed forms and conservation laws.

use crate::scene::{DENSITY, GRAVITY, Units, World, cube, join, join_with};
use ipc_contact::collision_mesh::{HalfSpace, SelfContact};
use ipc_contact::contact::{BarrierContact, BarrierForm, ContactOptions};
use ipc_contact::contact_set::Weighting;
use ipc_contact::stiffness::{Scale, Stiffness};
use lagrangian::stepper::StepperOptions;
use mechanics_core::newton::NewtonOptions;
use mechanics_core::objective::Projecting;
use mechanics_core::parallel;
use mechanics_core::tensor::Vec3;

fn stepping(tolerance: f64) -> StepperOptions {
    let newton = NewtonOptions { tolerance, ..Default::default() };
    StepperOptions { newton, projecting: Projecting::OnDemand, ..Default::default() }
}

/// One cube of 1 kg flies into another with 1 m/s, off centre.
fn collision(stiffness: Stiffness, units: Units, options: StepperOptions) -> World {
    collision_with(ContactOptions::new(1e-3 * units.length, stiffness), units, options)
}

fn collision_with(contact: ContactOptions, units: Units, options: StepperOptions) -> World {
    let mut bodies = [cube(3, Vec3::zeros()), cube(3, Vec3::new(0.04, 0.02, 0.103))];
    bodies.iter_mut().for_each(|body| body.scale(units.length).unwrap());
    let second = bodies[0].points().len();
    let (all, mesh) = join(&bodies, None);
    let contact = BarrierContact::new(mesh, contact).unwrap();
    let mut world = World::new(&all, contact, units, options);
    world.state.velocity[second..].fill(Vec3::new(0.0, 0.0, -units.length / units.time));
    world
}

#[test]
fn a_collision_conserves_momentum_and_lets_nothing_through() {
    let stiffness = Stiffness::adaptive(Scale::Load(1.0));
    let mut world = collision(stiffness, Units::SI, stepping(1e-9));
    let [linear, _] = world.momenta();
    let mut contacts = 0;
    for _ in 0..20 {
        world.step(2e-3);
        contacts = contacts.max(world.contact.report().contacts.total());
    }
    assert!(contacts > 20);
    let [after, _] = world.momenta();
    assert!((after - linear).norm() < 1e-13, "{}", after - linear);
    // The pushed cube has taken most of the momentum: it rests no more.
    let pushed: Vec3 = world.state.velocity[..64].iter().sum();
    assert!(pushed.z < -0.4 * 64.0, "{pushed}");
}

#[test]
fn with_area_weights_and_a_thickness_a_collision_conserves_momentum_too() {
    // A pressure of half of Young's modulus times d̂ over the length of an edge.
    let stiffness = Stiffness::adaptive(Scale::Load(1.5e3));
    let options = ContactOptions {
        weighting: Weighting::Area,
        form: BarrierForm::Physical,
        minimum_separation: 1e-3,
        ..ContactOptions::new(1e-3, stiffness)
    };
    let mut world = collision_with(options, Units::SI, stepping(1e-7));
    let [linear, _] = world.momenta();
    let mut smallest = f64::INFINITY;
    for _ in 0..20 {
        world.step(2e-3);
        smallest = smallest.min(world.contact.report().smallest_distance.unwrap_or(f64::INFINITY));
    }
    assert!(smallest > 1e-3 && smallest < 2e-3, "{smallest}");
    let [after, _] = world.momenta();
    assert!((after - linear).norm() < 1e-12, "{}", after - linear);
    let pushed: Vec3 = world.state.velocity[..64].iter().sum();
    assert!(pushed.z < -0.4 * 64.0, "{pushed}");
}

/// A cube let down on the floor until it rests: steps end at displacements below 1e-13 m.
fn resting(h: f64, steps: u32) -> (World, f64) {
    let load = 0.5;
    let body = cube(2, Vec3::new(0.0, 0.0, 8e-4));
    let floor = HalfSpace::through(&Vec3::zeros(), &Vec3::z());
    let (all, mesh) = join(&[body], Some(floor));
    let options = ContactOptions::new(1e-3, Stiffness::fixed(Scale::Load(load)));
    let contact = BarrierContact::new(mesh, options).unwrap();
    let mut world = World::new(&all, contact, Units::SI, stepping(1e-13 / h)).with_gravity(Units::SI);
    for _ in 0..steps {
        world.step(h);
    }
    let kappa = world.contact.stiffness();
    (world, kappa)
}

#[test]
fn a_resting_block_has_the_gap_of_the_force_balance_whatever_the_time_step() {
    let weight = DENSITY * 1e-3 * GRAVITY;
    let mut gaps: Vec<Vec<f64>> = Vec::new();
    for (h, steps) in [(0.1, 40), (0.01, 150), (0.3, 40)] {
        let (world, kappa) = resting(h, steps);
        // −κ ∂/∂d of −(d² − d̂²)² ln(d²/d̂²), summed over the points at the bottom.
        let hat: f64 = 1e-6;
        let push = |d: f64| {
            let s = d * d;
            kappa * 2.0 * d * (2.0 * (s - hat) * (s / hat).ln() + (s - hat).powi(2) / s)
        };
        let bottom: Vec<f64> = world.state.position.iter().map(|x| x.z).filter(|&z| z < 1e-3).collect();
        assert_eq!(bottom.len(), 9);
        let carried: f64 = bottom.iter().map(|&d| push(d)).sum();
        assert!((carried / weight - 1.0).abs() < 1e-9, "h = {h}: {carried} N carry {weight} N");
        gaps.push(bottom);
    }
    for other in &gaps[1..] {
        for (a, b) in gaps[0].iter().zip(other) {
            assert!((a - b).abs() < 1e-9 * 1e-3, "{a} {b}");
        }
    }
}

#[test]
fn the_same_scene_in_other_units_moves_the_same() {
    let run = |units: Units| {
        // One newton at half of the activation distance, whatever the units.
        let stiffness = Stiffness::adaptive(Scale::Load(units.force()));
        let mut world = collision(stiffness, units, stepping(1e-9 * units.length / units.time));
        for _ in 0..10 {
            world.step(2e-3 * units.time);
        }
        let positions: Vec<Vec3> = world.state.position.iter().map(|x| x / units.length).collect();
        (positions, world.contact.report())
    };
    let (si, report) = run(Units::SI);
    let (milli, other) = run(Units::MILLI);
    assert!(report.contacts.total() > 0);
    assert_eq!(report.contacts, other.contacts);
    for (a, b) in si.iter().zip(&milli) {
        assert!((a - b).norm() < 1e-9, "{a} {b}");
    }
}

#[test]
fn a_collision_has_the_same_bits_for_any_number_of_threads() {
    let run = |threads: usize| {
        parallel::with_threads(threads, || {
            let stiffness = Stiffness::adaptive(Scale::Load(1.0));
            let mut world = collision(stiffness, Units::SI, stepping(1e-6));
            (0..6).for_each(|_| drop(world.step(2e-3)));
            (world.state.hash(), world.contact.report())
        })
    };
    let one = run(1);
    assert!(one.1.contacts.total() > 0);
    for threads in [2, 3, 8] {
        assert_eq!(run(threads), one, "{threads} threads");
    }
}

#[test]
fn bits_of_a_step_depend_on_the_state_and_the_stiffness_alone() {
    let stiffness = Stiffness::adaptive(Scale::Load(1e-3));
    let mut world = collision(stiffness, Units::SI, stepping(1e-6));
    (0..4).for_each(|_| drop(world.step(2e-3)));
    let (state, kappa) = (world.state.clone(), world.contact.saved_stiffness(&world.state.position));
    (0..3).for_each(|_| drop(world.step(2e-3)));
    let mut resumed = collision(stiffness, Units::SI, stepping(1e-6));
    resumed.state = state;
    resumed.contact.resume_stiffness(kappa).unwrap();
    (0..3).for_each(|_| drop(resumed.step(2e-3)));
    assert_eq!(resumed.state.hash(), world.state.hash());
    assert!(kappa.kappa > stiffness_at_first(stiffness), "κ grew: the case is not trivial");
}

fn stiffness_at_first(stiffness: Stiffness) -> f64 {
    collision(stiffness, Units::SI, stepping(1e-6)).contact.stiffness()
}

#[test]
fn without_contact_nothing_is_searched_or_detected() {
    let bodies = [cube(2, Vec3::zeros()), cube(2, Vec3::new(0.0, 0.0, 1.0))];
    for self_contact in [SelfContact::Allowed, SelfContact::Excluded] {
        let (all, mesh) = join_with(&bodies, None, self_contact);
        let options = ContactOptions::new(1e-3, Stiffness::adaptive(Scale::Load(1.0)));
        let contact = BarrierContact::new(mesh, options).unwrap();
        let mut world = World::new(&all, contact, Units::SI, stepping(1e-6)).with_gravity(Units::SI);
        for step in 0..5 {
            world.step(0.01);
            let report = world.contact.report();
            assert_eq!(report.contacts.total(), 0);
            // Bodies that fall together stay in the neighbourhood they were found in.
            assert!(step == 0 || report.searches == 0, "{report:?}");
            // Neighbours within a body are candidates, because boxes are; between bodies there are none.
            assert!(self_contact == SelfContact::Allowed || report.detection_queries == 0, "{report:?}");
        }
    }
}
