//! What a step must not depend on, and what an equilibrium must not claim.

// In a test a panic is the report; the lint spares only functions marked as tests.
#![allow(clippy::unwrap_used)]
// The stepper needs the sparse solvers' feature.
#![cfg(feature = "bodies")]

#[path = "stepper_hostile/faults.rs"]
mod faults;
#[path = "stepper_hostile/law.rs"]
mod law;
#[path = "../../mechanics-core/tests/optimise/lying.rs"]
mod lying;
#[path = "stepper_hostile/resumed.rs"]
mod resumed;

use lagrangian::element::{Mass, Springs};
use lagrangian::stepper::{Minimum, Stepper, StepperOptions};
use mechanics_core::point_map::PointMap;
use mechanics_core::potential::{Changed, Potential, PotentialError};
use mechanics_core::projection::Projection;
use mechanics_core::sparse::Assembler;
use mechanics_core::stage::{Moment, Stage};
use mechanics_core::state::State;
use mechanics_core::tensor::{Mat3, Vec3};

/// Σ ½ k ‖xᵢ − xⱼ‖² over pairs that are chosen anew when a step begins, as those of lagged friction are.
#[derive(Default)]
struct Chosen {
    pairs: Vec<[u32; 2]>,
}

const POINTS: u32 = 80;
const STIFFNESS: f64 = 37.0;

impl Potential for Chosen {
    fn name(&self) -> &'static str {
        "chosen"
    }

    fn value(&self, x: &[Vec3]) -> f64 {
        let lengths = self.pairs.iter().map(|pair| pair.map(|i| x[i as usize]));
        lengths.map(|[a, b]| 0.5 * STIFFNESS * (a - b).norm_squared()).sum()
    }

    fn add_gradient(&self, x: &[Vec3], gradient: &mut [Vec3]) {
        for &[a, b] in &self.pairs {
            let force = (x[a as usize] - x[b as usize]) * STIFFNESS;
            gradient[a as usize] += force;
            gradient[b as usize] -= force;
        }
    }

    fn add_hessian(&self, _: &[Vec3], _: Projection, hessian: &mut Assembler<'_>) {
        let k = Mat3::from_diagonal_element(STIFFNESS);
        hessian.add(&self.pairs, |_| [[k, -k], [-k, k]]);
    }

    /// Steps two and three see the same pairs, the others their own.
    fn freeze(&mut self, stage: &Stage<'_>) -> Result<Changed, PotentialError> {
        if stage.moment != Moment::Step {
            return Ok(Changed::Nothing);
        }
        let factor = [7, 13, 13, 29][((stage.time / STEP).round() as usize - 1).min(3)];
        let pair = |i: u32, k: u32| [i, (i * factor + k) % POINTS];
        let all = (0..POINTS).flat_map(|i| [pair(i, 3), pair(i, 11), pair(i, 40)]);
        self.pairs = all.filter(|[a, b]| a != b).collect();
        Ok(Changed::Energy)
    }
}

const STEP: f64 = 0.1;

/// A run that is resumed from its state, with a new stepper and new terms, repeats the bits of the one that was not: elimination is
/// ordered for the elements that the step has, not for those of the step before.
#[test]
fn a_resumed_run_has_the_bits_of_the_original() {
    let start = |i: u32| Vec3::new(f64::from(i).sin(), f64::from(3 * i).cos(), f64::from(i * i).sin());
    let mut mass = Mass::zeros(POINTS as usize);
    (0..POINTS).for_each(|i| mass.add_point(i, 0.3 + f64::from(i % 7)).unwrap());
    let map = PointMap::identity(POINTS as usize);
    let stepper = || Stepper::new(mass.clone(), map.clone(), StepperOptions::default());
    let mut state = State::at_rest((0..POINTS).map(start).collect());
    let (mut original, mut term) = (stepper(), Chosen::default());
    for step in 1..=5 {
        let mut resumed = state.clone();
        original.step(&mut state, &mut [&mut term], STEP).unwrap();
        stepper().step(&mut resumed, &mut [&mut Chosen::default()], STEP).unwrap();
        assert_eq!(state.hash(), resumed.hash(), "step {step}");
    }
}

/// A point on two springs at rest can turn about the line between their anchors: the Hessian k (n₁n₁ᵀ + n₂n₂ᵀ) has rank two, however
/// its third pivot is rounded. With a third spring out of the plane the minimum is strict, be the plane nearly met.
#[test]
fn a_mechanism_is_no_strict_minimum() {
    for k in 0..60 {
        let t = f64::from(k);
        let anchors = [
            Vec3::new((1.1 * t).sin(), (2.3 * t).cos(), (0.7 * t).sin() + 0.1),
            Vec3::new((1.9 * t).cos(), (0.9 * t).sin(), (3.1 * t).cos() - 0.2),
        ];
        let across = anchors[0].cross(&anchors[1]).normalize();
        let third = anchors[0] + across * 1e-3;
        let rest = vec![Vec3::zeros(), anchors[0], anchors[1], third];
        let fixed: Vec<(u32, Vec3)> = (1..4).map(|i| (i, rest[i as usize])).collect();
        for (pairs, expected) in
            [(vec![[0, 1], [0, 2]], Minimum::NotDefinite), (vec![[0, 1], [0, 2], [0, 3]], Minimum::Strict)]
        {
            let mut springs = Springs::term("springs", 1e3, &rest, pairs).unwrap();
            let map = PointMap::with_fixed(4, &fixed).unwrap();
            let mut stepper = Stepper::new(Mass::zeros(4), map, StepperOptions::default());
            let mut state = State::at_rest(rest.clone());
            let report = stepper.equilibrium(&mut state, &mut [&mut springs], 1).unwrap();
            assert_eq!(report.minimum, expected, "{k}");
        }
    }
}
