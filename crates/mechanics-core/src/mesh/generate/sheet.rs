use super::check_counts;
use crate::mesh::TriMesh;
use crate::mesh::error::MeshError;
use crate::mesh::points::check_positive;
use crate::tensor::Vec3;

/// How the rectangles of a sheet are cut into triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Diagonals {
    /// All along (+x, +y). Shears more easily one way than the other.
    Rising,
    /// All along (+x, −y).
    Falling,
    /// In a chequerboard, so that diagonals meet in stars of eight ("union jack"). No preferred diagonal over two
    /// cells.
    #[default]
    Alternating,
    /// Both, with a point in the middle of each rectangle: four triangles. The most symmetric, at twice the cells.
    Crossed,
}

/// A flat rectangular sheet \[m\], 0 ≤ x ≤ `size[0]`, 0 ≤ y ≤ `size[1]`, z = 0, of `cells[0] × cells[1]` rectangles cut
/// into triangles with normals +z. Point (i, j) has the index `i + (nx + 1) j`; the midpoints of
/// [`Diagonals::Crossed`] follow after all of these.
///
/// # Errors
/// A size that is not positive and finite; a count of zero, or beyond what 32 bits number.
pub fn sheet(size: [f64; 2], cells: [u32; 2], diagonals: Diagonals) -> Result<TriMesh, MeshError> {
    height_field(size, cells, diagonals, |_, _| 0.0)
}

/// The graph z = `height`(x, y) over a rectangle \[m\], numbered and cut as [`sheet`].
///
/// # Errors
/// As [`sheet`]; and a height that is not finite.
pub fn height_field(
    size: [f64; 2],
    cells: [u32; 2],
    diagonals: Diagonals,
    height: impl Fn(f64, f64) -> f64,
) -> Result<TriMesh, MeshError> {
    size.iter().try_for_each(|&length| check_positive("size", length))?;
    check_counts("cells", &cells, 4)?;
    let [nx, ny] = cells;
    let coordinate = |d: usize, i: f64| size[d] * (i / f64::from(cells[d]));
    let point = |i: f64, j: f64| {
        let (x, y) = (coordinate(0, i), coordinate(1, j));
        Vec3::new(x, y, height(x, y))
    };
    let mut points: Vec<Vec3> =
        grid(nx + 1, ny + 1).map(|(i, j)| point(f64::from(i), f64::from(j))).collect();
    let first_midpoint = points.len() as u32;
    if diagonals == Diagonals::Crossed {
        points.extend(grid(nx, ny).map(|(i, j)| point(f64::from(i) + 0.5, f64::from(j) + 0.5)));
    }
    let mut triangles = Vec::new();
    for (i, j) in grid(nx, ny) {
        let a = i + (nx + 1) * j;
        let [b, c, d] = [a + 1, a + nx + 2, a + nx + 1];
        match (diagonals, (i + j) % 2) {
            (Diagonals::Crossed, _) => {
                let m = first_midpoint + i + nx * j;
                triangles.extend([[a, b, m], [b, c, m], [c, d, m], [d, a, m]]);
            }
            (Diagonals::Rising, _) | (Diagonals::Alternating, 0) => triangles.extend([[a, b, c], [a, c, d]]),
            _ => triangles.extend([[a, b, d], [b, c, d]]),
        }
    }
    TriMesh::new(points, triangles)
}

fn grid(nx: u32, ny: u32) -> impl Iterator<Item = (u32, u32)> {
    (0..ny).flat_map(move |j| (0..nx).map(move |i| (i, j)))
}
