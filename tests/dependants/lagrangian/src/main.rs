//! A bar of rubber hangs from the ceiling by its end, and stretches in its weight.

use lagrangian::element::{DeadLoad, Mass, MassDistribution, Tetrahedra};
use lagrangian::mechanics_core::law::{Lame, StableNeoHookean};
use lagrangian::mechanics_core::mesh::{BoxSplit, Surface, block};
use lagrangian::mechanics_core::point_map::PointMap;
use lagrangian::mechanics_core::state::State;
use lagrangian::mechanics_core::tensor::Vec3;
use lagrangian::stepper::{Stepper, StepperOptions};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (length, density, young, g) = (0.4, 1000.0, 1e7, 9.81);
    // Poisson's ratio zero: the bar stays as thick as it is.
    let bar = block(&Vec3::zeros(), &Vec3::new(0.1, 0.1, length), [2, 2, 8], BoxSplit::Six)?;
    let law = StableNeoHookean::new(Lame::from_young_poisson(young, 0.0)?);
    let mut elastic = Tetrahedra::term("elastic", law, &bar)?;
    let mut mass = Mass::zeros(bar.points().len());
    mass.add_tetrahedra(bar.points(), bar.cells(), density, MassDistribution::Lumped)?;
    let mut weight = DeadLoad::gravity(&mass, &Vec3::new(0.0, 0.0, -g))?;

    let top: Vec<(u32, Vec3)> =
        (0..).zip(bar.points().iter().copied()).filter(|(_, x)| x.z > length - 1e-9).collect();
    let map = PointMap::with_fixed(bar.points().len(), &top)?;
    let mut stepper = Stepper::new(mass, map, StepperOptions::default());
    let mut state = State::at_rest(bar.points().to_vec());
    // Backward Euler with steps much longer than the bar's period: it comes to rest.
    for _ in 0..40 {
        stepper.step(&mut state, &mut [&mut elastic, &mut weight], 1.0)?;
    }
    // The mean over the triangles of the free end, all of one area.
    let surface = Surface::of_tets(&bar)?;
    let is_end = |triangle: &&[u32; 3]| triangle.iter().all(|&p| surface.points()[p as usize].z < 1e-9);
    let ends = surface.triangles().iter().filter(is_end).flatten();
    let ways: Vec<f64> =
        ends.map(|&p| -state.position[surface.source_points()[p as usize] as usize].z).collect();
    let stretch = ways.iter().sum::<f64>() / ways.len() as f64;
    let exact = 0.5 * density * g * length * length / young;
    println!("the free end is {stretch:.5e} m lower; ρ g L²/2E is {exact:.5e} m");
    assert!((stretch / exact - 1.0).abs() < 1e-3);
    Ok(())
}
