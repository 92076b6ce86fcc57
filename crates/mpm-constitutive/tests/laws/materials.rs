//! One of every solid, so that a property of all laws is written once.

#![allow(dead_code, reason = "each test program uses a part")]

use mechanics_core::law::Lame;
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::{Mat3, Matrix3};
use mpm_constitutive::elastic::{FixedCorotated, Hencky, NeoHookean};
use mpm_constitutive::plastic::{
    DruckerPrager, FrictionAngle, HerschelBulkley, ModifiedCamClay, NonAssociativeCamClay, Snow, VonMises,
    YieldStress,
};
use mpm_constitutive::{Numbers, PointLaw};

pub(crate) const MU: f64 = 0.7e6;
pub(crate) const LAMBDA: f64 = 1.1e6;
/// 2μ + λ, the measure of errors of stress.
pub(crate) const STIFF: f64 = 2.0 * MU + LAMBDA;

pub(crate) fn lame() -> Lame {
    Lame::new(LAMBDA, MU).unwrap()
}

pub(crate) fn metal() -> VonMises {
    VonMises::new(lame(), YieldStress::linear(2e4, 1e5).unwrap().saturating(5e4, 12.0).unwrap()).unwrap()
}

pub(crate) fn plasticine() -> VonMises {
    VonMises::new(lame(), YieldStress::perfect(4e4).unwrap().saturating(1e4, 8.0).unwrap()).unwrap()
}

pub(crate) fn sand() -> DruckerPrager {
    DruckerPrager::new(lame(), FrictionAngle::constant(0.6).unwrap(), 0.0).unwrap()
}

pub(crate) fn wet_sand() -> DruckerPrager {
    let angle = FrictionAngle::hardening([0.61, 0.157, 0.3, 0.174]).unwrap();
    DruckerPrager::new(lame(), angle, 3e3).unwrap()
}

pub(crate) fn snow() -> Snow {
    Snow::new(Lame::from_young_poisson(1.4e5, 0.2).unwrap(), 2.5e-2, 7.5e-3, 10.0).unwrap()
}

pub(crate) fn clay() -> ModifiedCamClay {
    ModifiedCamClay::new(lame(), 1.1, 0.0, 5e4, 8.0).unwrap()
}

pub(crate) fn glued_clay() -> ModifiedCamClay {
    ModifiedCamClay::new(lame(), 0.9, 0.4, 3e4, 20.0).unwrap()
}

pub(crate) fn porous() -> NonAssociativeCamClay {
    NonAssociativeCamClay::new(lame(), 1.85, 0.8, 1.5, 0.04).unwrap()
}

pub(crate) fn foam(index: f64) -> HerschelBulkley {
    HerschelBulkley::new(lame(), 5e3, 2e3, index).unwrap()
}

/// What is done with a law, whatever its type.
pub(crate) trait Visitor {
    /// `histories` are some of the law's histories, as plain numbers.
    fn visit<L: SolidLaw>(&mut self, name: &str, law: &L, histories: &[&[f64]]);
}

/// A law of solids: its strain is F.
pub(crate) trait SolidLaw: PointLaw {
    fn strain<S: Scalar>(f: &Matrix3<S>) -> Self::Strain<S>;
    fn gradient<S: Scalar>(strain: &Self::Strain<S>) -> Matrix3<S>;
}

impl<L> SolidLaw for L
where
    L: PointLaw,
{
    fn strain<S: Scalar>(f: &Matrix3<S>) -> Self::Strain<S> {
        assert_eq!(<Self::Strain<S> as Numbers<S>>::COUNT, 9);
        Self::Strain::from_numbers(|k| f.number(k))
    }

    fn gradient<S: Scalar>(strain: &Self::Strain<S>) -> Matrix3<S> {
        Matrix3::from_numbers(|k| strain.number(k))
    }
}

pub(crate) fn history<L: PointLaw, S: Scalar>(numbers: &[f64]) -> L::History<S> {
    L::History::from_numbers(|k| S::constant(numbers[k]))
}

pub(crate) fn numbers_of<L: PointLaw>(history: &L::History<f64>) -> Vec<f64> {
    (0..<L::History<f64> as Numbers<f64>>::COUNT).map(|k| history.number(k)).collect()
}

/// Every objective solid with some histories.
pub(crate) fn visit_all(visitor: &mut impl Visitor) {
    visitor.visit("neo-Hookean", &NeoHookean::new(lame()), &[&[]]);
    visitor.visit("fixed corotated", &FixedCorotated::new(lame()), &[&[]]);
    visitor.visit("Hencky", &Hencky::new(lame()), &[&[]]);
    visitor.visit("metal", &metal(), &[&[0.0], &[0.3]]);
    visitor.visit("plasticine", &plasticine(), &[&[0.0], &[0.1]]);
    visitor.visit("sand", &sand(), &[&[0.0, 0.0], &[0.05, 1.0]]);
    visitor.visit("wet sand", &wet_sand(), &[&[0.0, 0.0], &[0.0, 2.0], &[0.1, 1.0]]);
    visitor.visit("snow", &snow(), &[&[0.0], &[-0.2], &[0.1]]);
    visitor.visit("clay", &clay(), &[&[0.0], &[-0.2]]);
    visitor.visit("glued clay", &glued_clay(), &[&[0.0], &[0.1]]);
    visitor.visit("porous", &porous(), &[&[0.0], &[-0.2], &[0.1]]);
    visitor.visit("foam", &foam(0.4), &[&[]]);
    visitor.visit("starch", &foam(1.7), &[&[]]);
}

/// One step of h = 1 ms from a trial F.
pub(crate) fn returned<L: SolidLaw>(law: &L, f: &Mat3, history: &mut L::History<f64>) -> (Mat3, Mat3) {
    let (strain, stress) = law.return_map(&L::strain(f), history, 1e-3);
    (L::gradient(&strain), stress.kirchhoff)
}
