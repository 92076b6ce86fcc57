//! Why there is no picture.

use crate::error::SplatError;

/// Why a picture cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RasterError {
    /// A number of a Gaussian is NaN, infinite or out of its range.
    #[error(transparent)]
    Splat(#[from] SplatError),
    /// A Gaussian is finite, but what is seen of it is not.
    #[error("Gaussian {splat} is so large or so far to the side that its projection overflows")]
    Overflow {
        /// The Gaussian.
        splat: usize,
    },
    /// Coefficients or an orientation that give no colour.
    #[error("the colour of Gaussian {splat} is not finite: look at its harmonics and its orientation")]
    BadColour {
        /// The Gaussian.
        splat: usize,
    },
    /// A background that is not a colour.
    #[error("channel {channel} of the background is {value}")]
    BadBackground {
        /// 0, 1, 2: red, green, blue.
        channel: usize,
        /// The value.
        value: f64,
    },
}
