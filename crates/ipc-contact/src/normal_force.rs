//! What a contact pushes with: all that friction reads of contact, and what sensors read.

use mechanics_core::tensor::Vec3;

/// The normal force of one active pair.
///
/// The points xᵢ of the pair (one against a half-space, two to four else) have weights wᵢ with d n = Σ wᵢ xᵢ (less the plane's own
/// position for a half-space): n is the unit vector from the second closest point to the first, d their distance, and the
/// weights are the barycentric coordinates of the closest points, positive on the first feature and negative on the second.
/// By the envelope theorem ∂d/∂xᵢ = wᵢ n, so the pair pushes point i with the force λ wᵢ n, λ = −∂E/∂d. The relative velocity
/// that friction opposes is Σ wᵢ ẋᵢ, less its part along n.
///
/// **Nearly parallel edges.** Their energy is m(x) κ b(d) with a mollifier m ≤ 1; λ = −m κ ∂b/∂d is the part along the normal,
/// and vanishes with m. The mollifier's own gradient, κ b ∇m, is in the forces of the points but in no normal force.
///
/// **Negative weights.** The area-weighted barrier takes away with a negative weight what it would else count twice where
/// features meet. λ is negative there. It is to be used with its sign: only the sum over the pairs that share a closest point is the
/// contact force of that place, and it is not negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalForce {
    points: [u32; 4],
    weights: [f64; 4],
    count: usize,
    /// Unit vector n, along which the first feature is pushed.
    pub normal: Vec3,
    /// Distance d of the closest points \[m\].
    pub distance: f64,
    /// λ = −∂E/∂d \[N\].
    pub magnitude: f64,
}

impl NormalForce {
    /// The force λ along n on points with these weights.
    ///
    /// # Panics
    /// If there are no points or more than four.
    pub fn new<const N: usize>(
        points: [u32; N],
        weights: [f64; N],
        normal: Vec3,
        distance: f64,
        magnitude: f64,
    ) -> Self {
        const { assert!(N > 0 && N <= 4, "a pair has one to four points") };
        let mut force = Self { points: [0; 4], weights: [0.0; 4], count: N, normal, distance, magnitude };
        force.points[..N].copy_from_slice(&points);
        force.weights[..N].copy_from_slice(&weights);
        force
    }

    /// The points, those of the first feature first.
    pub fn points(&self) -> &[u32] {
        &self.points[..self.count]
    }

    /// Their weights.
    pub fn weights(&self) -> &[f64] {
        &self.weights[..self.count]
    }

    /// The force λ wᵢ n on each point \[N\].
    pub fn forces(&self) -> impl Iterator<Item = (u32, Vec3)> {
        let push = self.normal * self.magnitude;
        self.points().iter().zip(self.weights()).map(move |(&point, &weight)| (point, push * weight))
    }
}

/// What contact does to a patch of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchForce {
    /// The whole force \[N\].
    pub force: Vec3,
    /// The area vector N of the patch at the positions asked about \[m²\]: Σ ½ (b − a) × (c − a) over its triangles.
    pub area_vector: Vec3,
    /// Mean pressure −F·N / N·N \[Pa\], positive where contact pushes against the outside; zero for a patch without area
    /// vector (a closed surface).
    pub pressure: f64,
}

impl PatchForce {
    pub(crate) fn new(force: Vec3, area_vector: Vec3) -> Self {
        let square = area_vector.norm_squared();
        let pressure = if square > 0.0 { -force.dot(&area_vector) / square } else { 0.0 };
        Self { force, area_vector, pressure }
    }
}
