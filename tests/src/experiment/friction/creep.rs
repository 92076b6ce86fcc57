//! An elastic block on a slope that it does not slide on.

use super::surfaces::{ACTIVATION, GRAVITY, creep, friction, gravity_on_slope, stepping};
use crate::experiment::contact::world::{Material, WorldBuilder};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{Count, Positive};
use ipc_contact::collision_mesh::HalfSpace;
use ipc_contact::contact::ContactOptions;
use ipc_contact::stiffness::{Scale, Stiffness};
use lagrangian::stepper::TimeScheme;
use mechanics_core::mesh::{BoxSplit, block};
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

/// A cube of tetrahedra, 0.1 m and 1 kg, on a slope; the ladder is the stick velocity (m/s).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ElasticBlockOnIncline {
    angle_deg: Positive,
    friction_coefficient: Positive,
    /// Young's modulus (Pa).
    young_modulus_pa: Positive,
    /// Cells along a side.
    cells: Count,
    step_s: Positive,
    /// How long it settles before it is measured (s).
    settling_s: Positive,
    /// How long it is measured (s).
    duration_s: Positive,
}

impl Experiment for ElasticBlockOnIncline {
    fn methods(&self) -> &'static [&'static str] {
        &["backward-euler"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let (angle, mu) = (self.angle_deg.value().to_radians(), self.friction_coefficient.value());
        let (h, stick_velocity, cells) = (self.step_s.value(), at.ladder, self.cells.value() as u32);
        let low = Vec3::z() * (0.5 * ACTIVATION);
        let cube = block(&low, &low.add_scalar(0.1), [cells; 3], BoxSplit::Six);
        let mut builder = WorldBuilder::default().with_friction(friction(mu, mu, stick_velocity)?);
        let material = Material { young: self.young_modulus_pa.value(), poisson: 0.3, density: 1000.0 };
        builder.add_solid(&cube.map_err(ExperimentError::stopped)?, material, Vec3::zeros())?;
        builder.add_half_space(HalfSpace::through(&Vec3::zeros(), &Vec3::z()));
        let weight = GRAVITY * angle.cos() / f64::from(cells + 1).powi(2);
        let contact = ContactOptions::new(ACTIVATION, Stiffness::fixed(Scale::Load(weight)));
        let options = stepping(1e-7 * stick_velocity, TimeScheme::BackwardEuler);
        let mut world = builder.build(gravity_on_slope(angle), contact, options)?;
        let steps = |time: f64| (time / h).round() as u64;
        for _ in 0..steps(self.settling_s.value()) {
            world.step(h, clock)?;
        }
        let start = world.state.position.clone();
        let measured = steps(self.duration_s.value());
        for _ in 0..measured {
            world.step(h, clock)?;
        }
        let ways = world.state.position.iter().zip(&start).map(|(x, x0)| (x - x0).norm());
        let way = ways.fold(0.0, f64::max);
        let expected = creep(stick_velocity, angle.tan() / mu) * measured as f64 * h;
        Ok(world
            .outcome()
            .error("creep", (way / expected - 1.0).abs())
            .error("way", way)
            .invariant("way (m)", way))
    }
}
