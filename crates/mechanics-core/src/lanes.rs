//! Lanes: several numbers in one vector register, and the choice of instructions at run time.
//!
//! A kernel written over [`Packet`] runs on eight `f32` or four `f64` at a time. [`dispatch`] picks the packet
//! for the processor it finds: AVX2 with FMA where present, arrays of floats on every other CPU. A
//! published binary, compiled for plain x86-64, therefore uses the vector units of the machine it runs on.
//!
//! ```
//! use mechanics_core::lanes::{LaneKernel, Packet, dispatch};
//! use mechanics_core::scalar::Scalar;
//!
//! /// Lennard-Jones energy 4 (r⁻¹² − r⁻⁶); it knows nothing of lanes.
//! #[inline(always)]
//! fn energy<S: Scalar>(distance: S) -> S {
//!     let attraction = distance.recip().powi(6);
//!     (attraction.square() - attraction).scale(4.0)
//! }
//!
//! struct Energies<'a> {
//!     distances: &'a [f32],
//!     energies: &'a mut [f32],
//! }
//!
//! impl LaneKernel<f32> for Energies<'_> {
//!     type Output = ();
//!     #[inline(always)]
//!     fn run<P: Packet<Element = f32>>(self) {
//!         let chunks = self.energies.chunks_mut(P::LANES).zip(self.distances.chunks(P::LANES));
//!         for (energies, distances) in chunks {
//!             // The last chunk may be short: its missing lanes are filled with ones.
//!             energy(P::load_or(distances, 1.0)).store_prefix(energies);
//!         }
//!     }
//! }
//!
//! let distances: Vec<f32> = (0..100).map(|i| 1.0 + 0.01 * i as f32).collect();
//! let mut energies = vec![0.0; 100];
//! dispatch(Energies { distances: &distances, energies: &mut energies });
//! // The minimum is −1 at 2^(1/6) = 1.122.
//! assert!((energies[12] + 1.0).abs() < 1e-3);
//! ```
//!
//! # Rules for a kernel
//!
//! - Everything between `run` and the arithmetic must be inlined into the one function that is compiled for AVX2:
//!   mark `run` and the generic functions it calls `#[inline(always)]`, and prefer loops to closures for
//!   long bodies. A function that is not inlined is compiled for plain x86-64; it is still *correct*, but every
//!   operation in it becomes a call.
//! - No `if` on a lane: compare, then [`Scalar::select`]; `mask.any()` may guard a rare path.
//! - The number of lanes is that of the element type on every machine ([`Element::LANES`]), so that data may be
//!   laid out by it.
//!
//! # What may differ
//!
//! The AVX2 packet fuses [`Scalar::mul_add`] into one rounding, the others round twice, so results on different
//! processors may differ in their last bits. On one machine the choice never changes: same binary, same input, same bits.
//! Functions without a vector instruction (`exp`, `sin`, …) run lane by lane through the standard library.

//!
//! # Measured
//!
//! Rust 1.95, an Intel server core with AVX2, `benches/kernels.rs`, singular value decomposition of 1,024 matrices, transposition
//! included. The whole decomposition of a packet becomes one function of about 1,100 instructions, whose only calls
//! are those to panics and to the copy of the last, short chunk. Times in nanoseconds a matrix:
//!
//! | | `f64` | `f32` |
//! |---|---|---|
//! | nalgebra, static SVD | 569 | 472 |
//! | one number at a time | 351 | 289 |
//! | two packets in flight ([`Pair`]), all factors stored | 79 | 34 |
//! | one packet at a time, singular values only | 76 | 32 |
//! | the same with portable packets (SSE2 found by the compiler) | 114 | 53 |

use crate::scalar::Scalar;

#[cfg(target_arch = "x86_64")]
mod avx2;
mod matrices;
mod pair;
mod portable;

pub use matrices::{load_matrices, store_matrices};
pub use pair::Pair;
pub use portable::Portable;

/// Several numbers of one type that move together, lane by lane.
pub trait Packet: Scalar {
    /// The type of one lane, `f32` or `f64`.
    type Element: Element;

    /// How many lanes there are: [`Element::LANES`].
    const LANES: usize = <Self::Element as Element>::LANES;

    /// The first [`LANES`](Self::LANES) elements of a slice.
    ///
    /// # Panics
    /// If the slice is shorter.
    fn load(elements: &[Self::Element]) -> Self;

    /// Writes the lanes to the first [`LANES`](Self::LANES) elements of a slice.
    ///
    /// # Panics
    /// If the slice is shorter.
    fn store(self, elements: &mut [Self::Element]);

    /// The same number on every lane.
    fn splat(element: Self::Element) -> Self;

    /// The first four elements of a slice, over and over.
    ///
    /// # Panics
    /// If the slice is shorter.
    #[inline(always)]
    fn load_repeated(elements: &[Self::Element]) -> Self {
        let mut lanes = <Self::Element as Element>::Lanes::default();
        for (k, lane) in lanes.as_mut().iter_mut().enumerate() {
            *lane = elements[k % 4];
        }
        Self::load(lanes.as_ref())
    }

    /// The first half of the lanes of `first`, and the second half of those of `second`.
    #[inline(always)]
    fn halves(first: Self, second: Self) -> Self {
        let mut lanes = first.to_lanes();
        let half = Self::LANES / 2;
        lanes.as_mut()[half..].copy_from_slice(&second.to_lanes().as_ref()[half..]);
        Self::load(lanes.as_ref())
    }

    /// A mask as bits: bit i is set if lane i is true.
    #[inline(always)]
    fn bits(mask: Self::Mask) -> u32 {
        let truths = Self::select(mask, Self::constant(1.0), Self::constant(0.0)).to_lanes();
        let one = Self::Element::constant(1.0);
        truths.as_ref().iter().rev().fold(0, |bits, &truth| bits << 1 | u32::from(truth == one))
    }

    /// The lanes on which a mask is true, and zero on the others: `select(mask, self, 0)` as one operation on bits.
    #[inline(always)]
    fn keep(self, mask: Self::Mask) -> Self {
        Self::select(mask, self, Self::constant(0.0))
    }

    /// Transposes a square block: lane j of packet i and lane i of packet j change places.
    ///
    /// # Panics
    /// If there are not exactly [`LANES`](Self::LANES) packets.
    #[inline(always)]
    fn transpose(block: &mut [Self]) {
        assert_eq!(block.len(), Self::LANES, "a block to transpose has as many packets as lanes");
        let mut rows = [<Self::Element as Element>::Lanes::default(); MOST_LANES];
        for (row, packet) in rows.iter_mut().zip(block.iter()) {
            *row = packet.to_lanes();
        }
        for (i, packet) in block.iter_mut().enumerate() {
            let mut column = <Self::Element as Element>::Lanes::default();
            for (entry, row) in column.as_mut().iter_mut().zip(&rows) {
                *entry = row.as_ref()[i];
            }
            *packet = Self::load(column.as_ref());
        }
    }

    /// The elements of a slice, and `filling` on the lanes that it does not reach.
    #[inline(always)]
    fn load_or(elements: &[Self::Element], filling: Self::Element) -> Self {
        if elements.len() >= Self::LANES {
            return Self::load(elements);
        }
        let mut lanes = Self::splat(filling).to_lanes();
        lanes.as_mut()[..elements.len()].copy_from_slice(elements);
        Self::load(lanes.as_ref())
    }

    /// Writes as many lanes as the slice has room for.
    #[inline(always)]
    fn store_prefix(self, elements: &mut [Self::Element]) {
        if elements.len() >= Self::LANES {
            return self.store(elements);
        }
        let count = elements.len();
        elements.copy_from_slice(&self.to_lanes().as_ref()[..count]);
    }

    /// The lanes as an array, `[f32; 8]` or `[f64; 4]`.
    #[inline(always)]
    fn to_lanes(self) -> <Self::Element as Element>::Lanes {
        let mut lanes = <Self::Element as Element>::Lanes::default();
        self.store(lanes.as_mut());
        lanes
    }

    /// A packet from an array.
    #[inline(always)]
    fn from_lanes(lanes: <Self::Element as Element>::Lanes) -> Self {
        Self::load(lanes.as_ref())
    }
}

/// The largest number of lanes of any packet.
pub const MOST_LANES: usize = 8;

/// A number that packets are made of: `f32` or `f64`.
pub trait Element: Scalar<Mask = bool> + Default + Into<f64> + sealed::Sealed {
    /// Lanes of a packet: 8 for `f32`, 4 for `f64` (32 bytes).
    const LANES: usize;

    /// The lanes of a packet as an array.
    type Lanes: Copy + Default + AsRef<[Self]> + AsMut<[Self]> + Send + Sync + 'static;

    /// The packet that needs no particular processor.
    type Portable: Packet<Element = Self>;

    /// This number as an index, if it is a whole one from 0 to 2²¹: four instructions less than a conversion that minds all others,
    /// for which the result is any index.
    fn to_index(self) -> usize;

    /// Runs a kernel with the best packet of this processor; see [`dispatch`].
    fn dispatch<K: LaneKernel<Self>>(kernel: K) -> K::Output;
}

/// A computation that is written for any packet of `E`, with its data as fields.
pub trait LaneKernel<E: Element> {
    /// What it returns.
    type Output;

    /// Does the work; mark it `#[inline(always)]`.
    fn run<P: Packet<Element = E>>(self) -> Self::Output;
}

/// Runs a kernel with the widest packet that this processor supports. The processor is asked once; later calls cost
/// one load and one branch.
#[inline]
pub fn dispatch<E: Element, K: LaneKernel<E>>(kernel: K) -> K::Output {
    E::dispatch(kernel)
}

/// Runs a kernel with the portable packet, as [`dispatch`] does on processors without AVX2 and FMA.
#[inline]
pub fn dispatch_portable<E: Element, K: LaneKernel<E>>(kernel: K) -> K::Output {
    kernel.run::<E::Portable>()
}

/// Asks the processor for the memory that lies `by` numbers beyond `data`, as many numbers as `data` has, so that it is in the first
/// cache when its turn comes. Nothing is read: there may be nothing at all. Where the processor cannot be asked, nothing is done.
///
/// For loops over more than the caches hold, whose work on a number is long enough to forget the next one meanwhile.
#[inline(always)]
pub fn prefetch_beyond<T>(data: &[T], by: usize) {
    #[cfg(target_arch = "x86_64")]
    avx2::prefetch_beyond(data, by);
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (data, by);
}

mod sealed {
    /// Only `f32` and `f64` are elements.
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

macro_rules! element {
    ($float:ident, $lanes:expr, $avx2:ident, $shift:expr) => {
        impl Element for $float {
            const LANES: usize = $lanes;
            type Lanes = [$float; $lanes];
            type Portable = Portable<$float, $lanes>;

            #[inline(always)]
            fn to_index(self) -> usize {
                // The sum's last bit weighs one, and the lowest of its mantissa are the whole number.
                (self + $shift).to_bits() as usize & 0x3f_ffff
            }

            #[inline]
            fn dispatch<K: LaneKernel<Self>>(kernel: K) -> K::Output {
                #[cfg(target_arch = "x86_64")]
                if avx2::is_supported() {
                    return avx2::$avx2(kernel);
                }
                dispatch_portable(kernel)
            }
        }
    };
}

element!(f32, 8, run_f32, 12_582_912.0);
element!(f64, 4, run_f64, 6_755_399_441_055_744.0);
