//! A run in steps, of a load or of time.

use super::contact::floor;
use super::{Bodies, LoadStep, LoadStepping, Motion, TimeStep};
use crate::experiment::ExperimentError;
use crate::scene::SceneFile;
use crate::scene::physics::Integration;
use mechanics_core::newton::NewtonReport;
use mechanics_core::tensor::Vec3;
use std::path::Path;

/// Equilibria one after the other, or motion.
pub(crate) struct Course {
    pub(super) kind: Kind,
    /// The height of a floor, for pictures [m].
    floor: Option<f64>,
}

pub(super) enum Kind {
    Equilibria(Box<LoadStepping>),
    Motion(Box<Motion>),
}

/// One step.
#[derive(Clone, Debug)]
pub(crate) enum Step {
    /// Of the load.
    Load(LoadStep),
    /// Of time.
    Time(TimeStep),
}

/// What colours a picture: its name, its unit and a value a point.
pub(super) struct Shade {
    pub(super) name: &'static str,
    pub(super) unit: &'static str,
    pub(super) values: Vec<f64>,
}

impl Step {
    /// Its number, from one.
    pub(crate) fn number(&self) -> usize {
        match self {
            Self::Load(step) => step.number,
            Self::Time(step) => step.number,
        }
    }

    /// What Newton's method did.
    pub(crate) fn newton(&self) -> &NewtonReport {
        match self {
            Self::Load(step) => &step.report,
            Self::Time(step) => &step.report.newton,
        }
    }

    /// The smallest det F [1].
    pub(crate) fn smallest_volume_ratio(&self) -> f64 {
        match self {
            Self::Load(step) => step.smallest_volume_ratio,
            Self::Time(step) => step.smallest_volume_ratio,
        }
    }

    /// A row of the table.
    pub(crate) fn row(&self) -> String {
        match self {
            Self::Load(step) => step.row(),
            Self::Time(step) => step.row(),
        }
    }
}

impl Course {
    /// A scene, whose file is in `folder`, before its first step.
    pub(crate) fn new(scene: &SceneFile, folder: &Path) -> Result<Self, ExperimentError> {
        let kind = match scene.integration {
            Some(Integration::Static { .. }) | None => {
                Kind::Equilibria(Box::new(LoadStepping::new(scene, folder)?))
            }
            Some(_) => Kind::Motion(Box::new(Motion::new(scene, folder)?)),
        };
        Ok(Self { kind, floor: scene.contact.as_ref().and_then(floor) })
    }

    /// Makes the next step. On error the state is as it was.
    pub(crate) fn advance(&mut self) -> Result<Step, ExperimentError> {
        match &mut self.kind {
            Kind::Equilibria(stepping) => stepping.advance().map(Step::Load),
            Kind::Motion(motion) => motion.advance().map(Step::Time),
        }
    }

    /// Steps that were made.
    pub(crate) fn done(&self) -> usize {
        match &self.kind {
            Kind::Equilibria(stepping) => stepping.done(),
            Kind::Motion(motion) => motion.done(),
        }
    }

    /// Steps to the end.
    pub(crate) fn steps(&self) -> usize {
        match &self.kind {
            Kind::Equilibria(stepping) => stepping.load_steps(),
            Kind::Motion(motion) => motion.steps(),
        }
    }

    /// The load factor [1], or the time [s].
    pub(crate) fn progress(&self) -> f64 {
        match &self.kind {
            Kind::Equilibria(stepping) => stepping.done() as f64 / stepping.load_steps() as f64,
            Kind::Motion(motion) => motion.state().time,
        }
    }

    /// The same for a reader.
    pub(crate) fn caption(&self) -> String {
        match &self.kind {
            Kind::Equilibria(_) => format!("load {:.0} %", 100.0 * self.progress()),
            Kind::Motion(_) => format!("t = {:.3} s", self.progress()),
        }
    }

    /// The names of the table's columns.
    pub(crate) fn head(&self) -> &'static str {
        match &self.kind {
            Kind::Equilibria(_) => LoadStep::HEAD,
            Kind::Motion(_) => TimeStep::HEAD,
        }
    }

    /// How long a frame of every `frame_every` steps stands in a film [s]; motion is shown as fast as it is.
    pub(crate) fn seconds_a_frame(&self, frame_every: usize) -> f64 {
        match &self.kind {
            Kind::Equilibria(_) => 0.25,
            Kind::Motion(motion) => motion.step() * frame_every as f64,
        }
    }

    /// Where the points are [m].
    pub(crate) fn positions(&self) -> &[Vec3] {
        match &self.kind {
            Kind::Equilibria(stepping) => stepping.positions(),
            Kind::Motion(motion) => &motion.state().position,
        }
    }

    /// How fast they move [m/s], if they do.
    pub(crate) fn velocities(&self) -> Option<&[Vec3]> {
        match &self.kind {
            Kind::Equilibria(_) => None,
            Kind::Motion(motion) => Some(&motion.state().velocity),
        }
    }

    /// The bodies.
    pub(crate) fn bodies(&self) -> &Bodies {
        match &self.kind {
            Kind::Equilibria(stepping) => stepping.bodies(),
            Kind::Motion(motion) => motion.bodies(),
        }
    }

    /// Free coordinates.
    pub(crate) fn unknowns(&self) -> usize {
        match &self.kind {
            Kind::Equilibria(stepping) => stepping.unknowns(),
            Kind::Motion(motion) => motion.unknowns(),
        }
    }

    /// The height of a floor [m].
    pub(super) fn floor(&self) -> Option<f64> {
        self.floor
    }

    /// What pictures show: how far points moved, or how fast they move.
    pub(super) fn shade(&self) -> Shade {
        let norms = |vectors: &[Vec3]| vectors.iter().map(Vec3::norm).collect();
        match self.velocities() {
            Some(v) => Shade { name: "speed", unit: "m/s", values: norms(v) },
            None => {
                let rest = self.bodies().mesh().points();
                let values = self.positions().iter().zip(rest).map(|(x, rest)| (x - rest).norm()).collect();
                Shade { name: "displacement", unit: "m", values }
            }
        }
    }
}
