//! Checks of parameters.

use crate::error::LagrangianError;

/// `value` if it is positive and finite.
pub(super) fn positive(
    system: &'static str,
    parameter: &'static str,
    value: f64,
) -> Result<f64, LagrangianError> {
    if value > 0.0 && value.is_finite() {
        return Ok(value);
    }
    Err(LagrangianError::Parameter { system, parameter, value, requirement: "positive and finite" })
}

/// `value` if it is zero or positive, and finite.
pub(super) fn not_negative(
    system: &'static str,
    parameter: &'static str,
    value: f64,
) -> Result<f64, LagrangianError> {
    if value >= 0.0 && value.is_finite() {
        return Ok(value);
    }
    Err(LagrangianError::Parameter { system, parameter, value, requirement: "finite and not negative" })
}

/// `value` if it is finite.
pub(super) fn finite(
    system: &'static str,
    parameter: &'static str,
    value: f64,
) -> Result<f64, LagrangianError> {
    if value.is_finite() {
        return Ok(value);
    }
    Err(LagrangianError::Parameter { system, parameter, value, requirement: "finite" })
}
