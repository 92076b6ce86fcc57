//! What the grid cannot see, and what its lumped mass smooths away.

use super::cloud::Cloud;
use super::method::Method;
use super::portrait::{Portrait, pictured};
use super::solver::{Elasticity, Matter, Solver};
use crate::experiment::random::Random;
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::picture::{Chart, Curve};
use crate::scene::quantity::Count;
use mpm_core::{Kernel, Samples, Transfer};
use nalgebra::{DMatrix, DVector};
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::TAU;

/// Two particles at each place with opposite random velocities, of which the grid gets nothing; the ladder is the number of steps.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct NullSpace {
    /// Cells along each side of the square.
    cells: Count,
}

impl Experiment for NullSpace {
    fn methods(&self) -> &'static [&'static str] {
        Method::names()
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let method = Method::named(at.method)?;
        let side = self.cells.value();
        // As soft as a gas: nothing but transfers acts.
        let matter = Matter::new(Elasticity::NeoHookean, (1e-9, 0.0), 1.0)?;
        let single = Cloud::cuboid([0.0; 2], [side as f64; 2], [method.along * side; 2]);
        let points: Vec<_> = single.points.iter().flat_map(|x| [*x, *x]).collect();
        let volumes = vec![0.5 * single.volumes[0]; points.len()];
        let mut random = Random::new(at.seed + 1);
        let noise: Vec<[f64; 2]> = (0..single.points.len())
            .map(|_| [random.symmetric(), random.symmetric()])
            .flat_map(|v| [v, v.map(|v| -v)])
            .collect();
        let mut solver = Solver::new(method, 1.0)?;
        solver.add_body(&matter, Samples { positions: &points, velocities: &noise, volumes: &volumes })?;
        let steps = at.ladder.round() as i32;
        for _ in 0..steps {
            clock.time(|| solver.step(0.1)).map_err(ExperimentError::stopped)?;
        }
        let size = |v: &[[f64; 2]]| v.iter().flatten().map(|v| v * v).sum::<f64>().sqrt();
        let left = size(&solver.velocities(0)) / size(&noise);
        let expected = match method.transfer {
            Transfer::Flip { flip } => flip.powi(steps),
            _ => 0.0,
        };
        let moved = solver
            .positions(0)
            .iter()
            .zip(&points)
            .fold(0.0_f64, |moved, (a, b)| moved.max((a[0] - b[0]).abs()).max((a[1] - b[1]).abs()));
        let outcome = solver.counted(
            Outcome::default()
                .error("noise left, less theory", (left - expected).abs())
                .error("way that noise goes", moved)
                .invariant("noise left", left),
        );
        pictured(outcome, at, "speed of the particles: noise that the grid does not see", || Portrait {
            positions: solver.positions(0),
            values: solver.velocities(0).iter().map(|v| v[0].hypot(v[1])).collect(),
            radius: 0.5 / method.along as f64,
            field: ("speed", "m/s"),
            range: Some((0.0, 1.5)),
            lines: Vec::new(),
            label: format!("{}: {left:.3} of the noise after {steps} steps", at.method),
        })
    }
}

/// A wave of nodal velocities, seen by particles and given back to the nodes: what a transfer leaves of it. The ladder is the wave's
/// length in cells.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct MassMatrix {}

/// Of the bar: far from its ends nothing knows of them.
const CELLS: usize = 96;
/// Nodes of the ring on which the consistent mass matrix is inverted.
const RING: usize = 96;
const CONSISTENT: &str = "quadratic PIC, consistent mass";
const WAYS: [&str; 8] = [
    "linear PIC",
    "quadratic PIC",
    "cubic PIC",
    "quadratic XPIC-2",
    "quadratic XPIC-5",
    "quadratic APIC",
    "quadratic FLIP",
    CONSISTENT,
];

impl Experiment for MassMatrix {
    fn methods(&self) -> &'static [&'static str] {
        &WAYS
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let wave = TAU / at.ladder;
        let outcome = if at.method == CONSISTENT {
            let kept = clock.time(|| consistent(wave));
            Outcome::default()
                .error("wave lost a step", (1.0 - kept).abs())
                .error("wave left, less theory", (kept - 1.0).abs())
        } else {
            Self::lumped(at, wave, clock)?
        };
        drawn(outcome, at)
    }
}

impl MassMatrix {
    /// A step of the crate, without stress.
    fn lumped(at: &Point<'_>, wave: f64, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let method = Method::named(at.method)?;
        let matter = Matter::new(Elasticity::FixedCorotated, (1e-9, 0.0), 1.0)?;
        let cloud = Cloud::cuboid([0.0; 2], [CELLS as f64, 1.0], [method.along * CELLS, method.along]);
        let nodal = |i: i64| (wave * i as f64).sin();
        let seen = |x: f64| {
            let near = reach(method.kernel, x);
            near.iter().map(|(i, w)| w * nodal(*i)).sum::<f64>()
        };
        let velocities: Vec<_> = cloud.points.iter().map(|x| [seen(x[0]), 0.0]).collect();
        let mut solver = Solver::new(method, 1.0)?;
        let body = solver.add_body(
            &matter,
            Samples { positions: &cloud.points, velocities: &velocities, volumes: &cloud.volumes },
        )?;
        if let Some(moment) = method.kernel.second_moment() {
            let slope = |x: f64| {
                let near = reach(method.kernel, x);
                near.iter().map(|(i, w)| w * nodal(*i) * (*i as f64 - x)).sum::<f64>() / moment
            };
            let gradients: Vec<_> = cloud.points.iter().map(|x| [[slope(x[0]), 0.0], [0.0; 2]]).collect();
            solver.set_velocity_gradients(body, &gradients)?;
        }
        clock.time(|| solver.step(1e-3)).map_err(ExperimentError::stopped)?;
        // The part of the first wave in what is left, far from the ends.
        let (mut product, mut square) = (0.0, 0.0);
        for (v, (x, first)) in solver.velocities(0).iter().zip(cloud.points.iter().zip(&velocities)) {
            if (x[0] - 0.5 * CELLS as f64).abs() < 0.35 * CELLS as f64 {
                product += v[0] * first[0];
                square += first[0] * first[0];
            }
        }
        let kept = product / square;
        let expected = match method.transfer {
            Transfer::Flip { .. } => 1.0,
            _ => symbol(method, wave),
        };
        Ok(solver.counted(
            Outcome::default()
                .error("wave lost a step", (1.0 - kept).abs())
                .error("wave left, less theory", (kept - expected).abs()),
        ))
    }
}

/// The nodes near a place \[cells\] with the values of their B-splines there, by the splines' own definition (differences of truncated
/// powers).
fn reach(kernel: Kernel, x: f64) -> Vec<(i64, f64)> {
    let degree = kernel.width() as i32 - 1;
    let spline = |d: f64| {
        let half = 0.5 * f64::from(degree + 1);
        let (mut sum, mut binomial) = (0.0, 1.0);
        for k in 0..=degree + 1 {
            sum += binomial * (d + half - f64::from(k)).max(0.0).powi(degree);
            binomial *= -f64::from(degree + 1 - k) / f64::from(k + 1);
        }
        sum / (1..=degree).map(f64::from).product::<f64>()
    };
    let first = x.floor() as i64 - 2;
    (first..first + 6).map(|i| (i, spline(x - i as f64))).filter(|(_, w)| *w > 0.0).collect()
}

/// What P2G with lumped mass makes of nodal velocities e^(iκj) at node 0, for equal particles in all cells: Σ_p w₀ₚ (Σ_j wⱼₚ (1 + (x₀ − xₚ)(xⱼ −
/// xₚ)/D) e^(iκj)) / Σ_p w₀ₚ, the bracket's second term with APIC only. It is real by symmetry. XPIC(m) keeps 1 − (1 − λ)ᵐ where PIC keeps λ.
fn symbol(method: Method, wave: f64) -> f64 {
    let affine = match (method.transfer, method.kernel.second_moment()) {
        (Transfer::Apic { .. } | Transfer::MlsApic, Some(moment)) => 1.0 / moment,
        _ => 0.0,
    };
    let (mut sum, mut mass) = (0.0, 0.0);
    for p in 0..6 * method.along {
        let x = (p as f64 + 0.5) / method.along as f64 - 3.0;
        let near = reach(method.kernel, x);
        let own = near.iter().find(|(i, _)| *i == 0).map_or(0.0, |(_, w)| *w);
        for (j, w) in &near {
            sum += own * w * (1.0 + affine * -x * (*j as f64 - x)) * (wave * *j as f64).cos();
        }
        mass += own;
    }
    match method.transfer {
        Transfer::Xpic { order } => 1.0 - (1.0 - sum / mass).powi(order as i32),
        _ => sum / mass,
    }
}

/// The same wave through the consistent mass matrix M_ij = Σ m wᵢ wⱼ, on a ring of nodes: the part of it that is left.
fn consistent(wave: f64) -> f64 {
    let ring = |i: i64| i.rem_euclid(RING as i64) as usize;
    let nodal = DVector::from_fn(RING, |i, _| (wave * i as f64).sin());
    let (mut mass, mut momentum) = (DMatrix::zeros(RING, RING), DVector::zeros(RING));
    for p in 0..2 * RING {
        let near = reach(Kernel::Quadratic, 0.5 * p as f64 + 0.25);
        let velocity: f64 = near.iter().map(|(i, w)| w * nodal[ring(*i)]).sum();
        for (i, w) in &near {
            momentum[ring(*i)] += w * velocity;
            for (j, other) in &near {
                mass[(ring(*i), ring(*j))] += w * other;
            }
        }
    }
    let found = mass.lu().solve(&momentum).unwrap_or_else(|| DVector::from_element(RING, f64::NAN));
    found.dot(&nodal) / nodal.dot(&nodal)
}

/// `outcome` with what all ways leave of waves, by theory.
fn drawn(outcome: Outcome, at: &Point<'_>) -> Result<Outcome, ExperimentError> {
    let mut chart = Chart {
        title: "What a step leaves of a wave of nodal velocities".to_owned(),
        x: "cells a wave".to_owned(),
        y: "part left".to_owned(),
        ..Chart::default()
    };
    for way in WAYS {
        let left = |cells: f64| match way {
            CONSISTENT | "quadratic FLIP" => Ok(1.0),
            _ => Method::named(way).map(|method| symbol(method, TAU / cells)),
        };
        let points: Result<Vec<_>, _> =
            (0..=60).map(|k| 2.0 + 0.25 * f64::from(k)).map(|cells| Ok([cells, left(cells)?])).collect();
        chart.curves.push(Curve::line(way, points?));
    }
    outcome.charted(at, "by theory, two particles a cell and axis", &chart)
}
