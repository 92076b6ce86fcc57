//! Errors that change nothing, checkpoints, total deformation, several laws in one grid.
#![allow(clippy::unwrap_used, missing_docs)]

#[path = "states/faults.rs"]
mod faults;
#[path = "states/snapshots.rs"]
mod snapshots;

use mechanics_core::checkpoint::{self, Checkpoint};
use mechanics_core::lanes::Element;
use mechanics_core::law::Lame;
use mechanics_core::parallel;
use mechanics_core::tensor::Mat3;
use mpm_constitutive::PointLawError;
use mpm_constitutive::elastic::{FixedCorotated, NeoHookean};
use mpm_constitutive::fluid::{Tait, Tension};
use mpm_constitutive::plastic::{DruckerPrager, FrictionAngle, VonMises, YieldStress};
use mpm_core::sampling::{Pattern, SampledBody, sample_shape};
use mpm_core::{
    Boundary, DeformationBuffer, Kernel, MpmError, ResumeError, Samples, Shape, Simulation,
    SimulationOptions, Surface, Transfer,
};

fn lame() -> Lame {
    Lame::from_young_poisson(1e5, 0.3).unwrap()
}

fn ball<const D: usize>(centre: [f64; D], radius: f64) -> SampledBody<D> {
    sample_shape(&Shape::Ball { centre, radius }, Pattern::per_cell(0.1, 2), 5).unwrap()
}

fn falling<const D: usize>(speed: f64, count: usize) -> Vec<[f64; D]> {
    vec![std::array::from_fn(|a| if a == D - 1 { -speed } else { 0.3 }); count]
}

/// Jelly, sand, metal and water on one grid, on a floor with friction.
fn mixture<E: Element, const D: usize>(transfer: Transfer) -> Simulation<E, D> {
    let mut simulation =
        Simulation::new(SimulationOptions { transfer, ..SimulationOptions::new(0.1) }).unwrap();
    let normal = std::array::from_fn(|a| f64::from(u8::from(a == D - 1)));
    let floor = Shape::HalfSpace { point: [0.0; D], normal };
    simulation.add_boundary(Boundary::at_rest(floor, Surface::Friction(0.4))).unwrap();
    simulation.set_gravity(normal.map(|n| -9.81 * n)).unwrap();
    for body in 0..4 {
        let centre = std::array::from_fn(|a| {
            if a == D - 1 { 0.32 } else { 0.45 * f64::from(body) * f64::from(u8::from(a == 0)) }
        });
        let SampledBody { positions, volumes } = ball::<D>(centre, 0.25);
        let velocities = falling(3.0, positions.len());
        let samples = Samples { positions: &positions, velocities: &velocities, volumes: &volumes };
        let number = match body {
            0 => simulation.add_body(FixedCorotated::new(lame()), 1000.0, samples),
            1 => simulation.add_tracked_body(
                DruckerPrager::new(lame(), FrictionAngle::constant(0.52).unwrap(), 0.0).unwrap(),
                1600.0,
                samples,
            ),
            2 => simulation.add_body(
                VonMises::new(lame(), YieldStress::perfect(3e3).unwrap()).unwrap(),
                2000.0,
                samples,
            ),
            _ => simulation.add_body(Tait::new(1e5, 7.0, Tension::Carried).unwrap(), 1000.0, samples),
        };
        assert_eq!(number.unwrap(), body as usize);
    }
    simulation
}

/// Four laws meet: masses and momenta add up, the floor holds everything, and the bits do not depend on the number of threads.
#[test]
fn bodies_of_different_laws_share_a_grid() {
    let run = |threads| {
        parallel::with_threads(threads, || {
            let mut simulation = mixture::<f64, 2>(Transfer::MlsApic);
            let before: f64 = (0..4).map(|body| simulation.totals(body).momentum.x).sum();
            let report = simulation.advance(0.02).unwrap();
            assert!(report.sorts >= 1);
            let lost = before - (0..4).map(|body| simulation.totals(body).momentum.x).sum::<f64>();
            (simulation.state_hash(), lost)
        })
    };
    let (hash, lost) = run(1);
    assert!(lost > 0.0, "friction takes momentum: {lost}");
    assert!([2, 3, 8].into_iter().all(|threads| run(threads) == (hash, lost)));
}

fn resumes<E: Element + checkpoint::Element, const D: usize>(transfer: Transfer) {
    let (mut whole, mut first) = (mixture::<E, D>(transfer), mixture::<E, D>(transfer));
    let mut sorts = 0;
    let step = |simulation: &mut Simulation<E, D>| {
        let step = simulation.stable_step().min(1e-3);
        simulation.step(step).unwrap()
    };
    for _ in 0..80 {
        sorts += u32::from(step(&mut whole).sorted);
    }
    assert!(sorts > 1, "sorted on the way");
    for _ in 0..37 {
        step(&mut first);
    }
    let bytes = first.checkpoint().to_bytes();
    let mut second = mixture::<E, D>(transfer);
    second.resume(Checkpoint::from_bytes(&bytes).unwrap()).unwrap();
    assert_eq!(second.state_hash(), first.state_hash());
    assert_eq!(second.stable_step(), first.stable_step());
    for _ in 37..80 {
        step(&mut second);
    }
    assert_eq!(second.checkpoint().to_bytes(), whole.checkpoint().to_bytes());
    assert_eq!((second.time(), second.steps()), (whole.time(), 80));
}

#[test]
fn a_resumed_run_is_the_uninterrupted_one() {
    resumes::<f64, 2>(Transfer::MlsApic);
    resumes::<f32, 3>(Transfer::Flip { flip: 0.95 });
    resumes::<f32, 2>(Transfer::Xpic { order: 3 });
    resumes::<f64, 2>(Transfer::ASFLIP);
}

/// A checkpoint with one array changed by `change`.
fn tampered<T: checkpoint::Element>(
    simulation: &Simulation<f64, 2>,
    name: &str,
    change: impl Fn(&mut Vec<T>),
) -> Checkpoint {
    let mut checkpoint = simulation.checkpoint();
    let mut array = checkpoint.take::<T>(name).unwrap();
    change(&mut array);
    checkpoint.put(name, &array);
    checkpoint
}

#[test]
fn checkpoints_of_other_states_are_refused() {
    let mut simulation = mixture::<f64, 2>(Transfer::MlsApic);
    simulation.step(1e-3).unwrap();
    let hash = simulation.state_hash();
    let cases = [
        tampered::<u32>(&simulation, "body 1/particles", |ids| ids[0] = 1_000_000),
        tampered::<u32>(&simulation, "body 1/particles", |ids| ids[0] = ids[1]),
        tampered::<u32>(&simulation, "body 0/block origins", |origins| origins[0] = 77),
        tampered::<u64>(&simulation, "body 2/block ends", |ends| ends[0] = u64::MAX),
        tampered::<u64>(&simulation, "body 2/block ends", |ends| ends[1] = 0),
        tampered::<f64>(&simulation, "body 3/numbers", |numbers| numbers.truncate(8)),
        tampered::<f64>(&simulation, "body 3/numbers", |numbers| numbers[0] = 40.0),
    ];
    for checkpoint in cases {
        assert!(matches!(simulation.resume(checkpoint), Err(ResumeError::Body { .. })));
        assert_eq!(simulation.state_hash(), hash);
    }
    assert!(matches!(simulation.resume(Checkpoint::new()), Err(ResumeError::Checkpoint(_))));
    let mut other = Simulation::<f64, 2>::new(SimulationOptions::new(0.1)).unwrap();
    assert!(matches!(
        other.resume(simulation.checkpoint()),
        Err(ResumeError::Bodies { stored: 4, wanted: 0 })
    ));
}

/// Two halves of a block run into each other so fast that one long step turns particles inside out.
fn crash<E: Element>(step: f64) -> (Simulation<E, 2>, Result<f64, MpmError>) {
    let mut simulation = Simulation::<E, 2>::new(SimulationOptions::new(0.1)).unwrap();
    let shape = Shape::Cuboid { centre: [0.0, 0.0], half: [0.8, 0.8] };
    let SampledBody { positions, volumes } = sample_shape(&shape, Pattern::regular(0.1, 2), 1).unwrap();
    let velocities: Vec<[f64; 2]> = positions.iter().map(|x| [-10.0 * x[0].signum(), 0.0]).collect();
    let samples = Samples { positions: &positions, velocities: &velocities, volumes: &volumes };
    simulation.add_body(NeoHookean::new(lame()), 1000.0, samples).unwrap();
    let result = simulation.step_unchecked(step).map(|report| report.speed);
    (simulation, result)
}

/// The fault is reported in the step that would make it, with the first particle, and nothing has moved.
#[test]
fn a_step_that_would_invert_a_particle_is_not_made() {
    // The harmless step is the same with and without a forecast: MLS gradients here are up to −20/0.1/2.
    let (simulation, result) = crash::<f64>(2e-3);
    assert!(result.is_ok() && simulation.steps() == 1);
    let (mut simulation, result) = crash::<f64>(2e-2);
    let Err(MpmError::Law { body: 0, particle, source: PointLawError::Elastic(_) }) = result else {
        panic!("{result:?}");
    };
    // At the plane x = 0 where the halves meet: columns of two particles a cell.
    let x = simulation.positions(0)[particle][0];
    assert!(x.abs() < 0.1, "{x}");
    let (fresh, _) = crash::<f64>(-1.0);
    assert_eq!(simulation.positions(0), fresh.positions(0));
    assert_eq!(simulation.velocities(0), fresh.velocities(0));
    assert_eq!((simulation.steps(), simulation.time()), (0, 0.0));
    // The order in memory has settled at the first attempt: from then on not a bit changes.
    let bytes = simulation.checkpoint().to_bytes();
    assert!(simulation.step_unchecked(2e-2).is_err());
    assert_eq!(simulation.checkpoint().to_bytes(), bytes);
    assert!(simulation.step_unchecked(1e-3).is_ok());
    let (_, single) = crash::<f32>(2e-2);
    assert!(matches!(single, Err(MpmError::Law { body: 0, .. })));
}

/// A particle that is not a number, one that is inside out, velocities whose nodes overflow, and a step as long as the universe is old: each is
/// an error that names its particle, and nothing has changed.
#[test]
fn broken_particles_are_named_and_left_alone() {
    let mut simulation = mixture::<f64, 2>(Transfer::MlsApic);
    simulation.step(1e-3).unwrap();
    let good = simulation.checkpoint();
    let first = good.clone().take::<u32>("body 0/particles").unwrap()[0] as usize;
    // By layout, four lanes a number: position 0–1, velocity 2–3, C 4–7, F 8–16.
    let cases: [(usize, f64, &str); 4] = [
        (0, f64::NAN, "position"),
        (2, f64::INFINITY, "velocity"),
        (5, f64::NAN, "velocity gradient"),
        (8, -1.0, ""),
    ];
    for (number, value, what) in cases {
        let broken = tampered::<f64>(&simulation, "body 0/numbers", |numbers| numbers[4 * number] = value);
        simulation.resume(broken).unwrap();
        let bytes = simulation.checkpoint().to_bytes();
        let result = simulation.step_unchecked(1e-3);
        match result {
            // Fixed corotated material is defined inside out: it is the only one that goes on.
            Ok(_) => assert_eq!(what, ""),
            Err(MpmError::Particle { body: 0, particle, what: found, .. }) => {
                assert_eq!((particle, found), (first, what));
                assert_eq!(simulation.checkpoint().to_bytes(), bytes);
            }
            Err(other) => panic!("{other}"),
        }
        simulation.resume(good.clone()).unwrap();
    }
    let sand = good.clone().take::<u32>("body 1/particles").unwrap()[0] as usize;
    let inverted = tampered::<f64>(&simulation, "body 1/numbers", |numbers| numbers[4 * 8] *= -1.0);
    simulation.resume(inverted).unwrap();
    let bytes = simulation.checkpoint().to_bytes();
    let error = simulation.step_unchecked(1e-3).unwrap_err();
    assert!(matches!(error, MpmError::Law { body: 1, particle, .. } if particle == sand), "{error}");
    assert_eq!(simulation.checkpoint().to_bytes(), bytes);
    simulation.resume(good.clone()).unwrap();
    for step in [1e20, 1e300] {
        assert!(simulation.step_unchecked(step).is_err());
        assert_eq!(simulation.checkpoint().to_bytes(), good.to_bytes());
    }
    simulation.set_gravity([1e308, 0.0]).unwrap();
    assert!(matches!(simulation.step_unchecked(10.0), Err(MpmError::Node { .. })));
    assert_eq!(simulation.checkpoint().to_bytes(), good.to_bytes());
}

/// A particle at a node sees the next one by the slope of its linear weight, though the weight is zero and the node has no velocity: ∂v/∂x = −v/Δx. A step that this would
/// turn inside out is refused though all nodes with mass have one velocity.
#[test]
fn a_particle_at_a_node_of_linear_weights_is_foreseen() {
    let options =
        SimulationOptions { kernel: Kernel::Linear, transfer: Transfer::FLIP, ..SimulationOptions::new(1.0) };
    let mut simulation = Simulation::<f64, 2>::new(options).unwrap();
    let samples = Samples { positions: &[[5.0, 3.0]], velocities: &[[3.0, 0.0]], volumes: &[0.25] };
    simulation.add_body(NeoHookean::new(lame()), 1000.0, samples).unwrap();
    let error = simulation.step_unchecked(0.5).unwrap_err();
    assert!(matches!(error, MpmError::Law { body: 0, particle: 0, .. }), "{error}");
    assert_eq!((simulation.steps(), simulation.positions(0)[0]), (0, [5.0, 3.0]));
    simulation.step_unchecked(1e-3).unwrap();
    assert_eq!(simulation.positions(0)[0], [5.0 + 3e-3, 3.0]);
}

#[test]
fn samples_are_checked_in_the_precision_of_particles() {
    let mut simulation = Simulation::<f32, 2>::new(SimulationOptions::new(0.1)).unwrap();
    let mut add = |position: [f64; 2], velocity: [f64; 2], volume: f64| {
        let samples = Samples {
            positions: &[[0.0; 2], position],
            velocities: &[[0.0; 2], velocity],
            volumes: &[1e-3, volume],
        };
        simulation.add_body(NeoHookean::new(lame()), 1000.0, samples)
    };
    for (position, velocity, volume) in [
        ([f64::NAN, 0.0], [0.0; 2], 1.0),
        ([1e39, 0.0], [0.0; 2], 1.0),
        ([0.0; 2], [0.0, 1e39], 1.0),
        ([0.0; 2], [0.0; 2], 0.0),
        ([0.0; 2], [0.0; 2], -1.0),
        ([0.0; 2], [0.0; 2], 1e-50),
        ([0.0; 2], [0.0; 2], 1e38),
    ] {
        let error = add(position, velocity, volume).unwrap_err();
        assert!(matches!(error, MpmError::Particle { body: 0, particle: 1, .. }), "{error}");
    }
    let error = add([0.0, 5e5], [0.0; 2], 1.0).unwrap_err();
    assert!(matches!(error, MpmError::OutOfDomain { body: 0, particle: 1, .. }), "{error}");
    assert_eq!(add([0.0; 2], [0.0; 2], 1.0), Ok(0));
}

/// What a double holds may be beyond an `f32`: fields are refused before anything is changed.
#[test]
fn fields_are_checked_in_the_precision_of_particles() {
    let mut simulation = Simulation::<f32, 2>::new(SimulationOptions::new(0.1)).unwrap();
    let samples = Samples { positions: &[[0.0; 2]; 2], velocities: &[[1.0; 2]; 2], volumes: &[1e-3; 2] };
    simulation.add_body(NeoHookean::new(lame()), 1000.0, samples).unwrap();
    let hash = simulation.state_hash();
    let refused = |result: Result<(), MpmError>| {
        let error = result.unwrap_err();
        assert!(matches!(error, MpmError::Particle { body: 0, particle: 1, .. }), "{error}");
    };
    refused(simulation.accelerate(0, &[[1.0; 2], [1e39, 0.0]], 1e-3));
    refused(simulation.accelerate(0, &[[1.0; 2], [0.0, 1e30]], 1e10));
    refused(simulation.set_velocity_gradients(0, &[[[0.0; 2]; 2], [[0.0, 1e39], [0.0; 2]]]));
    assert_eq!(simulation.state_hash(), hash);
    simulation.accelerate(0, &[[1.0; 2], [1e30, 0.0]], 1e-10).unwrap();
}

/// A body flies at the border of the domain: the step that would cross it fails and names the foremost particle; everything before is made.
#[test]
fn a_particle_that_leaves_the_domain_is_an_error() {
    for transfer in [Transfer::MlsApic, Transfer::FLIP] {
        let mut simulation =
            Simulation::<f64, 2>::new(SimulationOptions { transfer, ..SimulationOptions::new(0.1) }).unwrap();
        let SampledBody { positions, volumes } = ball::<2>([0.0; 2], 0.3);
        let velocities = vec![[2.0, 0.0]; positions.len()];
        let samples = Samples { positions: &positions, velocities: &velocities, volumes: &volumes };
        simulation.add_body(NeoHookean::new(lame()), 1000.0, samples).unwrap();
        let error = simulation.set_domain([-1.0, -1.0], [0.2, 1.0]).unwrap_err();
        let MpmError::OutOfDomain { body: 0, particle, .. } = error else { panic!("{error}") };
        assert_eq!(Some(particle), positions.iter().position(|x| x[0] > 0.2), "the first outside");
        simulation.set_domain([-1.0, -1.0], [1.0, 1.0]).unwrap();
        let foremost =
            (0..positions.len()).max_by(|a, b| positions[*a][0].total_cmp(&positions[*b][0])).unwrap();
        let start = positions[foremost][0];
        let mut steps = 0;
        let error = loop {
            let bytes = simulation.checkpoint().to_bytes();
            match simulation.step(2e-3) {
                Ok(_) => steps += 1,
                Err(error) => {
                    assert_eq!(simulation.checkpoint().to_bytes(), bytes);
                    break error;
                }
            }
        };
        let MpmError::OutOfDomain { body: 0, particle, position, .. } = error else { panic!("{error}") };
        assert_eq!(particle, foremost);
        assert!(position[0] > 1.0 && position[0] < 1.0 + 4e-3 + 1e-9);
        assert_eq!(steps, ((1.0 - start) / 4e-3) as u32);
    }
    let mut simulation = mixture::<f64, 2>(Transfer::MlsApic);
    let error = simulation.set_domain([0.0, 1.0], [1.0, 1.0]).unwrap_err();
    assert!(matches!(error, MpmError::Shape { value: 0.0, .. }), "{error}");
}

/// The total deformation gradient of sand in a homogeneous flow is the product of its increments, whatever the sand does.
#[test]
fn total_deformation_is_kept_beside_plastic_flow() {
    let mut simulation = mixture::<f64, 3>(Transfer::MlsApic);
    let mut buffer = DeformationBuffer::default();
    let start = simulation.positions(1);
    simulation.advance(0.01).unwrap();
    let positions = simulation.positions(1);
    let samples = simulation.deformation_samples(1, &mut buffer).unwrap();
    assert_eq!(samples.count(), start.len());
    assert!(samples.positions().iter().zip(&positions).all(|(a, b)| <[f64; 3]>::from(*a) == *b));
    let worst = samples.gradients().iter().map(|f| (f - Mat3::identity()).norm()).fold(0.0, f64::max);
    assert!(worst > 0.05, "the sand has hit the floor: {worst}");
    // F maps the lattice: against differences of neighbours that were within one cell of each other.
    let mut error = 0.0_f64;
    let mut pairs = 0;
    for (a, b) in (0..start.len()).flat_map(|a| (0..a).map(move |b| (a, b))) {
        let rest = mechanics_core::tensor::Vec3::from_fn(|k, _| start[a][k] - start[b][k]);
        if rest.norm() < 0.06 {
            let mean = (samples.gradients()[a] + samples.gradients()[b]) * 0.5;
            let now = samples.positions()[a] - samples.positions()[b];
            error = error.max((mean * rest - now).norm() / rest.norm());
            pairs += 1;
        }
    }
    assert!(pairs > 100 && error < 0.5 * worst, "{error} of {worst} over {pairs} pairs");
    assert!(simulation.deformation_samples(0, &mut buffer).is_ok(), "fixed corotated: F is the strain");
    for body in [2, 3] {
        let error = simulation.deformation_samples(body, &mut buffer).unwrap_err();
        assert_eq!(error, MpmError::NoTotalDeformation { body });
    }
}

/// A disk of fluid with γ = 16, thrown at a wall ten times as fast as its sound: K grows as J⁻¹⁵, by orders of magnitude. Steps that took the stiffness of the begin
/// for that of the end were refused, or gave it thirteen times its energy.
#[test]
fn a_fluid_that_stiffens_at_once_gains_no_energy() {
    let SampledBody { positions, volumes } = ball::<2>([0.0, 0.4], 0.3);
    let velocities = falling(100.0, positions.len());
    let mut simulation = Simulation::<f64, 2>::new(SimulationOptions::new(0.1)).unwrap();
    let samples = Samples { positions: &positions, velocities: &velocities, volumes: &volumes };
    simulation.add_body(Tait::new(1e5, 16.0, Tension::Carried).unwrap(), 1000.0, samples).unwrap();
    let floor = Shape::HalfSpace { point: [0.0; 2], normal: [0.0, 1.0] };
    simulation.add_boundary(Boundary::at_rest(floor, Surface::Friction(0.4))).unwrap();
    let energy = |simulation: &Simulation<f64, 2>| {
        let totals = simulation.totals(0);
        totals.kinetic_energy + totals.affine_energy + totals.stored_energy
    };
    let start = energy(&simulation);
    let mut densest = 1.0_f64;
    while simulation.time() < 0.01 {
        let step = simulation.stable_step();
        simulation.step(step).unwrap();
        assert!(
            energy(&simulation) < 1.000_001 * start,
            "{} s: {}",
            simulation.time(),
            energy(&simulation) / start
        );
        densest = simulation.states(0).iter().fold(densest, |least, state| least.min(state.volume_ratio));
    }
    assert!(densest < 0.7, "nothing was pressed: {densest}");
}
