//! A column under its own weight between smooth walls: P(Y) = −ρ₀ g (H − Y) whatever the law, so stretches and heights are known.

use super::cloud::Cloud;
use super::method::{Method, Precision};
use super::portrait::{Portrait, pictured};
use super::solver::{Elasticity, Matter, Solver, Watch};
use super::vibrating_bar::Support;
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Positive;
use mechanics_core::tensor::Mat3;
use mpm_core::{Boundary, EquilibriumReport, Kernel, PointState, Samples, Shape, Surface, Transfer};
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::FRAC_PI_2;

/// A column at rest in its weight, ν = 0; the ladder is Δx by the height. It starts in the exact state, and the diffusion of PIC, which
/// forces do not depend on, brings it to rest in that of the grid; or it starts undeformed and is brought to rest at once, by implicit steps.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SelfWeightColumn {
    /// H, without weight (m).
    height_m: Positive,
    /// (Pa).
    young_modulus_pa: Positive,
    /// ρ₀ (kg/m³).
    density_kg_m3: Positive,
    /// What it stands on.
    support: Support,
    /// Its height at rest, from quadrature elsewhere.
    heights_at_rest: Heights,
}

/// Heights at rest, by law.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Heights {
    /// (m).
    neo_hookean_m: Option<Positive>,
    /// (m).
    hencky_m: Option<Positive>,
    /// (m).
    fixed_corotated_m: Option<Positive>,
}

pub(super) const GRAVITY: f64 = 9.81;

/// Particles along each axis of a cell at rest.
pub(super) const ALONG: usize = 2;

/// What the name of a method ends in that brings the column to rest at once.
const AT_ONCE: &str = ", equilibrium";

/// Law and kernel.
const METHODS: &[(&str, Elasticity, Kernel)] = &[
    ("neo-Hookean, linear", Elasticity::NeoHookean, Kernel::Linear),
    ("neo-Hookean, quadratic", Elasticity::NeoHookean, Kernel::Quadratic),
    ("neo-Hookean, cubic", Elasticity::NeoHookean, Kernel::Cubic),
    ("Hencky, quadratic", Elasticity::Hencky, Kernel::Quadratic),
    ("Hencky, cubic", Elasticity::Hencky, Kernel::Cubic),
    ("fixed corotated, quadratic", Elasticity::FixedCorotated, Kernel::Quadratic),
    ("fixed corotated, cubic", Elasticity::FixedCorotated, Kernel::Cubic),
];

const NAMES: &[&str] = &[
    "neo-Hookean, linear",
    "neo-Hookean, quadratic",
    "neo-Hookean, cubic",
    "Hencky, quadratic",
    "Hencky, cubic",
    "fixed corotated, quadratic",
    "fixed corotated, cubic",
    "neo-Hookean, quadratic, equilibrium",
    "neo-Hookean, cubic, equilibrium",
    "Hencky, quadratic, equilibrium",
    "fixed corotated, quadratic, equilibrium",
];

/// The stretch l at which P of matter that cannot widen is −`load` times Young's modulus, in closed form.
fn stretch(law: Elasticity, load: f64) -> f64 {
    match law {
        // ½(l − 1/l) = −load.
        Elasticity::NeoHookean => (load * load + 1.0).sqrt() - load,
        Elasticity::FixedCorotated => 1.0 - load,
        // ln l / l = −load: with l = exp(−y), y exp(y) = load, by Newton's method from above.
        Elasticity::Hencky => {
            let mut y = load.ln_1p();
            for _ in 0..60 {
                y -= (y - load * (-y).exp()) / (1.0 + load * (-y).exp());
            }
            (-y).exp()
        }
    }
}

/// What a part of a column is made of.
#[derive(Clone, Copy)]
pub(super) struct Layer {
    pub(super) law: Elasticity,
    /// ρ₀ g H/E with the height of the whole column.
    pub(super) load: f64,
}

/// The column as it should be.
#[derive(Clone, Copy)]
pub(super) struct Rest {
    pub(super) lower: Layer,
    pub(super) upper: Layer,
    /// Where the upper layer begins, at rest without weight (m).
    pub(super) interface: f64,
    pub(super) height: f64,
}

impl Rest {
    fn stretch(&self, y: f64) -> f64 {
        let layer = if y < self.interface { self.lower } else { self.upper };
        stretch(layer.law, layer.load * (1.0 - y / self.height))
    }

    /// Stretch and place of material points at these heights, which ascend from the floor on: y = ∫ l dY by Gauss's rule of three points in
    /// eight parts from each to the next. The interface must be one of them, or in the middle between two.
    pub(super) fn at(&self, heights: &[f64]) -> Vec<(f64, f64)> {
        let (mut below, mut y) = (0.0, 0.0);
        let mut places = Vec::with_capacity(heights.len());
        for &height in heights {
            let part = (height - below) / 8.0;
            for k in 0..8 {
                let middle = below + part * (f64::from(k) + 0.5);
                let off = 0.5 * part * 0.6_f64.sqrt();
                let outer = self.stretch(middle - off) + self.stretch(middle + off);
                y += part / 18.0 * (5.0 * outer + 8.0 * self.stretch(middle));
            }
            below = height;
            places.push((self.stretch(height), y));
        }
        places
    }
}

impl SelfWeightColumn {
    fn height_at_rest(&self, law: Elasticity) -> Result<f64, ExperimentError> {
        let (key, height) = match law {
            Elasticity::NeoHookean => ("neo_hookean_m", self.heights_at_rest.neo_hookean_m),
            Elasticity::Hencky => ("hencky_m", self.heights_at_rest.hencky_m),
            Elasticity::FixedCorotated => ("fixed_corotated_m", self.heights_at_rest.fixed_corotated_m),
        };
        height.map(Positive::value).ok_or_else(|| ExperimentError::Refused {
            key: format!("experiment.parameters.heights_at_rest.{key}"),
            reason: "the height of a law that the scene uses is missing".to_owned(),
        })
    }

    /// Particles of the column and the exact state of each, (stretch, height).
    fn column(&self, spacing: f64, rest: &Rest) -> (Cloud<2>, Vec<(f64, f64)>) {
        let cells = (self.height_m.value() / spacing).round() as usize;
        let rows = ALONG * cells;
        let height = self.height_m.value();
        let above: Vec<f64> = (0..rows).map(|k| height * (k as f64 + 0.5) / rows as f64).collect();
        let above = rest.at(&above);
        match self.support {
            Support::Nodes => {
                let cloud = Cloud::cuboid([0.0; 2], [spacing, height], [ALONG, rows]);
                let states = (0..ALONG).flat_map(|_| above.iter().copied()).collect();
                (cloud, states)
            }
            Support::MirrorImage => {
                let cloud = Cloud::cuboid([0.0, -height], [spacing, height], [ALONG, 2 * rows]);
                let below = above.iter().rev().map(|(stretch, y)| (*stretch, -y));
                let whole: Vec<(f64, f64)> = below.chain(above.iter().copied()).collect();
                (cloud, (0..ALONG).flat_map(|_| whole.iter().copied()).collect())
            }
        }
    }

    fn start(
        &self,
        matter: &Matter,
        (cloud, states): (&Cloud<2>, &[(f64, f64)]),
        kernel: Kernel,
        spacing: f64,
    ) -> Result<Solver<2>, ExperimentError> {
        let method = Method { kernel, transfer: Transfer::Pic, precision: Precision::Double, along: ALONG };
        let mut solver = Solver::new(method, spacing)?;
        let tall = 2.0 * self.height_m.value();
        let low = if self.support == Support::Nodes { 0.0 } else { -tall };
        let walls = Shape::Walls { low: [0.0, low], high: [spacing, tall] };
        solver.add_boundary(Boundary::at_rest(walls, Surface::Slip))?;
        let positions: Vec<_> = cloud.points.iter().zip(states).map(|(x, state)| [x[0], state.1]).collect();
        let velocities = vec![[0.0; 2]; positions.len()];
        let samples = Samples { positions: &positions, velocities: &velocities, volumes: &cloud.volumes };
        let body = solver.add_body(matter, samples)?;
        let bent: Vec<_> =
            states.iter().map(|state| Mat3::from_diagonal(&[1.0, state.0, 1.0].into())).collect();
        solver.set_deformation_gradients(body, &bent)?;
        if self.support == Support::Nodes {
            solver.set_gravity([0.0, -GRAVITY])?;
        }
        Ok(solver)
    }
}

/// σ_yy of each particle of a body by ρ₀ g H, found and exact. σ = P where the lateral stretch is one.
pub(super) fn stresses(cloud: &Cloud<2>, states: &[PointState], height: f64, weight: f64) -> Vec<(f64, f64)> {
    let found = states.iter().map(|state| state.kirchhoff[(1, 1)] / state.volume_ratio / weight);
    found.zip(&cloud.points).map(|(stress, x)| (stress, x[1].abs() / height - 1.0)).collect()
}

impl Experiment for SelfWeightColumn {
    fn methods(&self) -> &'static [&'static str] {
        NAMES
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let way = at.method.strip_suffix(AT_ONCE);
        let found = METHODS.iter().find(|(name, ..)| *name == way.unwrap_or(at.method));
        let &(_, law, kernel) = found.ok_or_else(|| ExperimentError::Refused {
            key: "validation.methods".to_owned(),
            reason: format!("there is no method `{}`", at.method),
        })?;
        let height = self.height_m.value();
        let spacing = at.ladder * height;
        let matter = Matter::new(law, (self.young_modulus_pa.value(), 0.0), self.density_kg_m3.value())?;
        let weight = matter.density * GRAVITY * height;
        let layer = Layer { law, load: weight / self.young_modulus_pa.value() };
        let rest = Rest { lower: layer, upper: layer, interface: height, height };
        let (cloud, mut states) = self.column(spacing, &rest);
        if way.is_some() {
            // From where nothing presses it.
            states = cloud.points.iter().map(|x| (1.0, x[1])).collect();
        }
        let mut solver = self.start(&matter, (&cloud, &states), kernel, spacing)?;
        let mut watch = Watch::start(&solver);
        let step = 0.5 * solver.stable_step();
        let mut report = EquilibriumReport::default();
        // PIC takes (½ k Δx)²/2 and more of a vibration's velocity in a step, k = π/2H for the lowest: e⁻¹⁸ is left in the end.
        // On coarse grids what the kernel hardly sees is slower than that.
        let steps = match way {
            None => (18.0 * 4.0 / (FRAC_PI_2 * at.ladder).powi(2)).max(6000.0) as usize,
            Some(_) => 0,
        };
        if way.is_some() {
            report = clock.time(|| solver.equilibrate())?;
        }
        let pull: Vec<[f64; 2]> = cloud.points.iter().map(|x| [0.0, -GRAVITY.copysign(x[1])]).collect();
        for k in 0..steps {
            if self.support == Support::MirrorImage {
                solver.accelerate(0, &pull, step)?;
            }
            clock.time(|| solver.step(step)).map_err(ExperimentError::stopped)?;
            if k % steps.div_ceil(8) == 0 {
                watch.look(&mut solver, step);
            }
        }
        let speed = solver.velocities(0).iter().fold(0.0_f64, |m, v| m.max(v[1].abs()));
        let (x, now) = (solver.positions(0), solver.states(0));
        let top = (0..x.len()).max_by(|a, b| x[*a][1].total_cmp(&x[*b][1])).unwrap_or_default();
        let reached = x[top][1] + 0.5 * now[top].volume_ratio * spacing / ALONG as f64;
        let seen = stresses(&cloud, &now, height, weight);
        let off = seen.iter().map(|(found, exact)| (found - exact).abs()).sum::<f64>() / seen.len() as f64;
        let outcome = Outcome::default()
            .error("height", (reached - self.height_at_rest(law)?).abs() / height)
            .error("stress", off)
            .count("Newton iterations", report.iterations)
            .count("products", report.products)
            .invariant("largest speed at the end by the wave speed", speed / matter.wave_speed());
        let outcome = watch.held(solver.counted(outcome));
        let caption = format!("{}: the column at rest, and its stress; line: exact", at.method);
        pictured(outcome, at, &caption, || {
            let label = format!("{}, Δx = {spacing:.4} m", at.method);
            portrait(&x, &rest, (&seen, spacing), label)
        })
    }
}

/// The column above the floor, and beside it its stress, compression to the right, over the height.
pub(super) fn portrait(
    x: &[[f64; 2]],
    rest: &Rest,
    (seen, spacing): (&[(f64, f64)], f64),
    label: String,
) -> Portrait<2> {
    let tall = rest.at(&[rest.height])[0].1;
    let (left, width) = (0.25 * tall + spacing, tall);
    let mut portrait = Portrait {
        radius: (0.2 * spacing).min(0.01 * tall),
        field: ("error of stress by the base's", "1"),
        label,
        ..Portrait::default()
    };
    for (x, (found, exact)) in x.iter().zip(seen).filter(|(x, _)| x[1] > 0.0) {
        for place in [*x, [left - width * found, x[1]]] {
            portrait.positions.push(place);
            portrait.values.push(found - exact);
        }
    }
    let heights: Vec<f64> = (1..=100).map(|k| 0.01 * rest.height * f64::from(k)).collect();
    let curve = heights.iter().zip(rest.at(&heights));
    let curve = curve.map(|(rest_height, (_, y))| [left + width * (1.0 - rest_height / rest.height), y]);
    let mut line = vec![[left + width, 0.0]];
    line.extend(curve);
    portrait.lines = vec![line, vec![[left, 0.0], [left, tall]], vec![[0.0, 0.0], [left + width, 0.0]]];
    portrait
}
