//! Two plates that press what lies between them on a pedestal, and lift it.

use super::push;
use crate::experiment::ExperimentError;
use crate::experiment::contact::world::{World, WorldBuilder};
use ipc_contact::collision_mesh::CollisionObject;
use mechanics_core::mesh::{BoxSplit, Surface, TriMesh, block};
use mechanics_core::tensor::Vec3;
use std::ops::Range;

/// Fingers and pedestal of a gripper: scripted boxes.
pub(in crate::experiment) struct Hand {
    /// The points of the left finger, at negative x, and of the right one.
    pub(in crate::experiment) fingers: [Range<u32>; 2],
    /// The points of the pedestal.
    pub(in crate::experiment) pedestal: Range<u32>,
    /// What the left finger, the right one and the pedestal look like at the start.
    pub(in crate::experiment) surfaces: [TriMesh; 3],
}

impl Hand {
    /// Adds a right finger and a pedestal, boxes by their lowest and highest corners \[m\], and the right finger's mirror image.
    pub(in crate::experiment) fn add(
        builder: &mut WorldBuilder,
        [low, high]: [Vec3; 2],
        pedestal: [Vec3; 2],
    ) -> Result<Self, ExperimentError> {
        let left = [Vec3::new(-high.x, low.y, low.z), Vec3::new(-low.x, high.y, high.z)];
        let surfaces = [plate(left)?, plate([low, high])?, plate(pedestal)?];
        let [left, right, pedestal] = surfaces
            .each_ref()
            .map(|mesh| builder.add_obstacle(mesh.points(), |first| CollisionObject::of_mesh(mesh, first)));
        Ok(Self { fingers: [left, right], pedestal, surfaces })
    }

    /// Moves the right finger by `way` \[m\] during the next step, and the left one by its mirror image.
    pub(in crate::experiment) fn push(&self, world: &mut World, way: Vec3) -> Result<(), ExperimentError> {
        let [left, right] = self.fingers.clone();
        push(world, left, mirrored(way))?;
        push(world, right, way)
    }
}

fn plate([low, high]: [Vec3; 2]) -> Result<TriMesh, ExperimentError> {
    let solid = block(&low, &high, [1, 1, 1], BoxSplit::Six).map_err(ExperimentError::stopped)?;
    Ok(Surface::of_tets(&solid).map_err(ExperimentError::stopped)?.into_mesh())
}

/// A vector of the right finger, of the left one.
pub(in crate::experiment) fn mirrored(way: Vec3) -> Vec3 {
    Vec3::new(-way.x, way.y, way.z)
}

/// What a hand does: it closes at once, and lifts later.
pub(in crate::experiment) struct Grasp {
    /// How far each finger presses \[m\].
    pub(in crate::experiment) squeeze: f64,
    /// When the fingers have closed \[s\].
    pub(in crate::experiment) closed: f64,
    /// How far they lift \[m\].
    pub(in crate::experiment) lift: f64,
    /// From when until when \[s\].
    pub(in crate::experiment) lifting: [f64; 2],
}

impl Grasp {
    /// Where the right finger is at the time `t` \[s\], from where it was.
    pub(in crate::experiment) fn way(&self, t: f64) -> Vec3 {
        let [begin, end] = self.lifting;
        Vec3::new(-self.squeeze * ramp(t, 0.0, self.closed), 0.0, self.lift * ramp(t, begin, end))
    }
}

/// From 0 to 1, smoothly.
fn ramp(t: f64, from: f64, to: f64) -> f64 {
    let s = ((t - from) / (to - from)).clamp(0.0, 1.0);
    s * s * (3.0 - 2.0 * s)
}
