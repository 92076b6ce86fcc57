//! The incremental potential as something that core's Newton minimises.

use super::ImplicitError;
use super::cloud::Cloud;
use super::conjugate_gradient::{System, dot, solve_into};
use super::constraints::{Constraints, Round};
use super::nodes::Nodes;
use super::preconditioner::diagonal_blocks;
use crate::body::StepSettings;
use crate::grid::Fields;
use mechanics_core::objective::{DirectionAccuracy, DirectionReport, Location, Objective, ObjectiveError};
use mechanics_core::parallel;
use mechanics_core::tensor::{Mat3, Vec3};
use std::time::{Duration, Instant};

/// Accuracy of the directions that decide whether a minimum is reached.
const FULL: f64 = 1e-4;

/// Where friction is smoothed, as a part of the speed that matters.
const CREEP: f64 = 1e-4;

/// The most products a direction takes.
const MOST_PRODUCTS: u64 = 10_000;

/// Φ(v), see the module [implicit](super).
pub(crate) struct Problem<'a, const D: usize> {
    pub(super) grid: &'a dyn Fields,
    pub(super) cloud: Cloud<'a, D>,
    pub(crate) nodes: Nodes<D>,
    pub(super) constraints: Constraints<D>,
    pub(super) settings: StepSettings,
    /// Diagonal blocks of the last Hessian, and their inverses.
    pub(crate) blocks: Vec<Mat3>,
    inverses: Vec<Mat3>,
    /// Hessians of friction, by node.
    friction: Vec<(usize, Mat3)>,
    /// What velocities are measured by \[m/s\]; from the first direction.
    pub(super) speed: Option<f64>,
    pub(super) products: u64,
    pub(super) product_time: Duration,
}

impl<'a, const D: usize> Problem<'a, D> {
    pub(super) fn new(
        grid: &'a dyn Fields,
        cloud: Cloud<'a, D>,
        nodes: Nodes<D>,
        constraints: Constraints<D>,
        settings: StepSettings,
    ) -> Self {
        Self {
            grid,
            cloud,
            nodes,
            constraints,
            settings,
            blocks: Vec::new(),
            inverses: Vec::new(),
            friction: Vec::new(),
            speed: None,
            products: 0,
            product_time: Duration::ZERO,
        }
    }

    /// ∇Φ before what is held is taken out.
    pub(super) fn whole_gradient(&mut self, x: &[f64]) -> Vec<f64> {
        let mut gradient = self.inertia(x);
        self.cloud.gather(self.grid, self.nodes.expanded(x));
        self.cloud.scatter_stress();
        self.nodes.add_arenas(self.grid, self.cloud.arenas(), &mut gradient);
        self.constraints.add_friction(x, &mut gradient);
        gradient
    }

    /// M (v − v̂).
    fn inertia(&self, x: &[f64]) -> Vec<f64> {
        let (masses, forecast) = (&self.nodes.masses, &self.nodes.forecast);
        x.iter().zip(forecast).enumerate().map(|(i, (x, v))| masses[i / D] * (x - v)).collect()
    }

    /// H d at the last linearisation.
    #[cfg(test)]
    pub(crate) fn product(&mut self, d: &[f64]) -> Vec<f64> {
        let mut product = vec![0.0; d.len()];
        self.multiply_into(d, &mut product);
        product
    }

    /// The largest velocity of a node as far as particles feel it: a light node, of which particles have a small weight w ~ mᵢ and a gradient of
    /// the size √w, counts by √(mᵢ/m̄). Its own velocity is mostly rounding.
    fn felt(&self, velocities: &[f64]) -> f64 {
        let masses = &self.nodes.masses;
        let mean = masses.iter().sum::<f64>() / masses.len() as f64;
        velocities
            .chunks_exact(D)
            .zip(masses)
            .fold(0.0, |most, (v, m)| crate::material::largest((m / mean).min(1.0).sqrt() * largest(v), most))
    }

    /// The larger of what moves before stress and of `velocities`, but no more than a cell a step.
    fn fastest(&self, velocities: &[f64]) -> f64 {
        let fastest = self.felt(&self.nodes.forecast).max(self.felt(velocities));
        fastest.min(self.settings.spacing / self.settings.step)
    }

    /// Linearises at `x`.
    pub(crate) fn linearise(&mut self, x: &[f64]) {
        self.cloud.gather(self.grid, self.nodes.expanded(x));
        self.cloud.update_tangents();
        self.blocks = diagonal_blocks(&mut self.cloud, &self.nodes, self.grid, &self.settings);
        self.friction = self.constraints.friction_blocks(x);
        for (node, block) in &self.friction {
            self.blocks[*node] += block;
        }
        let mut blocks = self.blocks.clone();
        self.constraints.project_blocks(&mut blocks);
        self.inverses = blocks.iter().map(|b| b.try_inverse().unwrap_or_else(Mat3::zeros)).collect();
    }

    /// Lets boundaries hold and let go at the minimum `x`; answers how many conditions changed.
    pub(super) fn revise(&mut self, x: &[f64], tolerance: f64, number: u64) -> usize {
        if self.constraints.are_equalities() {
            return 0;
        }
        let gradient = self.whole_gradient(x);
        if self.blocks.is_empty() {
            self.linearise(x);
        }
        let speed = self.speed.unwrap_or_else(|| self.fastest(x));
        let round = Round { slack: tolerance * speed, creep: CREEP * speed, number };
        self.constraints.revise(x, &gradient, &self.blocks, &round)
    }

    /// The start of lowest Φ among what would be without stress, the same without load, and rest.
    pub(super) fn start(&mut self, gain: &[f64; D]) -> Result<Vec<f64>, ImplicitError> {
        let forecast = self.nodes.forecast.clone();
        let before = forecast.iter().enumerate().map(|(i, v)| v - gain[i % D]).collect();
        let rest = vec![0.0; forecast.len()];
        let mut best: Option<(f64, Vec<f64>)> = None;
        for mut x in [forecast, before, rest] {
            self.constraints.place(&mut x);
            let value = self.value(&x);
            if value.is_finite() && best.as_ref().is_none_or(|(least, _)| value < *least) {
                best = Some((value, x));
            }
        }
        match (best, self.cloud.first_inadmissible()) {
            (Some((_, x)), _) => Ok(x),
            (None, Some((body, particle, ratio))) => Err(ImplicitError::Start { body, particle, ratio }),
            (None, None) => Err(ImplicitError::Infinite),
        }
    }
}

impl<const D: usize> System for Problem<'_, D> {
    fn multiply_into(&mut self, p: &[f64], product: &mut [f64]) {
        let begin = Instant::now();
        for (i, (q, p)) in product.iter_mut().zip(p).enumerate() {
            *q = self.nodes.masses[i / D] * p;
        }
        self.cloud.product(self.grid, self.nodes.expanded(p));
        self.nodes.add_arenas(self.grid, self.cloud.arenas(), product);
        for (node, block) in &self.friction {
            let part = block * Vec3::from_fn(|k, _| if k < D { p[node * D + k] } else { 0.0 });
            for axis in 0..D {
                product[node * D + axis] += part[axis];
            }
        }
        self.constraints.project(product);
        self.products += 1;
        self.product_time += begin.elapsed();
    }

    fn precondition_into(&self, r: &[f64], z: &mut [f64]) {
        for ((z, r), inverse) in z.chunks_exact_mut(D).zip(r.chunks_exact(D)).zip(&self.inverses) {
            let full = inverse * Vec3::from_fn(|k, _| if k < D { r[k] } else { 0.0 });
            z.copy_from_slice(&full.as_slice()[..D]);
        }
        self.constraints.project(z);
    }
}

impl<const D: usize> Objective for Problem<'_, D> {
    fn dimension(&self) -> usize {
        self.nodes.count() * D
    }

    fn value(&mut self, x: &[f64]) -> f64 {
        let (masses, forecast) = (&self.nodes.masses, &self.nodes.forecast);
        let inertia = 0.5 * parallel::sum(x.len(), 4096, |i| masses[i / D] * (x[i] - forecast[i]).powi(2));
        self.cloud.gather(self.grid, self.nodes.expanded(x));
        inertia + self.cloud.energy() + self.constraints.friction_energy(x)
    }

    fn gradient_into(&mut self, x: &[f64], gradient: &mut [f64]) {
        gradient.copy_from_slice(&self.whole_gradient(x));
        self.constraints.project(gradient);
    }

    fn direction_into(
        &mut self,
        x: &[f64],
        gradient: &[f64],
        accuracy: DirectionAccuracy,
        direction: &mut [f64],
    ) -> Result<DirectionReport, ObjectiveError> {
        let begin = Instant::now();
        self.linearise(x);
        let assembly_time = begin.elapsed();
        let tolerance = match accuracy {
            DirectionAccuracy::Full | DirectionAccuracy::Decisive => FULL,
            DirectionAccuracy::Relative(part) => part.max(FULL),
        };
        let right: Vec<f64> = gradient.iter().map(|g| -g).collect();
        let linear_iterations =
            solve_into(self, &right, tolerance, MOST_PRODUCTS, direction).map_err(|unsolved| {
                let error = ImplicitError::LinearSystem {
                    products: unsolved.iterations,
                    residual: unsolved.residual,
                    wanted: tolerance,
                };
                ObjectiveError::Solver(Box::new(error))
            })?;
        if self.speed.is_none() {
            self.speed = Some(self.fastest(direction));
        }
        let solve_time = begin.elapsed() - assembly_time;
        Ok(DirectionReport { linear_iterations, assembly_time, solve_time, ..DirectionReport::default() })
    }

    /// That of the sum, and that of F in each energy: near rest ψ is a square of differences of F from a rotation.
    fn rounding(&self, value: f64) -> f64 {
        f64::EPSILON * (64.0 * value.abs() + 4.0 * self.cloud.stress_size())
    }

    fn step_norm(&self, p: &[f64]) -> f64 {
        self.felt(p) / self.speed.unwrap_or(1.0)
    }

    fn locate(&mut self, _x: &[f64], p: &[f64]) -> Location {
        let size = |node: usize| dot(&p[node * D..(node + 1) * D], &p[node * D..(node + 1) * D]);
        let point = (0..self.nodes.count()).max_by(|a, b| size(*a).total_cmp(&size(*b)));
        Location { point, ..Location::default() }
    }
}

/// The largest magnitude; NaN if there is one.
fn largest(numbers: &[f64]) -> f64 {
    numbers.iter().fold(0.0, |most, x| crate::material::largest(x.abs(), most))
}
