//! Particles on planes and spheres, and elastic cubes.

use ipc_contact::collision_mesh::{CollisionMeshBuilder, CollisionObject, HalfSpace, SelfContact};
use ipc_contact::contact::{BarrierContact, ContactOptions};
use ipc_contact::stiffness::{Scale, Stiffness};
use ipc_friction::coefficients::CoefficientTable;
use ipc_friction::law::{FrictionCoefficient, SmoothedCoulomb};
use ipc_friction::{ContactWithFriction, FrictionOptions};
use lagrangian::element::{DeadLoad, Mass, MassDistribution, Tetrahedra};
use lagrangian::stepper::{Lagging, StepReport, Stepper, StepperOptions};
use mechanics_core::law::{Lame, StableNeoHookean};
use mechanics_core::mesh::{BoxSplit, TetMesh, block};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::point_map::PointMap;
use mechanics_core::state::State;
use mechanics_core::stencil::StencilTerm;
use mechanics_core::tensor::Vec3;

pub(crate) const GRAVITY: f64 = 9.81;
pub(crate) const ACTIVATION: f64 = 1e-3;

pub(crate) fn mu(value: f64) -> FrictionCoefficient {
    FrictionCoefficient::new(value).unwrap()
}

pub(crate) fn options(coefficient: FrictionCoefficient, stick_velocity: f64) -> FrictionOptions {
    let law = SmoothedCoulomb::new(stick_velocity).unwrap();
    FrictionOptions::new(law, CoefficientTable::uniform(coefficient))
}

pub(crate) fn stepping(tolerance: f64, lagging: Lagging) -> StepperOptions {
    let newton = NewtonOptions { tolerance, ..Default::default() };
    StepperOptions { newton, lagging, ..Default::default() }
}

/// Gravity in the frame of a plane that falls towards +x by an angle.
pub(crate) fn gravity_on_slope(angle: f64) -> Vec3 {
    Vec3::new(angle.sin(), 0.0, -angle.cos()) * GRAVITY
}

/// A particle of 1 kg on the plane z = 0, at the height where contact carries its weight.
pub(crate) struct Particle {
    pub(crate) contact: ContactWithFriction,
    pub(crate) gravity: DeadLoad,
    pub(crate) stepper: Stepper,
    pub(crate) state: State,
}

impl Particle {
    pub(crate) fn on_slope(angle: f64, friction: FrictionOptions, stepping: StepperOptions) -> Self {
        let rest = [Vec3::new(0.0, 0.0, 0.5 * ACTIVATION)];
        let mut builder = CollisionMeshBuilder::new(&rest);
        let object = CollisionObject { points: vec![0], ..Default::default() };
        builder.add_object(object.with_thickness(0.01));
        builder.add_half_space(HalfSpace::through(&Vec3::zeros(), &Vec3::z()));
        let weight = GRAVITY * angle.cos();
        let contact = ContactOptions::new(ACTIVATION, Stiffness::fixed(Scale::Load(weight)));
        let contact = BarrierContact::new(builder.build().unwrap(), contact).unwrap();
        let mut mass = Mass::zeros(1);
        mass.add_point(0, 1.0).unwrap();
        let gravity = DeadLoad::gravity(&mass, &gravity_on_slope(angle)).unwrap();
        Self {
            contact: ContactWithFriction::new(contact, friction).unwrap(),
            gravity,
            stepper: Stepper::new(mass, PointMap::identity(1), stepping),
            state: State::at_rest(rest.to_vec()),
        }
    }

    pub(crate) fn step(&mut self, h: f64) -> StepReport {
        let Self { contact, gravity, stepper, state } = self;
        stepper.step(state, &mut [gravity, contact], h).unwrap()
    }

    pub(crate) fn velocity(&self) -> Vec3 {
        self.state.velocity[0]
    }
}

/// A cube of edge 0.1 m in n³ cells of six tetrahedra, moved.
pub(crate) fn cube(cells: u32, by: Vec3) -> TetMesh {
    let mut mesh = block(&Vec3::zeros(), &Vec3::repeat(0.1), [cells; 3], BoxSplit::Six).unwrap();
    mesh.translate(&by).unwrap();
    mesh
}

/// Elastic bodies that may touch each other, and the plane z = 0 if there is gravity.
pub(crate) struct Bodies {
    pub(crate) elastic: StencilTerm<Tetrahedra<StableNeoHookean>, 4>,
    pub(crate) gravity: Option<DeadLoad>,
    pub(crate) contact: ContactWithFriction,
    pub(crate) stepper: Stepper,
    pub(crate) state: State,
    /// The first point of each body.
    pub(crate) first: Vec<usize>,
}

impl Bodies {
    pub(crate) fn new(
        meshes: &[TetMesh],
        gravity: Option<Vec3>,
        friction: FrictionOptions,
        stepping: StepperOptions,
    ) -> Self {
        let contact = ContactOptions::new(ACTIVATION, Stiffness::fixed(Scale::Load(2.0)));
        Self::with_contact(meshes, gravity, friction, stepping, contact)
    }

    pub(crate) fn with_contact(
        meshes: &[TetMesh],
        gravity: Option<Vec3>,
        friction: FrictionOptions,
        stepping: StepperOptions,
        contact: ContactOptions,
    ) -> Self {
        let mut all = meshes[0].clone();
        let mut first = vec![0];
        meshes[1..].iter().for_each(|mesh| first.push(all.append(mesh).unwrap() as usize));
        let mut builder = CollisionMeshBuilder::new(all.points());
        for (mesh, &first) in meshes.iter().zip(&first) {
            let object = CollisionObject::of_tets(mesh, first as u32).unwrap();
            builder.add_object(object.with_self_contact(SelfContact::Excluded));
        }
        if gravity.is_some() {
            builder.add_half_space(HalfSpace::through(&Vec3::zeros(), &Vec3::z()));
        }
        let contact = BarrierContact::new(builder.build().unwrap(), contact).unwrap();
        let law = StableNeoHookean::new(Lame::from_young_poisson(1e5, 0.3).unwrap());
        let mut mass = Mass::zeros(all.points().len());
        mass.add_tetrahedra(all.points(), all.cells(), 1000.0, MassDistribution::Lumped).unwrap();
        Self {
            elastic: Tetrahedra::term("elastic", law, &all).unwrap(),
            gravity: gravity.map(|g| DeadLoad::gravity(&mass, &g).unwrap()),
            contact: ContactWithFriction::new(contact, friction).unwrap(),
            stepper: Stepper::new(mass, PointMap::identity(all.points().len()), stepping),
            state: State::at_rest(all.points().to_vec()),
            first,
        }
    }

    pub(crate) fn step(&mut self, h: f64) -> StepReport {
        let Self { elastic, gravity, contact, stepper, state, .. } = self;
        match gravity {
            Some(gravity) => stepper.step(state, &mut [elastic, gravity, contact], h).unwrap(),
            None => stepper.step(state, &mut [elastic, contact], h).unwrap(),
        }
    }

    pub(crate) fn momentum(&self) -> Vec3 {
        self.stepper.mass().linear_momentum(&self.state.velocity)
    }

    pub(crate) fn mean_velocity(&self) -> Vec3 {
        self.momentum() / self.stepper.mass().total()
    }
}

/// Two cubes of 1 kg: the upper flies against the lower, down and across.
pub(crate) fn glancing_blow(coefficient: f64, lagging: Lagging) -> Bodies {
    let meshes = [cube(3, Vec3::zeros()), cube(3, Vec3::new(0.02, 0.01, 0.1015))];
    let mut bodies = Bodies::new(&meshes, None, options(mu(coefficient), 1e-3), stepping(1e-8, lagging));
    let second = bodies.first[1];
    bodies.state.velocity[second..].fill(Vec3::new(0.8, 0.3, -0.7));
    bodies
}
