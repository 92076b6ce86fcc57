//! Strain limiting: a barrier that keeps sheets from stretching beyond a bound.

use super::membrane::{Mat3x2, Principal, PrincipalStiffness, RestTriangle};
use super::thin_error::{ThinError, positive};
use mechanics_core::mesh::TriMesh;
use mechanics_core::potential::Demand;
use mechanics_core::projection::Projection;
use mechanics_core::stencil::{LocalHessian, Stencil, StencilTerm};
use mechanics_core::tensor::Vec3;

/// A barrier on both principal stretches of every triangle: W = κ (b(σ₁) + b(σ₂)) per rest volume, with
///
/// - b(σ) = −y² ln(1 − y),  y = (σ − ŝ)/(s − ŝ) for σ > ŝ, and zero below;
///
/// ŝ is where the barrier begins, s the limit that no stretch reaches, κ \[Pa\] its strength. Cloth that yields easily up to
/// a few per cent and then not at all is a soft membrane with this on top.
///
/// By y, b' = −2y ln(1 − y) + y²/(1 − y) and b'' = −2 ln(1 − y) + 4y/(1 − y) + y²/(1 − y)², both positive, and b is C² at
/// y = 0. In principal axes (compare the membrane's laws) W,₁₂ = 0; the eigenvalues of the stiffness are b''(σᵢ), the divided
/// difference (b'(σ₁) − b'(σ₂))/(σ₁ − σ₂), (b'(σ₁) + b'(σ₂))/(σ₁ + σ₂), and b'(σᵢ)/σᵢ: all positive or zero, so there is nothing
/// to project.
///
/// A step is limited so that no stretch reaches s: σ_max(F + α dF) is a maximum over unit vectors v of |(F + α dF) v|, hence
/// convex in α. Its crossing of s is bracketed from inside by chords, so what is answered never is too large.
///
/// # Reference
/// M. Li, D. M. Kaufman, C. Jiang, *Codimensional incremental potential contact*, ACM Trans. Graph. 40(4), 2021,
/// section 4 (the barrier; their form is per triangle with area and thickness as here).
#[derive(Clone, Debug)]
pub struct StrainLimits {
    begin: f64,
    limit: f64,
    strength: f64,
    thickness: f64,
    rest: Vec<RestTriangle>,
}

/// The part of the way to the limit that a step may go.
const STAY_INSIDE: f64 = 0.9;

impl StrainLimits {
    /// The triangles of `mesh`, at rest where they are: stretches `[ŝ, s]` with 1 ≤ ŝ < s, strength κ \[Pa\], thickness \[m\].
    ///
    /// # Errors
    /// A parameter out of range; a triangle without area.
    pub fn new(
        mesh: &TriMesh,
        [begin, limit]: [f64; 2],
        strength: f64,
        thickness: f64,
    ) -> Result<Self, ThinError> {
        if !(begin >= 1.0 && begin.is_finite()) {
            let expected = "at least 1, so that the rest shape is not loaded";
            return Err(ThinError::Parameter {
                parameter: "the stretch where the limit begins",
                value: begin,
                expected,
            });
        }
        if !(limit > begin && limit.is_finite()) {
            let expected = "larger than where the barrier begins";
            return Err(ThinError::Parameter { parameter: "the largest stretch", value: limit, expected });
        }
        let strength = positive("the strength of the strain limit", strength)?;
        let thickness = positive("the thickness", thickness)?;
        let rest =
            (0..mesh.triangles().len()).map(|t| RestTriangle::of(mesh, t)).collect::<Result<_, _>>()?;
        Ok(Self { begin, limit, strength, thickness, rest })
    }

    /// The sum over the triangles of `mesh`, as a term of the incremental potential.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn term(
        name: impl Into<String>,
        mesh: &TriMesh,
        stretches: [f64; 2],
        strength: f64,
        thickness: f64,
    ) -> Result<StencilTerm<Self, 3>, ThinError> {
        let stencil = Self::new(mesh, stretches, strength, thickness)?;
        Ok(StencilTerm::new(name, stencil, mesh.triangles().to_vec())?)
    }

    /// The larger principal stretch of a triangle with its corners at `x`.
    pub fn largest_stretch(&self, triangle: usize, x: &[Vec3; 3]) -> f64 {
        largest_stretch_squared(&self.rest[triangle].deformation_gradient(x)).sqrt()
    }

    /// κ b, κ b', κ b'' by σ.
    fn barrier(&self, stretch: f64) -> [f64; 3] {
        let range = self.limit - self.begin;
        let y = (stretch - self.begin) / range;
        if y <= 0.0 {
            return [0.0; 3];
        }
        if y >= 1.0 {
            return [f64::INFINITY; 3];
        }
        let (log, inverse) = ((-y).ln_1p(), 1.0 / (1.0 - y));
        let values = [
            -y * y * log,
            (-2.0 * y * log + y * y * inverse) / range,
            (-2.0 * log + 4.0 * y * inverse + (y * inverse).powi(2)) / (range * range),
        ];
        values.map(|value| value * self.strength)
    }

    fn volume(&self, triangle: usize) -> f64 {
        self.rest[triangle].area() * self.thickness
    }
}

/// σ_max² = ½ (C₁₁ + C₂₂) + √((½ (C₁₁ − C₂₂))² + C₁₂²).
fn largest_stretch_squared(f: &Mat3x2) -> f64 {
    let (a, b) = (f.column(0), f.column(1));
    0.5 * (a.norm_squared() + b.norm_squared()) + (0.5 * (a - b).dot(&(a + b))).hypot(a.dot(&b))
}

/// A fraction α ≤ 1 up to which σ_max(F + α dF) stays below `limit`, within 1 % of the largest such.
fn admissible_fraction(f: &Mat3x2, change: &Mat3x2, limit: f64) -> f64 {
    let excess = |fraction: f64| largest_stretch_squared(&(f + change * fraction)) - limit * limit;
    let (mut inside, mut outside) = ([0.0, excess(0.0)], [1.0, excess(1.0)]);
    if outside[1] < 0.0 {
        return 1.0;
    }
    if inside[1].is_nan() || inside[1] >= 0.0 {
        return 0.0;
    }
    while outside[0] - inside[0] > 0.01 * inside[0] && outside[0] > f64::MIN_POSITIVE {
        // The chord lies above the convex function: where it vanishes is inside.
        let chord = inside[0] + (outside[0] - inside[0]) * (inside[1] / (inside[1] - outside[1]));
        for fraction in [chord, 0.5 * (chord + outside[0])] {
            let value = excess(fraction);
            if value < 0.0 {
                inside = [fraction, value];
            } else {
                outside = [fraction, value];
            }
        }
    }
    inside[0]
}

impl Stencil<3> for StrainLimits {
    fn value(&self, element: usize, x: &[Vec3; 3]) -> f64 {
        let f = self.rest[element].deformation_gradient(x);
        if largest_stretch_squared(&f) <= self.begin * self.begin {
            return 0.0;
        }
        let [one, two] = Principal::of(&f).stretches.map(|stretch| self.barrier(stretch)[0]);
        self.volume(element) * (one + two)
    }

    fn gradient(&self, element: usize, x: &[Vec3; 3]) -> [Vec3; 3] {
        let rest = &self.rest[element];
        let f = rest.deformation_gradient(x);
        if largest_stretch_squared(&f) <= self.begin * self.begin {
            return [Vec3::zeros(); 3];
        }
        let Principal { stretches, left, right, .. } = Principal::of(&f);
        let mut stress = Mat3x2::zeros();
        for i in 0..2 {
            stress += left[i] * nalgebra::RowVector2::from(right[i]) * self.barrier(stretches[i])[1];
        }
        rest.forces(&(stress * self.volume(element)))
    }

    fn hessian(&self, element: usize, x: &[Vec3; 3], projection: Projection) -> LocalHessian<3> {
        let rest = &self.rest[element];
        let f = rest.deformation_gradient(x);
        if largest_stretch_squared(&f) <= self.begin * self.begin {
            return [[mechanics_core::tensor::Mat3::zeros(); 3]; 3];
        }
        let frame = Principal::of(&f);
        let [s1, s2] = frame.stretches;
        let [[_, first1, second1], [_, first2, second2]] =
            frame.stretches.map(|stretch| self.barrier(stretch));
        // Where the stretches nearly coincide, the divided difference is the derivative between them.
        let gap = s1 - s2;
        let near = gap <= 1e-6 * (self.limit - self.begin);
        let shear = if near { 0.5 * (second1 + second2) } else { (first1 - first2) / gap };
        let tension = |first: f64, stretch: f64| if first > 0.0 { first / stretch } else { 0.0 };
        let values = PrincipalStiffness {
            scaling: [second1, 0.0, second2],
            shear,
            rotation: (first1 + first2) / (s1 + s2),
            tilting: [tension(first1, s1), tension(first2, s2)],
        };
        rest.blocks(&(values.assembled(&frame, projection) * self.volume(element)))
    }

    fn demand(&self) -> Demand {
        Demand::EndPositions
    }

    fn limit_step(&self, element: usize, x: &[Vec3; 3], p: &[Vec3; 3]) -> f64 {
        let rest = &self.rest[element];
        let fraction =
            admissible_fraction(&rest.deformation_gradient(x), &rest.deformation_gradient(p), self.limit);
        if fraction >= 1.0 { 1.0 } else { STAY_INSIDE * fraction }
    }
}
