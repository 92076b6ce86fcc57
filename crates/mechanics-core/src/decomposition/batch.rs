//! Decompositions of arrays of matrices, in lanes.

use super::{Polar, Svd, polar, svd, svd_with_sweeps};
use crate::lanes::{self, Element, LaneKernel, MOST_LANES, Packet, Pair};
use crate::scalar::Scalar;
use crate::tensor::{self, Matrix3};

/// [`svd`] of every matrix, eight (`f32`) or four (`f64`) at a time with the best instructions of this processor.
///
/// Two packets are in flight at a time ([`Pair`]), because one packet's chain of dependent operations leaves the
/// processor waiting. The result for a matrix does not depend on its place or its neighbours. It may differ from that of [`svd`] in the last
/// bits, by fused multiplications.
///
/// ```
/// use mechanics_core::decomposition::{Svd, svd_into};
/// use mechanics_core::tensor::Mat3;
///
/// let matrices: Vec<Mat3> = (1..=10).map(|i| Mat3::identity() * f64::from(i)).collect();
/// let mut decompositions = vec![Svd::identity(); 10];
/// svd_into(&matrices, &mut decompositions);
/// assert_eq!(decompositions[9].sigma, [10.0; 3]);
/// ```
///
/// # Panics
/// If the two slices differ in length.
pub fn svd_into<E: Element>(matrices: &[Matrix3<E>], decompositions: &mut [Svd<E>]) {
    lanes::dispatch(SvdBatch { method: Accurate, matrices, decompositions });
}

/// [`svd_with_sweeps`] of every matrix, in lanes as [`svd_into`].
///
/// # Panics
/// If the two slices differ in length, or `sweeps` is more than [`MOST_SWEEPS`](super::MOST_SWEEPS).
pub fn svd_with_sweeps_into<E: Element>(
    matrices: &[Matrix3<E>],
    sweeps: usize,
    decompositions: &mut [Svd<E>],
) {
    lanes::dispatch(SvdBatch { method: Sweeps(sweeps), matrices, decompositions });
}

/// [`polar`] of every matrix, in lanes as [`svd_into`].
///
/// # Panics
/// If the two slices differ in length.
pub fn polar_into<E: Element>(matrices: &[Matrix3<E>], decompositions: &mut [Polar<E>]) {
    lanes::dispatch(PolarBatch { matrices, decompositions });
}

/// How a batch decomposes one packet of matrices.
trait Method {
    fn svd<S: Scalar>(&self, f: &Matrix3<S>) -> Svd<S>;
}

/// As many sweeps as the accuracy needs.
struct Accurate;

impl Method for Accurate {
    #[inline(always)]
    fn svd<S: Scalar>(&self, f: &Matrix3<S>) -> Svd<S> {
        svd(f)
    }
}

/// A fixed number of sweeps.
struct Sweeps(usize);

impl Method for Sweeps {
    #[inline(always)]
    fn svd<S: Scalar>(&self, f: &Matrix3<S>) -> Svd<S> {
        svd_with_sweeps(f, self.0)
    }
}

struct SvdBatch<'a, E, M> {
    method: M,
    matrices: &'a [Matrix3<E>],
    decompositions: &'a mut [Svd<E>],
}

impl<E: Element, M: Method> LaneKernel<E> for SvdBatch<'_, E, M> {
    type Output = ();

    #[inline(always)]
    fn run<P: Packet<Element = E>>(self) {
        assert_eq!(self.matrices.len(), self.decompositions.len(), "one decomposition for each matrix");
        let step = 2 * P::LANES;
        for (matrices, targets) in self.matrices.chunks(step).zip(self.decompositions.chunks_mut(step)) {
            let d = self.method.svd(&load_pair::<P>(matrices));
            let (first, second) = targets.split_at_mut(P::LANES.min(targets.len()));
            let [u, v] = [first_of_pair(&d.u), first_of_pair(&d.v)];
            store_svd(&Svd { u, sigma: d.sigma.map(|s| s.0), v }, first);
            let [u, v] = [second_of_pair(&d.u), second_of_pair(&d.v)];
            store_svd(&Svd { u, sigma: d.sigma.map(|s| s.1), v }, second);
        }
    }
}

/// Lane i of a packet of decompositions to target i.
#[inline(always)]
fn store_svd<P: Packet>(d: &Svd<P>, targets: &mut [Svd<P::Element>]) {
    lanes::store_matrices(&d.u, targets.iter_mut().map(|t| &mut t.u));
    lanes::store_matrices(&d.v, targets.iter_mut().map(|t| &mut t.v));
    for i in 0..3 {
        let values = d.sigma[i].to_lanes();
        for (target, &value) in targets.iter_mut().zip(values.as_ref()) {
            target.sigma[i] = value;
        }
    }
}

struct PolarBatch<'a, E> {
    matrices: &'a [Matrix3<E>],
    decompositions: &'a mut [Polar<E>],
}

impl<E: Element> LaneKernel<E> for PolarBatch<'_, E> {
    type Output = ();

    #[inline(always)]
    fn run<P: Packet<Element = E>>(self) {
        assert_eq!(self.matrices.len(), self.decompositions.len(), "one decomposition for each matrix");
        let step = 2 * P::LANES;
        for (matrices, targets) in self.matrices.chunks(step).zip(self.decompositions.chunks_mut(step)) {
            let d = polar(&load_pair::<P>(matrices));
            let (first, second) = targets.split_at_mut(P::LANES.min(targets.len()));
            let [rotation, stretch] = [first_of_pair(&d.rotation), first_of_pair(&d.stretch)];
            store_polar(&Polar { rotation, stretch }, first);
            let [rotation, stretch] = [second_of_pair(&d.rotation), second_of_pair(&d.stretch)];
            store_polar(&Polar { rotation, stretch }, second);
        }
    }
}

/// Lane i of a packet of decompositions to target i.
#[inline(always)]
fn store_polar<P: Packet>(d: &Polar<P>, targets: &mut [Polar<P::Element>]) {
    lanes::store_matrices(&d.rotation, targets.iter_mut().map(|t| &mut t.rotation));
    lanes::store_matrices(&d.stretch, targets.iter_mut().map(|t| &mut t.stretch));
}

/// Up to twice as many matrices as lanes; identities where they end.
#[inline(always)]
fn load_pair<P: Packet>(matrices: &[Matrix3<P::Element>]) -> Matrix3<Pair<P>> {
    let mut filled = [tensor::multiple_of_identity(P::Element::constant(1.0)); 2 * MOST_LANES];
    let whole = if matrices.len() == 2 * P::LANES {
        matrices
    } else {
        filled[..matrices.len()].copy_from_slice(matrices);
        &filled[..2 * P::LANES]
    };
    let (first, second) = whole.split_at(P::LANES);
    let (a, b) = (lanes::load_matrices::<P>(first), lanes::load_matrices::<P>(second));
    let (a, b) = (tensor::columns(&a), tensor::columns(&b));
    tensor::from_entries(|i, j| Pair(a[j][i], b[j][i]))
}

#[inline(always)]
fn first_of_pair<P: Packet>(pair: &Matrix3<Pair<P>>) -> Matrix3<P> {
    tensor::from_entries(|i, j| tensor::columns(pair)[j][i].0)
}

#[inline(always)]
fn second_of_pair<P: Packet>(pair: &Matrix3<Pair<P>>) -> Matrix3<P> {
    tensor::from_entries(|i, j| tensor::columns(pair)[j][i].1)
}
