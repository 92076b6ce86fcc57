//! Random numbers, vectors and matrices that tests share.

use mechanics_core::tensor::{Mat3, Vec3};

/// Sebastiano Vigna's splitmix64, as a number from −1 to 1.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    pub(crate) fn vector(&mut self) -> Vec3 {
        Vec3::from_fn(|_, _| self.next())
    }

    pub(crate) fn matrix(&mut self) -> Mat3 {
        Mat3::from_fn(|_, _| self.next())
    }
}
