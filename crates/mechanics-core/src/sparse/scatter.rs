//! Parallel scattering: many element contributions summed into slots, with the bits of the plain loop.
//!
//! The plain loop takes the elements in order, a small run at a time, and adds their contributions to the slots at
//! once, while they are in the first cache. One thread does just that.
//!
//! **Several threads** each own a range of slots, a *window*. Every thread runs the plain loop, but only over those
//! elements that touch its window, and adds only what falls into it. Whatever the windows, a slot has one owner, and
//! its owner adds the contributions to it one by one in element order, as the plain loop does: the bits are
//! the same. Threads share nothing that is written and never wait for each other. The price is that an element
//! that touches two windows is computed twice: about one layer of elements a cut (4 % of a cube of 100,000
//! tetrahedra cut in two).
//!
//! That is so if elements that follow each other are near each other, and so are their slots, as in meshes of every
//! sensible numbering. For element lists in wild order (a shuffled mesh, contacts between distant parts) nearly all
//! would be computed by all. They go the other way: *batches* are computed once, in parallel, into a buffer that
//! stays in cache; then every thread walks through the whole batch and adds what falls into its window, while
//! the next batch is computed. Again each slot is summed by one thread in element order.
//!
//! **Where windows begin.** Elements are taken in *groups* of eight, so that vector lanes stay full and hold the same
//! elements whatever the windows; group g touches slots between l(g) and u(g). A cut at c gives the groups with l < c to the left and those with u ≥ c to the right.
//! With c the median of all the numbers l and u, as many of the l lie below c as of the u do not, so both sides
//! compute the same number of groups; for p windows we cut at the p-quantiles.

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

/// The results of a batch take about this many bytes, so that they are still in cache when they are added.
const BATCH_BYTES: usize = 1 << 19;

/// What elements add to slots: an `R` each, computed first.
pub(crate) trait Contributions<R>: Sync {
    /// What results are added to.
    type Slot: Send;
    /// Any result, to be overwritten.
    const BLANK: R;

    /// Overwrites the results of the elements `first..first + results.len()`; `first` is a multiple of [`GROUP`].
    fn compute(&self, first: usize, results: &mut [R]);

    /// Adds these results to the slots they belong to, in order, as far as `window` has them.
    fn add(&self, first: usize, results: &[R], window: &mut Window<'_, Self::Slot>);

    /// The smallest and the largest slot that a group of elements touches, if any.
    fn extent(&self, group: Range<usize>) -> Option<[u32; 2]>;
}

/// The slots a thread may write to.
pub(crate) struct Window<'a, T> {
    first: usize,
    slots: &'a mut [T],
}

impl<T> Window<'_, T> {
    /// A slot, if it is in this window.
    #[inline(always)]
    pub(crate) fn slot(&mut self, slot: u32) -> Option<&mut T> {
        // Slots before the window wrap around to numbers behind it.
        self.slots.get_mut((slot as usize).wrapping_sub(self.first))
    }

    fn touches(&self, [low, high]: [u32; 2]) -> bool {
        (low as usize) < self.first + self.slots.len() && high as usize >= self.first
    }
}

/// How the elements of a list lie among the slots: what is needed to share them out among any number of threads.
#[derive(Clone, Debug)]
struct Layout {
    /// The smallest and the largest slot of every group; the other way round if it has none.
    extents: Vec<[u32; 2]>,
    /// All of them in ascending order.
    ends: Vec<u32>,
}

/// What a group without slots has for an extent: it touches no window.
const NOWHERE: [u32; 2] = [u32::MAX, 0];

impl Layout {
    fn new<R, C: Contributions<R>>(elements: usize, work: &C) -> Self {
        let group = |k: usize| k * GROUP..((k + 1) * GROUP).min(elements);
        let mut extents = vec![NOWHERE; elements.div_ceil(GROUP)];
        parallel::map_into(&mut extents, 512, |k| work.extent(group(k)).unwrap_or(NOWHERE));
        let somewhere = extents.iter().filter(|extent| **extent != NOWHERE);
        let mut ends: Vec<u32> = somewhere.flatten().copied().collect();
        ends.sort_unstable();
        Self { extents, ends }
    }

    fn windows<'a, T>(&self, mut slots: &'a mut [T], count: usize) -> Vec<Window<'a, T>> {
        let mut windows = Vec::with_capacity(count);
        let mut first = 0;
        for k in 1..=count {
            let end =
                self.ends.get(k * self.ends.len() / count).map_or(first + slots.len(), |&end| end as usize);
            let (own, rest) = std::mem::take(&mut slots).split_at_mut(end - first);
            windows.push(Window { first, slots: own });
            (slots, first) = (rest, end);
        }
        windows
    }

    /// Whether sharing the elements by windows leaves no thread with much more than its part.
    fn parts_well<T>(&self, windows: &[Window<'_, T>]) -> bool {
        let touched = |window: &Window<'_, T>| self.extents.iter().filter(|e| window.touches(**e)).count();
        let most = windows.iter().map(touched).max().unwrap_or(0);
        2 * most * windows.len() <= 3 * self.extents.len()
    }
}

/// Adds the contributions of a list of elements to slots.
#[derive(Clone, Debug)]
pub(crate) struct Scatter {
    elements: usize,
    layout: OnceLock<Layout>,
}

impl Scatter {
    /// For a list of `elements` elements.
    pub(crate) fn new(elements: usize) -> Self {
        Self { elements, layout: OnceLock::new() }
    }

    /// To be called when elements touch other slots than before.
    pub(crate) fn forget(&mut self) {
        self.layout = OnceLock::new();
    }

    /// Adds all contributions. What elements touch must not change without [`forget`](Self::forget).
    pub(crate) fn accumulate<R: Copy + Send + Sync, C: Contributions<R>>(
        &self,
        work: &C,
        slots: &mut [C::Slot],
    ) {
        let threads = parallel::thread_count().min(self.elements / LEAST);
        if threads <= 1 {
            self.add_runs(work, &mut Window { first: 0, slots });
            return;
        }
        let layout = self.layout(work);
        let mut windows = layout.windows(slots, threads);
        if layout.parts_well(&windows) {
            for_each_window(&mut windows, |window| self.add_touching(layout, work, window));
        } else {
            parallel::enter(|| self.add_batches(work, &mut windows));
        }
    }

    /// The layout, found out if it is not known yet: before the lock is taken, since a thread that waits for its helpers may be
    /// given other work meanwhile, and that may ask for this same layout.
    fn layout<R, C: Contributions<R>>(&self, work: &C) -> &Layout {
        match self.layout.get() {
            Some(known) => known,
            None => {
                let layout = Layout::new(self.elements, work);
                self.layout.get_or_init(|| layout)
            }
        }
    }

    fn add_runs<R: Copy + Send + Sync, C: Contributions<R>>(
        &self,
        work: &C,
        window: &mut Window<'_, C::Slot>,
    ) {
        let run = run_length::<R>();
        let mut results = vec![C::BLANK; run.min(self.elements)];
        for first in (0..self.elements).step_by(run) {
            let results = &mut results[..run.min(self.elements - first)];
            work.compute(first, results);
            work.add(first, results, window);
        }
    }

    /// The plain loop over those groups that touch a window; neighbouring ones are taken together.
    fn add_touching<R: Copy + Send + Sync, C: Contributions<R>>(
        &self,
        layout: &Layout,
        work: &C,
        window: &mut Window<'_, C::Slot>,
    ) {
        let run = run_length::<R>();
        let mut results = vec![C::BLANK; run];
        let mut group = 0;
        while group < layout.extents.len() {
            let coming = layout.extents[group..].iter().take(run / GROUP);
            let touching = coming.take_while(|extent| window.touches(**extent)).count();
            if touching > 0 {
                let first = group * GROUP;
                let results = &mut results[..(touching * GROUP).min(self.elements - first)];
                work.compute(first, results);
                work.add(first, results, window);
            }
            group += touching.max(1);
        }
    }

    /// Computes every element once; adds one batch while the next is computed.
    fn add_batches<R: Copy + Send + Sync, C: Contributions<R>>(
        &self,
        work: &C,
        windows: &mut [Window<'_, C::Slot>],
    ) {
        let batch = (BATCH_BYTES / size_of::<R>().max(1)).clamp(64, 4096) / RUN * RUN;
        let range = |number: usize| number * batch..((number + 1) * batch).min(self.elements);
        let fill = |number: usize, results: &mut [R]| {
            let range = range(number);
            let task = |at: usize, results: &mut [R]| work.compute(range.start + at, results);
            parallel::for_each_chunk(&mut results[..range.len()], RUN, task);
        };
        let empty = |number: usize, results: &[R], windows: &mut [Window<'_, C::Slot>]| {
            let range = range(number);
            for_each_window(windows, |window| work.add(range.start, &results[..range.len()], window));
        };
        let buffer = vec![C::BLANK; batch.min(self.elements)];
        let (mut now, mut next) = (buffer.clone(), buffer);
        let batches = self.elements.div_ceil(batch);
        fill(0, &mut now);
        for number in 1..batches {
            parallel::join(|| empty(number - 1, &now, windows), || fill(number, &mut next));
            std::mem::swap(&mut now, &mut next);
        }
        empty(batches - 1, &now, windows);
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

fn for_each_window<T: Send>(windows: &mut [Window<'_, T>], work: impl Fn(&mut Window<'_, T>) + Sync) {
    parallel::for_each_chunk(windows, 1, |_, windows| windows.iter_mut().for_each(&work));
}
