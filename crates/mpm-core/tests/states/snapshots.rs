//! Runs that go on from a checkpoint taken at any tenth step, in a simulation set up anew: the same bits.

use crate::{ball, falling, lame, mixture};
use mechanics_core::checkpoint::Checkpoint;
use mpm_constitutive::elastic::FixedCorotated;
use mpm_constitutive::plastic::{VonMises, YieldStress};
use mpm_core::sampling::SampledBody;
use mpm_core::{
    Boundary, Grip, ImplicitStep, Samples, Shape, Simulation, SimulationOptions, Surface, Transfer,
};

const STEPS: usize = 60;

fn resumes(name: &str, start: impl Fn() -> Simulation<f64, 2>, step: impl Fn(&mut Simulation<f64, 2>)) {
    let mut whole = start();
    let mut snapshots = Vec::new();
    for number in 1..=STEPS {
        step(&mut whole);
        if number % 10 == 0 {
            snapshots.push((number, whole.checkpoint().to_bytes()));
        }
    }
    let end = whole.checkpoint().to_bytes();
    for (number, bytes) in snapshots {
        let mut resumed = start();
        resumed.resume(Checkpoint::from_bytes(&bytes).unwrap()).unwrap();
        (number..STEPS).for_each(|_| step(&mut resumed));
        assert!(resumed.checkpoint().to_bytes() == end, "{name}: other bits from step {number} on");
    }
}

/// Jelly, sand, metal and water, history and total deformation, on a floor with friction; a grip that begins, turns and lets go, and a floor that moves.
#[test]
fn explicit_runs_resumed_at_every_tenth_step_end_in_the_same_bits() {
    for transfer in [Transfer::MlsApic, Transfer::ASFLIP, Transfer::Xpic { order: 2 }] {
        let start = || {
            let mut simulation = mixture::<f64, 2>(transfer);
            let grip = Grip {
                region: Shape::Ball { centre: [0.0, 0.3], radius: 0.2 },
                centre: [0.0, 0.3],
                velocity: [0.2, 0.1],
                angular_velocity: [0.0, 0.0, 3.0],
                from: 5e-3,
                until: 40e-3,
            };
            simulation.add_grip(grip).unwrap();
            let shape = Shape::Cuboid { centre: [2.2, 0.3], half: [0.2, 0.2] };
            let piston = Boundary { velocity: [-1.5, 0.0], ..Boundary::at_rest(shape, Surface::Separating) };
            simulation.add_boundary(piston).unwrap();
            simulation
        };
        resumes(&format!("{transfer:?}"), start, |simulation| {
            let h = simulation.stable_step().min(1e-3);
            simulation.step(h).unwrap();
        });
    }
}

#[test]
fn implicit_runs_resumed_at_every_tenth_step_end_in_the_same_bits() {
    let start = || {
        let mut simulation = Simulation::<f64, 2>::new(SimulationOptions::new(0.1)).unwrap();
        let floor = Shape::HalfSpace { point: [0.0; 2], normal: [0.0, 1.0] };
        simulation.add_boundary(Boundary::at_rest(floor, Surface::Friction(0.4))).unwrap();
        simulation.set_gravity([0.0, -9.81]).unwrap();
        for body in 0..2 {
            let SampledBody { positions, volumes } = ball::<2>([0.4 * f64::from(body), 0.2], 0.15);
            let velocities = falling(1.0, positions.len());
            let samples = Samples { positions: &positions, velocities: &velocities, volumes: &volumes };
            let metal = VonMises::new(lame(), YieldStress::perfect(1e3).unwrap()).unwrap();
            let added = match body {
                0 => simulation.add_body(FixedCorotated::new(lame()), 1000.0, samples),
                _ => simulation.add_body(metal, 2000.0, samples),
            };
            added.unwrap();
        }
        simulation
    };
    resumes("implicit", start, |simulation| {
        simulation.step_implicitly(2e-3, &ImplicitStep::default()).unwrap();
    });
}
