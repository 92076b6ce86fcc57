//! Solids as colliders: against the same shape as a boundary, against node sums by hand, and against Coulomb's law.

use crate::distance::{bunny, cuboid, places};
use crate::parry::Parry;
use mechanics_core::law::Lame;
use mechanics_core::mesh::{TriMesh, sphere};
use mechanics_core::parallel::with_threads;
use mechanics_core::tensor::Vec3;
use mpm_constitutive::elastic::FixedCorotated;
use mpm_core::sampling::{Pattern, sample_shape};
use mpm_core::{
    Boundary, Collider, MpmError, RigidMotion, Samples, Shape, Simulation, SimulationOptions, SolidMesh,
    Surface, Transfer,
};
use nalgebra::Rotation3;
use std::collections::BTreeMap;

pub(crate) const KINDS: [Surface; 4] =
    [Surface::Sticky, Surface::Slip, Surface::Separating, Surface::Friction(0.3)];
const SPACING: f64 = 0.1;

pub(crate) fn simulation(
    transfer: Transfer,
    positions: &[[f64; 3]],
    velocities: &[[f64; 3]],
) -> Simulation<f64, 3> {
    simulation_of(Lame::from_young_poisson(1e4, 0.3).unwrap(), transfer, positions, velocities)
}

fn simulation_of(
    lame: Lame,
    transfer: Transfer,
    positions: &[[f64; 3]],
    velocities: &[[f64; 3]],
) -> Simulation<f64, 3> {
    let options = SimulationOptions { transfer, ..SimulationOptions::new(SPACING) };
    let mut simulation = Simulation::new(options).unwrap();
    let volumes = vec![SPACING.powi(3) / 8.0; positions.len()];
    simulation
        .add_body(FixedCorotated::new(lame), 1000.0, Samples { positions, velocities, volumes: &volumes })
        .unwrap();
    simulation
}

/// A block falls and slides on a box that moves: as a mesh and as a shape, for every surface.
#[test]
fn the_mesh_of_a_box_is_the_box() {
    let half = Vec3::new(0.83, 0.77, 0.41);
    let above = Shape::Cuboid { centre: [0.03, 0.02, 0.5], half: [0.2, 0.2, 0.1] };
    let positions = sample_shape(&above, Pattern::per_cell(SPACING, 2), 1).unwrap().positions;
    let velocities = vec![[0.7, -0.2, -1.0]; positions.len()];
    for surface in KINDS {
        let velocity = [0.3, 0.1, 0.5];
        let mut shape = simulation(Transfer::MlsApic, &positions, &velocities);
        let boundary = Boundary {
            velocity,
            ..Boundary::at_rest(Shape::Cuboid { centre: [0.0; 3], half: half.into() }, surface)
        };
        shape.add_boundary(boundary).unwrap();
        let mut mesh = simulation(Transfer::MlsApic, &positions, &velocities);
        let solid = SolidMesh::new(&cuboid(-half, half, 2)).unwrap();
        mesh.add_collider(Collider::moving(solid, surface, RigidMotion::translation(velocity))).unwrap();
        for simulation in [&mut shape, &mut mesh] {
            simulation.set_gravity([0.0, 0.0, -9.81]).unwrap();
            for _ in 0..120 {
                simulation.step(1e-3).unwrap();
            }
        }
        let apart =
            shape.positions(0).iter().zip(mesh.positions(0)).fold(0.0_f64, |most, (a, b)| {
                most.max((0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f64::max))
            });
        println!("{surface:?}: {apart:.1e} m apart after 120 steps");
        assert!(apart < 1e-12, "{surface:?}: {apart}");
        let bounced = shape.totals(0).momentum.z / shape.totals(0).mass + 1.0 + 9.81 * 0.12;
        assert!(bounced > 0.3, "{surface:?}: nothing happened, {bounced}");
    }
}

/// Masses and momenta that particles give to nodes with quadratic kernels, written down anew.
fn nodes_by_hand(
    positions: &[[f64; 3]],
    velocities: &[[f64; 3]],
    mass: f64,
) -> BTreeMap<[i64; 3], (f64, Vec3)> {
    let mut nodes: BTreeMap<[i64; 3], (f64, Vec3)> = BTreeMap::new();
    let weight = |r: f64| match r.abs() {
        r if r < 0.5 => 0.75 - r * r,
        r if r < 1.5 => 0.5 * (1.5 - r).powi(2),
        _ => 0.0,
    };
    for (x, v) in positions.iter().zip(velocities) {
        let base = x.map(|x| (x / SPACING).round() as i64);
        for k in 0..27_i64 {
            let node = [base[0] + k / 9 - 1, base[1] + k / 3 % 3 - 1, base[2] + k % 3 - 1];
            let w: f64 = (0..3).map(|a| weight(x[a] / SPACING - node[a] as f64)).product();
            let entry = nodes.entry(node).or_insert((0.0, Vec3::zeros()));
            entry.0 += w * mass;
            entry.1 += Vec3::from(*v) * (w * mass);
        }
    }
    nodes
}

/// The table of the module `boundary`, written down anew.
pub(crate) fn by_table(surface: Surface, w: Vec3, n: Vec3) -> Vec3 {
    let (approach, along) = (w.dot(&n), w - n * w.dot(&n));
    match surface {
        Surface::Sticky => Vec3::zeros(),
        Surface::Slip => along,
        _ if approach >= 0.0 => w,
        Surface::Separating => along,
        Surface::Friction(_) if along.norm() == 0.0 => along,
        Surface::Friction(mu) => along * (1.0 + mu * approach / along.norm()).max(0.0),
    }
}

/// One step of particles around a turning bunny: sums over nodes by hand, distances by another library, motion by its formula.
#[test]
fn a_step_around_a_turning_bunny_is_the_sum_by_hand() {
    let mut mesh = bunny();
    let bounds = mesh.bounding_box().unwrap();
    mesh.translate(&-bounds.centre()).unwrap();
    mesh.scale(1.0 / bounds.size().max()).unwrap();
    let (solid, parry) = (SolidMesh::new(&mesh).unwrap(), Parry::new(&mesh));
    let positions: Vec<[f64; 3]> = places(6000, Vec3::zeros(), Vec3::repeat(0.6))
        .into_iter()
        .filter(|place| solid.signed_distance((*place).into()).distance > 0.01)
        .map(Into::into)
        .collect();
    let velocities: Vec<[f64; 3]> =
        positions.iter().map(|x| [x[1] - 0.3 * x[2], 0.4 - x[0], 0.5 * x[0] * x[1] - 0.2]).collect();
    let (step, mass) = (1e-3, 1000.0 * SPACING.powi(3) / 8.0);
    let (centre, velocity, spin) =
        (Vec3::new(0.1, 0.0, -0.2), Vec3::new(0.3, -0.5, 0.2), Vec3::new(1.0, 2.0, -1.5));
    let motion =
        RigidMotion { centre: centre.into(), velocity: velocity.into(), angular_velocity: spin.into() };
    let turn = Rotation3::new(spin * step);
    let moved = centre + velocity * step;
    for surface in KINDS {
        let mut simulation = simulation(Transfer::Pic, &positions, &velocities);
        simulation.add_collider(Collider::moving(solid.clone(), surface, motion)).unwrap();
        simulation.step(step).unwrap();
        let (mut kept, mut given, mut moment, mut inside) = (Vec3::zeros(), Vec3::zeros(), Vec3::zeros(), 0);
        for (node, (mass, momentum)) in nodes_by_hand(&positions, &velocities, mass) {
            if mass == 0.0 {
                continue;
            }
            let place = Vec3::from(node.map(|k| k as f64 * SPACING));
            let own = centre + turn.inverse() * (place - moved);
            let (distance, normal) = parry.signed_distance(&own);
            let mut v = momentum / mass;
            if distance <= 0.0 {
                let u = velocity + spin.cross(&(place - moved));
                let after = by_table(surface, v - u, turn * normal) + u;
                given += (v - after) * mass;
                moment += place.cross(&((v - after) * mass));
                (v, inside) = (after, inside + 1);
            }
            kept += v * mass;
        }
        let (found, load) = (simulation.totals(0).momentum, simulation.collider_load(0));
        println!("{surface:?}: {inside} nodes inside take {:.3} N s", given.norm());
        assert!(inside > 100 && given.norm() > 1e-2);
        assert!((found - kept).norm() < 1e-10, "{surface:?}: {found} instead of {kept}");
        assert!((load.step.linear - given).norm() < 1e-10 && (load.step.angular - moment).norm() < 1e-10);
        assert_eq!(load.step, load.total);
    }
}

/// A ball that turns, moves, and is stopped amid a block: what is remembered changes no bit, threads do not, a checkpoint goes on.
#[test]
fn memory_threads_and_checkpoints_change_no_bit() {
    let ball = SolidMesh::new(&sphere(0.25, 5).unwrap()).unwrap();
    let block = Shape::Cuboid { centre: [0.0, 0.0, 0.5], half: [0.3, 0.3, 0.2] };
    let positions = sample_shape(&block, Pattern::per_cell(SPACING, 2), 3).unwrap().positions;
    let start = || {
        let mut simulation =
            simulation(Transfer::MlsApic, &positions, &vec![[0.0, 0.0, -2.0]; positions.len()]);
        let motion =
            RigidMotion { centre: [0.0; 3], velocity: [0.1, 0.0, 0.5], angular_velocity: [0.0, 4.0, 1.0] };
        simulation.add_collider(Collider::moving(ball.clone(), Surface::Friction(0.4), motion)).unwrap();
        simulation
    };
    let stop = |simulation: &mut Simulation<f64, 3>, step: usize| {
        if step == 30 {
            simulation
                .set_collider_motion(0, RigidMotion::rotation([0.0, 0.0, 0.1], [0.0, 0.0, 9.0]))
                .unwrap();
        }
        if step == 45 {
            simulation.set_collider_motion(0, RigidMotion::REST).unwrap();
        }
        simulation.step(2e-3).unwrap();
    };
    let run = |threads| {
        with_threads(threads, || {
            let mut simulation = start();
            (0..60).for_each(|step| stop(&mut simulation, step));
            (simulation.state_hash(), simulation.collider_load(0))
        })
    };
    let whole = run(1);
    assert!(whole.1.total.linear.norm() > 1.0);
    assert_eq!(whole, run(3));
    let mut parts = start();
    for step in 0..60 {
        // Whoever resumes remembers nothing.
        let checkpoint = parts.checkpoint();
        parts = start();
        parts.resume(checkpoint).unwrap();
        stop(&mut parts, step);
    }
    assert_eq!(whole, (parts.state_hash(), parts.collider_load(0)));
    let exact = Vec3::new(0.1, 0.0, 0.5) * 0.06;
    // It then turned about a fixed point of space for 0.03 s.
    let moved = Rotation3::new(Vec3::z() * 0.27) * (exact - Vec3::z() * 0.1) + Vec3::z() * 0.1;
    let middle = parts.collider_placement(0).place(&Vec3::zeros());
    assert!((middle - moved).norm() < 1e-14, "{middle} instead of {moved}");
    let centroid = parts.collider_mesh(0).centroid().unwrap();
    assert!((centroid - middle).norm() < 1e-12);
}

/// On a slope of a mesh: gravity is tilted. Each impulse across takes μ times itself from the sliding, and the acceleration is
/// g (sin θ − μ cos θ); beyond tan θ it stops.
pub(crate) fn slides_as_coulomb_says(name: &str, floor: impl Fn(Surface) -> Collider) {
    const GRAVITY: f64 = 9.81;
    let slab = Shape::Cuboid { centre: [0.0, 0.0, 0.1], half: [0.2, 0.2, 0.1] };
    let positions = sample_shape(&slab, Pattern::regular(SPACING, 2), 1).unwrap().positions;
    for (degrees, coefficient, acceleration) in
        [(30.0, 0.0, 4.905), (30.0, 0.2, 3.205_858), (30.0, 0.4, 1.506_716), (45.0, 0.5, 3.468_359_f64)]
    {
        let (sine, cosine) = f64::to_radians(degrees).sin_cos();
        let speed = 1.0;
        // Without lateral strain all slides along x, and friction adds up.
        let lame = Lame::from_young_poisson(1e6, 0.0).unwrap();
        let velocities = vec![[speed, 0.0, 0.0]; positions.len()];
        let mut simulation = simulation_of(lame, Transfer::MlsApic, &positions, &velocities);
        simulation.set_gravity([GRAVITY * sine, 0.0, -GRAVITY * cosine]).unwrap();
        let surface = if coefficient == 0.0 { Surface::Slip } else { Surface::Friction(coefficient) };
        simulation.add_collider(floor(surface)).unwrap();
        let time = 0.3;
        for _ in 0..200 {
            simulation.step(time / 200.0).unwrap();
        }
        let totals = simulation.totals(0);
        let velocity = totals.momentum / totals.mass;
        let load = simulation.collider_load(0).total.linear / totals.mass;
        // What gravity gave is in the body or in the floor.
        let start = Vec3::new(speed, 0.0, 0.0);
        let gained = velocity - start + load - Vec3::new(sine, 0.0, -cosine) * (GRAVITY * time);
        // Friction is along the sliding of each node, which the shear at the edges turns a little: sums along x fall short by its square.
        let missing = coefficient * -load.z - load.x;
        let found = (velocity.x - speed) / time;
        let settled = acceleration - coefficient * velocity.z / time;
        println!(
            "{name}, {degrees}°, {surface:?}: {found:.4} m/s² of {acceleration:.4}; less the bounce {:.1e} off; friction missing {missing:.1e}",
            found - settled
        );
        assert!(gained.norm() < 1e-10, "{name}, {surface:?}: {gained}");
        assert!(
            (-1e-10..=1e-4 * load.x.abs() + 1e-10).contains(&missing),
            "{name}, {surface:?}: {missing:e}"
        );
        // The closed forms above have seven digits.
        assert!((found - settled).abs() < 1e-4 * acceleration, "{name}, {surface:?}: {found}");
        assert!((found / acceleration - 1.0).abs() < 0.12, "{name}, {surface:?}: {found}");
    }
}

#[test]
fn blocks_slide_on_a_mesh_as_coulomb_says() {
    let floor = SolidMesh::new(&cuboid(Vec3::new(-1.0, -1.0, -0.5), Vec3::new(2.0, 1.0, 0.0), 4)).unwrap();
    slides_as_coulomb_says("solid", |surface| Collider::at_rest(floor.clone(), surface));
}

#[test]
fn particles_inside_at_the_start_are_named() {
    let ball = SolidMesh::new(&sphere(0.5, 6).unwrap()).unwrap();
    let at = |x: f64| [x, 0.0, 0.0];
    let mut simulation = simulation(Transfer::MlsApic, &[at(0.9), at(0.4), at(0.3)], &[[0.0; 3]; 3]);
    let hash = simulation.state_hash();
    let error = simulation.add_collider(Collider::at_rest(ball.clone(), Surface::Slip)).unwrap_err();
    assert!(
        matches!(error, MpmError::InCollider { body: 0, particle: 1, collider: 0, depth } if (0.08..0.1).contains(&depth)),
        "{error}"
    );
    assert_eq!((simulation.state_hash(), simulation.collider_count()), (hash, 0));
    for motion in
        [RigidMotion::translation([f64::NAN, 0.0, 0.0]), RigidMotion::rotation([0.0; 3], at(f64::INFINITY))]
    {
        let error =
            simulation.add_collider(Collider::moving(ball.clone(), Surface::Slip, motion)).unwrap_err();
        assert!(matches!(error, MpmError::Number { .. }), "{error}");
    }
    let rough = Collider::at_rest(ball.clone(), Surface::Friction(-1.0));
    assert!(matches!(simulation.add_collider(rough), Err(MpmError::Number { value: -1.0, .. })));

    let mut empty = Simulation::<f64, 3>::new(SimulationOptions::new(SPACING)).unwrap();
    let far =
        TriMesh::new(sphere(0.5, 6).unwrap().points().to_vec(), sphere(0.5, 6).unwrap().triangles().to_vec());
    empty.add_collider(Collider::at_rest(SolidMesh::new(&far.unwrap()).unwrap(), Surface::Slip)).unwrap();
    let law = FixedCorotated::new(Lame::from_young_poisson(1e4, 0.3).unwrap());
    let samples = Samples { positions: &[at(2.0), at(0.1)], velocities: &[[0.0; 3]; 2], volumes: &[1e-3; 2] };
    let error = empty.add_body(law, 1000.0, samples).unwrap_err();
    assert!(matches!(error, MpmError::InCollider { body: 0, particle: 1, collider: 0, .. }), "{error}");
    assert_eq!(empty.body_count(), 0);
}
