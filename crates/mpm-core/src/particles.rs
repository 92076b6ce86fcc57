//! Particles in memory: packs of as many as a register has lanes, each pack one number after the other, each number for all
//! lanes (an array of structures of arrays). Packs belong to blocks of cells; the last pack of a block may have free lanes.

use crate::MpmError;
use crate::kernel;
use crate::neighbourhood::{DRIFT, block_edge};
use mechanics_core::lanes::{Element, Packet};
use mechanics_core::parallel;
use std::collections::BTreeMap;

/// The number of a free lane.
pub(crate) const FREE: u32 = u32::MAX;

/// Cells from the origin that have numbers; beyond, `f32` cannot tell them apart and blocks overflow.
pub(crate) const FARTHEST_CELL: f64 = 4_194_304.0;

/// Slots that a thread takes at a time when particles are sorted: whole packs.
const SLOTS: usize = 8192;

/// Numbers of a pack in a line of the caches: 32 bytes a number in either precision.
const TOGETHER: usize = 2;

/// Which numbers a particle has, and in which order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Layout {
    pub(crate) velocity: usize,
    pub(crate) gradient: usize,
    pub(crate) strain: usize,
    pub(crate) history: usize,
    /// The stress and its stiffness kept from the last step, where the law flows; otherwise none.
    pub(crate) stress: usize,
    pub(crate) mass: usize,
    pub(crate) volume: usize,
    /// D² numbers of the total deformation gradient, by column, where it is tracked beside the strain; otherwise none.
    pub(crate) total: usize,
    pub(crate) count: usize,
}

impl Layout {
    /// For `dimension` axes, and so many numbers of strain, history, and kept stress and stiffness.
    pub(crate) const fn new(dimension: usize, strain: usize, history: usize, stress: usize) -> Self {
        let velocity = dimension;
        let gradient = velocity + dimension;
        let strain_at = gradient + dimension * dimension;
        let history_at = strain_at + strain;
        let stress_at = history_at + history;
        let mass = stress_at + stress;
        Self {
            velocity,
            gradient,
            strain: strain_at,
            history: history_at,
            stress: stress_at,
            mass,
            volume: mass + 1,
            total: mass + 2,
            count: mass + 2,
        }
    }

    /// The same with room for a total deformation gradient of so many numbers.
    pub(crate) const fn with_total(self, numbers: usize) -> Self {
        Self { count: self.total + numbers, ..self }
    }

    /// Whether there is a total deformation gradient beside the strain.
    pub(crate) const fn tracks_total(&self) -> bool {
        self.count > self.total
    }
}

/// Consecutive packs whose particles were in one block of cells when they were sorted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ParticleBlock<const D: usize> {
    /// Coordinates of the block.
    pub(crate) origin: [i32; D],
    /// Its packs end here; they begin where the block before ends.
    pub(crate) end: usize,
    /// Particles in it.
    pub(crate) count: usize,
}

impl<const D: usize> ParticleBlock<D> {
    /// Whether a particle here is within the arena of the block, or nowhere (NaN), which the nodes notice.
    fn reaches(&self, position: &[f64; D], spacing: f64, width: usize) -> bool {
        let edge = block_edge(D) as f64;
        // The lowest node is the integer nearest to `lowest`; a hundredth of a cell is left to rounding.
        let half = 0.5 * (width - 1) as f64;
        let (low, high) = (-(DRIFT as f64) - 0.5, edge - 1.0 + DRIFT as f64 + 0.5);
        self.origin.iter().all(|o| f64::from(*o).abs() * edge <= 2.0 * FARTHEST_CELL)
            && position.iter().zip(&self.origin).all(|(x, o)| {
                let lowest = x / spacing - half - f64::from(*o) * edge;
                !(lowest < low - 1e-2 || lowest > high + 1e-2)
            })
    }
}

/// Whether the blocks say where particles are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Order {
    /// Every particle is within the reach of its block.
    Fresh,
    /// Some have left it; all will be sorted before the next step.
    Stale,
}

/// Particles as a checkpoint has them.
pub(crate) struct Stored<E, const D: usize> {
    pub(crate) data: Vec<E>,
    pub(crate) ids: Vec<u32>,
    pub(crate) blocks: Vec<ParticleBlock<D>>,
}

/// All particles of a body.
#[derive(Clone, Debug)]
pub(crate) struct Particles<E, const D: usize> {
    pub(crate) layout: Layout,
    /// Pack by pack, number by number, lane by lane.
    pub(crate) data: Vec<E>,
    /// The particle on each lane, or [`FREE`].
    pub(crate) ids: Vec<u32>,
    pub(crate) blocks: Vec<ParticleBlock<D>>,
    /// Where the data of each block ends.
    pub(crate) ends: Vec<usize>,
    pub(crate) count: usize,
    scratch: Vec<E>,
}

/// The numbers of one pack.
#[inline(always)]
pub(crate) fn load<P: Packet, const N: usize>(pack: &[P::Element], first: usize) -> [P; N] {
    let mut numbers = [P::constant(0.0); N];
    for (k, number) in numbers.iter_mut().enumerate() {
        *number = P::load(&pack[(first + k) * P::LANES..][..P::LANES]);
    }
    numbers
}

/// Overwrites numbers of one pack.
#[inline(always)]
pub(crate) fn store<P: Packet, const N: usize>(pack: &mut [P::Element], first: usize, numbers: &[P; N]) {
    for (k, number) in numbers.iter().enumerate() {
        number.store(&mut pack[(first + k) * P::LANES..][..P::LANES]);
    }
}

impl<E: Element, const D: usize> Particles<E, D> {
    /// `count` particles whose number k is `number(particle, k)`; not yet sorted into blocks.
    pub(crate) fn new(layout: Layout, count: usize, number: impl Fn(usize, usize) -> E) -> Self {
        let packs = count.div_ceil(E::LANES);
        let mut data = vec![E::default(); packs * layout.count * E::LANES];
        let mut ids = vec![FREE; packs * E::LANES];
        for slot in 0..packs * E::LANES {
            // Free lanes repeat the last particle: whatever is computed on them is finite.
            let particle = slot.min(count - 1);
            if slot < count {
                ids[slot] = slot as u32;
            }
            for k in 0..layout.count {
                data[at(&layout, slot, k, E::LANES)] = number(particle, k);
            }
        }
        Self { layout, data, ids, blocks: Vec::new(), ends: Vec::new(), count, scratch: Vec::new() }
    }

    /// Number `k` of the particle in `slot`.
    pub(crate) fn number(&self, slot: usize, k: usize) -> E {
        self.data[at(&self.layout, slot, k, E::LANES)]
    }

    /// Overwrites number `k` of the particle in `slot`.
    pub(crate) fn set_number(&mut self, slot: usize, k: usize, value: E) {
        self.data[at(&self.layout, slot, k, E::LANES)] = value;
    }

    /// Bytes of everything that grows with the particles.
    pub(crate) fn bytes(&self) -> usize {
        let numbers = std::mem::size_of_val(&self.data[..]) + self.scratch.capacity() * size_of::<E>();
        let blocks = std::mem::size_of_val(&self.blocks[..]) + std::mem::size_of_val(&self.ends[..]);
        numbers + std::mem::size_of_val(&self.ids[..]) + blocks
    }

    /// Numbers of a pack.
    pub(crate) fn pack_length(&self) -> usize {
        self.layout.count * E::LANES
    }

    /// Sorts the particles by the block and cell of the lowest node that they reach, and starts every block with a new pack.
    ///
    /// # Errors
    /// [`MpmError::TooFar`] or [`MpmError::Particle`] for a position without a cell; the order is as it was.
    pub(crate) fn sort(&mut self, body: usize, spacing: f64, width: usize) -> Result<(), MpmError> {
        let edge = block_edge(D) as i32;
        let mut index: BTreeMap<[i32; D], u32> = BTreeMap::new();
        let mut found: Vec<[i32; D]> = Vec::new();
        // Per slot: block in order of appearance, and cell in it.
        let mut keys: Vec<(u32, u32)> = Vec::with_capacity(self.ids.len());
        let mut recent = ([i32::MAX; D], 0);
        let lowest = self.lowest_nodes(body, spacing, width)?;
        for (lowest, id) in lowest.into_iter().flatten().zip(&self.ids) {
            if *id == FREE {
                keys.push((FREE, 0));
                continue;
            }
            let block = lowest.map(|node| node.div_euclid(edge));
            let cell = lowest.iter().fold(0, |cell, node| cell * edge + node.rem_euclid(edge));
            if block != recent.0 {
                let number = *index.entry(block).or_insert_with(|| {
                    found.push(block);
                    found.len() as u32 - 1
                });
                recent = (block, number);
            }
            keys.push((recent.1, cell as u32));
        }
        let mut order: Vec<u32> = (0..found.len() as u32).collect();
        order.sort_unstable_by_key(|k| found[*k as usize]);
        let mut rank = vec![0_u32; found.len()];
        for (place, k) in order.iter().enumerate() {
            rank[*k as usize] = place as u32;
        }
        self.arrange(&keys, &rank, &order, &found);
        Ok(())
    }

    /// Confirms that every particle has a cell, so that [`sort`](Self::sort) succeeds.
    ///
    /// # Errors
    /// As `sort`.
    pub(crate) fn check_places(&self, body: usize, spacing: f64, width: usize) -> Result<(), MpmError> {
        self.lowest_nodes(body, spacing, width).map(|_| ())
    }

    /// The lowest node that each particle reaches, by slot, in parts; anything for free lanes.
    fn lowest_nodes(&self, body: usize, spacing: f64, width: usize) -> Result<Vec<Vec<[i32; D]>>, MpmError> {
        let lowest = |slot: usize| match self.ids[slot] {
            FREE => Ok([0; D]),
            _ => self.lowest_node(body, slot, spacing, width),
        };
        let parts = parallel::map_chunks(self.ids.len(), SLOTS, |slots| slots.map(lowest).collect());
        parts.into_iter().collect()
    }

    /// The lowest node that a particle reaches.
    fn lowest_node(
        &self,
        body: usize,
        slot: usize,
        spacing: f64,
        width: usize,
    ) -> Result<[i32; D], MpmError> {
        let position: [f64; D] = std::array::from_fn(|axis| self.number(slot, axis).into());
        let cells = position.map(|x| x / spacing);
        if cells.iter().any(|x| x.abs().partial_cmp(&FARTHEST_CELL) != Some(std::cmp::Ordering::Less)) {
            let particle = self.ids[slot] as usize;
            if let Some(value) = position.into_iter().find(|x| !x.is_finite()) {
                let (what, wanted) = ("position", "finite");
                return Err(MpmError::Particle { body, particle, what, value, wanted });
            }
            let (position, limit) = (position.to_vec(), FARTHEST_CELL);
            return Err(MpmError::TooFar { body, particle, position, limit, spacing });
        }
        Ok(cells.map(|x| match width {
            2 => kernel::lowest_node::<f64, 2>(x) as i32,
            3 => kernel::lowest_node::<f64, 3>(x) as i32,
            _ => kernel::lowest_node::<f64, 4>(x) as i32,
        }))
    }

    fn arrange(&mut self, keys: &[(u32, u32)], rank: &[u32], order: &[u32], found: &[[i32; D]]) {
        let lanes = E::LANES;
        let cells = block_edge(D).pow(D as u32);
        // A counting sort: places of every block and cell, blocks beginning with a pack.
        let mut next = vec![0_usize; found.len() * cells];
        for &(block, cell) in keys.iter().filter(|key| key.0 != FREE) {
            next[rank[block as usize] as usize * cells + cell as usize] += 1;
        }
        self.blocks.clear();
        self.ends.clear();
        let mut slots = 0;
        for (place, counts) in next.chunks_mut(cells).enumerate() {
            let start = slots;
            for count in counts {
                let here = *count;
                *count = slots;
                slots += here;
            }
            let count = slots - start;
            slots = slots.next_multiple_of(lanes);
            let end = slots / lanes;
            self.blocks.push(ParticleBlock { origin: found[order[place] as usize], end, count });
            self.ends.push(end * self.pack_length());
        }
        let mut source = vec![FREE; slots];
        for (slot, &(block, cell)) in keys.iter().enumerate().filter(|(_, key)| key.0 != FREE) {
            let place = &mut next[rank[block as usize] as usize * cells + cell as usize];
            source[*place] = slot as u32;
            *place += 1;
        }
        let mut recent = 0;
        let old_ids = std::mem::take(&mut self.ids);
        self.ids =
            source.iter().map(|slot| if *slot == FREE { FREE } else { old_ids[*slot as usize] }).collect();
        for slot in &mut source {
            // Free lanes repeat the particle before them.
            if *slot == FREE {
                *slot = recent;
            }
            recent = *slot;
        }
        let length = slots * self.layout.count;
        if self.data.len() < length {
            self.data.resize(length, E::default());
        }
        self.move_from(&source);
        self.data.truncate(length);
    }

    /// Gives every slot the numbers of its source; a line of the caches at a time, so that little scratch suffices and every line is read once.
    fn move_from(&mut self, source: &[u32]) {
        let (layout, lanes) = (self.layout, E::LANES);
        self.scratch.resize(source.len() * TOGETHER, E::default());
        for first in (0..layout.count).step_by(TOGETHER) {
            let together = TOGETHER.min(layout.count - first);
            let data = &self.data;
            parallel::for_each_chunk(&mut self.scratch, SLOTS * TOGETHER, |start, part| {
                for (numbers, slot) in part.chunks_exact_mut(TOGETHER).zip(&source[start / TOGETHER..]) {
                    let from = at(&layout, *slot as usize, first, lanes);
                    for (k, number) in numbers.iter_mut().enumerate().take(together) {
                        *number = data[from + k * lanes];
                    }
                }
            });
            let (scratch, length) = (&self.scratch, source.len() * layout.count);
            parallel::for_each_chunk(&mut self.data[..length], SLOTS * layout.count, |start, packs| {
                let packs = packs.chunks_exact_mut(layout.count * lanes);
                let parts = scratch[start / layout.count * TOGETHER..].chunks_exact(lanes * TOGETHER);
                for (pack, numbers) in packs.zip(parts) {
                    for k in 0..together {
                        let targets = &mut pack[(first + k) * lanes..][..lanes];
                        for (target, numbers) in targets.iter_mut().zip(numbers.chunks_exact(TOGETHER)) {
                            *target = numbers[k];
                        }
                    }
                }
            });
        }
    }

    /// Confirms that `stored` is a state of these particles, which can go on without a panic.
    ///
    /// # Errors
    /// What is wrong.
    pub(crate) fn check_stored(
        &self,
        stored: &Stored<E, D>,
        spacing: f64,
        width: usize,
        order: Order,
    ) -> Result<(), &'static str> {
        let Stored { data, ids, blocks } = stored;
        if ids.len() % E::LANES != 0 || data.len() != ids.len() * self.layout.count {
            return Err("too many or too few numbers");
        }
        let mut found = vec![0_u8; self.count];
        for id in ids.iter().filter(|id| **id != FREE) {
            *found.get_mut(*id as usize).ok_or("a particle beyond the last one")? |= 1;
        }
        let live = ids.iter().filter(|id| **id != FREE).count();
        if live != self.count || found.contains(&0) {
            return Err("a particle that is missing or there twice");
        }
        if order == Order::Stale {
            return Ok(());
        }
        let mut first = 0;
        for block in blocks {
            let slots = first * E::LANES..block.end.saturating_mul(E::LANES);
            let in_order = first < block.end && slots.end <= ids.len() && block.count <= slots.len();
            if !in_order {
                return Err("blocks out of order");
            }
            let (live, free) = ids[slots.clone()].split_at(block.count);
            if live.contains(&FREE) || free.iter().any(|id| *id != FREE) {
                return Err("free lanes in the middle of a block");
            }
            for slot in slots.start..slots.start + block.count {
                let position = std::array::from_fn(|k| data[at(&self.layout, slot, k, E::LANES)].into());
                if !block.reaches(&position, spacing, width) {
                    return Err("a particle away from its block");
                }
            }
            first = block.end;
        }
        if first * E::LANES == ids.len() { Ok(()) } else { Err("particles without block") }
    }

    /// Goes on from a state that [`check_stored`](Self::check_stored) accepts.
    pub(crate) fn restore(&mut self, stored: Stored<E, D>) {
        let length = self.pack_length();
        self.data = stored.data;
        self.ids = stored.ids;
        self.blocks = stored.blocks;
        self.ends = self.blocks.iter().map(|block| block.end * length).collect();
    }

    /// The slot of every particle.
    pub(crate) fn slots(&self) -> Vec<u32> {
        let mut slots = vec![FREE; self.count];
        for (slot, id) in self.ids.iter().enumerate().filter(|(_, id)| **id != FREE) {
            slots[*id as usize] = slot as u32;
        }
        slots
    }
}

/// Where number `k` of the particle in `slot` is.
#[inline(always)]
pub(crate) fn at(layout: &Layout, slot: usize, k: usize, lanes: usize) -> usize {
    (slot / lanes * layout.count + k) * lanes + slot % lanes
}
