//! Hard cases of material points: no reference, but what must hold whatever happens. What a simulation refuses it refuses with its own words,
//! and as it was before.

mod alone;
mod collision;
mod crowd;
mod limits;
mod refused;
mod released;
mod settling;

pub(in crate::experiment) use alone::ParticleAlone;
pub(in crate::experiment) use collision::HardCollision;
pub(in crate::experiment) use crowd::CrowdedCell;
pub(in crate::experiment) use limits::LawsAtLimits;
pub(in crate::experiment) use refused::RefusedNumbers;
pub(in crate::experiment) use released::StretchedAndReleased;
pub(in crate::experiment) use settling::SettlingSand;

use super::solver::Solver;

/// Kinetic and stored energy of all bodies, that of the affine motion included \[J\].
fn energy<const D: usize>(solver: &Solver<D>, bodies: usize) -> f64 {
    let of_body = |body: usize| {
        let totals = solver.totals(body);
        totals.kinetic_energy + totals.affine_energy + totals.stored_energy
    };
    (0..bodies).map(of_body).sum()
}
