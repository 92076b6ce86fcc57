//! A column of two layers under its own weight: two laws in one grid, brought to rest at once.

use super::cloud::Cloud;
use super::column::{ALONG, GRAVITY, Layer, Rest, portrait, stresses};
use super::method::{Method, Precision};
use super::portrait::pictured;
use super::solver::{Elasticity, Matter, Solver};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Positive;
use mpm_core::{Boundary, Kernel, Shape, Surface, Transfer};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// A column of H = 1 m and ρ₀ = 1000 kg/m³, ν = 0, whose lower half is of other matter than the upper one, undeformed at first and brought to rest
/// by implicit steps; the ladder is Δx/H. The softer half has E = 50 kPa. P(Y) = −ρ₀ g (H − Y) whatever the layers are.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct LayeredColumn {
    /// Heights at rest by method (m), from quadrature elsewhere.
    heights_at_rest_m: BTreeMap<String, Positive>,
}

const HEIGHT: f64 = 1.0;
const INTERFACE: f64 = 0.5 * HEIGHT;
/// Of the softer half.
const YOUNG: f64 = 5e4;
const DENSITY: f64 = 1000.0;

/// Lower and upper law, E₁/E₂ of the lower by the upper one, kernel.
const METHODS: &[(&str, [Elasticity; 2], f64, Kernel)] = {
    use Elasticity::{FixedCorotated as C, Hencky as H, NeoHookean as N};
    &[
        ("E₁ = E₂", [N, N], 1.0, Kernel::Quadratic),
        ("E₁ = 10 E₂", [N, N], 10.0, Kernel::Quadratic),
        ("E₁ = 100 E₂", [N, N], 100.0, Kernel::Quadratic),
        ("E₁ = 10⁴ E₂", [N, N], 1e4, Kernel::Quadratic),
        ("E₂ = 100 E₁", [N, N], 1e-2, Kernel::Quadratic),
        ("E₂ = 10⁴ E₁", [N, N], 1e-4, Kernel::Quadratic),
        ("E₂ = 100 E₁, cubic", [N, N], 1e-2, Kernel::Cubic),
        ("Hencky under neo-Hookean", [H, N], 1.0, Kernel::Quadratic),
        ("fixed corotated under Hencky", [C, H], 1.0, Kernel::Quadratic),
    ]
};

const NAMES: &[&str] = &[
    "E₁ = E₂",
    "E₁ = 10 E₂",
    "E₁ = 100 E₂",
    "E₁ = 10⁴ E₂",
    "E₂ = 100 E₁",
    "E₂ = 10⁴ E₁",
    "E₂ = 100 E₁, cubic",
    "Hencky under neo-Hookean",
    "fixed corotated under Hencky",
];

impl Experiment for LayeredColumn {
    fn methods(&self) -> &'static [&'static str] {
        NAMES
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let refused = |key: &str, reason: String| ExperimentError::Refused { key: key.to_owned(), reason };
        let found = METHODS.iter().find(|(name, ..)| *name == at.method);
        let &(_, laws, ratio, kernel) = found
            .ok_or_else(|| refused("validation.methods", format!("there is no method `{}`", at.method)))?;
        let known = self.heights_at_rest_m.get(at.method).copied().ok_or_else(|| {
            let key = "experiment.parameters.heights_at_rest_m";
            refused(key, format!("the height of `{}` is missing", at.method))
        })?;
        let spacing = at.ladder * HEIGHT;
        let soft = ratio.min(1.0);
        let moduli = [YOUNG * ratio / soft, YOUNG / soft];
        let weight = DENSITY * GRAVITY * HEIGHT;
        let [lower, upper] = [0, 1].map(|layer| Layer { law: laws[layer], load: weight / moduli[layer] });
        let rest = Rest { lower, upper, interface: INTERFACE, height: HEIGHT };
        let method = Method { kernel, transfer: Transfer::Pic, precision: Precision::Double, along: ALONG };
        let mut solver = Solver::new(method, spacing)?;
        let walls = Shape::Walls { low: [0.0; 2], high: [spacing, 2.0 * HEIGHT] };
        solver.add_boundary(Boundary::at_rest(walls, Surface::Slip))?;
        solver.set_gravity([0.0, -GRAVITY])?;
        let rows = ALONG * (INTERFACE / spacing).round() as usize;
        let mut layers = Vec::new();
        for layer in 0..2 {
            let low = INTERFACE * layer as f64;
            let cloud = Cloud::cuboid([0.0, low], [spacing, low + INTERFACE], [ALONG, rows]);
            let matter = Matter::new(laws[layer], (moduli[layer], 0.0), DENSITY)?;
            solver.add_cloud(&matter, &cloud)?;
            layers.push(cloud);
        }
        let report = clock.time(|| solver.equilibrate())?;
        let (mut x, mut seen, mut tops) = (Vec::new(), Vec::new(), Vec::new());
        for (body, cloud) in layers.iter().enumerate() {
            let (places, states) = (solver.positions(body), solver.states(body));
            let top = (0..places.len()).max_by(|a, b| places[*a][1].total_cmp(&places[*b][1]));
            let top = top.unwrap_or_default();
            tops.push(places[top][1] + 0.5 * states[top].volume_ratio * spacing / ALONG as f64);
            seen.extend(stresses(cloud, &states, HEIGHT, weight));
            x.extend(places);
        }
        let exact: Vec<f64> = rest.at(&[INTERFACE, HEIGHT]).iter().map(|(_, y)| *y).collect();
        let mean = |of: &[(f64, f64)]| of.iter().map(|(a, b)| (a - b).abs()).sum::<f64>() / of.len() as f64;
        // The rows within a cell of the interface, of both layers.
        let near: Vec<(f64, f64)> =
            seen.iter().copied().filter(|(_, exact)| (exact + 0.5).abs() < spacing / HEIGHT).collect();
        let outcome = Outcome::default()
            .error("height", (tops[1] - exact[1]).abs() / HEIGHT)
            .error("interface", (tops[0] - exact[0]).abs() / HEIGHT)
            .error("stress", mean(&seen))
            .error("stress at the interface", mean(&near))
            .count("Newton iterations", report.iterations)
            .count("products", report.products)
            .invariant("exact height less that from elsewhere", (exact[1] - known.value()).abs());
        let caption = format!("{}: the column at rest, and its stress; line: exact", at.method);
        pictured(solver.counted(outcome), at, &caption, || {
            let label = format!("{}, Δx = {spacing:.4} m", at.method);
            portrait(&x, &rest, (&seen, spacing), label)
        })
    }
}
