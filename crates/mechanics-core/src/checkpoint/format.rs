//! A checkpoint as bytes.

use super::{Checkpoint, CheckpointError, Element, FORMAT_VERSION, Kind, LONGEST_NAME, Section};
use crate::checksum::{crc64, update};
use std::collections::BTreeMap;
use std::convert::Infallible;

const MAGIC: [u8; 8] = *b"MECHCKP\n";
const HEADER_LENGTH: usize = 32;
const SECTION_HEAD_LENGTH: usize = 16;
const CHECKSUM_LENGTH: usize = 8;

impl Checkpoint {
    /// The content of the file. Equal checkpoints give equal bytes, whatever the order of the `put`s.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(self.file_length());
        let Ok(()) = self.visit_bytes::<Infallible>(|piece| {
            bytes.extend_from_slice(piece);
            Ok(())
        });
        bytes
    }

    /// Hands the content of the file to `visit`, piece by piece, without a second copy of the arrays.
    pub(super) fn visit_bytes<E>(&self, mut visit: impl FnMut(&[u8]) -> Result<(), E>) -> Result<(), E> {
        visit(&self.header())?;
        for (name, section) in &self.sections {
            visit(&section_head(name, section))?;
            visit(name.as_bytes())?;
            visit(&section.bytes)?;
            let register = update(update(!0, name.as_bytes()), &section.bytes);
            visit(&(!register).to_le_bytes())?;
        }
        Ok(())
    }

    fn file_length(&self) -> usize {
        HEADER_LENGTH
            + self.sections.iter().map(|(name, section)| section_length(name, section)).sum::<usize>()
    }

    fn header(&self) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        FORMAT_VERSION.append_to(&mut bytes);
        // More than 2³² sections would need more memory for their names than any machine has.
        (self.sections.len() as u32).append_to(&mut bytes);
        (self.file_length() as u64).append_to(&mut bytes);
        crc64(&bytes).append_to(&mut bytes);
        bytes
    }

    /// Reads the content of a file.
    ///
    /// # Errors
    /// Any variant of [`CheckpointError`] about the file's content. Nothing is returned of a damaged file.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, CheckpointError> {
        let section_count = read_header(bytes)?;
        let mut cursor = Cursor { bytes, position: HEADER_LENGTH };
        let mut sections = BTreeMap::new();
        for _ in 0..section_count {
            let offset = cursor.position as u64;
            let (name, section) = read_section(&mut cursor)?;
            let after_all = sections.last_key_value().is_none_or(|(last, _)| *last < name);
            if !after_all {
                let reason = "names must be distinct and in the order of their bytes";
                return Err(CheckpointError::BadName { offset, reason });
            }
            sections.insert(name, section);
        }
        if cursor.position < bytes.len() {
            let (expected, actual) = (cursor.position as u64, bytes.len() as u64);
            return Err(CheckpointError::TrailingBytes { expected, actual });
        }
        Ok(Self { sections })
    }
}

fn section_length(name: &str, section: &Section) -> usize {
    SECTION_HEAD_LENGTH + CHECKSUM_LENGTH + name.len() + section.bytes.len() + CHECKSUM_LENGTH
}

fn section_head(name: &str, section: &Section) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(SECTION_HEAD_LENGTH + CHECKSUM_LENGTH);
    section.kind.code().append_to(&mut bytes);
    (name.len() as u32).append_to(&mut bytes);
    (section.count as u64).append_to(&mut bytes);
    crc64(&bytes).append_to(&mut bytes);
    bytes
}

/// Checks the header and returns the number of sections.
///
/// Another version may have another header, so the version is judged before anything that follows it.
fn read_header(bytes: &[u8]) -> Result<u32, CheckpointError> {
    if !bytes.iter().zip(&MAGIC).all(|(found, expected)| found == expected) {
        return Err(CheckpointError::BadMagic);
    }
    let mut cursor = Cursor { bytes, position: 0 };
    cursor.bytes(MAGIC.len() as u64)?;
    let found: u32 = cursor.number()?;
    if found != FORMAT_VERSION {
        return Err(CheckpointError::UnsupportedVersion { found, supported: FORMAT_VERSION });
    }
    let section_count: u32 = cursor.number()?;
    let length: u64 = cursor.number()?;
    cursor.check_since(0)?;
    let actual = bytes.len() as u64;
    match actual.cmp(&length) {
        std::cmp::Ordering::Less => Err(CheckpointError::Truncated { expected: length, actual }),
        std::cmp::Ordering::Greater => Err(CheckpointError::TrailingBytes { expected: length, actual }),
        std::cmp::Ordering::Equal => Ok(section_count),
    }
}

/// Reads one section. Even lengths whose checksum is right are held against the bytes that are there.
fn read_section(cursor: &mut Cursor<'_>) -> Result<(String, Section), CheckpointError> {
    let head = cursor.position;
    let offset = head as u64;
    let code: u32 = cursor.number()?;
    let name_length: u32 = cursor.number()?;
    let count: u64 = cursor.number()?;
    cursor.check_since(head)?;
    let kind = Kind::from_code(code).ok_or(CheckpointError::UnknownKind { offset, code })?;
    if name_length == 0 || name_length as usize > LONGEST_NAME {
        return Err(CheckpointError::BadName { offset, reason: "it must have 1 to 255 bytes" });
    }
    let content = cursor.position;
    let name = cursor.bytes(u64::from(name_length))?;
    let data = cursor.bytes(count.saturating_mul(kind.element_size() as u64))?;
    cursor.check_since(content)?;
    let name = std::str::from_utf8(name)
        .map_err(|_| CheckpointError::BadName { offset, reason: "it is not UTF-8" })?
        .to_owned();
    let section = Section { kind, count: data.len() / kind.element_size(), bytes: data.to_vec() };
    Ok((name, section))
}

/// A place in the bytes of a file.
struct Cursor<'a> {
    bytes: &'a [u8],
    position: usize,
}

impl<'a> Cursor<'a> {
    /// The next `length` bytes.
    fn bytes(&mut self, length: u64) -> Result<&'a [u8], CheckpointError> {
        let rest = &self.bytes[self.position..];
        match usize::try_from(length).ok().and_then(|length| rest.get(..length)) {
            Some(taken) => {
                self.position += taken.len();
                Ok(taken)
            }
            None => Err(CheckpointError::Truncated {
                expected: (self.position as u64).saturating_add(length),
                actual: self.bytes.len() as u64,
            }),
        }
    }

    fn number<T: Element>(&mut self) -> Result<T, CheckpointError> {
        self.bytes(T::KIND.element_size() as u64).map(T::from_bytes)
    }

    /// Reads the checksum that stands here and holds it against the bytes since `start`.
    fn check_since(&mut self, start: usize) -> Result<(), CheckpointError> {
        let end = self.position;
        let computed = crc64(&self.bytes[start..end]);
        let stored: u64 = self.number()?;
        if stored == computed {
            Ok(())
        } else {
            Err(CheckpointError::ChecksumMismatch { start: start as u64, end: end as u64, stored, computed })
        }
    }
}
