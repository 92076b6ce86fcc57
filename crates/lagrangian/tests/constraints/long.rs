//! A million steps.

use crate::systems::*;
use lagrangian::constraint::{Composition, ConstraintSet, Constraints, ExpansionOf, Rattle};
use lagrangian::integrator::Integrator;
use lagrangian::{EulerLagrange, Phase, System};

/// What was seen over a run.
struct Record {
    /// The largest |φ|.
    constraint: f64,
    /// The largest |G v|.
    velocity: f64,
    /// Relative energy errors: the largest of the first and of the last tenth.
    energy: [f64; 2],
}

fn run<S, C, const N: usize, const K: usize>(
    system: &S,
    mut rattle: Rattle<C>,
    mut phase: Phase<[f64; N]>,
    (h, steps): (f64, usize),
) -> Record
where
    S: System<Coordinates = [f64; N]>,
    C: ConstraintSet<Coordinates = [f64; N], Multipliers = [f64; K], Jacobian = [[f64; N]; K]> + Clone,
{
    let constraints = rattle.constraints().clone();
    let mut at = ExpansionOf::<C>::zeros(constraints.shape());
    let start = system.energy(phase.time, &phase.q, &phase.v);
    let mut record = Record { constraint: 0.0, velocity: 0.0, energy: [0.0; 2] };
    for n in 0..steps {
        rattle.step(system, &mut phase, h).unwrap();
        constraints.expand(phase.time, &phase.q, &mut at);
        for k in 0..K {
            let speed: f64 = (0..N).map(|j| at.jacobian[k][j] * phase.v[j]).sum();
            record.constraint = record.constraint.max(at.value[k].abs());
            record.velocity = record.velocity.max((speed + at.rate[k]).abs());
        }
        let tenth = n * 10 / steps;
        if tenth == 0 || tenth == 9 {
            let error = (system.energy(phase.time, &phase.q, &phase.v) / start - 1.0).abs();
            let seen = &mut record.energy[tenth / 9];
            *seen = seen.max(error);
        }
    }
    record
}

fn assert_stays(name: &str, record: &Record) {
    let [first, last] = record.energy;
    println!("{name}: |φ| {:e}, |Gv| {:e}, energy {first:e} {last:e}", record.constraint, record.velocity);
    assert!(record.constraint <= 1e-12, "{name}: |φ| = {:e}", record.constraint);
    assert!(record.velocity <= 1e-12, "{name}: |Gv| = {:e}", record.velocity);
    assert!(
        (last / first - 1.0).abs() < 0.05 || (first < 1e-12 && last < 1e-12),
        "{name}: {first:e} {last:e}"
    );
}

const MILLION: usize = 1_000_000;

#[test]
fn a_pendulum_stays_on_its_rod_for_a_million_steps() {
    let start = Phase::new(0.0, [0.6, -0.8], [0.8, 0.6]);
    let record = run(&EulerLagrange::new(Particle), Rattle::new(rod()), start, (0.01, MILLION));
    assert_stays("pendulum", &record);
}

#[test]
fn a_bead_stays_on_its_parabola_for_a_million_steps() {
    let start = Phase::new(0.0, [1.5, 1.125], [0.0, 0.0]);
    let rattle = Rattle::new(Constraints::new(Parabola));
    assert_stays("bead", &run(&EulerLagrange::new(Particle), rattle, start, (0.01, MILLION)));
}

#[test]
fn a_double_pendulum_stays_on_its_rods_for_a_million_steps() {
    let lengths = [1.0, 0.5];
    let q = joints([0.5, -0.25], lengths);
    let v = joint_velocities([0.5, -0.25], [0.0, 0.5], lengths);
    let rattle = Rattle::new(Constraints::new(TwoRods(lengths)));
    let system = EulerLagrange::new(TwoMasses([2.0, 1.0]));
    assert_stays("double pendulum", &run(&system, rattle, Phase::new(0.0, q, v), (0.01, MILLION)));
}

/// The method's own error is at rounding here, so this is rounding's drift alone.
#[test]
fn rounding_does_not_drift() {
    let start = Phase::new(0.0, [0.6, -0.8], [0.8, 0.6]);
    let rattle = Rattle::composed(rod(), Composition::Eighth);
    let record = run(&EulerLagrange::new(Particle), rattle, start, (0.01, 50_000));
    let [first, last] = record.energy;
    println!("rounding: {first:e} {last:e}");
    assert!(record.constraint <= 1e-14, "{:e}", record.constraint);
    assert!(last < 2e-14, "{first:e} {last:e}");
}

/// The general form: masses that depend on coordinates.
#[test]
fn a_bead_in_polar_coordinates_keeps_its_energy() {
    let rattle = Rattle::new(Constraints::new(PolarParabola));
    let record =
        run(&EulerLagrange::new(Polar), rattle, Phase::new(0.0, polar_start(), [0.0, 0.0]), (0.01, 100_000));
    assert_stays("bead, polar", &record);
}
