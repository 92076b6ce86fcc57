//! Gradients and Hessians against finite differences and automatic differentiation; rigid motions; projections.

use crate::samples::{Random, relative_lowest};
use lagrangian::element::hinge::{BendingHessian, Hinges, RestAngle, dihedral_angle, dihedral_derivatives};
use lagrangian::element::membrane::{
    LinearMembranes, Membranes, NeoHookeanSheet, OrthotropicSheet, SaintVenantKirchhoffSheet, SheetLaw,
};
use mechanics_core::derivatives::check_stencil;
use mechanics_core::jet::Jet2;
use mechanics_core::mesh::TriMesh;
use mechanics_core::projection::{Projection, project_symmetric};
use mechanics_core::scalar::Scalar;
use mechanics_core::stencil::Stencil;
use mechanics_core::tensor::{Vec3, cross, dot};
use nalgebra::SMatrix;

/// The same points everywhere: one triangle, and a second on its first edge.
fn corners(random: &mut Random) -> [Vec3; 4] {
    [
        Vec3::zeros(),
        Vec3::new(1.0, 0.1, 0.0) + random.vector() * 0.2,
        Vec3::new(0.3, 0.9, 0.1) + random.vector() * 0.2,
        Vec3::new(0.4, -0.8, 0.1) + random.vector() * 0.2,
    ]
}

fn mesh(corners: &[Vec3; 4]) -> TriMesh {
    TriMesh::new(corners.to_vec(), vec![[0, 1, 2], [1, 0, 3]]).unwrap()
}

fn sheets(mesh: &TriMesh) -> Vec<(&'static str, Box<dyn Stencil<3>>)> {
    let along = Vec3::new(0.7, 0.5, 0.1);
    let law = OrthotropicSheet::new([30.0, 5.0], 0.25, 3.0).unwrap();
    vec![
        (
            "StVK",
            Box::new(Membranes::new(mesh, SaintVenantKirchhoffSheet::new(10.0, 0.3).unwrap(), 0.1).unwrap()),
        ),
        (
            "neo-Hookean",
            Box::new(Membranes::new(mesh, NeoHookeanSheet::new(10.0, 0.4).unwrap(), 0.1).unwrap()),
        ),
        ("auxetic", Box::new(Membranes::new(mesh, NeoHookeanSheet::new(10.0, -0.3).unwrap(), 0.1).unwrap())),
        ("orthotropic", Box::new(Membranes::with_fibre(mesh, law, 0.1, &along).unwrap())),
        ("linear", Box::new(LinearMembranes::new(mesh, 10.0, 0.3, 0.1).unwrap())),
    ]
}

struct Boxed<'a, const N: usize>(&'a dyn Stencil<N>);

impl<const N: usize> Stencil<N> for Boxed<'_, N> {
    fn value(&self, e: usize, x: &[Vec3; N]) -> f64 {
        self.0.value(e, x)
    }
    fn gradient(&self, e: usize, x: &[Vec3; N]) -> [Vec3; N] {
        self.0.gradient(e, x)
    }
    fn hessian(&self, e: usize, x: &[Vec3; N], p: Projection) -> mechanics_core::stencil::LocalHessian<N> {
        self.0.hessian(e, x, p)
    }
}

#[test]
fn sheets_pass_the_derivative_checker() {
    let mut random = Random(1);
    for round in 0..30 {
        let rest = corners(&mut random);
        let mesh = mesh(&rest);
        let strain = [1e-4, 0.05, 0.3][round % 3];
        let turn = random.rotation();
        let x: [Vec3; 3] = std::array::from_fn(|i| turn * (rest[i] + random.vector() * strain));
        for (name, sheet) in sheets(&mesh) {
            let x = if name == "linear" { x.map(|x| turn.transpose() * x) } else { x };
            let check = check_stencil(&Boxed(&*sheet), 0, &x);
            check.require(1e-7).unwrap_or_else(|e| panic!("{name}, round {round}: {e}"));
        }
    }
}

/// W of the neo-Hookean sheet over any scalar: the thickness from its implicit equation, by Newton's method on the values
/// and twice more on the jets, which makes two orders of derivatives exact.
fn neo_hookean<S: Scalar>(mu: f64, lambda: f64, [c11, c12, c22]: [S; 3]) -> S {
    let half = |a: S| a.scale(0.5);
    let log_area = half((c11 * c22 - c12 * c12).ln());
    let mut s = S::constant(0.0);
    for _ in 0..60 {
        let growth = (s + s).exp();
        let residual = (growth.offset(-1.0)).scale(mu) + (log_area + s).scale(lambda);
        s -= residual / growth.scale(2.0 * mu).offset(lambda);
    }
    let log_volume = log_area + s;
    half(c11 + c22 + (s + s).exp()).offset(-1.5).scale(mu) - log_volume.scale(mu)
        + half(log_volume.square()).scale(lambda)
}

fn saint_venant<S: Scalar>(young: f64, poisson: f64, [c11, c12, c22]: [S; 3]) -> S {
    let (e11, e22, e12) = (c11.offset(-1.0).scale(0.5), c22.offset(-1.0).scale(0.5), c12.scale(0.5));
    let factor = young / (1.0 - poisson * poisson);
    // Plane stress, textbook form: ½ E/(1 − ν²) (ε₁² + ε₂² + 2ν ε₁ε₂ + 2(1 − ν) ε₁₂²).
    (e11.square()
        + e22.square()
        + (e11 * e22).scale(2.0 * poisson)
        + e12.square().scale(2.0 * (1.0 - poisson)))
    .scale(0.5 * factor)
}

#[test]
fn isotropic_laws_agree_with_automatic_differentiation() {
    let mut random = Random(2);
    let (young, poisson) = (7.0, 0.35);
    let (mu, lambda) = (young / 2.7, young * poisson / (1.35 * 0.3));
    let laws: [(&dyn SheetLaw, bool); 2] = [
        (&NeoHookeanSheet::new(young, poisson).unwrap(), true),
        (&SaintVenantKirchhoffSheet::new(young, poisson).unwrap(), false),
    ];
    for round in 0..40 {
        let size = [0.01, 0.3, 0.8, 3.0][round % 4];
        let f =
            nalgebra::Matrix3x2::<f64>::from_fn(|i, j| f64::from(u8::from(i == j)) + size * random.number());
        let v: [Jet2<f64, 6>; 6] = Jet2::variables(std::array::from_fn(|k| f[(k % 3, k / 3)]));
        let (a, b) = ([v[0], v[1], v[2]], [v[3], v[4], v[5]]);
        let c = [dot(&a, &a), dot(&a, &b), dot(&b, &b)];
        for (law, is_neo_hookean) in laws {
            let jet =
                if is_neo_hookean { neo_hookean(mu, lambda, c) } else { saint_venant(young, poisson, c) };
            let scale = jet.hessian_matrix().as_flattened().iter().fold(young, |m, h| m.max(h.abs()));
            assert!((law.energy_density(&f) - jet.value).abs() < 1e-13 * scale.max(jet.value));
            let stress = law.first_piola(&f);
            let stiffness = law.stiffness(&f, Projection::None);
            for k in 0..6 {
                assert!((stress[(k % 3, k / 3)] - jet.gradient[k]).abs() < 1e-13 * scale, "round {round}");
                for l in 0..6 {
                    let error = stiffness[(k, l)] - jet.hessian(k, l);
                    assert!(
                        error.abs() < 2e-12 * scale,
                        "round {round}: ({k}, {l}) off by {error:e}, {scale:e}"
                    );
                }
            }
        }
    }
}

/// The closed-form projection against a numeric one of the same matrix.
#[test]
fn closed_form_projection_is_the_spectral_one() {
    let mut random = Random(3);
    let laws: [&dyn SheetLaw; 3] = [
        &NeoHookeanSheet::new(3.0, 0.45).unwrap(),
        &NeoHookeanSheet::new(3.0, -0.4).unwrap(),
        &SaintVenantKirchhoffSheet::new(3.0, 0.2).unwrap(),
    ];
    let mut negative = 0;
    for _ in 0..60 {
        let f = nalgebra::Matrix3x2::<f64>::from_fn(|i, j| {
            0.7 * f64::from(u8::from(i == j)) + 0.25 * random.number()
        });
        for law in laws {
            let exact = law.stiffness(&f, Projection::None);
            if law.energy_density(&f).is_infinite() {
                continue;
            }
            negative += usize::from(exact.symmetric_eigenvalues().min() < -1e-3);
            for projection in [Projection::Clamp, Projection::Absolute] {
                let numeric = project_symmetric(&exact, projection);
                let closed = law.stiffness(&f, projection);
                let error = (numeric - closed).amax() / exact.amax();
                assert!(error < 1e-12, "{projection:?} {error:e} {f}");
            }
        }
    }
    assert!(negative > 50, "{negative} cases had something to project");
}

#[test]
fn membranes_are_defined_where_singular_values_vanish_or_coincide() {
    let law = SaintVenantKirchhoffSheet::new(3.0, 0.3).unwrap();
    let coincident = nalgebra::Matrix3x2::new(0.8, 0.0, 0.0, 0.8, 0.0, 0.0);
    let line = nalgebra::Matrix3x2::new(1.0, 0.5, 0.2, 0.1, 0.0, 0.0);
    let line = nalgebra::Matrix3x2::from_columns(&[line.column(0).into_owned(), line.column(0) * 0.3]);
    for f in [nalgebra::Matrix3x2::zeros(), coincident, line] {
        let v: [Jet2<f64, 6>; 6] = Jet2::variables(std::array::from_fn(|k| f[(k % 3, k / 3)]));
        let (a, b) = ([v[0], v[1], v[2]], [v[3], v[4], v[5]]);
        let jet = saint_venant(3.0, 0.3, [dot(&a, &a), dot(&a, &b), dot(&b, &b)]);
        let stiffness = law.stiffness(&f, Projection::None);
        let expected = SMatrix::<f64, 6, 6>::from_fn(|i, j| jet.hessian(i, j));
        assert!((stiffness - expected).amax() < 1e-14, "{stiffness} {expected}");
    }
    let neo_hookean = NeoHookeanSheet::new(3.0, 0.3).unwrap();
    assert_eq!(neo_hookean.energy_density(&nalgebra::Matrix3x2::zeros()), f64::INFINITY);
}

fn hinge_angle<S: Scalar>(x: &[S; 12]) -> S {
    let point = |i: usize| [x[3 * i], x[3 * i + 1], x[3 * i + 2]];
    let minus = |a: [S; 3], b: [S; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let e = minus(point(1), point(0));
    let (m1, m2) = (cross(&e, &minus(point(2), point(0))), cross(&minus(point(3), point(0)), &e));
    let sine = dot(&cross(&m2, &m1), &e) / dot(&e, &e).sqrt();
    sine.atan2(dot(&m1, &m2))
}

#[test]
fn the_dihedral_angle_and_its_derivatives_agree_with_automatic_differentiation() {
    let mut random = Random(4);
    for round in 0..60 {
        let mut x = corners(&mut random);
        let scale = [1.0, 1e-4, 1e5][round % 3];
        x[2] += random.vector() * [0.0, 0.7, 2.0][round / 20];
        let x = x.map(|x| x * scale);
        let jet = hinge_angle(&Jet2::<f64, 12>::variables(std::array::from_fn(|k| x[k / 3][k % 3])));
        assert!((dihedral_angle(&x) - jet.value).abs() < 1e-14);
        let derivatives = dihedral_derivatives(&x);
        let largest = jet.hessian_matrix().as_flattened().iter().fold(0.0_f64, |m, h| m.max(h.abs()));
        let steepest = jet.gradient.iter().fold(0.0_f64, |m, g| m.max(g.abs()));
        for k in 0..12 {
            assert!((derivatives.gradient[k / 3][k % 3] - jet.gradient[k]).abs() < 1e-13 * steepest);
            for l in 0..12 {
                let error = derivatives.hessian[k / 3][l / 3][(k % 3, l % 3)] - jet.hessian(k, l);
                assert!(error.abs() < 1e-12 * largest, "round {round}: ({k}, {l}) {error:e} of {largest:e}");
            }
        }
    }
}

/// A wing turned about the edge by a known angle, through all angles, tiny ones too.
#[test]
fn the_dihedral_angle_is_the_one_the_wing_is_turned_by() {
    for angle in [0.0, 1e-300, 1e-12, 1e-6, 0.1, 1.0, 1.6, 3.0, 3.13, -1e-9, -0.5, -2.5, -3.12] {
        let (c, s) = (f64::cos(angle), f64::sin(angle));
        let x = [Vec3::zeros(), Vec3::x() * 2.0, Vec3::new(0.3, 1.5 * c, 1.5 * s), Vec3::new(0.9, -0.7, 0.0)];
        let found = dihedral_angle(&x);
        assert!((found - angle).abs() <= 4.0 * f64::EPSILON * f64::abs(angle), "{angle} {found}");
    }
}

#[test]
fn hinges_pass_the_derivative_checker_and_project_to_semi_definite() {
    let mut random = Random(5);
    for round in 0..30 {
        let rest = corners(&mut random);
        let hinges = Hinges::new(&mesh(&rest), 2.0, RestAngle::OfMesh).unwrap();
        let size = [0.01, 0.3, 1.0][round % 3];
        let x: [Vec3; 4] = std::array::from_fn(|i| {
            let point = rest[hinges.points()[0][i] as usize];
            point + random.vector() * size * if i < 2 { 0.2 } else { 1.0 }
        });
        check_stencil(&hinges, 0, &x).require(1e-6).unwrap_or_else(|e| panic!("round {round}: {e}"));
        for method in [BendingHessian::Spectral, BendingHessian::GaussNewton] {
            let hinges = hinges.clone().with_hessian(method);
            for projection in [Projection::Clamp, Projection::Absolute] {
                assert!(relative_lowest(&hinges.hessian(0, &x, projection)) > -1e-14);
            }
        }
        let spectral = hinges.clone().with_hessian(BendingHessian::Spectral);
        let projected = flat(&spectral.hessian(0, &x, Projection::Clamp));
        let numeric = project_symmetric(&flat(&hinges.hessian(0, &x, Projection::None)), Projection::Clamp);
        assert!((projected - numeric).amax() < 1e-12 * numeric.amax());
    }
}

fn flat(h: &mechanics_core::stencil::LocalHessian<4>) -> SMatrix<f64, 12, 12> {
    SMatrix::from_fn(|i, j| h[i / 3][j / 3][(i % 3, j % 3)])
}

#[test]
fn rigid_motions_change_no_energy_and_forces_turn_along() {
    let mut random = Random(6);
    for _ in 0..20 {
        let rest = corners(&mut random);
        let mesh = mesh(&rest);
        let hinges = Hinges::new(&mesh, 2.0, RestAngle::Flat).unwrap();
        let x: [Vec3; 4] = std::array::from_fn(|i| rest[i] + random.vector() * 0.2);
        let (turn, shift) = (random.rotation(), random.vector() * 3.0);
        let moved = x.map(|x| turn * x + shift);
        let same = |a: f64, b: f64| assert!((a - b).abs() < 1e-13 * a.abs().max(1e-3), "{a} {b}");
        same(hinges.value(0, &x), hinges.value(0, &moved));
        for (a, b) in hinges.gradient(0, &x).iter().zip(hinges.gradient(0, &moved)) {
            assert!((turn * a - b).norm() < 1e-12 * (1.0 + a.norm()));
        }
        let triangle = [x[0], x[1], x[2]];
        let moved = [moved[0], moved[1], moved[2]];
        for (name, sheet) in sheets(&mesh).iter().filter(|(name, _)| *name != "linear") {
            same(sheet.value(0, &triangle), sheet.value(0, &moved));
            let rest = [rest[0], rest[1], rest[2]].map(|x| turn * x + shift);
            assert!(sheet.value(0, &rest) < 1e-28, "{name} at rest, moved");
            let forces = sheet.gradient(0, &triangle);
            let torque: Vec3 = forces.iter().zip(&triangle).map(|(f, x)| x.cross(f)).sum();
            assert!(forces.iter().sum::<Vec3>().norm() < 1e-14 && torque.norm() < 1e-14);
        }
    }
}
