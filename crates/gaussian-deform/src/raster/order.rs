//! Sorting by depth.

/// How many values a digit has.
const DIGIT: usize = 256;

/// The numbers 0, 1, … of the depths, in ascending order of depth; equal depths in the order in which they come.
///
/// Depths between the nearest and the furthest are mapped to 16 bits, which two passes of a counting sort order. The map is monotone but not
/// injective, so runs of equal keys are sorted by comparison afterwards: few and short ones where depths are spread, correct ones always.
///
/// `depths` are finite.
pub(crate) fn by_depth<E: Copy + Into<f64>>(depths: &[E]) -> Vec<u32> {
    let depth = |i: u32| -> f64 { depths[i as usize].into() };
    let (nearest, furthest) =
        depths.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &depth| {
            let depth = depth.into();
            (low.min(depth), high.max(depth))
        });
    let scale = 65_535.0 / (furthest - nearest);
    // A cast saturates; NaN, from zero times infinity where all depths are nearly the same, becomes zero.
    let pairs: Vec<Pair> = depths
        .iter()
        .enumerate()
        .map(|(i, &depth)| Pair { key: ((depth.into() - nearest) * scale) as u16, index: i as u32 })
        .collect();
    let sorted = counting_sort(&counting_sort(&pairs, 0), 8);
    let mut order: Vec<u32> = sorted.iter().map(|pair| pair.index).collect();
    let mut start = 0;
    while start < sorted.len() {
        let mut end = start + 1;
        while end < sorted.len() && sorted[end].key == sorted[start].key {
            end += 1;
        }
        if end - start > 1 {
            order[start..end].sort_by(|&a, &b| depth(a).total_cmp(&depth(b)));
        }
        start = end;
    }
    order
}

#[derive(Clone, Copy, Default)]
struct Pair {
    index: u32,
    key: u16,
}

/// Stably by the eight bits of the key from `shift` on.
fn counting_sort(pairs: &[Pair], shift: u32) -> Vec<Pair> {
    let digit = |pair: &Pair| usize::from(pair.key >> shift) % DIGIT;
    let mut starts = [0_usize; DIGIT];
    for pair in pairs {
        starts[digit(pair)] += 1;
    }
    let mut sum = 0;
    for start in &mut starts {
        (*start, sum) = (sum, sum + *start);
    }
    let mut sorted = vec![Pair::default(); pairs.len()];
    for pair in pairs {
        let start = &mut starts[digit(pair)];
        sorted[*start] = *pair;
        *start += 1;
    }
    sorted
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(depths: &[f64]) {
        let mut expected: Vec<u32> = (0..depths.len() as u32).collect();
        expected.sort_by(|&a, &b| depths[a as usize].total_cmp(&depths[b as usize]));
        assert_eq!(by_depth(depths), expected);
    }

    #[test]
    fn agrees_with_the_stable_sort_of_the_standard_library() {
        let mut state = 7_u64;
        let mut number = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        check(&[]);
        check(&[1.0]);
        check(&[2.0; 100]);
        check(&(0..5000).map(|_| number()).collect::<Vec<_>>());
        // Many equal depths, which keep their order.
        check(&(0..5000).map(|_| (number() * 20.0).floor()).collect::<Vec<_>>());
        // One outlier gives all others the same key; so do depths that differ in their last bits.
        check(&(0..500).map(|i| if i == 250 { 1e30 } else { number() }).collect::<Vec<_>>());
        check(&(0..500).map(|_| 1.0 + 1e-14 * number()).collect::<Vec<_>>());
        check(&[1.0, 1.0 + f64::EPSILON, 1.0, 1.0 - f64::EPSILON, 5e-324, 0.0, 1e308]);
    }
}
