//! What stops position-based dynamics.

use crate::element::ThinError;

/// Why particles, constraints or a step were refused. The particles are then as they were.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PositionError {
    /// The step size is not a positive number.
    #[error("the step size is {step} s; it must be positive and finite")]
    Step {
        /// The step size \[s\].
        step: f64,
    },
    /// Without iterations no constraint is looked at.
    #[error("position-based dynamics needs at least one iteration a step")]
    NoIterations,
    /// A position, velocity or acceleration is infinite or NaN.
    #[error("the {what} of particle {particle} has the component {value}")]
    NonFinite {
        /// Of what.
        what: &'static str,
        /// The particle.
        particle: usize,
        /// The first offending component.
        value: f64,
    },
    /// An inverse mass is negative, infinite or NaN.
    #[error("particle {particle} has the inverse mass {value} 1/kg; it must be finite and not negative")]
    InverseMass {
        /// The particle.
        particle: usize,
        /// Its inverse mass.
        value: f64,
    },
    /// A rest shape is degenerate.
    #[error(transparent)]
    Rest(#[from] ThinError),
    /// A tetrahedron has no positive rest volume.
    #[error("tetrahedron {element} has the rest volume {volume:e} m³; it must be positive")]
    RestVolume {
        /// The tetrahedron.
        element: usize,
        /// Its volume \[m³\].
        volume: f64,
    },
    /// A plane's normal has no direction.
    #[error("the ground's normal {normal:?} has no direction")]
    Normal {
        /// The normal given.
        normal: [f64; 3],
    },
    /// A compliance is negative, infinite or NaN.
    #[error("{group}: constraint {element} has the compliance {value}; it must be finite and not negative")]
    Compliance {
        /// The group's name.
        group: String,
        /// The constraint.
        element: usize,
        /// Its compliance.
        value: f64,
    },
    /// There is not one compliance per constraint.
    #[error("{group}: {found} compliances for {expected} constraints")]
    ComplianceCount {
        /// The group's name.
        group: String,
        /// How many there are.
        found: usize,
        /// How many constraints there are.
        expected: usize,
    },
    /// A classic stiffness is not in (0, 1].
    #[error("{group}: the stiffness is {value}; it must be larger than 0 and at most 1")]
    Stiffness {
        /// The group's name.
        group: String,
        /// The stiffness.
        value: f64,
    },
    /// A constraint names a particle twice.
    #[error("{group}: constraint {element} names particle {particle} twice")]
    RepeatedParticle {
        /// The group's name.
        group: String,
        /// The constraint.
        element: usize,
        /// The particle.
        particle: u32,
    },
    /// A constraint names a particle that does not exist.
    #[error("{group}: constraint {element} names particle {particle}, but there are only {particles}")]
    ParticleOutOfRange {
        /// The group's name.
        group: String,
        /// The constraint.
        element: usize,
        /// The particle.
        particle: u32,
        /// How many there are.
        particles: usize,
    },
}
