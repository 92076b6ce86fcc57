//! Motions with known body forces: the manufactured solutions of the literature.
#![allow(dead_code, reason = "every test program takes what it needs")]

use mechanics_core::law::Lame;
use mechanics_core::scalar::Scalar;
use mpm_core::kinematics::DeformationMap;
use std::f64::consts::PI;

/// The factor s(t) = A sin(cπt) of the axis-aligned solution.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AxisAligned {
    pub(crate) amplitude: f64,
    pub(crate) speed: f64,
    pub(crate) density: f64,
    pub(crate) lame: Lame,
}

impl AxisAligned {
    /// E = 1e7 Pa, ν = 0.3, ρ₀ = 1000 kg/m³, A = 0.05.
    pub(crate) fn standard() -> Self {
        let (young, density) = (1e7_f64, 1000.0);
        let lame = Lame::from_young_poisson(young, 0.3).unwrap();
        Self { amplitude: 0.05, speed: (young / density).sqrt(), density, lame }
    }

    /// u_x = A sin 2πX sin cπt, u_y = A sin 2πY sin(cπt + π); B from the printed formula
    /// b = (π² u/ρ₀)(4μ − c²ρ₀ − 4 (λ(K − 1) − μ)/F²), K = ln J.
    pub(crate) fn printed_force(&self, x: &[f64; 2], t: f64) -> [f64; 2] {
        let phase = [0.0, PI];
        let s: [f64; 2] = std::array::from_fn(|a| self.amplitude * (self.speed * PI * t + phase[a]).sin());
        let f: [f64; 2] = std::array::from_fn(|a| 1.0 + 2.0 * PI * s[a] * (2.0 * PI * x[a]).cos());
        let (lambda, mu) = (self.lame.lambda(), self.lame.mu());
        let k = (f[0] * f[1]).ln();
        std::array::from_fn(|a| {
            let u = s[a] * (2.0 * PI * x[a]).sin();
            let elastic = 4.0 * mu - 4.0 * (lambda * (k - 1.0) - mu) / (f[a] * f[a]);
            PI * PI * u / self.density * (elastic - self.speed * self.speed * self.density)
        })
    }
}

impl DeformationMap<2> for AxisAligned {
    fn place<S: Scalar>(&self, x: &[S; 2], t: S) -> [S; 2] {
        let phase = t.scale(self.speed * PI);
        [(x[0], phase), (x[1], phase.offset(PI))]
            .map(|(x, phase)| x + (x.scale(2.0 * PI).sin() * phase.sin()).scale(self.amplitude))
    }
}

/// The generalised vortex: every ring of 0.75 < R < 1.25 turns by g(t) h(R), g = G sin(πt/T).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vortex {
    pub(crate) turn: f64,
    pub(crate) period: f64,
}

impl Vortex {
    /// h, h′, h″.
    fn profile(r: f64) -> [f64; 3] {
        let d = r - 1.0;
        [
            1.0 - 32.0 * d.powi(2) + 256.0 * d.powi(4),
            -64.0 * d + 1024.0 * d.powi(3),
            -64.0 + 3072.0 * d.powi(2),
        ]
    }

    /// b_r = −R α_t² + (μ/ρ₀) R α_R², b_θ = R α_tt − (μ/ρ₀)(3 α_R + R α_RR), in the turned polar frame.
    pub(crate) fn printed_force(&self, x: &[f64; 2], t: f64, mu_by_density: f64) -> [f64; 2] {
        let r = x[0].hypot(x[1]);
        let [h, h1, h2] = Self::profile(r);
        let rate = PI / self.period;
        let (g, g1, g2) = (
            self.turn * (rate * t).sin(),
            self.turn * rate * (rate * t).cos(),
            -self.turn * rate * rate * (rate * t).sin(),
        );
        let radial = -r * (g1 * h).powi(2) + mu_by_density * r * (g * h1).powi(2);
        let around = r * g2 * h - mu_by_density * (3.0 * g * h1 + r * g * h2);
        let angle = x[1].atan2(x[0]) + g * h;
        let (sine, cosine) = angle.sin_cos();
        [radial * cosine - around * sine, radial * sine + around * cosine]
    }
}

impl DeformationMap<2> for Vortex {
    fn place<S: Scalar>(&self, x: &[S; 2], t: S) -> [S; 2] {
        let d = (x[0].square() + x[1].square()).sqrt().offset(-1.0);
        let square = d.square();
        let profile = square.square().scale(256.0) - square.scale(32.0).offset(-1.0);
        let inside = S::select(d.abs().less(S::constant(0.25)), profile, S::constant(0.0));
        let angle = inside * t.scale(PI / self.period).sin().scale(self.turn);
        let (sine, cosine) = (angle.sin(), angle.cos());
        [x[0] * cosine - x[1] * sine, x[0] * sine + x[1] * cosine]
    }
}

/// The expanding ring: u_R = A cos(cπt) (c₃R³ + c₂R² + c₁R), free of traction at both rims for ν = 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ring {
    pub(crate) amplitude: f64,
    pub(crate) speed: f64,
    pub(crate) inner: f64,
    pub(crate) outer: f64,
}

impl Ring {
    fn coefficients(&self) -> [f64; 3] {
        let (i, o) = (self.inner, self.outer);
        let scale = o * o * (o - 3.0 * i);
        [-6.0 * i * o / scale, 3.0 * (o + i) / scale, -2.0 / scale]
    }

    /// The radial force by P_ii = μ(F_ii − 1/F_ii), Div P = P_RR′ + (P_RR − P_θθ)/R.
    pub(crate) fn printed_radial_force(&self, r: f64, t: f64, mu_by_density: f64) -> f64 {
        let [a, b, c] = self.coefficients();
        let rate = self.speed * PI;
        let s = self.amplitude * (rate * t).cos();
        let u = s * (c * r.powi(3) + b * r * r + a * r);
        let (u1, u2) = (s * (3.0 * c * r * r + 2.0 * b * r + a), s * (6.0 * c * r + 2.0 * b));
        let (f, g) = (1.0 + u1, 1.0 + u / r);
        let divergence = (1.0 + 1.0 / (f * f)) * u2 + (f - 1.0 / f - g + 1.0 / g) / r;
        -rate * rate * u - mu_by_density * divergence
    }
}

impl DeformationMap<2> for Ring {
    fn place<S: Scalar>(&self, x: &[S; 2], t: S) -> [S; 2] {
        let [a, b, c] = self.coefficients();
        let r = (x[0].square() + x[1].square()).sqrt();
        // u/R.
        let ratio = r.mul_add(S::constant(c), S::constant(b)).mul_add(r, S::constant(a));
        let stretch = (ratio * t.scale(self.speed * PI).cos()).scale(self.amplitude).offset(1.0);
        [x[0] * stretch, x[1] * stretch]
    }
}
