//! Which empty cells are inside.

use super::{CellGrid, Direction, Parity, Rules};

/// The empty cells that see dense ones around them and pass the test of parity, ascending.
pub(super) fn inner_cells(density: &[f64], occupied: &[bool], grid: &CellGrid, rules: &Rules) -> Vec<u32> {
    let dense = |cell: usize| density[cell] > rules.search_threshold;
    let mut inside: Vec<bool> = occupied.iter().map(|o| !o).collect();
    for direction in Direction::ALL.into_iter().filter(|&d| rules.excluded != Some(d)) {
        for_each_line(grid, direction, |line| {
            // From the far end: whether anything dense has been passed.
            let mut seen = false;
            for cell in line.cells() {
                inside[cell] &= seen;
                seen |= dense(cell);
            }
        });
    }
    match rules.parity {
        Parity::Unchecked => {}
        Parity::Along(direction) => {
            for_each_odd(grid, direction, dense, |cell, odd| inside[cell] &= odd);
        }
        Parity::Majority => {
            let mut votes = vec![0_u8; inside.len()];
            for direction in Direction::ALL {
                for_each_odd(grid, direction, dense, |cell, odd| votes[cell] += u8::from(odd));
            }
            inside.iter_mut().zip(votes).for_each(|(inside, votes)| *inside &= votes >= 4);
        }
    }
    (0..inside.len() as u32).filter(|&cell| inside[cell as usize]).collect()
}

/// Calls `visit` with every cell, and whether its ray in a direction enters dense cells an odd number of times. The cell itself counts as not dense.
fn for_each_odd(
    grid: &CellGrid,
    direction: Direction,
    dense: impl Fn(usize) -> bool,
    mut visit: impl FnMut(usize, bool),
) {
    for_each_line(grid, direction, |line| {
        // Of the cell before: whether its ray enters an odd number of times, and whether it is dense.
        let (mut odd, mut before) = (false, false);
        for cell in line.cells() {
            visit(cell, odd ^ before);
            let here = dense(cell);
            odd ^= before && !here;
            before = here;
        }
    });
}

/// The cells of a line along an axis, from the end that a direction points to.
struct Line {
    last: usize,
    step: isize,
    count: usize,
}

impl Line {
    fn cells(&self) -> impl Iterator<Item = usize> + use<> {
        let (last, step) = (self.last as isize, self.step);
        (0..self.count as isize).map(move |k| (last - k * step) as usize)
    }
}

/// Every line of cells along a direction.
fn for_each_line(grid: &CellGrid, direction: Direction, mut visit: impl FnMut(&Line)) {
    let [a, b, c] = grid.counts;
    let (axis, forward) = match direction {
        Direction::PlusX => (0, true),
        Direction::MinusX => (0, false),
        Direction::PlusY => (1, true),
        Direction::MinusY => (1, false),
        Direction::PlusZ => (2, true),
        Direction::MinusZ => (2, false),
    };
    let strides = [b * c, c, 1];
    let others = [[1, 2], [0, 2], [0, 1]][axis];
    let (count, stride) = ([a, b, c][axis], strides[axis]);
    for i in 0..grid.counts[others[0]] {
        for j in 0..grid.counts[others[1]] {
            let first = i * strides[others[0]] + j * strides[others[1]];
            let (last, step) = if forward {
                (first + (count - 1) * stride, stride as isize)
            } else {
                (first, -(stride as isize))
            };
            visit(&Line { last, step, count });
        }
    }
}
