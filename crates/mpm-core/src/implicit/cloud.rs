//! The particles as the solve sees them, in double precision, and their passes between nodes and particles.

use super::law::{Point, StepLaw};
use crate::Kernel;
use crate::body::{Body, StepSettings, in_arena};
use crate::grid::Fields;
use crate::neighbourhood::{
    GatherScratch, Gift, Places, Wanted, arena_length, gather, most_velocities, scatter, velocities_length,
};
use crate::particles::load;
use mechanics_core::lanes::{Element, LaneKernel, Packet, dispatch};
use mechanics_core::parallel;
use mechanics_core::tensor::Mat3;
use mpm_constitutive::Motion;

/// Lanes of a pack.
const LANES: usize = 4;

/// Particles of one law in one block of cells.
struct CloudBlock<'a, const D: usize> {
    law: &'a dyn StepLaw,
    body: usize,
    origin: [i32; D],
    /// Its packs; the last one may have free lanes.
    packs: std::ops::Range<usize>,
    count: usize,
    /// Where the numbers of strain and history of its first particle are, and how many there are of both.
    numbers: usize,
    strain: usize,
    history: usize,
}

/// All particles, pack by pack, in the order of the arenas.
pub(super) struct Cloud<'a, const D: usize> {
    settings: StepSettings,
    blocks: Vec<CloudBlock<'a, D>>,
    /// Particle of every lane.
    ids: Vec<u32>,
    volumes: Vec<f64>,
    numbers: Vec<f64>,
    positions: Vec<f64>,
    /// G = h∇v, D² numbers a pack, by column.
    increments: Vec<f64>,
    /// V₀ ∂W/∂G likewise.
    stresses: Vec<f64>,
    /// V₀ ∂²W/∂G², the lower triangle of D²×D².
    tangents: Vec<f64>,
    /// Ends of the blocks: in increments, tangents and arenas.
    increment_ends: Vec<usize>,
    tangent_ends: Vec<usize>,
    arena_ends: Vec<usize>,
    /// One a block: what parallel passes answer.
    unit: Vec<()>,
    arenas: Vec<f64>,
}

/// Numbers of a symmetric matrix over G.
const fn tangent_count(dimension: usize) -> usize {
    let square = dimension * dimension;
    square * (square + 1) / 2
}

impl<'a, const D: usize> Cloud<'a, D> {
    pub(super) fn new<E: Element>(bodies: &'a [Body<E, D>], settings: StepSettings) -> Self {
        let mut cloud = Self {
            settings,
            blocks: Vec::new(),
            ids: Vec::new(),
            volumes: Vec::new(),
            numbers: Vec::new(),
            positions: Vec::new(),
            increments: Vec::new(),
            stresses: Vec::new(),
            tangents: Vec::new(),
            increment_ends: Vec::new(),
            tangent_ends: Vec::new(),
            arena_ends: Vec::new(),
            unit: Vec::new(),
            arenas: Vec::new(),
        };
        for (number, body) in bodies.iter().enumerate() {
            cloud.add_body(number, body);
        }
        let packs = cloud.blocks.last().map_or(0, |block| block.packs.end);
        cloud.increments = vec![0.0; packs * D * D * LANES];
        cloud.stresses = cloud.increments.clone();
        cloud.increment_ends = cloud.blocks.iter().map(|block| block.packs.end * D * D * LANES).collect();
        cloud.tangent_ends =
            cloud.blocks.iter().map(|block| block.packs.end * tangent_count(D) * LANES).collect();
        let length = arena_length(D, settings.kernel.width());
        cloud.arena_ends = (1..=cloud.blocks.len()).map(|k| k * length).collect();
        cloud.arenas = vec![0.0; cloud.blocks.len() * length];
        cloud.unit = vec![(); cloud.blocks.len()];
        cloud
    }

    fn add_body<E: Element>(&mut self, number: usize, body: &'a Body<E, D>) {
        let particles = &body.particles;
        let layout = &particles.layout;
        let (strain, history) = (layout.history - layout.strain, layout.stress - layout.history);
        let mut slot = 0;
        for block in &particles.blocks {
            let first = self.ids.len() / LANES;
            let packs = first..first + block.count.div_ceil(LANES);
            let numbers = self.numbers.len();
            for lane in 0..packs.len() * LANES {
                let source = slot + lane.min(block.count - 1);
                self.ids.push(particles.ids[source]);
                self.volumes.push(particles.number(source, layout.volume).into());
                if lane < block.count {
                    self.numbers.extend(
                        (layout.strain..layout.stress)
                            .map(|k| Into::<f64>::into(particles.number(source, k))),
                    );
                }
            }
            for pack in 0..packs.len() {
                for axis in 0..D {
                    for lane in 0..LANES {
                        let source = slot + (pack * LANES + lane).min(block.count - 1);
                        self.positions.push(particles.number(source, axis).into());
                    }
                }
            }
            self.blocks.push(CloudBlock {
                law: body.step_law(),
                body: number,
                origin: block.origin,
                packs,
                count: block.count,
                numbers,
                strain,
                history,
            });
            slot = block.end * E::LANES;
        }
    }

    /// G of every particle for the velocities of a field.
    pub(super) fn gather(&mut self, grid: &dyn Fields, field: &[f64]) {
        let mut increments = std::mem::take(&mut self.increments);
        let mut unit = std::mem::take(&mut self.unit);
        parallel::for_each_part(&mut increments, &self.increment_ends, &mut unit, |block, increments, ()| {
            self.with_nodes(grid, block, field, &mut |nodes| {
                self.pass(
                    block,
                    Job { nodes: Some(nodes), increments: Some(&mut *increments), ..Job::default() },
                );
            });
        });
        (self.increments, self.unit) = (increments, unit);
    }

    /// Σ V₀ W over all particles \[J\].
    pub(super) fn energy(&self) -> f64 {
        let sums = parallel::map_chunks(self.blocks.len(), 1, |blocks| {
            let mut sum = 0.0;
            for block in blocks {
                self.for_each_particle(block, |k, motion, point| {
                    sum += self.volumes[k] * self.blocks[block].law.energy(&point, &motion);
                });
            }
            sum
        });
        sums.into_iter().sum()
    }

    /// The first particle, by body and number, whose energy is not finite, and det(I + G) of it.
    pub(super) fn first_inadmissible(&self) -> Option<(usize, usize, f64)> {
        let mut first: Option<(usize, usize, f64)> = None;
        for (number, block) in self.blocks.iter().enumerate() {
            self.for_each_particle(number, |k, motion, point| {
                let found = (block.body, self.ids[k] as usize);
                if !block.law.energy(&point, &motion).is_finite()
                    && first.is_none_or(|(body, particle, _)| found < (body, particle))
                {
                    let ratio = (Mat3::identity() + motion.velocity_gradient * motion.step).determinant();
                    first = Some((found.0, found.1, ratio));
                }
            });
        }
        first
    }

    /// The forces of the stress, h Σ V₀ ∂W/∂G ∇wᵢ, in the arenas.
    pub(super) fn scatter_stress(&mut self) {
        let mut stresses = std::mem::take(&mut self.stresses);
        let mut unit = std::mem::take(&mut self.unit);
        parallel::for_each_part(&mut stresses, &self.increment_ends, &mut unit, |block, stresses, ()| {
            let first = self.blocks[block].packs.start * LANES;
            self.for_each_particle(block, |k, motion, point| {
                let stress = self.blocks[block].law.stress(&point, &motion) * self.volumes[k];
                let (pack, lane) = ((k - first) / LANES, k % LANES);
                for n in 0..D * D {
                    stresses[(pack * D * D + n) * LANES + lane] = stress[(n % D, n / D)];
                }
            });
        });
        let mut arenas = std::mem::take(&mut self.arenas);
        parallel::for_each_part(&mut arenas, &self.arena_ends, &mut unit, |block, arena, ()| {
            arena.fill(0.0);
            let packs = &self.blocks[block].packs;
            let stresses = &stresses[packs.start * D * D * LANES..packs.end * D * D * LANES];
            self.pass(block, Job { stresses: Some(stresses), arena: Some(arena), ..Job::default() });
        });
        (self.stresses, self.arenas, self.unit) = (stresses, arenas, unit);
    }

    /// Σ V₀ |∂W/∂G| over all entries at the last scatter \[J\]: what a relative change of F makes of the energy.
    pub(super) fn stress_size(&self) -> f64 {
        parallel::sum(self.stresses.len(), 4096, |k| self.stresses[k].abs())
    }

    /// Curvatures at the present G.
    pub(super) fn update_tangents(&mut self) {
        let count = tangent_count(D);
        let packs = self.blocks.last().map_or(0, |block| block.packs.end);
        let mut tangents = std::mem::take(&mut self.tangents);
        tangents.resize(packs * count * LANES, 0.0);
        let mut unit = std::mem::take(&mut self.unit);
        parallel::for_each_part(&mut tangents, &self.tangent_ends, &mut unit, |block, tangents, ()| {
            let first = self.blocks[block].packs.start * LANES;
            let mut curvature = [[0.0; 9]; 9];
            self.for_each_particle(block, |k, motion, point| {
                self.blocks[block].law.curvature_into(&point, &motion, D, &mut curvature);
                let (pack, lane) = ((k - first) / LANES, k % LANES);
                let mut n = 0;
                for row in 0..D * D {
                    for column in 0..=row {
                        tangents[(pack * count + n) * LANES + lane] =
                            self.volumes[k] * curvature[row][column];
                        n += 1;
                    }
                }
            });
        });
        (self.tangents, self.unit) = (tangents, unit);
    }

    /// The change of the forces for a change of the velocities, in the arenas.
    pub(super) fn product(&mut self, grid: &dyn Fields, field: &[f64]) {
        let mut arenas = std::mem::take(&mut self.arenas);
        let mut unit = std::mem::take(&mut self.unit);
        let count = tangent_count(D) * LANES;
        parallel::for_each_part(&mut arenas, &self.arena_ends, &mut unit, |block, arena, ()| {
            arena.fill(0.0);
            let packs = &self.blocks[block].packs;
            let tangents = &self.tangents[packs.start * count..packs.end * count];
            self.with_nodes(grid, block, field, &mut |nodes| {
                self.pass(
                    block,
                    Job {
                        nodes: Some(nodes),
                        tangents: Some(tangents),
                        arena: Some(&mut *arena),
                        ..Job::default()
                    },
                );
            });
        });
        (self.arenas, self.unit) = (arenas, unit);
    }

    pub(super) fn arenas(&self) -> &[f64] {
        &self.arenas
    }

    /// Replaces the arenas, of `stride` numbers each, by what `fill` makes of each block.
    pub(super) fn fill_arenas(&mut self, fill: impl Fn(&Self, usize, &mut [f64]) + Sync) {
        let mut arenas = std::mem::take(&mut self.arenas);
        let mut unit = std::mem::take(&mut self.unit);
        parallel::for_each_part(&mut arenas, &self.arena_ends, &mut unit, |block, arena, ()| {
            arena.fill(0.0);
            fill(self, block, arena);
        });
        (self.arenas, self.unit) = (arenas, unit);
    }

    /// Where the particles of a block are from the lowest node of its arena \[cells\], and V₀ ∂²W/∂G² of each.
    pub(super) fn for_each_tangent(&self, block: usize, mut visit: impl FnMut([f64; D], &[f64])) {
        let CloudBlock { origin, packs, count, .. } = &self.blocks[block];
        let numbers = tangent_count(D);
        let mut tangent = [0.0; 45];
        for k in 0..*count {
            let (pack, lane) = (packs.start + k / LANES, k % LANES);
            let position = std::array::from_fn(|axis| self.positions[(pack * D + axis) * LANES + lane]);
            for n in 0..numbers {
                tangent[n] = self.tangents[(pack * numbers + n) * LANES + lane];
            }
            visit(crate::traction::cells(&position, origin, self.settings.spacing), &tangent[..numbers]);
        }
    }

    /// Calls `work` with lane, motion and begin of every particle of a block.
    fn for_each_particle(&self, block: usize, mut work: impl FnMut(usize, Motion<f64>, Point<'_>)) {
        let CloudBlock { packs, count, numbers, strain, history, .. } = &self.blocks[block];
        let scale = 1.0 / self.settings.step;
        for k in 0..*count {
            let (pack, lane) = (packs.start + k / LANES, k % LANES);
            let increment = &self.increments[pack * D * D * LANES..];
            let velocity_gradient = Mat3::from_fn(|a, b| match a < D && b < D {
                true => scale * increment[(b * D + a) * LANES + lane],
                false => 0.0,
            });
            let own = &self.numbers[numbers + k * (strain + history)..][..strain + history];
            let point = Point { strain: &own[..*strain], history: &own[*strain..] };
            work(packs.start * LANES + k, Motion { velocity_gradient, step: self.settings.step }, point);
        }
    }

    /// Calls `work` with the arena of a field around a block.
    fn with_nodes(&self, grid: &dyn Fields, block: usize, field: &[f64], work: &mut dyn FnMut(&[f64])) {
        let length = velocities_length(D, self.settings.kernel.width());
        if D == 2 {
            let mut arena = [0.0; most_velocities(2)];
            grid.fill_from_field(block, field, &mut arena[..length]);
            work(&arena[..length]);
        } else {
            let mut arena = [0.0; most_velocities(3)];
            grid.fill_from_field(block, field, &mut arena[..length]);
            work(&arena[..length]);
        }
    }

    fn pass(&self, block: usize, job: Job<'_>) {
        let CloudBlock { origin, packs, count, .. } = &self.blocks[block];
        let positions = &self.positions[packs.start * D * LANES..packs.end * D * LANES];
        let pass = Pass { positions, origin: *origin, count: *count, settings: &self.settings, job };
        match (self.settings.kernel, self.settings.transfer.uses_gradients()) {
            (Kernel::Linear, _) => dispatch(PassOf::<D, 2, true>(pass)),
            (Kernel::Quadratic, true) => dispatch(PassOf::<D, 3, true>(pass)),
            (Kernel::Quadratic, false) => dispatch(PassOf::<D, 3, false>(pass)),
            (Kernel::Cubic, true) => dispatch(PassOf::<D, 4, true>(pass)),
            (Kernel::Cubic, false) => dispatch(PassOf::<D, 4, false>(pass)),
        }
    }
}

/// What a pass over a block's particles reads and writes.
#[derive(Default)]
struct Job<'a> {
    /// Takes G from these nodes.
    nodes: Option<&'a [f64]>,
    /// Writes G here.
    increments: Option<&'a mut [f64]>,
    /// Makes stresses of G with these.
    tangents: Option<&'a [f64]>,
    /// Or reads them here.
    stresses: Option<&'a [f64]>,
    /// Gives the forces of the stresses to these nodes.
    arena: Option<&'a mut [f64]>,
}

struct Pass<'a, const D: usize> {
    positions: &'a [f64],
    origin: [i32; D],
    count: usize,
    settings: &'a StepSettings,
    job: Job<'a>,
}

struct PassOf<'a, const D: usize, const W: usize, const GRADIENTS: bool>(Pass<'a, D>);

impl<const D: usize, const W: usize, const GRADIENTS: bool> LaneKernel<f64> for PassOf<'_, D, W, GRADIENTS> {
    type Output = ();

    #[inline(always)]
    fn run<P: Packet<Element = f64>>(self) {
        let Pass { positions, origin, count, settings, mut job } = self.0;
        let moment = settings.kernel.second_moment().unwrap_or(f64::INFINITY);
        // h times the gradient's factor: of G for velocities, and of nodes' forces for stresses.
        let factor = settings.step / settings.spacing * if GRADIENTS { 1.0 } else { 1.0 / moment };
        let mut scratch = GatherScratch::<P, W>::new();
        let square = D * D * P::LANES;
        for (k, position) in positions.chunks_exact(D * P::LANES).enumerate() {
            let position = load::<P, D>(position, 0);
            let places = Places::<P, D, W>::new(&in_arena(&position, &origin, settings.spacing));
            let alive = count - k * P::LANES;
            let mut g = [[P::constant(0.0); D]; D];
            if let Some(nodes) = job.nodes {
                g = gradient::<P, D, W, GRADIENTS>(nodes, &places, alive, factor, &mut scratch);
            }
            if let Some(increments) = &mut job.increments {
                let target = &mut increments[k * square..][..square];
                for axis in 0..D {
                    for a in 0..D {
                        g[axis][a].store(&mut target[(axis * D + a) * P::LANES..][..P::LANES]);
                    }
                }
            }
            if let Some(tangents) = job.tangents {
                let count = tangent_count(D) * P::LANES;
                g = curved::<P, D>(&tangents[k * count..][..count], &g);
            } else if let Some(stresses) = job.stresses {
                for axis in 0..D {
                    g[axis] = load::<P, D>(&stresses[k * square..], axis * D);
                }
            }
            if let Some(arena) = &mut job.arena {
                give::<P, D, W, GRADIENTS>(arena, &places, alive, factor, g);
            }
        }
    }
}

/// `factor` times the sums that make a gradient, by column.
#[inline(always)]
fn gradient<P: Packet<Element = f64>, const D: usize, const W: usize, const GRADIENTS: bool>(
    nodes: &[f64],
    places: &Places<P, D, W>,
    alive: usize,
    factor: f64,
    scratch: &mut GatherScratch<P, W>,
) -> [[P; D]; D] {
    let wanted = if GRADIENTS { Wanted::Slopes } else { Wanted::Moments };
    let sums = gather(nodes, places, wanted, alive, scratch);
    let mut gradient = [[P::constant(0.0); D]; D];
    for axis in 0..D {
        for a in 0..D {
            let sum = if GRADIENTS {
                sums.slopes[axis][a]
            } else {
                (-places.fraction[axis]).mul_add(sums.velocity[a], sums.moments[axis][a])
            };
            gradient[axis][a] = sum.scale(factor);
        }
    }
    gradient
}

/// A symmetric matrix of D²×D² numbers, of which the lower triangle is given, times a matrix.
#[inline(always)]
fn curved<P: Packet<Element = f64>, const D: usize>(tangent: &[f64], g: &[[P; D]; D]) -> [[P; D]; D] {
    let mut stress = [[P::constant(0.0); D]; D];
    let mut n = 0;
    for row in 0..D * D {
        for column in 0..=row {
            let entry = P::load(&tangent[n * P::LANES..][..P::LANES]);
            n += 1;
            let (r, c) = ([row / D, row % D], [column / D, column % D]);
            stress[r[0]][r[1]] = entry.mul_add(g[c[0]][c[1]], stress[r[0]][r[1]]);
            if row != column {
                stress[c[0]][c[1]] = entry.mul_add(g[r[0]][r[1]], stress[c[0]][c[1]]);
            }
        }
    }
    stress
}

/// Adds `factor` · stress · gradients of the weights to the nodes of an arena.
#[inline(always)]
fn give<P: Packet<Element = f64>, const D: usize, const W: usize, const GRADIENTS: bool>(
    arena: &mut [f64],
    places: &Places<P, D, W>,
    alive: usize,
    factor: f64,
    mut stress: [[P; D]; D],
) {
    let zero = P::constant(0.0);
    let mut momentum = [zero; D];
    for axis in 0..D {
        for a in 0..D {
            stress[axis][a] = stress[axis][a].scale(factor);
            if !GRADIENTS {
                momentum[a] = (-places.fraction[axis]).mul_add(stress[axis][a], momentum[a]);
            }
        }
    }
    let (affine, impulses) = if GRADIENTS { ([[zero; D]; D], Some(stress)) } else { (stress, None) };
    scatter(arena, places, &Gift { mass: zero, momentum, affine, impulses }, alive);
}
