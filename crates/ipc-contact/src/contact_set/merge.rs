//! Pairs that several candidates meet in become one.

use super::ContactPairs;
use super::narrow::Near;

/// A candidate's share in a pair, before it is known which others share it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Share<const N: usize> {
    pub(super) points: [u32; N],
    /// Whose area the share is of, see [`Near::unit`].
    pub(super) sample: u32,
    /// How many times that area.
    pub(super) count: i32,
}

/// The pairs with their weights Σ count · area, ascending; without those whose counts cancel.
pub(super) fn merge_into<const N: usize>(
    near: &Near<'_>,
    mut shares: Vec<Share<N>>,
    merged: &mut ContactPairs<N>,
) {
    // Equal shares are interchangeable, so the order among them does not matter.
    shares.sort_unstable();
    for pair in shares.chunk_by(|a, b| a.points == b.points) {
        let mut weight = 0.0;
        for of_one_sample in pair.chunk_by(|a, b| a.sample == b.sample) {
            let count: i32 = of_one_sample.iter().map(|share| share.count).sum();
            weight += f64::from(count) * near.unit(of_one_sample[0].sample);
        }
        if weight != 0.0 {
            merged.push(pair[0].points, weight);
        }
    }
}
