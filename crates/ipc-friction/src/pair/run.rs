//! Runs of consecutive pairs through the lanes of vector registers.

use super::LaggedPair;
use crate::law::{SmoothedCoulomb, Strength};
use mechanics_core::lanes::{self, LaneKernel, Packet};
use mechanics_core::projection::Projection;
use mechanics_core::stencil::LocalHessian;
use mechanics_core::tensor::{self, Matrix3, Vec3};

/// Lanes of a packet of `f64`.
const LANES: usize = 4;

/// Consecutive pairs and their points.
pub(super) struct Run<'a, const N: usize> {
    pub(super) law: SmoothedCoulomb,
    pub(super) velocity_factor: f64,
    pub(super) floor: f64,
    pub(super) pairs: &'a [LaggedPair<N>],
    pub(super) x: &'a [[Vec3; N]],
}

impl<const N: usize> Run<'_, N> {
    /// Overwrites `values`.
    pub(super) fn values(self, values: &mut [f64]) {
        assert_eq!(values.len(), self.x.len(), "one energy for each pair");
        lanes::dispatch(Values { run: self, values });
    }

    /// Overwrites `gradients`.
    pub(super) fn gradients(self, gradients: &mut [[Vec3; N]]) {
        assert_eq!(gradients.len(), self.x.len(), "one gradient for each pair");
        lanes::dispatch(Gradients { run: self, gradients });
    }

    /// Overwrites the lower triangles of `hessians`.
    pub(super) fn hessians(self, projection: Projection, hessians: &mut [LocalHessian<N>]) {
        assert_eq!(hessians.len(), self.x.len(), "one Hessian for each pair");
        lanes::dispatch(Hessians { run: self, projection, hessians });
    }
}

/// Up to four pairs, one on each lane, at their positions.
struct Slips<P, const N: usize> {
    weights: [P; N],
    normal: [P; 3],
    strength: Strength<P>,
    /// u.
    slip: [P; 3],
    /// y.
    speed: P,
}

impl<P: Packet<Element = f64>, const N: usize> Slips<P, N> {
    /// Lanes beyond the last pair repeat it, so that they hold ordinary numbers; their results are not stored.
    #[inline(always)]
    fn load(pairs: &[LaggedPair<N>], x: &[[Vec3; N]], velocity_factor: f64) -> Self {
        let last = x.len() - 1;
        let lane = [0, last.min(1), last.min(2), last.min(3)];
        let p = [&pairs[lane[0]], &pairs[lane[1]], &pairs[lane[2]], &pairs[lane[3]]];
        let x = [&x[lane[0]], &x[lane[1]], &x[lane[2]], &x[lane[3]]];
        let mut weights = [P::constant(0.0); N];
        let (mut normal, mut relative) = ([P::constant(0.0); 3], [P::constant(0.0); 3]);
        for k in 0..3 {
            normal[k] = P::from_lanes([p[0].normal[k], p[1].normal[k], p[2].normal[k], p[3].normal[k]]);
            let origin = [p[0].origin[k], p[1].origin[k], p[2].origin[k], p[3].origin[k]];
            relative[k] = -P::from_lanes(origin);
        }
        for a in 0..N {
            weights[a] = P::from_lanes([p[0].weights[a], p[1].weights[a], p[2].weights[a], p[3].weights[a]]);
            for k in 0..3 {
                let x = P::from_lanes([x[0][a][k], x[1][a][k], x[2][a][k], x[3][a][k]]);
                relative[k] = x.mul_add(weights[a], relative[k]);
            }
        }
        let s = [p[0].strength, p[1].strength, p[2].strength, p[3].strength];
        let strength = Strength {
            at_rest: P::from_lanes([s[0].at_rest, s[1].at_rest, s[2].at_rest, s[3].at_rest]),
            fall: P::from_lanes([s[0].fall, s[1].fall, s[2].fall, s[3].fall]),
        };
        let along = tensor::dot(&normal, &relative);
        let mut slip = relative;
        for k in 0..3 {
            slip[k] = (relative[k] - along * normal[k]).scale(velocity_factor);
        }
        let speed = tensor::dot(&slip, &slip).sqrt();
        Self { weights, normal, strength, slip, speed }
    }

    /// The lower triangle of K, projected.
    #[inline(always)]
    fn curvature(
        &self,
        law: SmoothedCoulomb,
        velocity_factor: f64,
        floor: f64,
        projection: Projection,
    ) -> Matrix3<P> {
        let Self { normal, strength, slip, speed, .. } = self;
        let along = projection.apply(law.slope(*strength, *speed).scale(velocity_factor));
        let across = projection.apply(law.force_over_speed(*strength, *speed).scale(velocity_factor));
        // Not for θ = 0, which would clamp the true Hessian.
        let along = if floor > 0.0 { along.max(across.scale(floor)) } else { along };
        // û is zero where there is no slip: the difference is zero there.
        let reciprocal = speed.max(P::constant(f64::MIN_POSITIVE)).recip();
        let mut direction = *slip;
        for k in 0..3 {
            direction[k] = slip[k] * reciprocal;
        }
        let difference = along - across;
        let mut columns = [[P::constant(0.0); 3]; 3];
        for j in 0..3 {
            for i in 0..3 {
                let entry = difference * direction[i] * direction[j] - across * normal[i] * normal[j];
                columns[j][i] = if i == j { entry + across } else { entry };
            }
        }
        tensor::from_columns(columns)
    }
}

struct Values<'a, 'b, const N: usize> {
    run: Run<'a, N>,
    values: &'b mut [f64],
}

impl<const N: usize> LaneKernel<f64> for Values<'_, '_, N> {
    type Output = ();
    #[inline(always)]
    fn run<P: Packet<Element = f64>>(self) {
        let Run { law, velocity_factor, pairs, x, .. } = self.run;
        let chunks = self.values.chunks_mut(LANES).zip(pairs.chunks(LANES)).zip(x.chunks(LANES));
        for ((values, pairs), x) in chunks {
            let slips = Slips::<P, N>::load(pairs, x, velocity_factor);
            let value = law.potential(slips.strength, slips.speed).scale(1.0 / velocity_factor);
            value.store_prefix(values);
        }
    }
}

struct Gradients<'a, 'b, const N: usize> {
    run: Run<'a, N>,
    gradients: &'b mut [[Vec3; N]],
}

impl<const N: usize> LaneKernel<f64> for Gradients<'_, '_, N> {
    type Output = ();
    #[inline(always)]
    fn run<P: Packet<Element = f64>>(self) {
        let Run { law, velocity_factor, pairs, x, .. } = self.run;
        let chunks = self.gradients.chunks_mut(LANES).zip(pairs.chunks(LANES)).zip(x.chunks(LANES));
        for ((gradients, pairs), x) in chunks {
            let slips = Slips::<P, N>::load(pairs, x, velocity_factor);
            let factor = law.force_over_speed(slips.strength, slips.speed);
            for a in 0..N {
                let share = factor * slips.weights[a];
                let mut block =
                    [slips.slip[0] * share, slips.slip[1] * share, slips.slip[2] * share, P::constant(0.0)];
                P::transpose(&mut block);
                for (row, gradient) in block.iter().zip(gradients.iter_mut()) {
                    let [x, y, z, _] = row.to_lanes();
                    gradient[a] = Vec3::new(x, y, z);
                }
            }
        }
    }
}

struct Hessians<'a, 'b, const N: usize> {
    run: Run<'a, N>,
    projection: Projection,
    hessians: &'b mut [LocalHessian<N>],
}

impl<const N: usize> LaneKernel<f64> for Hessians<'_, '_, N> {
    type Output = ();
    #[inline(always)]
    fn run<P: Packet<Element = f64>>(self) {
        let Run { law, velocity_factor, floor, pairs, x } = self.run;
        let chunks = self.hessians.chunks_mut(LANES).zip(pairs.chunks(LANES)).zip(x.chunks(LANES));
        for ((hessians, pairs), x) in chunks {
            let slips = Slips::<P, N>::load(pairs, x, velocity_factor);
            let curvature = slips.curvature(law, velocity_factor, floor, self.projection);
            for i in 0..N {
                for j in 0..=i {
                    let block = tensor::scaled(&curvature, slips.weights[i] * slips.weights[j]);
                    lanes::store_matrices(&block, hessians.iter_mut().map(|hessian| &mut hessian[i][j]));
                }
            }
        }
    }
}
