//! The energy of a rod's twist.

use super::joints::{Joint, joints_of};
use super::rest_lengths;
use super::transport::{SweptDerivatives, swept_angle, swept_derivatives};
use crate::element::thin_error::{ThinError, positive};
use mechanics_core::mesh::TriMesh;
use mechanics_core::potential::{Changed, Potential, PotentialError};
use mechanics_core::projection::{Projection, project_symmetric};
use mechanics_core::sparse::Assembler;
use mechanics_core::stage::{Moment, Stage};
use mechanics_core::stencil::{LocalHessian, Stencil, StencilTerm};
use mechanics_core::tensor::{Mat3, Vec3};
use nalgebra::{SMatrix, SVector};
use std::ops::Range;

/// How a rod's section resists twist.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwistSection {
    /// Torsional rigidity GJ [N m²].
    pub torsional: f64,
    /// Polar radius of gyration r = √(I_p/A) \[m\], I_p = ∫ (y² + z²) dA.
    pub gyration_radius: f64,
}

impl TwistSection {
    /// A full circle: J = I_p = πR⁴/2, r = R/√2, from the shear modulus \[Pa\] and the radius R \[m\].
    ///
    /// # Errors
    /// A parameter that is not positive.
    pub fn circular(shear_modulus: f64, radius: f64) -> Result<Self, ThinError> {
        let shear = positive("the shear modulus", shear_modulus)?;
        let radius = positive("the radius", radius)?;
        let torsional = shear * 0.5 * std::f64::consts::PI * radius.powi(4);
        Ok(Self { torsional, gyration_radius: radius * std::f64::consts::FRAC_1_SQRT_2 })
    }
}

/// E = Σ ½ (GJ/ℓ̄ᵢ) (mᵢ − ℓ̄ᵢ τ̄)² over the joints i of a rod, mᵢ the angle \[rad\] by which the section of the joint's second
/// edge is turned about the rod against that of its first, ℓ̄ᵢ = ½(|ē₀| + |ē₁|), τ̄ the natural twist [rad/m] (zero unless set).
///
/// # Unknowns
/// Edge j of the mesh has an angle θⱼ about its direction, from its first to its second point. It is the x-component of a
/// further point, the edge's *turn* u = (rθⱼ, 0, 0) \[m\]: the arc that the section moves through at its radius of gyration r. So
///
/// - kinetic energy needs nothing new: ½ ρI_pℓ̄ θ̇² = ½ m u̇² with the edge's own mass m = ρAℓ̄, since I_p = Ar² ([`add_mass`](Self::add_mass));
/// - an edge is clamped, or turned by a motor, by fixing its turn as any point; the force there is the torque over r;
/// - velocities and tolerances in m/s mean for a turn what they mean for a point.
///
/// The other two components have no meaning; ½ (GJ/(ℓ̄r²)) (y² + z²) of both turns of every joint holds them at zero.
/// A mass that is far above the true one (turns are fast: their waves run at √(GJ/ρI_p)) slows them and changes no equilibrium.
///
/// # Twist
/// θ is measured from a reference frame that the edge carries along by parallel transport: θ̇ is the spin about the tangent,
/// and a turn at rest does not spin. At the start of a step ([`Moment::Step`]) let the joint's edges have the directions a₀, a₁ and
/// their reference frames the twist m̲; then
///
/// - m(x) = θ₁ − θ₀ + m̲ + A(a₀, a₁, t₀, t₁),
///
/// A the area on the unit sphere that the tangents sweep (`rod/transport.rs` has A and its derivatives in closed form). The mesh that the rod
/// is made of has no twist with all θ equal zero, whatever its shape. From step to step m̲ adds up; for a closed rod
/// Σ m̲ = −2π (writhe − writhe at rest), so that twist and writhe exchange as they must.
///
/// In a step an edge may turn by less than 180° minus the joint's own angle; beyond, the energy is infinite and a line
/// search backs away. A joint with an edge shorter than 10⁻⁸ of its rest length has no twist: no energy, no force.
///
/// # Moments
/// A rotation of everything by ω turns every frame by ω·t: so Σ x × f + Σ τⱼ tⱼ = 0 at the start of a step for the forces f on
/// points and the torques τⱼ on turns. Where the twist is settled, τⱼ = 0 but at held ends, Σ x × mv changes by their torque alone. Of
/// the inertia of turning only ½ ρI_pℓ̄ θ̇² is there: a fast spin does not resist being tilted (no gyroscopic force; it is smaller than
/// other inertia by (r/L)² θ̇/(the rate of bending)), as bending has no rotary inertia either.
///
/// The Hessian is projected as the 7×7 matrix by the two edges and the difference of the turns.
///
/// ```
/// use lagrangian::element::rod::{RodTwist, TwistSection};
/// use mechanics_core::mesh::rod;
/// use mechanics_core::potential::Potential;
/// use mechanics_core::tensor::Vec3;
///
/// // A steel wire of 1 mm radius, its end edges (1 m apart from middle to middle) turned by 0.1 rad against each other.
/// let n = 21;
/// let mesh = rod(&Vec3::zeros(), &Vec3::new(1.05, 0.0, 0.0), n)?;
/// let section = TwistSection::circular(80e9, 1e-3)?;
/// let twist = RodTwist::new("twist", &mesh, section, mesh.points().len() as u32)?;
/// let mut x = mesh.points().to_vec();
/// x.extend((0..n).map(|j| twist.turn(0.1 * f64::from(j) / f64::from(n - 1))));
/// let mut forces = vec![Vec3::zeros(); x.len()];
/// twist.add_gradient(&x, &mut forces);
/// let torque = forces[x.len() - 1].x * section.gyration_radius;
/// println!("torque {torque:.6} N m"); // GJ θ/L = 0.012566 N m
/// assert!((torque - 80e9 * 0.5 * std::f64::consts::PI * 1e-12 * 0.1).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Reference
/// M. Bergou, M. Wardetzky, S. Robinson, B. Audoly, E. Grinspun, *Discrete elastic rods*, ACM Trans. Graph. 27(3), 2008,
/// sections 4.2 and 7; frames carried in time: Bergou, Audoly, Vouga, Wardetzky, Grinspun, *Discrete viscous threads*, ACM Trans.
/// Graph. 29(4), 2010. The area in place of frames, the turn as a point and the closed Hessian are this module's.
#[derive(Debug)]
pub struct RodTwist {
    section: TwistSection,
    turns: Range<u32>,
    term: StencilTerm<TwistedJoints, 5>,
}

#[derive(Debug)]
struct TwistedJoints {
    gyration_radius: f64,
    joints: Vec<TwistedJoint>,
}

#[derive(Clone, Copy, Debug)]
struct TwistedJoint {
    /// GJ/ℓ̄ \[J\].
    stiffness: f64,
    /// ℓ̄ \[m\].
    length: f64,
    /// ℓ̄ τ̄ \[rad\].
    natural: f64,
    /// Whether the edges run with the joint (+1) or against it (−1).
    orientations: [f64; 2],
    /// Lengths below which an edge counts as collapsed \[m\].
    collapsed: [f64; 2],
    /// a₀, a₁.
    tangents: [Vec3; 2],
    /// m̲ \[rad\].
    reference: f64,
}

const COLLAPSED: f64 = 1e-8;

impl RodTwist {
    /// The twist of the free edges of `mesh`, untwisted where they are. The turn of edge j is point `first_turn + j`.
    ///
    /// # Errors
    /// A rigidity or radius that is not positive; an edge without length; a point in which more than two edges meet; a
    /// turn among the points of the mesh.
    pub fn new(
        name: impl Into<String>,
        mesh: &TriMesh,
        section: TwistSection,
        first_turn: u32,
    ) -> Result<Self, ThinError> {
        let torsional = positive("the torsional rigidity", section.torsional)?;
        let gyration_radius = positive("the polar radius of gyration", section.gyration_radius)?;
        let points = mesh.points().len();
        if (first_turn as usize) < points {
            return Err(ThinError::Turn { first_turn, points });
        }
        let rest = rest_lengths(mesh)?;
        let found = joints_of(mesh)?;
        let turn = |edge: usize| first_turn + edge as u32;
        let points = found.iter().map(|&Joint { points: [a, b, c], edges }| {
            let [u, v] = edges.map(turn);
            [a, b, c, u, v]
        });
        let elements = points.collect();
        let joint = |joint: &Joint| {
            let lengths = joint.edges.map(|edge| rest[edge]);
            let length = 0.5 * (lengths[0] + lengths[1]);
            let [a, b, c] = joint.points.map(|point| mesh.points()[point as usize]);
            TwistedJoint {
                stiffness: torsional / length,
                length,
                natural: 0.0,
                orientations: joint.orientations(mesh),
                collapsed: lengths.map(|length| COLLAPSED * length),
                tangents: [(b - a) / lengths[0], (c - b) / lengths[1]],
                reference: 0.0,
            }
        };
        let joints = TwistedJoints { gyration_radius, joints: found.iter().map(joint).collect() };
        let turns = first_turn..turn(mesh.free_edges().len());
        Ok(Self { section, turns, term: StencilTerm::new(name, joints, elements)? })
    }

    /// The same with a natural twist τ̄ [rad/m]: unloaded, sections turn by τ̄ per length along the rod.
    ///
    /// # Errors
    /// A twist that is not finite.
    pub fn with_natural_twist(mut self, twist: f64) -> Result<Self, ThinError> {
        if !twist.is_finite() {
            return Err(ThinError::Parameter {
                parameter: "the natural twist",
                value: twist,
                expected: "finite",
            });
        }
        for joint in &mut self.term.stencil_mut().joints {
            joint.natural = joint.length * twist;
        }
        Ok(self)
    }

    /// The section.
    pub fn section(&self) -> TwistSection {
        self.section
    }

    /// The points that are turns, one per edge of the mesh, in their order.
    pub fn turns(&self) -> Range<u32> {
        self.turns.clone()
    }

    /// The turn of an edge by `angle` \[rad\], as a point \[m\].
    pub fn turn(&self, angle: f64) -> Vec3 {
        Vec3::new(self.section.gyration_radius * angle, 0.0, 0.0)
    }

    /// The joints: the far point of the first edge, the joint, the far point of the second, the turns of the edges.
    pub fn joints(&self) -> &[[u32; 5]] {
        self.term.elements()
    }

    /// The twist mᵢ of every joint \[rad\] with all points at `x`; NaN where it has none.
    ///
    /// # Panics
    /// If `x` lacks a point.
    pub fn twists(&self, x: &[Vec3]) -> Vec<f64> {
        let stencil = self.term.stencil();
        let twist = |(element, points): (usize, &[u32; 5])| {
            let x = points.map(|point| x[point as usize]);
            stencil.twist(element, &x).map_or(f64::NAN, |found| found.angle)
        };
        self.joints().iter().enumerate().map(twist).collect()
    }

    /// The twisting moment GJ (mᵢ/ℓ̄ᵢ − τ̄) in every joint [N m]; NaN where it has no twist.
    ///
    /// # Panics
    /// If `x` lacks a point.
    pub fn moments(&self, x: &[Vec3]) -> Vec<f64> {
        let joints = &self.term.stencil().joints;
        let moment = |(twist, joint): (f64, &TwistedJoint)| joint.stiffness * (twist - joint.natural);
        self.twists(x).into_iter().zip(joints).map(moment).collect()
    }

    /// The twist m̲ of the reference frames \[rad\] in every joint. With the positions it is all that a checkpoint needs.
    pub fn reference_twists(&self) -> Vec<f64> {
        self.term.stencil().joints.iter().map(|joint| joint.reference).collect()
    }

    /// Carries the reference frames to the positions `x`, as the start of a step does. Twice is as good as once, in every bit.
    ///
    /// # Errors
    /// [`ThinError::Transport`] if the edges of a joint have turned so far that the way is ambiguous; no frame has moved then.
    ///
    /// # Panics
    /// If `x` lacks a point.
    pub fn transport_to(&mut self, x: &[Vec3]) -> Result<(), ThinError> {
        let elements = self.term.elements();
        let carried = |(joint, &points): (&TwistedJoint, &[u32; 5])| {
            let [a, b, c, ..] = points;
            let Some((_, tangents)) = joint.edges(&[a, b, c].map(|point| x[point as usize])) else {
                return Ok(*joint);
            };
            let swept = swept_angle(&joint.tangents, &tangents);
            let swept = swept.ok_or(ThinError::Transport { points: [a, b, c] })?;
            Ok(TwistedJoint { tangents, reference: joint.reference + swept, ..*joint })
        };
        let joints = &self.term.stencil().joints;
        let joints = joints.iter().zip(elements).map(carried).collect::<Result<Vec<_>, ThinError>>()?;
        self.term.stencil_mut().joints = joints;
        Ok(())
    }

    /// Puts the reference frames at `x` with the twists that [`reference_twists`](Self::reference_twists) gave there: the way
    /// back from a checkpoint. (Carry the frames there before asking: between two steps they are where the last one began.)
    ///
    /// # Errors
    /// A twist that is not finite.
    ///
    /// # Panics
    /// If there is not one twist per joint, or if `x` lacks a point.
    pub fn restore(&mut self, x: &[Vec3], reference_twists: &[f64]) -> Result<(), ThinError> {
        assert_eq!(reference_twists.len(), self.joints().len(), "one reference twist per joint");
        if let Some(&value) = reference_twists.iter().find(|twist| !twist.is_finite()) {
            return Err(ThinError::Parameter { parameter: "a reference twist", value, expected: "finite" });
        }
        let elements = self.term.elements().to_vec();
        let joints = self.term.stencil_mut().joints.iter_mut();
        for ((joint, [a, b, c, ..]), &reference) in joints.zip(elements).zip(reference_twists) {
            joint.reference = reference;
            if let Some((_, tangents)) = joint.edges(&[a, b, c].map(|point| x[point as usize])) {
                joint.tangents = tangents;
            }
        }
        Ok(())
    }

    /// Adds to `mass` what the turns need: the mass of its edge, `mass_per_length` [kg/m] times the length at rest, to each.
    ///
    /// # Errors
    /// [`ElementError`](crate::element::ElementError) if `mass_per_length` is negative or `mass` lacks a point.
    pub fn add_mass(
        &self,
        mass: &mut crate::element::Mass,
        mesh: &TriMesh,
        mass_per_length: f64,
    ) -> Result<(), crate::element::ElementError> {
        for (turn, &[a, b]) in self.turns().zip(mesh.free_edges()) {
            let length = (mesh.points()[b as usize] - mesh.points()[a as usize]).norm();
            mass.add_point(turn, mass_per_length * length)?;
        }
        Ok(())
    }
}

impl Potential for RodTwist {
    fn name(&self) -> &str {
        self.term.name()
    }

    fn value(&self, x: &[Vec3]) -> f64 {
        self.term.value(x)
    }

    fn add_gradient(&self, x: &[Vec3], gradient: &mut [Vec3]) {
        self.term.add_gradient(x, gradient);
    }

    fn add_hessian(&self, x: &[Vec3], projection: Projection, hessian: &mut Assembler<'_>) {
        self.term.add_hessian(x, projection, hessian);
    }

    /// At the start of a step the reference frames are carried to where the edges are now.
    fn freeze(&mut self, stage: &Stage<'_>) -> Result<Changed, PotentialError> {
        if stage.moment != Moment::Step {
            return Ok(Changed::Nothing);
        }
        self.transport_to(stage.x).map_err(|source| PotentialError::Term {
            term: self.name().to_owned(),
            source: Box::new(source),
        })?;
        Ok(Changed::Energy)
    }

    fn locate(&self, x: &[Vec3], point: usize) -> Option<usize> {
        self.term.locate(x, point)
    }

    fn diagnose(&self, x: &[Vec3]) -> Option<PotentialError> {
        self.term.diagnose(x)
    }
}

/// A joint's twist, and the edges it was found with.
struct Twist {
    angle: f64,
    lengths: [f64; 2],
    tangents: [Vec3; 2],
}

impl TwistedJoint {
    /// Lengths and directions of the edges; `None` where one has collapsed.
    fn edges(&self, x: &[Vec3; 3]) -> Option<([f64; 2], [Vec3; 2])> {
        let edges = [x[1] - x[0], x[2] - x[1]];
        let lengths = edges.map(|edge| edge.norm());
        let collapsed = lengths.iter().zip(&self.collapsed).any(|(length, least)| length <= least);
        (!collapsed).then(|| (lengths, [edges[0] / lengths[0], edges[1] / lengths[1]]))
    }
}

impl TwistedJoints {
    /// `None` where an edge has collapsed; an infinite angle where edges have turned too far.
    fn twist(&self, element: usize, x: &[Vec3; 5]) -> Option<Twist> {
        let joint = &self.joints[element];
        let (lengths, tangents) = joint.edges(&[x[0], x[1], x[2]])?;
        let [s0, s1] = joint.orientations;
        let turned = (s1 * x[4].x - s0 * x[3].x) / self.gyration_radius;
        let swept = swept_angle(&joint.tangents, &tangents).unwrap_or(f64::INFINITY);
        Some(Twist { angle: turned + joint.reference + swept, lengths, tangents })
    }

    /// What holds the two components of a turn that have no meaning [N/m].
    fn holding(&self, element: usize) -> f64 {
        self.joints[element].stiffness / self.gyration_radius.powi(2)
    }

    /// ∂²E/∂(e₀, e₁, u₁ − u₀)², projected.
    fn reduced_hessian(&self, element: usize, twist: &Twist, projection: Projection) -> SMatrix<f64, 7, 7> {
        let joint = &self.joints[element];
        let swept = swept_derivatives(&joint.tangents, &twist.tangents, twist.lengths);
        let SweptDerivatives { gradient: [g0, g1], hessian: [a, b, d] } = swept;
        let slope = SVector::<f64, 7>::from_column_slice(&[
            g0.x,
            g0.y,
            g0.z,
            g1.x,
            g1.y,
            g1.z,
            1.0 / self.gyration_radius,
        ]);
        let mut reduced = slope * slope.transpose();
        let strain = twist.angle - joint.natural;
        for (at, block) in [((0, 0), a), ((3, 0), b), ((0, 3), b.transpose()), ((3, 3), d)] {
            let mut view = reduced.fixed_view_mut::<3, 3>(at.0, at.1);
            view += block * strain;
        }
        project_symmetric(&(reduced * joint.stiffness), projection)
    }
}

impl Stencil<5> for TwistedJoints {
    fn value(&self, element: usize, x: &[Vec3; 5]) -> f64 {
        let joint = &self.joints[element];
        let held: f64 = x[3..].iter().map(|u| u.y * u.y + u.z * u.z).sum();
        let strain = self.twist(element, x).map_or(0.0, |twist| twist.angle - joint.natural);
        let value = 0.5 * (joint.stiffness * strain * strain + self.holding(element) * held);
        if value.is_nan() { f64::INFINITY } else { value }
    }

    fn gradient(&self, element: usize, x: &[Vec3; 5]) -> [Vec3; 5] {
        let held = self.holding(element);
        let mut gradient = [Vec3::zeros(); 5];
        for k in [3, 4] {
            gradient[k] = Vec3::new(0.0, held * x[k].y, held * x[k].z);
        }
        let Some(twist) = self.twist(element, x) else { return gradient };
        let joint = &self.joints[element];
        let moment = joint.stiffness * (twist.angle - joint.natural);
        let [g0, g1] = swept_derivatives(&joint.tangents, &twist.tangents, twist.lengths).gradient;
        gradient[0] = g0 * -moment;
        gradient[1] = (g0 - g1) * moment;
        gradient[2] = g1 * moment;
        let [s0, s1] = joint.orientations;
        gradient[3].x = -s0 * moment / self.gyration_radius;
        gradient[4].x = s1 * moment / self.gyration_radius;
        gradient
    }

    fn hessian(&self, element: usize, x: &[Vec3; 5], projection: Projection) -> LocalHessian<5> {
        let mut hessian = [[Mat3::zeros(); 5]; 5];
        let held = self.holding(element);
        for k in [3, 4] {
            hessian[k][k] = Mat3::from_diagonal(&Vec3::new(0.0, held, held));
        }
        let Some(twist) = self.twist(element, x) else { return hessian };
        let reduced = self.reduced_hessian(element, &twist, projection);
        // The rows of e₀, e₁ and u₁ − u₀ by the five points.
        let [s0, s1] = self.joints[element].orientations;
        let weights = [[-1.0, 1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, -s0, s1]];
        let block = |a: usize, b: usize| -> Mat3 {
            let width = |k: usize| if k < 2 { 3 } else { 1 };
            let mut block = Mat3::zeros();
            let part = reduced.view((3 * a, 3 * b), (width(a), width(b)));
            block.view_mut((0, 0), (width(a), width(b))).copy_from(&part);
            block
        };
        for a in 0..3 {
            for b in 0..3 {
                let part = block(a, b);
                for i in 0..5 {
                    for j in 0..=i {
                        hessian[i][j] += part * (weights[a][i] * weights[b][j]);
                    }
                }
            }
        }
        hessian
    }
}
