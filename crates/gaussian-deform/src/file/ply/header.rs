//! The header: which properties there are, and where.

use super::PlyEncoding;
use crate::file::{FileError, SplatFormat};
use crate::splats::Degree;
use std::collections::BTreeMap;

/// A scalar type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Kind {
    fn of(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// Where a property stands in its row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Column {
    /// Its number among the properties.
    pub(super) index: usize,
    /// Its first byte in a binary row.
    pub(super) offset: usize,
    pub(super) kind: Kind,
}

/// An element of which only scalars are known.
#[derive(Default)]
struct ElementRows {
    name: String,
    count: u64,
    properties: usize,
    /// Bytes of a binary row.
    size: usize,
    has_list: bool,
    columns: BTreeMap<String, Column>,
}

/// What a header says of its Gaussians.
pub(super) struct Header {
    pub(super) encoding: PlyEncoding,
    /// Where the body begins.
    pub(super) body: usize,
    /// Rows before the Gaussians: bytes of binary files, tokens of text.
    pub(super) skipped: u128,
    pub(super) count: u64,
    /// Properties of a row.
    pub(super) properties: usize,
    /// Bytes of a binary row.
    pub(super) size: usize,
    pub(super) degree: Degree,
    /// Columns in the order of [`Header::NAMES`], then `f_rest_0` and so on.
    pub(super) columns: Vec<Column>,
}

impl Header {
    /// The properties that every Gaussian has.
    pub(super) const NAMES: [&'static str; 14] = [
        "x", "y", "z", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3", "opacity",
        "f_dc_0", "f_dc_1", "f_dc_2",
    ];

    /// The name of a column of [`Header::columns`].
    pub(super) fn name(column: usize) -> String {
        match Self::NAMES.get(column) {
            Some(name) => (*name).to_string(),
            None => format!("f_rest_{}", column - Self::NAMES.len()),
        }
    }

    pub(super) fn read(bytes: &[u8]) -> Result<Self, FileError> {
        let mut lines = Lines { bytes, offset: 0, number: 0 };
        if lines.next()? != "ply" {
            return Err(lines.error("something else", "the line \"ply\""));
        }
        let mut encoding = None;
        let mut elements: Vec<ElementRows> = Vec::new();
        loop {
            let line = lines.next()?;
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            match words[..] {
                [] | ["comment" | "obj_info", ..] => {}
                ["format", name, "1.0"] if encoding.is_none() => {
                    encoding = Some(encoding_of(name).ok_or_else(|| lines.error(name, ENCODING))?);
                }
                ["element", name, count] => {
                    let count = count.parse().map_err(|_| lines.error(count, "a number of rows"))?;
                    elements.push(ElementRows { name: name.to_string(), count, ..Default::default() });
                }
                ["property", ref property @ ..] => match elements.last_mut() {
                    Some(element) => element.add_property(property, &lines)?,
                    None => return Err(lines.error("a property", "an element before it")),
                },
                ["end_header"] => break,
                _ => return Err(lines.error(line, "a line of a PLY header")),
            }
        }
        let encoding = encoding.ok_or_else(|| lines.error("end_header", "a line \"format … 1.0\""))?;
        Self::of_elements(encoding, lines.offset, elements)
    }

    fn of_elements(
        encoding: PlyEncoding,
        body: usize,
        mut elements: Vec<ElementRows>,
    ) -> Result<Self, FileError> {
        let Some(place) = elements.iter().position(|e| e.name == "vertex") else {
            return Err(FileError::MissingProperty { property: "x".to_string() });
        };
        if elements[place + 1..].iter().any(|e| e.name == "vertex") {
            return Err(FileError::Repeated { name: "element vertex".to_string() });
        }
        if let Some(element) = elements[..=place].iter().find(|e| e.has_list) {
            return Err(FileError::Unsupported {
                format: SplatFormat::Ply,
                found: format!("a list in element {}", element.name),
                supported: "elements up to vertex have scalar properties",
            });
        }
        let width = |e: &ElementRows| match encoding {
            PlyEncoding::Ascii => e.properties,
            _ => e.size,
        };
        let skipped = elements[..place].iter().map(|e| u128::from(e.count) * width(e) as u128).sum();
        let vertex = elements.swap_remove(place);
        let (degree, columns) = vertex.gaussian_columns()?;
        Ok(Self {
            encoding,
            body,
            skipped,
            count: vertex.count,
            properties: vertex.properties,
            size: vertex.size,
            degree,
            columns,
        })
    }
}

impl ElementRows {
    fn add_property(&mut self, words: &[&str], lines: &Lines<'_>) -> Result<(), FileError> {
        let kind = |name: &str| Kind::of(name).ok_or_else(|| lines.error(name, "a type of PLY"));
        match *words {
            ["list", count, item, _name] => {
                kind(count)?;
                kind(item)?;
                self.has_list = true;
            }
            [name_of_kind, name] => {
                let column = Column { index: self.properties, offset: self.size, kind: kind(name_of_kind)? };
                if self.columns.insert(name.to_string(), column).is_some() {
                    return Err(FileError::Repeated { name: format!("property {name}") });
                }
                self.size += column.kind.size();
            }
            _ => return Err(lines.error(words.join(" "), "a type and a name")),
        }
        self.properties += 1;
        Ok(())
    }

    /// The columns of a Gaussian, and the degree of its harmonics.
    fn gaussian_columns(&self) -> Result<(Degree, Vec<Column>), FileError> {
        let rest = self.columns.keys().filter(|name| name.starts_with("f_rest_")).count();
        let degree = Degree::ALL.into_iter().find(|d| d.stride() - 3 == rest);
        let Some(degree) = degree else {
            let found = match rest {
                72 => "72 properties f_rest, harmonics of degree 4".to_string(),
                _ => format!("{rest} properties f_rest"),
            };
            return Err(FileError::Degree { format: SplatFormat::Ply, found });
        };
        let columns = (0..Header::NAMES.len() + rest).map(|k| {
            let property = Header::name(k);
            self.columns.get(&property).copied().ok_or(FileError::MissingProperty { property })
        });
        Ok((degree, columns.collect::<Result<_, _>>()?))
    }
}

const ENCODING: &str = "ascii, binary_little_endian or binary_big_endian";

fn encoding_of(name: &str) -> Option<PlyEncoding> {
    Some(match name {
        "ascii" => PlyEncoding::Ascii,
        "binary_little_endian" => PlyEncoding::BinaryLittleEndian,
        "binary_big_endian" => PlyEncoding::BinaryBigEndian,
        _ => return None,
    })
}

/// Walks through the lines of the header, ended by LF or CR LF.
struct Lines<'a> {
    bytes: &'a [u8],
    offset: usize,
    /// Lines read so far.
    number: usize,
}

impl<'a> Lines<'a> {
    fn next(&mut self) -> Result<&'a str, FileError> {
        let rest = &self.bytes[self.offset..];
        self.number += 1;
        let Some(length) = rest.iter().position(|&b| b == b'\n') else {
            return Err(self.error("the end of the file", "a line \"end_header\""));
        };
        self.offset += length + 1;
        let line = rest[..length].strip_suffix(b"\r").unwrap_or(&rest[..length]);
        // Comments may be in any encoding; what matters is ASCII.
        Ok(match std::str::from_utf8(line) {
            Ok(line) => line,
            Err(_) if line.starts_with(b"comment") || line.starts_with(b"obj_info") => "comment",
            Err(_) => return Err(self.error("bytes that are no text", "a line of a PLY header")),
        })
    }

    fn error(&self, found: impl Into<String>, expected: &'static str) -> FileError {
        let mut found: String = found.into();
        if found.len() > 60 {
            found = found.chars().take(60).chain(['…']).collect();
        }
        FileError::Header { format: SplatFormat::Ply, line: self.number, found, expected }
    }
}
