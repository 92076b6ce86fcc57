//! The scenes that are stepped.

use ipc_contact::collision_mesh::{CollisionMeshBuilder, CollisionObject, HalfSpace, SelfContact};
use ipc_contact::contact::{BarrierContact, ContactOptions};
use ipc_contact::stiffness::{Scale, Stiffness};
use ipc_friction::{ContactWithFriction, FrictionOptions};
use lagrangian::element::hinge::{Hinges, RestAngle};
use lagrangian::element::membrane::{Membranes, NeoHookeanSheet};
use lagrangian::element::strain_limit::StrainLimits;
use lagrangian::element::{DeadLoad, Mass, MassDistribution, Tetrahedra};
use lagrangian::stepper::{Lagging, StepReport, Stepper, StepperOptions};
use mechanics_core::law::{Lame, StableNeoHookean};
use mechanics_core::mesh::{Diagonals, TetMesh, TriMesh, sheet};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::point_map::PointMap;
use mechanics_core::potential::Potential;
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;

/// Time of a step \[s\].
const STEP: f64 = 0.01;
/// [m/s].
const TOLERANCE: f64 = 1e-3;
/// μ.
const FRICTION_COEFFICIENT: f64 = 0.5;
/// [m/s²].
const GRAVITY: f64 = 9.81;

/// How friction is solved.
#[derive(Clone, Copy)]
pub struct Solving {
    /// εᵥ [m/s].
    pub stick_velocity: f64,
    pub lagging: Lagging,
}

pub struct Scene {
    /// Everything but contact.
    bodies: Vec<Box<dyn Potential>>,
    pub contact: ContactWithFriction,
    without_friction: BarrierContact,
    stepper: Stepper,
    stepper_without_friction: Stepper,
    pub state: State,
}

impl Scene {
    fn new(
        bodies: Vec<Box<dyn Potential>>,
        surfaces: &CollisionMeshBuilder,
        options: ContactOptions,
        (mass, map): (Mass, PointMap),
        solving: Solving,
    ) -> Self {
        let contact = || BarrierContact::new(surfaces.build().unwrap(), options).unwrap();
        let friction = FrictionOptions::uniform(FRICTION_COEFFICIENT, solving.stick_velocity).unwrap();
        let newton = NewtonOptions { tolerance: TOLERANCE, ..Default::default() };
        let stepping = StepperOptions { newton, lagging: solving.lagging, ..Default::default() };
        let (contact, without_friction) = (contact(), contact());
        let state = State::at_rest(contact.mesh().rest().to_vec());
        let contact = ContactWithFriction::new(contact, friction).unwrap();
        let stepper = || Stepper::new(mass.clone(), map.clone(), stepping);
        let (stepper, stepper_without_friction) = (stepper(), stepper());
        Self { bodies, contact, without_friction, stepper, stepper_without_friction, state }
    }

    pub fn step(&mut self) -> StepReport {
        let Self { bodies, contact, stepper, state, .. } = self;
        let mut terms: Vec<&mut dyn Potential> = bodies.iter_mut().map(|body| &mut **body as _).collect();
        terms.push(contact);
        stepper.step(state, &mut terms, STEP).unwrap()
    }

    pub fn step_without_friction(&mut self) -> StepReport {
        let Self { bodies, without_friction, stepper_without_friction: stepper, state, .. } = self;
        let mut terms: Vec<&mut dyn Potential> = bodies.iter_mut().map(|body| &mut **body as _).collect();
        terms.push(without_friction);
        stepper.step(state, &mut terms, STEP).unwrap()
    }
}

/// `count` numbers in [−1, 1).
fn noise(count: usize) -> Vec<f64> {
    let mut state = 1_u64;
    let mut number = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    (0..count).map(|_| number()).collect()
}

/// A cube about the origin in n³ cells, each of twelve tetrahedra about its middle.
fn cube(edge: f64, n: u32) -> TetMesh {
    let corner = |i: u32, j: u32, k: u32| i + (n + 1) * (j + (n + 1) * k);
    let at = |i: f64, j: f64, k: f64| Vec3::new(i, j, k) * (edge / f64::from(n)) - Vec3::repeat(0.5 * edge);
    let lattice = |n: u32| (0..n).flat_map(move |k| (0..n).flat_map(move |j| (0..n).map(move |i| [i, j, k])));
    let mut points: Vec<Vec3> = lattice(n + 1).map(|c| at(c[0].into(), c[1].into(), c[2].into())).collect();
    let mut tets = Vec::new();
    for c in lattice(n) {
        let middle = points.len() as u32;
        let [i, j, k] = c.map(|c| f64::from(c) + 0.5);
        points.push(at(i, j, k));
        for (axis, side) in (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]) {
            let face = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[u, v]| {
                let mut c = c;
                c[axis] += side;
                c[(axis + 1) % 3] += u;
                c[(axis + 2) % 3] += v;
                corner(c[0], c[1], c[2])
            });
            tets.extend([[middle, face[0], face[1], face[2]], [middle, face[0], face[2], face[3]]]);
        }
    }
    let mut mesh = TetMesh::new(points, tets).unwrap();
    mesh.orient();
    mesh
}

/// Eight cubes, turned at random, thrown together above a floor.
pub fn tumbling_cubes(solving: Solving) -> Scene {
    const YOUNG: f64 = 1e5;
    const PITCH: f64 = 0.18;
    let random = noise(48);
    let mut all: Option<TetMesh> = None;
    let mut velocity = Vec::new();
    let mut objects = Vec::new();
    for (number, random) in random.chunks(6).enumerate() {
        let [turn, spin] = [&random[..3], &random[3..]].map(Vec3::from_row_slice);
        let cell = Vec3::new((number & 1) as f64, (number >> 1 & 1) as f64, (number >> 2) as f64);
        let centre = (cell - Vec3::new(0.5, 0.5, -0.5)) * PITCH;
        let mut mesh = cube(0.1, 4);
        mesh.rotate(&nalgebra::Rotation3::new(turn * 2.0)).unwrap();
        let inwards = -Vec3::new(centre.x, centre.y, 0.0) * 5.0 - Vec3::z();
        velocity.extend(mesh.points().iter().map(|x| inwards + (spin * 5.0).cross(x)));
        mesh.translate(&centre).unwrap();
        let first = velocity.len() - mesh.points().len();
        objects.push(CollisionObject::of_tets(&mesh, first as u32).unwrap());
        match &mut all {
            None => all = Some(mesh),
            Some(all) => drop(all.append(&mesh).unwrap()),
        }
    }
    let all = all.unwrap();
    assert_eq!((all.points().len(), all.cells().len()), (1512, 6144));
    let mut surfaces = CollisionMeshBuilder::new(all.points());
    for object in objects {
        surfaces.add_object(object.with_self_contact(SelfContact::Excluded));
    }
    surfaces.add_half_space(HalfSpace::through(&Vec3::zeros(), &Vec3::z()));
    let mut mass = Mass::zeros(all.points().len());
    mass.add_tetrahedra(all.points(), all.cells(), 1000.0, MassDistribution::Lumped).unwrap();
    let gravity = DeadLoad::gravity(&mass, &(-Vec3::z() * GRAVITY)).unwrap();
    let law = StableNeoHookean::new(Lame::from_young_poisson(YOUNG, 0.4).unwrap());
    let elastic = Tetrahedra::term("elastic", law, &all).unwrap();
    let activation = 1e-3;
    // Half a cell's face at the strain that closes half of d̂ over a cell.
    let load = Scale::Load(0.5 * YOUNG * 0.025 * activation);
    let options = ContactOptions::new(activation, Stiffness::adaptive(load));
    let map = PointMap::identity(all.points().len());
    let mut scene =
        Scene::new(vec![Box::new(elastic), Box::new(gravity)], &surfaces, options, (mass, map), solving);
    scene.state.velocity = velocity;
    scene
}

/// What a sheet of 0.2 kg/m², 1 mm thick, ν = 0.3, is made of.
struct Fabric {
    /// \[Pa\].
    young: f64,
    /// Of bending \[J\].
    rigidity: f64,
    /// The barrier on its stretch: where it begins, where it ends, its strength \[Pa\].
    limit: Option<([f64; 2], f64)>,
}

/// A sheet of E t = 1 kN/m.
pub fn cloth_on_sphere(solving: Solving) -> Scene {
    sheet_on_sphere(&Fabric { young: 1e6, rigidity: 1e-5, limit: None }, solving)
}

/// STARK's preset `Cotton_Fabric` (version of its `deformables_preset_types.cpp` with E = 10³ Pa; a later one has 5·10³): 0.2 kg/m²,
/// 1 mm, ν = 0.3, bending 10⁻⁶ J, and beyond a Green strain of e₀ = 0.1 the energy k (e − e₀)³/3 with k = 10⁶ Pa.
///
/// In stretches that begins at ŝ = √1.2 with k ŝ³ (σ − ŝ)³/3. Our barrier begins with κ y³, y = (σ − ŝ)/(s − ŝ): the same for
/// κ = k ŝ³ (s − ŝ)³/3. Beyond, ours grows faster, and ends at s = 2. Its damping (of mass 0.1/s, of strain and bending a tenth of the stiffness times a second) is left out.
pub fn cotton_on_sphere(solving: Solving) -> Scene {
    let (begin, end) = (1.2_f64.sqrt(), 2.0_f64);
    let strength = 1e6 / 3.0 * (begin * (end - begin)).powi(3);
    sheet_on_sphere(&Fabric { young: 1e3, rigidity: 1e-6, limit: Some(([begin, end], strength)) }, solving)
}

/// A sheet that falls on a sphere.
fn sheet_on_sphere(fabric: &Fabric, solving: Solving) -> Scene {
    const RADIUS: f64 = 0.25;
    const THICKNESS: f64 = 1e-3;
    let flat = sheet([1.0, 1.0], [99, 99], Diagonals::Alternating).unwrap();
    let shift = Vec3::new(-0.503, -0.498, 5e-3);
    let cloth =
        TriMesh::new(flat.points().iter().map(|x| x + shift).collect(), flat.triangles().to_vec()).unwrap();
    let (sphere, faces) = crate::peers::icosphere(3);
    let count = cloth.points().len() as u32;
    let mut points = cloth.points().to_vec();
    points.extend(sphere.iter().map(|x| x * RADIUS - Vec3::z() * RADIUS));
    let fixed: Vec<(u32, Vec3)> = (count..points.len() as u32).map(|p| (p, points[p as usize])).collect();

    let mut surfaces = CollisionMeshBuilder::new(&points);
    surfaces.add_object(CollisionObject::of_mesh(&cloth, 0));
    let faces: Vec<[u32; 3]> = faces.iter().map(|face| face.map(|point| point + count)).collect();
    surfaces.add_object(CollisionObject::new(faces));
    surfaces.script_points(fixed.iter().map(|(point, _)| *point));

    let law = NeoHookeanSheet::new(fabric.young, 0.3).unwrap();
    let membrane = Membranes::new(&cloth, law, THICKNESS).unwrap();
    let mut mass = Mass::zeros(points.len());
    let local = |triangle: usize| membrane.local_mass(triangle, 200.0);
    mass.add_elements(cloth.triangles(), MassDistribution::Lumped, local).unwrap();
    let gravity = DeadLoad::gravity(&mass, &(-Vec3::z() * GRAVITY)).unwrap();
    let stretching = Membranes::term("membrane", &cloth, law, THICKNESS).unwrap();
    let hinges = Hinges::new(&cloth, fabric.rigidity, RestAngle::OfMesh).unwrap();
    let bending = hinges.term("bending").unwrap();
    let activation = 2e-3;
    // Some hundred vertices' weight.
    let options = ContactOptions::new(activation, Stiffness::adaptive(Scale::Load(0.02)));
    let map = PointMap::with_fixed(points.len(), &fixed).unwrap();
    let mut bodies: Vec<Box<dyn Potential>> =
        vec![Box::new(stretching), Box::new(bending), Box::new(gravity)];
    if let Some((stretches, strength)) = fabric.limit {
        let limit = StrainLimits::term("strain limit", &cloth, stretches, strength, THICKNESS).unwrap();
        bodies.push(Box::new(limit));
    }
    Scene::new(bodies, &surfaces, options, (mass, map), solving)
}
