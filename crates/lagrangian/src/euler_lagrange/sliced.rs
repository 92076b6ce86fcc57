//! The Euler–Lagrange equations of a [`SlicedLagrangian`].

use super::trace::{self, Formulas, Trace};
use crate::system::{Curvature, Dependence, Expansion, SlicedLagrangian, System};
use mechanics_core::jet::Jet1;
use mechanics_core::scalar::Scalar;

/// A [`SlicedLagrangian`] as a [`System`].
#[derive(Clone, Debug, PartialEq)]
pub struct SlicedEulerLagrange<L> {
    /// T, V, R, Q.
    pub lagrangian: L,
}

impl<L: SlicedLagrangian> SlicedEulerLagrange<L> {
    /// The equations of motion of `lagrangian`.
    pub fn new(lagrangian: L) -> Self {
        Self { lagrangian }
    }
}

/// Directions in one pass.
const WIDTH: usize = 4;

type Slope = Jet1<f64, WIDTH>;
type Mixed = Jet1<Slope, WIDTH>;
type Rate = Jet1<Slope, 1>;

/// Coordinates `start..start + WIDTH` as variables, the others as constants.
fn windowed(x: &[f64], start: usize) -> Vec<Slope> {
    let mut jets: Vec<Slope> = x.iter().map(|&x| Slope::from_value(x)).collect();
    for (k, jet) in jets.iter_mut().skip(start).take(WIDTH).enumerate() {
        jet.gradient[k] = 1.0;
    }
    jets
}

/// The same as the outer variables of a nested jet.
fn outer(x: &[f64], start: usize) -> Vec<Mixed> {
    let mut jets: Vec<Mixed> = x.iter().map(|&x| Mixed::lift(x)).collect();
    for (k, jet) in jets.iter_mut().skip(start).take(WIDTH).enumerate() {
        jet.gradient[k] = Slope::from_value(1.0);
    }
    jets
}

fn lifted<S: Scalar<Value = f64>>(x: &[f64]) -> Vec<S> {
    x.iter().map(|&x| S::lift(x)).collect()
}

impl<L: SlicedLagrangian> System for SlicedEulerLagrange<L> {
    type Coordinates = Vec<f64>;

    fn dimension(&self) -> usize {
        self.lagrangian.dimension()
    }

    // Chunks of nested jets: to be replaced by chunks of the Euler–Lagrange jet, and kept as their oracle.
    fn expand(&self, t: f64, q: &Vec<f64>, v: &Vec<f64>, out: &mut Expansion<Vec<f64>>) {
        let (l, n) = (&self.lagrangian, self.dimension());
        out.kinetic = l.kinetic(q, v, t);
        out.potential = l.potential(q, t);
        out.applied.fill(0.0);
        l.add_force(q, v, t, &mut out.applied);
        let now = Rate { value: Slope::from_value(t), gradient: [Slope::from_value(1.0)] };
        let along: Vec<Rate> = (0..n)
            .map(|i| Rate { value: Slope::from_value(q[i]), gradient: [Slope::from_value(v[i])] })
            .collect();
        for a in (0..n).step_by(WIDTH) {
            let (in_q, in_v) = (windowed(q, a), windowed(v, a));
            let (q_slopes, v_slopes) = (lifted(q), lifted(v));
            let rate_v: Vec<Rate> = in_v.iter().map(|&v| Rate::from_value(v)).collect();
            let slope_q = l.kinetic(&in_q, &v_slopes, Slope::lift(t)) - l.potential(&in_q, Slope::lift(t));
            let slope_v = l.kinetic(&q_slopes, &in_v, Slope::lift(t));
            let lost = l.rayleigh(&q_slopes, &in_v, Slope::lift(t));
            let rate = l.kinetic(&along, &rate_v, now).gradient[0];
            for (k, i) in (a..n.min(a + WIDTH)).enumerate() {
                out.slope[i] = slope_q.gradient[k];
                out.momentum[i] = slope_v.gradient[k];
                out.applied[i] -= lost.gradient[k];
                out.momentum_rate[i] = rate.gradient[k];
            }
            for b in (0..=a).step_by(WIDTH) {
                let v = outer_and_inner(v, a, b);
                let mixed = l.kinetic(&lifted::<Mixed>(q), &v, Mixed::lift(t));
                set_block(&mut out.mass, n, (a, b), &mixed, Part::Symmetric);
            }
        }
    }

    fn curve(&self, t: f64, q: &Vec<f64>, v: &Vec<f64>, out: &mut Curvature<Vec<f64>>) {
        let (l, n, now) = (&self.lagrangian, self.dimension(), Mixed::lift(t));
        let (q_fixed, v_fixed) = (lifted::<Mixed>(q), lifted::<Mixed>(v));
        for a in (0..n).step_by(WIDTH) {
            for b in (0..=a).step_by(WIDTH) {
                let both = outer_and_inner(q, a, b);
                let qq = l.kinetic(&both, &v_fixed, now) - l.potential(&both, now);
                set_block(&mut out.qq, n, (a, b), &qq, Part::Symmetric);
                let both = outer_and_inner(v, a, b);
                let vv = l.kinetic(&q_fixed, &both, now);
                set_block(&mut out.vv, n, (a, b), &vv, Part::Symmetric);
                let lost = -l.rayleigh(&q_fixed, &both, now);
                set_block(&mut out.applied_v, n, (a, b), &lost, Part::Symmetric);
            }
            let in_v = outer(v, a);
            for b in (0..n).step_by(WIDTH) {
                let in_q: Vec<Mixed> = windowed(q, b).into_iter().map(Mixed::from_value).collect();
                set_block(&mut out.vq, n, (a, b), &l.kinetic(&in_q, &in_v, now), Part::General);
                let lost = -l.rayleigh(&in_q, &in_v, now);
                set_block(&mut out.applied_q, n, (a, b), &lost, Part::General);
            }
        }
        self.add_force_slopes(t, q, v, out);
    }

    fn dependence(&self, t: f64, q: &Vec<f64>, v: &Vec<f64>) -> Dependence {
        trace::dependence(&Sliced(&self.lagrangian), t, q, v)
    }
}

impl<L: SlicedLagrangian> SlicedEulerLagrange<L> {
    fn add_force_slopes(&self, t: f64, q: &[f64], v: &[f64], out: &mut Curvature<Vec<f64>>) {
        let n = q.len();
        let (q_fixed, v_fixed, now) = (lifted::<Slope>(q), lifted::<Slope>(v), Slope::lift(t));
        for b in (0..n).step_by(WIDTH) {
            let mut force_q = vec![Slope::from_value(0.0); n];
            let mut force_v = force_q.clone();
            self.lagrangian.add_force(&windowed(q, b), &v_fixed, now, &mut force_q);
            self.lagrangian.add_force(&q_fixed, &windowed(v, b), now, &mut force_v);
            for i in 0..n {
                for (k, j) in (b..n.min(b + WIDTH)).enumerate() {
                    out.applied_q[i * n + j] += force_q[i].gradient[k];
                    out.applied_v[i * n + j] += force_v[i].gradient[k];
                }
            }
        }
    }
}

fn outer_and_inner(x: &[f64], a: usize, b: usize) -> Vec<Mixed> {
    let mut jets = outer(x, a);
    for (k, jet) in jets.iter_mut().skip(b).take(WIDTH).enumerate() {
        jet.value.gradient[k] = 1.0;
    }
    jets
}

#[derive(Clone, Copy)]
enum Part {
    Symmetric,
    General,
}

/// Overwrites the block (a, b) of an n × n matrix by a mixed jet's, and its mirror image.
fn set_block(matrix: &mut [f64], n: usize, (a, b): (usize, usize), jet: &Mixed, part: Part) {
    for (k, i) in (a..n.min(a + WIDTH)).enumerate() {
        for (m, j) in (b..n.min(b + WIDTH)).enumerate() {
            matrix[i * n + j] = jet.gradient[k].gradient[m];
            if let Part::Symmetric = part {
                matrix[j * n + i] = jet.gradient[k].gradient[m];
            }
        }
    }
}

/// The formulas of a [`SlicedLagrangian`], for tracing.
struct Sliced<'a, L>(&'a L);

impl<L: SlicedLagrangian> Formulas for Sliced<'_, L> {
    fn kinetic(&self, q: &[Trace], v: &[Trace], t: Trace) -> Trace {
        self.0.kinetic(q, v, t)
    }
    fn potential(&self, q: &[Trace], t: Trace) -> Trace {
        self.0.potential(q, t)
    }
    fn rayleigh(&self, q: &[Trace], v: &[Trace], t: Trace) -> Trace {
        self.0.rayleigh(q, v, t)
    }
    fn force(&self, q: &[Trace], v: &[Trace], t: Trace) -> Vec<Trace> {
        let mut force = vec![Trace::constant(0.0); q.len()];
        self.0.add_force(q, v, t, &mut force);
        force
    }
}
