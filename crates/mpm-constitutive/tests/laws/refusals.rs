//! Parameters out of range: errors that name the parameter and its value.

use crate::materials::lame;
use mechanics_core::law::LawError;
use mechanics_core::tensor::Mat3;
use mpm_constitutive::elastic::{FixedCorotated, Hencky};
use mpm_constitutive::fluid::{Tait, Tension};
use mpm_constitutive::plastic::{
    DruckerPrager, FrictionAngle, HerschelBulkley, ModifiedCamClay, NonAssociativeCamClay, Snow, VonMises,
    YieldStress,
};
use mpm_constitutive::{Parameter, PointLaw, PointLawError, Viscosity};

/// The constructor must refuse every value listed and name `parameter`.
#[track_caller]
fn refuses<T>(parameter: Parameter, values: &[f64], build: impl Fn(f64) -> Result<T, PointLawError>) {
    for &value in values.iter().chain(&[f64::NAN, f64::INFINITY, f64::NEG_INFINITY]) {
        match build(value).err() {
            Some(PointLawError::OutOfRange { parameter: named, value: refused, .. }) => {
                assert_eq!(named, parameter);
                assert!(refused == value || value.is_nan(), "{refused} is not {value}");
            }
            other => panic!("{parameter} = {value}: {other:?}"),
        }
    }
}

#[test]
fn parameters_out_of_range_are_named_with_their_value() {
    use Parameter as P;
    let (bad, positive) = ([-1.0], [0.0, -1.0]);
    let perfect = || YieldStress::perfect(1e4).unwrap();
    let angle = || FrictionAngle::constant(0.5).unwrap();
    refuses(P::ShearViscosity, &bad, |v| Viscosity::new(v, 0.0));
    refuses(P::BulkViscosity, &bad, |v| Viscosity::new(0.0, v));
    refuses(P::BulkModulus, &positive, |v| Tait::new(v, 7.0, Tension::Carried));
    refuses(P::StiffeningExponent, &positive, |v| Tait::new(1.0, v, Tension::Carried));
    refuses(P::YieldStress, &positive, YieldStress::perfect);
    refuses(P::HardeningModulus, &bad, |v| YieldStress::linear(1.0, v));
    refuses(P::SaturationStress, &positive, |v| perfect().saturating(v, 1.0));
    refuses(P::SaturationRate, &positive, |v| perfect().saturating(2e4, v));
    refuses(P::FrictionAngle, &[0.0, -0.1, 1.6], FrictionAngle::constant);
    refuses(P::FrictionHardeningRate, &bad, |v| FrictionAngle::hardening([0.6, v, 0.3, 0.1]));
    refuses(P::FrictionHardeningRate, &positive, |v| FrictionAngle::hardening([0.6, 0.1, v, 0.1]));
    refuses(P::Cohesion, &bad, |v| DruckerPrager::new(lame(), angle(), v));
    refuses(P::CriticalCompression, &[-0.1, 1.0], |v| Snow::new(lame(), v, 0.0, 1.0));
    refuses(P::CriticalStretch, &bad, |v| Snow::new(lame(), 0.1, v, 1.0));
    refuses(P::SnowHardening, &bad, |v| Snow::new(lame(), 0.1, 0.1, v));
    refuses(P::CriticalStateSlope, &positive, |v| ModifiedCamClay::new(lame(), v, 0.0, 1.0, 1.0));
    refuses(P::TensileRatio, &[-0.1, 1.1], |v| NonAssociativeCamClay::new(lame(), 1.0, v, 1.0, 0.1));
    refuses(P::Preconsolidation, &positive, |v| ModifiedCamClay::new(lame(), 1.0, 0.0, v, 1.0));
    refuses(P::ConsolidationRate, &bad, |v| ModifiedCamClay::new(lame(), 1.0, 0.0, 1.0, v));
    refuses(P::ConsolidationRate, &positive, |v| NonAssociativeCamClay::new(lame(), 1.0, 0.0, v, 0.1));
    refuses(P::InitialCompaction, &bad, |v| NonAssociativeCamClay::new(lame(), 1.0, 0.0, 1.0, v));
    refuses(P::Consistency, &positive, |v| HerschelBulkley::new(lame(), 1.0, v, 0.5));
    refuses(P::FlowIndex, &positive, |v| HerschelBulkley::new(lame(), 1.0, 1.0, v));
}

#[test]
fn a_friction_angle_that_would_leave_its_range_later_is_refused() {
    // Starts at 0.6, peaks above π/2 at q = 1/c.
    let steep = FrictionAngle::hardening([0.6, 10.0, 1.0, 0.0]);
    assert!(
        matches!(steep, Err(PointLawError::OutOfRange { parameter: Parameter::FrictionAngle, .. })),
        "{steep:?}"
    );
    assert!(FrictionAngle::hardening([0.1, 0.0, 1.0, 0.2]).is_err(), "negative at the start");
}

#[test]
fn softening_faster_than_the_solid_can_follow_is_refused() {
    let brittle = YieldStress::perfect(1e6).unwrap().saturating(1e3, 100.0).unwrap();
    let error = VonMises::new(lame(), brittle).unwrap_err();
    assert!(
        matches!(error, PointLawError::Softening { slope, limit } if slope > 9e7 && (limit - 2.1e6).abs() < 1.0)
    );
}

#[test]
fn sentences_name_value_and_remedy() {
    let text = Viscosity::new(-2.5, 0.0).unwrap_err().to_string();
    assert_eq!(text, "the shear viscosity [Pa s] must be finite and not negative, but it is -2.5");
}

#[test]
fn inverted_solids_are_refused_where_the_law_ends() {
    let mirror = Mat3::from_diagonal(&nalgebra::Vector3::new(1.0, 1.0, -0.5));
    let error = Hencky::new(lame()).check_admissible(&mirror, &()).unwrap_err();
    assert_eq!(error, PointLawError::Elastic(LawError::Inadmissible { determinant: -0.5 }));
    assert_eq!(FixedCorotated::new(lame()).check_admissible(&mirror, &()), Ok(()));
    let huge = Mat3::identity() * 1e60;
    assert!(matches!(
        FixedCorotated::new(lame()).check_admissible(&huge, &()),
        Err(PointLawError::Overflow { .. })
    ));
}
