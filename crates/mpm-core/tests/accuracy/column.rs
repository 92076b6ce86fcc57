//! A column under its own weight, ν = 0, between smooth walls: P(Y) = −ρ₀ g (H − Y) for every law, so its stretches and its height are known.

use crate::ladder::{Cloud, brief, orders};
use mechanics_core::law::Lame;
use mpm_constitutive::PointLaw;
use mpm_constitutive::elastic::{FixedCorotated, Hencky, NeoHookean};
use mpm_core::{Boundary, Kernel, Samples, Shape, Simulation, SimulationOptions, Surface, Transfer};

const DENSITY: f64 = 1000.0;
const GRAVITY: f64 = 9.81;
const YOUNG: f64 = 5e4;

/// Errors of a column of 1 m and `cells` cells at rest: of its height \[m\], and Σ |σ − σ exact| V/(ρ₀ g H V₀).
///
/// PIC's diffusion brings it to rest: the lowest vibration loses (π/2N)²/4 of its velocity in a step.
fn column<L: PointLaw + Copy + 'static>(cells: usize, law: L, height: f64) -> (f64, f64) {
    let spacing = 1.0 / cells as f64;
    let cloud = Cloud::rectangle([0.0; 2], [spacing, 1.0], [2, 2 * cells]);
    let options = SimulationOptions { spacing, kernel: Kernel::Quadratic, transfer: Transfer::Pic };
    let mut simulation = Simulation::<f64, 2>::new(options).unwrap();
    simulation.set_gravity([0.0, -GRAVITY]).unwrap();
    let walls = Shape::Walls { low: [0.0; 2], high: [spacing, 10.0] };
    simulation.add_boundary(Boundary::at_rest(walls, Surface::Slip)).unwrap();
    let velocities = vec![[0.0; 2]; cloud.points.len()];
    let samples = Samples { positions: &cloud.points, velocities: &velocities, volumes: &cloud.volumes };
    simulation.add_body(law, DENSITY, samples).unwrap();
    let step = 0.15 * spacing / (YOUNG / DENSITY).sqrt();
    let damping = (std::f64::consts::FRAC_PI_2 * spacing).powi(2) / 4.0;
    let steps = (28.0 / damping) as usize;
    for _ in 0..steps {
        simulation.step(step).unwrap();
    }
    let speed = simulation.velocities(0).iter().fold(0.0_f64, |m, v| m.max(v[1].abs()));
    assert!(speed < 1e-6, "not at rest: {speed} m/s after {steps} steps");
    let (x, states) = (simulation.positions(0), simulation.states(0));
    let half = 0.25 * spacing;
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
    let found = [8, 16, 32].map(|cells| column(cells, law, height));
    let (heights, stresses) = (found.map(|f| f.0), found.map(|f| f.1));
    println!("column {name}: height {}{:.2?}, stress {}{:.2?}", brief(&heights), orders(&heights), brief(&stresses), orders(&stresses));
    assert!(orders(&heights).iter().all(|order| *order > 0.8), "{name} {heights:?}");
    assert!(orders(&stresses).iter().all(|order| *order > 0.8), "{name} {stresses:?}");
    assert!(heights[2] < 3e-3 && stresses[2] < 2e-2, "{name} {found:?}");
}

#[test]
fn a_column_settles_to_the_height_of_its_law() {
    let lame = Lame::from_young_poisson(YOUNG, 0.0).unwrap();
    check("neo-Hookean", NeoHookean::new(lame), 0.908_279);
    check("Hencky", Hencky::new(lame), 0.917_270);
    check("fixed corotated", FixedCorotated::new(lame), 0.901_900);
}
