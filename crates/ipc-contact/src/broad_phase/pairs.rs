//! Pairs in ascending order, whatever the order in which they were found.

use mechanics_core::parallel;
use std::sync::atomic::{AtomicUsize, Ordering};

/// First numbers that share a bucket, at least.
const ROWS: usize = 512;
/// Buckets at most.
const BUCKETS: usize = 512;

/// Pairs by bucket: where each bucket begins, and the pairs bucket after bucket.
struct Bucketed {
    starts: Vec<u32>,
    pairs: Vec<[u32; 2]>,
}

impl Bucketed {
    fn new(found: &[[u32; 2]], buckets: usize, rows: usize) -> Self {
        let mut starts = vec![0_u32; buckets + 1];
        let mut pairs = vec![[0; 2]; found.len()];
        scatter(found.iter().copied(), &mut starts, &mut pairs, |p| p[0] as usize / rows);
        Self { starts, pairs }
    }

    fn bucket(&self, k: usize) -> &[[u32; 2]] {
        &self.pairs[self.starts[k] as usize..self.starts[k + 1] as usize]
    }
}

/// A search was given up: it would have found more pairs than it may.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TooMany;

/// How many pairs all parts of a search have found so far, and how many they may.
///
/// Parts that stop once there are too many stop at different places from run to run; that there are too many does not depend on
/// that.
pub(super) struct Tally {
    found: AtomicUsize,
    limit: usize,
}

impl Tally {
    pub(super) fn new(limit: usize) -> Self {
        Self { found: AtomicUsize::new(0), limit }
    }

    pub(super) fn add(&self, found: usize) {
        self.found.fetch_add(found, Ordering::Relaxed);
    }

    pub(super) fn is_over(&self) -> bool {
        self.found.load(Ordering::Relaxed) > self.limit
    }
}

/// Overwrites `pairs` with all that `search(part, found)` finds for the parts `0..parts`, ascending. First numbers
/// are below
/// `rows`. No pair may be found twice.
///
/// Every part sorts its pairs into buckets by their first number; then every bucket gathers its pairs from all
/// parts, orders them by counting, and by comparison only among those of one first number. Both stages run in
/// parallel. None is left where `tally` is over after the search.
pub(super) fn ascending_into(
    pairs: &mut Vec<[u32; 2]>,
    rows: usize,
    parts: usize,
    tally: &Tally,
    search: impl Fn(usize, &mut Vec<[u32; 2]>) + Sync,
) -> Result<(), TooMany> {
    pairs.clear();
    if parts == 0 {
        return Ok(());
    }
    let width = ROWS.max(rows.div_ceil(BUCKETS));
    let buckets = rows.div_ceil(width);
    let parts = parallel::map_chunks(parts, 1, |part| {
        let mut found = Vec::with_capacity(4096);
        search(part.start, &mut found);
        if tally.is_over() {
            found = Vec::new();
        }
        Bucketed::new(&found, buckets, width)
    });
    if tally.is_over() {
        return Err(TooMany);
    }
    let ordered = parallel::map_chunks(buckets, 1, |bucket| order(&parts, bucket.start, width));
    pairs.reserve(ordered.iter().map(Vec::len).sum());
    ordered.iter().for_each(|part| pairs.extend_from_slice(part));
    Ok(())
}

/// The pairs of one bucket, ascending.
fn order(parts: &[Bucketed], bucket: usize, width: usize) -> Vec<[u32; 2]> {
    let found = || parts.iter().flat_map(|part| part.bucket(bucket).iter().copied());
    let mut pairs = vec![[0; 2]; parts.iter().map(|part| part.bucket(bucket).len()).sum()];
    let mut starts = vec![0_u32; width + 1];
    scatter(found(), &mut starts, &mut pairs, |p| p[0] as usize - bucket * width);
    for row in starts.windows(2) {
        pairs[row[0] as usize..row[1] as usize].sort_unstable_by_key(|p| p[1]);
    }
    pairs
}

/// Writes pairs in the order of `key`, which is below `starts.len() − 1`; `starts`, zero at first, becomes the
/// place where each key begins.
fn scatter(
    found: impl Iterator<Item = [u32; 2]> + Clone,
    starts: &mut [u32],
    pairs: &mut [[u32; 2]],
    key: impl Fn(&[u32; 2]) -> usize,
) {
    found.clone().for_each(|p| starts[key(&p) + 1] += 1);
    (1..starts.len()).for_each(|k| starts[k] += starts[k - 1]);
    // Writing moves every start to its end, which is the next one's start.
    for pair in found {
        let place = &mut starts[key(&pair)];
        pairs[*place as usize] = pair;
        *place += 1;
    }
    starts.copy_within(0..starts.len() - 1, 1);
    starts[0] = 0;
}
