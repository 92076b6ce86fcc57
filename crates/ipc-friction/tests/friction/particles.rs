//! A particle on a slope, a plane and a sphere, against closed forms.

use crate::scene::{ACTIVATION, GRAVITY, Particle, mu, options, stepping};
use ipc_contact::collision_mesh::{CollisionMeshBuilder, CollisionObject};
use ipc_contact::contact::{BarrierContact, ContactOptions};
use ipc_contact::stiffness::{Scale, Stiffness};
use ipc_friction::law::{FrictionCoefficient, Smoothing};
use ipc_friction::{ContactWithFriction, FrictionOptions};
use lagrangian::element::{DeadLoad, Mass};
use lagrangian::stepper::{Lagging, Stepper, StepperOptions, TimeScheme};
use mechanics_core::point_map::PointMap;
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;

/// εᵥ (1 − √(1 − tan θ/μ)).
fn creep(stick_velocity: f64, angle: f64, coefficient: f64) -> f64 {
    stick_velocity * (1.0 - (1.0 - angle.tan() / coefficient).sqrt())
}

#[test]
fn what_sticks_creeps_with_the_speed_of_the_closed_form() {
    for (degrees, coefficient) in
        [(5.0, 0.1), (20.0, 0.4), (26.0, 0.5), (30.0, 0.6), (45.0, 2.0), (60.0, 1.8)]
    {
        for stick_velocity in [1e-2, 1e-4, 1e-6] {
            for h in [1e-3, 1e-2, 0.1] {
                let angle = f64::to_radians(degrees);
                let stepping = stepping(1e-9 * stick_velocity, Lagging::Once);
                let mut particle =
                    Particle::on_slope(angle, options(mu(coefficient), stick_velocity), stepping);
                let expected = creep(stick_velocity, angle, coefficient);
                // Rate at which a deviation decays: λ dμ/dy over the mass.
                let rate = 2.0 * coefficient * GRAVITY * angle.cos() / stick_velocity
                    * (1.0 - expected / stick_velocity);
                for _ in 0..20 + (20.0 / (rate * h)) as u32 {
                    particle.step(h);
                }
                let velocity = particle.velocity().x;
                assert!(
                    (velocity / expected - 1.0).abs() < 1e-6,
                    "{degrees} {stick_velocity} {h}: {velocity}"
                );
                let report = particle.contact.report(&particle.state.position).unwrap();
                assert_eq!((report.pairs, report.sticking), (1, 1));
                assert!(report.relative_lag_residual < 1e-9, "{report:?}");
            }
        }
    }
}

#[test]
fn the_quintic_law_creeps_as_its_polynomial_says() {
    let (angle, coefficient, stick_velocity) = (0.4f64, 0.5, 1e-3);
    let base = options(mu(coefficient), stick_velocity);
    let friction = FrictionOptions { law: base.law.with_smoothing(Smoothing::Quintic), ..base };
    let mut particle = Particle::on_slope(angle, friction, stepping(1e-13, Lagging::Once));
    for _ in 0..40 {
        particle.step(0.01);
    }
    let z = particle.velocity().x / stick_velocity;
    let f1 = (15.0 * z - 10.0 * z.powi(3) + 3.0 * z.powi(5)) / 8.0;
    assert!(z > 0.1 && (f1 - angle.tan() / coefficient).abs() < 1e-8, "{z} {f1}");
}

#[test]
fn what_slides_accelerates_as_the_exact_law_says() {
    for (degrees, coefficient) in [(10.0, 0.0), (20.0, 0.1), (30.0, 0.5), (60.0, 1.0)] {
        for h in [1e-3, 1e-2] {
            let angle = f64::to_radians(degrees);
            let mut particle =
                Particle::on_slope(angle, options(mu(coefficient), 1e-4), stepping(1e-11, Lagging::Once));
            particle.state.velocity[0] = Vec3::new(0.2, 0.0, 0.0);
            for _ in 0..50 {
                particle.step(h);
            }
            let expected = 0.2 + 50.0 * h * GRAVITY * (angle.sin() - coefficient * angle.cos());
            assert!((particle.velocity().x - expected).abs() < 1e-8, "{degrees} {h}");
        }
    }
}

#[test]
fn between_the_coefficients_rest_stays_rest_and_sliding_stays_sliding() {
    let angle = 0.4f64;
    let coefficient = FrictionCoefficient::with_kinetic(0.6, 0.3).unwrap();
    assert!(angle.tan() > 0.3 && angle.tan() < 0.6);
    let new = || Particle::on_slope(angle, options(coefficient, 1e-4), stepping(1e-12, Lagging::Once));
    let (mut resting, mut sliding) = (new(), new());
    sliding.state.velocity[0] = Vec3::new(0.1, 0.0, 0.0);
    for _ in 0..50 {
        resting.step(0.01);
        sliding.step(0.01);
    }
    assert!((resting.velocity().x / creep(1e-4, angle, 0.6) - 1.0).abs() < 1e-6);
    let expected = 0.1 + 0.5 * GRAVITY * (angle.sin() - 0.3 * angle.cos());
    assert!((sliding.velocity().x - expected).abs() < 1e-8);
}

/// How far a particle of 1 m/s slides on the level, μ = 0.5.
fn slide(h: f64, stick_velocity: f64, scheme: TimeScheme) -> f64 {
    let stepping = StepperOptions { scheme, ..stepping(1e-9, Lagging::Once) };
    let mut particle = Particle::on_slope(0.0, options(mu(0.5), stick_velocity), stepping);
    particle.state.velocity[0] = Vec3::new(0.6, 0.8, 0.0);
    for _ in 0..(0.3 / h).round() as u32 {
        particle.step(h);
    }
    assert!(particle.velocity().norm() < 1e-3 * stick_velocity, "it has stopped");
    let way = particle.state.position[0].xy();
    assert!((way.y / way.x - 0.8 / 0.6).abs() < 1e-6, "straight on");
    way.norm()
}

#[test]
fn the_sliding_distance_is_that_of_backward_euler_and_converges() {
    // v²/(2 μ g) = 0.1019 m. Backward Euler loses μ g h a step and then moves with what is left, until less is left than that.
    let loss = 0.5 * GRAVITY;
    let exact = 1.0 / (2.0 * loss);
    assert!((exact - 0.1019).abs() < 5e-5);
    let euler = |h: f64| {
        let steps = (1.0 / (loss * h)).floor();
        h * (steps - loss * h * steps * (steps + 1.0) / 2.0)
    };
    assert!((euler(0.01) - 0.0970).abs() < 5e-5);
    let mut errors = Vec::new();
    for h in [0.02, 0.01, 0.005, 0.0025] {
        let way = slide(h, 1e-6, TimeScheme::BackwardEuler);
        // The last step's remainder is less than εᵥ h.
        assert!((way - euler(h)).abs() < 2.0 * 1e-6 * h + 1e-9, "{h}: {way} {}", euler(h));
        errors.push(exact - way);
    }
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((order - 1.0).abs() < 0.1, "{errors:?}");
    }
    // The second-order scheme is far closer.
    assert!((slide(0.01, 1e-4, TimeScheme::Bdf2) - exact).abs() < 0.1 * errors[1]);
}

#[test]
fn the_energy_of_a_slide_is_dissipated_by_friction_and_backward_euler() {
    let mut particle = Particle::on_slope(0.0, options(mu(0.5), 1e-4), stepping(1e-12, Lagging::Once));
    particle.state.velocity[0] = Vec3::new(1.0, 0.0, 0.0);
    let (mut dissipated, mut numerical) = (0.0, 0.0);
    for _ in 0..30 {
        let before = particle.velocity();
        particle.step(0.01);
        let report = particle.contact.report(&particle.state.position).unwrap();
        assert!(report.dissipated >= 0.0);
        dissipated += report.dissipated;
        numerical += 0.5 * (particle.velocity() - before).norm_squared();
    }
    let kinetic = 0.5 * particle.velocity().norm_squared();
    assert!((dissipated + numerical + kinetic - 0.5).abs() < 1e-10, "{dissipated} {numerical} {kinetic}");
    assert!(dissipated > 0.47);
}

#[test]
fn a_particle_on_a_moving_sphere_sticks_to_it_or_slides_off() {
    // The sphere is a point with a minimum separation of its radius. At the polar angle θ the particle sticks for μ > tan θ.
    let (radius, angle, stick_velocity, h) = (0.5, 0.4f64, 1e-5, 0.01);
    let drift = Vec3::new(0.3, -0.2, 0.1);
    for (coefficient, sticks) in [(0.6, true), (0.3, false)] {
        let normal = Vec3::new(angle.sin(), 0.0, angle.cos());
        let start = vec![Vec3::zeros(), normal * (radius + 0.5 * ACTIVATION)];
        let mut builder = CollisionMeshBuilder::new(&start);
        for point in [0, 1] {
            builder.add_object(
                CollisionObject { points: vec![point], ..Default::default() }.with_thickness(0.01),
            );
        }
        builder.script_points([0]);
        let load = Stiffness::fixed(Scale::Load(GRAVITY * angle.cos()));
        let contact = ContactOptions { minimum_separation: radius, ..ContactOptions::new(ACTIVATION, load) };
        let contact = BarrierContact::new(builder.build().unwrap(), contact).unwrap();
        let mut contact =
            ContactWithFriction::new(contact, options(mu(coefficient), stick_velocity)).unwrap();
        let mut mass = Mass::zeros(2);
        mass.add_point(1, 1.0).unwrap();
        let mut gravity = DeadLoad::gravity(&mass, &Vec3::new(0.0, 0.0, -GRAVITY)).unwrap();
        let map = PointMap::with_fixed(2, &[(0, start[0])]).unwrap();
        let mut stepper = Stepper::new(mass, map, stepping(1e-12, Lagging::Until(30)));
        let mut state = State::at_rest(start);
        state.velocity.fill(drift);
        for step in 1..=20 {
            stepper.set_target(0, drift * (h * f64::from(step))).unwrap();
            stepper.step(&mut state, &mut [&mut gravity, &mut contact], h).unwrap();
        }
        let slip = state.velocity[1] - drift;
        if sticks {
            // It creeps down by less than 1e-6 m, so that the angle is still that of the start.
            let expected = creep(stick_velocity, angle, coefficient);
            assert!((slip.norm() / expected - 1.0).abs() < 1e-4, "{slip} {expected}");
            assert!(slip.x > 0.0 && slip.y.abs() < 1e-12 && slip.z < 0.0);
        } else {
            // Faster than with the steepness it began with.
            assert!(slip.norm() > 0.2 * GRAVITY * (angle.sin() - coefficient * angle.cos()));
        }
    }
}
