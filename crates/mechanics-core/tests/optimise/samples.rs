//! Stencils, meshes and random numbers that the tests share.

use mechanics_core::projection::Projection;
use mechanics_core::stencil::{LocalHessian, Stencil};
use mechanics_core::tensor::{Mat3, Vec3};

/// Springs: ½ k (l − L)².
#[derive(Clone, Debug)]
pub(crate) struct Springs {
    pub(crate) stiffness: Vec<f64>,
    pub(crate) rest_length: Vec<f64>,
}

impl Stencil<2> for Springs {
    fn value(&self, e: usize, x: &[Vec3; 2]) -> f64 {
        0.5 * self.stiffness[e] * ((x[1] - x[0]).norm() - self.rest_length[e]).powi(2)
    }
    fn gradient(&self, e: usize, x: &[Vec3; 2]) -> [Vec3; 2] {
        let d = x[1] - x[0];
        let force = d * (self.stiffness[e] * (1.0 - self.rest_length[e] / d.norm()));
        [-force, force]
    }
    fn hessian(&self, e: usize, x: &[Vec3; 2], projection: Projection) -> LocalHessian<2> {
        let d = x[1] - x[0];
        let n = d / d.norm();
        let along = n * n.transpose();
        let across = projection.apply(1.0 - self.rest_length[e] / d.norm());
        let h = (along + (Mat3::identity() - along) * across) * self.stiffness[e];
        [[h, -h], [-h, h]]
    }
}

/// Tetrahedra that keep their volume, and their edges from growing: w (6V − v)² + ½ s Σ |edge|². Not a model of anything, but
/// smooth, with a Hessian that is full.
#[derive(Clone, Debug)]
pub(crate) struct Volumes {
    pub(crate) weight: f64,
    pub(crate) stiffness: f64,
    pub(crate) volume: Vec<f64>,
}

fn skew(v: &Vec3) -> Mat3 {
    v.cross_matrix()
}

impl Volumes {
    fn edges(x: &[Vec3; 4]) -> [Vec3; 3] {
        [x[1] - x[0], x[2] - x[0], x[3] - x[0]]
    }
    fn volume_gradient([a, b, c]: &[Vec3; 3]) -> [Vec3; 4] {
        let (ga, gb, gc) = (b.cross(c), c.cross(a), a.cross(b));
        [-(ga + gb + gc), ga, gb, gc]
    }
}

impl Stencil<4> for Volumes {
    fn value(&self, e: usize, x: &[Vec3; 4]) -> f64 {
        let [a, b, c] = Self::edges(x);
        let excess = a.dot(&b.cross(&c)) - self.volume[e];
        let edges = (0..4).flat_map(|i| (0..i).map(move |j| (i, j)));
        self.weight * excess * excess
            + 0.5 * self.stiffness * edges.map(|(i, j)| (x[i] - x[j]).norm_squared()).sum::<f64>()
    }
    fn gradient(&self, e: usize, x: &[Vec3; 4]) -> [Vec3; 4] {
        let edges = Self::edges(x);
        let excess = edges[0].dot(&edges[1].cross(&edges[2])) - self.volume[e];
        let g = Self::volume_gradient(&edges);
        let mean = x[0] + x[1] + x[2] + x[3];
        std::array::from_fn(|i| g[i] * (2.0 * self.weight * excess) + (x[i] * 4.0 - mean) * self.stiffness)
    }
    fn hessian(&self, e: usize, x: &[Vec3; 4], _: Projection) -> LocalHessian<4> {
        let edges = Self::edges(x);
        let excess = edges[0].dot(&edges[1].cross(&edges[2])) - self.volume[e];
        let g = Self::volume_gradient(&edges);
        let [a, b, c] = edges.map(|edge| skew(&edge));
        // ∂²(a · b × c): the block of points (1, 2) is −[c]×, of (1, 3) is [b]×, of (2, 3) is −[a]×.
        let o = Mat3::zeros();
        let mut second = [[o, o, o, o], [o, o, -c, b], [o, c, o, -a], [o, -b, a, o]];
        for i in 1..4 {
            second[i][0] = -(second[i][1] + second[i][2] + second[i][3]);
            second[0][i] = second[i][0].transpose();
        }
        second[0][0] = -(second[0][1] + second[0][2] + second[0][3]);
        std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let spring = if i == j { 3.0 } else { -1.0 } * self.stiffness;
                (g[i] * g[j].transpose() + second[i][j] * excess) * (2.0 * self.weight)
                    + Mat3::from_diagonal_element(spring)
            })
        })
    }
}

/// A small generator (Steele, Lea, Flood 2014: SplitMix64): the same numbers everywhere.
#[derive(Clone, Debug)]
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
    /// In [−1, 1).
    pub(crate) fn number(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }
    pub(crate) fn vector(&mut self) -> Vec3 {
        Vec3::new(self.number(), self.number(), self.number())
    }
    pub(crate) fn vectors(&mut self, n: usize) -> Vec<Vec3> {
        (0..n).map(|_| self.vector()).collect()
    }
    pub(crate) fn matrix(&mut self) -> Mat3 {
        Mat3::from_fn(|_, _| self.number())
    }
    /// `count` elements of distinct points below `points`, near each other.
    pub(crate) fn elements<const N: usize>(&mut self, count: usize, points: usize) -> Vec<[u32; N]> {
        (0..count)
            .map(|_| {
                let base = self.below(points);
                let mut element = [0; N];
                for i in 0..N {
                    element[i] = loop {
                        let point = ((base + self.below(4 * N)) % points) as u32;
                        if !element[..i].contains(&point) {
                            break point;
                        }
                    };
                }
                element
            })
            .collect()
    }
    /// Symmetric local Hessians.
    pub(crate) fn hessians<const N: usize>(&mut self, count: usize) -> Vec<LocalHessian<N>> {
        (0..count)
            .map(|_| {
                let mut h = [[Mat3::zeros(); N]; N];
                for i in 0..N {
                    for j in 0..=i {
                        let block = self.matrix();
                        let block = if i == j { block + block.transpose() } else { block };
                        (h[i][j], h[j][i]) = (block, block.transpose());
                    }
                }
                h
            })
            .collect()
    }
}

/// The points of a grid of n³ cells of size 1/n, slightly disturbed.
pub(crate) fn grid_points(n: usize) -> Vec<Vec3> {
    let mut random = Random(7);
    let at = |k: usize| k as f64 / n as f64;
    let points = (0..=n).flat_map(|i| (0..=n).flat_map(move |j| (0..=n).map(move |k| (i, j, k))));
    points.map(|(i, j, k)| Vec3::new(at(i), at(j), at(k)) + random.vector() * (0.05 / n as f64)).collect()
}

/// Six tetrahedra (Kuhn 1960) in each cell of that grid, of positive volume.
pub(crate) fn grid_tetrahedra(n: usize) -> Vec<[u32; 4]> {
    let at = |c: [usize; 3]| ((c[0] * (n + 1) + c[1]) * (n + 1) + c[2]) as u32;
    let orders = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
    let mut tetrahedra = Vec::with_capacity(6 * n * n * n);
    for cell in 0..n * n * n {
        let corner = [cell / (n * n), cell / n % n, cell % n];
        for (number, order) in orders.iter().enumerate() {
            let mut c = corner;
            let mut tetrahedron = [at(c); 4];
            for (i, &axis) in order.iter().enumerate() {
                c[axis] += 1;
                tetrahedron[i + 1] = at(c);
            }
            if number >= 3 {
                tetrahedron.swap(2, 3);
            }
            tetrahedra.push(tetrahedron);
        }
    }
    tetrahedra
}
