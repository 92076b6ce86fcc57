//! What a body is made of, behind one virtual call for many particles: the only place where laws meet particles.
//!
//! Laws are compiled here, transfers are not: a new law adds two short kernels to a program, not one for each kernel, transfer and
//! dimension.

use crate::implicit::StepLaw;
use crate::particles::Layout;
use mechanics_core::lanes::{Element, LaneKernel, Packet, Pair, dispatch};
use mechanics_core::scalar::{Mask, Scalar};
use mechanics_core::tensor::{
    Mat3, Matrix3, columns, from_columns, multiple_of_identity, scaled, sum, trace,
};
use mpm_constitutive::{
    Motion, Numbers, PointLaw, PointLawError, StiffnessBound, Strain, Stress, TotalDeformation, Viscosity,
    fresh_history,
};
use std::marker::PhantomData;

/// Packs that laws and transfers take in turns: what passes between them stays in the first cache.
pub(crate) const CHUNK: usize = 16;

/// The most numbers that a strain or a history has.
const MOST_NUMBERS: usize = 16;

/// How stiff particles are: largest (2μ̂ + d λ̂)/ρ₀ and (λ̂ + 2μ̂)/ρ₀ \[m²/s²\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Stiffness {
    pub(crate) expansion: f64,
    pub(crate) wave: f64,
}

impl Stiffness {
    /// The larger of both; a NaN stays.
    pub(crate) fn merged(self, other: Self) -> Self {
        Self { expansion: largest(self.expansion, other.expansion), wave: largest(self.wave, other.wave) }
    }
}

/// The larger number, or NaN if one is.
pub(crate) fn largest(a: f64, b: f64) -> f64 {
    if a >= b || a.is_nan() { a } else { b }
}

/// The mechanical state of one particle, in double precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointState {
    /// The Kirchhoff stress τ \[Pa\], without viscosity.
    pub kirchhoff: Matrix3<f64>,
    /// Stored energy per rest volume \[J/m³\].
    pub energy_density: f64,
    /// J.
    pub volume_ratio: f64,
}

/// A law, as a body sees it.
pub(crate) trait Material<E: Element, const D: usize>: Send + Sync {
    /// Which numbers its particles have.
    fn layout(&self) -> Layout;

    /// Kirchhoff stress times rest volume \[J\] of the particles of some packs: D² numbers a pack, by column.
    fn stress_into(&self, packs: &[E], stress: &mut [E]) -> Stiffness;

    /// Deforms the particles of some packs; `gradients` is their velocity gradient, D² numbers a pack, by column \[1/s\].
    fn deform(&self, packs: &mut [E], gradients: &[E], step: f64);

    /// J of the particles of some packs, a number a pack.
    fn volume_ratios_into(&self, packs: &[E], ratios: &mut [E]);

    /// The numbers, by layout, of a particle of virgin material that is deformed: strain, history, and the kept stress and stiffness if any.
    fn deformed(&self, gradient: &Mat3) -> Vec<(usize, f64)>;

    /// The state of one particle by its numbers.
    fn state(&self, number: &dyn Fn(usize) -> f64) -> PointState;

    /// Stored energy per rest volume of one particle by its numbers \[J/m³\]: that of its [state](Self::state) without the stress.
    fn energy_density(&self, number: &dyn Fn(usize) -> f64) -> f64;

    /// Whether the law is defined at its strain and history.
    fn check(&self, number: &dyn Fn(usize) -> f64) -> Result<(), PointLawError>;

    /// The total deformation gradient, if it is known.
    fn total_deformation(&self, number: &dyn Fn(usize) -> f64) -> Option<Mat3>;

    /// n, where stiffness grows as J⁻ⁿ.
    fn stiffening(&self) -> f64;

    /// The law as implicit steps see it.
    fn step_law(&self) -> &dyn StepLaw;
}

/// Which deformation gradients particles have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Tracking {
    /// The strain alone.
    Strain,
    /// The total one beside the strain, where the law's strain is not the total one.
    Total,
}

/// A [`PointLaw`] as a material.
pub(crate) struct Matter<L> {
    pub(crate) law: L,
    pub(crate) tracking: Tracking,
}

/// Whether a law changes more than its trial strain. Its stress and stiffness are then made with the flow, and kept: all take the same
/// singular value decomposition.
const fn flows<L: PointLaw>() -> bool {
    <L::History<f64> as Numbers<f64>>::COUNT > 0 || matches!(L::TOTAL_DEFORMATION, TotalDeformation::Separate)
}

const fn layout<L: PointLaw>(dimension: usize) -> Layout {
    let strain = <L::Strain<f64> as Numbers<f64>>::COUNT;
    let history = <L::History<f64> as Numbers<f64>>::COUNT;
    assert!(strain <= MOST_NUMBERS && history <= MOST_NUMBERS, "room for strain and history");
    Layout::new(dimension, strain, history, if flows::<L>() { KEPT } else { 0 })
}

/// Numbers kept of a stress: six of τ, then λ̂ and μ̂.
const KEPT: usize = 8;

#[inline(always)]
fn kept_of<S: Scalar>(stress: &Stress<S>) -> [S; KEPT] {
    let tau = columns(&stress.kirchhoff);
    let StiffnessBound { lambda, mu } = stress.stiffness;
    [tau[0][0], tau[1][1], tau[2][2], tau[1][2], tau[2][0], tau[0][1], lambda, mu]
}

#[inline(always)]
fn from_kept<S: Scalar>([xx, yy, zz, yz, zx, xy, lambda, mu]: [S; KEPT]) -> Stress<S> {
    Stress {
        kirchhoff: from_columns([[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]]),
        stiffness: StiffnessBound { lambda, mu },
    }
}

impl<E: Element, const D: usize, L: PointLaw> Material<E, D> for Matter<L> {
    fn layout(&self) -> Layout {
        let separate = !matches!(L::TOTAL_DEFORMATION, TotalDeformation::IsTheStrain);
        match self.tracking {
            Tracking::Total if separate => layout::<L>(D).with_total(D * D),
            _ => layout::<L>(D),
        }
    }

    fn stress_into(&self, packs: &[E], stress: &mut [E]) -> Stiffness {
        let count = Material::<E, D>::layout(self).count;
        dispatch(StressKernel::<E, D, L> { law: &self.law, count, packs, stress })
    }

    fn deform(&self, packs: &mut [E], gradients: &[E], step: f64) {
        let count = Material::<E, D>::layout(self).count;
        dispatch(Deformation::<E, D, L> { law: &self.law, count, packs, gradients, step });
    }

    fn volume_ratios_into(&self, packs: &[E], ratios: &mut [E]) {
        let count = Material::<E, D>::layout(self).count;
        dispatch(VolumeRatios::<E, D, L> { law: PhantomData, count, packs, ratios });
    }

    fn deformed(&self, gradient: &Mat3) -> Vec<(usize, f64)> {
        let layout = Material::<E, D>::layout(self);
        let strain = L::Strain::<f64>::from_deformation_gradient(gradient);
        let history = fresh_history::<L, f64>();
        let strains =
            (0..<L::Strain<f64> as Numbers<f64>>::COUNT).map(|k| (layout.strain + k, strain.number(k)));
        let histories =
            (0..<L::History<f64> as Numbers<f64>>::COUNT).map(|k| (layout.history + k, history.number(k)));
        let mut numbers: Vec<(usize, f64)> = strains.chain(histories).collect();
        if flows::<L>() {
            let kept = kept_of(&self.law.stress(&strain, &history));
            numbers.extend(kept.into_iter().enumerate().map(|(k, number)| (layout.stress + k, number)));
        }
        if layout.tracks_total() {
            numbers.extend((0..D * D).map(|k| (layout.total + k, gradient[(k % D, k / D)])));
        }
        numbers
    }

    fn state(&self, number: &dyn Fn(usize) -> f64) -> PointState {
        let (strain, history) = point::<L, D>(number);
        PointState {
            kirchhoff: self.law.stress(&strain, &history).kirchhoff,
            energy_density: self.law.energy_density(&strain, &history),
            volume_ratio: strain.volume_ratio(),
        }
    }

    fn energy_density(&self, number: &dyn Fn(usize) -> f64) -> f64 {
        let (strain, history) = point::<L, D>(number);
        self.law.energy_density(&strain, &history)
    }

    fn check(&self, number: &dyn Fn(usize) -> f64) -> Result<(), PointLawError> {
        // In the precision of the particles: what a double holds may be beyond theirs.
        let layout = layout::<L>(D);
        let strain = L::Strain::<E>::from_numbers(|k| E::constant(number(layout.strain + k)));
        let history = L::History::<E>::from_numbers(|k| E::constant(number(layout.history + k)));
        self.law.check_admissible(&strain, &history)
    }

    fn total_deformation(&self, number: &dyn Fn(usize) -> f64) -> Option<Mat3> {
        let layout = Material::<E, D>::layout(self);
        if layout.tracks_total() {
            return Some(Mat3::from_fn(|a, b| match a < D && b < D {
                true => number(layout.total + b * D + a),
                false => f64::from(u8::from(a == b)),
            }));
        }
        let strain = <L::Strain<f64> as Numbers<f64>>::COUNT;
        let is_total = matches!(L::TOTAL_DEFORMATION, TotalDeformation::IsTheStrain);
        (is_total && strain == 9).then(|| Mat3::from_fn(|a, b| number(layout.strain + 3 * b + a)))
    }

    fn stiffening(&self) -> f64 {
        self.law.stiffening()
    }

    fn step_law(&self) -> &dyn StepLaw {
        &self.law
    }
}

fn point<L: PointLaw, const D: usize>(number: &dyn Fn(usize) -> f64) -> (L::Strain<f64>, L::History<f64>) {
    let layout = layout::<L>(D);
    let strain = L::Strain::<f64>::from_numbers(|k| number(layout.strain + k));
    (strain, L::History::<f64>::from_numbers(|k| number(layout.history + k)))
}

/// Numbers of two packs, whose laws are evaluated side by side: most laws are long chains of operations that wait for each other. At the end
/// of a block both may be the same pack.
#[derive(Clone, Copy)]
struct Two<'a, E> {
    first: &'a [E],
    second: &'a [E],
}

impl<'a, E> Two<'a, E> {
    /// The packs of `length` numbers in `packs`, one or two.
    #[inline(always)]
    fn new(packs: &'a [E], length: usize) -> Self {
        let second = packs.len() - length;
        Self { first: &packs[..length], second: &packs[second..second + length] }
    }

    #[inline(always)]
    fn load<P: Packet<Element = E>>(&self, k: usize) -> Pair<P> {
        let at = k * P::LANES;
        Pair(P::load(&self.first[at..at + P::LANES]), P::load(&self.second[at..at + P::LANES]))
    }

    /// `count` numbers. An array, because a closure that loads packets would not be compiled for AVX2.
    #[inline(always)]
    fn numbers<P: Packet<Element = E>>(&self, first: usize, count: usize) -> [Pair<P>; MOST_NUMBERS] {
        let mut numbers = [Pair::constant(0.0); MOST_NUMBERS];
        for (k, number) in numbers.iter_mut().enumerate().take(count) {
            *number = self.load(first + k);
        }
        numbers
    }

    #[inline(always)]
    fn strain<P: Packet<Element = E>, L: PointLaw>(&self, layout: &Layout) -> L::Strain<Pair<P>> {
        let numbers = self.numbers::<P>(layout.strain, <L::Strain<Pair<P>> as Numbers<Pair<P>>>::COUNT);
        L::Strain::from_numbers(|k| numbers[k])
    }

    #[inline(always)]
    fn history<P: Packet<Element = E>, L: PointLaw>(&self, layout: &Layout) -> L::History<Pair<P>> {
        let numbers = self.numbers::<P>(layout.history, <L::History<Pair<P>> as Numbers<Pair<P>>>::COUNT);
        L::History::from_numbers(|k| numbers[k])
    }

    #[inline(always)]
    fn kept<P: Packet<Element = E>>(&self, layout: &Layout) -> Stress<Pair<P>> {
        let mut kept = [Pair::constant(0.0); KEPT];
        for (k, number) in kept.iter_mut().enumerate() {
            *number = self.load(layout.stress + k);
        }
        from_kept(kept)
    }

    /// D² numbers by column as the corner of a 3×3 matrix.
    #[inline(always)]
    fn embedded<P: Packet<Element = E>, const D: usize>(&self, first: usize) -> Matrix3<Pair<P>> {
        let mut full = [[Pair::constant(0.0); 3]; 3];
        for (axis, column) in full.iter_mut().enumerate().take(D) {
            for (a, entry) in column.iter_mut().enumerate().take(D) {
                *entry = self.load(first + axis * D + a);
            }
        }
        from_columns(full)
    }
}

/// Writes number `k` of the packs of `length` numbers in `packs`, one or two.
#[inline(always)]
fn store<P: Packet>(packs: &mut [P::Element], length: usize, k: usize, number: Pair<P>) {
    let (at, second) = (k * P::LANES, packs.len() - length);
    number.0.store(&mut packs[at..at + P::LANES]);
    number.1.store(&mut packs[second + at..second + at + P::LANES]);
}

/// Writes D² numbers by column.
#[inline(always)]
fn store_corner<P: Packet, const D: usize>(
    packs: &mut [P::Element],
    length: usize,
    first: usize,
    matrix: &Matrix3<Pair<P>>,
) {
    let columns = columns(matrix);
    for axis in 0..D {
        for a in 0..D {
            store(packs, length, first + axis * D + a, columns[axis][a]);
        }
    }
}

/// det F below this many ε‖F‖³ leaves it to the law whether the smallest singular value is positive.
const DOUBTFUL: f64 = 64.0;

/// Zero, or not finite where the law refuses a strain whose kept stress need not show it.
#[inline(always)]
fn refusal<S: Scalar, L: PointLaw>(law: &L, strain: &L::Strain<S>, history: &L::History<S>) -> S {
    let mut size = S::constant(0.0);
    for k in 0..<L::Strain<S> as Numbers<S>>::COUNT {
        size = strain.number(k).mul_add(strain.number(k), size);
    }
    let sound = (size * size.sqrt()).scale(DOUBTFUL * S::EPSILON).less(strain.volume_ratio());
    if sound.all() {
        return S::constant(0.0);
    }
    trace(&law.stress(strain, history).kirchhoff) * S::constant(0.0)
}

struct StressKernel<'a, E, const D: usize, L> {
    law: &'a L,
    /// Numbers of a particle.
    count: usize,
    packs: &'a [E],
    stress: &'a mut [E],
}

impl<E: Element, const D: usize, L: PointLaw> LaneKernel<E> for StressKernel<'_, E, D, L> {
    type Output = Stiffness;

    #[inline(always)]
    fn run<P: Packet<Element = E>>(self) -> Stiffness {
        let layout = layout::<L>(D);
        let viscosity = self.law.viscosity();
        let (mut expansion, mut wave) = (Pair::<P>::constant(0.0), Pair::constant(0.0));
        let (length, target_length) = (self.count * P::LANES, D * D * P::LANES);
        let targets = self.stress.chunks_mut(2 * target_length);
        for (packs, targets) in self.packs.chunks(2 * length).zip(targets) {
            let targets = &mut targets[..packs.len() / length * target_length];
            let packs = Two::new(packs, length);
            let strain = packs.strain::<P, L>(&layout);
            let stress = if flows::<L>() {
                let mut stress = packs.kept::<P>(&layout);
                let refusal = refusal(self.law, &strain, &packs.history::<P, L>(&layout));
                stress.kirchhoff = sum(&stress.kirchhoff, &multiple_of_identity(refusal));
                stress
            } else {
                let mut stress = self.law.stress(&strain, &packs.history::<P, L>(&layout));
                if viscosity != Viscosity::NONE {
                    let gradient = packs.embedded::<P, D>(layout.gradient);
                    let viscous = viscosity.kirchhoff(strain.volume_ratio(), &gradient);
                    stress.kirchhoff = sum(&stress.kirchhoff, &viscous);
                }
                stress
            };
            let volume = packs.load::<P>(layout.volume);
            let per_mass = volume / packs.load(layout.mass);
            expansion = expansion.max(stress.stiffness.uniform(D) * per_mass);
            wave = wave.max(stress.stiffness.wave_modulus() * per_mass);
            store_corner::<P, D>(targets, target_length, 0, &scaled(&stress.kirchhoff, volume));
        }
        Stiffness { expansion: largest_lane(expansion), wave: largest_lane(wave) }
    }
}

struct VolumeRatios<'a, E, const D: usize, L> {
    law: PhantomData<L>,
    /// Numbers of a particle.
    count: usize,
    packs: &'a [E],
    ratios: &'a mut [E],
}

impl<E: Element, const D: usize, L: PointLaw> LaneKernel<E> for VolumeRatios<'_, E, D, L> {
    type Output = ();

    #[inline(always)]
    fn run<P: Packet<Element = E>>(self) {
        let layout = layout::<L>(D);
        let length = self.count * P::LANES;
        for (packs, ratios) in self.packs.chunks(2 * length).zip(self.ratios.chunks_mut(2 * P::LANES)) {
            let ratios = &mut ratios[..packs.len() / length * P::LANES];
            let ratio = Two::new(packs, length).strain::<P, L>(&layout).volume_ratio();
            store(ratios, P::LANES, 0, ratio);
        }
    }
}

struct Deformation<'a, E, const D: usize, L> {
    law: &'a L,
    /// Numbers of a particle.
    count: usize,
    packs: &'a mut [E],
    gradients: &'a [E],
    step: f64,
}

impl<E: Element, const D: usize, L: PointLaw> LaneKernel<E> for Deformation<'_, E, D, L> {
    type Output = ();

    #[inline(always)]
    fn run<P: Packet<Element = E>>(self) {
        let layout = layout::<L>(D);
        let (length, gradient_length) = (self.count * P::LANES, D * D * P::LANES);
        let gradients = self.gradients.chunks(2 * gradient_length);
        for (packs, gradients) in self.packs.chunks_mut(2 * length).zip(gradients) {
            let gradients = &gradients[..packs.len() / length * gradient_length];
            let velocity_gradient = Two::new(gradients, gradient_length).embedded::<P, D>(0);
            let increment = scaled(&velocity_gradient, Pair::constant(self.step));
            let before = Two::new(packs, length);
            let mut strain = before.strain::<P, L>(&layout);
            let mut history = before.history::<P, L>(&layout);
            if self.count > layout.count {
                let total = before.embedded::<P, D>(layout.total).advanced(&increment);
                store_corner::<P, D>(packs, length, layout.total, &total);
            }
            if flows::<L>() {
                let motion = Motion { velocity_gradient, step: self.step };
                let (moved, stress) = self.law.advance(&strain, &mut history, &motion);
                strain = moved;
                for k in 0..<L::History<Pair<P>> as Numbers<Pair<P>>>::COUNT {
                    store(packs, length, layout.history + k, history.number(k));
                }
                for (k, number) in kept_of(&stress).into_iter().enumerate() {
                    store(packs, length, layout.stress + k, number);
                }
            } else {
                strain = strain.advanced(&increment);
            }
            for k in 0..<L::Strain<Pair<P>> as Numbers<Pair<P>>>::COUNT {
                store(packs, length, layout.strain + k, strain.number(k));
            }
        }
    }
}

/// The largest lane, or NaN if one is.
#[inline(always)]
pub(crate) fn largest_lane<P: Packet>(packets: Pair<P>) -> f64 {
    let (first, second) = (packets.0.to_lanes(), packets.1.to_lanes());
    let mut most = 0.0;
    for lane in first.as_ref().iter().chain(second.as_ref()) {
        most = largest(most, (*lane).into());
    }
    most
}
