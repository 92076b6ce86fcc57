//! Tableware: thick shells of revolution.

use crate::experiment::ExperimentError;
use mechanics_core::mesh::{TetMesh, cylinder};
use mechanics_core::tensor::Vec3;

/// A plate, a bowl or a glass: a disc whose rim is turned up. A flat base, a rounding of a quarter of a circle, a wall; all of
/// one thickness.
#[derive(Clone, Copy, Debug)]
pub(super) struct Dish {
    /// Radius of the flat base (m).
    pub(super) base: f64,
    /// Radius of the rounding, on the outside (m).
    pub(super) rounding: f64,
    /// Height of the upright wall (m).
    pub(super) wall: f64,
    /// (m).
    pub(super) thickness: f64,
}

impl Dish {
    /// A plate, a bowl, a glass, a jar.
    pub(super) const SERVICE: [Self; 4] = [
        Self { base: 0.06, rounding: 0.02, wall: 1e-3, thickness: 6e-3 },
        Self { base: 0.025, rounding: 0.04, wall: 0.01, thickness: 5e-3 },
        Self { base: 0.025, rounding: 0.01, wall: 0.07, thickness: 5e-3 },
        Self { base: 0.035, rounding: 0.015, wall: 0.04, thickness: 6e-3 },
    ];

    /// Where a point of the disc at `s` from its middle and `depth` above its lower side is: radius and height.
    fn place(&self, s: f64, depth: f64) -> [f64; 2] {
        let arc = self.rounding * std::f64::consts::FRAC_PI_2;
        if s <= self.base {
            [s, depth]
        } else if s <= self.base + arc {
            let angle = (s - self.base) / self.rounding;
            let r = self.rounding - depth;
            [self.base + r * angle.sin(), self.rounding - r * angle.cos()]
        } else {
            [self.base + self.rounding - depth, self.rounding + s - self.base - arc]
        }
    }

    /// The dish on the plane z = 0 about the z axis, with so many rings of points from its middle to its rim.
    pub(super) fn mesh(&self, rings: u32) -> Result<TetMesh, ExperimentError> {
        let meridian = self.base + self.rounding * std::f64::consts::FRAC_PI_2 + self.wall;
        let mut mesh = cylinder(meridian, self.thickness, rings, 1).map_err(ExperimentError::stopped)?;
        mesh.map_points(|p| {
            let s = p.xy().norm();
            let [r, z] = self.place(s, p.z);
            let out = if s > 0.0 { p.xy() / s } else { p.xy() };
            Vec3::new(r * out.x, r * out.y, z)
        })
        .map_err(ExperimentError::stopped)?;
        mesh.orient();
        Ok(mesh)
    }
}
