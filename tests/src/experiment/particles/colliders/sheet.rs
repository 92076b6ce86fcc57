//! A thin sheet with water on both sides: a dam that stands, a piston that starts.

use super::super::cloud::Cloud;
use super::super::method::Method;
use super::super::solver::Solver;
use super::obstacle::Section;
use super::{Balance, EXPONENT, GRAVITY, Space, add_pressed, pressure_at, ratio_at, space};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::picture::Image;
use mechanics_core::mesh::{Diagonals, TriMesh, sheet};
use mechanics_core::tensor::Vec3;
use mpm_constitutive::fluid::{Tait, Tension};
use mpm_core::{Boundary, Collider, RigidMotion, Shape, SheetMesh, Surface};
use schemars::JsonSchema;
use serde::Deserialize;

/// A channel with an upright sheet at x = 0, four cells wide; the ladder is Δx (m).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ThinSheet {
    /// What the sheet does.
    role: Role,
}

/// What the sheet does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum Role {
    /// It holds a metre of water on its left and half a metre of brine, 1.2 times as heavy, on its right, each half a metre long.
    Dam,
    /// It starts at once with a tenth of the speed of sound, in water without weight that carries no tension, a metre long on both sides.
    Piston,
}

/// On one side of the sheet.
#[derive(Clone, Copy, Debug)]
struct Water {
    /// From the sheet to the wall, with its sign \[m\].
    length: f64,
    depth: f64,
    density: f64,
}

/// c of the water \[m/s\]: ten times √(gH).
const SOUND: f64 = 31.32;
/// The piston's speed by that of sound.
const MACH: f64 = 0.1;
/// Cells across the channel.
const ACROSS: f64 = 4.0;
/// How far sound runs from the piston \[m\]; and where water is looked at, in its first places \[m\].
const RUN: f64 = 0.8;
const LOOKED_AT: f64 = 0.4;
/// The whole time of the dam, and from when on loads count \[s\].
const TIMES: [f64; 2] = [0.6, 0.2];

impl Role {
    fn waters(self, width: f64) -> [Water; 2] {
        match self {
            Self::Dam => [
                Water { length: -0.5, depth: 1.0, density: 1000.0 },
                Water { length: 0.5, depth: 0.5, density: 1200.0 },
            ],
            // Without a weight the channel is full.
            Self::Piston => [-1.0, 1.0].map(|length| Water { length, depth: width, density: 1000.0 }),
        }
    }

    fn gravity(self) -> f64 {
        match self {
            Self::Dam => GRAVITY,
            Self::Piston => 0.0,
        }
    }

    /// Of the sheet \[m/s\].
    fn velocity(self) -> f64 {
        match self {
            Self::Dam => 0.0,
            Self::Piston => MACH * SOUND,
        }
    }

    fn duration(self) -> f64 {
        match self {
            Self::Dam => TIMES[0],
            Self::Piston => RUN / SOUND,
        }
    }
}

impl Water {
    fn bulk_modulus(&self) -> f64 {
        self.density * SOUND * SOUND
    }

    /// Force on a metre of the sheet's width, and its moment about the floor, by the pressure of rest, in 1000 layers \[N/m, N\].
    fn load(&self) -> [f64; 2] {
        const LAYERS: u32 = 1000;
        let layer = self.depth / f64::from(LAYERS);
        (0..LAYERS).fold([0.0; 2], |[force, moment], k| {
            let height = layer * (f64::from(k) + 0.5);
            let push = layer * pressure_at(self.depth - height, self.density, self.bulk_modulus());
            [force + push, moment + push * height]
        })
    }
}

/// A channel with its sheet.
struct Channel {
    role: Role,
    space: Space,
    waters: [Water; 2],
    spacing: f64,
    gap: f64,
    mesh: TriMesh,
    /// The first places of each body along x.
    first: [Vec<f64>; 2],
}

impl Channel {
    fn start(role: Role, method: Method, spacing: f64) -> Result<Self, ExperimentError> {
        let mut space = space(method, spacing)?;
        space.set_gravity([0.0, 0.0, -role.gravity()]).map_err(ExperimentError::stopped)?;
        let (gap, width) = (spacing / method.along as f64, ACROSS * spacing);
        let waters = role.waters(width);
        let mut first = [Vec::new(), Vec::new()];
        for (places, water) in first.iter_mut().zip(&waters) {
            *places = add_water(&mut space, role, water, (width, gap))?;
        }
        // Waves do not get to the ends, and need no walls there.
        let [ends, lid] = match role {
            Role::Dam => [waters[1].length, f64::INFINITY],
            Role::Piston => [f64::INFINITY, width],
        };
        let walls = Shape::Walls { low: [-ends, 0.0, 0.0], high: [ends, width, lid] };
        space.add_boundary(Boundary::at_rest(walls, Surface::Slip)).map_err(ExperimentError::stopped)?;
        let height = waters[0].depth.max(waters[1].depth);
        let mesh = upright([-2.0 * width, 3.0 * width], [-0.5 * height, 1.5 * height])?;
        let thin = SheetMesh::new(&mesh).map_err(ExperimentError::stopped)?;
        let motion = RigidMotion::translation([role.velocity(), 0.0, 0.0]);
        space
            .add_collider(Collider::moving(thin, Surface::Slip, motion))
            .map_err(ExperimentError::stopped)?;
        Ok(Self { role, space, waters, spacing, gap, mesh, first })
    }

    /// Particles that are not on the side of the sheet where they began.
    fn leaked(&self) -> u64 {
        let sheet = self.role.velocity() * self.space.time();
        let leaked = |side: usize| {
            let sign = self.waters[side].length.signum();
            self.space.positions(side).iter().filter(|x| (x[0] - sheet) * sign <= 0.0).count() as u64
        };
        leaked(0) + leaked(1)
    }

    /// The largest pressure there is in rest, or what the piston makes \[Pa\].
    fn highest_pressure(&self) -> f64 {
        match self.role {
            Role::Dam => 1000.0 * GRAVITY,
            Role::Piston => shock_pressure(&self.waters[1], MACH),
        }
    }

    /// With what a standing dam must have.
    fn against_rest(&self, outcome: Outcome, (force, moment): (Vec3, Vec3)) -> Outcome {
        let width = ACROSS * self.spacing;
        let [left, right] = self.waters.map(|water| water.load().map(|load| load * width));
        let (push, lever) = (left[0] - right[0], left[1] - right[1]);
        let speed = |body: usize| {
            let totals = self.space.totals(body);
            (2.0 * totals.kinetic_energy / totals.mass).sqrt()
        };
        outcome
            .error("force on the sheet", (force.x / push - 1.0).abs())
            .error("moment on the sheet", (moment.y / lever - 1.0).abs())
            .error("force sideways", force.y.hypot(force.z) / push)
            .count("force by the closed form (‰)", (1e3 * force.x / push).round() as u64)
            .invariant("speed that is left (√(gH))", speed(0).max(speed(1)) / GRAVITY.sqrt())
    }

    /// With what a piston must do: water before it moves with it and pushes by what its shock makes of that; water behind it, which carries no tension, stays.
    fn against_shock(&self, outcome: Outcome, impulse: Vec3) -> Outcome {
        let (width, velocity) = (ACROSS * self.spacing, self.role.velocity());
        let push = shock_pressure(&self.waters[1], MACH) * width * width * self.space.time();
        let speed = |side: usize| {
            let velocities = self.space.velocities(side);
            let near = self.first[side].iter().zip(&velocities).filter(|(x, _)| x.abs() < LOOKED_AT);
            let (sum, count) = near.fold((0.0, 0), |(sum, count), (_, v)| (sum + v[0], count + 1));
            sum / f64::from(count) / velocity
        };
        outcome
            // What pushes the piston back.
            .error("impulse on the sheet", (-impulse.x / push - 1.0).abs())
            .error("speed before the sheet", (speed(1) - 1.0).abs())
            .error("speed behind the sheet", speed(0).abs())
            .count("impulse by the closed form (‰)", (-1e3 * impulse.x / push).round() as u64)
    }

    fn drawn(&self, at: &Point<'_>) -> Result<Image, ExperimentError> {
        let (mut positions, mut pressures) = (Vec::new(), Vec::new());
        for body in 0..2 {
            positions.extend(self.space.positions(body));
            let states = self.space.states(body);
            pressures.extend(states.iter().map(|s| -s.kirchhoff.trace() / 3.0 / s.volume_ratio));
        }
        let most = self.highest_pressure();
        let mut seen = self.mesh.clone();
        seen.translate(&Vec3::new(self.role.velocity() * self.space.time(), 0.0, 0.0))
            .map_err(ExperimentError::stopped)?;
        let [left, right] = self.waters;
        let section = Section {
            positions: &positions,
            values: &pressures,
            meshes: &[seen],
            front: 0.0,
            radius: 0.5 * self.gap,
            field: ("pressure", "Pa"),
            range: Some((0.0, most)),
            towards: [0.4, -1.0, 0.3],
            frame: ([left.length, 0.0, 0.0], [right.length, ACROSS * self.spacing, left.depth]),
            label: format!("{}, t = {:.4} s", at.method, self.space.time()),
        };
        Ok(section.drawn((800, 500)))
    }
}

/// The pressure before a piston that starts at once with the speed V = `mach` c in water at rest \[Pa\].
///
/// A shock of speed U runs before it, with J = 1 − V/U from the mass and p = ρ₀ U V from the momentum: p(J) (1 − J) = ρ₀ V², which falls in J.
fn shock_pressure(water: &Water, mach: f64) -> f64 {
    let bulk = water.bulk_modulus();
    let pressure = |ratio: f64| bulk / EXPONENT * (ratio.powf(-EXPONENT) - 1.0);
    let (mut low, mut high) = (0.5, 1.0);
    for _ in 0..60 {
        let ratio = 0.5 * (low + high);
        if pressure(ratio) * (1.0 - ratio) > bulk * mach * mach { low = ratio } else { high = ratio }
    }
    pressure(low)
}

/// Water at rest on one side; answers where its particles are along x.
fn add_water(
    space: &mut Space,
    role: Role,
    water: &Water,
    (width, gap): (f64, f64),
) -> Result<Vec<f64>, ExperimentError> {
    let low = [water.length.min(0.0), 0.0, 0.0];
    let high = [water.length.max(0.0), width, water.depth];
    let counts = std::array::from_fn(|a| ((high[a] - low[a]) / gap).round() as usize);
    let cloud = Cloud::cuboid(low, high, counts);
    // Without a weight nothing is pressed.
    let weight = water.density * role.gravity() / GRAVITY;
    let ratio = |x: &[f64; 3]| ratio_at(water.depth - x[2], weight, water.bulk_modulus());
    let law =
        Tait::new(water.bulk_modulus(), EXPONENT, Tension::Vanishes).map_err(ExperimentError::stopped)?;
    add_pressed(space, (law, water.density), &cloud, ratio)?;
    Ok(cloud.points.iter().map(|x| x[0]).collect())
}

/// A sheet in the plane x = 0.
fn upright(y: [f64; 2], z: [f64; 2]) -> Result<TriMesh, ExperimentError> {
    let size = [y[1] - y[0], z[1] - z[0]];
    let mut mesh = sheet(size, [3, 3], Diagonals::Alternating).map_err(ExperimentError::stopped)?;
    mesh.map_points(|p| Vec3::new(0.0, y[0] + p.x, z[0] + p.y)).map_err(ExperimentError::stopped)?;
    Ok(mesh)
}

impl Experiment for ThinSheet {
    fn methods(&self) -> &'static [&'static str] {
        Method::names()
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let (method, role) = (Method::in_double(at.method, "water")?, self.role);
        let mut channel = Channel::start(role, method, at.ladder)?;
        let mut balance = Balance::start(&channel.space);
        let (mut leaked, mut before) = (0, None);
        while channel.space.time() < role.duration() {
            let step = channel.space.stable_step().min(role.duration() - channel.space.time());
            clock.time(|| channel.space.step(step)).map_err(ExperimentError::stopped)?;
            leaked = leaked.max(channel.leaked());
            if channel.space.steps().is_multiple_of(32) {
                balance.look(&channel.space, role.gravity());
            }
            if before.is_none() && channel.space.time() >= TIMES[1] {
                before = Some((channel.space.time(), channel.space.collider_load(0).total));
            }
        }
        balance.look(&channel.space, role.gravity());
        let total = channel.space.collider_load(0).total;
        let outcome = Outcome::default()
            .invariant("particles that passed the sheet", leaked as f64)
            .invariant("change of mass", balance.worst_mass);
        let outcome = match role {
            Role::Dam => {
                let (from, before) = before.unwrap_or_default();
                let duration = channel.space.time() - from;
                let mean = |now: Vec3, before: Vec3| (now - before) / duration;
                let (force, moment) =
                    (mean(total.linear, before.linear), mean(total.angular, before.angular));
                channel.against_rest(outcome, (force, moment))
            }
            Role::Piston => channel
                .against_shock(outcome, total.linear)
                .invariant("momentum that no force gave", balance.worst),
        };
        let outcome =
            outcome.pictured(at, "the sheet and its waters, coloured by pressure", || channel.drawn(at))?;
        Ok(Solver::Double(channel.space).counted(outcome))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slow_pistons_make_sound() {
        let water = Water { length: 1.0, depth: 1.0, density: 1000.0 };
        for mach in [1e-3, 1e-2] {
            let before = shock_pressure(&water, mach);
            let sound = 1000.0 * SOUND * SOUND * mach;
            // p = ρcV (1 + ¼(γ + 1) V/c + …).
            let second = 0.25 * (EXPONENT + 1.0) * mach;
            assert!((before / sound - 1.0 - second).abs() < 10.0 * mach * mach, "{before}");
        }
    }
}
