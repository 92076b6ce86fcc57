//! Splats moved by material points.

use super::material::Material;
use super::matter::{Matter, region, vector};
use super::refused;
use crate::experiment::ExperimentError;
use crate::scene::quantity::{NonNegative, Positive};
use crate::scene::splats::{
    Binding, Collider, ColliderShape, ColliderSurface, Fill, FloorSurface, Hold, Impulse, Particles,
    SimulationBox, SplatScene, Up,
};
use gaussian_deform::bind::{Moved, SampleBinding};
use gaussian_deform::fill::{CellGrid, Direction, Filled, Rules, Source, fill};
use gaussian_deform::select;
use mechanics_core::checkpoint::Checkpoint;
use mechanics_core::mesh::BoundingBox;
use mechanics_core::samples::DeformationSamples;
use mechanics_core::tensor::{Mat3, Vec3};
use mpm_core::{
    Boundary, DeformationBuffer, Grip, ResumeError, Samples, Shape, Simulation, SimulationOptions, Surface,
    Totals,
};

/// A simulation of particles, and how its particles move splats.
pub(super) struct ParticleDrive {
    simulation: Simulation<f64, 3>,
    /// Which samples the particles of each body are.
    bodies: Vec<Vec<u32>>,
    /// Positions and deformations of all samples: splats first, if each is a particle.
    positions: Vec<Vec3>,
    gradients: Vec<Mat3>,
    volumes: Vec<f64>,
    masses: Vec<f64>,
    buffer: DeformationBuffer,
    /// How splats move with samples, if they are none themselves.
    binding: Option<SampleBinding>,
    moved: Moved,
    splats: usize,
    blows: Vec<Blow>,
    /// Time \[s\], without the rounding of its steps.
    now: f64,
    /// Where conditions change \[s\], ascending.
    events: Vec<f64>,
    pub(super) gravity: Vec3,
    /// What the set-up found.
    pub(super) made: Made,
}

/// What was made of the splats.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Made {
    /// Particles.
    pub(crate) particles: usize,
    /// Of these, those that fill cells that were not full, or behind the surface.
    pub(crate) filling: usize,
    /// Splats too flat, or too large, for the filling's grid.
    pub(crate) clamped: usize,
    /// Distance of nodes \[m\].
    pub(crate) spacing: f64,
}

/// A particle's number and the impulse it gets \[N s\].
type Hit = (usize, [f64; 3]);

/// An impulse, resolved.
struct Blow {
    time: f64,
    /// By body.
    on: Vec<(usize, Vec<Hit>)>,
}

/// What a body of particles starts from.
struct Cloud {
    points: Vec<Vec3>,
    volumes: Vec<f64>,
    splats: usize,
    made: Made,
}

/// Cells of the grid along the matter, where a scene does not say.
const CELLS: f64 = 32.0;
/// Filling takes splats as at least so thick, in its cells: those of surfaces are much thinner than cells, and would not be seen from any corner of one.
const THINNEST: f64 = 0.4;
/// Samples that move a splat, where samples are fewer.
const NEIGHBOURS: usize = 8;

impl ParticleDrive {
    /// Particles in and of `matter`, at rest.
    pub(super) fn new(given: &SplatScene, matter: &Matter) -> Result<Self, ExperimentError> {
        let particles = given.particles.clone().unwrap_or_default();
        let cells = particles.cells.map_or(CELLS, |cells| cells.value() as f64);
        let spacing = matter.bounds.size().max() / cells;
        let failed = |error| refused("splats.particles.cells", error);
        let mut simulation = Simulation::new(SimulationOptions::new(spacing)).map_err(failed)?;
        let gravity = particles.gravity_m_s2.map_or(Vec3::z() * -9.81, |g| vector(&g));
        simulation.set_gravity(gravity.into()).map_err(|e| refused("splats.particles.gravity_m_s2", e))?;
        let cloud = cloud(&particles, matter, spacing)?;
        let (bodies, masses) = add_bodies(&mut simulation, given, &particles, (matter, &cloud))?;
        add_obstacles(&mut simulation, &particles)?;
        let mut events = Vec::new();
        add_holds(&mut simulation, &particles.holds, &cloud.points, &mut events)?;
        let blows = blows(&particles.impulses, (&cloud.points, &masses), &bodies, &mut events)?;
        events.sort_by(f64::total_cmp);
        let binding = match particles.binding {
            Binding::EachSplat => None,
            Binding::Embedded => {
                let means = select::means(&matter.splats, &matter.list);
                let means: Vec<Vec3> = means.iter().map(|x| matter.place.point(x)).collect();
                let binding = SampleBinding::new(&cloud.points, &means, NEIGHBOURS);
                Some(binding.map_err(|error| refused("splats.particles.binding", error))?)
            }
        };
        let count = cloud.points.len();
        Ok(Self {
            simulation,
            bodies,
            positions: cloud.points,
            gradients: vec![Mat3::identity(); count],
            volumes: cloud.volumes,
            masses,
            buffer: DeformationBuffer::default(),
            binding,
            moved: Moved::new(),
            splats: cloud.splats,
            blows,
            now: 0.0,
            events,
            gravity,
            made: cloud.made,
        })
    }

    /// Goes on to `time` \[s\]; answers the steps that it took.
    pub(super) fn advance_to(&mut self, time: f64) -> Result<u64, ExperimentError> {
        let mut steps = 0;
        while self.now < time {
            let now = self.now;
            for blow in self.blows.iter().filter(|blow| blow.time == now) {
                for (body, impulses) in &blow.on {
                    self.simulation.apply_impulses(*body, impulses).map_err(ExperimentError::stopped)?;
                }
            }
            let next = self.events.iter().copied().find(|event| *event > now).map_or(time, |e| e.min(time));
            steps += self.simulation.advance(next - now).map_err(ExperimentError::stopped)?.steps;
            self.now = next;
        }
        Ok(steps)
    }

    /// Where the splats are now, and how they are deformed: this is all that moves them.
    pub(super) fn samples(&mut self) -> Result<DeformationSamples<'_>, ExperimentError> {
        for (body, members) in self.bodies.iter().enumerate() {
            let samples = self.simulation.deformation_samples(body, &mut self.buffer);
            let samples = samples.map_err(ExperimentError::stopped)?;
            for (k, &sample) in members.iter().enumerate() {
                self.positions[sample as usize] = samples.positions()[k];
                self.gradients[sample as usize] = samples.gradients()[k];
            }
        }
        let all = DeformationSamples::new(&self.positions, &self.gradients);
        match &self.binding {
            None => {
                let splats = self.splats;
                Ok(DeformationSamples::new(&self.positions[..splats], &self.gradients[..splats]))
            }
            Some(binding) => {
                binding.move_into(all, &mut self.moved).map_err(ExperimentError::stopped)?;
                Ok(self.moved.samples())
            }
        }
    }

    /// What each body's particles add up to.
    pub(super) fn totals(&self) -> Vec<Totals> {
        (0..self.bodies.len()).map(|body| self.simulation.totals(body)).collect()
    }

    /// The centre of mass \[m\].
    pub(super) fn centre(&self) -> Vec3 {
        let (mut sum, mut mass) = (Vec3::zeros(), 0.0);
        for (sample, m) in self.positions.iter().zip(&self.masses) {
            sum += sample * *m;
            mass += m;
        }
        sum / mass
    }

    /// The smallest det F of the total deformation.
    pub(super) fn smallest_volume_ratio(&self) -> f64 {
        self.gradients.iter().map(Mat3::determinant).fold(f64::INFINITY, f64::min)
    }

    /// Positions and total deformations of all samples, those of the filling too, as of the last [`samples`](Self::samples).
    pub(super) fn all(&self) -> DeformationSamples<'_> {
        DeformationSamples::new(&self.positions, &self.gradients)
    }

    /// Volumes of all samples at rest \[m³\].
    pub(super) fn volumes(&self) -> &[f64] {
        &self.volumes
    }

    /// What must be kept to go on.
    pub(super) fn checkpoint(&self) -> Checkpoint {
        let mut checkpoint = self.simulation.checkpoint();
        checkpoint.put_one("now", self.now);
        checkpoint
    }

    /// Goes on from a checkpoint.
    pub(super) fn resume(&mut self, mut checkpoint: Checkpoint) -> Result<(), ResumeError> {
        let now = checkpoint.take_one("now")?;
        self.simulation.resume(checkpoint)?;
        self.now = now;
        Ok(())
    }
}

/// The splats of the matter as filling sees them, in the simulation.
fn sources(matter: &Matter) -> Vec<Source> {
    let turn = matter.place.rotation() * matter.place.scale();
    let source = |&i: &u32| {
        let splat = matter.splats.splat(i as usize);
        Source {
            mean: matter.place.point(&splat.mean.cast()),
            axes: turn * splat.axes.cast::<f64>(),
            opacity: splat.opacity.into(),
        }
    };
    matter.list.iter().map(source).collect()
}

/// The filling's grid: cells of half the simulation's, around the matter.
fn cells(bounds: &BoundingBox, cell: f64) -> CellGrid {
    const MARGIN: f64 = 3.0;
    let counts = |k: usize| (bounds.size()[k] / cell + 2.0 * MARGIN).ceil() as usize;
    CellGrid { origin: bounds.min.add_scalar(-MARGIN * cell), cell, counts: [0, 1, 2].map(counts) }
}

/// The filling's rules, and whether it fills.
fn rules(given: Fill) -> Rules {
    match given {
        Fill::Inside => Rules { particles_per_cell: 1, thinnest: THINNEST, ..Rules::default() },
        // Nothing is dense enough: cells only share their volume.
        Fill::Nothing => Rules {
            density_threshold: f64::INFINITY,
            search_threshold: f64::INFINITY,
            particles_per_cell: 1,
            ..Rules::default()
        },
        Fill::Rules { particles_per_cell, density_threshold, search_threshold, open } => Rules {
            particles_per_cell: particles_per_cell.value() as u32,
            density_threshold: density_threshold.value(),
            search_threshold: search_threshold.value(),
            excluded: open.map(|open| match open {
                Up::PlusX => Direction::PlusX,
                Up::MinusX => Direction::MinusX,
                Up::PlusY => Direction::PlusY,
                Up::MinusY => Direction::MinusY,
                Up::PlusZ => Direction::PlusZ,
                Up::MinusZ => Direction::MinusZ,
            }),
            thinnest: THINNEST,
            ..Rules::default()
        },
    }
}

/// The particles of the matter at rest.
fn cloud(given: &Particles, matter: &Matter, spacing: f64) -> Result<Cloud, ExperimentError> {
    let (sources, grid) = (sources(matter), cells(&matter.bounds, 0.5 * spacing));
    let filled =
        fill(&sources, &grid, &rules(given.fill)).map_err(|e| refused("splats.particles.cells", e))?;
    let mut cloud = match given.binding {
        Binding::EachSplat => Cloud {
            points: sources
                .iter()
                .map(|source| source.mean)
                .chain(filled.positions.iter().copied())
                .collect(),
            splats: sources.len(),
            made: Made { filling: filled.positions.len(), ..Made::default() },
            volumes: filled.volumes,
        },
        Binding::Embedded => lattice(&sources, &grid, &filled),
    };
    cloud.made.particles = cloud.points.len();
    cloud.made.clamped = filled.clamped.len();
    cloud.made.spacing = spacing;
    Ok(cloud)
}

/// A particle in the middle of every cell that has matter.
fn lattice(sources: &[Source], grid: &CellGrid, filled: &Filled) -> Cloud {
    let mut has_matter = vec![false; grid.cells()];
    let occupied = sources.iter().filter_map(|source| grid.cell_of(&source.mean));
    let new = filled.topped_up.iter().chain(&filled.inner).map(|&cell| cell as usize);
    occupied.chain(new).for_each(|cell| has_matter[cell] = true);
    let middle =
        |cell: usize| grid.origin + Vec3::from(grid.indices(cell).map(|i| i as f64 + 0.5)) * grid.cell;
    let points: Vec<Vec3> = (0..grid.cells()).filter(|&cell| has_matter[cell]).map(middle).collect();
    Cloud {
        volumes: vec![grid.cell.powi(3); points.len()],
        splats: 0,
        made: Made { filling: points.len(), ..Made::default() },
        points,
    }
}

/// Divides the particles among the materials; answers which particles each body has, and all masses.
fn add_bodies(
    simulation: &mut Simulation<f64, 3>,
    given: &SplatScene,
    particles: &Particles,
    (matter, cloud): (&Matter, &Cloud),
) -> Result<(Vec<Vec<u32>>, Vec<f64>), ExperimentError> {
    let regions: Vec<select::Region> = given.parts.iter().map(|part| region(&part.region)).collect();
    let mut members = vec![Vec::new(); regions.len() + 1];
    for (k, y) in cloud.points.iter().enumerate() {
        let x = matter.place.point_back(y);
        let first = regions.iter().position(|region| region.contains(&x));
        members[first.unwrap_or(regions.len())].push(k as u32);
    }
    if let Some(empty) = members[..regions.len()].iter().position(Vec::is_empty) {
        return Err(refused(format!("splats.parts.{empty}.region"), "there is no matter in it"));
    }
    let mut materials: Vec<(String, Material)> = given
        .parts
        .iter()
        .enumerate()
        .map(|(i, part)| {
            (format!("splats.parts.{i}"), Material::new(part.material, part.law, part.density_kg_m3))
        })
        .collect();
    materials.push(("splats".to_owned(), Material::new(given.material, given.law, given.density_kg_m3)));
    let velocity = particles.velocity_m_s.map_or(Vec3::zeros(), |v| vector(&v)).into();
    let mut masses = vec![0.0; cloud.points.len()];
    let mut bodies = Vec::new();
    for (members, (key, material)) in members.into_iter().zip(&materials) {
        if members.is_empty() {
            continue;
        }
        let positions: Vec<[f64; 3]> = members.iter().map(|&k| cloud.points[k as usize].into()).collect();
        let volumes: Vec<f64> = members.iter().map(|&k| cloud.volumes[k as usize]).collect();
        let velocities = vec![velocity; positions.len()];
        let samples = Samples { positions: &positions, velocities: &velocities, volumes: &volumes };
        material.add_body(simulation, samples, key)?;
        members.iter().for_each(|&k| masses[k as usize] = material.density() * cloud.volumes[k as usize]);
        bodies.push(members);
    }
    Ok((bodies, masses))
}

fn add_obstacles(simulation: &mut Simulation<f64, 3>, particles: &Particles) -> Result<(), ExperimentError> {
    let floor = match particles.floor.surface {
        FloorSurface::None => None,
        FloorSurface::Sticky => Some(Surface::Sticky),
        FloorSurface::Separating => Some(Surface::Separating),
        FloorSurface::Friction(coefficient) => Some(Surface::Friction(coefficient.value())),
    };
    if let Some(surface) = floor {
        let plane = Shape::HalfSpace { point: [0.0; 3], normal: [0.0, 0.0, 1.0] };
        simulation
            .add_boundary(Boundary::at_rest(plane, surface))
            .map_err(|e| refused("splats.particles.floor", e))?;
    }
    for (i, collider) in particles.colliders.iter().enumerate() {
        let key = format!("splats.particles.colliders.{i}");
        let boundary = boundary(collider)
            .ok_or_else(|| refused(format!("{key}.shape.half-space.normal"), "must not be zero"))?;
        simulation.add_boundary(boundary).map_err(|error| refused(key, error))?;
    }
    Ok(())
}

/// A collider as the simulation has it; `None` for a normal without direction.
fn boundary(given: &Collider) -> Option<Boundary<3>> {
    let point = |v| <[f64; 3]>::from(vector(v));
    let shape = match &given.shape {
        ColliderShape::HalfSpace { point_m, normal } => {
            let normal = vector(normal).try_normalize(0.0)?;
            Shape::HalfSpace { point: point(point_m), normal: normal.into() }
        }
        ColliderShape::Ball { centre_m, radius_m } => {
            Shape::Ball { centre: point(centre_m), radius: radius_m.value() }
        }
        ColliderShape::Box { centre_m, half_sides_m } => {
            Shape::Cuboid { centre: point(centre_m), half: half_sides_m.map(Positive::value) }
        }
        ColliderShape::Capsule { from_m, to_m, radius_m } => {
            Shape::Capsule { from: point(from_m), to: point(to_m), radius: radius_m.value() }
        }
    };
    let surface = match given.surface {
        ColliderSurface::Sticky => Surface::Sticky,
        ColliderSurface::Slip => Surface::Slip,
        ColliderSurface::Separating => Surface::Separating,
        ColliderSurface::Friction(coefficient) => Surface::Friction(coefficient.value()),
    };
    let velocity = given.velocity_m_s.as_ref().map_or([0.0; 3], point);
    Some(Boundary { shape, surface, velocity })
}

/// The particles at rest in a box.
fn selected(key: &str, select: &SimulationBox, points: &[Vec3]) -> Result<Vec<u32>, ExperimentError> {
    let bounds = BoundingBox { min: vector(&select.min_m), max: vector(&select.max_m) };
    let inside = |x: &Vec3| (0..3).all(|k| bounds.min[k] <= x[k] && x[k] <= bounds.max[k]);
    let found: Vec<u32> =
        (0..points.len() as u32).filter(|&particle| inside(&points[particle as usize])).collect();
    if found.is_empty() {
        let all = BoundingBox::of(points).map_or_else(String::new, |all| {
            let [low, high]: [[f64; 3]; 2] = [all.min.into(), all.max.into()];
            format!("; matter is between {low:.3?} and {high:.3?}")
        });
        return Err(refused(format!("{key}.select"), format!("there is no matter in the box{all}")));
    }
    Ok(found)
}

fn add_holds(
    simulation: &mut Simulation<f64, 3>,
    holds: &[Hold],
    points: &[Vec3],
    events: &mut Vec<f64>,
) -> Result<(), ExperimentError> {
    for (i, hold) in holds.iter().enumerate() {
        let key = format!("splats.particles.holds.{i}");
        selected(&key, &hold.select, points)?;
        let (low, high) = (vector(&hold.select.min_m), vector(&hold.select.max_m));
        let centre: [f64; 3] = ((low + high) * 0.5).into();
        let from = hold.from_s.map_or(0.0, NonNegative::value);
        let until = hold.until_s.map_or(f64::INFINITY, Positive::value);
        let grip = Grip {
            region: Shape::Cuboid { centre, half: ((high - low) * 0.5).into() },
            centre,
            velocity: hold.velocity_m_s.map_or([0.0; 3], |v| vector(&v).into()),
            angular_velocity: hold.angular_velocity_rad_s.map_or([0.0; 3], |v| vector(&v).into()),
            from,
            until,
        };
        simulation.add_grip(grip).map_err(|error| refused(key, error))?;
        events.extend([from, until].into_iter().filter(|time| time.is_finite()));
    }
    Ok(())
}

fn blows(
    impulses: &[Impulse],
    (points, masses): (&[Vec3], &[f64]),
    bodies: &[Vec<u32>],
    events: &mut Vec<f64>,
) -> Result<Vec<Blow>, ExperimentError> {
    let mut blows = Vec::with_capacity(impulses.len());
    for (i, impulse) in impulses.iter().enumerate() {
        let found = selected(&format!("splats.particles.impulses.{i}"), &impulse.select, points)?;
        let mass: f64 = found.iter().map(|&k| masses[k as usize]).sum();
        let velocity = vector(&impulse.impulse_n_s) / mass;
        let on = |members: &Vec<u32>| -> Vec<(usize, [f64; 3])> {
            let hit = members.iter().enumerate().filter(|(_, k)| found.binary_search(k).is_ok());
            hit.map(|(particle, &k)| (particle, (velocity * masses[k as usize]).into())).collect()
        };
        blows.push(Blow {
            time: impulse.at_s.value(),
            on: bodies.iter().map(on).enumerate().filter(|(_, hit)| !hit.is_empty()).collect(),
        });
        events.push(impulse.at_s.value());
    }
    Ok(blows)
}
