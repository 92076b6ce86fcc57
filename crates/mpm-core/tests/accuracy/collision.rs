//! Two elastic disks that meet: D. Sulsky, Z. Chen, H. L. Schreyer, *A particle method for history-dependent materials*, Comput. Methods
//! Appl. Mech. Engrg. 118, 1994.

use crate::ladder::Cloud;
use mechanics_core::law::Lame;
use mpm_constitutive::elastic::NeoHookean;
use mpm_core::{Kernel, Samples, Simulation, SimulationOptions, Transfer};

const SPACING: f64 = 0.05;
const RADIUS: f64 = 0.2;
const MASS: f64 = 251.327_412;

/// Momentum by Σ m |v| at its worst, the time at which a hundredth of the kinetic energy is gone, kinetic energy at the end by that at the
/// start, largest growth of the whole energy.
struct Encounter {
    momentum: f64,
    contact: f64,
    recovered: f64,
    growth: f64,
    lost: f64,
}

fn collide(transfer: Transfer) -> Encounter {
    let options = SimulationOptions { spacing: SPACING, kernel: Kernel::Quadratic, transfer };
    let mut simulation = Simulation::<f64, 2>::new(options).unwrap();
    let law = NeoHookean::new(Lame::from_young_poisson(1000.0, 0.3).unwrap());
    let square = Cloud::rectangle([-RADIUS; 2], [RADIUS; 2], [16; 2]);
    let inside: Vec<_> = square.points.into_iter().filter(|x| x[0].hypot(x[1]) <= RADIUS).collect();
    // Of two disks of the true mass.
    let volume = 0.5 * MASS / 1000.0 / inside.len() as f64;
    let volumes = vec![volume; inside.len()];
    for (centre, speed) in [(0.2, 0.1), (0.8, -0.1)] {
        let positions: Vec<_> = inside.iter().map(|x| [centre + x[0], centre + x[1]]).collect();
        let velocities = vec![[speed; 2]; inside.len()];
        let samples = Samples { positions: &positions, velocities: &velocities, volumes: &volumes };
        simulation.add_body(law, 1000.0, samples).unwrap();
    }
    let totals = |simulation: &Simulation<f64, 2>| {
        let (mut momentum, mut size, mut kinetic, mut stored) = ([0.0; 2], 0.0, 0.0, 0.0);
        for body in 0..2 {
            for (v, state) in simulation.velocities(body).iter().zip(simulation.states(body)) {
                for a in 0..2 {
                    momentum[a] += 1000.0 * volume * v[a];
                    size += 1000.0 * volume * v[a].abs();
                    kinetic += 500.0 * volume * v[a].powi(2);
                }
                stored += volume * state.energy_density;
            }
        }
        (momentum[0].abs().max(momentum[1].abs()) / size.max(1.0), kinetic, stored)
    };
    let start = totals(&simulation).1;
    assert!((start - 2.513_274).abs() < 1e-5, "{start}");
    let mut found = Encounter { momentum: 0.0, contact: f64::NAN, recovered: 0.0, growth: 0.0, lost: 0.0 };
    let step = 0.01;
    while simulation.time() < 3.6 {
        simulation.step(step).unwrap();
        let (momentum, kinetic, stored) = totals(&simulation);
        found.momentum = found.momentum.max(momentum);
        found.growth = found.growth.max((kinetic + stored) / start - 1.0);
        found.lost = 1.0 - (kinetic + stored) / start;
        if found.contact.is_nan() && kinetic < 0.99 * start {
            found.contact = simulation.time();
        }
        found.recovered = kinetic / start;
    }
    found
}

#[test]
fn disks_bounce_without_a_net_push() {
    for (transfer, least, most_lost) in [
        (Transfer::FLIP, 0.7, 0.06),
        (Transfer::APIC, 0.6, 0.4),
        (Transfer::MlsApic, 0.6, 0.4),
        (Transfer::Pic, 0.0, 1.0),
    ] {
        let found = collide(transfer);
        println!(
            "disks {transfer:?}: momentum {:.1e}, contact at {:.3} s, kinetic energy {:.3}, all energy grew by {:.4}, lost {:.4}",
            found.momentum, found.contact, found.recovered, found.growth, found.lost
        );
        assert!(found.momentum < 1e-13, "{transfer:?}: {}", found.momentum);
        assert!(found.recovered > least && found.recovered < 1.0, "{transfer:?}: {}", found.recovered);
        assert!(found.growth < 0.01 && found.lost < most_lost, "{transfer:?}: {} {}", found.growth, found.lost);
        if transfer != Transfer::Pic {
            // Rims touch at 1.586 s; a grid feels them from when they share nodes, up to three cells earlier in the gap along the diagonal.
            assert!((1.1..1.7).contains(&found.contact), "{transfer:?}: {}", found.contact);
        }
    }
}
