//! Which places lie inside of a closed triangle mesh.

use mechanics_core::mesh::TriMesh;
use mechanics_core::parallel;
use mechanics_core::tensor::Vec3;
use std::f64::consts::PI;

/// Cells along the longest edge of the box around a mesh, at most.
const MOST_CELLS: f64 = 64.0;

/// Keeps the places inside.
///
/// The winding number is an integer away from the surface and changes only across it: cells of a coarse grid that no triangle's box
/// touches are inside or outside as a whole, and so are all such cells that hang together by faces. One winding number decides for
/// them; places in the other cells have their own.
pub(super) fn retain_inside(mesh: &TriMesh, places: Vec<[f64; 3]>) -> Vec<[f64; 3]> {
    let corners: Vec<[Vec3; 3]> = (0..mesh.triangles().len()).map(|t| mesh.corners(t)).collect();
    let Some(cells) = Cells::new(mesh, &corners) else { return Vec::new() };
    let mut kept = vec![false; places.len()];
    parallel::map_into(&mut kept, 256, |k| {
        let place = Vec3::from(places[k]);
        match cells.decided[cells.index_at(&place)] {
            Decision::Inside => true,
            Decision::Outside => false,
            Decision::Open => is_inside(&corners, &place),
        }
    });
    places.into_iter().zip(kept).filter(|(_, kept)| *kept).map(|(place, _)| place).collect()
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Decision {
    Inside,
    Outside,
    /// A triangle may pass through.
    Open,
}

struct Cells {
    low: Vec3,
    edge: f64,
    counts: [usize; 3],
    decided: Vec<Decision>,
}

impl Cells {
    fn new(mesh: &TriMesh, corners: &[[Vec3; 3]]) -> Option<Self> {
        let bounds = mesh.bounding_box()?;
        let size = bounds.size();
        let cells = (corners.len() as f64).sqrt().clamp(4.0, MOST_CELLS);
        let edge = size.max() / cells;
        let low = bounds.centre() - 0.5 * size;
        let counts = std::array::from_fn(|a| (size[a] / edge) as usize + 1);
        let count: usize = counts.iter().product();
        let mut cells = Self { low, edge, counts, decided: vec![Decision::Open; count] };
        let crossed = cells.crossed(corners);
        cells.decide(corners, &crossed);
        Some(cells)
    }

    fn coordinates_at(&self, place: &Vec3) -> [usize; 3] {
        std::array::from_fn(|a| {
            (((place[a] - self.low[a]) / self.edge).max(0.0) as usize).min(self.counts[a] - 1)
        })
    }

    fn index(&self, cell: [usize; 3]) -> usize {
        (cell[0] * self.counts[1] + cell[1]) * self.counts[2] + cell[2]
    }

    fn index_at(&self, place: &Vec3) -> usize {
        self.index(self.coordinates_at(place))
    }

    fn coordinates(&self, index: usize) -> [usize; 3] {
        let [_, m, n] = self.counts;
        [index / (m * n), index / n % m, index % n]
    }

    /// Cells that the box of a triangle touches, with a margin against rounding.
    fn crossed(&self, corners: &[[Vec3; 3]]) -> Vec<bool> {
        let mut crossed = vec![false; self.decided.len()];
        let margin = Vec3::repeat(1e-6 * self.edge);
        for [a, b, c] in corners {
            let low = self.coordinates_at(&(a.inf(b).inf(c) - margin));
            let high = self.coordinates_at(&(a.sup(b).sup(c) + margin));
            for i in low[0]..=high[0] {
                for j in low[1]..=high[1] {
                    let first = self.index([i, j, low[2]]);
                    crossed[first..=first + high[2] - low[2]].fill(true);
                }
            }
        }
        crossed
    }

    /// Decides for the cells that are not crossed, one winding number for all that hang together.
    fn decide(&mut self, corners: &[[Vec3; 3]], crossed: &[bool]) {
        let mut seen = crossed.to_vec();
        let mut stack = Vec::new();
        for start in 0..seen.len() {
            if seen[start] {
                continue;
            }
            let middle =
                Vec3::from_fn(|a, _| self.low[a] + (self.coordinates(start)[a] as f64 + 0.5) * self.edge);
            let decision = if is_inside(corners, &middle) { Decision::Inside } else { Decision::Outside };
            seen[start] = true;
            stack.push(start);
            while let Some(index) = stack.pop() {
                self.decided[index] = decision;
                let cell = self.coordinates(index);
                for axis in 0..3 {
                    for next in
                        [cell[axis].checked_sub(1), Some(cell[axis] + 1).filter(|c| *c < self.counts[axis])]
                    {
                        let Some(next) = next else { continue };
                        let mut near = cell;
                        near[axis] = next;
                        let near = self.index(near);
                        if !seen[near] {
                            seen[near] = true;
                            stack.push(near);
                        }
                    }
                }
            }
        }
    }
}

/// Whether the winding number is above ½ in size.
fn is_inside(corners: &[[Vec3; 3]], place: &Vec3) -> bool {
    winding_number(corners.iter(), place).abs() > 0.5
}

/// Around how many of the triangles' surfaces a place lies: solid angles over 4π, positive within one whose normals point outward.
pub(crate) fn winding_number<'a>(corners: impl Iterator<Item = &'a [Vec3; 3]>, place: &Vec3) -> f64 {
    corners.map(|triangle| solid_angle(triangle, place)).sum::<f64>() / (4.0 * PI)
}

/// Ω of a triangle, seen from a place: tan(Ω/2) = a·(b × c)/(abc + (a·b)c + (b·c)a + (c·a)b).
///
/// # Reference
/// A. van Oosterom, J. Strackee, *The solid angle of a plane triangle*, IEEE Trans. Biomed. Eng. 30(2), 1983, equation 8.
fn solid_angle(triangle: &[Vec3; 3], place: &Vec3) -> f64 {
    let [a, b, c] = triangle.map(|corner| corner - place);
    let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
    let below = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
    2.0 * a.dot(&b.cross(&c)).atan2(below)
}
