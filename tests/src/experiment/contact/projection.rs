//! What becomes of negative eigenvalues: iterations and time of a press.

use super::portrait::pictured;
use super::world::{Material, World, WorldBuilder};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{Count, Positive};
use ipc_contact::collision_mesh::{CollisionObject, HalfSpace};
use ipc_contact::contact::ContactOptions;
use ipc_contact::pair::Curvature;
use ipc_contact::stiffness::{Scale, Stiffness};
use lagrangian::stepper::StepperOptions;
use mechanics_core::mesh::{BoxSplit, block};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::objective::Projecting;
use mechanics_core::projection::Projection;
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;
use std::ops::Range;

/// Two soft cubes, one turned on top of the other, are pressed on the floor by a plate; the ladder is Newton's tolerance (m/s). Positions
/// at the end against those of the first method with a tolerance of 1e-9 m/s.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct PressedStack {
    /// Cells along a side.
    cells: Count,
    /// The step (s).
    step_s: Positive,
    /// Steps.
    steps: Count,
    /// How fast the plate comes down (m/s).
    speed_m_s: Positive,
    /// The distance at which contact begins (m).
    activation_distance_m: Positive,
    /// What a pair carries at half of it (N).
    load_n: Positive,
}

const METHODS: &[&str] = &[
    "clamp-on-demand",
    "clamp-always",
    "absolute-on-demand",
    "absolute-always",
    "gauss-newton-on-demand",
    "gauss-newton-always",
];

const SIDE: f64 = 0.1;

/// The world and the points of its plate.
struct Press {
    world: World,
    plate: Range<u32>,
    corners: [Vec3; 4],
}

impl PressedStack {
    fn press(&self, method: &str, tolerance: f64) -> Result<Press, ExperimentError> {
        let (n, activation) = (self.cells.value() as u32, self.activation_distance_m.value());
        let gap = 1.01 * activation;
        let low = Vec3::new(-0.5 * SIDE, -0.5 * SIDE, gap);
        let lower =
            block(&low, &low.add_scalar(SIDE), [n; 3], BoxSplit::Six).map_err(ExperimentError::stopped)?;
        let mut upper = lower.clone();
        let (sin, cos) = 0.5_f64.sin_cos();
        let lift = SIDE + gap;
        upper
            .map_points(|x| Vec3::new(cos * x.x - sin * x.y, sin * x.x + cos * x.y, x.z + lift))
            .map_err(ExperimentError::stopped)?;
        let material = Material { young: 1e5, poisson: 0.4, density: 1000.0 };
        let mut builder = WorldBuilder::default();
        builder.add_solid(&lower, material, Vec3::zeros())?;
        builder.add_solid(&upper, material, Vec3::zeros())?;
        let corners = [[-0.2, -0.2], [0.2, -0.2], [0.2, 0.2], [-0.2, 0.2]]
            .map(|[x, y]| Vec3::new(x, y, 2.0 * lift + gap));
        let plate = builder.add_obstacle(&corners, |first| {
            CollisionObject::new(vec![[first, first + 2, first + 1], [first, first + 3, first + 2]])
        });
        builder.add_half_space(HalfSpace { normal: Vec3::z(), offset: 0.0 });
        let curvature = if method.starts_with("gauss") { Curvature::GaussNewton } else { Curvature::Full };
        let stiffness = Stiffness::fixed(Scale::Load(self.load_n.value()));
        let contact = ContactOptions { curvature, ..ContactOptions::new(activation, stiffness) };
        let newton = NewtonOptions { tolerance, max_iterations: 1000, ..NewtonOptions::default() };
        let projection =
            if method.starts_with("absolute") { Projection::Absolute } else { Projection::Clamp };
        let projecting = if method.ends_with("always") { Projecting::Always } else { Projecting::OnDemand };
        let options = StepperOptions { newton, projection, projecting, ..StepperOptions::default() };
        let world = builder.build(Vec3::zeros(), contact, options)?;
        Ok(Press { world, plate, corners })
    }

    fn run_press(&self, press: &mut Press, clock: &mut Clock) -> Result<(), ExperimentError> {
        let h = self.step_s.value();
        for step in 1..=self.steps.value() {
            let down = Vec3::z() * (self.speed_m_s.value() * h * step as f64);
            for (point, corner) in press.plate.clone().zip(&press.corners) {
                press.world.move_to(point, corner - down)?;
            }
            let report = press.world.step(h, clock)?;
            let times = &report.newton.times;
            clock.add_term("assembly", times.assembly);
            clock.add_term("linear solve", times.solve);
            clock.add_term("detection", times.limit_step);
        }
        Ok(())
    }
}

impl Experiment for PressedStack {
    fn methods(&self) -> &'static [&'static str] {
        METHODS
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let mut reference = self.press(METHODS[0], 1e-9)?;
        self.run_press(&mut reference, &mut Clock::default())?;
        let mut press = self.press(at.method, at.ladder)?;
        self.run_press(&mut press, clock)?;
        let (x, exact) = (&press.world.state.position, &reference.world.state.position);
        let worst = x.iter().zip(exact).map(|(x, exact)| (x - exact).norm()).fold(0.0, f64::max);
        let outcome = press.world.outcome().error("position", worst / SIDE);
        let displacements =
            x.iter().zip(press.world.contact.mesh().rest()).map(|(x, rest)| (x - rest).norm()).collect();
        let bodies: Vec<[u32; 3]> = press
            .world
            .contact
            .mesh()
            .triangles()
            .iter()
            .filter(|t| !press.plate.contains(&t[0]))
            .copied()
            .collect();
        pictured(outcome, at, x, &bodies, ("displacement", "m", displacements))
    }
}
