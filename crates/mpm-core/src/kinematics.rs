//! Kinematics of a continuum: the material and the spatial view of one motion, and what it must balance.
//!
//! A [`DeformationMap`] x = φ(X, t) says where the material point X is at time t. Written once over core's
//! [`Scalar`], automatic differentiation gives everything else:
//!
//! | material (at X) | spatial (at x = φ(X, t)) |
//! |---|---|
//! | V = ∂φ/∂t, [`material_motion`] | v(x, t) = V(φ⁻¹(x, t), t), [`Eulerian`] |
//! | A = ∂²φ/∂t² | a = ∂v/∂t + (∇v) v, [`eulerian_acceleration`] |
//! | F = ∂φ/∂X, Ḟ | ∇v = Ḟ F⁻¹ |
//! | R J = R₀, [`mass_residual`] | the density of the place where X is |
//! | R₀ A = Div P + R₀ B, [`momentum_residual`] | |
//!
//! A *manufactured solution* is a map that somebody likes, made a solution by the body force that it needs:
//! B = A − Div P/R₀ with P from the law ([`body_force`]). Nobody derives it by hand.
//!
//! ```
//! use mechanics_core::scalar::Scalar;
//! use mpm_core::kinematics::{DeformationMap, Eulerian, eulerian_acceleration, material_motion};
//!
//! /// A river that narrows: steady in space, v = v₀ (1 + x/L), and yet all of its water speeds up.
//! struct River;
//! impl DeformationMap<1> for River {
//!     fn place<S: Scalar>(&self, material: &[S; 1], time: S) -> [S; 1] {
//!         [material[0].offset(10.0) * time.scale(0.2).exp() - S::constant(10.0)] // v₀ = 2 m/s, L = 10 m
//!     }
//! }
//!
//! let motion = material_motion(&River, &[5.0], 3.0);
//! let a = eulerian_acceleration(&Eulerian(River), &motion.position, 3.0)?;
//! assert!(a.local[0].abs() < 1e-13); // nothing changes at a place of the bank
//! assert!((a.convective[0] - motion.acceleration[0]).abs() < 1e-13);
//! # Ok::<(), mpm_core::MpmError>(())
//! ```
//!
//! # Reference
//! M. E. Gurtin, E. Fried, L. Anand, *The Mechanics and Thermodynamics of Continua*, 2010: part II (motion, material and
//! spatial fields), part IV (balance of mass and momentum, also per rest volume).

use crate::MpmError;
use crate::material::largest;
use mechanics_core::jet::{Jet1, Jet2};
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::{
    Mat3, Matrix3, cofactor, determinant, from_entries, product_transpose, scaled, transpose,
};
use mpm_constitutive::{PointLaw, Strain, fresh_history};

/// A motion x = φ(X, t) of a continuum in `D` = 1, 2 or 3 dimensions; in fewer than three the other axes do not move (plane or uniaxial
/// strain).
///
/// φ(X, 0) = X where a function inverts the map; everything else asks for nothing but derivatives.
pub trait DeformationMap<const D: usize>: Send + Sync {
    /// φ(X, t): where the material point X is at time t \[m\].
    fn place<S: Scalar>(&self, material: &[S; D], time: S) -> [S; D];
}

/// A velocity field v(x, t) of a place, over any jet of `f64`.
pub trait VelocityField<const D: usize>: Send + Sync {
    /// v(x, t) \[m/s\].
    ///
    /// # Errors
    /// [`MpmError::NoMaterialPoint`] where nothing is.
    fn velocity<S: Scalar<Value = f64>>(&self, position: &[S; D], time: S) -> Result<[S; D], MpmError>;
}

/// What a map does to one material point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialMotion<const D: usize> {
    /// x = φ(X, t) \[m\].
    pub position: [f64; D],
    /// V = ∂φ/∂t \[m/s\].
    pub velocity: [f64; D],
    /// A = ∂²φ/∂t² \[m/s²\].
    pub acceleration: [f64; D],
    /// F = ∂φ/∂X; ones on the axes that do not move.
    pub deformation_gradient: Mat3,
    /// Ḟ \[1/s\].
    pub gradient_rate: Mat3,
}

impl<const D: usize> MaterialMotion<D> {
    /// J = det F.
    pub fn volume_ratio(&self) -> f64 {
        determinant(&self.deformation_gradient)
    }

    /// ∇v = Ḟ F⁻¹ \[1/s\], row a, column b = ∂v_a/∂x_b; not finite where J = 0.
    pub fn velocity_gradient(&self) -> [[f64; D]; D] {
        let gradient = self.gradient_rate * inverse(&self.deformation_gradient);
        std::array::from_fn(|a| std::array::from_fn(|b| gradient[(a, b)]))
    }
}

/// A⁻¹, from the cofactors.
fn inverse<S: Scalar>(a: &Matrix3<S>) -> Matrix3<S> {
    scaled(&transpose(&cofactor(a)), determinant(a).recip())
}

/// A D×D matrix as the corner of a 3×3 one, `rest` on the rest of its diagonal.
fn embedded<S: Scalar, const D: usize>(rest: f64, entry: impl Fn(usize, usize) -> S) -> Matrix3<S> {
    from_entries(
        |a, b| if a < D && b < D { entry(a, b) } else { S::constant(if a == b { rest } else { 0.0 }) },
    )
}

/// Place, velocity, acceleration, F and Ḟ of the material point X at time t, from one evaluation of the map: second order in t within first order
/// in X.
pub fn material_motion<M: DeformationMap<D>, const D: usize>(
    map: &M,
    material: &[f64; D],
    time: f64,
) -> MaterialMotion<D> {
    let points: [Jet1<Jet2<f64, 1>, D>; D] = Jet1::variables(material.map(Jet2::from_value));
    let place = map.place(&points, Jet1::from_value(Jet2::variable(time, 0)));
    MaterialMotion {
        position: place.map(|x| x.value.value),
        velocity: place.map(|x| x.value.gradient[0]),
        acceleration: place.map(|x| x.value.hessian(0, 0)),
        deformation_gradient: embedded::<f64, D>(1.0, |a, b| place[a].gradient[b].value),
        gradient_rate: embedded::<f64, D>(0.0, |a, b| place[a].gradient[b].gradient[0]),
    }
}

/// F over any scalar.
fn deformation_gradient<S: Scalar, M: DeformationMap<D>, const D: usize>(
    map: &M,
    material: &[S; D],
    time: S,
) -> Matrix3<S> {
    let place = map.place(&Jet1::<S, D>::variables(*material), Jet1::from_value(time));
    embedded::<S, D>(1.0, |a, b| place[a].gradient[b])
}

/// The most Newton steps towards a material point, and the most parts of the way from time zero.
const MOST_CORRECTIONS: usize = 40;
const MOST_PARTS: u32 = 256;

/// X = φ⁻¹(x, t): the material point that is at x at time t, by Newton's method, to a few roundings of x.
///
/// Starts from X = x at time zero and, where that is too far, follows the motion in 2, 4, … 256 parts of the time.
///
/// # Errors
/// [`MpmError::NoMaterialPoint`] if no part is short enough: outside of the body, or the map does not start as the identity.
pub fn material_point<M: DeformationMap<D>, const D: usize>(
    map: &M,
    position: &[f64; D],
    time: f64,
) -> Result<[f64; D], MpmError> {
    let mut parts = 1;
    loop {
        let mut found = Ok(*position);
        for part in 1..=parts {
            let now = time * f64::from(part) / f64::from(parts);
            found = found.and_then(|start| newton(map, start, position, now));
        }
        match found {
            Ok(material) => return Ok(material),
            Err(distance) if parts == MOST_PARTS => {
                return Err(MpmError::NoMaterialPoint { position: position.to_vec(), time, distance });
            }
            Err(_) => parts *= 2,
        }
    }
}

/// Newton's method for φ(X, t) = x from a start; the distance left if it does not converge.
fn newton<M: DeformationMap<D>, const D: usize>(
    map: &M,
    start: [f64; D],
    position: &[f64; D],
    time: f64,
) -> Result<[f64; D], f64> {
    // A NaN stays.
    let size = |v: &[f64; D]| v.iter().fold(0.0, |most, x| largest(most, x.abs()));
    let mut material = start;
    let mut distance = f64::INFINITY;
    for _ in 0..MOST_CORRECTIONS {
        let motion = material_motion(map, &material, time);
        let missing: [f64; D] = std::array::from_fn(|a| position[a] - motion.position[a]);
        let correction = corrected(&inverse(&motion.deformation_gradient), &missing);
        distance = size(&missing);
        let bound = 4.0 * f64::EPSILON * (size(position) + size(&motion.position) + size(&material));
        if !distance.is_finite() {
            break;
        }
        if distance <= bound {
            return Ok(material);
        }
        for a in 0..D {
            material[a] += correction[a];
        }
    }
    Err(distance)
}

/// The corner of a 3×3 matrix times a vector.
fn corrected<S: Scalar, const D: usize>(matrix: &Mat3, vector: &[S; D]) -> [S; D] {
    std::array::from_fn(|a| {
        (0..D).fold(S::constant(0.0), |sum, b| vector[b].mul_add(S::constant(matrix[(a, b)]), sum))
    })
}

/// How often the inverse is corrected in jets: each time gives one order of derivatives more.
const JET_CORRECTIONS: usize = 4;

/// The velocity field of a map's motion: v(x, t) = V(φ⁻¹(x, t), t), with derivatives up to the fourth order in jets.
///
/// With the inverse X₀ in values and G = F(X₀)⁻¹, X ← X − G (φ(X, t) − x) in jets leaves an error one order higher each time: the
/// implicit function theorem without its formulas.
#[derive(Clone, Copy, Debug)]
pub struct Eulerian<M>(
    /// The motion.
    pub M,
);

impl<M: DeformationMap<D>, const D: usize> VelocityField<D> for Eulerian<M> {
    fn velocity<S: Scalar<Value = f64>>(&self, position: &[S; D], time: S) -> Result<[S; D], MpmError> {
        let start = material_point(&self.0, &position.map(S::value), time.value())?;
        let slope = inverse(&material_motion(&self.0, &start, time.value()).deformation_gradient);
        let mut material = start.map(S::constant);
        for _ in 0..JET_CORRECTIONS {
            let place = self.0.place(&material, time);
            let missing: [S; D] = std::array::from_fn(|a| position[a] - place[a]);
            let correction = corrected(&slope, &missing);
            for a in 0..D {
                material[a] += correction[a];
            }
        }
        let place = self.0.place(&material.map(Jet1::<S, 1>::from_value), Jet1::variable(time, 0));
        Ok(place.map(|x| x.gradient[0]))
    }
}

/// The two parts of an acceleration seen from a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EulerianAcceleration<const D: usize> {
    /// ∂v/∂t \[m/s²\]: zero in a steady flow.
    pub local: [f64; D],
    /// (∇v) v \[m/s²\].
    pub convective: [f64; D],
}

impl<const D: usize> EulerianAcceleration<D> {
    /// a = ∂v/∂t + (∇v) v \[m/s²\], which is A of the material point there.
    pub fn total(&self) -> [f64; D] {
        std::array::from_fn(|a| self.local[a] + self.convective[a])
    }
}

/// a(x, t) = ∂v/∂t + (∇v) v of a velocity field.
///
/// # Errors
/// What the field gives.
pub fn eulerian_acceleration<V: VelocityField<D>, const D: usize>(
    field: &V,
    position: &[f64; D],
    time: f64,
) -> Result<EulerianAcceleration<D>, MpmError> {
    let at = position.map(Jet1::<f64, 1>::from_value);
    let local = field.velocity(&at, Jet1::variable(time, 0))?.map(|v| v.gradient[0]);
    let velocity = field.velocity(position, time)?;
    // The derivative along v itself is (∇v) v.
    let along: [Jet1<f64, 1>; D] =
        std::array::from_fn(|a| Jet1 { value: position[a], gradient: [velocity[a]] });
    let convective = field.velocity(&along, Jet1::from_value(time))?.map(|v| v.gradient[0]);
    Ok(EulerianAcceleration { local, convective })
}

/// A material quantity at a place: q(x, t) = Q(φ⁻¹(x, t), t).
///
/// # Errors
/// [`MpmError::NoMaterialPoint`] where nothing is.
pub fn at_place<M: DeformationMap<D>, T, const D: usize>(
    map: &M,
    quantity: impl Fn(&[f64; D], f64) -> T,
    position: &[f64; D],
    time: f64,
) -> Result<T, MpmError> {
    material_point(map, position, time).map(|material| quantity(&material, time))
}

/// A spatial quantity at a material point: Q(X, t) = q(φ(X, t), t).
pub fn at_material_point<M: DeformationMap<D>, T, const D: usize>(
    map: &M,
    quantity: impl Fn(&[f64; D], f64) -> T,
    material: &[f64; D],
    time: f64,
) -> T {
    quantity(&map.place(material, time), time)
}

/// R J − R₀ [kg/m³]: zero where mass is conserved; R is the density at the place where X is, R₀ its density at rest.
pub fn mass_residual<M: DeformationMap<D>, const D: usize>(
    map: &M,
    material: &[f64; D],
    time: f64,
    density: f64,
    rest_density: f64,
) -> f64 {
    density * material_motion(map, material, time).volume_ratio() - rest_density
}

/// P = τ F⁻ᵀ over any scalar.
fn piola<S: Scalar, L: PointLaw>(law: &L, f: &Matrix3<S>) -> Matrix3<S> {
    let strain = L::Strain::<S>::from_deformation_gradient(f);
    let tau = law.stress(&strain, &fresh_history::<L, S>()).kirchhoff;
    product_transpose(&tau, &inverse(f))
}

/// P, the first Piola–Kirchhoff stress \[Pa\] of virgin material at X: the traction on a rest area of normal N is P N.
pub fn first_piola<M: DeformationMap<D>, L: PointLaw, const D: usize>(
    map: &M,
    law: &L,
    material: &[f64; D],
    time: f64,
) -> Mat3 {
    piola(law, &deformation_gradient(map, material, time))
}

/// Div P, (Div P)ᵢ = ∂Pᵢⱼ/∂Xⱼ [N/m³ at rest]: stress from the law, its derivatives by jets, without viscosity or flow.
pub fn stress_divergence<M: DeformationMap<D>, L: PointLaw, const D: usize>(
    map: &M,
    law: &L,
    material: &[f64; D],
    time: f64,
) -> [f64; D] {
    let points = Jet1::<f64, D>::variables(*material);
    let stress = piola(law, &deformation_gradient(map, &points, Jet1::from_value(time)));
    std::array::from_fn(|i| (0..D).map(|j| stress[(i, j)].gradient[j]).sum())
}

/// B = A − Div P/R₀ \[m/s²\]: the body force per mass with which the map is a solution for the law.
pub fn body_force<M: DeformationMap<D>, L: PointLaw, const D: usize>(
    map: &M,
    law: &L,
    rest_density: f64,
    material: &[f64; D],
    time: f64,
) -> [f64; D] {
    let acceleration = material_motion(map, material, time).acceleration;
    let divergence = stress_divergence(map, law, material, time);
    std::array::from_fn(|i| acceleration[i] - divergence[i] / rest_density)
}

/// R₀ A − Div P − R₀ B \[N/m³\]: zero where momentum is balanced under the body force B \[m/s²\].
pub fn momentum_residual<M: DeformationMap<D>, L: PointLaw, const D: usize>(
    map: &M,
    law: &L,
    rest_density: f64,
    (material, time): (&[f64; D], f64),
    force: &[f64; D],
) -> [f64; D] {
    let needed = body_force(map, law, rest_density, material, time);
    std::array::from_fn(|i| rest_density * (needed[i] - force[i]))
}
