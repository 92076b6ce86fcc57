//! Selecting matter: which Gaussians are simulated.
//!
//! A selection is a strictly ascending list of Gaussians. Those that are not in it stay in the scene, and in the picture, as they are.

use crate::error::SplatError;
use crate::splats::Splats;
use mechanics_core::lanes::Element;
use mechanics_core::mesh::BoundingBox;
use mechanics_core::tensor::{Mat3, Vec3, components};

/// A part of space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Region {
    /// All of it.
    Everywhere,
    /// A box along the axes, its surface included.
    Box(BoundingBox),
    /// All x with |Qᵀ(x − c)| ≤ h, component by component.
    OrientedBox {
        /// c \[m\].
        centre: Vec3,
        /// h, half the sides \[m\].
        half_sides: Vec3,
        /// Q, whose columns are the directions of the sides.
        rotation: Mat3,
    },
}

impl Region {
    /// Whether a point is in it. A point that is not a number is in no box.
    pub fn contains(&self, x: &Vec3) -> bool {
        match self {
            Self::Everywhere => true,
            Self::Box(bounds) => (0..3).all(|k| bounds.min[k] <= x[k] && x[k] <= bounds.max[k]),
            Self::OrientedBox { centre, half_sides, rotation } => {
                let inside = rotation.tr_mul(&(x - centre));
                (0..3).all(|k| inside[k].abs() <= half_sides[k])
            }
        }
    }
}

/// Which Gaussians are matter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Criteria {
    /// Where their means are.
    pub region: Region,
    /// The least opacity. Fainter Gaussians are floaters and halos as a rule, which weigh nothing.
    pub opacity: f64,
}

impl Default for Criteria {
    /// Everywhere, opacity 0.02.
    fn default() -> Self {
        Self { region: Region::Everywhere, opacity: 0.02 }
    }
}

/// The Gaussians that meet the criteria, ascending.
///
/// # Errors
/// [`SplatError::EmptySelection`] if there are none.
pub fn select<E: Element>(splats: &Splats<E>, criteria: &Criteria) -> Result<Vec<u32>, SplatError> {
    let opaque = |i: usize| -> bool { splats.opacities()[i].into() >= criteria.opacity };
    let chosen: Vec<u32> = (0..splats.count())
        .filter(|&i| opaque(i) && criteria.region.contains(&mean(splats, i)))
        .map(|i| i as u32)
        .collect();
    if chosen.is_empty() {
        let most = splats.opacities().iter().map(|&x| x.into()).fold(0.0, f64::max);
        return Err(SplatError::EmptySelection { count: splats.count(), opacity: criteria.opacity, most });
    }
    Ok(chosen)
}

/// Divides a selection among regions: set k holds what region k is the first to contain, the last set, one more than regions, what none contains. For a material for each.
pub fn divide<E: Element>(splats: &Splats<E>, selection: &[u32], regions: &[Region]) -> Vec<Vec<u32>> {
    let mut sets = vec![Vec::new(); regions.len() + 1];
    for &i in selection {
        let x = mean(splats, i as usize);
        let first = regions.iter().position(|region| region.contains(&x));
        sets[first.unwrap_or(regions.len())].push(i);
    }
    sets
}

/// A box around the bulk of the Gaussians of at least the given opacity.
///
/// Along each axis, the means' interval from quantile `trim` to quantile 1 − `trim` is widened on both sides by a tenth of its length. A few
/// floaters, however far, do not move it.
///
/// # Errors
/// [`SplatError::EmptySelection`] if no Gaussian is so opaque.
///
/// # Panics
/// If `trim` is not from 0 to 0.5.
pub fn bulk<E: Element>(splats: &Splats<E>, opacity: f64, trim: f64) -> Result<BoundingBox, SplatError> {
    assert!((0.0..0.5).contains(&trim), "a share of less than a half is trimmed at each end");
    let chosen = select(splats, &Criteria { region: Region::Everywhere, opacity })?;
    let mut bounds = BoundingBox { min: Vec3::zeros(), max: Vec3::zeros() };
    for axis in 0..3 {
        let mut values: Vec<f64> = chosen.iter().map(|&i| mean(splats, i as usize)[axis]).collect();
        values.sort_unstable_by(f64::total_cmp);
        let last = values.len() - 1;
        let cut = (trim * last as f64).round() as usize;
        let (low, high) = (values[cut], values[last - cut]);
        bounds.min[axis] = low - 0.1 * (high - low);
        bounds.max[axis] = high + 0.1 * (high - low);
    }
    Ok(bounds)
}

/// The means of the listed Gaussians \[m\].
///
/// # Panics
/// If there is no such Gaussian.
pub fn means<E: Element>(splats: &Splats<E>, list: &[u32]) -> Vec<Vec3> {
    list.iter().map(|&i| mean(splats, i as usize)).collect()
}

fn mean<E: Element>(splats: &Splats<E>, i: usize) -> Vec3 {
    Vec3::from(components(&splats.means()[i]).map(Into::into))
}

/// Whether a list of Gaussians is strictly ascending and within the scene.
pub(crate) fn check_ascending(list: &[u32], count: usize) -> Result<(), SplatError> {
    let bad = |entry: usize| list[entry] as usize >= count || (entry > 0 && list[entry - 1] >= list[entry]);
    match (0..list.len()).find(|&entry| bad(entry)) {
        None => Ok(()),
        Some(entry) => Err(SplatError::BadSelection { entry, splat: list[entry], count }),
    }
}
