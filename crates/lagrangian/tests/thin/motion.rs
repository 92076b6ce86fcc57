//! Thin bodies in motion: eigenfrequencies, and cloth with the implicit stepper.

use crate::samples::{number, orders, reference};
use lagrangian::element::hinge::RestAngle;
use lagrangian::element::membrane::{Membranes, NeoHookeanSheet};
use lagrangian::element::plate::PlateBending;
use lagrangian::element::rod::{RodBending, RodStretching};
use lagrangian::element::strain_limit::StrainLimits;
use lagrangian::element::{DeadLoad, Mass, MassDistribution};
use lagrangian::stepper::{StepError, Stepper, StepperOptions, TimeScheme};
use mechanics_core::mesh::{Diagonals, rod, sheet};
use mechanics_core::point_map::PointMap;
use mechanics_core::potential::Potential;
use mechanics_core::projection::Projection;
use mechanics_core::state::State;
use mechanics_core::stencil::Stencil;
use mechanics_core::tensor::Vec3;
use nalgebra::DMatrix;

/// Lowest eigenfrequencies of a clamped rod of length 1, EI = 1, mass 1 a length, across the rod: √ of the eigenvalues of
/// M^(−1/2) H M^(−1/2), masses lumped.
fn cantilever_frequencies(n: u32, count: usize) -> Vec<f64> {
    let h = 1.0 / (f64::from(n) - 0.5);
    let mesh = rod(&Vec3::new(-0.5 * h, 0.0, 0.0), &Vec3::x(), n).unwrap();
    let bending = RodBending::new(&mesh, 1.0).unwrap();
    let size = n as usize - 1;
    let mass = |i: usize| if i + 1 == size { 0.5 * h } else { h };
    let mut matrix = DMatrix::<f64>::zeros(size, size);
    for (joint, points) in bending.points().iter().enumerate() {
        let block = bending.hessian(joint, &points.map(|i| mesh.points()[i as usize]), Projection::None);
        for (a, &i) in points.iter().enumerate() {
            for (b, &j) in points.iter().enumerate() {
                if i >= 2 && j >= 2 {
                    let (i, j) = (i as usize - 2, j as usize - 2);
                    matrix[(i, j)] += block[a][b][(2, 2)] / (mass(i) * mass(j)).sqrt();
                }
            }
        }
    }
    let mut values: Vec<f64> = matrix.symmetric_eigenvalues().iter().map(|value| value.sqrt()).collect();
    values.sort_by(f64::total_cmp);
    values.truncate(count);
    values
}

#[test]
fn a_clamped_rod_vibrates_as_a_beam_does() {
    let reference = reference();
    let exact: Vec<f64> = reference["beam_cantilever_betaL"].as_array().unwrap()[..3]
        .iter()
        .map(|root| number(root).powi(2))
        .collect();
    let found: Vec<Vec<f64>> = [20, 40, 80].into_iter().map(|n| cantilever_frequencies(n, 3)).collect();
    for mode in 0..3 {
        let errors: Vec<f64> = found.iter().map(|f| f[mode] / exact[mode] - 1.0).collect();
        println!("beam mode {mode}: errors {errors:?}, orders {:?}", orders(&errors));
        assert!(orders(&errors).iter().all(|order| (order - 2.0).abs() < 0.15));
        assert!(errors[2].abs() < 2e-3);
    }
}

/// A square cloth pinned at one corner falls and swings for 12 s at h = 0.04 s. Backward Euler's step minimises
/// Φ + ½‖x − x̃‖²_M/h², so Φ₁ + ½‖v₁ − v₀‖²_M ≤ Φ₀ + ½‖v₀‖²_M with all potentials, the limit's too, in Φ; and no stretch
/// passes the limit.
#[test]
fn a_cloth_pinned_at_a_corner_swings_within_its_limits() {
    let mesh = sheet([1.0, 1.0], [8, 8], Diagonals::Alternating).unwrap();
    let (young, poisson, thickness, density) = (1e5, 0.3, 1e-3, 300.0);
    let law = NeoHookeanSheet::new(young, poisson).unwrap();
    let mut membrane = Membranes::term("membrane", &mesh, law, thickness).unwrap();
    let mut bending =
        PlateBending::new("bending", &mesh, young, poisson, thickness, RestAngle::Flat).unwrap();
    let mut limits = StrainLimits::term("limit", &mesh, [1.05, 1.15], 1e5, thickness).unwrap();
    let mut mass = Mass::zeros(mesh.points().len());
    let local = |t: usize| membrane.stencil().local_mass(t, density);
    mass.add_elements(mesh.triangles(), MassDistribution::Lumped, local).unwrap();
    assert!((mass.total() - 0.3).abs() < 1e-15);
    let mut gravity = DeadLoad::gravity(&mass, &Vec3::new(0.0, 0.0, -9.81)).unwrap();
    let map = PointMap::with_fixed(mesh.points().len(), &[(0, Vec3::zeros())]).unwrap();
    let mut stepper = Stepper::new(mass.clone(), map.clone(), StepperOptions::default());
    let mut state = State::at_rest(mesh.points().to_vec());
    let kinetic =
        |v: &[Vec3]| -> f64 { v.iter().zip(mass.diagonal()).map(|(v, m)| 0.5 * m * v.norm_squared()).sum() };
    let (mut iterations, mut most) = (0, 0);
    for _ in 0..300 {
        let terms: [&dyn Potential; 4] = [&membrane, &bending, &limits, &gravity];
        let before: f64 = terms.iter().map(|term| term.value(&state.position)).sum();
        let (before, v0) = (before + kinetic(&state.velocity), state.velocity.clone());
        let report = stepper
            .step(&mut state, &mut [&mut membrane, &mut bending, &mut limits, &mut gravity], 0.04)
            .unwrap();
        let terms: [&dyn Potential; 4] = [&membrane, &bending, &limits, &gravity];
        let after: f64 = terms.iter().map(|term| term.value(&state.position)).sum();
        let change: Vec<Vec3> = state.velocity.iter().zip(&v0).map(|(a, b)| a - b).collect();
        assert!(after + kinetic(&change) <= before + 1e-9, "{after} {before}");
        iterations += report.newton.iterations;
        most = most.max(report.newton.iterations);
        for (t, points) in mesh.triangles().iter().enumerate() {
            assert!(limits.stencil().largest_stretch(t, &points.map(|i| state.position[i as usize])) < 1.15);
        }
    }
    println!("corner-pinned cloth: {} iterations a step, at most {most}", iterations as f64 / 300.0);
    // It swings, damped, about where it will hang: below its corner, the far corner nearly a diagonal away.
    let far = state.position[80];
    assert!(far.z < -1.2 && far.norm() > 1.3, "{far}");

    // A barrier guards the ends of steps only where they are what is minimised over.
    let options = StepperOptions { scheme: TimeScheme::ImplicitMidpoint, ..StepperOptions::default() };
    let mut midpoint = Stepper::new(mass, map, options);
    let error = midpoint.step(&mut state, &mut [&mut limits], 0.04).unwrap_err();
    assert!(matches!(error, StepError::MidpointWithBarrier { .. }), "{error}");
}

/// The mass of rods is that of their edges.
#[test]
fn rods_and_sheets_have_the_mass_of_their_rest_shape() {
    let mesh = rod(&Vec3::zeros(), &(Vec3::y() * 3.0), 7).unwrap();
    let stretching = RodStretching::new(&mesh, 1.0).unwrap();
    for distribution in [MassDistribution::Lumped, MassDistribution::Consistent] {
        let mut mass = Mass::zeros(mesh.points().len());
        mass.add_elements(mesh.free_edges(), distribution, |e| stretching.local_mass(e, 0.2)).unwrap();
        assert!((mass.total() - 0.6).abs() < 1e-15);
    }
}
