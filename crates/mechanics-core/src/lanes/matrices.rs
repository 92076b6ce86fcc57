//! 3×3 matrices between arrays of matrices and matrices of packets.

use super::{Element, MOST_LANES, Packet};
use crate::tensor::{self, Matrix3};

/// Matrix i of a slice on lane i of a matrix of packets.
///
/// # Panics
/// If there are not exactly as many matrices as lanes.
#[inline(always)]
pub fn load_matrices<P: Packet>(matrices: &[Matrix3<P::Element>]) -> Matrix3<P> {
    assert_eq!(matrices.len(), P::LANES, "one matrix for each lane");
    let mut entries = [P::constant(0.0); 9];
    // Nine entries are 8/LANES square blocks and one packet of last entries.
    for block in 0..8 / P::LANES {
        let rows = &mut entries[block * P::LANES..(block + 1) * P::LANES];
        for (row, matrix) in rows.iter_mut().zip(matrices) {
            *row = P::load(&matrix.as_slice()[block * P::LANES..]);
        }
        P::transpose(rows);
    }
    let mut last = <P::Element as Element>::Lanes::default();
    for (entry, matrix) in last.as_mut().iter_mut().zip(matrices) {
        *entry = matrix.as_slice()[8];
    }
    let e = &entries;
    tensor::from_columns([[e[0], e[1], e[2]], [e[3], e[4], e[5]], [e[6], e[7], P::from_lanes(last)]])
}

/// Lane i of a matrix of packets to `target(i)`, for `i` below `count`.
///
/// # Panics
/// If `count` exceeds the number of lanes.
#[inline(always)]
pub fn store_matrices<'a, P: Packet>(
    matrix: &Matrix3<P>,
    targets: impl Iterator<Item = &'a mut Matrix3<P::Element>>,
) {
    let columns = tensor::columns(matrix);
    let mut entries = [P::constant(0.0); MOST_LANES];
    for (k, entry) in entries.iter_mut().enumerate() {
        *entry = columns[k / 3][k % 3];
    }
    for block in 0..8 / P::LANES {
        P::transpose(&mut entries[block * P::LANES..(block + 1) * P::LANES]);
    }
    let last = columns[2][2].to_lanes();
    for (lane, target) in targets.take(P::LANES).enumerate() {
        let target = target.as_mut_slice();
        for block in 0..8 / P::LANES {
            entries[block * P::LANES + lane].store(&mut target[block * P::LANES..]);
        }
        target[8] = last.as_ref()[lane];
    }
}
