//! Second stage: one band of tiles, sixteen rows of pixels from the left to the right.

use super::TILE;
use super::footprint::Footprint;
use super::gathering::{Chunk, Placed};
use super::order;
use super::tile::{Grid, Tile};
use mechanics_core::lanes::{Element, LaneKernel, Packet};

/// The part of a picture that a band fills.
pub(crate) struct Band<'a, E> {
    /// Which one, from the top.
    pub number: usize,
    /// The width and the height of the picture.
    pub size: [usize; 2],
    pub colours: &'a mut [[E; 3]],
    pub transmittance: &'a mut [E],
    /// Empty if nobody asks for it.
    pub depth: &'a mut [E],
    /// Pairs of a Gaussian and a tile that were drawn.
    pub drawn: usize,
}

/// Draws a band, with N values a pixel: the transmittance, three colours, and the depth if N is 5.
pub(crate) struct Draw<'a, 'b, E, const N: usize> {
    pub chunks: &'a [Chunk<E>],
    pub background: [E; 3],
    pub band: &'a mut Band<'b, E>,
}

impl<E: Element, const N: usize> LaneKernel<E> for Draw<'_, '_, E, N> {
    type Output = ();

    #[inline(always)]
    fn run<P: Packet<Element = E>>(self) {
        let Draw { chunks, background, band } = self;
        let top = band.number * TILE;
        let rows = TILE.min(band.size[1] - top);
        let gaussians = Queue::new(chunks, band.number, band.size, rows);
        let grid = Grid::new();
        for column in 0..band.size[0].div_ceil(TILE) {
            let left = column * TILE;
            let columns = TILE.min(band.size[0] - left);
            let corner = [left, top].map(|x| E::constant(x as f64));
            let mut tile = Tile::<P, N>::new(&grid, corner, [columns, rows]);
            for footprint in gaussians.of_tile(column) {
                band.drawn += 1;
                if !tile.draw(footprint) {
                    break;
                }
            }
            let width = band.size[0];
            tile.for_each_pixel(|x, y, values| {
                if x < columns && y < rows {
                    let pixel = y * width + left + x;
                    for k in 0..3 {
                        band.colours[pixel][k] = values[k + 1] + values[0] * background[k];
                    }
                    band.transmittance[pixel] = values[0];
                    if N == 5 {
                        band.depth[pixel] = values[N - 1];
                    }
                }
            });
        }
    }
}

/// The Gaussians of a band from front to back, and which of them each tile needs.
struct Queue<E> {
    footprints: Vec<Footprint<E>>,
    /// Numbers of footprints, those of the first tile first, ascending within a tile.
    entries: Vec<u32>,
    /// Where each tile begins in `entries`, and the end.
    starts: Vec<usize>,
}

impl<E: Element> Queue<E> {
    /// Copies come first: in the order of depth the Gaussians of a large scene are all over the memory, and a loop that has anything else to do
    /// would wait for each of them.
    #[inline(always)]
    fn new(chunks: &[Chunk<E>], band: usize, size: [usize; 2], rows: usize) -> Self {
        let mut unsorted = Vec::with_capacity(chunks.iter().map(|chunk| chunk.count(band)).sum());
        for chunk in chunks {
            for placed in chunk.of_band(band) {
                unsorted.push(*placed);
            }
        }
        let mut depths = Vec::with_capacity(unsorted.len());
        for placed in &unsorted {
            depths.push(placed.footprint.depth);
        }
        let top = (band * TILE) as f64;
        let strip = [E::constant(top), E::constant(top + rows as f64 - 1.0)];
        for placed in &mut unsorted {
            placed.columns = columns_in_strip(placed, strip, size[0]);
        }
        let mut footprints = Vec::with_capacity(unsorted.len());
        let mut ranges = Vec::with_capacity(unsorted.len());
        for i in order::by_depth(&depths) {
            let placed = &unsorted[i as usize];
            footprints.push(placed.footprint);
            ranges.push(placed.columns);
        }
        let (entries, starts) = by_tile(&ranges, size[0].div_ceil(TILE));
        Self { footprints, entries, starts }
    }

    /// From front to back.
    #[inline(always)]
    fn of_tile(&self, column: usize) -> impl Iterator<Item = &Footprint<E>> {
        self.entries[self.starts[column]..self.starts[column + 1]]
            .iter()
            .map(|&i| &self.footprints[i as usize])
    }
}

/// The numbers of the ranges that each of so many tiles is in, ascending, tile after tile; and where each tile begins, and the end.
#[inline(always)]
fn by_tile(ranges: &[[u16; 2]], tiles: usize) -> (Vec<u32>, Vec<usize>) {
    let mut starts = vec![0_usize; tiles + 1];
    for range in ranges {
        for tile in range[0]..range[1] {
            starts[usize::from(tile) + 1] += 1;
        }
    }
    for tile in 0..tiles {
        starts[tile + 1] += starts[tile];
    }
    let mut ends = starts.clone();
    let mut entries = vec![0; starts[tiles]];
    for (i, range) in ranges.iter().enumerate() {
        for tile in range[0]..range[1] {
            let end = &mut ends[usize::from(tile)];
            entries[*end] = i as u32;
            *end += 1;
        }
    }
    (entries, starts)
}

/// The tiles of a band, half open, in which a Gaussian is drawn.
#[inline(always)]
fn columns_in_strip<E: Element>(placed: &Placed<E>, strip: [E; 2], width: usize) -> [u16; 2] {
    let (from, to) = placed.footprint.visible_in_strip(strip[0], strip[1]);
    let (from, to): (f64, f64) = (from.into(), to.into());
    if from.is_nan() || to.is_nan() {
        return [0, 0];
    }
    // Casts to integers saturate.
    let first = (from.ceil() as i64).max(0);
    let last = (to.floor() as i64).min(width as i64 - 1);
    if last < first {
        return [0, 0];
    }
    let tile = |pixel: i64| (pixel as usize / TILE) as u16;
    [tile(first).max(placed.columns[0]), (tile(last) + 1).min(placed.columns[1])]
}
