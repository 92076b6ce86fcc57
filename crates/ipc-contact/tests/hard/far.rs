//! Positions so far out that distances are rounding, and energies beyond a number.

use crate::{begin_step, contact_error};
use ipc_contact::ContactError;
use ipc_contact::collision_mesh::{CollisionMesh, CollisionMeshBuilder, CollisionObject, Feature};
use ipc_contact::contact::{BarrierContact, CloseFeatures, ContactOptions};
use ipc_contact::stiffness::{Scale, Stiffness};
use mechanics_core::mesh::{Diagonals, sheet};
use mechanics_core::potential::Potential;
use mechanics_core::tensor::Vec3;
use std::collections::BTreeSet;

const ACTIVATION: f64 = 0.5;

fn two_points() -> CollisionMesh {
    let rest = [Vec3::zeros(), Vec3::z() * 0.25];
    let mut builder = CollisionMeshBuilder::new(&rest);
    builder.add_object(CollisionObject { points: vec![0, 1], ..Default::default() }.with_thickness(0.1));
    builder.build().unwrap()
}

fn contact(mesh: &CollisionMesh, activation: f64, kappa: f64, minimum_separation: f64) -> BarrierContact {
    let stiffness = Stiffness::fixed(Scale::Kappa(kappa));
    let options = ContactOptions { minimum_separation, ..ContactOptions::new(activation, stiffness) };
    BarrierContact::new(mesh.clone(), options).unwrap()
}

/// Two points 0.25 m apart, moved together by as much as positions allow. Until they are refused their distance is off by no more than
/// 1 % of the activation distance, whatever the minimum separation.
#[test]
fn positions_where_distances_are_rounding_are_refused_by_name() {
    let mesh = two_points();
    for minimum_separation in [0.0, 0.2] {
        let mut accepted = 0;
        for exponent in 0..300 {
            let far = 10.0_f64.powf(0.25 * f64::from(exponent));
            let by = Vec3::new(0.6, -0.48, 0.64) * far;
            let x: Vec<Vec3> = mesh.rest().iter().map(|x| x + by).collect();
            let mut contact = contact(&mesh, ACTIVATION, 1.0, minimum_separation);
            let started = begin_step(&mut contact, &x);
            if far < 2e12 * ACTIVATION {
                started.unwrap_or_else(|error| panic!("{far:e}: {error}"));
                let distance = contact.smallest_distance(&x).unwrap();
                assert!((distance - 0.25).abs() < 0.01 * ACTIVATION, "{far:e}: {distance}");
                accepted += 1;
            } else if far > 4e12 * ACTIVATION {
                let error = contact_error(started.unwrap_err());
                let ContactError::TooFar { point, position, farthest } = error else { panic!("{error}") };
                assert_eq!((point, Vec3::from(position)), (0, x[0]));
                assert!(farthest > 2e12 * ACTIVATION && farthest < 4e12 * ACTIVATION, "{farthest:e}");
            }
        }
        assert!(accepted > 40);
    }
}

#[test]
fn a_point_far_from_the_others_is_the_one_named_and_a_step_ends_before_it_is_too_far() {
    let mesh = two_points();
    let mut contact = contact(&mesh, ACTIVATION, 1.0, 0.0);
    let error = contact_error(begin_step(&mut contact, &[Vec3::zeros(), Vec3::x() * 1e13]).unwrap_err());
    assert!(matches!(error, ContactError::TooFar { point: 1, .. }), "{error}");
    assert!(error.to_string().contains("point 1"), "{error}");
    // A step that would end out there is cut, so that its end is accepted.
    let x = mesh.rest().to_vec();
    begin_step(&mut contact, &x).unwrap();
    let p = [-Vec3::x() * 1e20, Vec3::x() * 1e20];
    let limit = contact.limit_step(&x, &p).unwrap();
    assert!(limit.fraction > 0.0 && limit.fraction < 1.0);
    let y: Vec<Vec3> = x.iter().zip(&p).map(|(x, p)| x + p * limit.fraction).collect();
    begin_step(&mut contact, &y).unwrap();
}

/// Clusters of points near each other: `pairs` times two points 0.25 m apart.
fn clusters(pairs: u32) -> CollisionMesh {
    let rest: Vec<Vec3> =
        (0..2 * pairs).map(|i| Vec3::new(10.0 * f64::from(i / 2), 0.0, 0.25 * f64::from(i % 2))).collect();
    let mut builder = CollisionMeshBuilder::new(&rest);
    let points = (0..2 * pairs).collect();
    builder.add_object(CollisionObject { points, ..Default::default() }.with_thickness(0.1));
    builder.build().unwrap()
}

#[test]
fn an_energy_beyond_a_number_names_pairs() {
    // −(s − ŝ)² ln(s/ŝ) of one pair, s = 1/16 and ŝ = 16.
    let activation = 4.0;
    let barrier = (16.0_f64 - 0.0625).powi(2) * 256.0_f64.ln();
    let mesh = clusters(8);
    let x = mesh.rest();
    // Alone each pair's energy is a quarter of the largest number, all of them together twice that; then each alone is beyond it.
    for (part, name) in [(0.25, "the sum"), (1e3, "each")] {
        let kappa = part * (f64::MAX / barrier);
        let mut contact = contact(&mesh, activation, kappa, 0.0);
        let error = contact_error(begin_step(&mut contact, x).unwrap_err());
        let ContactError::EnergyOverflow { pairs, stiffness } = &error else { panic!("{name}: {error}") };
        assert_eq!(*stiffness, kappa);
        assert_eq!(pairs.len(), 8, "{name}");
        for (k, pair) in (0..).zip(pairs) {
            assert_eq!([pair.first.feature, pair.second.feature], [2 * k, 2 * k + 1].map(Feature::Point));
        }
        assert!(error.to_string().contains("8 pairs of features"), "{error}");
    }
    let mut contact = contact(&mesh, activation, 0.1 * (f64::MAX / barrier), 0.0);
    begin_step(&mut contact, x).unwrap();
}

/// Two sheets of 2 · 30² triangles each within the minimum separation: every pair that is refused is named by features that hold the points.
#[test]
fn thousands_of_pairs_too_close_are_named_rightly() {
    let lower = sheet([3.0, 3.0], [30, 30], Diagonals::Alternating).unwrap();
    let mut upper = lower.clone();
    upper.translate(&Vec3::new(0.031, 0.017, 1e-3)).unwrap();
    let first = lower.points().len() as u32;
    let rest: Vec<Vec3> = lower.points().iter().chain(upper.points()).copied().collect();
    let mut builder = CollisionMeshBuilder::new(&rest);
    builder.add_object(CollisionObject::of_mesh(&lower, 0));
    builder.add_object(CollisionObject::of_mesh(&upper, first));
    let mesh = builder.build().unwrap();
    let mut contact = contact(&mesh, 1e-3, 1.0, 2e-3);
    let error = contact_error(begin_step(&mut contact, &rest).unwrap_err());
    let ContactError::TooClose { pairs, .. } = error else { panic!("{error}") };
    let mut triangles = BTreeSet::new();
    for CloseFeatures { first, second, distance } in &pairs {
        for place in [first, second] {
            let corners = match place.feature {
                Feature::Point(point) => vec![point],
                Feature::Edge(edge) => mesh.edges()[edge as usize].to_vec(),
                Feature::Triangle(triangle) => mesh.triangles()[triangle as usize].to_vec(),
                Feature::HalfSpace(_) => panic!("there is none"),
            };
            assert_eq!(place.points, corners);
        }
        if let (Feature::Point(point), Feature::Triangle(triangle)) = (first.feature, second.feature) {
            // The point is right above or below the triangle named.
            let [a, b, c] = mesh.triangles()[triangle as usize].map(|corner| rest[corner as usize].xy());
            let p = rest[point as usize].xy();
            let sides = [(a, b), (b, c), (c, a)].map(|(a, b)| (b - a).perp(&(p - a)));
            let inside = sides.iter().all(|side| *side > 0.0) || sides.iter().all(|side| *side < 0.0);
            assert!(inside && (distance - 1e-3).abs() < 1e-12, "{point} {triangle}");
            triangles.insert(triangle);
        }
    }
    assert!(pairs.len() > 4000 && triangles.len() > 800, "{} {}", pairs.len(), triangles.len());
}
