//! Damping as terms of the incremental potential.
//!
//! A rate potential R(v) = ½ vᵀ C v gives the force −C v. Every scheme reads the velocity as v = a(x − x̂), so
//!
//! - D(x) = R(v(x))/a = ½ a (x − x̂)ᵀ C (x − x̂)
//!
//! has the gradient C v: damping becomes an energy. C is positive semi-definite and kept over a step, so D is convex. Rayleigh's
//! C = αM + βK is the sum of [`MassDamping`] and a [`DampingTerm`] of [`StiffnessDamping`], K being the projected
//! stiffness at the start of the step. An oscillator of frequency ω is damped at the ratio ζ = α/(2ω) + βω/2.
//!
//! In statics there is no velocity and no damping.
//!
//! # Reference
//! Rayleigh, *The Theory of Sound*, 1877, section 102; the potential of a step as in Kane, Marsden, Ortiz, West, *Variational
//! integrators and the Newmark algorithm for conservative and dissipative mechanical systems*, IJNME 49 (2000).

use super::error::{ElementError, check_not_negative};
use super::inertia::MassNorm;
use super::mass::Mass;
use mechanics_core::parallel;
use mechanics_core::potential::{Changed, Potential, PotentialError};
use mechanics_core::projection::Projection;
use mechanics_core::sparse::Assembler;
use mechanics_core::stage::{Moment, Stage};
use mechanics_core::stencil::{LocalHessian, Stencil, StencilTerm};
use mechanics_core::tensor::{Mat3, Vec3};

/// Elements whose matrices are made by one task.
const CHUNK: usize = 128;

/// A family of elements that dissipate: their damping matrices.
pub trait Dissipation<const N: usize>: Send + Sync {
    /// C of `element` with its points at `x` [N s/m]: symmetric and positive semi-definite, the whole matrix.
    fn damping(&self, element: usize, x: &[Vec3; N]) -> LocalHessian<N>;
}

/// Damping in proportion to stiffness: C = β K, K the Hessian of a stencil, its negative eigenvalues clamped.
#[derive(Clone, Debug)]
pub struct StiffnessDamping<S> {
    stencil: S,
    /// β \[s\].
    coefficient: f64,
}

impl<S> StiffnessDamping<S> {
    /// β ≥ 0 \[s\] times the stiffness of `stencil`.
    ///
    /// # Errors
    /// [`ElementError::OutOfRange`] if β is negative or not finite.
    pub fn new(stencil: S, coefficient: f64) -> Result<Self, ElementError> {
        check_not_negative("coefficient", "damping", 0, coefficient)?;
        Ok(Self { stencil, coefficient })
    }
}

impl<S: Stencil<N>, const N: usize> Dissipation<N> for StiffnessDamping<S> {
    fn damping(&self, element: usize, x: &[Vec3; N]) -> LocalHessian<N> {
        let lower = self.stencil.hessian(element, x, Projection::Clamp);
        let mut damping = [[Mat3::zeros(); N]; N];
        for i in 0..N {
            for j in 0..=i {
                damping[i][j] = lower[i][j] * self.coefficient;
                damping[j][i] = damping[i][j].transpose();
            }
        }
        damping
    }
}

/// The damping of a list of elements: ½ a (x − x̂)ᵀ C (x − x̂) \[J\], C kept over a step.
#[derive(Debug)]
pub struct DampingTerm<D, const N: usize> {
    dissipation: D,
    term: StencilTerm<KeptDamping<N>, N>,
}

impl<D: Dissipation<N>, const N: usize> DampingTerm<D, N> {
    /// The damping of `dissipation` over `elements`, without effect until a step begins.
    ///
    /// # Errors
    /// If an element names a point twice.
    pub fn new(
        name: impl Into<String>,
        dissipation: D,
        elements: Vec<[u32; N]>,
    ) -> Result<Self, ElementError> {
        let kept = KeptDamping {
            factor: 0.0,
            origins: vec![[Vec3::zeros(); N]; elements.len()],
            matrices: vec![[[Mat3::zeros(); N]; N]; elements.len()],
        };
        Ok(Self { dissipation, term: StencilTerm::new(name, kept, elements)? })
    }
}

impl<D: Dissipation<N>, const N: usize> Potential for DampingTerm<D, N> {
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
        let Self { dissipation, term } = self;
        let elements = term.elements().to_vec();
        let kept = term.stencil_mut();
        kept.factor = if stage.step > 0.0 { stage.scheme.coefficients.velocity } else { 0.0 };
        for (origin, element) in kept.origins.iter_mut().zip(&elements) {
            *origin = element.map(|i| stage.scheme.velocity_origin[i as usize]);
        }
        parallel::map_into(&mut kept.matrices, CHUNK, |e| {
            dissipation.damping(e, &elements[e].map(|i| stage.x[i as usize]))
        });
        Ok(Changed::Energy)
    }

    fn locate(&self, x: &[Vec3], point: usize) -> Option<usize> {
        self.term.locate(x, point)
    }

    fn diagnose(&self, x: &[Vec3]) -> Option<PotentialError> {
        self.term.diagnose(x)
    }
}

/// Quadratic energies of elements, kept over a step.
#[derive(Debug)]
struct KeptDamping<const N: usize> {
    /// a [1/s].
    factor: f64,
    /// x̂ of each element's points.
    origins: Vec<[Vec3; N]>,
    /// C of each element.
    matrices: Vec<LocalHessian<N>>,
}

impl<const N: usize> KeptDamping<N> {
    /// C (x − x̂).
    fn product(&self, element: usize, offsets: &[Vec3; N]) -> [Vec3; N] {
        let matrix = &self.matrices[element];
        std::array::from_fn(|i| (0..N).map(|j| matrix[i][j] * offsets[j]).sum())
    }

    fn offsets(&self, element: usize, x: &[Vec3; N]) -> [Vec3; N] {
        std::array::from_fn(|i| x[i] - self.origins[element][i])
    }
}

impl<const N: usize> Stencil<N> for KeptDamping<N> {
    fn value(&self, element: usize, x: &[Vec3; N]) -> f64 {
        let offsets = self.offsets(element, x);
        let product = self.product(element, &offsets);
        0.5 * self.factor * offsets.iter().zip(&product).map(|(a, b)| a.dot(b)).sum::<f64>()
    }

    fn gradient(&self, element: usize, x: &[Vec3; N]) -> [Vec3; N] {
        self.product(element, &self.offsets(element, x)).map(|force| force * self.factor)
    }

    fn hessian(&self, element: usize, _: &[Vec3; N], _: Projection) -> LocalHessian<N> {
        self.matrices[element].map(|row| row.map(|block| block * self.factor))
    }
}

/// Damping in proportion to mass: ½ α a ‖x − x̂‖²_M \[J\].
#[derive(Clone, Debug)]
pub struct MassDamping {
    norm: MassNorm,
    /// α [1/s].
    coefficient: f64,
}

impl MassDamping {
    /// α ≥ 0 [1/s] times the mass.
    ///
    /// # Errors
    /// [`ElementError::OutOfRange`] if α is negative or not finite.
    pub fn new(mass: Mass, coefficient: f64) -> Result<Self, ElementError> {
        check_not_negative("coefficient", "damping", 0, coefficient)?;
        Ok(Self { norm: MassNorm::new(mass), coefficient })
    }
}

impl Potential for MassDamping {
    fn name(&self) -> &str {
        "mass damping"
    }

    fn value(&self, x: &[Vec3]) -> f64 {
        self.norm.value(x)
    }

    fn add_gradient(&self, x: &[Vec3], gradient: &mut [Vec3]) {
        self.norm.add_gradient(x, gradient);
    }

    fn add_hessian(&self, _: &[Vec3], _: Projection, hessian: &mut Assembler<'_>) {
        self.norm.add_hessian(hessian);
    }

    fn freeze(&mut self, stage: &Stage<'_>) -> Result<Changed, PotentialError> {
        if stage.moment != Moment::Step {
            return Ok(Changed::Nothing);
        }
        let rate = if stage.step > 0.0 { stage.scheme.coefficients.velocity } else { 0.0 };
        self.norm.set(self.coefficient * rate, stage.scheme.velocity_origin);
        Ok(Changed::Energy)
    }
}
