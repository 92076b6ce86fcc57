//! Assembly: element Hessians over points become one [`BlockMatrix`] over unknowns, `H_qq = Wᵀ H_xx W`.
//!
//! For every element list it was given, the assembly remembers which block of the matrix each element block goes to
//! (its *slot*). A list that is the same as last time costs one comparison of its indices; a list that changed
//! (contacts) is looked up anew, alone. Blocks that the matrix does not have yet get slots behind the last one and
//! are sorted in when the assembly is finished. Blocks that no list uses any more stay, as zeros, until a quarter of
//! the matrix is stale, or until [`Assembly::begin_step`] asks for a tidy pattern: within a time step the pattern
//! mostly grows, so that the solver's symbolic work is mostly reused, and at a step's start it depends on the state
//! alone, so that a resumed run repeats the original one.
//!
//! Computing and adding are fused: the Hessians of a batch of elements are computed in parallel into a buffer that
//! fits in cache, then added in parallel, run of slots by run of slots, while the next batch is computed. Every block is summed in the order terms,
//! calls and elements come in, whatever the number of threads.
//!
//! Fixed points have no unknowns: their blocks are never stored.

mod call;
mod fingerprint;
mod pattern;

use crate::parallel;
use crate::point_map::PointMap;
use crate::sparse::BlockMatrix;
use crate::sparse::scatter::{MARK, TASK};
use crate::stencil::LocalHessian;
use crate::tensor::Mat3;
use call::Call;
use fingerprint::Fingerprint;
use pattern::{SlotIndex, StaleBlocks};

/// Blocks set to zero by one task.
const ZEROING: usize = 1 << 13;

/// A batch's Hessians take about this many bytes, so that they are still in cache when they are added.
const BATCH_BYTES: usize = 1 << 19;

/// How many elements on `corners` points form a batch: depends on the element alone, never on the machine.
fn batch_length(corners: usize) -> usize {
    (BATCH_BYTES / (corners * corners * size_of::<Mat3>())).clamp(64, 2048) / TASK * TASK
}

/// What an [`Assembly`] did so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AssemblyCounts {
    /// Matrices assembled.
    pub assemblies: u64,
    /// Element lists that had to be looked up, because they were new or had changed.
    pub lists_mapped: u64,
    /// Times the pattern of the matrix changed.
    pub pattern_changes: u64,
}

/// The matrix, and what is remembered from one assembly to the next. Begin one with [`Assembly::begin`].
#[derive(Debug)]
pub struct Assembly {
    map: PointMap,
    index: SlotIndex,
    /// One per slot: blocks of the pattern in order, then new ones.
    values: Vec<Mat3>,
    /// Memory that values move to when the pattern changes.
    spare: Vec<Mat3>,
    matrix: BlockMatrix,
    /// Per term, per call.
    calls: Vec<Vec<Call>>,
    scratch: Vec<Mat3>,
    tidying: Tidying,
    counts: AssemblyCounts,
}

/// When stale blocks are dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Tidying {
    /// When they are more than a quarter.
    WhenMany,
    /// At the end of the next assembly, whatever their number.
    Next,
}

impl Assembly {
    /// An assembly for the unknowns of `map`; the matrix is zero, with diagonal blocks only.
    pub fn new(map: &PointMap) -> Self {
        let index = SlotIndex::new(map.unknowns());
        let matrix = BlockMatrix::zeros(index.pattern().clone());
        Self {
            map: map.clone(),
            index,
            values: Vec::new(),
            spare: Vec::new(),
            matrix,
            calls: Vec::new(),
            scratch: Vec::new(),
            tidying: Tidying::WhenMany,
            counts: AssemblyCounts::default(),
        }
    }

    /// The matrix as last finished.
    pub fn matrix(&self) -> &BlockMatrix {
        &self.matrix
    }

    /// What was done so far.
    pub fn counts(&self) -> AssemblyCounts {
        self.counts
    }

    /// Asks that the next finished matrix have no stale blocks: its pattern then depends on the terms alone, not on
    /// what was assembled before.
    pub fn begin_step(&mut self) {
        self.tidying = Tidying::Next;
    }

    /// Begins a new matrix. If the weights of `map` are not those known, everything remembered is dropped.
    pub fn begin(&mut self, map: &PointMap) -> Assembler<'_> {
        if !self.map.same_weights(map) {
            let counts = self.counts;
            *self = Self { counts, ..Self::new(map) };
        }
        self.calls.iter_mut().flatten().for_each(Call::retire);
        self.values.resize(self.index.slots(), Mat3::zeros());
        parallel::for_each_chunk(&mut self.values, ZEROING, |_, values| values.fill(Mat3::zeros()));
        Assembler { assembly: self, term: 0, call: 0, fingerprint: None }
    }

    /// A fingerprint of the element lists that `visit` adds: the numbers of their terms, their points, and the order of it all.
    /// No Hessian is computed, and the assembly stays as it is. Equal lists have equal fingerprints; others differ but for a
    /// coincidence of probability 2⁻⁶⁴.
    pub fn fingerprint(&mut self, visit: impl FnOnce(&mut Assembler<'_>)) -> u64 {
        let fingerprint = Some(Fingerprint::default());
        let mut assembler = Assembler { assembly: self, term: 0, call: 0, fingerprint };
        visit(&mut assembler);
        assembler.fingerprint.map_or(0, Fingerprint::value)
    }

    fn finish(&mut self) {
        for call in self.calls.iter_mut().flat_map(|calls| calls.extract_if(.., |call| !call.is_current())) {
            self.index.release(call.slots());
        }
        let many = 4 * self.index.stale() > self.index.slots();
        let tidying = std::mem::replace(&mut self.tidying, Tidying::WhenMany);
        let drop = tidying == Tidying::Next || many;
        let stale_blocks = if drop { StaleBlocks::Drop } else { StaleBlocks::Keep };
        self.counts.assemblies += 1;
        if let Some(new_slot) = self.index.rebuild(stale_blocks) {
            self.counts.pattern_changes += 1;
            self.calls.iter_mut().flatten().for_each(|call| call.renumber(&new_slot));
            self.spare.clear();
            self.spare.resize(self.index.slots(), Mat3::zeros());
            for (value, &slot) in self.values.iter().zip(&new_slot) {
                if slot != pattern::DROPPED {
                    self.spare[slot as usize] = *value;
                }
            }
            std::mem::swap(&mut self.values, &mut self.spare);
        }
        let values = std::mem::take(&mut self.values);
        let old = std::mem::replace(
            &mut self.matrix,
            BlockMatrix::from_blocks(self.index.pattern().clone(), values),
        );
        self.values = old.into_blocks();
    }
}

/// Takes element Hessians and adds them to the matrix being assembled; see [`Assembly::begin`].
///
/// A matrix is complete after [`finish`](Self::finish); one that is dropped before leaves the assembly as good as
/// new.
#[derive(Debug)]
pub struct Assembler<'a> {
    assembly: &'a mut Assembly,
    term: usize,
    call: usize,
    /// Where lists only leave their fingerprint.
    fingerprint: Option<Fingerprint>,
}

impl<'a> Assembler<'a> {
    /// Says that the element lists to come belong to term number `term`, counted from the first.
    ///
    /// # Panics
    /// If lists were added to that term before: they are recognised by their position, and would be overwritten.
    pub fn begin_term(&mut self, term: usize) {
        if let Some(fingerprint) = &mut self.fingerprint {
            return fingerprint.add_term(term);
        }
        let begun =
            self.assembly.calls.get(term).and_then(|calls| calls.first()).is_some_and(Call::is_current);
        assert!(!begun, "the lists of term {term} were added before");
        (self.term, self.call) = (term, 0);
    }

    /// Adds the Hessians of `elements`, given by their point numbers; `hessian(element)` computes one.
    ///
    /// # Panics
    /// If a point number is out of range.
    pub fn add<const N: usize>(
        &mut self,
        elements: &[[u32; N]],
        hessian: impl Fn(usize) -> LocalHessian<N> + Sync,
    ) {
        self.add_batches(elements, |first, hessians| {
            for (k, local) in hessians.iter_mut().enumerate() {
                *local = hessian(first + k);
            }
        });
    }

    /// Adds the Hessians of `elements`, given by their point numbers; `kernel(first, hessians)` overwrites the lower
    /// triangles (`[i][j]`, `i ≥ j`) of those of the elements `first..first + hessians.len()`. It is called with at
    /// most 32 elements at a time, a multiple of 8 but at the end of the list, and may compute them in lanes.
    ///
    /// # Panics
    /// If a point number is out of range.
    pub fn add_batches<const N: usize>(
        &mut self,
        elements: &[[u32; N]],
        kernel: impl Fn(usize, &mut [LocalHessian<N>]) + Sync,
    ) {
        if let Some(fingerprint) = &mut self.fingerprint {
            return fingerprint.add_list(N, elements.as_flattened());
        }
        self.remember(elements);
        let Assembly { calls, scratch, values, .. } = &mut *self.assembly;
        let scatter = calls[self.term][self.call].scatter_map();
        self.call += 1;
        let room = scatter.room() * N * N;
        if scratch.len() < room {
            scratch.resize(room, Mat3::zeros());
        }
        let hessians: &mut [LocalHessian<N>] = scratch[..room].as_chunks_mut::<N>().0.as_chunks_mut::<N>().0;
        scatter.accumulate(hessians, values, kernel, |target, hessians, source, weight| {
            add_block(target, hessians.as_flattened().as_flattened(), source, weight);
        });
    }

    /// Ends the assembly and answers the matrix.
    pub fn finish(self) -> &'a BlockMatrix {
        self.assembly.finish();
        &self.assembly.matrix
    }

    /// Makes sure that the call to come has an up-to-date map.
    fn remember<const N: usize>(&mut self, elements: &[[u32; N]]) {
        let Assembly { calls, index, map, values, counts, .. } = &mut *self.assembly;
        if calls.len() <= self.term {
            calls.resize_with(self.term + 1, Vec::new);
        }
        let calls = &mut calls[self.term];
        let flat = elements.as_flattened();
        if let Some(known) = calls.get_mut(self.call).filter(|known| known.is_for(N, flat)) {
            known.renew();
            return;
        }
        counts.lists_mapped += 1;
        let call = Call::new(N, flat, batch_length(N), map, index);
        index.retain(call.slots());
        values.resize(index.slots(), Mat3::zeros());
        match calls.get_mut(self.call) {
            Some(known) => index.release(std::mem::replace(known, call).slots()),
            None => calls.push(call),
        }
    }
}

#[inline(always)]
fn add_block(target: &mut Mat3, blocks: &[Mat3], source: u32, weight: f64) {
    let block = &blocks[(source & !MARK) as usize];
    if source & MARK == 0 {
        *target += block * weight;
    } else {
        *target += block.transpose() * weight;
    }
}
