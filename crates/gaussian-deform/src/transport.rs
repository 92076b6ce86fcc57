//! Transport: Gaussians carried by a motion.
//!
//! A Gaussian is a piece of the continuum. Where the motion near its mean is x = x̄ + F (X − X̄),
//!
//! | | rest | moved |
//! |---|---|---|
//! | mean | μ | x̄, the position of its sample |
//! | half-axes, A = B Bᵀ | B | F B, so that A becomes F A Fᵀ |
//! | opacity | α | α |
//! | colour in direction d | f(d) | f(Rᵀ d), R the rotation of F |
//!
//! F is the *total* deformation gradient from the shape of the trained scene, plastic flow included: solvers lend it as [`DeformationSamples`]. For a solver that has
//! velocity gradients only, [`advance_gradients`] accumulates it.
//! R is the rotation nearest to F ([`rotation`]), so that stretch and shear leave the colours attached to the material as rigid as they can be.
//!
//! # Degenerate deformations
//! F B is right for every F: a flattened Gaussian (rank 2, 1, 0) is a disc, a needle, a point, all of which can be drawn. An
//! inverted F (det F < 0) mirrors the half-axes; its R is a rotation all the same, and not unique where σ₁ + σ₂ = 0 (signed singular values): then one of the nearest. No
//! finite F gives NaN; an F that is not finite, or beyond [`largest_number`], is refused with its sample.
//!
//! # Reference
//! F A Fᵀ and the rotation of colours: Xie, Zong, Qiu, Li, Feng, Yang, Jiang (2024), *PhysGaussian: Physics-Integrated 3D Gaussians for Generative
//! Dynamics*, sections 3.4 and 3.5.

mod increment;
mod kernel;
mod rotation;

use crate::error::SplatError;
use crate::precision::by_precision;
use crate::splats::{Degree, Splats, largest_number};
pub use increment::{advance_axes, advance_covariance, advance_gradients};
use kernel::{ColourTarget, Part};
use mechanics_core::lanes::{self, Element};
use mechanics_core::parallel;
use mechanics_core::samples::DeformationSamples;
use mechanics_core::tensor::Mat3;
pub use rotation::rotation;

/// How colours follow the rotation; both show the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colours {
    /// Coefficients are rotated: a frame is complete in itself, as files need it.
    RotateCoefficients,
    /// The rotation is kept in [`Splats::orientations`], and whoever evaluates colours turns the direction of view. Cheaper where a frame is drawn once.
    TurnDirections,
}

/// What a deformation met.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TransportReport {
    /// Samples with det F < 0: turned inside out.
    pub inverted: usize,
}

/// A scene at rest, which of its Gaussians are matter, and the frame that they are in now.
///
/// ```
/// use gaussian_deform::transport::{Colours, Transport};
/// use gaussian_deform::{Degree, Splat, Splats};
/// use mechanics_core::samples::DeformationSamples;
/// use mechanics_core::tensor::{Mat3, Vec3};
///
/// let mut scene = Splats::<f64>::new(Degree::Zero);
/// let splat = Splat { mean: Vec3::zeros(), axes: Mat3::identity(), opacity: 0.5, harmonics: &[0.0; 3] };
/// scene.push(splat);
/// let mut transport = Transport::new(scene, vec![0], Colours::RotateCoefficients)?;
/// // Simple shear: A = F Fᵀ has xx = 1 + 2² = 5 and xy = 2.
/// let shear = Mat3::new(1.0, 2.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
/// transport.deform(DeformationSamples::new(&[Vec3::x()], &[shear]))?;
/// assert_eq!(transport.frame().covariance(0), [5.0, 2.0, 0.0, 1.0, 0.0, 1.0]);
/// # Ok::<(), gaussian_deform::SplatError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Transport<E: Element = f32> {
    rest: Splats<E>,
    matter: Vec<u32>,
    colours: Colours,
    frame: Splats<E>,
}

/// Gaussians in one piece of parallel work.
const CHUNK: usize = 2048;

impl<E: Element> Transport<E> {
    /// Of a scene at rest, of which the Gaussians `matter`, in ascending order, move: sample k of a motion moves Gaussian `matter[k]`. The others stay as they are. Orientations
    /// of the scene are settled first.
    ///
    /// # Errors
    /// [`SplatError::BadSelection`]; what [`Splats::check`] finds.
    pub fn new(mut rest: Splats<E>, matter: Vec<u32>, colours: Colours) -> Result<Self, SplatError> {
        crate::select::check_ascending(&matter, rest.count())?;
        rest.check()?;
        crate::harmonics::settle_orientations(&mut rest);
        let mut frame = rest.clone();
        if colours == Colours::TurnDirections && rest.degree() != Degree::Zero {
            frame.orientations_mut();
        }
        Ok(Self { rest, matter, colours, frame })
    }

    /// The scene at rest.
    pub fn rest(&self) -> &Splats<E> {
        &self.rest
    }

    /// The Gaussians that move, ascending.
    pub fn matter(&self) -> &[u32] {
        &self.matter
    }

    /// The scene in its present shape: at rest, or as of the last [`deform`](Self::deform).
    pub fn frame(&self) -> &Splats<E> {
        &self.frame
    }

    /// Moves and deforms the matter: sample k is Gaussian `matter[k]`, in the scene's own coordinates.
    ///
    /// The bits do not depend on the number of threads, nor a Gaussian's on the others'.
    ///
    /// # Errors
    /// [`SplatError::SampleCount`], [`SplatError::BadSample`]; the frame is then as it was.
    pub fn deform(&mut self, samples: DeformationSamples<'_>) -> Result<TransportReport, SplatError> {
        let (given, matter) = (samples.count(), self.matter.len());
        if given != matter {
            return Err(SplatError::SampleCount { samples: given, matter });
        }
        let inverted = check_samples(samples, largest_number::<E>())?;
        by_precision(self, |single| move_single(single, samples), |double| move_double(double, samples));
        Ok(TransportReport { inverted })
    }

    /// Moves and deforms by samples that have been checked.
    fn apply(&mut self, samples: DeformationSamples<'_>) {
        let mut parts = self.parts(samples);
        parallel::for_each_chunk(&mut parts, 1, |_, parts| {
            for part in parts {
                lanes::dispatch(part);
            }
        });
    }

    /// Consecutive Gaussians of the frame with those samples that move them.
    fn parts<'a>(&'a mut self, samples: DeformationSamples<'a>) -> Vec<Part<'a, E>> {
        let stride = self.rest.degree().stride();
        let (matter, rest) = (&self.matter, &self.rest);
        let frame = self.frame.arrays_mut();
        let mut orientations = frame.orientations.map(|all| all.chunks_mut(CHUNK));
        let mut harmonics = frame.harmonics.chunks_mut(CHUNK * stride);
        let mut colour_target = || match (&mut orientations, self.colours) {
            _ if stride == Degree::Zero.stride() => ColourTarget::None,
            (Some(chunks), _) => chunks.next().map_or(ColourTarget::None, ColourTarget::Orientations),
            (None, _) => harmonics.next().map_or(ColourTarget::None, ColourTarget::Harmonics),
        };
        let chunks = frame.means.chunks_mut(CHUNK).zip(frame.axes.chunks_mut(CHUNK)).enumerate();
        let mut end = 0;
        chunks
            .map(|(k, (means, axes))| {
                let start = end;
                let beyond = k * CHUNK + means.len();
                end = start + matter[start..].partition_point(|&i| (i as usize) < beyond);
                Part {
                    rest,
                    first: k * CHUNK,
                    matter: &matter[start..end],
                    positions: &samples.positions()[start..end],
                    gradients: &samples.gradients()[start..end],
                    means,
                    axes,
                    colours: colour_target(),
                }
            })
            .collect()
    }
}

#[inline(never)]
fn move_single(transport: &mut Transport<f32>, samples: DeformationSamples<'_>) {
    transport.apply(samples);
}

#[inline(never)]
fn move_double(transport: &mut Transport<f64>, samples: DeformationSamples<'_>) {
    transport.apply(samples);
}

/// How many gradients are inverted, if all numbers can be computed with.
fn check_samples(samples: DeformationSamples<'_>, most: f64) -> Result<usize, SplatError> {
    let parts = parallel::map_chunks(samples.count(), CHUNK, |range| {
        let mut inverted = 0;
        for k in range {
            let (x, f) = (&samples.positions()[k], &samples.gradients()[k]);
            // A sum is NaN or too large if one of its terms is; which one is found afterwards.
            let size: f64 = x.iter().chain(f.iter()).map(|x| x.abs()).sum();
            if size.is_nan() || size > most {
                return Err(bad_sample(k, x.iter().chain(f.iter()), most));
            }
            inverted += usize::from(determinant(f) < 0.0);
        }
        Ok(inverted)
    });
    parts.into_iter().sum()
}

fn bad_sample<'a>(sample: usize, numbers: impl Iterator<Item = &'a f64>, most: f64) -> SplatError {
    let worst = numbers.copied().fold(0.0_f64, |worst, x| match x.abs() <= worst.abs() {
        _ if worst.is_nan() => worst,
        true => worst,
        false => x,
    });
    SplatError::BadSample { sample, value: worst, most }
}

fn determinant(f: &Mat3) -> f64 {
    mechanics_core::tensor::determinant(f)
}
