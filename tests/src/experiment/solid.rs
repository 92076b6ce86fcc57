//! Solids of linear tetrahedra in equilibrium: the laws and solvers that scene files name, and deformations that are known.

pub(crate) mod element;
mod homogeneous;
mod linear_systems;
mod manufactured;
pub(crate) mod material;
pub(crate) mod statics;

pub(crate) use homogeneous::HomogeneousDeformation;
pub(crate) use linear_systems::LinearSystems;
pub(crate) use manufactured::ManufacturedStatics;

use crate::scene::physics::{self, Law};
use lagrangian::element::{ElementError, Tetrahedra};
use material::lame;
use mechanics_core::law::{
    FixedCorotated, LawError, Linear, NeoHookean, StVenantKirchhoff, StableNeoHookean,
};
use mechanics_core::linear::{Method, Ordering, Preconditioner};
use mechanics_core::mesh::TetMesh;
use mechanics_core::potential::Potential;
use mechanics_core::stencil::{StencilError, StencilTerm};

/// Why a material and a mesh make no elastic term.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ElasticError {
    #[error(transparent)]
    Law(#[from] LawError),
    #[error(transparent)]
    Elements(#[from] ElementError),
    #[error(transparent)]
    Points(#[from] StencilError),
}

/// The elastic energy of a mesh whose points begin at number `first`; `name` stands for it in errors.
pub(crate) fn elastic_term(
    name: &str,
    law: &Law,
    mesh: &TetMesh,
    first: u32,
) -> Result<Box<dyn Potential>, ElasticError> {
    let cells = mesh.cells().iter().map(|cell| cell.map(|node| node + first)).collect();
    macro_rules! term {
        ($law:ident, $constants:expr) => {{
            let stencil = Tetrahedra::new($law::new(lame($constants)?), mesh.points(), mesh.cells())?;
            Ok(Box::new(StencilTerm::new(name, stencil, cells)?))
        }};
    }
    match law {
        Law::Linear(constants) => term!(Linear, constants),
        Law::SaintVenantKirchhoff(constants) => term!(StVenantKirchhoff, constants),
        Law::NeoHookean(constants) => term!(NeoHookean, constants),
        Law::StableNeoHookean(constants) => term!(StableNeoHookean, constants),
        Law::FixedCorotated(constants) => term!(FixedCorotated, constants),
    }
}

/// A scene's linear solver.
pub(crate) fn linear_method(solver: physics::LinearSolver) -> Method {
    let conjugate_gradient = |preconditioner| Method::ConjugateGradient {
        preconditioner,
        tolerance: 1e-10,
        max_iterations: 20_000,
    };
    match solver {
        physics::LinearSolver::Cholesky => Method::Cholesky { ordering: Ordering::FewestFlops },
        physics::LinearSolver::PcgBlockJacobi => conjugate_gradient(Preconditioner::BlockJacobi),
        physics::LinearSolver::PcgIncompleteCholesky => {
            conjugate_gradient(Preconditioner::IncompleteCholesky)
        }
    }
}
