//! How far a step may go.

use super::ContactOptions;
use super::neighbourhood::Neighbourhood;
use super::report::CloseFeatures;
use crate::ccd::{self, Culprit, Impact, Settings};
use crate::collision_mesh::CollisionMesh;
use crate::error::ContactError;
use mechanics_core::tensor::Vec3;

/// How far into a step one search for candidates looks, in lengths of the longest edge or of the reach.
const STRIDE: f64 = 8.0;

/// Roundings of positions are at most this part of the activation distance.
const COARSEST: f64 = 0.01;

/// Roundings of a distance, in parts of the coordinates that it is found from.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Continuous detection for one mesh.
#[derive(Clone, Debug)]
pub(super) struct Detector {
    settings: Settings,
    /// d_min \[m\].
    minimum_separation: f64,
    /// Farther from the origin rounding is not small beside the activation distance \[m\].
    farthest: f64,
    /// The largest displacement for which candidates are searched at once \[m\].
    stride: f64,
    /// Half-space and point of all pairs that may touch.
    half_space_points: Vec<[u32; 2]>,
    /// Queries asked so far.
    pub(super) queries: u64,
}

/// The part of a step that is free, and the pair that ends it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Limit {
    pub(super) fraction: f64,
    pub(super) culprit: Option<Culprit>,
}

impl Detector {
    /// Leaves each pair `kept_gap` of its gap, or half of the activation distance if that is less.
    pub(super) fn new(mesh: &CollisionMesh, options: &ContactOptions) -> Self {
        let &ContactOptions { activation_distance, minimum_separation, kept_gap, detection, .. } = options;
        let longest = (0..mesh.edges().len() as u32).map(|edge| mesh.rest_length(edge)).fold(0.0, f64::max);
        let largest_kept_gap = 0.5 * activation_distance;
        let settings = Settings { kept_gap, largest_kept_gap, detection, ..Settings::default() };
        let stride = STRIDE * longest.max(activation_distance + minimum_separation);
        let planes = 0..mesh.half_spaces().len() as u32;
        let half_space_points = planes
            .flat_map(|h| mesh.vertices().iter().map(move |&p| [h, p]))
            .filter(|&[h, p]| mesh.may_touch_half_space(h, p))
            .collect();
        let farthest = COARSEST * activation_distance / ROUNDING;
        Self { settings, minimum_separation, farthest, stride, half_space_points, queries: 0 }
    }

    /// Refuses positions beyond 0.01 d̂ / 16 ε, about 3e12 d̂, from the origin: distances there are wrong by more than 1 % of d̂.
    pub(super) fn check_positions(&self, mesh: &CollisionMesh, x: &[Vec3]) -> Result<(), ContactError> {
        let farthest = self.farthest;
        let far = mesh.vertices().iter().map(|&i| i as usize).find(|&i| x[i].norm() > farthest);
        far.map_or(Ok(()), |point| Err(ContactError::TooFar { point, position: x[point].into(), farthest }))
    }

    /// The free part of the step from `x` to `x + p`.
    ///
    /// A long step is looked at piece by piece: up to one stride first, then up to twice as far, and so on. Boxes of
    /// a whole long step would hold most of the scene, though most of it is never reached because something is hit
    /// before. Where the pieces end depends on `x` and `p` alone, and a pair counts only if it comes closer than the reach,
    /// so the answer does not depend on the candidates that happen to be known.
    ///
    /// What all points have in common of their displacement brings no two together. It is taken out first, so that
    /// bodies that fall together sweep no boxes; the roundings of that are added to the minimum separation.
    ///
    /// Roundings grow with the piece. So the first piece is no longer than what rounds as `x` itself does: a pair that it
    /// finds too close is too close at `x`. A pair that is too close only for the roundings of a later piece ends the step where
    /// the piece before ended, and so, without a culprit, does a piece that goes farther from the origin than positions may be.
    ///
    /// # Errors
    /// If a pair touches at `x`, up to rounding.
    pub(super) fn limit(
        &mut self,
        mesh: &CollisionMesh,
        neighbourhood: &mut Neighbourhood,
        x: &[Vec3],
        p: &[Vec3],
    ) -> Result<Limit, ContactError> {
        let common = mean(mesh, p);
        let relative: Vec<Vec3> = p.iter().map(|p| p - common).collect();
        let longest = |p: &[Vec3]| mesh.vertices().iter().map(|&i| p[i as usize].norm()).fold(0.0, f64::max);
        let (here, way) = (longest(x), longest(p));
        // Half, so that the square of what is relative does not overflow where that of `p` does not.
        let halves: Vec<Vec3> = relative.iter().map(|p| p * 0.5).collect();
        let first = (0.5 * self.stride / longest(&halves)).min((here + self.stride) / way).min(1.0);
        let (mut part, mut free) = (first, 0.0);
        loop {
            let reached = here + part * way;
            let rounding = ROUNDING * reached;
            if free > 0.0 && reached > self.farthest {
                return Ok(Limit { fraction: free, culprit: None });
            }
            match self.limit_piece(mesh, neighbourhood, x, [p, &relative], part, rounding) {
                Ok(Limit { culprit: None, .. }) if part < 1.0 => free = part,
                Err(ContactError::TooClose { pairs, .. }) if free > 0.0 => {
                    let features = pairs.first().map(|pair| [pair.first.feature, pair.second.feature]);
                    let culprit = features.map(|features| Culprit { features, impact: Impact::At(free) });
                    return Ok(Limit { fraction: free, culprit });
                }
                answer => return answer,
            }
            part = (2.0 * part).min(1.0);
        }
    }

    /// The same up to `part` of the step, of which also what is `relative` to the common displacement is given.
    fn limit_piece(
        &mut self,
        mesh: &CollisionMesh,
        neighbourhood: &mut Neighbourhood,
        x: &[Vec3],
        [p, relative]: [&[Vec3]; 2],
        part: f64,
        rounding: f64,
    ) -> Result<Limit, ContactError> {
        let piece: Vec<Vec3> = p.iter().map(|p| p * part).collect();
        let planes = self.limit_by_half_spaces(mesh, x, &piece)?;
        let part = part * planes.fraction;
        let piece: Vec<Vec3> = relative.iter().map(|p| p * part).collect();
        let end: Vec<Vec3> = x.iter().zip(&piece).map(|(x, p)| x + p).collect();
        if !neighbourhood.covers(mesh, x, &end) {
            neighbourhood.search(mesh, x, &end)?;
        }
        let found = self.limit_by_pairs(mesh, neighbourhood, x, &piece, rounding)?;
        let culprit = found.culprit.or(planes.culprit);
        Ok(Limit { fraction: part * found.fraction, culprit })
    }

    fn limit_by_half_spaces(
        &mut self,
        mesh: &CollisionMesh,
        x: &[Vec3],
        p: &[Vec3],
    ) -> Result<Limit, ContactError> {
        let pairs = ccd::Pairs {
            half_spaces: mesh.half_spaces(),
            half_space_points: &self.half_space_points,
            ..Default::default()
        };
        self.ask(mesh, &pairs, x, p, 0.0)
    }

    fn limit_by_pairs(
        &mut self,
        mesh: &CollisionMesh,
        neighbourhood: &Neighbourhood,
        x: &[Vec3],
        p: &[Vec3],
        rounding: f64,
    ) -> Result<Limit, ContactError> {
        let candidates = neighbourhood.candidates();
        if candidates.is_empty() {
            return Ok(Limit { fraction: 1.0, culprit: None });
        }
        self.queries += candidates.len() as u64;
        let pairs = ccd::Pairs {
            edges: mesh.edges(),
            triangles: mesh.triangles(),
            point_points: &candidates.point_points,
            point_edges: &candidates.point_edges,
            point_triangles: &candidates.point_triangles,
            edge_edges: &candidates.edge_edges,
            ..Default::default()
        };
        self.ask(mesh, &pairs, x, p, rounding)
    }

    fn ask(
        &self,
        mesh: &CollisionMesh,
        pairs: &ccd::Pairs<'_>,
        x: &[Vec3],
        p: &[Vec3],
        rounding: f64,
    ) -> Result<Limit, ContactError> {
        let d_min = self.minimum_separation + rounding;
        let (fraction, culprit) = ccd::limit(pairs, x, p, d_min, &self.settings);
        match culprit {
            Some(Culprit { features, impact: Impact::StartsTooClose { distance } }) => {
                let pairs = vec![CloseFeatures::new(mesh, features, distance)];
                Err(ContactError::TooClose { pairs, minimum_separation: self.minimum_separation })
            }
            Some(Culprit { impact: Impact::NonFinite, .. }) => Err(non_finite(x, p)),
            culprit => Ok(Limit { fraction, culprit }),
        }
    }
}

/// The first point whose way is not finite.
pub(super) fn non_finite(x: &[Vec3], p: &[Vec3]) -> ContactError {
    let ends = x.iter().zip(p).map(|(x, p)| if x.iter().all(|c| c.is_finite()) { x + p } else { *x });
    let wrong = ends.enumerate().find(|(_, end)| !end.norm_squared().is_finite());
    let (point, position) = wrong.unwrap_or((0, Vec3::repeat(f64::NAN)));
    ContactError::NonFinite { point, position: position.into() }
}

/// The mean of the vectors of the points that take part.
pub(super) fn mean(mesh: &CollisionMesh, vectors: &[Vec3]) -> Vec3 {
    let points = mesh.vertices();
    let sum: Vec3 = points.iter().map(|&point| vectors[point as usize]).sum();
    sum / points.len().max(1) as f64
}
