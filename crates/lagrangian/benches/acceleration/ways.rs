//! Other ways to the same acceleration: num-dual's Hessian, and core's jets nested in three passes.

use lagrangian::{Expansion, Lagrangian, dense};
use mechanics_core::jet::{Jet1, Jet2};
use mechanics_core::scalar::Scalar;
use nalgebra::SVector;
use num_dual::{Dual2SVec64, hessian};

/// M q̈ = ∂L/∂q − D ∂L/∂v from the whole Hessian of L in (q, v). `Z` is 2 `N`.
pub(crate) fn by_num_dual<const N: usize, const Z: usize>(
    lagrangian: impl Fn(&[Dual2SVec64<Z>; N], &[Dual2SVec64<Z>; N]) -> Dual2SVec64<Z>,
    q: &[f64; N],
    v: &[f64; N],
) -> [f64; N] {
    let z = SVector::<f64, Z>::from_fn(|i, _| if i < N { q[i] } else { v[i - N] });
    let (_, gradient, second) = hessian(
        |z: SVector<Dual2SVec64<Z>, Z>| {
            let (q, v) = (std::array::from_fn(|i| z[i]), std::array::from_fn(|i| z[N + i]));
            lagrangian(&q, &v)
        },
        &z,
    );
    let mut mass = [[0.0; N]; N];
    let mut b = [0.0; N];
    for i in 0..N {
        b[i] = gradient[i];
        for j in 0..N {
            mass[i][j] = second[(N + i, N + j)];
            b[i] -= second[(N + i, j)] * v[j];
        }
    }
    solved(mass, b)
}

fn solved<const N: usize>(mut mass: [[f64; N]; N], mut b: [f64; N]) -> [f64; N] {
    match dense::solve_mass::<[f64; N]>(0.0, &mut mass, &mut b) {
        Ok(()) => b,
        Err(_) => [f64::NAN; N],
    }
}

/// Mass by a second-order jet in v, rate of momentum by a jet along D over a jet in v, slopes by a jet in q.
pub(crate) fn by_nested_jets<const N: usize>(l: &impl Lagrangian<N>, q: &[f64; N], v: &[f64; N]) -> [f64; N] {
    let mut at = Expansion::<[f64; N]>::zeros(N);
    at.mass = l.kinetic(&q.map(Jet2::lift), &Jet2::<f64, N>::variables(*v), Jet2::lift(0.0)).hessian_matrix();
    let along = std::array::from_fn(|i| Jet1::<Jet1<f64, N>, 1> {
        value: Jet1::from_value(q[i]),
        gradient: [Jet1::from_value(v[i])],
    });
    let velocity = Jet1::<f64, N>::variables(*v).map(Jet1::from_value);
    at.momentum_rate = l.kinetic(&along, &velocity, Jet1::constant(0.0)).gradient[0].gradient;
    let in_q = Jet1::<f64, N>::variables(*q);
    let kinetic = l.kinetic(&in_q, &v.map(Jet1::lift), Jet1::lift(0.0));
    at.slope = (kinetic - l.potential(&in_q, Jet1::lift(0.0))).gradient;
    solved(at.mass, std::array::from_fn(|i| at.slope[i] - at.momentum_rate[i]))
}
