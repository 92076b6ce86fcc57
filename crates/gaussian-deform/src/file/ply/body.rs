//! The rows.

use super::PlyEncoding;
use super::header::{Column, Header, Kind};
use crate::file::row::{BadNumber, Row, USABLE, read_rows, scales_of_logarithms, usable};
use crate::file::{FileError, SplatFormat};
use crate::splats::Splats;

const FORMAT: SplatFormat = SplatFormat::Ply;

pub(super) fn read(header: &Header, bytes: &[u8]) -> Result<Splats, FileError> {
    match header.encoding {
        PlyEncoding::Ascii => read_text(header, &bytes[header.body..]),
        _ => read_binary(header, &bytes[header.body..]),
    }
}

/// One Gaussian from the numbers of its columns, in the order of [`Header::NAMES`]; the other coefficients go where they belong.
#[inline(always)]
fn row(
    number: impl Fn(usize) -> Result<f32, BadNumber>,
    coefficients: usize,
    harmonics: &mut [f32],
) -> Result<Row, BadNumber> {
    let number = |k: usize| number(k).and_then(|x| usable(x, || Header::name(k)));
    for (c, channel) in harmonics.chunks_exact_mut(coefficients).enumerate() {
        channel[0] = number(11 + c)?;
        let first = Header::NAMES.len() + c * (coefficients - 1);
        for (k, coefficient) in channel[1..].iter_mut().enumerate() {
            *coefficient = number(first + k)?;
        }
    }
    Ok(Row {
        mean: [number(0)?, number(1)?, number(2)?],
        scales: scales_of_logarithms([number(3)?, number(4)?, number(5)?])?,
        quaternion: [number(6)?, number(7)?, number(8)?, number(9)?],
        opacity: 1.0 / (1.0 + (-number(10)?).exp()),
    })
}

fn read_binary(header: &Header, body: &[u8]) -> Result<Splats, FileError> {
    let needed = header.skipped + u128::from(header.count) * header.size as u128;
    if (body.len() as u128) < needed {
        return Err(truncated(header, needed, body));
    }
    // Both fit: they are not above the length of the body.
    let (skipped, count) = (header.skipped as usize, header.count as usize);
    let rows = &body[skipped..];
    let coefficients = header.degree.coefficients();
    let little = header.encoding == PlyEncoding::BinaryLittleEndian;
    let plain = little && header.columns.iter().all(|c| c.kind == Kind::F32);
    read_rows(FORMAT, header.degree, count, |i, harmonics| {
        let bytes = &rows[i * header.size..(i + 1) * header.size];
        if plain {
            return row(|k| Ok(little_float(bytes, header.columns[k])), coefficients, harmonics);
        }
        row(|k| Ok(binary_number(bytes, header.columns[k], header.encoding)), coefficients, harmonics)
    })
}

#[inline(always)]
fn little_float(row: &[u8], column: Column) -> f32 {
    match row[column.offset..].first_chunk::<4>() {
        Some(bytes) => f32::from_le_bytes(*bytes),
        None => f32::NAN,
    }
}

fn binary_number(row: &[u8], column: Column, encoding: PlyEncoding) -> f32 {
    let mut bytes = [0_u8; 8];
    let size = column.kind.size();
    bytes[..size].copy_from_slice(&row[column.offset..column.offset + size]);
    if encoding == PlyEncoding::BinaryBigEndian {
        bytes[..size].reverse();
    }
    let [a, b, c, d, ..] = bytes;
    match column.kind {
        Kind::I8 => f32::from(a as i8),
        Kind::U8 => f32::from(a),
        Kind::I16 => f32::from(i16::from_le_bytes([a, b])),
        Kind::U16 => f32::from(u16::from_le_bytes([a, b])),
        Kind::I32 => i32::from_le_bytes([a, b, c, d]) as f32,
        Kind::U32 => u32::from_le_bytes([a, b, c, d]) as f32,
        Kind::F32 => f32::from_le_bytes([a, b, c, d]),
        Kind::F64 => f64::from_le_bytes(bytes) as f32,
    }
}

fn read_text(header: &Header, body: &[u8]) -> Result<Splats, FileError> {
    // A token and the space after it; the last one may do without.
    let needed = (header.skipped + u128::from(header.count) * header.properties as u128) * 2;
    if (body.len() as u128) + 1 < needed {
        return Err(truncated(header, needed.saturating_sub(1), body));
    }
    let count = header.count as usize;
    let mut tokens = body.split(u8::is_ascii_whitespace).filter(|token| !token.is_empty());
    for _ in 0..header.skipped {
        tokens.next();
    }
    let needed_tokens = count * header.properties;
    let tokens: Vec<&[u8]> = tokens.take(needed_tokens).collect();
    if tokens.len() < needed_tokens {
        return Err(FileError::BadValue {
            format: FORMAT,
            splat: tokens.len() / header.properties,
            property: format!("property {}", tokens.len() % header.properties),
            found: "the end of the file".to_string(),
            expected: USABLE,
        });
    }
    let coefficients = header.degree.coefficients();
    read_rows(FORMAT, header.degree, count, |i, harmonics| {
        let row_tokens = &tokens[i * header.properties..(i + 1) * header.properties];
        row(|k| text_number(row_tokens[header.columns[k].index], k), coefficients, harmonics)
    })
}

fn text_number(token: &[u8], column: usize) -> Result<f32, BadNumber> {
    let number = std::str::from_utf8(token).ok().and_then(|text| text.parse().ok());
    number.ok_or_else(|| BadNumber {
        property: Header::name(column),
        found: String::from_utf8_lossy(&token[..token.len().min(60)]).into_owned(),
        expected: USABLE,
    })
}

fn truncated(header: &Header, needed: u128, body: &[u8]) -> FileError {
    FileError::Truncated { format: FORMAT, claimed: header.count, needed, found: body.len() }
}
