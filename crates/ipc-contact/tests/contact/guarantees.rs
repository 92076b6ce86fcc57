//! What must never happen, and what is refused.

use crate::scene::{Units, World, cube, join};
use ipc_contact::ContactError;
use ipc_contact::collision_mesh::{CollisionMeshBuilder, CollisionObject};
use ipc_contact::contact::{BarrierContact, ContactOptions};
use ipc_contact::intersection::check;
use ipc_contact::stiffness::{Scale, Stiffness};
use lagrangian::element::membrane::{Membranes, NeoHookeanSheet};
use lagrangian::element::{Mass, MassDistribution, Tetrahedra};
use lagrangian::stepper::{StepError, Stepper, StepperOptions};
use mechanics_core::law::{Lame, StableNeoHookean};
use mechanics_core::mesh::{Diagonals, TriMesh, ball, sheet};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::objective::Projecting;
use mechanics_core::point_map::PointMap;
use mechanics_core::potential::{Changed, Demand, Potential, PotentialError, StepLimit};
use mechanics_core::projection::Projection;
use mechanics_core::sparse::Assembler;
use mechanics_core::stage::Stage;
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;

fn contact_error(error: &StepError) -> &ContactError {
    let StepError::Term { source: PotentialError::Term { term, source }, .. } = error else {
        panic!("{error}")
    };
    assert_eq!(term, "contact");
    source.downcast_ref().unwrap()
}

fn options() -> ContactOptions {
    ContactOptions::new(1e-3, Stiffness::adaptive(Scale::Load(1.0)))
}

#[test]
fn an_intersecting_start_is_refused_with_names_and_changes_nothing() {
    let (all, mesh) = join(&[cube(2, Vec3::zeros()), cube(2, Vec3::new(0.01, 0.02, 0.09))], None);
    let contact = BarrierContact::new(mesh, options()).unwrap();
    let mut world = World::new(&all, contact, Units::SI, StepperOptions::default());
    world.state.velocity.fill(Vec3::new(0.1, 0.0, 0.0));
    let before = world.state.clone();
    let error = world.try_step(0.01).unwrap_err();
    let ContactError::Intersecting { pairs } = contact_error(&error) else { panic!("{error}") };
    assert_eq!(*pairs, check(world.contact.mesh(), &before.position).unwrap());
    assert!(
        error.to_string().contains("of object 0") && error.to_string().contains("of object 1"),
        "{error}"
    );
    assert_eq!(world.state.hash(), before.hash());
    // Put apart, the same objects go on.
    world.state.position.iter_mut().skip(27).for_each(|x| x.z += 0.02);
    world.step(0.01);
}

#[test]
fn a_touching_start_is_refused() {
    let (all, mesh) = join(&[cube(1, Vec3::zeros()), cube(1, Vec3::new(0.02, 0.03, 0.1))], None);
    let contact = BarrierContact::new(mesh, options()).unwrap();
    let mut world = World::new(&all, contact, Units::SI, StepperOptions::default());
    let error = world.try_step(0.01).unwrap_err();
    assert!(matches!(contact_error(&error), ContactError::Intersecting { .. }), "{error}");
}

#[test]
fn a_start_within_the_minimum_separation_is_refused() {
    let (all, mesh) = join(&[cube(1, Vec3::zeros()), cube(1, Vec3::new(0.02, 0.03, 0.101))], None);
    let options = ContactOptions { minimum_separation: 2e-3, ..options() };
    let contact = BarrierContact::new(mesh, options).unwrap();
    let mut world = World::new(&all, contact, Units::SI, StepperOptions::default());
    let error = world.try_step(0.01).unwrap_err();
    let ContactError::TooClose { pairs, minimum_separation } = contact_error(&error) else {
        panic!("{error}")
    };
    assert_eq!(*minimum_separation, 2e-3);
    assert!(pairs.iter().all(|pair| (pair.distance - 1e-3).abs() < 1e-12), "{pairs:?}");
}

/// Does contact look where a step goes?
#[derive(Clone, Copy, PartialEq)]
enum Sight {
    Seeing,
    Blind,
}

/// How a shot ended.
#[derive(Debug, PartialEq)]
enum Shot {
    /// Above the sheet, without intersection, after every step.
    Held,
    /// Below the sheet, or within it.
    Through,
    /// A step was refused.
    Refused,
}

/// Contact that may be blind: the check of the check.
struct Watched {
    contact: BarrierContact,
    sight: Sight,
}

impl Potential for Watched {
    fn name(&self) -> &str {
        self.contact.name()
    }
    fn value(&self, x: &[Vec3]) -> f64 {
        self.contact.value(x)
    }
    fn add_gradient(&self, x: &[Vec3], gradient: &mut [Vec3]) {
        self.contact.add_gradient(x, gradient);
    }
    fn add_hessian(&self, x: &[Vec3], projection: Projection, hessian: &mut Assembler<'_>) {
        self.contact.add_hessian(x, projection, hessian);
    }
    fn freeze(&mut self, stage: &Stage<'_>) -> Result<Changed, PotentialError> {
        self.contact.freeze(stage)
    }
    fn limit_step(&mut self, x: &[Vec3], p: &[Vec3]) -> Result<StepLimit, PotentialError> {
        if self.sight == Sight::Blind { Ok(StepLimit::FULL) } else { self.contact.limit_step(x, p) }
    }
    fn demand(&self) -> Demand {
        self.contact.demand()
    }
}

/// A ball of radius 2 cm flies with `speed` into a sheet of 20 cm and 1 mm whose rim is held, and is to stay above it.
fn shoot(speed: f64, h: f64, steps: u32, sight: Sight) -> Shot {
    let mut projectile = ball(0.02, 3).unwrap();
    projectile.translate(&Vec3::new(0.003, 0.002, 0.025)).unwrap();
    let mut cloth = sheet([0.2, 0.2], [8, 8], Diagonals::Alternating).unwrap();
    cloth.translate(&Vec3::new(-0.1, -0.1, 0.0)).unwrap();
    let first = projectile.points().len();
    let rest: Vec<Vec3> = projectile.points().iter().chain(cloth.points()).copied().collect();
    let mut builder = CollisionMeshBuilder::new(&rest);
    builder.add_object(CollisionObject::of_tets(&projectile, 0).unwrap());
    builder.add_object(CollisionObject::of_mesh(&cloth, first as u32));
    let rim = |x: &Vec3| x.xy().amax() > 0.0999;
    let held: Vec<(u32, Vec3)> =
        rest.iter().zip(0..).skip(first).filter(|(x, _)| rim(x)).map(|(x, point)| (point, *x)).collect();
    builder.script_points(held.iter().map(|(point, _)| *point));
    let options = ContactOptions::new(1e-3, Stiffness::adaptive(Scale::Load(1e3)));
    let mut contact =
        Watched { contact: BarrierContact::new(builder.build().unwrap(), options).unwrap(), sight };

    let lame = Lame::from_young_poisson(1e9, 0.3).unwrap();
    let mut mass = Mass::zeros(rest.len());
    mass.add_tetrahedra(&rest, projectile.cells(), 2000.0, MassDistribution::Lumped).unwrap();
    (first..rest.len()).for_each(|point| mass.add_point(point as u32, 1e-4).unwrap());
    let mut elastic = Tetrahedra::term("ball", StableNeoHookean::new(lame), &projectile).unwrap();
    let triangles = cloth.triangles().iter().map(|t| t.map(|p| p + first as u32)).collect();
    let whole = TriMesh::new(rest.clone(), triangles).unwrap();
    let mut membrane =
        Membranes::term("sheet", &whole, NeoHookeanSheet::new(1e9, 0.3).unwrap(), 1e-3).unwrap();

    let newton =
        NewtonOptions { tolerance: 1e-2 * speed.max(1.0), max_iterations: 300, ..Default::default() };
    let stepping = StepperOptions { newton, projecting: Projecting::OnDemand, ..Default::default() };
    let mut stepper = Stepper::new(mass, PointMap::with_fixed(rest.len(), &held).unwrap(), stepping);
    let mut state = State::at_rest(rest);
    state.velocity[..first].fill(Vec3::new(0.0, 0.0, -speed));
    let mut touched = false;
    for _ in 0..steps {
        if stepper.step(&mut state, &mut [&mut elastic, &mut membrane, &mut contact], h).is_err() {
            return Shot::Refused;
        }
        touched |= contact.contact.report().contacts.total() > 0;
        let mesh = contact.contact.mesh();
        let mut surface = mesh.vertices().iter().filter(|&&point| (point as usize) < first);
        let passed = surface.any(|&point| is_below(&state.position, point, &whole));
        if passed || !check(mesh, &state.position).unwrap().is_empty() {
            return Shot::Through;
        }
    }
    assert!(touched);
    Shot::Held
}

/// Whether a point is on the far side of the deformed sheet: the ray upwards from it meets the sheet's triangles an odd number of
/// times. The rim lies in a plane and the points above or below its inside, so that the sheet with the plane outside of its
/// rim parts space in two, and the ray never passes that plane.
fn is_below(x: &[Vec3], point: u32, sheet: &TriMesh) -> bool {
    let point = &x[point as usize];
    let meets = |t: &&[u32; 3]| {
        let [a, b, c] = t.map(|p| x[p as usize]);
        let side = |a: &Vec3, b: &Vec3| (b.x - a.x) * (point.y - a.y) - (b.y - a.y) * (point.x - a.x);
        let weights = [side(&b, &c), side(&c, &a), side(&a, &b)];
        let inside = weights.iter().all(|w| *w > 0.0) || weights.iter().all(|w| *w < 0.0);
        let height = (a.z * weights[0] + b.z * weights[1] + c.z * weights[2]) / weights.iter().sum::<f64>();
        inside && height > point.z
    };
    sheet.triangles().iter().filter(meets).count() % 2 == 1
}

#[test]
fn a_fast_ball_does_not_tunnel_through_a_thin_sheet() {
    assert_eq!(shoot(1000.0, 0.01, 2, Sight::Seeing), Shot::Held);
    assert_eq!(shoot(30.0, 1e-3, 4, Sight::Seeing), Shot::Held);
}

#[test]
fn without_detection_it_does() {
    assert_ne!(shoot(1000.0, 0.01, 2, Sight::Blind), Shot::Held);
}
