//! Sheets in a step: sides of particles, nodes that exist twice, paths that end where something is in the way.

use super::Simulation;
use crate::body::Body;
use crate::collider::{Impulse, Path, SheetReport, Sheets, Sides, Trail};
use crate::particles::at;
use crate::traction::embedded;
use mechanics_core::lanes::Element;
use mechanics_core::parallel;
use mechanics_core::tensor::Vec3;

/// Where the particles of the blocks near sheets were, by body and block; empty for the others.
pub(super) type Starts = Vec<Vec<Vec<Vec3>>>;

impl<E: Element, const D: usize> Simulation<E, D> {
    fn has_sheets(&self) -> bool {
        self.colliders.iter().any(|collider| collider.is_sheet())
    }

    /// Sheets from now on for `step` \[s\].
    pub(super) fn sheets(&self, step: f64) -> Sheets<'_> {
        let (spacing, width) = (self.options.spacing, self.options.kernel.width());
        Sheets::new(&self.colliders, (self.time, self.time + step), spacing, (width, D))
    }

    /// The sides of the particles of a body, by slot; none without sheets.
    pub(super) fn sides_of(&self, body: &Body<E, D>) -> Vec<Sides> {
        if !self.has_sheets() {
            return Vec::new();
        }
        self.sheets(0.0).sides_of_all(body.particles.ids.len(), |slot| embedded(&body.position(slot)))
    }

    /// Gives blocks of particles their sides: those of their first particles.
    pub(super) fn find_sides(&mut self) {
        if !self.has_sheets() {
            return;
        }
        for body in 0..self.bodies.len() {
            let sides = {
                let (sheets, body) = (self.sheets(0.0), &self.bodies[body]);
                let first = |block| embedded(&body.position(body.slots_of(block).start));
                sheets.sides_of_all(body.particles.blocks.len(), first)
            };
            for (block, sides) in self.bodies[body].particles.blocks.iter_mut().zip(sides) {
                block.sides = sides;
            }
        }
    }

    /// Where particles near sheets are before they move. `reach` is how far any particle moves along each axis \[m\].
    pub(super) fn starts_near_sheets(&self, step: f64, reach: &[f64; D]) -> Starts {
        if !self.has_sheets() {
            return Vec::new();
        }
        let (sheets, spacing) = (self.sheets(step), self.options.spacing);
        let way = embedded(reach).norm();
        let starts = |body: &Body<E, D>| {
            let of_block = |block: usize| {
                let (low, high) = body.cells_of(block, spacing);
                let (low, high) = (embedded(&low), embedded(&high));
                let radius = 0.5 * (high - low).norm() + way;
                match sheets.is_near(&(0.5 * (low + high)), radius) {
                    true => body.slots_of(block).map(|slot| embedded(&body.position(slot))).collect(),
                    false => Vec::new(),
                }
            };
            let blocks = body.particles.blocks.len();
            parallel::map_chunks(blocks, 8, |range| range.map(of_block).collect::<Vec<_>>()).concat()
        };
        self.bodies.iter().map(starts).collect()
    }

    /// Keeps particles that have moved on their sides of the sheets, and adds what these take to the loads of the step. Answers how many
    /// particles were looked at.
    pub(super) fn guard_sheets(&mut self, step: f64, starts: &Starts) -> u64 {
        if starts.is_empty() {
            return 0;
        }
        let Self { colliders, bodies, options, time, .. } = self;
        let (spacing, width) = (options.spacing, options.kernel.width());
        let sheets = Sheets::new(colliders, (*time, *time + step), spacing, (width, D));
        let mut total =
            SheetReport { loads: vec![Impulse::default(); colliders.len()], ..SheetReport::default() };
        for (body, starts) in bodies.iter_mut().zip(starts) {
            for report in guard_body(body, &sheets, starts, colliders.len()) {
                total.stale |= report.stale;
                total.speed_squared = total.speed_squared.max(report.speed_squared);
                total.loads.iter_mut().zip(&report.loads).for_each(|(sum, load)| sum.add(load));
            }
        }
        // Nodes change sides when their sheet moves.
        let moves = colliders.iter().any(|collider| collider.is_sheet() && collider.moves());
        for (collider, load) in colliders.iter_mut().zip(&total.loads) {
            collider.load.step.add(load);
            collider.load.total.add(load);
        }
        self.sorted &= !(total.stale || moves);
        if let Some((_, travel)) = &mut self.limits {
            travel.speed_squared = travel.speed_squared.max(total.speed_squared);
        }
        starts.iter().flatten().map(|starts| starts.len() as u64).sum()
    }
}

fn guard_body<E: Element, const D: usize>(
    body: &mut Body<E, D>,
    sheets: &Sheets<'_>,
    starts: &[Vec<Vec3>],
    colliders: usize,
) -> Vec<SheetReport> {
    let particles = &mut body.particles;
    let (layout, blocks) = (particles.layout, &particles.blocks);
    let mut reports = vec![SheetReport::default(); blocks.len()];
    parallel::for_each_part(&mut particles.data, &particles.ends, &mut reports, |block, packs, report| {
        if starts[block].is_empty() {
            return;
        }
        report.loads.resize(colliders, Impulse::default());
        let mut trail = Trail::default();
        for (slot, start) in starts[block].iter().enumerate() {
            let number = |k: usize| at(&layout, slot, k, E::LANES);
            let vector = |packs: &[E], first: usize| {
                Vec3::from_fn(|a, _| if a < D { packs[number(first + a)].into() } else { 0.0 })
            };
            let (end, velocity) = (vector(packs, 0), vector(packs, layout.velocity));
            let mass: f64 = packs[number(layout.mass)].into();
            let mut path = Path { start: *start, end, velocity };
            let loads = &mut report.loads;
            let (sides, changed) = sheets.guard::<E>(&mut path, &mut trail, |collider, change| {
                loads[collider].add(&Impulse::at(&end, change * mass));
            });
            report.stale |= changed || sides != blocks[block].sides;
            if changed {
                for a in 0..D {
                    packs[number(a)] = E::constant(path.end[a]);
                    packs[number(layout.velocity + a)] = E::constant(path.velocity[a]);
                }
                report.speed_squared = report.speed_squared.max(path.velocity.norm_squared());
            }
        }
    });
    reports
}
