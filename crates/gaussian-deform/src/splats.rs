//! The scene: Gaussians as a structure of arrays.

use crate::error::{Property, SplatError};
use mechanics_core::lanes::Element;
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::{self, Matrix3, Vector3};

/// The degree of the spherical harmonics that give a Gaussian's colour by direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Degree {
    /// One coefficient a channel: the same colour from everywhere.
    Zero,
    /// Four coefficients a channel.
    One,
    /// Nine coefficients a channel.
    Two,
    /// Sixteen coefficients a channel.
    Three,
}

impl Degree {
    /// Every degree, ascending.
    pub const ALL: [Self; 4] = [Self::Zero, Self::One, Self::Two, Self::Three];

    /// The degree of a number; `None` above 3.
    pub fn of(number: usize) -> Option<Self> {
        Self::ALL.get(number).copied()
    }

    /// l, from 0 to 3.
    pub fn number(self) -> usize {
        self as usize
    }

    /// (l + 1)²: coefficients of one channel.
    pub fn coefficients(self) -> usize {
        (self.number() + 1) * (self.number() + 1)
    }

    /// 3 (l + 1)²: coefficients of one Gaussian.
    pub fn stride(self) -> usize {
        3 * self.coefficients()
    }
}

/// One Gaussian, as it is put into [`Splats`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Splat<'a, E> {
    /// μ \[m\].
    pub mean: Vector3<E>,
    /// B \[m\], with the covariance A = B Bᵀ.
    pub axes: Matrix3<E>,
    /// From 0 to 1.
    pub opacity: E,
    /// The coefficients of red, then of green, then of blue; see [`Splats::harmonics`].
    pub harmonics: &'a [E],
}

/// Gaussians: mean μ, covariance A = B Bᵀ, opacity, and colour by direction.
///
/// # Why the factor B and not A
/// A file gives a rotation R and scales s: B = R diag(s). Its columns are three half-axes of the ellipsoid (x − μ)ᵀ A⁻¹ (x − μ) = 1: conjugate
/// ones after a deformation, which carries them along as it does any three vectors that are drawn into the material, B' = F B, so
/// that A' = F A Fᵀ. From B every covariance is symmetric and positive semi-definite by construction, also in `f32`. Stored as A, a disc
/// thinner than √ε of its diameter (2.4e-4 in `f32`; captured surfaces are full of them) would have lost its thickness; B keeps it to ε of the diameter.
/// A picture needs (J W B)(J W B)ᵀ, as many multiplications as J W A (J W)ᵀ.
///
/// # Layout
/// Gaussian i has `means[i]`, `axes[i]` (column-major 3×3), `opacities[i]`, and `harmonics[i·stride .. (i + 1)·stride]`, stride = 3 (l + 1)²,
/// channel-major: the (l + 1)² coefficients of red, those of green, those of blue. Coefficient k = l² + l + m in the order and with the signs of
/// [`crate::harmonics`]; colour = ½ + Σₖ cₖ Yₖ(d), d the unit vector from the camera to the mean.
///
/// # Orientations
/// Rotating a Gaussian's colours by R is done in one of two ways, equal but for rounding: by rotating the coefficients, or by remembering R and looking up the
/// colour in direction Rᵀ d. Where [`orientations`](Self::orientations) is `Some`, the second has been chosen: whoever evaluates colours uses Rᵀ d.
/// [`crate::harmonics::settle_orientations`] goes over to the first.
#[derive(Clone, Debug, PartialEq)]
pub struct Splats<E: Element = f32> {
    degree: Degree,
    means: Vec<Vector3<E>>,
    axes: Vec<Matrix3<E>>,
    opacities: Vec<E>,
    harmonics: Vec<E>,
    orientations: Option<Vec<Matrix3<E>>>,
}

/// All that can be changed, as slices.
pub(crate) struct ArraysMut<'a, E> {
    pub(crate) means: &'a mut [Vector3<E>],
    pub(crate) axes: &'a mut [Matrix3<E>],
    pub(crate) opacities: &'a mut [E],
    pub(crate) harmonics: &'a mut [E],
    pub(crate) orientations: Option<&'a mut [Matrix3<E>]>,
}

impl<E: Element> Splats<E> {
    /// No Gaussians, of the given degree.
    pub fn new(degree: Degree) -> Self {
        Self::with_capacity(degree, 0)
    }

    /// No Gaussians, with room for `count`.
    pub fn with_capacity(degree: Degree, count: usize) -> Self {
        Self {
            degree,
            means: Vec::with_capacity(count),
            axes: Vec::with_capacity(count),
            opacities: Vec::with_capacity(count),
            harmonics: Vec::with_capacity(count * degree.stride()),
            orientations: None,
        }
    }

    /// `count` Gaussians of which every number is zero.
    pub(crate) fn zeros(degree: Degree, count: usize) -> Self {
        let zero = E::constant(0.0);
        Self {
            degree,
            means: vec![tensor::vector([zero; 3]); count],
            axes: vec![tensor::zero(); count],
            opacities: vec![zero; count],
            harmonics: vec![zero; count * degree.stride()],
            orientations: None,
        }
    }

    /// Of arrays as in the [layout](Self#layout), without orientations.
    ///
    /// # Panics
    /// If the arrays do not have one entry (`harmonics`: one stride) for each Gaussian.
    pub fn from_arrays(
        degree: Degree,
        means: Vec<Vector3<E>>,
        axes: Vec<Matrix3<E>>,
        opacities: Vec<E>,
        harmonics: Vec<E>,
    ) -> Self {
        let count = means.len();
        assert_eq!(axes.len(), count, "axes for each Gaussian");
        assert_eq!(opacities.len(), count, "an opacity for each Gaussian");
        assert_eq!(harmonics.len(), count * degree.stride(), "coefficients for each Gaussian");
        Self { degree, means, axes, opacities, harmonics, orientations: None }
    }

    /// Appends one Gaussian; its orientation, if there are any, is the identity.
    ///
    /// # Panics
    /// If its coefficients are not of the scene's degree.
    pub fn push(&mut self, splat: Splat<'_, E>) {
        assert_eq!(splat.harmonics.len(), self.degree.stride(), "coefficients of the scene's degree");
        self.means.push(splat.mean);
        self.axes.push(splat.axes);
        self.opacities.push(splat.opacity);
        self.harmonics.extend_from_slice(splat.harmonics);
        if let Some(orientations) = &mut self.orientations {
            orientations.push(tensor::multiple_of_identity(E::constant(1.0)));
        }
    }

    /// Gaussian i, without its orientation.
    ///
    /// # Panics
    /// If there is none.
    pub fn splat(&self, i: usize) -> Splat<'_, E> {
        Splat {
            mean: self.means[i],
            axes: self.axes[i],
            opacity: self.opacities[i],
            harmonics: self.harmonics_of(i),
        }
    }

    /// How many Gaussians there are.
    pub fn count(&self) -> usize {
        self.means.len()
    }

    /// The degree of everybody's harmonics.
    pub fn degree(&self) -> Degree {
        self.degree
    }

    /// μ, by Gaussian \[m\].
    pub fn means(&self) -> &[Vector3<E>] {
        &self.means
    }

    /// B, by Gaussian \[m\]; A = B Bᵀ.
    pub fn axes(&self) -> &[Matrix3<E>] {
        &self.axes
    }

    /// Opacities from 0 to 1, by Gaussian.
    pub fn opacities(&self) -> &[E] {
        &self.opacities
    }

    /// All coefficients, one stride a Gaussian: red's, green's, blue's.
    pub fn harmonics(&self) -> &[E] {
        &self.harmonics
    }

    /// The coefficients of Gaussian i: red's, green's, blue's.
    ///
    /// # Panics
    /// If there is no such Gaussian.
    pub fn harmonics_of(&self, i: usize) -> &[E] {
        let stride = self.degree.stride();
        &self.harmonics[i * stride..(i + 1) * stride]
    }

    /// By Gaussian the rotation R by which its colours are turned: in direction d it shows what its coefficients say of Rᵀ d. `None`: not turned.
    pub fn orientations(&self) -> Option<&[Matrix3<E>]> {
        self.orientations.as_deref()
    }

    /// μ, to be changed.
    pub fn means_mut(&mut self) -> &mut [Vector3<E>] {
        &mut self.means
    }

    /// B, to be changed.
    pub fn axes_mut(&mut self) -> &mut [Matrix3<E>] {
        &mut self.axes
    }

    /// Opacities, to be changed.
    pub fn opacities_mut(&mut self) -> &mut [E] {
        &mut self.opacities
    }

    /// Coefficients, to be changed.
    pub fn harmonics_mut(&mut self) -> &mut [E] {
        &mut self.harmonics
    }

    /// All arrays at once, to be changed.
    pub(crate) fn arrays_mut(&mut self) -> ArraysMut<'_, E> {
        ArraysMut {
            means: &mut self.means,
            axes: &mut self.axes,
            opacities: &mut self.opacities,
            harmonics: &mut self.harmonics,
            orientations: self.orientations.as_deref_mut(),
        }
    }

    /// Sets the orientations, or takes them away without rotating anything.
    ///
    /// # Panics
    /// If there is not one for each Gaussian.
    pub fn set_orientations(&mut self, orientations: Option<Vec<Matrix3<E>>>) {
        if let Some(orientations) = &orientations {
            assert_eq!(orientations.len(), self.count(), "an orientation for each Gaussian");
        }
        self.orientations = orientations;
    }

    /// The orientations, to be changed; identities if there were none.
    pub fn orientations_mut(&mut self) -> &mut [Matrix3<E>] {
        let count = self.means.len();
        let identity = tensor::multiple_of_identity(E::constant(1.0));
        self.orientations.get_or_insert_with(|| vec![identity; count])
    }

    /// The upper triangle xx, xy, xz, yy, yz, zz of A = B Bᵀ of Gaussian i \[m²\].
    ///
    /// # Panics
    /// If there is no such Gaussian.
    pub fn covariance(&self, i: usize) -> [E; 6] {
        covariance(&self.axes[i])
    }

    /// The same scene in other numbers, rounded to nearest.
    pub fn cast<T: Element>(&self) -> Splats<T> {
        let number = |x: E| T::constant(x.into());
        let matrix = |a: &Matrix3<E>| tensor::from_columns(tensor::columns(a).map(|c| c.map(number)));
        Splats {
            degree: self.degree,
            means: self.means.iter().map(|m| tensor::vector(tensor::components(m).map(number))).collect(),
            axes: self.axes.iter().map(matrix).collect(),
            opacities: self.opacities.iter().map(|&x| number(x)).collect(),
            harmonics: self.harmonics.iter().map(|&x| number(x)).collect(),
            orientations: self.orientations.as_ref().map(|all| all.iter().map(matrix).collect()),
        }
    }

    /// The same scene with harmonics of another degree: higher coefficients dropped, missing ones zero.
    pub fn with_degree(&self, degree: Degree) -> Self {
        let (from, to) = (self.degree.coefficients(), degree.coefficients());
        let mut harmonics = vec![E::constant(0.0); self.count() * degree.stride()];
        for (target, source) in harmonics.chunks_exact_mut(to).zip(self.harmonics.chunks_exact(from)) {
            let shared = from.min(to);
            target[..shared].copy_from_slice(&source[..shared]);
        }
        Self { degree, harmonics, ..self.clone() }
    }

    /// The Gaussians with the given numbers, in the given order.
    ///
    /// # Panics
    /// If there is no such Gaussian.
    pub fn gather(&self, indices: &[u32]) -> Self {
        let mut gathered = Self::with_capacity(self.degree, indices.len());
        indices.iter().for_each(|&i| gathered.push(self.splat(i as usize)));
        let orientations = self.orientations.as_ref();
        gathered.orientations = orientations.map(|all| indices.iter().map(|&i| all[i as usize]).collect());
        gathered
    }

    /// Whether no number is NaN or larger than [`largest_number`], and opacities are from 0 to 1.
    ///
    /// # Errors
    /// [`SplatError::BadValue`] with the first Gaussian and property of which that is not so.
    pub fn check(&self) -> Result<(), SplatError> {
        self.check_within(largest_number::<E>())
    }

    /// Whether no number is NaN or larger than `most`, and opacities are from 0 to 1.
    pub(crate) fn check_within(&self, most: f64) -> Result<(), SplatError> {
        for i in 0..self.count() {
            check_all(i, Property::Mean, tensor::components(&self.means[i]), -most..=most)?;
            check_all(i, Property::Axes, self.axes[i].as_slice(), -most..=most)?;
            check_all(i, Property::Harmonics, self.harmonics_of(i), -most..=most)?;
            check_all(i, Property::Opacity, &[self.opacities[i]], 0.0..=1.0)?;
        }
        Ok(())
    }
}

/// The largest number of a scene or a deformation that can be computed with: products of two of them stay finite with room to spare. 1e15 for `f32`,
/// 1e120 for `f64`.
pub fn largest_number<E: Element>() -> f64 {
    if E::EPSILON > 1e-10 { 1e15 } else { 1e120 }
}

/// Whether every number is in the range, and none is NaN.
fn check_all<E: Element>(
    splat: usize,
    property: Property,
    numbers: &[E],
    range: std::ops::RangeInclusive<f64>,
) -> Result<(), SplatError> {
    match numbers.iter().map(|&x| x.into()).find(|x: &f64| !range.contains(x)) {
        None => Ok(()),
        Some(value) => Err(SplatError::BadValue { splat, property, value }),
    }
}

/// The upper triangle xx, xy, xz, yy, yz, zz of B Bᵀ.
#[inline(always)]
pub fn covariance<S: Scalar>(axes: &Matrix3<S>) -> [S; 6] {
    let a = tensor::product_transpose(axes, axes);
    let c = tensor::columns(&a);
    [c[0][0], c[1][0], c[2][0], c[1][1], c[2][1], c[2][2]]
}
