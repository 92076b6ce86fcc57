//! The ten-node tetrahedron.

use crate::{Random, matrix};
use lagrangian::element::{
    EDGES, ElementError, Mass, MassDistribution, QuadraticMesh, QuadraticTetrahedra, Tetrahedra,
    jacobian_lower_bound,
};
use mechanics_core::derivatives::check_stencil;
use mechanics_core::jet::{Jet1, Jet2};
use mechanics_core::law::{Hyperelastic, Lame, NeoHookean, StableNeoHookean};
use mechanics_core::mesh::TetMesh;
use mechanics_core::projection::Projection;
use mechanics_core::scalar::Scalar;
use mechanics_core::stencil::Stencil;
use mechanics_core::tensor::{Mat3, Vec3, from_entries};
use nalgebra::SMatrix;

fn law() -> StableNeoHookean {
    StableNeoHookean::new(Lame::from_young_poisson(10.0, 0.3).unwrap())
}

/// One element, its edges bent if `bend` is not zero.
fn element(bend: f64) -> QuadraticMesh {
    let corners =
        [[0.1, 0.0, -0.1], [1.0, 0.1, 0.0], [0.2, 0.9, 0.1], [0.1, 0.2, 1.1]].map(Vec3::from).to_vec();
    let mut mesh = QuadraticMesh::new(&TetMesh::new(corners, vec![[0, 1, 2, 3]]).unwrap());
    let mut random = Random(9);
    mesh.points[4..].iter_mut().for_each(|x| *x += random.vector() * bend);
    mesh
}

fn nodes(mesh: &QuadraticMesh) -> [Vec3; 10] {
    mesh.cells[0].map(|i| mesh.points[i as usize])
}

/// The shape functions once more, from their definition as Lagrange polynomials in barycentric coordinates.
fn shape<S: Scalar>(xi: [S; 3]) -> [S; 10] {
    let l = [(-(xi[0] + xi[1] + xi[2])).offset(1.0), xi[0], xi[1], xi[2]];
    std::array::from_fn(|a| {
        if a < 4 {
            l[a] * l[a].scale(2.0).offset(-1.0)
        } else {
            (l[EDGES[a - 4][0]] * l[EDGES[a - 4][1]]).scale(4.0)
        }
    })
}

/// Σ w det J ψ(F) over the four-point rule, by jets for shape functions and for all thirty coordinates.
fn by_jets(rest: &[Vec3; 10], x: &[Vec3; 10]) -> Jet2<f64, 30> {
    let q = Jet2::<f64, 30>::variables(std::array::from_fn(|k| x[k / 3][k % 3]));
    let (alpha, beta) = (0.585_410_196_624_968_5, 0.138_196_601_125_010_5);
    let mut energy = Jet2::constant(0.0);
    for point in 0..4 {
        let xi: [f64; 3] = std::array::from_fn(|k| if k + 1 == point { alpha } else { beta });
        let n = shape(Jet1::<f64, 3>::variables(xi));
        let jacobian: Mat3 = (0..10).map(|a| rest[a] * Vec3::from(n[a].gradient).transpose()).sum();
        let inverse = jacobian.try_inverse().unwrap();
        let gradients: Vec<Vec3> = n.iter().map(|n| inverse.tr_mul(&Vec3::from(n.gradient))).collect();
        let f = from_entries(|i, j| {
            (0..10).fold(Jet2::constant(0.0), |sum, a| sum + q[3 * a + i].scale(gradients[a][j]))
        });
        energy += law().energy_density(&f).scale(jacobian.determinant() / 24.0);
    }
    energy
}

#[test]
fn derivatives_are_those_of_automatic_differentiation() {
    for bend in [0.0, 0.05] {
        let mesh = element(bend);
        let rest = nodes(&mesh);
        let elements = QuadraticTetrahedra::new(law(), &mesh.points, &mesh.cells).unwrap();
        let mut random = Random(4);
        let x = rest.map(|x| x + random.vector() * 0.2);
        check_stencil(&elements, 0, &x).require(1e-7).unwrap();
        let jet = by_jets(&rest, &x);
        assert!((elements.value(0, &x) - jet.value).abs() < 1e-13 * jet.value.abs());
        let h: SMatrix<f64, 30, 30> = matrix(&elements.hessian(0, &x, Projection::None));
        let gradient = elements.gradient(0, &x);
        let scale = jet.gradient.iter().fold(0.0_f64, |m, g| m.max(g.abs()));
        for r in 0..30 {
            assert!((gradient[r / 3][r % 3] - jet.gradient[r]).abs() < 1e-12 * scale);
            for c in 0..30 {
                assert!((h[(r, c)] - jet.hessian(r, c)).abs() < 1e-11 * h.amax());
            }
        }
        let clamped: SMatrix<f64, 30, 30> = matrix(&elements.hessian(0, &x, Projection::Clamp));
        assert!(clamped.symmetric_eigenvalues().min() > -1e-12 * clamped.amax());
    }
}

#[test]
fn lanes_agree_with_single_elements() {
    let mesh = element(0.05);
    let cells = vec![mesh.cells[0]; 7];
    let elements = QuadraticTetrahedra::new(law(), &mesh.points, &cells).unwrap();
    let mut random = Random(8);
    let x: Vec<[Vec3; 10]> = (0..7).map(|_| nodes(&mesh).map(|x| x + random.vector() * 0.3)).collect();
    for count in 1..=7 {
        let mut values = vec![0.0; count];
        let mut gradients = vec![[Vec3::zeros(); 10]; count];
        let mut hessians = vec![[[Mat3::zeros(); 10]; 10]; count];
        elements.values_into(0, &x[..count], &mut values);
        elements.gradients_into(0, &x[..count], &mut gradients);
        elements.hessians_into(0, &x[..count], Projection::Clamp, &mut hessians);
        for e in 0..count {
            assert!((values[e] - elements.value(e, &x[e])).abs() < 1e-13 * values[e]);
            let single = elements.gradient(e, &x[e]);
            assert!((0..10).all(|a| (gradients[e][a] - single[a]).norm() < 1e-12));
            let (lanes, single): (SMatrix<f64, 30, 30>, SMatrix<f64, 30, 30>) =
                (matrix(&hessians[e]), matrix(&elements.hessian(e, &x[e], Projection::Clamp)));
            assert!((lanes - single).amax() < 1e-12 * single.amax());
        }
    }
}

/// Under an affine deformation F is the same everywhere, so the energy is that of the linear element.
#[test]
fn an_affine_deformation_has_the_energy_of_the_linear_element() {
    let mesh = element(0.0);
    let corners: Vec<Vec3> = mesh.points[..4].to_vec();
    let linear = Tetrahedra::new(law(), &corners, &[[0, 1, 2, 3]]).unwrap();
    let quadratic = QuadraticTetrahedra::new(law(), &mesh.points, &mesh.cells).unwrap();
    let f = Mat3::new(1.1, 0.2, -0.1, 0.0, 0.9, 0.3, 0.1, -0.2, 1.2);
    let x = nodes(&mesh).map(|x| f * x);
    let corners = [x[0], x[1], x[2], x[3]];
    let (a, b) = (linear.value(0, &corners), quadratic.value(0, &x));
    assert!((a - b).abs() < 1e-13 * a, "{a} {b}");
}

/// ∫ L₀ᵃ L₁ᵇ L₂ᶜ L₃ᵈ dV = 6V a! b! c! d! / (a + b + c + d + 3)!
fn barycentric_integral(powers: [usize; 4], volume: f64) -> f64 {
    let factorial = |n: usize| (1..=n).map(|k| k as f64).product::<f64>();
    let numerator: f64 = powers.iter().map(|&n| factorial(n)).product();
    6.0 * volume * numerator / factorial(powers.iter().sum::<usize>() + 3)
}

/// The monomials of a shape function: coefficient and powers.
fn monomials(node: usize) -> Vec<(f64, [usize; 4])> {
    let power = |list: &[usize]| std::array::from_fn(|k| list.iter().filter(|&&other| other == k).count());
    if node < 4 {
        vec![(2.0, power(&[node, node])), (-1.0, power(&[node]))]
    } else {
        vec![(4.0, power(&EDGES[node - 4]))]
    }
}

#[test]
fn consistent_masses_are_the_exact_integrals() {
    let mesh = element(0.0);
    let mut mass = Mass::zeros(10);
    mass.add_quadratic_tetrahedra(&mesh.points, &mesh.cells, 7.0, MassDistribution::Consistent).unwrap();
    let [a, b, c, d] = [0, 1, 2, 3].map(|i| mesh.points[i]);
    let volume = (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0;
    let local = |point: usize| mesh.cells[0].iter().position(|&node| node as usize == point).unwrap();
    let exact = |i: usize, j: usize| {
        let (i, j) = (local(i), local(j));
        let mut sum = 0.0;
        for (ci, pi) in monomials(i) {
            for (cj, pj) in monomials(j) {
                sum += ci * cj * barycentric_integral(std::array::from_fn(|k| pi[k] + pj[k]), volume);
            }
        }
        7.0 * sum
    };
    for i in 0..10 {
        assert!((mass.diagonal()[i] - exact(i, i)).abs() < 1e-14);
    }
    let (pairs, couplings) = mass.couplings();
    assert_eq!(pairs.len(), 45);
    for (&[i, j], coupling) in pairs.iter().zip(couplings) {
        assert!((coupling - exact(i as usize, j as usize)).abs() < 1e-14);
    }
    // A curved element has the mass of its volume, and lumping keeps it with positive shares.
    let mut lumped = Mass::zeros(10);
    let bent = element(0.05);
    lumped.add_quadratic_tetrahedra(&bent.points, &bent.cells, 7.0, MassDistribution::Lumped).unwrap();
    assert!(lumped.diagonal().iter().all(|&m| m > 0.0));
    assert!((lumped.total() - 7.0 * curved_volume(&bent)).abs() < 1e-14);
}

/// ∫ det J dξ with the exact rule of Newton and Cotes in each collapsed coordinate: seven points, degree seven.
fn curved_volume(mesh: &QuadraticMesh) -> f64 {
    let x = nodes(mesh);
    let weights = [41.0, 216.0, 27.0, 272.0, 27.0, 216.0, 41.0];
    let line: [(f64, f64); 7] = std::array::from_fn(|k| (k as f64 / 6.0, weights[k] / 840.0));
    let mut sum = 0.0;
    for (u, wu) in line {
        for (v, wv) in line {
            for (w, ww) in line {
                let xi = [u * (1.0 - v) * (1.0 - w), v * (1.0 - w), w];
                let n = shape(Jet1::<f64, 3>::variables(xi));
                let jacobian: Mat3 = (0..10).map(|a| x[a] * Vec3::from(n[a].gradient).transpose()).sum();
                sum += wu * wv * ww * (1.0 - v) * (1.0 - w).powi(2) * jacobian.determinant();
            }
        }
    }
    sum
}

#[test]
fn bad_elements_are_refused_by_name() {
    let mesh = element(0.0);
    let mut folded = mesh.clone();
    folded.points[4] += Vec3::new(0.0, 0.9, 0.9);
    let error = QuadraticTetrahedra::new(law(), &folded.points, &folded.cells).unwrap_err();
    assert!(
        matches!(error, ElementError::RestFold { element: 0, determinant } if determinant < 0.0),
        "{error}"
    );
    let mut mass = Mass::zeros(10);
    assert!(
        mass.add_quadratic_tetrahedra(&folded.points, &folded.cells, 1.0, MassDistribution::Lumped).is_err()
    );
    assert_eq!(mass, Mass::zeros(10));
    let mut lonely = mesh;
    lonely.points.push(Vec3::zeros());
    let error = QuadraticTetrahedra::term("t", law(), &lonely).unwrap_err();
    assert!(matches!(error, ElementError::Unreferenced { point: 10 }));
}

/// A step is cut before any quadrature point of a neo-Hookean element inverts.
#[test]
fn a_step_ends_before_an_element_inverts() {
    let mesh = element(0.0);
    let rubber = NeoHookean::new(Lame::from_young_poisson(10.0, 0.3).unwrap());
    let elements = QuadraticTetrahedra::new(rubber, &mesh.points, &mesh.cells).unwrap();
    let x = nodes(&mesh);
    let mut random = Random(21);
    let mut limited = 0;
    for _ in 0..50 {
        let p: [Vec3; 10] = std::array::from_fn(|_| random.vector());
        let part = elements.limit_step(0, &x, &p);
        assert!(part > 0.0 && part <= 1.0);
        limited += usize::from(part < 1.0);
        for k in 1..=20 {
            let moved = std::array::from_fn(|a| x[a] + p[a] * (part * f64::from(k) / 20.0));
            assert!(elements.value(0, &moved).is_finite());
        }
        if part < 1.0 {
            let beyond = std::array::from_fn(|a| x[a] + p[a] * (part / 0.9 * 1.001));
            assert!(elements.value(0, &beyond) == f64::INFINITY, "the limit is sharp");
        }
    }
    assert!(limited > 10, "{limited}");
}

/// det ∂x/∂ξ at ξ, by jets.
fn jacobian(x: &[Vec3; 10], xi: [f64; 3]) -> f64 {
    let n = shape(Jet1::<f64, 3>::variables(xi));
    (0..10).map(|a| x[a] * Vec3::from(n[a].gradient).transpose()).sum::<Mat3>().determinant()
}

#[test]
fn the_bound_of_the_jacobian_is_a_bound_and_sharp() {
    let straight = nodes(&element(0.0));
    let six_volumes = Mat3::from_columns(&[1, 2, 3].map(|a| straight[a] - straight[0])).determinant();
    assert!((jacobian_lower_bound(&straight) / six_volumes - 1.0).abs() < 1e-14);
    let mut random = Random(31);
    let (mut certified, mut inverted) = (0, 0);
    for case in 0..300 {
        let bend = 0.004 * f64::from(case % 100);
        let mut x = straight;
        x[4..].iter_mut().for_each(|x| *x += random.vector() * bend);
        let mut smallest = f64::INFINITY;
        for (i, j, k) in
            (0..9).flat_map(|i| (0..9 - i).flat_map(move |j| (0..9 - i - j).map(move |k| (i, j, k))))
        {
            smallest = smallest.min(jacobian(&x, [i, j, k].map(|n| f64::from(n) / 8.0)));
        }
        let bound = jacobian_lower_bound(&x);
        assert!(bound <= smallest + 1e-14, "{bound} {smallest}");
        certified += u32::from(bound > 0.0);
        inverted += u32::from(smallest <= 0.0);
        // What it gives away is of second order in the bending.
        assert!(smallest - bound <= 40.0 * bend * bend, "{bound} {smallest} at {bend}");
    }
    assert!(certified > 50 && inverted > 50, "{certified} certified, {inverted} inverted");
}

/// What a step limit at quadrature points lets through: positive at all four, negative at a corner, and the bound tells.
#[test]
fn an_element_may_be_inside_out_between_its_quadrature_points() {
    let mut x = nodes(&element(0.0));
    // The middle of the edge from corner 0 to corner 1, moved past a quarter of it: ∂x/∂L₁ at corner 0 turns round.
    let corner = x[0];
    x[4] = corner + (x[1] - corner) * 0.22;
    let (alpha, beta) = (0.585_410_196_624_968_5, 0.138_196_601_125_010_5);
    for point in 0..4 {
        let xi = std::array::from_fn(|k| if k + 1 == point { alpha } else { beta });
        assert!(jacobian(&x, xi) > 0.1, "positive where the law looks");
    }
    assert!(jacobian(&x, [0.0; 3]) < 0.0 && jacobian_lower_bound(&x) < 0.0);
}
