//! Sums over borrowed lists of elements.

use super::{LocalHessian, Stencil};
use crate::parallel;
use crate::projection::Projection;
use crate::sparse::{Assembler, Contributions, Scatter, Scattered, Slots};
use crate::tensor::Vec3;
use std::ops::Range;

/// Elements computed by one call of a stencil's `…_into` methods.
const RUN: usize = 32;
/// Elements whose energies or limits are reduced by one task.
pub(super) const CHUNK: usize = 512;

/// `E(x) = Σ E_e(x at e's points)` over lists of elements of several stencils, one list after the other: for those whose elements
/// come and go, so that a [`StencilTerm`](super::StencilTerm) for each would be made anew all the time.
///
/// Every sum has the same bits for any number of threads. All lists together are one parallel task, so that short ones cost no
/// more than their elements. Elements must not name a point twice.
#[derive(Default)]
pub struct StencilLists<'a> {
    lists: Vec<Box<dyn List + 'a>>,
}

impl<'a> StencilLists<'a> {
    /// No lists.
    pub fn new() -> Self {
        Self::default()
    }

    /// One list more, empty or not; element `e` of it is element `e` of the stencil.
    #[must_use]
    pub fn with<S: Stencil<N> + 'a, const N: usize>(mut self, stencil: S, elements: &'a [[u32; N]]) -> Self {
        self.lists.push(Box::new(StencilList { stencil, elements }));
        self
    }

    /// Σ E \[J\].
    ///
    /// # Panics
    /// If an element names a point that `x` does not have.
    pub fn value(&self, x: &[Vec3]) -> f64 {
        let chunks: Vec<(usize, usize)> = self
            .lists
            .iter()
            .enumerate()
            .flat_map(|(number, list)| (0..list.len()).step_by(CHUNK).map(move |first| (number, first)))
            .collect();
        let partial = parallel::map_chunks(chunks.len(), 1, |range| {
            let (number, first) = chunks[range.start];
            let list = &self.lists[number];
            list.value(first..(first + CHUNK).min(list.len()), x)
        });
        let mut parts = chunks.iter().zip(partial).peekable();
        let mut total = 0.0;
        for number in 0..self.lists.len() {
            let mut sum = 0.0;
            while let Some((_, part)) = parts.next_if(|((list, _), _)| *list == number) {
                sum += part;
            }
            total += sum;
        }
        total
    }

    /// Adds ∂E/∂xᵢ to `gradient[i]` \[N\], element after element.
    ///
    /// # Panics
    /// If an element names a point that `x` or `gradient` does not have.
    pub fn add_gradient(&self, x: &[Vec3], gradient: &mut [Vec3]) {
        let lists: Vec<Gradients<'_>> = self.lists.iter().map(|list| list.gradients(x)).collect();
        let lists: Vec<&dyn Scattered<Vec3>> = lists.iter().map(|list| &**list).collect();
        Scatter::default().accumulate(&lists, gradient);
    }

    /// Hands every list to the assembler, empty or not.
    ///
    /// # Panics
    /// If an element names a point that `x` or the assembler does not have.
    pub fn add_hessian(&self, x: &[Vec3], projection: Projection, hessian: &mut Assembler<'_>) {
        self.lists.iter().for_each(|list| list.add_hessian(x, projection, hessian));
    }
}

/// What a list adds to gradients.
type Gradients<'a> = Box<dyn Scattered<Vec3> + 'a>;

/// A list of elements, whatever the number of their points.
trait List: Sync {
    fn len(&self) -> usize;
    /// The sum of the energies of some elements.
    fn value(&self, range: Range<usize>, x: &[Vec3]) -> f64;
    fn gradients<'b>(&'b self, x: &'b [Vec3]) -> Gradients<'b>;
    fn add_hessian(&self, x: &[Vec3], projection: Projection, hessian: &mut Assembler<'_>);
}

/// Elements of one stencil.
#[derive(Clone, Copy, Debug)]
pub(super) struct StencilList<'a, S, const N: usize> {
    pub(super) stencil: S,
    pub(super) elements: &'a [[u32; N]],
}

impl<S: Stencil<N>, const N: usize> StencilList<'_, S, N> {
    /// Calls `work(first, x)` on runs of at most [`RUN`] consecutive elements of `range`, their points gathered.
    fn for_each_run(&self, range: Range<usize>, x: &[Vec3], mut work: impl FnMut(usize, &[[Vec3; N]])) {
        let mut gathered = [[Vec3::zeros(); N]; RUN];
        for first in range.clone().step_by(RUN) {
            let elements = &self.elements[first..(first + RUN).min(range.end)];
            for (gathered, element) in gathered.iter_mut().zip(elements) {
                gather_into(element, x, gathered);
            }
            work(first, &gathered[..elements.len()]);
        }
    }

    /// The sum of the energies of some elements.
    pub(super) fn value(&self, range: Range<usize>, x: &[Vec3]) -> f64 {
        let mut sum = 0.0;
        self.for_each_run(range, x, |first, x| {
            let mut values = [0.0; RUN];
            self.stencil.values_into(first, x, &mut values[..x.len()]);
            sum += values[..x.len()].iter().sum::<f64>();
        });
        sum
    }

    pub(super) fn add_hessian(&self, x: &[Vec3], projection: Projection, hessian: &mut Assembler<'_>) {
        hessian.add_batches(self.elements, |first, hessians: &mut [LocalHessian<N>]| {
            self.for_each_run(first..first + hessians.len(), x, |run, x| {
                let at = run - first;
                self.stencil.hessians_into(run, x, projection, &mut hessians[at..at + x.len()]);
            });
        });
    }
}

impl<S: Stencil<N>, const N: usize> List for StencilList<'_, S, N> {
    fn len(&self) -> usize {
        self.elements.len()
    }

    fn value(&self, range: Range<usize>, x: &[Vec3]) -> f64 {
        self.value(range, x)
    }

    fn gradients<'b>(&'b self, x: &'b [Vec3]) -> Gradients<'b> {
        Box::new(ListGradients { list: self, x })
    }

    fn add_hessian(&self, x: &[Vec3], projection: Projection, hessian: &mut Assembler<'_>) {
        self.add_hessian(x, projection, hessian);
    }
}

/// The gradients of a list's elements at `x`.
pub(super) struct ListGradients<'b, 'a, S, const N: usize> {
    pub(super) list: &'b StencilList<'a, S, N>,
    pub(super) x: &'b [Vec3],
}

impl<S: Stencil<N>, const N: usize> Contributions for ListGradients<'_, '_, S, N> {
    type Result = [Vec3; N];
    type Slot = Vec3;
    const BLANK: [Vec3; N] = [Vec3::new(0.0, 0.0, 0.0); N];

    fn elements(&self) -> usize {
        self.list.elements.len()
    }

    fn compute(&self, start: usize, gradients: &mut [[Vec3; N]]) {
        self.list.for_each_run(start..start + gradients.len(), self.x, |first, x| {
            let at = first - start;
            self.list.stencil.gradients_into(first, x, &mut gradients[at..at + x.len()]);
        });
    }

    fn add<W: Slots<Vec3>>(&self, first: usize, gradients: &[[Vec3; N]], slots: &mut W) {
        for (points, gradient) in self.list.elements[first..].iter().zip(gradients) {
            for (&point, gradient) in points.iter().zip(gradient) {
                if let Some(sum) = slots.slot(point) {
                    *sum += gradient;
                }
            }
        }
    }

    fn for_each_slot(&self, group: Range<usize>, visit: impl FnMut(u32)) {
        self.list.elements[group].as_flattened().iter().copied().for_each(visit);
    }
}

/// [`gather`] in place: a copy made of three numbers and moved on in wider registers would have to wait for its stores.
#[inline(always)]
fn gather_into<const N: usize>(element: &[u32; N], x: &[Vec3], gathered: &mut [Vec3; N]) {
    for (gathered, &point) in gathered.iter_mut().zip(element) {
        *gathered = x[point as usize];
    }
}

#[inline(always)]
pub(super) fn gather<const N: usize>(element: &[u32; N], x: &[Vec3]) -> [Vec3; N] {
    std::array::from_fn(|i| x[element[i] as usize])
}
