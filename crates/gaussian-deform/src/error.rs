//! Why a scene cannot be used.

use std::fmt;

/// A property of a Gaussian, as named in errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Property {
    /// The mean.
    Mean,
    /// The half-axes, or the scales and the rotation that they are made of.
    Axes,
    /// The opacity.
    Opacity,
    /// Coefficients of the harmonics.
    Harmonics,
}

impl fmt::Display for Property {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Mean => "mean",
            Self::Axes => "axes",
            Self::Opacity => "opacity",
            Self::Harmonics => "harmonics",
        })
    }
}

/// Why a scene, a selection or a motion of it cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SplatError {
    /// A number of a Gaussian is NaN, infinite or out of its range.
    #[error("Gaussian {splat} has a bad {property}: {value}")]
    BadValue {
        /// The Gaussian.
        splat: usize,
        /// Which of its properties.
        property: Property,
        /// The number.
        value: f64,
    },
    /// A deformation gradient or position of a sample is NaN, infinite, or too large to be computed with.
    #[error(
        "sample {sample} of the motion has the number {value}; numbers beyond ±{most:e} and NaN cannot be used"
    )]
    BadSample {
        /// The sample.
        sample: usize,
        /// The number.
        value: f64,
        /// The largest number that can be computed with.
        most: f64,
    },
    /// There are not as many samples as Gaussians that they move.
    #[error("{samples} samples for {matter} moving Gaussians")]
    SampleCount {
        /// Samples given.
        samples: usize,
        /// Gaussians that are moved.
        matter: usize,
    },
    /// A list of Gaussians is not strictly ascending.
    #[error(
        "entry {entry} of the list of Gaussians is {splat}: entries must be strictly ascending and below {count}"
    )]
    BadSelection {
        /// Which entry of the list.
        entry: usize,
        /// What it is.
        splat: u32,
        /// How many Gaussians the scene has.
        count: usize,
    },
    /// No mean is in the region.
    #[error("none of {count} Gaussians is in the region; their means are between {low:.3?} and {high:.3?}")]
    RegionOutside {
        /// How many Gaussians the scene has.
        count: usize,
        /// The least coordinates of their means \[m\].
        low: [f64; 3],
        /// The largest coordinates of their means \[m\].
        high: [f64; 3],
    },
    /// Gaussians are in the region, but all are too faint.
    #[error(
        "none of the {count} Gaussians in the region has an opacity of {opacity} or more (the largest is {most})"
    )]
    EmptySelection {
        /// How many Gaussians are in the region.
        count: usize,
        /// The least opacity asked for.
        opacity: f64,
        /// The largest opacity in the region.
        most: f64,
    },
    /// Not a rotation with a positive scale.
    #[error("not a similarity: scale {scale}, |QᵀQ − I| = {off:e}, det Q = {determinant}")]
    BadSimilarity {
        /// s.
        scale: f64,
        /// |QᵀQ − I|.
        off: f64,
        /// det Q.
        determinant: f64,
    },
    /// There is nothing to bind to.
    #[error("there are no samples, or no tetrahedra, to bind Gaussians to")]
    NoSamples,
    /// A tetrahedron has no volume at rest.
    #[error("tetrahedron {tet} has no volume at rest")]
    FlatTet {
        /// The tetrahedron.
        tet: usize,
    },
    /// A mean that is to be bound, or a position to be filled around, is not finite.
    #[error("point {point} has the coordinate {value}")]
    BadPoint {
        /// The point.
        point: usize,
        /// The coordinate.
        value: f64,
    },
    /// A grid without cells, with too many, or of cells without size.
    #[error(
        "a grid of {counts:?} cells of length {cell}: at least one cell, at most {most}, of a positive length"
    )]
    BadGrid {
        /// The length of a cell.
        cell: f64,
        /// Cells along each axis.
        counts: [usize; 3],
        /// The most cells.
        most: usize,
    },
}
