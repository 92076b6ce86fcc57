//! The container of version 4: one stream of Zstandard for each property.

use super::{FORMAT, Header, MOST_COMPRESSION, check_extensions, header_error};
use crate::file::FileError;
use ruzstd::decoding::{FrameDecoder, StreamingDecoder};
use std::io::{self, Read};

/// Bytes of the plain header.
const HEADER: usize = 32;
/// Bytes of a row of the table: the length with and without compression.
const ROW: usize = 16;
/// Any decoder is to have as much memory as this; streams that are longer may ask for their own length.
const WINDOW: u64 = 8 << 20;

/// The columns of all properties, one after the other.
pub(super) fn decompressed(header: &Header, bytes: &[u8]) -> Result<Vec<u8>, FileError> {
    let Some(start) = bytes.first_chunk::<HEADER>() else {
        return Err(header_error(format!("{} bytes", bytes.len()), "a header of 32 bytes"));
    };
    // Nothing is taken for what a header claims: so many bytes cannot come of so few.
    if header.needed() > bytes.len() as u128 * u128::from(MOST_COMPRESSION) {
        return Err(header.truncated(bytes.len()));
    }
    let lengths: Vec<usize> =
        header.widths().map(|w| w * header.count).into_iter().filter(|&n| n > 0).collect();
    if usize::from(start[15]) != lengths.len() {
        let found = format!("{} streams", start[15]);
        return Err(header_error(found, "one for each property: five, and a sixth from degree 1 on"));
    }
    let table = u32::from_le_bytes([start[16], start[17], start[18], start[19]]) as usize;
    let (Some(extensions), Some(rows)) =
        (bytes.get(HEADER..table), bytes.get(table..table.saturating_add(ROW * lengths.len())))
    else {
        return Err(header_error(
            format!("a table at byte {table}"),
            "one after the header and within the file",
        ));
    };
    if header.has_extensions {
        check_extensions(extensions)?;
    }
    let mut rest = &bytes[table + rows.len()..];
    let mut plain = Vec::new();
    for (row, length) in rows.chunks_exact(ROW).zip(lengths) {
        let number = |k: usize| row[k..].first_chunk::<8>().map_or(0, |bytes| u64::from_le_bytes(*bytes));
        if number(8) != length as u64 {
            let found = format!("a stream of {} bytes", number(8));
            return Err(header_error(found, "as many as the property of all Gaussians takes"));
        }
        let stream = usize::try_from(number(0)).ok().and_then(|n| rest.split_at_checked(n));
        let (stream, others) = stream.ok_or_else(|| header.truncated(bytes.len()))?;
        rest = others;
        let before = plain.len();
        add_stream(stream, length, &mut plain)
            .map_err(|source| FileError::Damaged { format: FORMAT, source })?;
        if plain.len() != before + length {
            return Err(header.truncated(plain.len()));
        }
    }
    Ok(plain)
}

/// What a stream stands for, up to one byte more than `length`.
fn add_stream(stream: &[u8], length: usize, plain: &mut Vec<u8>) -> io::Result<()> {
    let mut decoder = FrameDecoder::new();
    decoder.set_max_window_size(WINDOW.max(length as u64));
    let decoder = StreamingDecoder::new_with_decoder(stream, decoder).map_err(io::Error::other)?;
    decoder.take(length as u64 + 1).read_to_end(plain)?;
    Ok(())
}
