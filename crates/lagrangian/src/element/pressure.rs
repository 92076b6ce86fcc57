//! Pressure on a surface.
//!
//! A pressure p inside a closed surface of volume V has the energy −p V. With the triangles (x₀, x₁, x₂), outward by the right
//! hand,
//!
//! - V = ⅙ Σ x₀ · (x₁ × x₂),
//! - ∂V/∂x₀ = ⅙ x₁ × x₂ and cyclic: around a vertex these add up to a third of the area vectors of its triangles, which is the
//!   consistent nodal force of a uniform pressure,
//! - ∂²V/∂x₀∂x₁ = −⅙ \[x₂\]ₓ and ∂²V/∂x₀∂x₂ = ⅙ \[x₁\]ₓ, and cyclic; the diagonal blocks vanish.
//!
//! The Hessian of a triangle has trace zero, so it is always indefinite; it is projected numerically (9×9). Coordinates are
//! taken relative to a point near the surface, which changes neither the sum of values nor that of derivatives but keeps a
//! triangle's share small, and with it what projection adds.
//!
//! On a surface with a border the forces of this energy at the border are not those of a pressure (which has no potential
//! then), so a border must be held: [`Border::Held`].
//!
//! # Reference
//! Schweizerhof, Ramm, *Displacement dependent pressure loads in nonlinear finite element analyses*, Computers and
//! Structures 18 (1984).

use super::error::{ElementError, check_points};
use super::load::Amplitude;
use mechanics_core::potential::{Changed, Potential, PotentialError, StepLimit};
use mechanics_core::projection::{Projection, project_symmetric};
use mechanics_core::sparse::Assembler;
use mechanics_core::stage::{Moment, Stage};
use mechanics_core::stencil::{LocalHessian, Stencil, StencilTerm};
use mechanics_core::tensor::{Mat3, Vec3};
use nalgebra::SMatrix;

/// What a surface under pressure may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Border {
    /// No border: every edge has two triangles.
    None,
    /// A border whose points do not move; forces on them mean nothing.
    Held,
}

/// Pressure on triangles: the energy is −p A(t) V \[J\].
#[derive(Debug)]
pub struct Pressure {
    term: StencilTerm<PressedTriangles, 3>,
    /// p \[Pa\].
    pressure: f64,
    amplitude: Amplitude,
}

impl Pressure {
    /// The pressure p \[Pa\], positive if it inflates, on `triangles` with their vertices at rest in `points` \[m\].
    ///
    /// # Errors
    /// [`ElementError`] names the edge at which the surface is not closed or not orientable, or the vertex that is wrong.
    pub fn new(
        name: impl Into<String>,
        pressure: f64,
        points: &[Vec3],
        triangles: Vec<[u32; 3]>,
        border: Border,
    ) -> Result<Self, ElementError> {
        check_points(points, &triangles)?;
        check_manifold(&triangles, border)?;
        if !pressure.is_finite() {
            return Err(ElementError::OutOfRange {
                quantity: "pressure",
                owner: "surface",
                index: 0,
                value: pressure,
                expected: "finite",
            });
        }
        let corners = triangles.as_flattened();
        let origin = corners.iter().map(|&i| points[i as usize]).sum::<Vec3>() / corners.len().max(1) as f64;
        let term = StencilTerm::new(name, PressedTriangles { pressure, origin }, triangles)?;
        Ok(Self { term, pressure, amplitude: Amplitude::Constant })
    }

    /// The same with an amplitude over time.
    pub fn with_amplitude(mut self, amplitude: Amplitude) -> Self {
        self.term.stencil_mut().pressure = self.pressure * amplitude.at(0.0);
        Self { amplitude, ..self }
    }
}

impl Potential for Pressure {
    fn name(&self) -> &str {
        self.term.name()
    }

    fn value(&self, x: &[Vec3]) -> f64 {
        self.term.value(x)
    }

    fn add_gradient(&self, x: &[Vec3], gradient: &mut [Vec3]) {
        self.term.add_gradient(x, gradient);
    }

    fn add_hessian(&self, x: &[Vec3], projection: Projection, hessian: &mut Assembler<'_>) {
        self.term.add_hessian(x, projection, hessian);
    }

    fn freeze(&mut self, stage: &Stage<'_>) -> Result<Changed, PotentialError> {
        if stage.moment != Moment::Step {
            return Ok(Changed::Nothing);
        }
        self.amplitude.check(self.term.name())?;
        self.term.stencil_mut().pressure = self.pressure * self.amplitude.at(stage.time);
        Ok(Changed::Energy)
    }

    fn limit_step(&mut self, x: &[Vec3], p: &[Vec3]) -> Result<StepLimit, PotentialError> {
        self.term.limit_step(x, p)
    }

    fn locate(&self, x: &[Vec3], point: usize) -> Option<usize> {
        self.term.locate(x, point)
    }

    fn diagnose(&self, x: &[Vec3]) -> Option<PotentialError> {
        self.term.diagnose(x)
    }
}

/// The triangles of a [`Pressure`].
#[derive(Clone, Debug)]
struct PressedTriangles {
    /// p A(t) \[Pa\].
    pressure: f64,
    /// What coordinates are relative to \[m\].
    origin: Vec3,
}

impl PressedTriangles {
    fn relative(&self, x: &[Vec3; 3]) -> [Vec3; 3] {
        x.map(|x| x - self.origin)
    }
}

impl Stencil<3> for PressedTriangles {
    fn value(&self, _: usize, x: &[Vec3; 3]) -> f64 {
        let [a, b, c] = self.relative(x);
        -self.pressure / 6.0 * a.dot(&b.cross(&c))
    }

    fn gradient(&self, _: usize, x: &[Vec3; 3]) -> [Vec3; 3] {
        let [a, b, c] = self.relative(x);
        [b.cross(&c), c.cross(&a), a.cross(&b)].map(|area| area * (-self.pressure / 6.0))
    }

    fn hessian(&self, _: usize, x: &[Vec3; 3], projection: Projection) -> LocalHessian<3> {
        // Below the diagonal: blocks (1, 0), (2, 1) and (2, 0) of −p times the second derivatives of V.
        let [a, b, c] = self.relative(x).map(|x| x.cross_matrix() * (self.pressure / 6.0));
        let zero = Mat3::zeros();
        let hessian = [[zero, c, -b], [-c, zero, a], [b, -a, zero]];
        if projection == Projection::None {
            return hessian;
        }
        let whole: SMatrix<f64, 9, 9> = SMatrix::from_fn(|r, c| hessian[r / 3][c / 3][(r % 3, c % 3)]);
        let projected = project_symmetric(&whole, projection);
        std::array::from_fn(|i| std::array::from_fn(|j| projected.fixed_view::<3, 3>(3 * i, 3 * j).into()))
    }
}

/// Every edge is crossed once forwards and once backwards; where there may be a border, once in either direction will do.
fn check_manifold(triangles: &[[u32; 3]], border: Border) -> Result<(), ElementError> {
    let directed = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let mut edges: Vec<[u32; 2]> = directed.collect();
    edges.sort_unstable();
    let count = |edge: [u32; 2]| {
        edges.partition_point(|other| *other <= edge) - edges.partition_point(|other| *other < edge)
    };
    for &[from, to] in &edges {
        let (forward, backward) = (count([from, to]), count([to, from]));
        let open = border == Border::Held && backward == 0;
        if forward != 1 || (backward != 1 && !open) {
            return Err(ElementError::NotClosed { from, to, forward, backward });
        }
    }
    Ok(())
}
