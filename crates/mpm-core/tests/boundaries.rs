//! Boundaries, loads and regions against closed forms.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

#[path = "boundaries/distance.rs"]
mod distance;
#[path = "boundaries/kinds.rs"]
mod kinds;
#[path = "boundaries/parry.rs"]
mod parry;
#[path = "boundaries/sheets.rs"]
mod sheets;
#[path = "boundaries/solids.rs"]
mod solids;

use mechanics_core::law::Lame;
use mechanics_core::tensor::{Mat3, Vec3};
use mpm_constitutive::elastic::{FixedCorotated, NeoHookean};
use mpm_constitutive::fluid::{Tait, Tension};
use mpm_core::sampling::{Pattern, SampledBody, sample_shape};
use mpm_core::{
    Boundary, DeformationBuffer, Grip, MpmError, PrescribedVelocity, Samples, Shape, Simulation,
    SimulationOptions, Surface, Traction, Transfer,
};

const SPACING: f64 = 0.1;

fn soft() -> FixedCorotated {
    FixedCorotated::new(Lame::from_young_poisson(1e4, 0.3).unwrap())
}

/// A block of 4^D cells whose lower face is the floor x_D = 0, moving as one.
fn block_on_floor<const D: usize>(
    velocity: [f64; D],
    floor: Boundary<D>,
    gravity: [f64; D],
) -> Simulation<f64, D> {
    let mut simulation = Simulation::new(SimulationOptions::new(SPACING)).unwrap();
    let centre = std::array::from_fn(|a| if a == D - 1 { 0.2 } else { 0.0 });
    let SampledBody { positions, volumes } =
        sample_shape(&Shape::Cuboid { centre, half: [0.2; D] }, Pattern::regular(SPACING, 2), 1).unwrap();
    let velocities = vec![velocity; positions.len()];
    let samples = Samples { positions: &positions, velocities: &velocities, volumes: &volumes };
    simulation.add_body(soft(), 1000.0, samples).unwrap();
    simulation.add_boundary(floor).unwrap();
    simulation.set_gravity(gravity).unwrap();
    simulation
}

fn mean_velocity<const D: usize>(simulation: &Simulation<f64, D>) -> [f64; 3] {
    let totals = simulation.totals(0);
    (totals.momentum / totals.mass).into()
}

fn floor<const D: usize>(surface: Surface) -> Boundary<D> {
    let normal = std::array::from_fn(|a| f64::from(u8::from(a == D - 1)));
    Boundary::at_rest(Shape::HalfSpace { point: [0.0; D], normal }, surface)
}

/// A block that slides on a slip floor is not slowed, one on a separating floor neither; one on a sticky floor is.
#[test]
fn a_slip_floor_slips_and_a_sticky_one_holds() {
    let speed_after = |surface| {
        let mut simulation = block_on_floor::<3>([1.0, 0.0, 0.0], floor(surface), [0.0, 0.0, -9.81]);
        simulation.advance(0.05).unwrap();
        mean_velocity(&simulation)[0]
    };
    assert!((speed_after(Surface::Slip) - 1.0).abs() < 1e-12);
    assert!((speed_after(Surface::Separating) - 1.0).abs() < 1e-12);
    assert!((speed_after(Surface::Friction(0.0)) - 1.0).abs() < 1e-12);
    assert!(speed_after(Surface::Sticky) < 0.8);
}

/// A separating floor lets go, a slip floor does not: the block thrown upwards flies with v − g t, or is held.
#[test]
fn a_separating_floor_lets_go_and_a_slip_floor_does_not() {
    let speed_after = |surface| {
        let mut simulation = block_on_floor::<2>([0.3, 1.0], floor(surface), [0.0, -9.81]);
        simulation.advance(0.02).unwrap();
        mean_velocity(&simulation)
    };
    for surface in [Surface::Separating, Surface::Friction(0.5)] {
        let [along, up, _] = speed_after(surface);
        assert!(
            (along - 0.3).abs() < 1e-12 && (up - (1.0 - 9.81 * 0.02)).abs() < 1e-12,
            "{surface:?}: {along} {up}"
        );
    }
    assert!(speed_after(Surface::Slip)[1] < 0.75);
}

/// On a floor that pushes up with a = 9.81 m/s² the sliding block loses μ g t, and stops where that is all it has.
/// Free fall plus a floor moving with it would load nothing; here the load is gravity, and the block is let settle by PIC first.
#[test]
fn friction_is_coulombs() {
    let slowed = |coefficient: f64, time: f64| {
        let options = SimulationOptions { transfer: Transfer::Pic, ..SimulationOptions::new(SPACING) };
        let mut simulation = Simulation::<f64, 2>::new(options).unwrap();
        let shape = Shape::Cuboid { centre: [0.0, 0.1], half: [0.4, 0.1] };
        let SampledBody { positions, volumes } =
            sample_shape(&shape, Pattern::regular(SPACING, 2), 1).unwrap();
        let velocities = vec![[1.0, 0.0]; positions.len()];
        let samples = Samples { positions: &positions, velocities: &velocities, volumes: &volumes };
        simulation.add_body(soft(), 1000.0, samples).unwrap();
        simulation.add_boundary(floor(Surface::Friction(coefficient))).unwrap();
        simulation.set_gravity([0.0, -9.81]).unwrap();
        simulation.advance(time).unwrap();
        // The impulse of the floor, vertical and along: Coulomb's law binds them whatever the bounce does.
        let [along, up, _] = mean_velocity(&simulation);
        (1.0 - along, up + 9.81 * time)
    };
    for coefficient in [0.1, 0.3] {
        let (lost, pushed) = slowed(coefficient, 0.05);
        assert!(pushed > 0.2, "the floor has pushed: {pushed}");
        assert!(
            (lost - coefficient * pushed).abs() < 1e-10,
            "{coefficient}: {lost} of {}",
            coefficient * pushed
        );
    }
    // A floor rough enough brings it to rest, not beyond.
    let (lost, _) = slowed(1.5, 2.0);
    assert!((lost - 1.0).abs() < 0.02, "{lost}");
}

/// Every surface on every shape, at points where the normal is known.
#[test]
fn surfaces_act_on_shapes_as_their_table_says() {
    let normal = [0.6, 0.8];
    let cases: [(Shape<2>, [f64; 2], [f64; 2]); 5] = [
        (Shape::HalfSpace { point: [1.0, 1.0], normal }, [0.0, 0.0], normal),
        (Shape::Ball { centre: [0.0, 0.0], radius: 1.0 }, [0.3, 0.4], normal),
        (Shape::Cuboid { centre: [0.0, 0.0], half: [1.0, 2.0] }, [0.9, 0.5], [1.0, 0.0]),
        (Shape::Capsule { from: [-4.0, 3.0], to: [0.0, 0.0], radius: 1.0 }, [-1.4, 2.3], [0.6, 0.8]),
        (Shape::Walls { low: [0.0, -5.0], high: [1.0, 5.0] }, [-0.1, 0.0], [1.0, 0.0]),
    ];
    let own = [0.2, -0.3];
    for (shape, point, n) in cases {
        for w in [[-1.0, -0.5], [2.0, 0.25], [0.7, -0.9]] {
            let velocity = [own[0] + w[0], own[1] + w[1]];
            let approach = w[0] * n[0] + w[1] * n[1];
            let t = [w[0] - approach * n[0], w[1] - approach * n[1]];
            let sliding = t[0].hypot(t[1]);
            let expected = |surface| match surface {
                Surface::Sticky => [0.0, 0.0],
                Surface::Slip => t,
                _ if approach >= 0.0 => w,
                Surface::Separating => t,
                Surface::Friction(mu) => {
                    // The sliding loses min(μ |w·n|, ‖t‖).
                    let left = sliding - (mu * approach.abs()).min(sliding);
                    t.map(|t| t * left / sliding)
                }
            };
            for surface in [
                Surface::Sticky,
                Surface::Slip,
                Surface::Separating,
                Surface::Friction(0.4),
                Surface::Friction(9.0),
            ] {
                // Moved for two seconds, the shape is where it was less the way.
                let boundary = Boundary { shape, surface, velocity: own };
                let place = [point[0] + 2.0 * own[0], point[1] + 2.0 * own[1]];
                let found = boundary.act(&place, 2.0, &velocity);
                let e = expected(surface);
                let error = (found[0] - own[0] - e[0]).hypot(found[1] - own[1] - e[1]);
                assert!(error < 1e-14, "{shape:?} {surface:?} {w:?}: {found:?} for {e:?}");
            }
        }
        let boundary = Boundary::at_rest(shape, Surface::Sticky);
        let far = [point[0] + 0.5 + 9.0 * n[0], point[1] + 9.0 * n[1]];
        if !matches!(shape, Shape::Walls { .. }) {
            assert_eq!(boundary.act(&far, 0.0, &[1.0, 2.0]), [1.0, 2.0]);
        }
    }
}

/// A moving sticky floor carries the block along; a piston of prescribed velocity does so while it acts.
#[test]
fn moving_floors_and_pistons_carry() {
    let moving = Boundary { velocity: [0.5, 0.0], ..floor::<2>(Surface::Sticky) };
    let mut simulation = block_on_floor::<2>([0.0, 0.0], moving, [0.0, 0.0]);
    simulation.advance(1.5).unwrap();
    // It sways about the floor's velocity: the mean displacement is what counts.
    let mean =
        simulation.positions(0).iter().map(|x| x[0]).sum::<f64>() / simulation.particle_count(0) as f64;
    assert!((mean - 0.75).abs() < 0.15, "{mean}");

    let mut simulation = block_on_floor::<2>([0.0, 0.0], floor(Surface::Slip), [0.0, 0.0]);
    let region = Shape::Cuboid { centre: [0.0, 0.0], half: [5.0, 5.0] };
    let grip = PrescribedVelocity { region, velocity: [0.7, 0.0], from: 0.01, until: 0.02 };
    simulation.add_prescribed_velocity(grip).unwrap();
    for _ in 0..10 {
        simulation.step(1e-3).unwrap();
    }
    assert_eq!(mean_velocity(&simulation)[0], 0.0);
    simulation.step(1e-3).unwrap();
    assert!((mean_velocity(&simulation)[0] - 0.7).abs() < 1e-14);
    simulation.advance(0.05).unwrap();
    assert!((mean_velocity(&simulation)[0] - 0.7).abs() < 1e-12, "it keeps what it was given");
}

/// A block that a grip carries and turns goes exactly where a rigid body goes, deformed by the rotation alone, for whatever steps; let go, it keeps the velocities of the last step.
#[test]
fn a_grip_carries_and_turns_exactly_and_lets_go() {
    let region = Shape::Cuboid { centre: [0.0, 0.0, 0.2], half: [0.45, 0.45, 0.45] };
    let (velocity, spin) = (Vec3::new(0.4, -0.3, 0.5), Vec3::new(1.0, 2.0, -3.0));
    let centre = Vec3::new(0.05, 0.0, 0.2);
    let grip = Grip {
        region,
        centre: centre.into(),
        velocity: velocity.into(),
        angular_velocity: spin.into(),
        from: 0.0,
        // The sum of the steps may round below: the step after it must not act.
        until: 0.3,
    };
    let far = Boundary::at_rest(Shape::Ball { centre: [9.0; 3], radius: 0.1 }, Surface::Slip);
    let mut simulation = block_on_floor::<3>([0.0; 3], far, [0.0; 3]);
    simulation.add_grip(grip).unwrap();
    let rest: Vec<Vec3> = simulation.positions(0).into_iter().map(Vec3::from).collect();
    simulation.advance(0.3).unwrap();
    let turn = exponential(spin * 0.3);
    let mut buffer = DeformationBuffer::default();
    let samples = simulation.deformation_samples(0, &mut buffer).unwrap();
    for (k, rest) in rest.iter().enumerate() {
        let expected = centre + velocity * 0.3 + turn * (rest - centre);
        assert!((samples.positions()[k] - expected).norm() < 1e-12, "{}", samples.positions()[k] - expected);
        assert!((samples.gradients()[k] - turn).norm() < 1e-12, "{}", samples.gradients()[k]);
    }
    let momentum = simulation.totals(0).momentum;
    simulation.advance(0.1).unwrap();
    let change = simulation.totals(0).momentum - momentum;
    assert!(
        change.norm() < 1e-10 * momentum.norm(),
        "nobody pushes it: {change:?} of {momentum:?} at {}",
        simulation.time()
    );

    let mut plane = block_on_floor::<2>([0.0; 2], floor(Surface::Slip), [0.0; 2]);
    let region = Shape::Ball { centre: [0.0; 2], radius: 1.0 };
    let good = Grip {
        region,
        centre: [0.0; 2],
        velocity: [0.0; 2],
        angular_velocity: [0.0, 0.0, 1.0],
        from: 0.0,
        until: 1.0,
    };
    plane.add_grip(good).unwrap();
    for bad in [
        Grip { until: 0.0, ..good },
        Grip { angular_velocity: [1.0, 0.0, 0.0], ..good },
        Grip { region: Shape::Ball { centre: [0.0; 2], radius: -1.0 }, ..good },
    ] {
        assert!(matches!(plane.add_grip(bad), Err(MpmError::Shape { .. })), "{bad:?}");
    }
    for bad in [Grip { velocity: [f64::NAN, 0.0], ..good }, Grip { from: f64::INFINITY, ..good }] {
        assert!(matches!(plane.add_grip(bad), Err(MpmError::Number { .. })), "{bad:?}");
    }
}

/// R by the length of a vector about its direction, as the product of a thousand and twenty-four small ones of order four.
fn exponential(vector: Vec3) -> Mat3 {
    let [x, y, z] = (vector / 1024.0).into();
    let k = Mat3::new(0.0, -z, y, z, 0.0, -x, -y, x, 0.0);
    let mut turn = Mat3::identity() + k + k * k / 2.0 + k * k * k / 6.0 + k * k * k * k / 24.0;
    for _ in 0..10 {
        turn = turn * turn;
    }
    turn
}

/// A bar on a frictionless wall, stretched by λ = 1.1 from the start and pulled at its end by the first Piola stress of that stretch, stays as it is:
/// ν = 0 makes it one-dimensional, P = μ (λ − 1/λ), and keeps the width, so that all three tractions are the same force. Without the traction,
/// or with a wrong one, it would swing about another length by the difference.
#[test]
fn a_bar_pulled_at_its_end_has_the_closed_form_stretch() {
    let young = 1e4;
    let lame = Lame::from_young_poisson(young, 0.0).unwrap();
    let (stretch, mu) = (1.1_f64, 0.5 * young);
    let traction = mu * (stretch - 1.0 / stretch);
    let pulls = [
        Traction::Nominal([traction, 0.0]),
        Traction::Cauchy([traction, 0.0]),
        Traction::Pressure(-traction),
    ];
    for pull in pulls {
        let mut simulation = Simulation::<f64, 2>::new(SimulationOptions::new(SPACING)).unwrap();
        let shape = Shape::Cuboid { centre: [0.75, 0.1], half: [0.75, 0.1] };
        let SampledBody { positions: rest, volumes } =
            sample_shape(&shape, Pattern::regular(SPACING, 2), 1).unwrap();
        let positions: Vec<[f64; 2]> = rest.iter().map(|x| [stretch * x[0], x[1]]).collect();
        let velocities = vec![[0.0; 2]; rest.len()];
        let samples = Samples { positions: &positions, velocities: &velocities, volumes: &volumes };
        simulation.add_body(NeoHookean::new(lame), 1000.0, samples).unwrap();
        let gradient = Mat3::from_diagonal(&Vec3::new(stretch, 1.0, 1.0));
        simulation.set_deformation_gradients(0, &vec![gradient; rest.len()]).unwrap();
        let wall = Shape::HalfSpace { point: [0.0, 0.0], normal: [1.0, 0.0] };
        simulation.add_boundary(Boundary::at_rest(wall, Surface::Slip)).unwrap();
        let end: Vec<(usize, [f64; 2])> =
            (0..rest.len()).filter(|p| rest[*p][0] > 1.45).map(|p| (p, [0.05, 0.0])).collect();
        assert_eq!(end.len(), 4);
        simulation.add_traction(0, pull, &end).unwrap();
        // In the middle, away from both ends.
        let pick = |x: f64| (0..rest.len()).find(|p| (rest[*p][0] - x).abs() < 1e-9).unwrap();
        let (left, right) = (pick(0.325), pick(1.125));
        let mut largest = 0.0_f64;
        for _ in 0..40 {
            // Two and a half periods of the bar, 4 L/c each.
            simulation.advance(0.12).unwrap();
            let now = simulation.positions(0);
            largest = largest.max(((now[right][0] - now[left][0]) / 0.8 - stretch).abs());
        }
        println!("{pull:?}: {largest:.2e}");
        assert!(largest < 3e-3, "{pull:?}: off by {largest}");
    }
}

/// Impulses change momenta by what they are, and tractions by force times time, moments included.
#[test]
fn impulses_and_tractions_add_up() {
    for transfer in [Transfer::MlsApic, Transfer::FLIP, Transfer::Pic, Transfer::APIC] {
        let mut simulation =
            Simulation::<f64, 3>::new(SimulationOptions { transfer, ..SimulationOptions::new(SPACING) })
                .unwrap();
        let shape = Shape::Ball { centre: [0.1, 0.2, 0.3], radius: 0.2 };
        let SampledBody { positions, volumes } =
            sample_shape(&shape, Pattern::per_cell(SPACING, 2), 1).unwrap();
        let velocities = vec![[0.0; 3]; positions.len()];
        let samples = Samples { positions: &positions, velocities: &velocities, volumes: &volumes };
        simulation.add_body(soft(), 1000.0, samples).unwrap();
        simulation
            .apply_impulses(0, &[(3, [1.0, 2.0, 3.0]), (17, [0.0, 0.0, -1.0]), (3, [0.5, 0.0, 0.0])])
            .unwrap();
        let momentum = simulation.totals(0).momentum;
        assert!((momentum - mechanics_core::tensor::Vec3::new(1.5, 2.0, 2.0)).norm() < 1e-13);
        simulation
            .add_traction(
                0,
                Traction::Nominal([100.0, 0.0, 50.0]),
                &[(5, [0.0, 0.03, 0.04]), (60, [0.1, 0.0, 0.0])],
            )
            .unwrap();
        for _ in 0..25 {
            simulation.step(2e-4).unwrap();
        }
        let gained = simulation.totals(0).momentum - momentum;
        let expected = mechanics_core::tensor::Vec3::new(15.0, 0.0, 7.5) * 5e-3;
        assert!((gained - expected).norm() < 1e-13, "{transfer:?}: {gained:?}");
        simulation.clear_tractions(0);
        simulation.step(2e-4).unwrap();
        assert!((simulation.totals(0).momentum - momentum - expected).norm() < 1e-13);
    }
}

#[test]
fn shapes_regions_and_loads_are_checked() {
    let mut simulation = block_on_floor::<3>([0.0; 3], floor(Surface::Slip), [0.0; 3]);
    let hash = simulation.state_hash();
    let half_space = |normal| Shape::HalfSpace { point: [0.0; 3], normal };
    let shapes = [
        half_space([0.0, 0.0, 0.0]),
        half_space([0.0, 0.0, 2.0]),
        half_space([0.0, f64::NAN, 1.0]),
        Shape::Ball { centre: [0.0; 3], radius: 0.0 },
        Shape::Ball { centre: [0.0; 3], radius: f64::INFINITY },
        Shape::Cuboid { centre: [0.0; 3], half: [1.0, -1.0, 1.0] },
        Shape::Capsule { from: [0.0; 3], to: [1.0; 3], radius: -1.0 },
        Shape::Walls { low: [0.0; 3], high: [1.0, 0.0, 1.0] },
    ];
    for shape in shapes {
        let error = simulation.add_boundary(Boundary::at_rest(shape, Surface::Slip)).unwrap_err();
        assert!(matches!(error, MpmError::Shape { .. }), "{shape:?}: {error}");
    }
    let error = simulation.add_boundary(floor(Surface::Friction(-0.1))).unwrap_err();
    assert!(matches!(error, MpmError::Number { value: -0.1, .. }), "{error}");
    let region = Shape::Ball { centre: [0.0; 3], radius: 1.0 };
    let prescribed = PrescribedVelocity { region, velocity: [0.0; 3], from: 1.0, until: 1.0 };
    assert!(matches!(
        simulation.add_prescribed_velocity(prescribed),
        Err(MpmError::Shape { value: 1.0, .. })
    ));
    let count = simulation.particle_count(0);
    let error = simulation.apply_impulses(0, &[(0, [1.0; 3]), (count, [0.0; 3])]).unwrap_err();
    assert_eq!(error, MpmError::NoParticle { body: 0, particle: count, particles: count });
    let error = simulation.apply_impulses(0, &[(0, [1.0; 3]), (1, [0.0, f64::NAN, 0.0])]).unwrap_err();
    assert!(matches!(error, MpmError::Particle { particle: 1, .. }), "{error}");
    let pull = Traction::Nominal([1.0, 0.0, 0.0]);
    let error = simulation.add_traction(0, pull, &[(0, [1.0, 0.0, 0.0]), (7, [0.0; 3])]).unwrap_err();
    assert!(matches!(error, MpmError::Particle { particle: 7, value: 0.0, .. }), "{error}");
    assert_eq!(simulation.state_hash(), hash);
    let water = Tait::new(1e5, 7.0, Tension::Carried).unwrap();
    let samples = Samples { positions: &[[0.0; 3]], velocities: &[[0.0; 3]], volumes: &[1e-3] };
    let fluid = simulation.add_body(water, 1000.0, samples).unwrap();
    let error = simulation.add_traction(fluid, Traction::Pressure(1.0), &[(0, [1.0, 0.0, 0.0])]).unwrap_err();
    assert_eq!(error, MpmError::NoTotalDeformation { body: 1 });
}
