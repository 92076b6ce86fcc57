//! Numbers that are none: refused, with the particle named, and the state as it was.

use super::super::cloud::Cloud;
use super::super::portrait::{Portrait, pictured};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use mechanics_core::law::Lame;
use mechanics_core::tensor::Mat3;
use mpm_constitutive::elastic::NeoHookean;
use mpm_core::{Boundary, MpmError, Samples, Shape, Simulation, SimulationOptions, Surface};
use schemars::JsonSchema;
use serde::Deserialize;

/// A hundred particles in motion, and one wrong number given to the simulation; the ladder is the number of the particle that gets it.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct RefusedNumbers {}

const COUNT: usize = 100;
const DENSITY: f64 = 1000.0;
/// After which, and for how long after the refusal, it runs beside a twin that was given nothing.
const STEPS: usize = 20;

type Plane = Simulation<f64, 2>;

type Act = fn(&mut Plane, usize, NeoHookean) -> Result<(), MpmError>;

/// Something wrong, done to particle `p`.
#[derive(Clone, Copy)]
struct Wrong {
    name: &'static str,
    act: Act,
    /// Whether it is one particle's.
    particular: bool,
}

const fn of_particle(name: &'static str, act: Act) -> Wrong {
    Wrong { name, act, particular: true }
}

const fn of_all(name: &'static str, act: Act) -> Wrong {
    Wrong { name, act, particular: false }
}

/// `usual` for all but particle `p`.
fn but_one<T: Clone>(usual: T, p: usize, wrong: T) -> Vec<T> {
    let mut all = vec![usual; COUNT];
    all[p] = wrong;
    all
}

/// Another body, wrong in one number.
fn add(
    simulation: &mut Plane,
    law: NeoHookean,
    positions: &[[f64; 2]],
    velocities: &[[f64; 2]],
    volumes: &[f64],
) -> Result<(), MpmError> {
    let samples = Samples { positions, velocities, volumes };
    simulation.add_body(law, DENSITY, samples).map(|_| ())
}

fn places() -> Vec<[f64; 2]> {
    Cloud::cuboid([0.0; 2], [1.0; 2], [10; 2]).points
}

fn law() -> Result<NeoHookean, ExperimentError> {
    Ok(NeoHookean::new(Lame::from_young_poisson(1e4, 0.25).map_err(ExperimentError::stopped)?))
}

const WRONGS: &[Wrong] = &[
    of_particle("acceleration NaN", |s, p, _| s.accelerate(0, &but_one([0.0; 2], p, [0.0, f64::NAN]), 1e-3)),
    of_particle("deformation NaN", |s, p, _| {
        s.set_deformation_gradients(0, &but_one(Mat3::identity(), p, Mat3::repeat(f64::NAN)))
    }),
    of_particle("deformation inverted", |s, p, _| {
        let turned = Mat3::from_diagonal(&[-1.0, 1.0, 1.0].into());
        s.set_deformation_gradients(0, &but_one(Mat3::identity(), p, turned))
    }),
    of_particle("deformation flat", |s, p, _| {
        let flat = Mat3::from_diagonal(&[0.0, 1.0, 1.0].into());
        s.set_deformation_gradients(0, &but_one(Mat3::identity(), p, flat))
    }),
    of_particle("impulse NaN", |s, p, _| s.apply_impulses(0, &[(p, [f64::NAN, 0.0])])),
    of_particle("impulse infinite", |s, p, _| s.apply_impulses(0, &[(p, [f64::INFINITY, 0.0])])),
    of_particle("position NaN", |s, p, law| {
        let mut places = places();
        places[p][1] = f64::NAN;
        add(s, law, &places, &[[0.0; 2]; COUNT], &[0.01; COUNT])
    }),
    of_particle("position too far", |s, p, law| {
        let mut places = places();
        places[p][0] = 1e30;
        add(s, law, &places, &[[0.0; 2]; COUNT], &[0.01; COUNT])
    }),
    of_particle("velocity infinite", |s, p, law| {
        add(s, law, &places(), &but_one([0.0; 2], p, [f64::INFINITY, 0.0]), &[0.01; COUNT])
    }),
    of_particle("velocity gradient NaN", |s, p, _| {
        s.set_velocity_gradients(0, &but_one([[0.0; 2]; 2], p, [[f64::NAN; 2]; 2]))
    }),
    of_particle("volume zero", |s, p, law| {
        add(s, law, &places(), &[[0.0; 2]; COUNT], &but_one(0.01, p, 0.0))
    }),
    of_particle("volume negative", |s, p, law| {
        add(s, law, &places(), &[[0.0; 2]; COUNT], &but_one(0.01, p, -0.01))
    }),
    of_particle("volume NaN", |s, p, law| {
        add(s, law, &places(), &[[0.0; 2]; COUNT], &but_one(0.01, p, f64::NAN))
    }),
    of_particle("step of a day", |s, _, _| s.step_unchecked(86_400.0).map(|_| ())),
    of_all("density NaN", |s, _, law| {
        let samples =
            Samples { positions: &places(), velocities: &[[0.0; 2]; COUNT], volumes: &[0.01; COUNT] };
        s.add_body(law, f64::NAN, samples).map(|_| ())
    }),
    of_all("friction below zero", |s, _, _| {
        let floor = Shape::HalfSpace { point: [0.0; 2], normal: [0.0, 1.0] };
        s.add_boundary(Boundary::at_rest(floor, Surface::Friction(-0.1)))
    }),
    of_all("gravity infinite", |s, _, _| s.set_gravity([0.0, f64::NEG_INFINITY])),
    of_all("step NaN", |s, _, _| s.step_unchecked(f64::NAN).map(|_| ())),
    of_all("step zero", |s, _, _| s.step_unchecked(0.0).map(|_| ())),
    of_all("step above the stable one", |s, _, _| {
        let step = 1.01 * s.stable_step();
        s.step(step).map(|_| ())
    }),
];

const NAMES: &[&str] = &[
    "acceleration NaN",
    "deformation NaN",
    "deformation inverted",
    "deformation flat",
    "impulse NaN",
    "impulse infinite",
    "position NaN",
    "position too far",
    "velocity infinite",
    "velocity gradient NaN",
    "volume zero",
    "volume negative",
    "volume NaN",
    "step of a day",
    "density NaN",
    "friction below zero",
    "gravity infinite",
    "step NaN",
    "step zero",
    "step above the stable one",
];

fn start() -> Result<Plane, ExperimentError> {
    let mut simulation = Plane::new(SimulationOptions::new(0.2)).map_err(ExperimentError::stopped)?;
    simulation.set_gravity([0.0, -9.81]).map_err(ExperimentError::stopped)?;
    // Turning and growing.
    let velocities: Vec<_> = places().iter().map(|x| [x[0] - 2.0 * x[1], 2.0 * x[0] + x[1]]).collect();
    add(&mut simulation, law()?, &places(), &velocities, &[0.01; COUNT]).map_err(ExperimentError::stopped)?;
    Ok(simulation)
}

impl Experiment for RefusedNumbers {
    fn methods(&self) -> &'static [&'static str] {
        NAMES
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let wrong = WRONGS.iter().find(|wrong| wrong.name == at.method).copied().ok_or_else(|| {
            ExperimentError::Refused {
                key: "validation.methods".to_owned(),
                reason: format!("there is no method `{}`", at.method),
            }
        })?;
        let particle = (at.ladder as usize).min(COUNT - 1);
        let (mut victim, mut twin) = (start()?, start()?);
        let go_on = |simulation: &mut Plane| -> Result<(), ExperimentError> {
            for _ in 0..STEPS {
                let step = 0.5 * simulation.stable_step();
                simulation.step(step).map_err(ExperimentError::stopped)?;
            }
            Ok(())
        };
        go_on(&mut victim)?;
        go_on(&mut twin)?;
        let (before, law) = (victim.state_hash(), law()?);
        let result = clock.time(|| (wrong.act)(&mut victim, particle, law));
        let unchanged = victim.state_hash() == before;
        let words = result.as_ref().err().map(ToString::to_string).unwrap_or_default();
        // Any particle is a culprit of a step that is too long for all.
        let number = if at.method == "step of a day" {
            "particle ".to_owned()
        } else {
            format!("particle {particle} ")
        };
        let named = !wrong.particular || words.contains(&number);
        go_on(&mut victim)?;
        go_on(&mut twin)?;
        let flag = |holds: bool| f64::from(u8::from(holds));
        let outcome = Outcome::default()
            .invariant("refused", flag(result.is_err()))
            .invariant("particle named", flag(named))
            .invariant("state unchanged", flag(unchanged))
            .invariant("goes on as if nothing had been", flag(victim.state_hash() == twin.state_hash()))
            .state(victim.state_hash());
        pictured(outcome, at, "the body that was given a wrong number, after 40 steps", || Portrait {
            positions: victim.positions(0),
            values: victim.states(0).iter().map(|state| state.volume_ratio).collect(),
            radius: 0.04,
            field: ("J", "1"),
            label: format!("{} of particle {particle}: {words}", at.method),
            ..Portrait::default()
        })
    }
}
