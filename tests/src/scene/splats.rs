//! Gaussian splats in a scene: where they come from, which of them are matter, what moves them, and how they are looked at.
//!
//! Splats are moved by material points, which `[splats]` sets up itself, or by the tetrahedra of the scene's `[[meshes]]` if there are any.
//! Lengths of the simulation are metres, z is up and the floor is z = 0. The splats' own file may be anywhere, of any size, and stand on its head: one rotation, scale and
//! shift brings the matter into the simulation, and every frame goes back.

use super::quantity::{AtLeastOne, Count, Finite, NonNegative, PoissonRatio, Positive, Share, Vector};
use crate::experiment::splats::surface::ClosedSurface;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A scene of splats that moves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SplatScene {
    /// A .ply, .splat or .spz file; its path is relative to the scene file. Either this or `surface`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// Splats that are made here, on a surface.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) surface: Option<PaintedSurface>,
    /// Which way is up in the file; +z when absent.
    #[serde(default)]
    pub up: Up,
    /// Where matter is, in the file's coordinates; automatic when absent.
    #[serde(default)]
    pub region: Region,
    /// Splats below this opacity are not matter; 0.02 when absent. They stay in the picture.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub opacity: Option<Share>,
    /// What the matter is made of; jelly when absent.
    #[serde(default)]
    pub material: Preset,
    /// Density [kg/m³], instead of the material's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub density_kg_m3: Option<Positive>,
    /// Law, instead of the material's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub law: Option<ParticleLaw>,
    /// Parts of the matter that are made of something else.
    #[serde(default)]
    pub parts: Vec<Part>,
    /// From the file's coordinates to those of the simulation. When absent, the longest side of the matter becomes 1 m, and it stands on the floor; with
    /// `[[meshes]]`, it gets as large as fits into their box.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub placement: Option<Placement>,
    /// How material points move the splats.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub particles: Option<Particles>,
    /// What is done with splats that get long.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub elongation: Option<Elongation>,
    /// Where they are looked at from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<SplatCamera>,
}

/// Splats on a closed surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct PaintedSurface {
    /// The surface.
    pub(crate) shape: ClosedSurface,
    /// About one splat for the square of this (m).
    pub(crate) spacing_m: Positive,
}

/// An axis and its sign.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Up {
    /// +x.
    #[serde(rename = "+x")]
    PlusX,
    /// −x.
    #[serde(rename = "-x")]
    MinusX,
    /// +y.
    #[serde(rename = "+y")]
    PlusY,
    /// −y, as in many captures.
    #[serde(rename = "-y")]
    MinusY,
    /// +z.
    #[default]
    #[serde(rename = "+z")]
    PlusZ,
    /// −z.
    #[serde(rename = "-z")]
    MinusZ,
}

/// A part of space, in the file's coordinates.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Region {
    /// A box around the bulk of the splats: what a few floaters far away do not move.
    #[default]
    Auto,
    /// All of it.
    Everywhere,
    /// A box along the axes.
    Box {
        /// The corner with the smallest coordinates.
        min: Vector,
        /// The corner with the largest coordinates.
        max: Vector,
    },
    /// A box that is turned.
    OrientedBox {
        /// Its middle.
        centre: Vector,
        /// Half its sides.
        half_sides: [Positive; 3],
        /// Axis times angle (rad).
        rotation_rad: Vector,
    },
}

/// A material by its name: a law with constants for a body of about a metre that is seen to move. Hard materials are far softer than real ones, whose steps would be
/// microseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Preset {
    /// Fixed corotated, 1000 kg/m³, 60 kPa, 0.35.
    #[default]
    Jelly,
    /// Neo-Hookean, 1100 kg/m³, 1 MPa, 0.45.
    Rubber,
    /// Herschel–Bulkley, 100 kg/m³, 20 kPa, 0.3; flows above 300 Pa.
    Foam,
    /// Von Mises, 2700 kg/m³, 10 MPa, 0.33; yields at 100 kPa and hardens.
    Metal,
    /// Drucker–Prager, 1600 kg/m³, 2 MPa, 0.3; 35°, dry.
    Sand,
    /// Snow, 400 kg/m³, 140 kPa, 0.2.
    Snow,
    /// Tait, 1000 kg/m³, 300 kPa; a free surface breaks into drops.
    Water,
}

/// A law of material points and its parameters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum ParticleLaw {
    /// Neo-Hookean.
    NeoHookean {
        /// Young's modulus (Pa).
        young_modulus_pa: Positive,
        /// Poisson's ratio (1).
        poisson_ratio: PoissonRatio,
    },
    /// Fixed corotated: survives inversion.
    FixedCorotated {
        /// Young's modulus (Pa).
        young_modulus_pa: Positive,
        /// Poisson's ratio (1).
        poisson_ratio: PoissonRatio,
    },
    /// Quadratic in logarithmic strains.
    Hencky {
        /// Young's modulus (Pa).
        young_modulus_pa: Positive,
        /// Poisson's ratio (1).
        poisson_ratio: PoissonRatio,
    },
    /// Metals: von Mises with linear hardening.
    VonMises {
        /// Young's modulus (Pa).
        young_modulus_pa: Positive,
        /// Poisson's ratio (1).
        poisson_ratio: PoissonRatio,
        /// Yield stress (Pa).
        yield_stress_pa: Positive,
        /// Hardening modulus (Pa).
        hardening_modulus_pa: NonNegative,
    },
    /// Sand.
    DruckerPrager {
        /// Young's modulus (Pa).
        young_modulus_pa: Positive,
        /// Poisson's ratio (1).
        poisson_ratio: PoissonRatio,
        /// Angle of friction (rad).
        friction_angle_rad: Positive,
        /// Cohesion (Pa).
        cohesion_pa: NonNegative,
    },
    /// Snow.
    Snow {
        /// Young's modulus (Pa).
        young_modulus_pa: Positive,
        /// Poisson's ratio (1).
        poisson_ratio: PoissonRatio,
        /// Compression at which it yields (1).
        critical_compression: NonNegative,
        /// Stretch at which it yields (1).
        critical_stretch: NonNegative,
        /// Hardening (1).
        hardening: NonNegative,
    },
    /// Foams and pastes.
    HerschelBulkley {
        /// Young's modulus (Pa).
        young_modulus_pa: Positive,
        /// Poisson's ratio (1).
        poisson_ratio: PoissonRatio,
        /// Yield stress (Pa).
        yield_stress_pa: Positive,
        /// Consistency [Pa sʰ].
        consistency_pa_s: Positive,
        /// The exponent h (1).
        flow_index: Positive,
    },
    /// Fluids, by Tait's equation.
    Tait {
        /// Bulk modulus (Pa).
        bulk_modulus_pa: Positive,
        /// Exponent (1); 7 for water.
        exponent: Positive,
        /// Shear viscosity [Pa s].
        viscosity_pa_s: NonNegative,
    },
}

/// A part of the matter with a material of its own; what several parts contain belongs to the first of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Part {
    /// Where, in the file's coordinates.
    pub region: Region,
    /// What it is made of.
    pub material: Preset,
    /// Density [kg/m³], instead of the material's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub density_kg_m3: Option<Positive>,
    /// Law, instead of the material's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub law: Option<ParticleLaw>,
}

/// From the file's coordinates to those of the simulation; up becomes z either way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Placement {
    /// The matter over the origin.
    OnFloor {
        /// Its longest side (m).
        size_m: Positive,
        /// From the floor to its lowest splat (m).
        height_m: NonNegative,
    },
    /// As it is said.
    Exact {
        /// Metres a unit of the file.
        scale_m: Positive,
        /// Where the file's origin comes to (m).
        translation_m: Vector,
    },
}

/// How material points move the splats.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Particles {
    /// Cells of the grid along the longest side of the matter; 32 when absent.
    pub cells: Option<Count>,
    /// Which particles there are; one a splat when absent.
    pub binding: Binding,
    /// How the inside is filled.
    pub fill: Fill,
    /// Frames, the first of them at rest; 61 when absent.
    pub frames: Option<Count>,
    /// Frames a second; 30 when absent.
    pub frame_rate_hz: Option<Positive>,
    /// Gravity [m/s²]; 9.81 downwards when absent.
    pub gravity_m_s2: Option<Vector>,
    /// Velocity at the start [m/s].
    pub velocity_m_s: Option<Vector>,
    /// The plane z = 0.
    pub floor: Floor,
    /// Obstacles.
    pub colliders: Vec<Collider>,
    /// Matter that is held, or led.
    pub holds: Vec<Hold>,
    /// Blows.
    pub impulses: Vec<Impulse>,
}

/// Which particles there are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Binding {
    /// One for each splat, and those of the filling.
    #[default]
    EachSplat,
    /// One for each cell of the filling's grid that has matter; splats move with those around them.
    Embedded,
}

/// How the inside is filled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Fill {
    /// With a particle for each of eight parts of a cell.
    #[default]
    Inside,
    /// Not at all: a shell.
    Nothing,
    /// As it is said.
    Rules {
        /// Particles for each cell of the filling's grid, of which eight are a cell of the simulation's.
        particles_per_cell: Count,
        /// Cells are dense above this.
        density_threshold: Positive,
        /// Rays see cells above this.
        search_threshold: Positive,
        /// Where the surface has a hole, such as where it stood on a table; in the simulation's directions.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        open: Option<Up>,
    },
}

/// The plane z = 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Floor {
    /// What it does to matter.
    pub surface: FloorSurface,
    /// Splats that show it; none when absent.
    pub tiles: Option<Tiles>,
}

/// A floor of splats, chequered.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Tiles {
    /// The side of a tile (m).
    pub size_m: Positive,
    /// Tiles along each side.
    pub count: Count,
}

/// What the floor does to matter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum FloorSurface {
    /// There is none.
    None,
    /// Matter sticks to it.
    Sticky,
    /// Matter slides and may leave.
    Separating,
    /// Matter may leave, and slides with friction of this coefficient.
    Friction(NonNegative),
}

impl Default for FloorSurface {
    fn default() -> Self {
        // A number that is allowed.
        NonNegative::try_from(0.5).map_or(Self::Sticky, Self::Friction)
    }
}

/// An obstacle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Collider {
    /// Where it is at the start.
    pub shape: ColliderShape,
    /// What it does to matter.
    #[serde(default)]
    pub surface: ColliderSurface,
    /// How it moves [m/s]; at rest when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity_m_s: Option<Vector>,
}

/// A shape, in the simulation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum ColliderShape {
    /// Everything behind a plane.
    HalfSpace {
        /// A point of the plane (m).
        point_m: Vector,
        /// Out of the obstacle; need not have length one.
        normal: Vector,
    },
    /// A ball.
    Ball {
        /// Its centre (m).
        centre_m: Vector,
        /// Its radius (m).
        radius_m: Positive,
    },
    /// A box along the axes.
    Box {
        /// Its centre (m).
        centre_m: Vector,
        /// Half its sides (m).
        half_sides_m: [Positive; 3],
    },
    /// All points near a segment.
    Capsule {
        /// One end of the segment (m).
        from_m: Vector,
        /// The other end (m).
        to_m: Vector,
        /// (m).
        radius_m: Positive,
    },
}

/// What an obstacle does to matter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum ColliderSurface {
    /// Matter sticks to it.
    Sticky,
    /// Matter slides and never leaves.
    Slip,
    /// Matter slides and may leave.
    #[default]
    Separating,
    /// Matter may leave, and slides with friction of this coefficient.
    Friction(NonNegative),
}

/// A box, in the simulation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SimulationBox {
    /// The corner with the smallest coordinates (m).
    pub min_m: Vector,
    /// The corner with the largest coordinates (m).
    pub max_m: Vector,
}

/// The matter that is in a box at rest, held or led for a while: v = velocity + ω × (x − centre), whose centre moves along. Several of them with different ends release
/// it part by part.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Hold {
    /// Which matter.
    pub select: SimulationBox,
    /// [m/s]; none when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity_m_s: Option<Vector>,
    /// ω [rad/s], about the middle of the box; none when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub angular_velocity_rad_s: Option<Vector>,
    /// From this time on (s); the start when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from_s: Option<NonNegative>,
    /// Up to this time (s); for ever when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub until_s: Option<Positive>,
}

/// A blow to the matter that is in a box at rest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Impulse {
    /// Which matter.
    pub select: SimulationBox,
    /// On all of it together [N s]; every particle gets the same velocity.
    pub impulse_n_s: Vector,
    /// When (s).
    pub at_s: NonNegative,
}

/// What is done with splats that get long: largest deviation over the middle one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Elongation {
    /// They are shortened to this.
    Limit(AtLeastOne),
    /// They are cut into pieces of this.
    Split(AtLeastOne),
}

/// Where splats are looked at from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SplatCamera {
    /// Width and height of the picture (pixels); 480 × 480 when absent, with a `file` what that says.
    pub size_px: Option<[Count; 2]>,
    /// A cameras.json instead of an orbit; its path is relative to the scene file.
    pub file: Option<String>,
    /// Which camera of the file, by the name of its picture; the first when absent.
    pub picture: Option<String>,
    /// Around the upward direction (rad); 0.6 when absent.
    pub azimuth_rad: Option<Finite>,
    /// Over the horizon (rad); 0.25 when absent.
    pub elevation_rad: Option<Finite>,
    /// The camera goes around [rad/s]; it stands when absent.
    pub turn_rad_s: Option<Finite>,
    /// From the eye to what is looked at, in diagonals of the matter's box at rest; 2 when absent.
    pub distance: Option<Positive>,
    /// What is looked at (m), in the simulation; halfway between the middle of the matter at rest and the floor when absent.
    pub target_m: Option<Vector>,
    /// The angle between the upper and the lower edge (rad); 0.7 when absent.
    pub field_of_view_rad: Option<Positive>,
    /// Red, green, blue of what is behind, from 0 to 1; white when absent.
    pub background: Option<[Share; 3]>,
    /// In which tiles a splat is drawn; exact when absent.
    pub mode: DrawMode,
}

/// In which tiles a splat is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DrawMode {
    /// As those programs do it with which captures are trained.
    #[default]
    Exact,
    /// Wherever it is visible.
    Tight,
}
