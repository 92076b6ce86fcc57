//! Speed against accuracy of 3×3 singular value decompositions: precision × lanes × sweeps.

use super::random::Random;
use super::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Count;
use mechanics_core::decomposition::{MOST_SWEEPS, Svd, svd_with_sweeps, svd_with_sweeps_into};
use mechanics_core::lanes::Element;
use mechanics_core::state::StateHash;
use mechanics_core::tensor::{Mat3, Matrix3};
use schemars::JsonSchema;
use serde::Deserialize;

/// Random matrices; the ladder is the number of Jacobi sweeps.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SvdKernels {
    /// How many matrices.
    matrices: Count,
}

/// The ladder holds what is no number of sweeps.
#[derive(Debug, thiserror::Error)]
#[error("{sweeps} sweeps: must be a whole number from 0 to {MOST_SWEEPS}")]
struct SweepsError {
    sweeps: f64,
}

impl Experiment for SvdKernels {
    fn methods(&self) -> &'static [&'static str] {
        &["f64 one by one", "f64 lanes", "f32 one by one", "f32 lanes"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let mut random = Random::new(at.seed);
        let matrices: Vec<Mat3> = (0..self.matrices.value()).map(|_| random.matrix(1.0)).collect();
        let way = if at.method.ends_with("lanes") { Way::Lanes } else { Way::OneByOne };
        if at.method.starts_with("f32") {
            let single: Vec<Matrix3<f32>> =
                matrices.iter().map(|matrix| matrix.map(|entry| entry as f32)).collect();
            decompose(&single, way, at.ladder, clock)
        } else {
            decompose(&matrices, way, at.ladder, clock)
        }
    }
}

#[derive(Clone, Copy)]
enum Way {
    OneByOne,
    Lanes,
}

fn decompose<E: Element>(
    matrices: &[Matrix3<E>],
    way: Way,
    sweeps: f64,
    clock: &mut Clock,
) -> Result<Outcome, ExperimentError> {
    if sweeps.fract() != 0.0 || !(0.0..=MOST_SWEEPS as f64).contains(&sweeps) {
        return Err(ExperimentError::stopped(SweepsError { sweeps }));
    }
    let found = timed(matrices, way, sweeps as usize, clock);
    let mut hash = StateHash::new();
    let mut worst: f64 = 0.0;
    for (matrix, svd) in matrices.iter().zip(&found) {
        let [f, u, v] = [matrix, &svd.u, &svd.v].map(|matrix| matrix.map(Into::<f64>::into));
        let sigma = svd.sigma.map(Into::<f64>::into);
        worst = worst.max(defect(&f, &u, sigma, &v));
        hash.add("sigma", &sigma);
        hash.add("u", u.as_slice());
        hash.add("v", v.as_slice());
    }
    Ok(Outcome::default().error("defect", worst).count("matrices", matrices.len() as u64).state(hash.value()))
}

fn timed<E: Element>(matrices: &[Matrix3<E>], way: Way, sweeps: usize, clock: &mut Clock) -> Vec<Svd<E>> {
    let mut found = vec![Svd::identity(); matrices.len()];
    clock.time(|| match way {
        Way::Lanes => svd_with_sweeps_into(matrices, sweeps, &mut found),
        Way::OneByOne => {
            for (svd, matrix) in found.iter_mut().zip(matrices) {
                *svd = svd_with_sweeps(matrix, sweeps);
            }
        }
    });
    found
}

/// By how much three matrices fail to be a singular value decomposition: the largest of ‖U Σ Vᵀ − F‖/‖F‖, ‖UᵀU − 1‖,
/// ‖VᵀV − 1‖, in the Frobenius norm, and of the misorder of σ relative to ‖F‖. It is zero for no other matrices.
fn defect(f: &Mat3, u: &Mat3, sigma: [f64; 3], v: &Mat3) -> f64 {
    let size = f.norm().max(f64::MIN_POSITIVE);
    let product = u * Mat3::from_diagonal(&sigma.into()) * v.transpose();
    let skewness = |q: &Mat3| (q.transpose() * q - Mat3::identity()).norm();
    let misorder = (sigma[1] - sigma[0]).max(sigma[2].abs() - sigma[1]).max(0.0) / size;
    ((product - f).norm() / size).max(skewness(u)).max(skewness(v)).max(misorder)
}
