//! What the grid cannot see, and where it sees too much.

use crate::ladder::Cloud;
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::multiple_of_identity;
use mpm_constitutive::{PointLaw, StiffnessBound, Stress, TotalDeformation, VolumeChange};
use mpm_core::{Kernel, Samples, Simulation, SimulationOptions, Transfer};

/// The same stress τ = s I whatever happens.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Constant {
    pub(crate) stress: f64,
}

impl PointLaw for Constant {
    type Strain<S: Scalar> = VolumeChange<S>;
    type History<S: Scalar> = ();
    const TOTAL_DEFORMATION: TotalDeformation = TotalDeformation::Meaningless;

    #[inline(always)]
    fn energy_density<S: Scalar>(&self, strain: &VolumeChange<S>, _history: &()) -> S {
        strain.0.ln_1p().scale(self.stress)
    }

    #[inline(always)]
    fn stress<S: Scalar>(&self, _strain: &VolumeChange<S>, _history: &()) -> Stress<S> {
        let stiffness = StiffnessBound { lambda: S::constant(self.stress.abs()), mu: S::constant(0.0) };
        Stress { kirchhoff: multiple_of_identity(S::constant(self.stress)), stiffness }
    }
}

fn simulation(
    kernel: Kernel,
    transfer: Transfer,
    stress: f64,
    cloud: &Cloud,
    velocities: &[[f64; 2]],
) -> Simulation<f64, 2> {
    let mut simulation = Simulation::new(SimulationOptions { spacing: 1.0, kernel, transfer }).unwrap();
    let samples = Samples { positions: &cloud.points, velocities, volumes: &cloud.volumes };
    simulation.add_body(Constant { stress }, 1.0, samples).unwrap();
    simulation
}

#[test]
fn flip_keeps_what_the_grid_cannot_see_and_the_others_forget_it() {
    // Two particles at each place with opposite velocities: the grid gets nothing.
    let single = Cloud::rectangle([0.0; 2], [6.0; 2], [12; 2]);
    let points: Vec<_> = single.points.iter().flat_map(|x| [*x, *x]).collect();
    let cloud = Cloud { volumes: vec![0.125; points.len()], points };
    let noise: Vec<[f64; 2]> = (0..cloud.points.len())
        .map(|p| {
            let angle = 2.399_963 * (p / 2) as f64;
            let sign = if p % 2 == 0 { 1.0 } else { -1.0 };
            [sign * angle.cos(), sign * angle.sin()]
        })
        .collect();
    let energy =
        |v: &[[f64; 2]]| v.iter().map(|v| v[0] * v[0] + v[1] * v[1]).sum::<f64>() / noise.len() as f64;
    for (kernel, transfer, steps, least, most) in [
        (Kernel::Quadratic, Transfer::FLIP, 100, 1.0 - 1e-13, 1.0 + 1e-13),
        (Kernel::Linear, Transfer::FLIP, 100, 1.0 - 1e-13, 1.0 + 1e-13),
        (Kernel::Quadratic, Transfer::Flip { flip: 0.9 }, 1, 0.81 - 1e-13, 0.81 + 1e-13),
        (Kernel::Quadratic, Transfer::Pic, 1, 0.0, 1e-30),
        (Kernel::Quadratic, Transfer::Xpic { order: 2 }, 1, 0.0, 1e-30),
        (Kernel::Linear, Transfer::Xpic { order: 20 }, 1, 0.0, 1e-28),
        (Kernel::Quadratic, Transfer::Asflip { flip: 0.9, position: 0.0 }, 1, 0.81 - 1e-13, 0.81 + 1e-13),
        (Kernel::Quadratic, Transfer::APIC, 1, 0.0, 1e-30),
        (Kernel::Quadratic, Transfer::MlsApic, 1, 0.0, 1e-30),
        (Kernel::Cubic, Transfer::APIC, 1, 0.0, 1e-30),
    ] {
        let mut simulation = simulation(kernel, transfer, 0.0, &cloud, &noise);
        for _ in 0..steps {
            simulation.step(0.1).unwrap();
        }
        let left = energy(&simulation.velocities(0));
        assert!((least..=most).contains(&left), "{kernel:?} {transfer:?}: {left} of the noise is left");
        // And nobody went anywhere: particles move with the grid.
        let places = simulation.positions(0);
        let moved = places.iter().flatten().zip(cloud.points.iter().flatten()).map(|(a, b)| (a - b).abs());
        assert!(moved.fold(0.0, f64::max) < 1e-14);
    }
}

/// The largest force on an inner node of a body under uniform stress, which should be none, by stress × area of a cell's side, while the
/// body is moved through a cell. From velocities after a step: PIC's are h f/m, smoothed.
fn imbalance(kernel: Kernel, transfer: Transfer) -> f64 {
    let mut worst = 0.0_f64;
    for offset in 0..20 {
        let shift = 0.013 + 0.05 * f64::from(offset);
        // Stretched by a tenth: a cell has one or two particles an axis.
        let cloud = Cloud::rectangle([shift, 0.0], [shift + 17.6, 17.6], [32; 2]);
        let still = vec![[0.0; 2]; cloud.points.len()];
        let mut simulation = simulation(kernel, transfer, 1.0, &cloud, &still);
        let step = 1e-3;
        simulation.step(step).unwrap();
        for (v, x) in simulation.velocities(0).iter().zip(&cloud.points) {
            if (x[0] - shift - 8.8).abs() < 3.0 && (x[1] - 8.8).abs() < 3.0 {
                worst = worst.max(v[0].abs() / step);
            }
        }
    }
    worst
}

#[test]
fn uniform_stress_pushes_where_particles_cross_cells_by_the_kernel() {
    let linear = imbalance(Kernel::Linear, Transfer::Pic);
    let quadratic = imbalance(Kernel::Quadratic, Transfer::Pic);
    let cubic = imbalance(Kernel::Cubic, Transfer::Pic);
    let mls = imbalance(Kernel::Quadratic, Transfer::MlsApic);
    println!(
        "cell crossing: linear {linear:.1e}, quadratic {quadratic:.1e}, cubic {cubic:.1e}, quadratic MLS {mls:.1e}"
    );
    // Σ ∇w over regular particles, 0.55 of a cell apart, is a sum by the midpoint rule of a function with jumps (linear), kinks (quadratic),
    // jumps of the second derivative (cubic).
    assert!(quadratic < 0.1 && cubic < 0.02 && mls < 0.1, "{quadratic} {cubic} {mls}");
    assert!(linear > 2.0 * quadratic || linear < 1e-12, "{linear} {quadratic}");
}
