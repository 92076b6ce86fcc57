//! Linear solvers on elastic matrices: time against residual.

use super::elastic_term;
use crate::experiment::random::Random;
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::physics::{Isotropic, Law};
use crate::scene::quantity::{Count, Positive};
use mechanics_core::linear::{Accuracy, LinearSolver, Method, Ordering, Preconditioner, Solver};
use mechanics_core::mesh::{BoxSplit, block};
use mechanics_core::point_map::PointMap;
use mechanics_core::projection::Projection;
use mechanics_core::sparse::{Assembly, BlockMatrix};
use mechanics_core::state::StateHash;
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

/// The stiffness matrix of a box at rest, held at x = 0, with a random right-hand side; the ladder is the relative
/// residual that is asked for.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct LinearSystems {
    /// The material's constants.
    constants: Isotropic,
    /// Edge lengths [m].
    size_m: [Positive; 3],
    /// Cells along each edge.
    cells: [Count; 3],
}

impl Experiment for LinearSystems {
    fn methods(&self) -> &'static [&'static str] {
        &["Cholesky", "PCG, block Jacobi", "PCG, incomplete Cholesky"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let matrix = self.matrix()?;
        let mut random = Random::new(at.seed);
        let b: Vec<f64> = (0..matrix.dimension()).map(|_| random.symmetric()).collect();
        let mut x = vec![0.0; b.len()];
        let mut solver = Solver::new(method(at.method, at.ladder));
        let solved = clock.time(|| {
            solver.factor(&matrix)?;
            solver.solve_into(&b, &mut x, Accuracy::Configured)
        });
        let iterations = solved.map_err(ExperimentError::stopped)?.iterations;
        let mut hash = StateHash::new();
        hash.add("solution", &x);
        Ok(Outcome::default()
            .error("residual", residual(&matrix, &x, &b))
            .count("unknowns", b.len() as u64)
            .count("iterations", iterations as u64)
            .state(hash.value()))
    }
}

impl LinearSystems {
    fn matrix(&self) -> Result<BlockMatrix, ExperimentError> {
        let cells = self.cells.map(|count| count.value() as u32);
        let size = Vec3::from(self.size_m.map(Positive::value));
        let mesh = block(&Vec3::zeros(), &size, cells, BoxSplit::Six).map_err(ExperimentError::stopped)?;
        let law = Law::NeoHookean(self.constants);
        let term = elastic_term("elasticity", &law, &mesh, 0).map_err(ExperimentError::stopped)?;
        let held: Vec<(u32, Vec3)> =
            (0..).zip(mesh.points()).filter(|(_, p)| p.x == 0.0).map(|(i, p)| (i, *p)).collect();
        let map = PointMap::with_fixed(mesh.points().len(), &held).map_err(ExperimentError::stopped)?;
        let mut assembly = Assembly::new(&map);
        let mut assembler = assembly.begin(&map);
        assembler.begin_term(0);
        term.add_hessian(mesh.points(), Projection::Clamp, &mut assembler);
        Ok(assembler.finish().clone())
    }
}

fn method(name: &str, tolerance: f64) -> Method {
    let conjugate_gradient =
        |preconditioner| Method::ConjugateGradient { preconditioner, tolerance, max_iterations: 20_000 };
    match name {
        "Cholesky" => Method::Cholesky { ordering: Ordering::FewestFlops },
        "PCG, block Jacobi" => conjugate_gradient(Preconditioner::BlockJacobi),
        // The only other method of the list.
        _ => conjugate_gradient(Preconditioner::IncompleteCholesky),
    }
}

/// ‖b − A x‖₂ / ‖b‖₂.
fn residual(matrix: &BlockMatrix, x: &[f64], b: &[f64]) -> f64 {
    let x: Vec<Vec3> = x.chunks_exact(3).map(Vec3::from_column_slice).collect();
    let mut product = vec![Vec3::zeros(); x.len()];
    matrix.multiply_into(&x, &mut product);
    let rest: f64 = product.iter().flatten().zip(b).map(|(found, wanted)| (found - wanted).powi(2)).sum();
    (rest / b.iter().map(|b| b * b).sum::<f64>()).sqrt()
}
