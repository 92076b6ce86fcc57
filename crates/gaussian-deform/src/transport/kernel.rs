//! The loop over packets of Gaussians.

use super::rotation::rotation;
use crate::harmonics::Coefficients;
use crate::splats::Splats;
use mechanics_core::lanes::{self, Element, LaneKernel, MOST_LANES, Packet};
use mechanics_core::tensor::{self, Mat3, Matrix3, Vec3, Vector3};

/// Consecutive Gaussians of a frame, and the samples that move some of them.
pub(super) struct Part<'a, E: Element> {
    pub(super) rest: &'a Splats<E>,
    /// The number of the first Gaussian of `means` and the other targets.
    pub(super) first: usize,
    /// The Gaussians that move, each with a position and a gradient.
    pub(super) matter: &'a [u32],
    pub(super) positions: &'a [Vec3],
    pub(super) gradients: &'a [Mat3],
    pub(super) means: &'a mut [Vector3<E>],
    pub(super) axes: &'a mut [Matrix3<E>],
    pub(super) colours: ColourTarget<'a, E>,
}

/// What is written of colours.
pub(super) enum ColourTarget<'a, E> {
    /// Nothing: colours are the same from everywhere.
    None,
    Harmonics(&'a mut [E]),
    Orientations(&'a mut [Matrix3<E>]),
}

impl<E: Element> LaneKernel<E> for &mut Part<'_, E> {
    type Output = ();

    #[inline(always)]
    fn run<P: Packet<Element = E>>(self) {
        let identity = tensor::multiple_of_identity(E::constant(1.0));
        for start in (0..self.matter.len()).step_by(P::LANES) {
            let count = P::LANES.min(self.matter.len() - start);
            let matter = &self.matter[start..start + count];
            let mut matrices = [identity; MOST_LANES];
            for (matrix, f) in matrices.iter_mut().zip(&self.gradients[start..start + count]) {
                *matrix = narrowed(f);
            }
            let f = lanes::load_matrices::<P>(&matrices[..P::LANES]);
            for (matrix, &i) in matrices.iter_mut().zip(matter) {
                *matrix = self.rest.axes()[i as usize];
            }
            let axes = tensor::product(&f, &lanes::load_matrices::<P>(&matrices[..P::LANES]));
            lanes::store_matrices(&axes, matrices[..count].iter_mut());
            for ((&i, x), b) in matter.iter().zip(&self.positions[start..]).zip(&matrices) {
                let target = i as usize - self.first;
                self.means[target] = tensor::vector(tensor::components(x).map(E::constant));
                self.axes[target] = *b;
            }
            self.colours.turn(self.rest, self.first, matter, &f);
        }
    }
}

impl<E: Element> ColourTarget<'_, E> {
    /// Turns the colours of the Gaussians `matter` by the rotations of `f`.
    #[inline(always)]
    fn turn<P: Packet<Element = E>>(
        &mut self,
        rest: &Splats<E>,
        first: usize,
        matter: &[u32],
        f: &Matrix3<P>,
    ) {
        match self {
            Self::None => {}
            Self::Orientations(targets) => {
                let mut matrices = [Matrix3::<E>::default(); MOST_LANES];
                lanes::store_matrices(&rotation(f), matrices.iter_mut());
                for (&i, r) in matter.iter().zip(&matrices) {
                    targets[i as usize - first] = *r;
                }
            }
            Self::Harmonics(targets) => {
                let stride = rest.degree().stride();
                let mut starts = [0; MOST_LANES];
                for (start, &i) in starts.iter_mut().zip(matter) {
                    *start = i as usize * stride;
                }
                let starts = &mut starts[..matter.len()];
                let mut coefficients = Coefficients::load(rest.degree(), rest.harmonics(), starts);
                coefficients.rotate(&rotation(f));
                starts.iter_mut().for_each(|start| *start -= first * stride);
                coefficients.store(targets, starts);
            }
        }
    }
}

#[inline(always)]
fn narrowed<E: Element>(f: &Mat3) -> Matrix3<E> {
    tensor::from_columns(tensor::columns(f).map(|column| column.map(E::constant)))
}
