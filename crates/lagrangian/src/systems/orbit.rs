//! One mass in a plane, in a field: Kepler's, nearly Kepler's, and Hénon's.

use super::parameter::{finite, positive};
use crate::coordinates::Phase;
use crate::error::LagrangianError;
use crate::system::Lagrangian;
use mechanics_core::scalar::Scalar;
use std::f64::consts::{PI, TAU};

/// A planet about a fixed sun.
///
/// ```text
///          . - ‾ ‾ ‾ - .
///        ´       a(1+e)  ` m
///       |   ☉──────────────●        q = (x, y), the sun at the origin
///        `               ´
///          ` - _ _ _ - ´
/// ```
///
/// T = ½ m (ẋ² + ẏ²), V = −k/r. Kept are the energy E = −k/(2a), the angular momentum ℓ = m (x ẏ − y ẋ), and the vector A of
/// Laplace, Runge and Lenz, which points to the perihelion and has the length m k e. Bound orbits are ellipses of period
/// 2π √(m a³/k); [`motion`](Self::motion) gives the exact state at any time.
///
/// # Reference
/// Landau, Lifshitz, Mechanics, § 15.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kepler {
    /// m \[kg\].
    pub mass: f64,
    /// k \[J m\]; G M m for a planet.
    pub strength: f64,
}

impl Kepler {
    /// From mass \[kg\] and strength of attraction \[J m\].
    ///
    /// # Errors
    /// [`LagrangianError::Parameter`] if one is not positive and finite.
    pub fn new(mass: f64, strength: f64) -> Result<Self, LagrangianError> {
        let name = "Kepler's problem";
        Ok(Self { mass: positive(name, "mass", mass)?, strength: positive(name, "strength", strength)? })
    }

    /// The state at the perihelion of an orbit of half axis `a` \[m\] and eccentricity `e` in [0, 1), on the positive x axis,
    /// counter-clockwise, at time 0.
    pub fn perihelion(&self, a: f64, e: f64) -> Phase<[f64; 2]> {
        let speed = (self.strength / (self.mass * a) * (1.0 + e) / (1.0 - e)).sqrt();
        Phase::new(0.0, [a * (1.0 - e), 0.0], [0.0, speed])
    }

    /// ℓ = m (x ẏ − y ẋ) \[J s\].
    pub fn angular_momentum(&self, q: &[f64; 2], v: &[f64; 2]) -> f64 {
        self.mass * (q[0] * v[1] - q[1] * v[0])
    }

    /// A = p × ℓ − m k r/|r| \[kg² m³/s²\].
    pub fn runge_lenz(&self, q: &[f64; 2], v: &[f64; 2]) -> [f64; 2] {
        let (l, r) = (self.angular_momentum(q, v), q[0].hypot(q[1]));
        let mk = self.mass * self.strength;
        [self.mass * v[1] * l - mk * q[0] / r, -self.mass * v[0] * l - mk * q[1] / r]
    }

    /// The half axis a \[m\] of a bound orbit, from 1/a = 2/r − m v²/k; negative for a hyperbola, infinite for a parabola.
    pub fn half_axis(&self, q: &[f64; 2], v: &[f64; 2]) -> f64 {
        let square = v[0] * v[0] + v[1] * v[1];
        1.0 / (2.0 / q[0].hypot(q[1]) - self.mass * square / self.strength)
    }

    /// The period 2π √(m a³/k) \[s\]; infinite for a parabola, NaN for a hyperbola.
    pub fn period(&self, q: &[f64; 2], v: &[f64; 2]) -> f64 {
        let a = self.half_axis(q, v);
        TAU * a * (self.mass * a / self.strength).sqrt()
    }

    /// The exact state a time `t` \[s\] after `q`, `v` on a bound orbit, by Kepler's equation: positions, then velocities.
    ///
    /// In the axes of the ellipse, P to the perihelion and Q a quarter turn ahead, with the half axes a and b,
    ///
    /// q = a (cos E − e) P + b sin E Q,  v = n (−a sin E P + b cos E Q)/(1 − e cos E),  n = √(k/(m a³)).
    ///
    /// The start gives P (from A), b (from ℓ² = m k b²/a, without cancellation near e = 1) and the eccentric anomaly E₀; the mean anomaly
    /// M = E₀ − e sin E₀ + n t gives E by [`eccentric_anomaly`].
    ///
    /// The error is about ε n t/(1 − e) relative: that of a phase whose frequency is rounded. NaN if the orbit is not bound,
    /// and if it is a straight line into the centre.
    pub fn motion(&self, q: &[f64; 2], v: &[f64; 2], t: f64) -> [[f64; 2]; 2] {
        let a = self.half_axis(q, v);
        let n = (self.strength / (self.mass * a)).sqrt() / a;
        let [ax, ay] = self.runge_lenz(q, v);
        let mk = self.mass * self.strength;
        let e = ax.hypot(ay) / mk;
        // Unit vectors to the perihelion and a quarter turn ahead; a circle has no perihelion, so its start serves.
        let towards = if e > f64::EPSILON { [ax / (mk * e), ay / (mk * e)] } else { q.map(|x| x / a) };
        let l = self.angular_momentum(q, v);
        let ahead = [-towards[1], towards[0]].map(|x| x * l.signum());
        // b/a.
        let minor = l.abs() / (mk * a).sqrt();
        let along = |w: &[f64; 2], d: &[f64; 2]| w[0] * d[0] + w[1] * d[1];
        let start = (along(q, &ahead) / (a * minor)).atan2(along(q, &towards) / a + e);
        let anomaly = eccentric_anomaly(start - e * start.sin() + (n * t).rem_euclid(TAU), e);
        let (sin, cos) = anomaly.sin_cos();
        let rate = n / (1.0 - e * cos);
        let place = |i: usize| a * ((cos - e) * towards[i] + minor * sin * ahead[i]);
        let speed = |i: usize| a * rate * (minor * cos * ahead[i] - sin * towards[i]);
        [[place(0), place(1)], [speed(0), speed(1)]]
    }
}

impl Lagrangian<2> for Kepler {
    #[inline]
    fn kinetic<S: Scalar>(&self, _: &[S; 2], v: &[S; 2], _: S) -> S {
        (v[0].square() + v[1].square()).scale(0.5 * self.mass)
    }

    #[inline]
    fn potential<S: Scalar>(&self, q: &[S; 2], _: S) -> S {
        (q[0].square() + q[1].square()).sqrt().recip().scale(-self.strength)
    }
}

/// The eccentric anomaly E \[rad\] that solves Kepler's equation E − e sin E = M, for `eccentricity` in [0, 1).
///
/// The mean anomaly M is first brought to [−π, π]; E is returned with the same number of turns taken off. By symmetry let M ≥ 0. There
/// f(E) = E − e sin E − M is convex, f″ = e sin E ≥ 0, and min(M + e, π) is not below the solution. From there Newton's
/// method comes down monotonically and cannot overshoot; it stops where rounding stops it.
///
/// # Reference
/// Danby 1988, Fundamentals of Celestial Mechanics, § 6.6.
pub fn eccentric_anomaly(mean_anomaly: f64, eccentricity: f64) -> f64 {
    let e = eccentricity;
    let reduced = (mean_anomaly + PI).rem_euclid(TAU) - PI;
    let m = reduced.abs();
    let above = m + e;
    // Not `min`, which would lose a NaN.
    let mut anomaly = if above > PI { PI } else { above };
    loop {
        let (sin, cos) = anomaly.sin_cos();
        let next = anomaly - (anomaly - e * sin - m) / (1.0 - e * cos);
        if next >= anomaly || next.is_nan() {
            return anomaly.copysign(reduced);
        }
        anomaly = next;
    }
}

/// Kepler's problem with an additional force that falls with the cube of the distance: the orbit is an ellipse that turns.
///
/// T = ½ m (ẋ² + ẏ²), V = −k/r − β/r². Energy and angular momentum ℓ are kept. In polar coordinates β changes only the centrifugal term
/// ℓ²/(2 m r²), so r(φ) = p/(1 + e cos γφ) with γ² = 1 − 2mβ/ℓ²: from perihelion to perihelion the angle is 2π/γ, exactly.
///
/// # Reference
/// Newton's theorem of revolving orbits; Landau, Lifshitz, Mechanics, § 15, problem 3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PerturbedKepler {
    /// m \[kg\].
    pub mass: f64,
    /// k \[J m\].
    pub strength: f64,
    /// β \[J m²\], of either sign.
    pub perturbation: f64,
}

impl PerturbedKepler {
    /// From mass \[kg\], strength of attraction \[J m\] and of the perturbation \[J m²\].
    ///
    /// # Errors
    /// [`LagrangianError::Parameter`] if mass or strength is not positive, or one is not finite.
    pub fn new(mass: f64, strength: f64, perturbation: f64) -> Result<Self, LagrangianError> {
        let name = "perturbed Kepler problem";
        Ok(Self {
            mass: positive(name, "mass", mass)?,
            strength: positive(name, "strength", strength)?,
            perturbation: finite(name, "perturbation", perturbation)?,
        })
    }

    /// ℓ = m (x ẏ − y ẋ) \[J s\].
    pub fn angular_momentum(&self, q: &[f64; 2], v: &[f64; 2]) -> f64 {
        self.mass * (q[0] * v[1] - q[1] * v[0])
    }

    /// The angle 2π/√(1 − 2mβ/ℓ²) \[rad\] from one perihelion to the next; NaN if the mass spirals into the centre.
    pub fn apsidal_angle(&self, q: &[f64; 2], v: &[f64; 2]) -> f64 {
        let l = self.angular_momentum(q, v);
        TAU / (1.0 - 2.0 * self.mass * self.perturbation / (l * l)).sqrt()
    }
}

impl Lagrangian<2> for PerturbedKepler {
    #[inline]
    fn kinetic<S: Scalar>(&self, _: &[S; 2], v: &[S; 2], _: S) -> S {
        (v[0].square() + v[1].square()).scale(0.5 * self.mass)
    }

    #[inline]
    fn potential<S: Scalar>(&self, q: &[S; 2], _: S) -> S {
        let square = q[0].square() + q[1].square();
        -square.sqrt().recip().scale(self.strength) - square.recip().scale(self.perturbation)
    }
}

/// A star in the plane of a galaxy, as Hénon and Heiles simplified it; dimensionless.
///
/// ```text
///            y = 1 ●            ● saddles of V, at V = 1/6
///                 ╱ ╲
///                ╱ · ╲          · minimum, V = 0
///               ●─────●
/// ```
///
/// T = ½ (ẋ² + ẏ²), V = ½ (x² + y²) + x² y − ⅓ y³, symmetric under turns by 120°. Only the energy is kept. Below E ≈ 1/12 almost every motion
/// is regular, near [`ESCAPE_ENERGY`](Self::ESCAPE_ENERGY) = 1/6 almost every one chaotic; above it the star may leave.
///
/// # Reference
/// Hénon, Heiles 1964, Astron. J. 69, 73.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HenonHeiles;

impl HenonHeiles {
    /// The energy of the three saddles, above which the star may leave.
    pub const ESCAPE_ENERGY: f64 = 1.0 / 6.0;
}

impl Lagrangian<2> for HenonHeiles {
    #[inline]
    fn kinetic<S: Scalar>(&self, _: &[S; 2], v: &[S; 2], _: S) -> S {
        (v[0].square() + v[1].square()).scale(0.5)
    }

    #[inline]
    fn potential<S: Scalar>(&self, q: &[S; 2], _: S) -> S {
        let [x, y] = *q;
        (x.square() + y.square()).scale(0.5) + y * (x.square() - y.square().scale(1.0 / 3.0))
    }
}
