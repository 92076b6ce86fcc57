//! Numbers of a scene file that are checked as they are read. Their unit is part of the key that holds them
//! (`density_kg_m3`, `step_s`), so a wrong unit is an unknown key, which the reader refuses.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Declares a number that is checked when it is read, with the same rule in the JSON Schema.
macro_rules! checked_number {
    ($(#[$doc:meta])* $name:ident($raw:ty), $allowed:literal, $test:expr, $schema:tt) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize, Deserialize)]
        #[serde(try_from = "f64", into = "f64")]
        pub struct $name($raw);

        impl $name {
            /// The number itself.
            pub fn value(self) -> $raw {
                self.0
            }
        }

        impl TryFrom<f64> for $name {
            type Error = String;

            fn try_from(value: f64) -> Result<Self, String> {
                let allowed: fn(f64) -> bool = $test;
                if allowed(value) { Ok(Self(value as $raw)) } else { Err(format!("{value} is not allowed: must be {}", $allowed)) }
            }
        }

        impl From<$name> for f64 {
            fn from(number: $name) -> f64 {
                number.0 as f64
            }
        }

        impl JsonSchema for $name {
            fn inline_schema() -> bool {
                true
            }

            fn schema_name() -> Cow<'static, str> {
                stringify!($name).into()
            }

            fn json_schema(_: &mut SchemaGenerator) -> Schema {
                json_schema!($schema)
            }
        }
    };
}

checked_number!(
    /// Any finite number.
    Finite(f64), "a finite number", |v| v.is_finite(), { "type": "number" });
checked_number!(
    /// A finite number above zero: a density, a stiffness, a length, a time step.
    Positive(f64), "a finite number > 0", |v| v.is_finite() && v > 0.0, { "type": "number", "exclusiveMinimum": 0 });
checked_number!(
    /// A finite number that is zero or more: an error bound, a damping.
    NonNegative(f64), "a finite number ≥ 0", |v| v.is_finite() && v >= 0.0, { "type": "number", "minimum": 0 });
checked_number!(
    /// A part of a whole: an opacity, a colour.
    Share(f64), "from 0 to 1", |v| (0.0..=1.0).contains(&v), { "type": "number", "minimum": 0, "maximum": 1 });
checked_number!(
    /// A finite number of at least one: a ratio of larger to smaller.
    AtLeastOne(f64), "a finite number ≥ 1", |v| v.is_finite() && v >= 1.0, { "type": "number", "minimum": 1 });
checked_number!(
    /// Poisson's ratio of a stable isotropic solid.
    PoissonRatio(f64), "above -1 and below 0.5", |v| v > -1.0 && v < 0.5,
    { "type": "number", "exclusiveMinimum": -1, "exclusiveMaximum": 0.5 });
checked_number!(
    /// A whole number of at least one: cells, steps, repeats, threads.
    Count(usize), "a whole number ≥ 1 and ≤ 1000000000", |v| (1.0..=1e9).contains(&v) && v.fract() == 0.0,
    { "type": "integer", "minimum": 1, "maximum": 1_000_000_000 });
checked_number!(
    /// The seed of a hard case.
    Seed(u64), "a whole number ≥ 0 and ≤ 9007199254740992", |v| (0.0..=9_007_199_254_740_992.0).contains(&v) && v.fract() == 0.0,
    { "type": "integer", "minimum": 0, "maximum": 9_007_199_254_740_992_u64 });

impl Count {
    /// One.
    pub const ONE: Self = Self(1);
}

/// A point, a displacement, a force or a velocity: three finite numbers.
pub type Vector = [Finite; 3];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_outside_their_range_are_refused_with_what_is_allowed() {
        for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(Positive::try_from(value).is_err_and(|e| e.contains("must be a finite number > 0")));
        }
        for value in [-1.0, 0.5, 0.7, f64::NAN] {
            assert!(PoissonRatio::try_from(value).is_err());
        }
        for value in [0.0, 1.5, -3.0, 1e10, f64::NAN] {
            assert!(Count::try_from(value).is_err());
        }
        assert_eq!(Count::try_from(12.0).map(Count::value), Ok(12));
        assert_eq!(PoissonRatio::try_from(0.49999).map(PoissonRatio::value), Ok(0.49999));
    }
}
