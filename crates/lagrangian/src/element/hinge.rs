//! Sheets that resist bending: hinges between neighbouring triangles.
//!
//! A hinge is an interior edge (x₀, x₁) with the opposite corners x₂ and x₃ of its two triangles, ordered so that
//! (x₀, x₁, x₂) and (x₁, x₀, x₃) run as the triangles do. Its angle θ is zero when the triangles lie in one plane, and
//! positive when the wings x₂, x₃ rise to the side the normals point to (see [`dihedral_angle`]). The energy is
//!
//! - E = ½ k w (θ − θ̄)²,  w = 3 |ē|²/Ā,
//!
//! with the rest angle θ̄, the rest length |ē| of the edge and the rest area Ā of the two triangles together: the angle
//! per length of surface that it is spread over is θ/h̄ with h̄ = Ā/(3|ē|), a third of the mean height, and |ē|/h̄ = w
//! (Grinspun et al. 2003). For the stiffness k we take
//!
//! - k = D/3,  D = E_Y t³/(12(1 − ν²)) \[J\],
//!
//! so that E = ½ D (|ē|²/Ā)(θ − θ̄)². Why D/3: bend a flat mesh into a cylinder of curvature κ, for which a plate
//! stores ½Dκ² per area.
//!
//! - *Rectangles a × b with a diagonal each, axis along b.* Only edges along the axis fold, by θ = κa; |ē|²/Ā = b²/ab.
//!   A cell stores ½ D (b/a) κ²a² = ½Dκ² ab: exact.
//! - *Equilateral triangles of side a, any axis.* With the axis' normal at the angle φ to an edge's normal, the
//!   interpolated parabola folds by θ = (2/√3) κa (cos²φ − ¼). Over the three directions of edges Σθ² = ¾κ²a², each with
//!   |ē|²/Ā = 2/√3, so a vertex's share (√3/2)a² stores ½D(2/√3)(¾)κ²a² = ½Dκ²(√3/2)a²: exact for every axis.
//!
//! What a hinge model cannot do: it has one constant, so the cost of double curvature follows from the mesh (a sphere
//! costs what a plate with ν = −⅓ would on equilateral triangles, with ν = 0 on rectangles, where bending about a
//! diagonal costs 3/2 of what it should). On irregular meshes the energy converges to the plate's up to a factor that
//! depends on the mesh and does not go away with refinement. [`plate`](super::plate) is better on both counts.
//!
//! A hinge with a collapsed triangle has no angle. It then stores no energy and exerts no force (the bound is 10⁻⁸
//! of the triangle's rest area), so that collapsed sheets can recover. At |θ| = π the wings coincide and θ jumps by 2π; with a rest
//! angle the energy jumps too. ([`plate`](super::plate) has a barrier there.)
//!
//! # Reference
//! E. Grinspun, A. N. Hirani, M. Desbrun, P. Schröder, *Discrete shells*, SCA 2003, section 4.

mod angle;
mod rest;

pub use angle::{AngleDerivatives, dihedral_angle, dihedral_derivatives, dihedral_gradient};
pub use rest::{Hinge, RestAngle, flexural_rigidity, hinges_of};

use super::thin_error::{ThinError, positive};
use mechanics_core::mesh::TriMesh;
use mechanics_core::projection::{Projection, project_symmetric};
use mechanics_core::stencil::{LocalHessian, Stencil, StencilTerm};
use mechanics_core::tensor::{Mat3, Vec3};
use nalgebra::SMatrix;

/// How the Hessian k w (∇θ ⊗ ∇θ + (θ − θ̄) ∇∇θ) is made positive semi-definite when a projection is asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BendingHessian {
    /// Without the second part (Gauss and Newton's approximation): semi-definite by itself, at a fortieth of the cost of
    /// the other. Newton converges linearly where hinges are far from their rest angles.
    #[default]
    GaussNewton,
    /// By its eigenvalues, of the nine that translations leave. Newton then converges quadratically where every hinge's own
    /// Hessian is definite.
    Spectral,
}

/// The hinges of a mesh.
#[derive(Clone, Debug)]
pub struct Hinges {
    points: Vec<[u32; 4]>,
    rest: Vec<Rest>,
    method: BendingHessian,
}

/// One hinge at rest.
#[derive(Clone, Copy, Debug)]
struct Rest {
    /// D |ē|²/Ā \[J\].
    stiffness: f64,
    angle: f64,
    /// Squared lengths of the triangles' normals (twice the areas) below which they count as collapsed \[m⁴\].
    collapsed: [f64; 2],
}

/// Twice a triangle's area over twice its rest area, below which it has no normal.
const COLLAPSED: f64 = 1e-8;

impl Hinges {
    /// The hinges of `mesh`, whose positions are the rest shape, for a plate of flexural rigidity D \[J\]
    /// ([`flexural_rigidity`]).
    ///
    /// # Errors
    /// A rigidity that is not positive; an edge of three or more triangles; neighbours with opposite normals; a
    /// triangle without area.
    pub fn new(mesh: &TriMesh, rigidity: f64, rest_angle: RestAngle) -> Result<Self, ThinError> {
        let rigidity = positive("the flexural rigidity", rigidity)?;
        let hinges = hinges_of(mesh)?;
        let mut rest = Vec::with_capacity(hinges.len());
        for hinge in &hinges {
            let x = hinge.points.map(|point| mesh.points()[point as usize]);
            let doubled = rest::normals(mesh, hinge)?.map(|normal| normal.norm());
            let area = 0.5 * (doubled[0] + doubled[1]);
            let angle = match rest_angle {
                RestAngle::OfMesh => dihedral_angle(&x),
                RestAngle::Flat => 0.0,
            };
            let collapsed = doubled.map(|length| (COLLAPSED * length).powi(2));
            rest.push(Rest { stiffness: rigidity * (x[1] - x[0]).norm_squared() / area, angle, collapsed });
        }
        let points = hinges.iter().map(|hinge| hinge.points).collect();
        Ok(Self { points, rest, method: BendingHessian::default() })
    }

    /// The same with another way of projecting.
    pub fn with_hessian(self, method: BendingHessian) -> Self {
        Self { method, ..self }
    }

    /// The sum over all hinges, as a term of the incremental potential.
    ///
    /// # Errors
    /// None that [`new`](Self::new) has not seen.
    pub fn term(self, name: impl Into<String>) -> Result<StencilTerm<Self, 4>, ThinError> {
        let points = self.points.clone();
        Ok(StencilTerm::new(name, self, points)?)
    }

    /// The points of every hinge.
    pub fn points(&self) -> &[[u32; 4]] {
        &self.points
    }

    /// The rest angle of a hinge \[rad\].
    pub fn rest_angle(&self, hinge: usize) -> f64 {
        self.rest[hinge].angle
    }

    /// Bends the rest shape of one hinge: sets its rest angle \[rad\], in (−π, π).
    ///
    /// # Errors
    /// An angle outside that range.
    pub fn set_rest_angle(&mut self, hinge: usize, angle: f64) -> Result<(), ThinError> {
        if angle.abs() < std::f64::consts::PI {
            self.rest[hinge].angle = angle;
            Ok(())
        } else {
            Err(ThinError::Parameter {
                parameter: "the rest angle",
                value: angle,
                expected: "between −π and π",
            })
        }
    }

    /// Whether a triangle of the hinge has no normal.
    fn is_collapsed(&self, hinge: usize, x: &[Vec3; 4]) -> bool {
        let normals = angle::normals(x);
        let [one, two] = self.rest[hinge].collapsed;
        normals[0].norm_squared() <= one || normals[1].norm_squared() <= two
    }
}

impl Stencil<4> for Hinges {
    fn value(&self, element: usize, x: &[Vec3; 4]) -> f64 {
        if self.is_collapsed(element, x) {
            return 0.0;
        }
        let rest = &self.rest[element];
        0.5 * rest.stiffness * (dihedral_angle(x) - rest.angle).powi(2)
    }

    fn gradient(&self, element: usize, x: &[Vec3; 4]) -> [Vec3; 4] {
        if self.is_collapsed(element, x) {
            return [Vec3::zeros(); 4];
        }
        let rest = &self.rest[element];
        let moment = rest.stiffness * (dihedral_angle(x) - rest.angle);
        dihedral_gradient(x).map(|g| g * moment)
    }

    fn hessian(&self, element: usize, x: &[Vec3; 4], projection: Projection) -> LocalHessian<4> {
        if self.is_collapsed(element, x) {
            return [[Mat3::zeros(); 4]; 4];
        }
        let rest = &self.rest[element];
        let moment = rest.stiffness * (dihedral_angle(x) - rest.angle);
        if projection != Projection::None && self.method == BendingHessian::GaussNewton {
            let g = dihedral_gradient(x);
            return std::array::from_fn(|i| {
                std::array::from_fn(|j| g[i] * g[j].transpose() * rest.stiffness)
            });
        }
        let AngleDerivatives { gradient: g, hessian } = dihedral_derivatives(x);
        let exact = |i: usize, j: usize| g[i] * g[j].transpose() * rest.stiffness + hessian[i][j] * moment;
        let exact: LocalHessian<4> = std::array::from_fn(|i| std::array::from_fn(|j| exact(i, j)));
        if projection == Projection::None || moment == 0.0 { exact } else { project(&exact, projection) }
    }
}

/// The rows of an orthonormal basis of what is perpendicular to (1, 1, 1, 1), times two.
const WITHOUT_TRANSLATION: [[f64; 4]; 3] =
    [[1.0, 1.0, -1.0, -1.0], [1.0, -1.0, 1.0, -1.0], [1.0, -1.0, -1.0, 1.0]];

/// Projects a Hessian that translations are null vectors of: B f(BᵀHB) Bᵀ with an orthonormal basis B of the rest.
fn project(hessian: &LocalHessian<4>, projection: Projection) -> LocalHessian<4> {
    let mut reduced = SMatrix::<f64, 9, 9>::zeros();
    for (a, row) in WITHOUT_TRANSLATION.iter().enumerate() {
        for (b, column) in WITHOUT_TRANSLATION.iter().enumerate().take(a + 1) {
            let mut block = Mat3::zeros();
            for i in 0..4 {
                for j in 0..4 {
                    block += hessian[i][j] * (0.25 * row[i] * column[j]);
                }
            }
            reduced.fixed_view_mut::<3, 3>(3 * a, 3 * b).copy_from(&block);
        }
    }
    let projected = project_symmetric(&reduced, projection);
    let mut result = [[Mat3::zeros(); 4]; 4];
    for i in 0..4 {
        for j in 0..=i {
            for (a, row) in WITHOUT_TRANSLATION.iter().enumerate() {
                for (b, column) in WITHOUT_TRANSLATION.iter().enumerate() {
                    result[i][j] += projected.fixed_view::<3, 3>(3 * a, 3 * b) * (0.25 * row[i] * column[j]);
                }
            }
            result[j][i] = result[i][j].transpose();
        }
    }
    result
}
