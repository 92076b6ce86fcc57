//! The validation part of a scene: what it claims, how that is judged, and which runs it takes.

use super::quantity::{Count, Finite, NonNegative, Positive, Seed};
use crate::record::Reference;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What a scene claims and how the claim is judged.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Validation {
    /// A short human title.
    pub title: String,
    /// One paragraph: what is claimed.
    pub claim: String,
    /// The closed form or statement compared with, in plain text.
    #[serde(default)]
    pub formula: String,
    /// The truth.
    pub reference: Reference,
    /// The suites it belongs to.
    pub suites: Vec<Suite>,
    /// What is measured; the first one is plotted. May be empty for hard cases, which have invariants only.
    #[serde(default)]
    pub measures: Vec<MeasureSpec>,
    /// Bounds on invariants by name.
    #[serde(default)]
    pub invariants: BTreeMap<String, Bounds>,
    /// What is varied.
    pub ladder: Ladder,
    /// One work–precision line each.
    pub methods: Vec<String>,
    /// For physical scenes: the key of the scene that takes the method's name, such as `solver.linear`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub method_sets: Option<String>,
    /// Seeds of hard cases; each method runs once for each of them.
    #[serde(default)]
    pub seeds: Vec<Seed>,
    /// Thread counts; one thread when absent. `--threads` takes precedence.
    #[serde(default = "one_thread")]
    pub threads: Vec<Count>,
    /// Runs that are timed; `--repeat` takes precedence.
    #[serde(default = "one_run")]
    pub repeats: Count,
    /// A row may take so long, warm-up and repeats together (s).
    pub time_limit_s: Positive,
}

fn one_run() -> Count {
    Count::ONE
}

fn one_thread() -> Vec<Count> {
    vec![Count::ONE]
}

/// A suite.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema, clap::ValueEnum,
)]
#[serde(rename_all = "kebab-case")]
pub enum Suite {
    /// All scenes of it together take less than two minutes on two cores.
    Quick,
    /// Everything with a reference.
    Full,
    /// Hard cases: survived or not.
    Stress,
}

impl std::fmt::Display for Suite {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Quick => "quick",
            Self::Full => "full",
            Self::Stress => "stress",
        })
    }
}

/// An error measure and what is expected of it.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeasureSpec {
    /// The name under which the experiment reports it.
    pub name: String,
    /// Its unit; `1` for a relative error.
    pub unit: String,
    /// The largest value allowed at the ladder's last point.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bound: Option<NonNegative>,
    /// The largest value allowed at the last point of the quick suite, where that suite has fewer points.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub quick_bound: Option<NonNegative>,
    /// The expected slope of log error over log ladder value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub order: Option<Finite>,
    /// How far the observed order may be from the expected one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub order_tolerance: Option<Positive>,
    /// The order is fitted from this ladder value on; coarser points are not yet asymptotic. From the first one if
    /// absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub order_from: Option<Positive>,
    /// The round-off floor: errors at most this large say nothing about the order, and differences below it are
    /// no regression. Without it no point is taken to be on the floor unless its error is zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub floor: Option<Positive>,
    /// What is expected of single methods; it takes precedence over the measure's own, number by number.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub methods: BTreeMap<String, Expectation>,
}

/// What is expected of one method in one measure.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Expectation {
    /// The largest value allowed at the ladder's last point.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bound: Option<NonNegative>,
    /// The largest value allowed at the last point of the quick suite.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub quick_bound: Option<NonNegative>,
    /// The expected slope of log error over log ladder value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub order: Option<Finite>,
    /// How far the observed order may be from the expected one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub order_tolerance: Option<Positive>,
    /// The order is fitted from this ladder value on; coarser points are not yet asymptotic. From the first one if
    /// absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub order_from: Option<Positive>,
    /// The round-off floor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub floor: Option<Positive>,
}

impl MeasureSpec {
    /// What is expected of the line with this label: a method's name, followed by `, seed …` where there are seeds.
    pub fn expectation(&self, label: &str) -> Expectation {
        let method = label.split_once(", seed ").map_or(label, |(method, _)| method);
        let own = self.methods.get(method).copied().unwrap_or_default();
        Expectation {
            bound: own.bound.or(self.bound),
            quick_bound: own.quick_bound.or(self.quick_bound),
            order: own.order.or(self.order),
            order_tolerance: own.order_tolerance.or(self.order_tolerance),
            order_from: own.order_from.or(self.order_from),
            floor: own.floor.or(self.floor),
        }
    }
}

/// What the points of a work–precision line differ in, from coarse to fine.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ladder {
    /// Its name: `h`, `Δx`, `tolerance`, ….
    pub name: String,
    /// Its unit; `1` for a count or a ratio.
    pub unit: String,
    /// Its values, coarse to fine.
    pub values: Vec<Positive>,
    /// The quick suite runs only so many of them, the coarsest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub quick_points: Option<Count>,
    /// For physical scenes: the key that takes the value, such as `integration.backward-euler.step_s`; entries
    /// of a list are addressed by their number, as in `meshes.0.source.sphere.edge_m`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sets: Option<String>,
}

/// The range an invariant must stay in; both ends are allowed values.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Bounds {
    /// The smallest value allowed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min: Option<Finite>,
    /// The largest value allowed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max: Option<Finite>,
    /// The value must be above this one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub above: Option<Finite>,
}
