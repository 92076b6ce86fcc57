//! Which pairs may be near, found once and used for as long as nothing has left the region it was found for.

use super::detection::mean;
use crate::broad_phase::{Among, BroadPhase, Candidates};
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
///
/// **Own frames.** Where an object as a whole moves farther than a part of its features' size, the boxes of its features would hold all of it that lies ahead of
/// them and behind, though none of that comes any nearer. What an object's points have in common of their displacement brings no
/// two of them together. So the pairs within objects are then found for boxes from which it is taken out, and in a region that goes
/// along with each object: shifted by how far the mean of *its* points is at y₀, and at y₁, from that at x₀. The pairs of different objects
/// are found as ever.
#[derive(Clone, Debug)]
pub(super) struct Neighbourhood {
    broad_phase: BroadPhase,
    candidates: Candidates,
    /// Where the candidates are good; none as long as nothing was found.
    region: Option<Region>,
    /// The same for the pairs within objects, where these were found for themselves.
    own: Option<OwnFrames>,
    /// The mean of x₀.
    anchor: Vec3,
    /// R: pairs closer than this are found \[m\].
    reach: f64,
    /// Objects that move farther are looked at in frames of their own \[m\].
    far: f64,
    searches: u64,
}

/// How much a region is enlarged beyond need, in parts of the reach: more makes candidates last longer, and more of them. On a twisted mat 0.25 took
/// a third more searches than 1 and two thirds of the queries.
const MARGIN: f64 = 0.25;

/// Objects that move farther than the reach and than this part of the mean edge are looked at in frames of their own. On balls of icosahedral meshes
/// half an edge along each axis made a hundred times as many candidates; two searches take less time than ten times as many queries.
const FAR: f64 = 0.1;

/// Corners of each point's box: x₀ and x₁ by component, enlarged by r − ½R; in the order of the mesh's vertices.
#[derive(Clone, Debug)]
struct Region(Vec<[Vec3; 2]>);

impl Region {
    fn new(mesh: &CollisionMesh, x0: &[Vec3], x1: &[Vec3], margin: f64) -> Self {
        Self(
            mesh.vertices()
                .iter()
                .map(|&point| {
                    let (a, b) = (&x0[point as usize], &x1[point as usize]);
                    [a.inf(b).add_scalar(-margin), a.sup(b).add_scalar(margin)]
                })
                .collect(),
        )
    }

    /// Whether every point of `y`, less the shift of its own, is in its box.
    fn holds(&self, mesh: &CollisionMesh, y: &[Vec3], shift: impl Fn(u32) -> Vec3) -> bool {
        mesh.vertices().iter().zip(&self.0).all(|(&point, [low, high])| {
            let y = y[point as usize] - shift(point);
            (0..3).all(|k| low[k] <= y[k] && y[k] <= high[k])
        })
    }
}

/// The region of pairs within objects.
#[derive(Clone, Debug)]
struct OwnFrames {
    region: Region,
    /// The mean of each object's points at x₀.
    anchors: Vec<Vec3>,
}

impl OwnFrames {
    fn holds(&self, mesh: &CollisionMesh, y: &[Vec3]) -> bool {
        let means = means(mesh, y);
        let shift = |point| {
            let object = mesh.object_of(point) as usize;
            means[object] - self.anchors[object]
        };
        self.region.holds(mesh, y, shift)
    }
}

/// The mean of the vectors of each object's points that take part.
fn means(mesh: &CollisionMesh, vectors: &[Vec3]) -> Vec<Vec3> {
    let mut sums = vec![(Vec3::zeros(), 0.0); mesh.object_count()];
    for &point in mesh.vertices() {
        let (sum, count) = &mut sums[mesh.object_of(point) as usize];
        *sum += vectors[point as usize];
        *count += 1.0;
    }
    sums.into_iter().map(|(sum, count)| sum / f64::max(count, 1.0)).collect()
}

impl Neighbourhood {
    pub(super) fn new(mesh: &CollisionMesh, reach: f64) -> Self {
        let broad_phase = BroadPhase::new(mesh);
        let candidates = Candidates::default();
        let edges = 0..mesh.edges().len() as u32;
        let mean_edge =
            edges.clone().map(|edge| mesh.rest_length(edge)).sum::<f64>() / edges.len().max(1) as f64;
        let far = reach.max(FAR * mean_edge);
        Self {
            broad_phase,
            candidates,
            region: None,
            own: None,
            anchor: Vec3::zeros(),
            reach,
            far,
            searches: 0,
        }
    }

    pub(super) fn candidates(&self) -> &Candidates {
        &self.candidates
    }

    /// How often candidates were searched for.
    pub(super) fn searches(&self) -> u64 {
        self.searches
    }

    /// Whether the candidates hold all pairs closer than the reach somewhere between `y0` and `y1`.
    pub(super) fn covers(&self, mesh: &CollisionMesh, y0: &[Vec3], y1: &[Vec3]) -> bool {
        let Some(region) = &self.region else { return false };
        let shift = mean(mesh, y0) - self.anchor;
        [y0, y1].into_iter().all(|y| {
            region.holds(mesh, y, |_| shift) && self.own.as_ref().is_none_or(|own| own.holds(mesh, y))
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
        self.region = None;
        let (anchors, ends) = (means(mesh, x0), means(mesh, x1));
        let moves = |(from, to): (&Vec3, &Vec3)| (to - from).amax() > self.far;
        if anchors.iter().zip(&ends).any(moves) {
            let mut own_ends = x1.to_vec();
            for &point in mesh.vertices() {
                let object = mesh.object_of(point) as usize;
                own_ends[point as usize] -= ends[object] - anchors[object];
            }
            let mut within = Candidates::default();
            let Self { broad_phase, candidates, .. } = self;
            broad_phase.candidates_among(Among::Same, mesh, [x0, &own_ends], inflation, &mut within)?;
            broad_phase.candidates_among(Among::Different, mesh, [x0, x1], inflation, candidates)?;
            self.candidates.join(&within);
            self.own = Some(OwnFrames { region: Region::new(mesh, x0, &own_ends, margin), anchors });
        } else {
            self.broad_phase.candidates(mesh, x0, x1, inflation, &mut self.candidates)?;
            self.own = None;
        }
        self.anchor = mean(mesh, x0);
        self.region = Some(Region::new(mesh, x0, x1, margin));
        self.searches += 1;
        Ok(())
    }
}
