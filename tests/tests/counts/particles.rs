//! What material points pay for: a law that counts its own calls, the numbers a particle has, and what colliders were asked.

use mechanics_core::law::{Domain, Lame};
use mechanics_core::mesh::sphere;
use mechanics_core::scalar::Scalar;
use mpm_constitutive::elastic::FixedCorotated;
use mpm_constitutive::plastic::{VonMises, YieldStress};
use mpm_constitutive::{PointLaw, Stress, TotalDeformation};
use mpm_core::sampling::{Pattern, sample_shape};
use mpm_core::{
    Collider, ParticleNumbers, Samples, Shape, Simulation, SimulationOptions, SolidMesh, Surface,
};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Calls of a law: a call is of all lanes together.
#[derive(Default)]
struct Calls {
    stresses: AtomicU64,
    return_maps: AtomicU64,
}

/// Another law that counts.
struct Counted<L> {
    law: L,
    calls: Arc<Calls>,
}

impl<L: PointLaw> PointLaw for Counted<L> {
    type Strain<S: Scalar> = L::Strain<S>;
    type History<S: Scalar> = L::History<S>;
    const TOTAL_DEFORMATION: TotalDeformation = L::TOTAL_DEFORMATION;

    fn energy_density<S: Scalar>(&self, strain: &Self::Strain<S>, history: &Self::History<S>) -> S {
        self.law.energy_density(strain, history)
    }

    fn stress<S: Scalar>(&self, strain: &Self::Strain<S>, history: &Self::History<S>) -> Stress<S> {
        self.calls.stresses.fetch_add(1, Relaxed);
        self.law.stress(strain, history)
    }

    fn return_map<S: Scalar>(
        &self,
        trial: &Self::Strain<S>,
        history: &mut Self::History<S>,
        step: f64,
    ) -> (Self::Strain<S>, Stress<S>) {
        self.calls.return_maps.fetch_add(1, Relaxed);
        self.law.return_map(trial, history, step)
    }

    fn domain(&self) -> Domain {
        self.law.domain()
    }
}

const SPACING: f64 = 0.1;

/// A ball that falls, of a law that counts.
fn ball<L: PointLaw + 'static>(law: L) -> (Simulation<f64, 3>, Arc<Calls>) {
    let calls = Arc::new(Calls::default());
    let ball = Shape::Ball { centre: [0.0, 0.0, 1.0], radius: 0.25 };
    let ball = sample_shape(&ball, Pattern::per_cell(SPACING, 2), 1).unwrap();
    let velocities = vec![[0.0, 0.0, -1.0]; ball.positions.len()];
    let mut simulation = Simulation::new(SimulationOptions::new(SPACING)).unwrap();
    let samples = Samples { positions: &ball.positions, velocities: &velocities, volumes: &ball.volumes };
    simulation.add_body(Counted { law, calls: Arc::clone(&calls) }, 1000.0, samples).unwrap();
    (simulation, calls)
}

fn jelly() -> FixedCorotated {
    FixedCorotated::new(Lame::from_young_poisson(1e5, 0.3).unwrap())
}

fn clay() -> VonMises {
    VonMises::new(Lame::from_young_poisson(1e5, 0.3).unwrap(), YieldStress::linear(1e3, 0.0).unwrap())
        .unwrap()
}

/// Ten steps; answers how many places colliders were asked for, and how many blocks of nodes there were at the end.
fn ten_steps(simulation: &mut Simulation<f64, 3>) -> (u64, u64) {
    let step = 0.5 * simulation.stable_step();
    let reports: Vec<_> = (0..10).map(|_| simulation.step(step).unwrap()).collect();
    (reports.iter().map(|report| report.collider_queries).sum(), reports[9].blocks as u64)
}

#[test]
fn an_elastic_body_has_no_return_map_and_no_memory_of_flow() {
    let (mut elastic, calls) = ball(jelly());
    ten_steps(&mut elastic);
    assert_eq!(calls.return_maps.load(Relaxed), 0);
    // Ten times every particle, up to eight of them in a call.
    assert!(calls.stresses.load(Relaxed) * 8 >= 10 * elastic.particle_count(0) as u64);
    let numbers = ParticleNumbers { motion: 3 + 3 + 9, strain: 9, mass_and_volume: 2, ..Default::default() };
    assert_eq!(elastic.particle_numbers(0), numbers);
    assert_eq!(numbers.count() * size_of::<f64>(), 208);

    // The same ball of what flows: the counter counts, and the history takes its room.
    let (mut plastic, calls) = ball(clay());
    ten_steps(&mut plastic);
    assert!(calls.return_maps.load(Relaxed) * 8 >= 10 * plastic.particle_count(0) as u64);
    assert_eq!(plastic.particle_numbers(0), ParticleNumbers { history: 1, kept_stress: 8, ..numbers });
    assert!(plastic.memory_use().particles > elastic.memory_use().particles);
}

#[test]
fn colliders_are_asked_where_there_are_some_and_matter_is_near() {
    let asked = |centre: Option<[f64; 3]>| {
        let (mut simulation, _) = ball(jelly());
        if let Some(centre) = centre {
            let mut mesh = sphere(0.2, 4).unwrap();
            mesh.translate(&centre.into()).unwrap();
            let solid = SolidMesh::new(&mesh).unwrap();
            simulation.add_collider(Collider::at_rest(solid, Surface::Slip)).unwrap();
        }
        ten_steps(&mut simulation)
    };
    assert_eq!(asked(None).0, 0);
    // Every block asks once, and remembers: again only when the collider may have come near.
    let (far, blocks) = asked(Some([0.0, 0.0, -20.0]));
    assert!(far > 0 && far < 2 * blocks, "{far} of {blocks} blocks");
    let (near, _) = asked(Some([0.0, 0.0, 0.5]));
    assert!(near > 2 * far, "{near}, {far}");
}
