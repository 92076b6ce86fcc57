//! Sums of one kind of pairs: the same bits for any number of threads.

use mechanics_core::parallel;
use mechanics_core::projection::Projection;
use mechanics_core::sparse::Assembler;
use mechanics_core::stencil::{LocalHessian, Stencil};
use mechanics_core::tensor::Vec3;
use std::ops::Range;

/// Pairs computed by one call of a stencil's `…_into` methods.
const RUN: usize = 32;
/// Pairs whose energies are summed by one task.
const CHUNK: usize = 512;
/// Pairs whose gradients are computed before they are added: they stay in cache.
const BATCH: usize = 4096;

/// Pairs of one kind, and what computes them.
pub(super) struct Pairs<'a, S, const N: usize> {
    pub(super) stencil: S,
    pub(super) elements: &'a [[u32; N]],
}

impl<S: Stencil<N>, const N: usize> Pairs<'_, S, N> {
    /// Σ E.
    pub(super) fn value(&self, x: &[Vec3]) -> f64 {
        let partial = parallel::map_chunks(self.elements.len(), CHUNK, |range| {
            let mut sum = 0.0;
            self.for_each_run(range, x, |first, x| {
                let mut values = [0.0; RUN];
                self.stencil.values_into(first, x, &mut values[..x.len()]);
                sum += values[..x.len()].iter().sum::<f64>();
            });
            sum
        });
        partial.into_iter().fold(0.0, |sum, part| sum + part)
    }

    /// Adds ∂E/∂xᵢ to `gradient[i]`, pair after pair. Gradients are computed in parallel, batch by batch; while one batch is added
    /// the next is computed.
    pub(super) fn add_gradient(&self, x: &[Vec3], gradient: &mut [Vec3]) {
        let batches: Vec<Range<usize>> = (0..self.elements.len())
            .step_by(BATCH)
            .map(|first| first..(first + BATCH).min(self.elements.len()))
            .collect();
        let Some((last, earlier)) = batches.split_last() else { return };
        let room = batches[0].len();
        let (mut now, mut next) = (vec![[Vec3::zeros(); N]; room], Vec::new());
        self.gradients_into(batches[0].clone(), x, &mut now);
        for (batch, following) in earlier.iter().zip(&batches[1..]) {
            next.resize(room, [Vec3::zeros(); N]);
            parallel::join(
                || self.scatter(batch.clone(), &now, gradient),
                || self.gradients_into(following.clone(), x, &mut next),
            );
            std::mem::swap(&mut now, &mut next);
        }
        self.scatter(last.clone(), &now, gradient);
    }

    fn gradients_into(&self, batch: Range<usize>, x: &[Vec3], local: &mut [[Vec3; N]]) {
        parallel::for_each_chunk(&mut local[..batch.len()], CHUNK, |start, part| {
            let first = batch.start + start;
            self.for_each_run(first..first + part.len(), x, |run, x| {
                let at = run - first;
                self.stencil.gradients_into(run, x, &mut part[at..at + x.len()]);
            });
        });
    }

    fn scatter(&self, batch: Range<usize>, local: &[[Vec3; N]], gradient: &mut [Vec3]) {
        for (points, parts) in self.elements[batch].iter().zip(local) {
            for (&point, part) in points.iter().zip(parts) {
                gradient[point as usize] += part;
            }
        }
    }

    /// Hands the pairs to the assembler as one list, empty or not.
    pub(super) fn add_hessian(&self, x: &[Vec3], projection: Projection, hessian: &mut Assembler<'_>) {
        hessian.add_batches(self.elements, |first, hessians: &mut [LocalHessian<N>]| {
            self.for_each_run(first..first + hessians.len(), x, |run, x| {
                let at = run - first;
                self.stencil.hessians_into(run, x, projection, &mut hessians[at..at + x.len()]);
            });
        });
    }

    /// Calls `work(first, x)` on runs of at most [`RUN`] consecutive pairs of `range`, their points gathered.
    fn for_each_run(&self, range: Range<usize>, x: &[Vec3], mut work: impl FnMut(usize, &[[Vec3; N]])) {
        let mut gathered = [[Vec3::zeros(); N]; RUN];
        for first in range.clone().step_by(RUN) {
            let elements = &self.elements[first..(first + RUN).min(range.end)];
            for (gathered, element) in gathered.iter_mut().zip(elements) {
                *gathered = element.map(|point| x[point as usize]);
            }
            work(first, &gathered[..elements.len()]);
        }
    }
}
