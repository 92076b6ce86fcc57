//! How stiff a material point is now: the number that limits the time step.

use mechanics_core::scalar::Scalar;

/// An upper bound on the stiffness of a material point in its present state, in the form of Lamé's parameters.
///
/// For every displacement gradient G of the present shape the energy per rest volume satisfies
///
/// d²/dt² ψ((I + t G) F) at t = 0  ≤  λ̂ tr²G + 2μ̂ ‖G‖²,
///
/// with ‖G‖ Frobenius' norm. At F = I it is an equality for symmetric G, with λ̂ = λ, μ̂ = μ: the bound is sharp at rest, and
/// grows with compression and stretch as each law derives it.
///
/// # What a grid code does with it
/// With ρ₀ the *rest* density and all lengths those of the present shape:
///
/// - waves travel with c ≤ √((max(λ̂, 0) + 2μ̂)/ρ₀) ([`wave_speed`](Self::wave_speed)), from G = a ⊗ n;
/// - a lone particle in a grid of d dimensions, whose neighbouring nodes carry its mass only, swings in volume with
///   ω² = (D⁻¹)(2μ̂ + d λ̂)/ρ₀, where D is the kernel's second moment (Δx²/4 for quadratic B-splines): [`uniform`](Self::uniform)`(d)`;
/// - an explicit step h is stable for ω h < 2; with viscous rates γ (see [`Viscosity`](crate::Viscosity)) for ω²h² + 2γh < 4.
///
/// Plastic flow only softens, so that the elastic bound holds for plastic laws.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StiffnessBound<S> {
    /// λ̂ \[Pa\] per rest volume; may be negative where λ is.
    pub lambda: S,
    /// μ̂ ≥ 0 \[Pa\] per rest volume.
    pub mu: S,
}

impl<S: Scalar> StiffnessBound<S> {
    /// max(λ̂, 0) + 2μ̂ \[Pa\], the largest modulus of plane waves: G = a ⊗ n has ‖G‖ = 1, tr²G ≤ 1.
    #[inline(always)]
    pub fn wave_modulus(&self) -> S {
        self.uniform(1)
    }

    /// d max(λ̂, 0) + 2μ̂ \[Pa\]: the largest modulus of any G in `dimension` directions, ‖G‖ = 1, tr²G ≤ d; taken by uniform expansion.
    #[inline(always)]
    pub fn uniform(&self, dimension: usize) -> S {
        let volumetric = self.lambda.max(S::constant(0.0)).scale(dimension as f64);
        self.mu.mul_add(S::constant(2.0), volumetric)
    }

    /// √((max(λ̂, 0) + 2μ̂)/ρ₀) [m/s] for the rest density ρ₀ [kg/m³]: no wave in the present shape is faster.
    #[inline(always)]
    pub fn wave_speed(&self, rest_density: S) -> S {
        (self.wave_modulus() / rest_density).sqrt()
    }
}
