//! A block on an incline: a = g (sin θ − μ cos θ) where it slides, nothing where μ > tan θ.

use crate::ladder::Cloud;
use mechanics_core::law::Lame;
use mpm_constitutive::elastic::FixedCorotated;
use mpm_core::{Boundary, Kernel, Samples, Shape, Simulation, SimulationOptions, Surface, Transfer};

const GRAVITY: f64 = 9.81;

/// The way \[m\] along the incline in 1 s, and in its last fifth, of the middle of a block of 1 m × 0.5 m.
fn slide(degrees: f64, surface: Surface) -> (f64, f64) {
    let spacing = 0.125;
    let options = SimulationOptions { spacing, kernel: Kernel::Quadratic, transfer: Transfer::MlsApic };
    let mut simulation = Simulation::<f64, 2>::new(options).unwrap();
    let (sine, cosine) = degrees.to_radians().sin_cos();
    simulation.set_gravity([GRAVITY * sine, -GRAVITY * cosine]).unwrap();
    let floor = Shape::HalfSpace { point: [0.0; 2], normal: [0.0, 1.0] };
    simulation.add_boundary(Boundary::at_rest(floor, surface)).unwrap();
    let cloud = Cloud::rectangle([0.0; 2], [1.0, 0.5], [16, 8]);
    let velocities = vec![[0.0; 2]; cloud.points.len()];
    let samples = Samples { positions: &cloud.points, velocities: &velocities, volumes: &cloud.volumes };
    let law = FixedCorotated::new(Lame::from_young_poisson(1e6, 0.3).unwrap());
    simulation.add_body(law, 1000.0, samples).unwrap();
    let middle = |simulation: &Simulation<f64, 2>| {
        simulation.positions(0).iter().map(|x| x[0]).sum::<f64>() / cloud.points.len() as f64
    };
    let start = middle(&simulation);
    simulation.advance(0.8).unwrap();
    let late = middle(&simulation);
    simulation.advance(0.2).unwrap();
    let end = middle(&simulation);
    (end - start, end - late)
}

#[test]
fn blocks_slide_as_coulomb_says() {
    for (degrees, surface, acceleration) in [
        (30.0, Surface::Slip, 0.5 * GRAVITY),
        (30.0, Surface::Friction(0.2), 3.205_858),
        (30.0, Surface::Friction(0.4), 1.506_716),
        (45.0, Surface::Friction(0.5), 3.468_359),
    ] {
        let (way, _) = slide(degrees, surface);
        let error = way / (0.5 * acceleration) - 1.0;
        println!("{degrees}°, {surface:?}: {way:.6} m in 1 s, {error:+.1e}");
        assert!(error.abs() < 5e-3, "{degrees}°, {surface:?}: {way} m");
    }
    for surface in [Surface::Friction(0.6), Surface::Sticky] {
        let (way, last) = slide(30.0, surface);
        println!("30°, {surface:?}: {way:.2e} m in 1 s, {last:.2e} m in the last fifth");
        // Sheared by its own weight, ρ g sin θ H²/2G over three, by some 5e-4 m, and no further.
        assert!(way < 2e-3 && last.abs() < 2e-4, "30°, {surface:?}: {way} m, {last} m");
    }
}
