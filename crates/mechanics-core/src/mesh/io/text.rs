//! Reading text: tokens between white space, with line numbers for messages.

use super::error::{MeshFileError, MeshFormat, Place};
use std::str::FromStr;

/// One line of a text, without its end.
#[derive(Clone, Copy)]
pub(super) struct Line<'a> {
    pub(super) number: usize,
    pub(super) bytes: &'a [u8],
}

/// The lines of a text, ended by LF, CR LF or CR.
pub(super) fn lines(bytes: &[u8]) -> impl Iterator<Item = Line<'_>> {
    let mut cursor = TextCursor::new(MeshFormat::Obj, bytes, 0, 1);
    std::iter::from_fn(move || cursor.next_line())
}

/// Walks through text line by line or token by token.
pub(super) struct TextCursor<'a> {
    format: MeshFormat,
    bytes: &'a [u8],
    /// The offset of the next unread byte.
    pub(super) offset: usize,
    /// The number of the line it is in.
    pub(super) line: usize,
}

impl<'a> TextCursor<'a> {
    pub(super) fn new(format: MeshFormat, bytes: &'a [u8], offset: usize, line: usize) -> Self {
        Self { format, bytes, offset, line }
    }

    /// The rest of the current line; `None` at the end of the file.
    pub(super) fn next_line(&mut self) -> Option<Line<'a>> {
        let rest = self.bytes.get(self.offset..).filter(|rest| !rest.is_empty())?;
        let length = rest.iter().position(|&b| b == b'\n' || b == b'\r').unwrap_or(rest.len());
        let ending = match &rest[length..] {
            [b'\r', b'\n', ..] => 2,
            [] => 0,
            _ => 1,
        };
        let line = Line { number: self.line, bytes: &rest[..length] };
        self.offset += length + ending;
        self.line += 1;
        Some(line)
    }

    /// The next token, across line ends.
    pub(super) fn token(&mut self, expected: &'static str) -> Result<&'a [u8], MeshFileError> {
        let mut after_return = false;
        while let Some(&byte) = self.bytes.get(self.offset).filter(|b| b.is_ascii_whitespace()) {
            // CR LF is one line end.
            self.line += usize::from(byte == b'\r' || (byte == b'\n' && !after_return));
            after_return = byte == b'\r';
            self.offset += 1;
        }
        let rest = &self.bytes[self.offset.min(self.bytes.len())..];
        let length = rest.iter().position(|b| b.is_ascii_whitespace()).unwrap_or(rest.len());
        if length == 0 {
            return Err(self.error("the end of the file", expected));
        }
        self.offset += length;
        Ok(&rest[..length])
    }

    /// The next token as a number.
    pub(super) fn number<T: FromStr>(&mut self, expected: &'static str) -> Result<T, MeshFileError> {
        let token = self.token(expected)?;
        parse(token).ok_or_else(|| self.error(quoted(token), expected))
    }

    /// The next token as a finite number.
    pub(super) fn finite(&mut self) -> Result<f64, MeshFileError> {
        let token = self.token(FINITE)?;
        parse_finite(token).ok_or_else(|| self.error(quoted(token), FINITE))
    }

    pub(super) fn error(&self, found: impl Into<String>, expected: &'static str) -> MeshFileError {
        syntax(self.format, Place::Line(self.line), found, expected)
    }
}

pub(super) const FINITE: &str = "a finite number";

pub(super) fn syntax(
    format: MeshFormat,
    place: Place,
    found: impl Into<String>,
    expected: &'static str,
) -> MeshFileError {
    MeshFileError::Syntax { format, place, found: found.into(), expected }
}

/// The words of a line.
pub(super) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(|b| b.is_ascii_whitespace()).filter(|word| !word.is_empty())
}

pub(super) fn parse<T: FromStr>(token: &[u8]) -> Option<T> {
    std::str::from_utf8(token).ok()?.parse().ok()
}

pub(super) fn parse_finite(token: &[u8]) -> Option<f64> {
    parse(token).filter(|x: &f64| x.is_finite())
}

/// A piece of the file for a message: shortened, and with unprintable bytes escaped.
pub(super) fn quoted(token: &[u8]) -> String {
    const LONGEST: usize = 40;
    let shown = token[..token.len().min(LONGEST)].escape_ascii();
    let more = if token.len() > LONGEST { "…" } else { "" };
    format!("\"{shown}{more}\"")
}
