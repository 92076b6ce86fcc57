//! Data arrays inside a VTK XML file.

use super::{Field, FieldValues, Fields, VtkEncoding};
use crate::mesh::io::error::MeshFileError;
use crate::tensor::Vec3;
use std::io::{self, Write};

pub(super) struct Arrays<'a, W> {
    sink: &'a mut W,
    encoding: VtkEncoding,
}

impl<'a, W: Write> Arrays<'a, W> {
    pub(super) fn begin(kind: &str, encoding: VtkEncoding, sink: &'a mut W) -> Result<Self, MeshFileError> {
        writeln!(sink, "<?xml version=\"1.0\"?>")?;
        let attributes = "version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\"";
        writeln!(sink, "<VTKFile type=\"{kind}\" {attributes}>\n<{kind}>")?;
        Ok(Self { sink, encoding })
    }

    pub(super) fn end(mut self, kind: &str) -> Result<(), MeshFileError> {
        self.line(&format!("</Piece>\n</{kind}>\n</VTKFile>"))
    }

    pub(super) fn line(&mut self, line: &str) -> Result<(), MeshFileError> {
        Ok(writeln!(self.sink, "{line}")?)
    }

    pub(super) fn points(&mut self, points: &[Vec3]) -> Result<(), MeshFileError> {
        self.line("<Points>")?;
        self.reals("Points", 3, 3 * points.len(), points.iter().flatten().copied())?;
        self.line("</Points>")
    }

    /// The section of a VTP file for cells of `corners` points each.
    pub(super) fn cells(&mut self, name: &str, corners: usize, flat: &[u32]) -> Result<(), MeshFileError> {
        self.line(&format!("<{name}>"))?;
        self.integers("connectivity", flat.len(), flat.iter().map(|&i| i64::from(i)))?;
        let count = flat.len() / corners;
        self.integers("offsets", count, (1..=count).map(|k| (corners * k) as i64))?;
        self.line(&format!("</{name}>"))
    }

    pub(super) fn fields(&mut self, fields: &Fields<'_>) -> Result<(), MeshFileError> {
        for (name, fields) in [("PointData", fields.points), ("CellData", fields.cells)] {
            self.line(&format!("<{name}>"))?;
            fields.iter().try_for_each(|field| self.field(field))?;
            self.line(&format!("</{name}>"))?;
        }
        Ok(())
    }

    fn field(&mut self, field: &Field<'_>) -> Result<(), MeshFileError> {
        let (name, n) = (field.name, field.values.len());
        match field.values {
            FieldValues::Scalars(values) => self.reals(name, 1, n, values.iter().copied()),
            FieldValues::Vectors(values) => self.reals(name, 3, 3 * n, values.iter().flatten().copied()),
            FieldValues::Integers(values) => {
                let (numbers, text) = (values.iter().map(|i| i.to_le_bytes()), values.iter());
                self.array("Int32", name, 1, n, numbers, text)
            }
            // nalgebra iterates column by column; VTK wants rows.
            FieldValues::Tensors(values) => {
                let rows: Vec<f64> =
                    values.iter().flat_map(|a| a.transpose().iter().copied().collect::<Vec<_>>()).collect();
                self.reals(name, 9, 9 * n, rows.iter().copied())
            }
        }
    }

    fn reals(
        &mut self,
        name: &str,
        components: usize,
        count: usize,
        values: impl Iterator<Item = f64> + Clone,
    ) -> Result<(), MeshFileError> {
        let text = values.clone().map(Digits);
        self.array("Float64", name, components, count, values.map(f64::to_le_bytes), text)
    }

    pub(super) fn integers(
        &mut self,
        name: &str,
        count: usize,
        values: impl Iterator<Item = i64> + Clone,
    ) -> Result<(), MeshFileError> {
        self.array("Int64", name, 1, count, values.clone().map(i64::to_le_bytes), values)
    }

    pub(super) fn bytes(
        &mut self,
        name: &str,
        count: usize,
        values: impl Iterator<Item = u8> + Clone,
    ) -> Result<(), MeshFileError> {
        self.array("UInt8", name, 1, count, values.clone().map(|b| [b]), values)
    }

    fn array<const B: usize>(
        &mut self,
        kind: &str,
        name: &str,
        components: usize,
        count: usize,
        numbers: impl Iterator<Item = [u8; B]>,
        text: impl Iterator<Item: std::fmt::Display>,
    ) -> Result<(), MeshFileError> {
        let format = match self.encoding {
            VtkEncoding::Ascii => "ascii",
            VtkEncoding::Base64 => "binary",
        };
        let name = escaped(name);
        let attributes = format!("Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"{format}\"");
        writeln!(self.sink, "<DataArray type=\"{kind}\" {attributes}>")?;
        match self.encoding {
            VtkEncoding::Ascii => write_text(self.sink, text)?,
            VtkEncoding::Base64 => {
                let mut base64 = Base64::new(&mut *self.sink);
                base64.push(&((count * B) as u64).to_le_bytes())?;
                base64.flush()?;
                numbers.into_iter().try_for_each(|bytes| base64.push(&bytes))?;
                base64.flush()?;
            }
        }
        Ok(writeln!(self.sink, "\n</DataArray>")?)
    }
}

/// A number in the shortest form that reads back bit by bit.
struct Digits(f64);

impl std::fmt::Display for Digits {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:?}", self.0)
    }
}

fn write_text(sink: &mut impl Write, values: impl Iterator<Item: std::fmt::Display>) -> io::Result<()> {
    for (k, value) in values.enumerate() {
        // VTK reads lines of any length; people do not.
        let separator = if k % 12 == 11 { '\n' } else { ' ' };
        write!(sink, "{value}{separator}")?;
    }
    Ok(())
}

/// Base64 as in RFC 4648, section 4, with padding.
struct Base64<'a, W> {
    sink: &'a mut W,
    waiting: [u8; 3],
    filled: usize,
}

impl<'a, W: Write> Base64<'a, W> {
    fn new(sink: &'a mut W) -> Self {
        Self { sink, waiting: [0; 3], filled: 0 }
    }

    fn push(&mut self, bytes: &[u8]) -> io::Result<()> {
        for &byte in bytes {
            self.waiting[self.filled] = byte;
            self.filled += 1;
            if self.filled == 3 {
                self.emit()?;
            }
        }
        Ok(())
    }

    /// Writes what is left, padded to four characters.
    fn flush(&mut self) -> io::Result<()> {
        if self.filled > 0 { self.emit() } else { Ok(()) }
    }

    fn emit(&mut self) -> io::Result<()> {
        const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        let [a, b, c] = self.waiting.map(u32::from);
        let bits = a << 16 | b << 8 | c;
        let digit = |k: usize| {
            let padding = k > self.filled;
            if padding { b'=' } else { ALPHABET[(bits >> (18 - 6 * k) & 63) as usize] }
        };
        self.sink.write_all(&[digit(0), digit(1), digit(2), digit(3)])?;
        self.waiting = [0; 3];
        self.filled = 0;
        Ok(())
    }
}

/// Text for an XML attribute.
pub(super) fn escaped(text: &str) -> String {
    let escape = |c: char| match c {
        '&' => "&amp;".into(),
        '<' => "&lt;".into(),
        '>' => "&gt;".into(),
        '"' => "&quot;".into(),
        // XML 1.0 has no way to write other control characters.
        c if c.is_control() => " ".into(),
        c => c.to_string(),
    };
    text.chars().map(escape).collect::<Vec<String>>().concat()
}
