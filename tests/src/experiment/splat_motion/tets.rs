//! Splats moved by tetrahedra.

use super::matter::Matter;
use super::refused;
use crate::experiment::ExperimentError;
use crate::experiment::simulation::Course;
use gaussian_deform::bind::{Moved, TetBinding, TetGradients};
use gaussian_deform::select;
use mechanics_core::samples::DeformationSamples;
use mechanics_core::tensor::Vec3;

/// A simulation of tetrahedra, and how they move splats.
pub(super) struct TetDrive {
    pub(super) course: Course,
    binding: TetBinding,
    moved: Moved,
}

impl TetDrive {
    /// Splats of `matter` in the tetrahedra of `course`.
    pub(super) fn new(course: Course, matter: &Matter) -> Result<Self, ExperimentError> {
        let means = select::means(&matter.splats, &matter.list);
        let means: Vec<Vec3> = means.iter().map(|x| matter.place.point(x)).collect();
        let mesh = course.bodies().mesh();
        let binding =
            TetBinding::new(mesh, &means, TetGradients::Smooth).map_err(|error| refused("meshes", error))?;
        let size = mesh.bounding_box().map_or(0.0, |bounds| bounds.size().norm());
        if binding.farthest() > FARTHEST * size {
            let reason = format!(
                "{} of {} splats are outside of the meshes, by up to {:.3} m: bring them together with \
                 `splats.placement`, or make `splats.region` smaller",
                binding.outside(),
                means.len(),
                binding.farthest()
            );
            return Err(refused("splats.placement", reason));
        }
        Ok(Self { course, binding, moved: Moved::new() })
    }

    /// Where the splats are now, and how they are deformed: this is all that moves them.
    pub(super) fn samples(&mut self) -> Result<DeformationSamples<'_>, ExperimentError> {
        self.binding.move_into(self.course.positions(), &mut self.moved).map_err(ExperimentError::stopped)?;
        Ok(self.moved.samples())
    }
}

/// How far from the meshes a splat may be, in diagonals of their box.
const FARTHEST: f64 = 0.05;
