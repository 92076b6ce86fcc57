//! The header: what elements there are and of which properties they consist.

use super::{ByteOrder, PlyEncoding};
use crate::mesh::io::error::{MeshFileError, MeshFormat, Place};
use crate::mesh::io::text::{TextCursor, parse, quoted, syntax, words};
use std::collections::BTreeSet;

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Number {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Number {
    fn named(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    pub(super) fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
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

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    One(Number),
    List { length: Number, item: Number },
}

#[derive(Debug)]
pub(super) struct Property<'a> {
    pub(super) name: &'a [u8],
    pub(super) kind: Kind,
}

#[derive(Debug)]
pub(super) struct Element<'a> {
    pub(super) name: &'a [u8],
    pub(super) count: u64,
    pub(super) line: usize,
    pub(super) properties: Vec<Property<'a>>,
}

impl Element<'_> {
    pub(super) fn position(&self, name: &[u8]) -> Option<usize> {
        self.properties.iter().position(|p| p.name == name)
    }
}

pub(super) struct Header<'a> {
    pub(super) encoding: PlyEncoding,
    pub(super) elements: Vec<Element<'a>>,
    /// Where the body begins.
    pub(super) offset: usize,
    pub(super) line: usize,
}

impl<'a> Header<'a> {
    pub(super) fn read(bytes: &'a [u8]) -> Result<Self, MeshFileError> {
        let mut cursor = TextCursor::new(MeshFormat::Ply, bytes, 0, 1);
        let magic = cursor.next_line().map_or(&b""[..], |line| line.bytes.trim_ascii());
        if magic != b"ply" {
            return Err(error(1, quoted(magic), "\"ply\""));
        }
        let mut encoding = None;
        let mut elements: Vec<Element<'a>> = Vec::new();
        while let Some(line) = cursor.next_line() {
            let mut words = words(line.bytes);
            match words.next() {
                Some(b"format") => encoding = Some(read_encoding(line.number, words.next(), words.next())?),
                Some(b"comment" | b"obj_info") | None => {}
                Some(b"element") => elements.push(read_element(line.number, words.next(), words.next())?),
                Some(b"property") => {
                    let property = read_property(line.number, words)?;
                    match elements.last_mut() {
                        Some(element) => element.properties.push(property),
                        None => return Err(error(line.number, "a property", "an element before it")),
                    }
                }
                Some(b"end_header") => {
                    let Some(encoding) = encoding else {
                        return Err(error(line.number, "end_header", "a line \"format\" before it"));
                    };
                    check_elements(&elements)?;
                    return Ok(Self { encoding, elements, offset: cursor.offset, line: cursor.line });
                }
                Some(word) => return Err(error(line.number, quoted(word), "a keyword of the header")),
            }
        }
        Err(cursor.error("the end of the file", "\"end_header\""))
    }
}

/// Rows without properties would take no bytes, so that any count of them would "be" there; and the same name twice
/// would make a property's name ambiguous.
fn check_elements(elements: &[Element<'_>]) -> Result<(), MeshFileError> {
    let mut names = BTreeSet::new();
    for element in elements {
        if element.properties.is_empty() && element.count > 0 {
            let found = format!("element {} without properties", quoted(element.name));
            return Err(error(element.line, found, "at least one property"));
        }
        if !names.insert(element.name) {
            let found = format!("element {} again", quoted(element.name));
            return Err(error(element.line, found, "elements of different names"));
        }
        let mut names = BTreeSet::new();
        if let Some(property) = element.properties.iter().find(|p| !names.insert(p.name)) {
            let found = format!("property {} twice", quoted(property.name));
            return Err(error(element.line, found, "properties of different names"));
        }
    }
    Ok(())
}

fn read_encoding(
    line: usize,
    name: Option<&[u8]>,
    version: Option<&[u8]>,
) -> Result<PlyEncoding, MeshFileError> {
    let name = name.unwrap_or_default();
    let encoding = match name {
        b"ascii" => PlyEncoding::Ascii,
        b"binary_little_endian" => PlyEncoding::Binary(ByteOrder::LittleEndian),
        b"binary_big_endian" => PlyEncoding::Binary(ByteOrder::BigEndian),
        _ => {
            let expected = "\"ascii\", \"binary_little_endian\" or \"binary_big_endian\"";
            return Err(error(line, quoted(name), expected));
        }
    };
    match version {
        Some(b"1.0") => Ok(encoding),
        other => Err(error(line, quoted(other.unwrap_or_default()), "version 1.0")),
    }
}

fn read_element<'a>(
    line: usize,
    name: Option<&'a [u8]>,
    count: Option<&[u8]>,
) -> Result<Element<'a>, MeshFileError> {
    let name = name.ok_or_else(|| error(line, "nothing", "the element's name"))?;
    let count = count.unwrap_or_default();
    let count = parse(count).ok_or_else(|| error(line, quoted(count), "the number of elements"))?;
    Ok(Element { name, count, line, properties: Vec::new() })
}

fn read_property<'a>(
    line: usize,
    mut words: impl Iterator<Item = &'a [u8]>,
) -> Result<Property<'a>, MeshFileError> {
    let mut word = |expected| words.next().ok_or_else(|| error(line, "nothing", expected));
    let number = |name: &[u8]| {
        Number::named(name).ok_or_else(|| error(line, quoted(name), "a type such as float or uchar"))
    };
    let first = word("the property's type")?;
    let kind = if first == b"list" {
        let name = word("the type of the list's length")?;
        let length = number(name)?;
        if !length.is_integer() {
            return Err(error(line, quoted(name), "an integer type for the list's length"));
        }
        Kind::List { length, item: number(word("the type of the list's items")?)? }
    } else {
        Kind::One(number(first)?)
    };
    Ok(Property { name: word("the property's name")?, kind })
}

pub(super) fn error(line: usize, found: impl Into<String>, expected: &'static str) -> MeshFileError {
    syntax(MeshFormat::Ply, Place::Line(line), found, expected)
}
