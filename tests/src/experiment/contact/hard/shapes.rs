//! Bodies and obstacles with spikes, edges and grooves.

use mechanics_core::mesh::{MeshError, TetMesh, TriMesh};
use mechanics_core::tensor::Vec3;

/// A pyramid with its apex at the origin and a square base at the height `height`, which may be negative.
pub(in crate::experiment) fn pyramid(half_width: f64, height: f64, cells: u32) -> Result<TetMesh, MeshError> {
    let n = cells;
    let mut points = vec![Vec3::zeros()];
    let side = |i: u32| half_width * (2.0 * f64::from(i) / f64::from(n) - 1.0);
    points.extend((0..=n).flat_map(|j| (0..=n).map(move |i| Vec3::new(side(i), side(j), height))));
    let index = |i: u32, j: u32| 1 + i + (n + 1) * j;
    let mut cells = Vec::new();
    for (i, j) in (0..n).flat_map(|j| (0..n).map(move |i| (i, j))) {
        let [a, b, c, d] = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
        cells.extend([[0, a, b, c], [0, a, c, d]]);
    }
    oriented(points, cells)
}

/// A profile of triangles in the xz plane, drawn out along y from −`half_width` to `half_width`.
pub(in crate::experiment) fn prism(
    profile: &[[f64; 2]],
    triangles: &[[u32; 3]],
    half_width: f64,
    layers: u32,
) -> Result<TetMesh, MeshError> {
    let count = profile.len() as u32;
    let y = |k: u32| half_width * (2.0 * f64::from(k) / f64::from(layers) - 1.0);
    let points =
        (0..=layers).flat_map(|k| profile.iter().map(move |[x, z]| Vec3::new(*x, y(k), *z))).collect();
    let mut cells = Vec::new();
    for layer in 0..layers {
        for triangle in triangles {
            // Freudenthal's split of a prism: it conforms if every triangle's corners come in ascending order.
            let mut corners = *triangle;
            corners.sort_unstable();
            let [a, b, c] = corners.map(|p| p + layer * count);
            let [d, e, f] = [a, b, c].map(|p| p + count);
            cells.extend([[a, b, c, f], [a, b, e, f], [a, d, e, f]]);
        }
    }
    oriented(points, cells)
}

/// A strip of triangles with the profile of a polyline in the xz plane, drawn out along y; the normals of a profile that goes
/// along +x point up.
pub(in crate::experiment) fn drawn_out(
    profile: &[[f64; 2]],
    half_width: f64,
    layers: u32,
) -> Result<TriMesh, MeshError> {
    let count = profile.len() as u32;
    let y = |k: u32| half_width * (2.0 * f64::from(k) / f64::from(layers) - 1.0);
    let points =
        (0..=layers).flat_map(|k| profile.iter().map(move |[x, z]| Vec3::new(*x, y(k), *z))).collect();
    let mut triangles = Vec::new();
    for (i, k) in (0..layers).flat_map(|k| (0..count - 1).map(move |i| (i, k))) {
        let a = i + count * k;
        let [b, c, d] = [a + 1, a + 1 + count, a + count];
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    TriMesh::new(points, triangles)
}

/// A floor at z = 0 with a pyramidal pit whose lowest point is `depth` below it.
pub(in crate::experiment) fn pit(half_width: f64, depth: f64, outer: f64) -> Result<TriMesh, MeshError> {
    let corner = |h: f64, k: usize| {
        let [x, y] = [[-h, -h], [h, -h], [h, h], [-h, h]][k];
        Vec3::new(x, y, 0.0)
    };
    let mut points = vec![Vec3::new(0.0, 0.0, -depth)];
    points.extend((0..4).map(|k| corner(half_width, k)));
    points.extend((0..4).map(|k| corner(outer, k)));
    let mut triangles = Vec::new();
    for k in 0..4 {
        let next = (k + 1) % 4;
        let [inner, inner_next, rim, rim_next] = [1 + k, 1 + next, 5 + k, 5 + next];
        triangles.extend([[0, inner, inner_next], [inner, rim, rim_next], [inner, rim_next, inner_next]]);
    }
    TriMesh::new(points, triangles)
}

/// A surface of revolution about the z axis: radius and height of each ring of points, from bottom to top.
pub(in crate::experiment) fn revolved(profile: &[[f64; 2]], around: u32) -> Result<TriMesh, MeshError> {
    let angle = |k: u32| std::f64::consts::TAU * f64::from(k) / f64::from(around);
    let ring =
        |[r, z]: [f64; 2]| (0..around).map(move |k| Vec3::new(r * angle(k).cos(), r * angle(k).sin(), z));
    let points = profile.iter().flat_map(|&at| ring(at)).collect();
    let mut triangles = Vec::new();
    for i in 0..profile.len() as u32 - 1 {
        for k in 0..around {
            let next = (k + 1) % around;
            let [a, b] = [k, next].map(|k| k + around * i);
            let [c, d] = [b, a].map(|p| p + around);
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    TriMesh::new(points, triangles)
}

fn oriented(points: Vec<Vec3>, cells: Vec<[u32; 4]>) -> Result<TetMesh, MeshError> {
    let mut mesh = TetMesh::new(points, cells)?;
    mesh.orient();
    Ok(mesh)
}

/// A ring about the z axis with a square section of side 2 `half`; point 4 k + c is corner c of section k.
pub(in crate::experiment) fn ring(radius: f64, half: f64, around: u32) -> Result<TetMesh, MeshError> {
    let angle = |k: u32| std::f64::consts::TAU * (f64::from(k) + 0.5) / f64::from(around);
    let corners = [[-half, -half], [half, -half], [half, half], [-half, half]];
    let section = |k: u32| {
        let place = move |[r, z]: [f64; 2]| {
            Vec3::new((radius + r) * angle(k).cos(), (radius + r) * angle(k).sin(), z)
        };
        corners.map(place)
    };
    let points = (0..around).flat_map(section).collect();
    let mut cells = Vec::new();
    for k in 0..around {
        let next = (k + 1) % around;
        for triangle in [[0, 1, 2], [0, 2, 3]] {
            let [a, b, c] = triangle.map(|p| p + 4 * k);
            let [d, e, f] = triangle.map(|p| p + 4 * next);
            cells.extend([[a, b, c, f], [a, b, e, f], [a, d, e, f]]);
        }
    }
    oriented(points, cells)
}
