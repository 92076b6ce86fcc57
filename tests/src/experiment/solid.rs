//! Solids of linear tetrahedra: what scenes need of them until a solver crate has it.

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
use element::{LinearTetrahedra, RestShapes};
use material::lame;
use mechanics_core::law::{
    FixedCorotated, LawError, Linear, NeoHookean, StVenantKirchhoff, StableNeoHookean,
};
use mechanics_core::linear::{Method, Ordering, Preconditioner};
use mechanics_core::potential::Potential;
use mechanics_core::stencil::{StencilError, StencilTerm};
use std::sync::Arc;

/// Why a material and a mesh make no elastic term.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ElasticError {
    #[error(transparent)]
    Law(#[from] LawError),
    #[error(transparent)]
    Elements(#[from] StencilError),
}

/// The elastic energy of tetrahedra, given by their point numbers; `name` stands for it in errors.
pub(crate) fn elastic_term(
    name: &str,
    law: &Law,
    rest: &Arc<RestShapes>,
    cells: Vec<[u32; 4]>,
) -> Result<Box<dyn Potential>, ElasticError> {
    macro_rules! term {
        ($law:ident, $constants:expr) => {{
            let stencil = LinearTetrahedra::new($law::new(lame($constants)?), Arc::clone(rest));
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
