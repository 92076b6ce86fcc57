//! Newtonian viscosity, alone or added to any law.

use crate::error::{Parameter, not_negative};
use crate::{Curvature, PointLaw, PointLawError, Stress, TotalDeformation};
use mechanics_core::law::Domain;
use mechanics_core::projection::Projection;
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::{Matrix3, add_scaled, multiple_of_identity, scaled, symmetric_part, trace};

/// The linear viscous stress of Newton and Navier.
///
/// With the rate of deformation d = ½(∇v + ∇vᵀ), the Cauchy stress is σ = 2η dev d + ζ tr(d) I. Per rest volume
///
/// τ = J σ = J [2η d + (ζ − ⅔η) tr(d) I].
///
/// It dissipates σ : d = 2η ‖dev d‖² + ζ tr²d ≥ 0 per present volume, and does not see rigid rotation.
///
/// # Time step
/// As [`StiffnessBound`](crate::StiffnessBound) bounds ω², so does τ : ∇v ≤ J (λ̂ tr²∇v + 2μ̂ ‖∇v‖²) with μ̂ = η, λ̂ = ζ − ⅔η bound the rates γ of an
/// explicit step. It is stable for ω²h² + 2γh < 4 (the characteristic polynomial z² − (2 − γh − ω²h²) z + 1 − γh of the
/// symplectic Euler method has its roots in the unit disk).
///
/// # Reference
/// Landau and Lifshitz, Fluid Mechanics (2nd ed., 1987).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viscosity {
    shear: f64,
    bulk: f64,
}

impl Viscosity {
    /// No viscosity.
    pub const NONE: Self = Self { shear: 0.0, bulk: 0.0 };

    /// From the shear viscosity η and the bulk viscosity ζ [Pa s].
    ///
    /// # Errors
    /// [`PointLawError::OutOfRange`] unless both are finite and not negative.
    pub fn new(shear: f64, bulk: f64) -> Result<Self, PointLawError> {
        not_negative(Parameter::ShearViscosity, shear)?;
        not_negative(Parameter::BulkViscosity, bulk)?;
        Ok(Self { shear, bulk })
    }

    /// η [Pa s].
    pub fn shear(&self) -> f64 {
        self.shear
    }

    /// ζ [Pa s].
    pub fn bulk(&self) -> f64 {
        self.bulk
    }

    /// The viscous Kirchhoff stress \[Pa\] for the volume ratio J and ∇v [1/s].
    #[inline(always)]
    pub fn kirchhoff<S: Scalar>(&self, volume_ratio: S, velocity_gradient: &Matrix3<S>) -> Matrix3<S> {
        let rate = symmetric_part(velocity_gradient);
        let pressure = (trace(&rate) * volume_ratio).scale(self.bulk - self.shear * (2.0 / 3.0));
        let shear = scaled(&rate, volume_ratio.scale(2.0 * self.shear));
        add_scaled(&shear, S::constant(1.0), &multiple_of_identity(pressure))
    }
}

/// A law with Newtonian viscosity added: Kelvin and Voigt's solid from an elastic law, a viscous liquid from a fluid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viscous<L> {
    law: L,
    viscosity: Viscosity,
}

impl<L: PointLaw> Viscous<L> {
    /// `law` with `viscosity` in place of its own.
    pub fn new(law: L, viscosity: Viscosity) -> Self {
        Self { law, viscosity }
    }
}

impl<L: PointLaw> PointLaw for Viscous<L> {
    type Strain<S: Scalar> = L::Strain<S>;
    type History<S: Scalar> = L::History<S>;
    const TOTAL_DEFORMATION: TotalDeformation = L::TOTAL_DEFORMATION;

    #[inline(always)]
    fn energy_density<S: Scalar>(&self, strain: &L::Strain<S>, history: &L::History<S>) -> S {
        self.law.energy_density(strain, history)
    }

    fn energy_gradient(&self, strain: &L::Strain<f64>, history: &L::History<f64>) -> L::Strain<f64> {
        self.law.energy_gradient(strain, history)
    }

    fn energy_curvature(
        &self,
        strain: &L::Strain<f64>,
        history: &L::History<f64>,
        projection: Projection,
    ) -> Curvature {
        self.law.energy_curvature(strain, history, projection)
    }

    #[inline(always)]
    fn stress<S: Scalar>(&self, strain: &L::Strain<S>, history: &L::History<S>) -> Stress<S> {
        self.law.stress(strain, history)
    }

    #[inline(always)]
    fn return_map<S: Scalar>(
        &self,
        trial: &L::Strain<S>,
        history: &mut L::History<S>,
        step: f64,
    ) -> (L::Strain<S>, Stress<S>) {
        self.law.return_map(trial, history, step)
    }

    #[inline(always)]
    fn stiffening(&self) -> f64 {
        self.law.stiffening()
    }

    #[inline(always)]
    fn viscosity(&self) -> Viscosity {
        self.viscosity
    }

    fn domain(&self) -> Domain {
        self.law.domain()
    }
}
