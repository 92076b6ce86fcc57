//! Objectivity, isotropy, symmetry, the rest state, the domain, other scalars.

use crate::cases::{Random, Visit, defined, each_law, lame, special};
use mechanics_core::law::{Domain, Hyperelastic, Lame, LawError, Linear, Stiffness};
use mechanics_core::projection::Projection;
use mechanics_core::tensor::{Mat3, Matrix3};
use nalgebra::SMatrix;

type Mat9 = SMatrix<f64, 9, 9>;

const PROJECTIONS: [Projection; 3] = [Projection::None, Projection::Clamp, Projection::Absolute];

/// (QF R): vec(Q dF R) as a 9×9 matrix.
fn rotation_of_gradients(q: &Mat3, r: &Mat3) -> Mat9 {
    Mat9::from_fn(|row, column| q[(row % 3, column % 3)] * r[(column / 3, row / 3)])
}

struct Symmetry;

impl Visit for Symmetry {
    fn visit<L: Hyperelastic>(&mut self, name: &str, law: &L) {
        if name == "linear" {
            return;
        }
        let mut random = Random::new(11);
        for case in 0..300 {
            let f = if law.domain() == Domain::EveryDeformation && case % 3 == 0 {
                random.matrix() * 2.0
            } else {
                random.moderate()
            };
            let (q, r) = (random.rotation(), random.rotation());
            for (turned, left, right) in
                [(q * f, q, Mat3::identity()), (f * r, Mat3::identity(), r), (q * f * r, q, r)]
            {
                let (energy, stress) = (law.energy_density(&f), law.first_piola(&f));
                assert!(
                    (law.energy_density(&turned) - energy).abs() <= 1e-13 * (1.0 + energy),
                    "{name} energy"
                );
                let error = (law.first_piola(&turned) - left * stress * right).norm();
                assert!(error <= 1e-12 * (1.0 + stress.norm()), "{name}: stress off by {error:e}");
                // A reflection of singular axes may change a clamped curvature near the crest; see the law.
                let expected = rotation_of_gradients(&left, &right)
                    * law.stiffness(&f, Projection::None).to_matrix()
                    * rotation_of_gradients(&left, &right).transpose();
                let stiffness = law.stiffness(&turned, Projection::None).to_matrix();
                let error = (stiffness - expected).norm() / expected.norm();
                let gap = f.singular_values()[1] + f.singular_values()[2] * f.determinant().signum();
                assert!(error <= 1e-12 / gap.min(1.0), "{name}: stiffness off by {error:e} at {f}");
            }
        }
    }
}

#[test]
fn laws_are_objective_and_isotropic() {
    each_law(&mut Symmetry);
}

struct MajorSymmetry;

impl Visit for MajorSymmetry {
    fn visit<L: Hyperelastic>(&mut self, name: &str, law: &L) {
        let mut random = Random::new(12);
        for case in 0..500 {
            let f = random.hard(case);
            if !defined(law, &f) {
                continue;
            }
            for projection in PROJECTIONS {
                let stiffness = law.stiffness(&f, projection);
                let c = stiffness.to_matrix();
                assert!((c - c.transpose()).norm() <= 1e-14 * c.norm(), "{name} {projection:?} at {f}");
                // The three ways to read a stiffness agree.
                let df = random.matrix();
                let product = c * SMatrix::<f64, 9, 1>::from_column_slice(df.as_slice());
                let error = (stiffness.apply(&df) - Mat3::from_column_slice(product.as_slice())).norm();
                assert!(error <= 1e-13 * c.norm(), "{name}: apply at {f}");
                let again = Stiffness::from_matrix(&c);
                assert!((again.to_matrix() - c).norm() <= 1e-14 * c.norm(), "{name}: from_matrix");
            }
        }
    }
}

#[test]
fn stiffness_is_symmetric_in_every_form() {
    each_law(&mut MajorSymmetry);
}

struct Rest;

impl Visit for Rest {
    fn visit<L: Hyperelastic>(&mut self, name: &str, law: &L) {
        let linear = Linear::new(lame());
        let identity = Mat3::identity();
        assert!(law.energy_density(&identity).abs() <= 1e-30, "{name}: energy at rest");
        assert!(law.first_piola(&identity).norm() <= 1e-15, "{name}: stress at rest");
        let expected = linear.stiffness(&identity, Projection::None).to_matrix();
        for projection in PROJECTIONS {
            let c = law.stiffness(&identity, projection).to_matrix();
            assert!((c - expected).norm() <= 2e-14, "{name} {projection:?}: stiffness at rest{c}");
        }
        // The energy itself approaches the linear one at first order in the strain, without losing digits.
        let mut random = Random::new(13);
        let direction = random.matrix();
        for exponent in 3..12 {
            let size = 10.0_f64.powi(-exponent);
            let f = identity + direction * size;
            let ratio = law.energy_density(&f) / linear.energy_density(&f);
            let allowed = 20.0 * size + 1e-14 / size;
            assert!((ratio - 1.0).abs() <= allowed, "{name}: ratio {ratio} at strain {size:e}");
        }
    }
}

#[test]
fn rest_is_free_of_stress_and_stiff_as_linear_elasticity() {
    each_law(&mut Rest);
}

struct Outside;

impl Visit for Outside {
    fn visit<L: Hyperelastic>(&mut self, name: &str, law: &L) {
        let inverted = Mat3::from_diagonal(&nalgebra::Vector3::new(1.0, 1.0, -1.0));
        let nan = Mat3::from_element(f64::NAN);
        assert!(law.energy_density(&nan).is_nan(), "{name}: NaN in, NaN out");
        if name != "linear" {
            assert!(law.first_piola(&nan).iter().all(|entry| entry.is_nan()), "{name}");
            for projection in PROJECTIONS {
                let c = law.stiffness(&nan, projection).to_matrix();
                assert!(c.iter().all(|entry| entry.is_nan()), "{name} {projection:?}: NaN is not hidden");
            }
        }
        assert!(matches!(law.check_admissible(&nan), Err(LawError::Inadmissible { .. })), "{name}");
        assert_eq!(law.check_admissible(&Mat3::identity()), Ok(()));
        match law.domain() {
            Domain::EveryDeformation => {
                for f in special() {
                    assert!(law.energy_density(&f).is_finite(), "{name} at {f}");
                    assert!(law.first_piola(&f).iter().all(|entry| entry.is_finite()), "{name} at {f}");
                    assert_eq!(law.check_admissible(&f), Ok(()));
                }
                assert_eq!(law.largest_step(&inverted, &inverted), f64::INFINITY);
            }
            Domain::PositiveVolume => {
                assert_eq!(law.energy_density(&inverted), f64::INFINITY, "{name}");
                assert_eq!(law.energy_density(&Mat3::zeros()), f64::INFINITY, "{name}");
                let refusal = law.check_admissible(&inverted);
                assert_eq!(refusal, Err(LawError::Inadmissible { determinant: -1.0 }));
                assert_eq!(law.largest_step(&inverted, &Mat3::identity()), 0.0);
                let step = law.largest_step(&Mat3::identity(), &-Mat3::identity());
                assert!(step < 1.0 && step > 1.0 - 1e-4, "{name}: {step}");
            }
        }
    }
}

#[test]
fn outside_of_the_domain_is_told() {
    each_law(&mut Outside);
}

struct SinglePrecision;

impl Visit for SinglePrecision {
    fn visit<L: Hyperelastic>(&mut self, name: &str, law: &L) {
        let mut random = Random::new(14);
        for _ in 0..300 {
            let f = random.moderate();
            let single: Matrix3<f32> = f.cast();
            let f: Mat3 = single.cast();
            let scale = law.stiffness(&f, Projection::None).to_matrix().norm() as f32;
            let energy = law.energy_density(&f) as f32;
            assert!((law.energy_density(&single) - energy).abs() <= 1e-5 * scale, "{name}");
            let stress: Matrix3<f32> = law.first_piola(&f).cast();
            assert!((law.first_piola(&single) - stress).norm() <= 1e-5 * scale, "{name}");
            for projection in PROJECTIONS {
                let c: SMatrix<f32, 9, 9> = law.stiffness(&f, projection).to_matrix().cast();
                let error = (law.stiffness(&single, projection).to_matrix() - c).norm();
                assert!(error <= 2e-5 * scale, "{name} {projection:?}: {error}");
            }
        }
    }
}

#[test]
fn single_precision_agrees_with_double() {
    each_law(&mut SinglePrecision);
}

#[test]
fn stiff_and_nearly_incompressible_materials_keep_their_rest_state() {
    struct Stiff(Lame);
    impl Visit for Stiff {
        fn visit<L: Hyperelastic>(&mut self, name: &str, law: &L) {
            let stress = law.first_piola(&Mat3::identity()).norm();
            assert!(stress <= 1e-14 * self.0.bulk_modulus(), "{name}: {stress:e} at rest");
        }
    }
    for (young, poisson) in [(2e11, 0.3), (1e4, 0.4999), (1e6, -0.9)] {
        let lame = Lame::from_young_poisson(young, poisson).unwrap();
        crate::cases::each_law_of(lame, &mut Stiff(lame));
    }
}
