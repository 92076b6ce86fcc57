//! "Motion is optimisation", up to the first conjugate point: the action of an oscillator's discrete paths, handed to
//! this crate's Newton method, to its descent, and to an optimiser that knows nothing of mechanics (`argmin`).
//!
//! `cargo run --release -p lagrangian --no-default-features --example stationary_action`
#![allow(clippy::print_stdout, reason = "an example shows its numbers")]

use argmin::core::{CostFunction, Error, Executor, Gradient, State};
use argmin::solver::linesearch::MoreThuenteLineSearch;
use argmin::solver::quasinewton::LBFGS;
use lagrangian::action::{Action, Galerkin, Outcome, Path, Search};
use lagrangian::{EulerLagrange, Lagrangian};
use mechanics_core::scalar::Scalar;

/// A mass of 1 kg on a spring of 2.25 N/m: ω = 1.5/s, half a period is 2.094 s.
struct Spring;

impl Lagrangian<1> for Spring {
    fn kinetic<S: Scalar>(&self, _q: &[S; 1], v: &[S; 1], _t: S) -> S {
        v[0].square().scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 1], _t: S) -> S {
        q[0].square().scale(0.5 * 2.25)
    }
}

/// From 0.25 m to 1 m.
const ENDS: [f64; 2] = [0.25, 1.0];

/// The action as a function of the positions between the ends, which is all that an optimiser sees.
struct Objective<'a>(&'a Action<'a, EulerLagrange<Spring, 1>>);

impl Objective<'_> {
    fn path(&self, inner: &[f64]) -> Path<[f64; 1]> {
        let mut positions = std::iter::once(ENDS[0]).chain(inner.iter().copied()).chain([ENDS[1]]);
        self.0.path(|_| [positions.next().unwrap_or(f64::NAN)])
    }
}

impl CostFunction for Objective<'_> {
    type Param = Vec<f64>;
    type Output = f64;
    fn cost(&self, inner: &Vec<f64>) -> Result<f64, Error> {
        Ok(self.0.value(&self.path(inner)))
    }
}

impl Gradient for Objective<'_> {
    type Param = Vec<f64>;
    type Gradient = Vec<f64>;
    fn gradient(&self, inner: &Vec<f64>) -> Result<Vec<f64>, Error> {
        Ok(self.0.gradient(&self.path(inner)))
    }
}

/// The exact action between the ends.
fn exact(time: f64) -> f64 {
    let angle = 1.5 * time;
    1.5 / (2.0 * angle.sin()) * (1.0625 * angle.cos() - 0.5)
}

/// What L-BFGS makes of the same function from the same straight line.
fn off_the_shelf(
    action: &Action<'_, EulerLagrange<Spring, 1>>,
    stationary: &Path<[f64; 1]>,
) -> Result<(), Error> {
    let straight = action.straight(&[ENDS[0]], &[ENDS[1]]);
    let start: Vec<f64> = straight.positions()[1..action.node_count() - 1].iter().map(|q| q[0]).collect();
    let solver = LBFGS::new(MoreThuenteLineSearch::new(), 20).with_tolerance_grad(1e-10)?;
    let run =
        Executor::new(Objective(action), solver).configure(|state| state.param(start).max_iters(500)).run();
    let result = match run {
        Ok(result) => result,
        Err(error) => {
            println!("  argmin     gave up: {error}");
            return Ok(());
        }
    };
    let best = result.state().get_best_param().cloned().unwrap_or_default();
    let path = Objective(action).path(&best);
    let apart = path.positions().iter().zip(stationary.positions()).map(|(a, b)| (a[0] - b[0]).abs());
    let (cost, steps) = (result.state().get_best_cost(), result.state().get_iter());
    println!(
        "  argmin     A = {cost:.12} J s after {steps} L-BFGS steps, up to {:.1e} m from the stationary path",
        apart.fold(0.0, f64::max)
    );
    Ok(())
}

fn main() -> Result<(), Error> {
    let system = EulerLagrange::new(Spring);
    for time in [2.0, 2.5] {
        let action = Action::new(&system, 0.0, time, 10, Galerkin { degree: 4 })?;
        let straight = action.straight(&[ENDS[0]], &[ENDS[1]]);
        let found = action.stationary(&straight, &Search::default())?;
        println!("from {} m to {} m in {time} s; half a period is 2.094 s", ENDS[0], ENDS[1]);
        println!("  exact      A = {:.12} J s", exact(time));
        println!(
            "  stationary A = {:.12} J s: {:?}, found in {} Newton step",
            found.action,
            found.extremum(),
            found.iterations
        );
        for at in &found.conjugate_times {
            println!("             a conjugate point lies within two intervals before t = {at} s");
        }
        match action.descend(&straight, &Search::default())?.outcome {
            Outcome::Arrived(lowest) => println!("  descent    A = {:.12} J s", lowest.action),
            Outcome::RanAway { extent, action } => {
                println!(
                    "  descent    ran away to {extent:.0e} times the start's size, A = {action:.1e} J s"
                );
            }
        }
        off_the_shelf(&action, &found.path)?;
    }
    Ok(())
}
