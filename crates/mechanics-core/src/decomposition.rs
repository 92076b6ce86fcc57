//! Singular values, rotations and eigenvectors of 3×3 matrices over any real [`Scalar`](crate::scalar::Scalar):
//! `f64`, `f32` and their lanes.
//!
//! ```
//! use mechanics_core::decomposition::{polar, svd};
//! use mechanics_core::tensor::Mat3;
//!
//! // A mirror with stretch: the smallest singular value carries the sign of the determinant.
//! let f = Mat3::new(3.0, 0.0, 0.0, 0.0, -2.0, 0.0, 0.0, 0.0, 1.0);
//! assert_eq!(svd(&f).sigma, [3.0, 2.0, -1.0]);
//! assert!((polar(&f).rotation.determinant() - 1.0).abs() < 1e-15);
//! ```
//!
//! # Guarantees
//!
//! With ε the spacing at one (2.2e-16 for `f64`, 1.2e-7 for `f32`) every decomposition reconstructs its input to
//! 4e-15 (`f64`) and 1e-6 (`f32`) relative to its Frobenius norm, and its factors are orthogonal to the same
//! bound, for *all* matrices: singular, inverted, with repeated or widely ranging singular values. Singular values
//! and eigenvalues are therefore accurate to that fraction of the largest one. The input is scaled by a power of
//! two first, so its magnitude does not matter as long as the largest entry is a normal number and the sum of all
//! |entries| stays below half of the largest finite number.
//!
//! A matrix with an infinite or NaN entry gives NaN in every entry of every factor. Nothing here panics or hangs.
//! What one lane gives does not depend on what the other lanes hold.
//!
//! These are iterations on values: through jets they give the right values, but do not rely on their derivatives
//! (those do not exist at repeated singular values; laws use closed forms instead).

mod batch;
mod eigen;
mod jacobi;
mod polar;
mod svd;

pub use batch::{polar_into, svd_into, svd_with_sweeps_into};
pub use eigen::{SymmetricEigen, symmetric_eigen};
pub use polar::{Polar, polar};
pub use svd::{MOST_SWEEPS, Svd, svd, svd_with_sweeps};
