//! A pendulum in one angle whose body gives way a little.
//!
//! Points of a body with rest places X (from the axis, along y) are at x = R(θ)(X + u). The angle θ is that of the mean axes: with the displacements r = ∂(R X)/∂θ of a small turn
//! at rest, u has no part in a turn, rᵀM u = 0. To first order in u
//!
//! ```text
//! L = ½ I θ̇² + m g d cos θ + fᵀu − ½ uᵀK u,    f = cos θ f₁ + sin θ f₂ + θ̇² f₃
//! ```
//!
//! with weight along the body f₁, across it f₂ (less what turns it), and the centrifugal force f₃ = M P X, P X being the part of X across the axis. A stiff body follows its forces,
//! u = K⁻¹ f, so that L = ½ I θ̇² + m g d cos θ + ½ cᵀC c with Cᵢⱼ = fᵢᵀK⁻¹fⱼ and c = (cos θ, sin θ, θ̇²): what is left out is of second order in 1/E.
//!
//! # Reference
//! L. D. Landau, E. M. Lifshitz, *Mechanics*, § 30 (what is fast follows what is slow); O. P. Agrawal, A. A. Shabana, *Dynamic analysis of multibody systems using component modes*, Computers & Structures
//! 21, 1985 (mean axes).

use crate::experiment::{ExperimentError, Outcome};
use lagrangian::integrator::{DiscreteEulerLagrange, GaussLegendre, Integrator, RungeKutta4, drive};
use lagrangian::{EulerLagrange, Lagrangian, LagrangianError, Phase};
use mechanics_core::scalar::Scalar;

/// L of the body, by numbers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Swing {
    /// I about the axis \[kg m²\].
    pub(super) inertia: f64,
    /// m g d \[J\].
    pub(super) moment: f64,
    /// C \[J\], \[J s²\], \[J s⁴\]; zero of a rigid body.
    pub(super) compliance: [[f64; 3]; 3],
}

impl Swing {
    /// The same body, rigid.
    pub(super) fn rigid(self) -> Self {
        Self { compliance: [[0.0; 3]; 3], ..self }
    }
}

impl Lagrangian<1> for Swing {
    fn kinetic<S: Scalar>(&self, q: &[S; 1], v: &[S; 1], _: S) -> S {
        let rate = v[0].square();
        let c = [q[0].cos(), q[0].sin(), rate];
        let mut sum = rate.scale(self.inertia);
        for (row, a) in self.compliance.iter().zip(c) {
            for (entry, b) in row.iter().zip(c) {
                sum += (a * b).scale(*entry);
            }
        }
        sum.scale(0.5)
    }

    fn potential<S: Scalar>(&self, q: &[S; 1], _: S) -> S {
        q[0].cos().scale(-self.moment)
    }
}

/// Methods with a fixed step.
pub(super) const METHODS: [&str; 3] =
    ["one angle, midpoint", "one angle, rk4", "one angle, gauss-legendre-4"];

/// Angles after 0, 1, … `steps` steps of `h` \[s\] from rest at `start` \[rad\], by one of [`METHODS`].
pub(super) fn angles(
    swing: Swing,
    method: &str,
    (start, h, steps): (f64, f64, u64),
    outcome: &mut Outcome,
) -> Result<Vec<f64>, ExperimentError> {
    let system = EulerLagrange::new(swing);
    let mut integrator: Box<dyn Integrator<_>> = match method {
        "one angle, midpoint" => Box::new(DiscreteEulerLagrange::midpoint()),
        "one angle, rk4" => Box::new(RungeKutta4::new(&system)),
        _ => Box::new(GaussLegendre::<2, _>::new()),
    };
    let mut phase = Phase::new(0.0, [start], [0.0]);
    let mut found = vec![start];
    let report = drive::advance(&system, integrator.as_mut(), &mut phase, h, steps, |phase, _| {
        found.push(phase.q[0]);
        std::ops::ControlFlow::Continue(())
    })
    .map_err(ExperimentError::stopped)?;
    *outcome = std::mem::take(outcome)
        .count("steps", report.steps)
        .count("evaluations", report.work.evaluations)
        .count("iterations", report.work.iterations);
    Ok(found)
}

/// The same to twelve digits: by a method of order 12, with steps of a two-hundredth of the time of small swings at most.
///
/// # Errors
/// Of the integrator.
pub(super) fn exact_angles(
    swing: Swing,
    start: f64,
    h: f64,
    steps: u64,
) -> Result<Vec<f64>, LagrangianError> {
    let system = EulerLagrange::new(swing);
    let mut integrator = GaussLegendre::<6, _>::new();
    let mut phase = Phase::new(0.0, [start], [0.0]);
    let times: Vec<f64> = (0..=steps).map(|n| n as f64 * h).collect();
    let finest = std::f64::consts::TAU * (swing.inertia / swing.moment).sqrt() / 200.0;
    let (found, _) = drive::sample(&system, &mut integrator, &mut phase, &times, finest)?;
    Ok(found.phases().map(|phase| phase.q[0]).collect())
}
