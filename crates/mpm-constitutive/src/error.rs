//! Why a law cannot be built or evaluated.

use mechanics_core::law::LawError;
use std::fmt::{self, Display, Formatter};

/// A parameter of a law, as named in errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parameter {
    /// η [Pa s].
    ShearViscosity,
    /// ζ [Pa s].
    BulkViscosity,
    /// K \[Pa\].
    BulkModulus,
    /// γ of Tait and Murnaghan.
    StiffeningExponent,
    /// σ₀ \[Pa\].
    YieldStress,
    /// H \[Pa\].
    HardeningModulus,
    /// σ∞ \[Pa\].
    SaturationStress,
    /// δ, the rate of approach to saturation.
    SaturationRate,
    /// φ [rad].
    FrictionAngle,
    /// c \[Pa\].
    Cohesion,
    /// The decay rate of friction hardening.
    FrictionHardeningRate,
    /// θ_c.
    CriticalCompression,
    /// θ_s.
    CriticalStretch,
    /// ξ of snow.
    SnowHardening,
    /// M.
    CriticalStateSlope,
    /// β.
    TensileRatio,
    /// p_c at rest \[Pa\].
    Preconsolidation,
    /// ζ, ξ of clay.
    ConsolidationRate,
    /// Plastic volume strain at rest.
    InitialCompaction,
    /// k [Pa sʰ].
    Consistency,
    /// h of Herschel and Bulkley.
    FlowIndex,
}

impl Display for Parameter {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::ShearViscosity => "the shear viscosity [Pa s]",
            Self::BulkViscosity => "the bulk viscosity [Pa s]",
            Self::BulkModulus => "the bulk modulus [Pa]",
            Self::StiffeningExponent => "the stiffening exponent",
            Self::YieldStress => "the yield stress [Pa]",
            Self::HardeningModulus => "the hardening modulus [Pa]",
            Self::SaturationStress => "the saturation stress [Pa]",
            Self::SaturationRate => "the saturation rate",
            Self::FrictionAngle => "the friction angle [rad]",
            Self::Cohesion => "the cohesion [Pa]",
            Self::FrictionHardeningRate => "the rate of friction hardening",
            Self::CriticalCompression => "the critical compression",
            Self::CriticalStretch => "the critical stretch",
            Self::SnowHardening => "the hardening of snow",
            Self::CriticalStateSlope => "the slope of the critical state line",
            Self::TensileRatio => "the ratio of tensile to compressive strength",
            Self::Preconsolidation => "the preconsolidation pressure [Pa]",
            Self::ConsolidationRate => "the rate of consolidation",
            Self::InitialCompaction => "the initial plastic compaction",
            Self::Consistency => "the consistency [Pa s^h]",
            Self::FlowIndex => "the flow index",
        })
    }
}

/// Why a law of a material point cannot be built or evaluated.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PointLawError {
    /// Elastic parameters out of range, or a strain outside the law's domain.
    #[error(transparent)]
    Elastic(#[from] LawError),
    /// A parameter is out of its range, or not a number.
    #[error("{parameter} must be {allowed}, but it is {value}")]
    OutOfRange {
        /// Which one.
        parameter: Parameter,
        /// The refused value.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// The deformation or its history is so extreme that the stress is no finite number of the type computed with.
    #[error(
        "the stress of a deformation gradient with determinant {determinant} is too large to be represented: the simulation has \
         become unstable (a smaller time step?), or units are mixed"
    )]
    Overflow {
        /// det F.
        determinant: f64,
    },
    /// Softening is so steep that a strain would have several stresses.
    #[error(
        "the yield stress falls by up to {slope} Pa per unit of plastic strain, and at or beyond three times the shear modulus \
         ({limit} Pa) the stress is not unique: soften less, or take a stiffer solid"
    )]
    Softening {
        /// The steepest fall −dσ_y/dα \[Pa\].
        slope: f64,
        /// 3μ \[Pa\].
        limit: f64,
    },
}

pub(crate) fn require(
    parameter: Parameter,
    value: f64,
    holds: impl Fn(f64) -> bool,
    allowed: &'static str,
) -> Result<(), PointLawError> {
    // Comparisons with NaN are false, so that NaN is refused.
    if value.is_finite() && holds(value) {
        Ok(())
    } else {
        Err(PointLawError::OutOfRange { parameter, value, allowed })
    }
}

pub(crate) fn positive(parameter: Parameter, value: f64) -> Result<(), PointLawError> {
    require(parameter, value, |v| v > 0.0, "positive and finite")
}

pub(crate) fn not_negative(parameter: Parameter, value: f64) -> Result<(), PointLawError> {
    require(parameter, value, |v| v >= 0.0, "finite and not negative")
}
