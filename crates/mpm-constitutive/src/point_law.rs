//! The seam between materials and grids.

use crate::curvature::{self, Curvature, MOST};
use crate::{Numbers, PointLawError, StiffnessBound, Strain, Viscosity};
use mechanics_core::jet::Jet2;
use mechanics_core::law::{Domain, LawError};
use mechanics_core::projection::Projection;
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::{Matrix3, scaled, sum, trace};

/// How a law's strain is related to the total deformation gradient ∂x/∂X.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TotalDeformation {
    /// The strain is the total deformation gradient: an elastic solid.
    IsTheStrain,
    /// The strain is the elastic part only. Whoever wants the total one (to deform a picture with the body, say) integrates it beside.
    Separate,
    /// Neighbours do not stay neighbours: a total deformation gradient says nothing. Fluids.
    Meaningless,
}

/// Stress and stiffness of a material point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stress<S> {
    /// The Kirchhoff stress τ = J σ = P Fᵀ \[Pa\], per rest volume; symmetric for every objective law.
    pub kirchhoff: Matrix3<S>,
    /// What limits the time step. It costs nothing where it is not read: everything is inlined.
    pub stiffness: StiffnessBound<S>,
}

/// How a material point moves during one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion<S> {
    /// ∇v, entry (i, j) = ∂vᵢ/∂xⱼ [1/s].
    pub velocity_gradient: Matrix3<S>,
    /// h \[s\].
    pub step: f64,
}

/// The law of one material point: stress as a function of an elastic strain and a history, and the flow that changes both.
///
/// Formulas are written once over [`Scalar`], so that a law runs as `f64`, as `f32`, as four or eight lanes, and
/// [`energy_density`](Self::energy_density) through automatic differentiation. Energies and stresses are per rest volume.
///
/// # How a grid code uses it
/// A particle keeps `L::Strain` and `L::History`: [`Numbers::COUNT`] scalars each, stored as the grid code likes, for instance one
/// array of eight lanes a number. A new particle has [`Strain::undeformed`] and [`fresh_history`]. In every step, for the
/// particles of a packet `P`,
///
/// ```
/// # use mechanics_core::{lanes::Packet, tensor::{Matrix3, scaled}};
/// # use mpm_constitutive::{Motion, PointLaw};
/// fn momentum_flux<P: Packet, L: PointLaw>(
///     law: &L,
///     strain: &mut L::Strain<P>,
///     history: &mut L::History<P>,
///     motion: &Motion<P>, // ∇v gathered from the grid, and h
///     rest_volume: P,
/// ) -> Matrix3<P> {
///     let (moved, stress) = law.advance(strain, history, motion);
///     *strain = moved;
///     scaled(&stress.kirchhoff, rest_volume) // force on node i: −V₀ τ ∇wᵢ
/// }
/// ```
///
/// `advance` fuses the update of the strain, the return map and the stress, because laws in principal axes need one singular value
/// decomposition for all of them. Whether it runs at the end of a step (after the gather) or at the begin of the next (before the
/// scatter) is the grid's choice; [`stress`](Self::stress) gives the stress of a stored state at any time.
///
/// # Inadmissible strains
/// Outside the [`domain`](Self::domain) (an inverted F under a law with logarithms) **the trace of τ is not finite**: NaN or infinite, on that
/// lane alone. A grid code tests it once a packet, and asks [`check_admissible`](Self::check_admissible) for the error of the particle.
///
/// # Writing a law
/// Two functions for an elastic law; a plastic one adds [`return_map`](Self::return_map). Mark them `#[inline(always)]`. Histories are
/// chosen such that zero is virgin material.
pub trait PointLaw: Send + Sync {
    /// What the law needs of the motion: [`Matrix3`] or [`VolumeChange`](crate::VolumeChange).
    type Strain<S: Scalar>: Strain<S>;

    /// The variables of plastic flow, `()` if there are none.
    type History<S: Scalar>: Numbers<S>;

    /// Whether the total deformation gradient is the strain, or worth tracking beside it.
    const TOTAL_DEFORMATION: TotalDeformation;

    /// ψ, the stored energy [J/m³].
    fn energy_density<S: Scalar>(&self, strain: &Self::Strain<S>, history: &Self::History<S>) -> S;

    /// The stress of a state, without viscosity: τ = ∂ψ/∂F Fᵀ, or J ∂ψ/∂J I.
    fn stress<S: Scalar>(&self, strain: &Self::Strain<S>, history: &Self::History<S>) -> Stress<S>;

    /// The state in which the trial strain, reached by elastic motion alone during `step` \[s\], comes to rest; its history
    /// and its stress.
    ///
    /// A strain that needs no flow is returned as it came, bit for bit. The default is that of an elastic law.
    #[inline(always)]
    fn return_map<S: Scalar>(
        &self,
        trial: &Self::Strain<S>,
        history: &mut Self::History<S>,
        step: f64,
    ) -> (Self::Strain<S>, Stress<S>) {
        let _ = step;
        (*trial, self.stress(trial, history))
    }

    /// The power n ≥ 0 with which matter stiffens when it is pressed: the [bound](StiffnessBound) on its stiffness grows no faster than as J⁻ⁿ. For who
    /// must know how much stiffer matter may be at the end of a step than at its begin; zero by default, which says no more than that it
    /// is of the same size for strains of one.
    fn stiffening(&self) -> f64 {
        0.0
    }

    /// The Newtonian viscosity; none by default.
    #[inline(always)]
    fn viscosity(&self) -> Viscosity {
        Viscosity::NONE
    }

    /// ∂ψ/∂s over the numbers s of the strain, at a frozen history: P for F, −p for J \[Pa\]. By automatic differentiation unless overridden.
    fn energy_gradient(&self, strain: &Self::Strain<f64>, history: &Self::History<f64>) -> Self::Strain<f64> {
        curvature::gradient(|direction| energy_along(self, strain, history, direction))
    }

    /// ∂²ψ/∂s², its eigenvalues replaced as `projection` says: what implicit steps need. By automatic differentiation unless overridden,
    /// which costs 45 evaluations of the energy.
    fn energy_curvature(
        &self,
        strain: &Self::Strain<f64>,
        history: &Self::History<f64>,
        projection: Projection,
    ) -> Curvature {
        let along = |direction: &[f64; MOST]| energy_along(self, strain, history, direction);
        curvature::curvature::<Self::Strain<f64>>(along, projection)
    }

    /// The strains on which the law is defined.
    fn domain(&self) -> Domain {
        Domain::PositiveVolume
    }

    /// One step of a material point: trial strain (I + h ∇v) F, return map, stress, viscous stress. Not meant to be overridden.
    #[inline(always)]
    fn advance<S: Scalar>(
        &self,
        strain: &Self::Strain<S>,
        history: &mut Self::History<S>,
        motion: &Motion<S>,
    ) -> (Self::Strain<S>, Stress<S>) {
        let increment = scaled(&motion.velocity_gradient, S::constant(motion.step));
        let (strain, mut stress) = self.return_map(&strain.advanced(&increment), history, motion.step);
        let viscosity = self.viscosity();
        if viscosity != Viscosity::NONE {
            let viscous = viscosity.kirchhoff(strain.volume_ratio(), &motion.velocity_gradient);
            stress.kirchhoff = sum(&stress.kirchhoff, &viscous);
        }
        (strain, stress)
    }

    /// Whether the trace of τ is finite for a state, of one lane, and why not if it is not.
    ///
    /// # Errors
    /// [`LawError::Inadmissible`] with J if the strain is not finite or outside the [`domain`](Self::domain);
    /// [`PointLawError::Overflow`] if it is inside and yet has no stress that `S` can represent.
    fn check_admissible<S: Scalar<Mask = bool> + Into<f64>>(
        &self,
        strain: &Self::Strain<S>,
        history: &Self::History<S>,
    ) -> Result<(), PointLawError> {
        if trace(&self.stress(strain, history).kirchhoff).is_finite() {
            return Ok(());
        }
        let finite = (0..<Self::Strain<S> as Numbers<S>>::COUNT).all(|k| strain.number(k).is_finite());
        let determinant = strain.volume_ratio().into();
        let inside = self.domain() == Domain::EveryDeformation || determinant > 0.0;
        if finite && inside {
            Err(PointLawError::Overflow { determinant })
        } else {
            Err(LawError::Inadmissible { determinant }.into())
        }
    }
}

/// ψ(s + t d) to second order in t.
fn energy_along<L: PointLaw + ?Sized>(
    law: &L,
    strain: &L::Strain<f64>,
    history: &L::History<f64>,
    direction: &[f64; MOST],
) -> Jet2<f64, 1> {
    let [t] = Jet2::variables([0.0]);
    let moved = L::Strain::from_numbers(|k| t.scale(direction[k]).offset(strain.number(k)));
    law.energy_density(&moved, &L::History::from_numbers(|k| Jet2::from_value(history.number(k))))
}

/// The history of virgin material: zeros.
#[inline(always)]
pub fn fresh_history<L: PointLaw, S: Scalar>() -> L::History<S> {
    L::History::from_numbers(|_| S::constant(0.0))
}
