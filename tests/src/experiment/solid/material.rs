//! Laws of scene files, and the one place where their formulas are compiled.
//!
//! The laws' functions are inlined wherever they are called, which is what solvers want. Here they are called from many
//! experiments, and each copy costs seconds of compile time; the functions below keep one copy a law.

use crate::scene::physics::{Isotropic, Law};
use mechanics_core::law::{
    FixedCorotated, Hyperelastic, Lame, LawError, Linear, NeoHookean, StVenantKirchhoff, StableNeoHookean,
    Stiffness,
};
use mechanics_core::projection::Projection;
use mechanics_core::tensor::Mat3;

/// ψ(F) [J/m³].
#[inline(never)]
pub(crate) fn energy_density<L: Hyperelastic>(law: &L, f: &Mat3) -> f64 {
    law.energy_density(f)
}

/// P(F) [Pa].
#[inline(never)]
pub(crate) fn first_piola<L: Hyperelastic>(law: &L, f: &Mat3) -> Mat3 {
    law.first_piola(f)
}

/// ∂P/∂F [Pa], projected.
#[inline(never)]
pub(crate) fn stiffness<L: Hyperelastic>(law: &L, f: &Mat3, projection: Projection) -> Stiffness<f64> {
    law.stiffness(f, projection)
}

/// The Lamé parameters of a scene's constants.
pub(crate) fn lame(constants: &Isotropic) -> Result<Lame, LawError> {
    Lame::from_young_poisson(constants.young_modulus_pa.value(), constants.poisson_ratio.value())
}

/// P(F) [Pa] of a law that a scene names.
pub(crate) type Stress = Box<dyn Fn(&Mat3) -> Mat3>;

/// The stress of a law that a scene names.
pub(crate) fn stress(law: &Law) -> Result<Stress, LawError> {
    fn of<L: Hyperelastic + 'static>(law: L) -> Stress {
        Box::new(move |f| first_piola(&law, f))
    }
    Ok(match law {
        Law::Linear(constants) => of(Linear::new(lame(constants)?)),
        Law::SaintVenantKirchhoff(constants) => of(StVenantKirchhoff::new(lame(constants)?)),
        Law::NeoHookean(constants) => of(NeoHookean::new(lame(constants)?)),
        Law::StableNeoHookean(constants) => of(StableNeoHookean::new(lame(constants)?)),
        Law::FixedCorotated(constants) => of(FixedCorotated::new(lame(constants)?)),
    })
}

/// The von Mises stress [Pa] of the Cauchy stress σ = P Fᵀ / det F: √(3/2 s : s) with the deviator s = σ − ⅓ tr σ I.
pub(crate) fn von_mises(stress: &Mat3, f: &Mat3) -> f64 {
    let cauchy = stress * f.transpose() / f.determinant();
    let deviator = cauchy - Mat3::identity() * (cauchy.trace() / 3.0);
    (1.5 * deviator.norm_squared()).sqrt()
}
