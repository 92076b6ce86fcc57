//! The block diagonal of the Hessian, one D×D block a node.

use super::cloud::Cloud;
use super::nodes::Nodes;
use crate::body::StepSettings;
use crate::grid::Fields;
use crate::neighbourhood::{NODE, arena_side};
use crate::{Kernel, kernel};
use mechanics_core::tensor::Mat3;

/// Entries (a, b) of a block that are kept; in the plane the first three.
const ENTRIES: [(usize, usize); 6] = [(0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2)];

/// mᵢ I + h² Σ V₀ ∇wᵢ · ∂²W/∂G² · ∇wᵢ, as 3×3 matrices (in the plane with a third axis that nothing uses).
pub(super) fn diagonal_blocks<const D: usize>(
    cloud: &mut Cloud<'_, D>,
    nodes: &Nodes<D>,
    grid: &dyn Fields,
    settings: &StepSettings,
) -> Vec<Mat3> {
    let mut blocks: Vec<Mat3> = nodes.masses.iter().map(|m| Mat3::identity() * *m).collect();
    let count = D * (D + 1) / 2;
    for entries in ENTRIES[..count].chunks(NODE) {
        cloud.fill_arenas(|cloud, block, arena| {
            cloud.for_each_tangent(block, |cells, tangent| match settings.kernel {
                Kernel::Linear => add::<D, 2>(arena, &cells, tangent, settings, entries),
                Kernel::Quadratic => add::<D, 3>(arena, &cells, tangent, settings, entries),
                Kernel::Cubic => add::<D, 4>(arena, &cells, tangent, settings, entries),
            });
        });
        for (block, sums) in blocks.iter_mut().zip(nodes.sums(grid, cloud.arenas())) {
            for (sum, (a, b)) in sums.iter().zip(entries) {
                block[(*a, *b)] += sum;
                if a != b {
                    block[(*b, *a)] += sum;
                }
            }
        }
    }
    blocks
}

/// Adds some entries of the blocks of a particle's nodes.
fn add<const D: usize, const W: usize>(
    arena: &mut [f64],
    cells: &[f64; D],
    tangent: &[f64],
    settings: &StepSettings,
    entries: &[(usize, usize)],
) {
    let side = arena_side(D, W);
    let lowest = cells.map(|x| kernel::lowest_node::<f64, W>(x).clamp(0.0, (side - W) as f64));
    let fraction: [f64; D] = std::array::from_fn(|axis| cells[axis] - lowest[axis]);
    let weights: [[f64; W]; D] = fraction.map(kernel::weights::<f64, W>);
    let slopes: [[f64; W]; D] = fraction.map(kernel::slopes::<f64, W>);
    let moving = !settings.transfer.uses_gradients();
    let moment = settings.kernel.second_moment().unwrap_or(f64::INFINITY);
    let factor = settings.step / settings.spacing * if moving { 1.0 / moment } else { 1.0 };
    for node in 0..W.pow(D as u32) {
        let index: [usize; D] = std::array::from_fn(|axis| node / W.pow((D - 1 - axis) as u32) % W);
        let at = (0..D).fold(0, |at, axis| at * side + lowest[axis] as usize + index[axis]);
        let mut gradient = [factor; D];
        for axis in 0..D {
            for other in 0..D {
                let i = index[other];
                gradient[axis] *= match (moving, axis == other) {
                    (true, true) => weights[other][i] * (i as f64 - fraction[other]),
                    (false, true) => slopes[other][i],
                    _ => weights[other][i],
                };
            }
        }
        for (c, (a, b)) in entries.iter().enumerate() {
            let mut sum = 0.0;
            for j in 0..D {
                for l in 0..D {
                    sum += gradient[j] * gradient[l] * tangent[packed(j * D + a, l * D + b)];
                }
            }
            arena[at * NODE + c] += sum;
        }
    }
}

/// Where entry (k, l) of a symmetric matrix is in its lower triangle.
fn packed(k: usize, l: usize) -> usize {
    let (row, column) = (k.max(l), k.min(l));
    row * (row + 1) / 2 + column
}
