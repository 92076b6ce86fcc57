//! Random numbers: a counter mixed by SplitMix64.

/// Uniform numbers of one site or one sequence.
pub(super) struct SiteRandom {
    state: u64,
}

/// The increment and the finaliser of SplitMix64 (G. L. Steele, D. Lea, C. H. Flood, *Fast splittable pseudorandom number generators*, OOPSLA
/// 2014, figure 17).
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

fn mixed(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

impl SiteRandom {
    /// The numbers of the site with these coordinates.
    pub(super) fn new<const D: usize>(seed: u64, site: &[f64; D]) -> Self {
        // + 0.0 makes one zero of both.
        let state =
            site.iter().fold(mixed(seed), |state, c| mixed(state.wrapping_add(GOLDEN) ^ (c + 0.0).to_bits()));
        Self { state }
    }

    /// The next number in [0, 1).
    pub(super) fn uniform(&mut self) -> f64 {
        self.state = self.state.wrapping_add(GOLDEN);
        (mixed(self.state) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first outputs of SplitMix64 for the seed 1234567, as published with its reference implementation.
    #[test]
    fn it_is_splitmix64() {
        let mut random = SiteRandom { state: 1_234_567 };
        for expected in [6_457_827_717_110_365_317_u64, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423]
        {
            assert_eq!(random.uniform(), (expected >> 11) as f64 / (1_u64 << 53) as f64);
        }
    }

    #[test]
    fn sites_are_independent_of_each_other() {
        let mean = |axis: f64| {
            let numbers = (0..4000).map(|k| SiteRandom::new(3, &[f64::from(k), axis]).uniform());
            numbers.sum::<f64>() / 4000.0
        };
        // Four standard deviations, 4/√(12 · 4000).
        assert!((mean(0.0) - 0.5).abs() < 0.018 && (mean(-1.0) - 0.5).abs() < 0.018);
        assert_ne!(SiteRandom::new(3, &[0.0]).uniform(), SiteRandom::new(4, &[0.0]).uniform());
        assert_eq!(SiteRandom::new(3, &[0.0]).uniform(), SiteRandom::new(3, &[-0.0]).uniform());
    }
}
