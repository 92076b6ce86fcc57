//! Friction in statics, in Newmark's scheme, and of area-weighted contact.

use crate::scene::{
    ACTIVATION, Bodies, GRAVITY, Particle, cube, glancing_blow, gravity_on_slope, mu, options, stepping,
};
use ipc_contact::contact::ContactOptions;
use ipc_contact::contact_set::Weighting;
use ipc_contact::stiffness::{Scale, Stiffness};
use lagrangian::element::{Amplitude, Attachments, DeadLoad};
use lagrangian::stepper::{Lagging, StepperOptions, TimeScheme};
use mechanics_core::tensor::Vec3;

const MU: f64 = 0.5;

/// In statics εᵥ is a length, and every part of the load begins its slip anew.
#[test]
fn a_load_that_friction_holds_moves_it_by_the_creep_of_every_part() {
    for (length, parts) in [(1e-3, 1), (1e-3, 7), (1e-5, 4)] {
        let stepping = stepping(1e-10 * length, Lagging::Until(5));
        let mut particle = Particle::on_slope(0.0, options(mu(MU), length), stepping);
        let load = 0.9 * MU * GRAVITY;
        let pull = DeadLoad::new("pull", vec![(0, Vec3::x() * load)]).unwrap();
        let mut pull = pull.with_amplitude(Amplitude::Ramp);
        let Particle { contact, gravity, stepper, state } = &mut particle;
        stepper.equilibrium(state, &mut [gravity, contact, &mut pull], parts).unwrap();
        let part = |k: u32| length * (1.0 - (1.0 - 0.9 * f64::from(k) / f64::from(parts)).sqrt());
        let expected: f64 = (1..=parts).map(part).sum();
        let found = state.position[0].x;
        assert!((found / expected - 1.0).abs() < 1e-8, "{length} {parts}: {found} {expected}");
    }
}

#[test]
fn what_slides_in_statics_stops_where_the_spring_holds_the_rest_and_stays_when_the_load_is_gone() {
    let (stiffness, length) = (100.0, 1e-5);
    let stepping = stepping(1e-14, Lagging::Until(5));
    let mut particle = Particle::on_slope(0.0, options(mu(MU), length), stepping);
    let start = particle.state.position[0];
    let mut spring = Attachments::term("spring", stiffness, &[0], vec![start]).unwrap();
    let bound = MU * GRAVITY;
    let Particle { contact, gravity, stepper, state } = &mut particle;

    let mut pull = DeadLoad::new("pull", vec![(0, Vec3::x() * (1.5 * bound))]).unwrap();
    stepper.equilibrium(state, &mut [gravity, contact, &mut pull, &mut spring], 1).unwrap();
    let slid = state.position[0].x;
    assert!((slid - 0.5 * bound / stiffness).abs() < 1e-10, "{slid}");
    let report = contact.report(&state.position).unwrap();
    assert!((report.dissipated - bound * slid).abs() < 1e-9 && report.sticking == 0, "{report:?}");

    // The spring now pulls back with half of what friction can hold.
    stepper.equilibrium(state, &mut [gravity, contact, &mut spring], 1).unwrap();
    let back = slid - state.position[0].x;
    let held = stiffness * state.position[0].x / bound;
    assert!((back / (length * (1.0 - (1.0 - held).sqrt())) - 1.0).abs() < 1e-6, "{back}");
    assert_eq!(contact.report(&state.position).unwrap().sticking, 1);
}

#[test]
fn newmark_slides_exactly_and_creeps_as_the_closed_form_says() {
    let scheme = TimeScheme::Newmark;
    let (angle, h, steps) = (0.3f64, 0.01, 40);
    let newmark = |tolerance: f64| StepperOptions { scheme, ..stepping(tolerance, Lagging::Until(5)) };
    // A constant acceleration is integrated without error.
    let mut sliding = Particle::on_slope(angle, options(mu(0.2), 1e-4), newmark(1e-11));
    sliding.state.velocity[0] = Vec3::new(0.3, 0.4, 0.0);
    let (mut velocity, mut dissipated) = (sliding.velocity(), 0.0);
    for _ in 0..steps {
        sliding.step(h);
        let report = sliding.contact.report(&sliding.state.position).unwrap();
        dissipated += report.dissipated;
        // Friction at both ends of the step, each along its own velocity: by hand.
        let slip = |v: Vec3| -v.normalize() * (0.2 * GRAVITY * angle.cos());
        let weight = Vec3::x() * (GRAVITY * angle.sin());
        let mut end = velocity;
        for _ in 0..100 {
            end = velocity + (weight * 2.0 + slip(velocity) + slip(end)) * (0.5 * h);
        }
        velocity = end;
    }
    assert!((sliding.velocity() - velocity).norm() < 1e-8, "{} {velocity}", sliding.velocity());
    assert!(dissipated > 0.0);

    let stick_velocity = 0.05;
    let mut sticking = Particle::on_slope(angle, options(mu(0.5), stick_velocity), newmark(1e-13));
    for _ in 0..200 {
        sticking.step(h);
    }
    let expected = stick_velocity * (1.0 - (1.0 - angle.tan() / 0.5).sqrt());
    assert!((sticking.velocity().x / expected - 1.0).abs() < 1e-6, "{}", sticking.velocity());
}

fn area_weighted() -> ContactOptions {
    let load = Stiffness::fixed(Scale::Load(2000.0));
    ContactOptions { weighting: Weighting::Area, ..ContactOptions::new(ACTIVATION, load) }
}

/// Corners, edges and the middle of the cube's face stand for different areas, and all creep alike.
#[test]
fn an_area_weighted_block_creeps_like_a_particle() {
    let (angle, coefficient, stick_velocity) = (0.35f64, 0.5, 1e-3);
    let meshes = [cube(2, Vec3::z() * 6e-4)];
    let friction = options(mu(coefficient), stick_velocity);
    let stepping = stepping(1e-10, Lagging::Until(60));
    let gravity = Some(gravity_on_slope(angle));
    let mut block = Bodies::with_contact(&meshes, gravity, friction, stepping, area_weighted());
    for _ in 0..400 {
        block.step(0.02);
    }
    let bounds: Vec<f64> = block.contact.pairs(&block.state.position).iter().map(|pair| pair.bound).collect();
    let [least, most] = [f64::min, f64::max].map(|pick| bounds.iter().copied().fold(bounds[0], pick));
    assert!(bounds.len() == 9 && most > 2.0 * least, "{bounds:?}");
    let expected = stick_velocity * (1.0 - (1.0 - angle.tan() / coefficient).sqrt());
    let velocity = block.mean_velocity();
    assert!((velocity.x / expected - 1.0).abs() < 1e-5, "{velocity} {expected}");
}

#[test]
fn area_weighted_friction_conserves_momentum() {
    let plain = glancing_blow(0.4, Lagging::Until(60));
    let meshes = [cube(3, Vec3::zeros()), cube(3, Vec3::new(0.02, 0.01, 0.1015))];
    let stepping = stepping(1e-8, Lagging::Until(100));
    let mut bodies = Bodies::with_contact(&meshes, None, options(mu(0.4), 1e-3), stepping, area_weighted());
    bodies.state.velocity = plain.state.velocity;
    let (before, mut dissipated) = (bodies.momentum(), 0.0);
    for _ in 0..30 {
        bodies.step(1e-3);
        dissipated += bodies.contact.report(&bodies.state.position).unwrap().dissipated;
    }
    assert!((bodies.momentum() - before).norm() < 1e-13, "{}", bodies.momentum() - before);
    assert!(dissipated > 1e-3, "{dissipated}");
}
