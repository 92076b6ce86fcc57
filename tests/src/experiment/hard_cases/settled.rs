//! What a free body has come to: its spin, what it does beside spinning, and the equilibrium that it rests in.
//!
//! Backward Euler does not keep angular momentum. Over a step the forces have no torque about the positions at its end, so that
//! Lₙ₊₁ = Σ xₙ₊₁ × m vₙ = Lₙ + h Σ m vₙ₊₁ × vₙ. A body that snaps back from far away without a mirror plane in its mesh is left
//! with a spin of order h, which the scheme damps by ½(ωh)² a step, over minutes. A spinning body is stretched:
//! its strain at rest in the rotating frame is of order ρω²ℓ²/E. So the spin's part of the deformation is taken off before it is asked
//! whether the body has come to rest.

use super::body::{Deformation, mass, options};
use crate::experiment::ExperimentError;
use lagrangian::element::{DeadLoad, Mass};
use lagrangian::stepper::{Stepper, StepperOptions};
use mechanics_core::mesh::TetMesh;
use mechanics_core::objective::Projecting;
use mechanics_core::point_map::PointMap;
use mechanics_core::potential::Potential;
use mechanics_core::projection::Projection;
use mechanics_core::sparse::{Assembly, BlockMatrix};
use mechanics_core::state::State;
use mechanics_core::tensor::{Mat3, Vec3};
use nalgebra::DMatrix;

/// Where a free body has come to.
pub(super) struct Settled {
    /// |ω| of the rigid motion with the body's angular momentum (rad/s).
    pub(super) spin: f64,
    /// The largest difference of Green's strain from that of the body in steady rotation with this spin.
    pub(super) unsettled: f64,
    /// The largest Green strain of the equilibrium without spin, which the body is let down to.
    pub(super) strain: f64,
    /// The smallest det F there.
    pub(super) smallest_determinant: f64,
    /// The largest force of a point there over the largest force of one element on it.
    pub(super) force: f64,
    /// The smallest curvature of the energy there that is not of a rigid motion, over the largest; negative at a saddle.
    pub(super) curvature: f64,
}

/// Length of the steps without inertia (s): c M is then 1e-5 of the stiffness. That holds the rigid motions against the rounding of
/// elastic forces: with 1e-7 they drift by more than the tolerance.
const RELAXATION_STEP: f64 = 10.0;
/// Each takes the slowest elastic motion down by more than a hundred.
const RELAXATION_STEPS: usize = 12;

impl Settled {
    /// Looks at a state of a body with this elastic energy.
    pub(super) fn of(
        mesh: &TetMesh,
        density: f64,
        elastic: &mut dyn Potential,
        method: &str,
        state: &State,
    ) -> Result<Self, ExperimentError> {
        let mass = mass(mesh, density)?;
        let deformation = Deformation::of(mesh);
        let motion = RigidMotion::of(&mass, state);
        let mut load = DeadLoad::new("spin", motion.centrifugal(&mass, &state.position))
            .map_err(ExperimentError::stopped)?;
        let spinning = relaxed(&mass, method, &mut [&mut *elastic, &mut load], &state.position)?;
        let resting = relaxed(&mass, method, &mut [&mut *elastic], &spinning)?;
        Ok(Self {
            spin: motion.angular_velocity.norm(),
            unsettled: deformation.largest_strain_between(&state.position, &spinning),
            strain: deformation.largest_strain(&resting),
            smallest_determinant: deformation.smallest_determinant(&resting),
            force: force_left(elastic, &resting),
            curvature: smallest_curvature(elastic, &mass, &resting),
        })
    }
}

/// The rigid motion that has a state's momenta.
struct RigidMotion {
    centre: Vec3,
    angular_velocity: Vec3,
    angular_acceleration: Vec3,
}

impl RigidMotion {
    /// ω = I⁻¹ L; Euler's equation I ω̇ = −ω × Iω.
    fn of(mass: &Mass, state: &State) -> Self {
        let weighted: Vec3 = state.position.iter().zip(mass.diagonal()).map(|(x, m)| x * *m).sum();
        let centre = weighted / mass.total();
        let about = |(x, m): (&Vec3, &f64)| {
            let r = x - centre;
            (Mat3::identity() * r.norm_squared() - r * r.transpose()) * *m
        };
        let inertia: Mat3 = state.position.iter().zip(mass.diagonal()).map(about).sum();
        let inverse = inertia.try_inverse().unwrap_or_default();
        let momentum = mass.angular_momentum(&state.position, &state.velocity, &centre);
        let angular_velocity = inverse * momentum;
        let angular_acceleration = -inverse * angular_velocity.cross(&momentum);
        Self { centre, angular_velocity, angular_acceleration }
    }

    /// −m a of every point.
    fn centrifugal(&self, mass: &Mass, x: &[Vec3]) -> Vec<(u32, Vec3)> {
        let (spin, change) = (self.angular_velocity, self.angular_acceleration);
        let force = |((point, x), m): ((u32, &Vec3), &f64)| {
            let r = x - self.centre;
            (point, (spin.cross(&spin.cross(&r)) + change.cross(&r)) * -m)
        };
        (0..).zip(x).zip(mass.diagonal()).map(force).collect()
    }
}

/// Down the energy from `x`, with steps so long that inertia only holds the rigid motions, each from rest.
fn relaxed(
    mass: &Mass,
    method: &str,
    terms: &mut [&mut dyn Potential],
    x: &[Vec3],
) -> Result<Vec<Vec3>, ExperimentError> {
    let options =
        StepperOptions { projecting: Projecting::OnDemand, ..options(method, 2e-11, RELAXATION_STEP) };
    let mut stepper = Stepper::new(mass.clone(), PointMap::identity(x.len()), options);
    let mut x = x.to_vec();
    for _ in 0..RELAXATION_STEPS {
        let mut state = State::at_rest(x);
        stepper.step(&mut state, terms, RELAXATION_STEP).map_err(ExperimentError::stopped)?;
        x = state.position;
    }
    Ok(x)
}

/// The largest gradient of a point over the largest curvature of one times 1 m.
fn force_left(elastic: &dyn Potential, x: &[Vec3]) -> f64 {
    let mut gradient = vec![Vec3::zeros(); x.len()];
    elastic.add_gradient(x, &mut gradient);
    let matrix = hessian(elastic, x);
    let stiffest = (0..x.len()).map(|i| matrix.diagonal(i).norm()).fold(0.0, f64::max);
    gradient.iter().map(Vec3::norm).fold(0.0, f64::max) / stiffest
}

fn hessian(elastic: &dyn Potential, x: &[Vec3]) -> BlockMatrix {
    let map = PointMap::identity(x.len());
    let mut assembly = Assembly::new(&map);
    let mut assembler = assembly.begin(&map);
    assembler.begin_term(0);
    elastic.add_hessian(x, Projection::None, &mut assembler);
    assembler.finish().clone()
}

/// Of the eigenvalues of M⁻¹ᐟ² H M⁻¹ᐟ², in ascending order: the first if it is negative by more than rounding, else the seventh, six
/// being of rigid motions; over the last.
fn smallest_curvature(elastic: &dyn Potential, mass: &Mass, x: &[Vec3]) -> f64 {
    let matrix = hessian(elastic, x);
    let scale: Vec<f64> = mass.diagonal().iter().map(|m| m.sqrt().recip()).collect();
    let mut dense = DMatrix::zeros(3 * x.len(), 3 * x.len());
    for column in 0..x.len() {
        for slot in matrix.pattern().column(column) {
            let row = matrix.pattern().rows()[slot] as usize;
            let block = matrix.blocks()[slot] * (scale[row] * scale[column]);
            dense.view_mut((3 * row, 3 * column), (3, 3)).copy_from(&block);
            dense.view_mut((3 * column, 3 * row), (3, 3)).copy_from(&block.transpose());
        }
    }
    let mut values: Vec<f64> = dense.symmetric_eigenvalues().iter().copied().collect();
    values.sort_by(f64::total_cmp);
    let largest = values[values.len() - 1];
    let of_largest = |value: f64| value / largest;
    if values[0] < -ROUNDING * largest { of_largest(values[0]) } else { of_largest(values[6]) }
}

/// An eigenvalue of a rigid motion is zero up to some hundred ε of the largest.
const ROUNDING: f64 = 1e-11;
