//! Newton's method on the stage equations, for steps on which the iteration with the mass matrices is too slow.

use super::Tableau;
use super::stages::{Masses, Stages};
use crate::coordinates::Coordinates;
use crate::dense::solve_general;
use crate::error::LagrangianError;
use crate::integrator::StepReport;
use crate::integrator::canonical::Canonical;
use crate::integrator::convergence::{Convergence, Iteration, TOLERANCE, Verdict};
use crate::system::{Curvature, System};

const LIMIT: u32 = 30;

impl<const S: usize, C: Coordinates> Stages<S, C> {
    /// Solves the stage equations from the velocities that are there.
    pub(super) fn solve_by_newton<System_: System<Coordinates = C>>(
        &mut self,
        system: &System_,
        tableau: &Tableau<S>,
        start: &Canonical<C>,
        h: f64,
        method: &'static str,
        report: &mut StepReport,
    ) -> Result<(), LagrangianError> {
        let n = self.dimension();
        let mut curvatures: Vec<Curvature<C>> = (0..S).map(|_| Curvature::zeros(n)).collect();
        let mut matrix = vec![0.0; S * n * S * n];
        let mut correction = vec![0.0; S * n];
        let mut convergence = Convergence::new(Iteration::Newton, 1.0, LIMIT / 2, LIMIT);
        loop {
            self.evaluate(system, tableau, start, h, Masses::Kept, report);
            for i in 0..S {
                let time = start.time + tableau.nodes[i] * h;
                system.curve(time, &self.coordinates[i], &self.velocities[i], &mut curvatures[i]);
                correction[i * n..(i + 1) * n].copy_from_slice(self.residuals[i].as_ref());
            }
            report.curvatures += S as u64;
            fill_jacobian(tableau, h, &curvatures, &mut matrix, n);
            let residual = correction.clone();
            let solved = solve_general(&mut matrix, &mut correction);
            let verdict = match solved {
                Some(()) => {
                    let work = residual.iter().zip(&correction).map(|(r, d)| (r * d).abs()).sum::<f64>();
                    self.add(&correction);
                    convergence.judge(self.measure(start, h, [work, self.scale()]))
                }
                None => Verdict::Failing,
            };
            match verdict {
                Verdict::Continue | Verdict::Stalled => {}
                Verdict::Converged => return Ok(()),
                Verdict::Failing => {
                    return Err(LagrangianError::NotConverged {
                        method,
                        time: start.time,
                        step: h,
                        iterations: report.iterations as u32,
                        correction: convergence.correction(),
                        tolerance: TOLERANCE,
                    });
                }
            }
        }
    }

    fn add(&mut self, correction: &[f64]) {
        let n = self.dimension();
        for i in 0..S {
            self.residuals[i].as_mut().copy_from_slice(&correction[i * n..(i + 1) * n]);
            for j in 0..n {
                self.velocities[i].as_mut()[j] += correction[i * n + j];
            }
        }
    }

    /// Σ|v p| over the stages.
    fn scale(&self) -> f64 {
        let pairs = self.velocities.iter().zip(&self.momenta);
        pairs.flat_map(|(v, p)| v.as_ref().iter().zip(p.as_ref())).map(|(v, p)| (v * p).abs()).sum()
    }
}

/// −∂rᵢ/∂Vⱼ, row by row.
fn fill_jacobian<const S: usize, C: Coordinates>(
    tableau: &Tableau<S>,
    h: f64,
    curvatures: &[Curvature<C>],
    matrix: &mut [f64],
    n: usize,
) {
    let a = &tableau.stages;
    for i in 0..S {
        for j in 0..S {
            let (at_i, at_j) = (&curvatures[i], &curvatures[j]);
            for r in 0..n {
                for c in 0..n {
                    let (vq, vv) = (C::entries(&at_i.vq), C::entries(&at_i.vv));
                    let gyroscopic = vq[r * n + c]
                        - C::entries(&at_j.vq)[c * n + r]
                        - C::entries(&at_j.applied_v)[r * n + c];
                    let stiffness: f64 = (0..S)
                        .map(|k| {
                            let at = &curvatures[k];
                            let slope = C::entries(&at.qq)[r * n + c] + C::entries(&at.applied_q)[r * n + c];
                            a[i][k] * a[k][j] * slope
                        })
                        .sum();
                    let mass = if i == j { vv[r * n + c] } else { 0.0 };
                    matrix[(i * n + r) * S * n + j * n + c] =
                        mass + h * a[i][j] * gyroscopic - h * h * stiffness;
                }
            }
        }
    }
}
