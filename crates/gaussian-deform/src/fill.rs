//! Filling: a captured surface becomes a body.
//!
//! A scene is trained from pictures, so its Gaussians lie on surfaces, and what is behind them is empty. Filling finds the inside on a grid of cubic cells and
//! puts particles there. They are simulated, and not drawn.
//!
//! 1. **Density.** ρ of a cell is Σ α exp(−½ (c − μ)ᵀ A⁻¹ (c − μ)), averaged over its eight corners c, over the Gaussians whose cell is within ⌈σ/h⌉ cells, σ the largest
//!    standard deviation and h the length of a cell.
//! 2. **Dense cells**, ρ > the density threshold, are topped up to a number of particles.
//! 3. **Inside** is a cell without particles that (a) along the axes, in all six directions but those excluded, sees a cell with ρ > the search threshold, and (b) whose rays enter such cells an odd
//!    number of times ([`Parity`]). Holes in the surface (the bottom of a scene that stood on a table) are passed over by excluding a direction.
//! 4. **Volumes.** A particle's volume is h³ over the number of particles in its cell.
//!
//! Rays read densities and not particles, so that the answer does not depend on the order of cells; directions are swept once for all cells, six times the number of cells
//! in all. New particles lie where the cell's and their own number put them, without a random generator.
//!
//! # Bounded work
//! A nearly flat Gaussian has an A⁻¹ without bounds, a huge one reaches every cell. Standard deviations are taken as at least
//! [`Rules::thinnest`] and at most [`Rules::widest`] cells; [`Filled::clamped`] lists whose were not. So a Gaussian costs at most (2 widest + 2)³ exponentials.
//!
//! # Reference
//! Xie et al. (2024), *PhysGaussian*, section 3.7; the two tests of step 3 are its two conditions. Thresholds of particles and cells as in the code published with it.

mod density;
mod rays;

use crate::error::SplatError;
use mechanics_core::tensor::{Mat3, Vec3};

/// A direction along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// +x.
    PlusX,
    /// −x.
    MinusX,
    /// +y.
    PlusY,
    /// −y.
    MinusY,
    /// +z.
    PlusZ,
    /// −z.
    MinusZ,
}

impl Direction {
    /// All six.
    pub const ALL: [Self; 6] =
        [Self::PlusX, Self::MinusX, Self::PlusY, Self::MinusY, Self::PlusZ, Self::MinusZ];
}

/// Cells: those of index (i, j, k) fill the box from origin + h (i, j, k) to origin + h (i + 1, j + 1, k + 1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellGrid {
    /// The smallest corner \[m\].
    pub origin: Vec3,
    /// h \[m\].
    pub cell: f64,
    /// Cells along each axis.
    pub counts: [usize; 3],
}

/// The most cells of a grid: 512³.
pub const MOST_CELLS: usize = 1 << 27;

impl CellGrid {
    /// The number of cells.
    pub fn cells(&self) -> usize {
        self.counts.iter().product()
    }

    /// The cell of a point; `None` outside.
    pub fn cell_of(&self, x: &Vec3) -> Option<usize> {
        let place = self.place(x);
        let inside = (0..3).all(|k| place[k] >= 0 && (place[k] as usize) < self.counts[k]);
        inside.then(|| {
            (place[0] as usize * self.counts[1] + place[1] as usize) * self.counts[2] + place[2] as usize
        })
    }

    /// The indices (i, j, k) of cell number `cell`.
    pub fn indices(&self, cell: usize) -> [usize; 3] {
        let [_, b, c] = self.counts;
        [cell / (b * c), cell / c % b, cell % c]
    }

    /// Indices of a point's cell, of the grid continued beyond its ends.
    fn place(&self, x: &Vec3) -> [i64; 3] {
        [0, 1, 2].map(|k| ((x[k] - self.origin[k]) / self.cell).floor() as i64)
    }

    fn check(&self) -> Result<(), SplatError> {
        let total = self.counts.iter().try_fold(1_usize, |n, &c| n.checked_mul(c)).unwrap_or(usize::MAX);
        let valid = self.cell > 0.0 && self.cell.is_finite() && self.origin.iter().all(|x| x.is_finite());
        if valid && (1..=MOST_CELLS).contains(&total) {
            return Ok(());
        }
        Err(SplatError::BadGrid { cell: self.cell, counts: self.counts, most: MOST_CELLS })
    }
}

/// Along which rays the number of surfaces that are entered must be odd.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parity {
    /// Along none.
    Unchecked,
    /// Along one: the published rule. A ray that grazes the surface enters it twice, and its cells stay empty.
    Along(Direction),
    /// Along four of the six at least. Rays graze a surface where they are nearly tangent to it, which few directions are at once.
    Majority,
}

/// What makes a cell dense, and inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rules {
    /// Denser cells are topped up.
    pub density_threshold: f64,
    /// A cell must see denser ones around it to be inside.
    pub search_threshold: f64,
    /// Particles of a full cell.
    pub particles_per_cell: u32,
    /// In this direction nothing need be seen.
    pub excluded: Option<Direction>,
    /// Where an odd number of surfaces must be entered.
    pub parity: Parity,
    /// The smallest standard deviation taken, in cells.
    pub thinnest: f64,
    /// The largest standard deviation taken, in cells.
    pub widest: f64,
}

impl Default for Rules {
    /// Thresholds 1.2 and 0.6, two particles a cell, no direction excluded, parity of the majority, deviations from 1/1000 to 8 cells.
    fn default() -> Self {
        Self {
            density_threshold: 1.2,
            search_threshold: 0.6,
            particles_per_cell: 2,
            excluded: None,
            parity: Parity::Majority,
            thinnest: 1e-3,
            widest: 8.0,
        }
    }
}

/// A Gaussian as filling sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Source {
    /// μ \[m\].
    pub mean: Vec3,
    /// B \[m\].
    pub axes: Mat3,
    /// α.
    pub opacity: f64,
}

/// A filled body.
#[derive(Clone, Debug, PartialEq)]
pub struct Filled {
    /// The new particles, cell by cell \[m\].
    pub positions: Vec<Vec3>,
    /// Volumes \[m³\]: of the Gaussians given (zero outside of the grid), then of the new particles.
    pub volumes: Vec<f64>,
    /// ρ, by cell.
    pub density: Vec<f64>,
    /// Dense cells that were topped up, ascending.
    pub topped_up: Vec<u32>,
    /// Inner cells that were filled, ascending.
    pub inner: Vec<u32>,
    /// Gaussians whose standard deviations were clamped, ascending.
    pub clamped: Vec<u32>,
    /// Gaussians outside of the grid, ascending; they count for nothing.
    pub outside: Vec<u32>,
}

/// Fills the body whose surface the Gaussians are.
///
/// # Errors
/// [`SplatError::BadGrid`]; [`SplatError::BadPoint`] for a Gaussian that is not finite.
///
/// # Panics
/// If `thinnest` is not positive, or `widest` smaller, or above 64.
pub fn fill(sources: &[Source], grid: &CellGrid, rules: &Rules) -> Result<Filled, SplatError> {
    let range = rules.thinnest > 0.0 && rules.thinnest <= rules.widest && rules.widest <= 64.0;
    assert!(range, "standard deviations are clamped to a range of positive numbers up to 64 cells");
    grid.check()?;
    let (spreads, clamped) = density::spreads(sources, grid, rules)?;
    let density = density::field(&spreads, grid);
    let mut occupancy = vec![0_u32; grid.cells()];
    let mut outside = Vec::new();
    for (i, source) in sources.iter().enumerate() {
        match grid.cell_of(&source.mean) {
            Some(cell) => occupancy[cell] = occupancy[cell].saturating_add(1),
            None => outside.push(i as u32),
        }
    }
    let mut new = vec![0_u32; grid.cells()];
    let mut topped_up = Vec::new();
    for cell in 0..grid.cells() {
        if density[cell] > rules.density_threshold && occupancy[cell] < rules.particles_per_cell {
            new[cell] = rules.particles_per_cell - occupancy[cell];
            topped_up.push(cell as u32);
        }
    }
    let occupied: Vec<bool> = (0..grid.cells()).map(|c| occupancy[c] + new[c] > 0).collect();
    let inner = rays::inner_cells(&density, &occupied, grid, rules);
    inner.iter().for_each(|&cell| new[cell as usize] = rules.particles_per_cell);
    let positions = new_positions(grid, &new);
    let cell_volume = grid.cell.powi(3);
    let share = |cell: usize| cell_volume / f64::from(occupancy[cell] + new[cell]);
    let of_sources = sources.iter().map(|s| grid.cell_of(&s.mean).map_or(0.0, share));
    let of_new = (0..grid.cells()).flat_map(|c| std::iter::repeat_n(c, new[c] as usize)).map(share);
    let volumes = of_sources.chain(of_new).collect();
    Ok(Filled { positions, volumes, density, topped_up, inner, clamped, outside })
}

/// The new particles of every cell.
fn new_positions(grid: &CellGrid, new: &[u32]) -> Vec<Vec3> {
    let mut positions = Vec::with_capacity(new.iter().map(|&n| n as usize).sum());
    for (cell, &count) in new.iter().enumerate() {
        let corner = grid.indices(cell).map(|i| i as f64);
        for k in 0..count {
            let place = Vec3::from(corner) + scattered(cell as u64, k);
            positions.push(grid.origin + place * grid.cell);
        }
    }
    positions
}

/// A point of the unit cube for particle k of a cell: the k-th point of an additive recurrence, which spreads evenly for any number of points, from a start that
/// differs from cell to cell.
///
/// # Reference
/// Roberts (2018), *The unreasonable effectiveness of quasirandom sequences*: steps 1/φ, 1/φ², 1/φ³ with φ⁴ = φ + 1. The start: Vigna's splitmix64.
fn scattered(cell: u64, k: u32) -> Vec3 {
    const STEPS: [f64; 3] = [0.819_172_513_396_164_4, 0.671_043_606_703_789_3, 0.549_700_477_901_970_4];
    let mut state = cell;
    let mut start = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    };
    let start = [start(), start(), start()];
    Vec3::from([0, 1, 2].map(|axis| (start[axis] + f64::from(k) * STEPS[axis]).fract()))
}
