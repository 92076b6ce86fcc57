//! Springs, attachments, pressure, dead loads, mass.

use crate::{Random, matrix};
use lagrangian::element::{
    Amplitude, Attachments, Border, DampingTerm, Dashpots, DeadLoad, ElementError, Inertia, Mass,
    MassDamping, MassDistribution, Pressure, Springs, StiffnessDamping, Tetrahedra,
};
use mechanics_core::derivatives::{check_potential_gradient, check_potential_hessian, check_stencil};
use mechanics_core::jet::Jet2;
use mechanics_core::law::{Lame, StableNeoHookean};
use mechanics_core::mesh::{BoxSplit, Surface, block, sphere};
use mechanics_core::potential::{Changed, Potential};
use mechanics_core::projection::Projection;
use mechanics_core::scalar::Scalar;
use mechanics_core::stage::{Coefficients, Moment, Scheme, Stage};
use mechanics_core::stencil::Stencil;
use mechanics_core::tensor::Vec3;
use nalgebra::SMatrix;

#[test]
fn derivatives_of_a_spring_are_those_of_automatic_differentiation() {
    let springs = Springs::new(vec![7.0, 7.0, 7.0], vec![0.5, 2.5, 0.0]).unwrap();
    let mut random = Random(5);
    for spring in 0..3 {
        let x = [random.vector(), random.vector()];
        check_stencil(&springs, spring, &x).require(1e-7).unwrap();
        let q = Jet2::<f64, 6>::variables(std::array::from_fn(|k| x[k / 3][k % 3]));
        let squared = (0..3).fold(Jet2::constant(0.0), |sum, k| sum + (q[3 + k] - q[k]).square());
        let rest = [0.5, 2.5, 0.0][spring];
        let energy = (squared.sqrt().offset(-rest)).square().scale(3.5);
        let h: SMatrix<f64, 6, 6> = matrix(&springs.hessian(spring, &x, Projection::None));
        for r in 0..6 {
            assert!((springs.gradient(spring, &x)[r / 3][r % 3] - energy.gradient[r]).abs() < 1e-13);
            for c in 0..6 {
                assert!((h[(r, c)] - energy.hessian(r, c)).abs() < 1e-13 * 7.0);
            }
        }
        // The eigenvalue projection of the whole matrix is the oracle for the closed form.
        let eigen = h.symmetric_eigen();
        for projection in [Projection::Clamp, Projection::Absolute] {
            let values = eigen.eigenvalues.map(|value| projection.apply(value));
            let oracle =
                eigen.eigenvectors * SMatrix::from_diagonal(&values) * eigen.eigenvectors.transpose();
            let ours: SMatrix<f64, 6, 6> = matrix(&springs.hessian(spring, &x, projection));
            assert!((ours - oracle).amax() < 1e-12, "{projection:?}");
        }
    }
    // A collapsed spring has finite derivatives.
    let point = [Vec3::new(1.0, 2.0, 3.0); 2];
    assert_eq!(springs.value(1, &point), 0.5 * 7.0 * 2.5 * 2.5);
    assert!(springs.gradient(1, &point).iter().flatten().all(|g| *g == 0.0));
    assert!(springs.hessian(1, &point, Projection::Clamp).iter().flatten().flatten().all(|h| h.is_finite()));
}

#[test]
fn bad_springs_are_refused_by_name() {
    let refused = |k: f64, l: f64| Springs::new(vec![1.0, k], vec![1.0, l]).unwrap_err();
    for k in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(refused(k, 1.0), ElementError::OutOfRange { quantity: "stiffness", index: 1, .. }));
    }
    for length in [-1.0, f64::NAN, f64::INFINITY] {
        let error = refused(1.0, length);
        assert!(matches!(error, ElementError::OutOfRange { quantity: "rest length", index: 1, .. }));
    }
    let points = [Vec3::zeros(), Vec3::x()];
    assert!(Springs::term("s", 1.0, &points, vec![[0, 2]]).is_err());
    assert!(Springs::term("s", 1.0, &points, vec![[1, 1]]).is_err());
    assert!(Attachments::term("a", 0.0, &[0], vec![Vec3::x()]).is_err());
}

/// Inside a closed surface the forces of a pressure are p times a third of the area vectors around each vertex; they and
/// their moments sum to nothing.
#[test]
fn pressure_pushes_along_the_normals() {
    let cube = block(&Vec3::repeat(5.0), &Vec3::repeat(6.0), [3, 3, 3], BoxSplit::Five).unwrap();
    let skin = Surface::of_tets(&cube).unwrap();
    let triangles: Vec<[u32; 3]> =
        skin.triangles().iter().map(|t| t.map(|i| skin.source_points()[i as usize])).collect();
    let p = 3.0;
    let pressure = Pressure::new("air", p, cube.points(), triangles.clone(), Border::None).unwrap();
    let mut random = Random(11);
    let x: Vec<Vec3> = cube.points().iter().map(|x| x + random.vector() * 0.05).collect();
    let mut gradient = vec![Vec3::zeros(); x.len()];
    pressure.add_gradient(&x, &mut gradient);
    let mut expected = vec![Vec3::zeros(); x.len()];
    for t in &triangles {
        let [a, b, c] = t.map(|i| x[i as usize]);
        let area = (b - a).cross(&(c - a)) * 0.5;
        t.iter().for_each(|&i| expected[i as usize] -= area * (p / 3.0));
    }
    for (ours, expected) in gradient.iter().zip(&expected) {
        assert!((ours - expected).norm() < 1e-13);
    }
    let total: Vec3 = gradient.iter().sum();
    let moment: Vec3 = gradient.iter().zip(&x).map(|(g, x)| x.cross(g)).sum();
    assert!(total.norm() < 1e-13 && moment.norm() < 1e-12, "{total} {moment}");
    check_potential_gradient(&pressure, &x).require(1e-7).unwrap();
    check_potential_hessian(&pressure, &x).require(1e-7).unwrap();
}

/// With an amplitude the pressure is that of the time that a step asks for.
#[test]
fn pressure_follows_its_amplitude() {
    let cube = block(&Vec3::zeros(), &Vec3::repeat(1.0), [1; 3], BoxSplit::Six).unwrap();
    let skin = Surface::of_tets(&cube).unwrap();
    let triangles: Vec<[u32; 3]> =
        skin.triangles().iter().map(|t| t.map(|i| skin.source_points()[i as usize])).collect();
    let new = || Pressure::new("air", 2.0, cube.points(), triangles.clone(), Border::None).unwrap();
    let gradient = |pressure: &Pressure| {
        let mut gradient = vec![Vec3::zeros(); cube.points().len()];
        pressure.add_gradient(cube.points(), &mut gradient);
        gradient
    };
    let full = gradient(&new());
    let mut growing = new().with_amplitude(Amplitude::Ramp);
    assert!(gradient(&growing).iter().all(|force| force.norm() == 0.0), "the ramp begins at zero");
    for time in [0.5, 0.25, 1.0] {
        let scheme = Scheme::statics(cube.points());
        let stage = Stage { moment: Moment::Step, x: cube.points(), time, step: 0.1, scheme };
        assert_eq!(growing.freeze(&stage).unwrap(), Changed::Energy);
        for (found, full) in gradient(&growing).iter().zip(&full) {
            assert!((found - full * time).norm() < 1e-15, "{time}: {found} {full}");
        }
    }
}

#[test]
fn pressure_needs_a_closed_surface_or_a_held_border() {
    let ball = sphere(1.0, 1).unwrap();
    let whole = ball.triangles().to_vec();
    let make = |triangles: Vec<[u32; 3]>, border| Pressure::new("air", 1.0, ball.points(), triangles, border);
    assert!(make(whole.clone(), Border::None).is_ok());
    let open = whole[1..].to_vec();
    let error = make(open.clone(), Border::None).unwrap_err();
    let edge = |from: u32, to: u32| (0..3).any(|k| (whole[0][(k + 1) % 3], whole[0][k]) == (from, to));
    assert!(
        matches!(error, ElementError::NotClosed { from, to, forward: 1, backward: 0 } if edge(from, to)),
        "{error}"
    );
    assert!(make(open.clone(), Border::Held).is_ok());
    let mut flipped = whole.clone();
    flipped[3].swap(0, 1);
    assert!(matches!(make(flipped, Border::Held).unwrap_err(), ElementError::NotClosed { forward: 2, .. }));
    let mut doubled = whole;
    doubled.push(open[0]);
    let error = make(doubled, Border::None).unwrap_err();
    assert!(
        matches!(error, ElementError::NotClosed { forward, backward, .. } if forward.max(backward) == 2),
        "{error}"
    );
    assert!(Pressure::new("air", f64::NAN, ball.points(), open, Border::Held).is_err());
}

/// Everything that is kept over a step, with random x̃ and x̂: its gradient is that of its value, its Hessian that of its
/// gradient.
#[test]
fn terms_of_a_step_have_the_derivatives_of_their_values() {
    let mesh = block(&Vec3::zeros(), &Vec3::new(1.0, 2.0, 0.5), [1, 2, 1], BoxSplit::Five).unwrap();
    let n = mesh.points().len();
    let mut random = Random(31);
    let mut moved =
        |by: f64| -> Vec<Vec3> { mesh.points().iter().map(|x| x + random.vector() * by).collect() };
    let (x, start, target, origin) = (moved(0.2), moved(0.1), moved(0.3), moved(0.3));
    let mut mass = Mass::zeros(n);
    mass.add_tetrahedra(mesh.points(), mesh.cells(), 3.0, MassDistribution::Consistent).unwrap();
    let law = StableNeoHookean::new(Lame::from_young_poisson(10.0, 0.3).unwrap());
    let elements = Tetrahedra::new(law, mesh.points(), mesh.cells()).unwrap();
    let proportional = StiffnessDamping::new(elements, 0.3).unwrap();
    let dashpots = Dashpots::new(vec![2.0, 0.0, 5.0]).unwrap();
    let pairs = vec![[0, 5], [1, 2], [7, 3]];
    let targets = vec![Vec3::x(), Vec3::y()];
    let mut terms: [Box<dyn Potential>; 6] = [
        Box::new(Inertia::new(mass.clone())),
        Box::new(MassDamping::new(mass.clone(), 0.7).unwrap()),
        Box::new(DampingTerm::new("stiffness damping", proportional, mesh.cells().to_vec()).unwrap()),
        Box::new(DampingTerm::new("dashpots", dashpots, pairs).unwrap()),
        Box::new(Attachments::term("attachments", 4.0, &[2, 6], targets).unwrap()),
        Box::new(DeadLoad::gravity(&mass, &Vec3::new(1.0, 2.0, 3.0)).unwrap()),
    ];
    let scheme = Scheme::new(Coefficients::backward_euler(0.1), &target, &origin);
    let stage = Stage { moment: Moment::Step, x: &start, time: 0.1, step: 0.1, scheme };
    for term in &mut terms {
        let _: Changed = term.freeze(&stage).unwrap();
        check_potential_gradient(term.as_ref(), &x).require(1e-7).unwrap();
        check_potential_hessian(term.as_ref(), &x).require(1e-7).unwrap();
        if term.name().contains("damp") || term.name().contains("dashpots") {
            assert!(term.value(&x) > 0.0, "dissipation is positive");
            assert!(term.value(&origin).abs() < 1e-20, "and nothing at no velocity");
        }
    }
    // In statics there is neither inertia nor damping.
    let statics = Stage { step: 0.0, scheme: Scheme::statics(&start), ..stage };
    for term in &mut terms[..4] {
        let _: Changed = term.freeze(&statics).unwrap();
        assert_eq!(term.value(&x), 0.0, "{}", term.name());
    }
}

#[test]
fn amplitudes_interpolate() {
    let table = Amplitude::Table(vec![(1.0, 2.0), (2.0, 4.0), (4.0, 0.0)]);
    for (time, factor) in [(0.0, 2.0), (1.0, 2.0), (1.5, 3.0), (2.0, 4.0), (3.0, 2.0), (9.0, 0.0)] {
        assert_eq!(table.at(time), factor);
    }
    assert_eq!(Amplitude::Ramp.at(0.25), 0.25);
    assert_eq!(Amplitude::Ramp.at(7.0), 1.0);
    assert_eq!(Amplitude::Table(Vec::new()).at(1.0), 0.0);
    assert!(DeadLoad::new("f", vec![(3, Vec3::new(0.0, f64::NAN, 0.0))]).is_err());
}

#[test]
fn lumped_and_consistent_mass_hold_the_same_momenta() {
    let mesh = block(&Vec3::zeros(), &Vec3::new(1.0, 2.0, 0.5), [3, 2, 2], BoxSplit::Five).unwrap();
    let mut random = Random(2);
    let v: Vec<Vec3> = mesh.points().iter().map(|_| random.vector()).collect();
    let mass = |distribution| {
        let mut mass = Mass::zeros(mesh.points().len());
        mass.add_tetrahedra(mesh.points(), mesh.cells(), 800.0, distribution).unwrap();
        mass
    };
    let (lumped, consistent) = (mass(MassDistribution::Lumped), mass(MassDistribution::Consistent));
    assert_eq!(lumped.distribution(), MassDistribution::Lumped);
    assert_eq!(consistent.distribution(), MassDistribution::Consistent);
    for mass in [&lumped, &consistent] {
        assert!((mass.total() - 800.0).abs() < 1e-10, "the box is 1 m³ at 800 kg/m³");
    }
    assert!((lumped.linear_momentum(&v) - consistent.linear_momentum(&v)).norm() < 1e-10);
    // The kinetic energy of v = ω × x in a box of sides a, b, c: ½ ω² m (b² + c²)/12 about the axis along a through
    // the centre, exact for consistent mass, since v is linear.
    let centre = Vec3::new(0.5, 1.0, 0.25);
    let spin = |x: &Vec3| Vec3::x().cross(&(x - centre)) * 3.0;
    let v: Vec<Vec3> = mesh.points().iter().map(spin).collect();
    let exact = 0.5 * 9.0 * 800.0 * (4.0 + 0.25) / 12.0;
    assert!((consistent.kinetic_energy(&v) - exact).abs() < 1e-11 * exact);
    assert!(lumped.kinetic_energy(&v) > 1.05 * exact, "lumping moves mass outwards");
    let about = consistent.angular_momentum(mesh.points(), &v, &centre);
    assert!((about - Vec3::x() * (2.0 * exact / 3.0)).norm() < 1e-10 * exact, "L = I ω");
}
