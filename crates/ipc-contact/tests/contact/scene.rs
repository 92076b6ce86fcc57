//! Small scenes of elastic blocks.

use ipc_contact::collision_mesh::{
    CollisionMesh, CollisionMeshBuilder, CollisionObject, HalfSpace, SelfContact,
};
use ipc_contact::contact::BarrierContact;
use ipc_contact::intersection::check;
use lagrangian::element::{DeadLoad, Mass, MassDistribution, Tetrahedra};
use lagrangian::stepper::{StepError, StepReport, Stepper, StepperOptions};
use mechanics_core::law::{Lame, StableNeoHookean};
use mechanics_core::mesh::{BoxSplit, TetMesh, block};
use mechanics_core::point_map::PointMap;
use mechanics_core::state::State;
use mechanics_core::stencil::StencilTerm;
use mechanics_core::tensor::Vec3;

/// Kilograms, metres and seconds, or grams, millimetres and milliseconds: how many of the unit in one of SI.
#[derive(Clone, Copy)]
pub(crate) struct Units {
    pub(crate) length: f64,
    pub(crate) mass: f64,
    pub(crate) time: f64,
}

impl Units {
    pub(crate) const SI: Self = Self { length: 1.0, mass: 1.0, time: 1.0 };
    pub(crate) const MILLI: Self = Self { length: 1e3, mass: 1e3, time: 1e3 };

    pub(crate) fn force(self) -> f64 {
        self.mass * self.length / (self.time * self.time)
    }
    pub(crate) fn pressure(self) -> f64 {
        self.force() / (self.length * self.length)
    }
}

pub(crate) const YOUNG: f64 = 1e5;
pub(crate) const DENSITY: f64 = 1000.0;
pub(crate) const GRAVITY: f64 = 9.81;

/// A cube of edge 0.1 m in n³ cells of six tetrahedra, moved.
pub(crate) fn cube(cells: u32, by: Vec3) -> TetMesh {
    let mut mesh = block(&Vec3::zeros(), &Vec3::repeat(0.1), [cells; 3], BoxSplit::Six).unwrap();
    mesh.translate(&by).unwrap();
    mesh
}

/// All bodies as one mesh, and their collision mesh with an optional floor.
pub(crate) fn join(bodies: &[TetMesh], floor: Option<HalfSpace>) -> (TetMesh, CollisionMesh) {
    join_with(bodies, floor, SelfContact::Allowed)
}

/// The same, with contact of bodies with themselves or without.
pub(crate) fn join_with(
    bodies: &[TetMesh],
    floor: Option<HalfSpace>,
    self_contact: SelfContact,
) -> (TetMesh, CollisionMesh) {
    let mut all = bodies[0].clone();
    let mut first = vec![0];
    for body in &bodies[1..] {
        first.push(all.append(body).unwrap());
    }
    let mut builder = CollisionMeshBuilder::new(all.points());
    for (body, &first) in bodies.iter().zip(&first) {
        builder.add_object(CollisionObject::of_tets(body, first).unwrap().with_self_contact(self_contact));
    }
    if let Some(floor) = floor {
        builder.add_half_space(floor);
    }
    let mesh = builder.build().unwrap();
    (all, mesh)
}

/// Elastic bodies that may touch.
pub(crate) struct World {
    pub(crate) elastic: StencilTerm<Tetrahedra<StableNeoHookean>, 4>,
    pub(crate) gravity: Option<DeadLoad>,
    pub(crate) contact: BarrierContact,
    pub(crate) stepper: Stepper,
    pub(crate) state: State,
}

impl World {
    pub(crate) fn new(
        mesh: &TetMesh,
        contact: BarrierContact,
        units: Units,
        options: StepperOptions,
    ) -> Self {
        let law = StableNeoHookean::new(Lame::from_young_poisson(YOUNG * units.pressure(), 0.3).unwrap());
        let elastic = Tetrahedra::term("elastic", law, mesh).unwrap();
        let mut mass = Mass::zeros(mesh.points().len());
        let density = DENSITY * units.mass / units.length.powi(3);
        mass.add_tetrahedra(mesh.points(), mesh.cells(), density, MassDistribution::Lumped).unwrap();
        let stepper = Stepper::new(mass, PointMap::identity(mesh.points().len()), options);
        let state = State::at_rest(mesh.points().to_vec());
        Self { elastic, gravity: None, contact, stepper, state }
    }

    pub(crate) fn with_gravity(mut self, units: Units) -> Self {
        let g = Vec3::new(0.0, 0.0, -GRAVITY * units.length / (units.time * units.time));
        self.gravity = Some(DeadLoad::gravity(self.stepper.mass(), &g).unwrap());
        self
    }

    pub(crate) fn try_step(&mut self, h: f64) -> Result<StepReport, StepError> {
        match &mut self.gravity {
            Some(gravity) => {
                self.stepper.step(&mut self.state, &mut [&mut self.elastic, gravity, &mut self.contact], h)
            }
            None => self.stepper.step(&mut self.state, &mut [&mut self.elastic, &mut self.contact], h),
        }
    }

    /// A step, after which nothing may intersect.
    pub(crate) fn step(&mut self, h: f64) -> StepReport {
        let report = self.try_step(h).unwrap();
        assert!(
            check(self.contact.mesh(), &self.state.position).unwrap().is_empty(),
            "at {} s",
            self.state.time
        );
        report
    }

    /// Σ m v and Σ m x × v.
    pub(crate) fn momenta(&self) -> [Vec3; 2] {
        let mass = self.stepper.mass().diagonal();
        let State { position, velocity, .. } = &self.state;
        let linear = mass.iter().zip(velocity).map(|(m, v)| v * *m).sum();
        let angular = mass.iter().zip(position.iter().zip(velocity)).map(|(m, (x, v))| x.cross(v) * *m).sum();
        [linear, angular]
    }
}
