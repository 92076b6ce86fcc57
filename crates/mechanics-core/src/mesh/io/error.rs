use crate::mesh::MeshError;
use std::fmt;
use std::path::PathBuf;

/// A mesh file format, for messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// Wavefront OBJ.
    Obj,
    /// Stereolithography.
    Stl,
    /// Polygon file format.
    Ply,
    /// Gmsh MSH.
    Msh,
    /// VTK's XML formats.
    Vtk,
}

impl fmt::Display for MeshFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Obj => "OBJ",
            Self::Stl => "STL",
            Self::Ply => "PLY",
            Self::Msh => "MSH",
            Self::Vtk => "VTK",
        })
    }
}

/// Where in a file something is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// A line of text, counted from 1.
    Line(usize),
    /// A byte, counted from 0.
    Byte(usize),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(n) => write!(f, "line {n}"),
            Self::Byte(n) => write!(f, "byte {n}"),
        }
    }
}

/// Why a mesh file could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum MeshFileError {
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
    #[error("cannot write the mesh: {0}")]
    Sink(#[from] std::io::Error),
    /// The content is not what the format asks for.
    #[error("{format}, {place}: found {found}, expected {expected}")]
    Syntax {
        /// The format.
        format: MeshFormat,
        /// Where.
        place: Place,
        /// What stands there.
        found: String,
        /// What should stand there.
        expected: &'static str,
    },
    /// The content is valid but says something this reader does not handle.
    #[error("{format}, {place}: {found} is not supported; {supported}")]
    Unsupported {
        /// The format.
        format: MeshFormat,
        /// Where.
        place: Place,
        /// What stands there.
        found: String,
        /// What is supported.
        supported: &'static str,
    },
    /// The numbers could be read, but they do not make a mesh.
    #[error("{format}: {error}")]
    Mesh {
        /// The format.
        format: MeshFormat,
        /// What is wrong with the mesh.
        error: MeshError,
    },
    /// The mesh has parts that the format cannot hold.
    #[error("{format} cannot hold {what}")]
    NotRepresentable {
        /// The format.
        format: MeshFormat,
        /// Which parts.
        what: String,
    },
}

impl MeshFileError {
    pub(super) fn mesh(format: MeshFormat) -> impl Fn(MeshError) -> Self {
        move |error| Self::Mesh { format, error }
    }

    pub(super) fn not_representable(format: MeshFormat, what: impl Into<String>) -> Self {
        Self::NotRepresentable { format, what: what.into() }
    }
}
