//! Integers wide enough for any product of three finite f64: the last resort of the predicates.

/// Limbs of 64 bits that a product of three differences of finite f64 needs: 3 · (1024 + 1074 + 1) bits.
const CAPACITY: usize = 100;

/// A signed integer, magnitude in limbs of 64 bits, lowest first, no leading zeros.
#[derive(Clone, Debug)]
pub(super) struct Wide {
    negative: bool,
    limbs: Vec<u64>,
}

impl Wide {
    /// `value` · 2¹⁰⁷⁴, which is an integer for every finite f64.
    pub(super) fn of(value: f64) -> Self {
        let bits = value.to_bits();
        let exponent = (bits >> 52 & 0x7ff) as usize;
        let fraction = bits & ((1 << 52) - 1);
        let (mantissa, shift) =
            if exponent == 0 { (fraction, 0) } else { (fraction | 1 << 52, exponent - 1) };
        let (limb, bit) = (shift / 64, shift % 64);
        let mut limbs = Vec::with_capacity(CAPACITY);
        limbs.resize(limb, 0);
        let shifted = u128::from(mantissa) << bit;
        limbs.extend([shifted as u64, (shifted >> 64) as u64]);
        Self { negative: value.is_sign_negative(), limbs }.trimmed()
    }

    fn trimmed(mut self) -> Self {
        while self.limbs.last() == Some(&0) {
            self.limbs.pop();
        }
        self
    }

    pub(super) fn sign(&self) -> i8 {
        match (self.limbs.is_empty(), self.negative) {
            (true, _) => 0,
            (false, true) => -1,
            (false, false) => 1,
        }
    }

    fn magnitude_at_least(&self, other: &Self) -> bool {
        let by_length = self.limbs.len().cmp(&other.limbs.len());
        by_length.then_with(|| self.limbs.iter().rev().cmp(other.limbs.iter().rev())).is_ge()
    }

    pub(super) fn plus(&self, other: &Self) -> Self {
        if self.negative == other.negative {
            return self.magnitude_plus(other);
        }
        if self.magnitude_at_least(other) { self.magnitude_minus(other) } else { other.magnitude_minus(self) }
    }

    pub(super) fn minus(&self, other: &Self) -> Self {
        self.plus(&Self { negative: !other.negative, limbs: other.limbs.clone() })
    }

    /// |self| + |other| with the sign of `self`.
    fn magnitude_plus(&self, other: &Self) -> Self {
        let count = self.limbs.len().max(other.limbs.len());
        let mut limbs = Vec::with_capacity(count + 1);
        let mut carry = 0u128;
        for i in 0..count {
            let limb = |number: &Self| u128::from(number.limbs.get(i).copied().unwrap_or(0));
            carry += limb(self) + limb(other);
            limbs.push(carry as u64);
            carry >>= 64;
        }
        limbs.push(carry as u64);
        Self { negative: self.negative, limbs }.trimmed()
    }

    /// |self| − |other| ≥ 0 with the sign of `self`.
    fn magnitude_minus(&self, other: &Self) -> Self {
        let mut limbs = self.limbs.clone();
        let mut borrow = false;
        for (i, limb) in limbs.iter_mut().enumerate() {
            let (difference, first) = limb.overflowing_sub(other.limbs.get(i).copied().unwrap_or(0));
            let (difference, second) = difference.overflowing_sub(u64::from(borrow));
            (*limb, borrow) = (difference, first || second);
        }
        Self { negative: self.negative, limbs }.trimmed()
    }

    pub(super) fn times(&self, other: &Self) -> Self {
        let mut limbs = vec![0u64; self.limbs.len() + other.limbs.len()];
        for (i, a) in self.limbs.iter().enumerate() {
            let mut carry = 0u128;
            for (j, b) in other.limbs.iter().enumerate() {
                carry += u128::from(*a) * u128::from(*b) + u128::from(limbs[i + j]);
                limbs[i + j] = carry as u64;
                carry >>= 64;
            }
            limbs[i + other.limbs.len()] = carry as u64;
        }
        Self { negative: self.negative != other.negative, limbs }.trimmed()
    }
}
