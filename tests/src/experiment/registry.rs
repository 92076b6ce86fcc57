//! The experiments that scene files can name.

use super::Experiment;
use super::across::{GrippedSplats, PendulumBar};
use super::bodies::{
    BarOfSprings, BarOfTetrahedra, Cantilever, ManufacturedMotion, NodalDamping, PositionBasedSteps,
    StandingWave, Torsion,
};
use super::contact::{
    BarImpact, BlockOnFloor, Collision, DegeneratePair, FastImpact, FoldedCloth, GapForEveryStep, HardDrop,
    Hertz, LinkedChain, NarrowPipe, ParticleOnPlate, PlantedContacts, PressedBar, PressedStack, TwistedMat,
    TwoBlocks, Units,
};
use super::friction::{
    BallImpact, BitingRollers, BlocksOnInclines, Capstan, CardHouse, ElasticBlockOnIncline, FrictionPair,
    Funnel, GlancingBlow, Gripper, HeavyOnLight, MasonryArch, PulledKnot, PulledStack, Rollers,
    SlidingDistance, SpinningDisk, StickSlip, StickingPile, Tablecloth, TactilePad, Turntable,
};
use super::hard_cases::{HardBeam, HardCloth, RefusedStart, ReleasedBlock, WrungMat};
use super::killed::KilledRuns;
use super::laws::LawConsistency;
use super::motion::{
    BeadOnWire, Chain, Damping, LongEnergy, Orbits, RigidBody, StationaryAction, Trajectory,
};
use super::particles::{
    BlockOnIncline, BouncingBall, BunnyInSand, BunnyInWater, CellCrossing, CrowdedCell, DamBreak,
    FreeRotation, GranularColumn, HangingCantilever, HardCollision, LawsAtLimits, LayeredColumn, LoadedBar,
    ManufacturedParticles, MassMatrix, MeetingBars, NullSpace, ParticleAlone, PulledBar, RefusedNumbers,
    SelfWeightColumn, SettlingSand, StretchedAndReleased, TaylorBar, ThinSheet, TwoDisks, VibratingBar,
};
use super::point_laws::{ClayPoint, FluidPoint, FoamPoint, LawCycles, MetalPoint, SandPoint, SnowPoint};
use super::readers::MeshReaders;
use super::selftest::Selftest;
use super::simulation::Simulation;
use super::soak::Soak;
use super::solid::{HomogeneousDeformation, LinearSystems, ManufacturedStatics};
use super::splat_motion::{SplatDrives, SplatDrop, SplatPile, SplatsOnTets};
use super::splats::{
    SplatFilling, SplatPictureModes, SplatPlasticShear, SplatRigidMotion, SplatSamples, SplatStretch,
};
use super::svd::SvdKernels;
use super::thin_bodies::{CooksMembrane, ElasticaCantilever, HangingCable, TwistedRod};
use crate::scene::Inconsistency;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::DeserializeOwned;

mod parameters;

pub(crate) use parameters::Misfit;
use parameters::Parameter;

/// One registered experiment.
pub struct Entry {
    /// Its name in scene files.
    pub name: &'static str,
    /// What it does, in one sentence.
    pub summary: &'static str,
    read: fn(Parameter) -> Result<Box<dyn Experiment>, Misfit>,
    schema: fn(&mut SchemaGenerator) -> Schema,
}

impl Entry {
    const fn of<E: Experiment + DeserializeOwned + JsonSchema + 'static>(
        name: &'static str,
        summary: &'static str,
    ) -> Self {
        Self { name, summary, read: read::<E>, schema: |generator| generator.subschema_for::<E>() }
    }

    /// The experiment with the parameters that the text of a scene file gives it.
    pub(crate) fn read(&self, text: &str) -> Result<Box<dyn Experiment>, Misfit> {
        (self.read)(parameters::parameters(text)?)
    }

    /// The JSON Schema of its parameters.
    pub(crate) fn schema(&self, generator: &mut SchemaGenerator) -> Schema {
        (self.schema)(generator)
    }
}

/// Every experiment, in name order. A new one is one line here.
const ENTRIES: &[Entry] = &[
    Entry::of::<BallImpact>("ball-impact", "An elastic ball that hits a plate, against Hertz's impact."),
    Entry::of::<BarImpact>("bar-impact", "An elastic bar that hits a wall, against the wave solution."),
    Entry::of::<BarOfSprings>("bar-of-springs", "Frequencies of a bar of springs against closed forms."),
    Entry::of::<BarOfTetrahedra>(
        "bar-of-tetrahedra",
        "The axial frequency of a bar of tetrahedra against the closed form.",
    ),
    Entry::of::<BeadOnWire>("bead-on-wire", "A bead on a wire in Cartesian coordinates, with its reaction."),
    Entry::of::<BitingRollers>(
        "biting-rollers",
        "A block on two rollers that turn towards each other, against the bite condition.",
    ),
    Entry::of::<BlockOnFloor>(
        "block-on-floor",
        "A block at rest on the floor: the gap that its weight leaves.",
    ),
    Entry::of::<BlocksOnInclines>(
        "blocks-on-inclines",
        "Blocks on slopes: creep and slide against closed forms.",
    ),
    Entry::of::<Cantilever>("cantilever", "A cantilever of tetrahedra under a large end load."),
    Entry::of::<Capstan>("capstan", "A rope drawn over a cylinder: the ratio of its tensions."),
    Entry::of::<CardHouse>("card-house", "Cards that lean against each other, against statics."),
    Entry::of::<PlantedContacts>("ccd-planted", "Queries of collision detection with planted contacts."),
    Entry::of::<ClayPoint>("clay-point", "A material point of clay to its critical state."),
    Entry::of::<Collision>("collision", "Two bodies collide: momenta, energy."),
    Entry::of::<CooksMembrane>("cooks-membrane", "Cook's membrane, geometrically linear."),
    Entry::of::<Torsion>("cylinder-torsion", "A twisted cylinder against Rivlin's torque and push."),
    Entry::of::<DegeneratePair>("degenerate-pair", "A feature dropped exactly onto a fixed feature."),
    Entry::of::<ElasticBlockOnIncline>(
        "elastic-block-on-incline",
        "An elastic block on a slope, by its creep.",
    ),
    Entry::of::<ElasticaCantilever>("elastica-cantilever", "Clamped rods and strips against the elastica."),
    Entry::of::<FastImpact>("fast-impact", "A body that a step takes far beyond what it hits."),
    Entry::of::<FluidPoint>("fluid-point", "A material point of fluid, compressed or sheared."),
    Entry::of::<FoamPoint>("foam-point", "A material point of foam that relaxes or flows."),
    Entry::of::<FoldedCloth>("folded-cloth", "A strip of cloth in many layers, pressed."),
    Entry::of::<RigidBody>("free-rigid-body", "A free rigid body against Jacobi's elliptic functions."),
    Entry::of::<FrictionPair>(
        "friction-pair",
        "A feature dropped with friction exactly onto a fixed feature.",
    ),
    Entry::of::<Funnel>("funnel", "A soft bar pulled through a funnel, by the force that it takes."),
    Entry::of::<GapForEveryStep>("gap-for-every-step", "A block at rest on the floor, for any step."),
    Entry::of::<GlancingBlow>("glancing-blow", "Two bodies rub: momentum, direction, cone, energy."),
    Entry::of::<GrippedSplats>("gripped-splats", "Two plates lift a soft ball that carries splats."),
    Entry::of::<Gripper>("gripper", "Two plates lift a soft cube by friction, or do not."),
    Entry::of::<HangingCable>("hanging-cable", "Chains and cloth against catenaries."),
    Entry::of::<HardBeam>("hard-beam", "A beam in its weight, one parameter driven to extremes."),
    Entry::of::<HardCloth>("hard-cloth", "A cloth strip that swings from one corner."),
    Entry::of::<HardDrop>("hard-drop", "A soft body dropped or pressed onto hard-to-hit things."),
    Entry::of::<HeavyOnLight>(
        "heavy-on-light",
        "A cube thrown at another of very different mass, with friction.",
    ),
    Entry::of::<Hertz>("hertz", "A sphere's cap pressed on a half-space against Hertz."),
    Entry::of::<HomogeneousDeformation>(
        "homogeneous-deformation",
        "The scene's bodies against a homogeneous equilibrium (patch test).",
    ),
    Entry::of::<Orbits>("kepler-orbits", "A Kepler ellipse over very many revolutions."),
    Entry::of::<KilledRuns>("killed-runs", "Runs that are killed at random moments and resumed."),
    Entry::of::<LawConsistency>(
        "law-consistency",
        "Stress and stiffness of laws against central differences.",
    ),
    Entry::of::<LawCycles>("law-cycles", "Each law along a closed path: energy, rotation, derivative."),
    Entry::of::<LinearSystems>(
        "linear-systems",
        "Linear solvers on an elastic matrix, time against residual.",
    ),
    Entry::of::<LinkedChain>("linked-chain", "A chain of links that falls until it is taut."),
    Entry::of::<LongEnergy>("long-energy", "The energy of a double pendulum over very many steps."),
    Entry::of::<MasonryArch>(
        "masonry-arch",
        "A semicircular arch of loose stones, against its line of thrust.",
    ),
    Entry::of::<MeshReaders>("mesh-readers", "A mesh file written and read in each format."),
    Entry::of::<MetalPoint>("metal-point", "A material point of metal along three paths of strain."),
    Entry::of::<ManufacturedMotion>(
        "motion-manufactured",
        "A solid in motion with a manufactured solution, by every time scheme.",
    ),
    Entry::of::<BlockOnIncline>("mpm-block-on-incline", "A block of particles that slides or is held."),
    Entry::of::<BouncingBall>(
        "mpm-bouncing-ball",
        "An elastic ball that bounces off a floor, by elements and by particles.",
    ),
    Entry::of::<BunnyInSand>("mpm-bunny-in-sand", "A mesh that is pushed into sand and drawn through it."),
    Entry::of::<BunnyInWater>("mpm-bunny-in-water", "A mesh under water, against Archimedes' law."),
    Entry::of::<HangingCantilever>(
        "mpm-cantilever",
        "A cantilever under its weight, by finite elements and by particles.",
    ),
    Entry::of::<CellCrossing>(
        "mpm-cell-crossing",
        "A stretched rod in many places within a cell: spurious forces on its inside.",
    ),
    Entry::of::<CrowdedCell>("mpm-crowded-cell", "Very many particles in one cell."),
    Entry::of::<DamBreak>("mpm-dam-break", "Water that is let go, against a film and Ritter's solution."),
    Entry::of::<FreeRotation>("mpm-free-rotation", "A disk of particles that turns freely."),
    Entry::of::<GranularColumn>(
        "mpm-granular-column",
        "A column of sand that is let go, and how far it runs.",
    ),
    Entry::of::<HardCollision>(
        "mpm-hard-collision",
        "Disks of particles collide, one parameter driven to extremes.",
    ),
    Entry::of::<LawsAtLimits>(
        "mpm-laws-at-limits",
        "Laws with their parameters at the ends of their ranges, thrown at a wall.",
    ),
    Entry::of::<LayeredColumn>(
        "mpm-layered-column",
        "A column of two layers of particles at rest in its weight, against closed forms.",
    ),
    Entry::of::<LoadedBar>(
        "mpm-loaded-bar",
        "A bar of particles that is brought to its weight, by explicit and implicit steps.",
    ),
    Entry::of::<ManufacturedParticles>(
        "mpm-manufactured",
        "Particles in a manufactured motion, with the exact place of each.",
    ),
    Entry::of::<MassMatrix>("mpm-mass-matrix", "A wave of velocities through lumped and consistent mass."),
    Entry::of::<MeetingBars>(
        "mpm-meeting-bars",
        "Two bars of particles that meet and part, against Saint-Venant's waves.",
    ),
    Entry::of::<NullSpace>("mpm-null-space", "Noise of particles that the grid does not see."),
    Entry::of::<ParticleAlone>(
        "mpm-particle-alone",
        "A particle alone, at steps below and above the limit of stability.",
    ),
    Entry::of::<PulledBar>("mpm-pulled-bar", "A bar pulled by tractions, against d'Alembert's waves."),
    Entry::of::<RefusedNumbers>(
        "mpm-refused-numbers",
        "Numbers that are none: refused, with the state as it was.",
    ),
    Entry::of::<SelfWeightColumn>(
        "mpm-self-weight-column",
        "A column of particles at rest in its weight, against closed forms of three laws.",
    ),
    Entry::of::<SettlingSand>("mpm-settling-sand", "Sand in a box, for very many steps."),
    Entry::of::<StretchedAndReleased>(
        "mpm-stretched-and-released",
        "A block of particles that is drawn out and let go.",
    ),
    Entry::of::<TaylorBar>("mpm-taylor-bar", "A copper bar shot at a wall, with von Mises's plasticity."),
    Entry::of::<ThinSheet>("mpm-thin-sheet", "A sheet between two waters, against closed forms."),
    Entry::of::<TwoDisks>("mpm-two-disks", "Two disks of particles that bounce."),
    Entry::of::<VibratingBar>(
        "mpm-vibrating-bar",
        "A standing wave in a bar of particles, for many periods.",
    ),
    Entry::of::<NarrowPipe>("narrow-pipe", "A soft ball drawn through a pipe narrower than it is."),
    Entry::of::<NodalDamping>("nodal-damping", "The amplitude and the free fall that steps of points leave."),
    Entry::of::<Damping>("oscillator-damping", "The amplitude that a step leaves of an oscillation."),
    Entry::of::<ParticleOnPlate>("particle-on-plate", "A particle on a plate that moves, by time schemes."),
    Entry::of::<PendulumBar>(
        "pendulum-bar",
        "An elastic bar that swings, by elements and as a pendulum in one angle.",
    ),
    Entry::of::<PositionBasedSteps>(
        "position-based",
        "Position-based dynamics of springs against implicit Euler.",
    ),
    Entry::of::<PressedBar>(
        "pressed-bar",
        "A bar pressed on a half-space: force against activation distance.",
    ),
    Entry::of::<PressedStack>("pressed-stack", "Two cubes under a press, by projections."),
    Entry::of::<PulledKnot>("pulled-knot", "A rope with an overhand knot, pulled tight."),
    Entry::of::<PulledStack>("pulled-stack", "A stack of boxes whose lowest is pulled away."),
    Entry::of::<RefusedStart>("refused-start", "A start outside the domain of the law, refused."),
    Entry::of::<ReleasedBlock>("released-block", "A block released crushed, inverted or torn out."),
    Entry::of::<Rollers>("rollers", "A soft bar drawn in between two rollers, or refused."),
    Entry::of::<SandPoint>("sand-point", "A material point of sand: triaxial, confined, opened and closed."),
    Entry::of::<Selftest>("selftest", "The suite's own check: a synthetic error that behaves as told."),
    Entry::of::<SlidingDistance>("sliding-distance", "How far a block slides until it stops."),
    Entry::of::<SnowPoint>("snow-point", "A material point of snow, packed and pulled apart."),
    Entry::of::<Soak>("soak", "Very many steps of a small scene, by the memory that they leave behind."),
    Entry::of::<SpinningDisk>("spinning-disk", "How long a disk spins on the floor."),
    Entry::of::<SplatDrives>(
        "splat-drives",
        "One body of splats that falls, moved by tetrahedra with contact and by particles.",
    ),
    Entry::of::<SplatDrop>("splat-drop", "A body of splats falls and bounces, moved by particles."),
    Entry::of::<SplatFilling>("splat-filling", "Shells of splats whose inside is known, filled."),
    Entry::of::<SplatPictureModes>("splat-picture-modes", "Modes and precisions of splats' pictures."),
    Entry::of::<SplatPile>("splat-pile", "A body of splats of sand that flows apart, moved by particles."),
    Entry::of::<SplatPlasticShear>(
        "splat-plastic-shear",
        "A scene of splats that flows: the total deformation against the elastic one.",
    ),
    Entry::of::<SplatRigidMotion>(
        "splat-rigid-motion",
        "A scene of splats turned and shifted, seen by a camera that moves with it.",
    ),
    Entry::of::<SplatSamples>(
        "splat-samples",
        "Splats bound to fewer samples under a known motion, against one particle each.",
    ),
    Entry::of::<SplatStretch>(
        "splat-stretch",
        "A scene of splats stretched uniformly, against the closed form.",
    ),
    Entry::of::<SplatsOnTets>("splats-on-tets", "A body of splats moved by tetrahedra with contact."),
    Entry::of::<Chain>("spring-chain", "A chain of masses and springs against its normal modes."),
    Entry::of::<StandingWave>("standing-wave", "Free vibration of a bar of springs, by every time scheme."),
    Entry::of::<ManufacturedStatics>(
        "static-manufactured",
        "Nonlinear statics with a manufactured solution.",
    ),
    Entry::of::<StationaryAction>("stationary-action", "An oscillator's path of stationary action."),
    Entry::of::<StickSlip>("stick-slip", "A mass on a belt and a spring, from event to event."),
    Entry::of::<StickingPile>("sticking-pile", "A pyramid of cubes on a slope, all of it sticking."),
    Entry::of::<SvdKernels>("svd-kernels", "3×3 singular value decompositions, precision × lanes × sweeps."),
    Entry::of::<Tablecloth>("table-cloth", "A cloth that is pulled from under tableware."),
    Entry::of::<TactilePad>("tactile-pad", "A soft pad pressed by a sphere, against Hertz and Mindlin."),
    Entry::of::<Trajectory>("trajectory", "A worked system against a trajectory of high precision."),
    Entry::of::<Turntable>("turntable", "A ball that rolls on a turntable: round a circle with 2/7 Ω."),
    Entry::of::<TwistedMat>("twisted-mat", "A mat twisted until it lies upon itself."),
    Entry::of::<TwistedRod>("twisted-rod", "The moments at which twisted rods and rings buckle."),
    Entry::of::<TwoBlocks>("two-blocks", "Two blocks in contact, one parameter driven to extremes."),
    Entry::of::<Units>("units", "A collision in two systems of units."),
    Entry::of::<WrungMat>("wrung-mat", "A mat that is wrung, without contact."),
];

/// Every experiment, in name order.
pub fn entries() -> &'static [Entry] {
    ENTRIES
}

/// The entry of a name.
pub(crate) fn find(name: &str) -> Result<&'static Entry, Inconsistency> {
    entries().iter().find(|entry| entry.name == name).ok_or_else(|| {
        let names: Vec<&str> = entries().iter().map(|entry| entry.name).collect();
        Inconsistency {
            key: "experiment.name".to_owned(),
            message: format!("there is no experiment `{name}`; there are: {}", names.join(", ")),
        }
    })
}

/// What runs where a scene names no experiment.
pub(crate) fn simulation() -> Box<dyn Experiment> {
    Box::new(Simulation)
}

fn read<E: Experiment + DeserializeOwned + 'static>(
    parameters: Parameter,
) -> Result<Box<dyn Experiment>, Misfit> {
    Ok(Box::new(E::deserialize(parameters)?))
}
