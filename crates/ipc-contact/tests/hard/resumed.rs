//! κ of runs that are interrupted: before a step, after one, and after one that failed.

use ipc_contact::collision_mesh::{CollisionMeshBuilder, CollisionObject};
use ipc_contact::contact::{BarrierContact, ContactOptions};
use ipc_contact::stiffness::{SavedStiffness, Scale, Stiffness};
use lagrangian::element::{Mass, MassDistribution, Tetrahedra};
use lagrangian::stepper::{Stepper, StepperOptions};
use mechanics_core::law::{Lame, StableNeoHookean};
use mechanics_core::mesh::{BoxSplit, TetMesh, block};
use mechanics_core::newton::Proceed;
use mechanics_core::point_map::PointMap;
use mechanics_core::state::State;
use mechanics_core::stencil::StencilTerm;
use mechanics_core::tensor::Vec3;

struct World {
    elastic: StencilTerm<Tetrahedra<StableNeoHookean>, 4>,
    contact: BarrierContact,
    stepper: Stepper,
    state: State,
}

/// A cube flies into another with 3 m/s; κ is far too small for that and grows.
fn world() -> World {
    let cube = |by: Vec3| {
        let mut mesh = block(&Vec3::zeros(), &Vec3::repeat(0.1), [2; 3], BoxSplit::Six).unwrap();
        mesh.translate(&by).unwrap();
        mesh
    };
    let mut all: TetMesh = cube(Vec3::zeros());
    let other = cube(Vec3::new(0.03, 0.02, 0.102));
    let first = all.append(&other).unwrap();
    let mut builder = CollisionMeshBuilder::new(all.points());
    builder.add_object(CollisionObject::of_tets(&cube(Vec3::zeros()), 0).unwrap());
    builder.add_object(CollisionObject::of_tets(&other, first).unwrap());
    let stiffness = Stiffness::adaptive(Scale::Load(1e-4));
    let contact =
        BarrierContact::new(builder.build().unwrap(), ContactOptions::new(1e-3, stiffness)).unwrap();
    let law = StableNeoHookean::new(Lame::from_young_poisson(1e5, 0.3).unwrap());
    let elastic = Tetrahedra::term("elastic", law, &all).unwrap();
    let mut mass = Mass::zeros(all.points().len());
    mass.add_tetrahedra(all.points(), all.cells(), 1000.0, MassDistribution::Lumped).unwrap();
    let stepper = Stepper::new(mass, PointMap::identity(all.points().len()), StepperOptions::default());
    let mut state = State::at_rest(all.points().to_vec());
    state.velocity[first as usize..].fill(Vec3::new(0.0, 0.0, -3.0));
    World { elastic, contact, stepper, state }
}

impl World {
    /// A step that is cancelled before iteration `most`; answers whether it was.
    fn step(&mut self, h: f64, most: u32) -> bool {
        let Self { elastic, contact, stepper, state } = self;
        let mut observer = |at: &mechanics_core::newton::Progress| {
            if at.iteration < most { Proceed::Continue } else { Proceed::Cancel }
        };
        stepper.step_observed(state, &mut [elastic, contact], h, &mut observer).is_err()
    }

    /// Another run from what this one would have saved now.
    fn resumed(&self) -> Self {
        let mut other = world();
        other.state = self.state.clone();
        other.contact.resume_stiffness(self.contact.saved_stiffness(&self.state.position)).unwrap();
        other
    }
}

#[test]
fn a_run_resumed_at_any_moment_has_the_bits_of_one_that_was_not_interrupted() {
    let mut world = world();
    let (mut grown, mut failed) = (0, 0);
    for step in 0..14 {
        // Every step is first cancelled at some iteration, then tried again with half of its size.
        let mut resumed = world.resumed();
        let most = 2 + step % 5;
        let (a, b) = (world.step(2e-3, most), resumed.step(2e-3, most));
        assert_eq!(a, b, "step {step}");
        if a {
            let saved = world.contact.saved_stiffness(&world.state.position);
            grown += u32::from(world.contact.stiffness() > saved.kappa);
            failed += 1;
            let mut after_failure = world.resumed();
            for run in [&mut world, &mut resumed, &mut after_failure] {
                assert!(!run.step(1e-3, u32::MAX));
            }
            assert_eq!(after_failure.state.hash(), world.state.hash(), "step {step}");
            assert_eq!(after_failure.contact.stiffness(), world.contact.stiffness(), "step {step}");
        }
        assert_eq!(resumed.state.hash(), world.state.hash(), "step {step}");
        assert_eq!(resumed.contact.stiffness(), world.contact.stiffness(), "step {step}");
    }
    assert!(failed > 5 && grown > 0, "{failed} steps failed, {grown} of them with a larger κ: not trivial");
}

#[test]
fn a_run_at_rest_is_resumed_with_the_stiffness_it_has() {
    // Nothing moves: every step begins where the one before began.
    let mut world = world();
    world.state.velocity.fill(Vec3::zeros());
    let before = world.contact.stiffness();
    assert!(!world.step(1e-3, u32::MAX) && !world.step(1e-3, u32::MAX));
    assert_eq!(world.contact.saved_stiffness(&world.state.position).kappa, before);
    assert_eq!(world.contact.stiffness(), before);
}

#[test]
fn the_limit_of_growth_is_saved_too() {
    let (mut world, fresh) = (world(), world());
    let x = world.state.position.clone();
    let push: Vec<Vec3> = world.contact.forces(&x);
    assert!(push.iter().all(|force| *force == Vec3::zeros()), "apart at the start");
    let saved = SavedStiffness { kappa: 7.0, largest: 70.0 };
    world.contact.resume_stiffness(saved).unwrap();
    assert_eq!(world.contact.saved_stiffness(&x), saved);
    assert!(fresh.contact.saved_stiffness(&x).largest > fresh.contact.stiffness());
    for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        for saved in [SavedStiffness { kappa: wrong, ..saved }, SavedStiffness { largest: wrong, ..saved }] {
            assert!(world.contact.resume_stiffness(saved).is_err(), "{wrong}");
        }
    }
    assert_eq!(world.contact.saved_stiffness(&x), saved, "as it was");
}
