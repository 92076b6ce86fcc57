//! Which pairs may be near, found once and used for as long as nothing has left the region it was found for.

use super::detection::mean;
use crate::broad_phase::{BroadPhase, Candidates};
use crate::collision_mesh::CollisionMesh;
use crate::error::ContactError;
use mechanics_core::tensor::Vec3;

/// Candidates and the region they are good for.
///
/// They were found for boxes around each point's way from x₀ to x₁, every box larger by r on all sides, and hold every pair
/// of features whose boxes overlap. Let every point be within the box of its own way, enlarged by r − ½R, at
/// y₀ and at y₁. That region is convex, so it holds the whole segment from y₀ to y₁, and two features that come closer than R
/// on it have overlapping boxes: all pairs closer than R are among the candidates. The same holds if the region goes along with
/// the points: it is shifted by how far the mean of y₀ is from that of x₀, so that a body in free fall stays in its own.
#[derive(Clone, Debug)]
pub(super) struct Neighbourhood {
    broad_phase: BroadPhase,
    candidates: Candidates,
    /// Corners of each point's box: x₀ and x₁ by component, enlarged by r − ½R; empty as long as nothing was found.
    region: Vec<[Vec3; 2]>,
    /// The mean of x₀.
    anchor: Vec3,
    /// R: pairs closer than this are found \[m\].
    reach: f64,
    searches: u64,
}

/// How much a region is enlarged beyond need, in parts of the reach: more makes candidates last longer, and more of them. On a twisted mat 0.25 took
/// a third more searches than 1 and two thirds of the queries.
const MARGIN: f64 = 0.25;

impl Neighbourhood {
    pub(super) fn new(mesh: &CollisionMesh, reach: f64) -> Self {
        let broad_phase = BroadPhase::new(mesh);
        let candidates = Candidates::default();
        Self { broad_phase, candidates, region: Vec::new(), anchor: Vec3::zeros(), reach, searches: 0 }
    }

    pub(super) fn candidates(&self) -> &Candidates {
        &self.candidates
    }

    /// Pairs closer than this are found \[m\].
    pub(super) fn reach(&self) -> f64 {
        self.reach
    }

    /// How often candidates were searched for.
    pub(super) fn searches(&self) -> u64 {
        self.searches
    }

    /// Whether the candidates hold all pairs closer than the reach somewhere between `y0` and `y1`.
    pub(super) fn covers(&self, mesh: &CollisionMesh, y0: &[Vec3], y1: &[Vec3]) -> bool {
        let shift = mean(mesh, y0) - self.anchor;
        let within = |y: &Vec3, [low, high]: &[Vec3; 2]| {
            let y = y - shift;
            (0..3).all(|k| low[k] <= y[k] && y[k] <= high[k])
        };
        !self.region.is_empty()
            && mesh.vertices().iter().zip(&self.region).all(|(&point, region)| {
                within(&y0[point as usize], region) && within(&y1[point as usize], region)
            })
    }

    /// Finds candidates for everything between `x0` and `x1`, and somewhat beyond.
    pub(super) fn search(
        &mut self,
        mesh: &CollisionMesh,
        x0: &[Vec3],
        x1: &[Vec3],
    ) -> Result<(), ContactError> {
        // The margin is less than it might be by far more than the corners are rounded by.
        let inflation = self.reach * (0.5 + MARGIN);
        let margin = self.reach * MARGIN * 0.98;
        if let Err(error) = self.broad_phase.candidates(mesh, x0, x1, inflation, &mut self.candidates) {
            // There may be no candidates now: they cover nothing.
            self.region.clear();
            return Err(error);
        }
        self.anchor = mean(mesh, x0);
        self.region.clear();
        self.region.extend(mesh.vertices().iter().map(|&point| {
            let (a, b) = (&x0[point as usize], &x1[point as usize]);
            [a.inf(b).add_scalar(-margin), a.sup(b).add_scalar(margin)]
        }));
        self.searches += 1;
        Ok(())
    }
}
