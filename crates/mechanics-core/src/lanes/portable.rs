//! Packets as arrays of floats, for every processor.
//!
//! On x86-64 almost every processor takes the packets with AVX2, and these are compiled beside them for the others. Written out lane by lane
//! they are the dearest code there is to compile (measured: half of the time of the crates with kernels), so in builds with debug assertions the
//! loops over lanes are calls there. Release builds, and other processors in any build, have them inline.

use super::{Element, Packet};
use crate::scalar::{Mask, Scalar};
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// `N` floats that move together; the compiler finds what vector instructions it may.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Portable<E, const N: usize>([E; N]);

/// One truth value per lane of a [`Portable`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PortableMask<const N: usize>([bool; N]);

impl<E: Element, const N: usize> Portable<E, N> {
    #[cfg_attr(all(target_arch = "x86_64", debug_assertions), inline(never))]
    #[cfg_attr(not(all(target_arch = "x86_64", debug_assertions)), inline(always))]
    fn map(mut self, function: impl Fn(E) -> E) -> Self {
        for a in &mut self.0 {
            *a = function(*a);
        }
        self
    }

    #[cfg_attr(all(target_arch = "x86_64", debug_assertions), inline(never))]
    #[cfg_attr(not(all(target_arch = "x86_64", debug_assertions)), inline(always))]
    fn zip(mut self, other: Self, function: impl Fn(E, E) -> E) -> Self {
        for (a, b) in self.0.iter_mut().zip(other.0) {
            *a = function(*a, b);
        }
        self
    }

    #[cfg_attr(all(target_arch = "x86_64", debug_assertions), inline(never))]
    #[cfg_attr(not(all(target_arch = "x86_64", debug_assertions)), inline(always))]
    fn compare(self, other: Self, relation: impl Fn(E, E) -> bool) -> PortableMask<N> {
        let mut mask = [false; N];
        for i in 0..N {
            mask[i] = relation(self.0[i], other.0[i]);
        }
        PortableMask(mask)
    }
}

impl<const N: usize> PortableMask<N> {
    #[cfg_attr(all(target_arch = "x86_64", debug_assertions), inline(never))]
    #[cfg_attr(not(all(target_arch = "x86_64", debug_assertions)), inline(always))]
    fn zip(mut self, other: Self, function: impl Fn(bool, bool) -> bool) -> Self {
        for (a, b) in self.0.iter_mut().zip(other.0) {
            *a = function(*a, b);
        }
        self
    }
}

impl<const N: usize> Mask for PortableMask<N> {
    #[inline(always)]
    fn and(self, other: Self) -> Self {
        self.zip(other, |a, b| a & b)
    }
    #[inline(always)]
    fn or(self, other: Self) -> Self {
        self.zip(other, |a, b| a | b)
    }
    #[inline(always)]
    fn not(mut self) -> Self {
        for a in &mut self.0 {
            *a = !*a;
        }
        self
    }
    #[inline(always)]
    fn any(self) -> bool {
        self.0.contains(&true)
    }
    #[inline(always)]
    fn all(self) -> bool {
        !self.0.contains(&false)
    }
}

impl<E: Element, const N: usize> Add for Portable<E, N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl<E: Element, const N: usize> AddAssign for Portable<E, N> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<E: Element, const N: usize> Sub for Portable<E, N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl<E: Element, const N: usize> SubAssign for Portable<E, N> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl<E: Element, const N: usize> Mul for Portable<E, N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
}

impl<E: Element, const N: usize> MulAssign for Portable<E, N> {
    #[inline(always)]
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}

impl<E: Element, const N: usize> Div for Portable<E, N> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.zip(other, |a, b| a / b)
    }
}

impl<E: Element, const N: usize> DivAssign for Portable<E, N> {
    #[inline(always)]
    fn div_assign(&mut self, other: Self) {
        *self = *self / other;
    }
}

impl<E: Element, const N: usize> Neg for Portable<E, N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|a| -a)
    }
}

/// Functions of one number, lane by lane.
macro_rules! lane_by_lane {
    ($($function:ident)*) => {
        $(
            #[inline(always)]
            fn $function(self) -> Self {
                self.map(E::$function)
            }
        )*
    };
}

impl<E: Element, const N: usize> Scalar for Portable<E, N> {
    type Mask = PortableMask<N>;
    type Value = Self;
    const EPSILON: f64 = E::EPSILON;
    const MIN_POSITIVE: f64 = E::MIN_POSITIVE;

    lane_by_lane!(
        sqrt exp exp_m1 ln ln_1p sin cos tan asin acos sinh cosh tanh abs reciprocal_power_of_two
    );

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
        Self([E::constant(value); N])
    }
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        self.zip(x, E::atan2)
    }
    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        self.zip(sign, E::copysign)
    }
    #[inline(always)]
    fn powi(self, exponent: i32) -> Self {
        self.map(|a| a.powi(exponent))
    }
    #[inline(always)]
    fn powf(self, exponent: f64) -> Self {
        self.map(|a| a.powf(exponent))
    }
    #[inline(always)]
    fn less(self, other: Self) -> Self::Mask {
        self.compare(other, |a, b| a.less(b))
    }
    #[inline(always)]
    fn less_equal(self, other: Self) -> Self::Mask {
        self.compare(other, |a, b| a.less_equal(b))
    }
    #[inline(always)]
    fn is_finite(self) -> Self::Mask {
        self.compare(self, |a, _| a.is_finite())
    }
    #[cfg_attr(all(target_arch = "x86_64", debug_assertions), inline(never))]
    #[cfg_attr(not(all(target_arch = "x86_64", debug_assertions)), inline(always))]
    fn select(mask: Self::Mask, yes: Self, mut no: Self) -> Self {
        for i in 0..N {
            no.0[i] = E::select(mask.0[i], yes.0[i], no.0[i]);
        }
        no
    }
}

impl<E: Element, const N: usize> Packet for Portable<E, N> {
    type Element = E;

    #[inline(always)]
    fn load(elements: &[E]) -> Self {
        let mut lanes = [E::default(); N];
        lanes.copy_from_slice(&elements[..N]);
        Self(lanes)
    }
    #[inline(always)]
    fn store(self, elements: &mut [E]) {
        elements[..N].copy_from_slice(&self.0);
    }
    #[inline(always)]
    fn splat(element: E) -> Self {
        Self([element; N])
    }
}
