//! Two fingers lift a soft ball by friction, and splats go with it.

use crate::experiment::contact::world::{Material, SolidLaw, World, WorldBuilder};
use crate::experiment::friction::robot::hand::{Grasp, Hand, mirrored};
use crate::experiment::friction::robot::{friction, mass_mean};
use crate::experiment::splat_motion::embedded::places;
use crate::experiment::splats::surface::{Cover, cover};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::picture::{Film, draw_splats};
use crate::scene::quantity::{Count, Positive};
use gaussian_deform::bind::{Moved, TetBinding, TetGradients};
use gaussian_deform::camera::{Camera, Orbit};
use gaussian_deform::transport::{Colours, Transport};
use gaussian_deform::{Splats, select};
use ipc_contact::contact::ContactOptions;
use ipc_contact::stiffness::{Scale, Stiffness};
use lagrangian::stepper::{Lagging, StepperOptions};
use mechanics_core::mesh::{TetMesh, ball, sphere, tet_volume};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::tensor::{Mat3, Vec3};
use schemars::JsonSchema;
use serde::Deserialize;
use std::ops::Range;

/// A soft ball of radius 30 mm (E = 20 kPa, ν = 0.3, 1000 kg/m³), covered with splats, lies on a pedestal between two plates, which press it, lift it by 40 mm, and keep it there. The ladder is εᵥ (m/s).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct GrippedSplats {
    /// The step (s).
    step_s: Positive,
    /// Parts of the ball's radius.
    cells: Count,
    /// How far each plate presses (m).
    squeeze_m: Positive,
    /// The distance at which contact begins (m).
    activation_distance_m: Positive,
    /// μ.
    coefficient: Positive,
    /// About one splat for the square of this (m).
    spacing_m: Positive,
}

const RADIUS: f64 = 0.03;
const LIFT: f64 = 0.04;
const GRAVITY: f64 = 9.81;
const GEL: Material = Material { young: 2e4, poisson: 0.3, density: 1000.0 };
/// When the plates have closed, when they begin to lift, when they have lifted, and the end (s).
const CLOSED: f64 = 0.2;
const LIFTS: f64 = 0.3;
const LIFTED: f64 = 0.7;
const END: f64 = 1.0;
/// Where splats lie, in radii: inside of the ball of tetrahedra, whose faces are flat.
const COVERED: f64 = 0.95;
/// Points that carry more than this part of what the most loaded one of their finger does are within the zone that sticks.
const CARRIES: f64 = 0.5;
/// Between frames of the film (s).
const FRAME: f64 = 0.04;

struct Grip {
    world: World,
    mesh: TetMesh,
    ball: Range<u32>,
    hand: Hand,
}

impl GrippedSplats {
    fn grip(&self, stick_velocity: f64) -> Result<Grip, ExperimentError> {
        let gap = self.activation_distance_m.value();
        let mesh = ball(RADIUS, self.cells.value() as u32).map_err(ExperimentError::stopped)?;
        let mut builder = WorldBuilder::of_law(SolidLaw::Barrier);
        builder = builder.with_friction(friction(self.coefficient.value(), stick_velocity)?);
        let ball = builder.add_solid(&mesh, GEL, Vec3::zeros())?;
        let farthest = |way: Vec3| mesh.points().iter().map(|x| x.dot(&way)).fold(0.0_f64, f64::max);
        let (right, down) = (farthest(Vec3::x()), farthest(-Vec3::z()));
        let inner = right.max(farthest(-Vec3::x())) + gap;
        let (low, high) = (Vec3::new(inner, -0.02, -0.02), Vec3::new(inner + 0.006, 0.02, 0.02));
        let pedestal = [Vec3::new(-0.012, -0.012, -down - 0.02), Vec3::new(0.012, 0.012, -down - gap)];
        let hand = Hand::add(&mut builder, [low, high], pedestal)?;
        // About what a point carries of the force of Hertz, of some twenty that touch.
        let depth = self.squeeze_m.value();
        let force =
            4.0 / 3.0 * GEL.young / (1.0 - GEL.poisson * GEL.poisson) * RADIUS.sqrt() * depth.powf(1.5);
        let contact = ContactOptions::new(gap, Stiffness::fixed(Scale::Load(force / 20.0)));
        let newton = NewtonOptions { tolerance: 1e-6, max_iterations: 300, ..NewtonOptions::default() };
        let options = StepperOptions { newton, lagging: Lagging::AtMost(10), ..StepperOptions::default() };
        let world = builder.build(Vec3::z() * -GRAVITY, contact, options)?;
        Ok(Grip { world, mesh, ball, hand })
    }

    fn grasp(&self) -> Grasp {
        Grasp { squeeze: self.squeeze_m.value(), closed: CLOSED, lift: LIFT, lifting: [LIFTS, LIFTED] }
    }
}

impl Grip {
    fn step(&mut self, gripper: &GrippedSplats, clock: &mut Clock) -> Result<(), ExperimentError> {
        let (t, h, grasp) = (self.world.state.time, gripper.step_s.value(), gripper.grasp());
        self.hand.push(&mut self.world, grasp.way(t + h) - grasp.way(t))?;
        self.world.step(h, clock)?;
        Ok(())
    }

    fn body(&self) -> &[Vec3] {
        &self.world.state.position[self.ball.start as usize..self.ball.end as usize]
    }

    /// Points of the ball that are well within the contact with a finger, and where they are on it: what they do not have in common with the plate, across its normal.
    fn touching(&self, way: Vec3) -> Vec<(usize, Vec3)> {
        let forces = self.world.contact.forces(&self.world.state.position);
        let push = |i: usize| forces[self.ball.start as usize + i].x;
        let body = self.body();
        let most = |side: f64| {
            let of_side = (0..body.len()).filter(|&i| body[i].x * side > 0.0);
            of_side.map(|i| -push(i) * side).fold(0.0_f64, f64::max)
        };
        let loads = [most(-1.0), most(1.0)];
        let touches = |&i: &usize| {
            let (side, load) = if body[i].x < 0.0 { (-1.0, loads[0]) } else { (1.0, loads[1]) };
            // What only a plate can push with, far from the pedestal.
            -push(i) * side > CARRIES * load && body[i].x.abs() > 0.5 * RADIUS
        };
        let on_plate = |i: usize| Vec3::new(0.0, body[i].y, body[i].z - way.z);
        (0..body.len()).filter(touches).map(|i| (i, on_plate(i))).collect()
    }

    fn volume(&self) -> f64 {
        let x = self.body();
        self.mesh.cells().iter().map(|cell| tet_volume(&cell.map(|v| x[v as usize]))).sum()
    }

    fn height(&self) -> f64 {
        mass_mean(&self.world, self.ball.clone(), &self.world.state.position).z
    }
}

/// The splats of the ball and what moves them, and those of the plates.
///
/// Gradients are the smooth ones: those that are constant in a tetrahedron jump on its faces, and on which side a splat is there is a matter of rounding.
struct Skin {
    binding: TetBinding,
    transport: Transport<f32>,
    moved: Moved,
    /// Of each splat its tetrahedron and its weights, by trying all.
    places: Vec<(usize, [f64; 4])>,
    outside: usize,
    plates: [Splats<f32>; 3],
    means: f64,
    covariances: f64,
}

impl Skin {
    fn new(grip: &Grip, spacing: f64) -> Result<Self, ExperimentError> {
        let surface = sphere(COVERED * RADIUS, 24).map_err(ExperimentError::stopped)?;
        let how = Cover { spacing, up: Vec3::z(), ..Cover::default() };
        let splats: Splats<f32> = cover(&surface, &how).cast();
        let list: Vec<u32> = (0..splats.count() as u32).collect();
        let means = select::means(&splats, &list);
        let (places, outside) = places(&grip.mesh, &means);
        let binding = TetBinding::new(&grip.mesh, &means, TetGradients::Smooth);
        let transport = Transport::new(splats, list, Colours::RotateCoefficients);
        Ok(Self {
            binding: binding.map_err(ExperimentError::stopped)?,
            transport: transport.map_err(ExperimentError::stopped)?,
            moved: Moved::new(),
            places,
            outside,
            plates: grip.hand.surfaces.each_ref().map(|mesh| cover(mesh, &how).cast()),
            means: 0.0,
            covariances: 0.0,
        })
    }

    /// Moves the splats with the vertices at `x`, and compares.
    fn carry(&mut self, mesh: &TetMesh, x: &[Vec3], clock: &mut Clock) -> Result<(), ExperimentError> {
        let Self { binding, transport, moved, .. } = self;
        clock
            .time(|| {
                binding.move_into(x, moved)?;
                transport.deform(moved.samples())
            })
            .map_err(ExperimentError::stopped)?;
        let (rest, frame) = (self.transport.rest(), self.transport.frame());
        let around = averaged(mesh, &gradients(mesh, x));
        for (i, (cell, weights)) in self.places.iter().enumerate() {
            let corners = mesh.cells()[*cell].map(|v| v as usize);
            let mean: Vec3 = (0..4).map(|k| x[corners[k]] * weights[k]).sum();
            let f: Mat3 = (0..4).map(|k| around[corners[k]] * weights[k]).sum();
            let off = (frame.means()[i].cast::<f64>() - mean).norm() / (2.0 * RADIUS);
            self.means = self.means.max(off);
            let expected = f * full(rest.covariance(i)) * f.transpose();
            let off = (full(frame.covariance(i)) - expected).norm() / expected.norm();
            self.covariances = self.covariances.max(off);
        }
        Ok(())
    }

    /// All splats, with the plates where they are.
    fn all(&self, way: Vec3) -> Splats<f32> {
        let mut all = self.transport.frame().clone();
        let ways = [mirrored(way), way, Vec3::zeros()];
        for (plate, way) in self.plates.iter().zip(ways) {
            let first = all.count();
            (0..plate.count()).for_each(|i| all.push(plate.splat(i)));
            all.means_mut()[first..].iter_mut().for_each(|mean| *mean += way.cast::<f32>());
        }
        all
    }
}

/// F of each tetrahedron: its edges by those at rest.
fn gradients(mesh: &TetMesh, x: &[Vec3]) -> Vec<Mat3> {
    let edges = |points: &[Vec3], cell: &[u32; 4]| {
        let [a, b, c, d] = cell.map(|v| points[v as usize]);
        Mat3::from_columns(&[b - a, c - a, d - a])
    };
    let inverse = |cell| edges(mesh.points(), cell).try_inverse().unwrap_or_else(Mat3::zeros);
    mesh.cells().iter().map(|cell| edges(x, cell) * inverse(cell)).collect()
}

/// Averages over the tetrahedra around each vertex, by their volumes at rest.
fn averaged(mesh: &TetMesh, gradients: &[Mat3]) -> Vec<Mat3> {
    let mut sums = vec![(Mat3::zeros(), 0.0); mesh.points().len()];
    for (number, cell) in mesh.cells().iter().enumerate() {
        let volume = tet_volume(&mesh.corners(number));
        for v in cell {
            let (sum, weight) = &mut sums[*v as usize];
            *sum += gradients[number] * volume;
            *weight += volume;
        }
    }
    sums.into_iter().map(|(sum, weight)| sum / weight).collect()
}

/// The whole of a symmetric matrix of its upper triangle.
fn full(upper: [f32; 6]) -> Mat3 {
    let [xx, xy, xz, yy, yz, zz] = upper.map(f64::from);
    Mat3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
}

impl Experiment for GrippedSplats {
    fn methods(&self) -> &'static [&'static str] {
        &["backward-euler"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let (h, stick_velocity) = (self.step_s.value(), at.ladder);
        let (mut grip, grasp) = (self.grip(stick_velocity)?, self.grasp());
        let mut skin = Skin::new(&grip, self.spacing_m.value())?;
        let mut film = Film::new(FRAME);
        let every = ((FRAME / h).round() as u64).max(1);
        let (start, volume) = (grip.height(), grip.volume());
        let (mut before, mut volumes) = (Vec::new(), [1.0_f64; 2]);
        for step in 1..=(END / h).round() as u64 {
            grip.step(self, clock)?;
            let (time, way) = (step as f64 * h, grasp.way(step as f64 * h));
            skin.carry(&grip.mesh, grip.body(), clock)?;
            let ratio = grip.volume() / volume;
            volumes = [volumes[0].min(ratio), volumes[1].max(ratio)];
            if before.is_empty() && time > LIFTS - 0.5 * h {
                before = grip.touching(way);
            }
            if at.frames.is_some() && step % every == 0 {
                film.push(picture(&skin.all(way), time)?).map_err(ExperimentError::stopped)?;
            }
        }
        let end = grip.touching(grasp.way(END));
        let stayed = before
            .iter()
            .filter_map(|(i, from)| end.iter().find(|(j, _)| i == j).map(|(_, to)| (to - from).norm()));
        let slips: Vec<f64> = stayed.collect();
        let slip = if slips.is_empty() { f64::NAN } else { slips.iter().copied().fold(0.0_f64, f64::max) };
        let outcome = grip
            .world
            .outcome()
            .error("slip", slip)
            .error("slip by εᵥ t", slip / (stick_velocity * (END - LIFTS)))
            .error("splats off their tetrahedra", skin.means)
            .error("covariances, smooth gradients", skin.covariances)
            .error("left behind", LIFT - (grip.height() - start))
            .count("splats", skin.places.len() as u64)
            .count("points that stick", slips.len() as u64)
            .invariant("splats outside", skin.outside as f64)
            .invariant("smallest volume by that at rest", volumes[0])
            .invariant("largest volume by that at rest", volumes[1]);
        outcome.filmed_to_the_end(at, &at.title(), &film)
    }
}

fn picture(splats: &Splats<f32>, time: f64) -> Result<crate::picture::Image, ExperimentError> {
    let orbit = Orbit {
        target: Vec3::new(0.0, 0.0, 0.012),
        distance: 0.24,
        azimuth: -1.3,
        elevation: 0.2,
        up: Vec3::z(),
        field_of_view: 0.6,
    };
    let camera = Camera::on_orbit([400, 400], &orbit).map_err(ExperimentError::stopped)?;
    draw_splats(splats, &camera, &format!("t = {time:.2} s")).map_err(ExperimentError::stopped)
}
