//! Equilibria against elastica, catenaries, and Cook's membrane.

use crate::samples::{dead_forces, equilibrium, number, orders, reference};
use lagrangian::element::hinge::{Hinges, RestAngle, flexural_rigidity};
use lagrangian::element::membrane::{
    LinearMembranes, Membranes, NeoHookeanSheet, OrthotropicSheet, SaintVenantKirchhoffSheet,
};
use lagrangian::element::plate::PlateBending;
use lagrangian::element::rod::{RodBending, RodSection, RodStretching};
use mechanics_core::mesh::{Diagonals, rod, sheet};
use mechanics_core::potential::Potential;
use mechanics_core::projection::Projection;
use mechanics_core::stencil::{LocalHessian, Stencil, StencilTerm};
use mechanics_core::tensor::{Mat3, Vec3};

/// Springs that hold points in the plane z = 0, where nothing pulls them out of it.
struct InPlane;

impl Stencil<1> for InPlane {
    fn value(&self, _: usize, x: &[Vec3; 1]) -> f64 {
        0.5 * x[0].z * x[0].z
    }
    fn gradient(&self, _: usize, x: &[Vec3; 1]) -> [Vec3; 1] {
        [Vec3::z() * x[0].z]
    }
    fn hessian(&self, _: usize, _: &[Vec3; 1], _: Projection) -> LocalHessian<1> {
        [[Mat3::from_diagonal(&Vec3::z())]]
    }
}

fn in_plane(points: usize) -> StencilTerm<InPlane, 1> {
    StencilTerm::new("in plane", InPlane, (0..points as u32).map(|i| [i]).collect()).unwrap()
}

/// An irregular patch: interior points find the affine map of the boundary, and the stress is the same everywhere.
#[test]
fn patch_test() {
    let mesh = {
        let mut mesh = sheet([1.0, 1.0], [4, 4], Diagonals::Alternating).unwrap();
        mesh.map_points(|p| {
            let bubble = p.x * (1.0 - p.x) * p.y * (1.0 - p.y);
            p + Vec3::new((7.0 * p.y).sin(), (9.0 * p.x).cos(), 0.0) * bubble
        })
        .unwrap();
        mesh
    };
    let map = Mat3::new(1.2, 0.15, 0.0, -0.1, 0.9, 0.0, 0.3, -0.2, 1.0);
    let on_rim = |p: &Vec3| p.x == 0.0 || p.y == 0.0 || p.x == 1.0 || p.y == 1.0;
    let rim: Vec<u32> =
        (0..mesh.points().len() as u32).filter(|&i| on_rim(&mesh.points()[i as usize])).collect();
    let expected: Vec<Vec3> = mesh.points().iter().map(|p| map * p).collect();
    let orthotropic = OrthotropicSheet::new([3.0, 1.0], 0.2, 0.7).unwrap();
    let fibres = Membranes::with_fibre(&mesh, orthotropic, 0.1, &Vec3::new(1.0, 0.4, 0.0)).unwrap();
    let mut terms: [Box<dyn Potential>; 4] = [
        Box::new(
            Membranes::term("StVK", &mesh, SaintVenantKirchhoffSheet::new(5.0, 0.3).unwrap(), 0.1).unwrap(),
        ),
        Box::new(
            Membranes::term("neo-Hookean", &mesh, NeoHookeanSheet::new(5.0, 0.3).unwrap(), 0.1).unwrap(),
        ),
        Box::new(StencilTerm::new("orthotropic", fibres, mesh.triangles().to_vec()).unwrap()),
        Box::new(LinearMembranes::term("linear", &mesh, 5.0, 0.3, 0.1).unwrap()),
    ];
    for term in &mut terms {
        let linear = term.name() == "linear";
        let target = |p: &Vec3| if linear { Vec3::new(p.x, p.y, 0.0) } else { *p };
        let mut x: Vec<Vec3> = expected
            .iter()
            .zip(mesh.points())
            .map(|(x, p)| if on_rim(p) { target(x) } else { target(x) + Vec3::new(0.02, -0.01, 0.0) * p.x })
            .collect();
        let mut plane = in_plane(x.len());
        let mut with_plane: [&mut dyn Potential; 2] = [&mut **term, &mut plane];
        let count = if linear { 2 } else { 1 };
        equilibrium(&mut x, &rim, &mut with_plane[..count], 1e-12).unwrap();
        for (x, expected) in x.iter().zip(&expected) {
            assert!((x - target(expected)).norm() < 1e-12, "{}: {x} {expected}", term.name());
        }
    }
}

/// Mid-edge displacement of Cook's membrane with n × n cells of four triangles.
fn cook(n: u32) -> f64 {
    let mut mesh = sheet([1.0, 1.0], [n, n], Diagonals::Crossed).unwrap();
    mesh.map_points(|p| Vec3::new(48.0 * p.x, 44.0 * p.x + p.y * (44.0 - 28.0 * p.x), 0.0)).unwrap();
    let mut membrane = LinearMembranes::term("membrane", &mesh, 1.0, 1.0 / 3.0, 1.0).unwrap();
    let mut forces = vec![Vec3::zeros(); mesh.points().len()];
    for j in 0..n {
        for end in [j, j + 1] {
            forces[(n + (n + 1) * end) as usize].y += 0.5 / f64::from(n);
        }
    }
    let clamped: Vec<u32> = (0..=n).map(|j| (n + 1) * j).collect();
    let mut load = dead_forces(forces);
    let mut x = mesh.points().to_vec();
    let mut plane = in_plane(x.len());
    equilibrium(&mut x, &clamped, &mut [&mut membrane, &mut load, &mut plane], 1e-8).unwrap();
    let middle = (n + (n + 1) * (n / 2)) as usize;
    x[middle].y - mesh.points()[middle].y
}

/// The limit of the fixture is 23.9677; its own finest Q2 mesh gives 23.96668.
#[test]
fn cooks_membrane_converges_to_the_published_displacement() {
    let found: Vec<f64> = [16, 32, 64, 128].into_iter().map(cook).collect();
    let errors: Vec<f64> = found.iter().map(|u| 23.9677 - u).collect();
    let orders = orders(&errors);
    println!("Cook {found:?} {errors:?} {orders:?}");
    // The error is a h² (smooth part) + b h^p (corner): eliminate h² first, then the rest by Aitken's process.
    let smooth: Vec<f64> = found.windows(2).map(|pair| (4.0 * pair[1] - pair[0]) / 3.0).collect();
    let [a, b, c] = [smooth[0], smooth[1], smooth[2]];
    let limit = c - (c - b) * (c - b) / ((c - b) - (b - a));
    println!("limit {limit}");
    assert!((limit - 23.9677).abs() < 3e-4);
}

/// Tip deflection of a cantilever of length 1 with tip force P = load, EI = 1, as a rod of n edges.
///
/// The first edge is clamped with the wall in its middle: a joint stands for half an edge to either side, so the first
/// joint's share begins at the wall.
fn rod_cantilever(n: u32, load: f64) -> [f64; 2] {
    let h = 1.0 / (f64::from(n) - 0.5);
    let mesh = rod(&Vec3::new(-0.5 * h, 0.0, 0.0), &Vec3::new(1.0, 0.0, 0.0), n).unwrap();
    let mut stretching = RodStretching::term("stretching", &mesh, 1e8).unwrap();
    let mut bending = RodBending::new(&mesh, 1.0).unwrap().term("bending").unwrap();
    let mut forces = vec![Vec3::zeros(); mesh.points().len()];
    forces[n as usize].z = -load;
    let mut load = dead_forces(forces);
    let mut x = mesh.points().to_vec();
    let report = equilibrium(&mut x, &[0, 1], &mut [&mut stretching, &mut bending, &mut load], 1e-9).unwrap();
    println!("rod n = {n}: {} iterations", report.iterations);
    [-x[n as usize].z, 1.0 - x[n as usize].x]
}

fn elastica(load: f64) -> [f64; 2] {
    let reference = reference();
    let cases = reference["elastica_tip_load"].as_array().unwrap();
    let case = cases.iter().find(|case| number(&case["PL2_EI"]) == load).unwrap();
    [number(&case["tip_down_over_L"]), number(&case["tip_shortening_over_L"])]
}

#[test]
fn a_rod_converges_to_the_elastica_with_order_two() {
    for load in [1.0, 5.0] {
        let exact = elastica(load);
        let found: Vec<[f64; 2]> = [10, 20, 40, 80].into_iter().map(|n| rod_cantilever(n, load)).collect();
        for component in 0..2 {
            let errors: Vec<f64> = found.iter().map(|u| u[component] - exact[component]).collect();
            let orders = orders(&errors);
            println!("rod, load {load}: errors {errors:?}, orders {orders:?}");
            assert!(orders.iter().all(|order| (order - 2.0).abs() < 0.15));
            assert!(errors[3].abs() < 2e-4);
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Bending {
    Hinges,
    Plate,
}

#[derive(Clone, Copy, Debug)]
struct Strip {
    /// Along and across.
    cells: [u32; 2],
    diagonals: Diagonals,
    bending: Bending,
    /// Points move within the plane by up to this part of a cell.
    disorder: f64,
    thickness: f64,
}

/// The tip deflection of a clamped strip, 0.1 wide and 1 long from the wall, EI = 1, ν = 0, under the tip force `load`.
fn strip_cantilever(strip: &Strip, load: f64) -> f64 {
    let Strip { cells, diagonals, bending, disorder, thickness } = *strip;
    let [n, rows] = cells;
    let h = 1.0 / (f64::from(n) - 0.5);
    let width = 0.1;
    let mut mesh = sheet([h * f64::from(n), width], cells, diagonals).unwrap();
    let random = std::cell::RefCell::new(crate::samples::Random(11));
    let number = || random.borrow_mut().number();
    let clamped_to = 1.01 * h;
    let length = h * f64::from(n);
    let size = [disorder * h, disorder * width / f64::from(rows)];
    mesh.map_points(|p| {
        let free = p.x > clamped_to && p.x < length - 1e-9 && p.y > 1e-9 && p.y < width - 1e-9;
        p + Vec3::new(-0.5 * h, 0.0, 0.0)
            + if free { Vec3::new(size[0] * number(), size[1] * number(), 0.0) } else { Vec3::zeros() }
    })
    .unwrap();
    let young = 12.0 / (width * thickness.powi(3));
    let law = NeoHookeanSheet::new(young, 0.0).unwrap();
    let mut membrane = Membranes::term("membrane", &mesh, law, thickness).unwrap();
    let mut bending: Box<dyn Potential> = match bending {
        Bending::Hinges => {
            let rigidity = flexural_rigidity(young, 0.0, thickness).unwrap();
            Box::new(Hinges::new(&mesh, rigidity, RestAngle::OfMesh).unwrap().term("bending").unwrap())
        }
        Bending::Plate => {
            Box::new(PlateBending::new("bending", &mesh, young, 0.0, thickness, RestAngle::OfMesh).unwrap())
        }
    };
    let mut forces = vec![Vec3::zeros(); mesh.points().len()];
    for j in 0..rows {
        for end in [j, j + 1] {
            forces[(n + (n + 1) * end) as usize].z -= 0.5 * load / f64::from(rows);
        }
    }
    let mut load = dead_forces(forces);
    let mut clamped: Vec<u32> = (0..=rows).flat_map(|j| [(n + 1) * j, (n + 1) * j + 1]).collect();
    if diagonals == Diagonals::Crossed {
        clamped.extend((0..rows).map(|j| (n + 1) * (rows + 1) + n * j));
    }
    let mut x = mesh.points().to_vec();
    let report = equilibrium(&mut x, &clamped, &mut [&mut membrane, &mut *bending, &mut load], 1e-8).unwrap();
    println!("strip {cells:?}: {} iterations", report.iterations);
    -x[(n + (n + 1) * (rows / 2)) as usize].z
}

#[test]
fn an_aligned_strip_converges_to_the_elastica_with_order_two() {
    for load in [1.0, 5.0] {
        let exact = elastica(load)[0];
        let error = |n: u32| {
            let (diagonals, bending) = (Diagonals::Rising, Bending::Plate);
            let strip = Strip { cells: [n, 2], diagonals, bending, disorder: 0.0, thickness: 1e-3 };
            strip_cantilever(&strip, load) - exact
        };
        let errors: Vec<f64> = [8, 16, 32].into_iter().map(error).collect();
        let orders = orders(&errors);
        println!("strip, load {load}: errors {errors:?}, orders {orders:?}");
        assert!(orders.iter().all(|order| (order - 2.0).abs() < 0.15));
        assert!(errors[2].abs() < 1.2e-3);
    }
}

/// Deflections relative to the elastica on meshes of 20 × 2 and 40 × 4 cells.
fn relative(diagonals: Diagonals, bending: Bending, disorder: f64, thickness: f64) -> [f64; 2] {
    let exact = elastica(1.0)[0];
    let found = [[20, 2], [40, 4]].map(|cells| {
        let strip = Strip { cells, diagonals, bending, disorder, thickness };
        strip_cantilever(&strip, 1.0) / exact - 1.0
    });
    println!("PLATEAU {diagonals:?} {bending:?}, disorder {disorder}, t = {thickness}: {found:.5?}");
    found
}

/// What the page of the module `plate` says of meshes.
#[test]
fn hinges_keep_an_error_that_plates_do_not_have() {
    for diagonals in [Diagonals::Rising, Diagonals::Alternating] {
        let hinges = relative(diagonals, Bending::Hinges, 0.0, 1e-3);
        assert!(hinges.iter().all(|error| (0.09..0.17).contains(error)), "too soft, however fine");
        let plate = relative(diagonals, Bending::Plate, 0.0, 1e-3);
        assert!((plate[0] / plate[1]).log2() > 1.85 && plate[1].abs() < 3e-4);
    }
}

#[test]
fn crossed_meshes_are_too_stiff_in_bending() {
    let plate = relative(Diagonals::Crossed, Bending::Plate, 0.0, 1e-3);
    assert!((-0.3..-0.25).contains(&plate[1]), "{plate:?}");
}

#[test]
fn disorder_leaves_a_plateau_that_is_smaller_than_that_of_hinges() {
    let plate = relative(Diagonals::Rising, Bending::Plate, 0.25, 1e-3);
    let hinges = relative(Diagonals::Rising, Bending::Hinges, 0.25, 1e-3);
    assert!(plate[1].abs() < 0.06 && plate[1].abs() < hinges[1].abs(), "{plate:?} {hinges:?}");
}

/// Half the span and the sag of a cable: unstretched length 2·half, weight a length 1, horizontal tension H, stretch as a
/// function of tension. dx/ds = λ(T) H/T, dz/ds = λ(T) s/T with T = √(H² + s²), by Simpson's rule.
fn cable(half: f64, horizontal: f64, stretch: &dyn Fn(f64) -> f64) -> [f64; 2] {
    let cells = 2000;
    let step = half / f64::from(cells);
    let slope = |s: f64| {
        let tension = horizontal.hypot(s);
        [horizontal, s].map(|part| stretch(tension) * part / tension)
    };
    let mut sums = [0.0; 2];
    for k in 0..cells {
        let s = step * f64::from(k);
        let parts = [slope(s), slope(s + 0.5 * step), slope(s + step)];
        for i in 0..2 {
            sums[i] += step / 6.0 * (parts[0][i] + 4.0 * parts[1][i] + parts[2][i]);
        }
    }
    sums
}

/// The sag of the cable between ends `span` apart at the same height.
fn sag(span: f64, length: f64, stretch: &dyn Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (1e-3, 1e3);
    for _ in 0..100 {
        let middle = f64::sqrt(low * high);
        if cable(0.5 * length, middle, stretch)[0] < 0.5 * span { low = middle } else { high = middle }
    }
    cable(0.5 * length, low, stretch)[1]
}

/// The closed form for a linear cable (Irvine, *Cable Structures*, 1981, chapter 1), weight 1 a length.
#[test]
fn the_quadrature_of_cables_agrees_with_the_elastic_catenary() {
    let (length, axial) = (1.25, 20.0);
    let horizontal = 0.45;
    let [half_span, depth] = cable(0.5 * length, horizontal, &|tension| 1.0 + tension / axial);
    let v = 0.5 * length / horizontal;
    let expected = 0.5 * horizontal * length / axial + horizontal * v.asinh();
    assert!((half_span - expected).abs() < 1e-12);
    let expected = length * length / (8.0 * axial) + horizontal * ((1.0 + v * v).sqrt() - 1.0);
    assert!((depth - expected).abs() < 1e-12);
    // And the stiff limit with the catenary of the fixture.
    for case in reference()["catenary"].as_array().unwrap() {
        let found = sag(number(&case["span"]), number(&case["length"]), &|_| 1.0);
        assert!((found - number(&case["sag"])).abs() < 1e-10);
    }
}

/// Points of a V that is a little longer than the cable.
fn vee(points: &[Vec3], span: f64, length: f64) -> Vec<Vec3> {
    let depth = 0.5 * (length * length - span * span).sqrt();
    let at = |p: &Vec3| {
        let s = p.x / length;
        Vec3::new(span * s, p.y, -1.01 * depth * (1.0 - (2.0 * s - 1.0).abs()))
    };
    points.iter().map(at).collect()
}

fn hanging_rod(n: u32, length: f64, axial: f64) -> f64 {
    let mesh = rod(&Vec3::zeros(), &(Vec3::x() * length), n).unwrap();
    let mut stretching = RodStretching::term("stretching", &mesh, axial).unwrap();
    let mut weight = dead_forces(vec![-Vec3::z() * (length / f64::from(n)); mesh.points().len()]);
    let mut x = vee(mesh.points(), 1.0, length);
    equilibrium(&mut x, &[0, n], &mut [&mut stretching, &mut weight], 1e-9).unwrap();
    -x[(n / 2) as usize].z
}

#[test]
fn a_hanging_chain_converges_to_the_catenary_and_to_the_elastic_catenary() {
    for (length, axial) in [(1.25, 1e6), (2.0, 1e6), (1.25, 5.0)] {
        let exact = sag(1.0, length, &|tension| 1.0 + tension / axial);
        let errors: Vec<f64> =
            [16, 32, 64].into_iter().map(|n| hanging_rod(n, length, axial) - exact).collect();
        let orders = orders(&errors);
        println!("chain, length {length}, EA {axial:e}: errors {errors:?}, orders {orders:?}");
        assert!(orders.iter().all(|order| (order - 2.0).abs() < 0.15));
    }
}

fn hanging_strip(n: u32, length: f64, young: f64, diagonals: Diagonals) -> f64 {
    let (width, rows, thickness) = (0.25, 2, 0.01);
    let mesh = sheet([length, width], [n, rows], diagonals).unwrap();
    let law = NeoHookeanSheet::new(young, 0.0).unwrap();
    let mut membrane = Membranes::term("membrane", &mesh, law, thickness).unwrap();
    // Weight one a length: one over the width an area, a third of each triangle to each corner.
    let mut forces = vec![Vec3::zeros(); mesh.points().len()];
    for (triangle, area) in mesh.triangles().iter().zip(mesh.areas()) {
        triangle.iter().for_each(|&i| forces[i as usize].z -= area / (3.0 * width));
    }
    let mut weight = dead_forces(forces);
    let ends: Vec<u32> = (0..=rows).flat_map(|j| [(n + 1) * j, (n + 1) * j + n]).collect();
    let mut x = vee(mesh.points(), 1.0, length);
    equilibrium(&mut x, &ends, &mut [&mut membrane, &mut weight], 1e-9).unwrap();
    -x[(n / 2 + (n + 1) * (rows / 2)) as usize].z
}

/// A neo-Hookean sheet with ν = 0 pulled by T an original section: T = ½E(λ − 1/λ).
#[test]
fn a_hanging_strip_converges_to_its_own_elastic_catenary() {
    for (length, young) in [(1.25, 1e7), (1.25, 5e3)] {
        let axial = young * 0.25 * 0.01;
        let stretch = |tension: f64| tension / axial + (1.0 + (tension / axial).powi(2)).sqrt();
        let exact = sag(1.0, length, &stretch);
        let errors: Vec<f64> = [16, 32, 64]
            .into_iter()
            .map(|n| hanging_strip(n, length, young, Diagonals::Rising) - exact)
            .collect();
        let orders = orders(&errors);
        println!("strip, EA {axial:e}: exact {exact} errors {errors:?}, orders {orders:?}");
        assert!(orders.iter().all(|order| (order - 2.0).abs() < 0.15));
    }
}

/// EI θ'' = −w (L − s) cos θ, θ(0) = 0, θ'(L) = 0, θ the slope downwards: by shooting with the Runge–Kutta method.
fn self_weight_elastica(weight: f64) -> f64 {
    let shoot = |curvature: f64| {
        let n = 2000;
        let h = 1.0 / f64::from(n);
        let rate = |s: f64, y: [f64; 3]| [y[1], -weight * (1.0 - s) * y[0].cos(), y[0].sin()];
        let mut y = [0.0, curvature, 0.0];
        for k in 0..n {
            let s = h * f64::from(k);
            let along = |r: [f64; 3], f: f64| [0, 1, 2].map(|i| y[i] + f * r[i]);
            let k1 = rate(s, y);
            let k2 = rate(s + 0.5 * h, along(k1, 0.5 * h));
            let k3 = rate(s + 0.5 * h, along(k2, 0.5 * h));
            let k4 = rate(s + h, along(k3, h));
            y = [0, 1, 2].map(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        }
        y
    };
    let (mut low, mut high) = (0.0, weight);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if shoot(middle)[1] < 0.0 { low = middle } else { high = middle }
    }
    shoot(low)[2]
}

#[test]
fn a_rod_bends_under_its_own_weight_as_the_elastica_does() {
    for weight in [1.0, 10.0] {
        let exact = self_weight_elastica(weight);
        let bend = |n: u32| {
            let h = 1.0 / (f64::from(n) - 0.5);
            let mesh = rod(&Vec3::new(-0.5 * h, 0.0, 0.0), &Vec3::new(1.0, 0.0, 0.0), n).unwrap();
            let section = RodSection { axial: 1e8, flexural: 1.0 };
            let mut stretching = RodStretching::term("stretching", &mesh, section.axial).unwrap();
            let mut bending = RodBending::new(&mesh, section.flexural).unwrap().term("bending").unwrap();
            let mut forces = vec![-Vec3::z() * (weight * h); mesh.points().len()];
            forces[n as usize] *= 0.5;
            let mut load = dead_forces(forces);
            let mut x = mesh.points().to_vec();
            equilibrium(&mut x, &[0, 1], &mut [&mut stretching, &mut bending, &mut load], 1e-9).unwrap();
            -x[n as usize].z
        };
        let errors: Vec<f64> = [10, 20, 40].into_iter().map(|n| bend(n) - exact).collect();
        let orders = orders(&errors);
        println!("own weight {weight}: exact {exact}, errors {errors:?}, orders {orders:?}");
        assert!(orders.iter().all(|order| (order - 2.0).abs() < 0.15));
    }
}
