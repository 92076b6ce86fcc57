//! A wing nut in weightlessness: spun about its middle axis it flips, again and again, although nothing turns it.
//!
//! ```text
//! cargo run -p lagrangian --example flipping_body
//! ```
//!
//! The spin about the middle axis, ω₂, changes sign twice a period; the period between is Jacobi's, by the arithmetic–geometric mean.

#![allow(clippy::print_stdout)]

use lagrangian::integrator::{DormandPrince853, Event, Tolerance};
use lagrangian::systems::FreeBody;
use lagrangian::{EulerLagrange, LagrangianError, Phase};

fn main() -> Result<(), LagrangianError> {
    let body = FreeBody::new([1.0, 2.0, 3.0])?;
    let system = EulerLagrange::new(body);
    let (q, omega) = ([1.0, 0.0, 0.0, 0.0], [0.001, 2.0, 0.001]);
    let mut phase = Phase::new(0.0, q, FreeBody::rate(&q, &omega));

    let spin = |_: f64, q: &[f64; 4], v: &[f64; 4]| FreeBody::angular_velocity(q, v)[1];
    let mut events = [Event::new(spin)];
    let mut method = DormandPrince853::new(&system).with_tolerance(Tolerance::uniform(1e-14))?;
    let (flips, report) = method.locate(&system, &mut phase, 100.0, &mut events)?;

    let times: Vec<f64> = flips.iter().map(|flip| flip.phase.time).collect();
    times.iter().for_each(|time| println!("flips at t = {time:.9} s"));
    let measured = times[2] - times[0];
    println!("period: {measured:.9} s measured, {:.9} s in closed form; {report}", body.spin_period(&omega));
    let length = phase.q.iter().map(|x| x * x).sum::<f64>().sqrt();
    println!("|q| − 1 = {:.1e} after {:.0} s", length - 1.0, phase.time);
    Ok(())
}
