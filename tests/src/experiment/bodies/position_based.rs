//! Position-based dynamics against implicit Euler: what iterations do to the answer.
//!
//! Springs of stiffness k hang from held points and are let go. XPBD with the compliance 1/k solves implicit Euler's equations
//! in the limit of many iterations where gradients do not turn; classic position-based dynamics gets the stiffness
//! s = 2w/(2w + 1/kh²) that makes one iteration on one free spring exact, and more iterations make it stiffer.
//!
//! Reference: M. Müller et al., *Position based dynamics*, 2007; M. Macklin, M. Müller, N. Chentanez, *XPBD*, 2016.

use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{Count, Positive};
use lagrangian::element::{DeadLoad, Mass, Springs};
use lagrangian::position_based::{ConstraintGroup, Distances, Particles, PositionBased, Response};
use lagrangian::stepper::{Stepper, StepperOptions};
use mechanics_core::mesh::{Diagonals, Surface, sheet};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::point_map::PointMap;
use mechanics_core::state::{State, StateHash};
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

/// What hangs.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum Hanging {
    /// A straight chain, held at its top: gradients do not turn.
    Chain,
    /// A square net, held at two corners.
    Net,
}

/// Springs let go, by position-based dynamics; the ladder is the number of iterations a step.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct PositionBasedSteps {
    /// What hangs.
    hanging: Hanging,
    /// Springs along an edge of it.
    springs: Count,
    /// k [N/m].
    stiffness_n_m: Positive,
    /// Mass of a point [kg].
    mass_kg: Positive,
    /// h [s].
    step_s: Positive,
    /// Steps made.
    steps: Count,
}

impl Experiment for PositionBasedSteps {
    fn methods(&self) -> &'static [&'static str] {
        &["xpbd", "pbd"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let (points, edges, held) = self.shape()?;
        let (h, m) = (self.step_s.value(), self.mass_kg.value());
        let softness = 1.0 / (self.stiffness_n_m.value() * h * h);
        let response = if at.method == "pbd" {
            Response::Classic { stiffness: 2.0 / m / (2.0 / m + softness) }
        } else {
            Response::Compliant { compliance: vec![1.0 / self.stiffness_n_m.value(); edges.len()] }
        };
        let distances = Distances::new(&points, &edges).map_err(ExperimentError::stopped)?;
        let mut group = ConstraintGroup::new("springs", distances, edges.clone(), response)
            .map_err(ExperimentError::stopped)?;
        let weight = |i: u32| if held.contains(&i) { 0.0 } else { 1.0 / m };
        let weights = (0..points.len() as u32).map(weight).collect();
        let mut particles = Particles::new(points.clone(), weights).map_err(ExperimentError::stopped)?;
        let method = PositionBased { iterations: at.ladder.round() as u32, acceleration: GRAVITY };
        let mut projections = 0;
        clock
            .time(|| {
                (0..self.steps.value()).try_for_each(|_| {
                    let report = method.step(&mut particles, &mut [&mut group], h)?;
                    projections += report.projections;
                    Ok::<(), lagrangian::position_based::PositionError>(())
                })
            })
            .map_err(ExperimentError::stopped)?;

        let exact = self.implicit_euler(&points, &edges, &held)?;
        let moved = points.iter().zip(&exact).map(|(a, b)| (b - a).norm()).fold(0.0, f64::max);
        let pairs = particles.positions.iter().zip(&exact);
        let error = pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        let mut hash = StateHash::new();
        hash.add_vectors("position", &particles.positions);
        let mut outcome = Outcome::default()
            .error("position", error / moved)
            .count("projections", projections)
            .state(hash.value());
        outcome.simulated_seconds = Some(h * self.steps.value() as f64);
        Ok(outcome)
    }
}

const GRAVITY: Vec3 = Vec3::new(0.0, 0.0, -9.81);

/// Points, springs, and held points.
type Shape = (Vec<Vec3>, Vec<[u32; 2]>, Vec<u32>);

impl PositionBasedSteps {
    fn shape(&self) -> Result<Shape, ExperimentError> {
        let n = self.springs.value() as u32;
        match self.hanging {
            Hanging::Chain => {
                let points = (0..=n).map(|i| Vec3::z() * (-f64::from(i) / f64::from(n))).collect();
                Ok((points, (0..n).map(|i| [i, i + 1]).collect(), vec![0]))
            }
            Hanging::Net => {
                let mesh =
                    sheet([1.0, 1.0], [n, n], Diagonals::Alternating).map_err(ExperimentError::stopped)?;
                let surface = Surface::of_triangles(&mesh);
                Ok((mesh.points().to_vec(), surface.edges().to_vec(), vec![0, n]))
            }
        }
    }

    fn implicit_euler(
        &self,
        points: &[Vec3],
        edges: &[[u32; 2]],
        held: &[u32],
    ) -> Result<Vec<Vec3>, ExperimentError> {
        let mut springs = Springs::term("springs", self.stiffness_n_m.value(), points, edges.to_vec())
            .map_err(ExperimentError::stopped)?;
        let mut mass = Mass::zeros(points.len());
        for point in 0..points.len() as u32 {
            mass.add_point(point, self.mass_kg.value()).map_err(ExperimentError::stopped)?;
        }
        let mut gravity = DeadLoad::gravity(&mass, &GRAVITY).map_err(ExperimentError::stopped)?;
        let fixed: Vec<(u32, Vec3)> = held.iter().map(|&i| (i, points[i as usize])).collect();
        let map = PointMap::with_fixed(points.len(), &fixed).map_err(ExperimentError::stopped)?;
        let newton = NewtonOptions { tolerance: 1e-12, ..NewtonOptions::default() };
        let mut stepper = Stepper::new(mass, map, StepperOptions { newton, ..StepperOptions::default() });
        let mut state = State::at_rest(points.to_vec());
        for _ in 0..self.steps.value() {
            stepper
                .step(&mut state, &mut [&mut springs, &mut gravity], self.step_s.value())
                .map_err(ExperimentError::stopped)?;
        }
        Ok(state.position)
    }
}
