//! Time for a step of a material point under each law (strain update, return map, stress, stiffness), in lanes.
//!
//! `cargo bench -p mpm-constitutive --bench laws`
//!
//! Arrays of numbers as a grid code stores them: one of all particles for each entry of F, of ∇v, and of the history. The linear solid,
//! which needs no decomposition, calibrates: it is loads, stores and the update of F.

#![allow(clippy::print_stdout, clippy::unwrap_used, reason = "a benchmark prints")]

#[path = "../../mechanics-core/benches/timing/timing.rs"]
mod timing;

use mechanics_core::lanes::{Element, LaneKernel, Packet, dispatch};
use mechanics_core::law::Lame;
use mechanics_core::tensor::{columns, from_entries};
use mpm_constitutive::elastic::{FixedCorotated, Hencky, Linear, NeoHookean};
use mpm_constitutive::fluid::{Tait, Tension};
use mpm_constitutive::plastic::{
    DruckerPrager, FrictionAngle, HerschelBulkley, ModifiedCamClay, NonAssociativeCamClay, Snow, VonMises,
    YieldStress,
};
use mpm_constitutive::{Motion, Numbers, PointLaw, Viscosity, Viscous};
use std::hint::black_box;
use timing::{Case, Random, measure};

/// Particles; their data stay in the second-level cache.
const COUNT: usize = 2048;
/// Interleaved repeats, of which the median counts.
const REPEATS: usize = 41;

/// The numbers of all particles, one array after the other.
struct Particles<E> {
    strain: Vec<E>,
    history: Vec<E>,
    velocity_gradient: Vec<E>,
    kirchhoff: Vec<E>,
}

impl<E: Element> Particles<E> {
    fn new<L: PointLaw>() -> Self {
        let mut random = Random(1);
        let count = <L::Strain<E> as Numbers<E>>::COUNT;
        let mut strain = Vec::new();
        for k in 0..count {
            // Up to 4 % of strain, slightly compressed, and a rotation of the same size.
            let rest = if count == 9 && k % 4 == 0 { 0.99 } else { 0.0 };
            strain.extend((0..COUNT).map(|_| E::constant(rest + 0.02 * random.number())));
        }
        Self {
            strain,
            history: vec![E::constant(0.0); COUNT * <L::History<E> as Numbers<E>>::COUNT],
            velocity_gradient: (0..9 * COUNT).map(|_| E::constant(random.number())).collect(),
            kirchhoff: vec![E::constant(0.0); 6 * COUNT],
        }
    }
}

/// What is done with each packet of particles.
struct Advance<'a, L, E> {
    law: &'a L,
    particles: &'a mut Particles<E>,
}

impl<L: PointLaw, E: Element> LaneKernel<E> for Advance<'_, L, E> {
    type Output = f64;

    #[inline(always)]
    fn run<P: Packet<Element = E>>(self) -> f64 {
        let Particles { strain, history, velocity_gradient, kirchhoff } = self.particles;
        let mut fastest = P::constant(0.0);
        for i in (0..COUNT).step_by(P::LANES) {
            let f = L::Strain::<P>::from_numbers(|k| P::load(&strain[k * COUNT + i..]));
            let mut state = L::History::<P>::from_numbers(|k| P::load(&history[k * COUNT + i..]));
            let entries = from_entries(|a, b| P::load(&velocity_gradient[(3 * b + a) * COUNT + i..]));
            let motion = Motion { velocity_gradient: entries, step: 1e-4 };
            let (f, stress) = self.law.advance(&f, &mut state, &motion);
            for k in 0..L::Strain::<P>::COUNT {
                f.number(k).store(&mut strain[k * COUNT + i..]);
            }
            for k in 0..L::History::<P>::COUNT {
                state.number(k).store(&mut history[k * COUNT + i..]);
            }
            let tau = columns(&stress.kirchhoff);
            for (k, entry) in
                [tau[0][0], tau[1][1], tau[2][2], tau[0][1], tau[0][2], tau[1][2]].iter().enumerate()
            {
                entry.store(&mut kirchhoff[k * COUNT + i..]);
            }
            fastest = fastest.max(stress.stiffness.wave_modulus());
        }
        fastest.to_lanes().as_ref().iter().map(|&lane| lane.into()).fold(0.0, f64::max)
    }
}

fn case<L: PointLaw + 'static, E: Element>(name: &'static str, law: L) -> Case<'static> {
    let fresh = Particles::<E>::new::<L>();
    let mut particles = Particles::<E>::new::<L>();
    Case::new(name, COUNT, move || {
        // The same trial strains every time.
        particles.strain.copy_from_slice(&fresh.strain);
        particles.history.copy_from_slice(&fresh.history);
        black_box(dispatch(Advance { law: &law, particles: &mut particles }));
    })
}

fn cases<E: Element>() -> Vec<Case<'static>> {
    let lame = Lame::from_young_poisson(1e6, 0.3).unwrap();
    let linear = YieldStress::linear(1e4, 1e5).unwrap();
    let water = || Tait::new(1e6, 7.0, Tension::Carried).unwrap();
    let hardening = FrictionAngle::hardening([0.61, 0.157, 0.3, 0.174]).unwrap();
    let foam = |index| HerschelBulkley::new(lame, 1e4, 1e3, index).unwrap();
    vec![
        case::<_, E>("linear", Linear::new(lame)),
        case::<_, E>("Tait fluid", water()),
        case::<_, E>("Tait fluid, viscous", Viscous::new(water(), Viscosity::new(1.0, 0.0).unwrap())),
        case::<_, E>("neo-Hookean", NeoHookean::new(lame)),
        case::<_, E>("fixed corotated", FixedCorotated::new(lame)),
        case::<_, E>("Hencky", Hencky::new(lame)),
        case::<_, E>("von Mises, linear hardening", VonMises::new(lame, linear).unwrap()),
        case::<_, E>("von Mises, Voce", VonMises::new(lame, linear.saturating(4e4, 10.0).unwrap()).unwrap()),
        case::<_, E>("sand", DruckerPrager::new(lame, FrictionAngle::constant(0.6).unwrap(), 0.0).unwrap()),
        case::<_, E>("sand, hardening, cohesive", DruckerPrager::new(lame, hardening, 1e3).unwrap()),
        case::<_, E>("snow", Snow::new(lame, 2.5e-2, 7.5e-3, 10.0).unwrap()),
        case::<_, E>("modified Cam-Clay", ModifiedCamClay::new(lame, 1.1, 0.0, 2e4, 8.0).unwrap()),
        case::<_, E>(
            "non-associative Cam-Clay",
            NonAssociativeCamClay::new(lame, 1.85, 0.8, 1.0, 0.04).unwrap(),
        ),
        case::<_, E>("Bingham, h = 1", foam(1.0)),
        case::<_, E>("Herschel-Bulkley, h = 0.4", foam(0.4)),
    ]
}

fn main() {
    measure("eight lanes of f32", REPEATS, cases::<f32>());
    measure("four lanes of f64", REPEATS, cases::<f64>());
}
