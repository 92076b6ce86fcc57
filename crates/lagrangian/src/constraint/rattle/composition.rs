//! Steps of order 2 composed to order 4, 6 and 8.

/// How many steps of order 2, with sizes γᵢ h, make one step.
///
/// Composing a symmetric step of order 2 with γᵢ = γ_{s+1−i}, Σ γᵢ = 1 gives order 4 if Σ γᵢ³ = 0, order 6 with two
/// further conditions, and so on; some γᵢ are negative. All keep what the basic step keeps.
///
/// # Reference
/// Suzuki 1990 (order 4); Kahan & Li 1997 (orders 6 and 8, nine and seventeen steps); tables in Hairer, Lubich &
/// Wanner 2006, V.3.2.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Composition {
    /// One step of order 2.
    #[default]
    Second,
    /// Five steps, order 4.
    Fourth,
    /// Nine steps, order 6.
    Sixth,
    /// Seventeen steps, order 8.
    Eighth,
}

/// 1/(4 − 4^(1/3)).
const SUZUKI: f64 = 0.414_490_771_794_375_737_142_354_062_860_76;

const FOURTH: [f64; 5] = [SUZUKI, SUZUKI, 1.0 - 4.0 * SUZUKI, SUZUKI, SUZUKI];

const SIXTH: [f64; 9] = mirrored([
    0.392_161_444_007_314_139_279_250_56,
    0.332_599_136_789_359_438_599_748_64,
    -0.706_246_172_557_639_359_809_964_82,
    0.082_213_596_293_550_800_231_490_45,
    0.798_543_990_934_829_963_398_950_35,
]);

const EIGHTH: [f64; 17] = mirrored([
    0.130_202_483_088_890_080_878_817_63,
    0.561_162_981_775_108_384_561_964_41,
    -0.389_474_962_644_847_286_408_078_60,
    0.158_841_906_555_155_600_896_210_75,
    -0.395_903_894_133_237_577_336_231_54,
    0.184_539_640_978_315_707_091_832_54,
    0.258_374_387_686_322_047_293_979_11,
    0.295_011_723_609_310_298_870_966_24,
    -0.605_508_533_830_034_511_698_921_08,
]);

/// The whole symmetric sequence from its first half and middle.
const fn mirrored<const HALF: usize, const ALL: usize>(half: [f64; HALF]) -> [f64; ALL] {
    let mut all = [0.0; ALL];
    let mut i = 0;
    while i < ALL {
        all[i] = half[if i < HALF { i } else { ALL - 1 - i }];
        i += 1;
    }
    all
}

impl Composition {
    /// γᵢ.
    pub fn factors(self) -> &'static [f64] {
        match self {
            Self::Second => &[1.0],
            Self::Fourth => &FOURTH,
            Self::Sixth => &SIXTH,
            Self::Eighth => &EIGHTH,
        }
    }

    /// The order.
    pub fn order(self) -> u32 {
        match self {
            Self::Second => 2,
            Self::Fourth => 4,
            Self::Sixth => 6,
            Self::Eighth => 8,
        }
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Second => "RATTLE",
            Self::Fourth => "RATTLE 4",
            Self::Sixth => "RATTLE 6",
            Self::Eighth => "RATTLE 8",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Composition;

    #[test]
    fn sums_of_odd_powers_vanish_up_to_the_order() {
        for composition in [Composition::Second, Composition::Fourth, Composition::Sixth, Composition::Eighth]
        {
            let sum = |power: i32| composition.factors().iter().map(|c| c.powi(power)).sum::<f64>();
            assert!((sum(1) - 1.0).abs() < 4e-15, "{composition:?}: {}", sum(1));
            for power in (3..composition.order() as i32).step_by(2) {
                assert!(sum(power).abs() < 4e-15, "{composition:?}, power {power}: {}", sum(power));
            }
        }
    }
}
