//! Belts, turntables and scripted surfaces that turn.

use crate::scene::{ACTIVATION, GRAVITY, Particle, mu, options, stepping};
use ipc_contact::collision_mesh::{CollisionMeshBuilder, CollisionObject};
use ipc_contact::contact::{BarrierContact, ContactOptions};
use ipc_contact::stiffness::{Scale, Stiffness};
use ipc_friction::surface_motion::SurfaceMotion;
use ipc_friction::{ContactWithFriction, FrictionError, FrictionOptions};
use lagrangian::element::{DeadLoad, Mass};
use lagrangian::stepper::{Lagging, Stepper};
use mechanics_core::point_map::PointMap;
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;

fn on_surface(motion: SurfaceMotion, stick_velocity: f64) -> Particle {
    let friction = options(mu(0.5), stick_velocity).with_half_space_motion(0, motion);
    Particle::on_slope(0.0, friction, stepping(1e-12, Lagging::Until(5)))
}

/// The mass m gets to the speed V of the belt by the momentum m V, for which the belt does the work m V²: half of it is heat, but for what
/// backward Euler takes.
#[test]
fn a_belt_takes_a_particle_along_and_does_the_work() {
    let (belt, h) = (Vec3::new(0.6, -0.8, 0.0), 1e-3);
    let mut particle = on_surface(SurfaceMotion::sliding(belt), 1e-5);
    let (mut heat, mut driven, mut numerical) = (0.0, 0.0, 0.0);
    for step in 1..=300 {
        let before = particle.velocity();
        particle.step(h);
        if step == 100 {
            let expected = belt * (0.5 * GRAVITY * h * 100.0);
            assert!((particle.velocity() - expected).norm() < 1e-9, "{}", particle.velocity());
        }
        let report = particle.contact.report(&particle.state.position).unwrap();
        assert!(report.dissipated >= 0.0 && report.driven >= 0.0);
        heat += report.dissipated;
        driven += report.driven;
        numerical += 0.5 * (particle.velocity() - before).norm_squared();
    }
    assert!((particle.velocity() - belt).norm() < 1e-8, "{}", particle.velocity());
    assert!((driven - 1.0).abs() < 1e-7, "{driven}");
    let kinetic = 0.5 * particle.velocity().norm_squared();
    assert!((driven - heat - kinetic - numerical).abs() < 1e-9, "{driven} {heat} {kinetic} {numerical}");
}

#[test]
fn a_belt_that_stops_or_moves_across_its_plane_does_as_it_should() {
    // Only the part in the plane counts.
    let mut particle = on_surface(SurfaceMotion::sliding(Vec3::new(0.01, 0.0, 5.0)), 1e-5);
    for _ in 0..30 {
        particle.step(1e-3);
    }
    assert!((particle.velocity() - Vec3::x() * 0.01).norm() < 1e-8, "{}", particle.velocity());
    particle.contact.set_half_space_motion(0, SurfaceMotion::default()).unwrap();
    for _ in 0..30 {
        particle.step(1e-3);
    }
    assert!(particle.velocity().norm() < 1e-8, "{}", particle.velocity());
}

#[test]
fn a_turntable_carries_a_particle_round_as_long_as_friction_can() {
    let (radius, h) = (0.2f64, 2e-4);
    // ω² r against μ g.
    for (part, stays) in [(0.5, true), (1.5, false)] {
        let spin = (part * 0.5 * GRAVITY / radius).sqrt();
        let centre = Vec3::new(-radius, 0.0, 0.0);
        let mut particle = on_surface(SurfaceMotion::turning(Vec3::z() * spin, centre), 1e-3);
        particle.state.velocity[0] = Vec3::y() * (spin * radius);
        for _ in 0..2500 {
            particle.step(h);
        }
        let from_centre = (particle.state.position[0] - centre).xy().norm();
        if stays {
            // It creeps outwards, by less than εᵥ t.
            assert!((from_centre - radius).abs() < 1e-3 * 0.5, "{from_centre}");
            let turned = particle.state.position[0] - centre;
            let angle = turned.y.atan2(turned.x).rem_euclid(std::f64::consts::TAU);
            assert!((angle - (spin * 0.5) % std::f64::consts::TAU).abs() < 1e-2, "{angle}");
        } else {
            assert!(from_centre > 1.5 * radius, "{from_centre}");
        }
    }
}

/// The points of a scripted plate turn about the z axis; what lies on it is pushed along the way of the material under it.
#[test]
fn a_scripted_surface_that_turns_drags_with_the_velocity_of_its_points() {
    let (h, spin) = (1e-3, 3.0f64);
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let mut start: Vec<Vec3> = corners.iter().map(|[x, y]| Vec3::new(*x, *y, 0.0)).collect();
    start.push(Vec3::new(0.3, -0.1, 0.5 * ACTIVATION));
    let mut builder = CollisionMeshBuilder::new(&start);
    builder.add_object(CollisionObject::new(vec![[0, 1, 2], [0, 2, 3]]));
    builder.add_object(CollisionObject { points: vec![4], ..Default::default() }.with_thickness(0.01));
    builder.script_points([0, 1, 2, 3]);
    let load = Stiffness::fixed(Scale::Load(GRAVITY));
    let contact =
        BarrierContact::new(builder.build().unwrap(), ContactOptions::new(ACTIVATION, load)).unwrap();
    let mut contact = ContactWithFriction::new(contact, options(mu(0.5), 1e-4)).unwrap();
    let mut mass = Mass::zeros(5);
    mass.add_point(4, 1.0).unwrap();
    let mut gravity = DeadLoad::gravity(&mass, &(Vec3::z() * -GRAVITY)).unwrap();
    let fixed: Vec<(u32, Vec3)> = (0..4).map(|p| (p, start[p as usize])).collect();
    let map = PointMap::with_fixed(5, &fixed).unwrap();
    let mut stepper = Stepper::new(mass, map, stepping(1e-12, Lagging::Until(20)));
    let mut state = State::at_rest(start.clone());
    let (sine, cosine) = (spin * h).sin_cos();
    let turned = |x: &Vec3, sine: f64| Vec3::new(cosine * x.x - sine * x.y, sine * x.x + cosine * x.y, x.z);
    for point in 0..4 {
        stepper.set_target(point, turned(&start[point as usize], sine)).unwrap();
    }
    stepper.step(&mut state, &mut [&mut gravity, &mut contact], h).unwrap();
    // Backward Euler's velocity, along the chord, of the material that is under the particle at the end.
    let end = state.position[4];
    let material = (end - turned(&end, -sine)) / h;
    let velocity = state.velocity[4];
    assert!((velocity.norm() / (0.5 * GRAVITY * h) - 1.0).abs() < 1e-6, "{velocity}");
    let slip = (material - velocity).normalize();
    assert!((velocity.normalize() - slip).norm() < 1e-5, "{velocity} {material}");
    let pairs = contact.pairs(&state.position);
    assert!((pairs[0].slip_velocity + (material - velocity)).norm() < 1e-5, "{pairs:?}");
}

#[test]
fn motions_of_surfaces_that_are_not_there_or_not_finite_are_refused() {
    let nan = SurfaceMotion::sliding(Vec3::new(f64::NAN, 0.0, 0.0));
    let new = |friction: FrictionOptions| {
        let rest = [Vec3::new(0.0, 0.0, 1.0)];
        let mut builder = CollisionMeshBuilder::new(&rest);
        builder.add_object(CollisionObject { points: vec![0], ..Default::default() }.with_thickness(0.01));
        let load = Stiffness::fixed(Scale::Load(1.0));
        let contact = BarrierContact::new(builder.build().unwrap(), ContactOptions::new(ACTIVATION, load));
        ContactWithFriction::new(contact.unwrap(), friction).map(|_| ())
    };
    let friction = options(mu(0.5), 1e-3).with_half_space_motion(0, SurfaceMotion::default());
    assert_eq!(new(friction), Err(FrictionError::MotionOutOfRange { half_space: 0, half_spaces: 0 }));

    let mut particle = on_surface(SurfaceMotion::default(), 1e-3);
    let refused = particle.contact.set_half_space_motion(1, SurfaceMotion::default());
    assert_eq!(refused, Err(FrictionError::MotionOutOfRange { half_space: 1, half_spaces: 1 }));
    let refused = particle.contact.set_half_space_motion(0, nan).unwrap_err();
    assert!(matches!(refused, FrictionError::Motion { half_space: 0, .. }), "{refused}");
    assert_eq!(particle.contact.options().half_space_motions[&0], SurfaceMotion::default());
}
