//! Reading and writing binary numbers in either byte order.

use super::error::{MeshFileError, MeshFormat, Place};
use super::text::syntax;

/// In which order the bytes of a number are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ByteOrder {
    /// Least significant byte first, as on x86 and ARM.
    LittleEndian,
    /// Most significant byte first.
    BigEndian,
}

/// Walks through binary data.
pub(super) struct ByteCursor<'a> {
    format: MeshFormat,
    order: ByteOrder,
    bytes: &'a [u8],
    /// The offset of the next unread byte; never beyond the end.
    pub(super) offset: usize,
}

impl<'a> ByteCursor<'a> {
    pub(super) fn new(format: MeshFormat, order: ByteOrder, bytes: &'a [u8], offset: usize) -> Self {
        Self { format, order, bytes, offset: offset.min(bytes.len()) }
    }

    pub(super) fn remaining(&self) -> usize {
        self.bytes.len() - self.offset
    }

    /// The next `count` bytes.
    pub(super) fn take(&mut self, count: usize, expected: &'static str) -> Result<&'a [u8], MeshFileError> {
        if count > self.remaining() {
            let found = format!("the end of the file after {} more bytes", self.remaining());
            return Err(self.error(found, expected));
        }
        let taken = &self.bytes[self.offset..self.offset + count];
        self.offset += count;
        Ok(taken)
    }

    /// The next `N` bytes, least significant first.
    pub(super) fn array<const N: usize>(&mut self, expected: &'static str) -> Result<[u8; N], MeshFileError> {
        let taken = self.take(N, expected)?;
        let mut array: [u8; N] = std::array::from_fn(|k| taken[k]);
        if self.order == ByteOrder::BigEndian {
            array.reverse();
        }
        Ok(array)
    }

    pub(super) fn u32(&mut self, expected: &'static str) -> Result<u32, MeshFileError> {
        self.array(expected).map(u32::from_le_bytes)
    }

    pub(super) fn i32(&mut self, expected: &'static str) -> Result<i32, MeshFileError> {
        self.array(expected).map(i32::from_le_bytes)
    }

    pub(super) fn u64(&mut self, expected: &'static str) -> Result<u64, MeshFileError> {
        self.array(expected).map(u64::from_le_bytes)
    }

    pub(super) fn f64(&mut self, expected: &'static str) -> Result<f64, MeshFileError> {
        self.array(expected).map(f64::from_le_bytes)
    }

    /// An error about what was just read, `back` bytes before the next unread byte.
    pub(super) fn error_back(
        &self,
        back: usize,
        found: impl Into<String>,
        expected: &'static str,
    ) -> MeshFileError {
        syntax(self.format, Place::Byte(self.offset.saturating_sub(back)), found, expected)
    }

    pub(super) fn error(&self, found: impl Into<String>, expected: &'static str) -> MeshFileError {
        self.error_back(0, found, expected)
    }
}
