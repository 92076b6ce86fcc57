//! The same bits for any number of threads; single precision beside double.

use crate::conservation::Block;
use mechanics_core::lanes::Element;
use mechanics_core::parallel::with_threads;
use mpm_core::{Boundary, Kernel, Shape, Simulation, Surface, Transfer};

/// Positions and velocities after some steps on a floor, and how often particles were sorted.
fn run<E: Element, const D: usize>(
    block: &Block<D>,
    transfer: Transfer,
    steps: usize,
    step: f64,
) -> (Vec<[f64; D]>, Vec<[f64; D]>, usize) {
    let mut simulation: Simulation<E, D> = block.simulation(Kernel::Quadratic, transfer);
    let axis = |value: f64| std::array::from_fn(|a| if a == D - 1 { value } else { 0.0 });
    simulation.set_gravity(axis(-9.81)).unwrap();
    let floor = Shape::HalfSpace { point: axis(-0.5), normal: axis(1.0) };
    simulation.add_boundary(Boundary::at_rest(floor, Surface::Friction(0.3))).unwrap();
    let sorts = (0..steps).filter(|_| simulation.step(step).unwrap().sorted).count();
    (simulation.positions(0), simulation.velocities(0), sorts)
}

fn same_bits<E: Element, const D: usize>(cells: usize) {
    let block = Block::<D>::spinning(cells, 6.0);
    for transfer in
        [Transfer::MlsApic, Transfer::Flip { flip: 0.95 }, Transfer::Xpic { order: 3 }, Transfer::ASFLIP]
    {
        let once = with_threads(1, || run::<E, D>(&block, transfer, 120, 1e-3));
        assert!(once.2 > 1, "particles must be sorted anew on the way: {}", once.2);
        for threads in [1, 2, 3, 8] {
            let again = with_threads(threads, || run::<E, D>(&block, transfer, 120, 1e-3));
            // f64 from either precision is exact: equal numbers are equal bits, but for the sign of a zero.
            assert!(again == once, "{D}D {transfer:?}: other bits with {threads} threads");
        }
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    same_bits::<f64, 2>(10);
    same_bits::<f64, 3>(5);
    same_bits::<f32, 3>(5);
}

/// Rounding of single precision: x is rounded at each step, so that n steps leave about √n to n times ε |x|.
#[test]
fn single_precision_departs_from_double_as_rounding_does() {
    let block = Block::<3>::spinning(4, 6.0);
    for transfer in
        [Transfer::MlsApic, Transfer::APIC, Transfer::FLIP, Transfer::Xpic { order: 5 }, Transfer::ASFLIP]
    {
        for steps in [1, 10, 100] {
            let double = run::<f64, 3>(&block, transfer, steps, 1e-3);
            let single = run::<f32, 3>(&block, transfer, steps, 1e-3);
            let most = |a: &[[f64; 3]], b: &[[f64; 3]]| {
                a.iter().flatten().zip(b.iter().flatten()).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()))
            };
            let (x, v) = (most(&double.0, &single.0), most(&double.1, &single.1));
            println!("{transfer:?} after {steps}: x {x:.1e} m, v {v:.1e} m/s");
            let growth = (steps as f64).sqrt() * 4.0 * f64::from(f32::EPSILON);
            assert!(x < growth * 0.3 * 3.0, "{transfer:?} after {steps}: x {x}");
            assert!(v < growth * 40.0, "{transfer:?} after {steps}: v {v}");
        }
    }
}
