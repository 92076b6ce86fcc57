//! The energy near rest against high precision, down to strains of 1e-12.

#![allow(clippy::unwrap_used, reason = "tests")]

use crate::cases::{Visit, each_law, lame};
use mechanics_core::lanes::{LaneKernel, Packet, dispatch, load_matrices};
use mechanics_core::law::Hyperelastic;
use mechanics_core::tensor::Mat3;
use serde_json::Value;

/// A deformation gradient, its energies, and how far it is from the identity.
struct Row {
    kind: String,
    f: Mat3,
    /// ‖FᵀF − I‖.
    metric_change: f64,
    /// ‖F − I‖.
    displacement: f64,
    energy: Value,
}

fn rows() -> Vec<Row> {
    let fixture: Value = serde_json::from_str(include_str!("../fixtures/laws_near_rest.json")).unwrap();
    let read = |row: &Value| {
        let bits = |k: usize| f64::from_bits(row["f"][k].as_str().unwrap().parse().unwrap());
        Row {
            kind: row["kind"].as_str().unwrap().to_owned(),
            f: Mat3::from_fn(|i, j| bits(3 * j + i)),
            metric_change: row["metric_change"].as_f64().unwrap(),
            displacement: row["displacement"].as_f64().unwrap(),
            energy: row["energy"].clone(),
        }
    };
    fixture["rows"].as_array().unwrap().iter().map(read).collect()
}

fn expected(row: &Row, name: &str) -> f64 {
    let key = name.to_lowercase().replace([' ', '.'], "-").replace("--", "-");
    row.energy[&key].as_str().unwrap_or_else(|| panic!("no `{key}`")).parse().unwrap()
}

/// A few ε(1 + r²/s): what the module of these energies derives.
fn allowed(row: &Row) -> f64 {
    let strain = row.metric_change;
    16.0 * f64::EPSILON * (1.0 + row.displacement.powi(2) / strain)
}

struct Accuracy(Vec<Row>);

impl Visit for Accuracy {
    fn visit<L: Hyperelastic>(&mut self, name: &str, law: &L) {
        for row in &self.0 {
            // A linear strain of a turned body is not small, and it is not of second order.
            if name == "linear" && row.kind.starts_with("turned") {
                continue;
            }
            let (energy, expected) = (law.energy_density(&row.f), expected(row, name));
            let error = (energy / expected - 1.0).abs();
            let allowed = allowed(row);
            assert!(
                error <= allowed,
                "{name}, {}: off by {error:e} (allowed {allowed:e}) at strain {:e}",
                row.kind,
                row.metric_change
            );
        }
    }
}

#[test]
fn energies_near_rest_have_their_digits() {
    assert_eq!((lame().lambda(), lame().mu()), (1.7, 0.9), "those of the fixture");
    let rows = rows();
    assert_eq!(rows.len(), 48);
    assert!(rows.iter().any(|row| row.metric_change < 2e-12 && row.displacement < 2e-12));
    each_law(&mut Accuracy(rows));
}

struct Energies<'a, L> {
    law: &'a L,
    matrices: &'a [Mat3],
}

impl<L: Hyperelastic> LaneKernel<f64> for Energies<'_, L> {
    type Output = Vec<f64>;
    #[inline(always)]
    fn run<P: Packet<Element = f64>>(self) -> Self::Output {
        let packets = self.matrices.chunks_exact(P::LANES);
        packets
            .flat_map(|f| self.law.energy_density(&load_matrices::<P>(f)).to_lanes().as_ref().to_vec())
            .collect()
    }
}

struct AccuracyInLanes(Vec<Row>);

impl Visit for AccuracyInLanes {
    fn visit<L: Hyperelastic>(&mut self, name: &str, law: &L) {
        let matrices: Vec<Mat3> = self.0.iter().map(|row| row.f).collect();
        let energies = dispatch(Energies { law, matrices: &matrices });
        for (row, energy) in self.0.iter().zip(energies) {
            if name == "linear" && row.kind.starts_with("turned") {
                continue;
            }
            let error = (energy / expected(row, name) - 1.0).abs();
            // Beyond ‖C − I‖² = 0.1 Hencky's law takes the singular values, whose error is promised to stay below 4e-15 each.
            let singular = if name == "Hencky" && row.metric_change.powi(2) >= 0.1 { 1e-14 } else { 0.0 };
            assert!(error <= allowed(row) + singular, "{name}, {}: off by {error:e}", row.kind);
        }
    }
}

#[test]
fn energies_in_lanes_have_their_digits() {
    each_law(&mut AccuracyInLanes(rows()));
}
