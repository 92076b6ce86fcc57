//! Inertia as a term of the incremental potential: ½ c ‖x − x̃‖²_M.
//!
//! Minimising it together with the potential energy E(x) gives M c (x − x̃) = −∇E(x): Newton's law with the
//! acceleration that the time scheme reads off its positions. c and x̃ come from the [`Stage`] at the start of a step; the term knows
//! nothing else of time. In statics c is zero and the term is none.

use super::mass::Mass;
use mechanics_core::parallel;
use mechanics_core::potential::{Changed, Potential, PotentialError};
use mechanics_core::projection::Projection;
use mechanics_core::sparse::Assembler;
use mechanics_core::stage::{Moment, Stage};
use mechanics_core::tensor::{Mat3, Vec3};

/// Points summed by one task.
const CHUNK: usize = 4096;

/// ½ c ‖x − x̃‖²_M \[J\].
#[derive(Clone, Debug)]
pub struct Inertia {
    norm: MassNorm,
}

impl Inertia {
    /// The inertia of points with this mass; without effect until a step begins.
    pub fn new(mass: Mass) -> Self {
        Self { norm: MassNorm::new(mass) }
    }

    /// The mass.
    pub fn mass(&self) -> &Mass {
        &self.norm.mass
    }
}

impl Potential for Inertia {
    fn name(&self) -> &str {
        "inertia"
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
        self.norm.set(stage.scheme.coefficients.inertia, stage.scheme.inertial_target);
        Ok(Changed::Energy)
    }
}

/// A multiple of the distance from an origin, measured with mass: ½ factor ‖x − origin‖²_M.
#[derive(Clone, Debug)]
pub(super) struct MassNorm {
    mass: Mass,
    /// One a point, for the diagonal of the Hessian.
    points: Vec<[u32; 1]>,
    factor: f64,
    origin: Vec<Vec3>,
}

impl MassNorm {
    pub(super) fn new(mass: Mass) -> Self {
        let points = (0..mass.points() as u32).map(|point| [point]).collect();
        let origin = vec![Vec3::zeros(); mass.points()];
        Self { mass, points, factor: 0.0, origin }
    }

    pub(super) fn set(&mut self, factor: f64, origin: &[Vec3]) {
        self.factor = factor;
        self.origin.copy_from_slice(origin);
    }

    fn offset(&self, point: usize, x: &[Vec3]) -> Vec3 {
        x[point] - self.origin[point]
    }

    pub(super) fn value(&self, x: &[Vec3]) -> f64 {
        if self.factor == 0.0 {
            return 0.0;
        }
        let diagonal = self.mass.diagonal();
        let own = parallel::sum(x.len(), CHUNK, |i| diagonal[i] * self.offset(i, x).norm_squared());
        let (pairs, couplings) = self.mass.couplings();
        let mixed = parallel::sum(pairs.len(), CHUNK, |k| {
            let [i, j] = pairs[k].map(|point| self.offset(point as usize, x));
            couplings[k] * i.dot(&j)
        });
        self.factor * (0.5 * own + mixed)
    }

    pub(super) fn add_gradient(&self, x: &[Vec3], gradient: &mut [Vec3]) {
        if self.factor == 0.0 {
            return;
        }
        let offsets: Vec<Vec3> = (0..x.len()).map(|i| self.offset(i, x)).collect();
        self.mass.add_product(self.factor, &offsets, gradient);
    }

    /// The same lists whatever the factor, so that the pattern of the matrix is the same in statics.
    pub(super) fn add_hessian(&self, hessian: &mut Assembler<'_>) {
        let diagonal = self.mass.diagonal();
        hessian.add(&self.points, |i| [[Mat3::from_diagonal_element(self.factor * diagonal[i])]]);
        let (pairs, couplings) = self.mass.couplings();
        hessian.add(pairs, |k| {
            let coupling = Mat3::from_diagonal_element(self.factor * couplings[k]);
            [[Mat3::zeros(), coupling], [coupling, Mat3::zeros()]]
        });
    }
}
