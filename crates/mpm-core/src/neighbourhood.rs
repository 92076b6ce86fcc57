//! The nodes around a particle: arenas, and the two inner loops over them.
//!
//! # Layout
//! A node is four numbers, (m, p_x, p_y, p_z) when scattered and (m, v_x, v_y, v_z) when gathered. An *arena* is the box of nodes that
//! the particles of one block may reach, contiguous, the last axis fastest. A *line* is the W nodes of a particle along the last
//! axis: in `f32` a register holds two nodes, in `f64` one, so a line is ⌈W/2⌉ or W registers. Where a line is padded, its last
//! node has weight zero.
//!
//! # Scatter
//! The momentum that a particle gives to the node i cells from its lowest one is an affine function of i times a product of
//! weights, so per register of a line only w_x w_y (G + i A + j B) is left, with G, A, B made once for all particles
//! of a pack, lanes across particles, then transposed. Forces by true gradients of the weights (not MLS) add
//! w'_x w_y X + w_x w'_y Y.
//!
//! # Gather
//! Separable: along the lines, then over j, then over i, which takes about half the operations of Σᵢⱼₖ.

use crate::kernel;
use mechanics_core::lanes::{Element, MOST_LANES, Packet};

/// Numbers of a node.
pub(crate) const NODE: usize = 4;

/// The largest number of registers of a line: cubic in `f64`.
const MOST_REGISTERS: usize = 4;

/// How far a particle may have moved from its block's cells before it must be sorted anew \[cells\].
pub(crate) const DRIFT: usize = 1;

/// The largest edge of an arena: eight cells of two dimensions, a cubic kernel, drift at both ends.
const MOST_SIDE_2: usize = 8 + 2 * DRIFT + 3;
const MOST_SIDE_3: usize = 4 + 2 * DRIFT + 3;

/// Room for the largest arena of any dimension and kernel, and for the padding of its last line.
pub(crate) const MOST_ARENA: usize = {
    let (plane, space) = (MOST_SIDE_2 * MOST_SIDE_2, MOST_SIDE_3 * MOST_SIDE_3 * MOST_SIDE_3);
    (if plane > space { plane } else { space } + 1) * NODE
};

/// Cells along the edge of a block: 4³ or 8² nodes are 64.
pub(crate) const fn block_edge(dimension: usize) -> usize {
    if dimension == 3 { 4 } else { 8 }
}

/// Nodes along the edge of an arena.
pub(crate) const fn arena_side(dimension: usize, width: usize) -> usize {
    block_edge(dimension) + 2 * DRIFT + width - 1
}

/// Numbers of an arena, its padding included.
pub(crate) const fn arena_length(dimension: usize, width: usize) -> usize {
    (arena_side(dimension, width).pow(dimension as u32) + 1) * NODE
}

/// Registers of a line.
const fn registers(width: usize, lanes: usize) -> usize {
    (width * NODE).div_ceil(lanes)
}

/// Strides of an arena between nodes along each axis, in numbers.
#[inline(always)]
fn strides<const D: usize, const W: usize>() -> [usize; D] {
    let side = arena_side(D, W);
    std::array::from_fn(|axis| NODE * side.pow((D - 1 - axis) as u32))
}

/// Where the particles of a pack are among the nodes.
pub(crate) struct Places<P: Packet, const D: usize, const W: usize> {
    /// The lowest node of each, relative to the arena's \[cells\].
    lowest: [P; D],
    /// The distance from it \[cells\].
    pub(crate) fraction: [P; D],
    /// Weights along each axis.
    weights: [[P; W]; D],
}

impl<P: Packet, const D: usize, const W: usize> Places<P, D, W> {
    /// For positions relative to the arena's lowest node \[cells\].
    #[inline(always)]
    pub(crate) fn new(position: &[P; D]) -> Self {
        let mut lowest = [P::constant(0.0); D];
        let mut fraction = lowest;
        let mut weights = [[P::constant(0.0); W]; D];
        for axis in 0..D {
            lowest[axis] = kernel::lowest_node::<P, W>(position[axis]);
            fraction[axis] = position[axis] - lowest[axis];
            weights[axis] = kernel::weights::<P, W>(fraction[axis]);
        }
        Self { lowest, fraction, weights }
    }

    /// Where in an arena the lowest node of each lane is, as a number without fraction.
    #[inline(always)]
    fn offsets(&self) -> <P::Element as Element>::Lanes {
        let strides = strides::<D, W>();
        let mut offset = P::constant(0.0);
        for axis in 0..D {
            offset = self.lowest[axis].mul_add(P::constant(strides[axis] as f64), offset);
        }
        offset.to_lanes()
    }

    /// Slopes of the weights along each axis \[1/cell\].
    #[inline(always)]
    fn slopes(&self) -> [[P; W]; D] {
        let mut slopes = [[P::constant(0.0); W]; D];
        for axis in 0..D {
            slopes[axis] = kernel::slopes::<P, W>(self.fraction[axis]);
        }
        slopes
    }
}

/// What each particle of a pack gives: to the node at i from its lowest one Πw · (mass, momentum + Σ_axis i_axis affine_axis), and, if
/// there are `impulses`, Σ_axis impulses_axis ∂(Πw)/∂i_axis more.
pub(crate) struct Gift<P, const D: usize> {
    pub(crate) mass: P,
    pub(crate) momentum: [P; D],
    /// By axis, then component.
    pub(crate) affine: [[P; D]; D],
    /// By axis, then component.
    pub(crate) impulses: Option<[[P; D]; D]>,
}

/// The registers of one line for each particle of a pack.
type Line<P> = [[P; MOST_LANES]; MOST_REGISTERS];

/// Registers of lines: lane r of register q of particle l is lane l of `nodes[k][channel]`, where node k = q · (LANES/4) + r/4 and
/// channel = r mod 4.
#[inline(always)]
fn lines<P: Packet, const W: usize>(nodes: &[[P; NODE]; W]) -> Line<P> {
    let mut lines = [[P::constant(0.0); MOST_LANES]; MOST_REGISTERS];
    for q in 0..registers(W, P::LANES) {
        for r in 0..P::LANES {
            let k = q * (P::LANES / NODE) + r / NODE;
            if k < W {
                lines[q][r] = nodes[k][r % NODE];
            }
        }
        P::transpose(&mut lines[q][..P::LANES]);
    }
    lines
}

/// The same for four equal channels.
#[inline(always)]
fn equal_lines<P: Packet, const W: usize>(numbers: &[P; W]) -> Line<P> {
    let mut nodes = [[P::constant(0.0); NODE]; W];
    for k in 0..W {
        nodes[k] = [numbers[k]; NODE];
    }
    lines(&nodes)
}

/// Lines of w_k · channels.
#[inline(always)]
fn weighted_lines<P: Packet, const W: usize>(weights: &[P; W], channels: &[P; NODE]) -> Line<P> {
    let mut nodes = [[P::constant(0.0); NODE]; W];
    for k in 0..W {
        for c in 0..NODE {
            nodes[k][c] = weights[k] * channels[c];
        }
    }
    lines(&nodes)
}

/// A vector as channels of a node.
#[inline(always)]
fn channels<P: Packet, const D: usize>(first: P, rest: &[P; D]) -> [P; NODE] {
    let mut channels = [P::constant(0.0); NODE];
    channels[0] = first;
    channels[1..=D].copy_from_slice(rest);
    channels
}

/// Adds what the first `alive` particles of a pack give to the nodes of an arena.
#[inline(always)]
pub(crate) fn scatter<P: Packet, const D: usize, const W: usize>(
    arena: &mut [P::Element],
    places: &Places<P, D, W>,
    gift: &Gift<P, D>,
    alive: usize,
) {
    let zero = P::constant(0.0);
    let strides = strides::<D, W>();
    let last = D - 1;
    let weights = &places.weights;
    let start = channels(gift.mass, &gift.momentum);
    let along = channels(zero, &gift.affine[last]);
    let sloping = gift.impulses.is_some();
    let impulses = gift.impulses.unwrap_or([[zero; D]; D]);
    let slopes = if sloping { places.slopes() } else { [[zero; W]; D] };
    // Nodes of a line: w_k (start + k along), and the slope's part of the last axis.
    let mut nodes = [[zero; NODE]; W];
    let steep = channels(zero, &impulses[last]);
    for k in 0..W {
        for c in 0..NODE {
            let affine = along[c].mul_add(P::constant(k as f64), start[c]);
            nodes[k][c] = weights[last][k] * affine;
            if sloping {
                nodes[k][c] = slopes[last][k].mul_add(steep[c], nodes[k][c]);
            }
        }
    }
    let g = lines(&nodes);
    let mut across: [Line<P>; 2] = [[[zero; MOST_LANES]; MOST_REGISTERS]; 2];
    let mut sloped: [Line<P>; 2] = across;
    for axis in 0..last {
        across[axis] = weighted_lines(&weights[last], &channels(zero, &gift.affine[axis]));
        if sloping {
            sloped[axis] = weighted_lines(&weights[last], &channels(zero, &impulses[axis]));
        }
    }
    // Weights of the lines: products over the other axes.
    let mut products = [zero.to_lanes(); 16];
    let mut inclined = [[zero.to_lanes(); 16]; 2];
    for i in 0..W {
        if D == 2 {
            products[i] = weights[0][i].to_lanes();
            if sloping {
                inclined[0][i] = slopes[0][i].to_lanes();
            }
            continue;
        }
        for j in 0..W {
            products[i * W + j] = (weights[0][i] * weights[1][j]).to_lanes();
            if sloping {
                inclined[0][i * W + j] = (slopes[0][i] * weights[1][j]).to_lanes();
                inclined[1][i * W + j] = (weights[0][i] * slopes[1][j]).to_lanes();
            }
        }
    }
    let offsets = places.offsets();
    let count = registers(W, P::LANES);
    let span = strides[0] * (W - 1) + if D == 3 { strides[1] * (W - 1) } else { 0 } + count * P::LANES;
    let inner = if D == 3 { W } else { 1 };
    for particle in 0..alive.min(P::LANES) {
        let offset = index(offsets.as_ref()[particle]);
        let window = &mut arena[offset..offset + span];
        for q in 0..count {
            let (mut row, a, b) = (g[q][particle], across[0][q][particle], across[1][q][particle]);
            let (x, y) = (sloped[0][q][particle], sloped[1][q][particle]);
            for i in 0..W {
                let mut value = row;
                for j in 0..inner {
                    let n = i * inner + j;
                    let at = i * strides[0] + if D == 3 { j * strides[1] } else { 0 } + q * P::LANES;
                    let node = &mut window[at..at + P::LANES];
                    let mut sum = P::splat(products[n].as_ref()[particle]).mul_add(value, P::load(node));
                    if sloping {
                        sum = P::splat(inclined[0][n].as_ref()[particle]).mul_add(x, sum);
                        if D == 3 {
                            sum = P::splat(inclined[1][n].as_ref()[particle]).mul_add(y, sum);
                        }
                    }
                    sum.store(node);
                    value += b;
                }
                row += a;
            }
        }
    }
}

/// A number without fraction as an index. Positions that are not finite give zero: they are refused before, and the slice's
/// bounds are checked.
#[inline(always)]
fn index<E: Element>(number: E) -> usize {
    let wide: f64 = number.into();
    wide as i32 as usize
}

/// Sums over the nodes of each particle of a pack.
pub(crate) struct Sums<P, const D: usize> {
    /// Σ w v, by component.
    pub(crate) velocity: [P; D],
    /// Σ w i_axis v, by axis, then component; i from the lowest node \[cells\].
    pub(crate) moments: [[P; D]; D],
    /// Σ v ∂w/∂x_axis, by axis, then component; zero unless asked for.
    pub(crate) slopes: [[P; D]; D],
}

/// What [`gather`] is asked for beside the velocity.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Wanted {
    /// Nothing.
    Velocity,
    /// The moments.
    Moments,
    /// The moments and the slopes.
    Slopes,
}

/// Interpolates the nodes of an arena to the first `alive` particles of a pack; the others' lanes are zero.
#[inline(always)]
pub(crate) fn gather<P: Packet, const D: usize, const W: usize>(
    arena: &[P::Element],
    places: &Places<P, D, W>,
    wanted: Wanted,
    alive: usize,
) -> Sums<P, D> {
    let zero = P::constant(0.0);
    let strides = strides::<D, W>();
    let last = D - 1;
    let weights = &places.weights;
    let moments_wanted = wanted != Wanted::Velocity;
    let slopes_wanted = wanted == Wanted::Slopes;
    let slopes = if slopes_wanted { places.slopes() } else { [[zero; W]; D] };
    let plain = equal_lines(&weights[last]);
    let mut moments = weights[last];
    for k in 0..W {
        moments[k] = moments[k].scale(k as f64);
    }
    let counted = equal_lines(&moments);
    let inclined = if slopes_wanted { equal_lines(&slopes[last]) } else { plain };
    let outer: [[<P::Element as Element>::Lanes; W]; 2] = lanes_of(&weights[..last]);
    let steep: [[<P::Element as Element>::Lanes; W]; 2] = lanes_of(&slopes[..last]);
    let offsets = places.offsets();
    let count = registers(W, P::LANES);
    let span = strides[0] * (W - 1) + if D == 3 { strides[1] * (W - 1) } else { 0 } + count * P::LANES;
    let inner = if D == 3 { W } else { 1 };
    // Sums by kind: velocity, moments of axes 0, 1, 2, slopes of axes 0, 1, 2; by particle.
    let mut sums = [[zero; MOST_LANES]; 7];
    for particle in 0..alive.min(P::LANES) {
        let offset = index(offsets.as_ref()[particle]);
        let window = &arena[offset..offset + span];
        let mut total = [zero; 7];
        for i in 0..W {
            // Over the lines of one i: Σ_j w_j of the line's sum, of its moment, of its slope; Σ_j j w_j and Σ_j w'_j of its sum.
            let (mut sum, mut moment, mut slope) = (zero, zero, zero);
            let (mut moment_across, mut slope_across) = (zero, zero);
            for j in 0..inner {
                let at = i * strides[0] + if D == 3 { j * strides[1] } else { 0 };
                let (mut s, mut m, mut t) = (zero, zero, zero);
                for q in 0..count {
                    let nodes = P::load(&window[at + q * P::LANES..at + (q + 1) * P::LANES]);
                    s = plain[q][particle].mul_add(nodes, s);
                    if moments_wanted {
                        m = counted[q][particle].mul_add(nodes, m);
                    }
                    if slopes_wanted {
                        t = inclined[q][particle].mul_add(nodes, t);
                    }
                }
                if D == 2 {
                    (sum, moment, slope) = (s, m, t);
                    continue;
                }
                let w = P::splat(outer[1][j].as_ref()[particle]);
                let weighted = w * s;
                sum += weighted;
                if moments_wanted {
                    moment = w.mul_add(m, moment);
                    moment_across = P::constant(j as f64).mul_add(weighted, moment_across);
                }
                if slopes_wanted {
                    slope = w.mul_add(t, slope);
                    slope_across = P::splat(steep[1][j].as_ref()[particle]).mul_add(s, slope_across);
                }
            }
            let w = P::splat(outer[0][i].as_ref()[particle]);
            let weighted = w * sum;
            total[0] += weighted;
            if moments_wanted {
                total[1] = P::constant(i as f64).mul_add(weighted, total[1]);
                total[1 + last] = w.mul_add(moment, total[1 + last]);
                if D == 3 {
                    total[2] = w.mul_add(moment_across, total[2]);
                }
            }
            if slopes_wanted {
                total[4] = P::splat(steep[0][i].as_ref()[particle]).mul_add(sum, total[4]);
                total[4 + last] = w.mul_add(slope, total[4 + last]);
                if D == 3 {
                    total[5] = w.mul_add(slope_across, total[5]);
                }
            }
        }
        for (kind, total) in total.into_iter().enumerate() {
            sums[kind][particle] = total;
        }
    }
    let velocity = components(&mut sums[0]);
    let mut moments = [[zero; D]; D];
    let mut gradients = [[zero; D]; D];
    for axis in 0..D {
        if moments_wanted {
            moments[axis] = components(&mut sums[1 + axis]);
        }
        if slopes_wanted {
            gradients[axis] = components(&mut sums[4 + axis]);
        }
    }
    Sums { velocity, moments, slopes: gradients }
}

/// The components of a vector, lanes across particles, from registers whose lanes are nodes and channels.
#[inline(always)]
fn components<P: Packet, const D: usize>(rows: &mut [P; MOST_LANES]) -> [P; D] {
    P::transpose(&mut rows[..P::LANES]);
    let mut components = [P::constant(0.0); D];
    for a in 0..D {
        components[a] = rows[1 + a];
        if P::LANES > NODE {
            components[a] += rows[NODE + 1 + a];
        }
    }
    components
}

#[inline(always)]
fn lanes_of<P: Packet, const W: usize>(axes: &[[P; W]]) -> [[<P::Element as Element>::Lanes; W]; 2] {
    let mut lanes = [[<P::Element as Element>::Lanes::default(); W]; 2];
    for (axis, numbers) in axes.iter().enumerate() {
        for k in 0..W {
            lanes[axis][k] = numbers[k].to_lanes();
        }
    }
    lanes
}
