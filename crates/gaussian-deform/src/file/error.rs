use std::fmt;
use std::path::PathBuf;

/// A format of Gaussian scenes, for messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SplatFormat {
    /// Polygon file format with the properties of trained scenes.
    Ply,
    /// 32 bytes a Gaussian.
    Splat,
    /// Quantised and compressed.
    Spz,
}

impl fmt::Display for SplatFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Ply => "PLY",
            Self::Splat => "SPLAT",
            Self::Spz => "SPZ",
        })
    }
}

/// Why a scene's file could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// What is wrong in a file.
    #[error("{path}: {source}", path = .path.display())]
    InFile {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: Box<FileError>,
    },
    /// The operating system refused.
    #[error("cannot {action} {path}: {source}", path = .path.display())]
    System {
        /// What was tried: "read", "write", …
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// A writer that was handed in failed.
    #[error("cannot write the scene: {0}")]
    Sink(#[from] std::io::Error),
    /// The name of a file does not tell its format.
    #[error("{path}: scenes are read from .ply, .splat and .spz", path = .path.display())]
    UnknownEnding {
        /// The file.
        path: PathBuf,
    },
    /// A header is not what the format asks for.
    #[error("{format}, header line {line}: found {found}, expected {expected}")]
    Header {
        /// The format.
        format: SplatFormat,
        /// The line, counted from 1; 0 for a binary header.
        line: usize,
        /// What stands there.
        found: String,
        /// What should stand there.
        expected: &'static str,
    },
    /// A property that every Gaussian has is not in the file.
    #[error("PLY: element vertex has no property {property}; is this a scene of Gaussians?")]
    MissingProperty {
        /// The property.
        property: String,
    },
    /// A name is used twice.
    #[error("PLY: {name} is declared twice")]
    Repeated {
        /// The element or property.
        name: String,
    },
    /// Harmonics of a degree that is not supported, or of none.
    #[error("{format}: {found}; supported are degrees 0 to 3 (0, 9, 24 or 45 coefficients beyond the first)")]
    Degree {
        /// The format.
        format: SplatFormat,
        /// What the file has.
        found: String,
    },
    /// Valid, but not supported.
    #[error("{format}: {found} is not supported; {supported}")]
    Unsupported {
        /// The format.
        format: SplatFormat,
        /// What the file has.
        found: String,
        /// What is supported.
        supported: &'static str,
    },
    /// The file ends early.
    #[error("{format}: {claimed} Gaussians are announced, which need {needed} bytes; {found} are there")]
    Truncated {
        /// The format.
        format: SplatFormat,
        /// Gaussians announced.
        claimed: u64,
        /// Bytes they need at least.
        needed: u128,
        /// Bytes that are there.
        found: usize,
    },
    /// The compressed stream is damaged.
    #[error("{format}: the compressed data are damaged: {source}")]
    Damaged {
        /// The format.
        format: SplatFormat,
        /// What the decompressor says.
        source: std::io::Error,
    },
    /// A number of a Gaussian cannot be used.
    #[error("{format}, element vertex {splat}: {property} is {found}; expected {expected}")]
    BadValue {
        /// The format.
        format: SplatFormat,
        /// The Gaussian, counted from 0.
        splat: usize,
        /// The property.
        property: String,
        /// What it is.
        found: String,
        /// What it should be.
        expected: &'static str,
    },
}
