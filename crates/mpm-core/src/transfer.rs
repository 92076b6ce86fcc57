//! How velocities travel between particles and nodes.

use crate::Kernel;

/// What a particle carries to the grid and takes back.
///
/// | transfer | to the grid | back | force on node i |
/// |---|---|---|---|
/// | PIC | v | Σ w v | −V₀ τ ∇wᵢ |
/// | FLIP | v | v + Σ w Δv | −V₀ τ ∇wᵢ |
/// | APIC | v + C (xᵢ − x) | Σ w v and C = Σ w v (xᵢ − x)ᵀ D⁻¹ | −V₀ τ ∇wᵢ |
/// | MLS-APIC | the same | the same; C is the velocity gradient | −V₀ τ D⁻¹ w (xᵢ − x) |
///
/// D = Σ w (xᵢ − x)(xᵢ − x)ᵀ is Δx²/4 for quadratic and Δx²/3 for cubic kernels. Every variant moves particles with Σ w v. PIC
/// forgets rotation, FLIP keeps noise that the grid cannot see, APIC keeps angular momentum to round-off.
///
/// # Reference
/// C. Jiang, C. Schroeder, J. Teran, *An angular momentum conserving affine-particle-in-cell method*, J. Comput. Phys. 338, 2017;
/// Y. Hu et al., *A moving least squares material point method*, ACM Trans. Graph. 37(4), 2018; C. Fu et al., *A polynomial
/// particle-in-cell method*, ACM Trans. Graph. 36(6), 2017, for RPIC as its rigid part.
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
    /// The affine velocity field around the particle, `damping` = 0; RPIC, its rotation alone, `damping` = 1.
    Apic {
        /// How much of the symmetric part of C is taken away, 0 to 1.
        damping: f64,
    },
    /// APIC whose forces and velocity gradients are those of moving least squares: half the work.
    #[default]
    MlsApic,
}

impl Transfer {
    /// APIC without damping.
    pub const APIC: Self = Self::Apic { damping: 0.0 };
    /// FLIP without PIC.
    pub const FLIP: Self = Self::Flip { flip: 1.0 };

    /// Whether forces come from true gradients of the weights.
    pub(crate) fn uses_gradients(self) -> bool {
        self != Self::MlsApic
    }

    /// Whether C is carried to the grid, with how much of its symmetric part.
    pub(crate) fn affine_part(self) -> Option<f64> {
        match self {
            Self::Pic | Self::Flip { .. } => None,
            Self::Apic { damping } => Some(1.0 - damping),
            Self::MlsApic => Some(1.0),
        }
    }

    /// FLIP's part, if any.
    pub(crate) fn flip_part(self) -> Option<f64> {
        match self {
            Self::Flip { flip } if flip > 0.0 => Some(flip),
            _ => None,
        }
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
