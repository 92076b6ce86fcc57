//! A soft pad and a sphere: the field of pressure, and what the pad resists when the sphere is shifted.

use super::{friction, push};
use crate::experiment::contact::hertz::{boussinesq, graded};
use crate::experiment::contact::portrait::pictured;
use crate::experiment::contact::press::face_at;
use crate::experiment::contact::world::{Material, World, WorldBuilder};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{Count, NonNegative, Positive};
use ipc_contact::collision_mesh::{CollisionObject, SelfContact};
use ipc_contact::contact::ContactOptions;
use ipc_contact::contact_set::Weighting;
use ipc_contact::stiffness::{Scale, Stiffness};
use lagrangian::stepper::{Lagging, StepperOptions};
use mechanics_core::mesh::{Diagonals, TetMesh, TriMesh, height_field};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::PI;
use std::ops::Range;

/// A pad 20 × 20 × 10 mm (E = 0.1 MPa, ν = 0.3) that a rigid sphere presses so far that the radius of contact is 1 mm by Hertz; all
/// faces but the upper one move as the half-space does there, by Boussinesq and Cerruti. `sheared` then shifts the sphere. The ladder is one
/// over the number of cells across. Area-weighted contact.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct TactilePad {
    /// Of the sphere (m).
    radius_m: Positive,
    /// How much finer cells are in the middle: they lie at sinh(βs)/sinh(β) for equidistant s.
    grading: Positive,
    /// The activation distance with 8 cells across, in parts of the indentation.
    activation: Positive,
    /// It falls as this power of the ladder.
    activation_order: NonNegative,
    /// μ, of `sheared`.
    friction_coefficient: Positive,
    /// Q/(μP) that the sphere is shifted for.
    shear: Positive,
    /// Steps of the shift.
    shear_steps: Count,
}

const GEL: Material = Material { young: 1e5, poisson: 0.3, density: 1000.0 };
/// Radius of contact by Hertz, and the half width of the pad (m).
const CONTACT: f64 = 1e-3;
const HALF: f64 = 0.01;
/// Half of the width of the piece of the sphere that is there, in radii of contact.
const CAP: f64 = 1.6;

fn modulus() -> f64 {
    GEL.young / (1.0 - GEL.poisson * GEL.poisson)
}

/// The displacement at `x` (z into the body) of a half-space by a force `q` (N) at the origin along x.
///
/// Reference: V. Cerruti 1882; K. L. Johnson, *Contact Mechanics*, 1985, equations 3.75.
fn cerruti(q: f64, x: &Vec3) -> Vec3 {
    let shear = 0.5 * GEL.young / (1.0 + GEL.poisson);
    let (rho, part) = (x.norm(), 1.0 - 2.0 * GEL.poisson);
    let (cube, depth) = (rho.powi(3), rho + x.z);
    let along = 1.0 / rho + x.x * x.x / cube + part * (1.0 / depth - x.x * x.x / (rho * depth * depth));
    let across = x.x * x.y / cube - part * x.x * x.y / (rho * depth * depth);
    let down = x.x * x.z / cube + part * x.x / (rho * depth);
    Vec3::new(along, across, down) * (q / (4.0 * PI * shear))
}

/// Between the frame of the closed forms, with z into the body, and ours.
fn turned(x: &Vec3) -> Vec3 {
    Vec3::new(x.x, -x.y, -x.z)
}

/// What Hertz says of a force on the sphere.
struct Hertz {
    force: f64,
    contact: f64,
    peak: f64,
}

impl Hertz {
    fn of_force(force: f64, radius: f64) -> Self {
        let contact = (0.75 * force * radius / modulus()).cbrt();
        Self { force, contact, peak: 1.5 * force / (PI * contact * contact) }
    }

    fn of_contact(contact: f64, radius: f64) -> Self {
        Self::of_force(4.0 / 3.0 * modulus() * contact.powi(3) / radius, radius)
    }

    fn pressure(&self, r: f64) -> f64 {
        self.peak * (1.0 - (r / self.contact).powi(2)).max(0.0).sqrt()
    }
}

struct Pressed {
    world: World,
    pad: TetMesh,
    sphere: Range<u32>,
    far: Vec<u32>,
    skin: Vec<[u32; 3]>,
}

/// Forces that are read off the pad's points.
struct Reading {
    /// On the sphere: along x, and up (N).
    shear: f64,
    force: f64,
    /// By the second moment of the pressure (m).
    contact: f64,
    /// In the middle (Pa).
    peak: f64,
    /// The difference of the field from Hertz's for the force that is read, in parts of it.
    field: f64,
    pressures: Vec<f64>,
}

impl TactilePad {
    fn indentation(&self) -> f64 {
        CONTACT * CONTACT / self.radius_m.value()
    }

    fn cap(&self, cells: u32, activation: f64) -> Result<TriMesh, ExperimentError> {
        let (radius, width) = (self.radius_m.value(), 2.0 * CAP * CONTACT);
        let height = |x: f64, y: f64| {
            let square = (x - 0.5 * width).powi(2) + (y - 0.5 * width).powi(2);
            radius - (radius * radius - square).sqrt()
        };
        let mut cap = height_field([width; 2], [cells; 2], Diagonals::Alternating, height)
            .map_err(ExperimentError::stopped)?;
        cap.translate(&Vec3::new(-0.5 * width, -0.5 * width, activation))
            .map_err(ExperimentError::stopped)?;
        Ok(cap)
    }

    fn pressed(&self, at: &Point<'_>, coefficient: f64) -> Result<Pressed, ExperimentError> {
        let cells = (1.0 / at.ladder).round();
        let activation =
            self.activation.value() * self.indentation() * (8.0 / cells).powf(self.activation_order.value());
        let (mut pad, _) = graded(cells as u32, self.grading.value())?;
        pad.map_points(|x| turned(x) * HALF).map_err(ExperimentError::stopped)?;
        let cap = self.cap(2 * cells as u32, activation)?;
        let object = face_at(&pad, 0.0, 0)?;
        let skin = object.triangles.clone();
        let mut builder = WorldBuilder::default();
        let stick = 1e-3 * self.shift() / self.shear_steps.value() as f64;
        if coefficient > 0.0 {
            builder = builder.with_friction(friction(coefficient, stick)?);
        }
        builder.add_solid_that_touches(&pad, GEL, Vec3::zeros(), object)?;
        let is_far = |x: &Vec3| x.x.abs() >= HALF || x.y.abs() >= HALF || x.z <= -HALF;
        let far: Vec<u32> = (0..).zip(pad.points()).filter(|(_, x)| is_far(x)).map(|(i, _)| i).collect();
        builder.script(far.iter().copied());
        let sphere = builder.add_obstacle(cap.points(), |first| {
            CollisionObject::of_mesh(&cap, first).with_self_contact(SelfContact::Excluded)
        });
        let peak = Hertz::of_contact(CONTACT, self.radius_m.value()).peak;
        let contact = ContactOptions {
            weighting: Weighting::Area,
            ..ContactOptions::new(activation, Stiffness::fixed(Scale::Load(peak)))
        };
        let newton = NewtonOptions { tolerance: 1e-4 * activation, ..NewtonOptions::default() };
        let options = StepperOptions { newton, lagging: Lagging::Until(50), ..StepperOptions::default() };
        let world = builder.build(Vec3::zeros(), contact, options)?;
        Ok(Pressed { world, pad, sphere, far, skin })
    }

    /// By Cattaneo and Mindlin, for the sphere's Q/(μP) (m); K. L. Johnson, *Contact Mechanics*, 1985, equation 7.42.
    fn shift(&self) -> f64 {
        let hertz = Hertz::of_contact(CONTACT, self.radius_m.value());
        let bound = self.friction_coefficient.value() * hertz.force;
        3.0 * bound * compliance() / (16.0 * CONTACT) * (1.0 - (1.0 - self.shear.value()).powf(2.0 / 3.0))
    }

    /// Q by the same for a shift and a force (N).
    fn resistance(&self, shift: f64, hertz: &Hertz) -> f64 {
        let bound = self.friction_coefficient.value() * hertz.force;
        let part = 16.0 * hertz.contact * shift / (3.0 * bound * compliance());
        bound * (1.0 - (1.0 - part).max(0.0).powf(1.5))
    }
}

/// (2 − ν)/G (1/Pa).
fn compliance() -> f64 {
    (2.0 - GEL.poisson) * 2.0 * (1.0 + GEL.poisson) / GEL.young
}

impl Pressed {
    /// Puts the far points where the half-space has them under forces on the sphere (N).
    fn move_far(&mut self, force: f64, shear: f64) -> Result<(), ExperimentError> {
        for &point in &self.far {
            let rest = self.pad.points()[point as usize];
            let inner = turned(&rest) / CONTACT;
            // The formulas of `boussinesq` are for 1 MPa; lengths are in radii of contact.
            let normal = boussinesq(force, &inner) * (1e6 / GEL.young / CONTACT);
            let tangential = cerruti(shear, &inner) / CONTACT;
            self.world.move_to(point, rest + turned(&(normal + tangential)))?;
        }
        Ok(())
    }

    fn read(&self, radius: f64) -> Reading {
        let x = &self.world.state.position;
        let normal = self.world.contact.forces(x);
        let on_sphere =
            |forces: &[Vec3]| -> Vec3 { self.sphere.clone().map(|point| forces[point as usize]).sum() };
        let mut total = on_sphere(&normal);
        if let Some(both) = self.world.contact.friction() {
            total += on_sphere(&both.friction().forces(x));
        }
        let middle =
            self.sphere.clone().map(|point| x[point as usize]).sum::<Vec3>() / self.sphere.len() as f64;
        let points = 0..self.pad.points().len();
        let area = |i: usize| self.world.contact.mesh().point_area(i as u32);
        let hertz = Hertz::of_force(total.z, radius);
        let (mut moment, mut difference, mut whole) = (0.0, 0.0, 0.0);
        let mut pressures = vec![0.0; x.len()];
        let mut nearest = (f64::INFINITY, 0.0);
        for i in points.filter(|&i| self.pad.points()[i].z == 0.0) {
            let r = (x[i].x - middle.x).hypot(x[i].y - middle.y);
            pressures[i] = -normal[i].z / area(i);
            moment -= normal[i].z * r * r;
            difference += area(i) * (pressures[i] - hertz.pressure(r)).powi(2);
            whole += area(i) * hertz.pressure(r).powi(2);
            if r < nearest.0 {
                nearest = (r, pressures[i]);
            }
        }
        Reading {
            shear: total.x,
            force: total.z,
            contact: (2.5 * moment / total.z).sqrt(),
            peak: nearest.1,
            field: (difference / whole).sqrt(),
            pressures,
        }
    }
}

impl Experiment for TactilePad {
    fn methods(&self) -> &'static [&'static str] {
        &["pressed", "sheared"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let radius = self.radius_m.value();
        let aim = Hertz::of_contact(CONTACT, radius);
        let mut pressed = self.pressed(at, 0.0)?;
        pressed.move_far(aim.force, 0.0)?;
        let down = -(self.indentation() + pressed.world.contact.options().activation_distance);
        push(&mut pressed.world, pressed.sphere.clone(), Vec3::z() * down)?;
        pressed.world.equilibrium(1, clock)?;
        let mut read = pressed.read(radius);
        let mut shear = f64::NAN;
        if at.method == "sheared" {
            let positions = pressed.world.state.position.clone();
            pressed = self.pressed(at, self.friction_coefficient.value())?;
            for point in pressed.far.iter().copied().chain(pressed.sphere.clone()) {
                pressed.world.move_to(point, positions[point as usize])?;
            }
            pressed.world.state.position = positions;
            let steps = self.shear_steps.value() as u32;
            for step in 1..=steps {
                let shift = self.shift() * f64::from(step) / f64::from(steps);
                pressed.move_far(aim.force, self.resistance(shift, &aim))?;
                push(
                    &mut pressed.world,
                    pressed.sphere.clone(),
                    Vec3::x() * (self.shift() / f64::from(steps)),
                )?;
                pressed.world.equilibrium(1, clock)?;
            }
            read = pressed.read(radius);
            let expected = self.resistance(self.shift(), &Hertz::of_force(read.force, radius));
            shear = -read.shear / expected - 1.0;
        }
        let own = Hertz::of_force(read.force, radius);
        let mut outcome = pressed
            .world
            .outcome()
            .count("contacts", read.pressures.iter().filter(|p| **p > 0.0).count() as u64)
            .error("force", (read.force / aim.force - 1.0).abs())
            .error("radius", (read.contact / own.contact - 1.0).abs())
            .error("peak pressure", (read.peak / own.peak - 1.0).abs())
            .error("field", read.field);
        if at.method == "sheared" {
            outcome = outcome.error("shear force", shear.abs());
        }
        let x = &pressed.world.state.position;
        pictured(outcome, at, x, &pressed.skin, ("contact pressure", "Pa", read.pressures))
    }
}
