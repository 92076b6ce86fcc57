//! Events against exact times.

use crate::systems::{FreeFall, Kepler, Oscillator, Pendulum, of};
use lagrangian::integrator::{Crossing, Direction, DormandPrince853, Event, Outcome, Tolerance};
use lagrangian::{EulerLagrange, Lagrangian, Phase};
use std::f64::consts::PI;

fn method<const N: usize, L: Lagrangian<N>>(system: &EulerLagrange<L, N>) -> DormandPrince853<[f64; N]> {
    DormandPrince853::new(system).with_tolerance(Tolerance::uniform(1e-15)).unwrap()
}

#[test]
fn a_pendulum_turns_after_half_its_period() {
    let path = format!("{}/tests/fixtures/pendulum_periods.json", env!("CARGO_MANIFEST_DIR"));
    let file: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    for entry in file["periods"].as_array().unwrap() {
        let amplitude = entry["theta0"].as_f64().unwrap();
        let period: f64 = entry["period_s"].as_str().unwrap().parse().unwrap();
        let system = of(Pendulum);
        let mut phase = Phase::new(0.0, [amplitude], [0.0]);
        let mut events = [Event::new(|_, _, v: &[f64; 1]| v[0])];
        let (located, _) = method(&system).locate(&system, &mut phase, 2.2 * period, &mut events).unwrap();
        assert_eq!(located.len(), 4, "amplitude {amplitude}: the start is a root that does not count");
        for (k, event) in located.iter().enumerate() {
            let exact = 0.5 * period * (k + 1) as f64;
            // Near the top the period is ill-conditioned: dT/dθ₀ = 2/ω/(π − θ₀) there, and dE/dθ₀ = g sin θ₀; of
            // the 20 J that pass through the bottom, rounding and tolerance may take 5e-15.
            let slope = 2.0 / 9.81_f64.sqrt() / (PI - amplitude) / (9.81 * amplitude.sin());
            let allowed = 1e-14 + 20.0 * 5e-15 * slope / period;
            let error = (event.phase.time - exact).abs() / exact;
            assert!(error < allowed, "amplitude {amplitude}, turn {k}: error {error:e}, allowed {allowed:e}");
            assert_eq!(event.crossing, if k % 2 == 0 { Crossing::Rising } else { Crossing::Falling });
            let side = if k % 2 == 0 { -amplitude } else { amplitude };
            let allowed = 1e-13 + 20.0 * 5e-15 / (9.81 * amplitude.sin());
            assert!((event.phase.q[0] - side).abs() < allowed, "amplitude {amplitude}, turn {k}");
        }
    }
}

#[test]
fn a_falling_mass_lands() {
    let system = of(FreeFall);
    let mut phase = Phase::new(0.0, [2.0], [3.0]);
    let mut events =
        [Event::new(|_, q: &[f64; 1], _| q[0]).terminal(), Event::new(|_, _, v: &[f64; 1]| v[0])];
    let (located, report) = method(&system).locate(&system, &mut phase, 100.0, &mut events).unwrap();
    let landing = (3.0 + (9.0_f64 + 4.0 * 9.81).sqrt()) / 9.81;
    assert_eq!(report.outcome, Outcome::Event);
    assert_eq!(located.iter().map(|e| e.event).collect::<Vec<_>>(), [1, 0], "the summit comes first");
    assert!((located[0].phase.time - 3.0 / 9.81).abs() < 1e-15);
    assert!((located[1].phase.time - landing).abs() < 4e-15);
    assert_eq!(located[1].phase, phase);
    assert!((phase.v[0] - (3.0 - 9.81 * landing)).abs() < 1e-14);
    // Thrown up again from where it landed: the landing does not happen twice.
    phase.v[0] = 3.0;
    phase.q[0] = 0.0;
    let (again, _) = method(&system).locate(&system, &mut phase, 100.0, &mut events[..1]).unwrap();
    assert_eq!(again.len(), 1);
    assert!((again[0].phase.time - landing - 6.0 / 9.81).abs() < 4e-15);
}

#[test]
fn an_orbit_passes_its_apsides() {
    let system = of(Kepler);
    let mut phase = Phase::new(0.0, [0.4, 0.0], [0.0, 2.0]);
    let radial = |_: f64, q: &[f64; 2], v: &[f64; 2]| q[0] * v[0] + q[1] * v[1];
    let mut events = [
        Event::new(radial).in_direction(Direction::Falling),
        Event::new(radial).in_direction(Direction::Rising),
    ];
    let (located, _) = method(&system).locate(&system, &mut phase, 20.0 * PI + 0.1, &mut events).unwrap();
    assert_eq!(located.len(), 20);
    for (k, event) in located.iter().enumerate() {
        let exact = PI * (k + 1) as f64;
        assert!((event.phase.time - exact).abs() < 2e-12, "apsis {k}: {:e}", event.phase.time - exact);
        // Apocentre, pericentre, apocentre, …
        assert_eq!(event.event, k % 2);
        let radius = event.phase.q[0].hypot(event.phase.q[1]);
        let expected = if k % 2 == 0 { 1.6 } else { 0.4 };
        assert!((radius - expected).abs() < 1e-12);
    }
}

#[test]
fn all_roots_within_one_step_are_found() {
    // A mass that coasts makes huge steps, in which sin 3t has many roots: steps are at most 1 here, with one root each
    // subinterval at most.
    let system = of(Oscillator(1e-3));
    let mut phase = Phase::new(0.0, [0.0], [1.0]);
    let mut events = [Event::new(|t: f64, _: &[f64; 1], _: &[f64; 1]| (3.0 * t).sin())];
    let mut method = DormandPrince853::new(&system).with_largest_step(2.0).unwrap();
    let (located, report) = method.locate(&system, &mut phase, 100.0, &mut events).unwrap();
    assert!(report.accepted < 60);
    assert_eq!(located.len(), 95);
    for (k, event) in located.iter().enumerate() {
        let exact = PI / 3.0 * (k + 1) as f64;
        assert!((event.phase.time - exact).abs() < 4.0 * f64::EPSILON * exact, "root {k}");
    }
}

#[test]
fn close_pairs_of_roots_are_found() {
    // q = sin t passes 1 − d twice within 2 √(2 d).
    let system = of(Oscillator(1.0));
    for d in [1e-2, 1e-4, 1e-6] {
        let mut phase = Phase::new(0.0, [0.0], [1.0]);
        let mut events = [Event::new(|_, q: &[f64; 1], _| q[0] - (1.0 - d))];
        let (located, _) = method(&system).locate(&system, &mut phase, 6.0, &mut events).unwrap();
        let exact = [(1.0_f64 - d).asin(), PI - (1.0_f64 - d).asin()];
        assert_eq!(located.len(), 2, "d = {d}");
        assert_eq!([located[0].crossing, located[1].crossing], [Crossing::Rising, Crossing::Falling]);
        for (event, exact) in located.iter().zip(exact) {
            // The slope there is √(2 d).
            let allowed = 4e-15 / (2.0 * d).sqrt() + 1e-14;
            assert!((event.phase.time - exact).abs() < allowed, "d = {d}: {:e}", event.phase.time - exact);
        }
    }
}

#[test]
fn grazing_is_a_touch_or_nothing() {
    let system = of(Oscillator(1.0));
    let touching = |level: f64, direction: Direction| {
        let mut phase = Phase::new(0.0, [0.0], [1.0]);
        let mut events = [Event::new(move |_, q: &[f64; 1], _| q[0] - level).in_direction(direction)];
        method(&system).locate(&system, &mut phase, 6.0, &mut events).unwrap().0
    };
    let located = touching(1.0, Direction::Any);
    assert_eq!(located.len(), 1);
    assert_eq!(located[0].crossing, Crossing::Touching);
    // A minimum is found to the root of what its value is known to.
    assert!((located[0].phase.time - 0.5 * PI).abs() < 1e-6);
    assert!(touching(1.0, Direction::Rising).is_empty());
    assert!(touching(1.0 + 1e-8, Direction::Any).is_empty());
}

#[test]
fn an_exact_zero_at_the_end_of_a_step_counts_once() {
    // Rest at q = 0: the function is zero at every time and never leaves it, so nothing happens. Then a function of time that
    // is zero exactly at an end time, where the integration goes on afterwards.
    let system = of(Oscillator(1.0));
    let mut phase = Phase::new(0.0, [0.0], [0.0]);
    let mut at_rest = [Event::new(|_, q: &[f64; 1], _| q[0])];
    assert!(method(&system).locate(&system, &mut phase, 10.0, &mut at_rest).unwrap().0.is_empty());

    let mut phase = Phase::new(0.0, [1.0], [0.0]);
    let mut clock = [Event::new(|t: f64, _: &[f64; 1], _: &[f64; 1]| t - 2.0)];
    let mut method = method(&system);
    let (located, _) = method.locate(&system, &mut phase, 2.0, &mut clock).unwrap();
    assert_eq!(located.len(), 1);
    assert_eq!((located[0].phase.time, located[0].crossing), (2.0, Crossing::Rising));
    assert!(method.locate(&system, &mut phase, 4.0, &mut clock).unwrap().0.is_empty());
}

#[test]
fn a_terminal_event_hides_later_ones() {
    let system = of(Oscillator(1.0));
    let mut phase = Phase::new(0.0, [0.0], [1.0]);
    let mut events = [
        Event::new(|_, q: &[f64; 1], _| q[0] - 0.500_1),
        Event::new(|_, q: &[f64; 1], _| q[0] - 0.5).terminal(),
    ];
    let (located, report) = method(&system).locate(&system, &mut phase, 6.0, &mut events).unwrap();
    assert_eq!(located.len(), 1);
    assert_eq!(report.outcome, Outcome::Event);
    assert!((phase.time - PI / 6.0).abs() < 2e-14, "{:e}", phase.time - PI / 6.0);
}
