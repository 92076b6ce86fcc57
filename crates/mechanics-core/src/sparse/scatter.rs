//! Ordered parallel scattering: many element contributions summed into slots, the same bits for any thread count.
//!
//! Elements are worked on in batches small enough for their results to stay in cache. For every batch the map holds
//! its contributions sorted by slot, and by element within a slot. Threads take consecutive runs of slots, so no
//! two write the same one, and every slot is summed in element order, whatever the number of threads. The sorting
//! is done once per element list. While one batch is scattered the next is computed, so that threads meet once a
//! batch.

use crate::parallel;

/// One contribution of an element: local result number `source` goes, with `weight`, into `slot`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contribution {
    pub(crate) slot: u32,
    pub(crate) element: u32,
    /// Number of the result within its element's results; the top bit is the caller's.
    pub(crate) local: u32,
    pub(crate) weight: f64,
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    slot: u32,
    /// Number of the result within its batch's results; the top bit is the caller's.
    source: u32,
}

/// The top bit of a source, free for the caller to use as a mark.
pub(crate) const MARK: u32 = 1 << 31;

/// Below this many contributions in a batch, one thread scatters them.
const PARALLEL_ENTRIES: usize = 1024;

/// Elements whose results are computed by one task.
pub(crate) const TASK: usize = 32;

/// Where the results of batches of elements go.
#[derive(Clone, Debug)]
pub(crate) struct ScatterMap {
    elements: usize,
    batch: usize,
    start: Vec<usize>,
    entries: Vec<Entry>,
    /// One per entry, or none while all are one.
    weights: Vec<f64>,
}

impl ScatterMap {
    /// The map of `elements` elements, `per_element` results each, in batches of `batch`. Within a slot the
    /// contributions must come in element order; slots should ascend, else batches are sorted.
    pub(crate) fn new(
        elements: usize,
        per_element: usize,
        batch: usize,
        contributions: impl Iterator<Item = Contribution> + Clone,
    ) -> Self {
        assert!(batch * per_element < MARK as usize, "a batch has fewer than 2³¹ results");
        let batches = elements.div_ceil(batch);
        let mut start = vec![0; batches + 1];
        contributions.clone().for_each(|c| start[c.element as usize / batch + 1] += 1);
        (0..batches).for_each(|b| start[b + 1] += start[b]);
        let mut cursor = start.clone();
        let mut entries = vec![Entry { slot: 0, source: 0 }; start[batches]];
        let unit = contributions.clone().all(|c| c.weight == 1.0);
        let mut weights = if unit { Vec::new() } else { vec![0.0; start[batches]] };
        for c in contributions {
            let at = &mut cursor[c.element as usize / batch];
            let first = (c.element as usize % batch * per_element) as u32;
            entries[*at] = Entry { slot: c.slot, source: (first + (c.local & !MARK)) | (c.local & MARK) };
            if !unit {
                weights[*at] = c.weight;
            }
            *at += 1;
        }
        let mut map = Self { elements, batch, start, entries, weights };
        map.sort_batches();
        map
    }

    /// How many elements' results [`accumulate`](Self::accumulate) needs room for: two batches.
    pub(crate) fn room(&self) -> usize {
        self.elements.min(2 * self.batch)
    }

    /// Adds all results to their slots. `compute(first, results)` overwrites the results of the elements
    /// `first..first + results.len()`, at most [`TASK`] at a time; `add(target, results, source, weight)` adds number
    /// `source` of a batch's results. `results` is where batches are computed.
    pub(crate) fn accumulate<R: Send + Sync, T: Send>(
        &self,
        results: &mut [R],
        targets: &mut [T],
        compute: impl Fn(usize, &mut [R]) + Sync,
        add: impl Fn(&mut T, &[R], u32, f64) + Sync,
    ) {
        let range = |number: usize| number * self.batch..((number + 1) * self.batch).min(self.elements);
        let fill = |number: usize, results: &mut [R]| {
            let range = range(number);
            let results = &mut results[..range.len()];
            parallel::for_each_chunk(results, TASK, |at, results| compute(range.start + at, results));
        };
        let empty = |number: usize, results: &[R], targets: &mut [T]| {
            let results = &results[..range(number).len()];
            self.scatter(number, targets, |target, source, weight| add(target, results, source, weight));
        };
        let batches = self.elements.div_ceil(self.batch);
        if batches <= 1 || parallel::thread_count() == 1 {
            (0..batches).for_each(|number| {
                fill(number, results);
                empty(number, results, targets);
            });
            return;
        }
        parallel::enter(|| {
            let (mut now, mut next) = results.split_at_mut(self.batch);
            fill(0, now);
            for number in 1..batches {
                parallel::join(|| empty(number - 1, now, targets), || fill(number, next));
                std::mem::swap(&mut now, &mut next);
            }
            empty(batches - 1, now, targets);
        });
    }

    /// The slot of every contribution, as often as it is named.
    pub(crate) fn slots(&self) -> impl Iterator<Item = usize> {
        self.entries.iter().map(|entry| entry.slot as usize)
    }

    /// Gives every slot a new number.
    pub(crate) fn renumber(&mut self, new_slot: &[u32]) {
        parallel::for_each_chunk(&mut self.entries, 1 << 16, |_, entries| {
            entries.iter_mut().for_each(|entry| entry.slot = new_slot[entry.slot as usize]);
        });
        self.sort_batches();
    }

    fn sort_batches(&mut self) {
        for range in self.start.windows(2).map(|pair| pair[0]..pair[1]) {
            let entries = &mut self.entries[range.clone()];
            if entries.is_sorted_by_key(|entry| entry.slot) {
                continue;
            }
            if self.weights.is_empty() {
                entries.sort_by_key(|entry| entry.slot);
                continue;
            }
            let weights = &mut self.weights[range];
            let mut both: Vec<(Entry, f64)> = entries.iter().copied().zip(weights.iter().copied()).collect();
            both.sort_by_key(|(entry, _)| entry.slot);
            for (k, (entry, weight)) in both.into_iter().enumerate() {
                (entries[k], weights[k]) = (entry, weight);
            }
        }
    }

    /// Calls `add(target slot, source, weight)` for every contribution of batch number `batch`, in element order
    /// for each slot; slots are worked on in parallel.
    fn scatter<T: Send>(&self, batch: usize, targets: &mut [T], add: impl Fn(&mut T, u32, f64) + Sync) {
        let range = self.start[batch]..self.start[batch + 1];
        let entries = &self.entries[range.clone()];
        let weights = if self.weights.is_empty() { &[] } else { &self.weights[range] };
        let threads = if entries.len() < PARALLEL_ENTRIES { 1 } else { parallel::thread_count() };
        if threads == 1 {
            add_run(Run { first: 0, targets, entries, weights }, &add);
            return;
        }
        let mut runs = cut(targets, entries, weights, threads);
        parallel::for_each_chunk(&mut runs, 1, |_, runs| {
            for run in runs {
                let targets = std::mem::take(&mut run.targets);
                add_run(Run { targets, ..*run }, &add);
            }
        });
    }
}

/// A run of consecutive slots, beginning with slot `first`, and all contributions of a batch to them.
struct Run<'a, T> {
    first: usize,
    targets: &'a mut [T],
    entries: &'a [Entry],
    weights: &'a [f64],
}

fn add_run<T>(run: Run<'_, T>, add: &impl Fn(&mut T, u32, f64)) {
    if run.weights.is_empty() {
        for entry in run.entries {
            add(&mut run.targets[entry.slot as usize - run.first], entry.source, 1.0);
        }
    } else {
        for (entry, &weight) in run.entries.iter().zip(run.weights) {
            add(&mut run.targets[entry.slot as usize - run.first], entry.source, weight);
        }
    }
}

/// Cuts a batch into about `parts` runs of equally many contributions, never within a slot.
fn cut<'a, T>(
    mut targets: &'a mut [T],
    mut entries: &'a [Entry],
    mut weights: &'a [f64],
    parts: usize,
) -> Vec<Run<'a, T>> {
    let mut runs = Vec::with_capacity(parts);
    let mut first = 0;
    for remaining in (1..=parts).rev() {
        let mut end = entries.len() / remaining;
        while 0 < end && end < entries.len() && entries[end].slot == entries[end - 1].slot {
            end += 1;
        }
        let next_slot = entries.get(end).map_or(first + targets.len(), |entry| entry.slot as usize);
        let (own, rest) = std::mem::take(&mut targets).split_at_mut(next_slot - first);
        let (own_entries, rest_entries) = entries.split_at(end);
        let (own_weights, rest_weights) = weights.split_at(end.min(weights.len()));
        runs.push(Run { first, targets: own, entries: own_entries, weights: own_weights });
        (targets, entries, weights, first) = (rest, rest_entries, rest_weights, next_slot);
    }
    runs
}
