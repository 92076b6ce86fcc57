//! A bar that is pressed on a plane: the force against the activation distance.

use super::forms::{FORMS, crossing, form, pull};
use super::world::{Material, WorldBuilder};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{Count, Positive};
use ipc_contact::collision_mesh::{CollisionObject, HalfSpace, SelfContact};
use ipc_contact::contact::ContactOptions;
use ipc_contact::contact_set::Weighting;
use ipc_contact::stiffness::{Scale, Stiffness};
use lagrangian::stepper::StepperOptions;
use mechanics_core::mesh::{BoxSplit, TetMesh, block};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

/// The faces of a mesh of tetrahedra that lie in the plane z = `height`, as an object that does not touch itself.
pub(in crate::experiment) fn face_at(
    mesh: &TetMesh,
    height: f64,
    first: u32,
) -> Result<CollisionObject, ExperimentError> {
    let mut object = CollisionObject::of_tets(mesh, first).map_err(ExperimentError::stopped)?;
    let is_in = |point: &u32| mesh.points()[(point - first) as usize].z == height;
    object.triangles.retain(|triangle| triangle.iter().all(is_in));
    Ok(object.with_self_contact(SelfContact::Excluded))
}

/// A bar 0.05 × 0.05 × 0.1 m with ν = 0 and E = 1 MPa whose upper end is moved towards a half-space; the ladder is the activation
/// distance in parts of the indentation. Area-weighted contact.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct PressedBar {
    /// How far the upper end goes beyond contact (m).
    indentation_m: Positive,
    /// Cells across; twice as many along.
    cells: Count,
}

const YOUNG: f64 = 1e6;
const WIDTH: f64 = 0.05;
const LENGTH: f64 = 0.1;

impl Experiment for PressedBar {
    fn methods(&self) -> &'static [&'static str] {
        FORMS
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let (form, indentation, n) = (form(at.method), self.indentation_m.value(), self.cells.value() as u32);
        let activation = at.ladder * indentation;
        let mesh = block(&Vec3::zeros(), &Vec3::new(WIDTH, WIDTH, LENGTH), [n, n, 2 * n], BoxSplit::Six)
            .map_err(ExperimentError::stopped)?;
        let material = Material { young: YOUNG, poisson: 0.0, density: 1000.0 };
        let mut builder = WorldBuilder::default();
        let object = face_at(&mesh, 0.0, 0)?;
        builder.add_solid_that_touches(&mesh, material, Vec3::zeros(), object)?;
        builder.add_half_space(HalfSpace { normal: Vec3::z(), offset: -activation });
        let held: Vec<u32> =
            (0..).zip(mesh.points()).filter(|(_, x)| x.z == LENGTH).map(|(i, _)| i).collect();
        builder.script(held.iter().copied());

        // What is to be: without a gap, and with that at which the bar's force is the barrier's.
        let pressure = YOUNG * indentation / LENGTH;
        let stiffness = Stiffness::fixed(Scale::Load(pressure));
        let contact =
            ContactOptions { form, weighting: Weighting::Area, ..ContactOptions::new(activation, stiffness) };
        let kappa = pressure / pull(form, activation, 0.5 * activation);
        let gap = crossing(activation, |gap| {
            kappa * pull(form, activation, gap) - YOUNG * (indentation + gap) / LENGTH
        });

        let newton = NewtonOptions { tolerance: 1e-5 * activation, ..NewtonOptions::default() };
        let options = StepperOptions { newton, ..StepperOptions::default() };
        let mut world = builder.build(Vec3::zeros(), contact, options)?;
        for &point in &held {
            let target = mesh.points()[point as usize] - Vec3::z() * (indentation + activation);
            world.move_to(point, target)?;
        }
        world.equilibrium(1, clock)?;
        let force: f64 = world.contact.forces(&world.state.position).iter().map(|f| f.z).sum();
        let found = force / (WIDTH * WIDTH) / pressure - 1.0;
        let gaps = world.state.position.iter().zip(mesh.points()).filter(|(_, rest)| rest.z == 0.0);
        let worst = gaps.map(|(x, _)| (x.z + activation - gap).abs()).fold(0.0, f64::max);
        Ok(world.outcome().error("force", found.abs()).error("gap", worst / gap))
    }
}
