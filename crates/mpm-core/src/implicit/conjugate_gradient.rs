//! Preconditioned conjugate gradients for a symmetric positive definite matrix that is only known by its products.

use mechanics_core::parallel;

/// Entries that are summed at a time.
const CHUNK: usize = 4096;

/// A matrix and its preconditioner.
pub(super) trait System {
    /// Overwrites `product` with A p.
    fn multiply_into(&mut self, p: &[f64], product: &mut [f64]);

    /// Overwrites `z` with B⁻¹ r.
    fn precondition_into(&self, r: &[f64], z: &mut [f64]);
}

/// Why a system was not solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Unsolved {
    pub(super) iterations: u64,
    pub(super) residual: f64,
}

/// aᵀb, the same bits for any number of threads.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    parallel::sum(a.len(), CHUNK, |i| a[i] * b[i])
}

/// `target += factor · direction`.
pub(super) fn add(target: &mut [f64], factor: f64, direction: &[f64]) {
    parallel::for_each_chunk(target, CHUNK, |first, part| {
        for (t, d) in part.iter_mut().zip(&direction[first..]) {
            *t += factor * d;
        }
    });
}

/// Overwrites `x` with the solution of A x = b to ‖b − A x‖ ≤ `tolerance` ‖b‖ in the norm of B⁻¹, and answers how many products it took.
///
/// # Reference
/// Hestenes, Stiefel (1952); Saad, Iterative Methods for Sparse Linear Systems (2003), algorithm 9.1.
pub(super) fn solve_into(
    system: &mut dyn System,
    b: &[f64],
    tolerance: f64,
    most: u64,
    x: &mut [f64],
) -> Result<u64, Unsolved> {
    x.fill(0.0);
    let mut r = b.to_vec();
    let (mut z, mut q) = (vec![0.0; b.len()], vec![0.0; b.len()]);
    system.precondition_into(&r, &mut z);
    let mut p = z.clone();
    let mut descent = dot(&r, &z);
    let wanted = tolerance * tolerance * descent;
    let first = descent;
    if first == 0.0 {
        return Ok(0);
    }
    for iteration in 1..=most {
        system.multiply_into(&p, &mut q);
        let curvature = dot(&p, &q);
        if !(curvature > 0.0 && descent.is_finite()) {
            return Err(Unsolved { iterations: iteration, residual: (descent / first).sqrt() });
        }
        let length = descent / curvature;
        add(x, length, &p);
        add(&mut r, -length, &q);
        system.precondition_into(&r, &mut z);
        let next = dot(&r, &z);
        if next <= wanted {
            return Ok(iteration);
        }
        let beta = next / descent;
        descent = next;
        parallel::for_each_chunk(&mut p, CHUNK, |first, part| {
            for (p, z) in part.iter_mut().zip(&z[first..]) {
                *p = beta * *p + z;
            }
        });
    }
    Err(Unsolved { iterations: most, residual: (descent / first).sqrt() })
}
