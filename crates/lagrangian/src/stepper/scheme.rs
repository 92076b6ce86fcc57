//! The implicit schemes: what is minimised over, and how the end of the step follows from the minimum.

use mechanics_core::stage::{Coefficients, Scheme};
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;

/// An implicit time scheme.
///
/// Each minimises ½ c ‖y − x̃‖²_M + E(y) over positions y and reads the velocity there as a(y − x̂); see
/// [`Coefficients`] for c, a, x̃ and x̂ of the first three.
///
/// | scheme | order | on an oscillator ω, with z = ωh | remark |
/// |---|---|---|---|
/// | backward Euler | 1 | amplitude 1/√(1 + z²) a step | dissipates strongly, never oscillates |
/// | BDF2 | 2 | 1 − z⁴/4 + … | dissipates what is fast, keeps what is slow |
/// | average acceleration | 2 | 1 exactly | keeps the energy of linear systems; may ring |
/// | implicit midpoint | 2 | 1 exactly | symplectic; momenta and angular momenta to the tolerance |
///
/// The orders are those of the undamped motion and of constant damping. Damping by [`crate::element::StiffnessDamping`] or
/// [`crate::element::Dashpots`] takes its matrix from the start of the step: where that turns with the motion, the damping force is of
/// first order, whatever the scheme.
///
/// **Implicit midpoint** solves xₙ₊₁ = xₙ + h v̄, M(vₙ₊₁ − vₙ) = h f(y) with v̄ = ½(vₙ + vₙ₊₁) and y = ½(xₙ + xₙ₊₁). Since
/// v̄ = (2/h)(y − xₙ), the second equation is M(4/h²)(y − xₙ − ½h vₙ) = f(y): c = 4/h², a = 2/h, x̃ = xₙ + ½h vₙ, x̂ = xₙ. The end is
/// xₙ₊₁ = 2y − xₙ, vₙ₊₁ = 2v̄ − vₙ. Terms see the time tₙ + ½h.
///
/// **BDF2** with a step h after one of h/ω: the quadratic through the last two values and the new one gives
/// yₙ₊₁ = ŷ + ẏₙ₊₁/a with ŷ = ((1 + ω)² yₙ − ω² yₙ₋₁)/(1 + 2ω) and a = (1 + 2ω)/(h(1 + ω)); hence c = a², x̂ and x̃ = x̂ + v̂/a. Equal
/// steps give the constants of [`Coefficients::bdf2`]. Zero-stable for ω < 1 + √2: a step that grows faster starts anew. Without history
/// a step of backward Euler is made, which costs no order.
///
/// # Reference
/// Hairer, Wanner, *Solving Ordinary Differential Equations II*, 1996, chapters IV and V; for variable steps Hairer, Nørsett,
/// Wanner, *Solving Ordinary Differential Equations I*, 1993, section III.5 (equation 5.14).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum TimeScheme {
    /// First order, strongly dissipative.
    #[default]
    BackwardEuler,
    /// Second-order backward differentiation.
    Bdf2,
    /// Newmark's average acceleration, β = ¼ and γ = ½.
    Newmark,
    /// The midpoint rule. Refused if a term demands end positions, as contact does; a step whose end some term does not
    /// admit (a neo-Hookean element inside out) is an error.
    ImplicitMidpoint,
}

const EARLIER_POSITION: &str = "bdf2 earlier position";
const EARLIER_VELOCITY: &str = "bdf2 earlier velocity";
const EARLIER_STEP: &str = "bdf2 earlier step";
const ACCELERATION: &str = "newmark acceleration";

/// BDF2 starts anew when a step is longer than this many times the one before; 1 + √2 is the limit of zero-stability.
const LARGEST_GROWTH: f64 = 2.4;

/// What a step minimises over.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    pub(super) coefficients: Coefficients,
    /// x̃ \[m\].
    pub(super) inertial_target: Vec<Vec3>,
    /// x̂ \[m\].
    pub(super) velocity_origin: Vec<Vec3>,
    /// The time that terms see \[s\].
    pub(super) time: f64,
}

impl Plan {
    pub(super) fn scheme(&self) -> Scheme<'_> {
        Scheme::new(self.coefficients, &self.inertial_target, &self.velocity_origin)
    }
}

impl TimeScheme {
    /// Whether the step needs the accelerations at its start, which the state does not have.
    pub(super) fn needs_acceleration(self, state: &State) -> bool {
        self == Self::Newmark && state.history(ACCELERATION).is_none()
    }

    /// The plan of a step `h` from `state`; `acceleration` is read where [`needs_acceleration`](Self::needs_acceleration).
    pub(super) fn plan(self, state: &State, h: f64, acceleration: &[Vec3]) -> Plan {
        let (x, v) = (&state.position, &state.velocity);
        let end = state.time + h;
        match self {
            Self::BackwardEuler => backward_euler(state, h),
            Self::Bdf2 => bdf2(state, h).unwrap_or_else(|| backward_euler(state, h)),
            Self::Newmark => {
                let a = state.history(ACCELERATION).unwrap_or(acceleration);
                Plan {
                    coefficients: Coefficients::average_acceleration(h),
                    inertial_target: map(x.len(), |i| x[i] + v[i] * h + a[i] * (0.25 * h * h)),
                    velocity_origin: map(x.len(), |i| x[i] + v[i] * (0.5 * h)),
                    time: end,
                }
            }
            Self::ImplicitMidpoint => Plan {
                coefficients: Coefficients { inertia: 4.0 / (h * h), velocity: 2.0 / h },
                inertial_target: map(x.len(), |i| x[i] + v[i] * (0.5 * h)),
                velocity_origin: x.clone(),
                time: state.time + 0.5 * h,
            },
        }
    }

    /// Where a point that ends the step at `end` is when the minimum is taken.
    pub(super) fn evaluated(self, start: &Vec3, end: &Vec3) -> Vec3 {
        if self == Self::ImplicitMidpoint { (start + end) * 0.5 } else { *end }
    }

    /// Replaces the state by that at the end of the step, whose minimum is `y`.
    pub(super) fn finish(self, plan: &Plan, y: Vec<Vec3>, h: f64, state: &mut State) {
        let Coefficients { inertia: c, velocity: a } = plan.coefficients;
        let velocity = map(y.len(), |i| (y[i] - plan.velocity_origin[i]) * a);
        // What other schemes remember ends before this step, so it is of no use after it.
        state.clear_history();
        match self {
            Self::BackwardEuler => (state.position, state.velocity) = (y, velocity),
            Self::Bdf2 => {
                state.set_history(EARLIER_STEP, vec![Vec3::repeat(h); y.len()]);
                let earlier = std::mem::replace(&mut state.position, y);
                state.set_history(EARLIER_POSITION, earlier);
                let earlier = std::mem::replace(&mut state.velocity, velocity);
                state.set_history(EARLIER_VELOCITY, earlier);
            }
            Self::Newmark => {
                let acceleration = map(y.len(), |i| (y[i] - plan.inertial_target[i]) * c);
                (state.position, state.velocity) = (y, velocity);
                state.set_history(ACCELERATION, acceleration);
            }
            Self::ImplicitMidpoint => {
                let (x, v) = (&state.position, &state.velocity);
                let end = map(y.len(), |i| y[i] * 2.0 - x[i]);
                let end_velocity = map(y.len(), |i| velocity[i] * 2.0 - v[i]);
                (state.position, state.velocity) = (end, end_velocity);
            }
        }
        state.time += h;
        state.step += 1;
    }
}

fn map(count: usize, entry: impl Fn(usize) -> Vec3) -> Vec<Vec3> {
    (0..count).map(entry).collect()
}

fn backward_euler(state: &State, h: f64) -> Plan {
    let (x, v) = (&state.position, &state.velocity);
    Plan {
        coefficients: Coefficients::backward_euler(h),
        inertial_target: map(x.len(), |i| x[i] + v[i] * h),
        velocity_origin: x.clone(),
        time: state.time + h,
    }
}

fn bdf2(state: &State, h: f64) -> Option<Plan> {
    let (x, v) = (&state.position, &state.velocity);
    let (x0, v0) = (state.history(EARLIER_POSITION)?, state.history(EARLIER_VELOCITY)?);
    let omega = h / state.history(EARLIER_STEP)?.first()?.x;
    if omega.is_nan() || omega > LARGEST_GROWTH {
        return None;
    }
    let a = (1.0 + 2.0 * omega) / (h * (1.0 + omega));
    let (now, before) = ((1.0 + omega).powi(2) / (1.0 + 2.0 * omega), omega * omega / (1.0 + 2.0 * omega));
    let extrapolated = |y: &Vec3, y0: &Vec3| y * now - y0 * before;
    let origin = map(x.len(), |i| extrapolated(&x[i], &x0[i]));
    Some(Plan {
        coefficients: Coefficients { inertia: a * a, velocity: a },
        inertial_target: map(x.len(), |i| origin[i] + extrapolated(&v[i], &v0[i]) / a),
        velocity_origin: origin,
        time: state.time + h,
    })
}
