//! κ: how strong the barrier is, and when it grows.
//!
//! The energy of a pair is κ·b in joules. A barrier of any κ > 0 lets nothing through; κ decides how wide the gap is under a
//! load, and with it how hard the minimisation: the force of a pair grows like 1/gap and its stiffness like 1/gap² where the
//! gap is far below d̂. Good values leave gaps between a few per cent of d̂ and d̂.
//!
//! **Nothing here knows the time step.** The formulas of Li et al. (2020) are for h² E, so their κ is h² times ours, and their
//! lower bound, which balances the barrier against mass alone, turns into a bound that grows like 1/h²: we do not take it.
//! Instead the scale of κ comes from a load that the user can name:
//! - [`Scale::Load`] is the force λ that a pair carries at half of the activation distance: κ = λ / |∂b/∂d|;
//! - [`BarrierContact::balance`](crate::contact::BarrierContact::balance) takes the gradient of the other terms at positions in
//!   contact and makes the sum of all forces as small as κ can: with g = ∇Σb and f = ∇E of the others, κ = −gᵀf / gᵀg
//!   minimises ‖f + κ g‖² (Li et al. 2020, supplement, without its inertia, and so without its h);
//! - [`BarrierContact::match_stiffness`](crate::contact::BarrierContact::match_stiffness) reads the Hessians of the other terms,
//!   and makes a pair at half of the activation distance as stiff as the points in contact are (elasticity-inclusive).
//!
//! A term of the incremental potential cannot see the others, and should not: what a term does would depend on which stand
//! beside it. So whoever holds the terms hands over what the balance needs, once, before the first step.
//!
//! **Growth.** At every Newton iteration an adaptive κ doubles if the smallest gap is below `closest`·d̂ and below the smallest
//! gap of the iteration before: a pair that still approaches there is under a load for which κ is too small. κ never falls
//! within a run.
//!
//! **State.** κ is carried from step to step. A step that is tried again from the same positions (a smaller step after a failure) begins
//! with the κ of the first try. So κ is part of the state of a run, and which it is depends on where the next step begins: a checkpoint
//! saves [`BarrierContact::saved_stiffness`](crate::contact::BarrierContact::saved_stiffness) of its positions, and a run resumed with
//! [`BarrierContact::resume_stiffness`](crate::contact::BarrierContact::resume_stiffness) has the bits of one that was not interrupted.
//!
//! # Reference
//! M. Li et al., *Incremental Potential Contact*, ACM Trans. Graph. 39(4), 2020, section 4.3 and supplement. R. Ando, *A cubic barrier
//! with elasticity-inclusive dynamic stiffness*, ACM Trans. Graph. 43(6), 2024, for the idea that κ follows the elastic stiffness.

use crate::error::ContactError;
use mechanics_core::potential::Changed;
use mechanics_core::tensor::Vec3;

/// How κ is found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stiffness {
    /// κ at first.
    pub scale: Scale,
    /// How it grows; `None` keeps it as it is.
    pub growth: Option<Growth>,
}

/// What states κ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    /// κ itself. Its unit depends on the form of the barrier and on the weighting: κ·b is in joules.
    Kappa(f64),
    /// The load λ that a pair of weight one carries at half of the activation distance: \[N\], and with area weights \[Pa\]. A
    /// surface with Young's modulus E and edges of length ℓ is as stiff as its barrier is there at λ ≈ ½ E ℓ d̂
    /// (with area weights ½ E d̂/ℓ).
    Load(f64),
}

/// When an adaptive κ grows, and how far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Growth {
    /// κ doubles where the smallest gap is below this part of d̂ and still falls. In (0, 1).
    pub closest: f64,
    /// κ never exceeds this multiple of its start. At least 1.
    pub largest: f64,
}

impl Default for Growth {
    /// Below 1 % of d̂, to at most 2¹⁶ times the start.
    fn default() -> Self {
        Self { closest: 0.01, largest: 65536.0 }
    }
}

impl Stiffness {
    /// The same for good.
    pub fn fixed(scale: Scale) -> Self {
        Self { scale, growth: None }
    }

    /// Grows as [`Growth::default`] says.
    pub fn adaptive(scale: Scale) -> Self {
        Self { scale, growth: Some(Growth::default()) }
    }

    /// Checks the ranges.
    ///
    /// # Errors
    /// If κ or the load is not positive and finite, or a number of the growth is out of range.
    pub fn validate(&self) -> Result<(), ContactError> {
        let (Scale::Kappa(value) | Scale::Load(value)) = self.scale;
        if !(value.is_finite() && value > 0.0) {
            return Err(ContactError::Stiffness { value });
        }
        match self.growth {
            Some(Growth { closest, .. }) if !(closest > 0.0 && closest < 1.0) => {
                Err(ContactError::GrowthThreshold { value: closest })
            }
            Some(Growth { largest, .. }) if !(largest.is_finite() && largest >= 1.0) => {
                Err(ContactError::GrowthLimit { value: largest })
            }
            _ => Ok(()),
        }
    }
}

/// κ where a run stands: a checkpoint saves it with the positions, and a resumed run begins with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SavedStiffness {
    /// κ that the next step begins with.
    pub kappa: f64,
    /// κ never exceeds this.
    pub largest: f64,
}

/// κ now, and what its growth remembers.
#[derive(Clone, Debug)]
pub(crate) struct Adaptation {
    growth: Option<Growth>,
    current: f64,
    /// κ never exceeds this.
    largest: f64,
    /// The smallest gap at the iteration before, in this step.
    last_gap: Option<f64>,
    doublings: u64,
    /// The positions at the start of the last step, and κ there.
    start: Option<(Vec<Vec3>, f64)>,
}

impl Adaptation {
    pub(crate) fn new(initial: f64, growth: Option<Growth>) -> Self {
        let largest = growth.map_or(initial, |growth| growth.largest * initial);
        Self { growth, current: initial, largest, last_gap: None, doublings: 0, start: None }
    }

    pub(crate) fn current(&self) -> f64 {
        self.current
    }

    /// Doublings since the start of the step.
    pub(crate) fn doublings(&self) -> u64 {
        self.doublings
    }

    /// A new start: κ may grow from there.
    pub(crate) fn restart(&mut self, initial: f64) {
        *self = Self::new(initial, self.growth);
    }

    /// What a step from `x` begins with: if the last one began there too, it is being tried again, from the same κ.
    pub(crate) fn at(&self, x: &[Vec3]) -> SavedStiffness {
        let kappa = match &self.start {
            Some((positions, stiffness)) if positions == x => *stiffness,
            _ => self.current,
        };
        SavedStiffness { kappa, largest: self.largest }
    }

    /// κ as it was saved.
    pub(crate) fn resume(&mut self, saved: SavedStiffness) {
        (self.current, self.largest, self.start) = (saved.kappa, saved.largest, None);
    }

    /// A step begins at `x`.
    pub(crate) fn begin_step(&mut self, x: &[Vec3]) -> Changed {
        self.last_gap = None;
        self.doublings = 0;
        if self.growth.is_none() {
            return Changed::Nothing;
        }
        let before = self.current;
        self.current = self.at(x).kappa;
        let (positions, stiffness) = self.start.get_or_insert_default();
        x.clone_into(positions);
        *stiffness = self.current;
        if self.current == before { Changed::Nothing } else { Changed::Energy }
    }

    /// Before a Newton iteration at positions whose smallest gap is `gap`, in parts of d̂; `None` without contact.
    pub(crate) fn begin_iteration(&mut self, gap: Option<f64>) -> Changed {
        let Some(Growth { closest, .. }) = self.growth else { return Changed::Nothing };
        let last = std::mem::replace(&mut self.last_gap, gap);
        let approaches = gap.zip(last).is_some_and(|(gap, last)| gap < closest && gap < last);
        let grown = (2.0 * self.current).min(self.largest);
        if !approaches || grown <= self.current {
            return Changed::Nothing;
        }
        self.current = grown;
        self.doublings += 1;
        Changed::Energy
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn doubles_only_where_a_close_pair_comes_closer() {
        let mut adaptation = Adaptation::new(3.0, Some(Growth::default()));
        let gaps = [
            None,
            Some(0.5),
            Some(0.009),
            Some(0.009),
            Some(0.008),
            Some(0.02),
            Some(0.005),
            None,
            Some(0.001),
        ];
        let kappa: Vec<f64> = gaps
            .map(|gap| {
                let _: Changed = adaptation.begin_iteration(gap);
                adaptation.current()
            })
            .to_vec();
        assert_eq!(kappa, [3.0, 3.0, 6.0, 6.0, 12.0, 12.0, 24.0, 24.0, 24.0]);
    }

    #[test]
    fn growth_ends_at_its_limit() {
        let growth = Growth { closest: 0.1, largest: 5.0 };
        let mut adaptation = Adaptation::new(1.0, Some(growth));
        let changes =
            (1..10).filter(|k| adaptation.begin_iteration(Some(0.1 / f64::from(*k))) == Changed::Energy);
        assert_eq!(changes.count(), 3);
        assert_eq!(adaptation.current(), 5.0);
    }

    #[test]
    fn a_step_tried_again_begins_with_the_same_stiffness() {
        let mut adaptation = Adaptation::new(1.0, Some(Growth::default()));
        let (x, y) = ([Vec3::zeros()], [Vec3::x()]);
        assert_eq!(adaptation.begin_step(&x), Changed::Nothing);
        for gap in [0.004, 0.003, 0.002] {
            let _: Changed = adaptation.begin_iteration(Some(gap));
        }
        assert_eq!(adaptation.current(), 4.0);
        assert_eq!(adaptation.begin_step(&x), Changed::Energy);
        assert_eq!(adaptation.current(), 1.0);
        let _: Changed = adaptation.begin_iteration(Some(0.004));
        let _: Changed = adaptation.begin_iteration(Some(0.003));
        assert_eq!(adaptation.begin_step(&y), Changed::Nothing);
        assert_eq!(adaptation.current(), 2.0, "carried into the next step");
    }

    #[test]
    fn what_is_out_of_range_is_refused() {
        for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            for scale in [Scale::Kappa(value), Scale::Load(value)] {
                assert!(matches!(Stiffness::fixed(scale).validate(), Err(ContactError::Stiffness { .. })));
            }
        }
        let growing =
            |growth| Stiffness { growth: Some(growth), ..Stiffness::fixed(Scale::Kappa(1.0)) }.validate();
        let wrong = growing(Growth { closest: 1.0, largest: 5.0 });
        assert_eq!(wrong, Err(ContactError::GrowthThreshold { value: 1.0 }));
        let wrong = growing(Growth { closest: 0.1, largest: 0.5 });
        assert_eq!(wrong, Err(ContactError::GrowthLimit { value: 0.5 }));
    }
}
