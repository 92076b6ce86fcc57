//! A motion that is known, run on finer and finer grids.

use mpm_constitutive::PointLaw;
use mpm_core::kinematics::{DeformationMap, body_force, material_motion};
use mpm_core::{Samples, Simulation, SimulationOptions};

/// Material points and the area that each one stands for.
pub(crate) struct Cloud {
    pub(crate) points: Vec<[f64; 2]>,
    pub(crate) volumes: Vec<f64>,
}

impl Cloud {
    /// A rectangle in `counts` equal parts an axis, one particle in the middle of each.
    pub(crate) fn rectangle(low: [f64; 2], high: [f64; 2], counts: [usize; 2]) -> Self {
        let gap: [f64; 2] = std::array::from_fn(|a| (high[a] - low[a]) / counts[a] as f64);
        let points = (0..counts[0] * counts[1])
            .map(|k| {
                let index = [k / counts[1], k % counts[1]];
                std::array::from_fn(|a| low[a] + gap[a] * (index[a] as f64 + 0.5))
            })
            .collect();
        Self { points, volumes: vec![gap[0] * gap[1]; counts[0] * counts[1]] }
    }

    /// An annulus in rings of parts that are about `gap` wide and exactly tile it.
    pub(crate) fn annulus(inner: f64, outer: f64, gap: f64) -> Self {
        let rings = ((outer - inner) / gap).round() as usize;
        let width = (outer - inner) / rings as f64;
        let mut cloud = Self { points: Vec::new(), volumes: Vec::new() };
        for ring in 0..rings {
            let radius = inner + width * (ring as f64 + 0.5);
            let parts = (std::f64::consts::TAU * radius / gap).round() as usize;
            let angle = std::f64::consts::TAU / parts as f64;
            for part in 0..parts {
                let (sine, cosine) = (angle * (part as f64 + 0.5)).sin_cos();
                cloud.points.push([radius * cosine, radius * sine]);
                cloud.volumes.push(radius * angle * width);
            }
        }
        cloud
    }
}

/// What acts beside stress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Forcing {
    /// The body force that makes the motion a solution.
    Manufactured,
    /// Nothing: it is one.
    Free,
}

/// A motion and its material.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion<M, L> {
    pub(crate) map: M,
    pub(crate) law: L,
    pub(crate) density: f64,
    pub(crate) forcing: Forcing,
}

impl<M: DeformationMap<2>, L: PointLaw + Copy + 'static> Motion<M, L> {
    /// At time zero; velocities half a step earlier, where symplectic Euler has them.
    pub(crate) fn start(&self, cloud: &Cloud, options: SimulationOptions, step: f64) -> Simulation<f64, 2> {
        let now: Vec<_> = cloud.points.iter().map(|x| material_motion(&self.map, x, 0.0)).collect();
        let before: Vec<_> = cloud.points.iter().map(|x| material_motion(&self.map, x, -0.5 * step)).collect();
        let positions: Vec<_> = now.iter().map(|m| m.position).collect();
        let velocities: Vec<_> = before.iter().map(|m| m.velocity).collect();
        let gradients: Vec<_> = before.iter().map(|m| m.velocity_gradient()).collect();
        let deformations: Vec<_> = now.iter().map(|m| m.deformation_gradient).collect();
        let mut simulation = Simulation::new(options).unwrap();
        let samples = Samples { positions: &positions, velocities: &velocities, volumes: &cloud.volumes };
        simulation.add_body(self.law, self.density, samples).unwrap();
        simulation.set_velocity_gradients(0, &gradients).unwrap();
        simulation.set_deformation_gradients(0, &deformations).unwrap();
        simulation
    }

    pub(crate) fn step(&self, cloud: &Cloud, simulation: &mut Simulation<f64, 2>, step: f64) {
        if self.forcing == Forcing::Manufactured {
            let time = simulation.time();
            let force = |x: &[f64; 2]| body_force(&self.map, &self.law, self.density, x, time);
            let forces: Vec<_> = cloud.points.iter().map(force).collect();
            simulation.accelerate(0, &forces, step).unwrap();
        }
        simulation.step(step).unwrap();
    }

    /// The root mean square of the error of the positions \[m\] of the points that are `measured`, by volume.
    pub(crate) fn error(&self, cloud: &Cloud, simulation: &Simulation<f64, 2>, measured: impl Fn(&[f64; 2]) -> bool) -> f64 {
        let (mut sum, mut volume) = (0.0, 0.0);
        for (p, x) in simulation.positions(0).iter().enumerate().filter(|(p, _)| measured(&cloud.points[*p])) {
            let place = self.map.place(&cloud.points[p], simulation.time());
            sum += cloud.volumes[p] * ((x[0] - place[0]).powi(2) + (x[1] - place[1]).powi(2));
            volume += cloud.volumes[p];
        }
        (sum / volume).sqrt()
    }
}

/// Numbers for a line of print.
pub(crate) fn brief(numbers: &[f64]) -> String {
    numbers.iter().map(|x| format!("{x:.2e} ")).collect()
}

/// log₂ of the quotients of errors on grids of half the spacing.
pub(crate) fn orders(errors: &[f64]) -> Vec<f64> {
    errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect()
}
