//! The angle that two frames carried along with their edges open between them.
//!
//! Carry a frame along on an edge whose unit tangent moves from a to t, by the rotation about a × t that takes a to t and turns
//! nothing about t (parallel transport along the great circle). Two neighbouring edges with tangents a₀, a₁ → t₀, t₁ carry
//! two frames. The twist of the second against the first, measured by parallel transport from t₀ to t₁, then changes by what transport
//! round the quadrilateral t₁ → t₀ → a₀ → a₁ → t₁ of the unit sphere turns a vector by: by its signed area (Gauss and
//! Bonnet), with the diagonal a₀ t₁
//!
//! - A = Ω(a₀, t₁, t₀) + Ω(a₀, a₁, t₁),
//! - Ω(a, b, c) = 2 atan2(N, D), N = a·(b × c), D = 1 + a·b + b·c + c·a (van Oosterom, Strackee 1983),
//!
//! Ω the area of a triangle, positive if a, b, c run counter-clockwise seen from outside. So no frame need be stored:
//! the tangents and the twist at one moment tell the twist at another. A triangle of which D ≤ 0 covers a quarter of the sphere or
//! more (in a plane: its corners span 180° or more); the sum of two atan2 is then ambiguous, and so A is `None`.
//!
//! Derivatives by t₁ and t₀, with f = 2 atan2(N, D), S = N² + D² and N, D linear in each vector:
//!
//! - ∂ₛf = 2 (D ∂ₛN − N ∂ₛD)/S,
//! - ∂ₛ∂ᵤf = 2 (∂ᵤD ∂ₛN + D ∂ₛ∂ᵤN − ∂ᵤN ∂ₛD − N ∂ₛ∂ᵤD)/S − ∂ₛf (2N ∂ᵤN + 2D ∂ᵤD)/S.
//!
//! By the edge e = |e| t of which t is the direction, with P = 1 − t⊗t and f's derivatives g, H by t:
//!
//! - ∂f/∂e = P g/|e|,
//! - ∂²f/∂e² = (P H P − Pg⊗t − t⊗Pg − (t·g) P)/|e|²,  ∂²f/∂e₀∂e₁ = P₀ H₀₁ P₁/(|e₀||e₁|).
//!
//! At tᵢ = aᵢ the first is κb/(2|eᵢ|) for both edges, κb = 2 t₀ × t₁/(1 + t₀·t₁) (Bergou et al. 2008, equation 9).
//!
//! # Reference
//! A. van Oosterom, J. Strackee, *The solid angle of a plane triangle*, IEEE Trans. Biomed. Eng. 30, 1983; M. Bergou,
//! B. Audoly, E. Vouga, M. Wardetzky, E. Grinspun, *Discrete viscous threads*, ACM Trans. Graph. 29(4), 2010, section 4 (frames
//! carried in time).

use mechanics_core::tensor::{Mat3, Vec3};

/// N and D of a spherical triangle.
struct Triangle {
    numerator: f64,
    denominator: f64,
}

impl Triangle {
    /// N = a·(b × c) is exactly zero where b and c are the same.
    fn new(a: &Vec3, b: &Vec3, c: &Vec3) -> Self {
        Self { numerator: a.dot(&b.cross(c)), denominator: 1.0 + a.dot(b) + b.dot(c) + c.dot(a) }
    }

    fn area(&self) -> Option<f64> {
        (self.denominator > 0.0).then(|| 2.0 * self.numerator.atan2(self.denominator))
    }

    /// ∂ₛf from ∂ₛN and ∂ₛD.
    fn slope(&self, n: &Vec3, d: &Vec3) -> Vec3 {
        (n * self.denominator - d * self.numerator) * (2.0 / self.square())
    }

    /// ∂ₛ∂ᵤf from [∂ₛN, ∂ₛD], [∂ᵤN, ∂ᵤD] and [∂ₛ∂ᵤN, ∂ₛ∂ᵤD].
    fn curvature(&self, s: [&Vec3; 2], u: [&Vec3; 2], mixed: [&Mat3; 2]) -> Mat3 {
        let Self { numerator, denominator } = *self;
        let first =
            s[0] * u[1].transpose() - s[1] * u[0].transpose() + mixed[0] * denominator - mixed[1] * numerator;
        let change = (u[0] * numerator + u[1] * denominator) * (2.0 / self.square());
        first * (2.0 / self.square()) - self.slope(s[0], s[1]) * change.transpose()
    }

    fn square(&self) -> f64 {
        self.numerator.powi(2) + self.denominator.powi(2)
    }
}

/// A from the tangents `a` to the tangents `t` \[rad\]; exactly zero if they are the same.
pub(super) fn swept_angle(a: &[Vec3; 2], t: &[Vec3; 2]) -> Option<f64> {
    // The same area as Ω(a₀, t₁, t₀), with the equal pair last.
    let one = Triangle::new(&t[1], &t[0], &a[0]).area()?;
    Some(one + Triangle::new(&a[0], &a[1], &t[1]).area()?)
}

/// ∂A/∂e₀, ∂A/∂e₁, and the blocks (0, 0), (1, 0), (1, 1) of ∂²A/∂e².
pub(super) struct SweptDerivatives {
    pub(super) gradient: [Vec3; 2],
    pub(super) hessian: [Mat3; 3],
}

/// The derivatives of [`swept_angle`] by two edges of the directions `t` and these lengths.
pub(super) fn swept_derivatives(a: &[Vec3; 2], t: &[Vec3; 2], lengths: [f64; 2]) -> SweptDerivatives {
    let zero = Mat3::zeros();
    let one = Triangle::new(&t[1], &t[0], &a[0]);
    let (n0, d0) = (a[0].cross(&t[1]), t[1] + a[0]);
    let (n1, d1) = (t[0].cross(&a[0]), a[0] + t[0]);
    let two = Triangle::new(&a[0], &a[1], &t[1]);
    let (n2, d2) = (a[0].cross(&a[1]), a[0] + a[1]);

    let by_t0 = one.slope(&n0, &d0);
    let by_t1 = one.slope(&n1, &d1) + two.slope(&n2, &d2);
    let h00 = one.curvature([&n0, &d0], [&n0, &d0], [&zero, &zero]);
    // ∂(t₀ × a₀)/∂t₀ = −[a₀]×.
    let h10 = one.curvature([&n1, &d1], [&n0, &d0], [&-a[0].cross_matrix(), &Mat3::identity()]);
    let h11 = one.curvature([&n1, &d1], [&n1, &d1], [&zero, &zero])
        + two.curvature([&n2, &d2], [&n2, &d2], [&zero, &zero]);

    let [p0, p1] = t.map(|t| Mat3::identity() - t * t.transpose());
    let own = |h: Mat3, g: Vec3, t: Vec3, p: Mat3, length: f64| {
        let mixed = p * g * t.transpose();
        (p * h * p - mixed - mixed.transpose() - p * t.dot(&g)) / (length * length)
    };
    SweptDerivatives {
        gradient: [p0 * by_t0 / lengths[0], p1 * by_t1 / lengths[1]],
        hessian: [
            own(h00, by_t0, t[0], p0, lengths[0]),
            p1 * h10 * p0 / (lengths[0] * lengths[1]),
            own(h11, by_t1, t[1], p1, lengths[1]),
        ],
    }
}
