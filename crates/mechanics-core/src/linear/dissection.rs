//! Nested dissection of the node graph.
//!
//! A small set of nodes, the separator, cuts the graph into two halves of similar size; the halves are numbered
//! first (each by the same rule), the separator last, so that no fill ever joins the halves (George 1973). The
//! separator is found on a coarse version of the graph and refined on the way back to the fine one (Karypis, Kumar
//! 1998). Pieces of at most [`LEAF`] nodes are numbered by minimum degree, counting their neighbours in the
//! separators around them, which are eliminated later (Pellegrini, Roman, Amestoy 2000).
//!
//! Every piece is treated on its own and from its own data, so the pieces of one depth run in parallel and the
//! result depends on nothing but the graph.
//!
//! # Reference
//! A. George, SIAM J. Numer. Anal. 10 (1973); G. Karypis, V. Kumar, SIAM J. Sci. Comput. 20 (1998); F. Pellegrini,
//! J. Roman, P. Amestoy, Concurrency: Pract. Exper. 12 (2000).

mod coarsening;
mod graph;
mod minimum_degree;
mod separator;

use crate::parallel;
use crate::sparse::BlockPattern;
pub(super) use graph::Graph;
use graph::Piece;
use separator::Side;

/// Pieces of at most so many nodes are not cut any more.
const LEAF: usize = 40;

/// The largest piece numbered by minimum degree when no separator can be found (a nearly complete graph).
const LARGEST_MINIMUM_DEGREE: usize = 1000;

/// The caller's column at each new position.
pub(super) fn nested_dissection(pattern: &BlockPattern) -> Vec<u32> {
    let whole = Graph::new(pattern);
    let columns = pattern.columns();
    let mut order = vec![0u32; columns];
    let mut pieces = vec![Task { piece: Piece::whole(&whole), first: 0 }];
    while !pieces.is_empty() {
        let steps = parallel::map_chunks(pieces.len(), 1, |range| pieces[range.start].step(&whole));
        let mut next = Vec::new();
        for step in steps {
            order[step.first..step.first + step.numbered.len()].copy_from_slice(&step.numbered);
            next.extend(step.tasks);
        }
        pieces = next;
    }
    order
}

/// A piece of the graph that is to fill the positions from `first` on.
struct Task {
    piece: Piece,
    first: usize,
}

/// What became of a task: nodes numbered from `first` on, and what is left.
struct Step {
    first: usize,
    numbered: Vec<u32>,
    tasks: Vec<Task>,
}

impl Task {
    fn step(&self, whole: &Graph) -> Step {
        let nodes = self.piece.graph.nodes();
        if nodes <= LEAF {
            return self.leaf(minimum_degree::order(whole, &self.piece.names));
        }
        let components = self.piece.components();
        if components.len() > 1 {
            return self.divided(components, Vec::new());
        }
        let sides = separator::bisect(&self.piece.graph);
        let halves = self.piece.parts(&sides);
        if halves.iter().any(|half| half.graph.nodes() == 0) {
            return self.leaf(self.without_separator(whole));
        }
        let separator = (0..nodes).filter(|&node| sides[node] == Side::Separator);
        let separator = separator.map(|node| self.piece.names[node]).collect();
        self.divided(halves, separator)
    }

    fn leaf(&self, numbered: Vec<u32>) -> Step {
        Step { first: self.first, numbered, tasks: Vec::new() }
    }

    /// The parts one after the other, the separator last.
    fn divided(&self, parts: Vec<Piece>, separator: Vec<u32>) -> Step {
        let mut first = self.first;
        let mut tasks = Vec::with_capacity(parts.len());
        for piece in parts {
            let size = piece.graph.nodes();
            tasks.push(Task { piece, first });
            first += size;
        }
        Step { first, numbered: separator, tasks }
    }

    fn without_separator(&self, whole: &Graph) -> Vec<u32> {
        if self.piece.graph.nodes() <= LARGEST_MINIMUM_DEGREE {
            return minimum_degree::order(whole, &self.piece.names);
        }
        let mut nodes: Vec<usize> = (0..self.piece.graph.nodes()).collect();
        nodes.sort_by_key(|&node| self.piece.graph.neighbours(node).len());
        nodes.into_iter().map(|node| self.piece.names[node]).collect()
    }
}
