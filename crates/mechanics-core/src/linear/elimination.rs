//! The structure of a Cholesky factor, predicted from the node graph alone.

use crate::sparse::BlockPattern;

/// A numbering of block columns and its inverse.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Numbering {
    /// The caller's column at each new position.
    pub(super) old: Vec<u32>,
    /// The new position of each of the caller's columns.
    pub(super) new: Vec<u32>,
}

impl Numbering {
    pub(super) fn identity(columns: usize) -> Self {
        let same: Vec<u32> = (0..columns as u32).collect();
        Self { new: same.clone(), old: same }
    }

    /// The numbering that puts column `old[k]` at position `k`. `old` is a permutation.
    pub(super) fn from_old(old: Vec<u32>) -> Self {
        let mut new = vec![u32::MAX; old.len()];
        for (position, &column) in old.iter().enumerate() {
            new[column as usize] = position as u32;
        }
        debug_assert!(
            new.iter().all(|&position| position != u32::MAX),
            "a permutation names every column once"
        );
        Self { old, new }
    }
}

/// The upper triangle of a renumbered pattern: for each column the rows above the diagonal, ascending.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct UpperPattern {
    pub(super) start: Vec<usize>,
    pub(super) rows: Vec<u32>,
}

impl UpperPattern {
    /// The off-diagonal part of `pattern` in a new numbering.
    pub(super) fn renumbered(pattern: &BlockPattern, numbering: &Numbering) -> Self {
        let lower = sort_pairs(pattern.columns(), |emit| {
            for column in 0..pattern.columns() {
                let slots = pattern.column(column);
                let a = numbering.new[column];
                for &row in &pattern.rows()[slots.start + 1..slots.end] {
                    let b = numbering.new[row as usize];
                    emit(a.min(b), a.max(b));
                }
            }
        });
        // Sorting the transposed pairs in ascending order of their columns leaves every list ascending.
        let (start, rows) = sort_pairs(pattern.columns(), |emit| {
            for column in 0..pattern.columns() {
                for &row in &lower.1[lower.0[column]..lower.0[column + 1]] {
                    emit(row, column as u32);
                }
            }
        });
        Self { start, rows }
    }

    pub(super) fn columns(&self) -> usize {
        self.start.len() - 1
    }

    pub(super) fn column(&self, column: usize) -> &[u32] {
        &self.rows[self.start[column]..self.start[column + 1]]
    }
}

/// Groups pairs (key, value) by key, keeping the order of emission within a key. `pairs` is called twice.
fn sort_pairs(keys: usize, pairs: impl Fn(&mut dyn FnMut(u32, u32))) -> (Vec<usize>, Vec<u32>) {
    let mut start = vec![0usize; keys + 1];
    pairs(&mut |key, _| start[key as usize + 1] += 1);
    for key in 0..keys {
        start[key + 1] += start[key];
    }
    let mut values = vec![0u32; start[keys]];
    let mut next = start.clone();
    pairs(&mut |key, value| {
        values[next[key as usize]] = value;
        next[key as usize] += 1;
    });
    (start, values)
}

/// Marks a column without parent.
pub(super) const ROOT: u32 = u32::MAX;

/// The elimination tree and the column counts of a factor.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Elimination {
    /// The first block row below the diagonal in each block column of the factor, or [`ROOT`].
    pub(super) parent: Vec<u32>,
    /// The number of blocks in each block column of the factor, the diagonal included.
    pub(super) count: Vec<u32>,
}

impl Elimination {
    /// Liu's elimination tree with path compression, then column counts by walking the row subtrees: time
    /// proportional to the blocks of the factor.
    ///
    /// # Reference
    /// J. W. H. Liu, The role of elimination trees in sparse factorization, SIAM J. Matrix Anal. Appl. 11 (1990).
    pub(super) fn new(upper: &UpperPattern) -> Self {
        let parent = elimination_tree(upper);
        let columns = upper.columns();
        let mut count = vec![1u32; columns];
        let mut visited = vec![ROOT; columns];
        for column in 0..columns {
            visited[column] = column as u32;
            for &row in upper.column(column) {
                let mut node = row as usize;
                while visited[node] != column as u32 {
                    count[node] += 1;
                    visited[node] = column as u32;
                    node = parent[node] as usize;
                }
            }
        }
        Self { parent, count }
    }

    /// Multiplications and additions of the numeric factorisation, Σ m² over the m scalars of every scalar column.
    pub(super) fn flops(&self) -> f64 {
        let column = |count: &u32| {
            let m = 3.0 * f64::from(*count);
            m * m + (m - 1.0) * (m - 1.0) + (m - 2.0) * (m - 2.0)
        };
        self.count.iter().map(column).sum()
    }

    /// Scalar entries of the factor, the diagonal included.
    pub(super) fn entries(&self) -> usize {
        self.count.iter().map(|&count| 9 * count as usize - 3).sum()
    }

    /// The columns in an order in which every subtree is contiguous and ends with its root; the child with the
    /// longest column comes last, next to its parent, where the two can share a supernode.
    pub(super) fn postorder(&self) -> Vec<u32> {
        let columns = self.parent.len();
        let mut first_child = vec![ROOT; columns + 1];
        let mut sibling = vec![ROOT; columns];
        // Children are pushed in front, so visiting them in descending order lists them ascending.
        for node in (0..columns).rev() {
            let parent = if self.parent[node] == ROOT { columns } else { self.parent[node] as usize };
            sibling[node] = first_child[parent];
            first_child[parent] = node as u32;
        }
        let mut order = Vec::with_capacity(columns);
        let mut stack = Vec::new();
        let mut children = Vec::new();
        self.push_children(first_child[columns], &sibling, &mut children, &mut stack);
        while let Some((node, expanded)) = stack.pop() {
            if expanded {
                order.push(node);
                continue;
            }
            stack.push((node, true));
            self.push_children(first_child[node as usize], &sibling, &mut children, &mut stack);
        }
        order
    }

    fn push_children(
        &self,
        first: u32,
        sibling: &[u32],
        children: &mut Vec<u32>,
        stack: &mut Vec<(u32, bool)>,
    ) {
        children.clear();
        let mut child = first;
        while child != ROOT {
            children.push(child);
            child = sibling[child as usize];
        }
        children.sort_by_key(|&child| self.count[child as usize]);
        stack.extend(children.iter().rev().map(|&child| (child, false)));
    }
}

fn elimination_tree(upper: &UpperPattern) -> Vec<u32> {
    let columns = upper.columns();
    let mut parent = vec![ROOT; columns];
    let mut ancestor = vec![ROOT; columns];
    for column in 0..columns {
        for &row in upper.column(column) {
            let mut node = row as usize;
            loop {
                let next = ancestor[node];
                if next == column as u32 {
                    break;
                }
                ancestor[node] = column as u32;
                if next == ROOT {
                    parent[node] = column as u32;
                    break;
                }
                node = next as usize;
            }
        }
    }
    parent
}

/// How a stored block is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Reading {
    AsStored,
    Transposed,
}

/// The lower triangle of a renumbered pattern by block columns, the diagonal first and rows ascending, and where
/// each of its blocks is stored.
#[derive(Clone, Debug)]
pub(super) struct LowerTriangle {
    start: Vec<usize>,
    pub(super) rows: Vec<u32>,
    /// The slot of the pattern and how it is read.
    pub(super) sources: Vec<(u32, Reading)>,
}

impl LowerTriangle {
    pub(super) fn renumbered(pattern: &BlockPattern, numbering: &Numbering) -> Self {
        let columns = pattern.columns();
        let place = |column: usize, slot: usize| {
            let (row, column) = (numbering.new[pattern.rows()[slot] as usize], numbering.new[column]);
            let reading = if row >= column { Reading::AsStored } else { Reading::Transposed };
            (row.min(column) as usize, (row.max(column), slot as u32, reading))
        };
        let mut start = vec![0usize; columns + 1];
        for column in 0..columns {
            for slot in pattern.column(column) {
                start[place(column, slot).0 + 1] += 1;
            }
        }
        for column in 0..columns {
            start[column + 1] += start[column];
        }
        let mut next = start.clone();
        let mut entries = vec![(0, 0, Reading::AsStored); pattern.block_count()];
        for column in 0..columns {
            for slot in pattern.column(column) {
                let (key, entry) = place(column, slot);
                entries[next[key]] = entry;
                next[key] += 1;
            }
        }
        for range in start.windows(2) {
            entries[range[0]..range[1]].sort_unstable();
        }
        let rows = entries.iter().map(|entry| entry.0).collect();
        let sources = entries.iter().map(|entry| (entry.1, entry.2)).collect();
        Self { start, rows, sources }
    }

    pub(super) fn columns(&self) -> usize {
        self.start.len() - 1
    }

    pub(super) fn column(&self, column: usize) -> std::ops::Range<usize> {
        self.start[column]..self.start[column + 1]
    }
}
