//! Laws and deformation gradients that the tests run over.

use mechanics_core::law::{
    Domain, FixedCorotated, Hencky, Hyperelastic, Lame, Linear, NeoHookean, StVenantKirchhoff,
    StableNeoHookean,
};
use mechanics_core::tensor::{Mat3, Vec3};

/// λ and μ of the same order and of no special ratio.
pub(crate) fn lame() -> Lame {
    Lame::new(1.7, 0.9).unwrap()
}

/// What to do with each law.
pub(crate) trait Visit {
    fn visit<L: Hyperelastic>(&mut self, name: &str, law: &L);
}

pub(crate) fn each_law(visitor: &mut impl Visit) {
    each_law_of(lame(), visitor);
}

pub(crate) fn each_law_of(lame: Lame, visitor: &mut impl Visit) {
    visitor.visit("linear", &Linear::new(lame));
    visitor.visit("St. Venant-Kirchhoff", &StVenantKirchhoff::new(lame));
    visitor.visit("Hencky", &Hencky::new(lame));
    visitor.visit("fixed corotated", &FixedCorotated::new(lame));
    visitor.visit("neo-Hookean", &NeoHookean::new(lame));
    visitor.visit("stable neo-Hookean", &StableNeoHookean::new(lame));
}

/// splitmix64: small, fixed, good enough.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [−1, 1).
    pub(crate) fn uniform(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * 2.0_f64.powi(-52) - 1.0
    }

    pub(crate) fn matrix(&mut self) -> Mat3 {
        Mat3::from_fn(|_, _| self.uniform())
    }

    pub(crate) fn vector(&mut self) -> Vec3 {
        Vec3::from_fn(|_, _| self.uniform())
    }

    pub(crate) fn rotation(&mut self) -> Mat3 {
        nalgebra::Rotation3::new(self.vector() * 3.0).into_inner()
    }

    /// U diag(σ) Vᵀ with random rotations.
    pub(crate) fn with_stretches(&mut self, sigma: [f64; 3]) -> Mat3 {
        self.rotation() * Mat3::from_diagonal(&Vec3::from(sigma)) * self.rotation().transpose()
    }

    /// A deformation of moderate size: stretches in [0.3, 2].
    pub(crate) fn moderate(&mut self) -> Mat3 {
        let sigma = [0; 3].map(|_| 1.15 + 0.85 * self.uniform());
        self.with_stretches(sigma)
    }

    /// Any of the shapes that make trouble; number `kind` modulo 12.
    pub(crate) fn hard(&mut self, kind: usize) -> Mat3 {
        let u = 1.0 + 0.5 * self.uniform();
        let identity = Mat3::identity();
        match kind % 12 {
            0 => self.matrix() * 2.0,
            1 => self.with_stretches([u, u, -u]),
            2 => self.with_stretches([1.0, u, 0.0]),
            3 => self.with_stretches([u, 0.0, 0.0]),
            4 => self.with_stretches([u, u, u]),
            5 => self.matrix() * 1e6,
            6 => self.matrix() * 1e-6,
            7 => identity + self.matrix() * 1e-12,
            8 => self.with_stretches([u, u * (1.0 + 1e-9), 1.0 / u]),
            9 => self.with_stretches([2.0 * u, u, -1e-3 * u]),
            10 => self.with_stretches([1e3 * u, 1.0, 1e-3]),
            _ => self.moderate(),
        }
    }
}

/// The exact degenerate matrices that no random draw gives.
pub(crate) fn special() -> Vec<Mat3> {
    let diagonal = |a, b, c| Mat3::from_diagonal(&Vec3::new(a, b, c));
    vec![
        Mat3::identity(),
        Mat3::zeros(),
        diagonal(2.0, 2.0, 2.0),
        diagonal(2.0, 2.0, 0.5),
        diagonal(1.0, 1.0, -1.0),
        diagonal(-1.0, -1.0, -1.0),
        diagonal(1.0, 0.0, 0.0),
        diagonal(1.0, 1.0, 0.0),
        diagonal(1e6, 1e6, 1e6),
        diagonal(1e-6, 1e-6, 1e-6),
        Mat3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0),
        Mat3::from_element(1.0),
    ]
}

/// Whether the law is defined, with room to spare, at `f`.
pub(crate) fn defined<L: Hyperelastic>(law: &L, f: &Mat3) -> bool {
    law.domain() == Domain::EveryDeformation || f.determinant() > 1e-9 * f.norm().powi(3)
}
