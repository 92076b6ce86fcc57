use super::dissection::Graph;
use crate::sparse::BlockPattern;

/// Reverse Cuthill–McKee: the caller's column at each new position.
///
/// Breadth first from a node far from the middle, each node's neighbours by ascending degree, the whole reversed.
/// Neighbours in the graph get numbers close to each other, which is what an incomplete factorisation wants: what it
/// drops is then small, and a solve walks memory in order.
///
/// # Reference
/// E. Cuthill, J. McKee, Proc. 24th ACM Nat. Conf. (1969); A. George, J. W. H. Liu, ACM Trans. Math. Software 5
/// (1979) for the starting node; I. S. Duff, G. A. Meurant, BIT 29 (1989) for the effect on conjugate gradients.
pub(super) fn reverse_cuthill_mckee(pattern: &BlockPattern) -> Vec<u32> {
    let graph = Graph::new(pattern);
    let columns = pattern.columns();
    let mut walk =
        Walk { graph: &graph, seen: vec![0; columns], round: 0, order: Vec::with_capacity(columns) };
    let mut by_degree: Vec<u32> = (0..columns as u32).collect();
    by_degree.sort_by_key(|&node| graph.neighbours(node as usize).len());
    let mut placed = vec![false; columns];
    let mut order = Vec::with_capacity(columns);
    for seed in by_degree {
        if placed[seed as usize] {
            continue;
        }
        let start = walk.far_end(seed);
        walk.run(start);
        for &node in &walk.order {
            placed[node as usize] = true;
        }
        order.extend_from_slice(&walk.order);
    }
    order.reverse();
    order
}

/// A breadth-first walk through one component.
struct Walk<'a> {
    graph: &'a Graph,
    seen: Vec<u32>,
    round: u32,
    order: Vec<u32>,
}

impl Walk<'_> {
    /// Fills `order` from `start`; the number of levels and the first node of the last one.
    fn run(&mut self, start: u32) -> (usize, usize) {
        let degree = |node: u32| self.graph.neighbours(node as usize).len();
        self.round += 1;
        self.order.clear();
        self.order.push(start);
        self.seen[start as usize] = self.round;
        let (mut levels, mut first, mut level_end) = (1, 0, 1);
        let mut next = 0;
        while next < self.order.len() {
            if next == level_end {
                levels += 1;
                (first, level_end) = (level_end, self.order.len());
            }
            let children = self.order.len();
            for &end in self.graph.neighbours(self.order[next] as usize) {
                if self.seen[end as usize] != self.round {
                    self.seen[end as usize] = self.round;
                    self.order.push(end);
                }
            }
            self.order[children..].sort_by_key(|&node| degree(node));
            next += 1;
        }
        (levels, first)
    }

    /// A node at the end of a longest known path: the node of least degree in the last level, again and again while
    /// that makes the walk deeper.
    fn far_end(&mut self, seed: u32) -> u32 {
        let (mut start, mut depth) = (seed, 0);
        loop {
            let (levels, first) = self.run(start);
            if levels <= depth {
                return start;
            }
            depth = levels;
            let last = &self.order[first..];
            let least = last.iter().min_by_key(|&&node| self.graph.neighbours(node as usize).len());
            start = least.copied().unwrap_or(start);
        }
    }
}
