//! A rigid body that nothing turns.

use super::elliptic::arithmetic_geometric_mean;
use super::parameter::positive;
use crate::error::LagrangianError;
use crate::system::Lagrangian;
use mechanics_core::scalar::Scalar;
use std::f64::consts::TAU;

/// A free rigid body about its centre of mass, in a quaternion: no angle at which the coordinates fail.
///
/// ```text
///            ω₂ (middle axis: unstable)
///             ▲    ┌─────────┐
///             │   ╱         ╱│
///             └──┌─────────┐ ╱ ──▶ ω₁
///               │         │╱
///               └─────────┘
/// ```
///
/// q = (w, x, y, z) turns body vectors into space: r ↦ q r q̄/|q|². Its length means nothing, so the angular velocity in the body's
/// principal axes is written so that it does not depend on it, and the length gets an inertia of its own:
///
/// ω = 2 Im(q̄ q̇)/|q|², T = ½ (I₁ω₁² + I₂ω₂² + I₃ω₃²) + ½ m (d|q|/dt)², V = 0.
///
/// With r = |q| and the orientation as coordinates T is a sum of a function of the orientation and ½ m ṙ²: the two do not
/// know each other. The mass matrix is regular, and a start with |q| = 1 and q·q̇ = 0 keeps |q| = 1, for any m > 0. T is invariant under
/// q ↦ c q with any fixed quaternion c: its Noether charge is the angular momentum in space, L = R I ω
/// ([`angular_momentum`](Self::angular_momentum)). Energy and |L| are kept, too.
///
/// Rotation about the axes of the least and the greatest moment is stable. About the middle one it is not: the body flips, again
/// and again, with the period that [`spin_period`](Self::spin_period) gives.
///
/// # Reference
/// Landau, Lifshitz, Mechanics, § 37 (asymmetric top); quaternions: Betsch, Siebert 2009, Int. J. Numer. Meth. Eng. 79, 444.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreeBody {
    /// I₁, I₂, I₃ \[kg m²\], about the principal axes.
    pub inertia: [f64; 3],
    /// m \[kg m²\], the inertia of the quaternion's length. Any positive value gives the same rotation.
    pub radial_inertia: f64,
}

impl FreeBody {
    /// From the principal moments of inertia \[kg m²\]. The radial inertia becomes four times their mean.
    ///
    /// # Errors
    /// [`LagrangianError::Parameter`] if one is not positive and finite. (That none exceeds the sum of the others, as it is for every body
    /// of positive density, is not demanded.)
    pub fn new(inertia: [f64; 3]) -> Result<Self, LagrangianError> {
        let name = "free body";
        inertia.iter().try_for_each(|&moment| positive(name, "inertia", moment).map(drop))?;
        // 4 I is what the other directions of the quaternion weigh: the same scale keeps M well conditioned.
        let radial_inertia = 4.0 / 3.0 * inertia.iter().sum::<f64>();
        Ok(Self { inertia, radial_inertia })
    }

    /// The rate q̇ = ½ q ω of the quaternion `q` for the angular velocity `omega` \[rad/s\] in the body's axes.
    pub fn rate(q: &[f64; 4], omega: &[f64; 3]) -> [f64; 4] {
        let ([w, x, y, z], [a, b, c]) = (*q, *omega);
        [
            -0.5 * (x * a + y * b + z * c),
            0.5 * (w * a + y * c - z * b),
            0.5 * (w * b + z * a - x * c),
            0.5 * (w * c + x * b - y * a),
        ]
    }

    /// The angular velocity ω = 2 Im(q̄ q̇)/|q|² \[rad/s\] in the body's axes.
    pub fn angular_velocity<S: Scalar>(q: &[S; 4], v: &[S; 4]) -> [S; 3] {
        let ([w, x, y, z], [a, b, c, d]) = (*q, *v);
        let factor = S::constant(2.0) / (w.square() + x.square() + y.square() + z.square());
        [
            (w * b - x * a - y * d + z * c) * factor,
            (w * c - y * a - z * b + x * d) * factor,
            (w * d - z * a - x * c + y * b) * factor,
        ]
    }

    /// The angular momentum L = R I ω \[J s\] in space.
    pub fn angular_momentum(&self, q: &[f64; 4], v: &[f64; 4]) -> [f64; 3] {
        let omega = Self::angular_velocity(q, v);
        Self::turn(q, &std::array::from_fn(|i| self.inertia[i] * omega[i]))
    }

    /// The body's vector `r` as seen from space, q r q̄/|q|².
    pub fn turn(q: &[f64; 4], r: &[f64; 3]) -> [f64; 3] {
        let [w, u @ ..] = *q;
        let cross = |a: &[f64; 3], b: &[f64; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let square: f64 = q.iter().map(|x| x * x).sum();
        let once = cross(&u, r);
        let twice = cross(&u, &once);
        std::array::from_fn(|i| r[i] + 2.0 / square * (w * once[i] + twice[i]))
    }

    /// The period \[s\] of ω(t) in the body, for the angular velocity `omega` \[rad/s\] at some time; infinite on the separatrix.
    ///
    /// With the moments sorted, I₁ ≤ I₂ ≤ I₃, L² = Σ I²ω² and 2E = Σ Iω²: Euler's equations are solved by Jacobi's functions, of period
    /// 2π/agm(√A, √B) with
    ///
    /// A = (I₃ − I₂)(L² − 2E I₁)/(I₁I₂I₃), B = (I₃ − I₁)(L² − 2E I₂)/(I₁I₂I₃) for L² > 2E I₂,
    ///
    /// and 1 and 3 exchanged otherwise. The differences are taken before the squares, so nearly equal moments and the neighbourhood of the
    /// separatrix lose no digits.
    pub fn spin_period(&self, omega: &[f64; 3]) -> f64 {
        let mut axes: [[f64; 2]; 3] = std::array::from_fn(|i| [self.inertia[i], omega[i] * omega[i]]);
        axes.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let [[i1, s1], [i2, s2], [i3, s3]] = axes;
        let middle = i1 * (i1 - i2) * s1 + i3 * (i3 - i2) * s3;
        let about_one = i2 * (i2 - i1) * s2 + i3 * (i3 - i1) * s3;
        let about_three = i1 * (i3 - i1) * s1 + i2 * (i3 - i2) * s2;
        let a = if middle >= 0.0 { (i3 - i2) * about_one } else { (i2 - i1) * about_three };
        let b = (i3 - i1) * middle.abs();
        TAU * (i1 * i2 * i3).sqrt() / arithmetic_geometric_mean(a.sqrt(), b.sqrt())
    }
}

impl Lagrangian<4> for FreeBody {
    #[inline]
    fn kinetic<S: Scalar>(&self, q: &[S; 4], v: &[S; 4], _: S) -> S {
        let omega = Self::angular_velocity(q, v);
        let rotation = omega[0].square().scale(self.inertia[0])
            + omega[1].square().scale(self.inertia[1])
            + omega[2].square().scale(self.inertia[2]);
        let square = q[0].square() + q[1].square() + q[2].square() + q[3].square();
        let outwards = q[0] * v[0] + q[1] * v[1] + q[2] * v[2] + q[3] * v[3];
        (rotation + (outwards.square() / square).scale(self.radial_inertia)).scale(0.5)
    }

    #[inline]
    fn potential<S: Scalar>(&self, _: &[S; 4], _: S) -> S {
        S::constant(0.0)
    }
}
