//! From unknowns to points: `xᵢ = Σⱼ wᵢⱼ qⱼ + cᵢ(t)`.
//!
//! Energies act on points; the minimiser moves unknowns. Most often they are the same, and the map costs nothing
//! then. A Dirichlet point or a scripted obstacle has no unknown, only an offset `cᵢ(t)`; an embedded skin has a few
//! weighted unknowns per point; an affine body has four (`x = q₀ + X₁ q₁ + X₂ q₂ + X₃ q₃`). Chain rule, used by
//! the assembler: `g_q = Wᵀ g_x` and `H_qq = Wᵀ H_xx W`.

use crate::tensor::Vec3;
use std::sync::Arc;

/// Where one point's position comes from; the input of [`PointMap::new`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PointSource<'a> {
    /// The point is the unknown with this number.
    Unknown(u32),
    /// The point has no unknown: it sits at its offset `c(t)`.
    Fixed,
    /// The point is a weighted sum of unknowns (plus its offset).
    Weighted(&'a [(u32, f64)]),
}

/// Which unknowns make up each point; shared, and compared by address first, so that assembly can tell cheaply
/// whether the map is the one it knows.
#[derive(Debug, PartialEq)]
enum Weights {
    /// Point `i` is unknown `i`.
    Identity { points: usize },
    /// Every point is one unknown with weight one, or none ([`NO_UNKNOWN`]).
    Selection { unknowns: usize, unknown_of_point: Vec<u32> },
    /// The general case: the pairs of point `i` are `pairs[start[i]..start[i + 1]]`.
    Sparse { unknowns: usize, start: Vec<usize>, pairs: Vec<(u32, f64)> },
}

const NO_UNKNOWN: u32 = u32::MAX;

/// The map `xᵢ = Σⱼ wᵢⱼ qⱼ + cᵢ(t)` from unknowns `q` (three numbers each) to points `x`.
#[derive(Clone, Debug)]
pub struct PointMap {
    weights: Arc<Weights>,
    /// One per point, or none at all while every offset is zero.
    offsets: Vec<Vec3>,
}

/// Why data does not make a [`PointMap`].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PointMapError {
    /// A point names an unknown that does not exist.
    #[error("point {point} reads unknown {unknown}, but there are only {unknowns}")]
    UnknownOutOfRange {
        /// The point.
        point: usize,
        /// The unknown it names.
        unknown: u32,
        /// How many there are.
        unknowns: usize,
    },
    /// A point lists the same unknown twice.
    #[error("point {point} lists unknown {unknown} twice; add the weights up")]
    RepeatedUnknown {
        /// The point.
        point: usize,
        /// The unknown.
        unknown: u32,
    },
    /// A weight is infinite or NaN.
    #[error("point {point} reads unknown {unknown} with weight {weight}, which is not finite")]
    Weight {
        /// The point.
        point: usize,
        /// The unknown.
        unknown: u32,
        /// The weight.
        weight: f64,
    },
    /// An unknown moves no point, so nothing determines it.
    #[error("unknown {unknown} moves no point, so nothing would determine it; leave it out")]
    UnusedUnknown {
        /// The unknown.
        unknown: usize,
    },
    /// An offset is infinite or NaN.
    #[error("the offset of point {point} is {offset:?}, which is not finite")]
    Offset {
        /// The point.
        point: usize,
        /// The offset.
        offset: [f64; 3],
    },
    /// A point does not exist.
    #[error("point {point} does not exist: there are {points}")]
    PointOutOfRange {
        /// The point.
        point: usize,
        /// How many there are.
        points: usize,
    },
    /// No point shows this unknown directly, so it cannot be read off the points.
    #[error("unknown {unknown} is only read with weights, so it cannot be read off the points")]
    NotReadable {
        /// The unknown.
        unknown: usize,
    },
}

impl PointMap {
    /// Point `i` is unknown `i`; nothing is fixed.
    pub fn identity(points: usize) -> Self {
        Self { weights: Arc::new(Weights::Identity { points }), offsets: Vec::new() }
    }

    /// All points are unknowns but those in `fixed`, which sit at the offsets given. Unknowns keep the order of the
    /// points.
    ///
    /// # Errors
    /// If a fixed point does not exist or its offset is not finite.
    pub fn with_fixed(points: usize, fixed: &[(u32, Vec3)]) -> Result<Self, PointMapError> {
        let mut unknown_of_point = vec![0; points];
        for &(point, _) in fixed {
            let entry = unknown_of_point
                .get_mut(point as usize)
                .ok_or(PointMapError::PointOutOfRange { point: point as usize, points })?;
            *entry = NO_UNKNOWN;
        }
        let mut unknowns = 0;
        for entry in unknown_of_point.iter_mut().filter(|entry| **entry != NO_UNKNOWN) {
            *entry = unknowns;
            unknowns += 1;
        }
        let weights = Weights::Selection { unknowns: unknowns as usize, unknown_of_point };
        let mut map = Self { weights: Arc::new(weights), offsets: Vec::new() };
        for &(point, offset) in fixed {
            map.set_offset(point as usize, offset)?;
        }
        Ok(map)
    }

    /// The map of `points`, in order, over `unknowns` unknowns. Offsets are zero until set. Takes the fastest form
    /// that fits.
    ///
    /// # Errors
    /// [`PointMapError`] names the first point or unknown that is wrong.
    pub fn new<'a>(
        unknowns: usize,
        points: impl IntoIterator<Item = PointSource<'a>>,
    ) -> Result<Self, PointMapError> {
        let mut start = vec![0];
        let mut pairs = Vec::new();
        for (point, source) in points.into_iter().enumerate() {
            match source {
                PointSource::Unknown(unknown) => pairs.push((unknown, 1.0)),
                PointSource::Fixed => {}
                PointSource::Weighted(list) => pairs.extend_from_slice(list),
            }
            check_pairs(point, unknowns, &pairs[start[point]..])?;
            start.push(pairs.len());
        }
        let mut used = vec![false; unknowns];
        pairs.iter().for_each(|&(unknown, weight)| used[unknown as usize] |= weight != 0.0);
        if let Some(unknown) = used.iter().position(|used| !used) {
            return Err(PointMapError::UnusedUnknown { unknown });
        }
        let weights = Arc::new(simplest(unknowns, start, pairs));
        Ok(Self { weights, offsets: Vec::new() })
    }

    /// The number of points.
    pub fn points(&self) -> usize {
        match &*self.weights {
            Weights::Identity { points } => *points,
            Weights::Selection { unknown_of_point, .. } => unknown_of_point.len(),
            Weights::Sparse { start, .. } => start.len() - 1,
        }
    }

    /// The number of unknowns, three numbers each.
    pub fn unknowns(&self) -> usize {
        match &*self.weights {
            Weights::Identity { points } => *points,
            Weights::Selection { unknowns, .. } | Weights::Sparse { unknowns, .. } => *unknowns,
        }
    }

    /// The offset `c` of a point \[m\].
    ///
    /// # Panics
    /// If `point` is out of range.
    pub fn offset(&self, point: usize) -> Vec3 {
        assert!(point < self.points(), "point {point} of {}", self.points());
        self.offsets.get(point).copied().unwrap_or_default()
    }

    /// Moves a fixed or scripted point: sets its offset `c` \[m\].
    ///
    /// # Errors
    /// If the point does not exist or the offset is not finite; nothing has changed then.
    pub fn set_offset(&mut self, point: usize, offset: Vec3) -> Result<(), PointMapError> {
        let points = self.points();
        if point >= points {
            return Err(PointMapError::PointOutOfRange { point, points });
        }
        if !offset.iter().all(|c| c.is_finite()) {
            return Err(PointMapError::Offset { point, offset: offset.into() });
        }
        if self.offsets.is_empty() {
            self.offsets = vec![Vec3::zeros(); points];
        }
        self.offsets[point] = offset;
        Ok(())
    }

    /// Calls `visit(unknown, weight)` for the unknowns of a point, in the order given.
    #[inline]
    pub fn for_each_unknown(&self, point: usize, mut visit: impl FnMut(u32, f64)) {
        match &*self.weights {
            Weights::Identity { .. } => visit(point as u32, 1.0),
            Weights::Selection { unknown_of_point, .. } => {
                if unknown_of_point[point] != NO_UNKNOWN {
                    visit(unknown_of_point[point], 1.0);
                }
            }
            Weights::Sparse { start, pairs, .. } => {
                pairs[start[point]..start[point + 1]].iter().for_each(|&(unknown, w)| visit(unknown, w));
            }
        }
    }

    /// Whether every point is one unknown with weight one, or none.
    pub fn is_selection(&self) -> bool {
        !matches!(*self.weights, Weights::Sparse { .. })
    }

    /// Whether two maps have the same weights (offsets may differ).
    pub fn same_weights(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.weights, &other.weights) || self.weights == other.weights
    }

    /// Overwrites `x` with the points at flat unknowns `q`: `x = W q + c`.
    ///
    /// # Panics
    /// If a length is wrong.
    pub fn points_into(&self, q: &[f64], x: &mut [Vec3]) {
        self.displacements_into(q, x);
        x.iter_mut().zip(&self.offsets).for_each(|(x, c)| *x += c);
    }

    /// Overwrites `dx` with the displacements of the points for flat unknown displacements `dq`: `dx = W dq`.
    ///
    /// # Panics
    /// If a length is wrong.
    pub fn displacements_into(&self, dq: &[f64], dx: &mut [Vec3]) {
        self.check_lengths(dq.len(), dx.len());
        match &*self.weights {
            Weights::Identity { .. } => {
                for (dx, dq) in dx.iter_mut().zip(dq.as_chunks::<3>().0) {
                    *dx = Vec3::from(*dq);
                }
            }
            Weights::Selection { unknown_of_point, .. } => {
                for (dx, &unknown) in dx.iter_mut().zip(unknown_of_point) {
                    *dx = if unknown == NO_UNKNOWN { Vec3::zeros() } else { read(dq, unknown) };
                }
            }
            Weights::Sparse { start, pairs, .. } => {
                for (point, dx) in dx.iter_mut().enumerate() {
                    let own = &pairs[start[point]..start[point + 1]];
                    *dx = own.iter().map(|&(unknown, w)| read(dq, unknown) * w).sum();
                }
            }
        }
    }

    /// Overwrites `g_q` with the gradient over flat unknowns from the one over points: `g_q = Wᵀ g_x`, summed in
    /// the order of the points.
    ///
    /// # Panics
    /// If a length is wrong.
    pub fn gradient_into(&self, g_x: &[Vec3], g_q: &mut [f64]) {
        self.check_lengths(g_q.len(), g_x.len());
        if let Weights::Identity { .. } = *self.weights {
            g_q.as_chunks_mut::<3>().0.iter_mut().zip(g_x).for_each(|(q, x)| *q = (*x).into());
            return;
        }
        g_q.fill(0.0);
        for (point, g) in g_x.iter().enumerate() {
            self.for_each_unknown(point, |unknown, w| {
                let at = 3 * unknown as usize;
                (0..3).for_each(|k| g_q[at + k] += w * g[k]);
            });
        }
    }

    /// Overwrites the flat unknowns `q` with what the points `x` show: for every unknown, the first point that is
    /// that unknown with weight one and nothing else, less its offset.
    ///
    /// # Errors
    /// If some unknown is not read directly by a point; `q` is then as it was.
    ///
    /// # Panics
    /// If a length is wrong.
    pub fn unknowns_into(&self, x: &[Vec3], q: &mut [f64]) -> Result<(), PointMapError> {
        self.check_lengths(q.len(), x.len());
        let mut point_of_unknown = vec![usize::MAX; self.unknowns()];
        for point in (0..x.len()).rev() {
            let (mut only, mut count) = (None, 0);
            self.for_each_unknown(point, |unknown, w| {
                count += 1;
                only = (w == 1.0).then_some(unknown as usize);
            });
            if let (Some(unknown), 1) = (only, count) {
                point_of_unknown[unknown] = point;
            }
        }
        if let Some(unknown) = point_of_unknown.iter().position(|&point| point == usize::MAX) {
            return Err(PointMapError::NotReadable { unknown });
        }
        for (q, point) in q.as_chunks_mut::<3>().0.iter_mut().zip(point_of_unknown) {
            *q = (x[point] - self.offset(point)).into();
        }
        Ok(())
    }

    fn check_lengths(&self, numbers: usize, points: usize) {
        assert_eq!(numbers, 3 * self.unknowns(), "three numbers per unknown");
        assert_eq!(points, self.points(), "one vector per point");
    }
}

#[inline]
fn read(q: &[f64], unknown: u32) -> Vec3 {
    let at = 3 * unknown as usize;
    Vec3::new(q[at], q[at + 1], q[at + 2])
}

fn check_pairs(point: usize, unknowns: usize, pairs: &[(u32, f64)]) -> Result<(), PointMapError> {
    for (k, &(unknown, weight)) in pairs.iter().enumerate() {
        if unknown as usize >= unknowns {
            return Err(PointMapError::UnknownOutOfRange { point, unknown, unknowns });
        }
        if !weight.is_finite() {
            return Err(PointMapError::Weight { point, unknown, weight });
        }
        if pairs[..k].iter().any(|&(earlier, _)| earlier == unknown) {
            return Err(PointMapError::RepeatedUnknown { point, unknown });
        }
    }
    Ok(())
}

fn simplest(unknowns: usize, start: Vec<usize>, pairs: Vec<(u32, f64)>) -> Weights {
    let points = start.len() - 1;
    let own = |point: usize| &pairs[start[point]..start[point + 1]];
    if (0..points).any(|point| own(point).len() > 1 || own(point).iter().any(|&(_, w)| w != 1.0)) {
        return Weights::Sparse { unknowns, start, pairs };
    }
    let unknown_of_point: Vec<u32> =
        (0..points).map(|point| own(point).first().map_or(NO_UNKNOWN, |&(unknown, _)| unknown)).collect();
    let identity = points == unknowns && unknown_of_point.iter().zip(0..).all(|(&unknown, i)| unknown == i);
    if identity { Weights::Identity { points } } else { Weights::Selection { unknowns, unknown_of_point } }
}
