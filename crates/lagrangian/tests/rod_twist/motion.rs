//! Rods that move: what is kept, and how fast.

use crate::samples::{SECTION, orders};
use crate::statics::Body;
use lagrangian::element::Mass;
use lagrangian::stepper::{Stepper, StepperOptions, TimeScheme};
use mechanics_core::mesh::{PolylineEnds, TriMesh, polyline};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::point_map::PointMap;
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;

const POINTS: usize = 7;

fn arc() -> TriMesh {
    let at = |i: usize| Vec3::new((0.35 * i as f64).cos(), (0.35 * i as f64).sin(), 0.1 * (i as f64).sin());
    polyline((0..POINTS).map(at).collect(), PolylineEnds::Open).unwrap()
}

/// A free, bent and twisted rod let go: the energy relative to the start, the momentum, and Σ x × mv + Σ ∫ t d(rm u̇), which the balance
/// of forces and torques keeps.
fn released(steps: u32) -> [f64; 3] {
    let mesh = arc();
    let Body { mut stretching, mut bending, mut twist, mut x } = Body::new(&mesh, 40.0, 0.3, SECTION);
    for (k, j) in twist.turns().enumerate() {
        x[j as usize] = twist.turn(1.5 * (k as f64 / 5.0).powi(2));
    }
    let mut mass = Mass::zeros(x.len());
    (0..POINTS as u32).for_each(|i| mass.add_point(i, 0.35).unwrap());
    twist.add_mass(&mut mass, &mesh, 1.0).unwrap();
    let newton = NewtonOptions { tolerance: 1e-11, ..NewtonOptions::default() };
    let options =
        StepperOptions { scheme: TimeScheme::ImplicitMidpoint, newton, ..StepperOptions::default() };
    let mut stepper = Stepper::new(mass, PointMap::identity(x.len()), options);
    let mut state = State::at_rest(x.clone());
    let mut spin = Vec3::zeros();
    let start = stretching_energy(&stretching, &bending, &twist, &x);
    for _ in 0..steps {
        let before = state.clone();
        stepper
            .step(&mut state, &mut [&mut stretching, &mut bending, &mut twist], 0.5 / f64::from(steps))
            .unwrap();
        for (j, &[a, b]) in twist.turns().zip(mesh.free_edges()) {
            let (a, b, j) = (a as usize, b as usize, j as usize);
            let middle =
                (state.position[b] + before.position[b] - state.position[a] - before.position[a]).normalize();
            let gained = (state.velocity[j] - before.velocity[j]).x * stepper.mass().diagonal()[j];
            spin += middle * (gained * SECTION.gyration_radius);
        }
    }
    twist.transport_to(&state.position).unwrap();
    let (x, v) = (&state.position, &state.velocity);
    let end = stretching_energy(&stretching, &bending, &twist, x) + stepper.mass().kinetic_energy(v);
    let masses = &stepper.mass().diagonal()[..POINTS];
    let momentum: Vec3 = masses.iter().zip(v).map(|(m, v)| v * *m).sum();
    let orbital: Vec3 = masses.iter().zip(x).zip(v).map(|((m, x), v)| x.cross(v) * *m).sum();
    assert!(orbital.norm() > 1e-3, "it turns one way and spins the other");
    [(end / start - 1.0).abs(), momentum.norm(), (orbital + spin).norm()]
}

fn stretching_energy(
    stretching: &dyn mechanics_core::potential::Potential,
    bending: &dyn mechanics_core::potential::Potential,
    twist: &dyn mechanics_core::potential::Potential,
    x: &[Vec3],
) -> f64 {
    stretching.value(x) + bending.value(x) + twist.value(x)
}

#[test]
fn momentum_is_kept_and_moments_balance() {
    let found = [100, 200, 400].map(released);
    for k in [0, 2] {
        let errors = found.map(|f| f[k]);
        println!("{}: {errors:?}, orders {:?}", ["energy", "", "angular momentum"][k], orders(&errors));
    }
    assert!(found.iter().all(|f| f[1] < 1e-10), "{found:?}");
    assert!(found[2][0] < 1e-2 && found[2][2] < 1e-2);
    assert!(orders(&found.map(|f| f[2])).iter().all(|order| *order > 0.85));
}
