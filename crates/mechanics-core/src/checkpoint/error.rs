//! What can be wrong with a checkpoint.

use super::Kind;
use std::path::PathBuf;

/// Why a checkpoint cannot be read, written, or used. Offsets count bytes from the start of the file.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    /// The operating system refused.
    #[error("cannot {action} {}: {source}", path.display())]
    Io {
        /// What was attempted, as a verb.
        action: &'static str,
        /// The file or directory.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The file does not begin as a checkpoint does.
    #[error("this is not a checkpoint: it does not begin with \"MECHCKP\\n\"")]
    BadMagic,
    /// The file was written by another version of this format.
    #[error("the checkpoint has format version {found}, this program reads version {supported}")]
    UnsupportedVersion {
        /// The file's version.
        found: u32,
        /// The version this program reads.
        supported: u32,
    },
    /// The file ends too early.
    #[error(
        "the checkpoint ends at byte {actual}, but at least {expected} bytes are needed: it was cut short"
    )]
    Truncated {
        /// How many bytes there must be at least.
        expected: u64,
        /// How many there are.
        actual: u64,
    },
    /// The file goes on after its last section.
    #[error("the checkpoint should end at byte {expected}, but has {actual} bytes")]
    TrailingBytes {
        /// Where the content ends.
        expected: u64,
        /// How many bytes there are.
        actual: u64,
    },
    /// The content was altered after it was written.
    #[error(
        "the bytes {start}..{end} of the checkpoint have checksum {computed:016x}, not {stored:016x}: the file is \
         damaged"
    )]
    ChecksumMismatch {
        /// The first byte of the damaged part.
        start: u64,
        /// One past its last byte, where the checksum is stored.
        end: u64,
        /// The checksum in the file.
        stored: u64,
        /// The checksum of the bytes that are there.
        computed: u64,
    },
    /// A section's type is not one that this version knows.
    #[error("the section at byte {offset} has the unknown type code {code}")]
    UnknownKind {
        /// Where the section starts.
        offset: u64,
        /// Its code.
        code: u32,
    },
    /// A section's name is empty, too long, not UTF-8, or not after the name before it.
    #[error("the section at byte {offset} has an invalid name: {reason}")]
    BadName {
        /// Where the section starts.
        offset: u64,
        /// What is wrong with the name.
        reason: &'static str,
    },
    /// No section has this name.
    #[error("the checkpoint has no section {name:?}: it was written by another scheme, or taken already")]
    Missing {
        /// The name asked for.
        name: String,
    },
    /// The section holds something else.
    #[error("section {name:?} of the checkpoint holds {stored}, not {wanted}")]
    WrongKind {
        /// The section.
        name: String,
        /// What it holds.
        stored: Kind,
        /// What was asked for.
        wanted: Kind,
    },
    /// The section has another number of elements.
    #[error("section {name:?} of the checkpoint has {stored} elements, not {wanted}")]
    WrongLength {
        /// The section.
        name: String,
        /// How many elements it has.
        stored: usize,
        /// How many are needed.
        wanted: usize,
    },
    /// The section was read as text and is not UTF-8.
    #[error("section {name:?} of the checkpoint is not text: byte {position} of it is not valid UTF-8")]
    NotText {
        /// The section.
        name: String,
        /// The first byte that is not text.
        position: usize,
    },
    /// The section was read as text and says something else.
    #[error("section {name:?} of the checkpoint says {stored:?}, but this scheme is {wanted:?}")]
    WrongText {
        /// The section.
        name: String,
        /// What it says.
        stored: String,
        /// What it should say.
        wanted: String,
    },
    /// Sections that nobody asked for.
    #[error("{count} sections of the checkpoint were not used, first {name:?}: it belongs to another scheme")]
    LeftOver {
        /// The first of them.
        name: String,
        /// How many there are.
        count: usize,
    },
}
