//! Hertz's contact: force against indentation.

use super::forms::{FORMS, form};
use super::portrait::pictured;
use super::press::face_at;
use super::world::{Material, WorldBuilder};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{Count, NonNegative, Positive};
use ipc_contact::collision_mesh::HalfSpace;
use ipc_contact::contact::ContactOptions;
use ipc_contact::contact_set::Weighting;
use ipc_contact::stiffness::{Scale, Stiffness};
use lagrangian::stepper::StepperOptions;
use mechanics_core::mesh::{BoxSplit, TetMesh, block};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::PI;

/// An elastic block 2 × 2 × 1 m, E = 1 MPa and ν = 0.3, whose lower face is a sphere's cap of radius 1 km, pressed on a
/// half-space so far that the radius of contact is `contact_radius_m`. All other faces are moved as the half-space in Hertz's
/// solution moves far from contact: by the indentation, less Boussinesq's field of a point force. The ladder is one over the number of
/// cells across. Area-weighted contact.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Hertz {
    /// a (m).
    contact_radius_m: Positive,
    /// How much finer cells are in the middle: they lie at sinh(βs)/sinh(β) for equidistant s.
    grading: Positive,
    /// The activation distance with 8 cells across, in parts of the indentation. Newton's tolerance is 1e-4 of it: at strains of
    /// 1e-4 the energy's rounding hides smaller steps.
    activation: Positive,
    /// It falls as this power of the ladder.
    activation_order: NonNegative,
    /// Parts in which the indentation is put on.
    load_steps: Count,
}

const YOUNG: f64 = 1e6;
const POISSON: f64 = 0.3;
const RADIUS: f64 = 1000.0;

/// Boussinesq's displacement at `x` (z into the body) by a force `p` (N) at the origin along z.
///
/// Reference: K. L. Johnson, *Contact Mechanics*, 1985, equations 3.18.
pub(in crate::experiment) fn boussinesq(p: f64, x: &Vec3) -> Vec3 {
    let (r, rho) = (x.x.hypot(x.y), x.norm());
    let factor = p * (1.0 + POISSON) / (2.0 * PI * YOUNG);
    let along = factor * (x.z * x.z / rho.powi(3) + 2.0 * (1.0 - POISSON) / rho);
    let across = factor * (r * x.z / rho.powi(3) - (1.0 - 2.0 * POISSON) * r / (rho * (rho + x.z)));
    let outwards = if r > 0.0 { Vec3::new(x.x, x.y, 0.0) / r } else { Vec3::zeros() };
    outwards * across + Vec3::z() * along
}

/// The block, with the cap as its face z = 0 for now; and its points with the cap.
pub(in crate::experiment) fn graded(n: u32, grading: f64) -> Result<(TetMesh, TetMesh), ExperimentError> {
    let box_of_cells =
        block(&Vec3::new(-1.0, -1.0, 0.0), &Vec3::new(1.0, 1.0, 1.0), [n, n, n.div_ceil(2)], BoxSplit::Five);
    let mut flat = box_of_cells.map_err(ExperimentError::stopped)?;
    let place = |s: f64| if s.abs() == 1.0 { s } else { (grading * s).sinh() / grading.sinh() };
    flat.map_points(|x| x.map(place)).map_err(ExperimentError::stopped)?;
    let mut capped = flat.clone();
    // The cap fades out upwards, so that cells near it keep their shape and the other faces stay plane.
    capped
        .map_points(|x| x + Vec3::z() * (0.5 * (x.x * x.x + x.y * x.y) / RADIUS * (1.0 - x.z)))
        .map_err(ExperimentError::stopped)?;
    Ok((flat, capped))
}

impl Experiment for Hertz {
    fn methods(&self) -> &'static [&'static str] {
        FORMS
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let a = self.contact_radius_m.value();
        let modulus = YOUNG / (1.0 - POISSON * POISSON);
        let indentation = a * a / RADIUS;
        let force = 4.0 / 3.0 * modulus * RADIUS.sqrt() * indentation.powf(1.5);
        let peak = 1.5 * force / (PI * a * a);
        let cells = (1.0 / at.ladder).round();
        let activation =
            self.activation.value() * indentation * (8.0 / cells).powf(self.activation_order.value());

        let (flat, mesh) = graded(cells as u32, self.grading.value())?;
        let material = Material { young: YOUNG, poisson: POISSON, density: 1000.0 };
        let object = face_at(&flat, 0.0, 0)?;
        let skin = object.triangles.clone();
        let mut builder = WorldBuilder::default();
        builder.add_solid_that_touches(&mesh, material, Vec3::zeros(), object)?;
        builder.add_half_space(HalfSpace { normal: Vec3::z(), offset: -activation });
        let is_far = |x: &Vec3| x.x.abs() == 1.0 || x.y.abs() == 1.0 || x.z == 1.0;
        let far: Vec<u32> = (0..).zip(flat.points()).filter(|(_, x)| is_far(x)).map(|(i, _)| i).collect();
        builder.script(far.iter().copied());
        let contact = ContactOptions {
            form: form(at.method),
            weighting: Weighting::Area,
            ..ContactOptions::new(activation, Stiffness::fixed(Scale::Load(peak)))
        };
        let newton = NewtonOptions { tolerance: 1e-4 * activation, ..NewtonOptions::default() };
        let options = StepperOptions { newton, ..StepperOptions::default() };
        let mut world = builder.build(Vec3::zeros(), contact, options)?;
        for &point in &far {
            let moved = boussinesq(force, &flat.points()[point as usize]);
            let target = mesh.points()[point as usize] + moved - Vec3::z() * (indentation + activation);
            world.move_to(point, target)?;
        }
        world.equilibrium(self.load_steps.value() as u32, clock)?;

        let forces = world.contact.forces(&world.state.position);
        let found: f64 = forces.iter().map(|f| f.z).sum();
        let area = |point: usize| world.contact.mesh().point_area(point as u32);
        let middle = flat.points().iter().position(|x| *x == Vec3::zeros());
        let pressure = middle.map_or(f64::NAN, |point| forces[point].z / area(point));
        let outcome = world
            .outcome()
            .count("contacts", forces.iter().filter(|f| f.z > 0.0).count() as u64)
            .error("force", (found / force - 1.0).abs())
            .error("peak pressure", (pressure / peak - 1.0).abs());
        let pressures =
            (0..forces.len()).map(|i| if forces[i].z > 0.0 { forces[i].z / area(i) } else { 0.0 });
        pictured(outcome, at, &world.state.position, &skin, ("contact pressure", "Pa", pressures.collect()))
    }
}
