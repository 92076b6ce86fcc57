//! A number that finds out which blocks of arguments a second derivative can couple.
//!
//! Mixed second derivatives of a formula in n arguments, a block of arguments against a block at a time, take a number
//! of passes that grows with n². Most pairs of blocks of a chain or a network have none. One pass on [`Coupled`] tells
//! which have: two arguments are coupled where they meet in a product, a quotient, or a function that is not linear. The
//! numbers take the branches that jets take at the same arguments, so the answer holds for these arguments.

use mechanics_core::scalar::Scalar;
use std::cell::Cell;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// Blocks that are told apart; more share.
const BLOCKS: usize = 64;

thread_local! {
    /// For every block, those that it is coupled with, as found since [`Couplings::found`] began.
    static MET: [Cell<u64>; BLOCKS] = const { [const { Cell::new(0) }; BLOCKS] };
}

/// A value, and the blocks of arguments that its first derivative may mention.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coupled {
    value: f64,
    blocks: u64,
}

/// Equal numbers, as equal jets, decide the same way.
impl PartialEq for Coupled {
    fn eq(&self, other: &Self) -> bool {
        self.value == other.value
    }
}

impl Coupled {
    /// An argument out of a block.
    pub(super) fn argument(value: f64, block: usize, blocks: usize) -> Self {
        Self { value, blocks: 1 << bit(block, blocks) }
    }

    /// Whether a first derivative in `block` may be other than zero.
    pub(super) fn mentions(self, block: usize, blocks: usize) -> bool {
        self.blocks >> bit(block, blocks) & 1 == 1
    }

    fn meeting(value: f64, left: u64, right: u64) -> Self {
        if left != 0 && right != 0 {
            MET.with(|met| {
                let add = |to: u64, partners: u64| {
                    let mut rest = to;
                    while rest != 0 {
                        let cell = &met[rest.trailing_zeros() as usize];
                        cell.set(cell.get() | partners);
                        rest &= rest - 1;
                    }
                };
                add(left, right);
                add(right, left);
            });
        }
        Self { value, blocks: left | right }
    }

    fn function(self, value: f64) -> Self {
        Self::meeting(value, self.blocks, self.blocks)
    }
}

fn bit(block: usize, blocks: usize) -> usize {
    if blocks <= BLOCKS { block } else { block * BLOCKS / blocks }
}

/// Which pairs of blocks a formula couples.
pub(super) struct Couplings {
    met: [u64; BLOCKS],
    blocks: usize,
}

impl Couplings {
    /// Runs a formula over arguments out of `blocks` blocks.
    pub(super) fn found(blocks: usize, formula: impl FnOnce()) -> Self {
        MET.with(|met| met.iter().for_each(|cell| cell.set(0)));
        formula();
        Self { met: MET.with(|met| std::array::from_fn(|i| met[i].get())), blocks }
    }

    /// Whether a second derivative in both blocks may be other than zero.
    pub(super) fn has(&self, a: usize, b: usize) -> bool {
        self.met[bit(a, self.blocks)] >> bit(b, self.blocks) & 1 == 1
    }
}

impl Add for Coupled {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { value: self.value + other.value, blocks: self.blocks | other.blocks }
    }
}

impl Neg for Coupled {
    type Output = Self;
    fn neg(self) -> Self {
        Self { value: -self.value, ..self }
    }
}

impl Sub for Coupled {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Coupled {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self::meeting(self.value * other.value, self.blocks, other.blocks)
    }
}

impl Div for Coupled {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        Self::meeting(self.value / other.value, self.blocks | other.blocks, other.blocks)
    }
}

macro_rules! assigning {
    ($($trait:ident $method:ident $operator:tt),*) => { $(
        impl $trait for Coupled {
            fn $method(&mut self, other: Self) {
                *self = *self $operator other;
            }
        }
    )* };
}

assigning!(AddAssign add_assign +, SubAssign sub_assign -, MulAssign mul_assign *, DivAssign div_assign /);

macro_rules! functions {
    ($($name:ident),*) => { $(
        fn $name(self) -> Self {
            self.function(f64::$name(self.value))
        }
    )* };
}

impl Scalar for Coupled {
    type Mask = bool;
    type Value = f64;
    const EPSILON: f64 = f64::EPSILON;
    const MIN_POSITIVE: f64 = f64::MIN_POSITIVE;
    const DIFFERENTIATES: bool = true;

    fn value(self) -> f64 {
        self.value
    }
    fn lift(value: f64) -> Self {
        Self { value, blocks: 0 }
    }
    fn constant(value: f64) -> Self {
        Self::lift(value)
    }

    functions!(sqrt, exp, exp_m1, ln, ln_1p, sin, cos, tan, asin, acos, sinh, cosh, tanh);

    fn atan2(self, x: Self) -> Self {
        let both = self.blocks | x.blocks;
        Self::meeting(self.value.atan2(x.value), both, both)
    }
    fn powi(self, exponent: i32) -> Self {
        self.function(self.value.powi(exponent))
    }
    fn powf(self, exponent: f64) -> Self {
        self.function(self.value.powf(exponent))
    }
    fn reciprocal_power_of_two(self) -> Self {
        Self::lift(self.value.reciprocal_power_of_two())
    }
    fn abs(self) -> Self {
        Self { value: self.value.abs(), ..self }
    }
    fn copysign(self, sign: Self) -> Self {
        Self { value: self.value.copysign(sign.value), ..self }
    }
    fn less(self, other: Self) -> bool {
        self.value < other.value
    }
    fn less_equal(self, other: Self) -> bool {
        self.value <= other.value
    }
    fn is_finite(self) -> bool {
        self.value.is_finite()
    }
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
}
