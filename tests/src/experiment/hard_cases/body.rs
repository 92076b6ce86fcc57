//! Blocks of tetrahedra, their laws, and what to ask of their deformation.

use crate::experiment::ExperimentError;
use ipc_contact::collision_mesh::CollisionObject;
use lagrangian::element::{Mass, MassDistribution, Tetrahedra};
use lagrangian::stepper::StepperOptions;
use mechanics_core::law::{FixedCorotated, Hencky, Hyperelastic, Lame, NeoHookean, StableNeoHookean};
use mechanics_core::mesh::TetMesh;
use mechanics_core::newton::NewtonOptions;
use mechanics_core::objective::Projecting;
use mechanics_core::potential::Potential;
use mechanics_core::projection::Projection;
use mechanics_core::stencil::StencilTerm;
use mechanics_core::tensor::{Mat3, Vec3};

/// The methods of hard cases of solids: laws; with absolute eigenvalues instead of clamped ones, or with Hessians projected on
/// demand only, where they say so.
pub(super) const LAWS: &[&str] = &[
    "stable-neo-hookean",
    "stable-neo-hookean-absolute",
    "stable-neo-hookean-on-demand",
    "fixed-corotated",
    "fixed-corotated-absolute",
    "fixed-corotated-on-demand",
    "neo-hookean",
    "neo-hookean-absolute",
    "neo-hookean-on-demand",
    "hencky",
    "hencky-on-demand",
];

/// The elastic energy of the law that a method names, of some cells of a mesh.
pub(super) fn elastic(
    method: &str,
    lame: Lame,
    mesh: &TetMesh,
    cells: &[[u32; 4]],
) -> Result<Box<dyn Potential>, ExperimentError> {
    fn term<L: Hyperelastic + 'static>(
        law: L,
        mesh: &TetMesh,
        cells: &[[u32; 4]],
    ) -> Result<Box<dyn Potential>, ExperimentError> {
        let stencil = Tetrahedra::new(law, mesh.points(), cells).map_err(ExperimentError::stopped)?;
        let term = StencilTerm::new("elastic", stencil, cells.to_vec());
        Ok(Box::new(term.map_err(ExperimentError::stopped)?))
    }
    match method.trim_end_matches("-absolute").trim_end_matches("-on-demand") {
        "stable-neo-hookean" => term(StableNeoHookean::new(lame), mesh, cells),
        "fixed-corotated" => term(FixedCorotated::new(lame), mesh, cells),
        "neo-hookean" => term(NeoHookean::new(lame), mesh, cells),
        "hencky" => term(Hencky::new(lame), mesh, cells),
        other => Err(ExperimentError::Refused {
            key: "validation.methods".to_owned(),
            reason: format!("there is no method `{other}`"),
        }),
    }
}

/// How the steps of a hard case are made, of length `h` (s): `tolerance` is a velocity (m/s), less for steps so long that it
/// would be more than 40 ms of it.
pub(super) fn options(method: &str, tolerance: f64, h: f64) -> StepperOptions {
    let projection = if method.ends_with("-absolute") { Projection::Absolute } else { Projection::Clamp };
    let on_demand = method.ends_with("-on-demand");
    let projecting = if on_demand { Projecting::OnDemand } else { Projecting::Always };
    let tolerance = tolerance.min(0.04 * tolerance / h);
    let newton = NewtonOptions { tolerance, max_iterations: 2000, ..NewtonOptions::default() };
    StepperOptions { newton, projection, projecting, ..StepperOptions::default() }
}

/// The surface of a solid.
pub(super) fn skin(mesh: &TetMesh) -> Result<Vec<[u32; 3]>, ExperimentError> {
    Ok(CollisionObject::of_tets(mesh, 0).map_err(ExperimentError::stopped)?.triangles)
}

/// The lumped mass of a mesh of one density (kg/m³).
pub(super) fn mass(mesh: &TetMesh, density: f64) -> Result<Mass, ExperimentError> {
    let mut mass = Mass::zeros(mesh.points().len());
    mass.add_tetrahedra(mesh.points(), mesh.cells(), density, MassDistribution::Lumped)
        .map_err(ExperimentError::stopped)?;
    Ok(mass)
}

/// The deformation gradients of a mesh.
pub(super) struct Deformation {
    cells: Vec<[u32; 4]>,
    /// Of the rest edges.
    inverse: Vec<Mat3>,
}

impl Deformation {
    pub(super) fn of(mesh: &TetMesh) -> Self {
        let edges = |cell: usize| edges(&mesh.corners(cell));
        let inverse = (0..mesh.cells().len()).map(|cell| edges(cell).try_inverse().unwrap_or_default());
        Self { cells: mesh.cells().to_vec(), inverse: inverse.collect() }
    }

    fn gradients<'a>(&'a self, x: &'a [Vec3]) -> impl Iterator<Item = Mat3> + 'a {
        self.cells
            .iter()
            .zip(&self.inverse)
            .map(|(cell, inverse)| edges(&cell.map(|i| x[i as usize])) * inverse)
    }

    /// The smallest det F.
    pub(super) fn smallest_determinant(&self, x: &[Vec3]) -> f64 {
        self.gradients(x).map(|f| f.determinant()).fold(f64::INFINITY, f64::min)
    }

    /// The first element with det F ≤ 0.
    pub(super) fn first_inverted(&self, x: &[Vec3]) -> Option<usize> {
        self.gradients(x).position(|f| f.determinant() <= 0.0)
    }

    /// The largest Green strain ½‖FᵀF − I‖.
    pub(super) fn largest_strain(&self, x: &[Vec3]) -> f64 {
        let strain = |f: Mat3| 0.5 * (f.transpose() * f - Mat3::identity()).norm();
        self.gradients(x).map(strain).fold(0.0, f64::max)
    }

    /// The largest difference of Green's strain between two states, which no rigid motion changes.
    pub(super) fn largest_strain_between(&self, x: &[Vec3], y: &[Vec3]) -> f64 {
        let difference = |(f, g): (Mat3, Mat3)| 0.5 * (f.transpose() * f - g.transpose() * g).norm();
        self.gradients(x).zip(self.gradients(y)).map(difference).fold(0.0, f64::max)
    }
}

fn edges([a, b, c, d]: &[Vec3; 4]) -> Mat3 {
    Mat3::from_columns(&[b - a, c - a, d - a])
}
