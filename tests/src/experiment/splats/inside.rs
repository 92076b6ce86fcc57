//! Which cells of a grid have their centres inside of a closed mesh.

use gaussian_deform::fill::CellGrid;
use mechanics_core::mesh::TriMesh;
use mechanics_core::tensor::Vec3;

/// By cell, whether its centre is inside: along the line of centres of every row of cells in z, places below an odd number of triangles.
///
/// Lines are moved by 1e-7 and 2e-7 cells so that none meets an edge of a mesh that was made with some symmetry.
pub(super) fn inside(mesh: &TriMesh, grid: &CellGrid) -> Vec<bool> {
    let [nx, ny, nz] = grid.counts;
    let (centre_x, centre_y) = (0.5 + 1e-7, 0.5 + 2e-7);
    let mut crossings = vec![Vec::new(); nx * ny];
    for triangle in 0..mesh.triangles().len() {
        // In cells.
        let corners = mesh.corners(triangle).map(|x| (x - grid.origin) / grid.cell);
        let rows = |axis: usize, count: usize, centre: f64| {
            let ends = corners.iter().map(|x| x[axis] - centre);
            let (low, high) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
            let end = |x: f64| x.clamp(0.0, count as f64) as usize;
            end(low.ceil())..end(high.floor() + 1.0)
        };
        for i in rows(0, nx, centre_x) {
            for j in rows(1, ny, centre_y) {
                let line = [i as f64 + centre_x, j as f64 + centre_y];
                crossings[i * ny + j].extend(height(&corners, line));
            }
        }
    }
    let mut inside = vec![false; grid.cells()];
    for (line, mut heights) in crossings.into_iter().enumerate() {
        heights.sort_by(f64::total_cmp);
        for k in 0..nz {
            let below = heights.partition_point(|&height| height < k as f64 + 0.5);
            inside[line * nz + k] = below % 2 == 1;
        }
    }
    inside
}

/// Where the line (x, y) along z meets a triangle, if it does.
fn height([a, b, c]: &[Vec3; 3], [x, y]: [f64; 2]) -> Option<f64> {
    let area = |p: &Vec3, q: &Vec3| (p.x - x) * (q.y - y) - (p.y - y) * (q.x - x);
    let (u, v, w) = (area(b, c), area(c, a), area(a, b));
    let one_side = (u > 0.0 && v > 0.0 && w > 0.0) || (u < 0.0 && v < 0.0 && w < 0.0);
    one_side.then(|| (u * a.z + v * b.z + w * c.z) / (u + v + w))
}

#[cfg(test)]
mod tests {
    use super::*;
    use mechanics_core::mesh::torus;

    /// A torus in closed form, but for cells nearer to it than its facets are.
    #[test]
    fn the_inside_of_a_torus_is_known() {
        let mesh = torus(0.36, 0.16, 96, 48).unwrap();
        let grid = CellGrid { origin: Vec3::repeat(-0.6), cell: 0.03, counts: [40; 3] };
        let found = inside(&mesh, &grid);
        let mut counted = 0;
        for (cell, &found) in found.iter().enumerate() {
            let x = grid.origin + Vec3::from(grid.indices(cell).map(|i| i as f64 + 0.5)) * grid.cell;
            let depth = 0.16 - (x.x.hypot(x.y) - 0.36).hypot(x.z);
            if depth.abs() > 2e-3 {
                counted += 1;
                assert_eq!(found, depth > 0.0, "{x}");
            }
        }
        assert!(counted > 60_000);
    }
}
