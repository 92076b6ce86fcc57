//! The checks for potentials, stencils and objectives.

use super::difference::{Difference, differentiate};
use super::{
    Derivative, DerivativeCheck, DerivativeError, Entry, check_gradient, check_hessian, relative, unit, worst,
};
use crate::objective::{DirectionAccuracy, Objective, ObjectiveError};
use crate::point_map::PointMap;
use crate::potential::Potential;
use crate::projection::Projection;
use crate::sparse::{Assembly, BlockMatrix};
use crate::stencil::Stencil;
use crate::tensor::Vec3;

/// Both checks of one element.
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use]
pub struct StencilCheck {
    /// The gradient against the value.
    pub gradient: DerivativeCheck,
    /// The unprojected Hessian against the gradient; its lower triangle, and the symmetry of its diagonal blocks.
    pub hessian: DerivativeCheck,
}

impl StencilCheck {
    /// Asks that every relative error be at most `allowed`.
    ///
    /// # Errors
    /// The first derivative that is wrong.
    pub fn require(&self, allowed: f64) -> Result<(), DerivativeError> {
        self.gradient.require(allowed)?;
        self.hessian.require(allowed)
    }
}

/// Checks the derivatives of one element of a stencil, its points at `x`. Entry `3 i + k` is component `k` of point
/// `i`.
pub fn check_stencil<const N: usize>(
    stencil: &impl Stencil<N>,
    element: usize,
    x: &[Vec3; N],
) -> StencilCheck {
    let at = |flat: &[f64]| -> [Vec3; N] {
        std::array::from_fn(|i| Vec3::from_column_slice(&flat[3 * i..3 * i + 3]))
    };
    let gradient_into = |flat: &[f64], g: &mut [f64]| {
        let gradient = stencil.gradient(element, &at(flat));
        g.iter_mut().zip(gradient.iter().flatten()).for_each(|(g, entry)| *g = *entry);
    };
    let flat = flatten(x);
    let hessian = stencil.hessian(element, x, Projection::None);
    let entry = |row: usize, column: usize| {
        let (i, j) = (row / 3, column / 3);
        if i >= j { hessian[i][j][(row % 3, column % 3)] } else { hessian[j][i][(column % 3, row % 3)] }
    };
    StencilCheck {
        gradient: check_gradient(&flat, |flat| stencil.value(element, &at(flat)), gradient_into),
        hessian: check_hessian(&flat, gradient_into, entry),
    }
}

/// Checks the gradient of a term at `x` against its value. Entry `3 i + k` is component `k` of point `i`.
///
/// # Panics
/// If there are no points.
pub fn check_potential_gradient(potential: &dyn Potential, x: &[Vec3]) -> DerivativeCheck {
    check_gradient(
        &flatten(x),
        |flat| potential.value(&points(flat)),
        |flat, g| potential_gradient(potential, flat, g),
    )
}

/// Checks the unprojected Hessian of a term at `x`, as assembled, against its gradient.
///
/// # Panics
/// If there are no points.
pub fn check_potential_hessian(potential: &dyn Potential, x: &[Vec3]) -> DerivativeCheck {
    let map = PointMap::identity(x.len());
    let mut assembly = Assembly::new(&map);
    let mut assembler = assembly.begin(&map);
    potential.add_hessian(x, Projection::None, &mut assembler);
    let matrix = assembler.finish();
    let gradient_into = |flat: &[f64], g: &mut [f64]| potential_gradient(potential, flat, g);
    check_hessian(&flatten(x), gradient_into, |row, column| entry(matrix, row, column))
}

/// Checks the gradient of an objective at `x` against its value.
///
/// # Panics
/// If there are no unknowns.
pub fn check_objective_gradient(objective: &mut dyn Objective, x: &[f64]) -> DerivativeCheck {
    let objective = std::cell::RefCell::new(objective);
    check_gradient(x, |x| objective.borrow_mut().value(x), |x, g| objective.borrow_mut().gradient_into(x, g))
}

/// Checks the Newton direction `p` of an objective at `x`: with the true Hessian, `H p = −g`, so the gradient changes
/// along `p` at the rate `−g`. Fails by right where the Hessian is projected and the projection changes it.
///
/// # Errors
/// If the objective has no direction at `x`.
///
/// # Panics
/// If there are no unknowns.
pub fn check_objective_direction(
    objective: &mut dyn Objective,
    x: &[f64],
) -> Result<DerivativeCheck, ObjectiveError> {
    assert!(!x.is_empty(), "nothing to vary");
    let n = x.len();
    let (mut g, mut p) = (vec![0.0; n], vec![0.0; n]);
    objective.gradient_into(x, &mut g);
    objective.direction_into(x, &g, DirectionAccuracy::Full, &mut p)?;
    let mut moved = x.to_vec();
    // Offsets are fractions of p: scale them so that the largest move is of the size of the unknowns.
    let scale = unit(x) / unit(&p);
    let Difference { derivative: numeric, step, noise } = differentiate(scale, n, |offset, out| {
        moved.iter_mut().zip(x).zip(&p).for_each(|((moved, x), p)| *moved = x + offset * p);
        objective.gradient_into(&moved, out);
    });
    let entry = |row: usize| {
        (Entry { row, column: row, analytic: -g[row], numeric: numeric[row], error: 0.0, step }, noise)
    };
    let worst = worst(relative((0..n).map(entry).collect()));
    Ok(DerivativeCheck { derivative: Derivative::Direction, worst, asymmetry: 0.0 })
}

fn potential_gradient(potential: &dyn Potential, flat: &[f64], g: &mut [f64]) {
    let x = points(flat);
    let mut gradient = vec![Vec3::zeros(); x.len()];
    potential.add_gradient(&x, &mut gradient);
    g.iter_mut().zip(gradient.iter().flatten()).for_each(|(g, entry)| *g = *entry);
}

fn flatten(x: &[Vec3]) -> Vec<f64> {
    x.iter().flatten().copied().collect()
}

fn points(flat: &[f64]) -> Vec<Vec3> {
    flat.as_chunks::<3>().0.iter().map(|p| Vec3::from(*p)).collect()
}

fn entry(matrix: &BlockMatrix, row: usize, column: usize) -> f64 {
    let block =
        |row: usize, column: usize| matrix.pattern().slot(row, column).map(|slot| &matrix.blocks()[slot]);
    let (i, j) = (row / 3, column / 3);
    if i >= j {
        block(i, j).map_or(0.0, |b| b[(row % 3, column % 3)])
    } else {
        block(j, i).map_or(0.0, |b| b[(column % 3, row % 3)])
    }
}
