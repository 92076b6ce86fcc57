//! The Euler–Lagrange equations of a [`Lagrangian`], by automatic differentiation.

mod sliced;
mod trace;

pub use sliced::SlicedEulerLagrange;

use crate::system::{Curvature, Dependence, Expansion, Lagrangian, System};
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

fn lifted<S: Scalar<Value = f64>, const N: usize>(x: &[f64; N]) -> [S; N] {
    x.map(S::lift)
}

impl<const N: usize, L: Lagrangian<N>> System for EulerLagrange<L, N> {
    type Coordinates = [f64; N];

    fn dimension(&self) -> usize {
        N
    }

    // Three passes of nested jets: to be replaced by one pass of an Euler–Lagrange jet, and kept as its oracle.
    fn expand(&self, t: f64, q: &[f64; N], v: &[f64; N], out: &mut Expansion<[f64; N]>) {
        let l = &self.lagrangian;
        let in_v = l.kinetic(&lifted(q), &Jet2::variables(*v), Jet2::lift(t));
        out.kinetic = in_v.value;
        out.momentum = in_v.gradient;
        out.mass = in_v.hessian_matrix();

        type Rate<const N: usize> = Jet1<Jet1<f64, N>, 1>;
        let along: [Rate<N>; N] = std::array::from_fn(|i| Jet1 {
            value: Jet1::from_value(q[i]),
            gradient: [Jet1::from_value(v[i])],
        });
        let velocity = Jet1::<f64, N>::variables(*v).map(Rate::<N>::from_value);
        let now = Jet1 { value: Jet1::from_value(t), gradient: [Jet1::from_value(1.0)] };
        out.momentum_rate = l.kinetic(&along, &velocity, now).gradient[0].gradient;

        let in_q = Jet1::<f64, N>::variables(*q);
        let kinetic = l.kinetic(&in_q, &lifted(v), Jet1::lift(t));
        let potential = l.potential(&in_q, Jet1::lift(t));
        out.potential = potential.value;
        out.slope = (kinetic - potential).gradient;

        let lost = l.rayleigh(&lifted(q), &Jet1::<f64, N>::variables(*v), Jet1::lift(t));
        let force = l.force(q, v, t);
        out.applied = std::array::from_fn(|i| force[i] - lost.gradient[i]);
    }

    fn curve(&self, t: f64, q: &[f64; N], v: &[f64; N], out: &mut Curvature<[f64; N]>) {
        let l = &self.lagrangian;
        let in_q = Jet2::<f64, N>::variables(*q);
        let now = Jet2::lift(t);
        out.qq = (l.kinetic(&in_q, &lifted(v), now) - l.potential(&in_q, now)).hessian_matrix();
        out.vv = l.kinetic(&lifted(q), &Jet2::<f64, N>::variables(*v), now).hessian_matrix();

        type Mixed<const N: usize> = Jet1<Jet1<f64, N>, N>;
        let outer: [Mixed<N>; N] = Mixed::variables(lifted::<Jet1<f64, N>, N>(q));
        let inner = Jet1::<f64, N>::variables(*v).map(Mixed::<N>::from_value);
        let mixed = l.kinetic(&outer, &inner, Mixed::<N>::lift(t));
        let lost = l.rayleigh(&outer, &inner, Mixed::<N>::lift(t));
        let lost_v = l.rayleigh(&lifted(q), &Jet2::<f64, N>::variables(*v), now);
        let force_q = l.force(&Jet1::<f64, N>::variables(*q), &lifted(v), Jet1::lift(t));
        let force_v = l.force(&lifted(q), &Jet1::<f64, N>::variables(*v), Jet1::lift(t));
        for i in 0..N {
            for j in 0..N {
                out.vq[i][j] = mixed.gradient[j].gradient[i];
                out.applied_q[i][j] = force_q[i].gradient[j] - lost.gradient[j].gradient[i];
                out.applied_v[i][j] = force_v[i].gradient[j] - lost_v.hessian(i, j);
            }
        }
    }

    fn dependence(&self, t: f64, q: &[f64; N], v: &[f64; N]) -> Dependence {
        trace::dependence(&Fixed::<L, N>(&self.lagrangian), t, q, v)
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
