//! A uniform grid of cells over boxes, to find what is near a point.

use mechanics_core::mesh::BoundingBox;
use mechanics_core::tensor::Vec3;

/// For each cell the boxes that touch it, in their order.
pub(super) struct Cells {
    origin: Vec3,
    size: f64,
    counts: [usize; 3],
    /// The boxes of cell c are `items[starts[c]..starts[c + 1]]`.
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl Cells {
    /// At most about four cells a box. `None` if there are no boxes.
    pub(super) fn new(boxes: &[BoundingBox]) -> Option<Self> {
        let first = boxes.first()?;
        let (min, max) =
            boxes.iter().fold((first.min, first.max), |(a, b), x| (a.inf(&x.min), b.sup(&x.max)));
        let extent = max - min;
        let mean = boxes.iter().map(|b| b.size().max()).sum::<f64>() / boxes.len() as f64;
        let longest = extent.max().max(f64::MIN_POSITIVE);
        // As many cells as boxes where they fill the space, fewer where they overlap.
        let mut size = mean.max(longest / 256.0);
        let counts = loop {
            let counts = [0, 1, 2].map(|k| (extent[k] / size).floor() as usize + 1);
            if counts.iter().product::<usize>() <= 4 * boxes.len() + 8 {
                break counts;
            }
            size *= 1.25;
        };
        let mut cells = Self { origin: min, size, counts, starts: Vec::new(), items: Vec::new() };
        cells.fill(boxes);
        Some(cells)
    }

    fn fill(&mut self, boxes: &[BoundingBox]) {
        let total = self.counts.iter().product::<usize>();
        let mut starts = vec![0_u32; total + 1];
        let touched = |cells: &Self, b: &BoundingBox| {
            let (low, high) = (cells.cell(&b.min), cells.cell(&b.max));
            cells.indices(low, high).collect::<Vec<_>>()
        };
        for b in boxes {
            touched(self, b).into_iter().for_each(|c| starts[c + 1] += 1);
        }
        for c in 0..total {
            starts[c + 1] += starts[c];
        }
        let mut next = starts.clone();
        self.items = vec![0; starts[total] as usize];
        for (i, b) in boxes.iter().enumerate() {
            for c in touched(self, b) {
                self.items[next[c] as usize] = i as u32;
                next[c] += 1;
            }
        }
        self.starts = starts;
    }

    /// The cell of a point; the nearest one if it is outside.
    fn cell(&self, x: &Vec3) -> [usize; 3] {
        [0, 1, 2].map(|k| {
            let place = ((x[k] - self.origin[k]) / self.size).floor();
            // NaN becomes zero, as every negative number does.
            (place as usize).min(self.counts[k] - 1)
        })
    }

    fn indices(&self, low: [usize; 3], high: [usize; 3]) -> impl Iterator<Item = usize> + use<> {
        let [_, b, c] = self.counts;
        (low[0]..=high[0]).flat_map(move |i| {
            (low[1]..=high[1]).flat_map(move |j| (low[2]..=high[2]).map(move |k| (i * b + j) * c + k))
        })
    }

    /// The boxes that touch the cell of a point.
    pub(super) fn at(&self, x: &Vec3) -> &[u32] {
        let [i, j, k] = self.cell(x);
        self.of((i * self.counts[1] + j) * self.counts[2] + k)
    }

    fn of(&self, cell: usize) -> &[u32] {
        &self.items[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }

    /// Calls `visit` with boxes, ever farther from x, until all that are nearer than the distance that it last answered have been seen. A
    /// box may come more than once.
    pub(super) fn nearest(&self, x: &Vec3, mut visit: impl FnMut(u32) -> f64) {
        let centre = self.cell(x);
        let rings = *self.counts.iter().max().unwrap_or(&1);
        let mut reach = f64::INFINITY;
        for ring in 0..rings {
            // What is in this ring is farther than all of the cells within it.
            if self.distance_to_ring(x, centre, ring) > reach {
                return;
            }
            let low = centre.map(|c| c.saturating_sub(ring));
            let high = [0, 1, 2].map(|k| (centre[k] + ring).min(self.counts[k] - 1));
            for i in low[0]..=high[0] {
                for j in low[1]..=high[1] {
                    let on_side = i.abs_diff(centre[0]) == ring || j.abs_diff(centre[1]) == ring;
                    let step = if on_side || ring == 0 { 1 } else { 2 * ring };
                    let start = if on_side { low[2] as isize } else { centre[2] as isize - ring as isize };
                    for k in (start..=high[2] as isize).step_by(step).filter(|&k| k >= 0) {
                        let cell = (i * self.counts[1] + j) * self.counts[2] + k as usize;
                        for &item in self.of(cell) {
                            reach = visit(item);
                        }
                    }
                }
            }
        }
    }

    /// A lower bound of the distance from x to what no cell nearer than `ring` touches.
    fn distance_to_ring(&self, x: &Vec3, centre: [usize; 3], ring: usize) -> f64 {
        if ring == 0 {
            return 0.0;
        }
        let mut least = f64::INFINITY;
        for k in 0..3 {
            let low = self.origin[k] + (centre[k] as f64 - (ring as f64 - 1.0)) * self.size;
            let high = self.origin[k] + (centre[k] + ring) as f64 * self.size;
            if centre[k] >= ring {
                least = least.min((x[k] - low).max(0.0));
            }
            if centre[k] + ring < self.counts[k] {
                least = least.min((high - x[k]).max(0.0));
            }
        }
        least
    }
}
