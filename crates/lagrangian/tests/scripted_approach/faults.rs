//! Terms that lie while scripted points are drawn to their targets.

use crate::Press;
use crate::lying::{LIES, Lying, Step, Switch, every_answer_in_turn};
use lagrangian::stepper::TimeScheme;
use mechanics_core::state::State;
use std::sync::Arc;

/// A plate that must push a cube before it.
#[test]
fn pulls_see_through_every_lie() {
    let scene = |switch: &Arc<Switch>| -> Step {
        let press = Press::of(1);
        let mut stepper = press.stepper(TimeScheme::BackwardEuler, 1e-9);
        stepper.set_target(press.plate, press.target(0.9)).unwrap();
        let (mut elastic, mut heights) =
            (Lying::new(press.elastic, switch), Lying::new(press.heights, switch));
        Box::new(move |state| {
            let made = stepper.step(state, &mut [&mut elastic, &mut heights], 0.02);
            let pulls = made.map_err(|error| error.to_string())?.pulls;
            assert!(pulls > 0, "the plate is not pulled");
            Ok(())
        })
    };
    let start = State::at_rest(Press::of(1).start);
    let tally = every_answer_in_turn("pull", &LIES, &start, 1e-8, scene);
    assert!(tally.errors > 50 && tally.survived > 10, "{tally:?}");
}
