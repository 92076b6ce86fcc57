//! A soft bar that is pulled through a funnel.

use super::shots::Shots;
use super::{Body, add_body, contact, friction};
use crate::experiment::contact::hard::shapes::drawn_out;
use crate::experiment::contact::world::{Material, SolidLaw, World, WorldBuilder};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Positive;
use ipc_contact::collision_mesh::{CollisionObject, SelfContact};
use lagrangian::stepper::{Lagging, StepperOptions};
use mechanics_core::mesh::{BoxSplit, block};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;
use std::ops::Range;

/// A bar 100 × 20 × 40 mm (E = 50 kPa, ν = 0, 1000 kg/m³) whose front is held over the middle half of its height and pulled with constant speed between two
/// plates that come closer, stay so, and part again. No gravity. The ladder is the edge of the bar's cells (m). What is held has a height of its own, because
/// a line of points would be drawn out of the bar the further the finer the cells are.
///
/// # Closed form
/// The bar as a line of cross-sections that stay plane. At X from the free end it is at x(X), stretched by λ along and squeezed to
/// λ₂ = min(1, g/H) by the gap g(x) less what contact keeps free. The law's ψ = ½G (Σ λᵢ² − 3) − G ln J (ν = 0, G = E/2) has the nominal stresses
/// G (λᵢ − 1/λᵢ). Of a length dX a plate with the slope α pushes with N, so that N cos α − μ N sin α = q = G (1/λ₂ − λ₂) W across, and holds back
/// with N sin α + μ N cos α = q tan(α + φ), φ = arctan μ. So
///
/// dF/dX = 2 q tan(α + φ),  F = G (λ − 1/λ) W H,  dx/dX = λ,  F(0) = 0,  x(L) = the front,
///
/// the mean of the front's cross-section, which does not stay plane in the bar that is simulated: plates hold back its edges, the pull draws out its middle.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Funnel {
    /// tan α.
    slope: Positive,
    /// The gap of the narrow part, in parts of the bar's height; below one.
    throat: Positive,
    /// μ of `with-friction`.
    friction_coefficient: Positive,
    /// Of the pull (m/s).
    speed_m_s: Positive,
    /// h (s).
    step_s: Positive,
}

const LENGTH: f64 = 0.1;
const WIDTH: f64 = 0.02;
const HEIGHT: f64 = 0.04;
/// Of the narrow part (m).
const THROAT: f64 = 0.05;
const FOAM: Material = Material { young: 5e4, poisson: 0.0, density: 1000.0 };
const ACTIVATION: f64 = 2e-4;
const STICK_VELOCITY: f64 = 1e-3;
/// Parts of the bar in the closed form.
const SLICES: usize = 2000;

/// The upper plate; the lower one mirrors it. It comes down along the slope from x = 0 on.
#[derive(Clone, Copy)]
struct Plate {
    /// tan α.
    slope: f64,
    /// Half of the gap before and in the narrow part (m).
    open: f64,
    narrow: f64,
}

impl Plate {
    /// Where the slope ends.
    fn neck(&self) -> f64 {
        (self.open - self.narrow) / self.slope
    }

    /// Where the narrow part ends.
    fn exit(&self) -> f64 {
        self.neck() + THROAT
    }

    fn profile(&self, side: f64) -> Vec<[f64; 2]> {
        let line = [
            [-1.2 * LENGTH, self.open],
            [0.0, self.open],
            [self.neck(), self.narrow],
            [self.exit(), self.narrow],
            [self.exit() + HEIGHT, self.narrow + HEIGHT],
        ];
        line.map(|[x, z]| [x, side * z]).to_vec()
    }

    /// Half of the gap at `x`, and tan α there, up to the exit.
    fn at(&self, x: f64) -> [f64; 2] {
        let is_sloped = x > 0.0 && x < self.neck();
        [(self.open - self.slope * x).clamp(self.narrow, self.open), if is_sloped { self.slope } else { 0.0 }]
    }

    /// Where the front is, and the force there (N), if the free end is at `x`.
    fn pulled_from(&self, mut x: f64, friction_coefficient: f64) -> [f64; 2] {
        let shear = 0.5 * FOAM.young;
        let (part, mut force) = (LENGTH / SLICES as f64, 0.0);
        for _ in 0..SLICES {
            let [gap, slope] = self.at(x);
            let squeezed = ((gap - 0.5 * ACTIVATION) / (0.5 * HEIGHT)).min(1.0);
            let across = shear * (1.0 / squeezed - squeezed) * WIDTH;
            let tangent = (slope + friction_coefficient) / (1.0 - slope * friction_coefficient);
            let stress = force / (shear * WIDTH * HEIGHT);
            x += 0.5 * (stress + stress.hypot(2.0)) * part;
            force += 2.0 * across * tangent * part;
        }
        [x, force]
    }

    /// The closed form's force when the front is at `front` (N).
    fn force(&self, front: f64, friction_coefficient: f64) -> f64 {
        let (mut low, mut high) = (front - 3.0 * LENGTH, front);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            let [reached, _] = self.pulled_from(middle, friction_coefficient);
            *if reached < front { &mut low } else { &mut high } = middle;
        }
        self.pulled_from(low, friction_coefficient)[1]
    }
}

struct Rig {
    world: World,
    bar: Body,
    /// The points that are pulled.
    grip: Vec<u32>,
    /// The points of the front's cross-section, and the part of it that each stands for.
    front: Vec<(u32, f64)>,
    skins: Vec<Vec<[u32; 3]>>,
}

/// The points of the bar's front, each with its part of the area: all the same inside, half on an edge, a quarter in a corner.
fn cross_section(rest: &[Vec3], points: Range<u32>, tolerance: f64) -> Vec<(u32, f64)> {
    let half = |at: f64, size: f64| if at.abs() > 0.5 * size - tolerance { 0.5 } else { 1.0 };
    let weight = |p: &Vec3| half(p.y, WIDTH) * half(p.z, HEIGHT);
    let front: Vec<u32> = points.filter(|&p| rest[p as usize].x > -tolerance).collect();
    let sum: f64 = front.iter().map(|&p| weight(&rest[p as usize])).sum();
    front.into_iter().map(|p| (p, weight(&rest[p as usize]) / sum)).collect()
}

impl Funnel {
    fn plate(&self) -> Plate {
        let narrow = 0.5 * self.throat.value() * HEIGHT;
        Plate { slope: self.slope.value(), open: 0.5 * HEIGHT + 2.0 * ACTIVATION, narrow }
    }

    fn rig(&self, cell: f64, friction_coefficient: f64) -> Result<Rig, ExperimentError> {
        let cells = [LENGTH, WIDTH, HEIGHT].map(|edge| (edge / cell).round() as u32);
        let (low, high) =
            (Vec3::new(-LENGTH, -0.5 * WIDTH, -0.5 * HEIGHT), Vec3::new(0.0, 0.5 * WIDTH, 0.5 * HEIGHT));
        let mesh = block(&low, &high, cells, BoxSplit::Five).map_err(ExperimentError::stopped)?;
        let options = friction(friction_coefficient, STICK_VELOCITY)?;
        let mut builder = WorldBuilder::of_law(SolidLaw::Barrier).with_friction(options);
        let bar = add_body(&mut builder, &mesh, FOAM)?;
        let front = cross_section(builder.rest(), bar.points.clone(), 0.1 * cell);
        let is_held = |p: u32| builder.rest()[p as usize].z.abs() < 0.25 * HEIGHT + 0.1 * cell;
        let grip: Vec<u32> = front.iter().map(|&(p, _)| p).filter(|&p| is_held(p)).collect();
        builder.script(grip.iter().copied());
        let mut skins = vec![bar.skin.clone()];
        for side in [-1.0, 1.0] {
            let plate = drawn_out(&self.plate().profile(side), WIDTH, 2).map_err(ExperimentError::stopped)?;
            let points = builder.add_obstacle(plate.points(), |first| {
                CollisionObject::of_mesh(&plate, first).with_self_contact(SelfContact::Excluded)
            });
            skins.push(plate.triangles().iter().map(|t| t.map(|p| p + points.start)).collect());
        }
        let newton = NewtonOptions { tolerance: 1e-6, max_iterations: 1000, ..NewtonOptions::default() };
        let stepping = StepperOptions { newton, lagging: Lagging::Until(100), ..StepperOptions::default() };
        let load = FOAM.young * (1.0 - self.throat.value()) * cell * cell;
        let mut world = builder.build(Vec3::zeros(), contact(ACTIVATION, load), stepping)?;
        for point in bar.points.clone() {
            world.state.velocity[point as usize] = Vec3::x() * self.speed_m_s.value();
        }
        Ok(Rig { world, bar, grip, front, skins })
    }
}

/// The way (m), the work of the pull and of its closed form (J) while the front is in the narrow part, and the largest force (N).
#[derive(Default)]
struct Pull {
    way: f64,
    work: f64,
    expected: f64,
    largest: f64,
}

impl Experiment for Funnel {
    fn methods(&self) -> &'static [&'static str] {
        &["with-friction", "without-friction"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let mu = if at.method == "with-friction" { self.friction_coefficient.value() } else { 0.0 };
        let Rig { mut world, bar, grip, front, skins } = self.rig(at.ladder, mu)?;
        let (plate, h) = (self.plate(), self.step_s.value());
        let way = self.speed_m_s.value() * h;
        let start = world.state.position.clone();
        let mut shots = Shots::new(at, [0.25, -1.0, 0.3], skins.iter().map(|skin| &skin[..]));
        let mut pull = Pull::default();
        let steps = ((plate.exit() + 1.5 * LENGTH) / way).ceil() as usize;
        for step in 1..=steps {
            for &point in &grip {
                world.move_to(point, start[point as usize] + Vec3::x() * (way * step as f64))?;
            }
            let before = world.energy.work;
            world.step(h, clock)?;
            let done = world.energy.work - before;
            let front: f64 = front.iter().map(|&(p, part)| part * world.state.position[p as usize].x).sum();
            pull.largest = pull.largest.max(done / way);
            if front > plate.neck() && front < plate.exit() {
                pull.way += way;
                pull.work += done;
                pull.expected += plate.force(front, mu) * way;
            }
            if step % steps.div_ceil(3) == 0 || step == steps {
                let x = &world.state.position;
                let along = |p: usize| {
                    if bar.points.contains(&(p as u32)) { x[p].x - start[p].x - front } else { 0.0 }
                };
                shots.take(x, ("ahead of the front", "m", along), &format!("front at {front:.3} m"))?;
            }
        }
        let x = &world.state.position;
        let rear = bar.points.clone().map(|p| x[p as usize].x).fold(f64::INFINITY, f64::min);
        let (other, contact) = world.potential_energy();
        let outcome = world
            .outcome()
            .error("force", (pull.work / pull.expected - 1.0).abs())
            .invariant("mean force (N)", pull.work / pull.way)
            .invariant("mean force of the closed form (N)", pull.expected / pull.way)
            .invariant("largest force (N)", pull.largest)
            .invariant("work (J)", world.energy.work)
            .invariant("heat (J)", world.energy.heat)
            .invariant("elastic energy at the end (J)", other + contact)
            .invariant("rear behind the exit (m)", rear - plate.exit());
        Ok(shots.add_to(outcome))
    }
}
