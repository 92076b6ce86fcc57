//! Local energies on a few points: all that the author of a new term writes.
//!
//! *Local law, global loop, `dyn` at the seam*: a [`Stencil`] is monomorphic and knows only its own `N` points; a
//! [`StencilTerm`] sums a list of them, once for all terms, in parallel and with the same bits for any number of
//! threads.

mod list;
mod term;

pub use list::StencilLists;
pub use term::{StencilError, StencilTerm};

use crate::potential::Demand;
use crate::projection::Projection;
use crate::tensor::{Mat3, Vec3};

/// The Hessian of an energy on `N` points: entry `[i][j]` is `∂²E/∂xᵢ∂xⱼ` [N/m].
///
/// Whoever reads one reads the lower triangle, `i ≥ j`, and takes the rest by symmetry.
pub type LocalHessian<const N: usize> = [[Mat3; N]; N];

/// A family of local energies on `N` points each, numbered `0..`; the implementing type holds whatever the elements
/// share (a law) and whatever each has of its own (a rest shape), in the layout that suits it.
///
/// Three methods are required. The three `…_into` methods do the same for consecutive elements at once and default
/// to a loop; an implementation that computes several elements in the lanes of a vector register overrides them.
pub trait Stencil<const N: usize>: Send + Sync {
    /// The energy of `element` with its points at `x` \[J\]; `+∞` outside its domain.
    fn value(&self, element: usize, x: &[Vec3; N]) -> f64;

    /// Its gradient \[N\], one vector per point.
    fn gradient(&self, element: usize, x: &[Vec3; N]) -> [Vec3; N];

    /// Its Hessian [N/m], projected as asked; the lower triangle suffices.
    fn hessian(&self, element: usize, x: &[Vec3; N], projection: Projection) -> LocalHessian<N>;

    /// The largest part in [0, 1] of the step `p` that keeps `element` in its domain.
    fn limit_step(&self, element: usize, x: &[Vec3; N], p: &[Vec3; N]) -> f64 {
        let _ = (element, x, p);
        1.0
    }

    /// What the energy demands of the time scheme: barriers demand end positions.
    fn demand(&self) -> Demand {
        Demand::Nothing
    }

    /// The energies of elements `first..first + x.len()`, overwriting `values`.
    fn values_into(&self, first: usize, x: &[[Vec3; N]], values: &mut [f64]) {
        for (k, (x, value)) in x.iter().zip(values).enumerate() {
            *value = self.value(first + k, x);
        }
    }

    /// The gradients of elements `first..first + x.len()`, overwriting `gradients`.
    fn gradients_into(&self, first: usize, x: &[[Vec3; N]], gradients: &mut [[Vec3; N]]) {
        for (k, (x, gradient)) in x.iter().zip(gradients).enumerate() {
            *gradient = self.gradient(first + k, x);
        }
    }

    /// The Hessians of elements `first..first + x.len()`, overwriting the lower triangles of `hessians`.
    fn hessians_into(
        &self,
        first: usize,
        x: &[[Vec3; N]],
        projection: Projection,
        hessians: &mut [LocalHessian<N>],
    ) {
        for (k, (x, hessian)) in x.iter().zip(hessians).enumerate() {
            *hessian = self.hessian(first + k, x, projection);
        }
    }
}

impl<S: Stencil<N> + ?Sized, const N: usize> Stencil<N> for &S {
    fn value(&self, element: usize, x: &[Vec3; N]) -> f64 {
        (**self).value(element, x)
    }

    fn gradient(&self, element: usize, x: &[Vec3; N]) -> [Vec3; N] {
        (**self).gradient(element, x)
    }

    fn hessian(&self, element: usize, x: &[Vec3; N], projection: Projection) -> LocalHessian<N> {
        (**self).hessian(element, x, projection)
    }

    fn limit_step(&self, element: usize, x: &[Vec3; N], p: &[Vec3; N]) -> f64 {
        (**self).limit_step(element, x, p)
    }

    fn demand(&self) -> Demand {
        (**self).demand()
    }

    fn values_into(&self, first: usize, x: &[[Vec3; N]], values: &mut [f64]) {
        (**self).values_into(first, x, values);
    }

    fn gradients_into(&self, first: usize, x: &[[Vec3; N]], gradients: &mut [[Vec3; N]]) {
        (**self).gradients_into(first, x, gradients);
    }

    fn hessians_into(
        &self,
        first: usize,
        x: &[[Vec3; N]],
        projection: Projection,
        hessians: &mut [LocalHessian<N>],
    ) {
        (**self).hessians_into(first, x, projection, hessians);
    }
}
