//! Sliding bases: the tangent plane of a pair, and its relative velocity in it.
//!
//! Every pair has closest points Σ wᵢ xᵢ apart, with weights that are positive on the first feature and negative on the second,
//! and a unit normal n along that gap (from [`NormalForce`]). Its relative velocity is Σ wᵢ vᵢ, whatever kind of pair it is; what
//! slides is the part u = Tᵀ Σ wᵢ vᵢ in the plane across n, T = [t₁ t₂] with orthonormal columns. In the paper's notation
//! T(x) = (w ⊗ I₃) T, with 3N rows. So one rule makes the bases of all kinds:
//!
//! | pair | weights w | n |
//! |---|---|---|
//! | point, half-space | 1 | the plane's |
//! | point, point | 1, −1 | along x₀ − x₁ |
//! | point, edge | 1, −(1 − α), −α | across the edge, to the point |
//! | point, triangle | 1, −(1 − α − β), −α, −β | across the triangle, to the point |
//! | edge, edge | 1 − α, α, −(1 − β), −β | across both edges |
//! | particle, sphere | 1 | from the centre; the velocity less that of the surface, see [`sphere_surface_velocity`] |
//!
//! Any other T of the plane is T Q with a rotation or reflection Q, and u becomes Qᵀ u: its length, and so the smoothed law's energy, is the
//! same. The energy knows T only through T Tᵀ = I − n nᵀ, which is what [`crate::pair`] computes with. The columns are
//! for reading: [`SlidingBasis`] picks them by a fixed rule, so that they are the same from run to run.

use ipc_contact::normal_force::NormalForce;
use mechanics_core::tensor::Vec3;

/// An orthonormal basis t₁, t₂ of the plane across a unit normal n, with t₁ × t₂ = n.
///
/// t₁ is the part across n of the coordinate axis that has the smallest |component| of n (the first of equals), normalised; t₂ = n × t₁.
/// Deterministic, and continuous in n wherever that axis stays the same. Orthonormal to a few ε, because the axis has at most the
/// component 1/√3 along n.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlidingBasis {
    columns: [Vec3; 2],
}

impl SlidingBasis {
    /// The basis across the unit vector `normal`.
    pub fn across(normal: &Vec3) -> Self {
        let axis = normal.iamin();
        let first = (Vec3::ith(axis, 1.0) - normal * normal[axis]).normalize();
        Self { columns: [first, normal.cross(&first)] }
    }

    /// The basis of a pair of any kind.
    pub fn of_pair(pair: &NormalForce) -> Self {
        Self::across(&pair.normal)
    }

    /// The basis of a particle on a sphere. `None` if it is in the centre.
    pub fn on_sphere(particle: &Vec3, centre: &Vec3) -> Option<Self> {
        (particle - centre).try_normalize(0.0).map(|normal| Self::across(&normal))
    }

    /// t₁ and t₂.
    pub fn columns(&self) -> &[Vec3; 2] {
        &self.columns
    }

    /// Tᵀ v: the part of a vector in the plane.
    pub fn components(&self, v: &Vec3) -> [f64; 2] {
        self.columns.map(|column| column.dot(v))
    }

    /// T u: the vector with these components.
    pub fn vector(&self, u: [f64; 2]) -> Vec3 {
        self.columns[0] * u[0] + self.columns[1] * u[1]
    }
}

/// Σ wᵢ vᵢ: the velocity of the first closest point of a pair relative to the second.
///
/// # Panics
/// If a point of the pair has no velocity.
pub fn relative_velocity(pair: &NormalForce, velocity: &[Vec3]) -> Vec3 {
    pair.points().iter().zip(pair.weights()).map(|(&point, &weight)| velocity[point as usize] * weight).sum()
}

/// The velocity ċ + ω × (x − c) [m/s] of the surface of a sphere at x: what a particle there slides against.
pub fn sphere_surface_velocity(x: &Vec3, centre: &Vec3, velocity: &Vec3, angular_velocity: &Vec3) -> Vec3 {
    velocity + angular_velocity.cross(&(x - centre))
}
