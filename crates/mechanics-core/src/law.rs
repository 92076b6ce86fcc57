//! Hyperelastic laws: energy density ψ(F), first Piola–Kirchhoff stress P(F) = ∂ψ/∂F and stiffness ∂P/∂F.
//!
//! One trait, [`Hyperelastic`], is shared by finite elements (`f64`), material points (`f32` lanes) and automatic
//! differentiation (jets). Each law's page is its derivation, so that the code can be checked against it.
//!
//! | law | energy density | domain |
//! |---|---|---|
//! | [`Linear`] | μ ε:ε + ½λ tr²ε, small strain, not objective | every F |
//! | [`StVenantKirchhoff`] | μ E:E + ½λ tr²E, Green strain; no resistance to crushing | every F |
//! | [`Hencky`] | μ Σ ln²σᵢ + ½λ ln²J, logarithmic strain | det F > 0 |
//! | [`FixedCorotated`] | μ ‖F − R‖² + ½λ (J − 1)² | every F |
//! | [`NeoHookean`] | ½μ(tr FᵀF − 3) − μ ln J + ½λ ln²J | det F > 0 |
//! | [`StableNeoHookean`] | Smith et al. 2018, with the logarithm of tr FᵀF + 1 | every F |
//!
//! All of them are zero and stress-free at F = I and there agree to second order with linear elasticity of the
//! same [`Lame`] parameters.
//!
//! ```
//! use mechanics_core::law::{Hyperelastic, Lame, NeoHookean};
//! use mechanics_core::tensor::Mat3;
//!
//! let rubber = NeoHookean::new(Lame::from_young_poisson(1.0e6, 0.0)?);
//! let stretched = Mat3::new(2.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
//! let stress = rubber.first_piola(&stretched);
//! // P₁₁ = μ (2 − 1/2) with μ = E/2 when ν = 0.
//! assert!((stress[(0, 0)] - 0.75e6).abs() < 1e-6);
//! # Ok::<(), mechanics_core::law::LawError>(())
//! ```

mod fixed_corotated;
mod hencky;
mod inversion;
mod lame;
mod linear;
mod neo_hookean;
mod principal;
mod saint_venant_kirchhoff;
mod stable_neo_hookean;
mod stiffness;
mod volume;
mod volume_polynomial;

pub use fixed_corotated::FixedCorotated;
pub use hencky::Hencky;
pub use inversion::{LOOK_AHEAD, first_inversion};
pub use lame::Lame;
pub use linear::Linear;
pub use neo_hookean::NeoHookean;
pub use principal::PrincipalStiffness;
pub use saint_venant_kirchhoff::StVenantKirchhoff;
pub use stable_neo_hookean::StableNeoHookean;
pub use stiffness::Stiffness;

use crate::projection::Projection;
use crate::scalar::Scalar;
use crate::tensor::{Mat3, Matrix3, determinant};

/// The set of deformation gradients on which a law is defined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Domain {
    /// Every finite F, also flat and inverted ones.
    EveryDeformation,
    /// det F > 0. The energy tends to +∞ at the border.
    PositiveVolume,
}

/// Why a law cannot be built or evaluated.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum LawError {
    /// Young's modulus must be positive and finite.
    #[error("Young's modulus must be positive and finite, but it is {value} Pa")]
    YoungModulus {
        /// The refused value \[Pa\].
        value: f64,
    },
    /// Poisson's ratio must lie strictly between −1 and ½.
    #[error(
        "Poisson's ratio must lie strictly between -1 and 1/2, but it is {value}; for a nearly incompressible \
         material take a value like 0.49"
    )]
    PoissonRatio {
        /// The refused value.
        value: f64,
    },
    /// The shear modulus μ must be positive and finite.
    #[error("the shear modulus must be positive and finite, but it is {value} Pa")]
    ShearModulus {
        /// The refused value \[Pa\].
        value: f64,
    },
    /// The bulk modulus K = λ + ⅔μ must be positive and finite.
    #[error("the bulk modulus must be positive and finite, but it is {value} Pa")]
    BulkModulus {
        /// The refused value \[Pa\].
        value: f64,
    },
    /// The deformation gradient is outside the law's domain: it is inverted, flat, or not finite.
    #[error(
        "the deformation gradient has determinant {determinant}, and this law needs a positive one: the element \
         is inverted, flat, or its coordinates are not finite"
    )]
    Inadmissible {
        /// det F.
        determinant: f64,
    },
}

/// A hyperelastic law: stress derives from an energy density.
///
/// Matrices are deformation gradients F = ∂x/∂X, energies are per rest volume. All functions are pure, never
/// panic, and turn NaN into NaN.
///
/// The functions are generic over [`Scalar`], so one formula runs as `f64`, as lanes and through jets. A new law
/// writes three formulas and names its domain; [`PrincipalStiffness`] does the projection of isotropic laws, and
/// [`project_symmetric`](crate::projection::project_symmetric) that of any other.
///
/// # Derivatives through jets
/// The laws of this module give correct first and second derivatives of the energy, and first derivatives of the
/// stress, for jets over any F at which the law is that smooth, repeated singular values included. [`Hencky`] is
/// the only one limited to that; the others may be differentiated further. A stiffness that needs singular values
/// (any projection; [`Hencky`] and [`FixedCorotated`] always) comes out of jets with zero derivatives.
pub trait Hyperelastic: Send + Sync {
    /// ψ(F) [J/m³]; +∞ outside the [`Domain`].
    ///
    /// The laws of this module keep their digits near rest: with the strain s = ‖FᵀF − I‖, ψ is of order s² and wrong by
    /// 16 ε(1 + ‖F − I‖²/s) of itself while ‖F − I‖² < ½, and by a few ε/s of a body turned further. That is the error of the formula; F
    /// as a caller has it is usually rounded itself, by ε, which makes ψ wrong by about ε/s whatever the formula.
    fn energy_density<S: Scalar>(&self, f: &Matrix3<S>) -> S;

    /// P = ∂ψ/∂F \[Pa\], Pᵢⱼ = ∂ψ/∂Fᵢⱼ. Without meaning outside the [`Domain`].
    fn first_piola<S: Scalar>(&self, f: &Matrix3<S>) -> Matrix3<S>;

    /// ∂P/∂F \[Pa\], its eigenvalues replaced as `projection` says. Without meaning outside the [`Domain`].
    fn stiffness<S: Scalar>(&self, f: &Matrix3<S>, projection: Projection) -> Stiffness<S>;

    /// Where the law is defined.
    fn domain(&self) -> Domain;

    /// Whether `f` is finite and inside the [`Domain`], so that a caller can refuse a start and name the element.
    ///
    /// # Errors
    /// [`LawError::Inadmissible`] with det F otherwise.
    fn check_admissible(&self, f: &Mat3) -> Result<(), LawError> {
        let j = determinant(f);
        let inside = match self.domain() {
            Domain::EveryDeformation => f.iter().all(|entry| entry.is_finite()),
            Domain::PositiveVolume => j > 0.0 && j.is_finite(),
        };
        if inside { Ok(()) } else { Err(LawError::Inadmissible { determinant: j }) }
    }

    /// A step t so that F + s dF stays inside the [`Domain`] for every s in [0, t].
    ///
    /// ∞ if the domain is left nowhere on (0, [`LOOK_AHEAD`]]; 0 if `f` is not inside, or something is not
    /// finite. See [`first_inversion`] for how sharp it is. Multiply it by a factor below one: at t itself the
    /// determinant may be as small as rounding lets it.
    fn largest_step(&self, f: &Mat3, df: &Mat3) -> f64 {
        match self.domain() {
            Domain::EveryDeformation => f64::INFINITY,
            Domain::PositiveVolume => first_inversion(f, df),
        }
    }
}
