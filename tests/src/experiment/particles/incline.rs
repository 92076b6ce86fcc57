//! A block on an incline, sliding or held by friction.

use super::cloud::Cloud;
use super::method::{Method, Precision};
use super::portrait::{Portrait, pictured};
use super::solver::{Elasticity, Matter, Solver, Watch};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Positive;
use mpm_core::{Boundary, Kernel, Samples, Shape, Surface, Transfer};
use schemars::JsonSchema;
use serde::Deserialize;

/// A block of 1 m × 0.5 m for one second on an incline, seen in the frame of the incline; the ladder is Δx (m).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct BlockOnIncline {
    young_modulus_pa: Positive,
    /// h for Δx = 0.125 m; it goes with Δx.
    step_s: Positive,
}

const GRAVITY: f64 = 9.81;
const SIZE: [f64; 2] = [1.0, 0.5];
const DENSITY: f64 = 1000.0;
/// What slides starts with this speed, because a block that is loaded at once sticks here and there in its own vibrations.
const SPEED: f64 = 1.0;
/// How long a block that is to stick lies on the level floor, and how long the floor is then tilted \[s\]. A block that vibrates is light
/// now and then, and creeps: after a rest of 0.5 s by 0.2 m in a second on the finest grid, which damps least, 4 % below the limit.
const REST: f64 = 3.0;
const TILTING: f64 = 1.0;

/// An incline.
#[derive(Clone, Copy, Debug)]
struct Case {
    degrees: f64,
    surface: Surface,
    transfer: Transfer,
}

impl Case {
    fn named(name: &str) -> Self {
        let (degrees, coefficient) = match name {
            "30°, smooth" => (30.0, 0.0),
            "30°, μ = 0.2" => (30.0, 0.2),
            "30°, μ = 0.4" => (30.0, 0.4),
            "45°, μ = 0.5" => (45.0, 0.5),
            // The others of the list.
            _ => (30.0, 0.6),
        };
        let surface = if coefficient == 0.0 { Surface::Slip } else { Surface::Friction(coefficient) };
        let transfer = if name.ends_with("FLIP") { Transfer::FLIP } else { Transfer::MlsApic };
        Self { degrees, surface, transfer }
    }

    fn coefficient(&self) -> f64 {
        if let Surface::Friction(coefficient) = self.surface { coefficient } else { 0.0 }
    }

    fn sticks(&self) -> bool {
        self.coefficient() > self.degrees.to_radians().tan()
    }

    /// g (sin θ − μ cos θ), or 0.
    fn acceleration(&self) -> f64 {
        let (sine, cosine) = self.degrees.to_radians().sin_cos();
        (GRAVITY * (sine - self.coefficient() * cosine)).max(0.0)
    }
}

impl Experiment for BlockOnIncline {
    fn methods(&self) -> &'static [&'static str] {
        &["30°, smooth", "30°, μ = 0.2", "30°, μ = 0.4", "45°, μ = 0.5", "30°, μ = 0.6", "30°, μ = 0.6, FLIP"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let case = Case::named(at.method);
        let (spacing, step) = (at.ladder, self.step_s.value() * at.ladder / 0.125);
        let method = Method {
            kernel: Kernel::Quadratic,
            transfer: case.transfer,
            precision: Precision::Double,
            along: 2,
        };
        let matter = Matter::new(Elasticity::FixedCorotated, (self.young_modulus_pa.value(), 0.3), DENSITY)?;
        let counts = SIZE.map(|side| (2.0 * side / spacing).round() as usize);
        let cloud = Cloud::cuboid([0.0; 2], SIZE, counts);
        let mut solver = Solver::new(method, spacing)?;
        let floor = Shape::HalfSpace { point: [0.0; 2], normal: [0.0, 1.0] };
        solver.add_boundary(Boundary::at_rest(floor, case.surface))?;
        let speed = if case.sticks() { 0.0 } else { SPEED };
        let velocities = vec![[speed, 0.0]; cloud.points.len()];
        solver.add_body(
            &matter,
            Samples { positions: &cloud.points, velocities: &velocities, volumes: &cloud.volumes },
        )?;
        let mut watch = Watch::start(&solver);
        let angle = case.degrees.to_radians();
        if case.sticks() {
            for k in 0..((REST + TILTING) / step).round() as usize {
                let time = k as f64 * step;
                let tilt = angle * ((time - REST) / TILTING).clamp(0.0, 1.0);
                let load = GRAVITY * (time / (0.6 * REST)).min(1.0);
                solver.set_gravity([load * tilt.sin(), -load * tilt.cos()])?;
                clock.time(|| solver.step(step)).map_err(ExperimentError::stopped)?;
            }
        }
        solver.set_gravity([GRAVITY * angle.sin(), -GRAVITY * angle.cos()])?;
        let start = middle(&solver);
        let steps = (1.0 / step).round() as usize;
        for k in 0..steps {
            clock.time(|| solver.step(step)).map_err(ExperimentError::stopped)?;
            if k % 16 == 0 {
                watch.look(&mut solver, step);
            }
        }
        let end = middle(&solver);
        let (along, across) = (end[0] - start[0], end[1] - start[1]);
        // Symplectic Euler goes ½ a t (t + h).
        let exact = speed + 0.5 * case.acceleration() * (1.0 + step);
        // The floor's normal impulses are those of the weight and of what has moved the block across; friction is μ times both.
        let coulomb = if case.sticks() { 0.0 } else { along - exact + case.coefficient() * across };
        let unit = 0.5 * GRAVITY * angle.sin();
        let outcome = solver.counted(
            Outcome::default()
                .error("way", (along - exact).abs() / unit)
                .error("friction less μ times the normal impulse", coulomb.abs() / unit),
        );
        let outcome = watch.held(outcome);
        pictured(outcome, at, "after a second; the rectangle is where the block should be", || {
            let left = start[0] + exact - 0.5 * SIZE[0];
            let [right, top] = [left + SIZE[0], SIZE[1]];
            Portrait {
                positions: solver.positions(0),
                values: solver.states(0).iter().map(|state| 1e-3 * state.kirchhoff[(0, 1)]).collect(),
                radius: 0.2 * spacing,
                field: ("shear stress", "kPa"),
                lines: vec![
                    vec![[left - 0.4, 0.0], [right + 0.4, 0.0]],
                    vec![[left, 0.0], [left, top], [right, top], [right, 0.0]],
                ],
                label: format!("{}, way {along:.4} m, exact {exact:.4} m", at.method),
                ..Portrait::default()
            }
        })
    }
}

/// The mean position; all particles have the same mass.
fn middle(solver: &Solver<2>) -> [f64; 2] {
    let positions = solver.positions(0);
    std::array::from_fn(|a| positions.iter().map(|x| x[a]).sum::<f64>() / positions.len() as f64)
}
