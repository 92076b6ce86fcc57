//! Gaussians among the samples of a coarser body.

use super::Moved;
use super::cells::Cells;
use crate::error::SplatError;
use mechanics_core::mesh::BoundingBox;
use mechanics_core::parallel;
use mechanics_core::samples::DeformationSamples;
use mechanics_core::tensor::{Mat3, Vec3};

/// Gaussians that move with a blend of the affine motions of the samples nearest to them at rest:
///
/// x = Σₖ wₖ (xₖ + Fₖ (X − Xₖ)),  F = Σₖ wₖ Fₖ,  Σₖ wₖ = 1.
///
/// The weights are wₖ ∝ (1 − dₖ²/r²)², dₖ the distance to sample k and r that to the first sample beyond those taken, so that a sample comes in and goes out without a jump. Where
/// all samples move by one affine motion, so does every Gaussian, exactly. A Gaussian that coincides with a sample at rest does not in general follow it alone.
#[derive(Clone, Debug)]
pub struct SampleBinding {
    rest: Vec<Vec3>,
    means: Vec<Vec3>,
    neighbours: usize,
    /// For each mean `neighbours` samples with their weights.
    weights: Vec<(u32, f64)>,
}

impl SampleBinding {
    /// Of samples and means at rest, each mean to `neighbours` samples (fewer if there are not more samples).
    ///
    /// # Errors
    /// [`SplatError::NoSamples`], [`SplatError::BadSample`], [`SplatError::BadPoint`] for what is not finite.
    ///
    /// # Panics
    /// If `neighbours` is zero.
    pub fn new(samples: &[Vec3], means: &[Vec3], neighbours: usize) -> Result<Self, SplatError> {
        assert!(neighbours > 0, "a Gaussian moves with one sample at least");
        super::tets::check_points(samples, |sample, value| SplatError::BadSample {
            sample,
            value,
            most: f64::MAX,
        })?;
        super::tets::check_points(means, |point, value| SplatError::BadPoint { point, value })?;
        let boxes: Vec<BoundingBox> = samples.iter().map(|&x| BoundingBox { min: x, max: x }).collect();
        let cells = Cells::new(&boxes).ok_or(SplatError::NoSamples)?;
        let neighbours = neighbours.min(samples.len());
        let parts = parallel::map_chunks(means.len(), 256, |range| {
            let mut weights = Vec::with_capacity(range.len() * neighbours);
            for i in range {
                add_weights(&cells, samples, &means[i], neighbours, &mut weights);
            }
            weights
        });
        Ok(Self { rest: samples.to_vec(), means: means.to_vec(), neighbours, weights: parts.concat() })
    }

    /// The samples that Gaussian i moves with, and their weights.
    ///
    /// # Panics
    /// If there is no such Gaussian.
    pub fn weights(&self, i: usize) -> &[(u32, f64)] {
        &self.weights[i * self.neighbours..(i + 1) * self.neighbours]
    }

    /// Where the Gaussians are, and how they are deformed, when the samples are as given.
    ///
    /// # Errors
    /// [`SplatError::SampleCount`] unless there are as many samples as at rest.
    pub fn move_into(&self, samples: DeformationSamples<'_>, moved: &mut Moved) -> Result<(), SplatError> {
        if samples.count() != self.rest.len() {
            return Err(SplatError::SampleCount { samples: samples.count(), matter: self.rest.len() });
        }
        moved.set(self.means.len(), |i| {
            let (mut position, mut gradient) = (Vec3::zeros(), Mat3::zeros());
            for &(k, weight) in self.weights(i) {
                let k = k as usize;
                let f = &samples.gradients()[k];
                position += (samples.positions()[k] + f * (self.means[i] - self.rest[k])) * weight;
                gradient += f * weight;
            }
            (position, gradient)
        });
        Ok(())
    }
}

/// The `count` nearest samples with their weights, nearest first; of equally near ones those with the smaller number.
fn add_weights(cells: &Cells, samples: &[Vec3], mean: &Vec3, count: usize, weights: &mut Vec<(u32, f64)>) {
    let wanted = (count + 1).min(samples.len());
    let mut near: Vec<(f64, u32)> = Vec::with_capacity(wanted + 1);
    cells.nearest(mean, |k| {
        let entry = ((samples[k as usize] - mean).norm_squared(), k);
        let place = near.partition_point(|other| *other < entry);
        if place < wanted {
            near.insert(place, entry);
            near.truncate(wanted);
        }
        if near.len() < wanted { f64::INFINITY } else { near[wanted - 1].0.sqrt() }
    });
    let radius_squared = if near.len() > count { near[count].0 } else { 2.0 * near[count - 1].0 };
    let kernel =
        |d: f64| if radius_squared > 0.0 { (1.0 - d / radius_squared).max(0.0).powi(2) } else { 1.0 };
    let sum: f64 = near[..count].iter().map(|&(d, _)| kernel(d)).sum();
    // All of them as far as the next: no one is nearer.
    let weight = |d: f64| if sum > 0.0 { kernel(d) / sum } else { 1.0 / count as f64 };
    weights.extend(near[..count].iter().map(|&(d, k)| (k, weight(d))));
}
