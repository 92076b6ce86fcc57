//! Manufactured solutions with large strain and rotation.

use crate::ladder::{Cloud, Forcing, Motion, brief, orders};
use crate::motions::{AxisAligned, Vortex};
use mechanics_core::law::Lame;
use mpm_constitutive::elastic::NeoHookean;
use mpm_core::{Kernel, SimulationOptions, Transfer};

/// Cells of a unit length.
const LADDER: [usize; 3] = [8, 16, 32];

/// Errors of the axis-aligned solution at t = 0.4/c, when F runs from 0.70 to 1.30. The solution is periodic and the body is not: it is
/// half a period larger than the unit square on every side, and only what no wave from its rim has reached is measured.
fn axis_aligned(kernel: Kernel, transfer: Transfer) -> Vec<f64> {
    let solution = AxisAligned::standard();
    let law = NeoHookean::new(solution.lame);
    let motion = Motion { map: solution, law, density: solution.density, forcing: Forcing::Manufactured };
    let errors = LADDER.map(|cells| {
        let options = SimulationOptions { spacing: 1.0 / cells as f64, kernel, transfer };
        let cloud = Cloud::rectangle([-0.5; 2], [1.5; 2], [4 * cells; 2]);
        let steps = 2 * cells;
        let step = 0.4 / solution.speed / steps as f64;
        let mut simulation = motion.start(&cloud, options, step);
        for _ in 0..steps {
            motion.step(&cloud, &mut simulation, step);
        }
        motion.error(&cloud, &simulation, |x| x.iter().all(|x| (x - 0.5).abs() < 0.25))
    });
    println!("axis-aligned {kernel:?} {transfer:?}: {}orders {:.2?}", brief(&errors), orders(&errors));
    errors.to_vec()
}

#[test]
fn the_axis_aligned_solution_is_reached_with_second_order() {
    for (kernel, transfer) in [
        (Kernel::Quadratic, Transfer::MlsApic),
        (Kernel::Quadratic, Transfer::APIC),
        (Kernel::Quadratic, Transfer::FLIP),
        (Kernel::Cubic, Transfer::APIC),
    ] {
        let errors = axis_aligned(kernel, transfer);
        assert!(orders(&errors)[0] > 1.5, "{kernel:?} {transfer:?} {errors:?}");
        assert!(orders(&errors)[1] > 1.5, "{kernel:?} {transfer:?} {errors:?}");
        // The motion itself has an RMS of 0.05 · √(1/2) · √2 sin 72°.
        assert!(errors[2] < 5e-4, "{kernel:?} {transfer:?} {errors:?}");
    }
    // PIC's diffusion, Δx²/(8 Δt) and more, falls with the first power of Δx only.
    let pic = axis_aligned(Kernel::Quadratic, Transfer::Pic);
    assert!(orders(&pic).iter().all(|order| (0.5..1.5).contains(order)), "{pic:?}");
}

/// Errors of the vortex at half its period, when rings have turned by up to G.
fn vortex(turn: f64, kernel: Kernel, transfer: Transfer) -> Vec<f64> {
    let law = NeoHookean::new(Lame::from_young_poisson(1000.0, 0.3).unwrap());
    let map = Vortex { turn, period: 1.0 };
    let motion = Motion { map, law, density: 1000.0, forcing: Forcing::Manufactured };
    let errors = LADDER.map(|cells| {
        let options = SimulationOptions { spacing: 1.0 / cells as f64, kernel, transfer };
        let cloud = Cloud::annulus(0.75, 1.25, 0.5 / cells as f64);
        let steps = 4 * cells;
        let step = 0.5 / steps as f64;
        let mut simulation = motion.start(&cloud, options, step);
        for _ in 0..steps {
            motion.step(&cloud, &mut simulation, step);
        }
        motion.error(&cloud, &simulation, |_| true)
    });
    println!("vortex G = {turn:.3} {kernel:?} {transfer:?}: {}orders {:.2?}", brief(&errors), orders(&errors));
    errors.to_vec()
}

#[test]
fn the_vortex_is_reached_with_second_order() {
    for (kernel, transfer) in
        [(Kernel::Quadratic, Transfer::MlsApic), (Kernel::Quadratic, Transfer::FLIP), (Kernel::Cubic, Transfer::APIC)]
    {
        let errors = vortex(std::f64::consts::FRAC_PI_8, kernel, transfer);
        assert!(orders(&errors).iter().all(|order| *order > 1.4), "{kernel:?} {transfer:?} {errors:?}");
    }
}
