use super::coarsening::coarsen;
use super::graph::Graph;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A side may weigh at most this fraction of the whole.
const LARGEST_SIDE: f64 = 0.66;

/// Seeds from which separators of the coarsest graph are grown.
const SEEDS: usize = 10;

/// Refinement passes over one level at most.
const PASSES: usize = 4;

/// Where a node is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    First,
    Second,
    Separator,
}

const SIDES: [Side; 2] = [Side::First, Side::Second];

impl Side {
    fn other(self) -> Self {
        match self {
            Self::First => Self::Second,
            Self::Second => Self::First,
            Self::Separator => Self::Separator,
        }
    }
}

/// Cuts a connected graph: no edge joins the first side and the second. A side is empty only if nothing better was
/// found.
pub(super) fn bisect(graph: &Graph) -> Vec<Side> {
    let levels = coarsen(graph);
    let coarsest = levels.last().map_or(graph, |level| &level.graph);
    let mut sides = grow_best(coarsest);
    for depth in (0..levels.len()).rev() {
        let finer = if depth == 0 { graph } else { &levels[depth - 1].graph };
        let projected = levels[depth].coarse.iter().map(|&coarse| sides[coarse as usize]).collect();
        let mut cut = Cut::new(finer, projected);
        cut.refine();
        sides = cut.sides;
    }
    sides
}

/// The best of several grown and refined separators.
fn grow_best(graph: &Graph) -> Vec<Side> {
    let nodes = graph.nodes();
    let grow = |k: usize| {
        let mut cut = Cut::new(graph, vec![Side::Second; nodes]);
        cut.grow(k * nodes / SEEDS);
        cut.refine();
        cut
    };
    let best = (0..SEEDS.min(nodes)).map(grow).min_by_key(Cut::score);
    best.map_or_else(Vec::new, |cut| cut.sides)
}

/// A cut under refinement, after Fiduccia and Mattheyses (1982) with nodes for edges (Ashcraft, Liu 1998): moving a
/// node from the separator to one side pulls its neighbours on the other side into the separator.
struct Cut<'a> {
    graph: &'a Graph,
    sides: Vec<Side>,
    /// Weights of the first side, the second, the separator.
    weights: [u64; 3],
    largest: u64,
    /// For nodes of the separator: the weight of their neighbours on either side.
    pulls: Vec<[u64; 2]>,
    heaps: [BinaryHeap<(i64, Reverse<u32>)>; 2],
    locked: Vec<bool>,
}

impl<'a> Cut<'a> {
    fn new(graph: &'a Graph, sides: Vec<Side>) -> Self {
        let mut weights = [0; 3];
        for (&side, &weight) in sides.iter().zip(&graph.node_weights) {
            weights[side as usize] += u64::from(weight);
        }
        let nodes = graph.nodes();
        let largest = (LARGEST_SIDE * graph.total_weight() as f64) as u64;
        let (pulls, locked) = (vec![[0; 2]; nodes], vec![false; nodes]);
        Self { graph, sides, weights, largest, pulls, heaps: Default::default(), locked }
    }

    /// Smaller is better: overweight first, then the separator, then the difference of the sides.
    fn score(&self) -> (u64, u64, u64) {
        let [first, second, separator] = self.weights;
        (first.max(second).saturating_sub(self.largest), separator, first.abs_diff(second))
    }

    /// Moves nodes to the first side, the cheapest next to it first, until it is half.
    fn grow(&mut self, seed: usize) {
        let half = self.graph.total_weight() / 2;
        self.place(seed, Side::Separator);
        self.enter_separator(seed);
        while self.weights[0] < half {
            let Some((_, node)) = self.best_of(Side::First) else { break };
            self.advance(node, Side::First, &mut Vec::new());
        }
    }

    /// Passes of moves, each ending at the best cut it met, until a pass brings nothing.
    fn refine(&mut self) {
        for _ in 0..PASSES {
            let before = self.score();
            self.pass();
            if self.score() >= before {
                return;
            }
        }
    }

    fn pass(&mut self) {
        self.locked.fill(false);
        self.heaps = Default::default();
        for node in 0..self.graph.nodes() {
            if self.sides[node] == Side::Separator {
                self.enter_separator(node);
            }
        }
        let patience = 60 + self.graph.nodes() / 50;
        let (mut best, mut best_length) = (self.score(), 0);
        let mut moves: Vec<(usize, Side, Vec<usize>)> = Vec::new();
        while moves.len() < best_length + patience {
            let Some((node, side)) = self.next_move() else { break };
            let mut pulled = Vec::new();
            self.locked[node] = true;
            self.advance(node, side, &mut pulled);
            moves.push((node, side, pulled));
            if self.score() < best {
                (best, best_length) = (self.score(), moves.len());
            }
        }
        for (node, side, pulled) in moves.drain(best_length..).rev() {
            for back in pulled {
                self.place(back, side.other());
            }
            self.place(node, Side::Separator);
        }
    }

    /// The move that shrinks the separator most among those that keep the balance; to the lighter side if equal.
    fn next_move(&mut self) -> Option<(usize, Side)> {
        let candidates = SIDES.map(|side| self.best_of(side));
        let admissible = |side: Side| {
            let (gain, node) = candidates[side as usize]?;
            let weight = self.weights[side as usize] + u64::from(self.graph.node_weights[node]);
            let lighter = self.weights[side as usize] <= self.weights[side.other() as usize];
            (weight <= self.largest || lighter).then_some((gain, lighter, node, side))
        };
        let moves = SIDES.into_iter().filter_map(admissible);
        moves.max_by_key(|&(gain, lighter, _, _)| (gain, lighter)).map(|(_, _, node, side)| (node, side))
    }

    /// The best entry of a side's heap. Entries are renewed when a gain rises; one whose gain fell since is put back
    /// where it belongs, one of a node that moved is dropped.
    fn best_of(&mut self, side: Side) -> Option<(i64, usize)> {
        loop {
            let &(gain, Reverse(node)) = self.heaps[side as usize].peek()?;
            let node = node as usize;
            let movable = self.sides[node] == Side::Separator && !self.locked[node];
            let current = self.gain(node, side);
            if movable && gain == current {
                return Some((gain, node));
            }
            self.heaps[side as usize].pop();
            if movable && current < gain {
                self.queue(node, side);
            }
        }
    }

    /// By how much the separator shrinks when `node` leaves it for `side`.
    fn gain(&self, node: usize, side: Side) -> i64 {
        i64::from(self.graph.node_weights[node]) - self.pulls[node][side.other() as usize] as i64
    }

    fn place(&mut self, node: usize, side: Side) {
        let weight = u64::from(self.graph.node_weights[node]);
        self.weights[self.sides[node] as usize] -= weight;
        self.weights[side as usize] += weight;
        self.sides[node] = side;
    }

    /// Computes the pulls of a node of the separator and queues it.
    fn enter_separator(&mut self, node: usize) {
        let mut pulls = [0; 2];
        for &next in self.graph.neighbours(node) {
            let side = self.sides[next as usize];
            if side != Side::Separator {
                pulls[side as usize] += u64::from(self.graph.node_weights[next as usize]);
            }
        }
        self.pulls[node] = pulls;
        self.queue(node, Side::First);
        self.queue(node, Side::Second);
    }

    fn queue(&mut self, node: usize, side: Side) {
        if !self.locked[node] {
            let gain = self.gain(node, side);
            self.heaps[side as usize].push((gain, Reverse(node as u32)));
        }
    }

    /// Moves `node` from the separator to `side`, and its neighbours on the other side into the separator.
    fn advance(&mut self, node: usize, side: Side, pulled: &mut Vec<usize>) {
        let graph = self.graph;
        let weight = u64::from(graph.node_weights[node]);
        let other = side.other();
        self.place(node, side);
        for &next in graph.neighbours(node) {
            let next = next as usize;
            if self.sides[next] == Side::Separator {
                self.pulls[next][side as usize] += weight;
            } else if self.sides[next] == other {
                self.place(next, Side::Separator);
                pulled.push(next);
                self.leave_side(next, other);
                self.enter_separator(next);
            }
        }
    }

    /// Tells the separator that `node` is no longer on `side`.
    fn leave_side(&mut self, node: usize, side: Side) {
        let weight = u64::from(self.graph.node_weights[node]);
        for &next in self.graph.neighbours(node) {
            let next = next as usize;
            if self.sides[next] == Side::Separator && next != node {
                self.pulls[next][side as usize] -= weight;
                self.queue(next, side.other());
            }
        }
    }
}
