//! Bodies that move fast against each other: what is looked at, and that nothing is overlooked.

use crate::begin_step;
use ipc_contact::collision_mesh::{CollisionMesh, CollisionMeshBuilder, CollisionObject};
use ipc_contact::contact::{BarrierContact, ContactOptions, ContactReport};
use ipc_contact::stiffness::{Scale, Stiffness};
use mechanics_core::mesh::ball;
use mechanics_core::potential::Potential;
use mechanics_core::tensor::Vec3;

/// What is one object.
#[derive(Clone, Copy)]
enum Objects {
    EachBall,
    AllTogether,
}

/// Balls of radius 0.1 m around the centres, and the number of each point's ball.
fn balls(rings: u32, centres: &[Vec3], objects: Objects) -> (CollisionMesh, Vec<usize>) {
    let one = ball(0.1, rings).unwrap();
    let count = one.points().len();
    let rest: Vec<Vec3> =
        centres.iter().flat_map(|centre| one.points().iter().map(move |x| x + centre)).collect();
    let each = (0..centres.len()).map(|k| CollisionObject::of_tets(&one, (k * count) as u32).unwrap());
    let mut builder = CollisionMeshBuilder::new(&rest);
    match objects {
        Objects::EachBall => each.for_each(|ball| {
            builder.add_object(ball);
        }),
        Objects::AllTogether => {
            let triangles = each.flat_map(|ball| ball.triangles).collect();
            builder.add_object(CollisionObject::new(triangles));
        }
    }
    (builder.build().unwrap(), (0..rest.len()).map(|point| point / count).collect())
}

/// The part of the step that is free, and what was done for it.
fn limit(mesh: CollisionMesh, p: &[Vec3]) -> (f64, ContactReport) {
    let x = mesh.rest().to_vec();
    let options = ContactOptions::new(1e-3, Stiffness::fixed(Scale::Load(1.0)));
    let mut contact = BarrierContact::new(mesh, options).unwrap();
    begin_step(&mut contact, &x).unwrap();
    let fraction = contact.limit_step(&x, p).unwrap().fraction;
    (fraction, contact.report())
}

/// The same where each ball moves as a whole.
fn limit_of_balls(rings: u32, centres: &[Vec3], displacements: &[Vec3]) -> (f64, ContactReport) {
    let (mesh, ball_of) = balls(rings, centres, Objects::EachBall);
    let p: Vec<Vec3> = ball_of.iter().map(|&ball| displacements[ball]).collect();
    limit(mesh, &p)
}

/// Found with swept boxes of the whole motion: 1,008 candidates at rest became 5,301,180, asked in 37,851,960 queries that took 17 s.
#[test]
fn bodies_that_fly_apart_have_as_many_candidates_as_at_rest() {
    let centres = [Vec3::zeros(), Vec3::new(0.0, 0.0, -7.0)];
    let (_, rest) = limit_of_balls(8, &centres, &[Vec3::zeros(); 2]);
    for way in [0.01, 0.2, 1.0, 10.0, 1e3] {
        for direction in [Vec3::z(), Vec3::new(1.0, 1.0, 1.0), Vec3::new(-1.0, 0.7, 0.2)] {
            let way = direction.normalize() * way;
            let (fraction, report) = limit_of_balls(8, &centres, &[way, -way]);
            assert_eq!(fraction, 1.0);
            assert_eq!(report.candidates, rest.candidates, "{way}");
            // One search was made when the step began.
            assert_eq!(report.detection_queries, (report.searches - 1) * rest.candidates as u64, "{way}");
        }
    }
}

#[test]
fn balls_that_meet_stop_where_they_do() {
    let rings = 4;
    for direction in [Vec3::x(), Vec3::new(1.0, 1.0, 1.0).normalize()] {
        for way in [0.5, 1.0, 10.0] {
            let (fraction, report) =
                limit_of_balls(rings, &[Vec3::zeros(), direction], &[direction * way, -direction * way]);
            // Centres are 1 m apart and come 2 way nearer; inscribed polyhedra of radius 0.1 m with edges of 5 cm meet a little later than balls,
            // and a tenth of half of the activation distance is kept.
            let meeting = 0.8 / (2.0 * way);
            assert!(
                fraction > meeting - 1e-3 / way && fraction < meeting + 8e-3 / way,
                "{fraction} {meeting}"
            );
            assert!(report.limiting_pair.is_some());
        }
    }
}

/// Which points are one object decides in which frame pairs are looked for, not what is found: bodies that spin, stretch, fold over
/// themselves and fly at each other have the same free part of a step, to the bit.
#[test]
fn frames_of_objects_make_no_difference_to_the_limit() {
    let mut random = crate::Random(6);
    let (mut limited, mut free) = (0, 0);
    for case in 0..120 {
        let centres: Vec<Vec3> =
            (0..3).map(|k| Vec3::new(0.3 * f64::from(k), 0.0, 0.0) + random.vector() * 0.04).collect();
        let size = 10.0_f64.powf(-3.0 + 4.0 * f64::from(case % 12) / 11.0);
        let motions: Vec<[Vec3; 4]> = (0..3).map(|_| [0; 4].map(|_| random.vector() * size)).collect();
        let [each, all] = [Objects::EachBall, Objects::AllTogether].map(|objects| {
            let (mesh, ball_of) = balls(3, &centres, objects);
            let displacement = |(x, &ball): (&Vec3, &usize)| {
                let ([whole, a, b, c], local) = (motions[ball], (x - centres[ball]) * 10.0);
                // An affine motion, and a fold.
                whole + a * local.x + b * local.y * local.z + c * local.z.abs()
            };
            let p: Vec<Vec3> = mesh.rest().iter().zip(&ball_of).map(displacement).collect();
            limit(mesh, &p).0
        });
        assert_eq!(each.to_bits(), all.to_bits(), "case {case}: {each} {all}");
        if each < 1.0 { limited += 1 } else { free += 1 }
    }
    assert!(limited > 30 && free > 30, "{limited} {free}");
}
