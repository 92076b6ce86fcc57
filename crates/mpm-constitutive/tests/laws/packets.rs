//! Lanes compute what single numbers compute, and single precision what double does, to its digits.

use crate::materials::{STIFF, SolidLaw, Visitor, history, visit_all};
use crate::sample::Numbers;
use mechanics_core::lanes::{Element, LaneKernel, Packet, dispatch, dispatch_portable};
use mechanics_core::tensor::{Mat3, Matrix3, columns};
use mpm_constitutive::Numbers as _;

/// One step from each trial; the nine entries of F, then those of τ, then the history.
struct Steps<'a, L> {
    law: &'a L,
    trials: &'a [Mat3],
    numbers: &'a [f64],
}

impl<L: SolidLaw, E: Element> LaneKernel<E> for Steps<'_, L> {
    type Output = Vec<Vec<E>>;

    #[inline(always)]
    fn run<P: Packet<Element = E>>(self) -> Vec<Vec<E>> {
        let mut results = Vec::new();
        for chunk in self.trials.chunks(P::LANES) {
            let entry = |k: usize| {
                let lanes: Vec<E> = chunk.iter().map(|f| E::constant(f.as_slice()[k])).collect();
                P::load_or(&lanes, E::constant(if k.is_multiple_of(4) { 1.0 } else { 0.0 }))
            };
            let mut state = history::<L, P>(self.numbers);
            let (strain, stress) = self.law.return_map(&L::Strain::from_numbers(entry), &mut state, 1e-3);
            let (f, tau) = (L::gradient(&strain), stress.kirchhoff);
            let mut all: Vec<P> = columns(&f).iter().chain(columns(&tau)).flatten().copied().collect();
            all.extend((0..L::History::<P>::COUNT).map(|k| state.number(k)));
            for lane in 0..chunk.len() {
                results.push(all.iter().map(|packet| packet.to_lanes().as_ref()[lane]).collect());
            }
        }
        results
    }
}

fn one_by_one<L: SolidLaw, E: Element>(law: &L, trials: &[Mat3], numbers: &[f64]) -> Vec<Vec<E>> {
    let step = |f: &Mat3| {
        let f: Matrix3<E> = f.map(E::constant);
        let mut state = history::<L, E>(numbers);
        let (strain, stress) = law.return_map(&L::strain(&f), &mut state, 1e-3);
        let mut all: Vec<E> = L::gradient(&strain).iter().chain(stress.kirchhoff.iter()).copied().collect();
        all.extend((0..L::History::<E>::COUNT).map(|k| state.number(k)));
        all
    };
    trials.iter().map(step).collect()
}

/// The largest difference, strain and history absolutely, stress in units of the elastic stiffness.
fn difference<E: Element>(a: &[Vec<E>], b: &[Vec<E>]) -> f64 {
    let mut largest = 0.0_f64;
    for (a, b) in a.iter().zip(b) {
        for (k, (x, y)) in a.iter().zip(b).enumerate() {
            let (x, y): (f64, f64) = ((*x).into(), (*y).into());
            let scale = if (9..18).contains(&k) { STIFF.max(x.abs()) } else { x.abs().max(1.0) };
            largest = largest.max((x - y).abs() / scale);
        }
    }
    largest
}

fn trials(numbers: &mut Numbers, size: f64) -> Vec<Mat3> {
    (0..37).map(|_| numbers.deformation(size)).collect()
}

struct SameInLanes(Numbers);

impl Visitor for SameInLanes {
    fn visit<L: SolidLaw>(&mut self, name: &str, law: &L, histories: &[&[f64]]) {
        let trials = trials(&mut self.0, 0.3);
        for numbers in histories {
            let steps = || Steps { law, trials: &trials, numbers };
            let single: Vec<Vec<f64>> = one_by_one(law, &trials, numbers);
            let portable: Vec<Vec<f64>> = dispatch_portable(steps());
            assert_eq!(single, portable, "{name}: portable lanes, bit for bit");
            let native: Vec<Vec<f64>> = dispatch(steps());
            assert!(difference(&single, &native) < 1e-12, "{name}: {:e}", difference(&single, &native));
            // What a lane gives does not depend on its place or its neighbours.
            let reversed: Vec<Mat3> = trials.iter().rev().copied().collect();
            let mut backwards: Vec<Vec<f64>> = dispatch(Steps { law, trials: &reversed, numbers });
            backwards.reverse();
            assert_eq!(native, backwards, "{name}: neighbours");
        }
    }
}

#[test]
fn lanes_equal_single_numbers() {
    visit_all(&mut SameInLanes(Numbers(31)));
}

struct SinglePrecision(Numbers);

impl Visitor for SinglePrecision {
    fn visit<L: SolidLaw>(&mut self, name: &str, law: &L, histories: &[&[f64]]) {
        for size in [1e-4, 1e-2, 0.1, 0.5] {
            // Numbers of single precision, so that both see the same trial.
            let trials: Vec<Mat3> =
                trials(&mut self.0, size).iter().map(|f| f.map(|x| f64::from(x as f32))).collect();
            for numbers in histories {
                let double: Vec<Vec<f64>> = one_by_one(law, &trials, numbers);
                let single: Vec<Vec<f32>> = dispatch(Steps { law, trials: &trials, numbers });
                let single: Vec<Vec<f64>> =
                    single.iter().map(|row| row.iter().map(|&x| f64::from(x)).collect()).collect();
                let error = difference(&double, &single);
                assert!(error < 1e-5, "{name}: {error:e} for strains of {size}");
            }
        }
    }
}

/// Errors in units of the stiffness, so those of a strain: 1e-5 is 80 times the spacing of single precision.
#[test]
fn single_precision_follows_double() {
    visit_all(&mut SinglePrecision(Numbers(32)));
}
