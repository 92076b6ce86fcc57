//! Rods, strain limits, plates: derivatives, symmetries, hard inputs; and what is refused.

use crate::samples::{Random, dead_forces, equilibrium, relative_lowest};
use lagrangian::element::ThinError;
use lagrangian::element::hinge::{Hinges, RestAngle, flexural_rigidity, hinges_of};
use lagrangian::element::membrane::{
    Membranes, NeoHookeanSheet, OrthotropicSheet, SaintVenantKirchhoffSheet,
};
use lagrangian::element::plate::PlateBending;
use lagrangian::element::rod::{RodBending, RodSection, RodStretching};
use lagrangian::element::strain_limit::StrainLimits;
use mechanics_core::derivatives::{check_potential_gradient, check_potential_hessian, check_stencil};
use mechanics_core::jet::Jet2;
use mechanics_core::law::LawError;
use mechanics_core::mesh::{Diagonals, MeshError, PolylineEnds, TriMesh, polyline, sheet, sphere};
use mechanics_core::potential::{Potential, PotentialError};
use mechanics_core::projection::Projection;
use mechanics_core::scalar::Scalar;
use mechanics_core::stencil::{Stencil, StencilTerm};
use mechanics_core::tensor::{Mat3, Vec3, dot};

fn bent(points: &[Vec3]) -> TriMesh {
    polyline(points.to_vec(), PolylineEnds::Open).unwrap()
}

/// 4 tan²(φ/2) = 4 (1 − c)/(1 + c), c from the edges.
fn turn_energy<S: Scalar>(x: &[S; 9]) -> S {
    let edge = |k: usize| [0, 1, 2].map(|i| x[3 * (k + 1) + i] - x[3 * k + i]);
    let (a, b) = (edge(0), edge(1));
    let c = dot(&a, &b) / (dot(&a, &a) * dot(&b, &b)).sqrt();
    let one = S::constant(1.0);
    ((one - c) / (one + c)).scale(2.0)
}

#[test]
fn rods_agree_with_automatic_differentiation_and_project_to_semi_definite() {
    let mut random = Random(21);
    for round in 0..40 {
        let rest = [Vec3::zeros(), Vec3::x() * 1.3, Vec3::x() * 2.0];
        let rod = RodBending::new(&bent(&rest), 1.0).unwrap();
        let size = [0.01, 0.2, 0.8][round % 3];
        let x = rest.map(|x| x + random.vector() * size);
        let jet = turn_energy(&Jet2::<f64, 9>::variables(std::array::from_fn(|k| x[k / 3][k % 3])));
        let scale = jet.hessian_matrix().as_flattened().iter().fold(0.0_f64, |m, h| m.max(h.abs()));
        let (gradient, hessian) = (rod.gradient(0, &x), rod.hessian(0, &x, Projection::None));
        assert!((rod.value(0, &x) - jet.value).abs() < 1e-14 * (1.0 + jet.value));
        for k in 0..9 {
            assert!((gradient[k / 3][k % 3] - jet.gradient[k]).abs() < 1e-13 * scale);
            for l in 0..9 {
                assert!((hessian[k / 3][l / 3][(k % 3, l % 3)] - jet.hessian(k, l)).abs() < 1e-12 * scale);
            }
        }
        for projection in [Projection::Clamp, Projection::Absolute] {
            assert!(relative_lowest(&rod.hessian(0, &x, projection)) > -1e-14);
        }
        let stretching = RodStretching::new(&bent(&rest), 5.0).unwrap();
        check_stencil(&stretching, 0, &[x[0], x[1]]).require(1e-7).unwrap();
        assert!(relative_lowest(&stretching.hessian(0, &[x[0], x[1]], Projection::Clamp)) > -1e-14);
        // Rigid motions.
        let (turn, shift) = (random.rotation(), random.vector());
        let moved = x.map(|x| turn * x + shift);
        assert!((rod.value(0, &x) - rod.value(0, &moved)).abs() < 1e-12 * (1.0 + jet.value));
        let forces = rod.gradient(0, &x);
        assert!(forces.iter().sum::<Vec3>().norm() < 1e-13 * scale);
        assert!(forces.iter().zip(&x).map(|(f, x)| x.cross(f)).sum::<Vec3>().norm() < 1e-13 * scale);
    }
}

/// Tiny angles keep their relative accuracy; folded and collapsed joints are defined.
#[test]
fn rod_joints_are_accurate_for_tiny_angles_and_defined_when_degenerate() {
    let rest = [Vec3::zeros(), Vec3::x(), Vec3::x() * 2.0];
    let rod = RodBending::new(&bent(&rest), 1.0).unwrap();
    for angle in [1e-12, 1e-6, 1e-2, 1.0, 3.0] {
        let (s, c) = f64::sin_cos(angle);
        let x = [rest[0], rest[1], Vec3::new(1.0 + c, s, 0.0)];
        let expected = 2.0 * (0.5 * angle).tan().powi(2);
        assert!((rod.value(0, &x) / expected - 1.0).abs() < 1e-13 / (1.0 + c), "{angle}");
    }
    let folded = [rest[0], rest[1], rest[0]];
    assert_eq!(rod.value(0, &folded), f64::INFINITY);
    let collapsed = [rest[0], rest[0], rest[1]];
    assert_eq!((rod.value(0, &collapsed), rod.gradient(0, &collapsed)), (0.0, [Vec3::zeros(); 3]));
    let stretching = RodStretching::new(&bent(&rest), 5.0).unwrap();
    assert_eq!(stretching.value(0, &[rest[0], rest[0]]), 2.5);
    assert_eq!(stretching.gradient(0, &[rest[0], rest[0]]), [Vec3::zeros(); 2]);
    assert!(
        stretching.hessian(0, &[rest[0], rest[0]], Projection::Clamp)[0][0].iter().all(|h| h.is_finite())
    );
}

fn one_triangle() -> TriMesh {
    TriMesh::new(vec![Vec3::zeros(), Vec3::x(), Vec3::new(0.2, 0.9, 0.0)], vec![[0, 1, 2]]).unwrap()
}

#[test]
fn strain_limits_pass_the_derivative_checker_and_are_convex() {
    let mesh = one_triangle();
    let limits = StrainLimits::new(&mesh, [1.05, 1.4], 3.0, 0.1).unwrap();
    let mut random = Random(22);
    let mut checked = 0;
    for _ in 0..200 {
        let map = Mat3::identity() * 1.15 + Mat3::from_fn(|_, _| 0.25 * random.number());
        let x: [Vec3; 3] = std::array::from_fn(|i| map * mesh.points()[i]);
        let stretch = limits.largest_stretch(0, &x);
        if !(1.08..1.38).contains(&stretch) {
            continue;
        }
        checked += 1;
        check_stencil(&limits, 0, &x).require(2e-6).unwrap_or_else(|e| panic!("{stretch}: {e}"));
        assert!(relative_lowest(&limits.hessian(0, &x, Projection::None)) > -1e-13);
    }
    assert!(checked > 40);
    // Equal stretches.
    let x: [Vec3; 3] = std::array::from_fn(|i| mesh.points()[i] * 1.2);
    check_stencil(&limits, 0, &x).require(1e-6).unwrap();
    // Below the beginning there is nothing; beyond the limit everything.
    let scaled = |s: f64| -> [Vec3; 3] { std::array::from_fn(|i| mesh.points()[i] * s) };
    assert_eq!(limits.value(0, &scaled(1.05)), 0.0);
    assert_eq!(limits.value(0, &scaled(1.4)), f64::INFINITY);
}

#[test]
fn limited_steps_stay_below_the_largest_stretch_and_use_most_of_the_way() {
    let mesh = one_triangle();
    let limits = StrainLimits::new(&mesh, [1.0, 1.3], 3.0, 0.1).unwrap();
    let mut random = Random(23);
    for _ in 0..500 {
        let x: [Vec3; 3] = std::array::from_fn(|i| mesh.points()[i] + random.vector() * 0.05);
        if limits.largest_stretch(0, &x) >= 1.3 {
            continue;
        }
        let size = 10.0_f64.powf(5.0 * random.number());
        let p: [Vec3; 3] = std::array::from_fn(|_| random.vector() * size);
        let fraction = limits.limit_step(0, &x, &p);
        let at = |fraction: f64| limits.largest_stretch(0, &std::array::from_fn(|i| x[i] + p[i] * fraction));
        assert!(fraction > 0.0 && at(fraction) < 1.3, "{fraction}");
        assert!(limits.value(0, &std::array::from_fn(|i| x[i] + p[i] * fraction)).is_finite());
        if fraction < 1.0 {
            // By bisection along the way: the true crossing is at most 1/0.88 further.
            assert!(at(fraction / 0.88) >= 1.3, "too timid");
        }
    }
}

/// A soft sheet pulled far beyond its limit stops short of it.
#[test]
fn a_limited_sheet_does_not_stretch_beyond_its_limit() {
    let mesh = sheet([1.0, 0.5], [6, 3], Diagonals::Crossed).unwrap();
    let law = NeoHookeanSheet::new(1e3, 0.3).unwrap();
    let mut membrane = Membranes::term("membrane", &mesh, law, 1e-3).unwrap();
    let mut limits = StrainLimits::term("limit", &mesh, [1.05, 1.1], 1e3, 1e-3).unwrap();
    let held: Vec<u32> = (0..4).map(|j| 7 * j).collect();
    let mut forces = vec![Vec3::zeros(); mesh.points().len()];
    (0..4).for_each(|j| forces[7 * j + 6].x = 1.0);
    let mut load = dead_forces(forces);
    let mut x = mesh.points().to_vec();
    equilibrium(&mut x, &held, &mut [&mut membrane, &mut limits, &mut load], 1e-9).unwrap();
    let largest = (0..mesh.triangles().len())
        .map(|t| limits.stencil().largest_stretch(t, &mesh.triangles()[t].map(|i| x[i as usize])))
        .fold(0.0, f64::max);
    assert!(largest < 1.1 && largest > 1.06, "{largest}");
    let mut free = mesh.points().to_vec();
    equilibrium(&mut free, &held, &mut [&mut membrane, &mut load], 1e-9).unwrap();
    assert!(free[6].x > 2.0, "without a limit it goes to {}", free[6].x);
    // A start beyond the limit is refused with its triangle.
    let mut beyond = free.clone();
    let error = equilibrium(&mut beyond, &held, &mut [&mut limits, &mut load], 1e-9).unwrap_err();
    assert!(error.to_string().contains("limit: the energy of element"), "{error}");
    assert_eq!(beyond, free);
}

fn wavy() -> TriMesh {
    let mut mesh = sheet([1.0, 1.0], [3, 3], Diagonals::Alternating).unwrap();
    mesh.map_points(|p| p + Vec3::new(0.03 * (9.0 * p.y).sin(), 0.0, 0.1 * (4.0 * p.x + p.y).sin())).unwrap();
    mesh
}

#[test]
fn plates_pass_the_derivative_checker() {
    let mut random = Random(24);
    for rest_angle in [RestAngle::OfMesh, RestAngle::Flat] {
        for mesh in [wavy(), sphere(1.0, 1).unwrap(), pyramid()] {
            let plate = PlateBending::new("plate", &mesh, 10.0, 0.3, 0.2, rest_angle).unwrap();
            let x: Vec<Vec3> = mesh.points().iter().map(|p| p + random.vector() * 0.05).collect();
            check_potential_gradient(&plate, &x).require(1e-7).unwrap();
            check_potential_hessian(&plate, &x).require(1e-6).unwrap();
            let (turn, shift) = (random.rotation(), random.vector());
            let moved: Vec<Vec3> = x.iter().map(|x| turn * x + shift).collect();
            assert!((plate.value(&x) - plate.value(&moved)).abs() < 1e-12 * plate.value(&x));
        }
    }
}

/// A point of three triangles: neighbours of a triangle share their far corner.
fn pyramid() -> TriMesh {
    let points = vec![Vec3::x(), Vec3::y(), -Vec3::x() - Vec3::y(), Vec3::new(0.1, 0.1, 0.5)];
    TriMesh::new(points, vec![[0, 1, 3], [1, 2, 3], [2, 0, 3]]).unwrap()
}

/// Constant curvature K on a regular mesh: the energy a vertex' share of the interior stores is
/// ½D(tr²K − 2(1 − ν) det K), whatever K is. Measured as the second difference in the size of a patch, so that rims do not count.
#[test]
fn plates_store_the_energy_of_any_constant_curvature() {
    let (young, thickness) = (12.0, 0.1);
    let energy = |curvature: [f64; 3], poisson: f64, cells: u32| {
        let size = 1e-4;
        let side = size * f64::from(cells);
        let mesh = sheet([side, 1.5 * side], [cells, cells], Diagonals::Rising).unwrap();
        let plate = PlateBending::new("plate", &mesh, young, poisson, thickness, RestAngle::Flat).unwrap();
        let [xx, xy, yy] = curvature;
        let lift = |p: &Vec3| p + Vec3::z() * (0.5 * (xx * p.x * p.x + yy * p.y * p.y) + xy * p.x * p.y);
        let x: Vec<Vec3> = mesh.points().iter().map(lift).collect();
        plate.value(&x) / (1.5 * size * size)
    };
    for poisson in [-0.4, 0.0, 0.3] {
        let rigidity = flexural_rigidity(young, poisson, thickness).unwrap();
        for curvature in
            [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.5, 0.5, 0.5], [1.0, 0.0, 1.0], [0.3, -0.8, -0.6]]
        {
            let [xx, xy, yy] = curvature;
            let trace = xx + yy;
            let expected = 0.5 * rigidity * (trace * trace - 2.0 * (1.0 - poisson) * (xx * yy - xy * xy));
            let [a, b, c] = [4, 5, 6].map(|cells| energy(curvature, poisson, cells));
            let found = 0.5 * (a - 2.0 * b + c);
            assert!((found / expected - 1.0).abs() < 1e-5, "{curvature:?} {poisson}: {found} {expected}");
        }
    }
}

#[test]
fn hinges_store_the_energy_of_a_cylinder() {
    // Rectangles with the axis along an edge, as derived in the module's page.
    let (rigidity, radius) = (0.7, 1.0);
    let mesh = sheet([0.3, 0.2], [60, 3], Diagonals::Alternating).unwrap();
    let hinges = Hinges::new(&mesh, rigidity, RestAngle::Flat).unwrap();
    let roll =
        |p: &Vec3| Vec3::new(radius * (p.x / radius).sin(), p.y, radius * (1.0 - (p.x / radius).cos()));
    let x: Vec<Vec3> = mesh.points().iter().map(roll).collect();
    let energy: f64 =
        hinges.points().iter().enumerate().map(|(e, h)| hinges.value(e, &h.map(|i| x[i as usize]))).sum();
    // 59 of 60 cells: the rims fold nothing.
    let expected = 0.5 * rigidity * 0.3 * 0.2 * (59.0 / 60.0) / (radius * radius);
    assert!((energy / expected - 1.0).abs() < 1e-5, "{energy} {expected}");
}

#[test]
fn collapsed_sheets_have_no_bending_energy_and_no_force() {
    let mesh = wavy();
    let hinges = Hinges::new(&mesh, 1.0, RestAngle::Flat).unwrap().term("hinges").unwrap();
    let plate = PlateBending::new("plate", &mesh, 1.0, 0.3, 0.1, RestAngle::OfMesh).unwrap();
    let count = mesh.points().len();
    let line: Vec<Vec3> = mesh.points().iter().map(|p| Vec3::x() * p.x).collect();
    for x in [vec![Vec3::zeros(); count], line] {
        for term in [&hinges as &dyn Potential, &plate] {
            let mut gradient = vec![Vec3::zeros(); count];
            term.add_gradient(&x, &mut gradient);
            assert_eq!((term.value(&x), gradient), (0.0, vec![Vec3::zeros(); count]));
            assert!(term.diagnose(&x).is_none());
        }
    }
}

#[test]
fn rest_angles_can_be_those_of_the_mesh_flat_or_set() {
    let mesh = pyramid();
    let mut hinges = Hinges::new(&mesh, 1.0, RestAngle::OfMesh).unwrap();
    let at =
        |hinges: &Hinges, e: usize| hinges.value(e, &hinges.points()[e].map(|i| mesh.points()[i as usize]));
    assert_eq!(at(&hinges, 0), 0.0);
    hinges.set_rest_angle(0, 0.0).unwrap();
    let flat = Hinges::new(&mesh, 1.0, RestAngle::Flat).unwrap();
    assert!(at(&hinges, 0) > 0.0 && at(&hinges, 0) == at(&flat, 0));
    for angle in [3.2, f64::NAN] {
        assert!(matches!(hinges.set_rest_angle(0, angle), Err(ThinError::Parameter { .. })));
    }
}

#[test]
fn bad_parameters_are_refused_with_their_values() {
    let mesh = one_triangle();
    for young in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = NeoHookeanSheet::new(young, 0.3).unwrap_err();
        assert!(matches!(error, ThinError::Law(LawError::YoungModulus { .. })), "{error}");
        assert!(SaintVenantKirchhoffSheet::new(young, 0.3).is_err());
        assert!(flexural_rigidity(young, 0.3, 0.1).is_err());
        assert!(RodSection::circular(young, 0.1).is_err());
    }
    for poisson in [-1.0, 0.5, 0.7, f64::NAN] {
        let error = SaintVenantKirchhoffSheet::new(1.0, poisson).unwrap_err();
        assert!(matches!(error, ThinError::Law(LawError::PoissonRatio { .. })), "{error}");
        assert!(flexural_rigidity(1.0, poisson, 0.1).is_err());
    }
    let law = NeoHookeanSheet::new(1.0, 0.3).unwrap();
    for thickness in [0.0, -0.1, f64::NAN] {
        let error = Membranes::new(&mesh, law, thickness).unwrap_err();
        assert!(matches!(error, ThinError::Parameter { parameter: "the thickness", .. }), "{error}");
        assert!(StrainLimits::new(&mesh, [1.0, 1.1], 1.0, thickness).is_err());
    }
    assert_eq!(
        Membranes::new(&mesh, law, -0.1).unwrap_err().to_string(),
        "the thickness is -0.1; it must be positive and finite"
    );
    for stretches in [[0.9, 1.1], [1.1, 1.1], [1.0, f64::NAN]] {
        assert!(matches!(StrainLimits::new(&mesh, stretches, 1.0, 0.1), Err(ThinError::Parameter { .. })));
    }
    assert!(OrthotropicSheet::new([1.0, 1.0], 1.0, 1.0).is_err());
    assert!(OrthotropicSheet::new([1.0, 0.0], 0.1, 1.0).is_err());
    assert!(OrthotropicSheet::new([4.0, 1.0], 1.9, 1.0).is_ok());
    let fibres =
        Membranes::with_fibre(&mesh, OrthotropicSheet::new([4.0, 1.0], 0.1, 1.0).unwrap(), 0.1, &Vec3::z());
    assert!(matches!(fibres, Err(ThinError::FibreDirection { triangle: 0, .. })));
}

#[test]
fn bad_meshes_are_refused_with_the_culprit_named() {
    let law = NeoHookeanSheet::new(1.0, 0.3).unwrap();
    let points = vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::x() * 2.0, Vec3::z()];
    let flat = TriMesh::new(points.clone(), vec![[0, 1, 2], [0, 1, 3]]).unwrap();
    let error = Membranes::new(&flat, law, 0.1).unwrap_err();
    assert_eq!(error, ThinError::RestArea { triangle: 1, points: [0, 1, 3], area: 0.0 });
    let flat = TriMesh::new(points.clone(), vec![[0, 1, 2], [1, 0, 3]]).unwrap();
    assert!(matches!(Hinges::new(&flat, 1.0, RestAngle::Flat), Err(ThinError::RestArea { triangle: 1, .. })));
    let three = TriMesh::new(points.clone(), vec![[0, 1, 2], [1, 0, 4], [0, 1, 4]]).unwrap();
    let error = Hinges::new(&three, 1.0, RestAngle::Flat).unwrap_err();
    assert_eq!(error, ThinError::Mesh(MeshError::NonManifoldEdge { edge: [0, 1], count: 3 }));
    let opposed = TriMesh::new(points.clone(), vec![[0, 1, 2], [0, 1, 4]]).unwrap();
    assert!(matches!(hinges_of(&opposed), Err(MeshError::OpposedTriangles { edge: [0, 1], .. })));
    assert!(PlateBending::new("plate", &opposed, 1.0, 0.3, 0.1, RestAngle::Flat).is_err());
    let repeated = polyline(vec![Vec3::zeros(), Vec3::x(), Vec3::x()], PolylineEnds::Open).unwrap();
    let error = RodStretching::new(&repeated, 1.0).unwrap_err();
    assert_eq!(error, ThinError::RestLength { edge: 1, points: [1, 2], length: 0.0 });
    let branched = TriMesh::with_codimensional(points, vec![], vec![[0, 1], [0, 2], [0, 4]], vec![]).unwrap();
    assert_eq!(RodBending::new(&branched, 1.0).unwrap_err(), ThinError::Branch { point: 0, edges: 3 });
}

/// A neo-Hookean triangle without area is refused at a start, by number.
#[test]
fn a_collapsed_neo_hookean_triangle_is_named() {
    let mesh = wavy();
    let law = NeoHookeanSheet::new(1.0, 0.3).unwrap();
    let term = Membranes::term("sheet", &mesh, law, 0.1).unwrap();
    let mut x = mesh.points().to_vec();
    let [a, b, c] = mesh.triangles()[7];
    x[c as usize] = 0.5 * (x[a as usize] + x[b as usize]);
    let culprit = term.diagnose(&x);
    assert!(
        matches!(&culprit, Some(PotentialError::NonFinite { points, .. }) if points.contains(&c)),
        "{culprit:?}"
    );
}

/// Sums have the same bits for any number of threads.
#[test]
fn results_do_not_depend_on_threads() {
    let mesh = sheet([1.0, 1.0], [40, 40], Diagonals::Crossed).unwrap();
    let law = NeoHookeanSheet::new(1.0, 0.3).unwrap();
    let membrane = Membranes::new(&mesh, law, 0.1).unwrap();
    let membrane = StencilTerm::new("membrane", membrane, mesh.triangles().to_vec()).unwrap();
    let plate = PlateBending::new("plate", &mesh, 1.0, 0.3, 0.1, RestAngle::OfMesh).unwrap();
    let mut random = Random(25);
    let x: Vec<Vec3> = mesh.points().iter().map(|p| p + random.vector() * 0.003).collect();
    let run = |threads| {
        mechanics_core::parallel::with_threads(threads, || {
            let mut gradient = vec![Vec3::zeros(); x.len()];
            membrane.add_gradient(&x, &mut gradient);
            plate.add_gradient(&x, &mut gradient);
            (membrane.value(&x).to_bits(), plate.value(&x).to_bits(), gradient)
        })
    };
    let one = run(1);
    assert!([2, 3, 8].into_iter().all(|threads| run(threads) == one));
}
