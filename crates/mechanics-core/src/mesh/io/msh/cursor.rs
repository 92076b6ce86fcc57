//! Numbers of an MSH file, be they text or binary.

use crate::mesh::io::bytes::{ByteCursor, ByteOrder};
use crate::mesh::io::error::{MeshFileError, MeshFormat, Place};
use crate::mesh::io::text::{TextCursor, parse, quoted, syntax};

/// How the numbers of a section are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    Binary {
        order: ByteOrder,
        /// The width of what the format calls `size_t`, 4 or 8 bytes.
        size_bytes: usize,
    },
}

pub(super) struct MshCursor<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) text: TextCursor<'a>,
    pub(super) encoding: Encoding,
}

impl<'a> MshCursor<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, text: TextCursor::new(MeshFormat::Msh, bytes, 0, 1), encoding: Encoding::Text }
    }

    /// Where the cursor is. Lines have no meaning in a binary file.
    pub(super) fn place(&self) -> Place {
        match self.encoding {
            Encoding::Text => Place::Line(self.text.line),
            Encoding::Binary { .. } => Place::Byte(self.text.offset),
        }
    }

    pub(super) fn error(&self, found: impl Into<String>, expected: &'static str) -> MeshFileError {
        syntax(MeshFormat::Msh, self.place(), found, expected)
    }

    pub(super) fn unsupported(&self, found: impl Into<String>, supported: &'static str) -> MeshFileError {
        MeshFileError::Unsupported {
            format: MeshFormat::Msh,
            place: self.place(),
            found: found.into(),
            supported,
        }
    }

    /// The next word, which is text in binary files too (the names of sections).
    pub(super) fn word(&mut self, expected: &'static str) -> Result<&'a [u8], MeshFileError> {
        match self.text.token(expected) {
            Ok(word) => Ok(word),
            Err(_) => Err(self.error("the end of the file", expected)),
        }
    }

    /// A count that is text in binary files too, alone on its line.
    pub(super) fn text_count(&mut self, expected: &'static str) -> Result<u64, MeshFileError> {
        let word = self.word(expected)?;
        let count = parse(word).ok_or_else(|| self.error(quoted(word), expected))?;
        self.end_line()?;
        Ok(count)
    }

    /// Leaves a line of which nothing may be left.
    pub(super) fn end_line(&mut self) -> Result<(), MeshFileError> {
        match self.text.next_line() {
            Some(line) if !line.bytes.trim_ascii().is_empty() => {
                Err(self.error(quoted(line.bytes.trim_ascii()), "nothing more in the line before"))
            }
            _ => Ok(()),
        }
    }

    pub(super) fn int(&mut self, expected: &'static str) -> Result<i32, MeshFileError> {
        match self.encoding {
            Encoding::Text => self.text.number(expected),
            Encoding::Binary { order, .. } => self.binary(order, |bytes| bytes.i32(expected)),
        }
    }

    /// What the format calls `size_t`.
    pub(super) fn size(&mut self, expected: &'static str) -> Result<u64, MeshFileError> {
        match self.encoding {
            Encoding::Text => self.text.number(expected),
            Encoding::Binary { order, size_bytes: 4 } => {
                self.binary(order, |bytes| bytes.u32(expected).map(u64::from))
            }
            Encoding::Binary { order, .. } => self.binary(order, |bytes| bytes.u64(expected)),
        }
    }

    /// A number of a node: `size_t` in MSH 4.1, a non-negative `int` in MSH 2.2.
    pub(super) fn int_tag(&mut self, expected: &'static str) -> Result<u64, MeshFileError> {
        if self.encoding == Encoding::Text {
            return self.text.number(expected);
        }
        let tag = self.int(expected)?;
        u64::try_from(tag).map_err(|_| self.error(tag.to_string(), expected))
    }

    pub(super) fn real(&mut self, expected: &'static str) -> Result<f64, MeshFileError> {
        let value: f64 = match self.encoding {
            Encoding::Text => self.text.number(expected)?,
            Encoding::Binary { order, .. } => self.binary(order, |bytes| bytes.f64(expected))?,
        };
        if value.is_finite() { Ok(value) } else { Err(self.error(value.to_string(), "a finite number")) }
    }

    fn binary<T>(
        &mut self,
        order: ByteOrder,
        read: impl FnOnce(&mut ByteCursor<'a>) -> Result<T, MeshFileError>,
    ) -> Result<T, MeshFileError> {
        let mut bytes = ByteCursor::new(MeshFormat::Msh, order, self.bytes, self.text.offset);
        let value = read(&mut bytes)?;
        self.text.offset = bytes.offset;
        Ok(value)
    }
}
