//! Ordered parallelism: the same bits for any number of threads, and nothing lost at the edges.

use mechanics_core::parallel::{
    for_each_chunk, map_chunks, map_into, minimum, sum, thread_count, with_threads,
};

const THREADS: [usize; 4] = [1, 2, 3, 8];

/// Terms of alternating sign over sixteen decades: any other order of summation gives other bits.
fn rough_term(i: usize) -> f64 {
    let phase = (i as f64 * 12.9898).sin() * 43758.5453;
    phase.fract() * 10f64.powi((i % 17) as i32 - 8)
}

#[test]
fn terms_are_rough_enough_to_expose_a_changed_order() {
    let forward: f64 = (0..10_007).map(rough_term).sum();
    let backward: f64 = (0..10_007).rev().map(rough_term).sum();
    assert_ne!(forward.to_bits(), backward.to_bits());
}

#[test]
fn sum_has_the_same_bits_for_any_number_of_threads() {
    // 10,007 is prime: no chunk length divides it.
    for chunk in [1, 7, 64, 1000, 10_006, 10_007, 20_000] {
        let by_hand = (0..10_007)
            .collect::<Vec<_>>()
            .chunks(chunk)
            .map(|part| part.iter().fold(0.0, |s, &i| s + rough_term(i)))
            .fold(0.0, |s: f64, t| s + t);
        for threads in THREADS {
            for repeat in 0..5 {
                let parallel = with_threads(threads, || sum(10_007, chunk, rough_term));
                assert_eq!(
                    parallel.to_bits(),
                    by_hand.to_bits(),
                    "chunk {chunk}, {threads} threads, repeat {repeat}"
                );
            }
        }
    }
}

#[test]
fn sum_of_nothing_is_positive_zero() {
    assert_eq!(sum(0, 16, |_| f64::NAN).to_bits(), 0.0f64.to_bits());
}

#[test]
fn a_nan_term_reaches_the_sum() {
    for threads in THREADS {
        let total = with_threads(threads, || sum(100, 9, |i| if i == 63 { f64::NAN } else { 1.0 }));
        assert!(total.is_nan(), "{threads} threads");
    }
}

#[test]
fn minimum_is_the_first_of_equals_whatever_the_chunk_and_threads() {
    let value = |i: usize| ((i * 7919) % 101) as f64;
    let expected = (0..5000).map(|i| (i, value(i))).find(|&(_, v)| v == 0.0);
    for threads in THREADS {
        for chunk in [1, 3, 64, 4999, 5000, 9000] {
            assert_eq!(
                with_threads(threads, || minimum(5000, chunk, value)),
                expected,
                "{threads} threads, {chunk}"
            );
        }
    }
}

#[test]
fn minimum_reports_the_first_nan_even_below_negative_infinity() {
    let value = |i: usize| match i {
        10 => f64::NEG_INFINITY,
        701 | 900 => f64::NAN,
        _ => 1.0,
    };
    for threads in THREADS {
        for chunk in [1, 50, 701, 702, 2000] {
            let found = with_threads(threads, || minimum(1000, chunk, value));
            let (index, smallest) = found.expect("there are values");
            assert!(
                smallest.is_nan() && index == 701,
                "{threads} threads, chunk {chunk}: {index} {smallest}"
            );
        }
    }
}

#[test]
fn minimum_accepts_infinities_and_nothing() {
    assert_eq!(minimum(0, 8, |_| 0.0), None);
    assert_eq!(minimum(3, 2, |_| f64::INFINITY), Some((0, f64::INFINITY)));
    assert_eq!(minimum(3, 2, |i| [2.0, f64::NEG_INFINITY, 3.0][i]), Some((1, f64::NEG_INFINITY)));
}

#[test]
fn chunks_tile_the_range_in_order() {
    for threads in THREADS {
        for (count, chunk) in [(0, 4), (1, 4), (4, 4), (5, 4), (1003, 10), (7, 100)] {
            let ranges = with_threads(threads, || map_chunks(count, chunk, |range| range));
            let flat: Vec<usize> = ranges.iter().cloned().flatten().collect();
            assert_eq!(flat, (0..count).collect::<Vec<_>>(), "{count} in chunks of {chunk}");
            assert!(ranges.iter().all(|range| !range.is_empty() && range.len() <= chunk));
            assert_eq!(ranges.len(), count.div_ceil(chunk));
        }
    }
}

#[test]
fn map_into_writes_every_entry_once_in_place() {
    for threads in THREADS {
        for (count, chunk) in [(0, 4), (1, 1), (1003, 10), (64, 64), (65, 64)] {
            let mut data = vec![f64::NAN; count];
            with_threads(threads, || map_into(&mut data, chunk, rough_term));
            for (i, value) in data.iter().enumerate() {
                assert_eq!(value.to_bits(), rough_term(i).to_bits(), "{threads} threads, {count}/{chunk}");
            }
        }
    }
}

#[test]
fn for_each_chunk_passes_the_first_index_of_each_part() {
    for threads in THREADS {
        let mut visits = vec![0u32; 1003];
        with_threads(threads, || {
            for_each_chunk(&mut visits, 10, |first, part| {
                assert_eq!(first % 10, 0);
                assert_eq!(part.len(), if first == 1000 { 3 } else { 10 });
                part.iter_mut().for_each(|visit| *visit += 1);
            });
        });
        assert!(visits.iter().all(|&visit| visit == 1));
    }
    let mut nothing: [u32; 0] = [];
    for_each_chunk(&mut nothing, 10, |_, _| panic!("there is no part of nothing"));
}

#[test]
fn a_pool_has_the_threads_asked_for() {
    for threads in THREADS {
        assert_eq!(with_threads(threads, thread_count), threads);
    }
}

#[test]
#[should_panic(expected = "a chunk holds at least one element")]
fn a_chunk_of_zero_is_refused() {
    sum(3, 0, |_| 1.0);
}

#[test]
#[should_panic(expected = "at least one thread")]
fn a_pool_of_zero_threads_is_refused() {
    with_threads(0, || ());
}
