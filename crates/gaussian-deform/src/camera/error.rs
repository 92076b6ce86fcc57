//! Why there is no camera.

use std::fmt;

/// A property of a camera, as named in errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CameraProperty {
    /// Pixels in a row.
    Width,
    /// Rows of pixels.
    Height,
    /// The focal lengths.
    FocalLength,
    /// Where the optical axis meets the picture.
    PrincipalPoint,
    /// The rotation.
    Rotation,
    /// The place of the eye.
    Position,
    /// The angle of view.
    FieldOfView,
    /// The point that is looked at.
    Target,
    /// The direction that is up in the picture.
    Up,
    /// The distance between the eye and the target.
    Distance,
    /// The angles of an orbit.
    Angle,
}

impl fmt::Display for CameraProperty {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Width => "width",
            Self::Height => "height",
            Self::FocalLength => "focal length",
            Self::PrincipalPoint => "principal point",
            Self::Rotation => "rotation",
            Self::Position => "position",
            Self::FieldOfView => "field of view",
            Self::Target => "target",
            Self::Up => "up direction",
            Self::Distance => "distance",
            Self::Angle => "angle",
        })
    }
}

/// Why a camera cannot be made, or cannot be where it is.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CameraError {
    /// A number is not finite or out of its range.
    #[error("the camera's {property} is {value}, which is not {wanted}")]
    BadValue {
        /// Which property.
        property: CameraProperty,
        /// Its value.
        value: f64,
        /// What it should be.
        wanted: &'static str,
    },
    /// A matrix that does not rotate.
    #[error("the camera's rotation is off by {deviation:.1e} from an orthonormal right-handed matrix")]
    NotARotation {
        /// The largest entry of |R Rᵀ − I|, or |det R − 1|.
        deviation: f64,
    },
    /// Eye and target are the same point, or up points along the line of sight.
    #[error("the camera's {property} leaves its direction open: eye, target and up must span a plane")]
    NoDirection {
        /// Which property.
        property: CameraProperty,
    },
    /// A file that is not JSON.
    #[error("line {line}, column {column}: this is not JSON: {reason}")]
    Syntax {
        /// The line, from 1.
        line: usize,
        /// The column, from 1.
        column: usize,
        /// What the parser says.
        reason: String,
    },
    /// A file whose outermost value is not a list.
    #[error("a cameras.json holds a list of cameras at its top")]
    NotAList,
    /// A property of a camera in a file is missing, or of another type than it should be.
    #[error("camera {index} has no `{key}` that is {wanted}")]
    BadEntry {
        /// The camera, from 0.
        index: usize,
        /// The property's name in the file.
        key: &'static str,
        /// What it should be.
        wanted: &'static str,
    },
    /// What is wrong with one camera of a file.
    #[error("camera {index}: {error}")]
    InFile {
        /// The camera, from 0.
        index: usize,
        /// What is wrong.
        error: Box<CameraError>,
    },
    /// The eye is within a Gaussian.
    #[error("the eye is inside Gaussian {splat}, at {deviations:.2} standard deviations from its mean")]
    InsideSplat {
        /// The Gaussian.
        splat: usize,
        /// √((e − μ)ᵀ A⁻¹ (e − μ)).
        deviations: f64,
    },
}
