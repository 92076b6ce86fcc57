//! Runs of consecutive pairs through the lanes of vector registers.

use super::{Curvature, PairLaw, times};
use crate::barrier::Barrier;
use mechanics_core::lanes::{self, LaneKernel, Packet};
use mechanics_core::projection::Projection;
use mechanics_core::scalar::Scalar;
use mechanics_core::stencil::LocalHessian;
use mechanics_core::tensor::{Matrix3, Vec3};

/// Lanes of a packet of `f64`.
pub(super) const LANES: usize = 4;

/// The geometry of one kind of pair, for any scalar.
pub(super) trait Primitive<const N: usize>: Copy {
    /// s.
    fn squared_distance<S: Scalar>(x: &[[S; 3]; N]) -> S;

    /// The weights ω of the closest positions, and y = Σ ωᵢ xᵢ with s = |y|².
    fn closest<S: Scalar>(x: &[[S; 3]; N]) -> ([S; N], [S; 3]);

    /// The lower triangle of ∇²E, projected, from `coefficients(s)` = [2 w κ b′, α]; see the [module](super) page.
    fn hessian<S: Scalar>(
        x: &[[S; 3]; N],
        coefficients: impl FnOnce(S) -> [S; 2],
        rule: Rule,
    ) -> [[Matrix3<S>; N]; N];
}

/// What is made of the eigenvalues.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rule {
    pub projection: Projection,
    pub curvature: Curvature,
}

impl Rule {
    /// Whether only the part along the gap is wanted.
    #[inline(always)]
    pub(super) fn is_gauss_newton(self) -> bool {
        self.curvature == Curvature::GaussNewton && self.projection != Projection::None
    }

    /// Whether eigenvalues of the full Hessian are to be replaced.
    pub(super) fn is_full_and_projected(self) -> bool {
        self.curvature == Curvature::Full && self.projection != Projection::None
    }
}

/// Pairs of one kind with consecutive weights.
pub(super) struct Run<'a, B: ?Sized, const N: usize> {
    pub law: PairLaw<'a, B>,
    pub weights: &'a [f64],
    pub x: &'a [[Vec3; N]],
}

impl<'a, B: Barrier + ?Sized, const N: usize> Run<'a, B, N> {
    /// The run of `x`, whose weights are `weights[first..]`.
    pub(super) fn new(law: PairLaw<'a, B>, weights: &'a [f64], first: usize, x: &'a [[Vec3; N]]) -> Self {
        Self { law, weights: &weights[first..first + x.len()], x }
    }

    /// Overwrites `values`.
    #[inline]
    pub(super) fn values<K: Primitive<N>>(self, kind: K, values: &mut [f64]) {
        assert_eq!(values.len(), self.x.len(), "one energy for each pair");
        lanes::dispatch(Values { run: self, kind, values });
    }

    /// Overwrites `gradients`.
    #[inline]
    pub(super) fn gradients<K: Primitive<N>>(self, kind: K, gradients: &mut [[Vec3; N]]) {
        assert_eq!(gradients.len(), self.x.len(), "one gradient for each pair");
        lanes::dispatch(Gradients { run: self, kind, gradients });
    }

    /// Overwrites the lower triangles of `hessians`.
    #[inline]
    pub(super) fn hessians<K: Primitive<N>>(
        self,
        kind: K,
        projection: Projection,
        hessians: &mut [LocalHessian<N>],
    ) {
        assert_eq!(hessians.len(), self.x.len(), "one Hessian for each pair");
        lanes::dispatch(Hessians { run: self, kind, projection, hessians });
    }
}

struct Values<'a, 'b, B: ?Sized, K, const N: usize> {
    run: Run<'a, B, N>,
    kind: K,
    values: &'b mut [f64],
}

impl<B: Barrier + ?Sized, K: Primitive<N>, const N: usize> LaneKernel<f64> for Values<'_, '_, B, K, N> {
    type Output = ();
    #[inline(always)]
    fn run<P: Packet<Element = f64>>(self) {
        let _ = self.kind;
        let Run { law, weights, x } = self.run;
        let chunks = self.values.chunks_mut(LANES).zip(weights.chunks(LANES)).zip(x.chunks(LANES));
        for ((values, weights), x) in chunks {
            let s = K::squared_distance(&load_points::<P, N>(x)).to_lanes();
            for ((value, &weight), &s) in values.iter_mut().zip(weights).zip(s.as_ref()) {
                *value = law.energy(weight, s);
            }
        }
    }
}

struct Gradients<'a, 'b, B: ?Sized, K, const N: usize> {
    run: Run<'a, B, N>,
    kind: K,
    gradients: &'b mut [[Vec3; N]],
}

impl<B: Barrier + ?Sized, K: Primitive<N>, const N: usize> LaneKernel<f64> for Gradients<'_, '_, B, K, N> {
    type Output = ();
    #[inline(always)]
    fn run<P: Packet<Element = f64>>(self) {
        let _ = self.kind;
        let Run { law, weights, x } = self.run;
        let chunks = self.gradients.chunks_mut(LANES).zip(weights.chunks(LANES)).zip(x.chunks(LANES));
        for ((gradients, weights), x) in chunks {
            let (shares, y) = K::closest(&load_points::<P, N>(x));
            let s = mechanics_core::tensor::dot(&y, &y);
            let mut first = s.to_lanes();
            for (first, &weight) in first.as_mut().iter_mut().zip(weights) {
                *first = 2.0 * law.first(weight, *first);
            }
            let force = times(&y, P::from_lanes(first));
            let mut forces = [force; N];
            for i in 0..N {
                forces[i] = times(&force, shares[i]);
            }
            store_vectors(&forces, gradients);
        }
    }
}

struct Hessians<'a, 'b, B: ?Sized, K, const N: usize> {
    run: Run<'a, B, N>,
    kind: K,
    projection: Projection,
    hessians: &'b mut [LocalHessian<N>],
}

impl<B: Barrier + ?Sized, K: Primitive<N>, const N: usize> LaneKernel<f64> for Hessians<'_, '_, B, K, N> {
    type Output = ();
    #[inline(always)]
    fn run<P: Packet<Element = f64>>(self) {
        let _ = self.kind;
        let Run { law, weights, x } = self.run;
        let rule = Rule { projection: self.projection, curvature: law.curvature };
        let chunks = self.hessians.chunks_mut(LANES).zip(weights.chunks(LANES)).zip(x.chunks(LANES));
        for ((hessians, weights), x) in chunks {
            let coefficients = |s: P| {
                let mut along = s.to_lanes();
                let mut across = P::constant(0.0).to_lanes();
                let each = along.as_mut().iter_mut().zip(across.as_mut()).zip(weights);
                for ((along, across), &weight) in each {
                    [*across, *along] = law.across_and_along(weight, *along);
                }
                [P::from_lanes(across), P::from_lanes(along)]
            };
            let blocks = K::hessian(&load_points::<P, N>(x), coefficients, rule);
            for i in 0..N {
                for j in 0..=i {
                    let targets = hessians.iter_mut().map(|hessian| &mut hessian[i][j]);
                    lanes::store_matrices(&blocks[i][j], targets);
                }
            }
        }
    }
}

/// Component k of point a of pair i on lane i of `[a][k]`. Lanes beyond the last pair repeat it, so that they hold
/// ordinary numbers; their results are not stored.
#[inline(always)]
fn load_points<P: Packet<Element = f64>, const N: usize>(x: &[[Vec3; N]]) -> [[P; 3]; N] {
    let last = x.len() - 1;
    let pairs = [&x[0], &x[last.min(1)], &x[last.min(2)], &x[last.min(3)]];
    let mut points = [[P::constant(0.0); 3]; N];
    for a in 0..N {
        for k in 0..3 {
            points[a][k] = P::from_lanes([pairs[0][a][k], pairs[1][a][k], pairs[2][a][k], pairs[3][a][k]]);
        }
    }
    points
}

/// Lane i of `vectors[a][k]` becomes component k of vector a of pair i.
#[inline(always)]
fn store_vectors<P: Packet<Element = f64>, const N: usize>(vectors: &[[P; 3]; N], targets: &mut [[Vec3; N]]) {
    for a in 0..N {
        let mut block = [vectors[a][0], vectors[a][1], vectors[a][2], P::constant(0.0)];
        P::transpose(&mut block);
        for (row, target) in block.iter().zip(targets.iter_mut()) {
            let [x, y, z, _] = row.to_lanes();
            target[a] = Vec3::new(x, y, z);
        }
    }
}

/// Makes a list of pairs a [`Stencil`](mechanics_core::stencil::Stencil) by its runs.
macro_rules! stencil {
    ($pairs:ident, $primitive:ident, $corners:literal) => {
        impl<B: crate::barrier::Barrier + ?Sized> mechanics_core::stencil::Stencil<$corners>
            for $pairs<'_, B>
        {
            fn value(&self, element: usize, x: &[mechanics_core::tensor::Vec3; $corners]) -> f64 {
                let mut value = [0.0];
                self.values_into(element, std::slice::from_ref(x), &mut value);
                value[0]
            }

            fn gradient(
                &self,
                element: usize,
                x: &[mechanics_core::tensor::Vec3; $corners],
            ) -> [mechanics_core::tensor::Vec3; $corners] {
                let mut gradient = [[mechanics_core::tensor::Vec3::zeros(); $corners]];
                self.gradients_into(element, std::slice::from_ref(x), &mut gradient);
                gradient[0]
            }

            fn hessian(
                &self,
                element: usize,
                x: &[mechanics_core::tensor::Vec3; $corners],
                projection: mechanics_core::projection::Projection,
            ) -> mechanics_core::stencil::LocalHessian<$corners> {
                let mut hessian = [[[mechanics_core::tensor::Mat3::zeros(); $corners]; $corners]];
                self.hessians_into(element, std::slice::from_ref(x), projection, &mut hessian);
                hessian[0]
            }

            fn demand(&self) -> mechanics_core::potential::Demand {
                mechanics_core::potential::Demand::EndPositions
            }

            fn values_into(
                &self,
                first: usize,
                x: &[[mechanics_core::tensor::Vec3; $corners]],
                values: &mut [f64],
            ) {
                Run::new(self.law, self.weights, first, x).values($primitive, values);
            }

            fn gradients_into(
                &self,
                first: usize,
                x: &[[mechanics_core::tensor::Vec3; $corners]],
                gradients: &mut [[mechanics_core::tensor::Vec3; $corners]],
            ) {
                Run::new(self.law, self.weights, first, x).gradients($primitive, gradients);
            }

            fn hessians_into(
                &self,
                first: usize,
                x: &[[mechanics_core::tensor::Vec3; $corners]],
                projection: mechanics_core::projection::Projection,
                hessians: &mut [mechanics_core::stencil::LocalHessian<$corners>],
            ) {
                Run::new(self.law, self.weights, first, x).hessians($primitive, projection, hessians);
            }
        }
    };
}
pub(super) use stencil;
