//! Plates and shells with Poisson's ratio: bending by the shape operator of each triangle.
//!
//! [`Hinges`](super::hinge::Hinges) have one constant and depend on the mesh: a narrow strip cut into cells with parallel
//! diagonals twists when bent, and is too soft by a factor that refinement does not remove. Here each triangle sees the
//! angles θᵢ of its three edges together, as a curvature tensor, and stores a plate's energy.
//!
//! Edge i of triangle T has the rest length |eᵢ| and the unit vector nᵢ perpendicular to it in T's rest plane. The surface
//! turns by θᵢ about that edge on the way from T to its neighbour T'. T takes the part A/(A + A') of it, A and A' the rest
//! areas: between strips of widths w and w' that follow a circle, the turn divides as w : w'. A linear field of normals
//! that turns by φᵢ on the way to the middle of each edge has the gradient Σᵢ φᵢ (|eᵢ|/A) nᵢ⊗nᵢ (from ∫∇N = ∮N⊗n), so
//!
//! - Λ = Σᵢ cᵢ θᵢ nᵢ⊗nᵢ,  cᵢ = |eᵢ|/(A + A'),
//! - E = ½ A D ((1 − ν) Λ:Λ + ν (tr Λ)²) = ½ Σᵢⱼ Qᵢⱼ (uᵢ − ūᵢ)(uⱼ − ūⱼ),  Qᵢⱼ = A D cᵢ cⱼ ((1 − ν)(nᵢ·nⱼ)² + ν),
//!
//! with D = E_Y t³/12(1 − ν²): Kirchhoff's plate. Two things make it converge on regular meshes:
//!
//! - *It is exact for every constant curvature K on parallelograms with one diagonal each.* On rectangles a × b with parallel
//!   diagonals the interpolated paraboloid turns by aK_xx + bK_xy, bK_yy + aK_xy and −√(a² + b²) K_xy at the
//!   upright, level and slanted edges, whose Λ is K. (With hinges the same angles give, beside K_xx², a mixed term
//!   (2b/a) K_xx K_xy: bending drives twist.)
//! - *A constant moment M exerts no force on the interior.* The work A Λ:M summed over triangles is Σ |eᵢ| (nᵢ·M nᵢ) θᵢ over
//!   edges, however the turn is divided, and that is M : ∫∇∇f of the piecewise linear deflection f, a boundary term.
//!
//! At an edge on the boundary nothing is known of the angle, and no moment acts: E is minimised over it, which replaces Q by
//! its Schur complement. That is the natural boundary condition, to be had without a penalty or a ghost point.
//!
//! In place of θ stands u = 2 tan(θ/2), which is the same for small angles and grows without bound as an edge folds flat, so
//! that the energy has no jump there as one in θ would (from π to −π). Only the energy keeps a sheet from folding through itself at an
//! edge: there is no step limit, and a step long enough passes θ = π.
//!
//! # What remains
//!
//! Measured on a cantilever strip (40 × 4 cells, ν = 0) against the elastica:
//!
//! | mesh | plate | hinges |
//! |---|---|---|
//! | parallel or alternating diagonals | 3·10⁻⁴, order two | 15 % too soft, however fine |
//! | the same, points moved by up to a quarter of a cell | 5 % too stiff | 6 % too soft |
//! | both diagonals in each rectangle | 27 % too stiff | 14 % too stiff |
//!
//! The last two are plateaus: Λ is not exact there, and refinement does not help. (Solving for the curvature that each
//! triangle's six corners have makes Λ exact on every mesh, but then constant moments exert forces: on alternating
//! diagonals that was 25 % too soft.)
//!
//! # Reference
//! E. Grinspun, Y. Gingold, J. Reisman, D. Zorin, *Computing discrete shape operators on general meshes*, Computer Graphics
//! Forum 25(3), 2006 (the operator from angles at mid-edges; they split angles evenly). S. P. Timoshenko, S. Woinowsky-Krieger,
//! *Theory of Plates and Shells*, 2nd ed., 1959, equation (47) (the energy).

mod patch;

pub use patch::Patches;

use super::hinge::{RestAngle, dihedral_angle, flexural_rigidity, hinges_of};
use super::membrane::RestTriangle;
use super::thin_error::ThinError;
use mechanics_core::mesh::TriMesh;
use mechanics_core::potential::{Potential, PotentialError, StepLimit};
use mechanics_core::projection::Projection;
use mechanics_core::sparse::Assembler;
use mechanics_core::stencil::{Stencil, StencilTerm};
use mechanics_core::tensor::Vec3;
use patch::{Patch, PatchHinge};

/// The bending energy of a plate or shell. See the [module](self) page.
///
/// A term of the incremental potential made of three lists of elements: triangles with six, five and four points
/// (triangle and neighbours' far corners; fewer at boundaries and around points of three triangles).
#[derive(Debug)]
pub struct PlateBending {
    name: String,
    six: StencilTerm<Patches<6>, 6>,
    five: StencilTerm<Patches<5>, 5>,
    four: StencilTerm<Patches<4>, 4>,
}

impl PlateBending {
    /// The triangles of `mesh`, whose positions are the rest shape: Young's modulus \[Pa\], Poisson's ratio, thickness \[m\].
    ///
    /// # Errors
    /// A parameter out of range; an edge of three or more triangles; neighbours with opposite normals; a triangle
    /// without area; with [`RestAngle::OfMesh`] triangles that are folded onto each other.
    pub fn new(
        name: impl Into<String>,
        mesh: &TriMesh,
        young_modulus: f64,
        poisson_ratio: f64,
        thickness: f64,
        rest_angle: RestAngle,
    ) -> Result<Self, ThinError> {
        let rigidity = flexural_rigidity(young_modulus, poisson_ratio, thickness)?;
        let name = name.into();
        let mut lists = (Patches::default(), Patches::default(), Patches::default());
        let mut elements = (Vec::new(), Vec::new(), Vec::new());
        for (points, patch) in patches(mesh, rigidity, poisson_ratio, rest_angle)? {
            match points[..] {
                [a, b, c, d, e, f] => lists.0.add(&mut elements.0, [a, b, c, d, e, f], patch),
                [a, b, c, d, e] => lists.1.add(&mut elements.1, [a, b, c, d, e], patch),
                [a, b, c, d] => lists.2.add(&mut elements.2, [a, b, c, d], patch),
                _ => {}
            }
        }
        Ok(Self {
            six: StencilTerm::new(name.clone(), lists.0, elements.0)?,
            five: StencilTerm::new(name.clone(), lists.1, elements.1)?,
            four: StencilTerm::new(name.clone(), lists.2, elements.2)?,
            name,
        })
    }
}

/// π less a millionth: beyond it tan(θ/2) says nothing any more \[rad\].
const LARGEST_REST_ANGLE: f64 = std::f64::consts::PI - 1e-6;

/// Every triangle that has a neighbour: its points and its patch.
fn patches(
    mesh: &TriMesh,
    rigidity: f64,
    poisson_ratio: f64,
    rest_angle: RestAngle,
) -> Result<Vec<(Vec<u32>, Patch)>, ThinError> {
    let triangles = mesh.triangles();
    let rest: Vec<RestTriangle> =
        (0..triangles.len()).map(|t| RestTriangle::of(mesh, t)).collect::<Result<_, _>>()?;
    // For every triangle and each of its edges (k to k + 1): the neighbour and its far corner.
    let mut across: Vec<[Option<(u32, u32)>; 3]> = vec![[None; 3]; triangles.len()];
    for hinge in hinges_of(mesh)? {
        let [from, to, one, two] = hinge.points;
        let [t, u] = hinge.triangles;
        let edge = |t: u32, start: u32| triangles[t as usize].iter().position(|&p| p == start);
        if let (Some(k), Some(l)) = (edge(t, from), edge(u, to)) {
            across[t as usize][k] = Some((u, two));
            across[u as usize][l] = Some((t, one));
        }
    }
    let mut found = Vec::new();
    for (t, corners) in triangles.iter().enumerate() {
        if across[t].iter().all(Option::is_none) {
            continue;
        }
        let q = angle_stiffness(mesh, &rest, t, &across[t], rigidity, poisson_ratio);
        let mut points = corners.to_vec();
        let mut hinges = Vec::new();
        let mut kept = Vec::new();
        for (k, neighbour) in across[t].iter().enumerate() {
            let Some((u, far)) = *neighbour else { continue };
            let local = points.iter().position(|&p| p == far).unwrap_or(points.len());
            if local == points.len() {
                points.push(far);
            }
            let local = [k, (k + 1) % 3, (k + 2) % 3, local];
            let x = local.map(|i| mesh.points()[points[i] as usize]);
            let angle = match rest_angle {
                RestAngle::OfMesh => dihedral_angle(&x),
                RestAngle::Flat => 0.0,
            };
            if angle.abs() > LARGEST_REST_ANGLE {
                return Err(ThinError::RestFold { triangles: [t as u32, u], angle });
            }
            hinges.push(PatchHinge::new(local, angle, [rest[t].area(), rest[u as usize].area()]));
            kept.push(k);
        }
        found.push((points, Patch::new(hinges, |i, j| q[kept[i]][kept[j]])));
    }
    Ok(found)
}

/// Q of one triangle, edges on the boundary eliminated.
fn angle_stiffness(
    mesh: &TriMesh,
    rest: &[RestTriangle],
    triangle: usize,
    across: &[Option<(u32, u32)>; 3],
    rigidity: f64,
    poisson_ratio: f64,
) -> [[f64; 3]; 3] {
    let corners = mesh.corners(triangle);
    let area = rest[triangle].area();
    let edges: [Vec3; 3] = std::array::from_fn(|k| corners[(k + 1) % 3] - corners[k]);
    // The scale of a boundary edge's own angle does not matter.
    let scale =
        |k: usize| edges[k].norm() / (area + across[k].map_or(area, |(u, _)| rest[u as usize].area()));
    let mut q: [[f64; 3]; 3] = std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            // Normals to edges include the same angle as the edges do.
            let cosine = edges[i].normalize().dot(&edges[j].normalize());
            area * rigidity * scale(i) * scale(j) * ((1.0 - poisson_ratio) * cosine * cosine + poisson_ratio)
        })
    });
    for b in (0..3).filter(|&b| across[b].is_none()) {
        let eliminated = q;
        for i in 0..3 {
            for j in 0..3 {
                q[i][j] -= eliminated[i][b] * eliminated[b][j] / eliminated[b][b];
            }
        }
        // An eliminated angle takes no more part; one on the diagonal keeps a later elimination defined.
        q[b] = std::array::from_fn(|j| if j == b { 1.0 } else { 0.0 });
        (0..3).filter(|&i| i != b).for_each(|i| q[i][b] = 0.0);
    }
    q
}

impl Potential for PlateBending {
    fn name(&self) -> &str {
        &self.name
    }

    fn value(&self, x: &[Vec3]) -> f64 {
        self.six.value(x) + self.five.value(x) + self.four.value(x)
    }

    fn add_gradient(&self, x: &[Vec3], gradient: &mut [Vec3]) {
        self.six.add_gradient(x, gradient);
        self.five.add_gradient(x, gradient);
        self.four.add_gradient(x, gradient);
    }

    fn add_hessian(&self, x: &[Vec3], projection: Projection, hessian: &mut Assembler<'_>) {
        self.six.add_hessian(x, projection, hessian);
        self.five.add_hessian(x, projection, hessian);
        self.four.add_hessian(x, projection, hessian);
    }

    fn limit_step(&mut self, _: &[Vec3], _: &[Vec3]) -> Result<StepLimit, PotentialError> {
        Ok(StepLimit::FULL)
    }

    /// Elements are counted list after list: six points, five, four.
    fn locate(&self, x: &[Vec3], point: usize) -> Option<usize> {
        let (six, five) = (self.six.elements().len(), self.five.elements().len());
        let places = [
            strongest(&self.six, x, point, 0),
            strongest(&self.five, x, point, six),
            strongest(&self.four, x, point, six + five),
        ];
        places.into_iter().flatten().max_by(|a, b| a.1.total_cmp(&b.1)).map(|(element, _)| element)
    }

    fn diagnose(&self, x: &[Vec3]) -> Option<PotentialError> {
        self.six.diagnose(x).or_else(|| self.five.diagnose(x)).or_else(|| self.four.diagnose(x))
    }
}

/// The element of one list that pulls most at `point`, counted from `first`, and how hard \[N\].
fn strongest<const N: usize>(
    term: &StencilTerm<Patches<N>, N>,
    x: &[Vec3],
    point: usize,
    first: usize,
) -> Option<(usize, f64)> {
    let element = term.locate(x, point)?;
    let points = term.elements()[element];
    let local = points.iter().position(|&other| other as usize == point)?;
    let forces = term.stencil().gradient(element, &points.map(|i| x[i as usize]));
    Some((first + element, forces[local].norm()))
}
