//! The nodes around a particle: arenas, and the two inner loops over them.
//!
//! # Layout
//! A node is four numbers when scattered, (m, p_x, p_y, p_z), and when gathered four in space, (m, v_x, v_y, v_z), and two in the plane, (v_x, v_y). An *arena* is the
//! box of nodes that the particles of one block may reach, contiguous, the last axis fastest. A *line* is the W nodes of a particle along the last
//! axis: of four numbers each a register holds two in `f32` and one in `f64`, so a line is ⌈W/2⌉ or W registers; of two it holds twice as many. Where a line is padded, its
//! last nodes have weight zero or are not read.
//!
//! # Scatter
//! The momentum that a particle gives to the node (i, j, k) from its lowest one is affine in (i, j, k) times a product of
//! weights: w_i w_j · w_k (S + k A_k + i A_i + j A_j). S and the A are made with lanes across particles and transposed, to four channels
//! (m, p) of one particle; per register of a line only w_i w_j · (G + i A + j B) is left, one fused multiplication. Forces by true
//! gradients of the weights (not MLS) add w'_i w_j X + w_i w'_j Y.
//!
//! # Gather
//! Separable: over j, then over i, lanes across nodes and channels; then transposed, and along the lines with lanes across particles. That
//! takes about half the operations of Σᵢⱼₖ, and moments share their products with the plain sums.

use crate::kernel;
use mechanics_core::lanes::{Element, MOST_LANES, Packet};

/// Numbers of a node.
pub(crate) const NODE: usize = 4;

/// How far a particle may have moved from its block's cells before it must be sorted anew \[cells\].
pub(crate) const DRIFT: usize = 1;

/// Numbers of a node that is gathered: the mass is left where the rest without it fits into half of the registers.
pub(crate) const fn gathered(dimension: usize) -> usize {
    if dimension == 2 { 2 } else { NODE }
}

/// Room for the largest arena of velocities of a dimension, that of a cubic kernel, and for the padding of its last line.
pub(crate) const fn most_velocities(dimension: usize) -> usize {
    velocities_length(dimension, 4)
}

/// Numbers of an arena of velocities, its padding included.
pub(crate) const fn velocities_length(dimension: usize, width: usize) -> usize {
    arena_side(dimension, width).pow(dimension as u32) * gathered(dimension) + NODE
}

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

/// Registers of a line of nodes of so many numbers; W at most.
const fn registers(width: usize, node: usize, lanes: usize) -> usize {
    (width * node).div_ceil(lanes)
}

/// Strides of an arena between nodes of so many numbers along each axis, in numbers.
#[inline(always)]
fn strides<const D: usize, const W: usize>(node: usize) -> [usize; D] {
    let side = arena_side(D, W);
    std::array::from_fn(|axis| node * side.pow((D - 1 - axis) as u32))
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

    /// Where in an arena of these strides the lowest node of each lane is, as a number without fraction.
    #[inline(always)]
    fn offsets(&self, strides: &[usize; D]) -> <P::Element as Element>::Lanes {
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

/// Numbers of four vectors of four channels, as [`rows_into`] has them for a particle.
const ROW: usize = 4 * NODE;

/// [`ROW`] consecutive numbers a particle, for all particles of a pack.
type Rows<P> = [<<P as Packet>::Element as Element>::Lanes; ROW];

/// Four vectors of four channels, from lanes across particles to [`ROW`] consecutive numbers a particle. Into room of the caller: what is returned would be copied.
#[inline(always)]
fn rows_into<P: Packet>(vectors: &[[P; NODE]; 4], rows: &mut Rows<P>) {
    let parts = ROW / P::LANES;
    for part in 0..parts {
        let mut block = [P::constant(0.0); MOST_LANES];
        for r in 0..P::LANES {
            let n = part * P::LANES + r;
            block[r] = vectors[n / NODE][n % NODE];
        }
        P::transpose(&mut block[..P::LANES]);
        for particle in 0..P::LANES {
            rows[particle * parts + part] = block[particle].to_lanes();
        }
    }
}

/// A vector of four channels of a particle, for each of the nodes of a register.
#[inline(always)]
fn vector<P: Packet>(rows: &Rows<P>, particle: usize, n: usize) -> P {
    let at = particle * ROW + n * NODE;
    let first = at % P::LANES;
    P::load_repeated(&rows[at / P::LANES].as_ref()[first..first + NODE])
}

/// Numbers of the nodes of register `q` of a line, for each of their channels: `first` of its first node, and `second` of its second
/// one if it has two.
#[inline(always)]
fn of_nodes<P: Packet>(first: P, second: P) -> P {
    if P::LANES > NODE { P::halves(first, second) } else { first }
}

/// The weights of a particle for the nodes of register `q` of a line; zero beyond its end.
#[inline(always)]
fn on_line<P: Packet, const W: usize>(
    weights: &[<P::Element as Element>::Lanes; W],
    particle: usize,
    q: usize,
) -> P {
    let k = q * (P::LANES / NODE);
    let second = if k + 1 < W { P::splat(weights[k + 1].as_ref()[particle]) } else { P::constant(0.0) };
    of_nodes(P::splat(weights[k].as_ref()[particle]), second)
}

/// A vector as channels of a node.
#[inline(always)]
fn channels<P: Packet, const D: usize>(first: P, rest: &[P; D]) -> [P; NODE] {
    let mut channels = [P::constant(0.0); NODE];
    channels[0] = first;
    channels[1..=D].copy_from_slice(rest);
    channels
}

/// Channels of D vectors; the last axis comes third in either dimension.
#[inline(always)]
fn by_axis<P: Packet, const D: usize>(first: [P; NODE], vectors: &[[P; D]; D]) -> [[P; NODE]; 4] {
    let zero = P::constant(0.0);
    let mut all = [first, [zero; NODE], [zero; NODE], channels(zero, &vectors[D - 1])];
    for axis in 0..D - 1 {
        all[1 + axis] = channels(zero, &vectors[axis]);
    }
    all
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
    let strides = strides::<D, W>(NODE);
    let last = D - 1;
    let weights = &places.weights;
    let mut given = [zero.to_lanes(); ROW];
    rows_into(&by_axis(channels(gift.mass, &gift.momentum), &gift.affine), &mut given);
    let sloping = gift.impulses.is_some();
    let mut impulses = [zero.to_lanes(); ROW];
    if let Some(given) = &gift.impulses {
        rows_into(&by_axis([zero; NODE], given), &mut impulses);
    }
    let slopes = if sloping { places.slopes() } else { [[zero; W]; D] };
    let (along, steep) = (lanes_of(&weights[last]), lanes_of(&slopes[last]));
    // Weights of the lines: products over the other axes.
    let mut products = [[zero.to_lanes(); W]; W];
    let mut inclined = [products; 2];
    for i in 0..W {
        if D == 2 {
            products[i][0] = weights[0][i].to_lanes();
            inclined[0][i][0] = slopes[0][i].to_lanes();
            continue;
        }
        for j in 0..W {
            products[i][j] = (weights[0][i] * weights[1][j]).to_lanes();
            inclined[0][i][j] = (slopes[0][i] * weights[1][j]).to_lanes();
            inclined[1][i][j] = (weights[0][i] * slopes[1][j]).to_lanes();
        }
    }
    let offsets = places.offsets(&strides);
    let count = registers(W, NODE, P::LANES);
    let span = strides[0] * (W - 1) + if D == 3 { strides[1] * (W - 1) } else { 0 } + count * P::LANES;
    let inner = if D == 3 { W } else { 1 };
    for particle in 0..alive.min(P::LANES) {
        let offset = offsets.as_ref()[particle].to_index();
        let window = &mut arena[offset..offset + span];
        for q in 0..count {
            // Of the nodes of a register: w_k (start + k along), and what a step along the other axes adds.
            let w = on_line::<P, W>(&along, particle, q);
            let first = (q * (P::LANES / NODE)) as f64;
            let number = of_nodes(P::constant(first), P::constant(first + 1.0));
            let (a, b) = (w * vector::<P>(&given, particle, 1), w * vector::<P>(&given, particle, 2));
            let mut row =
                w * number.mul_add(vector::<P>(&given, particle, 3), vector::<P>(&given, particle, 0));
            let (mut x, mut y) = (zero, zero);
            if sloping {
                row = on_line::<P, W>(&steep, particle, q).mul_add(vector::<P>(&impulses, particle, 3), row);
                (x, y) = (w * vector::<P>(&impulses, particle, 1), w * vector::<P>(&impulses, particle, 2));
            }
            for i in 0..W {
                let mut value = row;
                for j in 0..inner {
                    let at = i * strides[0] + if D == 3 { j * strides[1] } else { 0 } + q * P::LANES;
                    let node = &mut window[at..at + P::LANES];
                    let mut sum = P::splat(products[i][j].as_ref()[particle]).mul_add(value, P::load(node));
                    if sloping {
                        sum = P::splat(inclined[0][i][j].as_ref()[particle]).mul_add(x, sum);
                        if D == 3 {
                            sum = P::splat(inclined[1][i][j].as_ref()[particle]).mul_add(y, sum);
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

/// Sums over the lines of each particle of a pack: by register of a line, then particle.
type Lines<P, const W: usize> = [[P; MOST_LANES]; W];

/// Room for a gather: made once for many packs.
pub(crate) struct GatherScratch<P, const W: usize> {
    /// Σ w of the lines' nodes.
    plain: Lines<P, W>,
    /// Σ w i_axis, of the axes that are not the last.
    moments: [Lines<P, W>; 2],
    /// Σ ∂w/∂x_axis, of the axes that are not the last.
    slopes: [Lines<P, W>; 2],
}

impl<P: Packet, const W: usize> GatherScratch<P, W> {
    #[inline(always)]
    pub(crate) fn new() -> Self {
        let zero = [[P::constant(0.0); MOST_LANES]; W];
        Self { plain: zero, moments: [zero; 2], slopes: [zero; 2] }
    }

    /// Free lanes give nothing.
    #[inline(always)]
    fn clear_from(&mut self, alive: usize) {
        let Self { plain, moments: [m0, m1], slopes: [s0, s1] } = self;
        for lines in [plain, m0, m1, s0, s1] {
            for line in lines {
                for particle in alive..P::LANES {
                    line[particle] = P::constant(0.0);
                }
            }
        }
    }
}

/// Σ w_i n_i, Σ i w_i n_i and, with slopes w′, Σ w′_i n_i.
#[inline(always)]
fn contracted<P: Packet, const W: usize>(
    numbers: &[P; W],
    weights: &[P; W],
    slopes: Option<&[P; W]>,
) -> [P; 3] {
    let mut sums = [weights[0] * numbers[0], P::constant(0.0), P::constant(0.0)];
    for i in 1..W {
        let part = weights[i] * numbers[i];
        sums[0] += part;
        sums[1] = if i == 1 { part } else { P::constant(i as f64).mul_add(part, sums[1]) };
    }
    if let Some(slopes) = slopes {
        sums[2] = slopes[0] * numbers[0];
        for i in 1..W {
            sums[2] = slopes[i].mul_add(numbers[i], sums[2]);
        }
    }
    sums
}

/// Interpolates the nodes of an arena of velocities to the first `alive` particles of a pack; the others' lanes are zero.
#[inline(always)]
pub(crate) fn gather<P: Packet, const D: usize, const W: usize>(
    arena: &[P::Element],
    places: &Places<P, D, W>,
    wanted: Wanted,
    alive: usize,
    scratch: &mut GatherScratch<P, W>,
) -> Sums<P, D> {
    let zero = P::constant(0.0);
    let strides = strides::<D, W>(gathered(D));
    let weights = &places.weights;
    let sloping = wanted == Wanted::Slopes;
    let slopes = if sloping { places.slopes() } else { [[zero; W]; D] };
    let (outer, steep) = (lanes_of(&weights[0]), lanes_of(&slopes[0]));
    let (middle, steep_middle) = (lanes_of(&weights[1]), lanes_of(&slopes[1]));
    let offsets = places.offsets(&strides);
    let count = registers(W, gathered(D), P::LANES);
    let span = strides[0] * (W - 1) + if D == 3 { strides[1] * (W - 1) } else { 0 } + count * P::LANES;
    for particle in 0..alive.min(P::LANES) {
        let offset = offsets.as_ref()[particle].to_index();
        let window = &arena[offset..offset + span];
        let (w, v) = (splats::<P, W>(&outer, particle), splats::<P, W>(&middle, particle));
        let (dw, dv) = (splats::<P, W>(&steep, particle), splats::<P, W>(&steep_middle, particle));
        for q in 0..count {
            // Over j: plain, moments, slopes; by i.
            let mut across = [[zero; W]; 3];
            for i in 0..W {
                let mut nodes = [zero; W];
                for j in 0..if D == 3 { W } else { 1 } {
                    let at = i * strides[0] + if D == 3 { j * strides[1] } else { 0 } + q * P::LANES;
                    nodes[j] = P::load(&window[at..at + P::LANES]);
                }
                let sums = match D {
                    2 => [nodes[0], zero, zero],
                    _ => contracted(&nodes, &v, sloping.then_some(&dv)),
                };
                for kind in 0..3 {
                    across[kind][i] = sums[kind];
                }
            }
            let [plain, moment, slope] = contracted(&across[0], &w, sloping.then_some(&dw));
            scratch.plain[q][particle] = plain;
            if wanted != Wanted::Velocity {
                scratch.moments[0][q][particle] = moment;
                if D == 3 {
                    scratch.moments[1][q][particle] = contracted(&across[1], &w, None)[0];
                }
            }
            if sloping {
                scratch.slopes[0][q][particle] = slope;
                if D == 3 {
                    scratch.slopes[1][q][particle] = contracted(&across[2], &w, None)[0];
                }
            }
        }
    }
    if alive < P::LANES {
        scratch.clear_from(alive);
    }
    along_lines(scratch, places, wanted, &slopes)
}

/// Sums along the lines, lanes across particles.
#[inline(always)]
fn along_lines<P: Packet, const D: usize, const W: usize>(
    scratch: &GatherScratch<P, W>,
    places: &Places<P, D, W>,
    wanted: Wanted,
    slopes: &[[P; W]; D],
) -> Sums<P, D> {
    let last = D - 1;
    let weights = &places.weights[last];
    let mut sums = Sums {
        velocity: [P::constant(0.0); D],
        moments: [[P::constant(0.0); D]; D],
        slopes: [[P::constant(0.0); D]; D],
    };
    let sloping = wanted == Wanted::Slopes;
    let plain = by_node::<P, D, W>(&scratch.plain);
    for a in 0..D {
        let [velocity, moment, slope] = contracted(&plain[a], weights, sloping.then_some(&slopes[last]));
        sums.velocity[a] = velocity;
        sums.moments[last][a] = moment;
        sums.slopes[last][a] = slope;
    }
    for axis in 0..last {
        if wanted != Wanted::Velocity {
            let nodes = by_node::<P, D, W>(&scratch.moments[axis]);
            for a in 0..D {
                sums.moments[axis][a] = contracted(&nodes[a], weights, None)[0];
            }
        }
        if sloping {
            let nodes = by_node::<P, D, W>(&scratch.slopes[axis]);
            for a in 0..D {
                sums.slopes[axis][a] = contracted(&nodes[a], weights, None)[0];
            }
        }
    }
    sums
}

/// The components of a vector at each node of the lines, lanes across particles; by component, then node.
#[inline(always)]
fn by_node<P: Packet, const D: usize, const W: usize>(lines: &Lines<P, W>) -> [[P; W]; D] {
    let mut nodes = [[P::constant(0.0); W]; D];
    // A mass comes before the velocity, if it is there.
    let (count, before) = (gathered(D), gathered(D) - D);
    for q in 0..registers(W, count, P::LANES) {
        let mut block = lines[q];
        P::transpose(&mut block[..P::LANES]);
        for r in 0..P::LANES {
            let (k, channel) = (q * (P::LANES / count) + r / count, r % count);
            if k < W && before <= channel {
                nodes[channel - before][k] = block[r];
            }
        }
    }
    nodes
}

/// One number of each weight on all lanes.
#[inline(always)]
fn splats<P: Packet, const W: usize>(
    weights: &[<P::Element as Element>::Lanes; W],
    particle: usize,
) -> [P; W] {
    let mut splats = [P::constant(0.0); W];
    for k in 0..W {
        splats[k] = P::splat(weights[k].as_ref()[particle]);
    }
    splats
}

#[inline(always)]
fn lanes_of<P: Packet, const W: usize>(weights: &[P; W]) -> [<P::Element as Element>::Lanes; W] {
    let mut lanes = [<P::Element as Element>::Lanes::default(); W];
    for k in 0..W {
        lanes[k] = weights[k].to_lanes();
    }
    lanes
}
