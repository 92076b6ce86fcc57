//! What can be wrong with a simulation, by culprit.

use crate::implicit::ImplicitError;
use mpm_constitutive::PointLawError;

/// Why a simulation cannot be set up or advanced. Whatever failed, the state is as it was.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MpmError {
    /// The distance of nodes is positive and finite.
    #[error("the grid's spacing must be positive and finite, not {value} m")]
    Spacing {
        /// The spacing \[m\].
        value: f64,
    },
    /// A blend or damping is a part.
    #[error("{what} must lie between 0 and 1, not at {value}")]
    Part {
        /// What is wrong.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// XPIC makes one pass at least.
    #[error("the order of XPIC must be 1 or more, not 0")]
    Order,
    /// A number of the set-up is out of range.
    #[error("{what} is {value}: it must be finite and, where it has no direction, positive")]
    Number {
        /// What is wrong.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// An affine transfer divides by the kernel's second moment, which is zero for a linear kernel at nodes.
    #[error(
        "APIC and MLS need quadratic or cubic kernels: the second moment of a linear one vanishes at nodes"
    )]
    SingularMoment,
    /// A body has particles.
    #[error("a body without particles")]
    EmptyBody,
    /// Every particle has its position, velocity, volume.
    #[error("{count} {what} for {particles} particles")]
    Count {
        /// What there is too little or too much of.
        what: &'static str,
        /// How many there are.
        count: usize,
        /// How many there should be.
        particles: usize,
    },
    /// A particle's number is out of range.
    #[error("particle {particle} of body {body}: its {what} is {value}, and it must be {wanted}")]
    Particle {
        /// The body's number.
        body: usize,
        /// The particle's number within it.
        particle: usize,
        /// Which of its numbers.
        what: &'static str,
        /// The number.
        value: f64,
        /// What is allowed.
        wanted: &'static str,
    },
    /// A material is pressed or turned where its law does not reach.
    #[error("particle {particle} of body {body}: {source}")]
    Law {
        /// The body's number.
        body: usize,
        /// The particle's number within it.
        particle: usize,
        /// What the law says.
        source: PointLawError,
    },
    /// Too many blocks, or a particle so far away that its cell has no number.
    #[error("particle {particle} of body {body} is at {position:?}, beyond {limit} cells of {spacing} m")]
    TooFar {
        /// The body's number.
        body: usize,
        /// The particle's number within it.
        particle: usize,
        /// Where it is \[m\].
        position: Vec<f64>,
        /// How many cells are numbered from the origin.
        limit: f64,
        /// The grid's spacing \[m\].
        spacing: f64,
    },
    /// A particle is or would be outside of the domain.
    #[error(
        "particle {particle} of body {body} leaves the domain from {low:?} to {high:?} m: it comes to {position:?}"
    )]
    OutOfDomain {
        /// The body's number.
        body: usize,
        /// The particle's number within it.
        particle: usize,
        /// Where it is, or would be after the step \[m\].
        position: Vec<f64>,
        /// The lowest corner of the domain \[m\].
        low: Vec<f64>,
        /// Its highest corner \[m\].
        high: Vec<f64>,
    },
    /// A particle that does not exist.
    #[error("body {body} has no particle {particle}: it has {particles}, numbered from 0")]
    NoParticle {
        /// The body's number.
        body: usize,
        /// The particle's number.
        particle: usize,
        /// How many there are.
        particles: usize,
    },
    /// Total deformation gradients are asked for, and the body does not keep them.
    #[error("body {body} does not keep its total deformation: add it with `add_tracked_body`")]
    NoTotalDeformation {
        /// The body's number.
        body: usize,
    },
    /// A shape of a boundary or a region is degenerate.
    #[error("{what} is {value}, and it must be {wanted}")]
    Shape {
        /// What is wrong.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        wanted: &'static str,
    },
    /// A place that a deformation map does not reach from the identity.
    #[error(
        "no material point is found at {position:?} m at {time} s: the map misses it by {distance} m; it must start as the \
         identity and be invertible"
    )]
    NoMaterialPoint {
        /// The place \[m\].
        position: Vec<f64>,
        /// \[s\].
        time: f64,
        /// The distance that is left \[m\].
        distance: f64,
    },
    /// A time step is positive and finite.
    #[error("the time step must be positive and finite, not {value} s")]
    Step {
        /// The step \[s\].
        value: f64,
    },
    /// A step beyond the stable one.
    #[error(
        "a time step of {step} s is above the stable {stable} s; take a shorter one, `advance`, or `step_unchecked`"
    )]
    Unstable {
        /// The step asked for \[s\].
        step: f64,
        /// The longest one allowed \[s\].
        stable: f64,
    },
    /// A node's velocity is not finite though every particle is.
    #[error("the velocity of the node at {position:?} m is not finite")]
    Node {
        /// Where the node is \[m\].
        position: Vec<f64>,
    },
    /// An implicit step that is not solved.
    #[error(transparent)]
    Implicit(#[from] ImplicitError),
    /// The particles move faster than anything sensible.
    #[error("the stable time step of {stable} s is too short to reach {duration} s in {most} steps")]
    TooManySteps {
        /// The stable step \[s\].
        stable: f64,
        /// The time to cover \[s\].
        duration: f64,
        /// How many steps are allowed.
        most: u64,
    },
}
