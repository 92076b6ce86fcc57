//! The Euler–Lagrange equations of a [`Lagrangian`], by automatic differentiation.

mod coupling;
mod sliced;
mod trace;

pub use sliced::SlicedEulerLagrange;

use crate::dense;
use crate::error::LagrangianError;
use crate::jet::{EulerLagrangeJet, PhaseJet1, PhaseJet2};
use crate::system::{Curvature, Dependence, Expansion, Gradient, Lagrangian, System, culprit};
use mechanics_core::jet::{Jet1, Jet2};
use mechanics_core::scalar::Scalar;
use trace::{Formulas, Trace};

/// A [`Lagrangian`] as a [`System`].
#[derive(Clone, Debug, PartialEq)]
pub struct EulerLagrange<L, const N: usize> {
    /// T, V, R, Q.
    pub lagrangian: L,
}

impl<const N: usize, L: Lagrangian<N>> EulerLagrange<L, N> {
    /// The equations of motion of `lagrangian`.
    pub fn new(lagrangian: L) -> Self {
        Self { lagrangian }
    }
}

impl<const N: usize, L: Lagrangian<N>> System for EulerLagrange<L, N> {
    type Coordinates = [f64; N];

    fn dimension(&self) -> usize {
        N
    }

    // T needs one pass of the Euler–Lagrange jet; V, R and Q have first derivatives only.
    fn expand(&self, t: f64, q: &[f64; N], v: &[f64; N], out: &mut Expansion<[f64; N]>) {
        let (kinetic, potential) = (self.kinetic(t, q, v), self.potential(t, q));
        out.kinetic = kinetic.value;
        out.potential = potential.value;
        out.momentum = kinetic.momentum;
        out.momentum_rate = kinetic.momentum_rate;
        out.slope = std::array::from_fn(|i| kinetic.slope[i] - potential.gradient[i]);
        out.applied = self.applied(t, q, v);
        out.mass = kinetic.mass_matrix();
    }

    #[inline(never)]
    fn differentiate(&self, t: f64, q: &[f64; N], v: &[f64; N], out: &mut Gradient<[f64; N]>) {
        let (in_q, in_v) = PhaseJet1::phase(*q, *v);
        let kinetic = self.lagrangian.kinetic(&in_q, &in_v, PhaseJet1::lift(t));
        let potential = self.potential(t, q);
        out.kinetic = kinetic.value;
        out.potential = potential.value;
        out.momentum = kinetic.v;
        out.slope = std::array::from_fn(|i| kinetic.q[i] - potential.gradient[i]);
        out.applied = self.applied(t, q, v);
    }

    // The same as `expand` and a solution, without what q̈ does not need: the compiler drops the value of V.
    #[inline]
    fn acceleration(
        &self,
        t: f64,
        q: &[f64; N],
        v: &[f64; N],
        acceleration: &mut [f64; N],
    ) -> Result<(), LagrangianError> {
        let (kinetic, potential, applied) =
            (self.kinetic(t, q, v), self.potential(t, q), self.applied(t, q, v));
        *acceleration = std::array::from_fn(|i| {
            kinetic.slope[i] - potential.gradient[i] + applied[i] - kinetic.momentum_rate[i]
        });
        dense::solve_mass::<[f64; N]>(t, &mut kinetic.mass_matrix(), acceleration)
            .map_err(|refusal| culprit(self, (t, q, v), refusal))
    }

    fn curve(&self, t: f64, q: &[f64; N], v: &[f64; N], out: &mut Curvature<[f64; N]>) {
        let l = &self.lagrangian;
        let (in_q, in_v) = PhaseJet2::phase(*q, *v);
        let kinetic = l.kinetic(&in_q, &in_v, PhaseJet2::lift(t));
        let potential = l.potential(&Jet2::<f64, N>::variables(*q), Jet2::lift(t)).hessian_matrix();
        let lost = l.rayleigh(&in_q, &in_v, PhaseJet2::lift(t));
        let (in_q, in_v) = PhaseJet1::phase(*q, *v);
        let force = l.force(&in_q, &in_v, PhaseJet1::lift(t));
        let (kinetic_qq, lost_vv) = (kinetic.qq_matrix(), lost.vv_matrix());
        out.vq = kinetic.vq;
        out.vv = kinetic.vv_matrix();
        for i in 0..N {
            for j in 0..N {
                out.qq[i][j] = kinetic_qq[i][j] - potential[i][j];
                out.applied_q[i][j] = force[i].q[j] - lost.vq[i][j];
                out.applied_v[i][j] = force[i].v[j] - lost_vv[i][j];
            }
        }
    }

    fn dependence(&self, t: f64, q: &[f64; N], v: &[f64; N]) -> Dependence {
        trace::dependence(&Fixed::<L, N>(&self.lagrangian), t, q, v)
    }
}

impl<const N: usize, L: Lagrangian<N>> EulerLagrange<L, N> {
    /// T in one pass of the Euler–Lagrange jet. Not inlined, so that this is the one place where T meets that jet: the
    /// compiler then inlines T itself here, and its arguments' zeros and ones with it.
    #[inline(never)]
    fn kinetic(&self, t: f64, q: &[f64; N], v: &[f64; N]) -> EulerLagrangeJet<f64, N> {
        let (q, v, now) = EulerLagrangeJet::phase(t, *q, *v);
        self.lagrangian.kinetic(&q, &v, now)
    }

    /// V and ∂V/∂q.
    #[inline]
    fn potential(&self, t: f64, q: &[f64; N]) -> Jet1<f64, N> {
        self.lagrangian.potential(&Jet1::variables(*q), Jet1::lift(t))
    }

    /// F = Q − ∂R/∂v. The defaults of R and Q are constants that the compiler sees through.
    #[inline]
    fn applied(&self, t: f64, q: &[f64; N], v: &[f64; N]) -> [f64; N] {
        let slope = Jet1::<f64, N>::variables(*v);
        let lost = self.lagrangian.rayleigh(&q.map(Jet1::lift), &slope, Jet1::lift(t));
        let force = self.lagrangian.force(q, v, t);
        std::array::from_fn(|i| force[i] - lost.gradient[i])
    }
}

/// The formulas of a [`Lagrangian`], for tracing.
struct Fixed<'a, L, const N: usize>(&'a L);

/// The `N` numbers of a slice.
fn array<const N: usize>(x: &[Trace]) -> [Trace; N] {
    std::array::from_fn(|i| x[i])
}

impl<const N: usize, L: Lagrangian<N>> Formulas for Fixed<'_, L, N> {
    fn kinetic(&self, q: &[Trace], v: &[Trace], t: Trace) -> Trace {
        self.0.kinetic(&array(q), &array(v), t)
    }
    fn potential(&self, q: &[Trace], t: Trace) -> Trace {
        self.0.potential(&array(q), t)
    }
    fn rayleigh(&self, q: &[Trace], v: &[Trace], t: Trace) -> Trace {
        self.0.rayleigh(&array(q), &array(v), t)
    }
    fn force(&self, q: &[Trace], v: &[Trace], t: Trace) -> Vec<Trace> {
        self.0.force(&array(q), &array(v), t).to_vec()
    }
}
