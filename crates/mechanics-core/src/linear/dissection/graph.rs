use super::separator::Side;
use crate::sparse::BlockPattern;

/// An undirected graph with weights, every edge stored at both of its ends.
#[derive(Clone, Debug)]
pub(in crate::linear) struct Graph {
    pub(super) start: Vec<usize>,
    pub(super) ends: Vec<u32>,
    /// How many edges of the finest graph an edge stands for.
    pub(super) edge_weights: Vec<u32>,
    /// How many nodes of the finest graph a node stands for.
    pub(super) node_weights: Vec<u32>,
}

impl Graph {
    /// The node graph of a pattern: an edge for each block off the diagonal.
    pub(in crate::linear) fn new(pattern: &BlockPattern) -> Self {
        let columns = pattern.columns();
        let mut start = vec![0usize; columns + 1];
        for column in 0..columns {
            let slots = pattern.column(column);
            start[column + 1] += slots.len() - 1;
            for &row in &pattern.rows()[slots.start + 1..slots.end] {
                start[row as usize + 1] += 1;
            }
        }
        for node in 0..columns {
            start[node + 1] += start[node];
        }
        let mut next = start.clone();
        let mut ends = vec![0u32; start[columns]];
        for column in 0..columns {
            let slots = pattern.column(column);
            for &row in &pattern.rows()[slots.start + 1..slots.end] {
                for (from, to) in [(column, row), (row as usize, column as u32)] {
                    ends[next[from]] = to;
                    next[from] += 1;
                }
            }
        }
        let edge_weights = vec![1; ends.len()];
        Self { start, ends, edge_weights, node_weights: vec![1; columns] }
    }

    pub(super) fn nodes(&self) -> usize {
        self.node_weights.len()
    }

    pub(in crate::linear) fn neighbours(&self, node: usize) -> &[u32] {
        &self.ends[self.start[node]..self.start[node + 1]]
    }

    /// Neighbours with the weights of the edges to them.
    pub(super) fn edges(&self, node: usize) -> impl Iterator<Item = (u32, u32)> + '_ {
        let range = self.start[node]..self.start[node + 1];
        self.ends[range.clone()].iter().copied().zip(self.edge_weights[range].iter().copied())
    }

    pub(super) fn total_weight(&self) -> u64 {
        self.node_weights.iter().map(|&weight| u64::from(weight)).sum()
    }
}

/// Part of a finest graph (all weights one), with the names its nodes have there.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    pub(super) graph: Graph,
    pub(super) names: Vec<u32>,
}

impl Piece {
    pub(super) fn whole(graph: &Graph) -> Self {
        Self { graph: graph.clone(), names: (0..graph.nodes() as u32).collect() }
    }

    /// The connected components, in the order of their first nodes.
    pub(super) fn components(&self) -> Vec<Self> {
        let nodes = self.graph.nodes();
        let mut label = vec![u32::MAX; nodes];
        let mut stack = Vec::new();
        let mut count = 0;
        for seed in 0..nodes {
            if label[seed] != u32::MAX {
                continue;
            }
            label[seed] = count;
            stack.push(seed as u32);
            while let Some(node) = stack.pop() {
                for &next in self.graph.neighbours(node as usize) {
                    if label[next as usize] == u32::MAX {
                        label[next as usize] = count;
                        stack.push(next);
                    }
                }
            }
            count += 1;
        }
        if count <= 1 {
            return vec![self.clone()];
        }
        self.split(count as usize, |node| Some(label[node] as usize))
    }

    /// The two sides of a separator.
    pub(super) fn parts(&self, sides: &[Side]) -> Vec<Self> {
        self.split(2, |node| match sides[node] {
            Side::First => Some(0),
            Side::Second => Some(1),
            Side::Separator => None,
        })
    }

    /// The subgraphs of the nodes with equal `part`; edges between parts are dropped.
    fn split(&self, parts: usize, part: impl Fn(usize) -> Option<usize>) -> Vec<Self> {
        let mut members: Vec<Vec<u32>> = vec![Vec::new(); parts];
        let mut place = vec![u32::MAX; self.graph.nodes()];
        for node in 0..self.graph.nodes() {
            if let Some(part) = part(node) {
                place[node] = members[part].len() as u32;
                members[part].push(node as u32);
            }
        }
        let subgraph = |(own, members): (usize, &Vec<u32>)| {
            let mut start = Vec::with_capacity(members.len() + 1);
            let mut ends = Vec::new();
            start.push(0);
            for &node in members {
                let inside = |next: &&u32| part(**next as usize) == Some(own);
                let neighbours = self.graph.neighbours(node as usize).iter().filter(inside);
                ends.extend(neighbours.map(|&next| place[next as usize]));
                start.push(ends.len());
            }
            let edge_weights = vec![1; ends.len()];
            let graph = Graph { start, ends, edge_weights, node_weights: vec![1; members.len()] };
            Self { graph, names: members.iter().map(|&node| self.names[node as usize]).collect() }
        };
        members.iter().enumerate().map(subgraph).collect()
    }
}
