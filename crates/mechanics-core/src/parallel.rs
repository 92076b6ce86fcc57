//! Parallel maps and reductions whose result has the same bits for any number of threads.
//!
//! The rule of the workspace: map in parallel, reduce in order. Work is cut into chunks whose size depends on the
//! data only, never on the number of threads; each chunk is computed on its own, and the chunks' results are
//! combined one after the other in index order. (rayon's own `sum`, `reduce` and `fold` combine in whatever order
//! threads finish, which changes the last bits from run to run.)
//!
//! This is the only module of the workspace that names rayon. The number of threads is that of the rayon pool the
//! caller is in; [`with_threads`] runs a closure in a pool of a stated size.
//!
//! Everything goes through one function that is not generic, `both`. rayon's machinery for a pair of closures is then compiled once
//! and not for every kind of work: it was a tenth of all code of a program that uses many elements and laws. A call through a
//! pointer for each chunk is what that costs.

/// Runs `work` with exactly `threads` worker threads.
///
/// # Panics
/// If `threads` is zero or the operating system refuses to start them.
pub fn with_threads<R: Send>(threads: usize, work: impl FnOnce() -> R + Send) -> R {
    assert!(threads > 0, "a pool needs at least one thread");
    match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
        Ok(pool) => run_once(work, |job| pool.install(job)),
        Err(error) => panic!("cannot start {threads} threads: {error}"),
    }
}

/// The number of threads that parallel work started here will use.
pub fn thread_count() -> usize {
    rayon::current_num_threads()
}

/// Runs both and answers both results; in parallel if a thread is free.
pub fn join<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    let (mut a, mut b) = (Some(a), Some(b));
    let (mut from_a, mut from_b) = (None, None);
    both(&mut || from_a = a.take().map(|work| work()), &mut || from_b = b.take().map(|work| work()));
    match (from_a, from_b) {
        (Some(a), Some(b)) => (a, b),
        _ => unreachable!("a pair of jobs ended without its results"),
    }
}

/// The one place that hands work to rayon.
fn both(a: &mut (dyn FnMut() + Send), b: &mut (dyn FnMut() + Send)) {
    rayon::join(a, b);
}

/// The result of `work`, which `run` calls on a thread of a pool; `run` sees no more of it than that it can be called.
fn run_once<R: Send>(work: impl FnOnce() -> R + Send, run: impl FnOnce(&mut (dyn FnMut() + Send))) -> R {
    let (mut work, mut result) = (Some(work), None);
    run(&mut || result = work.take().map(|work| work()));
    match result {
        Some(result) => result,
        None => unreachable!("a job ended without its result"),
    }
}

/// Runs `work` on a thread of the pool. Many small parallel calls within it are cheaper than from outside, where
/// each has to wake the pool and to wait for it.
pub fn enter<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    run_once(work, |job| rayon::scope(|_| job()))
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
    let mut results: Vec<Option<R>> = (0..chunks).map(|_| None).collect();
    fill(&mut results, 0, &|k| work(range(k)));
    results.into_iter().flatten().collect()
}

/// `results[k] = work(first + k)`, by halves.
fn fill<R: Send>(results: &mut [Option<R>], first: usize, work: &(dyn Fn(usize) -> R + Sync)) {
    if let [result] = results {
        *result = Some(work(first));
        return;
    }
    let middle = results.len() / 2;
    let (left, right) = results.split_at_mut(middle);
    both(&mut || fill(left, first, work), &mut || fill(right, first + middle, work));
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
    halve(data, chunk, 0, &work);
}

/// [`for_each_chunk`] for data of which the first entry has the number `first`.
fn halve<T: Send>(data: &mut [T], chunk: usize, first: usize, work: &(dyn Fn(usize, &mut [T]) + Sync)) {
    let chunks = data.len().div_ceil(chunk);
    if chunks <= 1 {
        return work(first, data);
    }
    let middle = chunks / 2 * chunk;
    let (left, right) = data.split_at_mut(middle);
    both(&mut || halve(left, chunk, first, work), &mut || halve(right, chunk, first + middle, work));
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

fn split<T: Send, R: Send>(parts: Parts<'_, T, R>, work: &(dyn Fn(usize, &mut [T], &mut R) + Sync)) {
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
            join(|| split(left, work), || split(right, work));
        }
    }
}
