//! A tree of boxes around triangles.

use mechanics_core::tensor::Vec3;

/// Triangles of a leaf, at most.
const LEAF: usize = 4;

/// Levels of a tree over `u32::MAX` triangles, and some.
const MOST_LEVELS: usize = 48;

/// Boxes are told from triangles a little farther away, so that rounding hides no triangle that is as near as the nearest one.
const SLACK: f64 = 1.0 - 1e-9;

/// A box along the axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    low: Vec3,
    high: Vec3,
}

impl Bounds {
    const EMPTY: Self = Self {
        low: Vec3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        high: Vec3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    /// Around points.
    pub(super) fn of(points: &[Vec3]) -> Self {
        points.iter().fold(Self::EMPTY, |all, p| Self { low: all.low.inf(p), high: all.high.sup(p) })
    }

    /// Larger by `margin` on every side.
    pub(super) fn grown(&self, margin: f64) -> Self {
        Self { low: self.low.add_scalar(-margin), high: self.high.add_scalar(margin) }
    }

    fn hull(&self, other: &Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }

    fn meets(&self, other: &Self) -> bool {
        (0..3).all(|a| self.low[a] <= other.high[a] && other.low[a] <= self.high[a])
    }

    fn square_to(&self, place: &Vec3) -> f64 {
        (0..3).map(|a| (self.low[a] - place[a]).max(place[a] - self.high[a]).max(0.0).powi(2)).sum()
    }

    fn twice_centre(&self, axis: usize) -> f64 {
        self.low[axis] + self.high[axis]
    }
}

/// A leaf has `count` > 0 triangles from `first` on; the children of another node are the next one and `first`.
#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Bounds,
    first: u32,
    count: u32,
}

/// Boxes of boxes, split at the median of the longest side.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    nodes: Vec<Node>,
}

impl Tree {
    /// The tree, and the triangles in its order: number k of the tree is triangle `order[k]`.
    pub(super) fn build(boxes: &[Bounds]) -> (Self, Vec<u32>) {
        let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
        let mut tree = Self { nodes: Vec::with_capacity(2 * boxes.len() / LEAF + 1) };
        if !boxes.is_empty() {
            tree.split(boxes, &mut order, 0);
        }
        (tree, order)
    }

    fn split(&mut self, boxes: &[Bounds], order: &mut [u32], first: usize) {
        let bounds = order.iter().fold(Bounds::EMPTY, |all, t| all.hull(&boxes[*t as usize]));
        let at = self.nodes.len();
        self.nodes.push(Node { bounds, first: first as u32, count: order.len() as u32 });
        if order.len() <= LEAF {
            return;
        }
        let axis = (bounds.high - bounds.low).imax();
        let half = order.len() / 2;
        order.select_nth_unstable_by(half, |a, b| {
            let [a, b] = [a, b].map(|t| (boxes[*t as usize].twice_centre(axis), *t));
            a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
        });
        let (low, high) = order.split_at_mut(half);
        self.split(boxes, low, first);
        let second = self.nodes.len() as u32;
        (self.nodes[at].first, self.nodes[at].count) = (second, 0);
        self.split(boxes, high, first + half);
    }

    /// Calls `visit(triangle)`, which answers a squared distance, for the triangles that may be within the square root of `best` of a place.
    ///
    /// Whatever `best` is at first, no triangle is passed over that is as near as the nearest one to 10⁻⁹.
    pub(super) fn visit_nearest(&self, place: &Vec3, mut best: f64, mut visit: impl FnMut(usize) -> f64) {
        let mut stack = [(0_u32, 0.0); MOST_LEVELS];
        let mut height = usize::from(!self.nodes.is_empty());
        while height > 0 {
            height -= 1;
            let (at, square) = stack[height];
            if square * SLACK > best {
                continue;
            }
            let node = &self.nodes[at as usize];
            if node.count > 0 {
                for triangle in node.first..node.first + node.count {
                    best = best.min(visit(triangle as usize));
                }
                continue;
            }
            let [near, far] =
                [at + 1, node.first].map(|k| (k, self.nodes[k as usize].bounds.square_to(place)));
            // The nearer child is looked at first.
            let (near, far) = if near.1 <= far.1 { (near, far) } else { (far, near) };
            for child in [far, near] {
                stack[height] = child;
                height += 1;
            }
        }
    }

    /// Calls `visit(triangle)` for all triangles of leaves that meet a box.
    pub(super) fn visit_meeting(&self, bounds: &Bounds, mut visit: impl FnMut(usize)) {
        let mut stack = [0_u32; MOST_LEVELS];
        let mut height = usize::from(!self.nodes.is_empty());
        while height > 0 {
            height -= 1;
            let at = stack[height];
            let node = &self.nodes[at as usize];
            if !node.bounds.meets(bounds) {
                continue;
            }
            if node.count > 0 {
                (node.first..node.first + node.count).for_each(|triangle| visit(triangle as usize));
                continue;
            }
            for child in [node.first, at + 1] {
                stack[height] = child;
                height += 1;
            }
        }
    }
}
