//! A column under its own weight, ν = 0, between smooth walls: P(Y) = −ρ₀ g (H − Y) for every law, so its stretches and its height are known.

use crate::ladder::{Cloud, brief, orders};
use mechanics_core::law::Lame;
use mechanics_core::parallel::with_threads;
use mechanics_core::tensor::Mat3;
use mpm_constitutive::elastic::{FixedCorotated, Hencky, NeoHookean};
use mpm_constitutive::{PointLaw, Strain, fresh_history};
use mpm_core::{Boundary, Kernel, Samples, Shape, Simulation, SimulationOptions, Surface, Transfer};

const DENSITY: f64 = 1000.0;
const GRAVITY: f64 = 9.81;
const YOUNG: f64 = 5e4;

/// The stretch l at which P of a bar that cannot widen is `pressure`.
pub(crate) fn stretch<L: PointLaw>(law: &L, pressure: f64) -> f64 {
    let (mut low, mut high) = (0.3, 1.5);
    while high - low > 1e-15 {
        let middle = 0.5 * (low + high);
        let f = Mat3::from_diagonal(&[1.0, middle, 1.0].into());
        let strain = L::Strain::<f64>::from_deformation_gradient(&f);
        let stress = law.stress(&strain, &fresh_history::<L, f64>()).kirchhoff[(1, 1)] / middle;
        if stress < pressure { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// l and y of the points of a column at rest; y = ∫ l dY by Simpson's rule from point to point.
fn rest<L: PointLaw>(law: &L, heights: &[f64]) -> Vec<(f64, f64)> {
    let at = |height: f64| stretch(law, -DENSITY * GRAVITY * (1.0 - height));
    let (mut below, mut y) = (0.0, 0.0);
    heights
        .iter()
        .map(|height| {
            y += (height - below) / 6.0 * (at(below) + 4.0 * at(0.5 * (below + height)) + at(*height));
            below = *height;
            (at(*height), y)
        })
        .collect()
}

/// Errors of a column of 1 m and `cells` cells at rest: of its height \[m\], and Σ |σ − σ exact| V/(ρ₀ g H V₀).
///
/// It starts in the exact state, and PIC's diffusion brings it to rest in that of the grid: the lowest vibration loses (π/2N)²/4 of its
/// velocity in a step.
fn column<L: PointLaw + Copy + 'static>(cells: usize, law: L, height: f64) -> (f64, f64) {
    let line = 2;
    let spacing = 1.0 / cells as f64;
    let cloud = Cloud::rectangle([0.0; 2], [spacing, 1.0], [line, line * cells]);
    let per_row: Vec<f64> = cloud.points[..line * cells].iter().map(|x| x[1]).collect();
    let rest = rest(&law, &per_row);
    let placed = |p: usize| [cloud.points[p][0], rest[p % rest.len()].1];
    let positions: Vec<_> = (0..cloud.points.len()).map(placed).collect();
    let bent = |p: usize| Mat3::from_diagonal(&[1.0, rest[p % rest.len()].0, 1.0].into());
    let deformations: Vec<_> = (0..cloud.points.len()).map(bent).collect();
    let options = SimulationOptions { spacing, kernel: Kernel::Quadratic, transfer: Transfer::Pic };
    let mut simulation = Simulation::<f64, 2>::new(options).unwrap();
    simulation.set_gravity([0.0, -GRAVITY]).unwrap();
    let walls = Shape::Walls { low: [0.0; 2], high: [spacing, 10.0] };
    simulation.add_boundary(Boundary::at_rest(walls, Surface::Slip)).unwrap();
    let velocities = vec![[0.0; 2]; cloud.points.len()];
    let samples = Samples { positions: &positions, velocities: &velocities, volumes: &cloud.volumes };
    simulation.add_body(law, DENSITY, samples).unwrap();
    simulation.set_deformation_gradients(0, &deformations).unwrap();
    let step = 0.15 * spacing / (YOUNG / DENSITY).sqrt();
    let damping = (std::f64::consts::FRAC_PI_2 * spacing).powi(2) / 4.0;
    let steps = (18.0 / damping) as usize;
    for _ in 0..steps {
        simulation.step(step).unwrap();
    }
    let speed = simulation.velocities(0).iter().fold(0.0_f64, |m, v| m.max(v[1].abs()));
    assert!(speed < 1e-5, "not at rest: {speed} m/s after {steps} steps");
    let (x, states) = (simulation.positions(0), simulation.states(0));
    let half = 0.5 * spacing / line as f64;
    let top = (0..x.len()).max_by(|a, b| cloud.points[*a][1].total_cmp(&cloud.points[*b][1])).unwrap();
    let stress: f64 = (0..x.len())
        .map(|p| {
            // σ_yy = P at lateral stretch one; τ = J σ.
            let sigma = states[p].kirchhoff[(1, 1)] / states[p].volume_ratio;
            let exact = -DENSITY * GRAVITY * (1.0 - cloud.points[p][1]);
            (sigma - exact).abs() * cloud.volumes[p]
        })
        .sum();
    ((x[top][1] + states[top].volume_ratio * half - height).abs(), stress / (DENSITY * GRAVITY * spacing))
}

fn check<L: PointLaw + Copy + 'static>(name: &str, law: L, height: f64) {
    // The quadrature of the rest state, against the height that somebody else computed.
    let (stretch, y) = rest(&law, &[0.5, 1.0])[1];
    assert!((y - height).abs() < 1e-4 && (stretch - 1.0).abs() < 1e-12, "{name}: {y} {stretch}");
    let found = [6, 12, 24].map(|cells| with_threads(1, || column(cells, law, height)));
    let (heights, stresses) = (found.map(|f| f.0), found.map(|f| f.1));
    println!(
        "column {name}: height {}{:.2?}, stress {}{:.2?}",
        brief(&heights),
        orders(&heights),
        brief(&stresses),
        orders(&stresses)
    );
    // First order: held nodes let the lowest matter sink by a part of a cell.
    assert!(orders(&heights).iter().all(|order| *order > 0.85), "{name} {heights:?}");
    assert!(orders(&stresses).iter().all(|order| *order > 0.3), "{name} {stresses:?}");
    assert!(heights[2] < 3e-3 && stresses[2] < 2.5e-2, "{name} {found:?}");
}

#[test]
fn a_column_settles_to_the_height_of_its_law() {
    let lame = Lame::from_young_poisson(YOUNG, 0.0).unwrap();
    check("neo-Hookean", NeoHookean::new(lame), 0.908_279);
    check("Hencky", Hencky::new(lame), 0.917_270);
    check("fixed corotated", FixedCorotated::new(lame), 0.901_900);
}
