//! The vibrating bar: L = 25 m, E = 100 Pa, ρ = 1 kg/m³, ν = 0, held at x = 0; v = v₀ sin(πX/2L) cos ωt, ω = (π/2L) √(E/ρ).
//!
//! Reference: S. G. Bardenhagen, *Energy conservation error in the material point method for solid mechanics*, J. Comput. Phys. 180, 2002.

use crate::ladder::{Cloud, Forcing, Motion, brief, orders};
use mechanics_core::law::Lame;
use mechanics_core::parallel::with_threads;
use mechanics_core::scalar::Scalar;
use mpm_constitutive::elastic::Linear;
use mpm_core::kinematics::DeformationMap;
use mpm_core::{Boundary, Kernel, Shape, SimulationOptions, Surface, Transfer};
use std::f64::consts::FRAC_PI_2;

const LENGTH: f64 = 25.0;
const WAVE_SPEED: f64 = 10.0;
const SPEED: f64 = 0.1;
const PERIOD: f64 = 4.0 * LENGTH / WAVE_SPEED;

#[derive(Clone, Copy, Debug)]
struct Vibration;

impl DeformationMap<2> for Vibration {
    fn place<S: Scalar>(&self, x: &[S; 2], t: S) -> [S; 2] {
        let omega = FRAC_PI_2 / LENGTH * WAVE_SPEED;
        let shape = x[0].scale(FRAC_PI_2 / LENGTH).sin() * t.scale(omega).sin();
        [x[0] + shape.scale(SPEED / omega), x[1]]
    }
}

/// How the bar is held.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Support {
    /// Nodes at x ≤ 0 do not move.
    Nodes,
    /// By its own mirror image: the bar from −L to L.
    Symmetry,
}

/// What a bar of `cells` cells does: RMS error of the velocity of the centre of mass over the last of some periods, by its amplitude, and
/// energy after them by energy before.
fn bar(cells: usize, support: Support, kernel: Kernel, transfer: Transfer, periods: usize) -> (f64, f64) {
    let law = Linear::new(Lame::from_young_poisson(100.0, 0.0).unwrap());
    let motion = Motion { map: Vibration, law, density: 1.0, forcing: Forcing::Free };
    let spacing = LENGTH / cells as f64;
    let cloud = match support {
        Support::Nodes => Cloud::rectangle([0.0; 2], [LENGTH, spacing], [2 * cells, 2]),
        Support::Symmetry => Cloud::rectangle([-LENGTH, 0.0], [LENGTH, spacing], [4 * cells, 2]),
    };
    let steps = 20 * cells;
    let step = PERIOD / steps as f64;
    let mut simulation = motion.start(&cloud, SimulationOptions { spacing, kernel, transfer }, step);
    if support == Support::Nodes {
        let wall = Shape::HalfSpace { point: [0.0; 2], normal: [1.0, 0.0] };
        simulation.add_boundary(Boundary::at_rest(wall, Surface::Sticky)).unwrap();
    }
    let amplitude = SPEED / FRAC_PI_2;
    let energy = |simulation: &mpm_core::Simulation<f64, 2>| -> f64 {
        let (v, states) = (simulation.velocities(0), simulation.states(0));
        (0..v.len())
            .map(|p| {
                cloud.volumes[p] * (0.5 * (v[p][0].powi(2) + v[p][1].powi(2)) + states[p].energy_density)
            })
            .sum()
    };
    let mut square = 0.0;
    let before = energy(&simulation);
    for period in 0..periods {
        for _ in 0..steps {
            motion.step(&cloud, &mut simulation, step);
            if period + 1 < periods {
                continue;
            }
            // The velocity belongs to the middle of the step.
            let time = simulation.time() - 0.5 * step;
            let half: Vec<f64> = simulation
                .velocities(0)
                .iter()
                .zip(&cloud.points)
                .filter(|(_, x)| x[0] > 0.0)
                .map(|(v, _)| v[0])
                .collect();
            let mean = half.iter().sum::<f64>() / half.len() as f64;
            square += (mean / amplitude - (std::f64::consts::TAU * time / PERIOD).cos()).powi(2);
        }
    }
    ((square / steps as f64).sqrt(), energy(&simulation) / before)
}

fn ladder(support: Support, kernel: Kernel, transfer: Transfer) -> Vec<f64> {
    let errors = [8, 16, 32].map(|cells| with_threads(1, || bar(cells, support, kernel, transfer, 1)).0);
    println!("bar {support:?} {kernel:?} {transfer:?}: {}orders {:.2?}", brief(&errors), orders(&errors));
    errors.to_vec()
}

#[test]
fn the_bar_vibrates_with_second_order() {
    for (kernel, transfer) in [
        (Kernel::Quadratic, Transfer::MlsApic),
        (Kernel::Quadratic, Transfer::APIC),
        (Kernel::Quadratic, Transfer::FLIP),
        (Kernel::Cubic, Transfer::APIC),
        (Kernel::Cubic, Transfer::FLIP),
    ] {
        let errors = ladder(Support::Symmetry, kernel, transfer);
        assert!(orders(&errors).iter().all(|order| *order > 1.6), "{kernel:?} {transfer:?} {errors:?}");
        // Nodes that are held beyond the end are a wall that is a part of a cell away: first order.
        let held = ladder(Support::Nodes, kernel, transfer);
        assert!(orders(&held).iter().all(|order| *order > 0.8), "{kernel:?} {transfer:?} {held:?}");
    }
}

#[test]
fn the_bar_keeps_its_energy_over_ten_periods_unless_the_transfer_forgets() {
    for (transfer, least, most) in [
        (Transfer::FLIP, 0.98, 1.02),
        (Transfer::APIC, 0.9, 1.001),
        (Transfer::MlsApic, 0.9, 1.001),
        (Transfer::Pic, 0.0, 0.1),
    ] {
        let (error, energy) = with_threads(1, || bar(16, Support::Symmetry, Kernel::Quadratic, transfer, 10));
        println!("bar of 16 cells, ten periods, {transfer:?}: energy {energy:.6}, error of v {error:.3}");
        assert!((least..most).contains(&energy), "{transfer:?}: {energy}");
    }
}

/// XPIC(m) takes the part (Dk²)ᵐ of a velocity in every step, D the second moment of the kernel and k the wave number: half of a vibration's
/// energy is kinetic, so n steps leave exp(−n (Dk²)ᵐ) of it.
#[test]
fn the_bar_loses_the_less_the_higher_the_order_of_xpic() {
    let (cells, periods) = (8, 3);
    let mut before = 0.0;
    for order in 1..=5 {
        let transfer = Transfer::Xpic { order };
        let (error, energy) =
            with_threads(1, || bar(cells, Support::Symmetry, Kernel::Quadratic, transfer, periods));
        let filtered = (FRAC_PI_2 / cells as f64).powi(2) / 4.0;
        let loss = (20 * cells * periods) as f64 * filtered.powi(order as i32);
        println!(
            "bar of {cells} cells, {periods} periods, XPIC({order}): energy {energy:.6}, by theory {:.6}; error of v {error:.3}",
            (-loss).exp()
        );
        assert!(energy > before && energy < 1.0 + 2e-3, "XPIC({order}): {energy} after {before}");
        if order < 3 {
            assert!((energy.ln() / -loss - 1.0).abs() < 0.15, "XPIC({order}): {energy}, {loss}");
        }
        // What is lost and what symplectic Euler swings by at the end of a period tell apart until here.
        before = if order < 3 { energy } else { energy.min(before) };
    }
}
