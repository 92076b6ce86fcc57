//! Checks of parameters.

use crate::error::LagrangianError;

/// `value` if it is positive and finite.
pub(super) fn positive(
    system: &'static str,
    parameter: &'static str,
    value: f64,
) -> Result<f64, LagrangianError> {
    accept(system, parameter, value, value > 0.0 && value.is_finite(), "positive and finite")
}

/// `value` if it is zero or positive, and finite.
pub(super) fn not_negative(
    system: &'static str,
    parameter: &'static str,
    value: f64,
) -> Result<f64, LagrangianError> {
    accept(system, parameter, value, value >= 0.0 && value.is_finite(), "finite and not negative")
}

/// `value` if it is finite.
pub(super) fn finite(
    system: &'static str,
    parameter: &'static str,
    value: f64,
) -> Result<f64, LagrangianError> {
    accept(system, parameter, value, value.is_finite(), "finite")
}

fn accept(
    system: &'static str,
    parameter: &'static str,
    value: f64,
    accepted: bool,
    requirement: &'static str,
) -> Result<f64, LagrangianError> {
    if accepted {
        Ok(value)
    } else {
        Err(LagrangianError::Parameter { system, parameter, value, requirement })
    }
}
