use super::graph::Graph;

/// Coarsening stops at so many nodes …
const COARSEST: usize = 50;

/// … or when a level keeps more than this fraction of the nodes.
const STALLED: f64 = 0.92;

/// No mate.
const NONE: u32 = u32::MAX;

/// A coarser graph and the coarse node of each fine node.
pub(super) struct Level {
    pub(super) graph: Graph,
    pub(super) coarse: Vec<u32>,
}

/// Ever coarser versions of `graph`, the coarsest last; empty if it is coarse enough.
pub(super) fn coarsen(graph: &Graph) -> Vec<Level> {
    let heaviest = (graph.total_weight() as f64 * 1.5 / COARSEST as f64).ceil() as u32;
    let mut levels: Vec<Level> = Vec::new();
    loop {
        let finest = levels.last().map_or(graph, |level| &level.graph);
        if finest.nodes() <= COARSEST {
            return levels;
        }
        let level = contract(finest, &matching(finest, heaviest.max(2)));
        let stalled = level.graph.nodes() as f64 > STALLED * finest.nodes() as f64;
        levels.push(level);
        if stalled {
            return levels;
        }
    }
}

/// Pairs nodes along heavy edges, those with few neighbours first, since they have the least choice; then pairs
/// what is left over around a common neighbour, without which a star would never shrink.
fn matching(graph: &Graph, heaviest: u32) -> Vec<u32> {
    let nodes = graph.nodes();
    let mut mate = vec![NONE; nodes];
    for node in visiting_order(graph) {
        if mate[node as usize] != NONE {
            continue;
        }
        let weight = graph.node_weights[node as usize];
        let free = graph.edges(node as usize).filter(|&(end, _)| {
            mate[end as usize] == NONE && weight + graph.node_weights[end as usize] <= heaviest
        });
        let light_end = |end: u32| std::cmp::Reverse(graph.node_weights[end as usize]);
        if let Some((end, _)) = free.max_by_key(|&(end, edge)| (edge, light_end(end))) {
            mate[node as usize] = end;
            mate[end as usize] = node;
        }
    }
    let mut waiting = vec![NONE; nodes];
    for node in 0..nodes {
        if mate[node] != NONE {
            continue;
        }
        let Some(&hub) = graph.neighbours(node).first() else { continue };
        let other = std::mem::replace(&mut waiting[hub as usize], node as u32);
        let fits = |other: u32| graph.node_weights[other as usize] + graph.node_weights[node] <= heaviest;
        if other != NONE && fits(other) {
            mate[node] = other;
            mate[other as usize] = node as u32;
            waiting[hub as usize] = NONE;
        }
    }
    mate
}

/// By degree, equal degrees in a scrambled but fixed order: mesh order would chain the pairs into stripes.
fn visiting_order(graph: &Graph) -> Vec<u32> {
    let mut order: Vec<u32> = (0..graph.nodes() as u32).collect();
    order.sort_by_key(|&node| (graph.neighbours(node as usize).len(), node.wrapping_mul(0x9e37_79b1), node));
    order
}

/// Melts pairs into one node each.
fn contract(graph: &Graph, mate: &[u32]) -> Level {
    let nodes = graph.nodes();
    let mut coarse = vec![NONE; nodes];
    let mut members: Vec<(usize, Option<usize>)> = Vec::with_capacity(nodes);
    for node in 0..nodes {
        if coarse[node] == NONE {
            coarse[node] = members.len() as u32;
            let other = (mate[node] != NONE).then_some(mate[node] as usize);
            if let Some(other) = other {
                coarse[other] = members.len() as u32;
            }
            members.push((node, other));
        }
    }
    let mut start = vec![0usize];
    let (mut ends, mut edge_weights) = (Vec::<u32>::new(), Vec::<u32>::new());
    let mut place = vec![usize::MAX; members.len()];
    let mut node_weights = Vec::with_capacity(members.len());
    for (own, &(node, other)) in members.iter().enumerate() {
        let first = ends.len();
        let pair = std::iter::once(node).chain(other);
        node_weights.push(pair.clone().map(|member| graph.node_weights[member]).sum());
        for (end, weight) in pair.flat_map(|member| graph.edges(member)) {
            let end = coarse[end as usize];
            if end as usize == own {
                continue;
            }
            let known = place[end as usize];
            if known != usize::MAX && known >= first {
                edge_weights[known] += weight;
            } else {
                place[end as usize] = ends.len();
                ends.push(end);
                edge_weights.push(weight);
            }
        }
        start.push(ends.len());
    }
    Level { graph: Graph { start, ends, edge_weights, node_weights }, coarse }
}
