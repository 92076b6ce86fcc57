//! What keeps matter in place: walls and obstacles, acting on the velocities of nodes.
//!
//! A boundary is a shape, how it moves, and what its surface does. It acts on nodes inside or on the shape, after forces. With the node's
//! velocity v, the surface's velocity u there, the outward normal n and v − u = w:
//!
//! | surface | the node's velocity becomes |
//! |---|---|
//! | sticky | u |
//! | slip | u + w − (w·n) n |
//! | separating | the same where w·n < 0, else v |
//! | friction μ | where w·n < 0: u + t max(0, 1 + μ (w·n)/‖t‖) with t = w − (w·n) n, else v |
//!
//! The friction is Coulomb's law for the impulse that stops the normal motion: it takes at most μ |w·n| from the sliding.
//! Boundaries act in the order in which they were added, after [prescribed velocities](PrescribedVelocity).

use crate::MpmError;

/// What a surface does to matter that touches it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Surface {
    /// Matter keeps the surface's velocity.
    Sticky,
    /// Matter slides freely and never leaves.
    Slip,
    /// Matter slides freely and may leave.
    Separating,
    /// Matter may leave, and slides with Coulomb friction of this coefficient.
    Friction(f64),
}

/// Where a boundary is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape<const D: usize> {
    /// Everything on the side of `point` that the unit `normal` points away from.
    HalfSpace {
        /// A point of the plane \[m\].
        point: [f64; D],
        /// Out of the obstacle.
        normal: [f64; D],
    },
    /// A ball (a disk in the plane).
    Ball {
        /// Its centre \[m\].
        centre: [f64; D],
        /// Its radius \[m\].
        radius: f64,
    },
    /// A box along the axes.
    Cuboid {
        /// Its centre \[m\].
        centre: [f64; D],
        /// Half of its edges \[m\].
        half: [f64; D],
    },
    /// All points within `radius` of a segment.
    Capsule {
        /// One end of the segment \[m\].
        from: [f64; D],
        /// The other end \[m\].
        to: [f64; D],
        /// \[m\].
        radius: f64,
    },
    /// Everything outside of a box along the axes: the walls of a domain.
    Walls {
        /// The lowest corner of the free space \[m\].
        low: [f64; D],
        /// Its highest corner \[m\].
        high: [f64; D],
    },
}

/// A shape, its surface, and its motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Boundary<const D: usize> {
    /// Where it is at time zero.
    pub shape: Shape<D>,
    /// What it does.
    pub surface: Surface,
    /// How it translates \[m/s\].
    pub velocity: [f64; D],
}

fn dot<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn minus<const D: usize>(a: &[f64; D], b: &[f64; D]) -> [f64; D] {
    std::array::from_fn(|k| a[k] - b[k])
}

fn along<const D: usize>(start: &[f64; D], step: f64, direction: &[f64; D]) -> [f64; D] {
    std::array::from_fn(|k| start[k] + step * direction[k])
}

/// `vector` at unit length; the last axis for a zero vector (the middle of a ball has no outward direction).
fn unit<const D: usize>(vector: &[f64; D]) -> [f64; D] {
    let length = dot(vector, vector).sqrt();
    if length > 0.0 {
        vector.map(|x| x / length)
    } else {
        std::array::from_fn(|k| if k == D - 1 { 1.0 } else { 0.0 })
    }
}

impl<const D: usize> Shape<D> {
    /// The outward normal where `point` is inside or on the shape, `None` outside.
    pub fn normal_inside(&self, point: &[f64; D]) -> Option<[f64; D]> {
        match self {
            Self::HalfSpace { point: origin, normal } => {
                (dot(&minus(point, origin), normal) <= 0.0).then_some(*normal)
            }
            Self::Ball { centre, radius } => round(&minus(point, centre), *radius),
            Self::Capsule { from, to, radius } => {
                let axis = minus(to, from);
                let length = dot(&axis, &axis);
                let part = if length > 0.0 { dot(&minus(point, from), &axis) / length } else { 0.0 };
                round(&minus(point, &along(from, part.clamp(0.0, 1.0), &axis)), *radius)
            }
            Self::Cuboid { centre, half } => {
                let offset = minus(point, centre);
                let depth = |k: usize| half[k] - offset[k].abs();
                let nearest = (0..D).fold(0, |best, k| if depth(k) < depth(best) { k } else { best });
                (depth(nearest) >= 0.0).then(|| {
                    std::array::from_fn(|k| if k == nearest { 1.0_f64.copysign(offset[k]) } else { 0.0 })
                })
            }
            Self::Walls { low, high } => {
                // Into the free space; in a corner the mean of the walls' normals.
                let side = |k: usize| f64::from(i8::from(point[k] <= low[k]) - i8::from(point[k] >= high[k]));
                let normal: [f64; D] = std::array::from_fn(side);
                normal.iter().any(|n| *n != 0.0).then(|| unit(&normal))
            }
        }
    }
}

/// How far the length of a normal may be from one.
const UNIT_TOLERANCE: f64 = 1e-9;

impl<const D: usize> Shape<D> {
    /// Confirms that the shape is one: finite, of positive size, with a unit normal.
    pub(crate) fn check(&self) -> Result<(), MpmError> {
        let positive = |what, value: f64| match value > 0.0 && value.is_finite() {
            true => Ok(()),
            false => Err(MpmError::Shape { what, value, wanted: "positive and finite" }),
        };
        match self {
            Self::HalfSpace { point, normal } => {
                finite("a point of a half-space", point)?;
                let value = dot(normal, normal).sqrt();
                let (what, wanted) = ("the length of a half-space's normal", "1");
                // A NaN is not near one.
                if (value - 1.0).abs() <= UNIT_TOLERANCE {
                    Ok(())
                } else {
                    Err(MpmError::Shape { what, value, wanted })
                }
            }
            Self::Ball { centre, radius } => {
                finite("the centre of a ball", centre)?;
                positive("the radius of a ball", *radius)
            }
            Self::Cuboid { centre, half } => {
                finite("the centre of a box", centre)?;
                half.iter().try_for_each(|half| positive("half an edge of a box", *half))
            }
            Self::Capsule { from, to, radius } => {
                finite("an end of a capsule", from)?;
                finite("an end of a capsule", to)?;
                positive("the radius of a capsule", *radius)
            }
            Self::Walls { low, high } => {
                // Walls at infinity are none.
                (0..D).try_for_each(|k| match low[k] < high[k] {
                    true => Ok(()),
                    false => Err(MpmError::Shape {
                        what: "the width between walls",
                        value: high[k] - low[k],
                        wanted: "positive",
                    }),
                })
            }
        }
    }
}

/// The normal of a ball at `offset` from its centre.
fn round<const D: usize>(offset: &[f64; D], radius: f64) -> Option<[f64; D]> {
    (dot(offset, offset) <= radius * radius).then(|| unit(offset))
}

impl<const D: usize> Boundary<D> {
    /// A boundary that stands still.
    pub fn at_rest(shape: Shape<D>, surface: Surface) -> Self {
        Self { shape, surface, velocity: [0.0; D] }
    }

    pub(crate) fn check(&self) -> Result<(), MpmError> {
        self.shape.check()?;
        finite("the velocity of a boundary", &self.velocity)?;
        self.surface.check()
    }

    /// The outward normals of the surfaces that a node at `point` is inside or on at `time`: one, several in a corner of walls, or none.
    pub(crate) fn normals(&self, point: &[f64; D], time: f64) -> Vec<[f64; D]> {
        let own = along(point, -time, &self.velocity);
        let Shape::Walls { low, high } = &self.shape else {
            return self.shape.normal_inside(&own).into_iter().collect();
        };
        let side = |k: usize, sign: f64| std::array::from_fn(|axis| if axis == k { sign } else { 0.0 });
        (0..D)
            .flat_map(|k| [(own[k] <= low[k], side(k, 1.0)), (own[k] >= high[k], side(k, -1.0))])
            .filter_map(|(outside, normal)| outside.then_some(normal))
            .collect()
    }

    /// The velocity of the node at `point` at `time` after the boundary has acted on `velocity`.
    pub fn act(&self, point: &[f64; D], time: f64, velocity: &[f64; D]) -> [f64; D] {
        let own = along(point, -time, &self.velocity);
        let w = minus(velocity, &self.velocity);
        if let (Shape::Walls { low, high }, true) = (&self.shape, self.surface != Surface::Sticky) {
            // Walls of a corner act one after the other: each takes its own normal part only.
            let mut w = w;
            for k in 0..D {
                for (outside, sign) in [(own[k] <= low[k], 1.0), (own[k] >= high[k], -1.0)] {
                    if outside {
                        let normal = std::array::from_fn(|axis| if axis == k { sign } else { 0.0 });
                        w = self.surface.relative(&w, &normal);
                    }
                }
            }
            return along(&w, 1.0, &self.velocity);
        }
        match self.shape.normal_inside(&own) {
            Some(normal) => along(&self.surface.relative(&w, &normal), 1.0, &self.velocity),
            None => *velocity,
        }
    }
}

/// A velocity that the nodes of a region are given for some time: a grip, a piston, a belt.
///
/// Acts in the steps whose middle is at `from` ≤ t < `until`, on the nodes with mass inside or on the region, which stands still, after
/// forces and before the boundaries. So it begins and ends at the boundary of steps that is nearest, whatever rounding does to their sum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrescribedVelocity<const D: usize> {
    /// Where: usually a ball or a cuboid.
    pub region: Shape<D>,
    /// Which velocity \[m/s\].
    pub velocity: [f64; D],
    /// From this time on \[s\].
    pub from: f64,
    /// Before this time \[s\]; may be ∞.
    pub until: f64,
}

impl<const D: usize> PrescribedVelocity<D> {
    /// The velocity of the node at `point` in a step whose middle is at `middle` \[s\].
    pub fn act(&self, point: &[f64; D], middle: f64, velocity: &[f64; D]) -> [f64; D] {
        if self.reaches(point, middle) { self.velocity } else { *velocity }
    }

    /// Whether it acts on the node at `point` in a step whose middle is at `middle`.
    pub(crate) fn reaches(&self, point: &[f64; D], middle: f64) -> bool {
        self.from <= middle && middle < self.until && self.region.normal_inside(point).is_some()
    }

    pub(crate) fn check(&self) -> Result<(), MpmError> {
        self.region.check()?;
        finite("a prescribed velocity", &self.velocity)?;
        if !self.from.is_finite() {
            return Err(MpmError::Number { what: "the begin of a prescribed velocity", value: self.from });
        }
        if !(self.until > self.from) {
            let (what, wanted) = ("the end of a prescribed velocity", "after its begin");
            return Err(MpmError::Shape { what, value: self.until, wanted });
        }
        Ok(())
    }
}

pub(crate) fn finite<const D: usize>(what: &'static str, numbers: &[f64; D]) -> Result<(), MpmError> {
    match numbers.iter().find(|x| !x.is_finite()) {
        Some(value) => Err(MpmError::Number { what, value: *value }),
        None => Ok(()),
    }
}

impl Surface {
    /// Confirms that friction is not below zero.
    pub(crate) fn check(self) -> Result<(), MpmError> {
        match self {
            Self::Friction(value) if !(value >= 0.0 && value.is_finite()) => {
                Err(MpmError::Number { what: "a coefficient of friction", value })
            }
            _ => Ok(()),
        }
    }

    /// What is left of the velocity relative to the surface.
    pub(crate) fn relative<const D: usize>(self, w: &[f64; D], normal: &[f64; D]) -> [f64; D] {
        let approach = dot(w, normal);
        let tangential = along(w, -approach, normal);
        match self {
            Self::Sticky => [0.0; D],
            Self::Slip => tangential,
            _ if approach >= 0.0 => *w,
            Self::Separating => tangential,
            Self::Friction(coefficient) => {
                let speed = dot(&tangential, &tangential).sqrt();
                let kept = if speed > 0.0 { (1.0 + coefficient * approach / speed).max(0.0) } else { 0.0 };
                tangential.map(|t| t * kept)
            }
        }
    }
}
