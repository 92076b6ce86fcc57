//! Contact as a term of the incremental potential.
//!
//! [`BarrierContact`] is E(x) = κ Σ w m b(s) over the pairs of a [`CollisionMesh`] that are closer than the activation
//! distance d̂, in joules: zero without contact, infinite at contact. Put among the other terms of a step, with core's Newton
//! method or anything else that asks [`limit_step`], it keeps everything on the side it began on.
//!
//! # What a step does
//! 1. [`freeze`] admits the positions: those it has seen as the end of the last step, or that lie on the segment that
//!    detection last cleared, need no look; all others are checked by the exact intersection test
//!    ([`crate::intersection`]) and refused by name if anything meets. κ may grow, see [`crate::stiffness`].
//! 2. [`limit_step`] finds how much of a direction is free, by continuous detection over the candidates for the swept
//!    segment ([`crate::ccd`], [`crate::broad_phase`]).
//! 3. Energy, gradient and Hessian at x come from the contact set at x ([`crate::contact_set`]), built once for each x and
//!    remembered until another is asked for.
//!
//! # Pure functions
//! Energy and derivatives are functions of x and κ, and of nothing else: of x from a step's segment they are found among
//! the known candidates, for any other x candidates are searched on the spot. The limit of a step is a function of x and p. What
//! is remembered (candidates, sets, cleared segments) only saves time. So the bits of a step depend on positions and κ alone, for any
//! number of threads.
//!
//! [`freeze`]: mechanics_core::potential::Potential::freeze
//! [`limit_step`]: mechanics_core::potential::Potential::limit_step

mod active;
mod detection;
mod guard;
mod neighbourhood;
mod options;
mod readings;
mod report;
mod term;

pub use options::{BarrierForm, ContactOptions};
pub use report::{CloseFeatures, ContactCounts, ContactReport};

use crate::barrier::Barrier;
use crate::collision_mesh::{CollisionMesh, Feature, SelfContact};
use crate::error::ContactError;
use crate::intersection;
use crate::pair::PairLaw;
use crate::stiffness::{Adaptation, Scale};
use active::ActivePairs;
use detection::Detector;
use guard::Guard;
use mechanics_core::tensor::Vec3;
use neighbourhood::Neighbourhood;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The name of the term.
const NAME: &str = "contact";

/// Contact of the features of a mesh, as a term of the incremental potential; see the [module](self) page.
#[derive(Debug)]
pub struct BarrierContact {
    mesh: CollisionMesh,
    options: ContactOptions,
    barrier: Box<dyn Barrier>,
    adaptation: Adaptation,
    neighbourhood: Neighbourhood,
    detector: Detector,
    guard: Guard,
    limiting_pair: Option<[Feature; 2]>,
    /// Counts of searches and queries at the start of the step.
    before: [u64; 2],
    remembered: Mutex<Remembered>,
}

/// The active pairs last built, and for which positions.
#[derive(Debug, Default)]
struct Remembered {
    x: Vec<Vec3>,
    pairs: Arc<ActivePairs>,
    builds: u64,
}

impl BarrierContact {
    /// Contact of the features of `mesh`.
    ///
    /// # Errors
    /// If an option is out of range; or if an object may touch itself and has an edge shorter than the distance at which contact
    /// begins, so that its neighbourhoods would push themselves apart at rest.
    pub fn new(mesh: CollisionMesh, options: ContactOptions) -> Result<Self, ContactError> {
        options.validate()?;
        check_edges(&mesh, &options)?;
        let ContactOptions { activation_distance, minimum_separation, .. } = options;
        let barrier = options.form.barrier(activation_distance, minimum_separation)?;
        let halfway = minimum_separation + 0.5 * activation_distance;
        let kappa = match options.stiffness.scale {
            Scale::Kappa(kappa) => kappa,
            Scale::Load(load) => load / (-2.0 * halfway * barrier.first(halfway * halfway)),
        };
        Ok(Self {
            adaptation: Adaptation::new(kappa, options.stiffness.growth),
            neighbourhood: Neighbourhood::new(&mesh, activation_distance + minimum_separation),
            detector: Detector::new(&mesh, &options),
            guard: Guard::default(),
            limiting_pair: None,
            before: [0; 2],
            remembered: Mutex::default(),
            mesh,
            options,
            barrier,
        })
    }

    /// What may touch.
    pub fn mesh(&self) -> &CollisionMesh {
        &self.mesh
    }

    /// What contact is like.
    pub fn options(&self) -> &ContactOptions {
        &self.options
    }

    fn law(&self) -> PairLaw<'_, dyn Barrier> {
        let stiffness = self.adaptation.current();
        PairLaw { barrier: &*self.barrier, stiffness, curvature: self.options.curvature }
    }

    fn remembered(&self) -> MutexGuard<'_, Remembered> {
        // A thread that panicked while it held the lock has left either the old pairs or the new ones.
        self.remembered.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The active pairs at `x`. Built outside the lock: a thread that waits for others may be given work that asks for it.
    ///
    /// # Errors
    /// If a position is not finite.
    fn active_at(&self, x: &[Vec3]) -> Result<Arc<ActivePairs>, ContactError> {
        assert_eq!(x.len(), self.mesh.point_count(), "one position for each point of the collision mesh");
        {
            let remembered = self.remembered();
            if is_same(&remembered.x, x) {
                return Ok(Arc::clone(&remembered.pairs));
            }
        }
        let pairs = Arc::new(self.build(x)?);
        let mut remembered = self.remembered();
        remembered.x.clear();
        remembered.x.extend_from_slice(x);
        remembered.pairs = Arc::clone(&pairs);
        remembered.builds += 1;
        Ok(pairs)
    }

    fn build(&self, x: &[Vec3]) -> Result<ActivePairs, ContactError> {
        let squared = self.barrier.activation_squared();
        let weighting = self.options.weighting;
        if self.neighbourhood.covers(&self.mesh, x, x) {
            let candidates = self.neighbourhood.candidates();
            return Ok(ActivePairs::new(&self.mesh, candidates, x, squared, weighting));
        }
        let reach = self.options.activation_distance + self.options.minimum_separation;
        let mut neighbourhood = Neighbourhood::new(&self.mesh, reach);
        neighbourhood.search(&self.mesh, x, x)?;
        Ok(ActivePairs::new(&self.mesh, neighbourhood.candidates(), x, squared, weighting))
    }

    /// Makes sure that `x` is free of intersections and that its candidates are known.
    fn admit(&mut self, x: &[Vec3]) -> Result<(), ContactError> {
        assert_eq!(x.len(), self.mesh.point_count(), "one position for each point of the collision mesh");
        if self.guard.accepted() == Some(x) {
            return Ok(());
        }
        self.detector.check_positions(&self.mesh, x)?;
        if !self.neighbourhood.covers(&self.mesh, x, x) {
            self.neighbourhood.search(&self.mesh, x, x)?;
        }
        if !self.guard.knows(x) {
            let pairs = intersection::check(&self.mesh, x)?;
            if !pairs.is_empty() {
                return Err(ContactError::Intersecting { pairs });
            }
            self.check_separation(x)?;
        }
        self.guard.accept(x);
        Ok(())
    }

    fn check_separation(&self, x: &[Vec3]) -> Result<(), ContactError> {
        let active = self.active_at(x)?;
        let law = self.law();
        if active.value(law, x).is_finite() {
            return Ok(());
        }
        let pairs = active.infinite_pairs(law, &self.mesh, x);
        if pairs.is_empty() {
            let pairs = active.strongest_pairs(law, &self.mesh, x);
            return Err(ContactError::EnergyOverflow { pairs, stiffness: law.stiffness });
        }
        Err(ContactError::TooClose { pairs, minimum_separation: self.options.minimum_separation })
    }
}

/// Whether two lists hold the same bits. Without a branch for each point: this is asked for every energy.
fn is_same(a: &[Vec3], b: &[Vec3]) -> bool {
    let differ = |(a, b): (&Vec3, &Vec3)| (0..3).fold(0, |bits, k| bits | (a[k].to_bits() ^ b[k].to_bits()));
    let parts = a.chunks(64).zip(b.chunks(64));
    a.len() == b.len()
        && parts.map(|(a, b)| a.iter().zip(b).fold(0, |bits, pair| bits | differ(pair))).all(|bits| bits == 0)
}

/// Refuses a distance of contact beyond the shortest edge of an object that may touch itself.
fn check_edges(mesh: &CollisionMesh, options: &ContactOptions) -> Result<(), ContactError> {
    let reach = options.activation_distance + options.minimum_separation;
    let touches_itself = |edge: &u32| {
        let [point, _] = mesh.edges()[*edge as usize];
        mesh.self_contact(mesh.object_of(point)) == SelfContact::Allowed
    };
    let edges = (0..mesh.edges().len() as u32).filter(touches_itself);
    let lengths = edges.map(|edge| (edge, mesh.rest_length(edge)));
    match lengths.min_by(|a, b| a.1.total_cmp(&b.1)) {
        Some((edge, length)) if reach > length => {
            Err(ContactError::ActivationBeyondEdge { reach, edge: Feature::Edge(edge), length })
        }
        _ => Ok(()),
    }
}
