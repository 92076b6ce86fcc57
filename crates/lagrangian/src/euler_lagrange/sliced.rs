//! The Euler–Lagrange equations of a [`SlicedLagrangian`].
//!
//! Jets have a fixed width, so derivatives come a window of [`WIDTH`] coordinates at a time: n / `WIDTH` passes of the
//! Euler–Lagrange jet give everything but the mass matrix's blocks off its diagonal, which take a pass of a mixed jet
//! each, and only if T couples the two windows (see [`coupling`](super::coupling)). So a chain of n masses costs a number
//! of passes proportional to n, a pendulum of n links one proportional to n².

use super::coupling::{Coupled, Couplings};
use super::trace::{self, Formulas, Trace};
use crate::jet::{EulerLagrangeJet, PhaseJet1};
use crate::system::{Curvature, Dependence, Expansion, Gradient, SlicedLagrangian, System};
use mechanics_core::jet::Jet1;
use mechanics_core::scalar::Scalar;
use std::ops::Range;

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

/// Coordinates in one window. Four beat eight, for chains as for pendulums of 5 to 100 masses (see the bench).
const WIDTH: usize = 4;

type Slope = Jet1<f64, WIDTH>;
type Moving = EulerLagrangeJet<f64, WIDTH>;
/// Derivatives in the outer window's arguments of those in the inner window's.
type Mixed = Jet1<Slope, WIDTH>;

/// The windows of arguments `from..to`.
fn windows(from: usize, to: usize) -> impl Iterator<Item = Range<usize>> {
    (from..to).step_by(WIDTH).map(move |start| start..to.min(start + WIDTH))
}

fn lifted<S: Scalar<Value = f64>>(x: &[f64]) -> Vec<S> {
    x.iter().map(|&x| S::lift(x)).collect()
}

/// q and v in one vector.
fn stacked<S: Scalar<Value = f64>>(q: &[f64], v: &[f64]) -> Vec<S> {
    q.iter().chain(v).map(|&x| S::lift(x)).collect()
}

impl<L: SlicedLagrangian> System for SlicedEulerLagrange<L> {
    type Coordinates = Vec<f64>;

    fn dimension(&self) -> usize {
        self.lagrangian.dimension()
    }

    fn expand(&self, t: f64, q: &Vec<f64>, v: &Vec<f64>, out: &mut Expansion<Vec<f64>>) {
        self.expand_kinetic(t, q, v, out);
        self.add_couplings_of_mass(t, q, v, &mut out.mass);
        out.potential = self.subtract_slope_of_potential(t, q, &mut out.slope);
        self.applied_into(t, q, v, &mut out.applied);
    }

    fn differentiate(&self, t: f64, q: &Vec<f64>, v: &Vec<f64>, out: &mut Gradient<Vec<f64>>) {
        let (mut in_q, mut in_v) = (lifted(q), lifted(v));
        for window in windows(0, q.len()) {
            let seed = |q: &mut [PhaseJet1<f64, WIDTH>], v: &mut [PhaseJet1<f64, WIDTH>], x: f64| {
                for (k, i) in window.clone().enumerate() {
                    q[i].q[k] = x;
                    v[i].v[k] = x;
                }
            };
            seed(&mut in_q, &mut in_v, 1.0);
            let kinetic = self.lagrangian.kinetic(&in_q, &in_v, PhaseJet1::lift(t));
            seed(&mut in_q, &mut in_v, 0.0);
            out.kinetic = kinetic.value;
            for (k, i) in window.enumerate() {
                out.momentum[i] = kinetic.v[k];
                out.slope[i] = kinetic.q[k];
            }
        }
        out.potential = self.subtract_slope_of_potential(t, q, &mut out.slope);
        self.applied_into(t, q, v, &mut out.applied);
    }

    fn curve(&self, t: f64, q: &Vec<f64>, v: &Vec<f64>, out: &mut Curvature<Vec<f64>>) {
        let (l, n) = (&self.lagrangian, q.len());
        let Curvature { qq, vq, vv, applied_q, applied_v } = out;
        for matrix in [&mut *qq, vq, vv, applied_q, applied_v] {
            matrix.fill(0.0);
        }
        let phase: Vec<Range<usize>> = windows(0, n).chain(windows(n, 2 * n)).collect();
        let (mut z, now) = (stacked::<Mixed>(q, v), Mixed::lift(t));
        let coupled = stacked::<Coupled>(q, v);

        let kinetic = |z: &[Mixed]| l.kinetic(&z[..n], &z[n..], now);
        let tracer = |z: &[Coupled]| l.kinetic(&z[..n], &z[n..], Coupled::lift(t));
        visit_couplings(&phase, &coupled, tracer, &mut z, kinetic, |a, b, jet| {
            match (a.start >= n, b.start >= n) {
                (false, false) => add_symmetric(qq, n, a, b, 1.0, jet),
                (true, false) => add_general(vq, n, a, b, 1.0, jet),
                _ => add_symmetric(vv, n, a, b, 1.0, jet),
            }
        });

        let potential = |z: &[Mixed]| l.potential(&z[..n], now);
        let tracer = |z: &[Coupled]| l.potential(&z[..n], Coupled::lift(t));
        let only_q = &phase[..phase.len() / 2];
        visit_couplings(only_q, &coupled, tracer, &mut z, potential, |a, b, jet| {
            add_symmetric(qq, n, a, b, -1.0, jet);
        });

        let rayleigh = |z: &[Mixed]| l.rayleigh(&z[..n], &z[n..], now);
        let tracer = |z: &[Coupled]| l.rayleigh(&z[..n], &z[n..], Coupled::lift(t));
        visit_couplings(&phase, &coupled, tracer, &mut z, rayleigh, |a, b, jet| {
            match (a.start >= n, b.start >= n) {
                (false, _) => {}
                (true, false) => add_general(applied_q, n, a, b, -1.0, jet),
                (true, true) => add_symmetric(applied_v, n, a, b, -1.0, jet),
            }
        });
        self.add_slopes_of_force(t, q, v, [applied_q, applied_v]);
    }

    fn dependence(&self, t: f64, q: &Vec<f64>, v: &Vec<f64>) -> Dependence {
        trace::dependence(&Sliced(&self.lagrangian), t, q, v)
    }
}

impl<L: SlicedLagrangian> SlicedEulerLagrange<L> {
    /// T's part of an expansion, but for the mass matrix's blocks off the diagonal, which it makes zero.
    fn expand_kinetic(&self, t: f64, q: &[f64], v: &[f64], out: &mut Expansion<Vec<f64>>) {
        let n = q.len();
        let mut moving: Vec<Moving> = q.iter().zip(v).map(|(&q, &v)| Moving::moving(q, v)).collect();
        let (mut velocity, now) = (lifted::<Moving>(v), Moving::moving(t, 1.0));
        out.mass.fill(0.0);
        for window in windows(0, n) {
            for (k, i) in window.clone().enumerate() {
                moving[i].slope[k] = 1.0;
                velocity[i] = Moving::velocity(v[i], Some(k));
            }
            let kinetic = self.lagrangian.kinetic(&moving, &velocity, now);
            out.kinetic = kinetic.value;
            for (k, i) in window.clone().enumerate() {
                moving[i].slope[k] = 0.0;
                velocity[i] = Moving::velocity(v[i], None);
                out.momentum[i] = kinetic.momentum[k];
                out.momentum_rate[i] = kinetic.momentum_rate[k];
                out.slope[i] = kinetic.slope[k];
                for (m, j) in window.clone().enumerate() {
                    out.mass[i * n + j] = kinetic.mass(k, m);
                }
            }
        }
    }

    fn add_couplings_of_mass(&self, t: f64, q: &[f64], v: &[f64], mass: &mut [f64]) {
        let n = q.len();
        let all: Vec<Range<usize>> = windows(0, n).collect();
        if all.len() < 2 {
            return;
        }
        let (q_traced, v_traced) = (lifted::<Coupled>(q), lifted::<Coupled>(v));
        let tracer = |v: &[Coupled]| self.lagrangian.kinetic(&q_traced, v, Coupled::lift(t));
        let couplings = couplings(&all, &v_traced, tracer);
        let mut coupled = pairs(all.len()).filter(|&(a, b)| a != b && couplings.has(a, b)).peekable();
        // Masses in a row share no kinetic energy: their matrix is done.
        if coupled.peek().is_none() {
            return;
        }
        let (q_fixed, mut in_v, now) = (lifted::<Mixed>(q), lifted::<Mixed>(v), Mixed::lift(t));
        let kinetic = |v: &[Mixed]| self.lagrangian.kinetic(&q_fixed, v, now);
        for (a, b) in coupled {
            let jet = mixed(&mut in_v, &all[a], &all[b], kinetic);
            add_symmetric(mass, n, &all[a], &all[b], 1.0, &jet);
        }
    }

    /// V; its slope is taken off.
    fn subtract_slope_of_potential(&self, t: f64, q: &[f64], slope: &mut [f64]) -> f64 {
        let mut value = self.lagrangian.potential(q, t);
        let mut in_q = lifted::<Slope>(q);
        for window in windows(0, q.len()) {
            window.clone().enumerate().for_each(|(k, i)| in_q[i].gradient[k] = 1.0);
            let potential = self.lagrangian.potential(&in_q, Slope::lift(t));
            value = potential.value;
            for (k, i) in window.enumerate() {
                in_q[i].gradient[k] = 0.0;
                slope[i] -= potential.gradient[k];
            }
        }
        value
    }

    /// F = Q − ∂R/∂v.
    fn applied_into(&self, t: f64, q: &[f64], v: &[f64], applied: &mut [f64]) {
        applied.fill(0.0);
        self.lagrangian.add_force(q, v, t, applied);
        let (q_fixed, mut in_v) = (lifted::<Slope>(q), lifted::<Slope>(v));
        for window in windows(0, q.len()) {
            window.clone().enumerate().for_each(|(k, i)| in_v[i].gradient[k] = 1.0);
            let lost = self.lagrangian.rayleigh(&q_fixed, &in_v, Slope::lift(t));
            for (k, i) in window.enumerate() {
                in_v[i].gradient[k] = 0.0;
                applied[i] -= lost.gradient[k];
            }
        }
    }

    /// ∂Q/∂q and ∂Q/∂v, window by window of those that Q mentions.
    fn add_slopes_of_force(&self, t: f64, q: &[f64], v: &[f64], applied: [&mut Vec<f64>; 2]) {
        let n = q.len();
        let phase: Vec<Range<usize>> = windows(0, n).chain(windows(n, 2 * n)).collect();
        let coupled = arguments(&phase, &stacked::<Coupled>(q, v));
        let mut traced = vec![Coupled::lift(0.0); n];
        self.lagrangian.add_force(&coupled[..n], &coupled[n..], Coupled::lift(t), &mut traced);
        let mut z = stacked::<Slope>(q, v);
        let mut force = vec![Slope::lift(0.0); n];
        for (block, window) in phase.iter().enumerate() {
            if !traced.iter().any(|f| f.mentions(block, phase.len())) {
                continue;
            }
            window.clone().enumerate().for_each(|(k, j)| z[j].gradient[k] = 1.0);
            force.fill(Slope::lift(0.0));
            self.lagrangian.add_force(&z[..n], &z[n..], Slope::lift(t), &mut force);
            for (k, j) in window.clone().enumerate() {
                z[j].gradient[k] = 0.0;
                let matrix = &mut *applied[j / n];
                force.iter().enumerate().for_each(|(i, f)| matrix[i * n + j % n] += f.gradient[k]);
            }
        }
    }
}

/// Pairs (a, b) with a ≥ b.
fn pairs(count: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..count).flat_map(|a| (0..=a).map(move |b| (a, b)))
}

/// `z` with every argument in a window marked by the window's number; the others are constants.
fn arguments(windows: &[Range<usize>], z: &[Coupled]) -> Vec<Coupled> {
    let mut marked = z.to_vec();
    for (block, window) in windows.iter().enumerate() {
        for i in window.clone() {
            marked[i] = Coupled::argument(z[i].value(), block, windows.len());
        }
    }
    marked
}

fn couplings(
    windows: &[Range<usize>],
    z: &[Coupled],
    formula: impl FnOnce(&[Coupled]) -> Coupled,
) -> Couplings {
    let marked = arguments(windows, z);
    Couplings::found(windows.len(), || {
        formula(&marked);
    })
}

/// A formula with the arguments of window `a` as outer variables and those of `b` as inner ones.
fn mixed(
    z: &mut [Mixed],
    a: &Range<usize>,
    b: &Range<usize>,
    formula: impl FnOnce(&[Mixed]) -> Mixed,
) -> Mixed {
    let seed = |z: &mut [Mixed], x: f64| {
        a.clone().enumerate().for_each(|(k, i)| z[i].gradient[k].value = x);
        b.clone().enumerate().for_each(|(k, j)| z[j].value.gradient[k] = x);
    };
    seed(z, 1.0);
    let jet = formula(z);
    seed(z, 0.0);
    jet
}

/// Hands every block of second derivatives that can be other than zero to `visit`, once for a pair of windows.
fn visit_couplings(
    windows: &[Range<usize>],
    traced: &[Coupled],
    tracer: impl FnOnce(&[Coupled]) -> Coupled,
    z: &mut [Mixed],
    formula: impl Fn(&[Mixed]) -> Mixed,
    mut visit: impl FnMut(&Range<usize>, &Range<usize>, &Mixed),
) {
    let couplings = couplings(windows, traced, tracer);
    for (a, b) in pairs(windows.len()).filter(|&(a, b)| couplings.has(a, b)) {
        let jet = mixed(z, &windows[a], &windows[b], &formula);
        visit(&windows[a], &windows[b], &jet);
    }
}

/// Adds `factor` times a block to an n × n matrix. Windows over velocities count from n.
fn add_general(matrix: &mut [f64], n: usize, a: &Range<usize>, b: &Range<usize>, factor: f64, jet: &Mixed) {
    for (k, i) in a.clone().enumerate() {
        for (m, j) in b.clone().enumerate() {
            matrix[(i % n) * n + j % n] += factor * jet.gradient[k].gradient[m];
        }
    }
}

/// The same, and the mirror image of a block that is not on the diagonal.
fn add_symmetric(matrix: &mut [f64], n: usize, a: &Range<usize>, b: &Range<usize>, factor: f64, jet: &Mixed) {
    add_general(matrix, n, a, b, factor, jet);
    if a != b {
        for (k, i) in a.clone().enumerate() {
            for (m, j) in b.clone().enumerate() {
                matrix[(j % n) * n + i % n] += factor * jet.gradient[k].gradient[m];
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
