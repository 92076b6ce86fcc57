//! The density field.

use super::{CellGrid, Rules, Source};
use crate::error::SplatError;
use mechanics_core::decomposition::svd;
use mechanics_core::parallel;
use mechanics_core::tensor::{Mat3, Vec3};

/// A Gaussian in units of cells.
pub(super) struct Spread {
    /// Its cell, of the grid continued beyond its ends.
    place: [i64; 3],
    /// Its mean, relative to the smallest corner of its cell.
    mean: Vec3,
    /// A⁻¹.
    precision: Mat3,
    opacity: f64,
    /// How many cells it reaches beyond its own.
    reach: i64,
}

/// Means farther from the grid than this many cells reach nothing.
const FAR: f64 = 1e9;

/// Every Gaussian that reaches the grid, and those whose deviations were clamped.
pub(super) fn spreads(
    sources: &[Source],
    grid: &CellGrid,
    rules: &Rules,
) -> Result<(Vec<Spread>, Vec<u32>), SplatError> {
    let (mut spreads, mut clamped) = (Vec::with_capacity(sources.len()), Vec::new());
    for (point, source) in sources.iter().enumerate() {
        let numbers = source.mean.iter().chain(source.axes.iter()).chain([&source.opacity]);
        if let Some(&value) = numbers.into_iter().find(|x| !x.is_finite()) {
            return Err(SplatError::BadPoint { point, value });
        }
        let svd = svd(&(source.axes / grid.cell));
        let deviations = svd.sigma.map(|s| s.abs().clamp(rules.thinnest, rules.widest));
        if (0..3).any(|k| !(svd.sigma[k].abs() == deviations[k])) {
            clamped.push(point as u32);
        }
        let mean = (source.mean - grid.origin) / grid.cell;
        if mean.amax() >= FAR {
            continue;
        }
        let place = grid.place(&source.mean);
        let inverse = Mat3::from_diagonal(&Vec3::from(deviations.map(|s| s.powi(-2))));
        spreads.push(Spread {
            place,
            mean: mean - Vec3::from(place.map(|i| i as f64)),
            precision: svd.u * inverse * svd.u.transpose(),
            opacity: source.opacity,
            reach: deviations[0].max(deviations[1]).max(deviations[2]).ceil() as i64,
        });
    }
    Ok((spreads, clamped))
}

/// Planes of cells in one piece of parallel work.
const PLANES: usize = 4;

/// ρ of every cell. Cells add up Gaussians in their order, whatever the number of threads.
pub(super) fn field(spreads: &[Spread], grid: &CellGrid) -> Vec<f64> {
    let mut density = vec![0.0; grid.cells()];
    let plane = grid.counts[1] * grid.counts[2];
    parallel::for_each_chunk(&mut density, PLANES * plane, |first, part| {
        let planes = (first / plane) as i64..((first + part.len()) / plane) as i64;
        let mut corners = Vec::new();
        for spread in spreads {
            spread.add_to(&planes, grid, part, &mut corners);
        }
    });
    density
}

impl Spread {
    /// Adds to the cells of some planes what is within reach.
    fn add_to(
        &self,
        planes: &std::ops::Range<i64>,
        grid: &CellGrid,
        density: &mut [f64],
        corners: &mut Vec<f64>,
    ) {
        let low = self.place.map(|i| i - self.reach);
        let high = self.place.map(|i| i + self.reach + 1);
        let [xs, ys, zs] = [
            low[0].max(planes.start)..high[0].min(planes.end),
            low[1].max(0)..high[1].min(grid.counts[1] as i64),
            low[2].max(0)..high[2].min(grid.counts[2] as i64),
        ];
        if xs.is_empty() || ys.is_empty() || zs.is_empty() {
            return;
        }
        let (ny, nz) = ((ys.end - ys.start + 1) as usize, (zs.end - zs.start + 1) as usize);
        corners.clear();
        for i in xs.start..=xs.end {
            for j in ys.start..=ys.end {
                self.add_row(i, j, zs.start, nz, corners);
            }
        }
        for i in xs.clone() {
            for j in ys.clone() {
                let first = ((i - xs.start) as usize * ny + (j - ys.start) as usize) * nz;
                let rows = [first, first + nz, first + ny * nz, first + ny * nz + nz];
                let start = ((i - planes.start) as usize * grid.counts[1] + j as usize) * grid.counts[2];
                let cells = &mut density[start + zs.start as usize..start + zs.end as usize];
                for (k, cell) in cells.iter_mut().enumerate() {
                    let sum: f64 = rows.iter().map(|&row| corners[row + k] + corners[row + k + 1]).sum();
                    *cell += sum * (self.opacity / 8.0);
                }
            }
        }
    }

    /// exp(−½ dᵀ A⁻¹ d) at `count` corners (i, j, k), k = `start`, …
    ///
    /// Along the row the exponent is a quadratic polynomial of k: q(k) = ½ c k² + b k + a.
    fn add_row(&self, i: i64, j: i64, start: i64, count: usize, corners: &mut Vec<f64>) {
        let corner = Vec3::new((i - self.place[0]) as f64, (j - self.place[1]) as f64, 0.0);
        let d = corner - self.mean;
        let a = 0.5 * d.dot(&(self.precision * d));
        let b = (self.precision * d).z;
        let c = 0.5 * self.precision.m33;
        corners.extend((0..count as i64).map(|k| {
            let z = (start + k - self.place[2]) as f64;
            (-(c * z + b) * z - a).exp()
        }));
    }
}
