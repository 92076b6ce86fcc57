//! Packets as 256-bit registers, for processors with AVX2 and FMA.
//!
//! # Safety
//! The packet types are private to this module. Their only way out is as the type parameter of
//! [`LaneKernel::run`], called below after the processor has been asked for both features. Whoever holds such a type
//! therefore runs on a processor that has them, and every intrinsic here needs nothing else.
#![allow(
    unsafe_code,
    reason = "vector intrinsics behind run-time dispatch: the singular value decomposition is 14 (f32) and 7 \
              (f64) times as fast as nalgebra's, against 1.6 for single numbers (benches/kernels.rs)"
)]

use super::{LaneKernel, Packet};
use crate::scalar::{Mask, Scalar};
use std::arch::x86_64::*;
use std::fmt::{self, Debug, Formatter};
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// Whether this processor has AVX2 and FMA; the standard library asks it once and remembers.
#[inline]
pub(super) fn is_supported() -> bool {
    is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma")
}

/// Bytes of a line of the caches.
const LINE: usize = 64;

/// See [`super::prefetch_beyond`].
#[inline(always)]
pub(super) fn prefetch_beyond<T>(data: &[T], by: usize) {
    let first = data.as_ptr().wrapping_add(by).cast::<i8>();
    for at in (0..size_of_val(data)).step_by(LINE) {
        // SAFETY: every x86-64 processor has the instruction; it accesses nothing, and an address that is not there does nothing.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(first.wrapping_add(at)) };
    }
}

/// Runs a kernel with eight `f32` lanes.
///
/// # Panics
/// If the processor is not [supported](is_supported).
#[inline]
pub(super) fn run_f32<K: LaneKernel<f32>>(kernel: K) -> K::Output {
    #[target_feature(enable = "avx2,fma")]
    fn run<K: LaneKernel<f32>>(kernel: K) -> K::Output {
        kernel.run::<F32x8>()
    }
    assert!(is_supported(), "AVX2 or FMA is missing");
    // SAFETY: the features are there.
    unsafe { run(kernel) }
}

/// Runs a kernel with four `f64` lanes.
///
/// # Panics
/// If the processor is not [supported](is_supported).
#[inline]
pub(super) fn run_f64<K: LaneKernel<f64>>(kernel: K) -> K::Output {
    #[target_feature(enable = "avx2,fma")]
    fn run<K: LaneKernel<f64>>(kernel: K) -> K::Output {
        kernel.run::<F64x4>()
    }
    assert!(is_supported(), "AVX2 or FMA is missing");
    // SAFETY: the features are there.
    unsafe { run(kernel) }
}

macro_rules! operator {
    ($packet:ident, $operator:ident, $function:ident, $assign:ident, $assign_function:ident, $intrinsic:ident) => {
        impl $operator for $packet {
            type Output = Self;
            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                // SAFETY: see the module.
                Self(unsafe { $intrinsic(self.0, other.0) })
            }
        }

        impl $assign for $packet {
            #[inline(always)]
            fn $assign_function(&mut self, other: Self) {
                *self = self.$function(other);
            }
        }
    };
}

/// Functions without an instruction, lane by lane through the standard library.
macro_rules! lane_by_lane {
    ($float:ident: $($function:ident)*) => {
        $(
            #[inline(always)]
            fn $function(self) -> Self {
                self.map($float::$function)
            }
        )*
    };
}

macro_rules! packet {
    (
        $packet:ident, $mask:ident, $float:ident, $lanes:literal, $register:ident,
        exponent $exponent_bits:expr, all $all:literal,
        [$add:ident $sub:ident $mul:ident $div:ident $fma:ident $sqrt:ident $min:ident $max:ident],
        [$set:ident $and:ident $or:ident $xor:ident $andnot:ident],
        [$blend:ident $compare:ident $movemask:ident $set_integer:ident $sub_integer:ident],
        [$to_integer:ident $from_integer:ident]
    ) => {
        #[doc = concat!(stringify!($lanes), " lanes of ", stringify!($float), ".")]
        #[derive(Clone, Copy)]
        #[repr(transparent)]
        struct $packet($register);

        #[doc = concat!("One truth value per lane of ", stringify!($packet), ": all bits of it or none.")]
        #[derive(Clone, Copy)]
        #[repr(transparent)]
        struct $mask($register);

        impl $packet {
            #[inline(always)]
            fn map(self, function: impl Fn($float) -> $float) -> Self {
                Self::from_lanes(self.to_lanes().map(function))
            }
        }

        operator!($packet, Add, add, AddAssign, add_assign, $add);
        operator!($packet, Sub, sub, SubAssign, sub_assign, $sub);
        operator!($packet, Mul, mul, MulAssign, mul_assign, $mul);
        operator!($packet, Div, div, DivAssign, div_assign, $div);

        // SAFETY, of every block below: see the module.
        impl Neg for $packet {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                Self(unsafe { $xor(self.0, $set(-0.0)) })
            }
        }

        impl PartialEq for $packet {
            #[inline(always)]
            fn eq(&self, other: &Self) -> bool {
                $mask(unsafe { $compare::<_CMP_EQ_OQ>(self.0, other.0) }).all()
            }
        }

        impl Debug for $packet {
            fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
                self.to_lanes().fmt(f)
            }
        }

        impl Debug for $mask {
            fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
                let bits = unsafe { $movemask(self.0) };
                f.debug_list().entries((0..$lanes).map(|lane| bits >> lane & 1 == 1)).finish()
            }
        }

        impl Mask for $mask {
            #[inline(always)]
            fn and(self, other: Self) -> Self {
                Self(unsafe { $and(self.0, other.0) })
            }
            #[inline(always)]
            fn or(self, other: Self) -> Self {
                Self(unsafe { $or(self.0, other.0) })
            }
            #[inline(always)]
            fn not(self) -> Self {
                Self(unsafe { $xor(self.0, $from_integer($set_integer(-1))) })
            }
            #[inline(always)]
            fn any(self) -> bool {
                unsafe { $movemask(self.0) != 0 }
            }
            #[inline(always)]
            fn all(self) -> bool {
                unsafe { $movemask(self.0) == $all }
            }
        }

        impl Scalar for $packet {
            type Mask = $mask;
            type Value = Self;
            const EPSILON: f64 = <$float as Scalar>::EPSILON;
            const MIN_POSITIVE: f64 = <$float as Scalar>::MIN_POSITIVE;

            lane_by_lane!($float: exp exp_m1 ln ln_1p sin cos tan asin acos sinh cosh tanh);

            #[inline(always)]
            fn value(self) -> Self {
                self
            }
            #[inline(always)]
            fn lift(value: Self) -> Self {
                value
            }
            #[inline(always)]
            fn constant(value: f64) -> Self {
                Self::splat(value as $float)
            }
            #[inline(always)]
            fn mul_add(self, factor: Self, term: Self) -> Self {
                Self(unsafe { $fma(self.0, factor.0, term.0) })
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                Self(unsafe { $sqrt(self.0) })
            }
            #[inline(always)]
            fn atan2(self, x: Self) -> Self {
                let (mut y, x) = (self.to_lanes(), x.to_lanes());
                for i in 0..$lanes {
                    y[i] = y[i].atan2(x[i]);
                }
                Self::from_lanes(y)
            }
            #[inline(always)]
            fn powi(self, exponent: i32) -> Self {
                let mut result = Self::constant(1.0);
                let (mut power, mut remaining) = (self, exponent.unsigned_abs());
                while remaining != 0 {
                    if remaining & 1 == 1 {
                        result *= power;
                    }
                    remaining >>= 1;
                    power *= power;
                }
                if exponent < 0 { result.recip() } else { result }
            }
            #[inline(always)]
            fn powf(self, exponent: f64) -> Self {
                self.map(|a| Scalar::powf(a, exponent))
            }
            #[inline(always)]
            fn reciprocal_power_of_two(self) -> Self {
                // As for one float, see there.
                Self(unsafe {
                    let exponent = $to_integer($and(self.0, $from_integer($set_integer($exponent_bits))));
                    let twice_bias = $set_integer(2 * (1.0 as $float).to_bits().cast_signed());
                    $from_integer($sub_integer(twice_bias, exponent))
                })
            }
            #[inline(always)]
            fn abs(self) -> Self {
                Self(unsafe { $andnot($set(-0.0), self.0) })
            }
            #[inline(always)]
            fn copysign(self, sign: Self) -> Self {
                Self(unsafe {
                    let bit = $set(-0.0);
                    $or($and(bit, sign.0), $andnot(bit, self.0))
                })
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                Self(unsafe { $min(self.0, other.0) })
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                Self(unsafe { $max(self.0, other.0) })
            }
            #[inline(always)]
            fn less(self, other: Self) -> Self::Mask {
                $mask(unsafe { $compare::<_CMP_LT_OQ>(self.0, other.0) })
            }
            #[inline(always)]
            fn less_equal(self, other: Self) -> Self::Mask {
                $mask(unsafe { $compare::<_CMP_LE_OQ>(self.0, other.0) })
            }
            #[inline(always)]
            fn is_finite(self) -> Self::Mask {
                self.abs().less(Self::splat($float::INFINITY))
            }
            #[inline(always)]
            fn select(mask: Self::Mask, yes: Self, no: Self) -> Self {
                Self(unsafe { $blend(no.0, yes.0, mask.0) })
            }
        }
    };
}

packet!(
    F32x8, Mask32x8, f32, 8, __m256,
    exponent 0x7f80_0000, all 0xff,
    [_mm256_add_ps _mm256_sub_ps _mm256_mul_ps _mm256_div_ps _mm256_fmadd_ps _mm256_sqrt_ps _mm256_min_ps _mm256_max_ps],
    [_mm256_set1_ps _mm256_and_ps _mm256_or_ps _mm256_xor_ps _mm256_andnot_ps],
    [_mm256_blendv_ps _mm256_cmp_ps _mm256_movemask_ps _mm256_set1_epi32 _mm256_sub_epi32],
    [_mm256_castps_si256 _mm256_castsi256_ps]
);

packet!(
    F64x4, Mask64x4, f64, 4, __m256d,
    exponent 0x7ff0_0000_0000_0000, all 0xf,
    [_mm256_add_pd _mm256_sub_pd _mm256_mul_pd _mm256_div_pd _mm256_fmadd_pd _mm256_sqrt_pd _mm256_min_pd _mm256_max_pd],
    [_mm256_set1_pd _mm256_and_pd _mm256_or_pd _mm256_xor_pd _mm256_andnot_pd],
    [_mm256_blendv_pd _mm256_cmp_pd _mm256_movemask_pd _mm256_set1_epi64x _mm256_sub_epi64],
    [_mm256_castpd_si256 _mm256_castsi256_pd]
);

impl Packet for F32x8 {
    type Element = f32;

    #[inline(always)]
    fn load(elements: &[f32]) -> Self {
        let elements: &[f32] = &elements[..8];
        // SAFETY: eight elements are there.
        Self(unsafe { _mm256_loadu_ps(elements.as_ptr()) })
    }
    #[inline(always)]
    fn store(self, elements: &mut [f32]) {
        let elements: &mut [f32] = &mut elements[..8];
        // SAFETY: eight elements are there.
        unsafe { _mm256_storeu_ps(elements.as_mut_ptr(), self.0) }
    }
    #[inline(always)]
    fn splat(element: f32) -> Self {
        Self(unsafe { _mm256_set1_ps(element) })
    }
    #[inline(always)]
    fn load_repeated(elements: &[f32]) -> Self {
        let elements: &[f32] = &elements[..4];
        // SAFETY: four elements are there.
        Self(unsafe {
            let four = _mm_loadu_ps(elements.as_ptr());
            _mm256_set_m128(four, four)
        })
    }
    #[inline(always)]
    fn halves(first: Self, second: Self) -> Self {
        // SAFETY: see the module.
        Self(unsafe { _mm256_blend_ps::<0xf0>(first.0, second.0) })
    }
    #[inline(always)]
    fn bits(mask: Self::Mask) -> u32 {
        // SAFETY: see the module.
        unsafe { _mm256_movemask_ps(mask.0) }.cast_unsigned()
    }
    #[inline(always)]
    fn keep(self, mask: Self::Mask) -> Self {
        // SAFETY: see the module.
        Self(unsafe { _mm256_and_ps(self.0, mask.0) })
    }
    #[inline(always)]
    fn transpose(block: &mut [Self]) {
        assert_eq!(block.len(), 8, "a block to transpose has as many packets as lanes");
        // SAFETY: see the module.
        unsafe {
            // Pairs of rows interleaved, then pairs of pairs, then the halves of the registers exchanged.
            let mut pairs = [_mm256_setzero_ps(); 8];
            for i in 0..4 {
                let (even, odd) = (block[2 * i].0, block[2 * i + 1].0);
                pairs[2 * i] = _mm256_unpacklo_ps(even, odd);
                pairs[2 * i + 1] = _mm256_unpackhi_ps(even, odd);
            }
            let mut quads = pairs;
            for half in 0..2 {
                for k in 0..2 {
                    let (first, second) = (pairs[4 * half + k], pairs[4 * half + k + 2]);
                    quads[4 * half + 2 * k] = _mm256_shuffle_ps::<0x44>(first, second);
                    quads[4 * half + 2 * k + 1] = _mm256_shuffle_ps::<0xee>(first, second);
                }
            }
            for i in 0..4 {
                block[i].0 = _mm256_permute2f128_ps::<0x20>(quads[i], quads[i + 4]);
                block[i + 4].0 = _mm256_permute2f128_ps::<0x31>(quads[i], quads[i + 4]);
            }
        }
    }
}

impl Packet for F64x4 {
    type Element = f64;

    #[inline(always)]
    fn load(elements: &[f64]) -> Self {
        let elements: &[f64] = &elements[..4];
        // SAFETY: four elements are there.
        Self(unsafe { _mm256_loadu_pd(elements.as_ptr()) })
    }
    #[inline(always)]
    fn store(self, elements: &mut [f64]) {
        let elements: &mut [f64] = &mut elements[..4];
        // SAFETY: four elements are there.
        unsafe { _mm256_storeu_pd(elements.as_mut_ptr(), self.0) }
    }
    #[inline(always)]
    fn splat(element: f64) -> Self {
        Self(unsafe { _mm256_set1_pd(element) })
    }
    #[inline(always)]
    fn load_repeated(elements: &[f64]) -> Self {
        Self::load(elements)
    }
    #[inline(always)]
    fn halves(first: Self, second: Self) -> Self {
        // SAFETY: see the module.
        Self(unsafe { _mm256_blend_pd::<0xc>(first.0, second.0) })
    }
    #[inline(always)]
    fn bits(mask: Self::Mask) -> u32 {
        // SAFETY: see the module.
        unsafe { _mm256_movemask_pd(mask.0) }.cast_unsigned()
    }
    #[inline(always)]
    fn keep(self, mask: Self::Mask) -> Self {
        // SAFETY: see the module.
        Self(unsafe { _mm256_and_pd(self.0, mask.0) })
    }
    #[inline(always)]
    fn transpose(block: &mut [Self]) {
        assert_eq!(block.len(), 4, "a block to transpose has as many packets as lanes");
        let [a, b, c, d] = [block[0].0, block[1].0, block[2].0, block[3].0];
        // SAFETY: see the module.
        unsafe {
            let (ab, cd) = (_mm256_unpacklo_pd(a, b), _mm256_unpacklo_pd(c, d));
            let (ab_odd, cd_odd) = (_mm256_unpackhi_pd(a, b), _mm256_unpackhi_pd(c, d));
            block[0].0 = _mm256_permute2f128_pd::<0x20>(ab, cd);
            block[1].0 = _mm256_permute2f128_pd::<0x20>(ab_odd, cd_odd);
            block[2].0 = _mm256_permute2f128_pd::<0x31>(ab, cd);
            block[3].0 = _mm256_permute2f128_pd::<0x31>(ab_odd, cd_odd);
        }
    }
}
