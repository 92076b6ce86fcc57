//! How velocities travel between particles and nodes.

use crate::{Kernel, MpmError};

/// What a particle carries to the grid and takes back.
///
/// | transfer | to the grid | back | moves with | force on node i |
/// |---|---|---|---|---|
/// | PIC | v | Σ w v⁺ | Σ w v⁺ | −V₀ τ ∇wᵢ |
/// | FLIP | v | v + Σ w Δv | Σ w v⁺ | −V₀ τ ∇wᵢ |
/// | XPIC(m) | v, m times | Σ w v⁺ | Σ w v⁺ | −V₀ τ ∇wᵢ |
/// | APIC | v + C (xᵢ − x) | Σ w v⁺ and C = Σ w v⁺ (xᵢ − x)ᵀ D⁻¹ | Σ w v⁺ | −V₀ τ ∇wᵢ |
/// | MLS-APIC | the same | the same; C is the velocity gradient | Σ w v⁺ | −V₀ τ D⁻¹ w (xᵢ − x) |
/// | ASFLIP | v + C (xᵢ − x) | Σ w v⁺ + α d and C | Σ w v⁺ + γ α d | −V₀ τ ∇wᵢ |
///
/// v⁺ are the velocities of nodes at the end of the step, Δv their change in it, d = v − Σ w (v⁺ − Δv) what the grid could not carry of a
/// particle's velocity. D = Σ w (xᵢ − x)(xᵢ − x)ᵀ is Δx²/4 for quadratic and Δx²/3 for cubic kernels. PIC forgets rotation, FLIP keeps noise
/// that the grid cannot see, APIC keeps angular momentum to round-off, XPIC forgets the noise and less and less of the rest, ASFLIP lets
/// particles that part move apart.
///
/// # XPIC(m)
/// Let S interpolate nodes to particles, (Sv)ₚ = Σᵢ wᵢₚ vᵢ, and S⁺ average particles at nodes, (S⁺V)ᵢ = Σₚ wᵢₚ mₚ Vₚ/mᵢ. FLIP keeps
/// (I − SS⁺)V for ever; the part of it that no grid velocity can make is noise. XPIC(m) keeps only SS⁺ and its repetitions:
///
///   V ← S v* + h S a,   S v* = (I − (I − SS⁺)ᵐ) V.
///
/// The authors expand the power, v* = m Σᵣ (−1)ʳ⁺¹ vᵣ with v₁ = S⁺V, vᵣ = ((m − r + 1)/r) S⁺S vᵣ₋₁: terms of alternating sign that grow
/// like binomials. As I − (I − A)ᵐ = A Σⱼ₌₀ᵐ⁻¹ (I − A)ʲ, the same v* is the m-th of
///
///   u₁ = S⁺V,   uⱼ₊₁ = uⱼ + S⁺(V − S uⱼ),
///
/// Richardson's iteration: particles give what the grid does not yet return to them. Nothing cancels, and m costs m − 1 passes of gather
/// and scatter of velocities alone. S⁺S = M_L⁻¹M_C, of the lumped mass M_L and the consistent mass M_C = Σₚ mₚ wₚ wₚᵀ, so v* tends to the
/// velocities of the consistent mass. Rows of S⁺S are averages, and it is symmetric and semi-definite with respect to M_L: its eigenvalues λ
/// are in [0, 1]. Therefore
/// - m = 1 is PIC; m → ∞ is the projection of V on what the grid can make: FLIP without its noise;
/// - each pass keeps linear momentum: Σᵢ mᵢ (S⁺(V − Su))ᵢ = Σₚ mₚ Vₚ − Σᵢ mᵢ uᵢ, and Σₚ mₚ (Su)ₚ = Σᵢ mᵢ uᵢ;
/// - a mode of eigenvalue λ keeps 1 − (1 − λ)ᵐ of its velocity: never more than all of it, and more as m grows; kinetic energy never grows;
/// - so does angular momentum: of a rigid rotation ⟨ω×x, (I − SS⁺)ᵐ ω×x⟩ₘ is lost, which shrinks in every pass, and to zero.
///
/// The velocities after forces and boundaries, v⁺ = v* + h a, are those with which particles move, deform and go on: one field for all
/// three, so that F stays the gradient of the motion. With K the stiffness, grid and strains then follow v⁺ ← Φv⁺ − h M_L⁻¹K u, u ← u + h v⁺,
/// Φ = I − (I − S⁺S)ᵐ: stable for h²ω² < 2(1 + φ), which is at least 2 and tends to the 4 of undamped symplectic Euler. (The paper moves particles
/// with velocities of first order and corrects them to second; of first order in h are the steps here.)
///
/// # ASFLIP
/// APIC keeps the affine field around a particle and loses the rest of d, and particles that are moved by the grid's one velocity cannot leave each
/// other. ASFLIP gives d back to the velocity (α) and, where matter is not under compression, to the motion (γ): particles then move with their
/// own velocities. Under compression, J (1 + h tr ∇v) < 0.999, γ is zero, else bodies would run into each other. Linear momentum is kept, because
/// Σₚ mₚ dₚ = 0. Angular momentum changes in a step by α Σₚ mₚ D ε:(C⁰ − C) + h Σₚ mₚ (α − γα) Σ w v⁺ × d, C⁰ the affine velocities that
/// the grid had before forces and C those of the particles: not exact, but small where C⁰ is what particles brought. A particle's own motion is not stopped
/// by boundaries, only that of nodes is.
///
/// # Reference
/// C. Jiang, C. Schroeder, J. Teran, *An angular momentum conserving affine-particle-in-cell method*, J. Comput. Phys. 338, 2017;
/// Y. Hu et al., *A moving least squares material point method*, ACM Trans. Graph. 37(4), 2018; C. Fu et al., *A polynomial
/// particle-in-cell method*, ACM Trans. Graph. 36(6), 2017, for RPIC as its rigid part; C. C. Hammerquist, J. A. Nairn, *A new method for material
/// point method particle updates that reduces noise and enhances stability*, Comput. Methods Appl. Mech. Engrg. 318, 2017; Y. Fei et al.,
/// *Revisiting integration in the material point method*, ACM Trans. Graph. 40(4), 2021.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[non_exhaustive]
pub enum Transfer {
    /// Velocities alone.
    Pic,
    /// Changes of velocities, blended with PIC: `flip` = 1 is FLIP, 0 is PIC; 0.95 to 0.99 are usual.
    Flip {
        /// FLIP's part, 0 to 1.
        flip: f64,
    },
    /// Velocities of which all is kept that `order` passes to the grid and back can find there: PIC for 1, FLIP without its noise for many. 2 to 5 are
    /// usual.
    Xpic {
        /// m, from 1 on.
        order: u32,
    },
    /// The affine velocity field around the particle, `damping` = 0; RPIC, its rotation alone, `damping` = 1.
    Apic {
        /// How much of the symmetric part of C is taken away, 0 to 1.
        damping: f64,
    },
    /// APIC whose forces and velocity gradients are those of moving least squares: half the work.
    #[default]
    MlsApic,
    /// APIC that gives particles back what the grid took: for matter that comes apart. Both zero is APIC; `position` = 0 is AFLIP.
    Asflip {
        /// α, the part of d that velocities keep, 0 to 1; 0.97 to 0.99 are usual.
        flip: f64,
        /// γ, the part of what velocities keep with which particles also move, where they are not under compression; 0 to 1.
        position: f64,
    },
}

impl Transfer {
    /// APIC without damping.
    pub const APIC: Self = Self::Apic { damping: 0.0 };
    /// FLIP without PIC.
    pub const FLIP: Self = Self::Flip { flip: 1.0 };
    /// ASFLIP with the coefficients of its authors.
    pub const ASFLIP: Self = Self::Asflip { flip: 0.99, position: 1.0 };

    /// Confirms that the coefficients are in their ranges.
    pub(crate) fn check(self) -> Result<(), MpmError> {
        let parts = match self {
            Self::Flip { flip } => [("FLIP's part", flip), ("", 0.0)],
            Self::Apic { damping } => [("the damping of APIC", damping), ("", 0.0)],
            Self::Asflip { flip, position } => {
                [("ASFLIP's part of velocities", flip), ("ASFLIP's part of positions", position)]
            }
            Self::Xpic { order: 0 } => return Err(MpmError::Order),
            Self::Pic | Self::Xpic { .. } | Self::MlsApic => return Ok(()),
        };
        match parts.into_iter().find(|(_, value)| !(0.0..=1.0).contains(value)) {
            Some((what, value)) => Err(MpmError::Part { what, value }),
            None => Ok(()),
        }
    }

    /// Whether forces come from true gradients of the weights.
    pub(crate) fn uses_gradients(self) -> bool {
        self != Self::MlsApic
    }

    /// Whether C is carried to the grid, with how much of its symmetric part.
    pub(crate) fn affine_part(self) -> Option<f64> {
        match self {
            Self::Pic | Self::Flip { .. } | Self::Xpic { .. } => None,
            Self::Apic { damping } => Some(1.0 - damping),
            Self::MlsApic | Self::Asflip { .. } => Some(1.0),
        }
    }

    /// FLIP's part, if any.
    pub(crate) fn flip_part(self) -> Option<f64> {
        match self {
            Self::Flip { flip } | Self::Asflip { flip, .. } if flip > 0.0 => Some(flip),
            _ => None,
        }
    }

    /// The part of what velocities keep with which particles also move, if any.
    pub(crate) fn position_part(self) -> Option<f64> {
        match self {
            Self::Asflip { flip, position } if flip > 0.0 && position > 0.0 => Some(position),
            _ => None,
        }
    }

    /// Passes to the grid and back beyond the first.
    pub(crate) fn passes(self) -> u32 {
        match self {
            Self::Xpic { order } => order.saturating_sub(1),
            _ => 0,
        }
    }

    /// Whether nodes keep impulses apart from the momenta before them.
    pub(crate) fn keeps_impulses(self) -> bool {
        self.flip_part().is_some() || self.passes() > 0
    }

    /// sup Σ (∂wᵢ)²/wᵢ over positions \[1/cell²\], or D⁻¹ for moving least squares: with it, ω² ≤ this · (2μ̂ + d λ̂)/(ρ₀ Δx²) bounds the
    /// frequencies that one particle alone can make.
    ///
    /// Quadratic: 4 at a node, 6 in the limit half a cell from it. Cubic: 3 at nodes, 72/23 between them. Linear: 1/(f(1 − f)), without
    /// bound (a node that is hardly touched is hardly heavy); a quarter of a cell from a node is taken.
    pub(crate) fn stiffness_factor(self, kernel: Kernel) -> f64 {
        match (kernel, self.uses_gradients()) {
            (Kernel::Linear, _) => 16.0 / 3.0,
            (Kernel::Quadratic, false) => 4.0,
            (Kernel::Quadratic, true) => 6.0,
            (Kernel::Cubic, false) => 3.0,
            (Kernel::Cubic, true) => 72.0 / 23.0,
        }
    }
}
