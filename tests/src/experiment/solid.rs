//! Solids of linear tetrahedra: what scenes need of them until a solver crate has it.

pub(crate) mod element;
mod linear_systems;
mod manufactured;
pub(crate) mod statics;

pub(crate) use linear_systems::LinearSystems;
pub(crate) use manufactured::ManufacturedStatics;

use crate::scene::physics::{Isotropic, Law};
use element::{LinearTetrahedra, RestShapes};
use mechanics_core::law::{
    FixedCorotated, Lame, LawError, Linear, NeoHookean, StVenantKirchhoff, StableNeoHookean,
};
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

/// The elastic energy of tetrahedra, given by their point numbers.
pub(crate) fn elastic_term(
    law: &Law,
    rest: &Arc<RestShapes>,
    cells: Vec<[u32; 4]>,
) -> Result<Box<dyn Potential>, ElasticError> {
    macro_rules! term {
        ($law:ident, $constants:expr) => {{
            let Isotropic { young_modulus_pa, poisson_ratio } = $constants;
            let lame = Lame::from_young_poisson(young_modulus_pa.value(), poisson_ratio.value())?;
            let stencil = LinearTetrahedra::new($law::new(lame), Arc::clone(rest));
            Ok(Box::new(StencilTerm::new("elasticity", stencil, cells)?))
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
