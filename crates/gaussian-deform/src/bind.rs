//! Binding: Gaussians to the samples of a simulation.
//!
//! | who drives | how |
//! |---|---|
//! | one particle for each Gaussian | its samples are lent to [`Transport::deform`](crate::transport::Transport::deform) as they are |
//! | fewer particles | [`SampleBinding`]: a blend of the affine motions of the nearest ones |
//! | tetrahedra | [`TetBinding`]: the motion of the tetrahedron around, or nearest to, the mean |
//!
//! A binding is made once, at rest; every frame it fills a [`Moved`], which lends itself as samples again. All of them reproduce affine motions exactly.

mod cells;
mod particles;
mod tets;

use mechanics_core::parallel;
use mechanics_core::samples::DeformationSamples;
use mechanics_core::tensor::{Mat3, Vec3};
pub use particles::SampleBinding;
pub use tets::{TetBinding, TetGradients};

/// Positions and deformation gradients of Gaussians: a buffer that is filled every frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Moved {
    positions: Vec<Vec3>,
    gradients: Vec<Mat3>,
}

/// Gaussians in one piece of parallel work.
const CHUNK: usize = 2048;

impl Moved {
    /// An empty buffer.
    pub fn new() -> Self {
        Self::default()
    }

    /// Its content, lent.
    pub fn samples(&self) -> DeformationSamples<'_> {
        DeformationSamples::new(&self.positions, &self.gradients)
    }

    /// Overwrites everything with `count` samples.
    pub(crate) fn set(&mut self, count: usize, sample: impl Fn(usize) -> (Vec3, Mat3) + Sync) {
        self.positions.resize(count, Vec3::zeros());
        self.gradients.resize(count, Mat3::identity());
        let positions = self.positions.chunks_mut(CHUNK);
        let mut parts: Vec<_> = positions.zip(self.gradients.chunks_mut(CHUNK)).collect();
        parallel::for_each_chunk(&mut parts, 1, |first, parts| {
            for (positions, gradients) in parts {
                let pairs = positions.iter_mut().zip(gradients.iter_mut()).enumerate();
                for (k, (position, gradient)) in pairs {
                    (*position, *gradient) = sample(first * CHUNK + k);
                }
            }
        });
    }
}
