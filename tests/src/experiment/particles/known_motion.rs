//! Motions in closed form, and a body that is started in one.

use super::cloud::Cloud;
use super::method::Method;
use super::solver::{Matter, Solver};
use crate::experiment::ExperimentError;
use mechanics_core::parallel;
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::Mat3;
use mpm_constitutive::elastic::NeoHookean;
use mpm_core::Samples;
use mpm_core::kinematics::{DeformationMap, MaterialMotion, body_force, first_piola, material_motion};
use std::f64::consts::PI;

/// A motion x = φ(X, t) in the plane.
#[derive(Clone, Copy, Debug)]
pub(super) enum KnownMotion {
    /// u_x = A sin 2πX sin ωt, u_y = −A sin 2πY sin ωt.
    AxisAligned { amplitude: f64, frequency: f64 },
    /// Every ring of ¾ < R < 5⁄4 turns by G sin(πt/T) h(R), h = 1 − 32(R − 1)² + 256(R − 1)⁴.
    Vortex { turn: f64, period: f64 },
    /// u_R = A cos ωt (c₃R³ + c₂R² + c₁R), with u_R′ = 0 at both rims.
    Ring { amplitude: f64, frequency: f64, inner: f64, outer: f64 },
    /// u_x = A sin kX sin ωt.
    Vibration { amplitude: f64, wave_number: f64, frequency: f64 },
}

impl DeformationMap<2> for KnownMotion {
    fn place<S: Scalar>(&self, x: &[S; 2], t: S) -> [S; 2] {
        match *self {
            Self::AxisAligned { amplitude, frequency } => {
                let now = t.scale(frequency).sin().scale(amplitude);
                [x[0] + x[0].scale(2.0 * PI).sin() * now, x[1] - x[1].scale(2.0 * PI).sin() * now]
            }
            Self::Vortex { turn, period } => {
                let d = (x[0].square() + x[1].square()).sqrt().offset(-1.0);
                let square = d.square();
                let profile = square.square().scale(256.0) - square.scale(32.0).offset(-1.0);
                let inside = S::select(d.abs().less(S::constant(0.25)), profile, S::constant(0.0));
                let angle = inside * t.scale(PI / period).sin().scale(turn);
                let (sine, cosine) = (angle.sin(), angle.cos());
                [x[0] * cosine - x[1] * sine, x[0] * sine + x[1] * cosine]
            }
            Self::Ring { amplitude, frequency, inner, outer } => {
                let scale = outer * outer * (outer - 3.0 * inner);
                let [a, b, c] = [-6.0 * inner * outer, 3.0 * (outer + inner), -2.0].map(|c| c / scale);
                let r = (x[0].square() + x[1].square()).sqrt();
                let ratio = r.mul_add(S::constant(c), S::constant(b)).mul_add(r, S::constant(a));
                let stretch = (ratio * t.scale(frequency).cos()).scale(amplitude).offset(1.0);
                [x[0] * stretch, x[1] * stretch]
            }
            Self::Vibration { amplitude, wave_number, frequency } => {
                let shape = x[0].scale(wave_number).sin() * t.scale(frequency).sin();
                [x[0] + shape.scale(amplitude), x[1]]
            }
        }
    }
}

impl KnownMotion {
    /// What it does to a material point.
    pub(super) fn at(&self, material: &[f64; 2], time: f64) -> MaterialMotion<2> {
        material_motion(self, material, time)
    }

    /// The body force per mass that makes it a solution for neo-Hookean matter \[m/s²\].
    pub(super) fn forces(&self, matter: &Matter, cloud: &Cloud<2>, time: f64) -> Vec<[f64; 2]> {
        let law = NeoHookean::new(matter.lame);
        let mut forces = vec![[0.0; 2]; cloud.points.len()];
        parallel::map_into(&mut forces, 256, |p| {
            body_force(self, &law, matter.density, &cloud.points[p], time)
        });
        forces
    }

    /// τ = P Fᵀ of neo-Hookean matter \[Pa\].
    pub(super) fn stress(&self, matter: &Matter, material: &[f64; 2], time: f64) -> Mat3 {
        let law = NeoHookean::new(matter.lame);
        first_piola(self, &law, material, time) * self.at(material, time).deformation_gradient.transpose()
    }

    /// A body in this motion at time zero; velocities of half a step earlier, where symplectic Euler has them.
    pub(super) fn start(
        &self,
        matter: &Matter,
        cloud: &Cloud<2>,
        method: Method,
        (spacing, step): (f64, f64),
    ) -> Result<Solver<2>, ExperimentError> {
        let at =
            |time: f64| -> Vec<MaterialMotion<2>> { cloud.points.iter().map(|x| self.at(x, time)).collect() };
        let (now, before) = (at(0.0), at(-0.5 * step));
        let positions: Vec<_> = now.iter().map(|m| m.position).collect();
        let velocities: Vec<_> = before.iter().map(|m| m.velocity).collect();
        let gradients: Vec<_> = before.iter().map(MaterialMotion::velocity_gradient).collect();
        let deformations: Vec<_> = now.iter().map(|m| m.deformation_gradient).collect();
        let mut solver = Solver::new(method, spacing)?;
        let samples = Samples { positions: &positions, velocities: &velocities, volumes: &cloud.volumes };
        let body = solver.add_body(matter, samples)?;
        solver.set_velocity_gradients(body, &gradients)?;
        solver.set_deformation_gradients(body, &deformations)?;
        Ok(solver)
    }
}
