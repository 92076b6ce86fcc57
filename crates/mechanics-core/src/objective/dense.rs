//! Small problems in any coordinates: a few unknowns, a dense Hessian.

use super::direction_solver::factor;
use super::{DirectionAccuracy, DirectionReport, Objective, ObjectiveError};
use crate::potential::Quantity;
use crate::projection::Projection;
use nalgebra::{DMatrix, DVector, DVectorView, DVectorViewMut, SymmetricEigen};
use std::time::Instant;

/// A function of a few unknowns with its derivatives; [`DenseObjective`] makes it an [`Objective`].
pub trait DenseProblem {
    /// The number of unknowns.
    fn dimension(&self) -> usize;

    /// The value at `x`; may be `+∞`.
    fn value(&self, x: &[f64]) -> f64;

    /// Overwrites `gradient`.
    fn gradient_into(&self, x: &[f64], gradient: &mut [f64]);

    /// Overwrites `hessian`, whole and symmetric.
    fn hessian_into(&self, x: &[f64], hessian: &mut DMatrix<f64>);

    /// The largest part in [0, 1] of the step `p` that stays in the domain.
    fn limit_step(&self, x: &[f64], p: &[f64]) -> f64 {
        let _ = (x, p);
        1.0
    }
}

/// A [`DenseProblem`] with directions from a dense Cholesky factorisation.
///
/// A Hessian that is not positive definite is replaced by its eigenvalue projection: negative eigenvalues as
/// [`Projection`] says ([`Projection::None`] makes them an error), and none smaller than 1e-10 of the largest.
#[derive(Clone, Debug)]
pub struct DenseObjective<P> {
    /// The problem.
    pub problem: P,
    /// What to do where the Hessian is not positive definite.
    pub projection: Projection,
}

impl<P: DenseProblem> DenseObjective<P> {
    /// Indefinite Hessians are projected with [`Projection::Absolute`], which keeps saddle points from attracting.
    pub fn new(problem: P) -> Self {
        Self { problem, projection: Projection::Absolute }
    }
}

/// Eigenvalues of a projected Hessian are at least this part of the largest.
const SMALLEST_EIGENVALUE: f64 = 1e-10;

impl<P: DenseProblem> Objective for DenseObjective<P> {
    fn dimension(&self) -> usize {
        self.problem.dimension()
    }

    fn value(&mut self, x: &[f64]) -> f64 {
        self.problem.value(x)
    }

    fn gradient_into(&mut self, x: &[f64], gradient: &mut [f64]) {
        self.problem.gradient_into(x, gradient);
    }

    fn direction_into(
        &mut self,
        x: &[f64],
        gradient: &[f64],
        _: DirectionAccuracy,
        direction: &mut [f64],
    ) -> Result<DirectionReport, ObjectiveError> {
        let n = self.dimension();
        let begin = Instant::now();
        let mut hessian = DMatrix::zeros(n, n);
        self.problem.hessian_into(x, &mut hessian);
        if let Some(index) = hessian.iter().position(|entry| !entry.is_finite()) {
            let value = hessian[index];
            return Err(ObjectiveError::NonFinite { what: Quantity::Hessian, index, value });
        }
        let assembly_time = begin.elapsed();
        let right = -DVectorView::from_slice(gradient, n).clone_owned();
        let (p, shifts) = match (factor(hessian.clone()), self.projection) {
            (Ok(factor), _) => (factor.solve(&right), 0),
            (Err(column), Projection::None) => {
                let location = super::Location { point: Some(column), ..Default::default() };
                return Err(ObjectiveError::Indefinite { location, shift: 0.0 });
            }
            (Err(_), projection) => (projected_solve(hessian, projection, &right), 1),
        };
        DVectorViewMut::from_slice(direction, n).copy_from(&p);
        let solve_time = begin.elapsed() - assembly_time;
        Ok(DirectionReport {
            factorisations: 1 + shifts,
            shifts,
            shift: 0.0,
            assembly_time,
            solve_time,
            linear_iterations: 0,
        })
    }

    fn limit_step(&mut self, x: &[f64], p: &[f64]) -> Result<super::Limit, ObjectiveError> {
        let fraction = self.problem.limit_step(x, p);
        if (0.0..=1.0).contains(&fraction) {
            return Ok(super::Limit { fraction, ..Default::default() });
        }
        Err(ObjectiveError::NonFinite { what: Quantity::StepLimit, index: 0, value: fraction })
    }
}

fn projected_solve(hessian: DMatrix<f64>, projection: Projection, right: &DVector<f64>) -> DVector<f64> {
    let SymmetricEigen { eigenvectors, eigenvalues } = hessian.symmetric_eigen();
    let floor = (SMALLEST_EIGENVALUE * eigenvalues.amax()).max(f64::MIN_POSITIVE);
    let mut coordinates = eigenvectors.tr_mul(right);
    coordinates.zip_apply(&eigenvalues, |c, eigenvalue| *c /= projection.apply(eigenvalue).max(floor));
    eigenvectors * coordinates
}
