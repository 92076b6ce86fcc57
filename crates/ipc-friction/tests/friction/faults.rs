//! Contact with friction that lies, and runs that go on from any tenth step.

use crate::lying::{LIES, Lying, Step, Switch, every_answer_in_turn};
use crate::scene::{ACTIVATION, Bodies, cube, mu, options, stepping};
use ipc_contact::contact::ContactOptions;
use ipc_contact::stiffness::{Scale, Stiffness};
use lagrangian::stepper::Lagging;
use mechanics_core::checkpoint::Checkpoint;
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;
use std::sync::Arc;

/// Two cubes: the upper flies against the lower, down and across.
fn blow(cells: u32, stiffness: Stiffness) -> Bodies {
    let meshes = [cube(cells, Vec3::zeros()), cube(cells, Vec3::new(0.02, 0.01, 0.1015))];
    let contact = ContactOptions::new(ACTIVATION, stiffness);
    let stepping = stepping(1e-9, Lagging::AtMost(3));
    let mut bodies = Bodies::with_contact(&meshes, None, options(mu(0.5), 1e-3), stepping, contact);
    let second = bodies.first[1];
    bodies.state.velocity[second..].fill(Vec3::new(0.8, 0.3, -0.7));
    bodies
}

#[test]
fn steps_in_contact_with_friction_see_through_every_lie() {
    let fixed = || Stiffness::fixed(Scale::Load(2.0));
    let mut before = blow(1, fixed());
    let mut pairs = 0;
    while pairs == 0 {
        before.step(1e-3);
        pairs = before.contact.report(&before.state.position).unwrap().pairs;
    }
    let scene = |switch: &Arc<Switch>| -> Step {
        let Bodies { mut elastic, contact, mut stepper, .. } = blow(1, fixed());
        let mut contact = Lying::new(contact, switch);
        Box::new(move |state| {
            let made = stepper.step(state, &mut [&mut elastic, &mut contact], 1e-3);
            made.map(drop).map_err(|error| error.to_string())
        })
    };
    let tally = every_answer_in_turn("contact with friction", &LIES, &before.state, 1e-8, scene);
    assert!(tally.errors > 50 && tally.survived > 10, "{tally:?}");
}

/// With a stiffness of contact that grows, which is part of what is saved.
#[test]
fn runs_in_contact_resumed_at_every_tenth_step_end_in_the_same_bits() {
    let start = || blow(2, Stiffness::adaptive(Scale::Load(0.1)));
    let steps = 50;
    let mut whole = start();
    let mut snapshots = Vec::new();
    let mut pairs = 0;
    while whole.state.step < steps {
        whole.step(1e-3);
        pairs += whole.contact.report(&whole.state.position).unwrap().pairs;
        if whole.state.step.is_multiple_of(10) {
            let mut checkpoint = Checkpoint::new();
            whole.state.save(&mut checkpoint, "state");
            let stiffness = whole.contact.contact_mut().saved_stiffness(&whole.state.position);
            snapshots.push((checkpoint.to_bytes(), stiffness));
        }
    }
    assert!(pairs > 0, "they touch");
    for (bytes, stiffness) in snapshots {
        let mut checkpoint = Checkpoint::from_bytes(&bytes).unwrap();
        let mut resumed = start();
        resumed.state = State::load(&mut checkpoint, "state").unwrap();
        resumed.contact.contact_mut().resume_stiffness(stiffness).unwrap();
        while resumed.state.step < steps {
            resumed.step(1e-3);
        }
        assert_eq!(resumed.state.hash(), whole.state.hash());
    }
}
