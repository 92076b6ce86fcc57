//! What a body is made of, behind one virtual call for many particles: the only place where laws meet particles.
//!
//! Laws are compiled here, transfers are not: a new law adds two short kernels to a program, not one for each kernel, transfer and
//! dimension.

use crate::particles::{Layout, load, store};
use mechanics_core::lanes::{Element, LaneKernel, Packet, dispatch};
use mechanics_core::tensor::{Mat3, Matrix3, columns, from_columns, scaled, sum, trace};
use mpm_constitutive::{
    Motion, Numbers, PointLaw, PointLawError, Strain, TotalDeformation, Viscosity, fresh_history,
};

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

    /// The number `k` of a strain without deformation.
    fn undeformed(&self, k: usize) -> f64;

    /// Kirchhoff stress times rest volume \[J\] of the particles of some packs: D² numbers a pack, by column.
    fn stress_into(&self, packs: &[E], stress: &mut [E]) -> Stiffness;

    /// Deforms the particles of some packs; `gradients` is their velocity gradient, D² numbers a pack, by column \[1/s\].
    fn deform(&self, packs: &mut [E], gradients: &[E], step: f64);

    /// The numbers, by layout, of a particle of virgin material that is deformed: strain, history, and the kept stress if any.
    fn deformed(&self, gradient: &Mat3) -> Vec<(usize, f64)>;

    /// The state of one particle by its numbers.
    fn state(&self, number: &dyn Fn(usize) -> f64) -> PointState;

    /// Whether the law is defined at its strain and history.
    fn check(&self, number: &dyn Fn(usize) -> f64) -> Result<(), PointLawError>;

    /// The total deformation gradient, if it is known.
    fn total_deformation(&self, number: &dyn Fn(usize) -> f64) -> Option<Mat3>;
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

/// Whether a law changes more than its trial strain. Its stress is then made with the flow, and kept: both take the same singular
/// value decomposition.
const fn flows<L: PointLaw>() -> bool {
    <L::History<f64> as Numbers<f64>>::COUNT > 0 || matches!(L::TOTAL_DEFORMATION, TotalDeformation::Separate)
}

const fn layout<L: PointLaw>(dimension: usize) -> Layout {
    let strain = <L::Strain<f64> as Numbers<f64>>::COUNT;
    let history = <L::History<f64> as Numbers<f64>>::COUNT;
    assert!(strain <= MOST_NUMBERS && history <= MOST_NUMBERS, "room for strain and history");
    Layout::new(dimension, strain, history, if flows::<L>() { 6 } else { 0 })
}

impl<E: Element, const D: usize, L: PointLaw> Material<E, D> for Matter<L> {
    fn layout(&self) -> Layout {
        let separate = !matches!(L::TOTAL_DEFORMATION, TotalDeformation::IsTheStrain);
        match self.tracking {
            Tracking::Total if separate => layout::<L>(D).with_total(D * D),
            _ => layout::<L>(D),
        }
    }

    fn undeformed(&self, k: usize) -> f64 {
        <L::Strain<f64> as Strain<f64>>::undeformed().number(k)
    }

    fn stress_into(&self, packs: &[E], stress: &mut [E]) -> Stiffness {
        let count = Material::<E, D>::layout(self).count;
        dispatch(StressKernel::<E, D, L> { law: &self.law, count, packs, stress })
    }

    fn deform(&self, packs: &mut [E], gradients: &[E], step: f64) {
        let count = Material::<E, D>::layout(self).count;
        dispatch(Deformation::<E, D, L> { law: &self.law, count, packs, gradients, step });
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
            let tau = self.law.stress(&strain, &history).kirchhoff;
            let kept = [(0, 0), (1, 1), (2, 2), (1, 2), (2, 0), (0, 1)];
            numbers.extend(kept.iter().enumerate().map(|(k, at)| (layout.stress + k, tau[*at])));
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
}

fn point<L: PointLaw, const D: usize>(number: &dyn Fn(usize) -> f64) -> (L::Strain<f64>, L::History<f64>) {
    let layout = layout::<L>(D);
    let strain = L::Strain::<f64>::from_numbers(|k| number(layout.strain + k));
    (strain, L::History::<f64>::from_numbers(|k| number(layout.history + k)))
}

/// `count` numbers of a pack. An array, because a closure that loads packets would not be compiled for AVX2.
#[inline(always)]
fn loaded<P: Packet>(pack: &[P::Element], first: usize, count: usize) -> [P; MOST_NUMBERS] {
    let mut numbers = [P::constant(0.0); MOST_NUMBERS];
    for (k, number) in numbers.iter_mut().enumerate().take(count) {
        *number = P::load(&pack[(first + k) * P::LANES..][..P::LANES]);
    }
    numbers
}

#[inline(always)]
fn strain_of<P: Packet, L: PointLaw>(pack: &[P::Element], layout: &Layout) -> L::Strain<P> {
    let numbers = loaded(pack, layout.strain, <L::Strain<P> as Numbers<P>>::COUNT);
    L::Strain::<P>::from_numbers(|k| numbers[k])
}

#[inline(always)]
fn history_of<P: Packet, L: PointLaw>(pack: &[P::Element], layout: &Layout) -> L::History<P> {
    let numbers = loaded(pack, layout.history, <L::History<P> as Numbers<P>>::COUNT);
    L::History::<P>::from_numbers(|k| numbers[k])
}

/// D² numbers by column as the corner of a 3×3 matrix.
#[inline(always)]
fn embedded<P: Packet, const D: usize>(pack: &[P::Element], first: usize) -> Matrix3<P> {
    let mut full = [[P::constant(0.0); 3]; 3];
    for (axis, column) in full.iter_mut().enumerate().take(D) {
        for (a, entry) in column.iter_mut().enumerate().take(D) {
            *entry = P::load(&pack[(first + axis * D + a) * P::LANES..][..P::LANES]);
        }
    }
    from_columns(full)
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
        let (mut expansion, mut wave) = (P::constant(0.0), P::constant(0.0));
        let packs = self.packs.chunks_exact(self.count * P::LANES);
        for (pack, target) in packs.zip(self.stress.chunks_exact_mut(D * D * P::LANES)) {
            // Of a length that the compiler knows: no bounds checks.
            let pack = &pack[..layout.count * P::LANES];
            let [mass, volume] = load::<P, 2>(pack, layout.mass);
            let strain = strain_of::<P, L>(pack, &layout);
            let mut stress = self.law.stress(&strain, &history_of::<P, L>(pack, &layout));
            if flows::<L>() {
                // Not finite where the law refuses the strain, which the kept stress need not show.
                let pressure = trace(&stress.kirchhoff);
                let refusal = pressure * P::constant(0.0);
                let [xx, yy, zz, yz, zx, xy] = load::<P, 6>(pack, layout.stress);
                stress.kirchhoff =
                    from_columns([[xx + refusal, xy, zx], [xy, yy + refusal, yz], [zx, yz, zz]]);
            } else if viscosity != Viscosity::NONE {
                let gradient = embedded::<P, D>(pack, layout.gradient);
                let viscous = viscosity.kirchhoff(strain.volume_ratio(), &gradient);
                stress.kirchhoff = sum(&stress.kirchhoff, &viscous);
            }
            let per_mass = volume / mass;
            expansion = expansion.max(stress.stiffness.uniform(D) * per_mass);
            wave = wave.max(stress.stiffness.wave_modulus() * per_mass);
            let tau = columns(&stress.kirchhoff);
            for axis in 0..D {
                for a in 0..D {
                    (tau[axis][a] * volume).store(&mut target[(axis * D + a) * P::LANES..][..P::LANES]);
                }
            }
        }
        Stiffness { expansion: largest_lane(expansion), wave: largest_lane(wave) }
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
        let packs = self.packs.chunks_exact_mut(self.count * P::LANES);
        for (pack, gradient) in packs.zip(self.gradients.chunks_exact(D * D * P::LANES)) {
            let velocity_gradient = embedded::<P, D>(gradient, 0);
            let (pack, total) = pack.split_at_mut(layout.count * P::LANES);
            if !total.is_empty() {
                let before = embedded::<P, D>(total, 0);
                let moved = before.advanced(&scaled(&velocity_gradient, P::constant(self.step)));
                let after = columns(&moved);
                for axis in 0..D {
                    for a in 0..D {
                        after[axis][a].store(&mut total[(axis * D + a) * P::LANES..][..P::LANES]);
                    }
                }
            }
            let mut strain = strain_of::<P, L>(pack, &layout);
            if flows::<L>() {
                let mut history = history_of::<P, L>(pack, &layout);
                let motion = Motion { velocity_gradient, step: self.step };
                let (moved, stress) = self.law.advance(&strain, &mut history, &motion);
                strain = moved;
                for k in 0..<L::History<P> as Numbers<P>>::COUNT {
                    history.number(k).store(&mut pack[(layout.history + k) * P::LANES..][..P::LANES]);
                }
                let tau = columns(&stress.kirchhoff);
                store(
                    pack,
                    layout.stress,
                    &[tau[0][0], tau[1][1], tau[2][2], tau[1][2], tau[2][0], tau[0][1]],
                );
            } else {
                strain = strain.advanced(&scaled(&velocity_gradient, P::constant(self.step)));
            }
            for k in 0..<L::Strain<P> as Numbers<P>>::COUNT {
                strain.number(k).store(&mut pack[(layout.strain + k) * P::LANES..][..P::LANES]);
            }
        }
    }
}

/// The largest lane, or NaN if one is.
#[inline(always)]
pub(crate) fn largest_lane<P: Packet>(packet: P) -> f64 {
    let lanes = packet.to_lanes();
    let mut most = 0.0;
    for lane in lanes.as_ref() {
        most = largest(most, (*lane).into());
    }
    most
}
