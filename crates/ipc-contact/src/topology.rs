//! What the test for intersection cannot see: a body that has passed right through another. Exact answers about sides and
//! links: on which side of a sheet a point is, whether it is inside a closed surface, how often two closed chains are
//! linked.
//!
//! A solver that never lets anything through keeps all of these for ever; a check compares them with those of the start.
//! All integers here come from signs of exact predicates and are right for all finite positions, however close to
//! degenerate; nothing is rounded but [`Surface::solid_angle`].
//!
//! ```
//! use ipc_contact::topology::{Location, Surface, linking_number};
//! use mechanics_core::tensor::Vec3;
//!
//! // A tetrahedron, outward normals.
//! let x = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Vec3::from);
//! let surface = Surface::new(vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], 4)?.closed()?;
//! assert_eq!(surface.locate(&x, &Vec3::new(0.1, 0.1, 0.1))?, Location::Off { winding: 1 });
//! assert_eq!(surface.locate(&x, &Vec3::new(0.4, 0.4, 0.4))?, Location::Off { winding: 0 });
//! assert_eq!(surface.locate(&x, &Vec3::new(0.25, 0.25, 0.5))?, Location::On { triangle: 3 });
//!
//! // Two squares, one through the other.
//! let flat = [[1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], [-1.0, -1.0, 0.0], [1.0, -1.0, 0.0]].map(Vec3::from);
//! let upright = [[0.0, 0.0, 1.0], [0.0, 2.0, 1.0], [0.0, 2.0, -1.0], [0.0, 0.0, -1.0]].map(Vec3::from);
//! assert_eq!(linking_number(&flat, &upright)?, 1);
//! # Ok::<(), ipc_contact::ContactError>(())
//! ```
//!
//! # What these cannot see
//! The linking number does not tell every link from parted rings: the Whitehead link and the Borromean rings have linking
//! number 0, and a knot is not linked with anything. Whether a point is inside a body says nothing of a body that has
//! passed all the way through. The side of a sheet is that of a segment's crossings: a segment that goes past the
//! sheet's rim finds none.

mod linking;
mod surface;

pub use linking::linking_number;
pub use surface::{ClosedSurface, Crossings, Location, Side, Surface};

use crate::ContactError;
use crate::intersection::{Projection, orientation};
use mechanics_core::tensor::Vec3;

/// On which side of the plane abc the point d is once it has been moved by (δ², δ³, δ) for an arbitrarily small
/// δ > 0: the sign of (b − a) × (c − a) · (d − a), or else of the first entry of (b − a) × (c − a) that is not
/// zero, in the order z, x, y. Zero only if a, b, c are on one line.
///
/// # Reference
/// H. Edelsbrunner, E. P. Mücke, *Simulation of simplicity*, ACM Trans. Graph. 9(1), 1990, with one moved point.
fn side_of_moved(a: &Vec3, b: &Vec3, c: &Vec3, d: &Vec3) -> i8 {
    match orientation(a, b, c, d) {
        0 => {
            let order = [Projection::AlongZ, Projection::AlongX, Projection::AlongY];
            order.into_iter().map(|along| along.turn(a, b, c)).find(|&turn| turn != 0).unwrap_or(0)
        }
        side => side,
    }
}

fn check_finite(positions: &[Vec3]) -> Result<(), ContactError> {
    match positions.iter().find(|p| p.iter().any(|c| !c.is_finite())) {
        Some(&position) => Err(ContactError::NonFiniteQuery { position: position.into() }),
        None => Ok(()),
    }
}
