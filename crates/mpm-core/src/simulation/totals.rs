//! What the particles add up to, and what they show to others.

use super::Simulation;
use crate::MpmError;
use crate::body::Body;
use crate::traction::embedded;
use mechanics_core::diagnostics::CompensatedSum;
use mechanics_core::lanes::Element;
use mechanics_core::samples::DeformationSamples;
use mechanics_core::tensor::{Mat3, Vec3};

/// Sums over particles, in two dimensions per unit of thickness.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Totals {
    /// Σ m \[kg\].
    pub mass: f64,
    /// Σ m v \[kg m/s\].
    pub momentum: Vec3,
    /// About the origin \[kg m²/s\]: Σ m x × v and, where C is carried to the grid, Σ m D ε:C more (D the second moment of the kernel):
    /// what the nodes have as Σ mᵢ xᵢ × vᵢ after the scatter.
    pub angular_momentum: Vec3,
    /// Σ ½ m ‖v‖² \[J\].
    pub kinetic_energy: f64,
    /// Σ ½ m D ‖C‖² \[J\], where C is carried to the grid: the energy of the motion around the particles.
    pub affine_energy: f64,
    /// Σ V₀ ψ \[J\].
    pub stored_energy: f64,
}

impl Totals {
    fn of_body<E: Element, const D: usize>(body: &Body<E, D>, affine: Option<(f64, f64)>) -> Self {
        let layout = &body.particles.layout;
        let mut sums = [CompensatedSum::new(); 10];
        for slot in body.live_slots() {
            let number = |k: usize| -> f64 { body.particles.number(slot, k).into() };
            let mass = number(layout.mass);
            let v = embedded::<D>(&std::array::from_fn(|a| number(layout.velocity + a)));
            let mut angular = embedded(&body.position(slot)).cross(&v);
            let mut energy = 0.0;
            if let Some((moment, symmetric)) = affine {
                let c = |a: usize, b: usize| {
                    if a < D && b < D { number(layout.gradient + b * D + a) } else { 0.0 }
                };
                let spin = [(2, 1), (0, 2), (1, 0)].map(|(a, b)| c(a, b) - c(b, a));
                angular += Vec3::from(spin) * moment;
                for (a, b) in (0..D * D).map(|k| (k % D, k / D)) {
                    // The part of C that is carried.
                    let carried = c(a, b) - 0.5 * (1.0 - symmetric) * (c(a, b) + c(b, a));
                    energy += 0.5 * moment * carried * carried;
                }
            }
            let stored = number(layout.volume) * body.energy_density(slot);
            let kinetic = 0.5 * v.norm_squared();
            let terms = [1.0, v.x, v.y, v.z, angular.x, angular.y, angular.z, kinetic, energy];
            for (sum, term) in sums.iter_mut().zip(terms) {
                sum.add(mass * term);
            }
            sums[9].add(stored);
        }
        let s = sums.map(|sum| sum.value());
        Self {
            mass: s[0],
            momentum: Vec3::new(s[1], s[2], s[3]),
            angular_momentum: Vec3::new(s[4], s[5], s[6]),
            kinetic_energy: s[7],
            affine_energy: s[8],
            stored_energy: s[9],
        }
    }
}

/// Room for [`DeformationSamples`], to be used again and again.
#[derive(Clone, Debug, Default)]
pub struct DeformationBuffer {
    positions: Vec<Vec3>,
    gradients: Vec<Mat3>,
}

impl<E: Element, const D: usize> Simulation<E, D> {
    /// What the particles of a body add up to, by compensated sums in the order in which they lie in memory: the same bits for any number of
    /// threads.
    ///
    /// # Panics
    /// If there is no such body.
    pub fn totals(&self, body: usize) -> Totals {
        let cells = self.options.kernel.second_moment().unwrap_or(0.0);
        let moment = cells * self.options.spacing * self.options.spacing;
        let affine = self.options.transfer.affine_part().map(|symmetric| (moment, symmetric));
        Totals::of_body(&self.bodies[body], affine)
    }

    /// Positions and total deformation gradients of a body's particles by their numbers, for whoever draws or deforms something with them; in two
    /// dimensions with z = 0 and F₃₃ = 1. Nothing is allocated once `buffer` is large enough.
    ///
    /// # Errors
    /// [`MpmError::NoTotalDeformation`] for a body whose law keeps less than F, unless it was
    /// [added to be tracked](Self::add_tracked_body).
    ///
    /// # Panics
    /// If there is no such body.
    pub fn deformation_samples<'a>(
        &self,
        body: usize,
        buffer: &'a mut DeformationBuffer,
    ) -> Result<DeformationSamples<'a>, MpmError> {
        let source = &self.bodies[body];
        buffer.positions.resize(source.particles.count, Vec3::zeros());
        buffer.gradients.resize(source.particles.count, Mat3::identity());
        for slot in source.live_slots() {
            let particle = source.particles.ids[slot] as usize;
            buffer.positions[particle] = embedded(&source.position(slot));
            buffer.gradients[particle] =
                source.total_deformation(slot).ok_or(MpmError::NoTotalDeformation { body })?;
        }
        Ok(DeformationSamples::new(&buffer.positions, &buffer.gradients))
    }
}
