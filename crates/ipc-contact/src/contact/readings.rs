//! What can be read off contact: forces, pressures, pairs, κ, counts; and what sets κ.

use super::active::ActivePairs;
use super::{BarrierContact, ContactCounts, ContactOptions, ContactReport};
use crate::contact_set::Weighting;
use crate::error::ContactError;
use crate::normal_force::{NormalForce, PatchForce};
use crate::pair::PairLaw;
use crate::stiffness::SavedStiffness;
use mechanics_core::mesh::triangle_area_vector;
use mechanics_core::point_map::PointMap;
use mechanics_core::potential::Potential;
use mechanics_core::projection::Projection;
use mechanics_core::sparse::Assembly;
use mechanics_core::tensor::Vec3;
use std::sync::Arc;

/// Gaps below this part of the activation distance are squeezed: a tolerance in metres may not resolve them.
const SQUEEZED: f64 = 0.01;
/// A minimisation does not end where its last direction changes a squeezed gap by more than this part of itself.
const SETTLED: f64 = 0.1;

impl BarrierContact {
    /// κ now.
    pub fn stiffness(&self) -> f64 {
        self.adaptation.current()
    }

    /// κ that the next step begins with if it begins at `x`, and how far it may grow: where κ grows this is part of the state of a
    /// run, to be saved with its positions. After a failed step that is not what [`stiffness`](Self::stiffness) says.
    pub fn saved_stiffness(&self, x: &[Vec3]) -> SavedStiffness {
        self.adaptation.at(x)
    }

    /// Sets κ to what was saved with the positions that the next step begins at.
    ///
    /// # Errors
    /// If a number of it is not positive and finite.
    pub fn resume_stiffness(&mut self, saved: SavedStiffness) -> Result<(), ContactError> {
        let wrong = [saved.kappa, saved.largest].into_iter().find(|k| !(k.is_finite() && *k > 0.0));
        if let Some(value) = wrong {
            return Err(ContactError::Stiffness { value });
        }
        self.adaptation.resume(saved);
        Ok(())
    }

    /// Sets κ so that contact at `x` balances the other terms best, whose gradient there is `others` \[N\]: κ = −gᵀf/gᵀg with g
    /// the gradient of contact for κ = 1, over points with unknowns. Answers κ; `None`, and κ is as it was, where contact does not oppose
    /// the other forces (or there is none at `x`).
    ///
    /// Inertia should not be among the others: its forces depend on the time step.
    ///
    /// # Panics
    /// If there is not one position and one force for each point.
    pub fn balance(&mut self, x: &[Vec3], others: &[Vec3]) -> Option<f64> {
        assert_eq!(others.len(), x.len(), "one gradient per point");
        let mut own = vec![Vec3::zeros(); x.len()];
        self.active_at(x).ok()?.add_gradient(PairLaw { stiffness: 1.0, ..self.law() }, x, &mut own);
        let free = self.mesh.vertices().iter().filter(|&&point| !self.mesh.is_scripted(point));
        let (against, square) = free.fold((0.0, 0.0), |(against, square), &point| {
            let (g, f) = (&own[point as usize], &others[point as usize]);
            (against - g.dot(f), square + g.norm_squared())
        });
        let stiffness = against / square;
        self.restart(stiffness)
    }

    /// Sets κ so that a pair of mean weight at half of the activation distance is as stiff as the points of the mesh are on
    /// average, by the Hessians of `others` at `x`: κ w ∂²b/∂d² = mean of a third of the trace of the diagonal blocks. Inertia
    /// should not be among the others. Answers κ; `None`, and κ is as it was, if the others have no stiffness there.
    pub fn match_stiffness(&mut self, x: &[Vec3], others: &[&dyn Potential]) -> Option<f64> {
        let map = PointMap::identity(x.len());
        let mut assembly = Assembly::new(&map);
        let mut assembler = assembly.begin(&map);
        for (number, other) in others.iter().enumerate() {
            assembler.begin_term(number);
            other.add_hessian(x, Projection::Clamp, &mut assembler);
        }
        let matrix = assembler.finish();
        let free = || self.mesh.vertices().iter().filter(|&&point| !self.mesh.is_scripted(point));
        let count = free().count() as f64;
        let stiffness =
            free().map(|&point| matrix.diagonal(point as usize).trace() / 3.0).sum::<f64>() / count;
        let weight = match self.options.weighting {
            Weighting::Unit => 1.0,
            Weighting::Area => free().map(|&point| self.mesh.point_area(point)).sum::<f64>() / count,
        };
        let halfway = self.options.minimum_separation + 0.5 * self.options.activation_distance;
        let squared = halfway * halfway;
        let [first, second] = self.barrier.first_and_second(squared);
        self.restart(stiffness / (weight * (4.0 * squared * second + 2.0 * first)))
    }

    fn restart(&mut self, stiffness: f64) -> Option<f64> {
        let usable = stiffness.is_finite() && stiffness > 0.0;
        usable.then(|| {
            self.adaptation.restart(stiffness);
            stiffness
        })
    }

    /// The normal force of every active pair at `x`: those with half-spaces, then pairs of points, points and edges, points and
    /// triangles, edges. Empty if a position is not finite.
    pub fn normal_forces(&self, x: &[Vec3]) -> Vec<NormalForce> {
        self.active(x).normal_forces(self.law(), x)
    }

    /// The half-space of each of the first [`normal_forces`](Self::normal_forces) at `x`, those of one point. Empty if a position is
    /// not finite.
    pub fn half_space_numbers(&self, x: &[Vec3]) -> Vec<u32> {
        self.active(x).half_space_numbers().to_vec()
    }

    /// What contact pushes each point with at `x`: −∂E/∂xᵢ \[N\]; all NaN if a position is not finite.
    pub fn forces(&self, x: &[Vec3]) -> Vec<Vec3> {
        let mut forces = vec![Vec3::zeros(); x.len()];
        self.add_gradient(x, &mut forces);
        forces.iter_mut().for_each(|force| *force = -*force);
        forces
    }

    /// The force and the mean pressure of contact at `x` on the triangles with these numbers. The force on a point is shared
    /// between its triangles by their rest areas. NaN if a position is not finite.
    ///
    /// # Panics
    /// If there is no such triangle.
    pub fn patch_force(&self, x: &[Vec3], triangles: &[u32]) -> PatchForce {
        let forces = self.forces(x);
        let (mut force, mut area_vector) = (Vec3::zeros(), Vec3::zeros());
        for &number in triangles {
            let corners = self.mesh.triangles()[number as usize];
            let rest = triangle_area_vector(&corners.map(|point| self.mesh.rest()[point as usize])).norm();
            area_vector += triangle_area_vector(&corners.map(|point| x[point as usize]));
            for point in corners {
                force += forces[point as usize] * (rest / (3.0 * self.mesh.point_area(point)));
            }
        }
        PatchForce::new(force, area_vector)
    }

    /// How many pairs are active at `x`. None if a position is not finite: [`value`](Potential::value) is NaN then.
    pub fn contact_counts(&self, x: &[Vec3]) -> ContactCounts {
        self.active(x).counts()
    }

    /// The smallest distance of active pairs at `x` \[m\]; `None` if there are none, or if a position is not finite
    /// ([`value`](Potential::value) is NaN then).
    pub fn smallest_distance(&self, x: &[Vec3]) -> Option<f64> {
        self.active(x).smallest_distance()
    }

    /// What was done since the start of the last step.
    pub fn report(&self) -> ContactReport {
        let accepted = self.guard.accepted().map(|x| self.active(x)).unwrap_or_default();
        let [searches, queries] = self.before;
        ContactReport {
            contacts: accepted.counts(),
            smallest_distance: accepted.smallest_distance(),
            stiffness: self.stiffness(),
            doublings: self.adaptation.doublings(),
            candidates: self.neighbourhood.candidates().len(),
            searches: self.neighbourhood.searches() - searches,
            detection_queries: self.detector.queries - queries,
            sets: self.remembered().builds,
            limiting_pair: self.limiting_pair,
        }
    }

    pub(super) fn begin_report(&mut self) {
        self.before = [self.neighbourhood.searches(), self.detector.queries];
        self.remembered().builds = 0;
        self.limiting_pair = None;
    }

    /// Whether the displacements `p` change every gap below [`SQUEEZED`] d̂ by at most the part [`SETTLED`] of itself, to first order.
    pub(super) fn keeps_squeezed_gaps(&self, active: &ActivePairs, x: &[Vec3], p: &[Vec3]) -> bool {
        let ContactOptions { minimum_separation, activation_distance, .. } = self.options;
        let squeezed = SQUEEZED * activation_distance;
        if active.smallest_distance().is_none_or(|distance| distance - minimum_separation >= squeezed) {
            return true;
        }
        active.normal_forces(self.law(), x).iter().all(|pair| {
            let gap = pair.distance - minimum_separation;
            let each = pair.points().iter().zip(pair.weights());
            let change: f64 = each.map(|(&point, weight)| weight * pair.normal.dot(&p[point as usize])).sum();
            gap >= squeezed || change.abs() <= SETTLED * gap
        })
    }

    /// The smallest gap at `x` in parts of d̂.
    pub(super) fn smallest_gap(&self, x: &[Vec3]) -> Result<Option<f64>, ContactError> {
        let distance = self.active_at(x)?.smallest_distance();
        Ok(distance.map(|d| (d - self.options.minimum_separation) / self.options.activation_distance))
    }

    fn active(&self, x: &[Vec3]) -> Arc<ActivePairs> {
        self.active_at(x).unwrap_or_default()
    }
}
