//! The systems under test.

use lagrangian::constraint::{Constraints, Holonomic, SlicedHolonomic};
use lagrangian::{Lagrangian, SlicedLagrangian};
use mechanics_core::scalar::Scalar;

pub(crate) const G: f64 = 9.81;

/// One kilogram in the plane, y upwards.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Particle;

impl Lagrangian<2> for Particle {
    fn kinetic<S: Scalar>(&self, _: &[S; 2], v: &[S; 2], _: S) -> S {
        (v[0].square() + v[1].square()).scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 2], _: S) -> S {
        q[1].scale(G)
    }
}

/// The same, with linear damping of `damping` [kg/s].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Damped {
    pub(crate) damping: f64,
}

impl Lagrangian<2> for Damped {
    fn kinetic<S: Scalar>(&self, q: &[S; 2], v: &[S; 2], t: S) -> S {
        Particle.kinetic(q, v, t)
    }
    fn potential<S: Scalar>(&self, q: &[S; 2], t: S) -> S {
        Particle.potential(q, t)
    }
    fn rayleigh<S: Scalar>(&self, _: &[S; 2], v: &[S; 2], _: S) -> S {
        (v[0].square() + v[1].square()).scale(0.5 * self.damping)
    }
}

/// (x² + y² − l²)/2.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rod(pub(crate) f64);

impl Holonomic<2, 1> for Rod {
    fn constraint<S: Scalar>(&self, q: &[S; 2], _: S) -> [S; 1] {
        [(q[0].square() + q[1].square()).offset(-self.0 * self.0).scale(0.5)]
    }
}

/// y − x²/2.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Parabola;

impl Holonomic<2, 1> for Parabola {
    fn constraint<S: Scalar>(&self, q: &[S; 2], _: S) -> [S; 1] {
        [q[1] - q[0].square().scale(0.5)]
    }
}

/// A particle in polar coordinates (r, θ), θ from the downward vertical: masses depend on coordinates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Polar;

impl Lagrangian<2> for Polar {
    fn kinetic<S: Scalar>(&self, q: &[S; 2], v: &[S; 2], _: S) -> S {
        (v[0].square() + (q[0] * v[1]).square()).scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 2], _: S) -> S {
        -(q[0] * q[1].cos()).scale(G)
    }
}

/// The parabola y = x²/2 in polar coordinates about (0, 1), from which it is 1 m away or more: y = 1 − r cos θ.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PolarParabola;

impl Holonomic<2, 1> for PolarParabola {
    fn constraint<S: Scalar>(&self, q: &[S; 2], _: S) -> [S; 1] {
        [(q[0] * q[1].sin()).square().scale(-0.5) - (q[0] * q[1].cos()).offset(-1.0)]
    }
}

/// Where the fixture's bead starts, (1.5, 1.125).
pub(crate) fn polar_start() -> [f64; 2] {
    [(1.5f64 * 1.5 + 0.125 * 0.125).sqrt(), 1.5f64.atan2(-0.125)]
}

/// Point masses in the plane, one after the other as (x, y).
#[derive(Clone, Copy, Debug)]
pub(crate) struct TwoMasses(pub(crate) [f64; 2]);

impl Lagrangian<4> for TwoMasses {
    fn kinetic<S: Scalar>(&self, _: &[S; 4], v: &[S; 4], _: S) -> S {
        let square = |i: usize| v[2 * i].square() + v[2 * i + 1].square();
        square(0).scale(0.5 * self.0[0]) + square(1).scale(0.5 * self.0[1])
    }
    fn potential<S: Scalar>(&self, q: &[S; 4], _: S) -> S {
        q[1].scale(G * self.0[0]) + q[3].scale(G * self.0[1])
    }
}

/// Two rods from the origin on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TwoRods(pub(crate) [f64; 2]);

impl Holonomic<4, 2> for TwoRods {
    fn constraint<S: Scalar>(&self, q: &[S; 4], _: S) -> [S; 2] {
        let rod = |x: S, y: S, l: f64| (x.square() + y.square()).offset(-l * l).scale(0.5);
        [rod(q[0], q[1], self.0[0]), rod(q[2] - q[0], q[3] - q[1], self.0[1])]
    }
}

/// (θ₁, θ₂) from the downward vertical to the four Cartesian coordinates.
pub(crate) fn joints(theta: [f64; 2], l: [f64; 2]) -> [f64; 4] {
    let (x, y) = (l[0] * theta[0].sin(), -l[0] * theta[0].cos());
    [x, y, x + l[1] * theta[1].sin(), y - l[1] * theta[1].cos()]
}

/// Velocities of [`joints`].
pub(crate) fn joint_velocities(theta: [f64; 2], rate: [f64; 2], l: [f64; 2]) -> [f64; 4] {
    let (x, y) = (l[0] * theta[0].cos() * rate[0], l[0] * theta[0].sin() * rate[0]);
    [x, y, x + l[1] * theta[1].cos() * rate[1], y + l[1] * theta[1].sin() * rate[1]]
}

/// Equal masses in the plane, as many as wanted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Masses {
    pub(crate) number: usize,
    pub(crate) mass: f64,
}

impl SlicedLagrangian for Masses {
    fn dimension(&self) -> usize {
        2 * self.number
    }
    fn kinetic<S: Scalar>(&self, _: &[S], v: &[S], _: S) -> S {
        v.iter().fold(S::constant(0.0), |sum, v| sum + v.square()).scale(0.5 * self.mass)
    }
    fn potential<S: Scalar>(&self, q: &[S], _: S) -> S {
        q.iter().skip(1).step_by(2).fold(S::constant(0.0), |sum, y| sum + *y).scale(self.mass * G)
    }
}

/// Rods of equal length that hang the masses one from the other, the first from the origin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rods {
    pub(crate) number: usize,
    pub(crate) length: f64,
}

impl SlicedHolonomic for Rods {
    fn dimension(&self) -> usize {
        2 * self.number
    }
    fn count(&self) -> usize {
        self.number
    }
    fn constraint_into<S: Scalar>(&self, q: &[S], _: S, phi: &mut [S]) {
        let zero = S::constant(0.0);
        for (k, phi) in phi.iter_mut().enumerate() {
            let (x0, y0) = if k == 0 { (zero, zero) } else { (q[2 * k - 2], q[2 * k - 1]) };
            let square = (q[2 * k] - x0).square() + (q[2 * k + 1] - y0).square();
            *phi = square.offset(-self.length * self.length).scale(0.5);
        }
    }
}

/// A rod of 1 m whose pivot moves sideways: x_p = `amplitude` sin(`frequency` t).
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShakenRod {
    pub(crate) amplitude: f64,
    pub(crate) frequency: f64,
}

impl Holonomic<2, 1> for ShakenRod {
    fn constraint<S: Scalar>(&self, q: &[S; 2], t: S) -> [S; 1] {
        let pivot = t.scale(self.frequency).sin().scale(self.amplitude);
        [((q[0] - pivot).square() + q[1].square()).offset(-1.0).scale(0.5)]
    }
}

/// A single rod as a set of constraints.
pub(crate) fn rod() -> Constraints<Rod, 2, 1> {
    Constraints::new(Rod(1.0))
}
