//! The same derivatives by brute force: core's jets, nested, one pass for every kind of derivative.

use lagrangian::{Curvature, Expansion, Lagrangian};
use mechanics_core::jet::{Jet1, Jet2};
use mechanics_core::scalar::Scalar;

fn lifted<S: Scalar<Value = f64>, const N: usize>(x: &[f64; N]) -> [S; N] {
    x.map(S::lift)
}

pub(crate) fn expand<const N: usize>(
    l: &impl Lagrangian<N>,
    t: f64,
    q: &[f64; N],
    v: &[f64; N],
) -> Expansion<[f64; N]> {
    let in_v = l.kinetic(&lifted(q), &Jet2::variables(*v), Jet2::lift(t));

    let along: [Jet1<Jet1<f64, N>, 1>; N] =
        std::array::from_fn(|i| Jet1 { value: Jet1::from_value(q[i]), gradient: [Jet1::from_value(v[i])] });
    let velocity = Jet1::<f64, N>::variables(*v).map(Jet1::from_value);
    let now = Jet1 { value: Jet1::from_value(t), gradient: [Jet1::from_value(1.0)] };
    let momentum_rate = l.kinetic(&along, &velocity, now).gradient[0].gradient;

    let in_q = Jet1::<f64, N>::variables(*q);
    let kinetic = l.kinetic(&in_q, &lifted(v), Jet1::lift(t));
    let potential = l.potential(&in_q, Jet1::lift(t));
    let lost = l.rayleigh(&lifted(q), &Jet1::<f64, N>::variables(*v), Jet1::lift(t));
    let force = l.force(q, v, t);
    Expansion {
        kinetic: in_v.value,
        potential: potential.value,
        momentum: in_v.gradient,
        momentum_rate,
        slope: (kinetic - potential).gradient,
        applied: std::array::from_fn(|i| force[i] - lost.gradient[i]),
        mass: in_v.hessian_matrix(),
    }
}

pub(crate) fn curve<const N: usize>(
    l: &impl Lagrangian<N>,
    t: f64,
    q: &[f64; N],
    v: &[f64; N],
) -> Curvature<[f64; N]> {
    let in_q = Jet2::<f64, N>::variables(*q);
    let now = Jet2::lift(t);
    let mut out = Curvature::<[f64; N]>::zeros(N);
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
    out
}
