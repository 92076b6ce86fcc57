//! Solids that flow.
//!
//! All are isotropic and keep the elastic deformation gradient Fᵉ as their strain. A trial strain (elastic motion alone) that leaves the
//! yield surface is returned to it along the flow direction, in the principal axes of τ. All but snow are elastic by
//! Hencky's law, in whose logarithmic strain the flow is additive.
//!
//! | law | yields where | flows | history |
//! |---|---|---|---|
//! | [`VonMises`] | √(3/2)‖dev τ‖ = σ_y(α) | associative, isochoric; hardens or softens | α |
//! | [`DruckerPrager`] | ‖dev τ‖ = 3a(p + p_t) | isochoric; opens freely, and must close before it carries pressure | opening, flow |
//! | [`ModifiedCamClay`] | on an ellipse in (p, q) | associative, implicit; hardens by compaction | compaction |
//! | [`NonAssociativeCamClay`] | on an ellipse in (p, q) | deviatoric; hardens by compaction | compaction |
//! | [`HerschelBulkley`] | √(3/2)‖dev τ‖ > σ_y | isochoric, at a rate | none |
//! | [`Snow`] | σᵢ outside [1 − θ_c, 1 + θ_s] | each σᵢ alone; hardens by compaction | volume |

mod drucker_prager;
mod herschel_bulkley;
mod modified_cam_clay;
mod non_associative_cam_clay;
mod snow;
mod von_mises;
mod yield_stress;

pub use drucker_prager::{DruckerPrager, FrictionAngle, SandHistory};
pub use herschel_bulkley::HerschelBulkley;
pub use modified_cam_clay::ModifiedCamClay;
pub use non_associative_cam_clay::NonAssociativeCamClay;
pub use snow::{Snow, SnowHistory};
pub use von_mises::{PlasticStrain, VonMises};
pub use yield_stress::YieldStress;

use crate::Numbers;
use mechanics_core::scalar::Scalar;

/// Plastic change of volume, as a natural logarithm relative to virgin material: negative for compaction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compaction<S> {
    /// ln Jᵖ.
    pub log_volume: S,
}

impl<S: Scalar> Numbers<S> for Compaction<S> {
    const COUNT: usize = 1;

    #[inline(always)]
    fn from_numbers(mut number: impl FnMut(usize) -> S) -> Self {
        Self { log_volume: number(0) }
    }

    #[inline(always)]
    fn number(&self, k: usize) -> S {
        [self.log_volume][k]
    }
}
