//! Solids of triangles and grips inside the solve.

use crate::block::{Block, DENSITY, SPACING, lame};
use mechanics_core::mesh::{self, BoxSplit, TriMesh};
use mechanics_core::tensor::{Mat3, Vec3};
use mpm_constitutive::elastic::NeoHookean;
use mpm_core::{
    Boundary, Collider, DeformationBuffer, Grip, ImplicitStep, RigidMotion, Shape, Simulation,
    SimulationOptions, SolidMesh, Surface, Transfer,
};

const GRAVITY: f64 = 9.81;

fn cuboid(low: Vec3, high: Vec3) -> TriMesh {
    let solid = mesh::block(&low, &high, [2; 3], BoxSplit::default()).unwrap();
    mesh::Surface::of_tets(&solid).unwrap().into_mesh()
}

/// A block falls and slides on a box that moves: as a mesh and as a shape, for every surface; and the mesh has got what the block has lost.
#[test]
fn the_mesh_of_a_box_is_the_box_in_long_steps() {
    // No face comes to a node at the end of a step, where rounding would decide.
    let (middle, half) = (Vec3::new(0.1, 0.2, -0.4357), Vec3::new(0.8371, 0.7713, 0.41));
    let (h, steps) = (4e-3, 25);
    for surface in [Surface::Sticky, Surface::Slip, Surface::Separating, Surface::Friction(0.3)] {
        let velocity = [0.3, 0.1, 0.2];
        let options = ImplicitStep::default();
        let start = || {
            let block = Block::<3>::new([3, 3, 2], SPACING);
            let mut simulation = block.rubber(Transfer::MlsApic, |_| [0.7, -0.2, -1.0]);
            simulation.set_gravity([0.0, 0.0, -GRAVITY]).unwrap();
            simulation
        };
        let (mut shape, mut mesh) = (start(), start());
        let cuboidal = Shape::Cuboid { centre: middle.into(), half: half.into() };
        shape.add_boundary(Boundary { velocity, ..Boundary::at_rest(cuboidal, surface) }).unwrap();
        let solid = SolidMesh::new(&cuboid(middle - half, middle + half)).unwrap();
        let collider =
            mesh.add_collider(Collider::moving(solid, surface, RigidMotion::translation(velocity))).unwrap();
        let before = mesh.totals(0);
        for _ in 0..steps {
            shape.step_implicitly(h, &options).unwrap();
            mesh.step_implicitly(h, &options).unwrap();
        }
        let apart =
            shape.positions(0).iter().zip(mesh.positions(0)).fold(0.0_f64, |most, (a, b)| {
                most.max((0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f64::max))
            });
        let (after, load) = (mesh.totals(0), mesh.collider_load(collider).total.linear);
        let weight = Vec3::new(0.0, 0.0, -GRAVITY * before.mass * h * f64::from(steps));
        let left = after.momentum - before.momentum + load - weight;
        println!(
            "{surface:?}: {apart:.1e} m apart, load {load:?}, momentum from nowhere {:.1e} N s",
            left.norm()
        );
        assert!(apart < 1e-7, "{surface:?}: {apart}");
        assert!(load.z < -0.3 * before.mass, "{surface:?}: nothing happened, {load}");
        // What Newton leaves: a millionth of the speed in each step.
        assert!(left.norm() < 1e-4 * load.norm(), "{surface:?}: {left}");
    }
}

/// A block between walls, pressed by a plate of triangles to 95 % of its height, pushes back as much after long steps as after short damped ones, and about
/// as much as the closed form of its law says.
#[test]
fn a_pressed_block_rests_as_short_steps_bring_it() {
    let (side, way, duration) = (4.0 * SPACING, 0.02, 0.1);
    let law = NeoHookean::new(lame(1e5, 0.3));
    let start = || {
        let options = SimulationOptions { transfer: Transfer::Pic, ..SimulationOptions::new(SPACING) };
        let mut simulation = Block::<3>::new([4; 3], SPACING).simulation(options, law, |_| [0.0; 3]);
        let walls = Shape::Walls { low: [0.0; 3], high: [side, side, f64::INFINITY] };
        simulation.add_boundary(Boundary::at_rest(walls, Surface::Slip)).unwrap();
        let plate = cuboid(Vec3::new(-0.5, -0.5, side), Vec3::new(1.0, 1.0, side + 0.3));
        let plate = SolidMesh::new(&plate).unwrap();
        let motion = RigidMotion::translation([0.0, 0.0, -way / duration]);
        simulation.add_collider(Collider::moving(plate, Surface::Separating, motion)).unwrap();
        simulation
    };
    let force = |simulation: &mut Simulation<f64, 3>, wait: &dyn Fn(&mut Simulation<f64, 3>)| {
        simulation.set_collider_motion(0, RigidMotion::REST).unwrap();
        wait(simulation);
        let (from, before) = (simulation.time(), simulation.collider_load(0).total.linear.z);
        wait(simulation);
        (simulation.collider_load(0).total.linear.z - before) / (simulation.time() - from)
    };
    let mut short = start();
    short.advance(duration).unwrap();
    let short_force = force(&mut short, &|simulation| {
        simulation.advance(0.15).unwrap();
    });
    let mut long = start();
    let options = ImplicitStep::default();
    for _ in 0..5 {
        long.step_implicitly(duration / 5.0, &options).unwrap();
    }
    let long_force = force(&mut long, &|simulation| {
        for _ in 0..10 {
            simulation.step_implicitly(0.05, &options).unwrap();
        }
    });
    // P = μ (l − 1/l) + λ ln l/l where nothing moves sideways.
    let (l, lame) = (1.0 - way / side, lame(1e5, 0.3));
    let exact = -(lame.mu() * (l - 1.0 / l) + lame.lambda() * l.ln() / l) * side * side;
    println!("force: short steps {short_force:.2} N, long steps {long_force:.2} N, closed form {exact:.2} N");
    assert!((long_force / short_force - 1.0).abs() < 0.02, "{long_force} {short_force}");
    assert!((long_force / exact - 1.0).abs() < 0.2, "{long_force} {exact}");
    let height = |simulation: &Simulation<f64, 3>| {
        let all = simulation.positions(0);
        all.iter().map(|x| x[2]).sum::<f64>() / all.len() as f64
    };
    assert!((height(&short) - height(&long)).abs() < 0.02 * way, "{} {}", height(&short), height(&long));
}

/// A block that a grip turns goes where a rigid body goes, for long steps too, and is let go when it should be.
#[test]
fn grips_turn_what_they_hold() {
    let block = Block::<2>::new([4, 4], SPACING);
    let mut simulation = block.rubber(Transfer::MlsApic, |_| [0.0; 2]);
    let (velocity, spin, duration) = ([0.4, -0.3], 2.0, 0.3);
    let centre = [0.15, 0.25];
    let region = Shape::Ball { centre: [0.2, 0.2], radius: 0.6 };
    let angular_velocity = [0.0, 0.0, spin];
    let grip = Grip { region, centre, velocity, angular_velocity, from: 0.0, until: duration };
    simulation.add_grip(grip).unwrap();
    for _ in 0..10 {
        simulation.step_implicitly(duration / 10.0, &ImplicitStep::default()).unwrap();
    }
    let (sine, cosine) = (spin * duration).sin_cos();
    let turn = Mat3::new(cosine, -sine, 0.0, sine, cosine, 0.0, 0.0, 0.0, 1.0);
    let mut buffer = DeformationBuffer::default();
    let samples = simulation.deformation_samples(0, &mut buffer).unwrap();
    let middle = Vec3::new(centre[0], centre[1], 0.0);
    for (k, rest) in block.positions.iter().enumerate() {
        let arm = Vec3::new(rest[0], rest[1], 0.0) - middle;
        let expected = middle + Vec3::new(velocity[0], velocity[1], 0.0) * duration + turn * arm;
        assert!((samples.positions()[k] - expected).norm() < 1e-12);
        assert!((samples.gradients()[k] - turn).norm() < 1e-12, "{}", samples.gradients()[k]);
    }
    let before = simulation.totals(0).momentum;
    simulation.step_implicitly(0.01, &ImplicitStep::default()).unwrap();
    let change = (simulation.totals(0).momentum - before).norm();
    assert!(change < 1e-6 * DENSITY * 0.16 * 0.5, "nobody pushes it: {change}");
}
