//! Every surface on every shape, at places where the normal is known: what a node keeps of its velocity.

use crate::solids::{KINDS, by_table};
use mechanics_core::tensor::Vec3;
use mpm_core::{Boundary, Shape, Surface};

/// Shapes, a place inside of each, and the outward normal there.
fn cases() -> Vec<(Shape<3>, Vec3, Vec3)> {
    let tilted = Vec3::new(0.6, 0.0, 0.8);
    let diagonal = Vec3::new(1.0, 2.0, -2.0) / 3.0;
    let along = Vec3::new(0.0, 0.6, 0.8);
    let capsule = Shape::Capsule { from: [0.0; 3], to: (along * 2.0).into(), radius: 0.5 };
    let across = Vec3::x();
    vec![
        (
            Shape::HalfSpace { point: [1.0, 2.0, 3.0], normal: tilted.into() },
            Vec3::new(1.0, 2.5, 3.0) - tilted * 0.3,
            tilted,
        ),
        (Shape::Ball { centre: [1.0, 0.0, 0.0], radius: 0.5 }, Vec3::x() + diagonal * 0.4, diagonal),
        (Shape::Cuboid { centre: [0.0; 3], half: [1.0, 2.0, 3.0] }, Vec3::new(0.1, -1.9, 0.3), -Vec3::y()),
        (capsule, along * 1.2 + across * 0.3, across),
        (capsule, along * 2.3, along),
        (capsule, -along * 0.2, -along),
        (Shape::Walls { low: [-1.0; 3], high: [1.0, 2.0, 3.0] }, Vec3::new(0.0, 2.1, 0.0), -Vec3::y()),
        (Shape::Walls { low: [-1.0; 3], high: [1.0, 2.0, 3.0] }, Vec3::new(0.0, 0.0, -1.5), Vec3::z()),
    ]
}

#[test]
fn surfaces_do_on_every_shape_what_their_table_says() {
    let (velocity, time) = (Vec3::new(0.3, -0.2, 0.5), 2.0);
    for (shape, place, normal) in cases() {
        let tangent = normal.cross(&Vec3::new(0.3, 0.5, 0.7)).normalize();
        for surface in KINDS {
            let boundary = Boundary { shape, surface, velocity: velocity.into() };
            for (approach, slide) in [(-2.0, 1.0), (-0.5, 3.0), (0.7, 1.5), (-1.0, 0.0)] {
                let w = normal * approach + tangent * slide;
                let place = place + velocity * time;
                let after = boundary.act(&place.into(), time, &(w + velocity).into());
                let kept = Vec3::from(after) - velocity;
                assert!(
                    (kept - by_table(surface, w, normal)).norm() < 1e-14,
                    "{shape:?}, {surface:?}: {kept}"
                );
                // Said in words: what is kept along, across, and lost to friction.
                match surface {
                    Surface::Sticky => assert!(kept.norm() < 1e-14),
                    Surface::Slip => {
                        assert!(kept.dot(&normal).abs() < 1e-14 && (kept.dot(&tangent) - slide).abs() < 1e-14)
                    }
                    _ if approach > 0.0 => assert!((kept - w).norm() < 1e-14),
                    Surface::Separating => assert!((kept.dot(&tangent) - slide).abs() < 1e-14),
                    Surface::Friction(mu) => {
                        let lost = slide - kept.dot(&tangent);
                        assert!(lost <= mu * approach.abs() + 1e-14 && lost <= slide + 1e-14);
                    }
                }
                let outside = boundary.act(&(place + normal * 10.0).into(), time, &(w + velocity).into());
                let walls = matches!(shape, Shape::Walls { .. });
                assert!(walls || outside == <[f64; 3]>::from(w + velocity));
            }
        }
    }
}
