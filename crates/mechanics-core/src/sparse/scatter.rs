//! Parallel scattering: many element contributions summed into slots, with the bits of the plain loop.
//!
//! The plain loop takes the elements in order, a small run at a time, and adds their contributions to the slots at
//! once, while they are in the first cache. One thread does just that.
//!
//! **Several threads** each own some of the slots, a *window*. Every thread runs the plain loop, but only over those
//! elements that touch its window, and adds only what falls into it. Whatever the windows, a slot has one owner, and
//! its owner adds the contributions to it one by one in element order, as the plain loop does: the bits are
//! the same. Elements that touch two windows are the *border*: about one layer of elements a cut (4 % of a cube of
//! 100,000 tetrahedra cut in two). A thin one is computed by every thread that touches it, which costs less than
//! to store its results and to wait for them; a thick one, as contacts have it, is computed before, once, in
//! parallel. After that threads share nothing that is written and never wait for each other.
//!
//! **What a window is.** The slots are cut into 32 to 64 *pieces* of equal size. Elements are taken in *groups* of
//! eight, so that vector lanes stay full and hold the same elements whatever the windows; a group touches a set of
//! pieces, a number with one bit for each. Pieces are put in the order of the mean number of the groups that touch them, and
//! cut into windows where those counts are halved. In a mesh of sensible numbering that is the order of the slots, and windows are
//! intervals. In contacts of two bodies, whose elements name points of both, pieces that meet have the same mean: a window has a
//! part of the one body and the part of the other that lies on it.
//!
//! Short lists in wild order, of which more than half is border, are left to the plain loop of one thread: nothing is gained there.
//!
//! For long lists in wild order (a shuffled mesh) nearly all elements are border, more than fit into a cache. They go the
//! other way: *batches* are computed once, in parallel, into a buffer that
//! stays in cache; then every thread walks through the whole batch and adds what falls into its window, while
//! the next batch is computed. Again each slot is summed by one thread in element order.

use crate::parallel;
use std::ops::Range;
use std::sync::OnceLock;

/// Elements that are computed together.
pub(crate) const GROUP: usize = 8;

/// Elements computed at once, at most.
const RUN: usize = 4 * GROUP;

/// Their results take about this many bytes, so that they are in the first cache when they are added.
const RUN_BYTES: usize = 3 << 13;

/// With less than this many elements a thread, there are fewer threads.
const LEAST: usize = 128;

/// Lists of fewer elements in all, most of which are border, are left to one thread: to wake helpers for every small batch takes longer than the
/// plain loop. (Lists with less border that are as short are slower on two threads too: the contacts of three spheres, 5,863 pairs with 75 ns each, take
/// 1.7 times as long there, and are not caught by this.)
const LEAST_WILD: usize = 1 << 13;

/// The results of a batch take about this many bytes, so that they are still in cache when they are added.
const BATCH_BYTES: usize = 1 << 19;

/// The results of a border may take this many bytes, or be those of one in this many groups.
const BORDER_BYTES: usize = 1 << 22;
const BORDER_PART: usize = 8;

/// A border of at most one in this many groups is computed by every thread that touches it.
const THIN_BORDER: usize = 16;

/// Groups of a border computed by one task.
const BORDER_TASK: usize = 8;

/// Pieces at most: bits of [`Pieces`].
const PIECES: usize = Pieces::BITS as usize;

/// A set of pieces.
type Pieces = u64;

/// At most so many groups say in which order pieces come.
const SAMPLES: usize = 1024;

/// Groups whose pieces are found out by one task.
const LOOKING: usize = 512;

/// What a list of elements adds to slots: results computed first.
pub(crate) trait Contributions: Sync {
    /// What one element contributes.
    type Result: Copy + Send + Sync;
    /// What results are added to.
    type Slot: Send;
    /// Any result, to be overwritten.
    const BLANK: Self::Result;

    /// How many elements there are.
    fn elements(&self) -> usize;

    /// Overwrites the results of the elements `first..first + results.len()`; `first` is a multiple of [`GROUP`].
    fn compute(&self, first: usize, results: &mut [Self::Result]);

    /// Adds these results to the slots they belong to, in order, as far as `slots` has them.
    fn add<S: Slots<Self::Slot>>(&self, first: usize, results: &[Self::Result], slots: &mut S);

    /// Calls `visit` with every slot that a group of elements touches.
    fn for_each_slot(&self, group: Range<usize>, visit: impl FnMut(u32));
}

/// The slots a thread may write to.
pub(crate) trait Slots<T> {
    /// A slot, if it is among them.
    fn slot(&mut self, slot: u32) -> Option<&mut T>;
}

impl<T> Slots<T> for [T] {
    #[inline(always)]
    fn slot(&mut self, slot: u32) -> Option<&mut T> {
        self.get_mut(slot as usize)
    }
}

impl<T> Slots<T> for &mut [T] {
    #[inline(always)]
    fn slot(&mut self, slot: u32) -> Option<&mut T> {
        self.get_mut(slot as usize)
    }
}

/// The slots of one thread.
pub(crate) enum Window<'a, T> {
    /// Consecutive pieces, as a mesh of sensible numbering has them: the cheaper to look up.
    Interval(Interval<'a, T>),
    /// Pieces that lie apart.
    Apart(Apart<'a, T>),
}

/// Consecutive slots.
pub(crate) struct Interval<'a, T> {
    first: u32,
    slots: &'a mut [T],
}

/// Pieces that lie apart.
pub(crate) struct Apart<'a, T> {
    /// Slots a piece, as a power of two.
    shift: u32,
    /// All pieces; those of others are empty here.
    pieces: Vec<&'a mut [T]>,
}

impl<T> Slots<T> for Interval<'_, T> {
    #[inline(always)]
    fn slot(&mut self, slot: u32) -> Option<&mut T> {
        self.slots.get_mut(slot.wrapping_sub(self.first) as usize)
    }
}

impl<T> Slots<T> for Apart<'_, T> {
    #[inline(always)]
    fn slot(&mut self, slot: u32) -> Option<&mut T> {
        let within = slot as usize & ((1 << self.shift) - 1);
        self.pieces.get_mut((slot >> self.shift) as usize)?.get_mut(within)
    }
}

impl<T: Send> Window<'_, T> {
    /// Adds results of a list as far as they fall in here.
    fn add<C: Contributions<Slot = T>>(&mut self, list: &C, first: usize, results: &[C::Result]) {
        match self {
            Self::Interval(window) => list.add(first, results, window),
            Self::Apart(window) => list.add(first, results, window),
        }
    }
}

/// A window and which pieces it has.
pub(crate) struct Share<'a, T> {
    owned: Pieces,
    window: Window<'a, T>,
}

/// One list of elements, whatever its results are.
pub(crate) trait Scattered<T>: Sync {
    /// How many elements there are.
    fn count(&self) -> usize;

    /// The pieces that a group touches.
    fn pieces_of(&self, group: usize, shift: u32) -> Pieces;

    /// The plain loop.
    fn add_all(&self, slots: &mut [T]);

    /// Bytes that the results of a group take.
    fn group_bytes(&self) -> usize;

    /// Computes the border, if it is worth it.
    fn with_border<'b>(&'b self, touched: &'b [Pieces], border: Vec<u32>) -> Box<dyn Bordered<T> + 'b>;

    /// Computes every element once; adds one batch while the next is computed.
    fn add_batches(&self, shares: &mut [Share<'_, T>]);
}

/// A list of elements whose border is known.
pub(crate) trait Bordered<T>: Send + Sync {
    /// The plain loop over those groups that touch a window; neighbouring ones are taken together.
    fn add_touching(&self, share: &mut Share<'_, T>);
}

/// The results of a border.
struct Border<'b, C: Contributions> {
    list: &'b C,
    /// The pieces that each group touches.
    touched: &'b [Pieces],
    /// The groups of the border, ascending.
    groups: Vec<u32>,
    /// Their results; none if every thread computes them for itself.
    results: Vec<C::Result>,
}

impl<C: Contributions> Bordered<C::Slot> for Border<'_, C> {
    fn add_touching(&self, Share { owned, window }: &mut Share<'_, C::Slot>) {
        let Self { list, touched, .. } = self;
        let (run, elements) = (run_length::<C::Result>(), list.elements());
        let mut results = vec![C::BLANK; run.min(touched.len() * GROUP)];
        let mut border = self.groups.iter().zip(self.results.chunks(GROUP)).peekable();
        let (owned, is_known) = (*owned, !self.results.is_empty());
        let is_own = |touched: &Pieces| touched & owned != 0 && !(is_known && touched & !owned != 0);
        let mut group = 0;
        while group < touched.len() {
            let first = group * GROUP;
            let own = touched[group..].iter().take(run / GROUP).take_while(|t| is_own(t)).count();
            if own > 0 {
                let results = &mut results[..(own * GROUP).min(elements - first)];
                list.compute(first, results);
                window.add(*list, first, results);
            } else if touched[group] & owned != 0 {
                while border.next_if(|(number, _)| (**number as usize) < group).is_some() {}
                if let Some((_, results)) = border.next() {
                    window.add(*list, first, &results[..GROUP.min(elements - first)]);
                }
            }
            group += own.max(1);
        }
    }
}

impl<C: Contributions> Scattered<C::Slot> for C {
    fn count(&self) -> usize {
        self.elements()
    }

    fn pieces_of(&self, group: usize, shift: u32) -> Pieces {
        let mut pieces = 0;
        let elements = group * GROUP..((group + 1) * GROUP).min(self.elements());
        self.for_each_slot(elements, |slot| pieces |= 1 << (slot >> shift));
        pieces
    }

    fn add_all(&self, mut slots: &mut [C::Slot]) {
        let (run, elements) = (run_length::<C::Result>(), self.elements());
        let mut results = vec![C::BLANK; run.min(elements)];
        for first in (0..elements).step_by(run) {
            let results = &mut results[..run.min(elements - first)];
            self.compute(first, results);
            self.add(first, results, &mut slots);
        }
    }

    fn group_bytes(&self) -> usize {
        GROUP * size_of::<C::Result>()
    }

    fn with_border<'b>(&'b self, touched: &'b [Pieces], groups: Vec<u32>) -> Box<dyn Bordered<C::Slot> + 'b> {
        let is_thin = groups.len() * THIN_BORDER <= touched.len();
        let mut results = vec![C::BLANK; if is_thin { 0 } else { groups.len() * GROUP }];
        parallel::for_each_chunk(&mut results, BORDER_TASK * GROUP, |at, results| {
            for (&group, results) in groups[at / GROUP..].iter().zip(results.chunks_mut(GROUP)) {
                let first = group as usize * GROUP;
                self.compute(first, &mut results[..GROUP.min(self.elements() - first)]);
            }
        });
        Box::new(Border { list: self, touched, groups, results })
    }

    fn add_batches(&self, shares: &mut [Share<'_, C::Slot>]) {
        let elements = self.elements();
        if elements == 0 {
            return;
        }
        let batch = (BATCH_BYTES / size_of::<C::Result>().max(1)).clamp(64, 4096) / RUN * RUN;
        let range = |number: usize| number * batch..((number + 1) * batch).min(elements);
        let fill = |number: usize, results: &mut [C::Result]| {
            let range = range(number);
            let task = |at: usize, results: &mut [C::Result]| self.compute(range.start + at, results);
            parallel::for_each_chunk(&mut results[..range.len()], RUN, task);
        };
        let empty = |number: usize, results: &[C::Result], shares: &mut [Share<'_, C::Slot>]| {
            let range = range(number);
            for_each_share(shares, |share| share.window.add(self, range.start, &results[..range.len()]));
        };
        let buffer = vec![C::BLANK; batch.min(elements)];
        let (mut now, mut next) = (buffer.clone(), buffer);
        let batches = elements.div_ceil(batch);
        fill(0, &mut now);
        for number in 1..batches {
            parallel::join(|| empty(number - 1, &now, shares), || fill(number, &mut next));
            std::mem::swap(&mut now, &mut next);
        }
        empty(batches - 1, &now, shares);
    }
}

/// How the elements of some lists lie among the slots: what is needed to share them out among any number of threads.
#[derive(Clone, Debug)]
struct Layout {
    /// Slots a piece, as a power of two.
    shift: u32,
    /// The pieces that each group touches, list after list.
    touched: Vec<Pieces>,
    /// The pieces that are touched at all, by the mean number of the groups that do, and how many these are.
    order: Vec<(u32, u64)>,
}

impl Layout {
    fn new<T>(lists: &[&dyn Scattered<T>], slots: usize) -> Self {
        let shift = slots.div_ceil(PIECES).next_power_of_two().trailing_zeros();
        let mut touched = vec![0; lists.iter().map(|list| list.count().div_ceil(GROUP)).sum()];
        let mut rest = touched.as_mut_slice();
        for list in lists {
            let (own, behind) = rest.split_at_mut(list.count().div_ceil(GROUP));
            parallel::map_into(own, LOOKING, |group| list.pieces_of(group, shift));
            rest = behind;
        }
        let order = by_mean_group(&touched);
        Self { shift, touched, order }
    }

    fn shares<'a, T>(&self, slots: &'a mut [T], count: usize) -> Vec<Share<'a, T>> {
        let total: u64 = self.order.iter().map(|(_, touching)| touching).sum();
        // Pieces that nothing touches go with the one before them, so that intervals stay whole.
        let mut owner = [usize::MAX; PIECES];
        let mut before = 0;
        for &(piece, touching) in &self.order {
            // The window in which the middle of what touches this piece lies.
            owner[piece as usize] = ((2 * before + touching) * count as u64 / (2 * total)) as usize;
            before += touching;
        }
        let mut last = 0;
        for owner in &mut owner {
            last = if *owner == usize::MAX { last } else { *owner };
            *owner = last;
        }
        let owner = &owner[..slots.len().div_ceil(1 << self.shift)];
        let windows = if owner.is_sorted() {
            self.intervals(slots, count, owner)
        } else {
            self.apart(slots, count, owner)
        };
        let owned = |window: usize| {
            (0..)
                .zip(owner)
                .filter(|(_, own)| **own == window)
                .fold(0, |set: Pieces, (piece, _)| set | 1 << piece)
        };
        windows.into_iter().enumerate().map(|(k, window)| Share { owned: owned(k), window }).collect()
    }

    fn intervals<'a, T>(&self, slots: &'a mut [T], count: usize, owner: &[usize]) -> Vec<Window<'a, T>> {
        let (mut rest, mut first) = (slots, 0);
        let mut windows = Vec::with_capacity(count);
        for window in 0..count {
            let pieces = owner.iter().filter(|own| **own == window).count();
            let (own, behind) = rest.split_at_mut((pieces << self.shift).min(rest.len()));
            windows.push(Window::Interval(Interval { first, slots: own }));
            first += (pieces << self.shift) as u32;
            rest = behind;
        }
        windows
    }

    fn apart<'a, T>(&self, slots: &'a mut [T], count: usize, owner: &[usize]) -> Vec<Window<'a, T>> {
        let mut pieces: Vec<Vec<&'a mut [T]>> = (0..count).map(|_| Vec::with_capacity(PIECES)).collect();
        for (piece, slots) in slots.chunks_mut(1 << self.shift).enumerate() {
            pieces.iter_mut().for_each(|pieces| pieces.push(&mut []));
            pieces[owner[piece]][piece] = slots;
        }
        pieces.into_iter().map(|pieces| Window::Apart(Apart { shift: self.shift, pieces })).collect()
    }

    /// Is more than half of all groups border?
    fn is_wild<T>(&self, shares: &[Share<'_, T>]) -> bool {
        let border = self.touched.iter().filter(|touched| is_border(**touched, shares)).count();
        2 * border > self.touched.len()
    }

    /// The border, list by list, each with its groups' pieces; none if its results are too many to be kept.
    fn border<'b, T>(
        &'b self,
        lists: &[&dyn Scattered<T>],
        shares: &[Share<'_, T>],
    ) -> Option<Vec<(&'b [Pieces], Vec<u32>)>> {
        let mut rest = self.touched.as_slice();
        let (mut borders, mut bytes, mut groups) = (Vec::with_capacity(lists.len()), 0, 0);
        for list in lists {
            let (own, behind) = rest.split_at(list.count().div_ceil(GROUP));
            let border = (0..).zip(own).filter(|(_, touched)| is_border(**touched, shares));
            let border: Vec<u32> = border.map(|(group, _)| group).collect();
            bytes += border.len() * list.group_bytes();
            groups += border.len();
            borders.push((own, border));
            rest = behind;
        }
        (bytes <= BORDER_BYTES || BORDER_PART * groups <= self.touched.len()).then_some(borders)
    }
}

/// Does a group that touches these pieces touch several windows?
fn is_border<T>(touched: Pieces, shares: &[Share<'_, T>]) -> bool {
    shares.iter().filter(|share| touched & share.owned != 0).count() > 1
}

/// The pieces that are touched, in the order of the mean number of the groups that touch them; and how many groups do. A sample of
/// the groups says so: another order, or a piece left out, costs time and nothing else.
fn by_mean_group(touched: &[Pieces]) -> Vec<(u32, u64)> {
    let (mut counts, mut sums) = ([0_u64; PIECES], [0_u64; PIECES]);
    let stride = touched.len().div_ceil(SAMPLES).max(1);
    for (group, &pieces) in (0..).zip(touched).step_by(stride) {
        let mut rest = pieces;
        while rest != 0 {
            let piece = rest.trailing_zeros() as usize;
            counts[piece] += 1;
            sums[piece] += group;
            rest &= rest - 1;
        }
    }
    let mut order: Vec<(u32, u64)> = (0..).zip(counts).filter(|(_, touching)| *touching > 0).collect();
    let mean = |piece: u32| sums[piece as usize] as f64 / counts[piece as usize] as f64;
    order.sort_by(|a, b| mean(a.0).total_cmp(&mean(b.0)));
    order
}

/// Adds the contributions of lists of elements to slots.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scatter {
    layout: OnceLock<Layout>,
}

impl Scatter {
    /// To be called when elements touch other slots than before.
    pub(crate) fn forget(&mut self) {
        self.layout = OnceLock::new();
    }

    /// Adds all contributions, list after list. What elements touch must not change without [`forget`](Self::forget).
    pub(crate) fn accumulate<T: Send>(&self, lists: &[&dyn Scattered<T>], slots: &mut [T]) {
        let elements: usize = lists.iter().map(|list| list.count()).sum();
        let threads = parallel::thread_count().min(elements / LEAST);
        if threads <= 1 || slots.is_empty() {
            return lists.iter().for_each(|list| list.add_all(slots));
        }
        let layout = self.layout(lists, slots.len());
        let mut shares = layout.shares(slots, threads);
        if elements < LEAST_WILD && layout.is_wild(&shares) {
            drop(shares);
            return lists.iter().for_each(|list| list.add_all(slots));
        }
        parallel::enter(|| match layout.border(lists, &shares) {
            Some(borders) => {
                let parts = lists.iter().zip(borders);
                let lists: Vec<Box<dyn Bordered<T> + '_>> =
                    parts.map(|(list, (touched, border))| list.with_border(touched, border)).collect();
                for_each_share(&mut shares, |share| {
                    lists.iter().for_each(|list| list.add_touching(share));
                });
            }
            None => lists.iter().for_each(|list| list.add_batches(&mut shares)),
        });
    }

    /// The layout, found out if it is not known yet: before the lock is taken, since a thread that waits for its helpers may be
    /// given other work meanwhile, and that may ask for this same layout.
    fn layout<T>(&self, lists: &[&dyn Scattered<T>], slots: usize) -> &Layout {
        match self.layout.get() {
            Some(known) => known,
            None => {
                let layout = Layout::new(lists, slots);
                self.layout.get_or_init(|| layout)
            }
        }
    }
}

/// How many elements whose results are `R`s are computed at once: whole groups.
const fn run_length<R>() -> usize {
    let groups = RUN_BYTES / (GROUP * if size_of::<R>() == 0 { 1 } else { size_of::<R>() });
    if groups * GROUP > RUN {
        RUN
    } else if groups == 0 {
        GROUP
    } else {
        groups * GROUP
    }
}

fn for_each_share<T: Send>(shares: &mut [Share<'_, T>], work: impl Fn(&mut Share<'_, T>) + Sync) {
    parallel::for_each_chunk(shares, 1, |_, shares| shares.iter_mut().for_each(&work));
}
