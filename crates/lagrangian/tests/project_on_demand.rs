//! Newton's method with Hessians projected on demand, in the stepper.

// In a test a panic is the report; the lint spares only functions marked as tests.
#![allow(clippy::unwrap_used)]
// The stepper needs the sparse solvers' feature.
#![cfg(feature = "bodies")]

use lagrangian::element::{Mass, MassDistribution, Tetrahedra};
use lagrangian::stepper::{StepReport, Stepper, StepperOptions};
use mechanics_core::law::{FixedCorotated, Hyperelastic, Lame, StableNeoHookean};
use mechanics_core::mesh::{BoxSplit, block};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::objective::Projecting;
use mechanics_core::point_map::PointMap;
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;

/// Twenty steps of a cube released crushed to a tenth of its height: the end, and what the steps took together.
fn release<L: Hyperelastic>(law: L, projecting: Projecting) -> (State, StepReport) {
    let mesh = block(&Vec3::zeros(), &Vec3::repeat(1.0), [3; 3], BoxSplit::Six).unwrap();
    let mut elastic = Tetrahedra::term("elastic", law, &mesh).unwrap();
    let mut mass = Mass::zeros(mesh.points().len());
    mass.add_tetrahedra(mesh.points(), mesh.cells(), 1000.0, MassDistribution::Lumped).unwrap();
    let newton = NewtonOptions { tolerance: 1e-7, max_iterations: 300, ..Default::default() };
    let options = StepperOptions { newton, projecting, ..Default::default() };
    let mut stepper = Stepper::new(mass, PointMap::identity(mesh.points().len()), options);
    let crushed = |x: &Vec3| Vec3::new(x.x, x.y, 0.1 * x.z);
    let mut state = State::at_rest(mesh.points().iter().map(crushed).collect());
    let mut total = StepReport::default();
    for _ in 0..20 {
        let report = stepper.step(&mut state, &mut [&mut elastic], 0.02).unwrap();
        total.newton.iterations += report.newton.iterations;
        total.newton.factorisations += report.newton.factorisations;
        total.newton.shifts += report.newton.shifts;
    }
    (state, total)
}

/// Elements are indefinite, their sum mostly is not: the true Hessian finds the same minima in fewer iterations and
/// factorisations.
#[test]
fn the_same_steps_take_fewer_iterations() {
    fn compare<L: Hyperelastic>(law: impl Fn() -> L) {
        let (always, slow) = release(law(), Projecting::Always);
        let (on_demand, fast) = release(law(), Projecting::OnDemand);
        for (a, b) in always.position.iter().zip(&on_demand.position) {
            assert!((a - b).norm() < 1e-7, "{a} {b}");
        }
        let (slow, fast) = (slow.newton, fast.newton);
        assert!(3 * fast.iterations < 2 * slow.iterations, "{} {}", fast.iterations, slow.iterations);
        assert!(4 * fast.factorisations < 3 * slow.factorisations);
        assert_eq!(fast.shifts, 0, "what is indefinite is projected, not shifted");
    }
    let lame = Lame::from_young_poisson(1e4, 0.4).unwrap();
    compare(|| StableNeoHookean::new(lame));
    compare(|| FixedCorotated::new(lame));
}
