//! The types that sections hold.

use crate::tensor::{Mat3, Vec3};

/// What the elements of a section are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// Bytes, and text as UTF-8.
    Bytes,
    /// 32-bit unsigned integers.
    U32,
    /// 64-bit unsigned integers.
    U64,
    /// Single-precision numbers.
    F32,
    /// Double-precision numbers.
    F64,
    /// Vectors of three doubles.
    Vec3,
    /// 3×3 matrices of doubles, column after column.
    Mat3,
}

impl Kind {
    const ALL: [Self; 7] = [Self::Bytes, Self::U32, Self::U64, Self::F32, Self::F64, Self::Vec3, Self::Mat3];

    /// The number that stands for this kind in a file.
    pub fn code(self) -> u32 {
        match self {
            Self::Bytes => 1,
            Self::U32 => 2,
            Self::U64 => 3,
            Self::F32 => 4,
            Self::F64 => 5,
            Self::Vec3 => 6,
            Self::Mat3 => 7,
        }
    }

    /// The kind that `code` stands for.
    pub fn from_code(code: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.code() == code)
    }

    /// How many bytes one element takes.
    pub fn element_size(self) -> usize {
        match self {
            Self::Bytes => 1,
            Self::U32 | Self::F32 => 4,
            Self::U64 | Self::F64 => 8,
            Self::Vec3 => 24,
            Self::Mat3 => 72,
        }
    }
}

impl std::fmt::Display for Kind {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(match self {
            Self::Bytes => "bytes",
            Self::U32 => "u32",
            Self::U64 => "u64",
            Self::F32 => "f32",
            Self::F64 => "f64",
            Self::Vec3 => "Vec3",
            Self::Mat3 => "Mat3",
        })
    }
}

mod sealed {
    pub trait Sealed {}
}

/// A type that a section can hold an array of. Floating-point numbers keep their bits, those of NaN and −0 too.
///
/// Implemented here only: the file format lists its kinds.
pub trait Element: Copy + sealed::Sealed {
    /// The kind of a section of these.
    const KIND: Kind;

    /// Appends the little-endian bytes of this element.
    fn append_to(&self, bytes: &mut Vec<u8>);

    /// The element with these little-endian bytes.
    ///
    /// # Panics
    /// If there are not exactly [`Kind::element_size`] bytes.
    fn from_bytes(bytes: &[u8]) -> Self;
}

macro_rules! number {
    ($number:ty, $kind:ident) => {
        impl sealed::Sealed for $number {}
        impl Element for $number {
            const KIND: Kind = Kind::$kind;

            #[inline]
            fn append_to(&self, bytes: &mut Vec<u8>) {
                bytes.extend_from_slice(&self.to_le_bytes());
            }

            #[inline]
            fn from_bytes(bytes: &[u8]) -> Self {
                let mut array = [0; size_of::<Self>()];
                array.copy_from_slice(bytes);
                Self::from_le_bytes(array)
            }
        }
    };
}

number!(u8, Bytes);
number!(u32, U32);
number!(u64, U64);
number!(f32, F32);
number!(f64, F64);

macro_rules! doubles {
    ($tensor:ty, $kind:ident) => {
        impl sealed::Sealed for $tensor {}
        impl Element for $tensor {
            const KIND: Kind = Kind::$kind;

            #[inline]
            fn append_to(&self, bytes: &mut Vec<u8>) {
                for entry in self.as_slice() {
                    entry.append_to(bytes);
                }
            }

            #[inline]
            fn from_bytes(bytes: &[u8]) -> Self {
                assert_eq!(bytes.len(), Self::KIND.element_size(), "the bytes of one element");
                Self::from_iterator(bytes.chunks_exact(8).map(f64::from_bytes))
            }
        }
    };
}

doubles!(Vec3, Vec3);
doubles!(Mat3, Mat3);
