//! What leads matter: a region whose nodes move rigidly for some time.

use crate::MpmError;
use crate::boundary::{Shape, finite};
use crate::traction::embedded;
use mechanics_core::tensor::{Mat3, Vec3};
use nalgebra::Rotation3;

/// A rigid motion that the nodes of a region are given for some time, and the region with them: a clamp, a crank, a gripper that lets go.
///
/// At time t the region has turned by ω (t − from) about its centre, which is then at c(t) = c + v (t − from). In a step from t to t + h the
/// nodes inside get the velocity that carries them along exactly,
///
/// u(x) = (c(t + h) + R(h ω) (x − c(t)) − x)/h,
///
/// which tends to v + ω × (x − c(t)) for short steps: matter inside moves without strain, and on circles, for any step. Grips act in the steps whose middle is
/// at `from` ≤ t < `until`, on nodes with mass, after forces and before [prescribed velocities](crate::PrescribedVelocity) and boundaries; the last one that reaches a node
/// counts. So no step is shortened: a grip begins and ends at the boundary of steps that is nearest, whatever rounding does to their sum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grip<const D: usize> {
    /// Where, when it begins.
    pub region: Shape<D>,
    /// What it turns about, when it begins \[m\].
    pub centre: [f64; D],
    /// v \[m/s\].
    pub velocity: [f64; D],
    /// ω \[rad/s\]; in the plane the third number alone has a meaning.
    pub angular_velocity: [f64; 3],
    /// From this time on \[s\].
    pub from: f64,
    /// Before this time \[s\]; may be ∞.
    pub until: f64,
}

/// A grip in one step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlacedGrip<const D: usize> {
    region: Shape<D>,
    /// c, c(t), c(t + h).
    centres: [Vec3; 3],
    /// From where the region is to where it was when the grip began.
    back: Mat3,
    /// R(h ω).
    turn: Mat3,
    step: f64,
}

fn rotation(vector: &Vec3) -> Mat3 {
    Rotation3::from_scaled_axis(*vector).into_inner()
}

impl<const D: usize> Grip<D> {
    /// Whether it acts in a step whose middle is at `middle` \[s\].
    pub(crate) fn acts_at(&self, middle: f64) -> bool {
        self.from <= middle && middle < self.until
    }

    /// The grip in a step from `begin` to `end`.
    pub(crate) fn placed(&self, begin: f64, end: f64) -> PlacedGrip<D> {
        let spin = Vec3::from(self.angular_velocity);
        let centre = |time: f64| embedded(&self.centre) + embedded(&self.velocity) * (time - self.from);
        PlacedGrip {
            region: self.region,
            centres: [embedded(&self.centre), centre(begin), centre(end)],
            back: rotation(&(spin * (self.from - begin))),
            turn: rotation(&(spin * (end - begin))),
            step: end - begin,
        }
    }

    pub(crate) fn check(&self) -> Result<(), MpmError> {
        self.region.check()?;
        finite("the centre of a grip", &self.centre)?;
        finite("the velocity of a grip", &self.velocity)?;
        finite("the angular velocity of a grip", &self.angular_velocity)?;
        finite("the begin of a grip", &[self.from])?;
        let flat = D == 3 || self.angular_velocity[..2] == [0.0; 2];
        if !flat {
            let (what, value) = ("the angular velocity of a grip across the plane", self.angular_velocity[0]);
            return Err(MpmError::Shape { what, value, wanted: "0" });
        }
        if !(self.until > self.from) {
            let (what, wanted) = ("the end of a grip", "after its begin");
            return Err(MpmError::Shape { what, value: self.until, wanted });
        }
        Ok(())
    }
}

impl<const D: usize> PlacedGrip<D> {
    /// The velocity that it gives to the node at `point`, if it reaches it.
    pub(crate) fn velocity_at(&self, point: &[f64; D]) -> Option<[f64; D]> {
        let [start, before, after] = &self.centres;
        let x = embedded(point);
        let own = start + self.back * (x - before);
        self.region.normal_inside(&std::array::from_fn(|axis| own[axis]))?;
        let moved = after + self.turn * (x - before);
        Some(std::array::from_fn(|axis| (moved[axis] - x[axis]) / self.step))
    }
}
