//! What makes no element.

use mechanics_core::stencil::StencilError;
use mechanics_core::tensor::Vec3;

/// Why data makes no element, mass or load.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ElementError {
    /// A rest shape is flat or inside out.
    #[error(
        "element {element} has the rest volume {volume:e} m³; it must be positive, and more than rounding: swap two corners of an inverted \
         element, remove a flat one"
    )]
    RestVolume {
        /// The element.
        element: usize,
        /// Its signed volume at rest \[m³\].
        volume: f64,
    },
    /// A curved rest shape folds over.
    #[error(
        "element {element} folds over at rest: the determinant of its rest shape is {determinant:e} m³ at one of its \
         quadrature points; move its mid-edge points closer to the middle of their edges"
    )]
    RestFold {
        /// The element.
        element: usize,
        /// det ∂X/∂ξ there \[m³\].
        determinant: f64,
    },
    /// A vertex belongs to no element, so nothing gives it mass or stiffness.
    #[error("vertex {point} belongs to no element, so nothing holds it and nothing gives it mass; remove it")]
    Unreferenced {
        /// The vertex.
        point: u32,
    },
    /// An element names a vertex that does not exist.
    #[error("element {element} names vertex {point}, but there are only {points}")]
    PointOutOfRange {
        /// The element.
        element: usize,
        /// The vertex.
        point: u32,
        /// How many there are.
        points: usize,
    },
    /// A rest position is infinite or NaN.
    #[error("vertex {point} rests at {position:?}, which is not finite")]
    NonFinite {
        /// The vertex.
        point: u32,
        /// Where it rests \[m\].
        position: [f64; 3],
    },
    /// A number is outside its range.
    #[error("the {quantity} of {owner} {index} is {value}; it must be {expected}")]
    OutOfRange {
        /// Which number.
        quantity: &'static str,
        /// Whose it is: an element, a vertex.
        owner: &'static str,
        /// Which of them.
        index: usize,
        /// The number.
        value: f64,
        /// What it should be.
        expected: &'static str,
    },
    /// A surface that must be closed is not, or has three triangles on an edge, or neighbours that disagree on outside.
    #[error(
        "the edge from vertex {from} to vertex {to} is crossed {forward} times forwards and {backward} times backwards; \
         on a closed surface with outward triangles it is once each"
    )]
    NotClosed {
        /// Where the edge starts.
        from: u32,
        /// Where it ends.
        to: u32,
        /// Triangles that run along it forwards.
        forward: usize,
        /// Triangles that run along it backwards.
        backward: usize,
    },
    /// The list of elements makes no term.
    #[error(transparent)]
    Stencil(#[from] StencilError),
}

/// Checks that every element names vertices that exist and rest at finite places.
pub(super) fn check_points<const N: usize>(
    points: &[Vec3],
    elements: &[[u32; N]],
) -> Result<(), ElementError> {
    for (element, corners) in elements.iter().enumerate() {
        for &point in corners {
            let Some(position) = points.get(point as usize) else {
                return Err(ElementError::PointOutOfRange { element, point, points: points.len() });
            };
            if !position.iter().all(|c| c.is_finite()) {
                return Err(ElementError::NonFinite { point, position: (*position).into() });
            }
        }
    }
    Ok(())
}

/// A determinant over the product of its columns' lengths, below which it is what rounding makes of a flat element.
const FLAT: f64 = 16.0 * f64::EPSILON;

/// Checks that a tetrahedron is neither inside out nor flat to rounding; answers its volume \[m³\].
pub(super) fn check_volume(element: usize, corners: &[Vec3; 4]) -> Result<f64, ElementError> {
    let [a, b, c] = [1, 2, 3].map(|corner| corners[corner] - corners[0]);
    let determinant = a.dot(&b.cross(&c));
    let sound = determinant > FLAT * a.norm() * b.norm() * c.norm() && determinant.is_finite();
    let volume = determinant / 6.0;
    if sound { Ok(volume) } else { Err(ElementError::RestVolume { element, volume }) }
}

/// Checks that a number is finite and positive.
pub(super) fn check_positive(
    quantity: &'static str,
    owner: &'static str,
    index: usize,
    value: f64,
) -> Result<(), ElementError> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(ElementError::OutOfRange { quantity, owner, index, value, expected: "positive and finite" })
}

/// Checks that a number is finite and not negative.
pub(super) fn check_not_negative(
    quantity: &'static str,
    owner: &'static str,
    index: usize,
    value: f64,
) -> Result<(), ElementError> {
    if value.is_finite() && value >= 0.0 {
        return Ok(());
    }
    Err(ElementError::OutOfRange { quantity, owner, index, value, expected: "finite and not negative" })
}
