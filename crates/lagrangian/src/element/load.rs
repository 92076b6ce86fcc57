//! Forces that do not depend on the positions: gravity and dead loads, with an amplitude over time.

use super::error::ElementError;
use super::mass::Mass;
use mechanics_core::potential::{Changed, Potential, PotentialError};
use mechanics_core::projection::Projection;
use mechanics_core::sparse::Assembler;
use mechanics_core::stage::{Moment, Stage};
use mechanics_core::tensor::Vec3;

/// How a load varies with time; in statics, time is the part of the load that is on.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Amplitude {
    /// Always one.
    #[default]
    Constant,
    /// Grows in proportion to time and stays at one from time 1 on: for load stepping.
    Ramp,
    /// Linear between (time \[s\], factor) pairs of ascending time, constant before the first and after the last. Two
    /// rows of one time make a jump. Other tables are refused when a step begins.
    Table(Vec<(f64, f64)>),
}

impl Amplitude {
    /// The factor at a time \[s\]; zero for an empty table.
    pub fn at(&self, time: f64) -> f64 {
        match self {
            Self::Constant => 1.0,
            Self::Ramp => time.clamp(0.0, 1.0),
            Self::Table(rows) => {
                let next = rows.partition_point(|row| row.0 <= time);
                match (next.checked_sub(1).map(|last| rows[last]), rows.get(next)) {
                    (Some((t0, f0)), Some(&(t1, f1))) => f0 + (f1 - f0) * (time - t0) / (t1 - t0),
                    (Some((_, factor)), None) | (None, Some(&(_, factor))) => factor,
                    (None, None) => 0.0,
                }
            }
        }
    }
}

impl Amplitude {
    /// Refuses a table that does not ascend or holds what is not finite, in the name of a term.
    pub(super) fn check(&self, term: &str) -> Result<(), PotentialError> {
        let Self::Table(rows) = self else { return Ok(()) };
        for (index, &(time, factor)) in rows.iter().enumerate() {
            let falls = index > 0 && time < rows[index - 1].0;
            let (quantity, value, expected) = if !time.is_finite() || falls {
                ("time", time, "finite and not before the last")
            } else if !factor.is_finite() {
                ("factor", factor, "finite")
            } else {
                continue;
            };
            let owner = "amplitude table's row";
            let source = Box::new(ElementError::OutOfRange { quantity, owner, index, value, expected });
            return Err(PotentialError::Term { term: term.to_owned(), source });
        }
        Ok(())
    }
}

/// Forces fᵢ on points that keep size and direction: the energy is −A(t) Σ fᵢ · xᵢ \[J\], with an amplitude A. A force on
/// a point that does not exist is refused when a step begins.
#[derive(Clone, Debug)]
pub struct DeadLoad {
    name: String,
    forces: Vec<(u32, Vec3)>,
    amplitude: Amplitude,
    factor: f64,
}

impl DeadLoad {
    /// Forces \[N\] on points.
    ///
    /// # Errors
    /// [`ElementError::OutOfRange`] names the point whose force is not finite.
    pub fn new(name: impl Into<String>, forces: Vec<(u32, Vec3)>) -> Result<Self, ElementError> {
        for (point, force) in &forces {
            if let Some(&value) = force.iter().find(|entry| !entry.is_finite()) {
                return Err(ElementError::OutOfRange {
                    quantity: "force",
                    owner: "vertex",
                    index: *point as usize,
                    value,
                    expected: "finite",
                });
            }
        }
        let amplitude = Amplitude::Constant;
        Ok(Self { name: name.into(), forces, amplitude, factor: 1.0 })
    }

    /// Weight: the forces M (g, g, …) of a uniform field `acceleration` [m/s²].
    ///
    /// # Errors
    /// [`ElementError::OutOfRange`] if the acceleration is not finite.
    pub fn gravity(mass: &Mass, acceleration: &Vec3) -> Result<Self, ElementError> {
        let forces = mass.row_sums().into_iter().zip(0..).filter(|(m, _)| *m != 0.0);
        Self::new("gravity", forces.map(|(m, point)| (point, acceleration * m)).collect())
    }

    /// The same with another amplitude.
    pub fn with_amplitude(self, amplitude: Amplitude) -> Self {
        Self { factor: amplitude.at(0.0), amplitude, ..self }
    }

    /// The forces \[N\], before the amplitude.
    pub fn forces(&self) -> &[(u32, Vec3)] {
        &self.forces
    }
}

impl Potential for DeadLoad {
    fn name(&self) -> &str {
        &self.name
    }

    fn value(&self, x: &[Vec3]) -> f64 {
        let work: f64 = self.forces.iter().map(|&(i, f)| f.dot(&x[i as usize])).sum();
        -self.factor * work
    }

    fn add_gradient(&self, _: &[Vec3], gradient: &mut [Vec3]) {
        for &(point, force) in &self.forces {
            gradient[point as usize] -= force * self.factor;
        }
    }

    fn add_hessian(&self, _: &[Vec3], _: Projection, _: &mut Assembler<'_>) {}

    fn freeze(&mut self, stage: &Stage<'_>) -> Result<Changed, PotentialError> {
        if stage.moment != Moment::Step {
            return Ok(Changed::Nothing);
        }
        self.amplitude.check(&self.name)?;
        let points = stage.x.len();
        let is_out = |&(_, (point, _)): &(usize, &(u32, Vec3))| *point as usize >= points;
        if let Some((element, &(point, _))) = self.forces.iter().enumerate().find(is_out) {
            let source = Box::new(ElementError::PointOutOfRange { element, point, points });
            return Err(PotentialError::Term { term: self.name.clone(), source });
        }
        self.factor = self.amplitude.at(stage.time);
        Ok(Changed::Energy)
    }
}
