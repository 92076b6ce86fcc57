//! Implicit steps: backward Euler as the minimum of an incremental potential over the nodes.
//!
//! # What is minimised
//! Scatter, nodes and gather are those of an explicit step; only the velocities vᵢ of the nodes at its end are others. Explicitly the
//! stress of the begin acts; here that of the end does. With v̂ᵢ the velocities without stress (momentum, gravity, tractions of the begin),
//! G_p = h∇v_p = h Σ vᵢ ⊗ gᵢ the displacement gradient of a particle (gᵢ = ∇wᵢ, or D⁻¹wᵢ(xᵢ − x) for moving least squares) and W the energy of
//! its step per rest volume,
//!
//! Φ(v) = ½ Σᵢ mᵢ ‖vᵢ − v̂ᵢ‖² + Σ_p V₀ W(G_p),  W(G) = ψ((I + G) F)                                                  (1)
//!
//! ∂Φ/∂vᵢ = mᵢ (vᵢ − v̂ᵢ) + h Σ_p V₀ W′(G_p) gᵢ,  W′ = P Fᵀ = τ (I + G)⁻ᵀ                                                 (2)
//!
//! (2) = 0 is backward Euler on the grid of the begin: (I + G)⁻ᵀ pulls the stress of the end back to where the gradients gᵢ are taken. A fluid
//! has W(G) = ψ(J (1 + tr G)), W′ = −p J I. Newtonian viscosity adds its rate potential ½h τ_v(J, ∇v) : ∇v at the volume of the begin. Forces
//! still sum to zero over i, so momentum is kept to what Newton leaves of (2); angular momentum is kept to the order of h, because τ is
//! symmetric at the end and the lever arms are those of the begin.
//!
//! Backward Euler is of order one, and damps: an oscillation of frequency ω loses the factor 1/√(1 + h²ω²) a step.
//!
//! # Flow
//! Plastic laws flow *after* the solve, in the gather, as in an explicit step: W is elastic, at the history of the begin (a lagged return map).
//! So (1) stays a minimum for every law. With the return map inside, (2) has a potential for associative flow alone, and its derivative
//! for sand, whose flow is not associative, is not symmetric: neither conjugate gradients nor a line search on Φ would be sound.
//! The price: in the momentum balance of one step stress is as far beyond the yield surface as the strain of one step can bring it. That acts like
//! a viscosity of about μh on the flow. It vanishes with h, of order one like the rest; it is too much where flow fast
//! compared with one step decides. Explicit steps are the better ones there.
//!
//! # How it is minimised
//! By core's Newton, with a line search on Φ: a trial that turns matter inside out has Φ = ∞ and is halved. The Hessian
//!
//! H = M + h² Σ_p V₀ gᵢ · W″(G_p) · gⱼ                                                                                   (3)
//!
//! takes ∂P/∂F from the law with negative eigenvalues set to zero, so H is positive definite. It is never assembled. Once an iteration
//! V₀W″ is stored, D²(D² + 1)/2 numbers a particle; then a product H q is: gather dG = h∇q, V₀W″ : dG, scatter — the inner loops of an explicit
//! step without its law. Conjugate gradients are preconditioned by the diagonal blocks (D×D) of (3), and stop where Eisenstat and Walker say.
//! Stiffness contrasts between materials are in the blocks and cost no iterations; long steps do, about in proportion to h.
//!
//! Newton starts from the lowest Φ among v̂, v̂ without gravity, and rest.
//!
//! # Boundaries
//! They are conditions on vᵢ in the solve, and so are solids of triangles and grips. Inside of them, sticky surfaces, grips and prescribed velocities fix vᵢ; slip fixes n·vᵢ.
//! Newton works in what is free: gradients, directions and the preconditioner are projected. Separating surfaces are inequalities n·(vᵢ − u) ≥ 0:
//! which ones hold is found by rounds of minimisation, letting go where the surface would pull and holding where it is entered (primal-dual active sets).
//! Friction joins the rounds: what is pushed slides freely in the first one, and is then braked by a potential of at most μ times the normal impulse λ of the round before, μλ ε ln cosh(‖t‖/ε)
//! with t the sliding velocity and a creep velocity ε of 1e-4 of the speed that matters: its derivative is μλ tanh(‖t‖/ε). What sticks creeps by a part of ε. Twelve rounds
//! follow λ and let go; later ones only hold more, so that they end.
//! At the minimum ∇Φ = Σ λ n: what a collider takes from a node is the opposite of its own λ n less what its friction takes from ∇Φ.
//! Thin sheets are left to explicit steps: near them a node is two, one for each side, and the unknowns here are velocities of single nodes.
//! A node outside of all boundaries does not see them: where matter comes flying, a step should not be longer than it takes for a cell.
//!
//! # Precision
//! The solve is in double precision whatever that of the particles is; `f32` particles give and take rounded numbers.
//!
//! # Reference
//! T. F. Gast et al., *Optimization integrator for large time steps*, IEEE TVCG 21(10), 2015, section 5, for the minimum;
//! A. Stomakhin et al., *A material point method for snow simulation*, ACM Trans. Graph. 32(4), 2013, for flow after the solve;
//! M. Hintermüller, K. Ito, K. Kunisch, *The primal-dual active set strategy as a semismooth Newton method*, SIAM J. Optim. 13(3), 2003.

mod cloud;
mod conjugate_gradient;
mod constraints;
mod law;
mod nodes;
mod preconditioner;
mod problem;

pub(crate) use law::StepLaw;
pub(crate) use nodes::Nodes;
pub(crate) use problem::Problem;

use crate::Grid;
use crate::body::{Body, StepSettings};
use crate::boundary::{Boundary, PrescribedVelocity};
use crate::collider::{ColliderStage, Impulse};
use crate::grip::PlacedGrip;
use cloud::Cloud;
use constraints::{Constraints, Sources};
use mechanics_core::lanes::Element;
use mechanics_core::newton::{Forcing, NewtonCause, NewtonError, NewtonOptions, minimise};
use mechanics_core::objective::{Location, Objective, ObjectiveError};

/// How accurately Newton's directions are solved on the way.
const FORCING: Forcing = Forcing::EisenstatWalker { first: 0.1, largest: 0.1 };

/// Solves until the inequalities of boundaries agree.
const MOST_ROUNDS: u64 = 60;

/// How an implicit step is solved: [`Simulation::step_implicitly`](crate::Simulation::step_implicitly).
///
/// The step minimises the incremental potential of backward Euler over the velocities of the nodes. It is stable at any length, of order one, and
/// damps motion that is fast compared with it. Plastic laws flow after the solve. Theory: `docs/theory/mpm-core.md`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImplicitStep {
    /// Newton's last step, as a part of the speed that matters: the largest velocity before stress or of Newton's first step, but no more
    /// than one cell a step. Nodes that particles hardly touch count less, by the root of their mass.
    pub tolerance: f64,
    /// Newton iterations after which not having converged is an error.
    pub max_iterations: u32,
}

impl Default for ImplicitStep {
    /// 1e-6, 100 iterations.
    fn default() -> Self {
        Self { tolerance: 1e-6, max_iterations: 100 }
    }
}

/// What an implicit step did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImplicitReport {
    /// As of an explicit step.
    pub step: crate::StepReport,
    /// Newton iterations.
    pub iterations: u64,
    /// Halvings of the line search.
    pub halvings: u64,
    /// Products of the Hessian and a vector.
    pub products: u64,
    /// Solves until the inequalities of boundaries agreed.
    pub rounds: u64,
    /// Unknown velocities.
    pub unknowns: u64,
    /// Time of all products \[s\].
    pub product_time: f64,
}

/// Why an implicit step was not made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ImplicitError {
    /// The tolerance is out of range.
    #[error("the tolerance of an implicit step must be positive and finite, not {value}")]
    Tolerance {
        /// Its value.
        value: f64,
    },
    /// Thin sheets act in explicit steps only: nodes near them are two, one for each side, which the solve does not know.
    #[error("implicit steps do not know {what} yet, and this simulation has {count}: take explicit ones")]
    NotKnown {
        /// What of its set-up.
        what: &'static str,
        /// How many there are.
        count: usize,
    },
    /// Transfers with passes or positions of their own belong to explicit steps.
    #[error(
        "implicit steps take PIC, FLIP, APIC and MLS-APIC, and neither XPIC of more than one pass nor ASFLIP"
    )]
    Transfer,
    /// No start of the iteration leaves every particle admissible.
    #[error(
        "particle {particle} of body {body} would change its volume by the factor {ratio} before the first iteration: boundaries or prescribed \
         velocities turn it inside out; take a shorter step"
    )]
    Start {
        /// The body's number.
        body: usize,
        /// The particle's number within it.
        particle: usize,
        /// det(I + h∇v).
        ratio: f64,
    },
    /// The potential is not finite though every particle's energy is.
    #[error("the incremental potential is not finite: velocities or the step are too large")]
    Infinite,
    /// Newton's method did not converge.
    #[error(
        "no convergence after {iterations} Newton iterations: the last step was {reached:e} of the speed that matters, {wanted:e} is wanted; \
         it was largest at the node at {position:?} m"
    )]
    NotConverged {
        /// Iterations made.
        iterations: u32,
        /// The last step, relatively.
        reached: f64,
        /// The tolerance.
        wanted: f64,
        /// The node where the last step was largest \[m\].
        position: Vec<f64>,
    },
    /// No part of Newton's step lowers the potential.
    #[error(
        "the line search failed in iteration {iterations}: {what}; the step is largest at the node at {position:?} m. A shorter time step may help"
    )]
    LineSearch {
        /// Iterations made.
        iterations: u32,
        /// What Newton's method says.
        what: String,
        /// The node where the step was largest \[m\].
        position: Vec<f64>,
    },
    /// The linear system of a Newton step was not solved.
    #[error(
        "a linear system was not solved in {products} products: its residual is {residual:e}, {wanted:e} is wanted"
    )]
    LinearSystem {
        /// Products made.
        products: u64,
        /// The residual, relatively.
        residual: f64,
        /// What was wanted.
        wanted: f64,
    },
    /// A search for equilibrium did not find it.
    #[error(
        "no equilibrium after {steps} steps: forces still accelerate matter by {imbalance:e} m/s\u{b2}, {wanted:e} is wanted; is the body held, and \
         can its law bear the load?"
    )]
    NoEquilibrium {
        /// Steps made.
        steps: u32,
        /// The largest acceleration left \[m/s²\].
        imbalance: f64,
        /// The largest one allowed.
        wanted: f64,
    },
    /// Boundaries did not agree on which nodes they hold.
    #[error("after {rounds} rounds {nodes} nodes still change between held and free; take a shorter step")]
    Boundaries {
        /// Rounds made.
        rounds: u64,
        /// Conditions that changed in the last one.
        nodes: usize,
    },
}

/// What acts on nodes in a step.
pub(crate) struct Conditions<'a, const D: usize> {
    pub(crate) grips: &'a [PlacedGrip<D>],
    pub(crate) prescribed: &'a [PrescribedVelocity<D>],
    pub(crate) boundaries: &'a [Boundary<D>],
    pub(crate) colliders: &'a ColliderStage<'a>,
    /// Middle and end of the step \[s\].
    pub(crate) middle: f64,
    pub(crate) end: f64,
    /// Factor of the velocities of all of them.
    pub(crate) speed: f64,
    /// The velocity that gravity gives in a step \[m/s\].
    pub(crate) gain: [f64; D],
}

/// The potential of a step of a grid that holds the velocities without stress.
pub(crate) fn potential<'a, E: Element, const D: usize>(
    grid: &'a Grid<E, D>,
    bodies: &'a [Body<E, D>],
    settings: StepSettings,
    conditions: &Conditions<'_, D>,
) -> Problem<'a, D> {
    let nodes = Nodes::new(grid, settings.spacing);
    let sources = Sources {
        grips: conditions.grips,
        prescribed: conditions.prescribed,
        boundaries: conditions.boundaries,
        colliders: conditions.colliders,
        middle: conditions.middle,
        end: conditions.end,
        speed: conditions.speed,
    };
    let constraints = Constraints::new(&sources, &nodes.places, &nodes.forecast);
    Problem::new(grid, Cloud::new(bodies, settings), nodes, constraints, settings)
}

/// What a solve has found.
pub(crate) struct Minimum<const D: usize> {
    /// The nodes with mass.
    pub(crate) nodes: Nodes<D>,
    /// Of the nodes.
    pub(crate) velocities: Vec<f64>,
    /// What colliders take at nodes, by collider.
    pub(crate) loads: Vec<(usize, Impulse)>,
    pub(crate) report: ImplicitReport,
}

/// The velocities of the nodes at the minimum: rounds of minimisations.
pub(crate) fn minimum<const D: usize>(
    mut problem: Problem<'_, D>,
    conditions: &Conditions<'_, D>,
    options: &ImplicitStep,
) -> Result<Minimum<D>, ImplicitError> {
    let mut x = problem.start(&conditions.gain)?;
    let mut report = ImplicitReport { unknowns: x.len() as u64, ..ImplicitReport::default() };
    let newton = NewtonOptions {
        tolerance: options.tolerance,
        max_iterations: options.max_iterations,
        forcing: FORCING,
        ..NewtonOptions::default()
    };
    loop {
        report.rounds += 1;
        match minimise(&mut problem, &mut x, &newton) {
            Err(error) => return Err(problem_error(*error, &problem.nodes.places, options)),
            Ok(done) => {
                report.iterations += done.iterations;
                report.halvings += done.halvings;
            }
        }
        let changed = problem.revise(&x, options.tolerance, report.rounds);
        if changed == 0 {
            break;
        }
        if report.rounds == MOST_ROUNDS {
            return Err(ImplicitError::Boundaries { rounds: report.rounds, nodes: changed });
        }
        if report.rounds == 1 {
            problem.constraints.stick(&mut x);
        }
        problem.constraints.place(&mut x);
        if !problem.value(&x).is_finite() {
            x = problem.start(&conditions.gain)?;
        }
    }
    report.products = problem.products;
    report.product_time = problem.product_time.as_secs_f64();
    let loads = if problem.constraints.touch_colliders() {
        let gradient = problem.whole_gradient(&x);
        problem.constraints.loads(&problem.nodes.places, &x, &gradient)
    } else {
        Vec::new()
    };
    let Problem { nodes, .. } = problem;
    Ok(Minimum { nodes, velocities: x, loads, report })
}

/// The error of a minimisation in the words of this crate.
fn problem_error<const D: usize>(
    error: NewtonError,
    places: &[[f64; D]],
    options: &ImplicitStep,
) -> ImplicitError {
    let NewtonError { cause, progress, .. } = error;
    let iterations = progress.iteration;
    let position = |location: &Location| {
        location.point.and_then(|point| places.get(point)).map_or(Vec::new(), |place| place.to_vec())
    };
    match &cause {
        NewtonCause::NotConverged { location, .. } | NewtonCause::Stagnated { location, .. } => {
            ImplicitError::NotConverged {
                iterations,
                reached: progress.step_norm,
                wanted: options.tolerance,
                position: position(location),
            }
        }
        NewtonCause::Objective(ObjectiveError::Solver(source)) => {
            match source.downcast_ref::<ImplicitError>() {
                Some(error) => error.clone(),
                None => {
                    ImplicitError::LineSearch { iterations, what: cause.to_string(), position: Vec::new() }
                }
            }
        }
        NewtonCause::LineSearch { location, .. }
        | NewtonCause::NoFiniteValue { location, .. }
        | NewtonCause::Diverged { location, .. } => {
            ImplicitError::LineSearch { iterations, what: cause.to_string(), position: position(location) }
        }
        _ => ImplicitError::LineSearch { iterations, what: cause.to_string(), position: Vec::new() },
    }
}
