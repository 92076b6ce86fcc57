//! The physical part of a scene: meshes, materials, conditions, integration, solver and output.
//!
//! What a scene does not name does not run: there is no default contact, friction or damping.

use super::quantity::{Count, Finite, NonNegative, PoissonRatio, Positive, Vector};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A mesh, named so that materials and conditions can refer to it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Mesh {
    /// Its name.
    pub name: String,
    /// The name of its material.
    pub material: String,
    /// Where its points and elements come from.
    pub source: MeshSource,
    /// Moves the mesh after it is made or read (m).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub translation_m: Option<Vector>,
    /// Turns the mesh about the origin before it is moved: axis times angle (rad).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotation_rad: Option<Vector>,
}

/// A mesh file or a generator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum MeshSource {
    /// A file; its path is relative to the scene file.
    File {
        /// Path of an OBJ, STL, PLY, MSH or VTU file.
        path: String,
        /// Metres per unit of the file; 1 when absent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        scale_m: Option<Positive>,
    },
    /// A box of tetrahedra with one corner at the origin.
    Box {
        /// Edge lengths (m).
        size_m: [Positive; 3],
        /// Cells along each edge.
        cells: [Count; 3],
    },
    /// A ball of tetrahedra about the origin.
    Sphere {
        /// Its radius (m).
        radius_m: Positive,
        /// The edge length aimed at (m).
        edge_m: Positive,
    },
    /// A solid cylinder of tetrahedra along z, its base's centre at the origin.
    Cylinder {
        /// Its radius (m).
        radius_m: Positive,
        /// Its height (m).
        height_m: Positive,
        /// The edge length aimed at (m).
        edge_m: Positive,
    },
    /// A rectangle of triangles in the plane z = 0.
    Cloth {
        /// Edge lengths (m).
        size_m: [Positive; 2],
        /// Cells along each edge.
        cells: [Count; 2],
        /// Thickness (m).
        thickness_m: Positive,
    },
    /// A straight line of segments along x.
    Rod {
        /// Its length (m).
        length_m: Positive,
        /// Its segments.
        cells: Count,
        /// Radius of its cross-section (m).
        radius_m: Positive,
    },
    /// A surface of triangles over a rectangle, heights by rows along x.
    HeightField {
        /// Edge lengths of the rectangle (m).
        size_m: [Positive; 2],
        /// Heights (m), one row a line of points along x; all rows of one length.
        heights_m: Vec<Vec<Finite>>,
    },
}

/// A material, named so that meshes can refer to it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Its name.
    pub name: String,
    /// Mass density in the rest state [kg/m³].
    pub density_kg_m3: Positive,
    /// Its stored-energy law.
    pub law: Law,
}

/// A hyperelastic law and its parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Law {
    /// Linear elasticity (small displacements).
    Linear(Isotropic),
    /// St. Venant–Kirchhoff.
    SaintVenantKirchhoff(Isotropic),
    /// Compressible neo-Hookean with a logarithmic barrier.
    NeoHookean(Isotropic),
    /// Stable neo-Hookean (finite at inversion).
    StableNeoHookean(Isotropic),
    /// Fixed corotated.
    FixedCorotated(Isotropic),
}

/// The two constants of an isotropic solid.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Isotropic {
    /// Young's modulus (Pa).
    pub young_modulus_pa: Positive,
    /// Poisson's ratio (1).
    pub poisson_ratio: PoissonRatio,
}

/// The state a mesh starts in; at rest when absent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InitialCondition {
    /// The mesh.
    pub mesh: String,
    /// Velocity of its centre of mass [m/s].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity_m_s: Option<Vector>,
    /// Angular velocity about its centre of mass [rad/s].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub angular_velocity_rad_s: Option<Vector>,
    /// Stretches about its centre of mass, one an axis (1).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stretch: Option<[Positive; 3]>,
}

/// Which points of a mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Selector {
    /// All points.
    All {},
    /// Points inside a closed box.
    Box {
        /// The corner with the smallest coordinates (m).
        min_m: Vector,
        /// The corner with the largest coordinates (m).
        max_m: Vector,
    },
    /// Points on a plane or on the side its normal points to.
    Plane {
        /// A point of the plane (m).
        point_m: Vector,
        /// Its normal; need not have length one.
        normal: Vector,
        /// Half-thickness of the plane (m); a point within it counts as on the plane.
        within_m: NonNegative,
    },
}

/// A Cartesian axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Axis {
    /// The first axis.
    X,
    /// The second axis.
    Y,
    /// The third axis.
    Z,
}

/// A condition on the motion of selected points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoundaryCondition {
    /// The mesh.
    pub mesh: String,
    /// Which of its points, chosen in the rest state.
    pub select: Selector,
    /// What they do.
    pub motion: Motion,
}

/// How selected points move.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Motion {
    /// They stay where they are along the named axes.
    Fixed {
        /// The axes.
        axes: Vec<Axis>,
    },
    /// They are displaced, in proportion to the load factor (statics) or at once (dynamics).
    Prescribed {
        /// The displacement (m).
        displacement_m: Vector,
    },
    /// They move with a constant velocity.
    Moving {
        /// The velocity [m/s].
        velocity_m_s: Vector,
    },
}

/// A load.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Load {
    /// Weight of every mesh.
    Gravity {
        /// The acceleration [m/s²].
        acceleration_m_s2: Vector,
    },
    /// A force on every selected point.
    NodalForce {
        /// The mesh.
        mesh: String,
        /// Which of its points.
        select: Selector,
        /// The force on each of them (N).
        force_n: Vector,
    },
    /// A force per rest area on the boundary triangles all of whose points are selected.
    Traction {
        /// The mesh.
        mesh: String,
        /// Which of its points.
        select: Selector,
        /// The force per rest area (Pa).
        traction_pa: Vector,
    },
}

/// Contact of all bodies with each other, with themselves and with half-spaces; in motion only.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Contact {
    /// Surfaces repel each other below this distance (m).
    pub activation_distance_m: Positive,
    /// The force of a pair of surface points at half of that distance (N); about ½ E ℓ d̂ for Young's modulus E and edges of
    /// length ℓ. It grows where bodies come closer than a hundredth of the distance.
    pub pair_force_n: Positive,
    /// Friction; none when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<Friction>,
    /// Floors and walls.
    #[serde(default)]
    pub half_spaces: Vec<HalfSpace>,
}

/// Coulomb friction between all surfaces, smoothed over small velocities.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Friction {
    /// Coulomb's coefficient (1).
    pub coefficient: NonNegative,
    /// Below this speed friction is smoothed [m/s].
    pub stick_velocity_m_s: Positive,
    /// Normal forces are taken at most so many times a step; once is at its start.
    pub lag_iterations: Count,
}

/// A half-space that no point enters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HalfSpace {
    /// A point of its boundary (m).
    pub point_m: Vector,
    /// Its normal, to where bodies may be; need not have length one.
    pub normal: Vector,
}

/// How time goes on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Integration {
    /// Equilibrium, no time.
    Static {
        /// The load is applied in so many equal steps.
        load_steps: Count,
    },
    /// Backward Euler.
    BackwardEuler(TimeSpan),
    /// The second-order backward difference formula.
    Bdf2(TimeSpan),
    /// Newmark with average acceleration (γ = ½, β = ¼).
    Newmark(TimeSpan),
}

/// A time step and an end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TimeSpan {
    /// The time step (s).
    pub step_s: Positive,
    /// The end (s).
    pub end_s: Positive,
}

impl Integration {
    /// Its name in scene files.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Static { .. } => "static",
            Self::BackwardEuler(_) => "backward-euler",
            Self::Bdf2(_) => "bdf2",
            Self::Newmark(_) => "newmark",
        }
    }
}

/// How the equations are solved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Solver {
    /// The linear solver inside Newton's method.
    pub linear: LinearSolver,
    /// Newton's method stops when no point would move farther (m); in dynamics, farther a step.
    pub tolerance_m: Positive,
    /// Newton iterations a step at most; more are an error.
    pub max_iterations: Count,
}

/// A linear solver.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LinearSolver {
    /// Sparse Cholesky.
    Cholesky,
    /// Conjugate gradients with block Jacobi.
    PcgBlockJacobi,
    /// Conjugate gradients with incomplete Cholesky.
    PcgIncompleteCholesky,
}

/// What is written.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Output {
    /// A frame every so many steps.
    pub frame_every: Count,
    /// The formats of a frame.
    pub formats: Vec<Format>,
}

/// A file format of frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Format {
    /// VTK's XML unstructured grid.
    Vtu,
    /// Stanford PLY.
    Ply,
    /// Wavefront OBJ.
    Obj,
    /// A picture.
    Png,
    /// A film.
    Gif,
    /// A film, by ffmpeg; none where there is no ffmpeg.
    Mp4,
}
