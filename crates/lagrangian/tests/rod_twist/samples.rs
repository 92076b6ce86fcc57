//! Random rods, and the matrices of terms.

use lagrangian::element::rod::{RodTwist, TwistSection};
use mechanics_core::mesh::{PolylineEnds, TriMesh, polyline};
use mechanics_core::point_map::PointMap;
use mechanics_core::potential::Potential;
use mechanics_core::projection::Projection;
use mechanics_core::sparse::{Assembly, BlockMatrix};
use mechanics_core::tensor::Vec3;
use nalgebra::DMatrix;

/// SplitMix64 (Steele, Lea, Flood 2014).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// In [−1, 1).
    pub(crate) fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        (z >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    pub(crate) fn vector(&mut self) -> Vec3 {
        Vec3::new(self.number(), self.number(), self.number())
    }
}

pub(crate) const SECTION: TwistSection = TwistSection { torsional: 0.7, gyration_radius: 0.2 };

/// A crooked open or closed line of `n` points.
pub(crate) fn crooked(random: &mut Random, n: u32, ends: PolylineEnds) -> TriMesh {
    let around = |i: u32| {
        let angle = std::f64::consts::TAU * f64::from(i) / f64::from(n);
        Vec3::new(angle.cos(), angle.sin(), 0.0)
    };
    let points = (0..n).map(|i| around(i) + random.vector() * 0.25).collect();
    polyline(points, ends).unwrap()
}

/// The twist of `mesh`, and its points with all turns at zero behind them.
pub(crate) fn twist(mesh: &TriMesh, section: TwistSection) -> (RodTwist, Vec<Vec3>) {
    let points = mesh.points().len();
    let twist = RodTwist::new("twist", mesh, section, points as u32).unwrap();
    let mut x = mesh.points().to_vec();
    x.resize(points + mesh.free_edges().len(), Vec3::zeros());
    (twist, x)
}

/// The true Hessian of the terms' sum by the points that are not `fixed`.
pub(crate) fn hessian(terms: &[&dyn Potential], x: &[Vec3], fixed: &[u32]) -> DMatrix<f64> {
    let held: Vec<(u32, Vec3)> = fixed.iter().map(|&i| (i, x[i as usize])).collect();
    let map = PointMap::with_fixed(x.len(), &held).unwrap();
    let mut assembly = Assembly::new(&map);
    let mut assembler = assembly.begin(&map);
    for (k, term) in terms.iter().enumerate() {
        assembler.begin_term(k);
        term.add_hessian(x, Projection::None, &mut assembler);
    }
    dense(assembler.finish(), map.unknowns())
}

/// A block matrix written out.
pub(crate) fn dense(matrix: &BlockMatrix, unknowns: usize) -> DMatrix<f64> {
    let entry = |row: usize, column: usize| {
        let (r, c) = (row.max(column), row.min(column));
        matrix.pattern().slot(r / 3, c / 3).map_or(0.0, |slot| matrix.blocks()[slot][(r % 3, c % 3)])
    };
    DMatrix::from_fn(3 * unknowns, 3 * unknowns, entry)
}

pub(crate) fn gradient(term: &dyn Potential, x: &[Vec3]) -> Vec<Vec3> {
    let mut gradient = vec![Vec3::zeros(); x.len()];
    term.add_gradient(x, &mut gradient);
    gradient
}

/// log₂ of the ratios of successive errors on meshes of halved size.
pub(crate) fn orders(errors: &[f64]) -> Vec<f64> {
    errors.windows(2).map(|pair| (pair[0] / pair[1]).abs().log2()).collect()
}
