//! Reading trajectories, and slopes of errors.

use serde_json::Value;

/// The samples of a fixture.
pub(crate) fn samples(text: &str) -> Vec<Value> {
    let file: Value = serde_json::from_str(text).unwrap();
    file["samples"].as_array().unwrap().clone()
}

/// A number that is a number or a decimal in a string.
pub(crate) fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| value.as_str().unwrap().parse().unwrap())
}

/// Observed orders between halvings: log₂ of quotients.
pub(crate) fn orders(errors: &[f64]) -> Vec<f64> {
    errors.windows(2).map(|e| (e[0] / e[1]).log2()).collect()
}

pub(crate) fn largest_gap(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}
