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
/// [`SplatError::RegionOutside`] if no mean is in the region; [`SplatError::EmptySelection`] if all that are, are too faint;
/// [`SplatError::BadSimilarity`] for an oriented box whose Q is not a rotation to 1e-6.
pub fn select<E: Element>(splats: &Splats<E>, criteria: &Criteria) -> Result<Vec<u32>, SplatError> {
    if let Region::OrientedBox { rotation, .. } = &criteria.region {
        let (off, determinant) =
            ((rotation.tr_mul(rotation) - Mat3::identity()).norm(), rotation.determinant());
        if off.is_nan() || off > 1e-6 || determinant < 0.0 {
            return Err(SplatError::BadSimilarity { scale: 1.0, off, determinant });
        }
    }
    let mut chosen: Vec<u32> = (0..splats.count() as u32).collect();
    chosen.retain(|&i| criteria.region.contains(&mean(splats, i as usize)));
    if chosen.is_empty() && splats.count() > 0 {
        return Err(outside(splats));
    }
    let opacity = |i: u32| -> f64 { splats.opacities()[i as usize].into() };
    let (count, most) = (chosen.len(), chosen.iter().map(|&i| opacity(i)).fold(0.0, f64::max));
    chosen.retain(|&i| opacity(i) >= criteria.opacity);
    if chosen.is_empty() {
        return Err(SplatError::EmptySelection { count, opacity: criteria.opacity, most });
    }
    Ok(chosen)
}

/// Where all means are instead of in the region.
fn outside<E: Element>(splats: &Splats<E>) -> SplatError {
    let none = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
    let (low, high) = (0..splats.count()).fold(none, |(low, high), i| {
        let x = mean(splats, i);
        (low.inf(&x), high.sup(&x))
    });
    SplatError::RegionOutside { count: splats.count(), low: low.into(), high: high.into() }
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
