//! Gaps that a tolerance in metres does not resolve.

use ipc_contact::collision_mesh::{CollisionMeshBuilder, CollisionObject, HalfSpace};
use ipc_contact::contact::{BarrierContact, BarrierForm, ContactOptions};
use ipc_contact::stiffness::{Scale, Stiffness};
use lagrangian::element::{DeadLoad, Mass};
use lagrangian::stepper::{StepReport, Stepper, StepperOptions};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::point_map::PointMap;
use mechanics_core::potential::Potential;
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;

const ACTIVATION: f64 = 1e-3;
const MASS: f64 = 2.0;
const GRAVITY: f64 = 9.81;
const STEP: f64 = 0.01;

/// A point above the plane z = 0, or above another point, with this κ in N/m.
fn contact(heights: &[f64], kappa: f64, minimum_separation: f64) -> BarrierContact {
    let rest: Vec<Vec3> = heights.iter().map(|&z| Vec3::z() * z).collect();
    let mut builder = CollisionMeshBuilder::new(&rest);
    let points = (0..rest.len() as u32).collect();
    builder.add_object(CollisionObject { points, ..Default::default() }.with_thickness(1e-3));
    if rest.len() == 1 {
        builder.add_half_space(HalfSpace::through(&Vec3::zeros(), &Vec3::z()));
    }
    let options = ContactOptions {
        form: BarrierForm::Distance,
        minimum_separation,
        ..ContactOptions::new(ACTIVATION, Stiffness::fixed(Scale::Kappa(kappa)))
    };
    BarrierContact::new(builder.build().unwrap(), options).unwrap()
}

/// −κ b′ of −(g − d̂)² ln(g/d̂) \[N\].
fn push(kappa: f64, gap: f64) -> f64 {
    if gap >= ACTIVATION {
        return 0.0;
    }
    let below = gap - ACTIVATION;
    kappa * (2.0 * below * (gap / ACTIVATION).ln() + below * below / gap)
}

/// The gap after a step of backward Euler from rest at `start`: m (g − start)/h² = −m g₀ + push(g), by bisection.
fn balanced(kappa: f64, start: f64) -> f64 {
    let excess = |gap: f64| push(kappa, gap) - MASS * GRAVITY - MASS * (gap - start) / (STEP * STEP);
    let (mut low, mut high) = (1e-300_f64, 1.0_f64);
    for _ in 0..2000 {
        let middle = (low * high).sqrt();
        if excess(middle) > 0.0 { low = middle } else { high = middle }
    }
    low
}

/// A step of a mass at rest at the height `start`; answers its height.
fn settle(kappa: f64, start: f64, tolerance: f64) -> (f64, StepReport) {
    let mut contact = contact(&[start], kappa, 0.0);
    let mut mass = Mass::zeros(1);
    mass.add_point(0, MASS).unwrap();
    let mut gravity = DeadLoad::gravity(&mass, &(Vec3::z() * -GRAVITY)).unwrap();
    let newton = NewtonOptions { tolerance, ..NewtonOptions::default() };
    let options = StepperOptions { newton, ..StepperOptions::default() };
    let mut stepper = Stepper::new(mass, PointMap::identity(1), options);
    let mut state = State::at_rest(vec![Vec3::z() * start]);
    let report = stepper.step(&mut state, &mut [&mut gravity, &mut contact], STEP).unwrap();
    (state.position[0].z, report)
}

/// κ is such that the balanced gap is far below 1 % of d̂; the step begins at a gap far below that, or far above it. A direction of the
/// size of such gaps is below the tolerance by orders of magnitude.
#[test]
fn a_squeezed_gap_is_left_where_its_force_is_balanced() {
    for kappa in [1.0, 30.0, 300.0] {
        for start in [1e-15, 1e-12, 1e-9, 1e-7] {
            let balance = balanced(kappa, start);
            assert!(balance < 0.01 * ACTIVATION || kappa > 200.0, "κ = {kappa}: {balance:e}");
            let (gap, report) = settle(kappa, start, 0.1);
            if balance < 0.009 * ACTIVATION {
                assert!((gap / balance - 1.0).abs() < 0.1, "κ = {kappa}, {start:e}: {gap:e} not {balance:e}");
            } else {
                assert!(gap >= 0.009 * ACTIVATION, "κ = {kappa}, {start:e}: {gap:e} not {balance:e}");
            }
            assert!(start > 1e-9 || report.newton.unsettled > 5, "{:?}", report.newton);
            // Every iteration doubles the gap.
            let doublings = (balance / start).log2().abs();
            assert!((report.newton.iterations as f64) < doublings + 12.0, "{:?}", report.newton);
        }
    }
}

#[test]
fn without_squeezed_gaps_the_tolerance_decides_alone() {
    // The balanced gap is most of d̂; the step begins in it, or without contact.
    let kappa = 1e6;
    let balance = balanced(kappa, 0.5 * ACTIVATION);
    assert!(balance > 0.1 * ACTIVATION, "{balance:e}");
    for start in [0.02 * ACTIVATION, balance, 2.0 * ACTIVATION] {
        let (_, report) = settle(kappa, start, 1.0);
        assert_eq!(report.newton.unsettled, 0, "{start:e}");
    }
}

#[test]
fn contact_objects_to_changes_of_squeezed_gaps_alone() {
    for d_min in [0.0, 5e-4] {
        for (gap, squeezed) in [(1e-9, true), (9e-6, true), (1.1e-5, false), (5e-4, false), (2e-3, false)] {
            let x = [Vec3::z() * (d_min + gap), Vec3::zeros()];
            let contact = contact(&[d_min + gap, 0.0], 1.0, d_min);
            for (part, small) in [(0.09, true), (-0.09, true), (0.11, false), (-0.11, false), (1.0, false)] {
                // The one moves, the other, or both apart.
                for shares in [[1.0, 0.0], [0.0, -1.0], [0.5, -0.5]] {
                    let p = shares.map(|share| Vec3::new(1.0, 2.0, share * part * gap));
                    assert_eq!(contact.is_settled(&x, &p), small || !squeezed, "{gap:e} {part} {shares:?}");
                }
            }
            // Both move together, as far as they like.
            assert!(contact.is_settled(&x, &[Vec3::repeat(1e3); 2]));
        }
    }
}
