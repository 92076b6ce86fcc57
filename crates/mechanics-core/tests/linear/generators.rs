//! Matrices for the tests and the bench of the linear solvers.
#![allow(dead_code, unreachable_pub)]

use mechanics_core::sparse::{BlockMatrix, BlockPattern};
use mechanics_core::tensor::{Mat3, Vec3};
use std::sync::Arc;

/// SplitMix64 (Steele, Lea, Flood 2014): small, and the same everywhere.
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [-1, 1).
    pub fn signed(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// Uniform in 0..bound.
    pub fn below(&mut self, bound: usize) -> usize {
        (self.bits() % bound as u64) as usize
    }

    pub fn vec3(&mut self) -> Vec3 {
        Vec3::new(self.signed(), self.signed(), self.signed())
    }

    pub fn vector(&mut self, size: usize) -> Vec<f64> {
        (0..size).map(|_| self.signed()).collect()
    }

    pub fn permutation(&mut self, size: usize) -> Vec<usize> {
        let mut order: Vec<usize> = (0..size).collect();
        for k in (1..size).rev() {
            order.swap(k, self.below(k + 1));
        }
        order
    }
}

/// Blocks (row, column, value) with row ≥ column, summed into a matrix.
#[derive(Clone)]
pub struct Triplets {
    pub columns: usize,
    pub blocks: Vec<(usize, usize, Mat3)>,
}

impl Triplets {
    pub fn new(columns: usize) -> Self {
        let blocks = (0..columns).map(|k| (k, k, Mat3::zeros())).collect();
        Self { columns, blocks }
    }

    /// Adds `block` at (row, column) and, off the diagonal, its transpose at (column, row).
    pub fn add(&mut self, row: usize, column: usize, block: Mat3) {
        if row >= column {
            self.blocks.push((row, column, block));
        } else {
            self.blocks.push((column, row, block.transpose()));
        }
    }

    /// The same matrix with node k renamed `new[k]`.
    pub fn renamed(&self, new: &[usize]) -> Self {
        let mut renamed = Self { columns: self.columns, blocks: Vec::new() };
        for &(row, column, block) in &self.blocks {
            renamed.add(new[row], new[column], block);
        }
        renamed
    }

    pub fn matrix(&self) -> BlockMatrix {
        let mut sorted: Vec<usize> = (0..self.blocks.len()).collect();
        sorted.sort_by_key(|&k| (self.blocks[k].1, self.blocks[k].0));
        let mut start = vec![0; self.columns + 1];
        let mut rows: Vec<u32> = Vec::new();
        let mut values: Vec<Mat3> = Vec::new();
        let mut last = None;
        for k in sorted {
            let (row, column, block) = self.blocks[k];
            if last == Some((row, column)) {
                *values.last_mut().unwrap() += block;
            } else {
                rows.push(row as u32);
                values.push(block);
                start[column + 1] += 1;
                last = Some((row, column));
            }
        }
        for column in 0..self.columns {
            start[column + 1] += start[column];
        }
        BlockMatrix::from_blocks(Arc::new(BlockPattern::new(start, rows).unwrap()), values)
    }
}

/// A box of nx × ny × nz nodes, six tetrahedra a cell, linear elasticity with ν = 0.4 plus lumped mass.
#[derive(Clone, Copy, Debug)]
pub struct ElasticBox {
    pub nodes: [usize; 3],
    /// Young's modulus over density times the square of time step over node distance: 400 is a soft solid of a
    /// thousand cells at a hundredth of a second.
    pub stiffness: f64,
}

impl ElasticBox {
    pub fn cube(n: usize) -> Self {
        Self { nodes: [n, n, n], stiffness: 400.0 }
    }

    pub fn mat(n: usize) -> Self {
        Self { nodes: [n, n, 2], stiffness: 400.0 }
    }

    pub fn node(&self, i: usize, j: usize, k: usize) -> usize {
        (k * self.nodes[1] + j) * self.nodes[0] + i
    }

    pub fn count(&self) -> usize {
        self.nodes.iter().product()
    }

    pub fn triplets(&self) -> Triplets {
        let mut triplets = Triplets::new(self.count());
        let orders = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
        let elements: Vec<[[Mat3; 4]; 4]> = orders.iter().map(|axes| element(axes, self.stiffness)).collect();
        let [nx, ny, nz] = self.nodes;
        for k in 0..nz - 1 {
            for j in 0..ny - 1 {
                for i in 0..nx - 1 {
                    for (axes, element) in orders.iter().zip(&elements) {
                        let mut at = [i, j, k];
                        let mut corners = [self.node(i, j, k); 4];
                        for (corner, &axis) in corners[1..].iter_mut().zip(axes) {
                            at[axis] += 1;
                            *corner = self.node(at[0], at[1], at[2]);
                        }
                        add_element(&mut triplets, &corners, element);
                    }
                }
            }
        }
        triplets
    }

    /// Rank-one springs k g gᵀ between a node of the top face and a triangle of it a few cells away.
    pub fn add_contacts(&self, triplets: &mut Triplets, count: usize, stiffness: f64, random: &mut Random) {
        let [nx, ny, nz] = self.nodes;
        for _ in 0..count {
            let (i, j) = (random.below(nx - 1), random.below(ny - 1));
            let near = |k: usize, n: usize, random: &mut Random| (k + 1 + random.below(4)).min(n - 1);
            let (p, q) = (near(i, nx, random), near(j, ny, random));
            let k = nz - 1;
            let corners =
                [self.node(p, q, k), self.node(i, j, k), self.node(i + 1, j, k), self.node(i, j + 1, k)];
            if corners[1..].contains(&corners[0]) {
                continue;
            }
            let weights = [1.0, -0.5, -0.3, -0.2];
            let normal = (random.vec3() * 0.2 + Vec3::z()).normalize();
            let spring = normal * normal.transpose() * stiffness;
            for a in 0..4 {
                for b in 0..=a {
                    triplets.add(corners[a], corners[b], spring * (weights[a] * weights[b]));
                }
            }
        }
    }
}

/// The stiffness of the tetrahedron 0, e_a, e_a + e_b, e_a + e_b + e_c plus its lumped mass.
fn element(axes: &[usize; 3], stiffness: f64) -> [[Mat3; 4]; 4] {
    let mut corners = [Vec3::zeros(); 4];
    for k in 0..3 {
        corners[k + 1] = corners[k];
        corners[k + 1][axes[k]] += 1.0;
    }
    let edges = Mat3::from_columns(&[corners[1], corners[2], corners[3]]);
    let volume = edges.determinant().abs() / 6.0;
    let inverse = edges.try_inverse().unwrap();
    let mut g = [Vec3::zeros(); 4];
    for k in 0..3 {
        g[k + 1] = inverse.row(k).transpose();
        g[0] -= g[k + 1];
    }
    let nu = 0.4;
    let mu = stiffness / (2.0 * (1.0 + nu));
    let lambda = stiffness * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
    std::array::from_fn(|a| {
        std::array::from_fn(|b| {
            let mass = if a == b { volume / 4.0 } else { 0.0 };
            (g[a] * g[b].transpose() * lambda
                + g[b] * g[a].transpose() * mu
                + Mat3::identity() * (mu * g[a].dot(&g[b])))
                * volume
                + Mat3::identity() * mass
        })
    })
}

fn add_element(triplets: &mut Triplets, corners: &[usize; 4], element: &[[Mat3; 4]; 4]) {
    for a in 0..4 {
        for b in 0..=a {
            triplets.add(corners[a], corners[b], element[a][b]);
        }
    }
}

/// A random sparse symmetric matrix, positive definite by diagonal dominance over `links` random links a node.
pub fn random_matrix(columns: usize, links: usize, random: &mut Random) -> Triplets {
    let mut triplets = Triplets::new(columns);
    for row in 0..columns {
        for _ in 0..links {
            let column = random.below(columns);
            if column == row {
                continue;
            }
            let block = Mat3::from_fn(|_, _| random.signed());
            let bound = Mat3::identity() * block.norm();
            triplets.add(row, column, block);
            triplets.add(row, row, bound);
            triplets.add(column, column, bound);
        }
        let half = Mat3::from_fn(|_, _| random.signed());
        triplets.add(row, row, half * half.transpose() + Mat3::identity() * 0.1);
    }
    triplets
}

/// ‖b − A x‖ / ‖b‖ with the dense copy's arithmetic.
pub fn product(matrix: &BlockMatrix, x: &[f64]) -> Vec<f64> {
    let blocks: Vec<Vec3> = x.chunks_exact(3).map(Vec3::from_column_slice).collect();
    let mut y = vec![Vec3::zeros(); blocks.len()];
    matrix.multiply_into(&blocks, &mut y);
    y.iter().flat_map(|v| [v.x, v.y, v.z]).collect()
}

pub fn dense(matrix: &BlockMatrix) -> nalgebra::DMatrix<f64> {
    let n = matrix.dimension();
    let mut dense = nalgebra::DMatrix::zeros(n, n);
    let pattern = matrix.pattern();
    for column in 0..pattern.columns() {
        for slot in pattern.column(column) {
            let row = pattern.rows()[slot] as usize;
            for i in 0..3 {
                for j in 0..3 {
                    let entry = matrix.blocks()[slot][(i, j)];
                    dense[(3 * row + i, 3 * column + j)] = entry;
                    dense[(3 * column + j, 3 * row + i)] = entry;
                }
            }
        }
    }
    dense
}

pub fn relative_error(x: &[f64], reference: &[f64]) -> f64 {
    let norm = |v: &mut dyn Iterator<Item = f64>| v.map(f64::abs).fold(0.0, f64::max);
    norm(&mut x.iter().zip(reference).map(|(a, b)| a - b)) / norm(&mut reference.iter().copied())
}
