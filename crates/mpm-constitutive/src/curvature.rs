//! Second derivatives of the energy: what implicit steps need of a law.

use crate::Numbers;
use mechanics_core::jet::Jet2;
use mechanics_core::law::Stiffness;
use mechanics_core::projection::{Projection, project_symmetric};
use mechanics_core::tensor::Mat3;
use nalgebra::SMatrix;

/// The most numbers of a strain that has a curvature.
pub(crate) const MOST: usize = 9;

/// ∂²ψ/∂s² over the numbers s of a strain, a symmetric map from changes of s to changes of ∂ψ/∂s.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "a value on the stack of one particle, never stored")]
pub enum Curvature {
    /// s = F: ∂P/∂F times a factor \[Pa\].
    Deformation(Stiffness<f64>, f64),
    /// s = J − 1: −dp/dJ \[Pa\].
    Volume(f64),
}

impl Curvature {
    /// The change of ∂ψ/∂s for a change of s \[Pa\].
    pub fn apply<T: Numbers<f64>>(&self, change: &T) -> T {
        match self {
            Self::Deformation(stiffness, factor) => {
                let change = Mat3::from_fn(|i, j| number_or_zero(change, 3 * j + i));
                let stress = stiffness.apply(&change);
                T::from_numbers(|k| factor * stress[(k % 3, k / 3)])
            }
            Self::Volume(modulus) => T::from_numbers(|k| modulus * change.number(k)),
        }
    }
}

fn number_or_zero<T: Numbers<f64>>(numbers: &T, k: usize) -> f64 {
    if k < T::COUNT { numbers.number(k) } else { 0.0 }
}

/// ∂ψ/∂s of a function of the numbers s, by automatic differentiation along each of them.
pub(crate) fn gradient<T: Numbers<f64>>(along: impl Fn(&[f64; MOST]) -> Jet2<f64, 1>) -> T {
    T::from_numbers(|k| along(&unit(k)).gradient[0])
}

/// ∂²ψ/∂s² likewise: with q(d) the second derivative along d, Hᵢⱼ = ½[q(eᵢ + eⱼ) − q(eᵢ) − q(eⱼ)].
pub(crate) fn curvature<T: Numbers<f64>>(
    along: impl Fn(&[f64; MOST]) -> Jet2<f64, 1>,
    projection: Projection,
) -> Curvature {
    const { assert!(T::COUNT <= MOST, "strains of more than nine numbers give their own curvature") };
    let second = |direction: &[f64; MOST]| along(direction).hessian(0, 0);
    if T::COUNT == 1 {
        return Curvature::Volume(projection.apply(second(&unit(0))));
    }
    let mut hessian = SMatrix::<f64, MOST, MOST>::zeros();
    for i in 0..T::COUNT {
        hessian[(i, i)] = second(&unit(i));
    }
    for i in 0..T::COUNT {
        for j in 0..i {
            let mut both = unit(i);
            both[j] = 1.0;
            hessian[(i, j)] = 0.5 * (second(&both) - hessian[(i, i)] - hessian[(j, j)]);
            hessian[(j, i)] = hessian[(i, j)];
        }
    }
    Curvature::Deformation(Stiffness::from_matrix(&project_symmetric(&hessian, projection)), 1.0)
}

fn unit(k: usize) -> [f64; MOST] {
    std::array::from_fn(|i| if i == k { 1.0 } else { 0.0 })
}
