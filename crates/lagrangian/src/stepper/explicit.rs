//! Explicit schemes, for comparison: one gradient a step, but the step is bounded by the fastest oscillation.
//!
//! With accelerations a(x, v) = −M⁻¹ ∇E and a lumped mass M,
//!
//! - symplectic Euler: vₙ₊₁ = vₙ + h a(xₙ, vₙ), xₙ₊₁ = xₙ + h vₙ₊₁; order one;
//! - central differences: v½ = vₙ + ½h a(xₙ), xₙ₊₁ = xₙ + h v½, vₙ₊₁ = v½ + ½h a(xₙ₊₁, v½); order two where forces do not depend on velocities.
//!
//! **Stability.** On an oscillator of frequency ω both are the recursion xₙ₊₁ − 2xₙ + xₙ₋₁ = −h²ω² xₙ, which is bounded for hω < 2 and grows
//! for hω > 2. For a body ω² is the largest eigenvalue of K q = ω² M q, K = ∂²E/∂x². It is enclosed:
//!
//! - from below by Rayleigh's quotient of a power iteration with M⁻¹K, which converges to it;
//! - from above by the row sums of M⁻¹K (Gershgorin): ω² ≤ maxᵢ Σⱼ ‖Kᵢⱼ‖∞ / mᵢ.
//!
//! A step of 2/ω with the upper bound is stable for certain, as long as the stiffness stays; with the lower one nearly so. Damping in
//! proportion to stiffness shortens it further, to h < 2(√(1 + ζ²) − ζ)/ω for damping ratio ζ (Belytschko, Liu, Moran 2000, section 6.2).
//!
//! # Reference
//! Hairer, Lubich, Wanner, *Geometric Numerical Integration*, 2006, section I.1; Belytschko, Liu, Moran, *Nonlinear Finite Elements for
//! Continua and Structures*, 2000, chapter 6.

use super::StepError;
use super::error::StateArray;
use crate::element::Mass;
use mechanics_core::objective::{DenseCholesky, IncrementalPotential, TimeStep};
use mechanics_core::point_map::PointMap;
use mechanics_core::potential::Potential;
use mechanics_core::projection::Projection;
use mechanics_core::sparse::{Assembly, BlockMatrix};
use mechanics_core::stage::{Coefficients, Moment, Scheme, Stage};
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;

/// An explicit scheme.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ExplicitScheme {
    /// Order one.
    #[default]
    SymplecticEuler,
    /// Order two, also known as velocity Verlet.
    CentralDifferences,
}

/// Moves a [`State`] through time without solving anything; bounded by [`largest_frequency`](Self::largest_frequency).
#[derive(Clone, Debug)]
pub struct ExplicitStepper {
    scheme: ExplicitScheme,
    mass: Mass,
    /// 1/m of each point [1/kg]; zero for points that stay.
    mobility: Vec<f64>,
    map: PointMap,
}

/// An enclosure of the largest frequency of small oscillations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrequencyBounds {
    /// √ of Rayleigh's quotient after power iteration [rad/s].
    pub lower: f64,
    /// √ of the largest row sum [rad/s].
    pub upper: f64,
    /// Power iterations made.
    pub iterations: u32,
}

impl FrequencyBounds {
    /// 2/ω with the lower bound \[s\]: what is stable up to the accuracy of the power iteration.
    pub fn stable_step(&self) -> f64 {
        2.0 / self.lower
    }

    /// 2/ω with the upper bound \[s\]: what is stable for certain while the stiffness stays.
    pub fn certain_step(&self) -> f64 {
        2.0 / self.upper
    }
}

const ACCELERATION: &str = "explicit acceleration";
const MAX_POWER_ITERATIONS: u32 = 2000;
/// Relative change of Rayleigh's quotient at which power iteration ends; its error is of the square of the vector's.
const POWER_TOLERANCE: f64 = 1e-9;

impl ExplicitStepper {
    /// A stepper for points with this mass; those that `map` fixes stay where it has them.
    ///
    /// # Errors
    /// [`StepError`] if points are coupled by the mass or by the map, if none moves, or names the point that moves but has no mass.
    ///
    /// # Panics
    /// If mass and map are not for the same number of points.
    pub fn new(scheme: ExplicitScheme, mass: Mass, map: PointMap) -> Result<Self, StepError> {
        assert_eq!(mass.points(), map.points(), "one mass per point of the map");
        if let Some(&pair) = mass.couplings().0.first() {
            return Err(StepError::ConsistentMass { pair });
        }
        if map.unknowns() == 0 {
            return Err(StepError::NothingToSolve { points: map.points() });
        }
        if !map.is_selection() {
            return Err(StepError::WeightedPoints);
        }
        let mut shown = vec![0_u32; map.unknowns()];
        for point in 0..map.points() {
            map.for_each_unknown(point, |unknown, _| shown[unknown as usize] += 1);
        }
        if shown.iter().any(|&points| points > 1) {
            return Err(StepError::WeightedPoints);
        }
        let mut mobility = vec![0.0; mass.points()];
        for (point, mobility) in mobility.iter_mut().enumerate() {
            let mass = mass.diagonal()[point];
            map.for_each_unknown(point, |_, _| *mobility = 1.0 / mass);
            if !mobility.is_finite() {
                return Err(StepError::NoMass { point, mass });
            }
        }
        Ok(Self { scheme, mass, mobility, map })
    }

    /// Moves `state` by `h` \[s\].
    ///
    /// # Errors
    /// [`StepError`] names the culprit, a force or position that is no longer finite among them; the state is then as it
    /// was.
    ///
    /// # Panics
    /// If the state is not for as many points as the mass.
    pub fn step(&self, state: &mut State, terms: &mut [&mut dyn Potential], h: f64) -> Result<(), StepError> {
        if !(h.is_finite() && h > 0.0) {
            return Err(StepError::StepSize { step: h });
        }
        let points = self.mobility.len();
        assert_eq!(state.position.len(), points, "one position per point");
        assert_eq!(state.velocity.len(), points, "one velocity per point");
        let mut next = state.clone();
        // What other schemes remember ends before this step, so it is of no use after it.
        next.clear_history();
        match self.scheme {
            ExplicitScheme::SymplecticEuler => {
                let acceleration = self.acceleration(&next, terms, h)?;
                kick(&mut next, &acceleration, h);
                self.drift(&mut next, h);
            }
            ExplicitScheme::CentralDifferences => {
                let known = state.history(ACCELERATION).map(<[Vec3]>::to_vec);
                let acceleration = match known {
                    Some(acceleration) => acceleration,
                    None => self.acceleration(&next, terms, h)?,
                };
                kick(&mut next, &acceleration, 0.5 * h);
                self.drift(&mut next, h);
                next.time += h;
                let acceleration = self.acceleration(&next, terms, h)?;
                next.time -= h;
                kick(&mut next, &acceleration, 0.5 * h);
                next.set_history(ACCELERATION, acceleration);
            }
        }
        let arrays = [(StateArray::Position, &next.position), (StateArray::Velocity, &next.velocity)];
        for (array, entries) in arrays {
            if let Some(point) = entries.iter().position(|v| !v.iter().all(|c| c.is_finite())) {
                return Err(StepError::NonFinite { array, point, value: entries[point].into() });
            }
        }
        next.time = state.time + h;
        next.step = state.step + 1;
        *state = next;
        Ok(())
    }

    /// −M⁻¹ ∇E at the positions and velocities of the state.
    fn acceleration(
        &self,
        state: &State,
        terms: &mut [&mut dyn Potential],
        h: f64,
    ) -> Result<Vec<Vec3>, StepError> {
        let (x, time) = (&state.position, state.time);
        let coefficients = Coefficients::backward_euler(h);
        let origin: Vec<Vec3> =
            x.iter().zip(&state.velocity).map(|(x, v)| x - v / coefficients.velocity).collect();
        let scheme = Scheme::new(coefficients, x, &origin);
        let mut forces = vec![Vec3::zeros(); x.len()];
        for term in terms.iter_mut() {
            for moment in [Moment::Step, Moment::Lag] {
                let stage = Stage { moment, x, time, step: h, scheme };
                let frozen = term.freeze(&stage);
                frozen.map(drop).map_err(|source| StepError::Term { time, source })?;
            }
            term.add_gradient(x, &mut forces);
        }
        forces.iter_mut().for_each(|force| *force = -*force);
        if let Some(point) = forces.iter().position(|f| !f.iter().all(|c| c.is_finite())) {
            let culprit = terms.iter().find_map(|term| term.diagnose(x)).map(Box::new);
            return Err(StepError::Force { point, force: forces[point].into(), time, culprit });
        }
        forces.iter_mut().zip(&self.mobility).for_each(|(force, mobility)| *force *= *mobility);
        Ok(forces)
    }

    /// x ← x + h v; fixed points go where the map has them.
    fn drift(&self, state: &mut State, h: f64) {
        for (point, (x, v)) in state.position.iter_mut().zip(&mut state.velocity).enumerate() {
            if self.mobility[point] == 0.0 {
                let target = self.map.offset(point);
                *v = (target - *x) / h;
                *x = target;
            } else {
                *x += *v * h;
            }
        }
    }

    /// The largest frequency of small oscillations of the terms about the positions `x` \[m\].
    ///
    /// # Errors
    /// [`StepError`] if a term does not admit the positions.
    ///
    /// # Panics
    /// If there is not one position per point.
    pub fn largest_frequency(
        &self,
        x: &[Vec3],
        terms: &mut [&mut dyn Potential],
    ) -> Result<FrequencyBounds, StepError> {
        assert_eq!(x.len(), self.mobility.len(), "one position per point");
        let mut q = vec![0.0; 3 * self.map.unknowns()];
        self.map.unknowns_into(x, &mut q)?;
        let (mut assembly, mut unused) = (Assembly::new(&self.map), DenseCholesky::new());
        let time_step = TimeStep { time: 0.0, step: 0.0, scheme: Scheme::statics(x) };
        let mut objective =
            IncrementalPotential::new(terms, &self.map, time_step, &mut assembly, &mut unused)
                .with_projection(Projection::None);
        let frozen = objective.freeze_at(Moment::Step, &q);
        frozen.map(drop).map_err(|source| StepError::Term { time: 0.0, source })?;
        let stiffness = objective.hessian(&q);
        let mut masses = vec![0.0; self.map.unknowns()];
        for (point, mass) in self.mass.diagonal().iter().enumerate() {
            self.map.for_each_unknown(point, |unknown, _| masses[unknown as usize] += mass);
        }
        let (lower, iterations) = power_iteration(stiffness, &masses);
        Ok(FrequencyBounds {
            lower: lower.sqrt(),
            upper: largest_row_sum(stiffness, &masses).sqrt(),
            iterations,
        })
    }
}

fn kick(state: &mut State, acceleration: &[Vec3], h: f64) {
    state.velocity.iter_mut().zip(acceleration).for_each(|(v, a)| *v += a * h);
}

/// The largest |Rayleigh quotient| of K q = λ M q found by iterating q ← M⁻¹K q, and the number of iterations.
fn power_iteration(stiffness: &BlockMatrix, masses: &[f64]) -> (f64, u32) {
    // A start with a part in every mode, and the same every time: the fractional parts of multiples of the golden ratio.
    let number = |k: usize| (k as f64 * 0.618_033_988_749_894_9).fract() - 0.5;
    let mut q: Vec<Vec3> = (0..masses.len()).map(|i| Vec3::from_fn(|k, _| number(3 * i + k + 1))).collect();
    let mut product = q.clone();
    let mut quotient = 0.0_f64;
    for iteration in 1..=MAX_POWER_ITERATIONS {
        stiffness.multiply_into(&q, &mut product);
        let energy: f64 = q.iter().zip(&product).map(|(q, p)| q.dot(p)).sum();
        let norm: f64 = q.iter().zip(masses).map(|(q, m)| m * q.norm_squared()).sum();
        let last = std::mem::replace(&mut quotient, (energy / norm).abs());
        if quotient.is_nan() || quotient <= 0.0 || (quotient - last).abs() <= POWER_TOLERANCE * quotient {
            return (quotient, iteration);
        }
        // Divided by the quotient, so that numbers keep their size.
        for ((q, p), m) in q.iter_mut().zip(&product).zip(masses) {
            *q = p / (m * quotient);
        }
    }
    (quotient, MAX_POWER_ITERATIONS)
}

/// maxᵢ Σⱼ |(M⁻¹K)ᵢⱼ| over scalar rows.
fn largest_row_sum(stiffness: &BlockMatrix, masses: &[f64]) -> f64 {
    let mut sums = vec![Vec3::zeros(); masses.len()];
    let pattern = stiffness.pattern();
    for column in 0..pattern.columns() {
        for slot in pattern.column(column) {
            let (row, block) = (pattern.rows()[slot] as usize, stiffness.blocks()[slot].abs());
            sums[row] += block.column_sum();
            if row != column {
                sums[column] += block.transpose().column_sum();
            }
        }
    }
    sums.iter().zip(masses).map(|(sum, m)| sum.max() / m).fold(0.0, f64::max)
}
