//! Parallel maps and reductions whose result has the same bits for any number of threads.
//!
//! The rule of the workspace: map in parallel, reduce in order. Work is cut into chunks whose size depends on the
//! data only, never on the number of threads; each chunk is computed on its own, and the chunks' results are
//! combined one after the other in index order. (rayon's own `sum`, `reduce` and `fold` combine in whatever order
//! threads finish, which changes the last bits from run to run.)
//!
//! This is the only module of the workspace that names rayon. The number of threads is that of the rayon pool the
//! caller is in; [`with_threads`] runs a closure in a pool of a stated size.

use rayon::prelude::*;

/// Runs `work` with exactly `threads` worker threads.
///
/// # Panics
/// If `threads` is zero or the operating system refuses to start them.
pub fn with_threads<R: Send>(threads: usize, work: impl FnOnce() -> R + Send) -> R {
    assert!(threads > 0, "a pool needs at least one thread");
    match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
        Ok(pool) => pool.install(work),
        Err(error) => panic!("cannot start {threads} threads: {error}"),
    }
}

/// The number of threads that parallel work started here will use.
pub fn thread_count() -> usize {
    rayon::current_num_threads()
}

/// Runs both and answers both results; in parallel if a thread is free.
pub fn join<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    rayon::join(a, b)
}

/// Runs `work` on a thread of the pool. Many small parallel calls within it are cheaper than from outside, where
/// each has to wake the pool and to wait for it.
pub fn enter<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    rayon::scope(|_| work())
}

/// Σ `term(i)` for `i` in `0..count`, summed within chunks of `chunk` in index order, then over chunks in order;
/// zero when `count` is zero.
///
/// The bits of the result depend on `chunk`, not on the number of threads.
///
/// # Panics
/// If `chunk` is zero.
pub fn sum(count: usize, chunk: usize, term: impl Fn(usize) -> f64 + Sync) -> f64 {
    // Not `Iterator::sum`, whose empty sum is negative zero.
    let add = |a: f64, b: f64| a + b;
    map_chunks(count, chunk, |range| range.map(&term).fold(0.0, add)).into_iter().fold(0.0, add)
}

/// The smallest `value(i)` for `i` in `0..count` and its index; the first one of equals. `None` when `count` is
/// zero. If any value is NaN, the first NaN and its index, so that it cannot hide.
///
/// The result depends neither on `chunk` nor on the number of threads, up to the sign of a zero: −0 and +0 are
/// equals here.
///
/// # Panics
/// If `chunk` is zero.
pub fn minimum(count: usize, chunk: usize, value: impl Fn(usize) -> f64 + Sync) -> Option<(usize, f64)> {
    let smaller = |a: Option<(usize, f64)>, b: (usize, f64)| match a {
        Some(a) if a.1.is_nan() || a.1 <= b.1 => Some(a),
        _ => Some(b),
    };
    map_chunks(count, chunk, |range| range.map(|i| (i, value(i))).fold(None, smaller))
        .into_iter()
        .flatten()
        .fold(None, smaller)
}

/// The results of `work` on the ranges `0..chunk`, `chunk..2 chunk`, …, in order.
///
/// # Panics
/// If `chunk` is zero.
pub fn map_chunks<R: Send>(
    count: usize,
    chunk: usize,
    work: impl Fn(std::ops::Range<usize>) -> R + Sync,
) -> Vec<R> {
    assert!(chunk > 0, "a chunk holds at least one element");
    let range = |k: usize| k * chunk..((k + 1) * chunk).min(count);
    let chunks = count.div_ceil(chunk);
    if chunks <= 1 {
        return (0..chunks).map(|k| work(range(k))).collect();
    }
    (0..chunks).into_par_iter().map(|k| work(range(k))).collect()
}

/// Overwrites `data[i]` with `value(i)`, in parallel parts of `chunk`.
///
/// # Panics
/// If `chunk` is zero.
pub fn map_into<T: Send>(data: &mut [T], chunk: usize, value: impl Fn(usize) -> T + Sync) {
    for_each_chunk(data, chunk, |first, part| {
        for (k, entry) in part.iter_mut().enumerate() {
            *entry = value(first + k);
        }
    });
}

/// Calls `work(first index, part)` on consecutive parts of `data`, each `chunk` long but the last, in parallel.
///
/// # Panics
/// If `chunk` is zero.
pub fn for_each_chunk<T: Send>(data: &mut [T], chunk: usize, work: impl Fn(usize, &mut [T]) + Sync) {
    assert!(chunk > 0, "a chunk holds at least one element");
    if data.len() <= chunk {
        if !data.is_empty() {
            work(0, data);
        }
        return;
    }
    data.par_chunks_mut(chunk).enumerate().for_each(|(k, part)| work(k * chunk, part));
}

/// Calls `work(k, part, result)` for every k in `0..ends.len()`, in parallel, where part k of `data` reaches from the end of part
/// k − 1 (from 0) to `ends[k]`, and result k is `results[k]`. For parts of different lengths; allocates nothing.
///
/// # Panics
/// If there are not as many results as ends, if `ends` descends, or if the last end is not the length of `data`.
pub fn for_each_part<T: Send, R: Send>(
    data: &mut [T],
    ends: &[usize],
    results: &mut [R],
    work: impl Fn(usize, &mut [T], &mut R) + Sync,
) {
    assert_eq!(ends.len(), results.len(), "one result for each part");
    assert_eq!(ends.last().copied().unwrap_or(0), data.len(), "the parts make up the data");
    split(Parts { first: 0, start: 0, data, ends, results }, &work);
}

/// Consecutive parts: the number of the first one, and where it starts.
struct Parts<'a, T, R> {
    first: usize,
    start: usize,
    data: &'a mut [T],
    ends: &'a [usize],
    results: &'a mut [R],
}

fn split<T: Send, R: Send>(parts: Parts<'_, T, R>, work: &(impl Fn(usize, &mut [T], &mut R) + Sync)) {
    let Parts { first, start, data, ends, results } = parts;
    match ends.len() {
        0 => {}
        1 => work(first, data, &mut results[0]),
        count => {
            let half = count / 2;
            let middle = ends[half - 1];
            let (left, right) = data.split_at_mut(middle - start);
            let (left_results, right_results) = results.split_at_mut(half);
            let left = Parts { first, start, data: left, ends: &ends[..half], results: left_results };
            let right = Parts {
                first: first + half,
                start: middle,
                data: right,
                ends: &ends[half..],
                results: right_results,
            };
            rayon::join(|| split(left, work), || split(right, work));
        }
    }
}
