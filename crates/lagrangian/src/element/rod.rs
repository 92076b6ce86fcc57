//! Rods: curves that resist stretching, bending and, where asked for, twist.
//!
//! A rod is a polyline of free edges of a [`TriMesh`]. [`RodStretching`] is the energy of its edges, [`RodBending`] and
//! [`RodTwist`] those of its joints; they are straight-forward sums and can be used without each other (a chain has no bending).
//!
//! The rod is isotropic (one flexural rigidity for all directions) and straight when unloaded. Then its material frames
//! have no part in bending, and as long as no end is held against turning about the tangent, no twist builds up:
//! stretching and bending are complete without unknowns of their own. With held or driven ends [`RodTwist`] adds an angle per edge.
//! Not here: anisotropic sections and natural curvature.
//!
//! # Reference
//! M. Bergou, M. Wardetzky, S. Robinson, B. Audoly, E. Grinspun, *Discrete elastic rods*, ACM Trans. Graph. 27(3), 2008.

mod bending;
mod joints;
mod stretching;
mod transport;
mod twist;

pub use bending::RodBending;
pub use stretching::RodStretching;
pub use twist::{RodTwist, TwistSection};

use super::thin_error::{ThinError, positive};
use mechanics_core::mesh::TriMesh;

/// The stiffness of a rod's section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RodSection {
    /// Axial stiffness EA \[N\].
    pub axial: f64,
    /// Flexural rigidity EI [N m²].
    pub flexural: f64,
}

impl RodSection {
    /// A full circle: A = πr², I = πr⁴/4, from Young's modulus \[Pa\] and the radius \[m\].
    ///
    /// # Errors
    /// A parameter that is not positive.
    pub fn circular(young_modulus: f64, radius: f64) -> Result<Self, ThinError> {
        let young = positive("Young's modulus", young_modulus)?;
        let square = positive("the radius", radius)?.powi(2);
        let axial = young * std::f64::consts::PI * square;
        Ok(Self { axial, flexural: 0.25 * axial * square })
    }

    /// A rectangle `width` \[m\] × `height` \[m\], bent about the width: I = width height³/12. The rod bends equally in all
    /// directions nonetheless.
    ///
    /// # Errors
    /// A parameter that is not positive.
    pub fn rectangular(young_modulus: f64, width: f64, height: f64) -> Result<Self, ThinError> {
        let young = positive("Young's modulus", young_modulus)?;
        let (width, height) = (positive("the width", width)?, positive("the height", height)?);
        let axial = young * width * height;
        Ok(Self { axial, flexural: axial * height * height / 12.0 })
    }
}

/// The rest lengths of a mesh's free edges \[m\].
fn rest_lengths(mesh: &TriMesh) -> Result<Vec<f64>, ThinError> {
    let length = |(edge, points): (usize, &[u32; 2])| {
        let [a, b] = points.map(|point| mesh.points()[point as usize]);
        let length = (b - a).norm();
        let points = *points;
        if length > 0.0 && length.is_finite() {
            Ok(length)
        } else {
            Err(ThinError::RestLength { edge, points, length })
        }
    };
    mesh.free_edges().iter().enumerate().map(length).collect()
}
