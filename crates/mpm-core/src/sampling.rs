//! Particles for bodies: places and volumes, seeded and the same on every machine.
//!
//! ```
//! use mpm_core::{Shape, sampling::{Pattern, sample_shape}};
//!
//! let ball = Shape::Ball { centre: [0.0; 3], radius: 0.5 };
//! let samples = sample_shape(&ball, Pattern::per_cell(0.1, 2), 7)?;
//! // Eight particles a cell of 0.1 m; together they have the volume of the ball.
//! assert!((samples.positions.len() as f64 - 4189.0).abs() < 42.0);
//! assert!((samples.volumes.iter().sum::<f64>() - 0.5236).abs() < 1e-4);
//! # Ok::<(), mpm_core::sampling::SamplingError>(())
//! ```

mod disk;
mod inside;
mod random;

pub(crate) use inside::winding_number;

use crate::{MpmError, Shape};
use mechanics_core::mesh::{MeshError, Surface, TriMesh};
use random::SiteRandom;

/// How places are laid out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pattern {
    /// One place in each cube of a lattice through the origin: its middle, and up to `jitter`/2 of its edge away from it along each axis.
    Lattice {
        /// Edge of the cubes \[m\].
        spacing: f64,
        /// 0 (regular) to 1 (anywhere in its cube).
        jitter: f64,
    },
    /// Random places no closer than `distance` to each other, with no gap where another one would fit that thirty attempts a place found.
    ///
    /// # Reference
    /// R. Bridson, *Fast Poisson disk sampling in arbitrary dimensions*, SIGGRAPH sketches 2007.
    PoissonDisk {
        /// The smallest distance \[m\].
        distance: f64,
    },
}

impl Pattern {
    /// A jittered lattice of `along`^D particles in each cell of a grid of this spacing \[m\].
    pub fn per_cell(spacing: f64, along: u32) -> Self {
        Self::Lattice { spacing: spacing / f64::from(along), jitter: 0.4 }
    }

    /// A jittered lattice of `count` particles a cell of a grid of this spacing \[m\] in `D` dimensions, in the mean: any number, not only a
    /// power.
    pub fn of_count<const D: usize>(spacing: f64, count: f64) -> Self {
        Self::Lattice { spacing: spacing * count.powf(-1.0 / D as f64), jitter: 0.4 }
    }

    /// A regular lattice of `along`^D particles in each cell of a grid of this spacing \[m\]: the midpoints of equal parts of the cells.
    pub fn regular(spacing: f64, along: u32) -> Self {
        Self::Lattice { spacing: spacing / f64::from(along), jitter: 0.0 }
    }
}

/// Places and the volume that each stands for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SampledBody<const D: usize> {
    /// \[m\].
    pub positions: Vec<[f64; D]>,
    /// All the same: the body's volume over the number of places \[m³\], in the plane \[m²\] per unit of thickness.
    pub volumes: Vec<f64>,
}

/// Why something cannot be sampled.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SamplingError {
    /// A parameter of the pattern is out of range.
    #[error("{what} is {value}, and it must be {wanted}")]
    Pattern {
        /// Which one.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        wanted: &'static str,
    },
    /// The shape has no finite volume, or none.
    #[error("the shape cannot be filled: {0}")]
    Shape(#[from] MpmError),
    /// A half-space or the space outside of walls.
    #[error("the shape is not bounded")]
    Unbounded,
    /// The mesh is not closed and consistently oriented, or it is empty.
    #[error("the mesh does not enclose a volume: {0}")]
    Mesh(#[from] MeshError),
    /// No triangles, or flat.
    #[error("the mesh encloses a volume of {volume} m³")]
    NoVolume {
        /// \[m³\].
        volume: f64,
    },
    /// The pattern is too coarse.
    #[error("no place of the pattern lies within the body: make it finer")]
    Empty,
    /// The pattern is too fine.
    #[error("{count} places are more than {most}: make the pattern coarser")]
    TooMany {
        /// About as many places.
        count: f64,
        /// The most.
        most: f64,
    },
}

/// The most places of a pattern in the box around a body.
const MOST_SITES: f64 = 1e9;

/// Fills a ball, a cuboid or a capsule.
///
/// # Errors
/// [`SamplingError`] for a shape that is degenerate or not bounded, a pattern that is out of range, too coarse or too fine.
pub fn sample_shape<const D: usize>(
    shape: &Shape<D>,
    pattern: Pattern,
    seed: u64,
) -> Result<SampledBody<D>, SamplingError> {
    shape.check()?;
    let (low, high, volume) = bounded(shape).ok_or(SamplingError::Unbounded)?;
    let mut positions = sites(&low, &high, pattern, seed)?;
    positions.retain(|x| shape.normal_inside(x).is_some());
    with_volumes(positions, volume)
}

/// Fills a closed triangle mesh: places whose generalised winding number is above ½ in size, so that either orientation, touching parts and
/// slightly intersecting ones are served. Parts inside of others that are oriented the other way are holes.
///
/// # Errors
/// [`SamplingError::Mesh`] unless every edge has two triangles of opposite direction; and as [`sample_shape`].
///
/// # Reference
/// A. Jacobson, L. Kavan, O. Sorkine-Hornung, *Robust inside-outside segmentation using generalized winding numbers*, ACM Trans.
/// Graph. 32(4), 2013, equation 5.
pub fn sample_mesh(mesh: &TriMesh, pattern: Pattern, seed: u64) -> Result<SampledBody<3>, SamplingError> {
    Surface::of_triangles(mesh).check_closed()?;
    let volume = mesh.enclosed_volume().abs();
    let Some(bounds) = mesh.bounding_box().filter(|_| volume > 0.0) else {
        return Err(SamplingError::NoVolume { volume });
    };
    let centre = bounds.centre();
    let half = bounds.size() * 0.5;
    let positions = sites(&(centre - half).into(), &(centre + half).into(), pattern, seed)?;
    with_volumes(inside::retain_inside(mesh, positions), volume)
}

fn with_volumes<const D: usize>(
    positions: Vec<[f64; D]>,
    volume: f64,
) -> Result<SampledBody<D>, SamplingError> {
    if positions.is_empty() {
        return Err(SamplingError::Empty);
    }
    let volumes = vec![volume / positions.len() as f64; positions.len()];
    Ok(SampledBody { positions, volumes })
}

/// The box around a shape, and its volume.
fn bounded<const D: usize>(shape: &Shape<D>) -> Option<([f64; D], [f64; D], f64)> {
    let pi = std::f64::consts::PI;
    let ball = |radius: f64| if D == 3 { 4.0 / 3.0 * pi * radius.powi(3) } else { pi * radius * radius };
    match shape {
        Shape::HalfSpace { .. } | Shape::Walls { .. } => None,
        Shape::Ball { centre, radius } => {
            Some((centre.map(|x| x - radius), centre.map(|x| x + radius), ball(*radius)))
        }
        Shape::Cuboid { centre, half } => {
            let corner = |sign: f64| std::array::from_fn(|a| centre[a] + sign * half[a]);
            Some((corner(-1.0), corner(1.0), half.iter().map(|h| 2.0 * h).product()))
        }
        Shape::Capsule { from, to, radius } => {
            let length = from.iter().zip(to).map(|(a, b)| (b - a).powi(2)).sum::<f64>().sqrt();
            let across = if D == 3 { pi * radius * radius } else { 2.0 * radius };
            let low = std::array::from_fn(|a| from[a].min(to[a]) - radius);
            let high = std::array::from_fn(|a| from[a].max(to[a]) + radius);
            Some((low, high, ball(*radius) + length * across))
        }
    }
}

/// Places of a pattern within a box.
fn sites<const D: usize>(
    low: &[f64; D],
    high: &[f64; D],
    pattern: Pattern,
    seed: u64,
) -> Result<Vec<[f64; D]>, SamplingError> {
    let (what, value) = match pattern {
        Pattern::Lattice { spacing, .. } => ("the spacing of the lattice", spacing),
        Pattern::PoissonDisk { distance } => ("the smallest distance", distance),
    };
    if !(value > 0.0 && value.is_finite()) {
        return Err(SamplingError::Pattern { what, value, wanted: "positive and finite" });
    }
    let count: f64 = (0..D).map(|a| (high[a] - low[a]) / value + 2.0).product();
    if !(count <= MOST_SITES) {
        return Err(SamplingError::TooMany { count, most: MOST_SITES });
    }
    match pattern {
        Pattern::Lattice { jitter, .. } if !(0.0..=1.0).contains(&jitter) => {
            Err(SamplingError::Pattern { what: "the jitter", value: jitter, wanted: "between 0 and 1" })
        }
        Pattern::Lattice { spacing, jitter } => Ok(lattice(low, high, spacing, jitter, seed)),
        Pattern::PoissonDisk { distance } => Ok(disk::sites(low, high, distance, seed)),
    }
}

/// Random numbers belong to a cube's coordinates: two bodies that share a lattice and a seed fit together.
fn lattice<const D: usize>(
    low: &[f64; D],
    high: &[f64; D],
    spacing: f64,
    jitter: f64,
    seed: u64,
) -> Vec<[f64; D]> {
    // A corner that is a lattice plane but for rounding is one.
    let first = low.map(|x| (x / spacing + 1e-9).floor());
    let counts: [usize; D] =
        std::array::from_fn(|a| (high[a] / spacing - 1e-9 - first[a]).ceil().max(0.0) as usize);
    let mut sites = Vec::with_capacity(counts.iter().product());
    for index in 0..counts.iter().product::<usize>() {
        let mut rest = index;
        let mut cube = [0.0; D];
        for axis in (0..D).rev() {
            cube[axis] = first[axis] + (rest % counts[axis]) as f64;
            rest /= counts[axis];
        }
        let mut random = SiteRandom::new(seed, &cube);
        let site = cube.map(|c| (c + 0.5 + jitter * (random.uniform() - 0.5)) * spacing);
        if (0..D).all(|a| low[a] <= site[a] && site[a] <= high[a]) {
            sites.push(site);
        }
    }
    sites
}
