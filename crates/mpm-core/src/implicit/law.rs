//! The energy of one particle's step, and its derivatives, for any law: compiled once a law, in double precision.

use mechanics_core::projection::Projection;
use mechanics_core::tensor::Mat3;
use mpm_constitutive::{Motion, Numbers, PointLaw, Strain, Viscosity};

/// Strain and history of a particle at the begin of a step.
pub(crate) struct Point<'a> {
    pub(crate) strain: &'a [f64],
    pub(crate) history: &'a [f64],
}

/// A law as an implicit step sees it: W(G), the energy per rest volume of a particle whose displacement gradient during the step is G = h∇v;
/// a dissipated part is counted as if it were stored, so that its derivative is the stress.
pub(crate) trait StepLaw: Send + Sync {
    /// W \[J/m³\]; not finite where the law is not defined.
    fn energy(&self, point: &Point<'_>, motion: &Motion<f64>) -> f64;

    /// ∂W/∂G \[Pa\].
    fn stress(&self, point: &Point<'_>, motion: &Motion<f64>) -> Mat3;

    /// ∂²W/∂G² \[Pa\] over G's first `axes` rows and columns, by column: entry (k, l) of a symmetric matrix with k = column · axes + row.
    fn curvature_into(
        &self,
        point: &Point<'_>,
        motion: &Motion<f64>,
        axes: usize,
        curvature: &mut [[f64; 9]; 9],
    );
}

struct State<L: PointLaw> {
    begin: L::Strain<f64>,
    trial: L::Strain<f64>,
    history: L::History<f64>,
}

impl<L: PointLaw> State<L> {
    fn new(point: &Point<'_>, motion: &Motion<f64>) -> Self {
        let begin = L::Strain::<f64>::from_numbers(|k| point.strain[k]);
        let trial = begin.advanced(&(motion.velocity_gradient * motion.step));
        Self { begin, trial, history: L::History::from_numbers(|k| point.history[k]) }
    }

    /// The change of the strain's numbers, which are affine in G, with entry (a, b) of G.
    fn change(&self, a: usize, b: usize) -> L::Strain<f64> {
        let mut unit = Mat3::zeros();
        unit[(a, b)] = 1.0;
        let moved = self.begin.advanced(&unit);
        L::Strain::from_numbers(|k| moved.number(k) - self.begin.number(k))
    }
}

fn contraction<T: Numbers<f64>>(a: &T, b: &T) -> f64 {
    (0..T::COUNT).map(|k| a.number(k) * b.number(k)).sum()
}

impl<L: PointLaw> StepLaw for L {
    fn energy(&self, point: &Point<'_>, motion: &Motion<f64>) -> f64 {
        let state = State::<L>::new(point, motion);
        let energy = self.energy_density(&state.trial, &state.history);
        let viscosity = self.viscosity();
        if viscosity == Viscosity::NONE {
            return energy;
        }
        // The rate potential ½ τ:∇v at the volume of the begin, times h.
        let viscous = viscosity.kirchhoff(state.begin.volume_ratio(), &motion.velocity_gradient);
        energy + 0.5 * motion.step * viscous.dot(&motion.velocity_gradient)
    }

    fn stress(&self, point: &Point<'_>, motion: &Motion<f64>) -> Mat3 {
        let state = State::<L>::new(point, motion);
        let gradient = self.energy_gradient(&state.trial, &state.history);
        let mut stress = Mat3::from_fn(|a, b| contraction(&gradient, &state.change(a, b)));
        let viscosity = self.viscosity();
        if viscosity != Viscosity::NONE {
            stress += viscosity.kirchhoff(state.begin.volume_ratio(), &motion.velocity_gradient);
        }
        stress
    }

    fn curvature_into(
        &self,
        point: &Point<'_>,
        motion: &Motion<f64>,
        axes: usize,
        curvature: &mut [[f64; 9]; 9],
    ) {
        let state = State::<L>::new(point, motion);
        let law = self.energy_curvature(&state.trial, &state.history, Projection::Clamp);
        let count = axes * axes;
        let mut changes = [state.begin; 9];
        for k in 0..count {
            changes[k] = state.change(k % axes, k / axes);
        }
        for k in 0..count {
            let stress = law.apply(&changes[k]);
            for l in 0..=k {
                curvature[k][l] = contraction(&stress, &changes[l]);
                curvature[l][k] = curvature[k][l];
            }
        }
        let viscosity = self.viscosity();
        if viscosity == Viscosity::NONE {
            return;
        }
        for k in 0..count {
            let mut rate = Mat3::zeros();
            rate[(k % axes, k / axes)] = 1.0 / motion.step;
            let viscous = viscosity.kirchhoff(state.begin.volume_ratio(), &rate);
            for l in 0..count {
                curvature[k][l] += viscous[(l % axes, l / axes)];
            }
        }
    }
}
