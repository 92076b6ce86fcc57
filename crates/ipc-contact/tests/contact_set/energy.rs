//! The sum of barriers over a contact set, written plainly: b(s) = −(s − ŝ)² ln(s/ŝ) of each pair, κ = 1.

use ipc_contact::contact_set::ContactSet;
use ipc_contact::distance::{EdgeEdgeMollifier, Region};
use mechanics_core::stencil::LocalHessian;
use mechanics_core::tensor::{Mat3, Vec3};
use std::collections::BTreeMap;

/// b, b′, b″.
pub(crate) fn barrier(s: f64, activation: f64) -> [f64; 3] {
    if s >= activation {
        return [0.0; 3];
    }
    let (u, logarithm) = (s - activation, (s / activation).ln());
    [-u * u * logarithm, -2.0 * u * logarithm - u * u / s, -2.0 * logarithm - 4.0 * u / s + u * u / (s * s)]
}

#[derive(Default)]
pub(crate) struct Sums {
    pub(crate) value: f64,
    pub(crate) gradient: BTreeMap<u32, Vec3>,
    pub(crate) hessian: BTreeMap<[u32; 2], Mat3>,
}

impl Sums {
    pub(crate) fn gradient_norm(&self) -> f64 {
        self.gradient.values().map(Vec3::norm_squared).sum::<f64>().sqrt()
    }

    pub(crate) fn hessian_norm(&self) -> f64 {
        self.hessian.values().map(Mat3::norm_squared).sum::<f64>().sqrt()
    }

    fn add<const N: usize>(&mut self, points: &[u32; N], x: &[Vec3; N], term: &Term) {
        let (value, gradient, hessian) = term.evaluate(x);
        self.value += value;
        for i in 0..N {
            *self.gradient.entry(points[i]).or_default() += gradient[i];
            for j in 0..N {
                *self.hessian.entry([points[i], points[j]]).or_default() += hessian[i][j];
            }
        }
    }
}

struct Term {
    weight: f64,
    activation: f64,
    region: Region,
    mollifier: EdgeEdgeMollifier,
}

const NO_MOLLIFIER: EdgeEdgeMollifier = EdgeEdgeMollifier { threshold: 0.0 };

impl Term {
    fn evaluate<const N: usize>(&self, x: &[Vec3; N]) -> (f64, [Vec3; N], LocalHessian<N>) {
        let [b, first, second] = barrier(self.region.value(x), self.activation).map(|b| b * self.weight);
        let (slope, curved) = (self.region.gradient(x), self.region.hessian(x));
        let four = |i: usize| x[i.min(N - 1)];
        let four = [four(0), four(1), four(2), four(3)];
        let is_mollified = N == 4 && self.mollifier.is_active(&four);
        if !is_mollified {
            let hessian = std::array::from_fn(|i| {
                std::array::from_fn(|j| curved[i][j] * first + slope[i] * slope[j].transpose() * second)
            });
            return (b, slope.map(|part| part * first), hessian);
        }
        let m = self.mollifier.value(&four);
        let (m_i, m_ij) = (self.mollifier.gradient(&four), self.mollifier.hessian(&four));
        let gradient = std::array::from_fn(|i| slope[i] * (m * first) + m_i[i] * b);
        let hessian = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                (curved[i][j] * first + slope[i] * slope[j].transpose() * second) * m
                    + (slope[i] * m_i[j].transpose() + m_i[i] * slope[j].transpose()) * first
                    + m_ij[i][j] * b
            })
        });
        (m * b, gradient, hessian)
    }
}

/// All pairs of triangle meshes; half-spaces are left out.
pub(crate) fn sums(set: &ContactSet, x: &[Vec3], activation: f64) -> Sums {
    let mut sums = Sums::default();
    let at = |p: u32| x[p as usize];
    let term = |weight: f64, region: Region| Term { weight, activation, region, mollifier: NO_MOLLIFIER };
    for (points, &weight) in set.point_points.points.iter().zip(&set.point_points.weights) {
        sums.add(points, &points.map(at), &term(weight, Region::PointPoint([0, 1])));
    }
    for (points, &weight) in set.point_edges.points.iter().zip(&set.point_edges.weights) {
        sums.add(points, &points.map(at), &term(weight, Region::PointEdge([0, 1, 2])));
    }
    for (points, &weight) in set.point_triangles.points.iter().zip(&set.point_triangles.weights) {
        sums.add(points, &points.map(at), &term(weight, Region::PointTriangle([0, 1, 2, 3])));
    }
    let edges = &set.edge_edges;
    for (k, points) in edges.points.iter().enumerate() {
        let term = Term {
            weight: edges.weights[k],
            activation,
            region: edges.regions[k],
            mollifier: edges.mollifiers[k],
        };
        sums.add(points, &points.map(at), &term);
    }
    sums
}
