//! Columns at rest under their weight, directly. At lateral stretch one P(Y) = −ρ₀ g (H − Y) for every law.

use crate::block::{Block, DENSITY, lame};
use mechanics_core::tensor::Mat3;
use mpm_constitutive::elastic::{FixedCorotated, Hencky, NeoHookean};
use mpm_constitutive::{PointLaw, Strain, fresh_history};
use mpm_core::{Boundary, Equilibrium, Samples, Shape, Simulation, SimulationOptions, Surface};

const GRAVITY: f64 = 9.81;

fn column(cells: usize) -> (Block<2>, Simulation<f64, 2>) {
    let spacing = 1.0 / cells as f64;
    let block = Block::new([1, cells], spacing);
    let mut simulation = Simulation::new(SimulationOptions::new(spacing)).unwrap();
    simulation.set_gravity([0.0, -GRAVITY]).unwrap();
    let walls = Shape::Walls { low: [0.0; 2], high: [spacing, 10.0] };
    simulation.add_boundary(Boundary::at_rest(walls, Surface::Slip)).unwrap();
    (block, simulation)
}

/// The error of the height of a column of 1 m \[m\].
fn error<L: PointLaw + 'static>(cells: usize, law: L, height: f64) -> f64 {
    let (block, mut simulation) = column(cells);
    let velocities = vec![[0.0; 2]; block.positions.len()];
    let samples = Samples { positions: &block.positions, velocities: &velocities, volumes: &block.volumes };
    simulation.add_body(law, DENSITY, samples).unwrap();
    let report = simulation.equilibrate(&Equilibrium::default()).unwrap();
    let (x, states) = (simulation.positions(0), simulation.states(0));
    let top = (0..x.len()).max_by(|a, b| x[*a][1].total_cmp(&x[*b][1])).unwrap();
    let found = x[top][1] + states[top].volume_ratio * 0.25 / cells as f64;
    println!("{cells} cells: {found:.6} m, {report:?}");
    assert_eq!(simulation.time(), 0.0);
    (found - height).abs()
}

#[test]
fn a_column_comes_to_the_height_of_its_law_at_once() {
    let lame = lame(5e4, 0.0);
    let check = |name: &str, found: [f64; 3]| {
        let orders = [0, 1].map(|k| (found[k] / found[k + 1]).log2());
        println!("{name}: {found:?}, orders {orders:.2?}");
        assert!(orders.iter().all(|order| *order > 0.85) && found[2] < 1.5e-3, "{name}: {found:?}");
    };
    check("neo-Hookean", [12, 24, 48].map(|cells| error(cells, NeoHookean::new(lame), 0.908_279)));
    check("Hencky", [12, 24, 48].map(|cells| error(cells, Hencky::new(lame), 0.917_270)));
    check("fixed corotated", [12, 24, 48].map(|cells| error(cells, FixedCorotated::new(lame), 0.901_900)));
}

/// The stretch l of a neo-Hookean bar that cannot widen, where P is −`pressure`.
fn stretch(young: f64, pressure: f64) -> f64 {
    let law = NeoHookean::new(lame(young, 0.0));
    let (mut low, mut high) = (0.1, 1.5);
    while high - low > 1e-14 {
        let middle = 0.5 * (low + high);
        let f = Mat3::from_diagonal(&[1.0, middle, 1.0].into());
        let tau = law.stress(&Strain::from_deformation_gradient(&f), &fresh_history::<NeoHookean, f64>());
        if tau.kirchhoff[(1, 1)] / middle < -pressure { low = middle } else { high = middle }
    }
    middle_of(low, high)
}

fn middle_of(low: f64, high: f64) -> f64 {
    0.5 * (low + high)
}

/// A stiff half on a soft one, and the other way round.
#[test]
fn halves_of_stiffness_one_and_ten_thousand_rest_together() {
    let cells = 24;
    for (below, above) in [(5e4, 5e8), (5e8, 5e4)] {
        let (block, mut simulation) = column(cells);
        for (young, lower) in [(below, true), (above, false)] {
            let chosen: Vec<usize> =
                (0..block.positions.len()).filter(|p| (block.positions[*p][1] < 0.5) == lower).collect();
            let positions: Vec<_> = chosen.iter().map(|p| block.positions[*p]).collect();
            let volumes: Vec<_> = chosen.iter().map(|p| block.volumes[*p]).collect();
            let velocities = vec![[0.0; 2]; positions.len()];
            let samples = Samples { positions: &positions, velocities: &velocities, volumes: &volumes };
            simulation.add_body(NeoHookean::new(lame(young, 0.0)), DENSITY, samples).unwrap();
        }
        let report = simulation.equilibrate(&Equilibrium::default()).unwrap();
        let height = |from: f64, young: f64| {
            let parts = 1000;
            let part = 0.5 / f64::from(parts);
            let middle = |k: i32| from + part * (f64::from(k) + 0.5);
            (0..parts).map(|k| part * stretch(young, DENSITY * GRAVITY * (1.0 - middle(k)))).sum::<f64>()
        };
        let expected = height(0.0, below) + height(0.5, above);
        let (x, states) = (simulation.positions(1), simulation.states(1));
        let top = (0..x.len()).max_by(|a, b| x[*a][1].total_cmp(&x[*b][1])).unwrap();
        let found = x[top][1] + states[top].volume_ratio * 0.25 / cells as f64;
        println!("{below:e} below {above:e}: {found:.5} m, exact {expected:.5} m, {report:?}");
        assert!((found - expected).abs() < 5e-3, "{found} {expected}");
    }
}
