//! The linear tetrahedron: derivatives, lanes, bad input.

use crate::{Random, matrix};
use lagrangian::element::{ElementError, Mass, MassDistribution, Tetrahedra};
use mechanics_core::derivatives::check_stencil;
use mechanics_core::jet::Jet2;
use mechanics_core::law::{
    FixedCorotated, Hencky, Hyperelastic, Lame, Linear, NeoHookean, StVenantKirchhoff, StableNeoHookean,
};
use mechanics_core::mesh::TetMesh;
use mechanics_core::mesh::{BoxSplit, block};
use mechanics_core::projection::Projection;
use mechanics_core::scalar::Scalar;
use mechanics_core::stencil::Stencil;
use mechanics_core::tensor::{Mat3, Vec3, from_entries};
use nalgebra::SMatrix;

const REST: [[f64; 3]; 4] = [[0.1, 0.0, -0.1], [1.0, 0.1, 0.0], [0.2, 0.9, 0.1], [0.1, 0.2, 1.1]];

fn rest() -> [Vec3; 4] {
    REST.map(Vec3::from)
}

fn lame() -> Lame {
    Lame::from_young_poisson(10.0, 0.3).unwrap()
}

/// V ψ(F) through jets over the twelve coordinates, F from Cramer's rule on the rest edges.
fn by_jets<L: Hyperelastic>(law: &L, x: &[Vec3; 4]) -> Jet2<f64, 12> {
    let [a, b, c, d] = rest();
    let edges = Mat3::from_columns(&[b - a, c - a, d - a]);
    let inverse = edges.try_inverse().unwrap();
    let q = Jet2::variables(std::array::from_fn(|k| x[k / 3][k % 3]));
    let deformed = |i: usize, a: usize| q[3 * (a + 1) + i] - q[i];
    let f = from_entries(|i, j| {
        (0..3).fold(Jet2::constant(0.0), |sum, a| sum + deformed(i, a).scale(inverse[(a, j)]))
    });
    law.energy_density(&f).scale(edges.determinant() / 6.0)
}

fn derivatives_agree<L: Hyperelastic>(law: L, amplitude: f64) {
    let elements = Tetrahedra::new(law, &rest(), &[[0, 1, 2, 3]]).unwrap();
    let mut random = Random(7);
    for _ in 0..6 {
        let x = rest().map(|x| x + random.vector() * amplitude);
        check_stencil(&elements, 0, &x).require(1e-7).unwrap();
        let jet = by_jets(elements.law(), &x);
        let value = elements.value(0, &x);
        assert!((value - jet.value).abs() <= 1e-13 * (1.0 + value.abs()), "{value} {}", jet.value);
        let gradient = elements.gradient(0, &x);
        let scale = jet.gradient.iter().fold(0.0_f64, |m, g| m.max(g.abs()));
        for k in 0..12 {
            assert!((gradient[k / 3][k % 3] - jet.gradient[k]).abs() <= 1e-12 * scale);
        }
        let h: SMatrix<f64, 12, 12> = matrix(&elements.hessian(0, &x, Projection::None));
        for r in 0..12 {
            for c in 0..12 {
                assert!((h[(r, c)] - jet.hessian(r, c)).abs() <= 1e-11 * h.amax());
            }
        }
        let clamped: SMatrix<f64, 12, 12> = matrix(&elements.hessian(0, &x, Projection::Clamp));
        assert!(clamped.symmetric_eigenvalues().min() >= -1e-12 * clamped.amax());
        // Clamping adds energy in no direction in which the Hessian already was convex.
        assert!((clamped - h).symmetric_eigenvalues().min() >= -1e-11 * h.amax());
    }
}

#[test]
fn derivatives_of_a_tetrahedron_are_those_of_automatic_differentiation() {
    derivatives_agree(NeoHookean::new(lame()), 0.1);
    derivatives_agree(StableNeoHookean::new(lame()), 0.8);
    derivatives_agree(FixedCorotated::new(lame()), 0.1);
    derivatives_agree(StVenantKirchhoff::new(lame()), 0.5);
    derivatives_agree(Hencky::new(lame()), 0.1);
    derivatives_agree(Linear::new(lame()), 0.5);
}

/// All lengths of runs, starts that are no multiple of four: what lanes compute is what one element computes, and does
/// not depend on its neighbours.
#[test]
fn lanes_agree_with_single_elements_wherever_a_run_begins() {
    let mesh = block(&Vec3::zeros(), &Vec3::new(1.0, 1.2, 0.7), [2, 2, 2], BoxSplit::Six).unwrap();
    let elements = Tetrahedra::new(StableNeoHookean::new(lame()), mesh.points(), mesh.cells()).unwrap();
    let mut random = Random(3);
    let moved: Vec<Vec3> = mesh.points().iter().map(|x| x + random.vector() * 0.3).collect();
    let x: Vec<[Vec3; 4]> = mesh.cells().iter().map(|cell| cell.map(|i| moved[i as usize])).collect();
    let (mut all_values, mut all_gradients) = (vec![0.0; 48], vec![[Vec3::zeros(); 4]; 48]);
    let mut all_hessians = vec![[[Mat3::zeros(); 4]; 4]; 48];
    elements.values_into(0, &x, &mut all_values);
    elements.gradients_into(0, &x, &mut all_gradients);
    elements.hessians_into(0, &x, Projection::Clamp, &mut all_hessians);
    for first in 0..9 {
        for count in 1..10 {
            let x = &x[first..first + count];
            let mut values = vec![0.0; count];
            elements.values_into(first, x, &mut values);
            assert_eq!(values, all_values[first..first + count]);
            let mut gradients = vec![[Vec3::zeros(); 4]; count];
            elements.gradients_into(first, x, &mut gradients);
            assert_eq!(gradients, all_gradients[first..first + count]);
            let mut hessians = vec![[[Mat3::zeros(); 4]; 4]; count];
            elements.hessians_into(first, x, Projection::Clamp, &mut hessians);
            for (k, h) in hessians.iter().enumerate() {
                let (h, all): (SMatrix<f64, 12, 12>, SMatrix<f64, 12, 12>) =
                    (matrix(h), matrix(&all_hessians[first + k]));
                assert_eq!(h, all);
                let single: SMatrix<f64, 12, 12> =
                    matrix(&elements.hessian(first + k, &x[k], Projection::Clamp));
                assert!((h - single).amax() <= 1e-12 * h.amax());
                assert!((values[k] - elements.value(first + k, &x[k])).abs() <= 1e-13);
            }
        }
    }
}

#[test]
fn bad_rest_shapes_are_refused_by_name() {
    let law = NeoHookean::new(lame());
    let [a, b, c, d] = rest();
    let points = [a, b, c, d, Vec3::new(f64::NAN, 0.0, 0.0)];
    let wrong = |cells: &[[u32; 4]]| Tetrahedra::new(law, &points, cells).unwrap_err();
    assert!(matches!(
        wrong(&[[0, 1, 2, 3], [0, 2, 1, 3]]),
        ElementError::RestVolume { element: 1, volume } if volume < 0.0
    ));
    assert!(
        matches!(wrong(&[[0, 1, 2, 2]]), ElementError::RestVolume { element: 0, volume } if volume == 0.0)
    );
    assert!(matches!(
        wrong(&[[0, 1, 2, 5]]),
        ElementError::PointOutOfRange { element: 0, point: 5, points: 5 }
    ));
    assert!(matches!(wrong(&[[0, 1, 2, 4]]), ElementError::NonFinite { point: 4, .. }));
    let lonely = TetMesh::new(vec![a, b, c, d, a * 2.0], vec![[0, 1, 2, 3]]).unwrap();
    assert!(matches!(
        Tetrahedra::term("t", law, &lonely).unwrap_err(),
        ElementError::Unreferenced { point: 4 }
    ));
    let mut mass = Mass::zeros(4);
    let lumped = MassDistribution::Lumped;
    for density in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = mass.add_tetrahedra(&points, &[[0, 1, 2, 3]], density, lumped).unwrap_err();
        assert!(matches!(error, ElementError::OutOfRange { quantity: "density", .. }), "{error}");
    }
    assert_eq!(mass, Mass::zeros(4));
    assert!(mass.add_tetrahedra(&points, &[[0, 2, 1, 3]], 1.0, lumped).is_err());
    assert!(mass.add_point(1, -1.0).is_err());
    assert!(mass.add_point(4, 1.0).is_err());
}
