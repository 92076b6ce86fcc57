//! Forces on the surface of a body: ∫ Nᵢ t ds by tagged particles.
//!
//! A tagged particle stands for a piece of the surface with the rest area vector A (its length the area, its direction outward). The
//! force f of the piece acts where the particle is: node i gets wᵢ f, so that forces add up to Σ f and, because kernels reproduce lines,
//! their moments to Σ x × f. A particle half a spacing below the surface moves the place of the force by as much: nothing else is lost.
//!
//! | traction | force of a piece | follows |
//! |---|---|---|
//! | nominal T | T ‖A‖ | nothing: a dead load, per rest area |
//! | Cauchy t | t ‖a‖ | the area, not its direction |
//! | pressure p | −p a | area and direction |
//!
//! with Nanson's formula a = J F⁻ᵀ A = cof(F) A for the present area vector; F is the particle's total deformation gradient at the
//! beginning of the step.

use crate::Kernel;
use crate::Transfer;
use crate::kernel;
use crate::neighbourhood::{DRIFT, NODE, arena_length, arena_side, block_edge};
use mechanics_core::lanes::Element;
use mechanics_core::tensor::{Mat3, Vec3};

/// What pulls or presses at a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Traction<const D: usize> {
    /// Force per *rest* area \[Pa\], of constant direction: a dead load.
    Nominal([f64; D]),
    /// Force per *present* area \[Pa\], of constant direction.
    Cauchy([f64; D]),
    /// A pressure \[Pa\] against the present surface, wherever that has turned: a following load.
    Pressure(f64),
}

impl<const D: usize> Traction<D> {
    /// Whether the force depends on the deformation.
    pub(crate) fn follows(&self) -> bool {
        !matches!(self, Self::Nominal(_))
    }

    /// A number of it that is not finite.
    pub(crate) fn not_finite(&self) -> Option<f64> {
        match self {
            Self::Nominal(t) | Self::Cauchy(t) => t.iter().copied().find(|x| !x.is_finite()),
            Self::Pressure(p) => Some(*p).filter(|p| !p.is_finite()),
        }
    }

    /// The force of a piece of surface \[N\], in the plane per unit of thickness.
    fn force(&self, area: &[f64; D], deformation: Option<&Mat3>) -> [f64; D] {
        let rest = embedded(area);
        let present = deformation.map_or(rest, |f| cofactor(f) * rest);
        match self {
            Self::Nominal(t) => t.map(|t| t * rest.norm()),
            Self::Cauchy(t) => t.map(|t| t * present.norm()),
            Self::Pressure(p) => std::array::from_fn(|axis| -p * present[axis]),
        }
    }
}

/// J F⁻ᵀ without division: columns are cross products of F's.
fn cofactor(f: &Mat3) -> Mat3 {
    let [a, b, c]: [Vec3; 3] = std::array::from_fn(|k| f.column(k).into());
    Mat3::from_columns(&[b.cross(&c), c.cross(&a), a.cross(&b)])
}

/// A vector of the plane or of space as one of space.
pub(crate) fn embedded<const D: usize>(vector: &[f64; D]) -> Vec3 {
    Vec3::from_fn(|k, _| vector.get(k).copied().unwrap_or(0.0))
}

/// A piece of a body's surface under load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Piece<const D: usize> {
    pub(crate) particle: u32,
    /// Where the particle is in memory.
    pub(crate) slot: u32,
    /// A \[m²\].
    pub(crate) area: [f64; D],
    pub(crate) traction: Traction<D>,
}

impl<const D: usize> Piece<D> {
    /// Adds the impulse h wᵢ f to the nodes of an arena around `position`, whose block is at `origin`.
    pub(crate) fn add_impulse<E: Element>(
        &self,
        arena: &mut [E],
        position: &[f64; D],
        origin: &[i32; D],
        deformation: Option<&Mat3>,
        place: &Place,
    ) {
        let impulse = self.traction.force(&self.area, deformation).map(|f| f * place.step);
        match place.kernel {
            Kernel::Linear => add::<E, D, 2>(arena, &impulse, &cells(position, origin, place.spacing)),
            Kernel::Quadratic => add::<E, D, 3>(arena, &impulse, &cells(position, origin, place.spacing)),
            Kernel::Cubic => add::<E, D, 4>(arena, &impulse, &cells(position, origin, place.spacing)),
        }
    }
}

/// What all pieces share in a step.
pub(crate) struct Place {
    pub(crate) kernel: Kernel,
    pub(crate) spacing: f64,
    /// h \[s\].
    pub(crate) step: f64,
}

impl Place {
    /// Where in an arena impulses begin: behind the momenta if they are kept apart.
    pub(crate) fn first_impulse<const D: usize>(&self, transfer: Transfer) -> usize {
        if transfer.keeps_impulses() { arena_length(D, self.kernel.width()) } else { 0 }
    }
}

/// A position relative to the lowest node of the arena \[cells\].
pub(crate) fn cells<const D: usize>(position: &[f64; D], origin: &[i32; D], spacing: f64) -> [f64; D] {
    let edge = block_edge(D) as f64;
    std::array::from_fn(|axis| position[axis] / spacing - (f64::from(origin[axis]) * edge - DRIFT as f64))
}

fn add<E: Element, const D: usize, const W: usize>(arena: &mut [E], impulse: &[f64; D], cells: &[f64; D]) {
    let side = arena_side(D, W);
    // Within the arena: where rounding differs from that of the scatter, the neighbouring polynomial continues this one.
    let lowest = cells.map(|x| kernel::lowest_node::<f64, W>(x).clamp(0.0, (side - W) as f64));
    let weights: [[f64; W]; D] =
        std::array::from_fn(|axis| kernel::weights::<f64, W>(cells[axis] - lowest[axis]));
    for node in 0..W.pow(D as u32) {
        let (mut weight, mut at) = (1.0, 0);
        for axis in 0..D {
            let i = node / W.pow((D - 1 - axis) as u32) % W;
            weight *= weights[axis][i];
            at = at * side + lowest[axis] as usize + i;
        }
        for axis in 0..D {
            arena[at * NODE + 1 + axis] += E::constant(weight * impulse[axis]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sheared and stretched parallelogram: the area vector of the mapped edges is the cross product of the mapped edges.
    #[test]
    fn nanson_maps_areas_as_edges_are_mapped() {
        let f = Mat3::new(1.1, 0.3, -0.2, 0.05, 0.8, 0.4, -0.3, 0.1, 1.4);
        let (p, q) = (Vec3::new(0.3, -1.0, 0.2), Vec3::new(0.7, 0.1, -0.5));
        let mapped = (f * p).cross(&(f * q));
        assert!((cofactor(&f) * p.cross(&q) - mapped).norm() < 1e-15);
        let area: [f64; 3] = p.cross(&q).into();
        let force = Traction::Pressure(2.0).force(&area, Some(&f));
        assert!((Vec3::from(force) + 2.0 * mapped).norm() < 1e-14);
        let force = Traction::Cauchy([0.0, 0.0, 3.0]).force(&area, Some(&f));
        assert!((force[2] - 3.0 * mapped.norm()).abs() < 1e-14);
        assert_eq!(Traction::Nominal([0.0, 0.0, 3.0]).force(&area, Some(&f))[2], 3.0 * p.cross(&q).norm());
    }
}
