//! Meshes on top of each other, where most edges are parallel and weights are of both signs.

use crate::random::Random;
use ipc_contact::collision_mesh::{CollisionMeshBuilder, CollisionObject, SelfContact};
use ipc_contact::contact::{BarrierContact, BarrierForm, ContactOptions};
use ipc_contact::contact_set::Weighting;
use ipc_contact::stiffness::{Scale, Stiffness};
use mechanics_core::mesh::{Diagonals, sheet};
use mechanics_core::potential::Potential;
use mechanics_core::tensor::Vec3;

/// The energy of two equal sheets rises as they come closer, however they lie.
#[test]
fn the_barrier_of_stacked_sheets_never_gives_way() {
    let mut random = Random(11);
    for case in 0..400 {
        let cells = [1 + (random.bits() % 3) as u32, 1 + (random.bits() % 3) as u32];
        let diagonals = if case % 2 == 0 { Diagonals::Alternating } else { Diagonals::Rising };
        let lower = sheet([1.0, 1.0], cells, diagonals).unwrap();
        let count = lower.points().len();
        let shift = [0.0, 1e-9, 1e-4, 1e-2, 0.5][case % 5];
        let shift = Vec3::new(random.unit(), random.unit(), 0.0) * shift;
        let tilt = [0.0, 1e-6, 1e-3, 0.5][case / 5 % 4];
        let rest: Vec<Vec3> = lower.points().iter().chain(lower.points()).copied().collect();
        let mut builder = CollisionMeshBuilder::new(&rest);
        for first in [0, count as u32] {
            let object = CollisionObject::of_mesh(&lower, first).with_self_contact(SelfContact::Excluded);
            builder.add_object(object);
        }
        let options = ContactOptions {
            weighting: Weighting::Area,
            form: [BarrierForm::SquaredDistance, BarrierForm::Distance, BarrierForm::Physical][case % 3],
            ..ContactOptions::new(0.05, Stiffness::fixed(Scale::Load(1.0)))
        };
        let contact = BarrierContact::new(builder.build().unwrap(), options).unwrap();
        let noise: Vec<Vec3> = rest.iter().map(|_| random.point()).collect();
        let mut before = 0.0;
        for gap in [0.04, 0.02, 0.01, 1e-3, 1e-4, 1e-5, 1e-6] {
            let x: Vec<Vec3> = (0..rest.len())
                .map(|i| {
                    let upper = if i < count { Vec3::zeros() } else { shift + Vec3::z() * gap };
                    rest[i] + upper + noise[i] * (tilt * gap)
                })
                .collect();
            let value = contact.value(&x);
            let what = format!(
                "case {case}, gap {gap}, {cells:?}, shift {shift:?}, tilt {tilt}: {value:e} after {before:e}"
            );
            assert!(value > before, "{what}");
            before = value;
        }
    }
}
