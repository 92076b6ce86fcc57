//! Sheets: which side particles are on, which nodes exist twice, and that nothing passes.
//!
//! # Sides
//! A particle within reach of a sheet, whose nearest point of it is not on its rim, is on one of its sides: that of the signed distance. Particles are
//! sorted by block *and* sides, so the kernels of scatter and gather know nothing of sheets. A node within reach has a side too. A particle of the
//! other side does not see it: it has a second node there, the *ghost*, on which the sheet acts as a solid does on nodes inside of it,
//! with the normal towards the particle's side. So each side feels a wall, momentum passes only through the sheet, and forces of all transfers and
//! laws are those of a wall. Beyond the rim, and out of reach, all particles share all nodes.
//!
//! A particle on one side and a node on the other are at least as far apart as each of them is from the sheet. A kernel of W nodes reaches
//! W√D/2 cells: particles farther away than that are on no side, and need none.
//!
//! # Paths
//! A wall of nodes stops what flows, but a particle in the last half cell still moves with the free nodes before it. Its path of a step,
//! a straight line in the frame of the sheet from where it was at the begin to where it is at the end, is tested against the triangles. If it
//! crosses, or ends closer than the gap of 10⁻³ cells, the surface acts on the particle's velocity as on a node's, and the particle is put beside
//! the sheet at the first of these places that its path reaches freely: the end of the path less its normal part beyond the sheet; the
//! point where it would have crossed; where it was. In the frame of the sheet paths are joined end to end, so that a particle can change sides only
//! around the rim. The change of its momentum is an impulse on the collider.
//!
//! # Reference
//! Y. Hu et al., *A moving least squares material point method with displacement discontinuity and two-way rigid body coupling*, ACM Trans.
//! Graph. 37(4), 2018, section 5, has the idea of compatible nodes; there particles replace what they do not see by their own
//! velocity, here by the velocity of their side.

use super::motion::Moment;
use super::surface::{Side, SignedDistance, TriangleSurface};
use super::{ColliderShape, Impulse, PlacedCollider};
use crate::boundary::Surface;
use crate::neighbourhood::block_edge;
use crate::traction::embedded;
use mechanics_core::lanes::Element;
use mechanics_core::parallel;
use mechanics_core::tensor::Vec3;

/// The sides of a particle: two bits a sheet, 1 where its triangles' normals point, 2 behind.
pub(crate) type Sides = u64;

/// On no side of any sheet.
pub(crate) const NEUTRAL: Sides = 0;

/// Sheets of a simulation, at most.
pub(crate) const MOST_SHEETS: usize = 32;

/// How far particles stay away from sheets \[cells\].
pub(crate) const GAP: f64 = 1e-3;

/// Attempts to bring a path beside several sheets.
const MOST_CONTACTS: usize = 4;

/// A sheet during a step.
struct PlacedSheet<'a> {
    /// Its number among the colliders.
    collider: usize,
    triangles: &'a TriangleSurface,
    surface: Surface,
    begin: Moment,
    end: Moment,
}

/// All sheets during a step.
pub(crate) struct Sheets<'a> {
    sheets: Vec<PlacedSheet<'a>>,
    spacing: f64,
    /// How far from a sheet particles have a side \[m\].
    reach: f64,
}

/// What the path of a particle met.
struct Contact {
    sheet: usize,
    /// In the frame of the sheet, towards the particle.
    normal: Vec3,
    /// In the frame of the sheet.
    point: Vec3,
}

/// A particle's path in a step.
pub(crate) struct Path {
    pub(crate) start: Vec3,
    pub(crate) end: Vec3,
    pub(crate) velocity: Vec3,
}

/// What sheets took from the particles of a block.
#[derive(Clone, Debug, Default)]
pub(crate) struct SheetReport {
    /// By collider.
    pub(crate) loads: Vec<Impulse>,
    /// Whether the block must be sorted anew: a particle was moved or is on other sides than its block.
    pub(crate) stale: bool,
    /// The square of the largest speed given by a sheet.
    pub(crate) speed_squared: f64,
}

/// Sides by nearness: a place that is far away is followed by others as far.
#[derive(Default)]
pub(crate) struct Trail(Vec<Option<(Vec3, f64)>>);

impl<'a> Sheets<'a> {
    /// Sheets in a step from `begin` to `end`, for kernels of `width` nodes in `dimension` axes.
    pub(crate) fn new(
        colliders: &'a [PlacedCollider],
        (begin, end): (f64, f64),
        spacing: f64,
        (width, dimension): (usize, usize),
    ) -> Self {
        let sheet = |(collider, placed): (usize, &'a PlacedCollider)| match &placed.collider.shape {
            ColliderShape::Solid(_) => None,
            ColliderShape::Sheet(sheet) => Some(PlacedSheet {
                collider,
                triangles: &sheet.0,
                surface: placed.collider.surface,
                begin: placed.moment(begin),
                end: placed.moment(end),
            }),
        };
        let reach = 0.5 * width as f64 * (dimension as f64).sqrt() + GAP;
        let sheets = colliders.iter().enumerate().filter_map(sheet).collect();
        Self { sheets, spacing, reach: reach * spacing }
    }

    /// The sides of a place at the begin of the step.
    pub(crate) fn sides_at(&self, place: &Vec3, trail: &mut Trail) -> Sides {
        self.sides_of(|sheet| sheet.begin.placement.point_at(place), 0.0, trail)
    }

    /// The sides of a place, given in the frame of each sheet. Those farther away than reach and `length` \[m\] may be left out of the trail.
    fn sides_of(&self, point: impl Fn(&PlacedSheet<'a>) -> Vec3, length: f64, trail: &mut Trail) -> Sides {
        trail.0.resize(self.sheets.len(), None);
        let mut sides = NEUTRAL;
        for (k, sheet) in self.sheets.iter().enumerate() {
            let point = point(sheet);
            if self.is_far(trail, k, &point, length) {
                continue;
            }
            let found = sheet.triangles.signed_distance(&point, f64::INFINITY);
            trail.0[k] = Some((point, found.distance.abs()));
            if found.nearest == Side::Surface && found.distance.abs() <= self.reach {
                sides |= (if found.distance > 0.0 { 1 } else { 2 }) << (2 * k);
            }
        }
        sides
    }

    /// Whether a place is farther away from a sheet than reach and `length`, as the trail tells.
    fn is_far(&self, trail: &Trail, sheet: usize, point: &Vec3, length: f64) -> bool {
        let far = self.reach.max(length);
        trail.0[sheet].is_some_and(|(before, distance)| distance - (point - before).norm() > far)
    }

    /// Which of the 64 nodes of the block at `origin` particles of these sides do not see.
    pub(crate) fn ghost_nodes<const D: usize>(&self, origin: &[i32; D], sides: Sides) -> u64 {
        let edge = block_edge(D);
        let unseen = |node: usize| {
            let place = std::array::from_fn(|axis| {
                let local = node / edge.pow((D - 1 - axis) as u32) % edge;
                (f64::from(origin[axis]) * edge as f64 + local as f64) * self.spacing
            });
            self.walls(&embedded::<D>(&place), sides).next().is_some()
        };
        (0..64).fold(0, |mask, node| mask | u64::from(unseen(node)) << node)
    }

    /// The sheets between a node and particles of these sides, with their normals towards the particles.
    fn walls(&self, place: &Vec3, sides: Sides) -> impl Iterator<Item = (&PlacedSheet<'a>, Vec3)> {
        self.sheets.iter().enumerate().filter_map(move |(k, sheet)| {
            let side = match sides >> (2 * k) & 3 {
                1 => 1.0,
                2 => -1.0,
                _ => return None,
            };
            let point = sheet.begin.placement.point_at(place);
            let found = sheet.triangles.signed_distance(&point, f64::INFINITY);
            // A node on the sheet is a wall for both sides.
            let hidden = found.nearest == Side::Surface && found.distance * side <= MARGIN * self.spacing;
            hidden.then(|| (sheet, sheet.begin.placement.rotation * (found.normal * side)))
        })
    }

    /// Lets the sheets act on the velocity of a ghost node; answers what each of them took, by collider.
    pub(crate) fn constrain(
        &self,
        place: &Vec3,
        sides: Sides,
        velocity: &Vec3,
        mut take: impl FnMut(usize, Vec3),
    ) -> Vec3 {
        let mut velocity = *velocity;
        for (sheet, normal) in self.walls(place, sides) {
            let after = sheet.act(&sheet.begin, place, &normal, &velocity);
            take(sheet.collider, velocity - after);
            velocity = after;
        }
        velocity
    }

    /// Whether something within `radius` of a place may meet a sheet, or have a side, in the step.
    pub(crate) fn is_near(&self, place: &Vec3, radius: f64) -> bool {
        self.sheets.iter().any(|sheet| {
            let (begin, end) = (sheet.begin.placement.point_at(place), sheet.end.placement.point_at(place));
            let within = radius + self.reach + 2.0 * (begin - end).norm();
            sheet.triangles.signed_distance(&begin, f64::INFINITY).distance.abs() <= within
        })
    }

    /// Keeps a particle of precision `E` on its sides; answers the sides of the end of its path, and whether the path was changed.
    pub(crate) fn guard<E: Element>(
        &self,
        path: &mut Path,
        trail: &mut Trail,
        mut take: impl FnMut(usize, Vec3),
    ) -> (Sides, bool) {
        let sides_at_end = |path: &Path, trail: &mut Trail| {
            self.sides_of(|sheet| sheet.end_of(path), self.length(path), trail)
        };
        let sides = sides_at_end(path, trail);
        let length = self.length(path);
        if (0..self.sheets.len()).all(|k| self.is_far(trail, k, &self.sheets[k].end_of(path), length)) {
            return (sides, false);
        }
        let start = path.start;
        for contacts in 0..MOST_CONTACTS {
            let Some(contact) = self.first_contact(path) else {
                let sides = if contacts > 0 { sides_at_end(path, trail) } else { sides };
                return (sides, contacts > 0);
            };
            let sheet = &self.sheets[contact.sheet];
            let place = sheet.end.placement.place(&contact.point);
            let normal = sheet.end.placement.rotation * contact.normal;
            let after = sheet.act(&sheet.end, &place, &normal, &path.velocity).map(|v| E::constant(v).into());
            take(sheet.collider, path.velocity - after);
            path.velocity = after;
            path.end = self.beside::<E>(&contact, path);
        }
        // Between sheets that leave no room.
        path.end = start;
        (sides_at_end(path, trail), true)
    }

    /// The longest way of a particle in the frames of the sheets.
    fn length(&self, path: &Path) -> f64 {
        self.sheets.iter().map(|sheet| (sheet.start_of(path) - sheet.end_of(path)).norm()).fold(0.0, f64::max)
    }

    fn first_contact(&self, path: &Path) -> Option<Contact> {
        (0..self.sheets.len()).find_map(|k| {
            let sheet = &self.sheets[k];
            let (start, end) = (sheet.start_of(path), sheet.end_of(path));
            let towards = |normal: Vec3, from: f64| if from < 0.0 { -normal } else { normal };
            if let Some((part, normal)) = sheet.triangles.first_crossing(&start, &end) {
                let normal = towards(normal, (start - end).dot(&normal));
                return Some(Contact { sheet: k, normal, point: start + (end - start) * part });
            }
            let found = sheet.triangles.signed_distance(&end, f64::INFINITY);
            self.is_too_close(&found).then(|| Contact {
                sheet: k,
                normal: towards(found.normal, found.distance),
                point: end - found.normal * found.distance,
            })
        })
    }

    fn is_too_close(&self, found: &SignedDistance) -> bool {
        found.nearest == Side::Surface && found.distance.abs() < 0.5 * GAP * self.spacing
    }

    /// Where a particle goes that met a sheet.
    fn beside<E: Element>(&self, contact: &Contact, path: &Path) -> Vec3 {
        let sheet = &self.sheets[contact.sheet];
        let (start, end) = (sheet.start_of(path), sheet.end_of(path));
        let gap = contact.normal * (GAP * self.spacing);
        let slid = end + contact.normal * (contact.point - end).dot(&contact.normal) + gap;
        let stopped = contact.point + gap;
        let places = if sheet.surface == Surface::Sticky { [stopped, stopped] } else { [slid, stopped] };
        let rounded = |point: &Vec3| sheet.end.placement.place(point).map(|x| E::constant(x).into());
        let is_free = |place: &Vec3| {
            let end = sheet.end.placement.point_at(place);
            sheet.triangles.first_crossing(&start, &end).is_none()
                && !self.is_too_close(&sheet.triangles.signed_distance(&end, f64::INFINITY))
        };
        places.iter().map(rounded).find(is_free).unwrap_or_else(|| rounded(&start))
    }

    /// The sides of places, one after the other, at the begin of the step.
    pub(crate) fn sides_of_all(&self, count: usize, place: impl Fn(usize) -> Vec3 + Sync) -> Vec<Sides> {
        let parts = parallel::map_chunks(count, 4096, |range| {
            let mut trail = Trail::default();
            range.map(|k| self.sides_at(&place(k), &mut trail)).collect::<Vec<_>>()
        });
        parts.concat()
    }
}

/// Nodes this close to a sheet are on it \[cells\].
const MARGIN: f64 = 1e-9;

impl PlacedSheet<'_> {
    fn start_of(&self, path: &Path) -> Vec3 {
        self.begin.placement.point_at(&path.start)
    }

    fn end_of(&self, path: &Path) -> Vec3 {
        self.end.placement.point_at(&path.end)
    }

    fn act(&self, moment: &Moment, place: &Vec3, normal: &Vec3, velocity: &Vec3) -> Vec3 {
        let own = moment.velocity_at(place);
        Vec3::from(self.surface.relative(&(velocity - own).into(), &(*normal).into())) + own
    }
}
