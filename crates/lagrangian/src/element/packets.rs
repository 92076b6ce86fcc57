//! Points of consecutive elements between memory and the lanes of vector registers.

use mechanics_core::lanes::Packet;
use mechanics_core::tensor::Vec3;

/// Component k of point a of element i on lane i of `[a][k]`. Lanes beyond the last element repeat it, so that they hold
/// ordinary numbers; their results are not stored.
///
/// # Panics
/// If `x` is empty.
#[inline(always)]
pub(super) fn load_points<P: Packet<Element = f64>, const N: usize>(x: &[[Vec3; N]]) -> [[P; 3]; N] {
    let last = x.len() - 1;
    let elements = [&x[0], &x[last.min(1)], &x[last.min(2)], &x[last.min(3)]];
    let mut points = [[P::constant(0.0); 3]; N];
    for a in 0..N {
        for k in 0..3 {
            let lanes = [elements[0][a][k], elements[1][a][k], elements[2][a][k], elements[3][a][k]];
            points[a][k] = P::from_lanes(lanes);
        }
    }
    points
}

/// The reverse: lane i of `vectors[a][k]` becomes component k of vector a of element i.
#[inline(always)]
pub(super) fn store_vectors<P: Packet<Element = f64>, const N: usize>(
    vectors: &[[P; 3]; N],
    targets: &mut [[Vec3; N]],
) {
    for a in 0..N {
        let mut block = [vectors[a][0], vectors[a][1], vectors[a][2], P::constant(0.0)];
        P::transpose(&mut block);
        for (row, target) in block.iter().zip(targets.iter_mut()) {
            let [x, y, z, _] = row.to_lanes();
            target[a] = Vec3::new(x, y, z);
        }
    }
}

/// Twelve numbers of each of up to four consecutive records, one record a lane; lanes beyond the last record repeat it.
///
/// # Panics
/// If `records` is empty.
#[inline(always)]
pub(super) fn load_records<P: Packet<Element = f64>>(records: &[[f64; 12]]) -> [P; 12] {
    let last = records.len() - 1;
    let mut numbers = [P::constant(0.0); 12];
    for block in 0..3 {
        let at = 4 * block;
        let mut rows = [
            P::load(&records[0][at..]),
            P::load(&records[last.min(1)][at..]),
            P::load(&records[last.min(2)][at..]),
            P::load(&records[last.min(3)][at..]),
        ];
        P::transpose(&mut rows);
        numbers[at..at + 4].copy_from_slice(&rows);
    }
    numbers
}
