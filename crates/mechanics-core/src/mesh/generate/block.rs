use super::check_counts;
use crate::mesh::error::MeshError;
use crate::mesh::points::check_positive;
use crate::mesh::{TetMesh, tet_volume};
use crate::tensor::Vec3;

/// How a hexahedral cell is cut into tetrahedra. Both are conforming for any number of cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BoxSplit {
    /// Six congruent tetrahedra around the diagonal from the cell's smallest to its largest corner (Kuhn 1960,
    /// Freudenthal 1942). Every cell is cut alike, so the mesh is periodic and refines into itself; but all
    /// diagonals point the same way, and so does a slight stiffness. The default, because convergence studies need
    /// meshes that are similar at every level.
    #[default]
    Six,
    /// A regular tetrahedron (in a cube) and four corners; neighbouring cells are mirror images. Fewer and better
    /// shaped cells, and no preferred diagonal over two cells; but a mesh with an odd number of cells has no
    /// mirror symmetry.
    Five,
}

/// The box between two corners \[m\] as a structured mesh of `cells[0] × cells[1] × cells[2]` cells, each cut into
/// tetrahedra. Point (i, j, k) has the index `i + (nx + 1) (j + (ny + 1) k)`.
///
/// # Errors
/// A corner that is not finite, `min` not below `max` in every coordinate, a count of zero, more cells than 32 bits
/// number.
pub fn block(min: &Vec3, max: &Vec3, cells: [u32; 3], split: BoxSplit) -> Result<TetMesh, MeshError> {
    check_counts("cells", &cells, 6)?;
    (max - min).iter().try_for_each(|&length| check_positive("side of the box", length))?;
    let [nx, ny, nz] = cells;
    let index = |[i, j, k]: [u32; 3]| i + (nx + 1) * (j + (ny + 1) * k);
    let coordinate = |d: usize, i: u32| {
        let t = f64::from(i) / f64::from(cells[d]);
        min[d] * (1.0 - t) + max[d] * t
    };
    let points = lattice([nx + 1, ny + 1, nz + 1])
        .map(|[i, j, k]| Vec3::new(coordinate(0, i), coordinate(1, j), coordinate(2, k)))
        .collect();
    let tets = lattice(cells)
        .flat_map(|cell| {
            cut(split, cell).iter().map(move |tet| {
                tet.map(|corner| index([0, 1, 2].map(|d| cell[d] + (u32::from(corner) >> d & 1))))
            })
        })
        .collect();
    TetMesh::new(points, tets)
}

/// All (i, j, k) below the counts, i fastest.
fn lattice([nx, ny, nz]: [u32; 3]) -> impl Iterator<Item = [u32; 3]> {
    (0..nz).flat_map(move |k| (0..ny).flat_map(move |j| (0..nx).map(move |i| [i, j, k])))
}

/// The tetrahedra of a cell by its corners, corner bits being the offsets in x, y, z.
fn cut(split: BoxSplit, cell: [u32; 3]) -> &'static [[u8; 4]] {
    // Each path 0 → 7 through the cube's edges is one tetrahedron; odd paths have two corners exchanged.
    const SIX: [[u8; 4]; 6] =
        [[0, 1, 3, 7], [0, 1, 7, 5], [0, 2, 7, 3], [0, 2, 6, 7], [0, 4, 5, 7], [0, 4, 7, 6]];
    // The regular tetrahedron on the corners of even bit count, and the four others around it.
    const EVEN: [[u8; 4]; 5] = [[0, 3, 6, 5], [1, 3, 0, 5], [2, 0, 3, 6], [4, 0, 6, 5], [7, 3, 5, 6]];
    // The mirror image: every corner bit in x flipped.
    const ODD: [[u8; 4]; 5] = [[1, 2, 4, 7], [0, 2, 4, 1], [3, 1, 7, 2], [5, 1, 4, 7], [6, 2, 7, 4]];
    match split {
        BoxSplit::Six => &SIX,
        BoxSplit::Five if cell.iter().fold(0, |parity, i| parity ^ (i & 1)) == 0 => &EVEN,
        BoxSplit::Five => &ODD,
    }
}

/// Exchanges two corners where needed so that the volume is positive.
pub(super) fn oriented(points: &[Vec3], mut tet: [u32; 4]) -> [u32; 4] {
    if tet_volume(&tet.map(|i| points[i as usize])) < 0.0 {
        tet.swap(2, 3);
    }
    tet
}
