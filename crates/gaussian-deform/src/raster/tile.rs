//! Blending within one tile of 16 × 16 pixels.

use super::TILE;
use super::exponential::decay;
use super::footprint::Footprint;
use mechanics_core::lanes::{Element, Packet};
use mechanics_core::scalar::{Mask, Scalar};

/// The most opaque that a Gaussian is at a pixel.
const MOST_OPAQUE: f64 = 0.99;

/// Nothing is drawn any more on a pixel where less light than this would come through.
const LEAST_LIGHT: f64 = 1e-4;

/// Pixels in a row of a block.
const BLOCK_WIDTH: usize = 4;

/// Blocks beside each other in a tile.
const BLOCK_COLUMNS: usize = TILE / BLOCK_WIDTH;

/// The most blocks in a tile.
pub(crate) const MOST_BLOCKS: usize = 64;

/// The pixels of a tile in blocks, one packet each: four columns of two rows (`f32`) or of one (`f64`).
///
/// Blocks are numbered column after column, from 0 to 31 (63), so that sets of blocks are sets of bits. A block holds the transmittance first, negative
/// on pixels that are finished, then N − 1 channels.
pub(crate) struct Tile<P: Packet, const N: usize> {
    blocks: [[P; N]; MOST_BLOCKS],
    /// Of the first pixel.
    corner: [P::Element; 2],
    /// The blocks on which something may still be drawn.
    open: u64,
    grid: Grid<P>,
}

/// Where blocks and lanes are in a tile.
#[derive(Clone, Copy)]
pub(crate) struct Grid<P: Packet> {
    /// The column and the row of the first pixel of each block.
    corners: [[P::Element; 2]; MOST_BLOCKS],
    /// The column and the row of each lane's pixel in its block.
    lanes: [P; 2],
    /// The first rows of as many blocks as lanes.
    strips: P,
}

impl<P: Packet> Grid<P> {
    #[inline(always)]
    pub(crate) fn new() -> Self {
        let (height, block_rows) = rows::<P>();
        let number = |n: usize| P::Element::constant(n as f64);
        let mut corners = [[number(0); 2]; MOST_BLOCKS];
        for (index, corner) in corners.iter_mut().enumerate() {
            *corner = [number(index / block_rows * BLOCK_WIDTH), number(index % block_rows * height)];
        }
        let mut lanes = [<P::Element as Element>::Lanes::default(); 3];
        for lane in 0..P::LANES {
            lanes[0].as_mut()[lane] = number(lane % BLOCK_WIDTH);
            lanes[1].as_mut()[lane] = number(lane / BLOCK_WIDTH);
            lanes[2].as_mut()[lane] = number(lane * height);
        }
        let [columns, rows, strips] = lanes.map(P::from_lanes);
        Self { corners, lanes: [columns, rows], strips }
    }
}

/// How many rows of pixels a block has, and how many rows of blocks a tile.
const fn rows<P: Packet>() -> (usize, usize) {
    let height = P::LANES / BLOCK_WIDTH;
    (height, TILE / height)
}

impl<P: Packet, const N: usize> Tile<P, N> {
    /// Nothing is drawn yet. `inside` columns and rows of pixels belong to the picture.
    #[inline(always)]
    pub(crate) fn new(grid: &Grid<P>, corner: [P::Element; 2], inside: [usize; 2]) -> Self {
        let (height, block_rows) = rows::<P>();
        let mut empty = [P::constant(0.0); N];
        empty[0] = P::constant(1.0);
        let used_rows = inside[1].div_ceil(height).min(block_rows);
        let column = (1_u64 << used_rows) - 1;
        let open = (0..inside[0].div_ceil(BLOCK_WIDTH).min(BLOCK_COLUMNS))
            .fold(0, |open, k| open | column << (k * block_rows));
        Self { blocks: [empty; MOST_BLOCKS], corner, open, grid: *grid }
    }

    /// Draws a Gaussian behind what is there already; false once nothing more can be drawn on the tile.
    #[inline(always)]
    pub(crate) fn draw(&mut self, footprint: &Footprint<P::Element>) -> bool {
        let mut touched = self.touched(footprint) & self.open;
        if touched == 0 {
            return true;
        }
        let ink = Ink::<P, N>::new(footprint, self);
        while touched != 0 {
            let index = touched.trailing_zeros() as usize % MOST_BLOCKS;
            touched &= touched - 1;
            if !ink.blend(self.grid.corners[index], &mut self.blocks[index]) {
                self.open &= !(1 << index);
            }
        }
        self.open != 0
    }

    /// The blocks in whose rows a Gaussian is visible at their columns: a superset of those with a visible pixel.
    #[inline(always)]
    fn touched(&self, footprint: &Footprint<P::Element>) -> u64 {
        let (height, block_rows) = rows::<P>();
        let footprint = footprint.on_lanes::<P>();
        let mut touched = 0;
        let corner = [P::splat(self.corner[0]), P::splat(self.corner[1])];
        for first in (0..block_rows).step_by(P::LANES) {
            let top = corner[1] + self.grid.strips + P::constant((first * height) as f64);
            let (from, to) = footprint.visible_in_strip(top, top + P::constant(height as f64 - 1.0));
            for column in 0..BLOCK_COLUMNS {
                let left = corner[0] + P::constant((column * BLOCK_WIDTH) as f64);
                let right = left + P::constant(BLOCK_WIDTH as f64 - 1.0);
                let bits = P::bits(from.less_equal(right).and(left.less_equal(to)));
                touched |= u64::from(bits) << (column * block_rows + first);
            }
        }
        touched
    }

    /// Calls `pixel(column, row, values)` on every pixel of the tile; the first value is the transmittance.
    #[inline(always)]
    pub(crate) fn for_each_pixel(&self, mut pixel: impl FnMut(usize, usize, [P::Element; N])) {
        let (height, block_rows) = rows::<P>();
        for index in 0..BLOCK_COLUMNS * block_rows {
            let lanes = self.blocks[index].map(P::to_lanes);
            let (column, row) = (index / block_rows * BLOCK_WIDTH, index % block_rows * height);
            for lane in 0..P::LANES {
                let mut values = [P::Element::constant(0.0); N];
                for k in 0..N {
                    values[k] = lanes[k].as_ref()[lane];
                }
                values[0] = Scalar::abs(values[0]);
                pixel(column + lane % BLOCK_WIDTH, row + lane / BLOCK_WIDTH, values);
            }
        }
    }
}

/// A Gaussian as it is needed at every pixel of one tile.
struct Ink<P, const N: usize> {
    /// u and v at the first block, and how they grow with columns and rows.
    u: P,
    v: P,
    u_by_column: P,
    u_by_row: P,
    v_by_row: P,
    reach: P,
    opacity: P,
    /// The first is not used.
    channels: [P; N],
}

impl<P: Packet, const N: usize> Ink<P, N> {
    #[inline(always)]
    fn new(footprint: &Footprint<P::Element>, tile: &Tile<P, N>) -> Self {
        let [columns, rows] = tile.grid.lanes;
        let x = tile.corner[0] - footprint.middle[0];
        let y = tile.corner[1] - footprint.middle[1];
        let (u_by_column, v_by_row) = (P::splat(footprint.across), P::splat(footprint.down));
        let u_by_row = P::splat(-(footprint.across * footprint.slope));
        let u = P::splat(footprint.across * (x - footprint.slope * y));
        let v = P::splat(footprint.down * y);
        let mut channels = [P::splat(footprint.depth); N];
        for k in 1..4 {
            channels[k] = P::splat(footprint.colour[k - 1]);
        }
        Self {
            u: columns.mul_add(u_by_column, rows.mul_add(u_by_row, u)),
            v: rows.mul_add(v_by_row, v),
            u_by_column,
            u_by_row,
            v_by_row,
            reach: P::splat(footprint.reach),
            opacity: P::splat(footprint.opacity),
            channels,
        }
    }

    /// Draws on the block whose first pixel is at column and row `corner` of the tile; false once all of its pixels are finished.
    ///
    /// With the transmittance T and the opacity α: C ← C + α T c, T ← (1 − α) T where (1 − α) T ≥ 1e-4, else the pixel is finished and T
    /// changes its sign. A finished pixel finishes again: (1 − α) T is negative.
    #[inline(always)]
    fn blend(&self, corner: [P::Element; 2], block: &mut [P; N]) -> bool {
        let (column, row) = (P::splat(corner[0]), P::splat(corner[1]));
        let u = column.mul_add(self.u_by_column, row.mul_add(self.u_by_row, self.u));
        let v = row.mul_add(self.v_by_row, self.v);
        let s = u.mul_add(u, v * v);
        let opaque = (self.opacity * decay(s)).min(P::constant(MOST_OPAQUE));
        let opaque = opaque.keep(s.less_equal(self.reach));
        let light = block[0];
        let weight = opaque * light;
        let rest = light - weight;
        let goes_on = P::constant(LEAST_LIGHT).less_equal(rest);
        let weight = weight.keep(goes_on);
        for k in 1..N {
            block[k] = weight.mul_add(self.channels[k], block[k]);
        }
        block[0] = P::select(goes_on, rest, -light.abs());
        goes_on.any()
    }
}
